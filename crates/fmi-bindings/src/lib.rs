//! The C edge of FMI, both ways: export of a model, import of any FMU
//!
//! The only crate of the program with `unsafe` code (the other one, `counting`, is for tests); each
//! block says why it is sound.

#[cfg(feature = "export")]
pub mod export;
pub mod fmi2;
pub mod fmi3;
#[cfg(all(feature = "import", not(target_family = "wasm")))]
pub mod import;
