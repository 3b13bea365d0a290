//! One FMU driven by a log: what acts when, in which order calls are made, what is recorded.
#![allow(clippy::print_stdout)]

use crate::common;
use common::instance;
use cosim::{
    CsvRecorder, Diagram, Drive, Fmu, Jacobi, Memory, Points, Run, Signal, Signals, Slave, Value,
    simulate_with_inputs,
};

const DT: f64 = 1e-3;

fn times(rows: usize) -> Vec<f64> {
    (0..rows).map(|k| 2.0 + k as f64 * DT).collect()
}

#[test]
fn a_row_acts_until_the_next_and_outputs_are_read_before_it_acts() {
    let fmus = fmus_or_skip!();
    let time = times(50);
    let u: Vec<f64> = (0..50).map(|k| (0.3 * f64::from(k)).sin()).collect();
    let signals = Signals::new(&time).with("command[1]", &u);
    let mut memory = Memory::new();
    let endings = simulate_with_inputs(
        instance(&fmus.integrator(), "plant"),
        &[signals],
        &Drive::default(),
        &mut memory,
    )
    .unwrap();
    assert_eq!(endings, [None]);
    assert_eq!(memory.time(), time);
    assert_eq!(memory.values("command[1]").unwrap(), u);
    let mut y = 0.0;
    for k in 0..50 {
        assert_eq!(memory.values("position[1]").unwrap()[k], y, "row {k}");
        assert_eq!(memory.values("steps").unwrap()[k], k as f64);
        if k < 49 {
            y += u[k] * (time[k + 1] - time[k]);
        }
    }
    let names: Vec<&str> = memory.series().iter().map(|s| s.column.name.as_str()).collect();
    assert_eq!(names, ["command[1]", "position[1]", "steps"]);
    assert_eq!(memory.series()[1].column.unit.as_deref(), Some("um"));
}

#[test]
fn unequal_rows_are_stepped_from_row_to_row() {
    let fmus = fmus_or_skip!();
    let time = [0.0, 0.1, 0.5, 0.6];
    let u = [1.0, 10.0, 100.0, 0.0];
    let mut memory = Memory::new();
    let signals = Signals::new(&time).with("u", &u);
    let drive = Drive { map: vec![("command[1]".to_owned(), "u".to_owned())], ..Drive::default() };
    simulate_with_inputs(instance(&fmus.integrator(), "plant"), &[signals], &drive, &mut memory)
        .unwrap();
    let expected = [0.0, 0.1, 4.1, 14.1];
    for (y, exact) in memory.values("position[1]").unwrap().iter().zip(expected) {
        assert!((y - exact).abs() < 1e-13, "{y} {exact}");
    }
}

#[test]
fn calls_come_in_the_order_of_fmpy() {
    let fmus = fmus_or_skip!();
    let fmu = fmus.integrator();
    let mut slave = instance(&fmu, "plant");
    assert_eq!(text_of(&mut *slave, "history"), "");
    let mut diagram = Diagram::new();
    diagram
        .add(slave)
        .feed("u", None, ("plant", "command[1]"))
        .start(("plant", "k"), 3.0)
        .record(("plant", "position[1]"));
    let mut system = diagram.build().unwrap();
    let signals = Signals::new(&[0.0, 0.1, 0.2]).with("u", &[1.0, 2.0, 3.0]);
    let run = Run {
        record: 0,
        points: Points::rows(signals.time).unwrap(),
        signals: &signals,
        tolerance: None,
        no_stop_time: false,
        pace: None,
    };
    let mut memory = Memory::new();
    system.run(&run, &Jacobi, &mut memory).unwrap();
    // setup, k, enter, input, exit, read, then twice input, doStep, read; terminate. This is the
    // order of calls of fmpy.simulate_fmu.
    let value = system.slave(0).unwrap();
    let text = text_of(value, "history");
    assert_eq!(text, "srerxgrdgrdgt");
    // A second run resets first.
    system.run(&run, &Jacobi, &mut memory).unwrap();
    assert_eq!(text_of(system.slave(0).unwrap(), "history"), "Rsrerxgrdgrdgt");
    assert_eq!(memory.records(), [0..3, 3..6]);
    assert_eq!(
        memory.values("position[1]").unwrap()[..3],
        memory.values("position[1]").unwrap()[3..]
    );
    assert!((memory.values("position[1]").unwrap()[2] - 0.9).abs() < 1e-15);
}

fn text_of(slave: &mut dyn Slave, variable: &str) -> String {
    match slave.value(variable).unwrap() {
        Value::Text(text) => text,
        other => panic!("{other}"),
    }
}

#[test]
fn records_begin_anew_with_their_parameters() {
    let fmus = fmus_or_skip!();
    let time = times(4);
    let (a, b) = ([1.0; 4], [2.0; 4]);
    let records = [
        Signals::new(&time).with("command[1]", &a),
        Signals::new(&time[1..]).with("command[1]", &b[1..]),
    ];
    let drive = Drive {
        parameters: vec![("k".to_owned(), Value::Real(5.0))],
        record: vec!["position[1]".to_owned()],
        ..Drive::default()
    };
    let mut out = CsvRecorder::new(Vec::new()).with_record_column().with_units();
    simulate_with_inputs(instance(&fmus.integrator(), "plant"), &records, &drive, &mut out)
        .unwrap();
    let text = String::from_utf8(out.into_inner().unwrap()).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "time [s],record,position[1] [um]");
    assert_eq!(lines.len(), 8);
    let cell = |line: usize, column: usize| -> f64 {
        lines[line].split(',').nth(column).unwrap().parse().unwrap()
    };
    assert_eq!((cell(1, 0), cell(1, 1), cell(1, 2)), (2.0, 0.0, 0.0));
    assert!((cell(4, 2) - 5.0 * 3.0 * DT).abs() < 1e-14);
    assert_eq!((cell(5, 0), cell(5, 1), cell(5, 2)), (time[1], 1.0, 0.0));
    assert!((cell(7, 2) - 5.0 * 2.0 * 2.0 * DT).abs() < 1e-14);
}

#[test]
fn integers_booleans_and_tunable_parameters_are_fed() {
    let fmus = fmus_or_skip!();
    let time = [0.0, 1.0, 2.0, 3.0];
    let (ones, enabled, k) = ([1.0; 4], [1.0, 0.0, 1.0, 1.0], [1.0, 1.0, 7.0, 7.0]);
    // A tunable parameter is fed by the column of its name, as fmpy does, or by the map's.
    for (column, map) in [("k", vec![]), ("gain", vec![("k".to_owned(), "gain".to_owned())])] {
        let signals = Signals::new(&time)
            .with("command[1]", &ones)
            .with("enabled", &enabled)
            .with(column, &k);
        let drive = Drive { map, ..Drive::default() };
        let mut memory = Memory::new();
        let slave = instance(&fmus.integrator(), "plant");
        simulate_with_inputs(slave, &[signals], &drive, &mut memory).unwrap();
        assert_eq!(memory.values("position[1]").unwrap(), [0.0, 1.0, 1.0, 8.0]);
        assert_eq!(memory.values("enabled").unwrap(), enabled);
    }
}

#[test]
fn a_column_in_another_unit_is_converted() {
    let fmus = fmus_or_skip!();
    let kilovolt = modeldescription::description::BaseUnit {
        kg: 1,
        m: 2,
        s: -3,
        a: -1,
        factor: 1e3,
        ..Default::default()
    };
    let mut signals = Signals::new(&[0.0, 1.0]);
    let unit = Some(common::unit("kV", kilovolt));
    signals.columns.push(Signal { name: "command[1]".to_owned(), unit, values: &[2.0, 2.0] });
    let mut memory = Memory::new();
    let slave = instance(&fmus.integrator(), "plant");
    simulate_with_inputs(slave, &[signals], &Drive::default(), &mut memory).unwrap();
    assert_eq!(memory.values("command[1]").unwrap(), [2000.0, 2000.0]);
    assert_eq!(memory.values("position[1]").unwrap(), [0.0, 2000.0]);
}

#[test]
fn an_fmu_without_optional_functions_runs_and_is_created_anew_between_records() {
    let fmus = fmus_or_skip!();
    let fmu = Fmu::open(fmus.pack("bare", &common::bare())).unwrap();
    assert!(fmu.missing_functions().contains(&"fmi2Reset"));
    let time = [0.0, 1.0];
    let signals = Signals::new(&time).with("u", &[3.0, 4.0]);
    let mut memory = Memory::new();
    let records = [signals.clone(), signals];
    simulate_with_inputs(instance(&fmu, "bare"), &records, &Drive::default(), &mut memory).unwrap();
    assert_eq!(memory.values("y").unwrap(), [0.0, 6.0, 0.0, 6.0]);
}

#[test]
fn an_fmu_may_end_the_run() {
    let fmus = fmus_or_skip!();
    let time = [0.0, 1.0, 2.0, 3.0];
    let signals = Signals::new(&time).with("command[1]", &[1.0; 4]);
    let drive =
        Drive { parameters: vec![("end".to_owned(), Value::Real(1.5))], ..Drive::default() };
    let mut memory = Memory::new();
    let endings =
        simulate_with_inputs(instance(&fmus.integrator(), "p"), &[signals], &drive, &mut memory)
            .unwrap();
    let ending = endings[0].as_ref().expect("an early end");
    assert_eq!((ending.slave.as_str(), ending.time), ("p", 1.5));
    assert_eq!(memory.time(), [0.0, 1.0, 1.5]);
    assert_eq!(memory.values("position[1]").unwrap(), [0.0, 1.0, 1.5]);
}
