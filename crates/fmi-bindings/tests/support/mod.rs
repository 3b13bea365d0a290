//! An importer for tests: it calls the functions of the edge as C does and keeps what the FMU says.
#![allow(dead_code, unreachable_pub)]

pub mod components;
pub mod plays;
pub mod reference;
pub mod sequences;
pub mod taps;

use std::ffi::{CStr, CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::{Mutex, OnceLock};

pub use fmi_bindings::export::Factory;
use fmi_bindings::export::v2;
use fmi_bindings::fmi2::*;
use model::System;

/// A message as the logger got it, the format unformatted.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedMessage {
    pub environment: usize,
    pub name: String,
    pub status: fmi2Status,
    pub category: String,
    pub format: String,
}

/// What the logger's environment pointer points to.
#[derive(Default)]
pub struct Recorder(pub Mutex<Vec<LoggedMessage>>);

unsafe extern "C" fn record(
    environment: *mut c_void,
    name: *const c_char,
    status: fmi2Status,
    category: *const c_char,
    format: *const c_char,
) {
    let text = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_string();
    let messages = LoggedMessage {
        environment: environment as usize,
        name: text(name),
        status,
        category: text(category),
        format: text(format),
    };
    if let Some(recorder) = unsafe { environment.cast::<Recorder>().as_ref() } {
        recorder.0.lock().unwrap().push(messages);
    }
}

/// The logger as the standard's variadic type: the FMU passes no variable arguments.
pub fn logger() -> fmi2CallbackLogger {
    type Plain =
        unsafe extern "C" fn(*mut c_void, *const c_char, fmi2Status, *const c_char, *const c_char);
    unsafe { std::mem::transmute::<Plain, fmi2CallbackLogger>(record) }
}

/// A folder with a blueprint, which the test factories do not read.
pub fn resources() -> &'static Path {
    static FOLDER: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("blueprint.toml"), "").unwrap();
        let path = folder.path().to_path_buf();
        (folder, path)
    });
    path
}

pub fn plant(_: &Path) -> Result<System, String> {
    Ok(components::plant())
}

pub fn other_plant(_: &Path) -> Result<System, String> {
    Ok(components::other_plant())
}

pub fn controller(_: &Path) -> Result<System, String> {
    Ok(components::controller())
}

pub fn plays_plant(_: &Path) -> Result<System, String> {
    Ok(plays::plays_plant(0.0))
}

pub fn arrays_plant(_: &Path) -> Result<System, String> {
    Ok(taps::taps_plant())
}

pub fn stairs_plant(_: &Path) -> Result<System, String> {
    Ok(plays::plays_plant(0.5))
}

/// What an importer passes to `fmi2Instantiate`.
pub struct Arguments {
    pub name: Option<CString>,
    pub kind: fmi2Type,
    pub guid: Option<CString>,
    pub location: Option<CString>,
    pub logging_on: fmi2Boolean,
    pub callbacks: Option<fmi2CallbackFunctions>,
}

impl Arguments {
    /// Good ones for the models of this factory.
    pub fn of(factory: Factory) -> Self {
        let guid = factory(resources()).unwrap().variables().fingerprint();
        let location = format!("file://{}", resources().display());
        Self {
            name: Some(c"it".into()),
            kind: fmi2CoSimulation,
            guid: CString::new(guid).ok(),
            location: CString::new(location).ok(),
            logging_on: fmi2False,
            callbacks: Some(callbacks()),
        }
    }

    pub fn location(mut self, location: &str) -> Self {
        self.location = CString::new(location).ok();
        self
    }
}

/// Callbacks of a friendly importer; the environment is filled in at instantiation.
pub fn callbacks() -> fmi2CallbackFunctions {
    fmi2CallbackFunctions {
        logger: Some(logger()),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    }
}

/// An instance and its messages.
pub struct Fmu {
    pub c: fmi2Component,
    pub recorder: Box<Recorder>,
    pub system: System,
}

impl Fmu {
    /// An instance in the state *instantiated*.
    pub fn new(factory: Factory) -> Self {
        Self::with(factory, Arguments::of(factory))
    }

    /// An instance from these arguments; its pointer is null where the FMU refuses.
    pub fn with(factory: Factory, mut arguments: Arguments) -> Self {
        let recorder = Box::<Recorder>::default();
        if let Some(callbacks) = &mut arguments.callbacks {
            callbacks.componentEnvironment = (&raw const *recorder).cast_mut().cast();
        }
        let pointer = |text: &Option<CString>| text.as_ref().map_or(null(), |t| t.as_ptr());
        let c = unsafe {
            v2::fmi2Instantiate(
                factory,
                pointer(&arguments.name),
                arguments.kind,
                pointer(&arguments.guid),
                pointer(&arguments.location),
                arguments.callbacks.as_ref().map_or(null(), |c| c),
                fmi2False,
                arguments.logging_on,
            )
        };
        // The structure is only good during the call.
        if let Some(callbacks) = &mut arguments.callbacks {
            callbacks.componentEnvironment = null_mut();
        }
        let system = if c.is_null() { components::plant() } else { factory(resources()).unwrap() };
        Self { c, recorder, system }
    }

    /// An instance of the plant that is ready to step from 0 s.
    pub fn ready(factory: Factory) -> Self {
        let fmu = Self::new(factory);
        fmu.start(0.0);
        fmu
    }

    /// Sets up, enters and exits the initialization mode.
    pub fn start(&self, time: f64) {
        assert_eq!(self.set_up(time, None), fmi2OK);
        assert_eq!(self.enter(), fmi2OK);
        assert_eq!(self.exit(), fmi2OK);
    }

    pub fn set_up(&self, start: f64, stop: Option<f64>) -> fmi2Status {
        let defined = fmi2Boolean::from(stop.is_some());
        unsafe {
            v2::fmi2SetupExperiment(self.c, fmi2False, 0.0, start, defined, stop.unwrap_or(-1.0))
        }
    }

    pub fn enter(&self) -> fmi2Status {
        unsafe { v2::fmi2EnterInitializationMode(self.c) }
    }

    pub fn exit(&self) -> fmi2Status {
        unsafe { v2::fmi2ExitInitializationMode(self.c) }
    }

    pub fn terminate(&self) -> fmi2Status {
        unsafe { v2::fmi2Terminate(self.c) }
    }

    pub fn reset(&self) -> fmi2Status {
        unsafe { v2::fmi2Reset(self.c) }
    }

    pub fn step(&self, time: f64, step: f64) -> fmi2Status {
        unsafe { v2::fmi2DoStep(self.c, time, step, fmi2True) }
    }

    pub fn reference(&self, name: &str) -> u32 {
        self.system.variables().find(name).unwrap_or_else(|| panic!("no variable {name}"))
    }

    pub fn set_real(&self, name: &str, value: f64) -> fmi2Status {
        self.set_reals(&[self.reference(name)], &[value])
    }

    pub fn set_reals(&self, references: &[u32], values: &[f64]) -> fmi2Status {
        let count = references.len();
        unsafe { v2::fmi2SetReal(self.c, references.as_ptr(), count, values.as_ptr()) }
    }

    pub fn set_boolean(&self, name: &str, value: fmi2Boolean) -> fmi2Status {
        unsafe { v2::fmi2SetBoolean(self.c, &self.reference(name), 1, &value) }
    }

    pub fn set_slope(&self, name: &str, order: i32, slope: f64) -> fmi2Status {
        unsafe { v2::fmi2SetRealInputDerivatives(self.c, &self.reference(name), 1, &order, &slope) }
    }

    /// The derivative of Real variables in a direction, and the status.
    pub fn derivative(
        &self,
        unknowns: &[&str],
        knowns: &[&str],
        seed: &[f64],
    ) -> (fmi2Status, Vec<f64>) {
        let references = |names: &[&str]| -> Vec<u32> {
            names.iter().map(|name| self.reference(name)).collect()
        };
        let (unknowns, knowns) = (references(unknowns), references(knowns));
        let mut result = vec![f64::NAN; unknowns.len()];
        let status = unsafe {
            v2::fmi2GetDirectionalDerivative(
                self.c,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                result.as_mut_ptr(),
            )
        };
        (status, result)
    }

    /// The value of a Real variable; the call must succeed.
    pub fn real(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        let status = unsafe { v2::fmi2GetReal(self.c, &self.reference(name), 1, &mut value) };
        assert_eq!(status, fmi2OK, "{name}: {:?}", self.messages());
        value
    }

    /// The value of a Boolean variable; the call must succeed.
    pub fn boolean(&self, name: &str) -> fmi2Boolean {
        let mut value = -1;
        let status = unsafe { v2::fmi2GetBoolean(self.c, &self.reference(name), 1, &mut value) };
        assert_eq!(status, fmi2OK, "{name}: {:?}", self.messages());
        value
    }

    /// All messages so far.
    pub fn messages(&self) -> Vec<LoggedMessage> {
        self.recorder.0.lock().unwrap().clone()
    }

    /// The last message.
    pub fn last(&self) -> String {
        self.messages().last().map(|messages| messages.format.clone()).unwrap_or_default()
    }

    /// Saves the state.
    pub fn save(&self) -> fmi2FMUstate {
        let mut state = null_mut();
        assert_eq!(unsafe { v2::fmi2GetFMUstate(self.c, &mut state) }, fmi2OK);
        assert!(!state.is_null());
        state
    }

    pub fn restore(&self, state: fmi2FMUstate) -> fmi2Status {
        unsafe { v2::fmi2SetFMUstate(self.c, state) }
    }

    /// A saved state as bytes.
    pub fn bytes(&self, state: fmi2FMUstate) -> Vec<u8> {
        let mut size = 0;
        assert_eq!(unsafe { v2::fmi2SerializedFMUstateSize(self.c, state, &mut size) }, fmi2OK);
        let mut bytes = vec![0_u8; size];
        let pointer = bytes.as_mut_ptr().cast();
        let status = unsafe { v2::fmi2SerializeFMUstate(self.c, state, pointer, size) };
        assert_eq!(status, fmi2OK);
        bytes
    }

    /// A saved state from bytes.
    pub fn deserialize(&self, bytes: &[u8], state: &mut fmi2FMUstate) -> fmi2Status {
        let pointer = bytes.as_ptr().cast();
        unsafe { v2::fmi2DeSerializeFMUstate(self.c, pointer, bytes.len(), state) }
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        unsafe { v2::fmi2FreeInstance(self.c) }
    }
}

/// Small numbers in a repeatable order (xorshift).
pub struct Random(pub u64);

impl Random {
    /// A number from 0 (included) to 1 (not included).
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
