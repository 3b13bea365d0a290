//! The test bench: runs a controller FMU in real time next to a machine, and plays the machine.
//!
//! ```text
//! Plan ─┐                 ┌────────── Runner: absolute deadlines, one Cycle each ──────────┐
//!       ├─▶ Cycle ───────▶│ Gateway ▶ Receiver ▶ Monitor ▶ next(State) ▶ Controller FMU    │
//! FMU ──┘                 │                           Gateway ◀ packet ◀ Shaper ◀──────────┘
//!                         └─▶ row ─▶ ring buffer ─▶ Journal (survives a kill) ─▶ log file
//!                                               └─▶ live view
//! Emulator: Gateway ▶ faults ▶ plant FMU ▶ faults ▶ Gateway
//! ```
//!
//! The cycle allocates nothing and takes no lock; recording and display are other threads behind a
//! ring buffer of one producer and one consumer. The state machine of [`safety`] is a pure function.
//!
//! Row k of a record: the command u_k is sent at t_k and acts until t_{k+1}; the position y_k was
//! received at t_k, before u_k was computed. [`replay`] steps the controller through such rows again.

pub mod campaign;
pub mod clock;
pub mod cycle;
pub mod emulate;
pub mod gateway;
pub mod live;
pub mod packet;
pub mod plan;
mod plant;
pub mod receive;
pub mod record;
pub mod replay;
pub mod runner;
pub mod safety;
pub mod virtual_run;
