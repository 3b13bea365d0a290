//! From the variable table of a built model to its model description.
//!
//! The table is the only source: names, references, types, units, bounds and start values of the XML
//! are those the binary uses, and the GUID is the table's fingerprint.

use std::collections::{HashMap, HashSet};

use model::{Bundle, Causality as Role, DataType as Kind, Variable as Row, VariableTable};

use crate::description::{
    BaseUnit, CoSimulation, DefaultExperiment, FmiVersion, Line, LogCategory, ModelDescription,
    Unit,
};
use crate::structure::Unknown;
use crate::time::generation_time;
use crate::variable::{
    Causality, DataType, Dimension, Initial, Number, Properties, Start, Variability, Variable,
};
use crate::write::WriteError;

/// What a model description says beside the variables.
#[derive(Debug, Clone)]
pub struct About {
    /// Version of the standard.
    pub fmi_version: FmiVersion,
    /// Name of the model, for people.
    pub model_name: String,
    /// One sentence about the model.
    pub description: Option<String>,
    /// Author of the model.
    pub author: Option<String>,
    /// Version of the model.
    pub version: Option<String>,
    /// Copyright notice.
    pub copyright: Option<String>,
    /// Licence of the model.
    pub license: Option<String>,
    /// Tool that writes the file.
    pub generation_tool: Option<String>,
    /// Name of the shared library and what it can do.
    pub co_simulation: CoSimulation,
    /// Names and sentences of the log categories.
    pub log_categories: Vec<(String, String)>,
    /// Step of the model's own time grid in s.
    pub internal_step: f64,
}

impl About {
    /// A model of this name in the shared library `co_simulation` names, nothing else stated.
    pub fn new(
        fmi_version: FmiVersion,
        model_name: impl Into<String>,
        co_simulation: CoSimulation,
        internal_step: f64,
    ) -> Self {
        About {
            fmi_version,
            model_name: model_name.into(),
            description: None,
            author: None,
            version: None,
            copyright: None,
            license: None,
            generation_tool: None,
            co_simulation,
            log_categories: Vec::new(),
            internal_step,
        }
    }
}

/// Why a variable table cannot be described.
#[derive(Debug, thiserror::Error, Clone, PartialEq)]
pub enum DescribeError {
    /// An input or a parameter has no start value.
    #[error("variable \"{name}\" has no start value; inputs and parameters must have one")]
    NoStart {
        /// Name of the variable.
        name: String,
    },
    /// A start value that the type does not have.
    #[error("variable \"{name}\" of type {data_type} starts at {start}; {rule}")]
    Start {
        /// Name of the variable.
        name: String,
        /// The name's type.
        data_type: DataType,
        /// The start value.
        start: f64,
        /// What start values the type has.
        rule: &'static str,
    },
    /// The internal step is no positive number.
    #[error("the internal step is {step} s; it must be positive and finite")]
    Step {
        /// The step in s.
        step: f64,
    },
    /// The time stamp cannot be made.
    #[error(transparent)]
    Time(#[from] WriteError),
}

/// Communication steps of the default experiment. An importer that is given no step of its own may
/// coarsen a longer run (fmpy: until it has at most 1000 steps).
const DEFAULT_STEPS: f64 = 1000.0;

/// The value reference of the independent variable, which FMI 3.0 requires: the one after the table.
pub fn time_reference(table: &VariableTable) -> u32 {
    u32::try_from(table.len()).unwrap_or(u32::MAX)
}

/// The description of a model with these variables, in the table's order: value reference 0 first.
///
/// FMI 3.0 has arrays: variables that differ in their last index alone ([`VariableTable::bundles`])
/// are one, with the value reference of its first element. Its bounds are those that all elements
/// are within. Short names stand in the description.
///
/// Outputs are those of the last hit of the model's own time grid, so that at a communication point
/// they depend on no input of that point; after initialisation they depend on what the table says.
///
/// # Errors
/// If an input or parameter has no start value or one its type does not have, the internal step is
/// not positive, or `SOURCE_DATE_EPOCH` is no time.
pub fn describe(table: &VariableTable, about: &About) -> Result<ModelDescription, DescribeError> {
    let step = about.internal_step;
    if !(step > 0.0 && step.is_finite()) {
        return Err(DescribeError::Step { step });
    }
    let mut description =
        ModelDescription::new(about.fmi_version, &about.model_name, table.fingerprint());
    description.description = about.description.clone();
    description.author = about.author.clone();
    description.version = about.version.clone();
    description.copyright = about.copyright.clone();
    description.license = about.license.clone();
    description.generation_tool = about.generation_tool.clone();
    description.generation_date_and_time = Some(generation_time()?);
    description.co_simulation = Some(about.co_simulation.clone());
    description.log_categories = about.log_categories.iter().map(log_category).collect();
    description.default_experiment = Some(DefaultExperiment {
        start_time: Some(0.0),
        stop_time: Some(DEFAULT_STEPS * step),
        tolerance: None,
        step_size: Some(step),
        line: Line(0),
    });
    description.units = units(table.as_slice());
    match about.fmi_version {
        FmiVersion::V2 => {
            for (reference, row) in (0..).zip(table.as_slice()) {
                description.variables.push(scalar(reference, row)?);
            }
        }
        FmiVersion::V3 => {
            for bundle in table.bundles() {
                description.variables.push(scalar_or_array(table, &bundle)?);
            }
            add_time(&mut description, time_reference(table));
        }
    }
    add_structure(&mut description, table);
    Ok(description)
}

fn log_category((name, sentence): &(String, String)) -> LogCategory {
    LogCategory { name: name.clone(), description: Some(sentence.clone()), line: Line(0) }
}

/// Every unit once, in the order of first use.
fn units(rows: &[Row]) -> Vec<Unit> {
    let mut seen = HashSet::new();
    let with_unit = rows.iter().filter(|row| !row.unit.is_empty());
    with_unit.filter(|row| seen.insert(row.unit.as_str())).map(unit).collect()
}

fn unit(row: &Row) -> Unit {
    let [kg, m, s, a, k, mol, cd, rad] = row.si.exponents.map(i32::from);
    let (factor, offset) = (row.si.factor, row.si.offset);
    Unit {
        name: row.unit.clone(),
        base: Some(BaseUnit { kg, m, s, a, k, mol, cd, rad, factor, offset }),
        display_units: Vec::new(),
        line: Line(0),
    }
}

fn scalar(reference: u32, row: &Row) -> Result<Variable, DescribeError> {
    let data_type = match row.data_type {
        Kind::Real => DataType::Float64,
        Kind::Integer => DataType::Int32,
        Kind::Boolean => DataType::Boolean,
    };
    let (causality, variability) = match row.causality {
        Role::FixedParameter => (Causality::Parameter, Variability::Fixed),
        Role::TunableParameter => (Causality::Parameter, Variability::Tunable),
        Role::Input => (Causality::Input, changing(row)),
        Role::Output => (Causality::Output, changing(row)),
    };
    let mut read = Variable::new(&row.name, reference, data_type);
    read.description = (!row.description.is_empty()).then(|| row.description.clone());
    read.causality = causality;
    read.stated_variability = Some(variability);
    read.properties = properties(row, data_type);
    match causality {
        Causality::Output => read.stated_initial = Some(Initial::Calculated),
        _ => read.start = Some(start(row, data_type)?),
    }
    Ok(read)
}

/// The variable of FMI 3.0 that stands for these rows of the table.
fn scalar_or_array(table: &VariableTable, bundle: &Bundle) -> Result<Variable, DescribeError> {
    let rows: Vec<&Row> = bundle.elements.iter().filter_map(|r| table.get(*r)).collect();
    let scalars = bundle.elements.iter().zip(&rows).map(|(reference, row)| scalar(*reference, row));
    let mut scalars = scalars.collect::<Result<Vec<_>, _>>()?;
    let mut array = scalars.remove(0);
    if bundle.is_array {
        array.name.clone_from(&bundle.name);
        array.description = array_description(&rows);
        array.dimensions = vec![Dimension::Size(rows.len() as u64)];
    }
    for element in scalars {
        array.properties.min = wider(array.properties.min, element.properties.min, f64::lt);
        array.properties.max = wider(array.properties.max, element.properties.max, f64::gt);
        match (&mut array.start, element.start) {
            (Some(Start::Float(all)), Some(Start::Float(one))) => all.extend(one),
            (Some(Start::Integer(all)), Some(Start::Integer(one))) => all.extend(one),
            (Some(Start::Boolean(all)), Some(Start::Boolean(one))) => all.extend(one),
            _ => {}
        }
    }
    // An alias would be the better place, but fmpy 0.3.32 takes it for a second variable: it misses
    // an input of that name, and an output among the initial unknowns.
    if let [Row { alias: Some(alias), .. }] = rows[..] {
        let sentence = array.description.unwrap_or_default();
        array.description = Some(format!("{sentence} ({alias})").trim_start().to_owned());
    }
    Ok(array)
}

/// The bound that holds for both, none where one has none.
fn wider(a: Option<Number>, b: Option<Number>, beyond: fn(&f64, &f64) -> bool) -> Option<Number> {
    let (a, b) = (a?, b?);
    Some(if beyond(&b.as_f64(), &a.as_f64()) { b } else { a })
}

/// One sentence for all elements: `Command to the amplifier, axes Y (u1), Z (u2)` of
/// `…, axis Y` and `…, axis Z` with their short names.
fn array_description(rows: &[&Row]) -> Option<String> {
    let [first, ..] = rows else { return None };
    let same = rows.iter().all(|row| row.description == first.description);
    if same {
        return (!first.description.is_empty()).then(|| first.description.clone());
    }
    let parts: Option<Vec<_>> =
        rows.iter().map(|row| row.description.rsplit_once(", axis ")).collect();
    if let Some(parts) = parts
        && parts.iter().all(|(sentence, _)| *sentence == parts[0].0)
    {
        let named = |((_, axis), row): (&(&str, &str), &&Row)| match &row.alias {
            Some(alias) => format!("{axis} ({alias})"),
            None => (*axis).to_owned(),
        };
        let axes: Vec<_> = parts.iter().zip(rows).map(named).collect();
        return Some(format!("{}, axes {}", parts[0].0, axes.join(", ")));
    }
    Some(rows.iter().map(|row| row.description.as_str()).collect::<Vec<_>>().join("; "))
}

fn changing(row: &Row) -> Variability {
    match row.data_type {
        Kind::Real if !row.discrete => Variability::Continuous,
        _ => Variability::Discrete,
    }
}

fn properties(row: &Row, data_type: DataType) -> Properties {
    let bound = |value: f64| match data_type {
        DataType::Float64 => value.is_finite().then_some(Number::Float(value)),
        // Bounds outside the type say nothing.
        DataType::Int32 => integer(value).map(|value| Number::Integer(value.into())),
        _ => None,
    };
    Properties {
        unit: (data_type.is_float() && !row.unit.is_empty()).then(|| row.unit.clone()),
        min: bound(row.min),
        max: bound(row.max),
        ..Properties::default()
    }
}

fn start(row: &Row, data_type: DataType) -> Result<Start, DescribeError> {
    let start = row.start.ok_or_else(|| DescribeError::NoStart { name: row.name.clone() })?;
    let wrong = |rule| DescribeError::Start { name: row.name.clone(), data_type, start, rule };
    match row.data_type {
        Kind::Real if start.is_finite() => Ok(Start::Float(vec![start])),
        Kind::Real => Err(wrong("it must be finite")),
        Kind::Integer => match integer(start) {
            Some(value) => Ok(Start::Integer(vec![value.into()])),
            None => Err(wrong("it must be a whole number of 32 bits")),
        },
        Kind::Boolean if start == 0.0 || start == 1.0 => Ok(Start::Boolean(vec![start == 1.0])),
        Kind::Boolean => Err(wrong("it must be 0 or 1")),
    }
}

/// The value as a 32-bit integer, if it is one.
fn integer(value: f64) -> Option<i32> {
    let is_integer = value.fract() == 0.0;
    let fits = value >= f64::from(i32::MIN) && value <= f64::from(i32::MAX);
    (is_integer && fits).then_some(value as i32)
}

fn add_time(description: &mut ModelDescription, reference: u32) {
    let mut time = Variable::new("time", reference, DataType::Float64);
    time.causality = Causality::Independent;
    time.stated_variability = Some(Variability::Continuous);
    time.description = Some("time in s".to_owned());
    description.variables.push(time);
}

fn add_structure(description: &mut ModelDescription, table: &VariableTable) {
    match description.fmi_version {
        // The table's order is the file's order, so references ascend as 2.0 requires.
        FmiVersion::V2 => {
            let position = |reference| reference + 1;
            for (output, row) in table.with(Role::Output) {
                add_output(description, &position, output, row.initial_dependencies.clone());
            }
        }
        FmiVersion::V3 => {
            let bundles = table.bundles();
            let arrays: HashMap<u32, u32> = bundles
                .iter()
                .flat_map(|bundle| bundle.elements.iter().map(|e| (*e, bundle.elements[0])))
                .collect();
            for bundle in &bundles {
                let rows: Vec<&Row> =
                    bundle.elements.iter().filter_map(|r| table.get(*r)).collect();
                if rows.iter().any(|row| row.causality == Role::Output) {
                    // An array depends on what any of its elements does.
                    let knowns = rows.iter().map(|row| row.initial_dependencies.as_deref());
                    let knowns: Option<Vec<&[u32]>> = knowns.collect();
                    let home = |reference| arrays.get(&reference).copied().unwrap_or(reference);
                    let knowns = knowns.map(|knowns| knowns.concat());
                    add_output(description, &home, bundle.elements[0], knowns);
                }
            }
        }
    }
}

/// Lists an output, which depends on no input at a communication point, and on these value
/// references of the table (`None`: on any) at initialisation; `reference` is how the structure
/// means them.
fn add_output(
    description: &mut ModelDescription,
    reference: &dyn Fn(u32) -> u32,
    output: u32,
    knowns: Option<Vec<u32>>,
) {
    let output = reference(output);
    let dependencies = knowns.map(|knowns| {
        let mut known: Vec<u32> = knowns.into_iter().map(reference).collect();
        known.sort_unstable();
        known.dedup();
        known
    });
    let structure = &mut description.structure;
    structure.outputs.push(Unknown::depending_on(output, Vec::new()));
    structure.initial_unknowns.push(Unknown { dependencies, ..Unknown::new(output) });
}
