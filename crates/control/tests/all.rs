//! The tests of controllers.
//! One program: it links once, and its tests share the processors to the end.

#[path = "../../identify/tests/common/mod.rs"]
mod common;
mod control;
mod coupled;
mod damping;
mod every_plant;
mod learned_control;
mod responses;
