//! Axes that a static coupling joins: an effect is found in the axis, or behind the reading, in which it is.

use crate::common::machine::Normal;
use components::COMPONENTS;
use data::{Blueprint, CheckedBlueprint, Log};
use diagnose::{Diagnosis, Error, Model, Noise, Request, Silent, Verdict, diagnose, examine};

const STEP: f64 = 1e-3;
const ROWS: usize = 8000;
/// Standard deviations of the two readings in um.
const NOISE: [f64; 2] = [0.05, 0.2];
const SEED: u64 = 31;

const OPTICS: &str = "[[coupling]]\ntype = \"optics-jacobian\"\nname = \"optics\"\naxes = [\"A\", \"B\"]\n\
                      matrix = [[500, 30], [200, -130]]\noffset = [-260, 12]\n";
const FILTER: &str =
    "[[axis.component]]\ntype = \"sensor-butterworth\"\norder = 2\nbandwidth = 50\n";
const CREEP: &str = "[[axis.component]]\ntype = \"kelvin-voigt-creep\"\nshare = [0.03, 0.04]\n\
                     time_constant = [0.2, 1.5]\n";

/// Two axes with plays; in each what stands behind them, and behind the coupling.
fn machine(front: [&str; 2], behind: [&str; 2], coupling: &str) -> CheckedBlueprint {
    let mut text = format!("piezoloop = 1\nkind = \"plant\"\nname = \"mirror\"\nstep = {STEP}\n");
    for (k, name) in ["A", "B"].iter().enumerate() {
        text += &format!(
            "[[axis]]\nname = \"{name}\"\ncommand = {{ name = \"u{0}\", unit = \"V\", min = 0, max = 150 }}\n\
             motion = {{ unit = \"1\" }}\nposition = {{ name = \"y{0}\", unit = \"um\" }}\n\
             [[axis.component]]\ntype = \"prandtl-ishlinskii\"\nr = [0, 15, 30, 45]\n\
             w = [0.004, 0.0009, 0.0008, 0.0008]\n{1}{2}",
            k + 1,
            front[k],
            behind[k]
        );
    }
    Blueprint::parse(&(text + coupling), "mirror.toml").unwrap().check(COMPONENTS).unwrap()
}

fn model() -> CheckedBlueprint {
    machine([""; 2], [FILTER; 2], OPTICS)
}

/// Both commands at once, with turning points at many voltages.
fn commands() -> [Vec<f64>; 2] {
    let wave = |rate: f64, phase: f64| {
        (0..ROWS).map(move |n| {
            let angle = std::f64::consts::TAU * rate * n as f64 * STEP;
            let start = (n as f64 * STEP / 0.5).min(1.0);
            start
                * (75.0 + 40.0 * (angle + phase).sin() + 28.0 * (0.37 * angle + 2.0 * phase).sin())
        })
    };
    [wave(0.9, 0.3).collect(), wave(1.3, 1.9).collect()]
}

/// The positions of both axes, one per row.
fn positions(machine: &CheckedBlueprint) -> [Vec<f64>; 2] {
    let mut system = machine.build();
    let of = |name: &str| system.variables().find(name).unwrap();
    let (u, y) = ([of("command[1]"), of("command[2]")], [of("position[1]"), of("position[2]")]);
    system.initialise(0.0).unwrap();
    let [first, second] = commands();
    let mut all = [Vec::new(), Vec::new()];
    for (n, both) in first.into_iter().zip(second).enumerate() {
        all.iter_mut().zip(y).for_each(|(all, y)| all.push(system.get(y).unwrap()));
        system.set(u[0], both.0).unwrap();
        system.set(u[1], both.1).unwrap();
        system.advance((n + 1) as f64 * STEP).unwrap();
    }
    all
}

fn log(positions: [Vec<f64>; 2]) -> Log {
    let mut noise = Normal::new(SEED);
    let mut log = Log::new("log.csv", (0..ROWS).map(|n| n as f64 * STEP).collect()).unwrap();
    for (k, (u, mut y)) in commands().into_iter().zip(positions).enumerate() {
        y.iter_mut().for_each(|y| *y += NOISE[k] * noise.draw());
        log.add_column(&format!("u{}", k + 1), Some("V"), u).unwrap();
        log.add_column(&format!("y{}", k + 1), Some("um"), y).unwrap();
    }
    log
}

fn request(model: CheckedBlueprint, log: Log) -> Request {
    let mut request = Request::new(Model::Blueprint(Box::new(model)), vec![log]);
    let given = |k: usize| (Some(format!("y{}", k + 1)), NOISE[k]);
    request.noise = Noise::Given(vec![given(0), given(1)]);
    request
}

fn diagnosis(machine: &CheckedBlueprint) -> Diagnosis {
    examine(&request(model(), log(positions(machine))), &mut Silent).unwrap()
}

/// Output and name of each effect.
fn names(diagnosis: &Diagnosis) -> Vec<(&str, &str)> {
    let effects = diagnosis.gap.effects.iter();
    effects.map(|e| (e.output.as_str(), e.effect.as_str())).collect()
}

/// Root mean square of the second half of each position less the machine's.
fn left(written: Blueprint, machine: &CheckedBlueprint) -> [f64; 2] {
    let written = positions(&written.check(COMPONENTS).unwrap());
    let wanted = positions(machine);
    let rms = |k: usize| {
        let half = ROWS / 2..ROWS;
        let squares = half.map(|n| (written[k][n] - wanted[k][n]).powi(2));
        (squares.sum::<f64>() / (ROWS / 2) as f64).sqrt()
    };
    [rms(0), rms(1)]
}

#[test]
fn the_model_itself_is_adequate_and_the_noise_of_a_motion_is_that_of_the_readings() {
    let gap = diagnosis(&model()).gap;
    assert_eq!(gap.verdict, Verdict::Adequate, "{} (seed {SEED})", gap.sentence);
    // A⁻¹ of [[500, 30], [200, −130]], row by row.
    let inverse = [[130.0, 30.0], [200.0, -500.0]].map(|row| row.map(|v: f64| v / 71_000.0));
    for (output, row) in gap.outputs.iter().zip(inverse) {
        let wanted = (row[0] * NOISE[0]).hypot(row[1] * NOISE[1]);
        assert!((output.noise.sigma / wanted - 1.0).abs() < 1e-9, "{}", output.output);
    }
    assert!(gap.warnings.iter().any(|w| w.contains("optics") && w.contains("y1, y2")));
}

#[test]
fn an_effect_of_an_axis_is_found_there_and_nowhere_else_and_can_be_handed_back() {
    let machine = machine(["", CREEP], [FILTER; 2], OPTICS);
    let mut found = diagnosis(&machine);
    assert_eq!(names(&found), [("motion[2]", "creep")], "{} (seed {SEED})", found.gap.sentence);
    let before = left(model().blueprint().clone(), &machine);
    let (repaired, notes) = found.repair(model().blueprint());
    let after = left(repaired, &machine);
    for k in 0..2 {
        assert!(after[k] < 0.05 * before[k], "{after:?} of {before:?}, {notes:?} (seed {SEED})");
    }
}

#[test]
fn an_effect_of_a_sensor_is_found_behind_the_coupling() {
    let scale =
        format!("{FILTER}[[axis.component]]\ntype = \"sensor-scale\"\ngain = 1.1\noffset = 4\n");
    let lag = format!("{FILTER}[[axis.component]]\ntype = \"sensor-lag\"\nbandwidth = 15\n");
    for (behind, wanted) in
        [([FILTER, &scale], ("y2", "actuator_gain")), ([&lag, FILTER], ("y1", "sensor_bandwidth"))]
    {
        let machine = machine([""; 2], behind, OPTICS);
        let mut found = diagnosis(&machine);
        assert_eq!(names(&found), [wanted], "{} (seed {SEED})", found.gap.sentence);
        let before = left(model().blueprint().clone(), &machine);
        let (repaired, notes) = found.repair(model().blueprint());
        let after = left(repaired, &machine);
        let k = usize::from(wanted.0 == "y2");
        assert!(after[k] < 0.05 * before[k], "{after:?} of {before:?}, {notes:?} (seed {SEED})");
    }
}

#[test]
fn an_offset_that_the_logs_show_is_part_of_the_repaired_model() {
    // Without a coupling, the actuator's offset takes it.
    let machine = machine([CREEP, ""], [FILTER; 2], &OPTICS.replace("-260, 12", "-250, 9"));
    let mut found = diagnosis(&machine);
    assert_eq!(names(&found), [("motion[1]", "creep")], "{} (seed {SEED})", found.gap.sentence);
    let (repaired, _) = found.repair(model().blueprint());
    let after = left(repaired, &machine);
    let motion = |k: usize| after[k] / [500.0, 130.0][k];
    assert!(motion(0) < 1e-3, "{after:?} (seed {SEED})");
}

#[test]
fn what_cannot_be_inverted_is_refused_with_the_reason() {
    let refused = |model: CheckedBlueprint| -> String {
        match diagnose(&request(model.clone(), log(positions(&model))), &mut Silent) {
            Err(error @ Error::Joined { .. }) => error.to_string(),
            other => panic!("{other:?}"),
        }
    };
    let message = refused(machine([""; 2], [FILTER, &FILTER.replace("50", "60")], OPTICS));
    assert!(message.contains("axes A and B differ in filter"), "{message}");
    let flat = OPTICS.replace("[200, -130]", "[500, 30.001]");
    let message = refused(machine([""; 2], [FILTER; 2], &flat));
    assert!(message.contains("condition number"), "{message}");
    let bent = format!(
        "{OPTICS}[[coupling]]\ntype = \"psd-pincushion\"\nname = \"psd\"\naxes = [\"A\", \"B\"]\n\
         distortion = 0.01\nhalf_size = 5000\n"
    );
    let message = refused(machine([""; 2], [FILTER; 2], &bent));
    assert!(message.contains("no straight line") && message.contains("pack"), "{message}");
}

#[test]
fn all_readings_of_coupled_axes_are_needed() {
    let mut one = Log::new("one.csv", (0..ROWS).map(|n| n as f64 * STEP).collect()).unwrap();
    let [u, _] = commands();
    let [y, _] = positions(&model());
    one.add_column("u1", Some("V"), u).unwrap();
    one.add_column("y1", Some("um"), y).unwrap();
    let mut request = request(model(), one);
    request.noise = Noise::Estimated;
    let message = diagnose(&request, &mut Silent).unwrap_err().to_string();
    assert!(message.contains("position[2]") && message.contains("one.csv"), "{message}");
}
