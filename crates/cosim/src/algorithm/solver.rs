//! How the values of a loop are found: passes with corrected guesses.

use std::cell::RefCell;

use super::loops::Group;
use crate::error::Error;
use crate::problem::Problem;
use crate::system::System;

/// How a guess of a loop's values is corrected by what the slaves made of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relaxation {
    /// `x ← x + ω·(y(x) − x)` with this ω; 1 is plain substitution.
    Fixed(f64),
    /// `x ← x + ω·(y(x) − x)` with ω from the last two corrections, which solves a linear loop of one variable in
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

impl IterationSettings {
    pub(super) fn problems(&self) -> Vec<Problem> {
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

/// Finds the values of loops.
#[derive(Debug, Default)]
pub(super) struct Solver {
    settings: IterationSettings,
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

impl Solver {
    pub(super) fn new(settings: IterationSettings) -> Self {
        Solver { settings, work: RefCell::default() }
    }

    /// Forgets the magnitudes of the last run.
    pub(super) fn begin(&self) {
        self.work.borrow_mut().largest.clear();
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
