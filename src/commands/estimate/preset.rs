//! What was found, as a parameter set and as an FMU that begins with it.

use std::path::{Path, PathBuf};

use anyhow::Context;
use cosim::Value;
use modeldescription::ssp::{Parameter, ParameterSet, ParameterValue};
use modeldescription::variable::DataType;

use super::asked::Asked;
use crate::fmus::Opened;
use crate::{libraries, wrapped};

/// Writes the shared values as a parameter set.
pub(super) fn write_set(out: &Path, asked: &[Asked], values: &[f64]) -> anyhow::Result<PathBuf> {
    let shared = asked.iter().zip(values).filter(|(asked, _)| asked.own.is_none());
    let parameter = |(asked, value): (&Asked, &f64)| Parameter {
        name: asked.name.clone(),
        value: ParameterValue::Real(vec![*value]),
        unit: None,
        line: Default::default(),
    };
    let parameters = shared.map(parameter).collect();
    let set = ParameterSet { parameters, ..ParameterSet::new("estimated") };
    data::AtomicFile::write_all_of(out, set.to_xml()?.as_bytes())
        .with_context(|| format!("{} cannot be written", out.display()))?;
    Ok(out.to_path_buf())
}

/// Writes an FMU with this one inside, which begins with the shared values and with what `--start` gave;
/// what of it could not be taken along.
pub(super) fn write_fmu(
    file: &Path,
    opened: &Opened,
    asked: &[Asked],
    values: &[f64],
    fixed: &[(String, Value)],
) -> anyhow::Result<Vec<String>> {
    let mut notes = Vec::new();
    let mut all = Vec::new();
    for (name, value) in fixed {
        match value {
            Value::Real(value) if is_double(opened, name) => all.push((name.clone(), *value)),
            _ => notes.push(format!(
                "{}: `{name}` does not begin with {value}, as only numbers of type Real (Float64) are packed",
                file.display()
            )),
        }
    }
    let shared = asked.iter().zip(values).filter(|(asked, _)| asked.own.is_none());
    all.extend(shared.map(|(asked, value)| (asked.name.clone(), *value)));
    let archive = opened.fmu.package().path();
    let archive = match archive.is_dir() {
        true => archive.join("modelDescription.xml"),
        false => archive.to_path_buf(),
    };
    let sha256 = report::InputFile::read("original", archive)?.sha256;
    let carried = [(libraries::PLATFORM, libraries::WRAP.bytes)];
    let mut packed = diagnose::preset(&opened.fmu, &sha256, &all, &carried)?;
    wrapped::finish(&mut packed, opened.fmu.package(), file, None)?;
    notes.extend(packed.notes);
    Ok(notes)
}

fn is_double(opened: &Opened, name: &str) -> bool {
    opened.fmu.variable(name).is_ok_and(|variable| variable.data_type == DataType::Float64)
}
