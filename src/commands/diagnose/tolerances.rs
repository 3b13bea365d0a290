//! Whether the parameters of `--tune` are there.

use anyhow::bail;
use diagnose::{Model, Request, Tolerance};
use modeldescription::Package;

use crate::inputs;

/// Whether each `--tune` names a parameter that can be re-tuned. Of several, a pattern may be for another
/// model of a series: what matches nothing is given back to be said.
pub(super) fn check_tolerances(request: &Request) -> anyhow::Result<Vec<String>> {
    if request.tolerances.is_empty() {
        return Ok(Vec::new());
    }
    let names: Vec<String> = match &request.model {
        Model::Blueprint(checked) => {
            let system = checked.build();
            let variables = system.variables().as_slice().iter();
            variables.filter(|v| v.fit && v.start != Some(0.0)).map(|v| v.name.clone()).collect()
        }
        Model::Fmu(path) => {
            let package = Package::open(path)?;
            let variables = package.description().variables.iter();
            let is_tuned = |v: &&modeldescription::variable::Variable| {
                v.causality == modeldescription::variable::Causality::Parameter
                    && v.start.as_ref().is_some_and(|start| start.numbers().is_some())
            };
            variables.filter(is_tuned).map(|v| v.name.clone()).collect()
        }
    };
    let matches = |tolerance: &Tolerance| names.iter().any(|name| tolerance.is_for(name));
    let any = request.tolerances.iter().any(matches);
    let mut unmatched = Vec::new();
    for tolerance in &request.tolerances {
        if !matches(tolerance) {
            if any && tolerance.name.contains('*') {
                unmatched.push(format!(
                    "--tune {}: no parameter of the model has such a name; it changes nothing",
                    tolerance.name
                ));
                continue;
            }
            let near = inputs::meant(&tolerance.name, names.iter().map(String::as_str));
            let most = 12;
            let more = match names.len().saturating_sub(most) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            bail!(
                "--tune {}: is no parameter of the model that can be re-tuned (its value is a number and not 0); {near}there are {}{more}",
                tolerance.name,
                names.iter().take(most).cloned().collect::<Vec<_>>().join(", ")
            );
        }
    }
    Ok(unmatched)
}
