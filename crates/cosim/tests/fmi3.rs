//! FMUs of FMI 3.0: the same master, the same answers, also beside FMUs of FMI 2.0.
#![allow(clippy::print_stdout)]

use crate::common;
use common::instance;
use cosim::{
    Coupling, Diagram, Drive, Experiment, Fmu, GaussSeidel, Loop, LoopSettings, Memory, Points,
    Run, Selection, Signals, Value, Wiring, simulate_with_inputs,
};

fn integrator3(fmus: &common::Fmus) -> Fmu {
    Fmu::open(fmus.pack("integrator3", &common::integrator3())).expect("it opens")
}

#[test]
fn a_driven_fmu_of_fmi_3_gives_the_values_of_fmi_2() {
    let fmus = fmus_or_skip!();
    let time: Vec<f64> = (0..100).map(|k| 5.0 + f64::from(k) * 0.01).collect();
    let u: Vec<f64> = time.iter().map(|t| (7.0 * t).cos()).collect();
    // Two records: this FMU has no fmi3Reset and is made anew.
    let signals = || Signals::new(&time).with("command[1]", &u);
    let drive = Drive {
        parameters: vec![("k".to_owned(), Value::Real(2.0))],
        record: vec!["command[1]".to_owned(), "position[1]".to_owned()],
        ..Drive::default()
    };
    let run = |fmu: &Fmu| {
        let mut memory = Memory::new();
        let records = [signals(), signals()];
        simulate_with_inputs(instance(fmu, "p"), &records, &drive, &mut memory).unwrap();
        memory
    };
    let fmu = integrator3(&fmus);
    assert_eq!(
        fmu.missing_functions(),
        [
            "fmi3SetDebugLogging",
            "fmi3Reset",
            "fmi3GetDirectionalDerivative",
            "fmi3GetOutputDerivatives"
        ]
    );
    assert_eq!(run(&fmu).records(), [0..100, 100..200]);
    let (three, two) = (run(&fmu), run(&fmus.integrator()));
    for (a, b) in
        three.values("position[1]").unwrap().iter().zip(two.values("position[1]").unwrap())
    {
        // The one adds k·u·(t + h − t), the other k·u·h.
        assert!((a - b).abs() < 1e-14, "{a} {b}");
    }
}

#[test]
fn both_versions_close_a_loop() {
    let fmus = fmus_or_skip!();
    let (c, p) =
        (instance(&fmus.controller(), "controller"), instance(&integrator3(&fmus), "plant"));
    let wiring = Wiring::by_name(&*c, &*p, &["reference[1]"]).unwrap();
    let parameters = vec![("controller".to_owned(), "k".to_owned(), 2.0.into())];
    let coupling = Coupling::ControllerFirst;
    let settings = LoopSettings { wiring, coupling, parameters, ..LoopSettings::default() };
    let mut closed = Loop::new(c, p, &settings).unwrap();
    let signals = Signals::new(&[0.0]).with("reference[1]", &[1.0]);
    let points = Points::uniform(0.0, 5.0, 0.125).unwrap();
    let mut memory = Memory::new();
    closed.run(&Run::new(points, &signals), &mut memory).unwrap();
    for (k, y) in memory.values("position[1]").unwrap().iter().enumerate() {
        assert!((y - (1.0 - 0.75_f64.powi(k as i32))).abs() < 1e-14, "y_{k} = {y}");
    }
}

#[test]
fn values_of_every_type_by_name() {
    let fmus = fmus_or_skip!();
    let mut slave = instance(&integrator3(&fmus), "p");
    for (name, value) in [
        ("k", Value::Real(2.5)),
        ("f32", Value::Real(0.5)),
        ("i8", Value::Integer(-128)),
        ("u8", Value::Integer(255)),
        ("i16", Value::Integer(-32768)),
        ("u16", Value::Integer(65535)),
        ("i32", Value::Integer(i128::from(i32::MIN))),
        ("u32", Value::Integer(i128::from(u32::MAX))),
        ("i64", Value::Integer(-(1 << 53))),
        ("u64", Value::Integer(1 << 53)),
        ("boolean", Value::Boolean(true)),
        ("label", Value::from("Tür 50 %")),
    ] {
        slave.set_start(name, &value).unwrap();
        assert_eq!(slave.value(name).unwrap(), value, "{name}");
    }
    for (name, value) in [("i8", 128), ("u8", -1), ("u16", 65536), ("u64", -1), ("boolean", 2)] {
        let error = slave.set_start(name, &Value::Integer(value)).unwrap_err().to_string();
        assert!(error.contains(&format!("cannot take {value}")), "{error}");
    }
}

#[test]
fn states_are_saved_and_go_to_other_instances() {
    let fmus = fmus_or_skip!();
    let fmu = integrator3(&fmus);
    let (mut a, mut b) = (instance(&fmu, "a"), instance(&fmu, "b"));
    a.setup(&Experiment::default()).unwrap();
    a.enter_initialization().unwrap();
    a.set_start("command[1]", &Value::Real(3.0)).unwrap();
    a.exit_initialization().unwrap();
    a.step(0.0, 1.0).unwrap();
    let saved = a.save(None).unwrap();
    a.step(1.0, 1.0).unwrap();
    assert_eq!(a.value("position[1]").unwrap(), Value::Real(6.0));
    a.restore(saved).unwrap();
    assert_eq!(a.value("position[1]").unwrap(), Value::Real(3.0));
    let bytes = a.serialize(saved).unwrap();
    let loaded = b.deserialize(&bytes).unwrap();
    b.restore(loaded).unwrap();
    assert_eq!(b.value("position[1]").unwrap(), Value::Real(3.0));
    let error = b.deserialize(&bytes[1..]).unwrap_err().to_string();
    assert!(
        error.contains(
            "fmi3DeserializeFMUState returned Error; the FMU says:\n  \
                            [Error, logStatus] these bytes are no state of mine"
        ),
        "{error}"
    );
    a.forget(saved).unwrap();
    assert!(a.restore(saved).is_err());
}

#[test]
fn an_fmu_may_end_the_run_within_a_step() {
    let fmus = fmus_or_skip!();
    let signals = Signals::new(&[0.0, 1.0, 2.0, 3.0])
        .with("command[1]", &[1.0; 4])
        .with("i32", &[0.0, 99.0, 0.0, 0.0]);
    let mut memory = Memory::new();
    let slave = instance(&integrator3(&fmus), "p");
    let endings = simulate_with_inputs(slave, &[signals], &Drive::default(), &mut memory).unwrap();
    assert_eq!(endings[0].as_ref().map(|ending| ending.time), Some(1.5));
    assert_eq!(memory.time(), [0.0, 1.0, 1.5]);
    assert_eq!(memory.values("position[1]").unwrap(), [0.0, 1.0, 1.5]);
}

#[test]
fn a_wrong_token_is_refused_with_the_words_of_the_fmu() {
    let fmus = fmus_or_skip!();
    let mut description = common::integrator3();
    description.instantiation_token = "another".to_owned();
    let fmu = Fmu::open(fmus.pack("integrator3", &description)).unwrap();
    let error = match fmu.instantiate("p", &Default::default()) {
        Ok(_) => panic!("the token is wrong"),
        Err(error) => error.to_string(),
    };
    assert!(
        error.starts_with("FMU `p`: fmi3InstantiateCoSimulation returned no instance"),
        "{error}"
    );
    assert!(error.contains("this token is not mine: 100%"), "{error}");
}

/// y' = u, element by element; the elements that nothing feeds keep their start values.
#[test]
fn elements_of_arrays_are_fed_connected_and_recorded() {
    let fmus = fmus_or_skip!();
    let fmu = integrator3(&fmus);
    let mut diagram = Diagram::new();
    diagram
        .add(instance(&fmu, "a"))
        .add(instance(&fmu, "b"))
        .feed("column", None, ("a", "u[2]"))
        .start(("a", "u[3]"), 7.0)
        .connect(("a", "y[2]"), ("b", "u[1]"))
        .connect(("a", "y[3]"), ("b", "u[2]"))
        .connect(("a", "y[1]"), ("b", "u[3]"));
    for name in ["y[1]", "y[2]", "y[3]"] {
        diagram.record(("a", name)).record(("b", name));
    }
    let mut system = diagram.build().expect("a system");
    let signals = Signals::new(&[0.0]).with("column", &[5.0]);
    let order = GaussSeidel::by_dependency(&system);
    let mut memory = Memory::new();
    for _ in 0..2 {
        memory = Memory::new();
        let points = Points::uniform(0.0, 2.0, 1.0).expect("points");
        let run = Run::new(points, &signals);
        system.run(&run, &order, &mut memory).expect("a run");
    }
    let found = |name: &str| memory.values(name).expect(name).to_vec();
    assert_eq!(found("a.y[1]"), [0.0, 1.0, 2.0]);
    assert_eq!(found("a.y[2]"), [0.0, 5.0, 10.0]);
    assert_eq!(found("a.y[3]"), [0.0, 7.0, 14.0]);
    // Sources step first: b works with a's values at the end of the step.
    assert_eq!(found("b.y[1]"), [0.0, 5.0, 15.0]);
    assert_eq!(found("b.y[2]"), [0.0, 7.0, 21.0]);
    assert_eq!(found("b.y[3]"), [0.0, 1.0, 3.0]);
}

/// With k = -77 the FMU writes four values where it is asked for three.
#[test]
fn an_array_that_is_written_beyond_its_end_is_reported() {
    let fmus = fmus_or_skip!();
    let mut slave = instance(&integrator3(&fmus), "p");
    for names in [&["y[1]", "y[2]", "y[3]"][..], &["y[2]"]] {
        let selection = Selection::of(slave.description(), names).expect("elements");
        let mut values = vec![9.0; names.len()];
        slave.set_start("k", &Value::Real(1.0)).expect("a parameter");
        slave.get(&selection, &mut values).expect("values");
        assert_eq!(values, vec![0.0; names.len()]);
        slave.set_start("k", &Value::Real(-77.0)).expect("a parameter");
        let error = slave.get(&selection, &mut values).expect_err("too many").to_string();
        assert!(error.contains("fmi3GetFloat64 was asked for 3 values and wrote more"), "{error}");
    }
}

#[test]
fn what_is_no_element_is_reported() {
    let fmus = fmus_or_skip!();
    let fmu = integrator3(&fmus);
    let mut diagram = Diagram::new();
    diagram.add(instance(&fmu, "a")).record(("a", "y")).record(("a", "y[4]")).record(("a", "z[1]"));
    let error = diagram.build().err().expect("problems").to_string();
    for words in [
        "variable `y` of FMU `a` is of type array of Float64, but must be one number",
        "array `y` of FMU `a` has no element `y[4]`: the array has 3 elements, counted from 1",
        "FMU `a` has no variable `z[1]`",
    ] {
        assert!(error.contains(words), "{words} is not in\n{error}");
    }
    let slave = instance(&fmu, "a");
    let selection = Selection::of(slave.description(), &["y[1]", "y[2]", "y[3]"]).expect("three");
    let [run] = selection.runs() else { panic!("one call reads all three") };
    assert!(run.array.as_ref().is_some_and(|array| array.is_complete()));
    assert!(Selection::of(slave.description(), &["y[9]"]).is_err());
}
