//! Variables by name without walking through all of them.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use modeldescription::ModelDescription;
use modeldescription::variable::Variable;

use super::address::Address;
use crate::problem::Problem;

/// Name to place, the first of a name counts; aliases come behind all names.
type Places = HashMap<String, usize>;

/// An index for each description that is asked, made when it is asked first. The descriptions stay what
/// and where they are as long as this lives.
#[derive(Default)]
pub(crate) struct Index(RefCell<HashMap<*const ModelDescription, Rc<Places>>>);

impl Index {
    fn of(&self, description: &ModelDescription) -> Rc<Places> {
        let mut indices = self.0.borrow_mut();
        let entry = indices.entry(std::ptr::from_ref(description));
        Rc::clone(entry.or_insert_with(|| Rc::new(places(description))))
    }

    /// The variable of this name; none where there is none.
    pub(crate) fn variable<'d>(
        &self,
        description: &'d ModelDescription,
        name: &str,
    ) -> Option<&'d Variable> {
        description.variables.get(*self.of(description).get(name)?)
    }

    /// The variable of this name, or the element of an array ([`Address::find`]).
    pub(crate) fn find(
        &self,
        slave: &str,
        description: &ModelDescription,
        name: &str,
    ) -> Result<Address, Problem> {
        Address::find_by(slave, description, name, |name| self.variable(description, name))
    }
}

fn places(description: &ModelDescription) -> Places {
    let mut places = HashMap::with_capacity(description.variables.len());
    for (place, variable) in description.variables.iter().enumerate() {
        places.entry(variable.name.clone()).or_insert(place);
    }
    for (place, variable) in description.variables.iter().enumerate() {
        for alias in &variable.aliases {
            places.entry(alias.name.clone()).or_insert(place);
        }
    }
    places
}
