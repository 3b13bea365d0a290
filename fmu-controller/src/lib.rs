//! The binary of the controller FMU: the standard's functions, and nothing else that a host could see.
//!
//! It is the same for every controller; the blueprint in the FMU's resources chooses the chain.

use std::path::Path;

use data::Blueprint;
use fmi_bindings::export;
use model::{Kind, System};

fmi_bindings::old_glibc!();
fmi_bindings::export_fmi2!(crate::controller);
fmi_bindings::export_fmi3!(crate::controller);

/// Builds the controller that the blueprint in these resources describes.
fn controller(resources: &Path) -> Result<System, String> {
    let file = resources.join(export::BLUEPRINT);
    let checked = Blueprint::read(&file)
        .and_then(|blueprint| blueprint.check(learned::COMPONENTS))
        .map_err(|problems| problems.to_string())?;
    if checked.blueprint().kind != Kind::Controller {
        return Err(format!(
            "{}: kind = \"plant\", but this is the binary of a controller; pack the blueprint \
             again, which takes the binary that belongs to it",
            file.display()
        ));
    }
    Ok(checked.build())
}
