//! FMI model descriptions and packages: write, read, check, pack, open.
//!
//! * [`ModelDescription`] is what an FMU of FMI 2.0 or 3.0 says about itself:
//!   [`ModelDescription::parse`] reads any vendor's file, [`ModelDescription::to_xml`] writes one to
//!   the letter of the schema.
//! * [`PackageBuilder`] packs an FMU, always to the same bytes; [`Package`] opens one, whoever made
//!   it, and writes nothing outside a temporary folder.
//! * [`check()`] tells every [`Problem`] of an FMU, with line and section of the standard.
//! * [`ssp`] reads and writes systems of connected FMUs.
//! * [`describe::describe`] makes the description of a built model from its variable table.
//!
//! ```
//! use modeldescription::description::CoSimulation;
//! use modeldescription::structure::Unknown;
//! use modeldescription::variable::{Causality, DataType, Variable};
//! use modeldescription::{FmiVersion, ModelDescription, check_model};
//!
//! let mut stage = ModelDescription::new(FmiVersion::V2, "Piezo stage", "0123456789abcdef");
//! stage.co_simulation = Some(CoSimulation::new("stage"));
//! let mut position = Variable::new("axis[1].position", 0, DataType::Float64);
//! position.causality = Causality::Output;
//! stage.variables.push(position);
//! stage.structure.outputs.push(Unknown::new(1));
//!
//! let problems = check_model(&stage);
//! assert_eq!(problems.len(), 1);
//! assert!(problems[0].found.starts_with("InitialUnknowns lacks \"axis[1].position\""));
//!
//! stage.structure.initial_unknowns.push(Unknown::new(1));
//! assert!(check_model(&stage).is_empty());
//! assert!(stage.to_xml()?.contains("<Unknown index=\"1\"/>"));
//! # Ok::<(), modeldescription::WriteError>(())
//! ```

mod check;
pub mod describe;
pub mod description;
mod names;
pub mod package;
pub mod problem;
mod read;
pub mod ssp;
pub mod structure;
mod time;
pub mod variable;
mod version;
mod write;
pub mod xml;

pub use check::{check, check_description, check_library, check_model, required_functions};
pub use description::{FmiVersion, ModelDescription};
pub use package::{Package, PackageBuilder, PackageError};
pub use problem::{Problem, Severity};
pub use read::ParseError;
pub use time::generation_time;
pub use write::WriteError;
