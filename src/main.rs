//! The tool `piezoloop`.
fn main() {}
