//! Saved states: bit-exact, reused, freed, serialised, loaded in another process, garbage refused.

use std::ptr::null_mut;

use crate::support::components::PERIOD;
use crate::support::{Fmu, Random, other_plant, plant};
use fmi_bindings::export::v2;
use fmi_bindings::fmi2::*;

/// Steps with a repeatable, rough input, and returns the bits of all outputs.
fn run(fmu: &Fmu, from: usize, steps: usize) -> Vec<u64> {
    let mut random = Random(1 + from as u64);
    let mut bits = Vec::new();
    for k in from..from + steps {
        for name in ["command[1]", "command[2]"] {
            assert_eq!(fmu.set_real(name, 50.0 * random.unit()), fmi2OK);
        }
        assert_eq!(fmu.step(k as f64 * 0.7 * PERIOD, 0.7 * PERIOD), fmi2OK, "{}", fmu.last());
        bits.push(fmu.real("position[1]").to_bits());
        bits.push(fmu.real("position[2]").to_bits());
    }
    bits
}

#[test]
fn run_save_run_restore_run_gives_the_same_bits() {
    let fmu = Fmu::ready(plant);
    run(&fmu, 0, 100);
    fmu.set_real("axis[1].lag.gain", 3.0);
    fmu.set_slope("command[1]", 1, 12.0);
    let state = fmu.save();
    let first = run(&fmu, 100, 100);
    fmu.set_real("axis[1].lag.gain", 1.0);
    run(&fmu, 200, 50);
    for _ in 0..2 {
        assert_eq!(fmu.restore(state), fmi2OK, "it stays saved");
        assert_eq!(fmu.real("axis[1].lag.gain"), 3.0);
        assert_eq!(run(&fmu, 100, 100), first);
    }
}

/// As importers do that write a state at the end of a run and begin the next run with it.
#[test]
fn a_run_that_goes_on_from_a_state_has_its_own_stop_time() {
    let fmu = Fmu::new(plant);
    fmu.set_up(0.0, Some(1.0));
    fmu.enter();
    fmu.exit();
    assert_eq!(fmu.step(0.0, 1.0), fmi2OK);
    let state = fmu.save();
    let bytes = fmu.bytes(state);
    let read = |fmu: &Fmu| {
        let mut state = null_mut();
        assert_eq!(fmu.deserialize(&bytes, &mut state), fmi2OK);
        assert_eq!(fmu.restore(state), fmi2OK);
    };
    let next = Fmu::new(plant);
    read(&next);
    assert_eq!(next.step(1.0, 0.5), fmi2OK, "no stop time was given: {}", next.last());
    let other = Fmu::new(plant);
    other.set_up(0.0, Some(1.25));
    read(&other);
    assert_eq!(other.step(1.0, 0.25), fmi2OK, "{}", other.last());
    assert_eq!(other.step(1.25, 0.25), fmi2Error);
    assert!(other.last().contains("stop time 1.25 s"), "{}", other.last());
    assert_eq!(fmu.restore(state), fmi2OK);
    assert_eq!(fmu.step(1.0, 0.5), fmi2Error, "this run still ends at 1 s");
}

#[test]
fn a_state_brings_back_phase_and_time() {
    let fmu = Fmu::new(plant);
    let instantiated = fmu.save();
    fmu.set_up(2.0, Some(3.0));
    fmu.enter();
    fmu.set_real("command[1]", 5.0);
    let initializing = fmu.save();
    fmu.exit();
    assert_eq!(fmu.step(2.0, 0.5), fmi2OK);
    let stepping = fmu.save();
    assert_eq!(fmu.terminate(), fmi2OK);

    assert_eq!(fmu.restore(stepping), fmi2OK);
    assert_eq!(fmu.step(2.5, 0.5), fmi2OK);
    assert_eq!(fmu.restore(initializing), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 10.0, "outputs follow the inputs again");
    assert_eq!(fmu.exit(), fmi2OK);
    assert_eq!(fmu.step(2.0, 0.5), fmi2OK);
    assert_eq!(fmu.restore(instantiated), fmi2OK);
    assert_eq!(fmu.set_up(0.0, None), fmi2OK);
    assert_eq!(fmu.enter(), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 0.0);
}

#[test]
fn reset_is_the_state_right_after_instantiation() {
    let fresh = Fmu::new(plant);
    let fmu = Fmu::new(plant);
    fmu.set_real("axis[1].lag.gain", 9.0);
    fmu.set_real("command[1]", 4.0);
    fmu.set_slope("command[1]", 1, 3.0);
    fmu.start(7.0);
    fmu.step(7.0, 1.0);
    assert_eq!(fmu.reset(), fmi2OK);
    assert_eq!(fmu.bytes(fmu.save()), fresh.bytes(fresh.save()));
}

#[test]
fn a_state_that_is_there_is_used_again_and_null_is_ignored_when_freed() {
    let fmu = Fmu::ready(plant);
    let mut state = fmu.save();
    let place = state;
    fmu.set_real("command[1]", 8.0);
    assert_eq!(unsafe { v2::fmi2GetFMUstate(fmu.c, &mut state) }, fmi2OK);
    assert_eq!(state, place);
    fmu.set_real("command[1]", 0.0);
    fmu.restore(state);
    assert_eq!(fmu.real("command[1]"), 8.0);
    unsafe {
        assert_eq!(v2::fmi2FreeFMUstate(fmu.c, &mut state), fmi2OK);
        assert!(state.is_null());
        assert_eq!(v2::fmi2FreeFMUstate(fmu.c, &mut state), fmi2OK);
        assert_eq!(v2::fmi2FreeFMUstate(fmu.c, null_mut()), fmi2OK);
    }
}

#[test]
fn states_are_freed_in_any_order_and_the_rest_with_the_instance() {
    let fmu = Fmu::ready(plant);
    let mut states: Vec<_> = (0..8).map(|_| fmu.save()).collect();
    for at in [3, 0, 7, 5, 1] {
        assert_eq!(unsafe { v2::fmi2FreeFMUstate(fmu.c, &mut states[at]) }, fmi2OK);
    }
    for at in [2, 4, 6] {
        assert_eq!(fmu.restore(states[at]), fmi2OK);
    }
}

#[test]
fn a_state_serves_every_instance_of_its_model_but_is_freed_by_its_own() {
    let (a, b) = (Fmu::ready(plant), Fmu::ready(plant));
    run(&a, 0, 20);
    let mut state = a.save();
    assert_eq!(b.restore(state), fmi2OK);
    assert_eq!(run(&b, 20, 20), run(&a, 20, 20));
    assert_eq!(unsafe { v2::fmi2FreeFMUstate(b.c, &mut state) }, fmi2Error);
    assert!(b.last().contains("another instance"), "{}", b.last());
    assert!(!state.is_null());
    let other = Fmu::ready(other_plant);
    assert_eq!(other.restore(state), fmi2Error);
    assert!(other.last().contains("another model"), "{}", other.last());
}

#[test]
fn bytes_give_the_state_back() {
    let (a, b) = (Fmu::ready(plant), Fmu::new(plant));
    run(&a, 0, 30);
    let bytes = a.bytes(a.save());
    let mut state = null_mut();
    assert_eq!(b.deserialize(&bytes, &mut state), fmi2OK);
    let place = state;
    assert_eq!(b.deserialize(&bytes, &mut state), fmi2OK);
    assert_eq!(state, place, "used again");
    assert_eq!(b.bytes(state), bytes);
    assert_eq!(b.restore(state), fmi2OK);
    assert_eq!(run(&b, 30, 30), run(&a, 30, 30));
}

/// Set in the process that only loads a state: a file of bytes.
const STATE_FILE: &str = "PIEZOLOOP_TEST_STATE";

#[test]
fn bytes_are_loaded_in_another_process() {
    if let Some(file) = std::env::var_os(STATE_FILE) {
        let fmu = Fmu::new(plant);
        let mut state = null_mut();
        assert_eq!(fmu.deserialize(&std::fs::read(&file).unwrap(), &mut state), fmi2OK);
        assert_eq!(fmu.restore(state), fmi2OK);
        let bits: Vec<u8> = run(&fmu, 30, 30).iter().flat_map(|b| b.to_le_bytes()).collect();
        std::fs::write(std::path::Path::new(&file).with_extension("out"), bits).unwrap();
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state.bin");
    let fmu = Fmu::ready(plant);
    run(&fmu, 0, 30);
    std::fs::write(&file, fmu.bytes(fmu.save())).unwrap();
    let done = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "export_states::bytes_are_loaded_in_another_process"])
        .env(STATE_FILE, &file)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stdout));
    let bits: Vec<u8> = run(&fmu, 30, 30).iter().flat_map(|b| b.to_le_bytes()).collect();
    assert_eq!(std::fs::read(file.with_extension("out")).unwrap(), bits);
}

#[test]
fn garbage_is_refused_with_its_reason_and_changes_nothing() {
    let fmu = Fmu::ready(plant);
    run(&fmu, 0, 10);
    let good = fmu.bytes(fmu.save());
    let other = Fmu::ready(other_plant);
    let foreign = other.bytes(other.save());
    let with = |at: usize, byte: u8| {
        let mut bytes = good.clone();
        bytes[at] ^= byte;
        bytes
    };
    let cases = [
        (vec![], "no serialised state"),
        (vec![0; 500], "no serialised state"),
        (good[..good.len() - 1].to_vec(), "cut"),
        (good[..30].to_vec(), "cut"),
        (with(8, 1), "version"),
        (with(13, 0x40), "cut"),
        (with(good.len() / 2, 1), "checksum"),
        (with(good.len() - 1, 1), "checksum"),
        (foreign, "another model"),
    ];
    for (bytes, part) in cases {
        let state = fmu.save();
        let mut place = null_mut();
        assert_eq!(fmu.deserialize(&bytes, &mut place), fmi2Error, "{part}");
        assert!(place.is_null());
        assert!(fmu.last().contains(part), "{part}: {}", fmu.last());
        assert_eq!(fmu.restore(state), fmi2OK);
    }
    let mut random = Random(99);
    for _ in 0..2000 {
        let bytes =
            with((random.unit() * good.len() as f64) as usize, 1 << (8.0 * random.unit()) as u8);
        let state = fmu.save();
        assert_eq!(fmu.deserialize(&bytes, &mut null_mut()), fmi2Error);
        fmu.restore(state);
    }
}

#[test]
fn bytes_with_a_good_checksum_and_a_bad_content_are_refused() {
    let fmu = Fmu::ready(plant);
    let good = fmu.bytes(fmu.save());
    let sealed = |mut bytes: Vec<u8>| {
        let body = bytes.len() - 8;
        let sum = model::fnv_64(bytes[..body].iter().copied());
        bytes[body..].copy_from_slice(&sum.to_le_bytes());
        bytes
    };
    let mut state = null_mut();
    assert_eq!(fmu.deserialize(&sealed(good.clone()), &mut state), fmi2OK, "the test's seal");
    // The state's number, behind magic, version, length and GUID.
    let mut phase = good.clone();
    phase[8 + 4 + 8 + 32] = 3;
    // Eight bytes less, which the length and the checksum agree to.
    let mut short = good[..good.len() - 8].to_vec();
    let length = short.len() as u64;
    short[12..20].copy_from_slice(&length.to_le_bytes());
    for bytes in [phase, short] {
        assert_eq!(fmu.deserialize(&sealed(bytes), &mut null_mut()), fmi2Error);
        assert!(fmu.last().contains("does not fit this model"), "{}", fmu.last());
        assert_eq!(fmu.reset(), fmi2OK);
    }
}

#[test]
fn too_little_room_is_refused() {
    let fmu = Fmu::ready(plant);
    let state = fmu.save();
    let mut bytes = [0_u8; 10];
    let status = unsafe { v2::fmi2SerializeFMUstate(fmu.c, state, bytes.as_mut_ptr().cast(), 10) };
    assert_eq!(status, fmi2Error);
    assert!(fmu.last().contains("room is given for 10"), "{}", fmu.last());
}
