//! Slaves that step more rarely than the system communicates.

use super::System;
use crate::problem::Problem;
use crate::slave::Slave;
use crate::time::Points;

/// How often a slave steps.
#[derive(Debug)]
pub(crate) struct Pace {
    /// It steps once every so many communication steps.
    pub(crate) every: usize,
    /// The pace's own step begins at this communication point.
    pub(crate) due: bool,
    /// Begin and length of its own step in s; none: the communication step.
    pub(crate) own: Option<(f64, f64)>,
    /// It takes its step when the end is reached, not at the begin.
    late: bool,
    /// Places on the bus: of the values that the slave has reached, and of those that are seen
    /// because their time is reached too.
    places: Vec<(usize, usize)>,
}

impl Default for Pace {
    fn default() -> Self {
        Pace { every: 1, due: true, own: None, late: false, places: Vec::new() }
    }
}

impl Pace {
    /// The place of what is reached, for the place where it is seen.
    pub(crate) fn seen(&self, place: usize) -> Option<usize> {
        self.places.iter().find(|(_, seen)| *seen == place).map(|(reached, _)| *reached)
    }

    /// A slave that takes equal steps only needs a whole number of its own.
    pub(crate) fn problem(&self, slave: &dyn Slave, points: &Points<'_>) -> Option<Problem> {
        let co_simulation = slave.description().co_simulation.as_ref();
        let variable = co_simulation?.can_handle_variable_communication_step_size;
        if variable || points.steps().is_multiple_of(self.every) {
            return None;
        }
        let what = format!(
            "once every {} communication steps and takes equal steps only, but the run has {} \
             communication steps; end the run at a multiple of its step",
            self.every,
            points.steps()
        );
        Some(Problem::Pace { slave: slave.name().to_owned(), what })
    }
}

impl System {
    /// Lets a slave step once every so many communication steps. Called after all connections.
    pub(crate) fn set_pace(&mut self, slave: usize, every: usize) {
        let Some(participant) = self.participants.get_mut(slave) else { return };
        let is_new = participant.pace.places.is_empty();
        participant.pace.every = every;
        if every == 1 || !is_new {
            return;
        }
        let mut seen = std::mem::take(&mut participant.outputs.places);
        let outputs = seen.len();
        seen.append(&mut participant.observed.places);
        let mut places = Vec::new();
        for place in seen {
            let owner = self.owners.get(place).copied().flatten();
            places.push((self.add_place(owner), place));
        }
        if let Some(participant) = self.participants.get_mut(slave) {
            let reached = |pairs: &[(usize, usize)]| pairs.iter().map(|pair| pair.0).collect();
            let (first, rest) = places.split_at(outputs);
            participant.outputs.places = reached(first);
            participant.observed.places = reached(rest);
            participant.pace.places = places;
        }
        self.paced = true;
    }

    /// Lets slow slaves step late, and the wires from a source to a target begin at what it has reached, where
    /// the algorithm wants it so.
    pub(crate) fn look_ahead(
        &mut self,
        steps_late: impl Fn(usize) -> bool,
        looks_ahead: impl Fn(usize, usize) -> bool,
    ) {
        for (slave, participant) in self.participants.iter_mut().enumerate() {
            participant.pace.late = participant.pace.every > 1 && steps_late(slave);
        }
        let pairs = |system: &System, source: usize| {
            system.participants.get(source).map(|p| p.pace.places.clone()).unwrap_or_default()
        };
        for source in (0..self.len()).filter(|_| self.paced) {
            for (reached, seen) in pairs(self, source) {
                for (target, participant) in self.participants.iter_mut().enumerate() {
                    let ahead = looks_ahead(source, target);
                    for wire in &mut participant.wires {
                        if wire.from == reached || wire.from == seen {
                            wire.from = if ahead { reached } else { seen };
                        }
                    }
                }
            }
        }
    }

    /// Says which slaves step from communication point `n` on, and shows what those have reached.
    #[inline]
    pub(crate) fn pace(&mut self, points: &Points<'_>, n: usize) {
        if self.paced {
            self.pace_each(points, n);
        }
    }

    fn pace_each(&mut self, points: &Points<'_>, n: usize) {
        for participant in &mut self.participants {
            let pace = &mut participant.pace;
            if pace.every == 1 {
                continue;
            }
            let begin = if pace.late { n - n % pace.every } else { n };
            let end = begin.saturating_add(pace.every).min(points.steps());
            pace.due = if pace.late { n + 1 == end } else { n.is_multiple_of(pace.every) };
            pace.own = Some((points.at(begin), points.at(end) - points.at(begin)));
            let is_reached = pace.late || n.is_multiple_of(pace.every) || n == points.steps();
            if is_reached {
                show(&mut self.bus, &pace.places);
            }
        }
    }

    /// Shows what one slave has reached.
    pub(crate) fn publish_one(&mut self, slave: usize) {
        if let Some(participant) = self.participants.get(slave) {
            show(&mut self.bus, &participant.pace.places);
        }
    }

    /// Shows what the slaves that step late have reached, where the run ends between their steps.
    pub(crate) fn publish_late(&mut self) {
        for participant in self.participants.iter().filter(|p| p.pace.late) {
            show(&mut self.bus, &participant.pace.places);
        }
    }

    /// Shows what the slow slaves have reached.
    pub(crate) fn publish(&mut self) {
        for participant in &mut self.participants {
            show(&mut self.bus, &participant.pace.places);
        }
    }
}

fn show(bus: &mut [f64], places: &[(usize, usize)]) {
    for (reached, seen) in places {
        if let Some(value) = bus.get(*reached).copied()
            && let Some(place) = bus.get_mut(*seen)
        {
            *place = value;
        }
    }
}
