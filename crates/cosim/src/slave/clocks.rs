//! When the clocks of an FMI 3.0 slave tick.
//!
//! FMI 3.0.2 §2.2.8.3. With t_0 the start of the run and n = 0, 1, …:
//!
//! | `intervalVariability` | ticks at |
//! |---|---|
//! | constant, fixed, tunable | t_0 + shift + n·interval; a new interval counts from when it was given |
//! | changing | the interval that the FMU gave at initialization, then at each tick, after that time |
//! | countdown | as changing, asked for at every event |
//! | triggered (input) | when the master says so |

use fmi_bindings::import::v3::Instance;
use modeldescription::ModelDescription;
use modeldescription::variable::{Causality, ClockProperties, DataType, Variable};
use serde::{Deserialize, Serialize};

use crate::error::Error;

/// Interval, first tick and how many ticks have been.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Period {
    first: f64,
    interval: f64,
    ticks: u64,
}

/// What says when a time-based clock ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Kind {
    /// The description states the period.
    Stated,
    /// The FMU says its period at initialization.
    Asked,
    /// The FMU may say another period at any event.
    Tunable,
    /// The FMU says after each tick when the next one is.
    Changing,
    /// The FMU may say at any event when the next one is.
    Countdown,
}

/// A time-based clock.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct TimeBased {
    name: String,
    reference: u32,
    kind: Kind,
    period: Option<Period>,
    /// Time of the next tick in s; none: it is not known.
    next: Option<f64>,
}

/// The clocks of a slave.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Clocks {
    timed: Vec<TimeBased>,
    outputs: Vec<u32>,
}

/// What the description says of a clock.
fn properties(description: &ModelDescription, clock: &Variable) -> ClockProperties {
    description.properties(clock).clock.map(|clock| *clock).unwrap_or_default()
}

/// Whether a clock ticks when somebody says so, not at times of its own.
fn is_triggered(description: &ModelDescription, clock: &Variable) -> bool {
    let kind = properties(description, clock).interval_variability;
    kind.as_deref().is_none_or(|kind| kind == "triggered")
}

/// Whether somebody else may let a clock tick.
pub(crate) fn can_be_triggered(description: &ModelDescription, clock: &Variable) -> bool {
    clock.causality == Causality::Input && is_triggered(description, clock)
}

impl Clocks {
    /// The clocks that a description declares.
    pub(super) fn of(description: &ModelDescription) -> Self {
        let all = || description.variables.iter().filter(|v| v.data_type == DataType::Clock);
        let is_timed = |clock: &&Variable| {
            clock.causality == Causality::Input && !is_triggered(description, clock)
        };
        let timed = all().filter(is_timed).map(|clock| {
            let stated = properties(description, clock);
            let (interval, shift) = stated_period(&stated);
            let kind = match stated.interval_variability.as_deref() {
                Some("changing") => Kind::Changing,
                Some("countdown") => Kind::Countdown,
                _ if interval.is_some() => Kind::Stated,
                Some("tunable") => Kind::Tunable,
                _ => Kind::Asked,
            };
            let period = |interval| Period { first: shift, interval, ticks: 0 };
            TimeBased {
                name: clock.name.clone(),
                reference: clock.value_reference,
                kind,
                period: interval.map(period),
                next: None,
            }
        });
        let outputs = all().filter(|clock| clock.causality == Causality::Output);
        let outputs = outputs.map(|clock| clock.value_reference).collect();
        Clocks { timed: timed.collect(), outputs }
    }

    /// Triggered output clocks.
    pub(super) fn outputs(&self) -> &[u32] {
        &self.outputs
    }

    /// In initialization mode: when each clock ticks first.
    pub(super) fn begin(&mut self, instance: &mut Instance, start: f64) -> Result<(), Error> {
        for clock in &mut self.timed {
            match clock.kind {
                Kind::Stated => {
                    if let Some(period) = &mut clock.period {
                        period.first += start;
                        clock.next = Some(period.first);
                    }
                }
                Kind::Asked | Kind::Tunable => {
                    let (interval, _) = instance.interval(clock.reference)?;
                    let interval = interval.ok_or_else(|| clock.silent(instance))?;
                    let first = start + instance.shift(clock.reference)?;
                    clock.period = Some(Period { first, interval, ticks: 0 });
                    clock.next = Some(first);
                }
                Kind::Changing | Kind::Countdown => {
                    let (interval, _) = instance.interval(clock.reference)?;
                    clock.next = interval.map(|interval| start + interval);
                }
            }
            clock.check(instance)?;
        }
        Ok(())
    }

    /// The first tick in s.
    pub(super) fn next(&self) -> Option<(f64, &str)> {
        let known = self.timed.iter().filter_map(|clock| Some((clock.next?, clock.name.as_str())));
        known.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Takes the clocks that tick until `time`; periodic ones are set to their next tick.
    pub(super) fn take(&mut self, time: f64, active: &mut Vec<u32>) {
        for clock in &mut self.timed {
            if clock.next.is_none_or(|next| next > time) {
                continue;
            }
            active.push(clock.reference);
            clock.next = clock.period.as_mut().map(|period| {
                period.ticks += 1;
                period.first + period.ticks as f64 * period.interval
            });
        }
    }

    /// After an update of the discrete states at `time`, for which these clocks were active: asks for
    /// new intervals. Clocks that tick again at once are added to `again`.
    pub(super) fn ask(
        &mut self,
        instance: &mut Instance,
        time: f64,
        active: &[u32],
        again: &mut Vec<u32>,
    ) -> Result<(), Error> {
        for clock in &mut self.timed {
            let is_asked = match clock.kind {
                Kind::Stated | Kind::Asked => false,
                Kind::Changing => active.contains(&clock.reference),
                Kind::Tunable | Kind::Countdown => true,
            };
            if !is_asked {
                continue;
            }
            let (Some(interval), _) = instance.interval(clock.reference)? else { continue };
            if clock.kind == Kind::Tunable {
                // The same interval told again changes nothing.
                if clock.period.as_ref().is_some_and(|period| period.interval == interval) {
                    continue;
                }
                clock.period = Some(Period { first: time, interval, ticks: 1 });
            }
            clock.next = Some(time + interval);
            clock.check(instance)?;
            if interval == 0.0 {
                clock.next = None;
                again.push(clock.reference);
            }
        }
        Ok(())
    }
}

/// Interval and shift in s, where the description has them.
fn stated_period(clock: &ClockProperties) -> (Option<f64>, f64) {
    let ticks = |counter: Option<u64>| Some(counter? as f64 / clock.resolution? as f64);
    let interval = ticks(clock.interval_counter).or(clock.interval_decimal);
    (interval, ticks(clock.shift_counter).or(clock.shift_decimal).unwrap_or(0.0))
}

impl TimeBased {
    #[cold]
    fn silent(&self, instance: &Instance) -> Error {
        self.wrong(instance, "the FMU does not say its interval in initialization mode".to_owned())
    }

    #[cold]
    fn wrong(&self, instance: &Instance, what: String) -> Error {
        Error::Clock { fmu: instance.name().to_owned(), clock: self.name.clone(), what }
    }

    /// A clock that never moves on would tick for ever.
    fn check(&self, instance: &Instance) -> Result<(), Error> {
        let interval = self.period.as_ref().map_or(1.0, |period| period.interval);
        if !(interval.is_finite() && interval > 0.0) {
            let what = format!("its interval is {interval} s; it must be greater than 0");
            return Err(self.wrong(instance, what));
        }
        match self.next {
            Some(next) if !next.is_finite() => {
                Err(self.wrong(instance, format!("its next tick is at {next} s")))
            }
            _ => Ok(()),
        }
    }
}
