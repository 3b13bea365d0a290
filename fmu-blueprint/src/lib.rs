//! The binary of a packed blueprint's FMU: the standard's functions, and nothing else that a host could see.
//!
//! It is the same for every plant and every controller; the blueprint in the FMU's resources chooses the chain.

use std::path::Path;

use data::Blueprint;
use fmi_bindings::export;
use model::System;

fmi_bindings::old_glibc!();
fmi_bindings::export_fmi2!(crate::model);
fmi_bindings::export_fmi3!(crate::model);

/// Builds the plant or controller that the blueprint in these resources describes.
fn model(resources: &Path) -> Result<System, String> {
    Blueprint::read(&resources.join(export::BLUEPRINT))
        .and_then(|blueprint| blueprint.check(learned::COMPONENTS))
        .map(|checked| checked.build())
        .map_err(|problems| problems.to_string())
}
