//! Instances: many at once, saved and restored states, start values, threads.
#![allow(clippy::print_stdout)]

use crate::common;
use common::instance;
use cosim::{Experiment, Fmu, Selection, Slave, Value};

/// The integrator's command and position.
fn ports(slave: &dyn Slave) -> (Selection, Selection) {
    let select = |name: &str| {
        let mut selection = Selection::default();
        selection.add("p", slave.description().variable(name).unwrap()).unwrap();
        selection
    };
    (select("command[1]"), select("position[1]"))
}

fn started(fmu: &Fmu, name: &str) -> Box<dyn Slave> {
    let mut slave = instance(fmu, name);
    slave.setup(&Experiment::default()).unwrap();
    slave.enter_initialization().unwrap();
    slave.exit_initialization().unwrap();
    slave
}

fn step_with(slave: &mut dyn Slave, time: f64, u: f64) -> f64 {
    let (command, position) = ports(slave);
    let mut y = [0.0];
    slave.set(&command, &[u]).unwrap();
    slave.step(time, 1.0).unwrap();
    slave.get(&position, &mut y).unwrap();
    y[0]
}

#[test]
fn instances_do_not_disturb_each_other_and_outlive_the_fmu() {
    let fmus = fmus_or_skip!();
    let fmu = fmus.integrator();
    let mut slaves: Vec<Box<dyn Slave>> =
        (0..20).map(|i| started(&fmu, &format!("p{i}"))).collect();
    drop(fmu);
    for step in 0..5 {
        for (i, slave) in slaves.iter_mut().enumerate() {
            let y = step_with(&mut **slave, f64::from(step), i as f64);
            assert_eq!(y, (step + 1) as f64 * i as f64);
        }
    }
    let threads: Vec<_> = slaves
        .into_iter()
        .map(|mut slave| std::thread::spawn(move || step_with(&mut *slave, 5.0, 1.0)))
        .collect();
    for (i, thread) in threads.into_iter().enumerate() {
        assert_eq!(thread.join().unwrap(), 5.0 * i as f64 + 1.0);
    }
}

#[test]
fn a_saved_state_is_the_complete_state() {
    let fmus = fmus_or_skip!();
    let mut slave = started(&fmus.integrator(), "p");
    step_with(&mut *slave, 0.0, 3.0);
    let state = slave.save(None).unwrap();
    assert_eq!(step_with(&mut *slave, 1.0, 4.0), 7.0);
    slave.restore(state).unwrap();
    assert_eq!(slave.value("position[1]").unwrap(), Value::Real(3.0));
    assert_eq!(step_with(&mut *slave, 1.0, 4.0), 7.0);
    assert_eq!(slave.save(Some(state)).unwrap(), state);
    assert_eq!(step_with(&mut *slave, 2.0, 1.0), 8.0);
    slave.restore(state).unwrap();
    assert_eq!(step_with(&mut *slave, 2.0, 1.0), 8.0);
    slave.forget(state).unwrap();
    let error = slave.restore(state).unwrap_err().to_string();
    assert!(error.contains("was freed before"), "{error}");
}

#[test]
fn a_serialised_state_goes_to_another_instance() {
    let fmus = fmus_or_skip!();
    let fmu = fmus.integrator();
    let (mut a, mut b) = (instance(&fmu, "a"), instance(&fmu, "b"));
    a.set_start("position[1]", &Value::Real(42.0)).unwrap();
    let saved = a.save(None).unwrap();
    let bytes = a.serialize(saved).unwrap();
    // A state of one instance is not one of the other.
    assert!(b.restore(saved).is_err());
    let loaded = b.deserialize(&bytes).unwrap();
    b.restore(loaded).unwrap();
    assert_eq!(b.value("position[1]").unwrap(), Value::Real(42.0));
    let error = b.deserialize(&bytes[1..]).unwrap_err().to_string();
    assert!(error.contains("these bytes are no state of mine"), "{error}");
}

#[test]
fn an_fmu_that_cannot_save_says_so() {
    let fmus = fmus_or_skip!();
    let fmu = Fmu::open(fmus.pack("bare", &common::bare())).unwrap();
    let error = instance(&fmu, "bare").save(None).unwrap_err().to_string();
    assert_eq!(
        error,
        "FMU `bare` cannot save or restore its state: its model description does not state \
         canGetAndSetFMUstate"
    );
}

#[test]
fn values_of_every_type_by_name() {
    let fmus = fmus_or_skip!();
    let mut slave = instance(&fmus.integrator(), "p");
    for (name, value) in [
        ("k", Value::Real(2.5)),
        ("misbehaviour", Value::Integer(-7)),
        ("enabled", Value::Boolean(false)),
        ("label", Value::from("Tür 50 %")),
    ] {
        slave.set_start(name, &value).unwrap();
        assert_eq!(slave.value(name).unwrap(), value);
    }
    let error = slave.set_start("enabled", &Value::Real(0.5)).unwrap_err().to_string();
    assert!(error.contains("`enabled` is of type Boolean and cannot take 0.5"), "{error}");
    let error = slave.set_start("misbehaviour", &Value::Integer(1 << 40)).unwrap_err();
    assert!(error.to_string().contains("cannot take 1099511627776"), "{error}");
    let error = slave.set_start("label", &Value::from("a\0b")).unwrap_err().to_string();
    assert!(error.contains("zero byte"), "{error}");
    let error = slave.value("lable").unwrap_err().to_string();
    assert!(error.ends_with("did you mean `label`?"), "{error}");
}

#[test]
fn reset_is_the_state_after_instantiation() {
    let fmus = fmus_or_skip!();
    let fmu = fmus.integrator();
    let mut slave = started(&fmu, "p");
    assert_eq!(step_with(&mut *slave, 0.0, 9.0), 9.0);
    slave.reset().unwrap();
    assert_eq!(slave.value("position[1]").unwrap(), Value::Real(0.0));
    slave.setup(&Experiment { start: -1.0, ..Experiment::default() }).unwrap();
    slave.enter_initialization().unwrap();
    slave.exit_initialization().unwrap();
    assert_eq!(step_with(&mut *slave, -1.0, 2.0), 2.0);
}
