//! What an FMU says of itself by the blueprint that it carries: the short names of its variables, and the tolerances of
//! its parameters.

use std::path::Path;

use data::NameMap;
use diagnose::{Request, Tolerance};
use modeldescription::Package;

use crate::fmus;

/// Adds to a request what the FMU's blueprint says and the command line does not; in sentences. Nothing where it carries none.
///
/// # Errors
/// The package cannot be opened, or a variable has a column under both of its names.
pub(super) fn add(request: &mut Request, fmu: &Path) -> anyhow::Result<Vec<String>> {
    // A later version may carry what this one cannot read: its FMU is one as any other.
    let Some(checked) = fmus::carried(&Package::open(fmu)?) else { return Ok(Vec::new()) };
    let mut notes = Vec::new();
    let own = Tolerance::of_blueprint(&checked);
    let is_asked = |t: &Tolerance| request.tolerances.iter().any(|asked| asked.is_for(&t.name));
    // Each stands twice, for a number and for a list.
    let mut used: Vec<&str> =
        own.iter().filter(|t| !is_asked(t)).map(|t| t.name.trim_end_matches("[*")).collect();
    used.dedup();
    if !used.is_empty() {
        notes.push(format!(
            "the FMU carries its blueprint, whose tolerances hold for {} (--tune NAME=TOLERANCE changes one)",
            used.join(", ")
        ));
    }
    // Of several the last one counts: what the command line says.
    request.tolerances.splice(0..0, own);
    let short = fmus::short_names(&checked);
    let variable =
        |name: &str| short.iter().find(|(alias, _)| alias == name).map(|(_, v)| v.as_str());
    let mut pairs: Vec<String> = request
        .names
        .iter()
        .map(|(name, column)| format!("{}={column}", variable(name).unwrap_or(name)))
        .collect();
    let has = |name: &str| request.logs.iter().all(|log| log.column(name).is_some());
    for (alias, name) in &short {
        let is_mapped = request.names.iter().any(|(of, _)| of == name || of == alias);
        if !is_mapped && has(alias) && !has(name) {
            pairs.push(format!("{name}={alias}"));
            notes.push(format!("column {alias} is {name}, as the FMU's blueprint calls it"));
        }
    }
    request.names = NameMap::parse(&pairs)?;
    Ok(notes)
}
