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
//! Not offered, though the original may: directional derivatives, derivatives of inputs and outputs
//! by time, event mode, clocks, early return, intermediate update, model exchange.

mod core;
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
