//! Coupling from the neighbours' commands through a mode of each neighbour.
//!
//! ```text
//! y_i = x_i + Σ_j K_ij·z_j,   z_j″ + 2·damping_j·ω_j·z_j′ + ω_j²·z_j = ω_j²·u_j,   ω_j = 2π·frequency_j
//! ```
//!
//! * matrix K in position per command, row by row, zero on the diagonal; frequency in Hz and
//!   damping of the mode of each axis that is shared; u_j is the command of axis j.
//! * State: z_j and z_j′/ω_j. Exact at any period. Up to four axes.
//!
//! Limits: linear; the neighbour does not feel the motion that it causes.

use model::{
    Component, Declaration, Input, Quantity, Role, Sizes, Stage, Structural, Tick, Violation,
};

use super::matrix;
use crate::linear::Transition;
use crate::rules::{WRONG_LENGTH, second_order};
use crate::{effects, phenomena};

/// The component `mode-coupling`.
pub struct ModeCoupling;

static STRUCTURE: [Structural; 2] = matrix::structure(4);
static DECLARATION: Declaration = Declaration {
    kind: "mode-coupling",
    name: "mode_coupling",
    summary: "Coupling from the neighbours' commands through a mode of each neighbour",
    equation: "y[i] = x[i] + sum(matrix[i,j]*z[j]); z'' + 2*damping*w*z' + w^2*z = w^2*u; w = \
               2*pi*frequency",
    reference: "S. Devasia, E. Eleftheriou, S. O. R. Moheimani, IEEE Trans. CST 15 (2007) 802-823",
    stage: Stage::Coupling,
    effect: Some(&effects::CROSS_COUPLING),
    phenomena: &[&phenomena::DYNAMIC_COUPLING],
    inputs: &[Input::EACH_PATH, Input::each("command")],
    structure: &STRUCTURE,
    parameters: &[
        Quantity::new(
            "matrix",
            "{position}/{command}",
            "Motion per command of the neighbour, row by row, zero on the diagonal",
        )
        .per(1)
        .fitted(),
        Quantity::new("frequency", "Hz", "Undamped natural frequency of each axis' mode")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .per(0)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio of each axis' mode")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .per(0)
            .min(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

/// Numbers per axis: the three coefficients of its transition.
const PER_AXIS: usize = 3;

impl Component for ModeCoupling {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let n = matrix::axes(structure);
        Sizes { coefficients: PER_AXIS * n + matrix::entries(structure), states: 2 * n }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (n, entries) = (matrix::axes(structure), matrix::entries(structure));
        if parameters.len() != entries + 2 * n || coefficients.len() != entries + PER_AXIS * n {
            return Err(WRONG_LENGTH);
        }
        matrix::is_square(structure)?;
        let (matrix, modes) = parameters.split_at(entries);
        matrix::is_hollow(matrix, n)?;
        let (transitions, own) = coefficients.split_at_mut(PER_AXIS * n);
        own.copy_from_slice(matrix);
        let (frequencies, dampings) = modes.split_at(n);
        let modes = frequencies.iter().zip(dampings).enumerate();
        for ((index, (f, d)), slot) in modes.zip(transitions.chunks_exact_mut(PER_AXIS)) {
            second_order(*f, *d, period).map_err(|v| Violation { index: Some(index), ..v })?;
            let t = Transition::new(*f, *d, period);
            slot.copy_from_slice(&[t.same, t.cross, t.rate]);
        }
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (_, u) = inputs.split_at(inputs.len() / 2);
        for (mode, u) in state.chunks_exact_mut(2).zip(u) {
            mode.copy_from_slice(&[*u, 0.0]);
        }
        add(coefficients, inputs, state, outputs);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (_, u) = inputs.split_at(inputs.len() / 2);
        let modes = state.chunks_exact_mut(2).zip(u);
        for ((mode, u), t) in modes.zip(coefficients.chunks_exact(PER_AXIS)) {
            if let (&[same, cross, rate], [z, v]) = (t, mode) {
                let (e, scaled_rate) = Transition { same, cross, rate }.apply(*z - u, *v);
                (*z, *v) = (u + e, scaled_rate);
            }
        }
        add(coefficients, inputs, state, outputs);
    }
}

/// The paths with what the modes add.
#[inline]
fn add(coefficients: &[f64], inputs: &[f64], state: &[f64], outputs: &mut [f64]) {
    let n = inputs.len() / 2;
    let Some((_, matrix)) = coefficients.split_at_checked(PER_AXIS * n) else { return };
    for ((output, row), x) in outputs.iter_mut().zip(matrix.chunks_exact(n.max(1))).zip(inputs) {
        let sum: f64 = row.iter().zip(state.chunks_exact(2)).map(|(k, mode)| k * mode[0]).sum();
        *output = x + sum;
    }
}
