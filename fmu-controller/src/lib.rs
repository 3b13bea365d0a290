//! The binary of the controller FMU: the standard's functions, and nothing else that a host could see.
//!
//! It is the same for every controller; the blueprint in the FMU's resources chooses the chain.

use std::path::Path;

use data::Blueprint;
use fmi_bindings::export;
use model::{Kind, System};

fmi_bindings::export_fmi2!(crate::controller);
fmi_bindings::export_fmi3!(crate::controller);

/// Builds the controller that the blueprint in these resources describes.
fn controller(resources: &Path) -> Result<System, String> {
    let file = resources.join(export::BLUEPRINT);
    let blueprint = Blueprint::read(&file).map_err(|problems| problems.to_string())?;
    if blueprint.kind != Kind::Controller {
        return Err(format!(
            "{}: kind = \"plant\", but this is the binary of a controller; pack the FMU again, which \
             takes the binary that belongs to the blueprint",
            file.display()
        ));
    }
    let checked =
        blueprint.check(components::COMPONENTS).map_err(|problems| problems.to_string())?;
    Ok(checked.build())
}
