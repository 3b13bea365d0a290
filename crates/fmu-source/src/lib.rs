//! The core of source-code FMUs: the functions of FMI 2.0 and 3.0, compiled to WebAssembly, which wasm2c
//! translates to C (`dev/tools/source-core`).
//!
//! All component types are in it, for plants and controllers; the bytes that `source::spec` makes of a blueprint
//! choose among them. What is around it, `crates/source/c/fmu.h`, copies arguments in and results out. Elsewhere
//! than on WebAssembly this crate is empty.
#![cfg(target_family = "wasm")]

use model::System;

fmi_bindings::export_fmi2!(crate::model_of_this_fmu);
fmi_bindings::export_fmi3!(crate::model_of_this_fmu);
fmi_bindings::export_core!(model_of_this_fmu, crate::build);

fn build(bytes: &[u8]) -> Result<System, String> {
    let spec = source::spec::from_bytes(bytes, learned::COMPONENTS)?;
    System::new(&spec)
        .map_err(|errors| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
}
