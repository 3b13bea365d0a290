//! The binary of a repaired FMU: the standard's functions, and nothing else that a host could see.
//!
//! It is the same for every repair; `repair.toml` in the FMU's resources says what is put around the
//! original, which lies unpacked beside it in `inner/`.

fmi_bindings::old_glibc!();
fmi_bindings::old_glibc_loader!();
fmi_bindings::wrap_fmi2!();
fmi_bindings::wrap_fmi3!();
