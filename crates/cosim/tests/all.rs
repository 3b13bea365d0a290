//! The tests of the master.
//! One program: it links once, and its tests share the processors to the end.

#[macro_use]
mod common;
mod coupling;
mod events;
mod failures;
mod fmi3;
mod fmpy;
mod foreign_systems;
mod initialization;
mod instances;
mod one_fmu;
mod plan;
mod system;
