//! Random sequences of legal and illegal calls against a reference state machine: every answer is
//! right, no call ends the program, and afterwards an instance computes as a new one.
//!
//! `PIEZOLOOP_SEQUENCES=1000000 cargo test --release -p piezoloop-fmi-bindings --test export_sequences`
//! tries so many of each version.
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each block calls the edge as an importer does, by the standard's contract"
)]
#![allow(clippy::print_stdout)]

mod support;

use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};

use fmi_bindings::export::{v2, v3};
use fmi_bindings::fmi2::*;
use fmi_bindings::fmi3::*;
use model::System;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use support::reference::{Answers, Kind, NUMBERS, OK, Op, Reference, SLOTS, STEPS};
use support::sequences::sequence;
use support::{components, plant, resources};

/// An instance behind one of the two edges.
trait Edge {
    const HAS_ARRAYS: bool;
    fn new() -> Self;
    /// The answer to a call at this time, with arrays of so many values; as bit.
    fn call(&mut self, op: &Op, time: f64, count: usize) -> Option<Answers>;
}

/// The answer of a status of either standard.
fn answer(status: u32) -> Answers {
    assert!(status <= 3, "status {status}");
    1 << status
}

/// States and bytes of an importer.
#[derive(Default)]
struct Kept {
    states: [Option<*mut c_void>; SLOTS],
    bytes: [Vec<u8>; SLOTS],
}

impl Kept {
    fn state(&self, slot: usize) -> *mut c_void {
        self.states[slot].unwrap_or(null_mut())
    }

    fn keep(&mut self, slot: usize, state: *mut c_void) {
        self.states[slot] = (!state.is_null()).then_some(state);
    }

    /// The bytes of a slot with one of them changed.
    fn damaged(&self, slot: usize, damage: Option<usize>) -> Vec<u8> {
        let mut bytes = self.bytes[slot].clone();
        if let (Some(at), false) = (damage, bytes.is_empty()) {
            let at = at % bytes.len();
            bytes[at] ^= 0x10;
        }
        bytes
    }
}

fn experiment(start: usize, stop: Option<usize>) -> (f64, bool, f64) {
    (NUMBERS[start], stop.is_some(), stop.map_or(f64::NAN, |stop| NUMBERS[stop]))
}

fn reals(items: &[(u32, usize)], each: usize) -> (Vec<u32>, Vec<f64>) {
    let values = items.iter().flat_map(|(_, number)| std::iter::repeat_n(NUMBERS[*number], each));
    (items.iter().map(|(reference, _)| *reference).collect(), values.collect())
}

/// A pointer to the values, or null.
fn pointer<T>(values: &[T], null_instead: bool) -> *const T {
    if null_instead { null() } else { values.as_ptr() }
}

struct Two {
    c: fmi2Component,
    kept: Kept,
}

impl Drop for Two {
    fn drop(&mut self) {
        unsafe { v2::fmi2FreeInstance(self.c) }
    }
}

impl Edge for Two {
    const HAS_ARRAYS: bool = false;

    fn new() -> Self {
        let location = CString::new(format!("file://{}", resources().display())).unwrap();
        let callbacks = support::callbacks();
        let c = unsafe {
            let (guid, location) = (token().as_ptr(), location.as_ptr());
            v2::fmi2Instantiate(
                plant,
                c"it".as_ptr(),
                fmi2CoSimulation,
                guid,
                location,
                &callbacks,
                0,
                0,
            )
        };
        assert!(!c.is_null());
        Self { c, kept: Kept::default() }
    }

    fn call(&mut self, op: &Op, time: f64, _: usize) -> Option<Answers> {
        let c = self.c;
        let status = unsafe {
            match op {
                Op::Debug { category } => {
                    let texts = [c"logEvents".as_ptr(), c"nonsense".as_ptr(), null()];
                    match category {
                        0 => v2::fmi2SetDebugLogging(c, 0, 0, null()),
                        n => v2::fmi2SetDebugLogging(c, 1, 1, &texts[usize::from(*n) - 1]),
                    }
                }
                Op::SetUp { start, stop } => {
                    let (start, defined, stop) = experiment(*start, *stop);
                    v2::fmi2SetupExperiment(c, 1, f64::NAN, start, defined.into(), stop)
                }
                Op::Enter { .. } => v2::fmi2EnterInitializationMode(c),
                Op::Exit => v2::fmi2ExitInitializationMode(c),
                Op::Terminate => v2::fmi2Terminate(c),
                Op::Reset => v2::fmi2Reset(c),
                Op::Get { kind, references, null, .. } => {
                    let n = references.len();
                    let vr = pointer(references, *null);
                    let (mut real, mut integer, mut text) =
                        ([0.0; 4], [0; 4], [std::ptr::null(); 4]);
                    match kind {
                        Kind::Real => v2::fmi2GetReal(c, vr, n, real.as_mut_ptr()),
                        Kind::Integer => v2::fmi2GetInteger(c, vr, n, integer.as_mut_ptr()),
                        Kind::Boolean => v2::fmi2GetBoolean(c, vr, n, integer.as_mut_ptr()),
                        Kind::String => v2::fmi2GetString(c, vr, n, text.as_mut_ptr()),
                    }
                }
                Op::Set { kind, items, null, .. } => {
                    let (vr, values) = reals(items, 1);
                    let integer: Vec<i32> = items.iter().map(|(_, n)| *n as i32).collect();
                    let flags: Vec<i32> = items.iter().map(|(_, n)| (*n % 2) as i32).collect();
                    let (n, vr) = (items.len(), vr.as_ptr());
                    match kind {
                        Kind::Real => v2::fmi2SetReal(c, vr, n, pointer(&values, *null)),
                        Kind::Integer => v2::fmi2SetInteger(c, vr, n, pointer(&integer, *null)),
                        Kind::Boolean => v2::fmi2SetBoolean(c, vr, n, pointer(&flags, *null)),
                        Kind::String => v2::fmi2SetString(c, vr, n, std::ptr::null()),
                    }
                }
                Op::Save { null: true, .. } => v2::fmi2GetFMUstate(c, null_mut()),
                Op::Save { slot, .. } => {
                    let mut state = self.kept.state(*slot);
                    let status = v2::fmi2GetFMUstate(c, &mut state);
                    self.kept.keep(*slot, state);
                    status
                }
                Op::Restore { slot } => v2::fmi2SetFMUstate(c, self.kept.state(*slot)),
                Op::Free { slot } => {
                    let mut state = self.kept.state(*slot);
                    let status = v2::fmi2FreeFMUstate(c, &mut state);
                    assert!(state.is_null());
                    self.kept.keep(*slot, state);
                    status
                }
                Op::Size { slot } => {
                    v2::fmi2SerializedFMUstateSize(c, self.kept.state(*slot), &mut 0)
                }
                Op::Serialize { slot, short } => {
                    let mut size = 0;
                    let state = self.kept.state(*slot);
                    if !state.is_null() {
                        let asked = v2::fmi2SerializedFMUstateSize(c, state, &mut size);
                        assert_eq!(asked, fmi2OK);
                    }
                    let mut bytes = vec![0_u8; size - usize::from(*short && size > 0)];
                    let to = bytes.as_mut_ptr().cast();
                    let status = v2::fmi2SerializeFMUstate(c, state, to, bytes.len());
                    if status == fmi2OK {
                        self.kept.bytes[*slot] = bytes;
                    }
                    status
                }
                Op::Deserialize { slot, damage } => {
                    let bytes = self.kept.damaged(*slot, *damage);
                    let mut state = self.kept.state(*slot);
                    let from = bytes.as_ptr().cast();
                    let status = v2::fmi2DeSerializeFMUstate(c, from, bytes.len(), &mut state);
                    self.kept.keep(*slot, state);
                    status
                }
                Op::Derivative { unknown, known, seed } => {
                    let (seed, mut result) = (NUMBERS[*seed], 0.0);
                    v2::fmi2GetDirectionalDerivative(c, unknown, 1, known, 1, &seed, &mut result)
                }
                Op::OutputSlope { reference, order } => {
                    v2::fmi2GetRealOutputDerivatives(c, reference, 1, order, &mut 0.0)
                }
                Op::Step { ahead, size } => {
                    v2::fmi2DoStep(c, time + AHEAD[*ahead], STEPS[*size], 1)
                }
                Op::Never { which } => match which {
                    0 => v2::fmi2EnterEventMode(c),
                    1 => v2::fmi2NewDiscreteStates(c, null_mut()),
                    2 => v2::fmi2EnterContinuousTimeMode(c),
                    3 => v2::fmi2CompletedIntegratorStep(c, 1, null_mut(), null_mut()),
                    4 => v2::fmi2SetTime(c, f64::NAN),
                    5 => v2::fmi2SetContinuousStates(c, null(), usize::MAX),
                    6 => v2::fmi2GetDerivatives(c, null_mut(), usize::MAX),
                    7 => v2::fmi2GetEventIndicators(c, null_mut(), usize::MAX),
                    8 => v2::fmi2GetNominalsOfContinuousStates(c, null_mut(), usize::MAX),
                    _ => v2::fmi2CancelStep(c),
                },
                Op::Inquiry { which } => match which % 4 {
                    0 => v2::fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &mut 0.0),
                    1 => v2::fmi2GetBooleanStatus(c, fmi2Terminated, &mut 0),
                    2 => v2::fmi2GetIntegerStatus(c, fmi2DoStepStatus, &mut 0),
                    _ => v2::fmi2GetStringStatus(c, fmi2PendingStatus, null_mut()),
                },
                Op::Renew => {
                    *self = Self::new();
                    return Some(OK);
                }
            }
        };
        Some(answer(status.0))
    }
}

const AHEAD: [f64; 4] = [0.0, 1.0, f64::NAN, f64::NEG_INFINITY];

struct Three {
    i: fmi3Instance,
    kept: Kept,
}

impl Drop for Three {
    fn drop(&mut self) {
        unsafe { v3::fmi3FreeInstance(self.i) }
    }
}

impl Edge for Three {
    const HAS_ARRAYS: bool = true;

    fn new() -> Self {
        let path = CString::new(format!("{}/", resources().display())).unwrap();
        let (no, none) = (false, null_mut());
        let i = unsafe {
            let (token, path) = (token().as_ptr(), path.as_ptr());
            v3::fmi3InstantiateCoSimulation(
                plant,
                c"it".as_ptr(),
                token,
                path,
                no,
                no,
                no,
                no,
                null(),
                0,
                none,
                None,
                None,
            )
        };
        assert!(!i.is_null());
        Self { i, kept: Kept::default() }
    }

    fn call(&mut self, op: &Op, time: f64, count: usize) -> Option<Answers> {
        let i = self.i;
        let status = unsafe {
            match op {
                Op::Debug { category } => {
                    let texts = [c"logEvents".as_ptr(), c"nonsense".as_ptr(), null()];
                    match category {
                        0 => v3::fmi3SetDebugLogging(i, false, 0, null()),
                        n => v3::fmi3SetDebugLogging(i, true, 1, &texts[usize::from(*n) - 1]),
                    }
                }
                Op::SetUp { .. } | Op::Inquiry { .. } => return None,
                Op::Enter { start, stop } => {
                    let (start, defined, stop) = experiment(*start, *stop);
                    v3::fmi3EnterInitializationMode(i, true, f64::NAN, start, defined, stop)
                }
                Op::Exit => v3::fmi3ExitInitializationMode(i),
                Op::Terminate => v3::fmi3Terminate(i),
                Op::Reset => v3::fmi3Reset(i),
                Op::Get { kind, references, null, excess } => {
                    let (n, vr) = (references.len(), pointer(references, *null));
                    let count = count + usize::from(*excess);
                    let (mut real, mut integer, mut flags) = ([0.0; 16], [0; 16], [false; 16]);
                    match kind {
                        Kind::Real => v3::fmi3GetFloat64(i, vr, n, real.as_mut_ptr(), count),
                        Kind::Integer => v3::fmi3GetInt32(i, vr, n, integer.as_mut_ptr(), count),
                        Kind::Boolean => v3::fmi3GetBoolean(i, vr, n, flags.as_mut_ptr(), count),
                        Kind::String => v3::fmi3GetString(i, vr, n, null_mut(), count),
                    }
                }
                Op::Set { kind, items, null, excess } => {
                    let vr: Vec<u32> = items.iter().map(|(reference, _)| *reference).collect();
                    let (n, vr) = (items.len(), vr.as_ptr());
                    let sizes = sizes();
                    let mut numbers = Vec::new();
                    for (reference, number) in items {
                        let size = sizes.iter().find(|(first, _)| first == reference);
                        let size = size.map_or(1, |(_, size)| *size);
                        numbers.extend(std::iter::repeat_n(*number, size));
                    }
                    numbers.extend(std::iter::repeat_n(0, usize::from(*excess)));
                    let real: Vec<f64> = numbers.iter().map(|n| NUMBERS[*n]).collect();
                    let integer: Vec<i32> = numbers.iter().map(|n| *n as i32).collect();
                    let flags: Vec<bool> = numbers.iter().map(|n| n % 2 == 1).collect();
                    let count = numbers.len();
                    match kind {
                        Kind::Real => v3::fmi3SetFloat64(i, vr, n, pointer(&real, *null), count),
                        Kind::Integer => {
                            v3::fmi3SetInt32(i, vr, n, pointer(&integer, *null), count)
                        }
                        Kind::Boolean => {
                            v3::fmi3SetBoolean(i, vr, n, pointer(&flags, *null), count)
                        }
                        Kind::String => v3::fmi3SetString(i, vr, n, std::ptr::null(), count),
                    }
                }
                Op::Save { null: true, .. } => v3::fmi3GetFMUState(i, null_mut()),
                Op::Save { slot, .. } => {
                    let mut state = self.kept.state(*slot);
                    let status = v3::fmi3GetFMUState(i, &mut state);
                    self.kept.keep(*slot, state);
                    status
                }
                Op::Restore { slot } => v3::fmi3SetFMUState(i, self.kept.state(*slot)),
                Op::Free { slot } => {
                    let mut state = self.kept.state(*slot);
                    let status = v3::fmi3FreeFMUState(i, &mut state);
                    assert!(state.is_null());
                    self.kept.keep(*slot, state);
                    status
                }
                Op::Size { slot } => {
                    v3::fmi3SerializedFMUStateSize(i, self.kept.state(*slot), &mut 0)
                }
                Op::Serialize { slot, short } => {
                    let mut size = 0;
                    let state = self.kept.state(*slot);
                    if !state.is_null() {
                        let asked = v3::fmi3SerializedFMUStateSize(i, state, &mut size);
                        assert_eq!(asked, fmi3OK);
                    }
                    let mut bytes = vec![0_u8; size - usize::from(*short && size > 0)];
                    let to = bytes.as_mut_ptr();
                    let status = v3::fmi3SerializeFMUState(i, state, to, bytes.len());
                    if status == fmi3OK {
                        self.kept.bytes[*slot] = bytes;
                    }
                    status
                }
                Op::Deserialize { slot, damage } => {
                    let bytes = self.kept.damaged(*slot, *damage);
                    let mut state = self.kept.state(*slot);
                    let from = bytes.as_ptr();
                    let status = v3::fmi3DeserializeFMUState(i, from, bytes.len(), &mut state);
                    self.kept.keep(*slot, state);
                    status
                }
                Op::Derivative { unknown, known, seed } => {
                    let (seed, mut result) = ([NUMBERS[*seed]; 2], [0.0; 2]);
                    let (from, to) = (seed.as_ptr(), result.as_mut_ptr());
                    v3::fmi3GetDirectionalDerivative(i, unknown, 1, known, 1, from, 2, to, 2)
                }
                Op::OutputSlope { reference, order } => {
                    let mut slopes = [0.0; 2];
                    v3::fmi3GetOutputDerivatives(i, reference, 1, order, slopes.as_mut_ptr(), 2)
                }
                Op::Step { ahead, size } => {
                    let (mut event, mut end, mut early, mut last) = (true, true, true, 0.0);
                    let (at, size) = (time + AHEAD[*ahead], STEPS[*size]);
                    let flags = (&mut event, &mut end, &mut early);
                    v3::fmi3DoStep(i, at, size, true, flags.0, flags.1, flags.2, &mut last)
                }
                Op::Never { which } => match which {
                    0 => v3::fmi3EnterEventMode(i),
                    1 => v3::fmi3EnterConfigurationMode(i),
                    2 => v3::fmi3EnterContinuousTimeMode(i),
                    3 => v3::fmi3CompletedIntegratorStep(i, true, null_mut(), null_mut()),
                    4 => v3::fmi3SetTime(i, f64::NAN),
                    5 => v3::fmi3SetContinuousStates(i, null(), usize::MAX),
                    6 => v3::fmi3GetContinuousStateDerivatives(i, null_mut(), usize::MAX),
                    7 => v3::fmi3GetEventIndicators(i, null_mut(), usize::MAX),
                    8 => v3::fmi3EnterStepMode(i),
                    _ => v3::fmi3ActivateModelPartition(i, u32::MAX, f64::NAN),
                },
                Op::Renew => {
                    *self = Self::new();
                    return Some(OK);
                }
            }
        };
        Some(answer(status.0))
    }
}

/// Value references of arrays, with their sizes.
fn sizes() -> &'static [(u32, usize)] {
    static SIZES: std::sync::OnceLock<Vec<(u32, usize)>> = std::sync::OnceLock::new();
    SIZES.get_or_init(|| {
        let bundles = components::plant().variables().bundles();
        bundles.iter().map(|bundle| (bundle.elements[0], bundle.elements.len())).collect()
    })
}

/// The token of the plant.
fn token() -> &'static std::ffi::CStr {
    static TOKEN: std::sync::OnceLock<CString> = std::sync::OnceLock::new();
    TOKEN.get_or_init(|| CString::new(components::plant().variables().fingerprint()).unwrap())
}

/// Whether an instance computes as a new one after a reset.
fn as_new<E: Edge>(edge: &mut E, system: &System) {
    let mut good = |op: Op, time: f64| {
        let answers = edge.call(&op, time, 1).unwrap_or(OK);
        assert!(answers <= 2, "{op:?}: {answers}");
    };
    good(Op::Reset, 0.0);
    good(Op::SetUp { start: 0, stop: None }, 0.0);
    good(Op::Enter { start: 0, stop: None }, 0.0);
    good(Op::Exit, 0.0);
    let command = system.variables().find("command[1]").unwrap();
    good(Op::Set { kind: Kind::Real, items: vec![(command, 3)], null: false, excess: 0 }, 0.0);
    (0..3).for_each(|k| good(Op::Step { ahead: 0, size: 0 }, f64::from(k) * 1e-3));
    good(Op::Terminate, 0.0);
}

fn life<E: Edge>(ops: &[Op], system: &System) -> Result<(), TestCaseError> {
    let mut edge = E::new();
    let mut reference = Reference::new(system.variables(), E::HAS_ARRAYS);
    for (at, op) in ops.iter().enumerate() {
        let time = reference.time();
        let count = match op {
            Op::Get { references, .. } => reference.count(references),
            _ => 0,
        };
        let right = reference.expect(op);
        let Some(came) = edge.call(op, time, count) else { continue };
        prop_assert!(came & right != 0, "call {at}, {op:?}: came {came}, right {right}");
        reference.settle(came);
    }
    as_new(&mut edge, system);
    Ok(())
}

/// Runs so many sequences on several threads, each with its own seed and its own instances.
fn run<E: Edge>(seed: u64) {
    let all: u32 =
        std::env::var("PIEZOLOOP_SEQUENCES").ok().and_then(|n| n.parse().ok()).unwrap_or(20_000);
    const THREADS: u32 = 4;
    std::thread::scope(|scope| {
        for thread in 0..THREADS {
            scope.spawn(move || {
                let system = components::plant();
                let count = system.variables().len() as u32;
                let config =
                    Config { cases: all / THREADS, failure_persistence: None, ..Config::default() };
                let mut bytes = [0; 32];
                bytes[..8].copy_from_slice(&(seed + u64::from(thread)).to_le_bytes());
                let random = TestRng::from_seed(RngAlgorithm::ChaCha, &bytes);
                let mut runner = TestRunner::new_with_rng(config, random);
                let done = runner.run(&sequence(count), |ops| life::<E>(&ops, &system));
                if let Err(error) = done {
                    panic!("seed {seed}, thread {thread}: {error}");
                }
            });
        }
    });
    println!("{all} sequences, seed {seed}");
}

#[test]
fn no_sequence_is_answered_wrongly() {
    // The component that panics on purpose must not fill the screen.
    std::panic::set_hook(Box::new(|info| {
        if !info.to_string().contains("on 100% purpose") {
            println!("{info}");
        }
    }));
    run::<Two>(2_000);
    run::<Three>(3_000);
}
