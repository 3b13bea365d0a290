//! An FMU with other start values.

use cosim::Fmu;
use modeldescription::variable::{Causality, DataType};
use surround::{Original, Repair};

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
    let common = description.co_simulation.as_ref().map(|cs| &cs.common);
    let original = Original {
        fmi: description.fmi_version.text().to_owned(),
        identifier: common.map(|common| common.model_identifier.clone()).unwrap_or_default(),
        token: description.instantiation_token.clone(),
        sha256: sha256.to_owned(),
    };
    let sizes = [Causality::Input, Causality::Output, Causality::Parameter]
        .into_iter()
        .flat_map(|causality| fmu.names(causality))
        .filter_map(|name| fmu.place(&name).ok())
        .filter(|(_, index, size)| *index == 0 && *size > 1)
        .map(|(reference, _, size)| (reference, size))
        .collect();
    let mut repair = Repair {
        format: surround::FORMAT,
        token: String::new(),
        step: 1.0,
        divide: false,
        original,
        inputs: Vec::new(),
        outputs: Vec::new(),
        changes: Vec::new(),
        effects: Vec::new(),
        sizes,
        presets: Vec::new(),
    };
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
            let whole = all.find(|v| v.value_reference == reference && !v.dimensions.is_empty());
            let start = super::starts(whole, size);
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
