//! Directional derivatives through a repair.
//!
//! # Safety
//! The contract of all functions of [`v2`](super).

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
        const NAME: &str = "fmi2GetDirectionalDerivative";
        let (y, ny, u, nu) = (unknowns.as_ptr(), unknowns.len(), knowns.as_ptr(), knowns.len());
        // SAFETY: the function's own type; all arrays have the length given.
        unsafe {
            self.pass::<fmi2GetDirectionalDerivativeTYPE>(NAME, |f, inner| {
                f(inner, y, ny, u, nu, seed.as_ptr(), out.as_mut_ptr())
            })
        }
    }
}

/// The original's derivative, through the effects.
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    vUnknown_ref: *const fmi2ValueReference,
    nUnknown: usize,
    vKnown_ref: *const fmi2ValueReference,
    nKnown: usize,
    dvKnown: *const fmi2Real,
    dvUnknown: *mut fmi2Real,
) -> fmi2Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's arrays of `nUnknown` and `nKnown` elements.
        let (unknowns, knowns, seed, room) = unsafe {
            (
                array(vUnknown_ref, nUnknown, "vUnknown_ref")?,
                array(vKnown_ref, nKnown, "vKnown_ref")?,
                array(dvKnown, nKnown, "dvKnown")?,
                Room::new(dvUnknown, nUnknown, "dvUnknown")?,
            )
        };
        let mut values = vec![0.0; nUnknown];
        let code = w.directional_derivative(unknowns, knowns, seed, &mut values)?;
        if code < DISCARD {
            // SAFETY: positions are below `nUnknown`.
            values.iter().enumerate().for_each(|(at, value)| unsafe { room.write(at, *value) });
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2GetDirectionalDerivative", body) }
}
