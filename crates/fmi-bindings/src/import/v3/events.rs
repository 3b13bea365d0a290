//! Events of an FMI 3.0 instance: event mode, clocks, structural parameters.

use std::ptr;

use super::super::error::Error;
use super::instance::Instance;
use crate::fmi3::*;

/// What `fmi3UpdateDiscreteStates` answers, but for what model exchange needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Updated {
    /// Another pass at the same time is needed.
    pub needs_update: bool,
    /// The FMU asks for the end of the simulation.
    pub terminated: bool,
    /// Time of its next time event, s, if it is known.
    pub next_event: Option<f64>,
}

impl Instance {
    /// `fmi3EnterEventMode`
    pub fn enter_event_mode(&mut self) -> Result<(), Error> {
        const CALL: &str = "fmi3EnterEventMode";
        let enter = self.optional(self.events().enter_event_mode, CALL)?;
        self.plain_in_cycle(&CALL, enter)
    }

    /// `fmi3EnterStepMode`
    pub fn enter_step_mode(&mut self) -> Result<(), Error> {
        const CALL: &str = "fmi3EnterStepMode";
        let enter = self.optional(self.events().enter_step_mode, CALL)?;
        self.plain_in_cycle(&CALL, enter)
    }

    /// `fmi3EnterConfigurationMode`
    pub fn enter_configuration_mode(&mut self) -> Result<(), Error> {
        const CALL: &str = "fmi3EnterConfigurationMode";
        let enter = self.optional(self.events().enter_configuration_mode, CALL)?;
        self.plain(&CALL, enter)
    }

    /// `fmi3ExitConfigurationMode`
    pub fn exit_configuration_mode(&mut self) -> Result<(), Error> {
        const CALL: &str = "fmi3ExitConfigurationMode";
        let exit = self.optional(self.events().exit_configuration_mode, CALL)?;
        self.plain(&CALL, exit)
    }

    /// Ends an instant of super-dense time (`fmi3UpdateDiscreteStates`).
    pub fn update_discrete_states(&mut self) -> Result<Updated, Error> {
        const CALL: &str = "fmi3UpdateDiscreteStates";
        let update = self.optional(self.events().update_discrete_states, CALL)?;
        let instance = self.alive(&CALL)?;
        // Read as bytes: a foreign FMU may write other values than 0 and 1.
        let mut flags = [0_u8; 5];
        let mut next = 0.0;
        let [needs, ends, nominals, states, defined] =
            flags.each_mut().map(|flag| ptr::from_mut(flag).cast());
        // SAFETY: the instance is alive; each result has a place of the size of C's `bool`.
        let status =
            unsafe { update(instance, needs, ends, nominals, states, defined, &raw mut next) };
        self.check(CALL, status)?;
        let [needs_update, terminated, _, _, defined] = flags.map(|flag| flag != 0);
        Ok(Updated { needs_update, terminated, next_event: defined.then_some(next) })
    }

    /// Activates input clocks (`fmi3SetClock`).
    pub fn activate_clocks(&mut self, clocks: &[u32]) -> Result<(), Error> {
        const CALL: &str = "fmi3SetClock";
        if clocks.is_empty() {
            return Ok(());
        }
        let set = self.optional(self.events().set_clock, CALL)?;
        let instance = self.alive(&CALL)?;
        let active = vec![fmi3ClockActive; clocks.len()];
        // SAFETY: the instance is alive, both slices have the length given.
        let status = unsafe { set(instance, clocks.as_ptr(), clocks.len(), active.as_ptr()) };
        self.check(CALL, status)
    }

    /// Whether an output clock is active (`fmi3GetClock`).
    pub fn is_active(&mut self, clock: u32) -> Result<bool, Error> {
        const CALL: &str = "fmi3GetClock";
        let get = self.optional(self.events().get_clock, CALL)?;
        let instance = self.alive(&CALL)?;
        let mut active = 0_u8;
        // SAFETY: the instance is alive; one reference and one place of the size of C's `bool`.
        let status = unsafe { get(instance, &raw const clock, 1, (&raw mut active).cast()) };
        self.check(CALL, status)?;
        Ok(active != 0)
    }

    /// The next interval of a time-based clock in s (`fmi3GetIntervalDecimal`), unless it is as it was
    /// or not yet known; the second value tells whether it is known.
    pub fn interval(&mut self, clock: u32) -> Result<(Option<f64>, bool), Error> {
        const CALL: &str = "fmi3GetIntervalDecimal";
        let get = self.optional(self.events().get_interval_decimal, CALL)?;
        let instance = self.alive(&CALL)?;
        let (mut interval, mut qualifier) = (0.0, fmi3IntervalNotYetKnown);
        // SAFETY: the instance is alive; one reference and one place for each result.
        let status =
            unsafe { get(instance, &raw const clock, 1, &raw mut interval, &raw mut qualifier) };
        self.check(CALL, status)?;
        let is_new = qualifier == fmi3IntervalChanged;
        Ok((is_new.then_some(interval), qualifier != fmi3IntervalNotYetKnown))
    }

    /// The delay of a periodic clock's first tick in s (`fmi3GetShiftDecimal`).
    pub fn shift(&mut self, clock: u32) -> Result<f64, Error> {
        const CALL: &str = "fmi3GetShiftDecimal";
        let get = self.optional(self.events().get_shift_decimal, CALL)?;
        let instance = self.alive(&CALL)?;
        let mut shift = 0.0;
        // SAFETY: the instance is alive; one reference and one place.
        let status = unsafe { get(instance, &raw const clock, 1, &raw mut shift) };
        self.check(CALL, status)?;
        Ok(shift)
    }
}
