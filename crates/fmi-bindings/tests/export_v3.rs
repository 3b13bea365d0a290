//! The edge of FMI 3.0: the same instance under the other names.

use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use crate::support::{Fmu, controller, plant, resources};
use fmi_bindings::export::{Factory, Phase, v3};
use fmi_bindings::fmi3::*;

/// The standard's table for co-simulation: function, its marks in Instantiated, Initialization
/// Mode, Step Mode, Terminated and after an error, and its answer to good arguments there.
const STANDARD: &str = include_str!("support/fmi3_call_table.txt");

type Messages = Mutex<Vec<(fmi3Status, String, String)>>;

unsafe extern "C" fn record(
    environment: *mut c_void,
    status: fmi3Status,
    category: *const c_char,
    message: *const c_char,
) {
    let text = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_string();
    let messages = unsafe { &*environment.cast::<Messages>() };
    messages.lock().unwrap().push((status, text(category), text(message)));
}

struct Fmu3 {
    instance: fmi3Instance,
    messages: Box<Messages>,
    /// Number of elements by value reference.
    sizes: HashMap<u32, usize>,
}

struct Arguments {
    token: String,
    path: Option<CString>,
    logging_on: bool,
    event_mode: bool,
    intermediate: usize,
}

impl Arguments {
    fn of(factory: Factory) -> Self {
        Self {
            token: factory(resources()).unwrap().variables().fingerprint(),
            path: CString::new(format!("{}/", resources().display())).ok(),
            logging_on: true,
            event_mode: false,
            intermediate: 0,
        }
    }
}

impl Fmu3 {
    fn with(factory: Factory, arguments: &Arguments) -> Self {
        let messages = Box::<Messages>::default();
        let token = CString::new(arguments.token.as_str()).unwrap();
        let instance = unsafe {
            v3::fmi3InstantiateCoSimulation(
                factory,
                c"it".as_ptr(),
                token.as_ptr(),
                arguments.path.as_ref().map_or(null(), |path| path.as_ptr()),
                false,
                arguments.logging_on,
                arguments.event_mode,
                true,
                null(),
                arguments.intermediate,
                (&raw const *messages).cast_mut().cast(),
                Some(record),
                None,
            )
        };
        let bundles = factory(resources()).unwrap().variables().bundles();
        let sizes = bundles.iter().map(|b| (b.elements[0], b.elements.len())).collect();
        Self { instance, messages, sizes }
    }

    fn size(&self, reference: u32) -> usize {
        self.sizes.get(&reference).copied().unwrap_or(1)
    }

    fn new(factory: Factory) -> Self {
        let fmu = Self::with(factory, &Arguments::of(factory));
        assert!(!fmu.instance.is_null(), "{:?}", fmu.messages);
        fmu
    }

    fn enter(&self, start: f64) -> fmi3Status {
        unsafe { v3::fmi3EnterInitializationMode(self.instance, false, 0.0, start, false, 0.0) }
    }

    fn start(&self, time: f64) {
        assert_eq!(self.enter(time), fmi3OK);
        assert_eq!(unsafe { v3::fmi3ExitInitializationMode(self.instance) }, fmi3OK);
    }

    fn set_all(&self, reference: u32, values: &[f64]) -> fmi3Status {
        let (pointer, count) = (values.as_ptr(), values.len());
        unsafe { v3::fmi3SetFloat64(self.instance, &reference, 1, pointer, count) }
    }

    fn get_all(&self, reference: u32) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.size(reference)];
        let (pointer, count) = (values.as_mut_ptr(), values.len());
        let status = unsafe { v3::fmi3GetFloat64(self.instance, &reference, 1, pointer, count) };
        assert_eq!(status, fmi3OK, "{:?}", self.messages);
        values
    }

    /// Sets the first element, the others to 0.
    fn set(&self, reference: u32, value: f64) -> fmi3Status {
        let mut values = vec![0.0; self.size(reference)];
        values[0] = value;
        self.set_all(reference, &values)
    }

    /// The first element.
    fn get(&self, reference: u32) -> f64 {
        self.get_all(reference)[0]
    }

    /// A step; the answers must be those of a complete one.
    fn step(&self, time: f64, step: f64) -> fmi3Status {
        let (mut event, mut end, mut early, mut last) = (true, true, true, f64::NAN);
        let status = unsafe {
            v3::fmi3DoStep(
                self.instance,
                time,
                step,
                true,
                &mut event,
                &mut end,
                &mut early,
                &mut last,
            )
        };
        if status == fmi3OK {
            assert_eq!((event, end, early, last), (false, false, false, time + step));
        }
        status
    }

    fn save(&self) -> fmi3FMUState {
        let mut state = null_mut();
        assert_eq!(unsafe { v3::fmi3GetFMUState(self.instance, &mut state) }, fmi3OK);
        state
    }

    fn last(&self) -> String {
        self.messages.lock().unwrap().last().map(|m| m.2.clone()).unwrap_or_default()
    }
}

impl Drop for Fmu3 {
    fn drop(&mut self) {
        unsafe { v3::fmi3FreeInstance(self.instance) }
    }
}

fn in_state(phase: Phase) -> (Fmu3, fmi3FMUState) {
    let fmu = Fmu3::new(plant);
    match phase {
        Phase::Instantiated => {}
        Phase::Initialization => assert_eq!(fmu.enter(0.0), fmi3OK),
        Phase::Step => fmu.start(0.0),
        Phase::Terminated => {
            fmu.start(0.0);
            assert_eq!(unsafe { v3::fmi3Terminate(fmu.instance) }, fmi3OK);
        }
        Phase::Error => {
            fmu.start(0.0);
            assert_eq!(fmu.step(0.0, -1.0), fmi3Error);
        }
    }
    let state = fmu.save();
    (fmu, state)
}

/// Calls a function with arguments that are good for the plant: input 0, output 2.
fn call(function: &str, fmu: &Fmu3, state: fmi3FMUState) -> fmi3Status {
    let i = fmu.instance;
    let (mut place, mut size, mut reals) = (state, 0, [0.0; 2]);
    let real = &mut reals[0];
    let mut flags = [false; 6];
    // Values of types that no variable has: none are asked for.
    macro_rules! none {
        ($function:ident) => {
            v3::$function(i, null(), 0, null_mut(), 0)
        };
    }
    macro_rules! none_set {
        ($function:ident) => {
            v3::$function(i, null(), 0, null(), 0)
        };
    }
    unsafe {
        match function {
            "fmi3SetDebugLogging" => v3::fmi3SetDebugLogging(i, true, 0, null()),
            "fmi3EnterInitializationMode" => fmu.enter(0.0),
            "fmi3ExitInitializationMode" => v3::fmi3ExitInitializationMode(i),
            "fmi3EnterEventMode" => v3::fmi3EnterEventMode(i),
            "fmi3Terminate" => v3::fmi3Terminate(i),
            "fmi3Reset" => v3::fmi3Reset(i),
            "fmi3GetFloat32" => none!(fmi3GetFloat32),
            "fmi3GetFloat64" => v3::fmi3GetFloat64(i, &2, 1, reals.as_mut_ptr(), 2),
            "fmi3GetInt8" => none!(fmi3GetInt8),
            "fmi3GetUInt8" => none!(fmi3GetUInt8),
            "fmi3GetInt16" => none!(fmi3GetInt16),
            "fmi3GetUInt16" => none!(fmi3GetUInt16),
            "fmi3GetInt32" => none!(fmi3GetInt32),
            "fmi3GetUInt32" => none!(fmi3GetUInt32),
            "fmi3GetInt64" => none!(fmi3GetInt64),
            "fmi3GetUInt64" => none!(fmi3GetUInt64),
            "fmi3GetBoolean" => v3::fmi3GetBoolean(i, &4, 1, flags.as_mut_ptr(), 2),
            "fmi3GetString" => none!(fmi3GetString),
            "fmi3GetBinary" => v3::fmi3GetBinary(i, null(), 0, null_mut(), null_mut(), 0),
            "fmi3GetClock" => v3::fmi3GetClock(i, null(), 0, null_mut()),
            "fmi3SetFloat32" => none_set!(fmi3SetFloat32),
            "fmi3SetFloat64" => fmu.set(0, 1.0),
            "fmi3SetInt8" => none_set!(fmi3SetInt8),
            "fmi3SetUInt8" => none_set!(fmi3SetUInt8),
            "fmi3SetInt16" => none_set!(fmi3SetInt16),
            "fmi3SetUInt16" => none_set!(fmi3SetUInt16),
            "fmi3SetInt32" => none_set!(fmi3SetInt32),
            "fmi3SetUInt32" => none_set!(fmi3SetUInt32),
            "fmi3SetInt64" => none_set!(fmi3SetInt64),
            "fmi3SetUInt64" => none_set!(fmi3SetUInt64),
            "fmi3SetBoolean" => none_set!(fmi3SetBoolean),
            "fmi3SetString" => none_set!(fmi3SetString),
            "fmi3SetBinary" => v3::fmi3SetBinary(i, null(), 0, null(), null(), 0),
            "fmi3SetClock" => v3::fmi3SetClock(i, null(), 0, null()),
            "fmi3GetNumberOfVariableDependencies" => {
                v3::fmi3GetNumberOfVariableDependencies(i, 2, &mut size)
            }
            "fmi3GetVariableDependencies" => v3::fmi3GetVariableDependencies(
                i,
                2,
                null_mut(),
                null_mut(),
                null_mut(),
                null_mut(),
                0,
            ),
            "fmi3GetFMUState" => v3::fmi3GetFMUState(i, &mut place),
            "fmi3SetFMUState" => v3::fmi3SetFMUState(i, state),
            "fmi3FreeFMUState" => v3::fmi3FreeFMUState(i, &mut place),
            "fmi3SerializedFMUStateSize" => v3::fmi3SerializedFMUStateSize(i, state, &mut size),
            "fmi3SerializeFMUState" | "fmi3DeserializeFMUState" => {
                assert_eq!(v3::fmi3SerializedFMUStateSize(i, state, &mut size), fmi3OK);
                let mut bytes = vec![0; size];
                let status = v3::fmi3SerializeFMUState(i, state, bytes.as_mut_ptr(), size);
                if function == "fmi3SerializeFMUState" {
                    return status;
                }
                v3::fmi3DeserializeFMUState(i, bytes.as_ptr(), size, &mut place)
            }
            "fmi3GetDirectionalDerivative" => {
                let (seed, result) = ([1.0, 0.0].as_ptr(), reals.as_mut_ptr());
                v3::fmi3GetDirectionalDerivative(i, &2, 1, &0, 1, seed, 2, result, 2)
            }
            "fmi3GetAdjointDerivative" => {
                v3::fmi3GetAdjointDerivative(i, &2, 1, &0, 1, &1.0, 1, real, 1)
            }
            "fmi3EnterConfigurationMode" => v3::fmi3EnterConfigurationMode(i),
            "fmi3ExitConfigurationMode" => v3::fmi3ExitConfigurationMode(i),
            "fmi3GetIntervalDecimal" => {
                v3::fmi3GetIntervalDecimal(i, null(), 0, null_mut(), null_mut())
            }
            "fmi3GetIntervalFraction" => {
                v3::fmi3GetIntervalFraction(i, null(), 0, null_mut(), null_mut(), null_mut())
            }
            "fmi3GetShiftDecimal" => v3::fmi3GetShiftDecimal(i, null(), 0, null_mut()),
            "fmi3GetShiftFraction" => {
                v3::fmi3GetShiftFraction(i, null(), 0, null_mut(), null_mut())
            }
            "fmi3SetIntervalDecimal" => v3::fmi3SetIntervalDecimal(i, null(), 0, null()),
            "fmi3SetIntervalFraction" => v3::fmi3SetIntervalFraction(i, null(), 0, null(), null()),
            "fmi3SetShiftDecimal" => v3::fmi3SetShiftDecimal(i, null(), 0, null()),
            "fmi3SetShiftFraction" => v3::fmi3SetShiftFraction(i, null(), 0, null(), null()),
            "fmi3EvaluateDiscreteStates" => v3::fmi3EvaluateDiscreteStates(i),
            "fmi3UpdateDiscreteStates" => {
                let [a, b, c, d, e, _] = &mut flags;
                v3::fmi3UpdateDiscreteStates(i, a, b, c, d, e, real)
            }
            "fmi3EnterContinuousTimeMode" => v3::fmi3EnterContinuousTimeMode(i),
            "fmi3CompletedIntegratorStep" => {
                let [a, b, ..] = &mut flags;
                v3::fmi3CompletedIntegratorStep(i, true, a, b)
            }
            "fmi3SetTime" => v3::fmi3SetTime(i, 0.0),
            "fmi3SetContinuousStates" => v3::fmi3SetContinuousStates(i, null(), 0),
            "fmi3GetContinuousStateDerivatives" => {
                v3::fmi3GetContinuousStateDerivatives(i, null_mut(), 0)
            }
            "fmi3GetEventIndicators" => v3::fmi3GetEventIndicators(i, null_mut(), 0),
            "fmi3GetContinuousStates" => v3::fmi3GetContinuousStates(i, null_mut(), 0),
            "fmi3GetNominalsOfContinuousStates" => {
                v3::fmi3GetNominalsOfContinuousStates(i, null_mut(), 0)
            }
            "fmi3GetNumberOfEventIndicators" => v3::fmi3GetNumberOfEventIndicators(i, &mut size),
            "fmi3GetNumberOfContinuousStates" => v3::fmi3GetNumberOfContinuousStates(i, &mut size),
            "fmi3EnterStepMode" => v3::fmi3EnterStepMode(i),
            "fmi3GetOutputDerivatives" => v3::fmi3GetOutputDerivatives(i, &2, 1, &1, real, 2),
            "fmi3DoStep" => fmu.step(0.0, 1e-3),
            "fmi3ActivateModelPartition" => v3::fmi3ActivateModelPartition(i, 0, 0.0),
            other => panic!("the test does not call {other}"),
        }
    }
}

fn rows() -> impl Iterator<Item = (&'static str, [bool; 5], bool)> {
    STANDARD.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let mut words = line.split_whitespace();
        let function = words.next().unwrap();
        let marks: Vec<bool> = words.by_ref().take(5).map(|mark| mark == "x").collect();
        (function, marks.try_into().unwrap(), words.next().is_none())
    })
}

#[test]
fn every_function_in_every_state_answers_as_the_standard_says() {
    let mut pairs = 0;
    for (function, marks, offered) in rows().filter(|row| row.0 != "fmi3FreeInstance") {
        for (phase, allowed) in Phase::ALL.into_iter().zip(marks) {
            let (fmu, state) = in_state(phase);
            fmu.messages.lock().unwrap().clear();
            let status = call(function, &fmu, state);
            let place = format!("{function} in {phase}: {:?}", fmu.messages);
            if allowed && offered {
                assert_eq!(status, fmi3OK, "{place}");
            } else {
                assert_eq!(status, fmi3Error, "{place}");
                let rule = if allowed { "not offered" } else { "not allowed in the state" };
                assert!(fmu.last().contains(rule), "{place}");
                assert!(fmu.last().starts_with(function), "{place}");
            }
            pairs += 1;
        }
    }
    assert_eq!(pairs, 70 * 5);
}

#[test]
fn the_table_in_the_code_is_the_standards() {
    assert_eq!(v3::TABLE.len(), rows().count());
    for (rule, (function, marks, _)) in v3::TABLE.iter().zip(rows()) {
        assert_eq!(rule.function, function);
        assert_eq!(Phase::ALL.map(|phase| rule.allows(phase)), marks, "{function}");
    }
    // The 75 functions: the rows, and four that need no instance.
    assert_eq!(v3::TABLE.len() + 4, 75);
}

#[test]
fn both_versions_compute_the_same_bits_and_share_serialised_states() {
    let (two, three) = (Fmu::ready(plant), Fmu3::new(plant));
    three.start(0.0);
    let (input, output) = (two.reference("command[1]"), two.reference("position[1]"));
    for k in 0..100 {
        let (time, command) = (f64::from(k) * 1.3e-3, f64::from(k % 7));
        two.set_real("command[1]", command);
        assert_eq!(three.set(input, command), fmi3OK);
        two.step(time, 1.3e-3);
        assert_eq!(three.step(time, 1.3e-3), fmi3OK, "{:?}", three.messages);
        assert_eq!(two.real("position[1]").to_bits(), three.get(output).to_bits());
    }
    let bytes = two.bytes(two.save());
    let mut state = null_mut();
    unsafe {
        let (pointer, size) = (bytes.as_ptr(), bytes.len());
        let status = v3::fmi3DeserializeFMUState(three.instance, pointer, size, &mut state);
        assert_eq!(status, fmi3OK);
        assert_eq!(v3::fmi3SetFMUState(three.instance, state), fmi3OK);
    }
    assert_eq!(three.get(output).to_bits(), two.real("position[1]").to_bits());
}

#[test]
fn time_is_a_variable_that_is_only_read() {
    let fmu = Fmu3::new(plant);
    let time = v3::time_reference(plant(resources()).unwrap().variables());
    assert_eq!(fmu.get(time), 0.0);
    fmu.start(2.5);
    assert_eq!(fmu.get(time), 2.5);
    assert_eq!(fmu.step(2.5, 0.5), fmi3OK);
    assert_eq!(fmu.get(time), 3.0);
    assert_eq!(fmu.set(time, 1.0), fmi3Error);
    assert!(fmu.last().contains("independent variable"), "{}", fmu.last());
    let mut flag = false;
    assert_eq!(unsafe { v3::fmi3GetBoolean(fmu.instance, &time, 1, &mut flag, 1) }, fmi3Error);
}

#[test]
fn start_values_are_read_before_initialization_and_booleans_are_set() {
    let fmu = Fmu3::new(controller);
    let enable = controller(resources()).unwrap().variables().find("enable").unwrap();
    let mut flag = false;
    unsafe {
        assert_eq!(v3::fmi3GetBoolean(fmu.instance, &enable, 1, &mut flag, 1), fmi3OK);
        assert!(flag);
        assert_eq!(v3::fmi3SetBoolean(fmu.instance, &enable, 1, &false, 1), fmi3OK);
        assert_eq!(v3::fmi3GetBoolean(fmu.instance, &enable, 1, &mut flag, 1), fmi3OK);
    }
    assert!(!flag);
}

#[test]
fn what_is_not_offered_is_refused_at_instantiation() {
    let good = || Arguments::of(plant);
    for (arguments, part) in [
        (Arguments { event_mode: true, ..good() }, "event mode"),
        (Arguments { intermediate: 1, ..good() }, "intermediate update"),
        (Arguments { token: "other".into(), ..good() }, "instantiationToken"),
        (Arguments { path: Some(c"/nowhere/".into()), ..good() }, "/nowhere"),
    ] {
        let fmu = Fmu3::with(plant, &Arguments { logging_on: false, ..arguments });
        assert!(fmu.instance.is_null(), "{part}");
        assert!(fmu.last().contains(part), "{}", fmu.last());
    }
    let messages = Box::<Messages>::default();
    let environment = (&raw const *messages).cast_mut().cast();
    let (name, none) = (c"it".as_ptr(), null());
    unsafe {
        let exchange = v3::fmi3InstantiateModelExchange(
            name,
            none,
            none,
            false,
            false,
            environment,
            Some(record),
        );
        let scheduled = v3::fmi3InstantiateScheduledExecution(
            name,
            none,
            none,
            false,
            false,
            environment,
            Some(record),
            None,
            None,
            None,
        );
        assert!(exchange.is_null() && scheduled.is_null());
    }
    assert_eq!(messages.lock().unwrap().len(), 2);
}

#[test]
fn with_logging_off_nothing_is_reported() {
    let fmu = Fmu3::with(plant, &Arguments { logging_on: false, ..Arguments::of(plant) });
    assert_eq!(fmu.step(0.0, 1.0), fmi3Error);
    assert!(fmu.messages.lock().unwrap().is_empty());
    let loud = Fmu3::new(plant);
    loud.start(0.0);
    assert_eq!(loud.set(0, f64::NAN), fmi3Error);
    let messages = loud.messages.lock().unwrap();
    let (status, category, text) = messages.last().unwrap();
    assert_eq!((*status, category.as_str()), (fmi3Error, "logStatusError"));
    assert!(text.contains("command[1]") && text.contains("NaN"), "{text}");
}

#[test]
fn a_step_that_is_refused_tells_how_far_it_came() {
    let fmu = Fmu3::new(plant);
    fmu.start(1.0);
    let (mut flags, mut last) = ([true; 3], f64::NAN);
    let [a, b, c] = &mut flags;
    let status = unsafe { v3::fmi3DoStep(fmu.instance, 5.0, 1.0, true, a, b, c, &mut last) };
    assert_eq!((status, last), (fmi3Error, 1.0));
    assert_eq!(flags, [false; 3]);
}
