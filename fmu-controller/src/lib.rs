//! The controller FMU's binary
