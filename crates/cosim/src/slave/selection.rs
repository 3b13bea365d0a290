//! Variables chosen by name, once, to be read or written many times.

use std::collections::HashMap;
use std::ops::Range;

use modeldescription::ModelDescription;
use modeldescription::variable::{DataType, Variable};

use super::address::Address;
use super::index::Index;
use crate::error::Error;
use crate::problem::Problem;

/// Some number-valued variables of one slave, in an order of the user's choice.
///
/// Values travel as `f64`: exact for reals, 32-bit integers and booleans (0 and 1); whole numbers of
/// 64 bits that are connected to such ones as two, the nearest double and the rest. An element of
/// an FMI 3.0 array is one of the variables, by the array's name and its place, counted from 1:
/// `command[1]`, `matrix[2,3]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    names: Vec<String>,
    references: Vec<u32>,
    runs: Vec<TypeRun>,
    /// The first place of each name.
    places: HashMap<String, usize>,
}

/// Neighbours of one type, which one call of the C interface can read or write.
#[derive(Clone, Debug, PartialEq)]
pub struct TypeRun {
    /// Type of these variables.
    pub data_type: DataType,
    /// Places of these variables in the selection.
    pub range: Range<usize>,
    /// The array that they are elements of; none: they are scalars.
    pub array: Option<ArrayRun>,
    /// Whole numbers of 64 bits as two values each: the nearest double, and what is left.
    pub is_split: bool,
}

/// Some elements of one array.
#[derive(Clone, Debug, PartialEq)]
pub struct ArrayRun {
    /// Value reference of the array.
    pub reference: u32,
    /// Number of its elements.
    pub size: usize,
    /// The elements, counted from 0 in row-major order.
    pub indices: Vec<usize>,
}

impl ArrayRun {
    /// Whether these are all elements, in their order.
    pub fn is_complete(&self) -> bool {
        self.indices.len() == self.size && self.indices.iter().enumerate().all(|(i, e)| i == *e)
    }
}

impl Selection {
    /// The variables of these names.
    ///
    /// # Errors
    /// All names that the description does not have, or that mean no number.
    pub fn of(description: &ModelDescription, names: &[impl AsRef<str>]) -> Result<Self, Error> {
        let mut selection = Selection::default();
        let mut problems = Vec::new();
        let index = Index::default();
        for name in names {
            let added = index
                .find(&description.model_name, description, name.as_ref())
                .and_then(|address| selection.add_address(&description.model_name, &address));
            problems.extend(added.err());
        }
        Ok(crate::problem::Problems::none_or(problems, selection)?)
    }

    /// Adds a variable; its place is the return value.
    ///
    /// # Errors
    /// A text or a binary is no number; an array is not one number.
    pub fn add(&mut self, slave: &str, variable: &Variable) -> Result<usize, Problem> {
        self.add_address(slave, &Address::of(variable))
    }

    /// Adds a variable or an element of an array; its place is the return value.
    pub(crate) fn add_address(&mut self, slave: &str, address: &Address) -> Result<usize, Problem> {
        let Address { variable, element, is_rest } = address;
        if !Selection::takes(variable) {
            return Err(no_number(slave, variable));
        }
        let place = self.references.len();
        self.names.push(variable.name.clone());
        self.places.entry(variable.name.clone()).or_insert(place);
        self.references.push(variable.value_reference);
        if *is_rest {
            self.split_last();
            return Ok(place);
        }
        let fits = |run: &&mut TypeRun| run.data_type == variable.data_type && !run.is_split;
        match (self.runs.last_mut().filter(fits), element) {
            (Some(TypeRun { array: None, range, .. }), None) => range.end += 1,
            (Some(TypeRun { array: Some(array), range, .. }), Some(element))
                if array.reference == variable.value_reference =>
            {
                range.end += 1;
                array.indices.push(element.index);
            }
            (_, element) => self.runs.push(TypeRun {
                data_type: variable.data_type,
                range: place..place + 1,
                array: element.map(|element| ArrayRun {
                    reference: variable.value_reference,
                    size: element.size,
                    indices: vec![element.index],
                }),
                is_split: false,
            }),
        }
        Ok(place)
    }

    /// The last variable is one of two values, of which the second has just been added.
    fn split_last(&mut self) {
        let Some(last) = self.runs.last_mut() else { return };
        let (data_type, end) = (last.data_type, last.range.end);
        last.range.end -= 1;
        if last.range.is_empty() {
            self.runs.pop();
        }
        match self.runs.last_mut().filter(|run| run.is_split && run.data_type == data_type) {
            Some(run) => run.range.end = end + 1,
            None => self.runs.push(TypeRun {
                data_type,
                range: end - 1..end + 1,
                array: None,
                is_split: true,
            }),
        }
    }

    /// Whether a variable is one number; a clock is 1 where it ticks, else 0.
    pub fn takes(variable: &Variable) -> bool {
        let text = matches!(variable.data_type, DataType::String | DataType::Binary);
        !text && variable.dimensions.is_empty()
    }

    /// Some neighbours of a run, counted from its begin, as a selection of their own.
    pub(crate) fn part(&self, run: &TypeRun, places: Range<usize>) -> Selection {
        let range = run.range.start + places.start..run.range.start + places.end;
        let array = run.array.as_ref().map(|array| ArrayRun {
            indices: array.indices.get(places.clone()).unwrap_or_default().to_vec(),
            ..array.clone()
        });
        let names = self.names.get(range.clone()).unwrap_or_default().to_vec();
        Selection {
            places: names.iter().cloned().zip(0..).collect(),
            names,
            references: self.references.get(range).unwrap_or_default().to_vec(),
            runs: vec![TypeRun {
                data_type: run.data_type,
                range: 0..places.len(),
                array,
                is_split: run.is_split,
            }],
        }
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

    /// Value references, in order; elements of an array repeat the array's.
    pub fn references(&self) -> &[u32] {
        &self.references
    }

    /// Runs of one type, in order; together they are the whole selection.
    pub fn runs(&self) -> &[TypeRun] {
        &self.runs
    }

    /// Whether all are scalars of type Float64, which one call of the C interface reads or writes.
    #[inline]
    pub(crate) fn is_float64(&self) -> bool {
        let [run] = &self.runs[..] else { return false };
        run.data_type == DataType::Float64 && run.array.is_none()
    }

    /// Place of a name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }
}

fn no_number(slave: &str, variable: &Variable) -> Problem {
    let is_array = !variable.dimensions.is_empty();
    let array = if is_array { "array of " } else { "" };
    let must_be = if is_array { "one number, such as an element `name[1]`" } else { "a number" };
    Problem::WrongRole {
        slave: slave.to_owned(),
        variable: variable.name.clone(),
        is: format!("of type {array}{}", variable.data_type.name()),
        must_be,
        role: "be connected or recorded".to_owned(),
    }
}
