//! Variables chosen by name, once, to be read or written many times.

use std::ops::Range;

use modeldescription::ModelDescription;
use modeldescription::variable::{DataType, Variable};

use crate::problem::{Problem, nearest};

/// Some number-valued variables of one slave, in an order of the user's choice.
///
/// Values travel as `f64`: exact for reals, 32-bit integers and booleans (0 and 1).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    names: Vec<String>,
    references: Vec<u32>,
    runs: Vec<TypeRun>,
}

/// Neighbours of one type, which one call of the C interface can read or write.
#[derive(Clone, Debug, PartialEq)]
pub struct TypeRun {
    /// Their type.
    pub data_type: DataType,
    /// Their places in the selection.
    pub range: Range<usize>,
}

impl Selection {
    /// Adds a variable; its place is the return value.
    ///
    /// # Errors
    /// A text, a binary or a clock is no number; an array is not one number.
    pub fn add(&mut self, slave: &str, variable: &Variable) -> Result<usize, Problem> {
        if !Selection::takes(variable) {
            let array = if variable.dimensions.is_empty() { "" } else { "array of " };
            return Err(Problem::WrongRole {
                slave: slave.to_owned(),
                variable: variable.name.clone(),
                is: format!("of type {array}{}", variable.data_type.name()),
                must_be: "a number",
                role: "be connected or recorded".to_owned(),
            });
        }
        let place = self.references.len();
        self.names.push(variable.name.clone());
        self.references.push(variable.value_reference);
        match self.runs.last_mut() {
            Some(run) if run.data_type == variable.data_type => run.range.end += 1,
            _ => self.runs.push(TypeRun { data_type: variable.data_type, range: place..place + 1 }),
        }
        Ok(place)
    }

    /// Whether a variable is one number.
    pub fn takes(variable: &Variable) -> bool {
        let text =
            matches!(variable.data_type, DataType::String | DataType::Binary | DataType::Clock);
        !text && variable.dimensions.is_empty()
    }

    /// Number of variables.
    pub fn len(&self) -> usize {
        self.references.len()
    }

    /// Whether nothing is selected.
    pub fn is_empty(&self) -> bool {
        self.references.is_empty()
    }

    /// Names, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Value references, in order.
    pub fn references(&self) -> &[u32] {
        &self.references
    }

    /// Runs of one type, in order; together they are the whole selection.
    pub fn runs(&self) -> &[TypeRun] {
        &self.runs
    }

    /// Place of a name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|there| there == name)
    }
}

/// The variable of a slave by its name, or the problem with names like it.
pub(crate) fn find<'a>(
    slave: &str,
    description: &'a ModelDescription,
    name: &str,
) -> Result<&'a Variable, Problem> {
    description.variable(name).ok_or_else(|| Problem::NoSuchVariable {
        slave: slave.to_owned(),
        variable: name.to_owned(),
        near: nearest(name, description.variables.iter().map(|v| v.name.as_str())),
    })
}
