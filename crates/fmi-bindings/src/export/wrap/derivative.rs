//! Directional derivatives of a repaired FMU: the chain rule through the effects before the original,
//! the original's own derivative, and the effects behind it.

use surround::{Directions, Jump};

use super::core::{Answer, Code, DISCARD, OK, Original, Wrapped};
use crate::export::Phase;
use crate::export::notice::Notice;

/// Originals that may know directional derivatives.
pub(super) trait Differentiable: Original {
    /// The original's directional derivative of these unknowns.
    fn derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        out: &mut [f64],
    ) -> Answer;
}

impl<O: Differentiable> Wrapped<O> {
    /// The derivative of outputs in a direction of the knowns: in a step of how the last step computed
    /// them, at rest of how rest does, as the original means it.
    pub(super) fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        out: &mut [f64],
    ) -> Answer {
        self.measure(knowns, seed.len())?;
        self.measure(unknowns, out.len())?;
        if let Some(own) = unknowns.iter().find(|r| self.surround.is_own(**r)) {
            return Err(Notice::error(format!(
                "value reference {own} is no output; only those have derivatives"
            )));
        }
        let (mut repaired, mut within) = (Directions::new(), (Vec::new(), Vec::new()));
        let is_active = self.surround.is_active();
        let mut at = 0;
        for reference in knowns {
            let own = &seed[at..at + self.surround.size(*reference)];
            at += own.len();
            if is_active && self.surround.is_ours(*reference) {
                repaired.push((*reference, own.to_vec()));
            } else if !self.surround.is_own(*reference) {
                within.0.push(*reference);
                within.1.extend_from_slice(own);
            }
        }
        if !is_active {
            return self.original.derivative(unknowns, &within.0, &within.1, out);
        }
        if self.phase == Phase::Initialization {
            let code = self.settle_if_stale();
            if code >= DISCARD {
                return Ok(code);
            }
        }
        let parts = self.surround.last_parts();
        if parts > 1 {
            return Err(Notice::discard(format!(
                "the last communication step was done in {parts} parts, because it is longer than \
                 the effects' step; the original knows the derivative of the last part only: take \
                 shorter communication steps, or differences between saved states"
            )));
        }
        let inner = self.surround.inner_directions(&repaired).map_err(jump)?;
        for (reference, direction) in inner.into_iter().filter(|(_, d)| d.iter().any(|d| *d != 0.0))
        {
            within.0.push(reference);
            within.1.extend(direction);
        }
        let (code, moved) = self.moved_outputs(unknowns, &within.0, &within.1)?;
        if code >= DISCARD {
            return Ok(code);
        }
        let shown = self.surround.output_directions(&repaired, &moved).map_err(jump)?;
        let mut at = 0;
        for reference in unknowns {
            let size = self.surround.size(*reference);
            // What the effects show goes before what the original has; `moved` holds each unknown.
            let found = shown.iter().chain(&moved).find(|(known, _)| known == reference);
            if let Some((_, values)) = found {
                out[at..at + size].copy_from_slice(values);
            }
            at += size;
        }
        Ok(code)
    }

    /// How the unknowns, and all outputs with effects, move at the original.
    fn moved_outputs(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
    ) -> Result<(Code, Directions), Notice> {
        let mut references: Vec<u32> =
            self.surround.outputs().iter().map(|variable| variable.reference).collect();
        for unknown in unknowns {
            if !references.contains(unknown) {
                references.push(*unknown);
            }
        }
        let count = references.iter().map(|r| self.surround.size(*r)).sum();
        let mut values = vec![0.0; count];
        let mut code = OK;
        if !knowns.is_empty() {
            code = self.original.derivative(&references, knowns, seed, &mut values)?;
        }
        let mut values = values.into_iter();
        let moved = references.into_iter().map(|reference| {
            let size = self.surround.size(reference);
            (reference, values.by_ref().take(size).collect())
        });
        Ok((code, moved.collect()))
    }
}

fn jump(Jump(reference): Jump) -> Notice {
    Notice::discard(format!(
        "value reference {reference} jumps at the present values, so it has no derivative in this \
         direction; ask at other values"
    ))
}
