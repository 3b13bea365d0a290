//! FMUs that are WebAssembly components, and hostile ones: each ends by its limits, with a message that names the limit.
//!
//! The FMUs in `fmus/components` are made from `crates/fmi-bindings/wit` by wit-component 0.236 (`dummy_module`: every
//! function traps), with another body for `cabi_realloc`, which takes the arguments of every call, in two of them.
#![cfg(feature = "wasm")]
#![allow(clippy::print_stdout)]

use std::path::Path;
use std::time::{Duration, Instant};

use cosim::{Experiment, Fmu, InstanceOptions, Selection, Slave};

fn opened(name: &str) -> Result<Box<dyn Slave>, String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fmus/components").join(name);
    let fmu = Fmu::open(file).map_err(|error| error.to_string())?;
    fmu.instantiate("hostile", &InstanceOptions::default()).map_err(|error| error.to_string())
}

#[test]
fn hostile_components_end_by_their_limits() {
    for (name, words) in [
        ("trap.fmu", "trapped: wasm `unreachable` instruction executed"),
        ("endless.fmu", "did not end within 5000000000 instructions"),
        ("memory.fmu", "asked for more than 256 MiB of memory"),
        ("empty.fmu", "co-simulation"),
        ("files.fmu", "wants more than the callbacks of FMI-LS-WASM"),
    ] {
        let begin = Instant::now();
        let message = opened(name).err().expect("it is hostile");
        println!("{name}, {:?}: {message}", begin.elapsed());
        assert!(message.contains(words), "{name}: {message}");
        assert!(message.starts_with("FMU `"), "{message}");
        assert!(begin.elapsed() < Duration::from_secs(120), "{name}");
    }
}

/// `PIEZOLOOP_COMPONENTS` names a folder with `library.fmu` and `component.fmu`, packed from the same plant.
#[test]
fn a_component_computes_what_the_library_does() {
    let Some(folder) = std::env::var_os("PIEZOLOOP_COMPONENTS") else {
        println!("SKIPPED: PIEZOLOOP_COMPONENTS names no folder");
        return;
    };
    let rows = ["library.fmu", "component.fmu"].map(|name| {
        let fmu = Fmu::open(Path::new(&folder).join(name)).unwrap();
        let mut slave = fmu.instantiate("one", &InstanceOptions::default()).unwrap();
        let [inputs, outputs] = [&["command[1]"], &["position[1]"]]
            .map(|names| Selection::of(slave.description(), names).unwrap());
        slave.setup(&Experiment { start: 0.0, stop: None, tolerance: None }).unwrap();
        slave.enter_initialization().unwrap();
        slave.exit_initialization().unwrap();
        let mut all = Vec::new();
        let mut saved = None;
        for k in 0..2000 {
            let mut y = [0.0];
            slave.set(&inputs, &[5.0 + 3.0 * (0.01 * f64::from(k)).sin()]).unwrap();
            slave.step(f64::from(k) * 1e-3, 1e-3).unwrap();
            slave.get(&outputs, &mut y).unwrap();
            all.push(y[0].to_bits());
            if k == 1000 {
                saved = Some(slave.save(None).unwrap());
            }
        }
        // Behind a saved state the same once more.
        slave.restore(saved.unwrap()).unwrap();
        let mut y = [0.0];
        slave.set(&inputs, &[5.0 + 3.0 * (0.01_f64 * 1001.0).sin()]).unwrap();
        slave.step(1001.0 * 1e-3, 1e-3).unwrap();
        slave.get(&outputs, &mut y).unwrap();
        assert_eq!(y[0].to_bits(), all[1001]);
        all
    });
    assert_eq!(rows[0], rows[1]);
    assert!(rows[0].iter().collect::<std::collections::HashSet<_>>().len() > 100);
}

/// A lag that another hand wrote (`fmus/components/lag.rs`), in initialization; `mode`: how it misbehaves.
fn lag(mode: f64) -> Box<dyn Slave> {
    let mut slave = opened("lag.fmu").unwrap();
    let parameters = Selection::of(slave.description(), &["k", "T", "mode"]).unwrap();
    slave.set(&parameters, &[3.0, 0.02, mode]).unwrap();
    slave.setup(&Experiment { start: 0.0, stop: None, tolerance: None }).unwrap();
    slave.enter_initialization().unwrap();
    slave.exit_initialization().unwrap();
    slave
}

#[test]
fn a_component_by_another_hand_computes_what_it_says() {
    let mut slave = lag(0.0);
    let [input, output] =
        [["u"], ["y"]].map(|names| Selection::of(slave.description(), &names).unwrap());
    let share = 1.0 - (1.0 - 1e-3_f64 / 0.02 / 64.0).powi(64);
    let (mut wanted, mut saved) = (0.0, None);
    for k in 0..500 {
        let u = (0.05 * f64::from(k)).sin();
        wanted += share * (3.0 * u - wanted);
        slave.set(&input, &[u]).unwrap();
        slave.step(f64::from(k) * 1e-3, 1e-3).unwrap();
        let mut y = [0.0];
        slave.get(&output, &mut y).unwrap();
        assert!((y[0] - wanted).abs() < 1e-12, "step {k}: {} is not {wanted}", y[0]);
        if k == 250 {
            saved = Some((slave.save(None).unwrap(), y[0]));
        }
    }
    let ((state, y), mut again) = (saved.unwrap(), [0.0]);
    slave.restore(state).unwrap();
    slave.get(&output, &mut again).unwrap();
    assert_eq!(again[0].to_bits(), y.to_bits());
}

#[test]
fn a_component_that_misbehaves_in_a_step_ends_by_its_limits() {
    for (mode, words) in [
        (1.0, "did not end within 5000000000 instructions"),
        (2.0, "asked for more than 256 MiB of memory"),
        (3.0, "trapped: wasm `unreachable` instruction executed"),
        (
            4.0,
            "do-step: returned the status error: hostile: logStatusError: the lag refuses this step",
        ),
    ] {
        let mut slave = lag(mode);
        slave.step(0.0, 1e-3).unwrap();
        let begin = Instant::now();
        let message = slave.step(1e-3, 1e-3).expect_err("it misbehaves").to_string();
        println!("mode {mode}, {:?}: {message}", begin.elapsed());
        assert!(message.contains(words) && message.starts_with("FMU `"), "{message}");
        // It is not called any more, but a new one works.
        assert!(slave.step(2e-3, 1e-3).is_err());
        lag(0.0).step(0.0, 1e-3).unwrap();
    }
}
