//! The package of a repaired FMU.

use std::path::Path;

use modeldescription::description::{BaseUnit, Line, LogCategory, Unit};
use modeldescription::structure::Unknown;
use modeldescription::variable::{
    Causality, DataType, Initial, Number, Start, Variability, Variable,
};
use modeldescription::{
    FmiVersion, ModelDescription, Package, PackageBuilder, PackageError, generation_time,
};
use surround::Repair;

use crate::error::Error;

/// A repaired FMU, to be written.
pub struct Repaired {
    /// The package; the caller adds licences, documentation and reference results, and writes it.
    pub package: PackageBuilder,
    /// What the repaired says about itself.
    pub description: ModelDescription,
    /// What is put around the original.
    pub repair: Repair,
    /// What stays out of it, and what else its user should know, one sentence each.
    pub notes: Vec<String>,
}

/// Packs a repair around an FMU; with the first of the libraries, and with those for platforms that the original
/// runs on too.
pub(crate) fn pack(
    original: &Package,
    repair: &Repair,
    mut notes: Vec<String>,
    libraries: &[(&str, &[u8])],
) -> Result<Repaired, Error> {
    let failed = |message: String| Error::Model {
        model: original.path().display().to_string(),
        message: format!("cannot be repaired: {message}"),
    };
    let description = describe(original.description(), repair).map_err(&failed)?;
    let described = |e: PackageError| failed(e.to_string());
    let mut package = PackageBuilder::new(&description).map_err(described)?;
    let platforms = original.platforms();
    for (number, (platform, bytes)) in libraries.iter().enumerate() {
        if number == 0 || platforms.iter().any(|own| is_same(own, platform)) {
            package.binary(platform, bytes.to_vec()).map_err(described)?;
        }
    }
    let text = repair.to_toml().map_err(|e| failed(e.to_string()))?;
    package.resource(surround::FILE, text.into_bytes()).map_err(described)?;
    for (path, content) in files(original.folder()).map_err(|e| failed(e.to_string()))? {
        package.resource(&format!("inner/{path}"), content).map_err(described)?;
    }
    for path in looks(original) {
        let content =
            std::fs::read(original.folder().join(&path)).map_err(|e| failed(e.to_string()))?;
        package.entry(path, content).map_err(described)?;
    }
    let is_missing = |own: &String| !libraries.iter().any(|(given, _)| is_same(own, given));
    let others: Vec<String> = platforms.into_iter().filter(is_missing).collect();
    if !others.is_empty() {
        notes.push(format!(
            "the original also runs on {}; the repaired FMU does not, no library was given for it",
            others.join(", ")
        ));
    }
    Ok(Repaired { package, notes, description, repair: repair.clone() })
}

/// The original's icons and terminals, which fit the repaired FMU too: it has all its variables.
fn looks(original: &Package) -> Vec<String> {
    let folder = original.folder();
    let mut all = Vec::new();
    if folder.join("model.png").is_file() {
        all.push("model.png".to_owned());
    }
    let icons = std::fs::read_dir(folder.join("terminalsAndIcons")).into_iter().flatten().flatten();
    for entry in icons.filter(|entry| entry.path().is_file()) {
        all.push(format!("terminalsAndIcons/{}", entry.file_name().to_string_lossy()));
    }
    all.sort();
    all
}

/// Whether a folder of binaries is of this platform, in either version's name.
fn is_same(folder: &str, platform: &str) -> bool {
    let of = modeldescription::package::Platform::from_name;
    folder == platform
        || of(folder).is_some_and(|a| {
            of(platform).is_some_and(|b| a.folder(FmiVersion::V3) == b.folder(FmiVersion::V3))
        })
}

/// All files of a folder with their paths in it, sorted.
fn files(folder: &Path) -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let mut all = Vec::new();
    let mut open = vec![(folder.to_path_buf(), String::new())];
    while let Some((folder, head)) = open.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let entry = entry?;
            let path = format!("{head}{}", entry.file_name().to_string_lossy());
            if entry.file_type()?.is_dir() {
                open.push((entry.path(), format!("{path}/")));
            } else {
                all.push((path, std::fs::read(entry.path())?));
            }
        }
    }
    all.sort();
    Ok(all)
}

/// The original's description with the variables of the repair.
fn describe(original: &ModelDescription, repair: &Repair) -> Result<ModelDescription, String> {
    let mut d = original.clone();
    let kind = if repair.effects.is_empty() { "preset" } else { "repaired" };
    let clocked = |v: &Variable| v.data_type == DataType::Clock || !v.clocks.is_empty();
    if let Some(v) = d.variables.iter().find(|v| clocked(v)) {
        return Err(format!("it has clocks ({}), which need event mode", v.name));
    }
    let Some(cs) = &mut d.co_simulation else {
        return Err("it offers no co-simulation".to_owned());
    };
    cs.common.model_identifier = identifier(&cs.common.model_identifier, kind);
    cs.common.source_files.clear();
    cs.common.provides_adjoint_derivatives = false;
    cs.can_interpolate_inputs = false;
    cs.can_run_asynchronously = false;
    cs.max_output_derivative_order = 0;
    cs.recommended_intermediate_input_smoothness = 0;
    cs.provides_intermediate_update = false;
    cs.might_return_early_from_do_step = false;
    cs.can_return_early_after_intermediate_update = false;
    cs.has_event_mode = false;
    cs.provides_evaluate_discrete_states = false;
    (d.model_exchange, d.scheduled_execution) = (None, None);
    d.number_of_event_indicators = None;
    d.instantiation_token.clone_from(&repair.token);
    d.generation_tool = Some(format!("Piezoloop {}", env!("CARGO_PKG_VERSION")));
    d.generation_date_and_time = generation_time().ok();
    let names: Vec<&str> = repair.effects.iter().map(|e| e.name.as_str()).collect();
    let described = d.description.take().filter(|t| !t.is_empty());
    let described = described.unwrap_or_else(|| d.model_name.clone());
    d.description = Some(match kind {
        "preset" => format!("{described} (with other start values)"),
        _ => format!("{described} (repaired: {})", names.join(", ")),
    });
    d.log_categories.push(LogCategory {
        name: "repair".to_owned(),
        description: Some("What the repair around the original says".to_owned()),
        line: Line::default(),
    });
    let version = d.version.take().filter(|text| !text.is_empty());
    d.version = Some(version.map_or(kind.to_owned(), |text| format!("{text}, {kind}")));
    let license = d.license.take().filter(|text| !text.is_empty());
    d.license = Some(match license {
        Some(text) => format!("{text}; MIT OR Apache-2.0 (the shared library around the original)"),
        None => "MIT OR Apache-2.0 (the shared library around the original)".to_owned(),
    });
    preset(&mut d, repair);
    add_variables(&mut d, repair);
    restructure(&mut d, repair);
    Ok(d)
}

/// A C identifier for the repaired FMU's library.
fn identifier(original: &str, kind: &str) -> String {
    let base: String = original.chars().take(100).collect();
    format!("{base}_{kind}")
}

/// Start values that the original is given are those of the description.
fn preset(d: &mut ModelDescription, repair: &Repair) {
    for preset in &repair.presets {
        let is = |v: &&mut Variable| {
            v.value_reference == preset.reference && v.data_type == DataType::Float64
        };
        for variable in d.variables.iter_mut().filter(is) {
            if variable.start.is_some() {
                variable.start = Some(Start::Float(preset.start.clone()));
            }
        }
    }
}

fn add_variables(d: &mut ModelDescription, repair: &Repair) {
    for effect in &repair.effects {
        let mut enabled =
            Variable::new(format!("{}.enabled", effect.name), effect.reference, DataType::Boolean);
        enabled.description = Some(format!("Whether it acts. {}", effect.description));
        enabled.start = Some(Start::Boolean(vec![effect.enabled]));
        parameter(d, enabled);
        for p in &effect.parameters {
            let mut v = Variable::new(
                format!("{}.{}", effect.name, p.name),
                p.reference,
                DataType::Float64,
            );
            v.description = Some(p.description.clone());
            v.start = Some(Start::Float(vec![p.start]));
            v.properties.unit = unit(d, &p.unit);
            v.properties.min = p.min.map(Number::Float);
            v.properties.max = p.max.map(Number::Float);
            parameter(d, v);
        }
    }
    for input in repair.inputs.iter().filter(|input| input.own) {
        let mut v = Variable::new(input.name.clone(), input.variable.reference, DataType::Float64);
        v.causality = Causality::Input;
        v.description = Some("Auxiliary signal of an effect, in SI units".to_owned());
        v.start = Some(Start::Float(input.variable.start.clone()));
        d.variables.push(v);
    }
}

fn parameter(d: &mut ModelDescription, mut v: Variable) {
    v.causality = Causality::Parameter;
    v.stated_variability = Some(Variability::Fixed);
    v.stated_initial = Some(Initial::Exact);
    d.variables.push(v);
}

/// The name of a unit, which is declared where it is not yet; none for a plain number.
fn unit(d: &mut ModelDescription, text: &str) -> Option<String> {
    if text == "1" || text.is_empty() {
        return None;
    }
    if d.unit(text).is_some() {
        return Some(text.to_owned());
    }
    let parsed = model::Unit::parse(text).ok()?;
    let [kg, m, s, a, k, mol, cd, rad] = parsed.exponents.map(i32::from);
    let (factor, offset) = (parsed.factor, parsed.offset);
    d.units.push(Unit {
        name: text.to_owned(),
        base: Some(BaseUnit { kg, m, s, a, k, mol, cd, rad, factor, offset }),
        display_units: Vec::new(),
        line: Line::default(),
    });
    Some(text.to_owned())
}

/// Outputs with effects depend on whatever they may; wrong lists of initial unknowns are put right.
fn restructure(d: &mut ModelDescription, repair: &Repair) {
    let touched: Vec<u32> = repair.outputs.iter().map(|p| p.variable.reference).collect();
    let positions = (0..d.variables.len())
        .filter(|k| touched.contains(&d.variables[*k].value_reference))
        .filter(|k| d.variables[*k].causality == Causality::Output);
    let touched: Vec<u32> = positions.filter_map(|k| d.reference_to(k)).collect();
    for unknown in d.structure.outputs.iter_mut().chain(&mut d.structure.initial_unknowns) {
        if touched.contains(&unknown.variable) {
            (unknown.dependencies, unknown.dependency_kinds) = (None, None);
        }
    }
    let version = d.fmi_version;
    let computed = |v: &Variable| {
        matches!(v.initial(version), Some(Initial::Approx | Initial::Calculated))
            && matches!(v.causality, Causality::Output | Causality::CalculatedParameter)
    };
    let wanted: Vec<u32> = (0..d.variables.len())
        .filter(|k| computed(&d.variables[*k]))
        .filter_map(|k| d.reference_to(k))
        .collect();
    let described: Vec<u32> = d.structure.initial_unknowns.iter().map(|u| u.variable).collect();
    let has_states = !d.structure.derivatives.is_empty() || !d.structure.clocked_states.is_empty();
    if !has_states && described != wanted {
        d.structure.initial_unknowns = wanted.into_iter().map(Unknown::new).collect();
    }
}
