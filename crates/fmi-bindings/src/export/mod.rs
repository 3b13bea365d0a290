//! Export: a [`System`] behind the C functions of the standard.
//!
//! ```text
//! symbols of the library ── v2 ┐                       ┌ call table (phase)   ┌ Logger
//!  (export_fmi2!)           v3 ┴── guard (unwinding) ──┴── Instance ── System ┴ saved states
//! ```
//!
//! [`Instance`] knows no version of the standard: it is the state machine, the rules of setting and
//! getting, time, saved states. `v2` (and every other edge) only turns C arguments into slices and
//! its outcome into a status. Which function may be called when is a table in each edge.
//!
//! Strict on writes and on the order of calls, lenient on reads: in a state in which values may be
//! read at all, every known variable is answered.

mod arguments;
#[cfg(all(target_family = "wasm", feature = "component"))]
pub mod component;
#[cfg(test)]
mod forced_panic_tests;
mod guard;
#[cfg(target_family = "wasm")]
mod host;
mod instance;
#[cfg(not(target_family = "wasm"))]
mod library;
mod log;
mod notice;
mod old_glibc;
mod phase;
mod progress;
mod resources;
mod saved;
pub mod slot;
mod state_calls;
pub mod v2;
pub mod v3;
#[cfg(all(feature = "wrap", not(target_family = "wasm")))]
pub mod wrap;

use std::path::Path;

use model::System;

pub use guard::install_panic_hook;
pub use instance::Instance;
#[cfg(not(target_family = "wasm"))]
pub use library::Library;
pub use phase::{Phase, Rule};

/// Makes the model of a new instance from the folder of the FMU's resources.
///
/// It is called at each instantiation, with a folder that holds [`BLUEPRINT`]. The error is the
/// message that the importer's user sees.
pub type Factory = fn(resources: &Path) -> Result<System, String>;

/// The file that the folder of the resources must hold.
pub const BLUEPRINT: &str = "blueprint.toml";

/// The log categories, each with its description, for the model description. The first four are
/// the categories of messages; `logAll` stands for all of them.
pub const LOG_CATEGORIES: [(&str, &str); 5] = [
    ("logEvents", "Instantiation, initialisation, reset, termination"),
    ("logStatusWarning", "Calls that are answered although they break a rule"),
    ("logStatusDiscard", "Inquiries that cannot be answered"),
    ("logStatusError", "Calls that are refused: variable, value, rule and how to fix it"),
    ("logAll", "All messages"),
];
