//! Variables that belong together as one array, for interfaces that have arrays (FMI 3.0).

use alloc::borrow::ToOwned;
use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use crate::{Variable, VariableTable};

/// One variable of an interface with arrays: a scalar or the elements of an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bundle {
    /// Name; of an array without the index: `command`, `axis[1].hysteresis.w`.
    pub name: String,
    /// Whether it is an array, with one dimension.
    pub is_array: bool,
    /// Value references in the table: of the scalar, or of the elements in the order of their
    /// indices. The first one is the value reference of the whole.
    pub elements: Vec<u32>,
}

impl VariableTable {
    /// All variables, those that differ in their last index alone joined to arrays, in the order of
    /// their first elements.
    ///
    /// `command[1]` and `command[2]` become the array `command` of two elements if the indices of a
    /// name are exactly 1 to n, in this order, and all are alike in type, unit, causality and
    /// variability. Otherwise (an axis in um, another in urad) they stay scalars.
    #[must_use]
    pub fn bundles(&self) -> Vec<Bundle> {
        let mut families: BTreeMap<&str, Vec<u32>> = BTreeMap::new();
        for (reference, variable) in (0..).zip(self.as_slice()) {
            if let Some((family, _)) = indexed(&variable.name) {
                families.entry(family).or_default().push(reference);
            }
        }
        families.retain(|family, members| self.is_array(family, members));
        let mut bundles = Vec::with_capacity(self.len());
        for (reference, variable) in (0..).zip(self.as_slice()) {
            let family =
                indexed(&variable.name).and_then(|(family, _)| families.get_key_value(family));
            bundles.push(match family {
                None => Bundle {
                    name: variable.name.clone(),
                    is_array: false,
                    elements: vec![reference],
                },
                Some((family, members)) if members.first() == Some(&reference) => {
                    Bundle { name: (*family).to_owned(), is_array: true, elements: members.clone() }
                }
                Some(_) => continue,
            });
        }
        bundles
    }

    /// Whether the variables of this name, in the order of the table, make an array.
    fn is_array(&self, family: &str, members: &[u32]) -> bool {
        let rows: Vec<&Variable> = members.iter().filter_map(|r| self.get(*r)).collect();
        let in_order = (1..)
            .zip(&rows)
            .all(|(index, row)| indexed(&row.name).is_some_and(|(_, found)| found == index));
        in_order
            && rows.iter().all(|row| alike(row, rows[0]))
            && self.as_slice().iter().all(|other| other.name != family)
    }
}

fn alike(a: &Variable, b: &Variable) -> bool {
    a.data_type == b.data_type
        && a.unit == b.unit
        && a.causality == b.causality
        && a.discrete == b.discrete
}

/// `w[3]` as `w` and 3; `None` for a name that does not end with an index.
fn indexed(name: &str) -> Option<(&str, usize)> {
    let (family, index) = name.strip_suffix(']')?.rsplit_once('[')?;
    let index: usize = index.parse().ok().filter(|index| *index > 0)?;
    (!family.is_empty()).then_some((family, index))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Causality, DataType, Unit};

    fn row(name: &str, unit: &str) -> Variable {
        Variable {
            name: name.into(),
            alias: None,
            description: String::new(),
            data_type: DataType::Real,
            unit: unit.into(),
            si: Unit::ONE,
            causality: Causality::Input,
            discrete: false,
            start: Some(0.0),
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            fit: false,
            initial_dependencies: None,
        }
    }

    fn bundles(names: &[&str]) -> Vec<(String, bool, Vec<u32>)> {
        let rows = names.iter().map(|name| row(name, "V")).collect();
        let bundles = VariableTable::new(rows).bundles();
        bundles.into_iter().map(|b| (b.name, b.is_array, b.elements)).collect()
    }

    fn array(name: &str, elements: &[u32]) -> (String, bool, Vec<u32>) {
        (name.into(), true, elements.into())
    }

    fn scalar(name: &str, reference: u32) -> (String, bool, Vec<u32>) {
        (name.into(), false, vec![reference])
    }

    #[test]
    fn the_last_index_makes_arrays_even_of_scattered_elements() {
        let names = ["u[1]", "u[2]", "a[1].on", "y[1]", "s[1]", "y[2]", "s[2]", "axis[1].w[1]"];
        let wanted = [
            array("u", &[0, 1]),
            scalar("a[1].on", 2),
            array("y", &[3, 5]),
            array("s", &[4, 6]),
            array("axis[1].w", &[7]),
        ];
        assert_eq!(bundles(&names), wanted);
    }

    #[test]
    fn gaps_other_orders_and_taken_names_stay_scalars() {
        assert_eq!(bundles(&["u[2]"]), [scalar("u[2]", 0)]);
        assert_eq!(bundles(&["u[2]", "u[1]"]), [scalar("u[2]", 0), scalar("u[1]", 1)]);
        assert_eq!(bundles(&["u", "u[1]"]), [scalar("u", 0), scalar("u[1]", 1)]);
        assert_eq!(bundles(&["u[0]", "u[x]", "[1]"]).iter().filter(|b| b.1).count(), 0);
        assert_eq!(bundles(&["u[1]", "u[1]"]).iter().filter(|b| b.1).count(), 0);
    }

    #[test]
    fn elements_of_an_array_are_alike() {
        let table = VariableTable::new(vec![row("y[1]", "um"), row("y[2]", "urad")]);
        assert_eq!(table.bundles().len(), 2);
        let mut rows = vec![row("y[1]", "um"), row("y[2]", "um")];
        rows[1].discrete = true;
        assert_eq!(VariableTable::new(rows).bundles().len(), 2);
    }
}
