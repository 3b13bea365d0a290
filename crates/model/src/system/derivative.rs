//! Directional derivatives of the outputs.

use alloc::vec::Vec;
use core::fmt;

use super::{Past, StepError, System};
use crate::{Causality, Context, DataType};

/// Steps of the difference quotients, relative to the size of the knowns: the largest at which two
/// neighbouring quotients agree is taken.
const STEPS: [f64; 4] = [
    1.0 / (1_u64 << 14) as f64,
    1.0 / (1_u64 << 20) as f64,
    1.0 / (1_u64 << 26) as f64,
    1.0 / (1_u64 << 32) as f64,
];
/// Neighbouring quotients that differ by less, relatively, belong to one smooth piece.
const SMOOTH: f64 = 1e-6;
/// Neighbouring quotients that differ by more at every step belong to no derivative.
const BROKEN: f64 = 1e-2;
/// Rounding error of an output, relative to it, that a quotient may contain.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Room for [`System::directional_derivative`], so that it allocates nothing.
#[derive(Clone, Debug)]
pub struct DerivativeRoom {
    scratch: Context,
    outputs: Vec<Output>,
}

/// An output in a derivative that is being computed.
#[derive(Clone, Copy, Debug, Default)]
struct Output {
    /// Values at 0, 1 and 2 steps along the direction.
    values: [f64; 3],
    /// The best quotient so far.
    slope: f64,
    /// How far its neighbours disagree, relatively; infinite before there is one.
    doubt: f64,
}

/// Why there is no derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DerivativeError {
    /// The variable is no Real output.
    Unknown {
        /// The unknown's value reference.
        reference: u32,
    },
    /// The variable is not one that the outputs are computed from now.
    Known {
        /// The known's value reference.
        reference: u32,
        /// Parameters count as knowns.
        at_rest: bool,
    },
    /// A component of the direction is not finite.
    Seed {
        /// Value reference of the known.
        reference: u32,
        /// The component.
        value: f64,
    },
    /// The output jumps here, so that it has no derivative in this direction.
    Jump {
        /// Value reference of the output.
        reference: u32,
    },
    /// The outputs cannot be computed near the present values.
    Step(StepError),
}

impl fmt::Display for DerivativeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { .. } => {
                f.write_str("is no Real output; only those have derivatives")
            }
            Self::Known { at_rest: true, .. } => {
                f.write_str("is neither a Real input nor a Real parameter; differentiate by one of those")
            }
            Self::Known { at_rest: false, .. } => f.write_str(
                "is no Real input; in a step only the inputs are knowns (in Initialization Mode also \
                 the parameters)",
            ),
            Self::Seed { value, .. } => {
                write!(f, "{value} is no component of a direction; give a finite number")
            }
            Self::Jump { .. } => f.write_str(
                "jumps at the present values, so it has no derivative in this direction; ask at \
                 other values",
            ),
            Self::Step(_) => f.write_str("the model leaves its range near the present values"),
        }
    }
}

impl core::error::Error for DerivativeError {}

impl System {
    /// Room for derivatives of this system.
    #[must_use]
    pub fn derivative_room(&self) -> DerivativeRoom {
        let outputs = alloc::vec![Output::default(); self.plan.outputs.len()];
        DerivativeRoom { scratch: self.context.clone(), outputs }
    }

    /// The directional derivative of outputs: `lim (y(v + s·seed) − y(v))/s` for `s → 0` from above,
    /// where `y(v)` is how the present outputs were computed according to `past`, from the values `v`
    /// of the `knowns`.
    ///
    /// After a step that is the step itself, with its state, slopes and parameters: `v` are inputs,
    /// held over the step. At rest it is [`initialise`](Self::initialise): `v` are inputs and
    /// parameters. Each value is in its variable's own unit. `write` gets position and derivative of
    /// each of the `unknowns`; a known that is listed twice counts twice.
    ///
    /// It is a one-sided difference quotient of second order, taken with the largest step on which
    /// the outputs are smooth, so that it is exact but for rounding where they are linear on one
    /// side (hysteresis operators) and good to about 1e-8 where they are curved. A parameter on its
    /// bound is differentiated from inside. An output in which no knows take part has the derivative
    /// 0 exactly. It allocates nothing and changes nothing but `room`.
    ///
    /// # Errors
    /// [`DerivativeError`]; nothing is written then.
    pub fn directional_derivative(
        &mut self,
        room: &mut DerivativeRoom,
        past: &Past,
        knowns: (&[u32], &[f64]),
        unknowns: &[u32],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), DerivativeError> {
        self.check_unknowns(unknowns)?;
        let stride = self.stride(past, knowns)?;
        room.outputs.fill(Output { doubt: f64::INFINITY, ..Output::default() });
        if stride > 0.0 {
            self.quotients(room, past, knowns, stride)?;
            for reference in unknowns {
                if self.output(*reference).is_some_and(|at| room.outputs[at].doubt > BROKEN) {
                    return Err(DerivativeError::Jump { reference: *reference });
                }
            }
        }
        for (position, reference) in unknowns.iter().enumerate() {
            let slope = self.output(*reference).map_or(0.0, |at| room.outputs[at].slope);
            write(position, slope);
        }
        Ok(())
    }

    /// The slope of outputs in time, in their unit per second: `(y_n − y_{n−1})/period`, that of the
    /// straight line through their values at the last two hits. At rest, and as long as there was no
    /// hit, it is 0. `write` gets position and slope of each of the `unknowns`.
    ///
    /// It allocates nothing and changes nothing but `room`.
    ///
    /// # Errors
    /// [`DerivativeError`]; nothing is written then.
    pub fn output_slopes(
        &mut self,
        room: &mut DerivativeRoom,
        past: &Past,
        unknowns: &[u32],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), DerivativeError> {
        self.check_unknowns(unknowns)?;
        let moved = self.one_hit_before(&mut room.scratch, past).map_err(DerivativeError::Step)?;
        for (position, reference) in unknowns.iter().enumerate() {
            let at = *reference as usize;
            let change = self.context.cells[at] - room.scratch.cells[at];
            write(position, if moved { change / self.plan.period } else { 0.0 });
        }
        Ok(())
    }

    /// Which of the plan's outputs the variable is.
    fn output(&self, reference: u32) -> Option<usize> {
        self.plan.outputs.iter().position(|wire| wire.variable == reference as usize)
    }

    fn check_unknowns(&self, unknowns: &[u32]) -> Result<(), DerivativeError> {
        let is_output = |reference: u32| {
            let variable = self.plan.variables.get(reference);
            variable
                .is_some_and(|v| v.causality == Causality::Output && v.data_type == DataType::Real)
        };
        match unknowns.iter().find(|reference| !is_output(**reference)) {
            Some(reference) => Err(DerivativeError::Unknown { reference: *reference }),
            None => Ok(()),
        }
    }

    /// The factor of the direction that moves the known that it moves most, relatively, by its size;
    /// 0 for the direction 0.
    fn stride(
        &self,
        past: &Past,
        (knowns, seed): (&[u32], &[f64]),
    ) -> Result<f64, DerivativeError> {
        let mut most: f64 = 0.0;
        for (reference, value) in knowns.iter().zip(seed) {
            let (reference, value) = (*reference, *value);
            let at_rest = past.is_rest();
            let variable = self.plan.variables.get(reference);
            let variable = variable.filter(|v| {
                let parameter = !matches!(v.causality, Causality::Input | Causality::Output);
                v.data_type == DataType::Real
                    && (v.causality == Causality::Input || (parameter && at_rest))
            });
            let Some(variable) = variable else {
                return Err(DerivativeError::Known { reference, at_rest });
            };
            if !value.is_finite() {
                return Err(DerivativeError::Seed { reference, value });
            }
            let range = variable.max - variable.min;
            let present = self.context.cells[reference as usize].abs();
            let size = if range.is_finite() && range > 0.0 {
                range
            } else if present > 0.0 {
                present
            } else {
                1.0
            };
            most = most.max((value / size).abs());
        }
        Ok(if most > 0.0 { (1.0 / most).min(f64::MAX) } else { 0.0 })
    }

    /// Finds for each output the best quotient along the direction.
    fn quotients(
        &mut self,
        room: &mut DerivativeRoom,
        past: &Past,
        knowns: (&[u32], &[f64]),
        stride: f64,
    ) -> Result<(), DerivativeError> {
        self.sample(room, past, knowns, 0, 0.0).map_err(DerivativeError::Step)?;
        let mut failure = None;
        for side in [1.0, -1.0] {
            for step in STEPS.map(|step| side * step * stride) {
                let sampled = self
                    .sample(room, past, knowns, 1, step)
                    .and_then(|()| self.sample(room, past, knowns, 2, 2.0 * step));
                if let Err(error) = sampled {
                    failure = Some(error);
                    continue;
                }
                failure = None;
                room.outputs.iter_mut().for_each(|output| output.improve(step));
                if room.outputs.iter().all(|output| output.doubt <= SMOOTH) {
                    return Ok(());
                }
            }
            // Only a parameter on its bound needs the other side.
            if failure.is_none() {
                return Ok(());
            }
        }
        failure.map_or(Ok(()), |error| Err(DerivativeError::Step(error)))
    }

    /// Computes the outputs with the knowns moved along the direction.
    fn sample(
        &mut self,
        room: &mut DerivativeRoom,
        past: &Past,
        (knowns, seed): (&[u32], &[f64]),
        place: usize,
        distance: f64,
    ) -> Result<(), StepError> {
        self.again(&mut room.scratch, past, |values| {
            for (reference, component) in knowns.iter().zip(seed) {
                values[*reference as usize] += distance * component;
            }
        })?;
        for (output, wire) in room.outputs.iter_mut().zip(&self.plan.outputs) {
            output.values[place] = room.scratch.cells[wire.variable];
        }
        Ok(())
    }
}

impl Output {
    /// Takes over the quotient over this step where its neighbours agree better than before.
    fn improve(&mut self, step: f64) {
        if self.doubt <= SMOOTH {
            return;
        }
        let [here, near, far] = self.values;
        let (first, second) = ((near - here) / step, (far - near) / step);
        let rounding = ROUNDING * here.abs().max(far.abs()) / step.abs();
        let scale = first.abs().max(second.abs());
        let apart = ((second - first).abs() - rounding).max(0.0);
        let doubt = if apart > 0.0 { apart / scale } else { 0.0 };
        if doubt < self.doubt {
            // The parabola through the three values.
            self.slope = first - 0.5 * (second - first);
            self.doubt = doubt;
        }
    }
}
