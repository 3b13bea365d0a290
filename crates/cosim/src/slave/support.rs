//! What slaves of FMI 2.0 and 3.0 have in common.

use std::collections::HashMap;
use std::hint::black_box;

use fmi_bindings::import::{Error as ImportError, OnMessage, SavedState};
use modeldescription::ModelDescription;
use modeldescription::variable::DataType;

use super::selection::Selection;
use super::value::Value;
use super::{Slave, StateId};
use crate::error::Error;

/// What an instance is made with, to make it again.
#[derive(Clone, Default)]
pub(crate) struct Settings {
    pub(crate) name: String,
    pub(crate) visible: bool,
    pub(crate) logging_on: bool,
    pub(crate) on_message: Option<OnMessage>,
    /// Values of structural parameters that the description was configured with.
    pub(crate) structure: Vec<(String, Value)>,
}

/// Room for the numbers that an FMU writes. Behind those it was asked for there is more room, so that
/// an FMU that writes too many hits nothing, and is found out.
pub(super) struct Room {
    fmu: String,
    values: Vec<f64>,
}

/// Values that an FMU may write too many before it hits something.
pub(super) const SPARE: usize = 64;
/// Stands behind the values that are asked for: a NaN that no computation gives.
const MARK: u64 = 0x7ff8_5e7d_0c0f_fee5;

impl Room {
    /// Room for every number of this FMU at once.
    pub(super) fn of(fmu: &str, description: &ModelDescription) -> Self {
        Room { fmu: fmu.to_owned(), values: vec![0.0; description.variables.len() + SPARE] }
    }

    /// Reads `values`; `get` is the FMU's function `call`.
    #[inline]
    pub(super) fn read(
        &mut self,
        call: &'static str,
        values: &mut [f64],
        get: impl FnOnce(&mut [f64]) -> Result<(), ImportError>,
    ) -> Result<(), Error> {
        let asked = values.len();
        if asked + SPARE > self.values.len() {
            self.values.resize(asked + SPARE, 0.0);
        }
        let mark = f64::from_bits(MARK);
        self.values[asked] = mark;
        get(&mut self.values[..asked]).map_err(failed)?;
        if self.values[asked].to_bits() != MARK {
            return Err(self.overrun(call, asked));
        }
        copy(values, &self.values[..asked]);
        Ok(())
    }

    #[cold]
    fn overrun(&self, call: &'static str, asked: usize) -> Error {
        Error::Overrun { fmu: self.fmu.clone(), call, asked }
    }
}

/// So many numbers are copied one by one.
const FEW: usize = 8;

/// Copies what an FMU has just written. Where that is little, number by number, as FMUs write it: a
/// wider load has to wait until the stores of the single numbers have left the processor's store
/// queue (5 ns per step and FMU in `dev/benches/masters.py`), and the compiler would make one.
#[inline]
fn copy(to: &mut [f64], from: &[f64]) {
    if from.len() > FEW {
        to.copy_from_slice(from);
        return;
    }
    for (to, from) in to.iter_mut().zip(from) {
        *to = black_box(*from);
    }
}

/// The error of a call of the FMU, apart so that calls that go well are short.
#[cold]
#[inline(never)]
pub(super) fn failed(error: ImportError) -> Error {
    error.into()
}

/// Saved states by their numbers.
#[derive(Default)]
pub(super) struct States {
    saved: HashMap<StateId, SavedState>,
    next: usize,
}

impl States {
    pub(super) fn is_empty(&self) -> bool {
        self.saved.is_empty()
    }

    pub(super) fn clear(&mut self) {
        self.saved.clear();
    }

    pub(super) fn insert(&mut self, saved: SavedState) -> StateId {
        let state = StateId(self.next);
        self.next += 1;
        self.saved.insert(state, saved);
        state
    }

    pub(super) fn get(&self, fmu: &str, state: StateId) -> Result<&SavedState, Error> {
        self.saved.get(&state).ok_or_else(|| unknown_state(fmu))
    }

    pub(super) fn remove(&mut self, fmu: &str, state: StateId) -> Result<SavedState, Error> {
        self.saved.remove(&state).ok_or_else(|| unknown_state(fmu))
    }
}

fn unknown_state(fmu: &str) -> Error {
    ImportError::UnknownState { fmu: fmu.to_owned() }.into()
}

/// The instance, if there is one.
#[inline]
pub(super) fn instance_of<'a, I>(
    instance: &'a mut Option<I>,
    fmu: &str,
) -> Result<&'a mut I, Error> {
    instance.as_mut().ok_or_else(|| {
        ImportError::Dead { fmu: fmu.to_owned(), call: "a function of a lost instance" }.into()
    })
}

pub(super) fn offers_state(slave: &dyn Slave) -> Result<(), Error> {
    let common = slave.description().co_simulation.as_ref().map(|cs| &cs.common);
    if common.is_some_and(|common| common.can_get_and_set_fmu_state) {
        return Ok(());
    }
    Err(slave.no_state())
}

pub(super) fn offers_bytes(slave: &dyn Slave) -> Result<(), Error> {
    let common = slave.description().co_simulation.as_ref().map(|cs| &cs.common);
    if common.is_some_and(|common| common.can_serialize_fmu_state) {
        return Ok(());
    }
    Err(slave.no_bytes())
}

#[inline]
pub(super) fn same_length(
    fmu: &str,
    call: &'static str,
    selection: &Selection,
    values: usize,
) -> Result<(), Error> {
    if selection.len() == values {
        return Ok(());
    }
    let (fmu, references) = (fmu.to_owned(), selection.len());
    Err(ImportError::Length { fmu, call, references, values }.into())
}

pub(super) fn type_error(fmu: &str, variable: &str, data_type: DataType, value: &Value) -> Error {
    Error::Type {
        fmu: fmu.to_owned(),
        variable: variable.to_owned(),
        data_type: data_type.name(),
        value: value.to_string(),
    }
}

pub(super) fn problem(problem: crate::problem::Problem) -> Error {
    Error::Problems(problem.into())
}
