//! Start values as a user writes them: `NAME=VALUE`.

use anyhow::{Context, bail};
use cosim::{Fmu, Value};
use modeldescription::variable::Causality;

use crate::fmus::Addresses;

fn parts(text: &str) -> anyhow::Result<(&str, &str)> {
    let Some((name, value)) = text.split_once('=') else {
        bail!("--start {text}: write NAME=VALUE, as in axis[1].mechanics.damping=0.05");
    };
    Ok((name.trim(), value.trim()))
}

/// Gives the FMU the values of structural parameters, which set the sizes of its arrays.
pub(crate) fn configure<'a>(
    texts: impl IntoIterator<Item = &'a str>,
    fmu: &mut Fmu,
) -> anyhow::Result<()> {
    let mut structure = Vec::new();
    for text in texts {
        let (name, value) = parts(text)?;
        let found = fmu.description().variable(name);
        let Some(variable) = found.filter(|v| v.causality == Causality::StructuralParameter) else {
            continue;
        };
        let value = Value::parse(value, variable.data_type)
            .map_err(|why| anyhow::anyhow!("--start {text}: {why}"))?;
        structure.push((variable.name.clone(), value));
    }
    if structure.is_empty() { Ok(()) } else { Ok(fmu.configure(&structure)?) }
}

/// The start values of an FMU that is configured; arrays by their elements, in row-major order.
pub(crate) fn starts<'a>(
    texts: impl IntoIterator<Item = &'a str>,
    addresses: &Addresses,
    fmu: &Fmu,
) -> anyhow::Result<Vec<(String, Value)>> {
    let mut all = Vec::new();
    for text in texts {
        let (name, value) = parts(text)?;
        let name = addresses.variable(name);
        let variable = fmu.variable(&name).with_context(|| format!("--start {text}"))?;
        let read = |value: &str| {
            Value::parse(value, variable.data_type)
                .map_err(|why| anyhow::anyhow!("--start {text}: {why}"))
        };
        if variable.dimensions.is_empty() {
            all.push((name, read(value)?));
            continue;
        }
        let elements = fmu.elements(&name)?;
        let values: Vec<&str> = value.split([' ', ',', ';']).filter(|v| !v.is_empty()).collect();
        if values.len() != elements.len() {
            bail!(
                "--start {text}: `{name}` has {} elements, {} values are given; write all of them, row by \
                 row, or one element, as in {name}[1]=VALUE",
                elements.len(),
                values.len()
            );
        }
        for (element, value) in elements.into_iter().zip(values) {
            all.push((element, read(value)?));
        }
    }
    Ok(all)
}
