//! Coordination of axes whose coupling has dynamics: Jacobian and a matrix of filters that know the reference ahead.
//!
//! ```text
//! θ_r = J⁻¹·(p_r − p0)                becomes, `preview` later, the axis' reference
//! θ_m = J⁻¹·(p − p0)                  becomes the axis' measured position
//! path_i(t) = Σ_k Σ_j F_kij·θ_rj(t − k·T)   goes to the axis' feedforward
//! ```
//!
//! * matrix J in position per motion and offset p0 in position as of `jacobian-coordinator`, which this is with taps of
//!   [1] and no preview; J is refused above a condition number of 1000.
//! * taps F without unit: a matrix per period, row by row, tap after tap; a row per axis that is moved, a column per
//!   axis whose reference moves it. They belong to one period T, sample_time, and are refused at another.
//! * preview in s, a whole number of periods: by so much the position follows the reference input late, or the
//!   reference input runs ahead. The law behind compares the position with the reference of then.
//! * At rest path is Σ_k F_k·θ_r. n axes and N taps cost n²·N multiplications a period.
//!
//! Limits: fixed geometry, linear; 2 to 8 axes.
//!
//! Source: M. Tomizuka, ASME J. Dyn. Syst. Meas. Control 115 (1993) 412–418 (preview); laser beam pointing with four
//! piezo axes, eqs. (14), (18), (19) (Jacobian).

use libm::{fabs, round};
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Structural, Tick,
    Violation,
};

use super::jacobian_coordinator::{JacobianCoordinator, motions};
use crate::coupling::matrix;
use crate::rules::{WRONG_LENGTH, kept, require};

/// The component `preview-coordinator`.
pub struct PreviewCoordinator;

/// Most axes, entries of all taps, and periods of preview.
const AXES: usize = 8;
const ENTRIES: usize = 1 << 16;
const PERIODS: f64 = 4096.0;
/// Greatest condition number of the Jacobian.
const CONDITION: f64 = 1000.0;
/// Parts of a period that do not count.
const ROUNDING: f64 = 1e-6;

static STRUCTURE: [Structural; 5] = [
    Structural::count("axes", "Number of coupled axes", 2, AXES),
    Structural::count("entries", "Number of entries of the matrix", 4, AXES * AXES),
    Structural::count("filter", "Entries of all taps", 4, ENTRIES),
    Structural::real("sample_time", "s", "Sample period of the taps", 1e-3, 1e-9, 1e3),
    Structural::real("preview", "s", "Time by which the reference input is ahead", 0.0, 0.0, 1e3),
];
static DECLARATION: Declaration = Declaration {
    kind: "preview-coordinator",
    name: "coordinator",
    summary: "From coordinates to the motions of axes whose coupling has dynamics: inverse Jacobian, and filters that use the reference in advance",
    equation: "theta_r = J^-1*(p_r - p0); theta_m = J^-1*(p - p0); path[i] = \
               sum(taps[k,i,j]*theta_r[j](t - k*T)); reference = theta_r(t - preview)",
    reference: "M. Tomizuka, ASME J. Dyn. Syst. Meas. Control 115 (1993) 412-418",
    stage: Stage::Control,
    conversion: Conversion::PositionToMotion,
    inputs: &[Input::EACH_PATH, Input::each("measured")],
    outputs: &[
        Output::PATH,
        Output { name: "reference", published: None },
        Output { name: "measured", published: None },
    ],
    structure: &STRUCTURE,
    parameters: &[
        // {command} is the unit of the motion.
        Quantity::new("matrix", "{position}/{command}", "Jacobian, row by row").per(1),
        Quantity::new("offset", "{position}", "Coordinates at zero motion").per(0),
        Quantity::new("taps", "1", "Motion per motion of each tap, row by row, tap after tap")
            .per(2),
    ],
    ..Declaration::PATH
};

/// Axes, taps and steps of preview.
fn counts(structure: &[f64], period: f64) -> (usize, usize, usize) {
    let n = matrix::axes(structure);
    let entries = structure.get(2).map_or(0, |count| *count as usize);
    let ahead = structure.get(4).map_or(0.0, |preview| round(preview / period));
    let ahead = if ahead <= PERIODS { ahead as usize } else { 0 };
    (n, entries / (n * n).max(1), ahead)
}

impl Component for PreviewCoordinator {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("sample_time", &[1e-4]),
            ("preview", &[1e-4]),
            ("matrix", &[1.0, 0.02, -0.03, 0.9]),
            ("offset", &[3.0, -2.0]),
            ("taps", &[0.1, 0.0, 0.02, 0.2, 0.9, -0.1, 0.0, 0.8]),
        ]
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        let (n, taps, ahead) = counts(structure, period);
        let own = JacobianCoordinator.sizes(structure, period).coefficients;
        // The coordinator's, steps of preview, and the taps; where the ring begins, and past motions.
        Sizes { coefficients: own + 1 + taps * n * n, states: 1 + n * taps.max(ahead + 1) }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (n, taps, ahead) = counts(structure, period);
        let &[_, entries, filter, sample_time, preview] = structure else {
            return Err(WRONG_LENGTH);
        };
        matrix::is_square(structure)?;
        require(
            filter == (taps * n * n) as f64 && taps > 0,
            "taps",
            filter,
            "entries: each tap is a matrix with a row and a column per axis; give them all, tap after tap",
        )?;
        require(
            fabs(sample_time - period) <= ROUNDING * period,
            "sample_time",
            sample_time,
            "is the period that the taps belong to, and the controller has another; design it anew for this period",
        )?;
        require(
            fabs(preview / period - ahead as f64) <= ROUNDING * (1.0 + ahead as f64),
            "preview",
            preview,
            "is a whole number of the controller's periods, at most 4096",
        )?;
        let square = entries as usize;
        if parameters.len() != square + n + taps * n * n {
            return Err(WRONG_LENGTH);
        }
        let own = JacobianCoordinator.sizes(structure, period).coefficients;
        let (jacobian, filter) = parameters.split_at(square + n);
        let (coordinator, rest) = coefficients.split_at_mut_checked(own).ok_or(WRONG_LENGTH)?;
        JacobianCoordinator::prepare_with(n, jacobian, CONDITION, coordinator)?;
        let (steps, room) = rest.split_first_mut().ok_or(WRONG_LENGTH)?;
        *steps = ahead as f64;
        kept(filter, room)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let n = inputs.len() / 2;
        let mut wanted = [0.0; AXES];
        let (Some(wanted), Some((begin, ring))) = (wanted.get_mut(..n), state.split_first_mut())
        else {
            return;
        };
        if !motions(coefficients, inputs, outputs) {
            return;
        }
        wanted.copy_from_slice(&outputs[..n]);
        *begin = 0.0;
        for past in ring.chunks_exact_mut(n.max(1)) {
            past.copy_from_slice(wanted);
        }
        filtered(coefficients, 0, ring, outputs);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let n = inputs.len() / 2;
        let Some((begin, ring)) = state.split_first_mut() else { return };
        if n == 0 || !motions(coefficients, inputs, outputs) {
            return;
        }
        let last = (ring.len() / n).saturating_sub(1);
        // The newest motion stands where the ring begins, older ones behind it. A restored state may hold any number.
        let now = if *begin >= 1.0 { (*begin as usize - 1).min(last) } else { last };
        *begin = now as f64;
        if let Some(cell) = ring.get_mut(now * n..(now + 1) * n) {
            cell.copy_from_slice(&outputs[..n]);
        }
        filtered(coefficients, now, ring, outputs);
    }
}

/// Puts the filtered motions on the paths, and those of `preview` ago on the references.
fn filtered(coefficients: &[f64], now: usize, ring: &[f64], outputs: &mut [f64]) {
    let n = outputs.len() / 3;
    let own = 2 * n * n + n;
    let Some((ahead, taps)) = coefficients.get(own..).and_then(<[f64]>::split_first) else {
        return;
    };
    let (path, others) = outputs.split_at_mut(n);
    let (newer, older) = ring.split_at((now * n).min(ring.len()));
    path.fill(0.0);
    let past = older.chunks_exact(n).chain(newer.chunks_exact(n));
    for (tap, motion) in taps.chunks_exact(n * n).zip(past.clone()) {
        for (sum, row) in path.iter_mut().zip(tap.chunks_exact(n)) {
            for (factor, value) in row.iter().zip(motion) {
                *sum += factor * value;
            }
        }
    }
    if let (Some(motion), Some(reference)) =
        (past.clone().nth(*ahead as usize), others.get_mut(..n))
    {
        reference.copy_from_slice(motion);
    }
}

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use super::*;

    const T: f64 = 1e-3;

    fn refusal(taps: usize, sample_time: f64, preview: f64) -> &'static str {
        let structure = [2.0, 4.0, taps as f64, sample_time, preview];
        let mut coefficients = vec![0.0; PreviewCoordinator.sizes(&structure, T).coefficients];
        let values = [vec![1.0, 0.0, 0.0, 1.0, 0.0, 0.0], vec![1.0; taps]].concat();
        let found = PreviewCoordinator.prepare(&structure, &values, T, &mut coefficients);
        found.err().map_or("", |violation| violation.quantity)
    }

    #[test]
    fn taps_act_on_past_motions_of_all_axes_and_the_reference_comes_later() {
        // p1 = 2·θ1 + 1, p2 = θ1 + θ2; three taps, preview of 3 periods.
        let structure = [2.0, 4.0, 12.0, T, 3.0 * T];
        let taps = [0.5, 0.1, 0.0, 1.0, 0.3, 0.0, -0.2, 0.0, 0.2, 0.4, 0.1, 0.2];
        let values = [&[2.0, 0.0, 1.0, 1.0, 1.0, 0.0][..], &taps].concat();
        let sizes = PreviewCoordinator.sizes(&structure, T);
        let (mut coefficients, mut state) =
            (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
        PreviewCoordinator.prepare(&structure, &values, T, &mut coefficients).expect("fits");
        let motion = |k: i32| {
            let k = f64::from(k.max(0));
            [0.3 * k * k, 1.0 - 0.7 * k]
        };
        let position = |[a, b]: [f64; 2]| [2.0 * a + 1.0, a + b];
        let mut out = [0.0; 6];
        for k in 0..20 {
            let inputs = [position(motion(k)), position([0.25, -0.5])].concat();
            let tick = Tick { index: k as u64, time: f64::from(k) * T, period: T };
            if k == 0 {
                PreviewCoordinator.rest(&coefficients, &inputs, &mut state, &mut out);
            } else {
                PreviewCoordinator.step(&coefficients, &mut state, tick, &inputs, &mut out);
            }
            for row in 0..2 {
                let sum = |tap: i32| -> f64 {
                    let past = motion(k - tap);
                    (0..2).map(|j| taps[4 * tap as usize + 2 * row + j] * past[j]).sum()
                };
                let path: f64 = (0..3).map(sum).sum();
                assert!((out[row] - path).abs() < 1e-12, "{k}: {out:?} {path}");
                assert!((out[2 + row] - motion(k - 3)[row]).abs() < 1e-12, "{k}: {out:?}");
            }
            assert!((out[4] - 0.25).abs() < 1e-15 && (out[5] + 0.5).abs() < 1e-15, "{out:?}");
        }
    }

    #[test]
    fn a_restored_state_without_a_place_in_the_ring_finds_one() {
        let structure = [2.0, 4.0, 8.0, T, 0.0];
        let values = [&[1.0, 0.0, 0.0, 1.0, 0.0, 0.0][..], &[1.0; 8]].concat();
        let sizes = PreviewCoordinator.sizes(&structure, T);
        let mut coefficients = vec![0.0; sizes.coefficients];
        PreviewCoordinator.prepare(&structure, &values, T, &mut coefficients).expect("fits");
        let tick = Tick { index: 1, time: T, period: T };
        for begin in [f64::MAX, 1e18, 3.0, 0.5, -1.0, f64::NAN] {
            let mut state = vec![0.0; sizes.states];
            state[0] = begin;
            let mut out = [0.0; 6];
            PreviewCoordinator.step(&coefficients, &mut state, tick, &[0.5; 4], &mut out);
            assert_eq!(state, [1.0, 0.0, 0.0, 0.5, 0.5], "{begin}");
        }
    }

    #[test]
    fn taps_of_another_period_or_shape_and_a_preview_between_periods_are_refused() {
        let found: Vec<&str> = [(8, T, 2.0 * T), (6, T, 0.0), (8, 2.0 * T, 0.0), (8, T, 2.5 * T)]
            .map(|(taps, sample_time, preview)| refusal(taps, sample_time, preview))
            .into();
        assert_eq!(found, ["", "taps", "sample_time", "preview"]);
    }
}
