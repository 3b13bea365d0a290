//! Iteration: algebraic loops are solved in every communication step.

use std::cell::RefCell;

use super::Algorithm;
use super::initial::settle;
use super::loops::{Group, Meeting, groups, late};
use super::solver::{IterationSettings, Solver};
use crate::error::Error;
use crate::problem::Problems;
use crate::slave::StateId;
use crate::system::System;

/// Sources step before targets. Slaves that wait for each other form a loop: their states are
/// saved, they step with guessed inputs, and are rolled back and step again until what they give at
/// t_{k+1} is what they were given. So no connection delays. Where the slaves of a loop have different
/// steps, those whose steps end at t_{k+1} are solved together, and the others are not asked.
///
/// By hand, in fmpy, for slaves `a` and `b` in a loop:
///
/// ```python
/// states = [slave.getFMUState() for slave in (a, b)]
/// x = a.getReal(a_out)                               # the guess: a's output at t_k
/// while True:
///     b.setReal(b_in, x); b.doStep(t, h)
///     a.setReal(a_in, b.getReal(b_out)); a.doStep(t, h)
///     y = a.getReal(a_out)
///     if close(x, y): break
///     x = x + omega * (y - x)
///     for slave, state in zip((a, b), states): slave.setFMUState(state)
/// ```
#[derive(Debug)]
pub struct Iteration {
    groups: Vec<Group>,
    /// The loops among those slaves of a group with different steps whose steps end together.
    meetings: RefCell<Vec<Meeting>>,
    /// By slave: it steps at the end of its own step, as it is in a group with different steps or is fed by
    /// one.
    late: Vec<bool>,
    solver: Solver,
    /// Saved states, by slave.
    states: RefCell<Vec<Option<StateId>>>,
}

impl Iteration {
    /// Finds the loops.
    ///
    /// # Errors
    /// Settings that are none; all slaves in loops that cannot save their state.
    pub fn new(system: &System, settings: IterationSettings) -> Result<Self, Problems> {
        let mut problems = settings.problems();
        let groups = groups(system);
        problems.extend(groups.iter().flat_map(|group| group.problems(system)));
        let late = late(system, &groups);
        let (meetings, states) = Default::default();
        let solver = Solver::new(settings);
        Problems::none_or(problems, Iteration { groups, meetings, late, solver, states })
    }

    /// The loops, by places of their slaves.
    pub fn loops(&self) -> impl Iterator<Item = &[usize]> {
        let loops = self.groups.iter().filter(|group| group.is_loop());
        loops.map(|group| group.slaves.as_slice())
    }

    /// Steps slaves that step together, a loop until it is solved.
    fn step_group(
        &self,
        group: &Group,
        system: &mut System,
        (time, step): (f64, f64),
    ) -> Result<(), Error> {
        let once = |system: &mut System| {
            group.slaves.iter().try_for_each(|slave| {
                system.transfer(*slave)?;
                system.advance(*slave, time, step)?;
                system.read(*slave)
            })
        };
        if !group.is_loop() {
            return once(system);
        }
        self.solver.solve(group, system, |system, iteration| {
            self.roll_back(group, system, iteration)?;
            once(system)
        })
    }

    /// Saves the states of a loop's slaves, or goes back to them.
    fn roll_back(&self, group: &Group, system: &mut System, iteration: usize) -> Result<(), Error> {
        let mut states = self.states.borrow_mut();
        states.resize(system.len(), None);
        system.ending = None;
        for slave in &group.slaves {
            let (state, participant) = (&mut states[*slave], &mut system.participants[*slave]);
            match (iteration, *state) {
                (0, reuse) => *state = Some(participant.slave.save(reuse)?),
                (_, Some(saved)) => participant.slave.restore(saved)?,
                (_, None) => {}
            }
        }
        Ok(())
    }
}

impl Algorithm for Iteration {
    fn step(&self, system: &mut System, time: f64, step: f64) -> Result<(), Error> {
        self.groups.iter().enumerate().try_for_each(|(number, group)| {
            if !group.is_loop() || group.is_due(system) {
                return self.step_group(group, system, (time, step));
            }
            let mut meetings = self.meetings.borrow_mut();
            let meets = |m: &Meeting| m.group == number && m.is_now(group, system);
            let known = meetings.iter().position(meets);
            let at = known.unwrap_or_else(|| {
                meetings.push(Meeting::new(number, group, system));
                meetings.len() - 1
            });
            let parts = meetings.get(at).map_or(&[][..], |meeting| &meeting.parts);
            parts.iter().try_for_each(|part| self.step_group(part, system, (time, step)))
        })
    }

    fn steps_late(&self, slave: usize) -> bool {
        self.late.get(slave).copied().unwrap_or(false)
    }

    fn looks_ahead(&self, source: usize, target: usize) -> bool {
        let place = |slave: usize| self.groups.iter().position(|g| g.slaves.contains(&slave));
        place(source) <= place(target)
    }

    fn initialization_order(&self, _system: &System) -> Vec<usize> {
        self.groups.iter().flat_map(|group| group.slaves.iter().copied()).collect()
    }

    /// In initialization mode outputs follow inputs at once, so circles are solved without rollback.
    fn initialize(&self, system: &mut System) -> Result<(), Error> {
        for (slave, state) in self.states.borrow_mut().iter_mut().enumerate() {
            if let (Some(state), Some(slave)) = (state.take(), system.slave(slave)) {
                // A slave that was made anew has no saved states any more.
                let _ = slave.forget(state);
            }
        }
        self.solver.begin();
        settle(system, &self.initialization_order(system), &self.solver, true)
    }
}
