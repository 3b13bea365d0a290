//! Tables of variables.

use modeldescription::ModelDescription;
use modeldescription::variable::{Causality, DataType, Dimension, Start, Variability, Variable};
use report::{Section, Table};

/// Inputs and outputs, then parameters.
pub(super) fn sections(description: &ModelDescription) -> Vec<Section> {
    let of = |wanted: &[Causality]| -> Vec<&Variable> {
        description.variables.iter().filter(|v| wanted.contains(&v.causality)).collect()
    };
    let ports = of(&[Causality::Input, Causality::Output]);
    let parameters = of(&[Causality::Parameter, Causality::StructuralParameter]);
    let mut all = vec![Section::new("Inputs and outputs").table(table(
        "Inputs and outputs",
        description,
        &ports,
    ))];
    if !parameters.is_empty() {
        all.push(
            Section::new("Parameters")
                .paragraph(
                    "A fixed parameter is set before the initialisation ends; a tunable one may change while \
                     the model runs.",
                )
                .table(table("Parameters", description, &parameters)),
        );
    }
    all
}

/// A row of the table: variables of one array, or one variable.
struct Row<'a> {
    base: &'a str,
    first: &'a Variable,
    /// Indices of the elements, first and last; none for a variable alone.
    elements: Option<(u64, u64)>,
    starts: Vec<String>,
}

pub(super) fn table(caption: &str, description: &ModelDescription, all: &[&Variable]) -> Table {
    let mut rows: Vec<Row<'_>> = Vec::new();
    for variable in all {
        let properties = description.properties(variable);
        let starts = starts(variable);
        let (base, index) = split(&variable.name);
        if let Some(last) = rows.last_mut()
            && let (Some((_, end)), Some(index)) = (last.elements, index)
            && last.base == base
            && end + 1 == index
            && last.first.causality == variable.causality
            && last.first.description == variable.description
            && description.properties(last.first) == properties
        {
            last.elements = last.elements.map(|(first, _)| (first, index));
            last.starts.extend(starts);
            continue;
        }
        let size = match variable.dimensions.as_slice() {
            [Dimension::Size(size)] if *size > 1 => Some((1, *size)),
            _ => None,
        };
        rows.push(Row {
            base: if index.is_some() { base } else { &variable.name },
            first: variable,
            elements: index.map(|k| (k, k)).or(size),
            starts,
        });
    }
    let columns = ["name", "what", "start", "range", "unit", "meaning"];
    rows.iter().fold(Table::new(caption, columns), |table, row| {
        let properties = description.properties(row.first);
        let bound = |number: Option<modeldescription::variable::Number>| {
            number.map(|number| report::format_number(number.as_f64(), 6))
        };
        let range = match (bound(properties.min), bound(properties.max)) {
            _ if row.first.data_type == DataType::Boolean => "false, true".to_owned(),
            (Some(min), Some(max)) => format!("{min} … {max}"),
            (Some(min), None) => format!("≥ {min}"),
            (None, Some(max)) => format!("≤ {max}"),
            (None, None) => "any".to_owned(),
        };
        let name = match row.elements {
            Some((first, last)) if last > first => format!("{}[{first}…{last}]", row.base),
            _ => row.first.name.clone(),
        };
        table.row([
            name,
            what(row.first).to_owned(),
            shown(&row.starts),
            range,
            report::format_unit(properties.unit.as_deref().unwrap_or("1")),
            row.first.description.clone().unwrap_or_default(),
        ])
    })
}

/// `axis[1].hysteresis.w` and 3 of `axis[1].hysteresis.w[3]`.
fn split(name: &str) -> (&str, Option<u64>) {
    let parts = name.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    match parts.and_then(|(base, index)| Some((base, index.parse().ok()?))) {
        Some((base, index)) => (base, Some(index)),
        None => (name, None),
    }
}

fn what(variable: &Variable) -> &'static str {
    match (variable.causality, variable.stated_variability) {
        (Causality::Input, _) => "input",
        (Causality::Output, _) => "output",
        (Causality::Parameter, Some(Variability::Tunable)) => "tunable",
        (Causality::Parameter, _) => "fixed",
        _ => "structural",
    }
}

fn starts(variable: &Variable) -> Vec<String> {
    let number = |x: &f64| report::format_number(*x, 6);
    match &variable.start {
        Some(Start::Float(values)) => values.iter().map(number).collect(),
        Some(Start::Integer(values)) => values.iter().map(ToString::to_string).collect(),
        Some(Start::Boolean(values)) => values.iter().map(ToString::to_string).collect(),
        Some(Start::Text(values)) => values.clone(),
        Some(Start::Binary(values)) => {
            values.iter().map(|v| format!("{} bytes", v.len())).collect()
        }
        None => Vec::new(),
    }
}

/// All start values of an array, or as many as a cell holds.
fn shown(starts: &[String]) -> String {
    const MOST: usize = 6;
    match starts {
        [first, rest @ ..] if rest.len() >= MOST && rest.iter().all(|s| s == first) => {
            format!("{first} (all)")
        }
        [.., last] if starts.len() > MOST => {
            format!("{}, …, {last}", starts[..MOST - 2].join(", "))
        }
        all => all.join(", "),
    }
}
