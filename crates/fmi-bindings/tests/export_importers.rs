//! What importers really pass: the recorded oddities of nine of them, and what must be refused.

use std::ffi::CString;

use crate::support::{Arguments, Fmu, controller, other_plant, plant, resources};
use fmi_bindings::export::v2;
use fmi_bindings::fmi2::*;

fn plant_at(location: &str) -> Fmu {
    Fmu::with(plant, Arguments::of(plant).location(location))
}

#[test]
fn every_spelling_of_the_resource_location_is_understood() {
    let folder = tempfile::Builder::new().prefix("mit é 100% ").tempdir().unwrap();
    std::fs::write(folder.path().join("blueprint.toml"), "").unwrap();
    let path = folder.path().to_str().unwrap();
    let encoded = path.replace('%', "%25").replace(' ', "%20").replace('é', "%C3%A9");
    for location in [
        format!("file://{encoded}"),
        format!("file://{encoded}/"),
        format!("file:{encoded}"),
        format!("file:///{encoded}"),
        format!("file://localhost{encoded}"),
        format!("file://{path}"),
        path.to_string(),
    ] {
        let fmu = plant_at(&location);
        assert!(!fmu.c.is_null(), "{location}: {:?}", fmu.messages());
    }
}

#[test]
fn a_location_without_resources_is_refused_with_all_places_that_were_tried() {
    for (location, part) in [
        ("file:///nowhere/resources", "looked in: /nowhere/resources, "),
        ("http://nowhere/resources", "\"http://nowhere/resources\" is no file URI"),
        ("file://server/resources", "\"server\" is another machine"),
        ("", "looked in: "),
    ] {
        let fmu = plant_at(location);
        assert!(fmu.c.is_null());
        let messages = fmu.messages();
        assert_eq!((messages.len(), messages[0].status), (1, fmi2Error));
        let text = &messages[0].format;
        assert!(text.starts_with("fmi2Instantiate: no blueprint.toml"), "{text}");
        assert!(text.contains(part) && text.contains("give the folder `resources`"), "{text}");
    }
}

/// Set in the process that runs from inside an unpacked FMU.
const INSIDE: &str = "PIEZOLOOP_TEST_INSIDE_FMU";

#[test]
fn without_a_location_the_resources_are_found_from_the_library() {
    if std::env::var_os(INSIDE).is_some() {
        for location in [None, Some(c"".into()), Some(c"file:///nowhere".into())] {
            let fmu = Fmu::with(plant, Arguments { location, ..Arguments::of(plant) });
            assert!(!fmu.c.is_null(), "{:?}", fmu.messages());
        }
        return;
    }
    // The library is this test program, put where the FMU has its library.
    let folder = tempfile::tempdir().unwrap();
    let (binaries, resources) =
        (folder.path().join("binaries/linux64"), folder.path().join("resources"));
    std::fs::create_dir_all(&binaries).unwrap();
    std::fs::create_dir_all(&resources).unwrap();
    std::fs::write(resources.join("blueprint.toml"), "").unwrap();
    let program = binaries.join("program");
    std::fs::copy(std::env::current_exe().unwrap(), &program).unwrap();
    let done = std::process::Command::new(&program)
        .args([
            "--exact",
            "export_importers::without_a_location_the_resources_are_found_from_the_library",
        ])
        .env(INSIDE, "1")
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stdout));
}

#[test]
fn the_guid_must_be_that_of_the_model() {
    let other = other_plant(resources()).unwrap().variables().fingerprint();
    for guid in [None, Some(c"".into()), CString::new(other).ok(), Some(c"{00}".into())] {
        let fmu = Fmu::with(plant, Arguments { guid, ..Arguments::of(plant) });
        assert!(fmu.c.is_null());
        assert!(fmu.last().contains("GUID") && fmu.last().contains("blueprint.toml"));
    }
}

#[test]
fn model_exchange_and_unnamed_instances_are_refused() {
    for kind in [fmi2ModelExchange, fmi2Type(7)] {
        let fmu = Fmu::with(plant, Arguments { kind, ..Arguments::of(plant) });
        assert!(fmu.c.is_null());
        assert!(fmu.last().contains("co-simulation only"), "{}", fmu.last());
    }
    for name in [None, Some(c"".into()), Some(c"  ".into())] {
        let fmu = Fmu::with(plant, Arguments { name, ..Arguments::of(plant) });
        assert!(fmu.c.is_null());
        assert!(fmu.last().contains("instance name"), "{}", fmu.last());
    }
}

#[test]
fn the_factorys_problems_are_the_users() {
    let fmu = Fmu::with(|_| Err("blueprint.toml, line 3: 5 % #1".into()), Arguments::of(plant));
    assert!(fmu.c.is_null());
    assert_eq!(fmu.last(), "fmi2Instantiate: blueprint.toml, line 3: 5 %% ##1");
}

#[test]
fn a_panic_while_instantiating_is_a_refusal() {
    let fmu = Fmu::with(|_| panic!("on purpose"), Arguments::of(plant));
    assert!(fmu.c.is_null());
    assert!(fmu.last().contains("internal defect"), "{}", fmu.last());
}

#[test]
fn missing_callbacks_are_fine() {
    let none = fmi2CallbackFunctions { logger: None, ..crate::support::callbacks() };
    for callbacks in [None, Some(none)] {
        let fmu = Fmu::with(plant, Arguments { callbacks, ..Arguments::of(plant) });
        assert!(!fmu.c.is_null());
        fmu.start(0.0);
        assert_eq!(fmu.step(0.0, 1e-3), fmi2OK);
        assert_eq!(fmu.step(5.0, 1e-3), fmi2Error, "nobody listens, nothing crashes");
        let refused = Arguments { callbacks, guid: None, ..Arguments::of(plant) };
        assert!(Fmu::with(plant, refused).c.is_null());
    }
}

#[test]
fn the_instance_keeps_its_own_copies() {
    let mut arguments = Arguments::of(plant);
    arguments.name = Some(c"first".into());
    let fmu = Fmu::with(plant, arguments);
    // The texts and the structure of the arguments are gone by now.
    fmu.step(0.0, 1.0);
    let messages = &fmu.messages()[0];
    assert_eq!(messages.name, "first");
    assert_eq!(messages.environment, (&raw const *fmu.recorder) as usize);
}

#[test]
fn inputs_and_start_values_may_be_set_before_the_experiment_and_before_initialization() {
    let fmu = Fmu::new(plant);
    assert_eq!(fmu.set_real("command[1]", 2.0), fmi2OK);
    assert_eq!(fmu.set_real("axis[1].lag.time", 0.02), fmi2OK);
    assert_eq!(fmu.set_up(0.0, None), fmi2OK);
    assert_eq!(fmu.set_real("command[2]", 1.0), fmi2OK);
    assert_eq!(fmu.enter(), fmi2OK);
    assert_eq!(fmu.set_real("axis[2].lag.ceiling", 50.0), fmi2OK, "as ecos does");
    assert_eq!(fmu.exit(), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 4.0);
    assert_eq!(fmu.real("position[2]"), 5.0);
}

#[test]
fn everything_may_be_read_in_the_initialization_mode() {
    let fmu = Fmu::new(controller);
    fmu.set_up(0.0, None);
    fmu.enter();
    for (reference, variable) in (0..).zip(fmu.system.variables().as_slice()) {
        let (mut real, mut integer, mut boolean) = (0.0, 0, 0);
        let status = match variable.data_type {
            model::DataType::Integer => unsafe {
                v2::fmi2GetInteger(fmu.c, &reference, 1, &mut integer)
            },
            model::DataType::Boolean => unsafe {
                v2::fmi2GetBoolean(fmu.c, &reference, 1, &mut boolean)
            },
            _ => unsafe { v2::fmi2GetReal(fmu.c, &reference, 1, &mut real) },
        };
        assert_eq!(status, fmi2OK, "{}", variable.name);
    }
}

#[test]
fn values_are_read_after_the_end_and_twice_at_each_point() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 1.0);
    fmu.step(0.0, 0.01);
    let value = fmu.real("position[1]");
    assert_eq!(fmu.real("position[1]"), value);
    assert_eq!(fmu.terminate(), fmi2OK);
    assert_eq!(fmu.real("position[1]"), value);
    assert_eq!(fmu.real("axis[1].lag.gain"), 2.0);
}

#[test]
fn many_instances_live_in_many_threads() {
    let one = |command: f64| {
        let fmu = Fmu::ready(plant);
        fmu.set_real("command[1]", command);
        for k in 0..200 {
            assert_eq!(fmu.step(f64::from(k) * 1e-3, 1e-3), fmi2OK);
        }
        fmu.real("position[1]")
    };
    let alone: Vec<f64> = (0..8).map(|k| one(f64::from(k))).collect();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8)
            .map(|k| scope.spawn(move || (0..20).map(|_| one(f64::from(k))).collect::<Vec<_>>()))
            .collect();
        for (thread, value) in threads.into_iter().zip(&alone) {
            assert!(thread.join().unwrap().iter().all(|v| v == value));
        }
    });
}
