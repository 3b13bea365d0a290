//! The binary of the plant FMU: the standard's functions, and nothing else that a host could see.
//!
//! It is the same for every plant; the blueprint in the FMU's resources chooses the chain.

use std::path::Path;

use data::Blueprint;
use fmi_bindings::export;
use model::{Kind, System};

fmi_bindings::old_glibc!();
fmi_bindings::export_fmi2!(crate::plant);
fmi_bindings::export_fmi3!(crate::plant);

/// Builds the plant that the blueprint in these resources describes.
fn plant(resources: &Path) -> Result<System, String> {
    let file = resources.join(export::BLUEPRINT);
    let checked = Blueprint::read(&file)
        .and_then(|blueprint| blueprint.check(learned::COMPONENTS))
        .map_err(|problems| problems.to_string())?;
    if checked.blueprint().kind != Kind::Plant {
        return Err(format!(
            "{}: kind = \"controller\", but this is the binary of a plant; pack the blueprint \
             again, which takes the binary that belongs to it",
            file.display()
        ));
    }
    Ok(checked.build())
}
