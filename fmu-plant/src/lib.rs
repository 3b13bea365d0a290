//! The plant FMU's binary
