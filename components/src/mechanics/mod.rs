//! Moving mass, flexures, guides and load.

mod mode;

pub use mode::Mode;
