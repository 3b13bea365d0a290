//! FMI 3.0 in co-simulation: event mode, clocks, early return, structural parameters, 64 bits. The FMU,
//! `events3.c`, refuses every call that is not allowed in its mode.
#![allow(clippy::print_stdout)]

use crate::common;
use common::{events3, instance};
use cosim::{
    Diagram, Drive, Experiment, Fmu, GaussSeidel, Jacobi, Memory, Points, Run, Signals, Value,
    simulate_with_inputs,
};

fn opened(fmus: &common::Fmus) -> Fmu {
    Fmu::open(fmus.pack("events3", &events3())).expect("it opens")
}

/// A run of its own with nothing fed, from 0 to 1 s in steps of 0.1 s.
fn alone(fmu: &Fmu, names: &[&str]) -> Memory {
    let mut diagram = Diagram::new();
    diagram.add(instance(fmu, "p"));
    for name in names {
        diagram.record(("p", *name));
    }
    let mut system = diagram.build().expect("a system");
    let mut memory = Memory::new();
    // Twice: a reset begins all clocks anew.
    for _ in 0..2 {
        memory = Memory::new();
        let points = Points::uniform(0.0, 1.0, 0.1).expect("points");
        system.run(&Run::new(points, &Signals::default()), &Jacobi, &mut memory).expect("a run");
    }
    memory
}

#[test]
fn clocks_tick_when_their_kind_says() {
    let fmus = fmus_or_skip!();
    let names = ["samples", "askeds", "countdowns", "changes", "out", "sample", "kick", "pulses"];
    let memory = alone(&opened(&fmus), &names);
    let found = |name: &str| memory.values(name).expect(name).to_vec();
    // 0.1 + n·0.25; ticks at a point are in its row, as nothing feeds the FMU.
    assert_eq!(found("samples"), [0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0, 4.0, 4.0]);
    assert_eq!(found("sample"), [0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    // Every second of them lets the output clock tick.
    assert_eq!(found("out"), [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    // n·0.3, which the FMU says at initialization.
    assert_eq!(found("askeds"), [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 4.0, 4.0]);
    // 0.05 s after the second sample at 0.35 s.
    assert_eq!(found("countdowns"), [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
    // At 0.1, 0.3, 0.6, 1.0.
    assert_eq!(found("changes"), [0.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0, 4.0]);
    // The time event at 0.7; steps beyond it are refused.
    assert_eq!(found("kick"), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    assert_eq!(found("pulses"), [0.0; 11]);
}

#[test]
fn discrete_inputs_change_and_triggered_clocks_tick_at_events() {
    let fmus = fmus_or_skip!();
    let time: Vec<f64> = (0..6).map(|k| 0.1 * f64::from(k)).collect();
    let level = [1.0, 1.0, 4.0, 4.0, 4.0, 5.0];
    let pulse = [0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    let clocked = [7.0, 8.0, 9.0, 9.0, 10.0, 11.0];
    let u = [1.0, 2.0, 3.0, 6.0, 5.0, 6.0];
    let signals = Signals::new(&time)
        .with("level", &level)
        .with("pulse", &pulse)
        .with("clocked", &clocked)
        .with("u", &u);
    let names = ["seen", "pulses", "out", "taken", "held", "samples", "crossed"];
    let record = names.map(str::to_owned).to_vec();
    let drive = Drive { record, ..Drive::default() };
    let mut memory = Memory::new();
    simulate_with_inputs(instance(&opened(&fmus), "p"), &[signals], &drive, &mut memory)
        .expect("a run");
    let found = |name: &str| memory.values(name).expect(name).to_vec();
    assert_eq!(found("seen"), [1.0, 1.0, 1.0, 4.0, 4.0, 4.0]);
    assert_eq!(found("pulses"), [0.0, 0.0, 1.0, 1.0, 2.0, 3.0]);
    assert_eq!(found("taken"), [0.0, 0.0, 8.0, 8.0, 9.0, 10.0]);
    // Row k is read before the inputs of row k act: the sample at 0.1 takes u of 0.1, seen at 0.2.
    assert_eq!(found("held"), [0.0, 0.0, 2.0, 2.0, 6.0, 6.0]);
    assert_eq!(found("out")[1..5], [0.0, 1.0, 0.0, 1.0]);
    // y reaches 1 within a step.
    assert_eq!(found("crossed"), [0.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
}

#[test]
fn an_fmu_may_end_the_run_at_an_event() {
    let fmus = fmus_or_skip!();
    let signals = Signals::new(&[0.0, 0.1, 0.2, 0.3]).with("level", &[0.0, 0.0, 99.0, 0.0]);
    let mut memory = Memory::new();
    let slave = instance(&opened(&fmus), "p");
    let endings =
        simulate_with_inputs(slave, &[signals], &Drive::default(), &mut memory).expect("a run");
    assert_eq!(endings[0].as_ref().map(|ending| ending.time), Some(0.2));
}

#[test]
fn a_saved_state_keeps_the_clocks_also_as_bytes() {
    let fmus = fmus_or_skip!();
    let fmu = opened(&fmus);
    let (mut a, mut b) = (instance(&fmu, "a"), instance(&fmu, "b"));
    for slave in [&mut a, &mut b] {
        slave.setup(&Experiment::default()).expect("setup");
        slave.enter_initialization().expect("initialization");
        slave.exit_initialization().expect("a slave that steps");
    }
    let samples = |slave: &mut dyn cosim::Slave| slave.value("samples").expect("a value");
    a.step(0.0, 0.3).expect("a step");
    let saved = a.save(None).expect("a state");
    for _ in 0..2 {
        a.step(0.3, 0.4).expect("a step");
        assert_eq!(samples(&mut *a), Value::Integer(3));
        a.restore(saved).expect("the state");
        assert_eq!(samples(&mut *a), Value::Integer(1));
    }
    let bytes = a.serialize(saved).expect("bytes");
    let there = b.deserialize(&bytes).expect("a state");
    b.restore(there).expect("the state");
    b.step(0.3, 0.4).expect("a step");
    assert_eq!(samples(&mut *b), Value::Integer(3));
    assert!(b.deserialize(&bytes[..9]).is_err());
}

#[test]
fn arrays_follow_structural_parameters() {
    let fmus = fmus_or_skip!();
    let mut fmu = opened(&fmus);
    assert_eq!(fmu.elements("out array").expect("an array").len(), 2);
    fmu.configure(&[("n".to_owned(), Value::Integer(4))]).expect("a size");
    let mut diagram = Diagram::new();
    diagram.add(instance(&fmu, "p")).start(("p", "x[2]"), 20.0).start(("p", "n"), 4_i64);
    for k in 1..=4 {
        diagram.start(("p", format!("in[{k}]")), f64::from(k));
        diagram.record(("p", format!("out array[{k}]")));
    }
    let mut system = diagram.build().expect("a system");
    for _ in 0..2 {
        let mut memory = Memory::new();
        let points = Points::uniform(0.0, 0.1, 0.1).expect("points");
        system.run(&Run::new(points, &Signals::default()), &Jacobi, &mut memory).expect("a run");
        let last = |k: usize| memory.values(&format!("out array[{k}]")).expect("a column")[1];
        // x of the FMU is 1, 2, 3, 4; the second one is set.
        assert_eq!([1, 2, 3, 4].map(last), [1.0, 40.0, 9.0, 16.0]);
    }
    for (name, value, words) in [
        ("n", 6, "it must be from 1 to 5"),
        ("x", 3, "there is no structural parameter of this name"),
    ] {
        let error =
            fmu.configure(&[(name.to_owned(), Value::Integer(value))]).expect_err("refused");
        assert!(error.to_string().contains(words), "{error}");
    }
    let error = instance(&fmu, "p").set_start("n", &Value::Integer(3)).expect_err("too late");
    assert!(error.to_string().contains("before the instance is made"), "{error}");
}

#[test]
fn whole_numbers_of_64_bits_lose_nothing() {
    let fmus = fmus_or_skip!();
    let mut slave = instance(&opened(&fmus), "p");
    for (name, value) in [
        ("big", i128::from(i64::MIN)),
        ("big", i128::from(i64::MAX)),
        ("big", (1 << 53) + 1),
        ("huge", i128::from(u64::MAX)),
    ] {
        slave.set_start(name, &Value::Integer(value)).expect("a value");
        assert_eq!(slave.value(name).expect("a value"), Value::Integer(value));
    }
    for (name, value) in [("big", 1 << 63), ("huge", -1)] {
        assert!(slave.set_start(name, &Value::Integer(value)).is_err(), "{name} {value}");
    }
}

#[test]
fn connections_carry_whole_numbers_of_64_bits_as_they_are() {
    let fmus = fmus_or_skip!();
    let fmu = opened(&fmus);
    let mut diagram = Diagram::new();
    diagram
        .add(instance(&fmu, "a"))
        .add(instance(&fmu, "b"))
        .add(instance(&fmu, "slow"))
        .connect(("a", "big out"), ("b", "big in"))
        .connect(("a", "huge out"), ("b", "huge in"))
        .connect(("b", "big fed"), ("slow", "big in"))
        .connect(("b", "huge fed"), ("slow", "huge in"))
        .start(("a", "big"), 0_i64)
        .start(("a", "huge"), 0_i64)
        .record(("b", "big fed"));
    diagram.every("slow", 2);
    let mut system = diagram.build().expect("a system");
    let points = || Points::uniform(0.0, 0.8, 0.1).expect("points");
    let signals = Signals::default();
    for (big, huge) in [
        (i128::from(i64::MAX), i128::from(u64::MAX)),
        (i128::from(i64::MIN) + 1, (1 << 53) + 1),
        (-(1 << 60) - 3, i128::from(u64::MAX) - 1024),
        (7, 9),
    ] {
        for (name, value) in [("big", big), ("huge", huge)] {
            system.set_start(&("a", name).into(), Value::Integer(value)).expect("a start value");
        }
        for algorithm in [&Jacobi as &dyn cosim::Algorithm, &GaussSeidel::by_dependency(&system)] {
            let mut memory = Memory::new();
            system.run(&Run::new(points(), &signals), algorithm, &mut memory).expect("a run");
            for slave in 1..3 {
                let slave = system.slave(slave).expect("a slave");
                for (name, value) in [("big fed", big), ("huge fed", huge)] {
                    assert_eq!(slave.value(name).expect("a value"), Value::Integer(value));
                }
            }
            // A record holds the nearest double.
            assert_eq!(memory.values("big fed").expect("recorded").last(), Some(&(big as f64)));
        }
    }
}

#[test]
fn a_clock_within_a_step_that_the_fmu_takes_as_a_whole_is_reported() {
    let fmus = fmus_or_skip!();
    let mut description = events3();
    if let Some(co_simulation) = &mut description.co_simulation {
        co_simulation.can_handle_variable_communication_step_size = false;
    }
    let fmu = Fmu::open(fmus.pack("events3", &description)).expect("it opens");
    let mut diagram = Diagram::new();
    diagram.add(instance(&fmu, "p")).record(("p", "samples"));
    let mut system = diagram.build().expect("a system");
    let points = Points::uniform(0.0, 0.4, 0.2).expect("points");
    let signals = Signals::default();
    let run = Run::new(points, &signals);
    let error = system.run(&run, &Jacobi, &mut Memory::new()).expect_err("a clock inside");
    let error = error.to_string();
    assert!(error.contains("clock `sample`: it ticks at 0.1 s, within the"), "{error}");
}

#[test]
fn a_clock_that_ticks_by_itself_is_not_fed() {
    let fmus = fmus_or_skip!();
    let mut diagram = Diagram::new();
    let fmu = opened(&fmus);
    diagram
        .add(instance(&fmu, "a"))
        .add(instance(&fmu, "b"))
        .connect(("a", "out"), ("b", "sample"))
        .connect(("a", "out"), ("b", "pulse"));
    let error = diagram.build().err().expect("a problem").to_string();
    assert!(error.contains("a clock that does not tick by itself"), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
}
