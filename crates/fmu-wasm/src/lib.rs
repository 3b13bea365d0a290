//! The WebAssembly component of FMUs by the draft of the layered standard FMI-LS-WASM: all component types, for plants
//! and controllers; the bytes that `source::spec` makes of a blueprint choose among them (`dev/tools/wasm-component`).
//! Elsewhere than on WebAssembly this crate is empty.
#![cfg(target_family = "wasm")]

fmi_bindings::export_component!(crate::build);

fn build(bytes: &[u8]) -> Result<model::System, String> {
    let spec = source::spec::from_bytes(bytes, learned::COMPONENTS)?;
    model::System::new(&spec)
        .map_err(|errors| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
}
