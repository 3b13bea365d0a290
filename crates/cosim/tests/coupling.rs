//! Several FMUs: delays of Jacobi and Gauss–Seidel, units, the closed loop.
#![allow(clippy::print_stdout)]

use crate::common;
use common::{Fmus, instance};
use cosim::{
    Algorithm, Coupling, Diagram, GaussSeidel, Jacobi, Loop, LoopSettings, Memory, Points, Problem,
    Run, Signals, System, Wiring,
};

const H: f64 = 0.125;

/// A source whose output is the time, feeding a sampler whose output is its input at its last step.
fn source_and_sampler(fmus: &Fmus, sampler_first: bool) -> System {
    let (source, sampler) = (fmus.integrator(), fmus.controller());
    let mut diagram = Diagram::new();
    if sampler_first {
        diagram.add(instance(&sampler, "sampler")).add(instance(&source, "source"));
    } else {
        diagram.add(instance(&source, "source")).add(instance(&sampler, "sampler"));
    }
    diagram
        .start(("source", "command[1]"), 1.0)
        .connect(("source", "position[1]"), ("sampler", "reference[1]"))
        .record(("source", "position[1]"))
        .record(("sampler", "reference[1]"))
        .record(("sampler", "command[1]"));
    diagram.build().unwrap()
}

/// The sampler's output and the input that acted in each step.
fn run(system: &mut System, algorithm: &dyn Algorithm) -> (Vec<f64>, Vec<f64>) {
    let signals = Signals::default();
    let points = Points::uniform(0.0, 10.0 * H, H).unwrap();
    let run = Run::new(points, &signals);
    let mut memory = Memory::new();
    assert_eq!(system.run(&run, algorithm, &mut memory).unwrap(), None);
    for (k, (t, y)) in memory.time().iter().zip(memory.values("position[1]").unwrap()).enumerate() {
        assert_eq!((*t, *y), (k as f64 * H, k as f64 * H));
    }
    let values = |name: &str| memory.values(name).unwrap().to_vec();
    (values("reference[1]"), values("command[1]"))
}

#[test]
fn jacobi_delays_every_connection_by_one_step() {
    let fmus = fmus_or_skip!();
    for sampler_first in [false, true] {
        let mut system = source_and_sampler(&fmus, sampler_first);
        let (input, output) = run(&mut system, &Jacobi);
        for k in 0..10 {
            // The source at t_k acts from t_k on, and is seen at t_{k+1}.
            assert_eq!(input[k], k as f64 * H);
            assert_eq!(output[k + 1], k as f64 * H, "delay of one step");
        }
    }
}

#[test]
fn gauss_seidel_forward_has_no_delay() {
    let fmus = fmus_or_skip!();
    let mut system = source_and_sampler(&fmus, true);
    let algorithm = GaussSeidel::in_order(&system, &["source", "sampler"]).unwrap();
    let (input, output) = run(&mut system, &algorithm);
    for k in 0..10 {
        // The source at t_{k+1} acts from t_k on.
        assert_eq!(input[k], (k + 1) as f64 * H);
        assert_eq!(output[k + 1], (k + 1) as f64 * H, "no delay");
    }
    // By dependency it is the same order.
    assert_eq!(GaussSeidel::by_dependency(&system), algorithm);
}

#[test]
fn gauss_seidel_backward_delays_by_one_step() {
    let fmus = fmus_or_skip!();
    let mut system = source_and_sampler(&fmus, true);
    let algorithm = GaussSeidel::in_order(&system, &["sampler", "source"]).unwrap();
    let (input, output) = run(&mut system, &algorithm);
    for k in 0..10 {
        assert_eq!(input[k], k as f64 * H);
        assert_eq!(output[k + 1], k as f64 * H, "delay of one step");
    }
}

#[test]
fn an_order_must_name_every_fmu_once() {
    let fmus = fmus_or_skip!();
    let system = source_and_sampler(&fmus, true);
    let problems = GaussSeidel::in_order(&system, &["source", "source", "sink"]).unwrap_err();
    let texts: Vec<String> = problems.0.iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), 3, "{texts:?}");
    assert!(texts[1].contains("no FMU `sink`; there are: sampler, source"), "{texts:?}");
    assert!(texts[2].contains("`sampler` is left out"), "{texts:?}");
}

/// A step of height 1 on the loop plant y' = u, controller u = K·(r − y).
fn closed_loop(fmus: &Fmus, coupling: Coupling, gain: f64) -> Memory {
    let controller = instance(&fmus.controller(), "controller");
    let plant = instance(&fmus.integrator(), "plant");
    let wiring = Wiring::by_name(&*controller, &*plant, &["reference[1]"]).unwrap();
    let parameters = vec![("controller".to_owned(), "k".to_owned(), gain.into())];
    let settings = LoopSettings { wiring, coupling, parameters, ..LoopSettings::default() };
    let mut closed = Loop::new(controller, plant, &settings).unwrap();
    let signals = Signals::new(&[0.0]).with("reference[1]", &[1.0]);
    let points = Points::uniform(0.0, 40.0 * H, H).unwrap();
    let mut memory = Memory::new();
    closed.run(&Run::new(points, &signals), &mut memory).unwrap();
    memory
}

#[test]
fn controller_first_applies_the_command_of_the_same_sample() {
    let fmus = fmus_or_skip!();
    let gain = 2.0;
    let memory = closed_loop(&fmus, Coupling::ControllerFirst, gain);
    // y_{k+1} = y_k + h K (r − y_k)  ⇒  y_k = 1 − (1 − hK)^k, u_k = K (1 − hK)^k
    let ratio: f64 = 1.0 - H * gain;
    for k in 0..40 {
        let (y, u) =
            (memory.values("position[1]").unwrap()[k], memory.values("command[1]").unwrap()[k]);
        let decay = ratio.powi(k as i32);
        assert!((y - (1.0 - decay)).abs() < 1e-14, "y_{k} = {y}");
        assert!((u - gain * decay).abs() < 1e-14, "u_{k} = {u}");
    }
}

#[test]
fn side_by_side_has_one_sample_more() {
    let fmus = fmus_or_skip!();
    let memory = closed_loop(&fmus, Coupling::SideBySide, 1.5);
    // y_{k+1} = y_k + h u_k, u_{k+1} = K (r − y_k): λ² − λ + hK = 0, hK = 3/16, λ = 3/4, 1/4;
    // y_0 = y_1 = 0  ⇒  y_k = 1 − 1.5 (3/4)^k + 0.5 (1/4)^k
    for (k, y) in memory.values("position[1]").unwrap().iter().enumerate() {
        let exact = 1.0 - 1.5 * 0.75_f64.powi(k as i32) + 0.5 * 0.25_f64.powi(k as i32);
        assert!((y - exact).abs() < 1e-14, "y_{k} = {y}, exact {exact}");
    }
    assert_eq!(memory.values("command[1]").unwrap()[0], 0.0);
    let names: Vec<&str> = memory.series().iter().map(|s| s.column.name.as_str()).collect();
    assert_eq!(names, ["reference[1]", "command[1]", "position[1]"]);
}

#[test]
fn units_are_converted_on_connections() {
    let fmus = fmus_or_skip!();
    let mut in_metres = common::controller();
    in_metres.variables[1].properties.unit = Some("m".to_owned());
    let controller = cosim::Fmu::open(fmus.pack("controller", &in_metres)).unwrap();
    let mut diagram = Diagram::new();
    diagram
        .add(instance(&fmus.integrator(), "source"))
        .add(instance(&controller, "sampler"))
        .start(("source", "command[1]"), 8.0)
        .connect(("source", "position[1]"), ("sampler", "measured[1]"))
        .record(("sampler", "measured[1]"));
    let mut system = diagram.build().unwrap();
    let signals = Signals::default();
    let points = Points::uniform(0.0, 1.0, 1.0).unwrap();
    let mut memory = Memory::new();
    let run = Run::new(points, &signals);
    system.run(&run, &Jacobi, &mut memory).unwrap();
    assert_eq!(memory.values("measured[1]").unwrap(), [0.0, 8e-6]);
    assert_eq!(memory.series()[0].column.unit.as_deref(), Some("m"));
}

#[test]
fn every_problem_of_a_diagram_is_reported() {
    let fmus = fmus_or_skip!();
    let mut diagram = Diagram::new();
    diagram
        .add(instance(&fmus.integrator(), "plant"))
        .add(instance(&fmus.controller(), "controller"))
        .add(instance(&fmus.controller(), "controller"))
        .connect(("plant", "position[1]"), ("plant", "command[1]"))
        .connect(("plant", "postion[1]"), ("controller", "measured[1]"))
        .connect(("plan", "position[1]"), ("controller", "measured[1]"))
        .connect(("plant", "k"), ("controller", "measured[1]"))
        .connect(("controller", "command[1]"), ("plant", "position[1]"))
        .connect(("plant", "position[1]"), ("plant", "enabled"))
        .feed("r", None, ("controller", "reference[1]"))
        .connect(("plant", "position[1]"), ("controller", "reference[1]"))
        .start(("plant", "position[1]"), 1.0)
        .start(("plant", "limit"), "wide")
        .record(("plant", "label"));
    let problems = match diagram.build() {
        Ok(_) => panic!("this cannot be built"),
        Err(problems) => problems.0,
    };
    let has = |matches: fn(&Problem) -> bool| problems.iter().filter(|p| matches(p)).count();
    assert_eq!(has(|p| matches!(p, Problem::SameName { .. })), 1);
    assert_eq!(has(|p| matches!(p, Problem::Units { .. })), 1);
    assert_eq!(has(|p| matches!(p, Problem::NoSuchVariable { .. })), 1);
    assert_eq!(has(|p| matches!(p, Problem::NoSuchSlave { .. })), 1);
    assert_eq!(has(|p| matches!(p, Problem::WrongRole { .. })), 4);
    assert_eq!(has(|p| matches!(p, Problem::TwoSources { .. })), 1);
    assert_eq!(has(|p| matches!(p, Problem::StartValue { .. })), 2);
    assert_eq!(problems.len(), 11);
    let text = cosim::Problems(problems).to_string();
    assert!(text.contains("did you mean `position[1]`?"), "{text}");
    assert!(
        text.contains(
            "output `position[1]` of FMU `plant` in um cannot feed \
                           `command[1]` of FMU `plant` in V: m is not kg.m2.s-3.A-1"
        ),
        "{text}"
    );
    assert!(
        text.contains("two sources: column `r` and output `position[1]` of FMU `plant`"),
        "{text}"
    );
}
