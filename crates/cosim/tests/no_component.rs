//! A build without WebAssembly says of a component what to do.
#![cfg(not(feature = "wasm"))]

use std::path::Path;

#[test]
fn a_component_is_refused_with_the_way_out() {
    let components = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fmus/components");
    let message = cosim::Fmu::open(components.join("lag.fmu")).err().unwrap().to_string();
    assert!(message.contains("FMU `lag`") && message.contains("--features wasm"), "{message}");
}
