//! Directional derivatives through a repair.
//!
//! # Safety
//! The contract of all functions of [`v3`](super).

use super::super::derivative::Differentiable;
use super::*;

impl Differentiable for Inner {
    fn derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        out: &mut [f64],
    ) -> Answer {
        const NAME: &str = "fmi3GetDirectionalDerivative";
        let (y, ny, u, nu) = (unknowns.as_ptr(), unknowns.len(), knowns.as_ptr(), knowns.len());
        let (seed, ns, out, no) = (seed.as_ptr(), seed.len(), out.as_mut_ptr(), out.len());
        // SAFETY: the function's own type; all arrays have the length given.
        unsafe {
            self.pass::<fmi3GetDirectionalDerivativeTYPE>(NAME, |f, inner| {
                f(inner, y, ny, u, nu, seed, ns, out, no)
            })
        }
    }
}

/// The original's derivative, through the effects.
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    instance: fmi3Instance,
    unknowns: *const fmi3ValueReference,
    nUnknowns: usize,
    knowns: *const fmi3ValueReference,
    nKnowns: usize,
    seed: *const fmi3Float64,
    nSeed: usize,
    sensitivity: *mut fmi3Float64,
    nSensitivity: usize,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's arrays of these lengths.
        let (unknowns, knowns, seed, room) = unsafe {
            (
                array(unknowns, nUnknowns, "unknowns")?,
                array(knowns, nKnowns, "knowns")?,
                array(seed, nSeed, "seed")?,
                Room::new(sensitivity, nSensitivity, "sensitivity")?,
            )
        };
        let mut values = vec![0.0; nSensitivity];
        let code = w.directional_derivative(unknowns, knowns, seed, &mut values)?;
        if code < DISCARD {
            // SAFETY: positions are below `nSensitivity`.
            values.iter().enumerate().for_each(|(at, value)| unsafe { room.write(at, *value) });
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3GetDirectionalDerivative", body) }
}
