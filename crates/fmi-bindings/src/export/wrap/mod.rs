//! A repaired FMU: another FMU behind the C functions, with effects before and behind it.
//!
//! ```text
//! symbols of the library ── v2 ┐           ┌ Surround (effects, the repair's own variables)
//!  (wrap_fmi2!)             v3 ┴── Wrapped ┴ the original's library (import)
//! ```
//!
//! What the repair does not touch goes through as the host calls it: same value references, same
//! values, same messages. With all effects switched off the host talks to the original. The original
//! lies unpacked in `resources/inner/`; its library is loaded from there by its absolute path, so
//! that each unpacked copy of the repaired FMU has an original of its own.
//!
//! Directional derivatives are offered where the original offers them, by the chain rule. Not offered,
//! though the original may:
//!
//! * derivatives of inputs and outputs by time: effects hold their inputs over a step, and an effect
//!   with memory has no slope of its own at a communication point;
//! * adjoint derivatives: at the kinks of effects the derivative is not linear in the direction;
//! * event mode: an original that has it must also run without (FMI 3.0 §4.2.1, `eventModeUsed =
//!   fmi3False`), and then handles its events itself; it does so here. An FMU with clocks cannot, and is
//!   not repaired;
//! * early return and intermediate update: effects are known at the end of a step only;
//! * model exchange and scheduled execution: effects step.

mod core;
mod derivative;
mod file;
mod state_calls;
pub mod v2;
pub mod v3;

/// Exports the functions of FMI 2.0 from a library for a repaired FMU. To be used once, in a
/// `cdylib`.
#[macro_export]
macro_rules! wrap_fmi2 {
    () => {
        $crate::fmi2_symbols! { $crate::export::wrap::v2, }
    };
}

/// Exports the functions of FMI 3.0 from a library for a repaired FMU. To be used once, in a
/// `cdylib`.
#[macro_export]
macro_rules! wrap_fmi3 {
    () => {
        $crate::fmi3_symbols! { $crate::export::wrap::v3, }
    };
}
