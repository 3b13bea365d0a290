//! Directional derivatives.

use model::DerivativeError;

use super::Instance;
use crate::export::guard::{Notice, Outcome};
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
        if self.phase() == Phase::Initialization {
            self.settle()?;
        }
        let Self { system, room, past, .. } = self;
        let done = system.directional_derivative(room, past, (knowns, seed), unknowns, write);
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
