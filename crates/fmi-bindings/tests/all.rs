//! The tests of the edge of an exported FMU that need no process of their own.
//! One program: it links once, and its tests share the processors to the end.
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each block calls the edge as an importer does, by the standard's contract"
)]

mod support;

mod export_arrays;
mod export_call_table;
mod export_derivatives;
mod export_importers;
mod export_lives;
mod export_log;
mod export_slopes;
mod export_states;
mod export_steps;
mod export_v3;
mod export_values;
