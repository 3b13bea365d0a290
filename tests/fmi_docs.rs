//! docs/fmi.md, coupling.md and conformance.md say what the code does.

use crate::common;

use common::packed::{CONTROLLER, PLANT};
use common::succeed;
use fmi_bindings::export::{Phase, Rule, v2, v3};

const PAGE: &str = include_str!("../docs/fmi.md");
/// The coupling of masters, and the defects that the checker finds.
const COUPLING: &str = include_str!("../docs/coupling.md");
const CONFORMANCE: &str = include_str!("../docs/conformance.md");
const PAGE_3: &str = include_str!("../docs/fmi3.md");
/// The test with the defects that an FMU may have.
const DEFECTS: &str = include_str!("../modeldescription/tests/check.rs");

/// The call table of a page, and that of the code.
fn tables(page: &str, code: &[Rule]) -> [Vec<String>; 2] {
    let rows = page.lines().skip_while(|line| !line.starts_with("| function | Instantiated"));
    let rows = rows.skip(2).take_while(|line| line.starts_with('|'));
    let of_code = code.iter().map(|rule| {
        let marks = Phase::ALL.map(|phase| if rule.allows(phase) { "x" } else { "." });
        format!("| `{}` | {} |", rule.function, marks.join(" | "))
    });
    [rows.map(str::to_owned).collect(), of_code.collect()]
}

#[test]
fn the_call_tables_of_the_pages_are_those_of_the_code() {
    for (page, code, rows) in [(PAGE, v2::TABLE, 41), (PAGE_3, v3::TABLE, 71)] {
        let [page, code] = tables(page, code);
        assert_eq!(page, code);
        assert_eq!(page.len(), rows);
    }
}

/// Every defect of the page's table is a case of the test.
#[test]
fn every_defect_of_the_page_is_a_case_of_the_test() {
    let rows = CONFORMANCE.lines().skip_while(|line| !line.starts_with("| defect | fmpy"));
    let rows = rows.skip(2).take_while(|line| line.starts_with('|'));
    let mut cases = Vec::new();
    for row in rows {
        let last = row.trim_end_matches('|').rsplit('|').next().expect("a cell").trim();
        // "InitialUnknowns unordered and with a duplicate" are two of one beginning.
        let (first, second) = last.split_once(" and ").unwrap_or((last, ""));
        let beginning = first.split(' ').next().unwrap_or_default();
        cases.push(first.to_owned());
        match second {
            "" => {}
            second if second.starts_with("with ") => cases.push(format!("{beginning} {second}")),
            second => cases.push(second.to_owned()),
        }
    }
    assert_eq!(cases.len(), 33, "{cases:#?}");
    for case in cases {
        assert!(DEFECTS.contains(&format!("\"{case}\"")), "no case {case:?}");
    }
}

/// The reference result of the loop, for each coupling, as our master computes it.
#[test]
fn the_reference_result_of_the_page_is_that_of_the_master() {
    let folder = tempfile::tempdir().expect("a folder");
    succeed(&["pack", PLANT, "-o", "plant.fmu"], folder.path());
    succeed(&["pack", CONTROLLER, "-o", "controller.fmu"], folder.path());
    let mut text = String::from("time,reference[1],reference[2]\n");
    for k in 0..2001 {
        let t = f64::from(k) * 20e-6;
        let wave = 1.0 - (2.0 * std::f64::consts::PI * 50.0 * t).cos();
        text += &format!("{t},{wave},{}\n", 1.5 * wave);
    }
    std::fs::write(folder.path().join("reference.csv"), text).expect("the folder is writable");
    for (coupling, name) in [("side-by-side", "Jacobi"), ("controller-first", "Gauss–Seidel")] {
        let files = ["simulate", "--loop", "plant.fmu", "controller.fmu"];
        let rest = ["--reference", "reference.csv", "--coupling", coupling, "-o", "run.csv"];
        succeed(&[&files[..], &rest[..]].concat(), folder.path());
        let run = std::fs::read_to_string(folder.path().join("run.csv")).expect("the run");
        let mut rows = run.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let header = rows.next().expect("a header");
        let position = header.iter().position(|n| *n == "position[1]").expect("the position");
        let values: Vec<f64> = rows.map(|row| row[position].parse().expect("a number")).collect();
        let cells = [250, 500, 1000, 2000].map(|row: usize| format!("{:.9}", values[row]));
        let wanted = format!("| {name} | {} |", cells.join(" | "));
        assert!(COUPLING.lines().any(|line| line == wanted), "docs/coupling.md lacks: {wanted}");
    }
}
