//! The tests of identification.
//! One program: it links once, and its tests share the processors to the end.

mod common;
mod frequency;
mod linear;
mod methods;
mod real_pea;
mod recovery;
