//! Systems: steps of several lengths, algebraic loops, scaled connections.
#![allow(clippy::print_stdout)]

use crate::common;
use common::{Fmus, instance};
use cosim::{
    Algorithm, Diagram, Error, GaussSeidel, Iteration, IterationSettings, Jacobi, Memory, Points,
    Relaxation, Run, Signals, System, Transformations, Value,
};

fn loop_of(fmus: &Fmus, controller_gain: f64, every: usize) -> System {
    loop_with_steps(fmus, controller_gain, [every, 1])
}

/// Of controller and plant.
fn loop_with_steps(fmus: &Fmus, controller_gain: f64, every: [usize; 2]) -> System {
    let (controller, plant) = (fmus.controller(), fmus.integrator());
    let mut diagram = Diagram::new();
    diagram
        .add(instance(&controller, "c"))
        .add(instance(&plant, "p"))
        .connect(("c", "command[1]"), ("p", "command[1]"))
        .connect(("p", "position[1]"), ("c", "measured[1]"))
        .start(("c", "k"), controller_gain)
        .start(("c", "reference[1]"), 1.0)
        .every("c", every[0])
        .every("p", every[1])
        .record(("c", "command[1]"))
        .record_as(("p", "command[1]"), "u")
        .record(("p", "position[1]"));
    diagram.build().expect("a system")
}

fn run(system: &mut System, algorithm: &dyn Algorithm, steps: u32) -> Result<Memory, Error> {
    let mut memory = Memory::new();
    let signals = Signals::new(&[0.0]);
    let points = Points::uniform(0.0, f64::from(steps), 1.0).expect("points");
    let run = Run::new(points, &signals);
    system.run(&run, algorithm, &mut memory).map(|_| memory)
}

fn close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{found:?} is not {expected:?}");
    }
}

/// The runs are those of systems that were made with the values.
#[test]
fn start_values_are_replaced_between_runs() {
    let fmus = fmus_or_skip!();
    let mut system = loop_of(&fmus, 0.25, 1);
    let first = GaussSeidel::in_order(&system, &["c", "p"]).unwrap();
    for k in [0.25, 0.5, 0.125, 0.5] {
        system.set_start(&("c", "k").into(), Value::Real(k)).unwrap();
        let mut anew = loop_of(&fmus, k, 1);
        assert_eq!(run(&mut system, &first, 8).unwrap(), run(&mut anew, &first, 8).unwrap());
    }
    for (variable, value, words) in [
        ("k", Value::from("a"), "of type Float64"),
        ("position[1]", Value::Real(1.0), "position[1]"),
        ("measured[1]", Value::Real(1.0), "no start value to replace"),
    ] {
        let message = system.set_start(&("c", variable).into(), value).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

/// u = k (1 − y), held over three steps; y' = u.
#[test]
fn a_slow_controller_holds_its_command() {
    let fmus = fmus_or_skip!();
    let (k, every) = (0.25, 3);
    let mut system = loop_of(&fmus, k, every);
    let first = GaussSeidel::in_order(&system, &["c", "p"]).unwrap();
    let memory = run(&mut system, &first, 8).unwrap();
    let (mut y, mut u, mut acts, mut positions) = (0.0, 0.0, Vec::new(), Vec::new());
    for n in 0..8 {
        if n % every == 0 {
            u = k * (1.0 - y);
        }
        acts.push(u);
        positions.push(y);
        y += u;
    }
    positions.push(y);
    close(&memory.values("u").unwrap()[..8], &acts);
    close(memory.values("position[1]").unwrap(), &positions);
    // The command is seen as an output when its time is reached.
    let seen: Vec<f64> =
        (0..=8_usize).map(|n| if n < 3 { 0.0 } else { acts[n / every * every - 1] }).collect();
    let command = memory.values("c.command[1]").or(memory.values("command[1]")).unwrap();
    close(&command[..8], &seen[..8]);
}

#[test]
fn side_by_side_a_slow_output_is_seen_when_its_time_is_reached() {
    let fmus = fmus_or_skip!();
    let (k, every) = (0.25, 3);
    let mut system = loop_of(&fmus, k, every);
    let memory = run(&mut system, &Jacobi, 9).unwrap();
    let (mut y, mut next, mut acting, mut positions) = (0.0, 0.0, 0.0, Vec::new());
    for n in 0..9 {
        if n % every == 0 {
            acting = next;
            next = k * (1.0 - y);
        }
        positions.push(y);
        y += acting;
    }
    positions.push(y);
    close(memory.values("position[1]").unwrap(), &positions);
    // A second run of the same system is the first.
    let again = run(&mut system, &Jacobi, 9).unwrap();
    assert_eq!(again, memory);
}

#[test]
fn an_fmu_of_equal_steps_needs_a_whole_number_of_its_own() {
    let fmus = fmus_or_skip!();
    let mut description = common::controller();
    let co_simulation = description.co_simulation.as_mut().unwrap();
    co_simulation.can_handle_variable_communication_step_size = false;
    let fmu = cosim::Fmu::open(fmus.pack("controller", &description)).unwrap();
    let mut diagram = Diagram::new();
    diagram.add(instance(&fmu, "c")).every("c", 4);
    let error = run(&mut diagram.build().unwrap(), &Jacobi, 10).unwrap_err().to_string();
    assert!(error.contains("FMU `c` steps once every 4 communication steps"), "{error}");
    let mut diagram = Diagram::new();
    diagram.add(instance(&fmu, "c")).every("c", 0).every("d", 2);
    let error = diagram.build().err().unwrap().to_string();
    assert!(error.contains("every 0") && error.contains("no FMU `d`"), "{error}");
}

/// Implicit coupling: u = k (1 − y⁺) and y⁺ = y + u, so y⁺ = (y + k)/(1 + k).
#[test]
fn a_loop_is_solved_by_iteration_with_rollback() {
    let fmus = fmus_or_skip!();
    // Plain substitution diverges for k > 1; Aitken solves it.
    for (k, relaxation) in [
        (0.5, Relaxation::Fixed(1.0)),
        (0.5, Relaxation::Aitken),
        (3.0, Relaxation::Fixed(0.25)),
        (3.0, Relaxation::Aitken),
        (40.0, Relaxation::Aitken),
    ] {
        let mut system = loop_of(&fmus, k, 1);
        let settings = IterationSettings { relaxation, tolerance: 1e-13, iterations: 200 };
        let iteration = Iteration::new(&system, settings).unwrap();
        assert_eq!(iteration.loops().collect::<Vec<_>>(), [[0, 1]]);
        let memory = run(&mut system, &iteration, 10).unwrap();
        let mut expected = vec![0.0];
        for n in 0..10 {
            expected.push((expected[n] + k) / (1.0 + k));
        }
        let found = memory.values("position[1]").unwrap();
        for (a, b) in found.iter().zip(&expected) {
            assert!(
                (a - b).abs() < 1e-11,
                "k = {k}, {relaxation:?}: {found:?} is not {expected:?}"
            );
        }
        assert_eq!(run(&mut system, &iteration, 10).unwrap(), memory, "a second run is the first");
    }
}

/// The solutions at the points where steps of the loop end, u = k (1 − y) held by the slow one.
///
/// Plant by plant: y += u·(its step), where u is what the controller has given at the end of that step if it
/// gives it there, else what it gave last.
#[test]
fn a_loop_of_different_steps_is_solved_where_they_end() {
    let fmus = fmus_or_skip!();
    let k = 0.7;
    for every in [[1, 1], [2, 2], [3, 1], [1, 3], [2, 3], [4, 2]] {
        let [c, p] = every;
        let mut system = loop_with_steps(&fmus, k, every);
        let settings =
            IterationSettings { tolerance: 1e-14, iterations: 200, ..Default::default() };
        let iteration = Iteration::new(&system, settings).unwrap();
        let steps = 12;
        let memory = run(&mut system, &iteration, steps as u32).unwrap();
        // The controller gives 0 before its first step.
        let (mut u, mut y, mut commands, mut positions) = (0.0, 0.0, vec![0.0], vec![0.0]);
        for end in 1..=steps {
            match (end % c == 0, end % p == 0) {
                (true, true) => {
                    let h = p as f64;
                    y = (y + h * k) / (1.0 + h * k);
                    u = k * (1.0 - y);
                }
                (true, false) => u = k * (1.0 - y),
                (false, true) => y += p as f64 * u,
                (false, false) => {}
            }
            commands.push(u);
            positions.push(y);
        }
        println!("every {every:?}: y = {positions:?}");
        close(memory.values("position[1]").unwrap(), &positions);
        let command = memory.values("c.command[1]").unwrap();
        close(command, &commands);
        assert_eq!(run(&mut system, &iteration, steps as u32).unwrap(), memory, "{every:?}, again");
        // Made after a run it is the same.
        let anew = Iteration::new(&system, settings).unwrap();
        assert_eq!(run(&mut system, &anew, steps as u32).unwrap(), memory, "{every:?}, anew");
    }
}

/// An end of the run inside a slow step shortens that step.
#[test]
fn the_last_slow_step_of_a_loop_ends_with_the_run() {
    let fmus = fmus_or_skip!();
    let k = 0.5;
    let mut system = loop_with_steps(&fmus, k, [1, 3]);
    let iteration = Iteration::new(&system, IterationSettings::default()).unwrap();
    let memory = run(&mut system, &iteration, 5).unwrap();
    let after = |y: f64, h: f64| (y + h * k) / (1.0 + h * k);
    let (first, last) = (after(0.0, 3.0), after(after(0.0, 3.0), 2.0));
    let found = memory.values("position[1]").unwrap();
    for (n, (a, b)) in found.iter().zip([0.0, 0.0, 0.0, first, first, last]).enumerate() {
        assert!((a - b).abs() < 1e-8, "{n}: {found:?}");
    }
}

/// Behind a loop of different steps a slow slave works with what the loop gives at the end of its step.
#[test]
fn what_a_loop_of_different_steps_feeds_is_not_late() {
    let fmus = fmus_or_skip!();
    let (controller, plant) = (fmus.controller(), fmus.integrator());
    let mut diagram = Diagram::new();
    diagram
        .add(instance(&plant, "behind"))
        .add(instance(&controller, "c"))
        .add(instance(&plant, "p"))
        .connect(("c", "command[1]"), ("p", "command[1]"))
        .connect(("p", "position[1]"), ("c", "measured[1]"))
        .connect_by(
            ("p", "position[1]"),
            ("behind", "command[1]"),
            Transformations::scaled(1.0, 0.0, true),
        )
        .start(("c", "k"), 0.25)
        .start(("c", "reference[1]"), 1.0)
        .every("c", 3)
        .every("behind", 2)
        .record_as(("p", "position[1]"), "y")
        .record_as(("behind", "position[1]"), "sum");
    let mut system = diagram.build().unwrap();
    let iteration = Iteration::new(&system, IterationSettings::default()).unwrap();
    let memory = run(&mut system, &iteration, 12).unwrap();
    let (y, sum) = (memory.values("y").unwrap(), memory.values("sum").unwrap());
    let mut expected = 0.0;
    for n in 1..=12 {
        if n % 2 == 0 {
            expected += 2.0 * y[n];
        }
        assert!((sum[n] - expected).abs() < 1e-12, "{n}: {sum:?}");
    }
}

#[test]
fn a_loop_without_solution_is_named() {
    let fmus = fmus_or_skip!();
    let mut system = loop_of(&fmus, 3.0, 1);
    let relaxation = Relaxation::Fixed(1.0);
    let settings = IterationSettings { relaxation, iterations: 20, ..Default::default() };
    let iteration = Iteration::new(&system, settings).unwrap();
    let error = run(&mut system, &iteration, 10).unwrap_err().to_string();
    assert!(
        error.starts_with(
            "at t = 0 s: the algebraic loop of `position[1]` of FMU `p` is not solved after 20 passes"
        ),
        "{error}"
    );
}

#[test]
fn a_loop_needs_states_and_settings() {
    let fmus = fmus_or_skip!();
    let bare = cosim::Fmu::open(fmus.pack("bare", &common::bare())).unwrap();
    let mut diagram = Diagram::new();
    diagram.add(instance(&bare, "a")).add(instance(&bare, "b"));
    diagram.connect(("a", "y"), ("b", "u")).connect(("b", "y"), ("a", "u"));
    let system = diagram.build().unwrap();
    let settings =
        IterationSettings { relaxation: Relaxation::Fixed(0.0), tolerance: 2.0, iterations: 1 };
    let error = Iteration::new(&system, settings).unwrap_err().to_string();
    for words in ["relaxation of 0", "tolerance of 2", "1 passes", "FMU `a` is in", "FMU `b` is in"]
    {
        assert!(error.contains(words), "{words}: {error}");
    }
    assert!(error.contains("canGetAndSetFMUstate"));
}

/// Without loops, sources step before targets, whatever the order in which they were added.
#[test]
fn slaves_outside_loops_step_in_dependency_order() {
    let fmus = fmus_or_skip!();
    let plant = fmus.integrator();
    let mut diagram = Diagram::new();
    diagram
        .add(instance(&plant, "last"))
        .add(instance(&plant, "first"))
        .connect_by(
            ("first", "position[1]"),
            ("last", "command[1]"),
            Transformations::scaled(2.0, 1.0, true),
        )
        .start(("first", "command[1]"), 1.0)
        .start(("last", "k"), Value::Real(1.0))
        .record(("last", "position[1]"))
        .record(("last", "command[1]"));
    let mut system = diagram.build().unwrap();
    let iteration = Iteration::new(&system, IterationSettings::default()).unwrap();
    assert_eq!(iteration.loops().count(), 0);
    let memory = run(&mut system, &iteration, 3).unwrap();
    // 2·y + 1 with y at the end of the step.
    close(&memory.values("command[1]").unwrap()[..3], &[3.0, 5.0, 7.0]);
    close(memory.values("position[1]").unwrap(), &[0.0, 3.0, 8.0, 15.0]);
}
