//! FMUs in processes of their own: the same values, and an error where one crashes or hangs.
#![cfg(unix)]
#![allow(clippy::print_stdout)]

mod common;

use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use common::{Fmus, instance};
use cosim::{
    Drive, Error, Fmu, GaussSeidel, InstanceOptions, Iteration, IterationSettings, Memory, Message,
    Points, RecordFile, Run, Signals, Slave, StateId, Status, Value, Worker, isolate,
    simulate_with_inputs,
};

/// Started by [`worker`] as another process; as a test it has nothing to do.
#[test]
fn serve() {
    if std::env::args().any(|argument| argument == "--include-ignored") {
        isolate::serve().expect("the master listens");
    }
}

/// This test program is its own worker.
fn worker(timeout: Duration) -> Worker {
    let arguments = ["serve", "--exact", "--nocapture", "--quiet", "--include-ignored"];
    let program = std::env::current_exe().expect("this program");
    Worker { program, arguments: arguments.map(Into::into).to_vec(), timeout, memory: None }
}

fn isolated(path: PathBuf, name: &str, timeout: f64) -> Box<dyn Slave> {
    let fmu = Fmu::open_isolated(path, &worker(Duration::from_secs_f64(timeout))).unwrap();
    instance(&fmu, name)
}

fn drive(slave: Box<dyn Slave>, misbehaviour: &[f64]) -> (Result<(), Error>, Memory) {
    let time: Vec<f64> = (0..misbehaviour.len()).map(|k| k as f64 * 0.5).collect();
    let u: Vec<f64> = time.iter().map(|t| t.cos()).collect();
    let signals = Signals::new(&time).with("command[1]", &u).with("misbehaviour", misbehaviour);
    let mut memory = Memory::new();
    let parameters = vec![("k".to_owned(), Value::Real(3.0))];
    let drive = Drive { parameters, ..Drive::default() };
    let outcome = simulate_with_inputs(slave, &[signals], &drive, &mut memory);
    (outcome.map(|_| ()), memory)
}

#[test]
fn the_values_are_those_of_the_same_process() {
    let fmus = fmus_or_skip!();
    let path = fmus.pack("integrator", &common::integrator());
    let calm = vec![0.0; 50];
    let (outcome, here) = drive(instance(&Fmu::open(&path).unwrap(), "p"), &calm);
    outcome.unwrap();
    let (outcome, there) = drive(isolated(path, "p", 20.0), &calm);
    outcome.unwrap();
    assert_eq!(here, there);
}

#[test]
fn a_crash_is_an_error_that_names_the_fmu_and_keeps_the_record() {
    let fmus = fmus_or_skip!();
    let path = fmus.pack("integrator", &common::integrator());
    let (outcome, memory) = drive(isolated(path, "stage", 20.0), &[0.0, 0.0, 0.0, 8.0, 0.0]);
    let error = outcome.unwrap_err().to_string();
    assert!(
        error.starts_with(
            "at t = 1.5 s: FMU `stage`: fmi2DoStep has not returned, because the FMU crashed: its \
             process ended with signal: 6 (SIGABRT)"
        ),
        "{error}"
    );
    assert_eq!(memory.time(), [0.0, 0.5, 1.0, 1.5]);
    assert!(memory.values("position[1]").unwrap()[3] > 1.0);
}

#[test]
fn a_hanging_fmu_is_ended_after_the_timeout() {
    let fmus = fmus_or_skip!();
    let path = fmus.pack("integrator", &common::integrator());
    let begin = Instant::now();
    let (outcome, memory) = drive(isolated(path, "stage", 2.0), &[0.0, 9.0, 0.0]);
    let error = outcome.unwrap_err().to_string();
    let words = "at t = 0.5 s: FMU `stage`: fmi2DoStep has not returned within 2 s; its process \
                 was ended";
    assert!(error.starts_with(words), "{error}");
    assert!(begin.elapsed() < Duration::from_secs(30));
    assert_eq!(memory.time(), [0.0, 0.5]);
}

#[test]
fn the_record_on_disk_is_kept_after_a_crash() {
    let fmus = fmus_or_skip!();
    let path = fmus.pack("integrator", &common::integrator());
    let csv = fmus.path("run.csv");
    let mut file = RecordFile::create(&csv).unwrap();
    let signals = Signals::new(&[0.0, 1.0, 2.0]).with("misbehaviour", &[0.0, 0.0, 8.0]);
    let mut diagram = cosim::Diagram::new();
    diagram.add(isolated(path, "p", 20.0)).feed("misbehaviour", None, ("p", "misbehaviour"));
    diagram.start(("p", "command[1]"), 1.0).record(("p", "position[1]"));
    let mut system = diagram.build().unwrap();
    let points = Points::uniform(0.0, 5.0, 1.0).unwrap();
    let run = Run::new(points, &signals);
    let order = GaussSeidel::by_dependency(&system);
    assert!(system.run(&run, &order, &mut file).is_err());
    file.finish().unwrap();
    let text = std::fs::read_to_string(csv).unwrap();
    assert_eq!(text, "time,position[1]\n0,0\n1,1\n2,2\n");
}

#[test]
fn errors_messages_and_states_come_from_the_other_process() {
    let fmus = fmus_or_skip!();
    let path = fmus.pack("integrator", &common::integrator());
    let fmu = Fmu::open_isolated(path, &worker(Duration::from_secs(20))).unwrap();
    let heard: Arc<Mutex<Vec<Message>>> = Arc::default();
    let ear = Arc::clone(&heard);
    let options = InstanceOptions {
        on_message: Some(Arc::new(move |message| ear.lock().unwrap().push(message.clone()))),
        ..InstanceOptions::default()
    };
    let mut slave = fmu.instantiate("p", &options).unwrap();
    slave.setup(&cosim::Experiment::default()).unwrap();
    slave.set_start("limit", &Value::Real(2.0)).unwrap();
    slave.set_start("label", &Value::from("ü")).unwrap();
    slave.enter_initialization().unwrap();
    slave.set_start("command[1]", &Value::Real(1.0)).unwrap();
    slave.exit_initialization().unwrap();
    assert_eq!(slave.value("label").unwrap(), Value::from("ü"));
    let state = slave.save(None).unwrap();
    slave.step(0.0, 1.0).unwrap();
    assert_eq!(slave.value("position[1]").unwrap(), Value::Real(1.0));
    let bytes = slave.serialize(state).unwrap();
    let again = slave.deserialize(&bytes).unwrap();
    slave.restore(again).unwrap();
    assert_eq!(slave.value("position[1]").unwrap(), Value::Real(0.0));
    slave.forget(again).unwrap();
    assert!(slave.restore(again).unwrap_err().to_string().contains("was freed before"));
    assert!(slave.restore(StateId(99)).is_err());
    let error = slave.step(0.0, 5.0).unwrap_err().to_string();
    assert!(error.contains("FMU `p`: fmi2DoStep returned Error") && error.contains("y = 5"));
    let heard = heard.lock().unwrap();
    assert!(heard.iter().any(|m| m.status == Status::Error && m.text.contains("y = 5")));
}

/// Both in processes of their own, in a loop that is rolled back.
#[test]
fn a_loop_is_iterated_across_processes() {
    let fmus = fmus_or_skip!();
    let controller = fmus.pack("controller", &common::controller());
    let plant = fmus.pack("integrator", &common::integrator());
    let mut diagram = cosim::Diagram::new();
    diagram
        .add(isolated(controller, "c", 20.0))
        .add(isolated(plant, "p", 20.0))
        .connect(("c", "command[1]"), ("p", "command[1]"))
        .connect(("p", "position[1]"), ("c", "measured[1]"))
        .start(("c", "reference[1]"), 1.0)
        .record(("p", "position[1]"));
    let mut system = diagram.build().unwrap();
    let iteration = Iteration::new(&system, IterationSettings::default()).unwrap();
    let signals = Signals::new(&[0.0]);
    let points = Points::uniform(0.0, 3.0, 1.0).unwrap();
    let run = Run::new(points, &signals);
    let mut memory = Memory::new();
    system.run(&run, &iteration, &mut memory).unwrap();
    let found = memory.values("position[1]").unwrap();
    for (y, expected) in found.iter().zip([0.0, 0.5, 0.75, 0.875]) {
        assert!((y - expected).abs() < 1e-8, "{found:?}");
    }
}

#[test]
fn a_program_that_is_no_worker_is_reported() {
    let fmus = fmus_or_skip!();
    let path = fmus.pack("integrator", &common::integrator());
    // The FMU has no part in a process that does not start.
    for (program, words) in [
        ("/bin/true", "FMU `p`: "),
        ("/bin/true", "fmi2Instantiate has not returned"),
        ("/no/such", "no process can be started for the FMU `p` (/no/such): "),
    ] {
        let timeout = Duration::from_secs(20);
        let worker =
            Worker { program: program.into(), arguments: Vec::new(), timeout, memory: None };
        let fmu = Fmu::open_isolated(&path, &worker).unwrap();
        let error = fmu.instantiate("p", &InstanceOptions::default()).err().unwrap().to_string();
        assert!(error.contains(words), "{error}");
    }
    let _ = Fmus::new();
}
