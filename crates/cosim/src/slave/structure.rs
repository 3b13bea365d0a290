//! Structural parameters, which set the sizes of arrays (FMI 3.0).

use modeldescription::ModelDescription;
use modeldescription::variable::{Causality, Dimension, Start, Variable};

use super::address::sizes;
use super::value::Value;
use crate::error::Error;
use crate::problem::{Problem, Problems};

/// The description with other values of structural parameters: arrays have the sizes that follow.
/// Arrays whose start values no longer fit lose them: the FMU knows what they are.
///
/// # Errors
/// A name that is no structural parameter, or a value that it does not take.
pub(crate) fn configured(
    slave: &str,
    description: &ModelDescription,
    values: &[(String, Value)],
) -> Result<ModelDescription, Error> {
    let mut description = description.clone();
    for (name, value) in values {
        let refuse = |why: String| -> Error {
            let (slave, variable) = (slave.to_owned(), name.clone());
            Problems::from(Problem::StartValue { slave, variable, value: value.to_string(), why })
                .into()
        };
        let found = description.variables.iter().position(|variable| variable.name == *name);
        let variable = found.and_then(|at| description.variables.get(at)).filter(|variable| {
            variable.causality == Causality::StructuralParameter && variable.dimensions.is_empty()
        });
        let (Some(at), Some(variable)) = (found, variable) else {
            return Err(refuse("there is no structural parameter of this name".to_owned()));
        };
        let Some(Value::Integer(size)) = value.fit(variable.data_type) else {
            return Err(refuse(format!("it is of type {}", variable.data_type.name())));
        };
        let properties = description.properties(variable);
        let limit = |limit: Option<modeldescription::variable::Number>, or: f64| {
            limit.map_or(or, modeldescription::variable::Number::as_f64)
        };
        let (least, most) = (limit(properties.min, 0.0), limit(properties.max, f64::INFINITY));
        if !(least..=most).contains(&(size as f64)) {
            return Err(refuse(format!("it must be from {least} to {most}")));
        }
        if let Some(variable) = description.variables.get_mut(at) {
            variable.start = Some(Start::Integer(vec![size]));
        }
    }
    let stale: Vec<usize> = (0..)
        .zip(&description.variables)
        .filter_map(|(at, variable)| {
            let count = sizes(&description, variable).ok()?.iter().product::<u64>();
            let given = variable.start.as_ref()?.len() as u64;
            let follows = variable.dimensions.iter().any(|d| matches!(d, Dimension::Parameter(_)));
            (follows && given != 1 && given != count).then_some(at)
        })
        .collect();
    for at in stale {
        if let Some(variable) = description.variables.get_mut(at) {
            variable.start = None;
        }
    }
    Ok(description)
}

/// A structural parameter has the value that the FMU was configured with.
pub(super) fn check(slave: &str, variable: &Variable, value: &Value) -> Result<(), Error> {
    let is = match (&variable.start, value.fit(variable.data_type)) {
        (Some(Start::Integer(start)), Some(Value::Integer(value))) => start.first() == Some(&value),
        _ => false,
    };
    if is {
        return Ok(());
    }
    Err(Problems::from(Problem::StartValue {
        slave: slave.to_owned(),
        variable: variable.name.clone(),
        value: value.to_string(),
        why: "it sets sizes of arrays and is given before the instance is made (Fmu::configure)"
            .to_owned(),
    })
    .into())
}
