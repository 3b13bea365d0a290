//! The master: connect FMUs, step them, record
