//! Names of variables and of elements of arrays.

use modeldescription::variable::{Causality, DataType, Dimension, Start, Variable};
use modeldescription::{FmiVersion, ModelDescription};

use super::clocks::can_be_triggered;
use crate::problem::{Problem, nearest};

/// Arrays with more elements are not taken apart.
const MOST_ELEMENTS: u64 = 1 << 24;
/// Arrays with more elements are not recorded unless one asks for them.
const MOST_LISTED: u64 = 1 << 10;
/// Names that a note lists.
const MOST_NAMED: usize = 8;

/// A variable, or an element of an array as if it were a variable of its own.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Address {
    /// The variable; of an element, the array's declaration with the element's name and without
    /// dimensions.
    pub(crate) variable: Variable,
    /// The element, if it is one.
    pub(crate) element: Option<Element>,
    /// Only what a double leaves of a whole number of 64 bits; the value itself stands before it.
    pub(crate) is_rest: bool,
}

/// Ends the name of a [rest](Address::is_rest); no name of a variable has it.
const REST: char = '\u{0}';

/// An element of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Element {
    /// The element's place, from 0, in row-major order.
    pub(crate) index: usize,
    /// Number of elements of the array.
    pub(crate) size: usize,
}

impl Address {
    /// A whole variable.
    pub(crate) fn of(variable: &Variable) -> Self {
        Address { variable: variable.clone(), element: None, is_rest: false }
    }

    /// What a double leaves of it; none where doubles leave nothing.
    pub(crate) fn rest(&self, description: &ModelDescription) -> Option<Self> {
        let is_long = description.fmi_version == FmiVersion::V3
            && matches!(self.variable.data_type, DataType::Int64 | DataType::UInt64);
        let mut rest = (is_long && self.element.is_none()).then(|| self.clone())?;
        rest.variable.name.push(REST);
        rest.is_rest = true;
        Some(rest)
    }

    /// The name of the variable that this is the rest of.
    fn variable_name(name: &str) -> Option<&str> {
        name.strip_suffix(REST)
    }

    /// The variable of a slave by its name, or the problem with names like it.
    pub(crate) fn find(
        slave: &str,
        description: &ModelDescription,
        name: &str,
    ) -> Result<Address, Problem> {
        Address::find_by(slave, description, name, |name| description.variable(name))
    }

    /// [`Address::find`] with a faster way to find a variable of the description.
    pub(super) fn find_by<'d>(
        slave: &str,
        description: &'d ModelDescription,
        name: &str,
        variable: impl Fn(&str) -> Option<&'d Variable>,
    ) -> Result<Address, Problem> {
        if let Some(variable) = variable(name) {
            return Ok(Address::of(variable));
        }
        if let Some(rest) = Address::variable_name(name)
            .and_then(&variable)
            .and_then(|variable| Address::of(variable).rest(description))
        {
            return Ok(rest);
        }
        let found = indexed(name)
            .and_then(|(array, indices)| Some((variable(array)?, indices)))
            .filter(|(array, _)| !array.dimensions.is_empty());
        let Some((array, indices)) = found else {
            return Err(Problem::NoSuchVariable {
                slave: slave.to_owned(),
                variable: name.to_owned(),
                near: nearest(name, description.variables.iter().map(|v| v.name.as_str())),
            });
        };
        let element = element(description, array, &indices).map_err(|why| {
            let (slave, array) = (slave.to_owned(), array.name.clone());
            Problem::NoSuchElement { slave, array, element: name.to_owned(), why }
        })?;
        let mut variable = array.clone();
        name.clone_into(&mut variable.name);
        variable.dimensions.clear();
        variable.start = array.start.as_ref().and_then(|start| start_of(start, element.index));
        Ok(Address { variable, element: Some(element), is_rest: false })
    }
}

/// The names by which the values of a variable are connected and recorded: its own, or those of an
/// array's elements in row-major order; none where there are no numbers, or too many to list. An input
/// clock that ticks by itself is not connected.
pub(crate) fn numbers(description: &ModelDescription, variable: &Variable) -> Vec<String> {
    let is_timed = variable.data_type == DataType::Clock
        && variable.causality == Causality::Input
        && !can_be_triggered(description, variable);
    if is_timed || matches!(variable.data_type, DataType::String | DataType::Binary) {
        return Vec::new();
    }
    if variable.dimensions.is_empty() {
        return vec![variable.name.clone()];
    }
    let sizes = sizes(description, variable).unwrap_or_default();
    if sizes.is_empty() || sizes.iter().product::<u64>() > MOST_LISTED {
        return Vec::new();
    }
    let indices = sizes.iter().fold(vec![String::new()], |heads, size| {
        let longer = |head: &String, index| match head.as_str() {
            "" => format!("{index}"),
            head => format!("{head},{index}"),
        };
        heads.iter().flat_map(|head| (1..=*size).map(move |index| longer(head, index))).collect()
    });
    indices.iter().map(|index| format!("{}[{index}]", variable.name)).collect()
}

/// What a record of all outputs leaves out of an FMU: texts, bytes, and arrays that are too long to list.
#[must_use]
pub fn unrecorded(fmu: &str, description: &ModelDescription) -> Option<String> {
    let outputs = description.variables.iter().filter(|v| v.causality == Causality::Output);
    let left: Vec<String> = outputs
        .filter(|output| numbers(description, output).is_empty())
        .map(|output| format!("`{}` ({})", output.name, output.data_type.name()))
        .collect();
    let shown = left.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join(", ");
    let more = if left.len() > MOST_NAMED { ", …" } else { "" };
    (!left.is_empty())
        .then(|| format!("FMU `{fmu}`: a record holds numbers only; not recorded: {shown}{more}"))
}

/// `matrix[2,3]` is `matrix` and 2, 3.
fn indexed(name: &str) -> Option<(&str, Vec<u64>)> {
    let (array, indices) = name.strip_suffix(']')?.rsplit_once('[')?;
    let indices: Option<Vec<u64>> = indices.split(',').map(|i| i.trim().parse().ok()).collect();
    Some((array, indices?))
}

/// Sizes of an array's dimensions, with the start values of structural parameters.
pub(super) fn sizes(description: &ModelDescription, array: &Variable) -> Result<Vec<u64>, String> {
    let size = |dimension: &Dimension| match dimension {
        Dimension::Size(size) => Ok(*size),
        Dimension::Parameter(reference) => {
            let parameter = description.referenced(*reference);
            let start = parameter.and_then(|parameter| parameter.start.as_ref());
            match start {
                Some(Start::Integer(values)) => {
                    values.first().and_then(|value| u64::try_from(*value).ok())
                }
                _ => None,
            }
            .ok_or_else(|| format!("the size, value reference {reference}, has no start value"))
        }
    };
    let sizes = array.dimensions.iter().map(size).collect::<Result<Vec<u64>, String>>()?;
    let count = sizes.iter().try_fold(1_u64, |count, size| count.checked_mul(*size));
    match count {
        Some(count) if count <= MOST_ELEMENTS => Ok(sizes),
        _ => Err(format!("it has more than {MOST_ELEMENTS} elements")),
    }
}

fn element(
    description: &ModelDescription,
    array: &Variable,
    indices: &[u64],
) -> Result<Element, String> {
    let sizes = sizes(description, array)?;
    let shown = sizes.iter().map(u64::to_string).collect::<Vec<_>>().join(" x ");
    let fits = indices.len() == sizes.len()
        && indices.iter().zip(&sizes).all(|(index, size)| (1..=*size).contains(index));
    if !fits {
        return Err(format!("the array has {shown} elements, counted from 1"));
    }
    let index = indices.iter().zip(&sizes).fold(0, |at, (index, size)| at * size + (index - 1));
    let size = sizes.iter().product::<u64>();
    Ok(Element { index: index as usize, size: size as usize })
}

/// The start value of an element; one value may stand for all.
fn start_of(start: &Start, index: usize) -> Option<Start> {
    let at = if start.len() == 1 { 0 } else { index };
    Some(match start {
        Start::Float(values) => Start::Float(vec![*values.get(at)?]),
        Start::Integer(values) => Start::Integer(vec![*values.get(at)?]),
        Start::Boolean(values) => Start::Boolean(vec![*values.get(at)?]),
        Start::Text(values) => Start::Text(vec![values.get(at)?.clone()]),
        Start::Binary(values) => Start::Binary(vec![values.get(at)?.clone()]),
    })
}

#[cfg(test)]
mod tests {
    use modeldescription::FmiVersion;

    use super::*;

    fn description() -> ModelDescription {
        let mut description = ModelDescription::new(FmiVersion::V3, "m", "t");
        let mut size = Variable::new("n", 1, DataType::UInt64);
        size.start = Some(Start::Integer(vec![3]));
        let mut matrix = Variable::new("matrix", 2, DataType::Float64);
        matrix.dimensions = vec![Dimension::Size(2), Dimension::Parameter(1)];
        matrix.start = Some(Start::Float(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
        description.variables = vec![size, matrix, Variable::new("plain[1]", 3, DataType::Float64)];
        description
    }

    fn found(name: &str) -> Result<Address, String> {
        Address::find("p", &description(), name).map_err(|problem| problem.to_string())
    }

    #[test]
    fn elements_are_counted_from_one_in_row_major_order() {
        let address = found("matrix[2,3]").unwrap();
        assert_eq!(address.element, Some(Element { index: 5, size: 6 }));
        assert_eq!(address.variable.start, Some(Start::Float(vec![6.0])));
        assert_eq!(found("matrix[1, 2]").unwrap().element.unwrap().index, 1);
        // A variable that is called like an element is a variable.
        assert_eq!(found("plain[1]").unwrap().element, None);
    }

    #[test]
    fn an_array_is_listed_by_its_elements() {
        let mut description = description();
        let listed = |description: &ModelDescription, at: usize| {
            numbers(description, &description.variables[at])
        };
        let matrix = ["[1,1]", "[1,2]", "[1,3]", "[2,1]", "[2,2]", "[2,3]"];
        assert_eq!(listed(&description, 1), matrix.map(|index| format!("matrix{index}")));
        assert!(listed(&description, 1).iter().all(|name| found(name).is_ok()));
        assert_eq!(listed(&description, 2), ["plain[1]"]);
        description.variables[1].dimensions = vec![Dimension::Size(5000)];
        assert!(listed(&description, 1).is_empty());
        description.variables[2].data_type = DataType::String;
        assert!(listed(&description, 2).is_empty());
        assert_eq!(unrecorded("p", &description), None);
        description.variables.iter_mut().for_each(|v| v.causality = Causality::Output);
        let note = unrecorded("p", &description).unwrap();
        assert!(note.ends_with("not recorded: `matrix` (Float64), `plain[1]` (String)"), "{note}");
    }

    #[test]
    fn what_is_no_element_is_reported() {
        for name in ["matrix[0,1]", "matrix[1,4]", "matrix[1]", "matrix[1,1,1]"] {
            let text = found(name).unwrap_err();
            assert!(text.contains("2 x 3 elements, counted from 1"), "{text}");
        }
        for name in ["matrix[a]", "plain[2]", "matrix[1,2"] {
            assert!(found(name).unwrap_err().contains("has no variable"), "{name}");
        }
    }
}
