//! An FMU's WebAssembly component.

use std::io::Read as _;

use model::SystemSpec;

use crate::spec;

/// The component without a model, packed; `dev/tools/wasm-component` makes it.
const COMPONENT: &[u8] = include_bytes!("../wasm/component.wasm.gz");

/// The component of one model: it exports the functions of FMI 3.0 for co-simulation and imports the importer's
/// callbacks alone.
///
/// # Errors
/// The model cannot be written as bytes, or is larger than the component's place for it.
pub fn component(spec: &SystemSpec) -> Result<Vec<u8>, String> {
    let mut component = Vec::new();
    flate2::read::GzDecoder::new(COMPONENT).read_to_end(&mut component).map_err(|error| {
        format!("the WebAssembly component in this program is damaged: {error}")
    })?;
    fmi_bindings::export::slot::put(&mut component, &spec::to_bytes(spec)?)?;
    Ok(component)
}
