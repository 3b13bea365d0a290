//! What a failing FMU leaves behind: an error with FMU, time, call and message, and the record.
#![allow(clippy::print_stdout)]

use crate::common;
use std::sync::{Arc, Mutex};

use common::instance;
use cosim::{
    Drive, Error, Experiment, Fmu, InstanceOptions, Memory, Points, Problem, Signals, Status,
    Value, simulate_with_inputs,
};

fn drive(parameters: &[(&str, Value)]) -> Drive {
    let parameters = parameters.iter().map(|(n, v)| ((*n).to_owned(), v.clone())).collect();
    Drive { parameters, ..Drive::default() }
}

#[test]
fn an_error_names_fmu_time_call_and_message_and_keeps_the_record() {
    let fmus = fmus_or_skip!();
    let time: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.5).collect();
    let u = vec![1.0; 100];
    let signals = Signals::new(&time).with("command[1]", &u);
    let mut memory = Memory::new();
    let error = simulate_with_inputs(
        instance(&fmus.integrator(), "stage"),
        &[signals],
        &drive(&[("limit", Value::Real(2.25))]),
        &mut memory,
    )
    .unwrap_err();
    assert_eq!(
        error.to_string(),
        "at t = 2 s: FMU `stage`: fmi2DoStep returned Error; the FMU says:\n  \
         [Error, logStatus] y = 2.5 is beyond its limit 2.25"
    );
    assert_eq!(memory.time(), [0.0, 0.5, 1.0, 1.5, 2.0]);
    assert_eq!(memory.values("position[1]").unwrap(), [0.0, 0.5, 1.0, 1.5, 2.0]);
}

/// The statuses of a step, asked for by the integrator's input `misbehaviour`.
fn misbehave(fmus: &common::Fmus, how: f64) -> (Result<(), Error>, Memory) {
    let signals = Signals::new(&[0.0, 1.0, 2.0, 3.0]).with("command[1]", &[1.0; 4]);
    let column = [0.0, how, 0.0, 0.0];
    let signals = signals.with("misbehaviour", &column);
    let mut memory = Memory::new();
    let outcome = simulate_with_inputs(
        instance(&fmus.integrator(), "p"),
        &[signals],
        &Drive::default(),
        &mut memory,
    );
    (outcome.map(|_| ()), memory)
}

#[test]
fn each_status_of_a_step_has_its_consequence() {
    let fmus = fmus_or_skip!();
    for (how, words) in [
        (
            1.0,
            "at t = 1 s: FMU `p`: fmi2DoStep returned Fatal; the FMU says:\n  [Fatal, logStatus] out of memory",
        ),
        (2.0, "at t = 1 s: FMU `p`: fmi2DoStep over 1 s returned Discard, having reached t = 1 s"),
        (4.0, "at t = 1 s: FMU `p`: fmi2DoStep returned Pending"),
        (5.0, "at t = 1 s: FMU `p`: fmi2DoStep returned 17 (not a status of the standard)"),
    ] {
        let (outcome, memory) = misbehave(&fmus, how);
        let text = outcome.unwrap_err().to_string();
        assert!(text.starts_with(words), "{text}");
        assert_eq!(memory.time(), [0.0, 1.0]);
    }
    // A warning passes.
    let (outcome, memory) = misbehave(&fmus, 3.0);
    outcome.unwrap();
    assert_eq!(memory.values("position[1]").unwrap(), [0.0, 1.0, 2.0, 3.0]);
}

#[test]
fn after_a_fatal_status_no_instance_is_called_again() {
    let fmus = fmus_or_skip!();
    let fmu = fmus.integrator();
    let (mut one, mut other) = (instance(&fmu, "one"), instance(&fmu, "other"));
    for slave in [&mut one, &mut other] {
        slave.setup(&Experiment::default()).unwrap();
        slave.enter_initialization().unwrap();
        slave.exit_initialization().unwrap();
    }
    one.set_start("misbehaviour", &Value::Integer(1)).unwrap();
    assert!(one.step(0.0, 1.0).unwrap_err().to_string().contains("returned Fatal"));
    for slave in [&mut one, &mut other] {
        let error = slave.step(0.0, 1.0).unwrap_err().to_string();
        assert!(error.contains("fmi2DoStep not called"), "{error}");
        assert!(slave.reset().is_err());
    }
    assert!(fmu.instantiate("third", &InstanceOptions::default()).is_err());
}

#[test]
fn messages_are_forwarded_at_once() {
    let fmus = fmus_or_skip!();
    let heard = Arc::new(Mutex::new(Vec::new()));
    let ears = Arc::clone(&heard);
    let options = InstanceOptions {
        on_message: Some(Arc::new(move |message| ears.lock().unwrap().push(message.clone()))),
        ..InstanceOptions::default()
    };
    let slave = fmus.integrator().instantiate("p", &options).unwrap();
    let signals = Signals::new(&[0.0, 1.0, 2.0, 3.0]).with("misbehaviour", &[3.0, 6.0, 7.0, 0.0]);
    simulate_with_inputs(slave, &[signals], &Drive::default(), &mut ()).unwrap();
    let heard = heard.lock().unwrap();
    let texts: Vec<&str> = heard.iter().map(|message| message.text.as_str()).collect();
    assert!(heard.iter().all(|message| message.status == Status::Warning));
    assert_eq!(texts[0], "this is odd");
    // Values of a printf format are shown; a text that is no format is left as it stands.
    if cfg!(target_os = "linux") {
        assert_eq!(texts[1], "p: -3 of  2.50 at 1 s, 123456789012%, c ff 1.000000e-03 end");
    }
    assert_eq!(texts[2], "100% too large, by %s and more");
    assert_eq!(heard[2].category, "");
}

#[test]
fn a_wrong_guid_is_refused_with_the_words_of_the_fmu() {
    let fmus = fmus_or_skip!();
    let mut description = common::integrator();
    description.instantiation_token = "another".to_owned();
    let fmu = Fmu::open(fmus.pack("integrator", &description)).unwrap();
    let error = match fmu.instantiate("p", &InstanceOptions::default()) {
        Ok(_) => panic!("the GUID is wrong"),
        Err(error) => error.to_string(),
    };
    assert!(
        error.starts_with("FMU `p`: fmi2Instantiate returned no instance (GUID \"another\""),
        "{error}"
    );
    assert!(error.contains("[Error, logStatus] the GUID is not 100% mine"), "{error}");
    assert!(error.contains("file:///") && error.contains("/resources"), "{error}");
}

#[test]
fn a_library_without_the_needed_functions_is_refused_with_their_names() {
    let fmus = fmus_or_skip!();
    let source = fmus.path("half.c");
    std::fs::write(&source, "int fmi2DoStep(void) { return 0; }").unwrap();
    let library = fmus.path("half.so");
    let output = std::process::Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .args([&library, &source])
        .output()
        .unwrap();
    assert!(output.status.success());
    let error = match fmi_bindings::import::v2::Library::load(&library) {
        Ok(_) => panic!("functions are missing"),
        Err(error) => error.to_string(),
    };
    for name in ["fmi2Instantiate", "fmi2FreeInstance", "fmi2SetReal", "fmi2GetReal"] {
        assert!(error.contains(name), "{error}");
    }
    assert!(!error.contains("fmi2DoStep"), "{error}");

    std::fs::write(&library, "no library").unwrap();
    let error = fmi_bindings::import::v2::Library::load(&library).err().unwrap().to_string();
    assert!(error.contains("does not load") && error.contains("half.so"), "{error}");
}

#[test]
fn problems_of_table_and_steps_are_reported_before_anything_runs() {
    let fmus = fmus_or_skip!();
    let fmu = fmus.integrator();
    let mut memory = Memory::new();
    let bad = Signals::new(&[0.0, 1.0, 1.0]).with("command[1]", &[1.0, f64::NAN]);
    let error = simulate_with_inputs(instance(&fmu, "p"), &[bad], &Drive::default(), &mut memory)
        .unwrap_err()
        .to_string();
    assert!(error.contains("time must increase"), "{error}");
    let map = vec![("command[1]".to_owned(), "volts".to_owned())];
    let good = Signals::new(&[0.0, 1.0]).with("u1", &[1.0, 1.0]);
    let drive = Drive { map, ..Drive::default() };
    let error = simulate_with_inputs(instance(&fmu, "p"), &[good], &drive, &mut memory)
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "there is no column `volts` for input `command[1]` of FMU `p`; there are: u1"
    );
    assert!(memory.time().is_empty());
}

#[test]
fn an_fmu_that_wants_equal_steps_gets_them_or_an_error() {
    let fmus = fmus_or_skip!();
    let mut description = common::integrator();
    let co_simulation = description.co_simulation.as_mut().unwrap();
    co_simulation.can_handle_variable_communication_step_size = false;
    let fmu = Fmu::open(fmus.pack("integrator", &description)).unwrap();
    let mut memory = Memory::new();
    let unequal = Signals::new(&[0.0, 1.0, 3.0]).with("command[1]", &[1.0; 3]);
    let error =
        simulate_with_inputs(instance(&fmu, "p"), &[unequal], &Drive::default(), &mut memory)
            .unwrap_err();
    assert!(matches!(&error, Error::Problems(p) if matches!(p.0[0], Problem::UnequalSteps { .. })));
    let equal = Signals::new(&[0.0, 1.0, 2.0]).with("command[1]", &[1.0; 3]);
    simulate_with_inputs(instance(&fmu, "p"), &[equal], &Drive::default(), &mut memory).unwrap();
    assert_eq!(memory.values("position[1]").unwrap(), [0.0, 1.0, 2.0]);
    assert!(Points::uniform(0.0, 0.25, 0.1).unwrap().equal_steps().is_err());
}
