//! The papers' tables on machines that could be theirs.
//!
//! [`matching`] compares the machines with what the papers print of theirs, without the papers' methods;
//! [`reproduce`] runs the methods: the models here, the controllers through packed FMUs, which a [`Tool`]
//! packs; [`page`] shows both, and [`keep`] has what others may run of it.

pub mod keep;
pub mod machines;
pub mod matching;
pub mod page;
pub mod reproduce;

use std::path::Path;

use data::Blueprint;

pub use reproduce::control::Bed;

/// What the control experiments need of the tool that runs them: it carries the FMUs' libraries.
#[derive(Clone, Copy)]
pub struct Tool {
    /// Puts the FMU of a rig, by its name, on the bench.
    pub open: fn(&Path) -> anyhow::Result<Bed>,
    /// Identifies with these arguments of `piezoloop identify`, which name the blueprint that it writes.
    pub identify: fn(&[&str]) -> anyhow::Result<()>,
}

/// Writes the FMU of a blueprint.
pub type Pack = fn(&Blueprint, &Path) -> anyhow::Result<()>;
