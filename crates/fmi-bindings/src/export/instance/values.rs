//! Getting and setting.

use model::{Causality, DataType, Gate, SetError, Variable};

use super::Instance;
use crate::export::notice::{Notice, Outcome};
use crate::export::phase::Phase;

impl Instance {
    /// Reads values of one type; `write` gets position and value. Nothing is written on failure.
    #[inline]
    pub(in crate::export) fn get(
        &mut self,
        wanted: DataType,
        references: &[u32],
        mut write: impl FnMut(usize, f64),
    ) -> Outcome {
        if self.progress.stale && self.progress.phase == Phase::Initialization {
            self.settle()?;
        }
        let values = self.system.values();
        let is_usual =
            wanted == DataType::Real && references.iter().all(|reference| *reference < self.reals);
        if !is_usual {
            for reference in references {
                if self.gate(*reference, wanted).is_none() {
                    return Err(self.mismatch(*reference, wanted));
                }
            }
        }
        for (at, reference) in references.iter().enumerate() {
            // Each variable that has a gate has a value.
            let Some(value) = values.get(*reference as usize) else { break };
            write(at, *value);
        }
        Ok(())
    }

    /// Sets values of one type, as many as there are references. Nothing is set on failure.
    #[inline]
    pub(in crate::export) fn set(
        &mut self,
        wanted: DataType,
        references: &[u32],
        values: impl Iterator<Item = f64> + Clone,
    ) -> Outcome {
        // The usual call sets inputs, which take each finite number.
        let mut all = references.iter().zip(values.clone());
        if wanted == DataType::Real
            && all.all(|(to, value)| *to < self.real_inputs && value.abs() <= f64::MAX)
        {
            for (reference, value) in references.iter().zip(values) {
                self.system.put_input(*reference, value);
            }
            self.follow();
            return Ok(());
        }
        for (reference, value) in references.iter().zip(values.clone()) {
            if !self.takes(*reference, wanted, value) {
                return Err(self.not_taken(*reference, wanted, value));
            }
        }
        for (reference, value) in references.iter().zip(values) {
            self.system.put(*reference, value);
        }
        self.follow();
        Ok(())
    }

    /// What a variable with this reference and type admits.
    #[inline]
    pub(super) fn gate(&self, reference: u32, wanted: DataType) -> Option<&Gate> {
        self.system.variables().gate(reference).filter(|gate| gate.data_type == wanted)
    }

    /// Whether a variable has this type and may be set to this value now.
    #[inline]
    pub(super) fn takes(&self, reference: u32, wanted: DataType, value: f64) -> bool {
        self.gate(reference, wanted).is_some_and(|gate| {
            let fixed = gate.causality == Causality::FixedParameter;
            gate.takes(value) && !(fixed && self.progress.phase == Phase::Step)
        })
    }

    /// Outputs follow from now on what was set, where there was no step yet.
    #[inline]
    pub(super) fn follow(&mut self) {
        self.progress.stale |= self.progress.phase != Phase::Step;
    }

    /// Why [`takes`](Self::takes) refuses.
    #[cold]
    pub(super) fn not_taken(&self, reference: u32, wanted: DataType, value: f64) -> Notice {
        let variable = match self.typed(reference, wanted) {
            Ok(variable) => variable,
            Err(notice) => return notice,
        };
        if variable.causality == Causality::FixedParameter && self.progress.phase == Phase::Step {
            let problem = format!(
                "{value} comes too late: a fixed parameter is set before the simulation; reset \
                 the instance and set it then"
            );
            return self.refused(variable, reference, &problem);
        }
        match self.system.check(reference, value) {
            Err(error) => self.not_set(&error),
            Ok(()) => self.refused(variable, reference, &format!("{value} cannot be set")),
        }
    }

    /// Gives inputs a slope, in their unit per second, in the next step. Nothing is set on failure.
    pub(in crate::export) fn set_slopes(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Outcome {
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            let variable = self.typed(*reference, DataType::Real)?;
            let problem = if variable.causality != Causality::Input || variable.discrete {
                "is no continuous input; only those have derivatives that can be set".to_string()
            } else if *order != 1 {
                format!("derivative of order {order}: inputs move on straight lines, give order 1")
            } else if !value.is_finite() {
                format!("derivative {value} is not a finite number; set a finite one")
            } else {
                continue;
            };
            return Err(self.refused(variable, *reference, &problem));
        }
        for (reference, value) in references.iter().zip(values) {
            self.slopes[*reference as usize] = *value;
        }
        self.progress.sloped = true;
        Ok(())
    }

    /// The variable with this reference and type.
    pub(super) fn typed(&self, reference: u32, wanted: DataType) -> Result<&Variable, Notice> {
        match self.system.variables().get(reference) {
            Some(variable) if variable.data_type == wanted => Ok(variable),
            _ => Err(self.mismatch(reference, wanted)),
        }
    }

    /// The variable with this reference is of another type, or there is none.
    #[cold]
    pub(super) fn mismatch(&self, reference: u32, wanted: DataType) -> Notice {
        self.unknown(reference, self.type_name(wanted))
    }

    fn of_other_type(&self, variable: &Variable, reference: u32, wanted: &str) -> Notice {
        let own = self.type_name(variable.data_type);
        let problem = format!("is of type {own}, not {wanted}; use the functions of its type");
        self.refused(variable, reference, &problem)
    }

    /// A reference that no variable of this type has.
    #[cold]
    pub(in crate::export) fn unknown(&self, reference: u32, type_name: &str) -> Notice {
        let (home, number) = self.layout.home(reference);
        match self.system.variables().get(reference) {
            Some(variable) if home != reference => Notice::error(format!(
                "value reference {reference} is unknown; {} is element {} of the array with the \
                 value reference {home}, which is read and set as a whole",
                variable.name,
                number.unwrap_or(1)
            )),
            Some(variable) => self.of_other_type(variable, reference, type_name),
            None if self.time_reference == Some(reference) => Notice::error(format!(
                "time (value reference {reference}): the independent variable is of type Float64 \
                 and is only read; the communication points set it"
            )),
            None => Notice::error(format!(
                "value reference {reference} is unknown; this model has the references 0 to {}",
                self.system.variables().len().saturating_sub(1)
            )),
        }
    }

    /// The message about a value that the model does not take.
    #[cold]
    pub(super) fn not_set(&self, error: &SetError) -> Notice {
        let (reference, problem) = match *error {
            SetError::Unknown { reference, .. } => return self.unknown(reference, "Real"),
            SetError::NotSettable { reference } => {
                (reference, "is an output and cannot be set; set inputs and parameters".to_string())
            }
            SetError::NotFinite { reference, value } => {
                (reference, format!("{value} is not a finite number; set a finite one"))
            }
            SetError::OutOfRange { reference, value, min, max } => {
                (reference, format!("{value} is outside {min} to {max}; set a value inside"))
            }
        };
        match self.system.variables().get(reference) {
            Some(variable) => self.refused(variable, reference, &problem),
            None => self.unknown(reference, "Real"),
        }
    }

    /// What this version of the standard calls a type.
    pub(super) fn type_name(&self, data_type: DataType) -> &'static str {
        match (data_type, self.time_reference.is_some()) {
            (DataType::Boolean, _) => "Boolean",
            (DataType::Real, false) => "Real",
            (DataType::Real, true) => "Float64",
            (DataType::Integer, false) => "Integer",
            (DataType::Integer, true) => "Int32",
        }
    }

    /// A message about a variable of the model, with the value reference under which the importer
    /// knows it.
    #[cold]
    pub(super) fn refused(&self, variable: &Variable, reference: u32, problem: &str) -> Notice {
        let name = &variable.name;
        Notice::error(match self.layout.home(reference) {
            (home, None) => format!("{name} (value reference {home}): {problem}"),
            (home, Some(number)) => {
                format!("{name} (element {number} of value reference {home}): {problem}")
            }
        })
    }
}
