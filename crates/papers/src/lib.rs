//! The papers' tables on machines that could be theirs.
//!
//! [`matching`] compares the machines with what the papers print of theirs, without the papers' methods;
//! [`reproduce`] runs the methods: the models here, the controllers through packed FMUs, which a [`Tool`]
//! packs; [`page`] shows both, and [`keep`] has what others may run of it.

pub mod keep;
pub mod machines;
pub mod matching;
pub mod page;
pub mod reproduce;
mod tool;

pub use reproduce::control::Bed;
pub use tool::Tool;
