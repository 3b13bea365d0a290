//! Iteration: algebraic loops are solved in every communication step.

mod loops;

use std::cell::RefCell;

use super::Algorithm;
use super::initial::settle;
use crate::error::Error;
use crate::problem::{Problem, Problems};
use crate::slave::StateId;
use crate::system::System;
pub(super) use loops::Group;
use loops::{Meeting, groups, late};

/// How a guess of a loop's values is corrected by what the slaves made of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relaxation {
    /// `x ← x + ω·(y(x) − x)` with this ω; 1 is plain substitution.
    Fixed(f64),
    /// As `Fixed`, with ω from the last two corrections, which solves a linear loop of one variable in
    /// three passes (Aitken's Δ², as in Küttler and Wall, Comput. Mech. 43, 2008).
    Aitken,
}

/// When and how a loop is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationSettings {
    /// How a guess is corrected.
    pub relaxation: Relaxation,
    /// Each value of the loop must change by less than this part of the largest magnitude it has
    /// had in the run.
    pub tolerance: f64,
    /// Most passes through a loop in one step.
    pub iterations: usize,
}

impl Default for IterationSettings {
    fn default() -> Self {
        IterationSettings { relaxation: Relaxation::Aitken, tolerance: 1e-9, iterations: 50 }
    }
}

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
    settings: IterationSettings,
    /// Saved states, by slave.
    states: RefCell<Vec<Option<StateId>>>,
    work: RefCell<Work>,
}

/// What is kept from pass to pass.
#[derive(Debug, Default)]
struct Work {
    /// Largest magnitude that each value of the bus has had in a solution.
    largest: Vec<f64>,
    guess: Vec<f64>,
    corrections: Vec<Correction>,
    /// Corrections of the pass before.
    previous: Vec<f64>,
    /// What weighs the corrections of values of different magnitudes, fixed by the first pass.
    scales: Vec<f64>,
}

/// What the slaves made of a guess, less the guess.
#[derive(Clone, Copy, Debug)]
struct Correction {
    change: f64,
    /// In parts of the largest magnitude.
    relative: f64,
}

impl IterationSettings {
    fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        let mut add = |text: String| problems.push(Problem::Iteration(text));
        if let Relaxation::Fixed(omega) = self.relaxation
            && !(omega > 0.0 && omega <= 2.0)
        {
            add(format!("a relaxation of {omega} is none; give more than 0 and at most 2"));
        }
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            let tolerance = self.tolerance;
            add(format!("a tolerance of {tolerance} is none; give more than 0 and less than 1"));
        }
        if self.iterations < 2 {
            let most = self.iterations;
            add(format!("{most} passes cannot show that a loop is solved; allow 2 or more"));
        }
        problems
    }
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
        let (meetings, states, work) = Default::default();
        Problems::none_or(problems, Iteration { groups, meetings, late, settings, states, work })
    }

    /// What solves circles at the start for algorithms that solve none later.
    pub(super) fn at_start() -> Self {
        let (groups, meetings, late, settings, states, work) = Default::default();
        Iteration { groups, meetings, late, settings, states, work }
    }

    /// The loops, by places of their slaves.
    pub fn loops(&self) -> impl Iterator<Item = &[usize]> {
        let loops = self.groups.iter().filter(|group| group.is_loop());
        loops.map(|group| group.slaves.as_slice())
    }

    /// Passes through a loop until its values stay.
    pub(super) fn solve(
        &self,
        group: &Group,
        system: &mut System,
        mut pass: impl FnMut(&mut System, usize) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut work = self.work.borrow_mut();
        let mut omega = match self.settings.relaxation {
            Relaxation::Fixed(omega) => omega,
            Relaxation::Aitken => 1.0,
        };
        work.previous.clear();
        work.scales.clear();
        for iteration in 0..self.settings.iterations {
            work.guess.clear();
            work.guess.extend(group.torn.iter().map(|place| system.bus[*place]));
            pass(system, iteration)?;
            let worst = work.compare(group, system);
            if work.corrections.iter().all(|r| r.relative.abs() <= self.settings.tolerance) {
                work.accept(group, system);
                return Ok(());
            }
            if iteration + 1 == self.settings.iterations {
                return Err(self.unsolved(group, system, worst, &work));
            }
            if self.settings.relaxation == Relaxation::Aitken {
                omega = work.aitken(omega);
            }
            for ((place, x), r) in group.torn.iter().zip(&work.guess).zip(&work.corrections) {
                system.bus[*place] = x + omega * r.change;
            }
            let Work { previous, corrections, .. } = &mut *work;
            previous.clear();
            previous.extend(corrections.iter().map(|r| r.change));
        }
        Ok(())
    }

    #[cold]
    fn unsolved(&self, group: &Group, system: &System, worst: usize, work: &Work) -> Error {
        let change = work.corrections.get(worst).map_or(f64::NAN, |r| r.change);
        let value = work.guess.get(worst).map_or(f64::NAN, |x| x + change);
        Error::Loop {
            variables: group.names(system),
            iterations: self.settings.iterations,
            worst: group.name(system, worst),
            value,
            change,
            tolerance: self.settings.tolerance,
        }
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
        self.solve(group, system, |system, iteration| {
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

impl Work {
    /// Compares what the slaves gave with the guess; the place of the largest relative change.
    fn compare(&mut self, group: &Group, system: &System) -> usize {
        self.largest.resize(system.bus.len(), 0.0);
        self.corrections.clear();
        for (place, x) in group.torn.iter().zip(&self.guess) {
            let y = system.bus[*place];
            let largest = self.largest[*place].max(x.abs()).max(y.abs());
            let change = y - x;
            let relative = if change == 0.0 { 0.0 } else { change / largest };
            self.corrections.push(Correction { change, relative });
            if self.scales.len() < self.corrections.len() {
                self.scales.push(if largest > 0.0 { largest } else { 1.0 });
            }
        }
        let sizes = self.corrections.iter().map(|r| r.relative.abs()).enumerate();
        sizes.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(worst, _)| worst)
    }

    /// Notes the magnitudes of a solution; those of guesses say nothing.
    fn accept(&mut self, group: &Group, system: &System) {
        for place in &group.torn {
            self.largest[*place] = self.largest[*place].max(system.bus[*place].abs());
        }
    }

    /// The next ω: −ω·(r·Δr)/(Δr·Δr), r the corrections before, Δr their change.
    fn aitken(&self, omega: f64) -> f64 {
        if self.previous.len() != self.corrections.len() {
            return omega;
        }
        let (mut along, mut square) = (0.0, 0.0);
        for ((before, now), scale) in self.previous.iter().zip(&self.corrections).zip(&self.scales)
        {
            let before = before / scale;
            let difference = now.change / scale - before;
            along += before * difference;
            square += difference * difference;
        }
        let next = -omega * along / square;
        if next.is_finite() && next != 0.0 { next } else { omega }
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
        self.work.borrow_mut().largest.clear();
        settle(system, &self.initialization_order(system), self, true)
    }
}
