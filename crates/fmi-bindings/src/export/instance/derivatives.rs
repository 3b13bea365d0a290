//! Directional derivatives, and slopes of outputs in time.

use model::DerivativeError;

use super::Instance;
use crate::export::notice::{Notice, Outcome};
use crate::export::phase::Phase;

impl Instance {
    /// The derivative of outputs in the direction `seed` of the knowns; `write` gets position and
    /// derivative of each unknown.
    ///
    /// In Initialization Mode, and as long as no step was done, the outputs are those at rest,
    /// `v_InitialUnknowns = f_init(u, …)`; afterwards those of the last step,
    /// `y = f_doStep(u, …)`, with the inputs that were held over it.
    pub(in crate::export) fn directional_derivative(
        &mut self,
        knowns: &[u32],
        seed: &[f64],
        unknowns: &[u32],
        write: impl FnMut(usize, f64),
    ) -> Outcome {
        if self.progress.phase == Phase::Initialization {
            self.settle()?;
        }
        let Self { system, room, past, .. } = self;
        let done = system.directional_derivative(room, past, (knowns, seed), unknowns, write);
        done.map_err(|error| self.no_derivative(&error))
    }

    /// The slope of outputs in time, in their unit per second: that of the straight line through
    /// their values at the last two hits of the internal grid, 0 before the first hit. `write` gets
    /// position and slope of each.
    pub(in crate::export) fn output_slopes(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: impl FnMut(usize, f64),
    ) -> Outcome {
        if let Some(order) = orders.iter().find(|order| **order != 1) {
            return Err(Notice::error(format!(
                "derivative of order {order}: outputs have a slope (maxOutputDerivativeOrder = 1); \
                 give order 1"
            )));
        }
        let Self { system, room, past, .. } = self;
        let done = system.output_slopes(room, past, references, write);
        done.map_err(|error| self.no_derivative(&error))
    }

    #[cold]
    fn no_derivative(&self, error: &DerivativeError) -> Notice {
        let reference = match error {
            DerivativeError::Unknown { reference }
            | DerivativeError::Known { reference, .. }
            | DerivativeError::Seed { reference, .. }
            | DerivativeError::Jump { reference } => *reference,
            DerivativeError::Step(step) => {
                return Notice::discard(format!("{error}: {}", self.system.explain(step)));
            }
        };
        let Some(variable) = self.system.variables().get(reference) else {
            return self.unknown(reference, "Real");
        };
        let notice = self.refused(variable, reference, &error.to_string());
        match error {
            DerivativeError::Jump { .. } => Notice::discard(notice.message),
            _ => notice,
        }
    }
}
