//! The C edge of FMI, both ways: export of a model, import of any FMU
//!
//! The only crate with `unsafe` code; each block says why it is sound.
#![allow(unsafe_code)]

pub mod export;
pub mod fmi2;
pub mod fmi3;
pub mod import;
