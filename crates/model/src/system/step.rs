//! Rest and steps: what runs at each communication step, and allocates nothing.

use super::cells::own_seed;
use super::{Past, Plan, StepError, System};
use crate::wiring::Span;
use crate::{Context, Tick};

/// Passes over the chain within which signals that are read back must settle at rest.
const MOST_PASSES: usize = 1000;

impl System {
    /// Puts the system at rest under its present inputs at time `start`: computes the coefficients,
    /// the state of a machine whose inputs were held forever, and the outputs. It may be called
    /// again with other inputs or parameters before the first step.
    ///
    /// # Errors
    /// [`StepError::Parameters`] where the parameters break a rule as a set.
    pub fn initialise(&mut self, start: f64) -> Result<(), StepError> {
        (self.context.start, self.context.index) = (start, 0);
        self.context.dirty = true;
        self.prepare()?;
        self.settle()?;
        self.show(&mut [])
    }

    /// Shows the signals as values of the outputs; an error where one is not finite.
    fn show(&mut self, noted: &mut [f64]) -> Result<(), StepError> {
        let (plan, cells) = self.split();
        if plan.show(cells, noted) { Ok(()) } else { Err(self.not_finite()) }
    }

    /// Puts every node at rest; where a signal is read back, until all signals stay as they are.
    fn settle(&mut self) -> Result<(), StepError> {
        let (plan, cells) = self.split();
        plan.read_inputs(cells);
        if !plan.reads_back {
            plan.rest(cells);
            return Ok(());
        }
        plan.forget_outputs(cells);
        let mut before = 0;
        for _ in 0..MOST_PASSES {
            plan.rest(cells);
            let now = plan.fingerprint(cells);
            if now == before {
                return Ok(());
            }
            before = now;
        }
        Err(StepError::NoRest)
    }

    /// Performs every hit with `t_n ≤ time + 1e-9·period`, with the present inputs. Returns how many.
    /// Without a hit nothing changes.
    ///
    /// # Errors
    /// [`StepError`]: parameters that break a rule, or an output that is not finite.
    pub fn advance(&mut self, time: f64) -> Result<u64, StepError> {
        self.hits(time, 0.0, &[], None)
    }

    /// Performs every hit up to `time` with inputs that move on straight lines: at time `t` the input
    /// with value reference `i` is `u_i + slopes[i]·(t − from)`, `u_i` being the value that was set
    /// and the slope in its unit per second. Hit `n` takes the inputs as they are at `t_{n-1}`, as
    /// if they were set there. Inputs without a slope here are held.
    ///
    /// # Errors
    /// [`StepError`]: parameters that break a rule, or an output that is not finite.
    pub fn advance_along(
        &mut self,
        time: f64,
        from: f64,
        slopes: &[f64],
    ) -> Result<u64, StepError> {
        self.hits(time, from, slopes, None)
    }

    /// Performs every hit up to `time` with inputs along `slopes`, and notes in `past` what the step
    /// began with.
    ///
    /// # Errors
    /// [`StepError`]: parameters that break a rule, or an output that is not finite.
    pub fn advance_noted(
        &mut self,
        time: f64,
        from: f64,
        slopes: &[f64],
        past: &mut Past,
    ) -> Result<u64, StepError> {
        if slopes.is_empty() {
            self.hits(time, from, &[], Some(past))
        } else {
            self.hits_along(time, from, slopes, past)
        }
    }

    /// Apart from the rest, so that steps with held inputs are short.
    #[cold]
    fn hits_along(
        &mut self,
        time: f64,
        from: f64,
        slopes: &[f64],
        past: &mut Past,
    ) -> Result<u64, StepError> {
        self.hits(time, from, slopes, Some(past))
    }

    /// Up to which time hits belong to a step that ends at `time`, and the time of the next hit.
    #[inline(always)]
    pub(super) fn reach_of(&self, time: f64) -> (f64, f64) {
        let Context { start, index, .. } = self.context;
        // Far from zero, a billionth of a period is less than what adding up times loses.
        let (near, far) = (self.plan.near, 4.0 * f64::EPSILON * time.abs());
        let limit = time + if near > far { near } else { far };
        // The cast through a signed number is one instruction.
        (limit, start + (index + 1) as i64 as f64 * self.plan.period)
    }

    /// Performs the hits up to `time`.
    #[inline(always)]
    fn hits(
        &mut self,
        time: f64,
        from: f64,
        slopes: &[f64],
        mut past: Option<&mut Past>,
    ) -> Result<u64, StepError> {
        let (start, period) = (self.context.start, self.plan.period);
        let first = self.context.index;
        let at = |index: u64| start + index as i64 as f64 * period;
        let (limit, next) = self.reach_of(time);
        // Neither holds for NaN, and a limit of infinity would never be reached.
        if !(next <= limit && limit <= f64::MAX) {
            if let Some(past) = past {
                past.note_idle();
            }
            return Ok(0);
        }
        if self.context.dirty {
            self.prepare()?;
        }
        let tick = Tick { index: first + 1, time: next, period };
        let is_one = at(first + 2) > limit && slopes.is_empty();
        let (plan, cells) = self.split();
        match &mut past {
            None => plan.read_inputs(cells),
            Some(past) => {
                past.note_step(first, from, slopes);
                plan.begin(cells, past);
            }
        }
        // The usual step is kept apart, so that no number of the loop has to live through a call.
        let last = if is_one {
            plan.step(cells, &tick);
            first + 1
        } else {
            plan.steps(cells, (first, limit), at, |time| time - from, slopes)
        };
        self.context.index = last;
        let noted = past.map_or(&mut [][..], |past| &mut past.outputs);
        self.show(noted)?;
        Ok(last - first)
    }

    /// The first output that is not finite.
    #[cold]
    pub fn not_finite(&self) -> StepError {
        let value = |variable: usize| self.context.cells[variable];
        let mut outputs = self.plan.outputs.iter().map(|wire| wire.variable);
        let variable = outputs.find(|output| !value(*output).is_finite()).unwrap_or(0);
        StepError::NotFinite {
            reference: variable as u32,
            value: value(variable),
            time: self.time(),
        }
    }

    /// Computes the coefficients from the parameters.
    #[cold]
    fn prepare(&mut self) -> Result<(), StepError> {
        let blocks = self.plan.blocks;
        let (values, rest) = self.context.cells.split_at_mut(blocks[0]);
        let (coefficients, scratch) = rest.split_at_mut(blocks[1] - blocks[0]);
        // The last cells are scratch for the SI values of one node.
        let scratch_start = scratch.len() - self.plan.widest;
        let scratch = &mut scratch[scratch_start..];
        let variables = self.plan.variables.as_slice();
        for (number, node) in self.plan.nodes.iter().enumerate() {
            let range = node.parameters.clone();
            let si = &mut scratch[..range.len()];
            for ((si, value), variable) in
                si.iter_mut().zip(&values[range.clone()]).zip(&variables[range])
            {
                *si = variable.si.to_si(*value);
            }
            for seed in &node.seeds {
                si[*seed] = own_seed(si[*seed], &node.path);
            }
            let Span { start, len } = node.wiring.coefficients;
            let coefficients = &mut coefficients[start - blocks[0]..][..len];
            node.component
                .prepare(&node.structure, si, self.plan.period, coefficients)
                .map_err(|violation| StepError::Parameters { node: number, violation })?;
        }
        self.context.dirty = false;
        Ok(())
    }

    #[inline(always)]
    fn split(&mut self) -> (&Plan, &mut [f64]) {
        (&self.plan, &mut self.context.cells)
    }
}
