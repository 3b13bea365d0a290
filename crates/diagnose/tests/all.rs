//! The tests of the diagnosis.
//! One program: it links once, and its tests share the processors to the end.

mod answer;
mod between;
mod common;
mod coupled;
mod evidence;
mod experiment;
mod hardening;
mod interval;
mod names;
mod place;
mod real_data;
mod repair;
mod same_model;
mod within;
