//! A first-order lag T·y' = k·u − y as a component of FMI-LS-WASM, written by hand against the interface, not by this
//! project's tool: the component in `lag.fmu`. `mode` makes it misbehave in its steps after time 0.
//!
//! Made with `crates/fmi-bindings/wit` beside it: wit-bindgen 0.46, `cargo build --release --target wasm32-unknown-unknown`
//! (opt-level s, lto, panic = abort), then the `ComponentEncoder` of wit-component 0.236.
use std::cell::RefCell;
wit_bindgen::generate!({ path: "fmi3.wit", world: "co-simulation-fmu" });
use exports::fmi::fmi3::{co_simulation::*, common};
use fmi::fmi3::callbacks::log_message;
struct Lag;
export!(Lag);
impl common::Guest for Lag { fn get_version() -> String { "3.0".into() } }
impl Guest for Lag { type CoSimulationInstance = One; }
#[derive(Clone, Copy)]
struct All { u: f64, k: f64, t: f64, y: f64, mode: u32, time: f64 }
const START: All = All { u: 0.0, k: 2.0, t: 0.01, y: 0.0, mode: 0, time: 0.0 };
struct One { name: String, all: RefCell<All>, hoard: RefCell<Vec<Vec<u8>>> }
impl One { fn say(&self, text: &str) { log_message(&self.name, Status::Error, "logStatusError", text) } }
impl GuestCoSimulationInstance for One {
    fn instantiate_co_simulation(name: String, token: String, _: String, _: bool, _: bool, _: bool, _: bool, _: Vec<u32>) -> Option<CoSimulationInstance> {
        if token != "{lag-by-hand}" { log_message(&name, Status::Error, "logStatusError", "another token"); return None; }
        Some(CoSimulationInstance::new(One { name, all: RefCell::new(START), hoard: RefCell::default() }))
    }
    fn set_debug_logging(&self, _: bool, _: Vec<String>) -> Status { Status::Ok }
    fn enter_initialization_mode(&self, _: Option<f64>, start: f64, _: Option<f64>) -> Status { self.all.borrow_mut().time = start; Status::Ok }
    fn exit_initialization_mode(&self) -> Status { Status::Ok }
    fn terminate(&self) -> Status { Status::Ok }
    fn reset(&self) -> Status { *self.all.borrow_mut() = START; Status::Ok }
    fn get_float64(&self, refs: Vec<u32>) -> Result<Vec<f64>, Status> {
        let all = self.all.borrow();
        refs.iter().map(|r| Ok(match r { 0 => all.time, 1 => all.u, 2 => all.k, 3 => all.t, 4 => all.y, _ => return Err(Status::Error) })).collect()
    }
    fn set_float64(&self, refs: Vec<u32>, values: Vec<f64>) -> Status {
        let mut all = self.all.borrow_mut();
        for (r, v) in refs.iter().zip(values) {
            match r { 1 => all.u = v, 2 => all.k = v, 3 if v > 0.0 => all.t = v,
                3 => { self.say("T must be positive"); return Status::Error }
                _ => { self.say("no such variable"); return Status::Error } }
        }
        Status::Ok
    }
    fn get_uint32(&self, refs: Vec<u32>) -> Result<Vec<u32>, Status> { Ok(refs.iter().map(|_| self.all.borrow().mode).collect()) }
    fn set_uint32(&self, _: Vec<u32>, values: Vec<u32>) -> Status { if let Some(v) = values.last() { self.all.borrow_mut().mode = *v } Status::Ok }
    fn get_fmu_state(&self) -> Result<Vec<u8>, Status> {
        let a = self.all.borrow();
        Ok([a.u, a.k, a.t, a.y, a.mode as f64, a.time].iter().flat_map(|x| x.to_le_bytes()).collect())
    }
    fn set_fmu_state(&self, state: Vec<u8>) -> Status {
        let x: Vec<f64> = state.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
        let [u, k, t, y, mode, time] = x[..] else { self.say("a state of another length"); return Status::Error };
        *self.all.borrow_mut() = All { u, k, t, y, mode: mode as u32, time }; Status::Ok
    }
    fn do_step(&self, now: f64, h: f64, _: bool) -> Result<DoStepResult, Status> {
        let mode = self.all.borrow().mode;
        if now > 0.0 { match mode {
            1 => loop { std::hint::black_box(0); },
            2 => loop { self.hoard.borrow_mut().push(vec![1; 1 << 20]) },
            3 => std::process::abort(),
            4 => { self.say("the lag refuses this step"); return Err(Status::Error) }
            _ => {} } }
        let mut a = self.all.borrow_mut();
        let share = 1.0 - (1.0 - h / a.t / 64.0).powi(64);
        a.y += share * (a.k * a.u - a.y);
        a.time = now + h;
        Ok(DoStepResult { last_successful_time: a.time, event_handling_needed: false, terminate_simulation: false, early_return: false })
    }
    fn enter_event_mode(&self) -> Status { Status::Error }
    fn update_discrete_states(&self) -> Result<DiscreteStatesInfo, Status> { Err(Status::Error) }
    fn enter_configuration_mode(&self) -> Status { Status::Error }
    fn exit_configuration_mode(&self) -> Status { Status::Error }
    fn get_float32(&self, _: Vec<u32>) -> Result<Vec<f32>, Status> { Err(Status::Error) }
    fn get_int8(&self, _: Vec<u32>) -> Result<Vec<i8>, Status> { Err(Status::Error) }
    fn get_int16(&self, _: Vec<u32>) -> Result<Vec<i16>, Status> { Err(Status::Error) }
    fn get_int32(&self, _: Vec<u32>) -> Result<Vec<i32>, Status> { Err(Status::Error) }
    fn get_int64(&self, _: Vec<u32>) -> Result<Vec<i64>, Status> { Err(Status::Error) }
    fn get_uint8(&self, _: Vec<u32>) -> Result<Vec<u8>, Status> { Err(Status::Error) }
    fn get_uint16(&self, _: Vec<u32>) -> Result<Vec<u16>, Status> { Err(Status::Error) }
    fn get_uint64(&self, _: Vec<u32>) -> Result<Vec<u64>, Status> { Err(Status::Error) }
    fn get_boolean(&self, _: Vec<u32>) -> Result<Vec<bool>, Status> { Err(Status::Error) }
    fn get_string(&self, _: Vec<u32>) -> Result<Vec<String>, Status> { Err(Status::Error) }
    fn get_binary(&self, _: Vec<u32>) -> Result<Vec<Vec<u8>>, Status> { Err(Status::Error) }
    fn get_clock(&self, _: Vec<u32>) -> Result<Vec<bool>, Status> { Err(Status::Error) }
    fn set_float32(&self, _: Vec<u32>, _: Vec<f32>) -> Status { Status::Error }
    fn set_int8(&self, _: Vec<u32>, _: Vec<i8>) -> Status { Status::Error }
    fn set_int16(&self, _: Vec<u32>, _: Vec<i16>) -> Status { Status::Error }
    fn set_int32(&self, _: Vec<u32>, _: Vec<i32>) -> Status { Status::Error }
    fn set_int64(&self, _: Vec<u32>, _: Vec<i64>) -> Status { Status::Error }
    fn set_uint8(&self, _: Vec<u32>, _: Vec<u8>) -> Status { Status::Error }
    fn set_uint16(&self, _: Vec<u32>, _: Vec<u16>) -> Status { Status::Error }
    fn set_uint64(&self, _: Vec<u32>, _: Vec<u64>) -> Status { Status::Error }
    fn set_boolean(&self, _: Vec<u32>, _: Vec<bool>) -> Status { Status::Error }
    fn set_string(&self, _: Vec<u32>, _: Vec<String>) -> Status { Status::Error }
    fn set_binary(&self, _: Vec<u32>, _: Vec<Vec<u8>>) -> Status { Status::Error }
    fn set_clock(&self, _: Vec<u32>, _: Vec<bool>) -> Status { Status::Error }
    fn get_number_of_variable_dependencies(&self, _: u32) -> Result<u64, Status> { Err(Status::Error) }
    fn get_variable_dependencies(&self, _: u32) -> Result<Vec<VariableDependency>, Status> { Err(Status::Error) }
    fn get_directional_derivative(&self, _: Vec<u32>, _: Vec<u32>, _: Vec<f64>) -> Result<Vec<f64>, Status> { Err(Status::Error) }
    fn get_adjoint_derivative(&self, _: Vec<u32>, _: Vec<u32>, _: Vec<f64>) -> Result<Vec<f64>, Status> { Err(Status::Error) }
    fn get_interval_decimal(&self, _: Vec<u32>) -> Result<Vec<(f64, IntervalQualifier)>, Status> { Err(Status::Error) }
    fn get_interval_fraction(&self, _: Vec<u32>) -> Result<Vec<(IntervalFraction, IntervalQualifier)>, Status> { Err(Status::Error) }
    fn get_shift_decimal(&self, _: Vec<u32>) -> Result<Vec<f64>, Status> { Err(Status::Error) }
    fn get_shift_fraction(&self, _: Vec<u32>) -> Result<Vec<IntervalFraction>, Status> { Err(Status::Error) }
    fn set_interval_decimal(&self, _: Vec<u32>, _: Vec<f64>) -> Status { Status::Error }
    fn set_interval_fraction(&self, _: Vec<u32>, _: Vec<IntervalFraction>) -> Status { Status::Error }
    fn set_shift_decimal(&self, _: Vec<u32>, _: Vec<f64>) -> Status { Status::Error }
    fn set_shift_fraction(&self, _: Vec<u32>, _: Vec<IntervalFraction>) -> Status { Status::Error }
    fn evaluate_discrete_states(&self) -> Status { Status::Error }
    fn set_input_derivatives(&self, _: Vec<(u32, u32)>, _: Vec<f64>) -> Status { Status::Error }
    fn get_output_derivatives(&self, _: Vec<(u32, u32)>) -> Result<Vec<f64>, Status> { Err(Status::Error) }
    fn enter_step_mode(&self) -> Status { Status::Error }
}
