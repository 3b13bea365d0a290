//! Events of an FMI 3.0 slave in co-simulation: event mode between and within communication steps.
//!
//! A communication step of the master is as many steps of the FMU as there are events in it. An event
//! is where a clock ticks, where the FMU asks for one (`eventHandlingNeeded`, `nextEventTime`), and
//! where the master changes a discrete input, a tunable parameter or ticks a triggered clock.

use std::collections::{HashMap, HashSet};

use fmi_bindings::import::StepResult;
use fmi_bindings::import::v3::Instance;
use modeldescription::variable::{Causality, DataType, Variability, Variable};
use modeldescription::{FmiVersion, ModelDescription};
use serde::{Deserialize, Serialize};

use super::clocks::Clocks;
use super::selection::{Selection, TypeRun};
use crate::error::Error;

/// Instants of super-dense time at one event; more are an FMU that does not settle.
const MOST_PASSES: usize = 1000;
/// Times closer than this part of a step are the same.
const ROUNDING: f64 = 1e-9;

/// Writes the variables of a selection.
pub(super) type Write<'a> = dyn FnMut(&mut Instance, &Selection, &[f64]) -> Result<(), Error> + 'a;

/// The events of one slave that uses event mode.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Events {
    /// The FMU has event mode; without, it only may return early.
    has_mode: bool,
    clocks: Clocks,
    /// The FMU takes steps of any length.
    any_step: bool,
    /// Time of the FMU's next time event in s.
    next_event: Option<f64>,
    /// Clocks that have ticked since the step began.
    ticked: Vec<u32>,
    /// Somebody sets inputs: a tick at a communication point waits for those of that point.
    fed: bool,
    /// Triggered clocks that tick at the next event.
    #[serde(skip)]
    requested: Vec<u32>,
    /// Inputs and tunable parameters that may change at events only.
    discrete: HashSet<u32>,
    /// What the master has set last of runs with such variables, by value reference.
    #[serde(skip)]
    held: HashMap<u32, Held>,
}

/// Values of a variable, which may wait for an event.
#[derive(Clone, Debug)]
struct Held {
    selection: Selection,
    values: Vec<f64>,
    /// Clocks, of which one must be active; none: any event will do.
    clocks: Vec<u32>,
    is_discrete: bool,
    waiting: bool,
}

impl Events {
    /// The events of an FMU with event mode; none without.
    pub(super) fn of(description: &ModelDescription) -> Option<Self> {
        let co_simulation = description.co_simulation.as_ref().filter(|cs| cs.has_event_mode)?;
        Some(Events {
            has_mode: true,
            clocks: Clocks::of(description),
            any_step: co_simulation.can_handle_variable_communication_step_size,
            next_event: None,
            ticked: Vec::new(),
            fed: false,
            requested: Vec::new(),
            discrete: description
                .variables
                .iter()
                .filter(|v| is_discrete(v))
                .map(reference)
                .collect(),
            held: HashMap::new(),
        })
    }

    /// Before the end of initialization mode.
    pub(super) fn initialized(&mut self, instance: &mut Instance, start: f64) -> Result<(), Error> {
        self.clocks.begin(instance, start)
    }

    /// The event at which initialization ends; the FMU is in event mode already. Whether it asks for the
    /// end.
    pub(super) fn first(
        &mut self,
        instance: &mut Instance,
        start: f64,
        write: &mut Write<'_>,
    ) -> Result<bool, Error> {
        let mut active = Vec::new();
        self.clocks.take(start, &mut active);
        self.settle(instance, start, active, write)
    }

    /// Whether a clock has ticked since the step began.
    pub(super) fn has_ticked(&self, clock: u32) -> bool {
        self.ticked.contains(&clock)
    }

    /// The master sets inputs in initialization mode, too.
    pub(super) fn feeds(&mut self) {
        self.fed = true;
    }

    /// Keeps values of a run until the next event, if there are such that may change at events only;
    /// the others are written. Whether it did.
    pub(super) fn keep(
        &mut self,
        instance: &mut Instance,
        description: &ModelDescription,
        (selection, run): (&Selection, &TypeRun),
        values: &[f64],
        write: &mut Write<'_>,
    ) -> Result<bool, Error> {
        self.fed = true;
        let references = selection.references().get(run.range.clone()).unwrap_or_default();
        if run.data_type == DataType::Clock {
            let ticking = references.iter().zip(values).filter(|(_, value)| **value != 0.0);
            self.requested.extend(ticking.map(|(reference, _)| *reference));
            return Ok(true);
        }
        if !references.iter().any(|reference| self.discrete.contains(reference)) {
            return Ok(false);
        }
        // An array is written as a whole, as is a value of two parts; other scalars one by one.
        let width = match run {
            TypeRun { array: Some(_), .. } => values.len().max(1),
            TypeRun { is_split: true, .. } => 2,
            _ => 1,
        };
        let parts = references.chunks(width).zip(values.chunks(width));
        for (place, (references, values)) in parts.enumerate() {
            let Some(reference) = references.first().copied() else { continue };
            let discrete = &self.discrete;
            let held = self.held.entry(reference).or_insert_with(|| Held {
                selection: selection.part(run, place * width..place * width + values.len()),
                values: Vec::new(),
                clocks: clocks_of(description, reference),
                is_discrete: discrete.contains(&reference),
                waiting: false,
            });
            if !held.is_discrete {
                write(instance, &held.selection, values)?;
            } else if held.values != values {
                held.values.clear();
                held.values.extend_from_slice(values);
                held.waiting = true;
            }
        }
        Ok(true)
    }

    /// Steps from `time` over `step` seconds, with all events on the way.
    pub(super) fn step(
        &mut self,
        instance: &mut Instance,
        (time, step): (f64, f64),
        keep_earlier_state: bool,
        write: &mut Write<'_>,
    ) -> Result<StepResult, Error> {
        self.ticked.clear();
        let (end, near) = (time + step, ROUNDING * step);
        let ended = |at: f64| StepResult::Discarded { reached: Some(at), terminated: true };
        let is_input_event = !self.requested.is_empty()
            || self.held.values().any(|held| held.waiting && held.clocks.is_empty());
        let is_event = is_input_event || self.is_due(time + near);
        if is_event && self.event(instance, time, near, true, write)? {
            return Ok(ended(time));
        }
        let mut now = time;
        let mut stuck = 0;
        loop {
            let stop = self.stop(instance, now, end, near)?;
            let length = if now == time && stop == end { step } else { stop - now };
            let stepped = instance.step_to_event(now, length, keep_earlier_state)?;
            if stepped.discarded {
                let terminated = stepped.terminated;
                return Ok(StepResult::Discarded { reached: None, terminated });
            }
            let reached = if stepped.early { stepped.reached.min(stop) } else { stop };
            if stepped.terminated {
                return Ok(ended(if stepped.reached <= end { stepped.reached } else { reached }));
            }
            stuck = if reached > now { 0 } else { stuck + 1 };
            if stuck > MOST_PASSES || reached.is_nan() || reached < now {
                return Ok(StepResult::Discarded { reached: Some(reached), terminated: false });
            }
            now = reached;
            let is_end = now >= end - near;
            // Clocks of an FMU that is fed wait for the inputs of the communication point.
            let ticks = !(is_end && self.fed);
            let is_time_event = self.next_event.is_some_and(|next| next <= now + near);
            let is_event = stepped.event || is_time_event || (ticks && self.is_due(now + near));
            if self.has_mode && is_event && self.event(instance, now, near, ticks, write)? {
                return Ok(ended(now));
            }
            if is_end {
                return Ok(StepResult::Completed);
            }
        }
    }

    fn is_due(&self, time: f64) -> bool {
        self.clocks.next().is_some_and(|(next, _)| next <= time)
    }

    /// Where the next step of the FMU ends.
    fn stop(&self, instance: &Instance, now: f64, end: f64, near: f64) -> Result<f64, Error> {
        if let Some((tick, clock)) = self.clocks.next().filter(|(tick, _)| *tick < end - near) {
            if !self.any_step {
                return Err(Error::Clock {
                    fmu: instance.name().to_owned(),
                    clock: clock.to_owned(),
                    what: format!(
                        "it ticks at {tick} s, within the communication step from {now} s to {end} s, \
                         which this FMU takes as a whole (canHandleVariableCommunicationStepSize is \
                         false); choose a communication step of which all its intervals are multiples"
                    ),
                });
            }
            if tick > now {
                let event = self.next_event.filter(|event| *event > now && *event < tick);
                return Ok(event.unwrap_or(tick));
            }
        }
        let inside = |event: &f64| self.any_step && *event > now + near && *event < end - near;
        Ok(self.next_event.filter(inside).unwrap_or(end))
    }

    /// Enters event mode at `time`, lets what is due happen and goes back to step mode. Whether the FMU
    /// asks for the end.
    fn event(
        &mut self,
        instance: &mut Instance,
        time: f64,
        near: f64,
        ticks: bool,
        write: &mut Write<'_>,
    ) -> Result<bool, Error> {
        instance.enter_event_mode()?;
        let mut active = std::mem::take(&mut self.requested);
        if ticks {
            self.clocks.take(time + near, &mut active);
        }
        self.settle(instance, time, active, write)
    }

    /// In event mode: instants of super-dense time until nothing changes any more.
    fn settle(
        &mut self,
        instance: &mut Instance,
        time: f64,
        mut active: Vec<u32>,
        write: &mut Write<'_>,
    ) -> Result<bool, Error> {
        for _ in 0..MOST_PASSES {
            instance.activate_clocks(&active)?;
            for held in self.held.values_mut().filter(|held| held.waiting) {
                let is_open = held.clocks.is_empty();
                if is_open || held.clocks.iter().any(|clock| active.contains(clock)) {
                    write(instance, &held.selection, &held.values)?;
                    held.waiting = false;
                }
            }
            for clock in self.clocks.outputs() {
                if !self.ticked.contains(clock) && instance.is_active(*clock)? {
                    self.ticked.push(*clock);
                }
            }
            for clock in &active {
                if !self.ticked.contains(clock) {
                    self.ticked.push(*clock);
                }
            }
            let updated = instance.update_discrete_states()?;
            self.next_event = updated.next_event;
            if updated.terminated {
                return Ok(true);
            }
            let mut again = Vec::new();
            self.clocks.ask(instance, time, &active, &mut again)?;
            active = again;
            if !updated.needs_update && active.is_empty() {
                instance.enter_step_mode()?;
                return Ok(false);
            }
        }
        Err(Error::Events { fmu: instance.name().to_owned(), time, passes: MOST_PASSES })
    }
}

fn clocks_of(description: &ModelDescription, reference: u32) -> Vec<u32> {
    description.referenced(reference).map(|variable| variable.clocks.clone()).unwrap_or_default()
}

/// Whether a variable that the master may set changes at events only.
fn is_discrete(variable: &Variable) -> bool {
    match variable.causality {
        Causality::Input => {
            !variable.data_type.is_float()
                || !variable.clocks.is_empty()
                || variable.variability(FmiVersion::V3) != Variability::Continuous
        }
        Causality::Parameter => true,
        _ => false,
    }
}

fn reference(variable: &Variable) -> u32 {
    variable.value_reference
}
