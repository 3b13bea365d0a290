//! An FMU with other start values.

use cosim::Fmu;
use modeldescription::variable::DataType;

use super::package::{Repaired, pack};
use crate::error::Error;

/// Packs an FMU with other start values of Float64 variables or elements: the original lies inside and is
/// given them when it is instantiated and after a reset, whatever the importer does. `sha256` is that of the
/// original's archive; libraries as for a repaired FMU.
///
/// # Errors
/// A name that is no such variable, or an FMU that cannot be put into another one.
pub fn preset(
    fmu: &Fmu,
    sha256: &str,
    values: &[(String, f64)],
    libraries: &[(&str, &[u8])],
) -> Result<Repaired, Error> {
    let description = fmu.description();
    let failed = |message: String| Error::Model {
        model: description.model_name.clone(),
        message: format!("cannot be packed with other start values: {message}"),
    };
    let mut repair = super::unchanged(fmu, sha256, 1.0, false);
    for (name, value) in values {
        let variable = fmu.variable(name).map_err(|e| failed(e.to_string()))?;
        if variable.data_type != DataType::Float64 {
            let found = variable.data_type.name();
            return Err(failed(format!("`{name}` is of type {found}, not Float64")));
        }
        let (reference, element, size) = fmu.place(name).map_err(|e| failed(e.to_string()))?;
        let known = repair.presets.iter().position(|preset| preset.reference == reference);
        let at = known.unwrap_or_else(|| {
            let mut all = description.variables.iter();
            let complete = all.find(|v| v.value_reference == reference && !v.dimensions.is_empty());
            let start = super::starts(complete, size);
            repair.presets.push(surround::Variable { reference, start });
            repair.presets.len() - 1
        });
        if let Some(place) = repair.presets[at].start.get_mut(element) {
            *place = *value;
        }
    }
    let text = repair.to_toml().map_err(|e| failed(e.to_string()))?;
    let print = report::InputFile::of_bytes("repair", surround::FILE, text.as_bytes());
    repair.token = print.sha256[..32].to_owned();
    pack(fmu.package(), &repair, Vec::new(), libraries)
}
