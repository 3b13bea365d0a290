use std::path::Path;

use super::*;

fn targets() -> Vec<Target> {
    let frequency = |axis: u8, start: f64| Target {
        start: Some(start),
        min: 1.0,
        max: 1e5,
        unit: Some("Hz".to_owned()),
        ..Target::new(format!("plant.axis[{axis}].frequency"), ColumnKind::Real)
    };
    let zero = Target { start: Some(0.0), ..Target::new("plant.offset", ColumnKind::Real) };
    let seed = Target { min: 0.0, max: 1e9, ..Target::new("plant.seed", ColumnKind::Integer) };
    let on = Target::new("plant.backlash.enabled", ColumnKind::Truth);
    vec![frequency(1, 480.0), frequency(2, 290.0), zero, seed, on]
}

fn design(runs: u64, vary: &str) -> Result<Design, String> {
    let table = "[loop]\nplant = \"p\"\ncontroller = \"c\"\nreference = \"r\"\n[vary]\n";
    let plan = Plan::parse(&format!("runs = {runs}\n{table}{vary}"), Path::new("p.toml"));
    Design::new(&plan.unwrap(), &targets()).map_err(|problems| problems.to_string())
}

fn reals(design: &Design, variable: usize) -> Vec<f64> {
    let values = (0..design.runs()).map(|run| design.point(run).unwrap()[variable].clone());
    values.map(|cell| cell.number().unwrap()).collect()
}

#[test]
fn a_pattern_draws_each_variable_for_itself() {
    let design = design(4000, "\"plant.*.frequency\" = { tolerance = 0.05 }\n").unwrap();
    assert_eq!(design.columns().len(), 2);
    let (a, b) = (reals(&design, 0), reals(&design, 1));
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (ma, mb) = (mean(&a), mean(&b));
    let deviation =
        (a.iter().map(|x| (x - ma).powi(2)).sum::<f64>() / a.len() as f64).sqrt() / 480.0;
    // Standard error of the mean 0.08 %, of the deviation 1.1 %.
    assert!((ma / 480.0 - 1.0).abs() < 0.004, "{ma}");
    assert!((deviation / 0.05 - 1.0).abs() < 0.05, "{deviation}");
    let together: f64 = a.iter().zip(&b).map(|(x, y)| (x - ma) * (y - mb)).sum();
    assert!((together / (a.len() as f64 * 0.05 * 480.0 * 0.05 * 290.0)).abs() < 0.06);
}

#[test]
fn combinations_of_grids_meet_the_same_machines() {
    let vary = "\"plant.backlash.enabled\" = { grid = [false, true] }\n\
                \"plant.axis[1].frequency\" = { within = 0.1 }\n\
                \"plant.offset\" = { grid = [0, 1, 2] }\n";
    let design = design(5, vary).unwrap();
    assert_eq!(design.runs(), 30);
    let points: Vec<Vec<Cell>> = (0..30).map(|run| design.point(run).unwrap()).collect();
    for (run, point) in points.iter().enumerate() {
        assert_eq!(point[0], Cell::Truth(run >= 15));
        assert_eq!(point[2], Cell::Real(f64::from((run as u32 / 5) % 3)));
        assert_eq!(point[1], points[run % 5][1]);
    }
    assert_ne!(points[0][1], points[1][1]);
}

#[test]
fn a_further_variable_leaves_the_others_as_they_are() {
    let one = design(9, "\"plant.axis[2].frequency\" = { log-uniform = [100, 1000] }\n").unwrap();
    let two = "\"plant.seed\" = { whole = [0, 99] }\n\
               \"plant.axis[2].frequency\" = { log-uniform = [100, 1000] }\n";
    let two = design(9, two).unwrap();
    assert_eq!(reals(&one, 0), reals(&two, 1));
    assert!(reals(&two, 0).iter().all(|seed| seed.fract() == 0.0 && *seed < 100.0));
}

#[test]
fn draws_stay_within_the_bounds_of_their_variable() {
    let design = design(3000, "\"plant.axis[1].frequency\" = { normal = [2, 5] }\n").unwrap();
    let values = reals(&design, 0);
    assert!(values.iter().all(|x| *x >= 1.0) && values.iter().any(|x| *x < 2.0));
}

#[test]
fn every_problem_is_reported_with_line_and_way_out() {
    for (vary, words) in [
        (
            "\"plant.axis[1].freqency\" = { tolerance = 0.1 }",
            ["p.toml:7:", "did you mean plant.axis[1]"],
        ),
        ("\"plant.offset\" = { tolerance = 0.1 }", ["start value 0", "take normal or uniform"]),
        ("\"plant.seed\" = { uniform = [1, 2] }", ["a whole number", "take choice or grid"]),
        (
            "\"plant.axis[1].frequency\" = { uniform = [0, 5] }",
            ["0 Hz is not within 1 to 100000", "bounds"],
        ),
        (
            "\"plant.axis[1].frequency\" = { uniform = [9, 5] }",
            ["9 to 5 is no range", "least value first"],
        ),
        ("\"plant.axis[1].frequency\" = { tolerance = -1 }", ["-1 is no tolerance", "0.05"]),
        ("\"plant.backlash.enabled\" = { choice = [1] }", ["true or false, not 1", "correct"]),
        ("\"plant.backlash.enabled\" = { choice = [] }", ["has no value", "list one"]),
        (
            "\"plant.*\" = { choice = [5] }\n\"plant.offset\" = { choice = [1] }",
            ["varied twice", "enabled"],
        ),
    ] {
        let message = design(3, vary).unwrap_err();
        assert!(words.iter().all(|word| message.contains(word)), "{vary}: {message}");
    }
    let too_many = "\"plant.offset\" = { grid = [1, 2] }\n";
    assert!(design(60_000_000, too_many).unwrap_err().contains("120000000 runs"));
}

#[test]
fn patterns() {
    for (pattern, name, is) in [
        ("a*c", "abc", true),
        ("a*c", "ac", true),
        ("*", "", true),
        ("a*b*c", "axxbyyc", true),
        ("a*b", "axxbyy", false),
        ("ab", "abc", false),
        ("*.k[1]", "a.b.k[1]", true),
    ] {
        assert_eq!(data::fits_pattern(pattern, name), is, "{pattern} {name}");
    }
}
