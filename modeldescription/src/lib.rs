//! FMI model descriptions and packages: write, read, check, pack, open.
//!
//! [`ModelDescription`] holds what an FMU of FMI 2.0 or 3.0 says about itself.

mod check;
pub mod describe;
pub mod description;
mod names;
pub mod package;
pub mod problem;
mod read;
pub mod structure;
mod time;
pub mod variable;
mod write;
pub mod xml;

pub use check::{check, check_description, check_model, required_functions};
pub use description::{FmiVersion, ModelDescription};
pub use package::{Package, PackageBuilder, PackageError};
pub use problem::{Problem, Severity};
pub use read::ParseError;
pub use time::generation_time;
pub use write::WriteError;
