//! A model as a WebAssembly component: `wit/fmi3.wit` in front of the C functions of FMI 3.0.
//!
//! The component imports nothing but `callbacks`, so it can reach nothing else of its host. A panic is a trap, which
//! ends this component alone; its text goes to `log-message` first. The model's bytes are written into its [`Slot`] when
//! the FMU is packed.

mod calls;

use std::collections::BTreeMap;
use std::ffi::{CString, c_void};
use std::marker::PhantomData;
use std::path::Path;
use std::ptr::{null, null_mut};

use model::System;

use super::slot::Slot;
use super::v3;

/// What `wit/fmi3.wit` becomes.
#[allow(missing_docs, unreachable_pub, clippy::all, clippy::undocumented_unsafe_blocks)]
pub mod bindings {
    wit_bindgen::generate!({
        path: "wit",
        world: "co-simulation-fmu",
        pub_export_macro: true,
        default_bindings_module: "fmi_bindings::export::component::bindings",
    });
}

use self::bindings::exports::fmi::fmi3::{co_simulation, common};
use self::calls::{answer, begin, plain, status_of, tell, values};
pub(super) use self::calls::{panicked, say};
use co_simulation::{
    CoSimulationInstance, DiscreteStatesInfo, DoStepResult, IntervalFraction, IntervalQualifier,
    Status, VariableDependency,
};

/// A library's model.
pub trait Model: 'static {
    /// The place of its bytes.
    fn slot() -> &'static Slot;
    /// Makes it of its bytes.
    ///
    /// # Errors
    /// What is wrong with them.
    fn build(bytes: &[u8]) -> Result<System, String>;
}

fn build<M: Model>(_resources: &Path) -> Result<System, String> {
    M::build(M::slot().model().ok_or("the component has no model")?)
}

/// A function of FMI 3.0 that no FMU of this library offers is called for its message and status.
const NOTHING: usize = 0;

/// The library's functions.
pub struct Component<M>(PhantomData<M>);

impl<M: Model> common::Guest for Component<M> {
    fn get_version() -> String {
        "3.0".to_owned()
    }
}

impl<M: Model> co_simulation::Guest for Component<M> {
    type CoSimulationInstance = Instance<M>;
}

/// One instance.
pub struct Instance<M> {
    model: PhantomData<M>,
    name: String,
    handle: *mut c_void,
    /// Number of values of each array; all other variables have one.
    sizes: BTreeMap<u32, usize>,
}

impl<M> Drop for Instance<M> {
    fn drop(&mut self) {
        // SAFETY: the handle of this instance, which ends here.
        unsafe { v3::fmi3FreeInstance(self.handle) }
    }
}

impl<M> Instance<M> {
    /// The handle, right before a call.
    fn handle(&self) -> *mut c_void {
        begin(&self.name);
        self.handle
    }

    /// Number of values of these variables.
    fn size(&self, references: &[u32]) -> usize {
        references.iter().map(|reference| self.sizes.get(reference).copied().unwrap_or(1)).sum()
    }
}

impl<M: Model> co_simulation::GuestCoSimulationInstance for Instance<M> {
    values! {
        get_float32 fmi3GetFloat32 set_float32 fmi3SetFloat32 f32;
        get_float64 fmi3GetFloat64 set_float64 fmi3SetFloat64 f64;
        get_int8 fmi3GetInt8 set_int8 fmi3SetInt8 i8;
        get_int16 fmi3GetInt16 set_int16 fmi3SetInt16 i16;
        get_int32 fmi3GetInt32 set_int32 fmi3SetInt32 i32;
        get_int64 fmi3GetInt64 set_int64 fmi3SetInt64 i64;
        get_uint8 fmi3GetUInt8 set_uint8 fmi3SetUInt8 u8;
        get_uint16 fmi3GetUInt16 set_uint16 fmi3SetUInt16 u16;
        get_uint32 fmi3GetUInt32 set_uint32 fmi3SetUInt32 u32;
        get_uint64 fmi3GetUInt64 set_uint64 fmi3SetUInt64 u64;
        get_boolean fmi3GetBoolean set_boolean fmi3SetBoolean bool;
    }

    plain! {
        exit_initialization_mode fmi3ExitInitializationMode;
        enter_event_mode fmi3EnterEventMode;
        terminate fmi3Terminate;
        reset fmi3Reset;
        enter_configuration_mode fmi3EnterConfigurationMode;
        exit_configuration_mode fmi3ExitConfigurationMode;
        evaluate_discrete_states fmi3EvaluateDiscreteStates;
        enter_step_mode fmi3EnterStepMode;
    }

    fn instantiate_co_simulation(
        name: String,
        token: String,
        resources: String,
        visible: bool,
        logging_on: bool,
        event_mode_used: bool,
        early_return_allowed: bool,
        required: Vec<u32>,
    ) -> Option<CoSimulationInstance> {
        begin(&name);
        super::install_panic_hook();
        // A text of the component model may hold zero bytes; the C edge says what is wrong with a cut one.
        let text = |text: &str| CString::new(text.split('\0').next().unwrap_or("")).ok();
        let (c_name, c_token, c_path) = (text(&name)?, text(&token)?, text(&resources)?);
        // SAFETY: texts and an array that live until the call returns.
        let handle = unsafe {
            v3::fmi3InstantiateCoSimulation(
                build::<M>,
                c_name.as_ptr(),
                c_token.as_ptr(),
                c_path.as_ptr(),
                visible,
                logging_on,
                event_mode_used,
                early_return_allowed,
                required.as_ptr(),
                required.len(),
                null_mut(),
                None,
                None,
            )
        };
        if handle.is_null() {
            return None;
        }
        let arrays = build::<M>(Path::new("")).map(|system| system.variables().bundles());
        let sizes = arrays.into_iter().flatten().filter(|bundle| bundle.is_array);
        let sizes = sizes.map(|bundle| (bundle.elements[0], bundle.elements.len())).collect();
        Some(CoSimulationInstance::new(Self { model: PhantomData, name, handle, sizes }))
    }

    fn set_debug_logging(&self, logging_on: bool, categories: Vec<String>) -> Status {
        let categories: Vec<_> =
            categories.into_iter().filter_map(|text| CString::new(text).ok()).collect();
        let pointers: Vec<_> = categories.iter().map(|text| text.as_ptr()).collect();
        // SAFETY: texts that live until the call returns.
        status_of(unsafe {
            v3::fmi3SetDebugLogging(self.handle(), logging_on, pointers.len(), pointers.as_ptr())
        })
    }

    fn enter_initialization_mode(
        &self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Status {
        // SAFETY: the handle of this instance.
        status_of(unsafe {
            v3::fmi3EnterInitializationMode(
                self.handle(),
                tolerance.is_some(),
                tolerance.unwrap_or(0.0),
                start,
                stop.is_some(),
                stop.unwrap_or(0.0),
            )
        })
    }

    fn update_discrete_states(&self) -> Result<DiscreteStatesInfo, Status> {
        let none = null_mut();
        // SAFETY: refused before anything is written.
        let status = unsafe {
            v3::fmi3UpdateDiscreteStates(self.handle(), none, none, none, none, none, null_mut())
        };
        Err(status_of(status))
    }

    fn get_string(&self, references: Vec<u32>) -> Result<Vec<String>, Status> {
        // SAFETY: there are no such variables, so nothing is written.
        let status = unsafe {
            v3::fmi3GetString(
                self.handle(),
                references.as_ptr(),
                references.len(),
                null_mut(),
                NOTHING,
            )
        };
        answer(status, Vec::new())
    }

    fn get_binary(&self, references: Vec<u32>) -> Result<Vec<Vec<u8>>, Status> {
        let (at, length) = (references.as_ptr(), references.len());
        // SAFETY: there are no such variables, so nothing is written.
        let status = unsafe {
            v3::fmi3GetBinary(self.handle(), at, length, null_mut(), null_mut(), NOTHING)
        };
        answer(status, Vec::new())
    }

    fn get_clock(&self, references: Vec<u32>) -> Result<Vec<bool>, Status> {
        // SAFETY: refused before anything is written.
        let status = unsafe {
            v3::fmi3GetClock(self.handle(), references.as_ptr(), references.len(), null_mut())
        };
        answer(status, Vec::new())
    }

    fn set_string(&self, references: Vec<u32>, _values: Vec<String>) -> Status {
        // SAFETY: there are no such variables, so nothing is read.
        status_of(unsafe {
            v3::fmi3SetString(self.handle(), references.as_ptr(), references.len(), null(), NOTHING)
        })
    }

    fn set_binary(&self, references: Vec<u32>, _values: Vec<Vec<u8>>) -> Status {
        let (at, length) = (references.as_ptr(), references.len());
        // SAFETY: there are no such variables, so nothing is read.
        status_of(unsafe { v3::fmi3SetBinary(self.handle(), at, length, null(), null(), NOTHING) })
    }

    fn set_clock(&self, references: Vec<u32>, _values: Vec<bool>) -> Status {
        // SAFETY: refused before anything is read.
        status_of(unsafe {
            v3::fmi3SetClock(self.handle(), references.as_ptr(), references.len(), null())
        })
    }

    fn get_number_of_variable_dependencies(&self, reference: u32) -> Result<u64, Status> {
        // SAFETY: refused before anything is written.
        let status = unsafe {
            v3::fmi3GetNumberOfVariableDependencies(self.handle(), reference, null_mut())
        };
        answer(status, 0)
    }

    fn get_variable_dependencies(&self, dependent: u32) -> Result<Vec<VariableDependency>, Status> {
        let handle = self.handle();
        // SAFETY: refused before anything is written.
        let status = unsafe {
            v3::fmi3GetVariableDependencies(
                handle,
                dependent,
                null_mut(),
                null_mut(),
                null_mut(),
                null_mut(),
                NOTHING,
            )
        };
        answer(status, Vec::new())
    }

    fn get_fmu_state(&self) -> Result<Vec<u8>, Status> {
        let (handle, mut state, mut size) = (self.handle(), null_mut(), 0);
        // SAFETY: the state that the first call makes lives until the last one.
        unsafe {
            answer(v3::fmi3GetFMUState(handle, &raw mut state), ())?;
            let mut bytes = Vec::new();
            let mut status = v3::fmi3SerializedFMUStateSize(handle, state, &raw mut size);
            if status.0 == 0 {
                bytes.resize(size, 0);
                status = v3::fmi3SerializeFMUState(handle, state, bytes.as_mut_ptr(), size);
            }
            answer(v3::fmi3FreeFMUState(handle, &raw mut state), ())?;
            answer(status, bytes)
        }
    }

    fn set_fmu_state(&self, bytes: Vec<u8>) -> Status {
        let (handle, mut state) = (self.handle(), null_mut());
        // SAFETY: as above.
        unsafe {
            let built =
                v3::fmi3DeserializeFMUState(handle, bytes.as_ptr(), bytes.len(), &raw mut state);
            if built.0 > 1 {
                return status_of(built);
            }
            let status = status_of(v3::fmi3SetFMUState(handle, state));
            match answer(v3::fmi3FreeFMUState(handle, &raw mut state), ()) {
                Ok(()) => status,
                Err(status) => status,
            }
        }
    }

    fn get_directional_derivative(
        &self,
        unknowns: Vec<u32>,
        knowns: Vec<u32>,
        seed: Vec<f64>,
    ) -> Result<Vec<f64>, Status> {
        let mut values = vec![0.0; self.size(&unknowns)];
        // SAFETY: arrays of the lengths given.
        let status = unsafe {
            v3::fmi3GetDirectionalDerivative(
                self.handle(),
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                seed.len(),
                values.as_mut_ptr(),
                values.len(),
            )
        };
        answer(status, values)
    }

    fn get_adjoint_derivative(
        &self,
        unknowns: Vec<u32>,
        knowns: Vec<u32>,
        seed: Vec<f64>,
    ) -> Result<Vec<f64>, Status> {
        // SAFETY: refused before anything is written.
        let status = unsafe {
            v3::fmi3GetAdjointDerivative(
                self.handle(),
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                seed.len(),
                null_mut(),
                NOTHING,
            )
        };
        answer(status, Vec::new())
    }

    fn get_interval_decimal(&self, r: Vec<u32>) -> Result<Vec<(f64, IntervalQualifier)>, Status> {
        let (at, length) = (r.as_ptr(), r.len());
        // SAFETY: refused before anything is written.
        let status = unsafe {
            v3::fmi3GetIntervalDecimal(self.handle(), at, length, null_mut(), null_mut())
        };
        answer(status, Vec::new())
    }

    fn get_interval_fraction(
        &self,
        r: Vec<u32>,
    ) -> Result<Vec<(IntervalFraction, IntervalQualifier)>, Status> {
        let (at, length) = (r.as_ptr(), r.len());
        // SAFETY: refused before anything is written.
        let status = unsafe {
            v3::fmi3GetIntervalFraction(
                self.handle(),
                at,
                length,
                null_mut(),
                null_mut(),
                null_mut(),
            )
        };
        answer(status, Vec::new())
    }

    fn get_shift_decimal(&self, r: Vec<u32>) -> Result<Vec<f64>, Status> {
        // SAFETY: refused before anything is written.
        let status =
            unsafe { v3::fmi3GetShiftDecimal(self.handle(), r.as_ptr(), r.len(), null_mut()) };
        answer(status, Vec::new())
    }

    fn get_shift_fraction(&self, r: Vec<u32>) -> Result<Vec<IntervalFraction>, Status> {
        let (at, length) = (r.as_ptr(), r.len());
        // SAFETY: refused before anything is written.
        let status =
            unsafe { v3::fmi3GetShiftFraction(self.handle(), at, length, null_mut(), null_mut()) };
        answer(status, Vec::new())
    }

    fn set_interval_decimal(&self, r: Vec<u32>, _intervals: Vec<f64>) -> Status {
        // SAFETY: refused before anything is read.
        status_of(unsafe { v3::fmi3SetIntervalDecimal(self.handle(), r.as_ptr(), r.len(), null()) })
    }

    fn set_interval_fraction(&self, r: Vec<u32>, _intervals: Vec<IntervalFraction>) -> Status {
        let (at, length) = (r.as_ptr(), r.len());
        // SAFETY: refused before anything is read.
        status_of(unsafe { v3::fmi3SetIntervalFraction(self.handle(), at, length, null(), null()) })
    }

    fn set_shift_decimal(&self, r: Vec<u32>, _shifts: Vec<f64>) -> Status {
        // SAFETY: refused before anything is read.
        status_of(unsafe { v3::fmi3SetShiftDecimal(self.handle(), r.as_ptr(), r.len(), null()) })
    }

    fn set_shift_fraction(&self, r: Vec<u32>, _shifts: Vec<IntervalFraction>) -> Status {
        let (at, length) = (r.as_ptr(), r.len());
        // SAFETY: refused before anything is read.
        status_of(unsafe { v3::fmi3SetShiftFraction(self.handle(), at, length, null(), null()) })
    }

    fn set_input_derivatives(&self, requests: Vec<(u32, u32)>, values: Vec<f64>) -> Status {
        let _ = (requests, values);
        tell(
            Status::Error,
            "logStatusError",
            "set-input-derivatives: is not part of FMI 3.0; inputs are held over a step",
        );
        Status::Error
    }

    fn get_output_derivatives(&self, requests: Vec<(u32, u32)>) -> Result<Vec<f64>, Status> {
        let (references, orders): (Vec<u32>, Vec<i32>) =
            requests.into_iter().map(|(reference, order)| (reference, order.cast_signed())).unzip();
        let mut values = vec![0.0; self.size(&references)];
        // SAFETY: arrays of the lengths given.
        let status = unsafe {
            v3::fmi3GetOutputDerivatives(
                self.handle(),
                references.as_ptr(),
                references.len(),
                orders.as_ptr(),
                values.as_mut_ptr(),
                values.len(),
            )
        };
        answer(status, values)
    }

    fn do_step(&self, at: f64, step: f64, no_state_before: bool) -> Result<DoStepResult, Status> {
        let (mut events, mut end, mut early, mut last) = (false, false, false, at);
        // SAFETY: room for one value each.
        let status = unsafe {
            v3::fmi3DoStep(
                self.handle(),
                at,
                step,
                no_state_before,
                &raw mut events,
                &raw mut end,
                &raw mut early,
                &raw mut last,
            )
        };
        let done = DoStepResult {
            last_successful_time: last,
            event_handling_needed: events,
            terminate_simulation: end,
            early_return: early,
        };
        answer(status, done)
    }
}

/// Exports a component whose model `$build` (`fn(&[u8]) -> Result<System, String>`) makes of bytes.
#[macro_export]
macro_rules! export_component {
    ($build:path) => {
        static SLOT: $crate::export::slot::Slot = $crate::export::slot::Slot::EMPTY;

        struct ThisModel;

        impl $crate::export::component::Model for ThisModel {
            fn slot() -> &'static $crate::export::slot::Slot {
                &SLOT
            }

            fn build(bytes: &[u8]) -> Result<::model::System, String> {
                $build(bytes)
            }
        }

        type ThisComponent = $crate::export::component::Component<ThisModel>;
        $crate::export::component::bindings::export!(ThisComponent with_types_in $crate::export::component::bindings);
    };
}
