//! A linear structure with as many inputs as outputs: modes that all axes share.
//!
//! ```text
//! y_i = Σ_j D_ij·x_j + Σ_k Σ_j (R_kij·z_kj + Q_kij·z_kj′/ω_k)
//! z_kj″ + 2·damping_k·ω_k·z_kj′ + ω_k²·z_kj = ω_k²·x_j,   ω_k = 2π·frequency_k
//! ```
//!
//! * direct D, and per mode residue R and rate_residue Q, without unit, row by row and mode after mode: a
//!   row per axis that is moved, a column per axis that moves it. frequency in Hz and damping of each mode; a
//!   damping of 1 or more is a pair of real poles.
//! * The static gain is `D + Σ_k R_k`. Residues of any rank: a free structure has those of rank one.
//! * State: z_kj and z_kj′/ω_k. Exact at any period, as the input is held over a step. Up to eight axes.
//!
//! Limits: linear.
//!
//! Source: J.-N. Juang, R. S. Pappa, J. Guidance 8 (1985) 620-627; fitted by `piezoloop frequency-response`.

use model::{
    Component, Declaration, Input, Quantity, Role, Sizes, Stage, Structural, Tick, Violation,
};

use super::matrix;
use crate::linear::Transition;
use crate::rules::{WRONG_LENGTH, require, second_order};
use crate::{effects, phenomena};

/// The component `modal-matrix`.
pub struct ModalMatrix;

/// Most axes, and most modes.
const AXES: usize = 8;
const MODES: usize = 64;

/// Settings of components with matrices of modes.
pub(super) const STRUCTURE: [Structural; 4] = [
    Structural::count("axes", "Number of coupled axes", 1, AXES),
    Structural::count("entries", "Number of entries of a matrix", 1, AXES * AXES),
    Structural::count("modes", "Number of modes", 1, MODES),
    Structural::count("residues", "Entries of all modes' matrices", 1, MODES * AXES * AXES),
];

static DECLARATION: Declaration = Declaration {
    kind: "modal-matrix",
    name: "modes",
    summary: "Linear structure with several inputs and outputs: modes that all axes share",
    equation: "y[i] = sum(direct[i,j]*x[j]) + sum(residue[k,i,j]*z[k,j] + rate_residue[k,i,j]*z[k,j]'/w[k]); \
               z'' + 2*damping*w*z' + w^2*z = w^2*x; w = 2*pi*frequency",
    reference: "J.-N. Juang, R. S. Pappa, J. Guidance 8 (1985) 620-627",
    stage: Stage::Coupling,
    phenomena: &[&phenomena::DYNAMIC_COUPLING],
    inputs: &[Input::EACH_PATH],
    structure: &STRUCTURE,
    parameters: &[
        Quantity::new("direct", "1", "Motion per motion outside the listed modes, row by row")
            .per(1)
            .fitted(),
        Quantity::new("frequency", "Hz", "Undamped natural frequency of each mode")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .per(2)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio of each mode")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .per(2)
            .min(0.0)
            .fitted(),
        Quantity::new(
            "residue",
            "1",
            "Static motion per motion through each mode, row by row, mode after mode",
        )
        .per(3)
        .fitted(),
        Quantity::new(
            "rate_residue",
            "1",
            "Motion per rate of each mode over its angular frequency, row by row, mode after mode",
        )
        .per(3)
        .fitted(),
    ],
    ..Declaration::PATH
};

/// Numbers of axes and modes.
pub(super) fn counts(structure: &[f64]) -> (usize, usize) {
    (matrix::axes(structure), structure.get(2).map_or(0, |n| *n as usize))
}

/// Refuses a direct matrix that is not square, and residues that are not a matrix per mode.
pub(super) fn has_matrices(structure: &[f64]) -> Result<(), Violation> {
    matrix::is_square(structure)?;
    let (n, modes) = counts(structure);
    let residues = structure.get(3).copied().unwrap_or(0.0);
    require(
        residues == (modes * n * n) as f64,
        "residue",
        residues,
        "entries: each mode has a matrix with a row and a column per axis; give them all, mode after mode",
    )
}

/// Coefficients of a mode's transition.
const TRANSITION: usize = 3;

/// Coefficients of a mode: those of its transition, R and Q.
fn per_mode(axes: usize) -> usize {
    TRANSITION + 2 * axes * axes
}

impl Component for ModalMatrix {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    #[cfg(not(target_family = "wasm"))]
    fn way(&self, structure: &[f64], to: usize, from: usize) -> Option<model::TransferPath> {
        let (n, modes) = counts(structure);
        if to.max(from) >= n {
            return None;
        }
        let (entries, own) = (n * n, n * to + from);
        let poles = entries..entries + 2 * modes;
        let residues = (0..2 * modes).map(move |k| entries + 2 * modes + k * entries + own);
        let takes = core::iter::once(own).chain(poles).chain(residues);
        let modes = modes as f64;
        Some(model::TransferPath::new(&ModalMatrix, &[1.0, 1.0, modes, modes], takes))
    }

    #[cfg(not(target_family = "wasm"))]
    fn part(&self, structure: &[f64], number: usize) -> Option<model::TransferPath> {
        let (n, modes) = counts(structure);
        let of_mode = (0..4).map(|place| 1 + place * modes + number);
        let takes = core::iter::once(0).chain(of_mode);
        (n == 1 && number < modes).then(|| model::TransferPath::new(&ModalMatrix, &[1.0; 4], takes))
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let (n, modes) = counts(structure);
        Sizes { coefficients: n * n + modes * per_mode(n), states: 2 * n * modes }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (n, modes) = counts(structure);
        let entries = n * n;
        has_matrices(structure)?;
        if parameters.len() != entries + 2 * modes * (1 + entries)
            || coefficients.len() != entries + modes * per_mode(n)
        {
            return Err(WRONG_LENGTH);
        }
        let (direct, rest) = parameters.split_at(entries);
        let (frequencies, rest) = rest.split_at(modes);
        let (dampings, rest) = rest.split_at(modes);
        let (residues, rate_residues) = rest.split_at(modes * entries);
        let (own_direct, own) = coefficients.split_at_mut(entries);
        own_direct.copy_from_slice(direct);
        let poles = frequencies.iter().zip(dampings).enumerate();
        let matrices = residues.chunks_exact(entries).zip(rate_residues.chunks_exact(entries));
        for (((index, (f, d)), (r, q)), slot) in
            poles.zip(matrices).zip(own.chunks_exact_mut(per_mode(n)))
        {
            second_order(*f, *d, period).map_err(|v| Violation { index: Some(index), ..v })?;
            let Transition { same, cross, rate } = Transition::new(*f, *d, period);
            let (transition, matrices) = slot.split_at_mut(TRANSITION);
            transition.copy_from_slice(&[same, cross, rate]);
            let (own_r, own_q) = matrices.split_at_mut(entries);
            own_r.copy_from_slice(r);
            own_q.copy_from_slice(q);
        }
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let n = inputs.len().max(1);
        for mode in state.chunks_exact_mut(2 * n) {
            let (z, v) = mode.split_at_mut(n);
            z.copy_from_slice(inputs);
            v.fill(0.0);
        }
        read(inputs.len(), TRANSITION, coefficients, inputs, state, outputs);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        // With the number of axes known to the compiler a step takes less than half of the time.
        match inputs.len() {
            1 => step_of(1, coefficients, state, inputs, outputs),
            2 => step_of(2, coefficients, state, inputs, outputs),
            3 => step_of(3, coefficients, state, inputs, outputs),
            n => step_of(n, coefficients, state, inputs, outputs),
        }
    }

    #[cfg(feature = "records")]
    fn step_records(
        &self,
        coefficients: &[f64],
        _period: f64,
        hits: core::ops::Range<usize>,
        records: &mut [model::Record<'_>],
        _outputs: &mut [f64],
    ) {
        let Some((direct, modes)) = coefficients.split_first() else { return };
        for record in records {
            let (x, out) = (&record.inputs[0][hits.clone()], &mut record.out[hits.clone()]);
            out.iter_mut().zip(x).for_each(|(out, x)| *out = 0.0 + direct * x);
            let mut states = record.state.chunks_exact_mut(2 * LANES);
            let mut slots = modes.chunks_exact(LANES * per_mode(1));
            for (slots, states) in (&mut slots).zip(&mut states) {
                run_modes::<LANES>(slots, states, x, out);
            }
            let rest = slots.remainder().chunks_exact(per_mode(1));
            for (slot, state) in rest.zip(states.into_remainder().chunks_exact_mut(2)) {
                run_modes::<1>(slot, state, x, out);
            }
        }
    }
}

/// Modes whose states stay in registers while they run through a record.
#[cfg(feature = "records")]
const LANES: usize = 4;

/// Adds what the next `M` modes of a structure with one axis make of the path `x` to `out`, as steps one after the
/// other would: to the bit.
#[cfg(feature = "records")]
fn run_modes<const M: usize>(coefficients: &[f64], state: &mut [f64], x: &[f64], out: &mut [f64]) {
    let of = |place: usize| core::array::from_fn(|k| coefficients[per_mode(1) * k + place]);
    let [same, cross, rate, r, q]: [[f64; M]; 5] = core::array::from_fn(of);
    let mut z: [f64; M] = core::array::from_fn(|k| state[2 * k]);
    let mut v: [f64; M] = core::array::from_fn(|k| state[2 * k + 1]);
    for (x, out) in x.iter().zip(out) {
        let mut sum = *out;
        for k in 0..M {
            let transition = Transition { same: same[k], cross: cross[k], rate: rate[k] };
            let (e, scaled_rate) = transition.apply(z[k] - x, v[k]);
            (z[k], v[k]) = (x + e, scaled_rate);
            sum += r[k] * z[k] + q[k] * v[k];
        }
        *out = sum;
    }
    for k in 0..M {
        (state[2 * k], state[2 * k + 1]) = (z[k], v[k]);
    }
}

/// A step over `n` axes, compiled anew for each n that is a constant where it is called.
#[inline(always)]
fn step_of(n: usize, coefficients: &[f64], state: &mut [f64], inputs: &[f64], outputs: &mut [f64]) {
    advance(n, coefficients, state, inputs);
    read(n, TRANSITION, coefficients, inputs, state, outputs);
}

/// Moves the states on by a step.
#[inline(always)]
fn advance(n: usize, coefficients: &[f64], state: &mut [f64], inputs: &[f64]) {
    let n = n.max(1);
    let Some((_, modes)) = coefficients.split_at_checked(n * n) else { return };
    for (slot, mode) in modes.chunks_exact(per_mode(n)).zip(state.chunks_exact_mut(2 * n)) {
        let &[same, cross, rate, ..] = slot else { return };
        let transition = Transition { same, cross, rate };
        let (z, v) = mode.split_at_mut(n);
        for ((z, v), x) in z.iter_mut().zip(v).zip(inputs) {
            let (e, scaled_rate) = transition.apply(*z - x, *v);
            (*z, *v) = (x + e, scaled_rate);
        }
    }
}

/// What the states and the inputs make of the paths; each mode has `head` coefficients in front of R and Q.
#[inline(always)]
pub(super) fn read(
    n: usize,
    head: usize,
    coefficients: &[f64],
    inputs: &[f64],
    state: &[f64],
    outputs: &mut [f64],
) {
    let n = n.max(1);
    let entries = n * n;
    let Some((direct, modes)) = coefficients.split_at_checked(entries) else { return };
    matrix::product(direct, core::iter::repeat_n(&0.0, n), inputs, outputs);
    for (slot, mode) in modes.chunks_exact(head + 2 * entries).zip(state.chunks_exact(2 * n)) {
        let Some((r, q)) = slot.get(head..).and_then(|both| both.split_at_checked(entries)) else {
            return;
        };
        let (z, v) = mode.split_at(n);
        let rows = r.chunks_exact(n).zip(q.chunks_exact(n));
        for (output, (r, q)) in outputs.iter_mut().zip(rows) {
            let slow: f64 = r.iter().zip(z).map(|(r, z)| r * z).sum();
            let fast: f64 = q.iter().zip(v).map(|(q, v)| q * v).sum();
            *output += slow + fast;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::MODE;
    use crate::testing::{Instance, Random};

    const T: f64 = 1e-4;

    /// Paths of a component over two axes.
    fn run(structure: &[f64], values: &[f64], signals: &[[f64; 2]]) -> [std::vec::Vec<f64>; 2] {
        let mut own = Instance::new(&ModalMatrix, structure, values, T).unwrap();
        own.outputs = std::vec![0.0; 2];
        let mut all = [std::vec![], std::vec![]];
        own.rest(&[0.0; 2]);
        for inputs in signals {
            own.step(inputs);
            all[0].push(own.outputs[0]);
            all[1].push(own.outputs[1]);
        }
        all
    }

    #[cfg(feature = "records")]
    #[test]
    fn records_run_as_single_steps_do_and_a_part_changes_as_all_do() {
        const SEED: u64 = 3;
        const MODES: usize = 7;
        let mut random = Random::new(SEED);
        let x: std::vec::Vec<f64> = (0..500).map(|_| random.between(-1.0, 1.0)).collect();
        let mut values = std::vec![0.3];
        for (low, high) in [(50.0, 2000.0), (0.01, 1.2), (-1.0, 1.0), (-1.0, 1.0)] {
            values.extend((0..MODES).map(|_| random.between(low, high)));
        }
        let with_records = |structure: &[f64], values: &[f64]| {
            let mut own = Instance::new(&ModalMatrix, structure, values, T).unwrap();
            own.rest(&x[..1]);
            let mut out = std::vec![own.outputs[0]; x.len()];
            let state = own.state.clone();
            let record = model::Record { inputs: [&x, &x], count: 1, out: &mut out, state };
            let mut outputs = [0.0];
            let coefficients = own.coefficients.clone();
            let hits = [1..200, 200..x.len()];
            let mut records = [record];
            for hits in hits {
                ModalMatrix.step_records(&coefficients, T, hits, &mut records, &mut outputs);
            }
            out
        };
        let structure = [1.0, 1.0, MODES as f64, MODES as f64];
        let own = with_records(&structure, &values);
        let mut one = Instance::new(&ModalMatrix, &structure, &values, T).unwrap();
        assert_eq!(own[1..], one.response(x[0], &x[1..]), "seed {SEED}");
        for k in 0..values.len() {
            let mut other = values.clone();
            other[k] *= 1.01;
            let mut parts = (0..).map_while(|number| ModalMatrix.part(&structure, number));
            let part = parts.find(|part| part.takes.contains(&k)).unwrap();
            let of_part = |values: &[f64]| {
                let taken: std::vec::Vec<f64> = part.takes.iter().map(|k| values[*k]).collect();
                with_records(&part.structure, &taken)
            };
            let [before, after, all] =
                [of_part(&values), of_part(&other), with_records(&structure, &other)];
            for n in 0..x.len() {
                let change = after[n] - before[n];
                assert!(
                    (all[n] - own[n] - change).abs() < 1e-12,
                    "value {k}, step {n}, seed {SEED}"
                );
            }
        }
        assert!(ModalMatrix.part(&structure, MODES).is_none());
        assert!(ModalMatrix.part(&[2.0, 4.0, 2.0, 8.0], 0).is_none());
    }

    #[test]
    fn is_a_matrix_of_sums_of_modes() {
        let mut random = Random::new(5);
        let signals: std::vec::Vec<[f64; 2]> =
            (0..400).map(|_| [random.between(-1.0, 1.0), random.between(-1.0, 1.0)]).collect();
        let (f, d) = ([300.0, 720.0], [0.02, 1.4]);
        let direct = [0.1, -0.2, 0.3, 0.4];
        let residue = [1.0, 0.5, -0.3, 0.8, 0.2, -0.6, 0.7, 0.9];
        let values = [&direct[..], &f, &d, &residue, &[0.0; 8]].concat();
        let own = run(&[2.0, 4.0, 2.0, 8.0], &values, &signals);
        let through = |mode: usize, input: usize| {
            let x: std::vec::Vec<f64> = signals.iter().map(|both| both[input]).collect();
            let mut one = Instance::new(&MODE, &[], &[f[mode], d[mode], 1.0], T).unwrap();
            one.response(0.0, &x)
        };
        let z = [[through(0, 0), through(0, 1)], [through(1, 0), through(1, 1)]];
        for (k, inputs) in signals.iter().enumerate() {
            for (i, path) in own.iter().enumerate() {
                let wanted: f64 = (0..2)
                    .map(|j| {
                        let modes: f64 =
                            (0..2).map(|m| residue[4 * m + 2 * i + j] * z[m][j][k]).sum();
                        direct[2 * i + j] * inputs[j] + modes
                    })
                    .sum();
                assert!((path[k] - wanted).abs() < 1e-12, "row {k}, axis {i}");
            }
        }
    }

    #[test]
    fn is_the_sum_of_its_ways() {
        let mut random = Random::new(11);
        let structure = [2.0, 4.0, 2.0, 8.0];
        let mut values: std::vec::Vec<f64> = (0..24).map(|_| random.between(-1.0, 1.0)).collect();
        values[4..8].copy_from_slice(&[150.0, 420.0, 0.03, 1.2]);
        let signals: std::vec::Vec<[f64; 2]> =
            (0..300).map(|_| [random.between(-1.0, 1.0), random.between(-1.0, 1.0)]).collect();
        let complete = run(&structure, &values, &signals);
        for (to, path) in complete.iter().enumerate() {
            let mut sum = std::vec![0.0; signals.len()];
            for from in 0..2 {
                let way = ModalMatrix.way(&structure, to, from).unwrap();
                let own: std::vec::Vec<f64> = way.takes.iter().map(|k| values[*k]).collect();
                let mut one = Instance::new(way.component, &way.structure, &own, T).unwrap();
                let x: std::vec::Vec<f64> = signals.iter().map(|both| both[from]).collect();
                let y = one.response(0.0, &x);
                sum.iter_mut().zip(y).for_each(|(sum, y)| *sum += y);
            }
            assert!(sum.iter().zip(path).all(|(a, b)| (a - b).abs() < 1e-12), "path {to}");
        }
        assert!(ModalMatrix.way(&structure, 2, 0).is_none());
    }

    #[test]
    fn a_known_number_of_axes_changes_no_bit() {
        let mut random = Random::new(7);
        let mut numbers = |count: usize| -> std::vec::Vec<f64> {
            (0..count).map(|_| random.between(0.1, 1.0)).collect()
        };
        let (coefficients, start, inputs) = (numbers(9 + 4 * 21), numbers(24), numbers(3));
        let (mut one, mut other) = (start.clone(), start);
        let (mut known, mut any) = ([0.0; 3], [0.0; 3]);
        for _ in 0..50 {
            step_of(3, &coefficients, &mut one, &inputs, &mut known);
            let n = core::hint::black_box(3);
            step_of(n, &coefficients, &mut other, &inputs, &mut any);
            assert_eq!((known, &one), (any, &other));
        }
    }

    #[test]
    fn rate_residue_is_the_slope_of_a_mode() {
        // After a step, z′/ω = e^(−ζωt)·sin(ω√(1−ζ²)t)/√(1−ζ²).
        let (f, d) = (200.0, 0.05);
        let values = [[0.0; 4].as_slice(), &[f], &[d], &[0.0; 4], &[0.0, 1.0, 0.0, 0.0]].concat();
        let own = run(&[2.0, 4.0, 1.0, 4.0], &values, &[[0.0, 1.0]; 300]);
        let omega = core::f64::consts::TAU * f;
        let root = (1.0_f64 - d * d).sqrt();
        for (k, y) in own[0].iter().enumerate() {
            let t = (k + 1) as f64 * T;
            let wanted = (-d * omega * t).exp() * (omega * root * t).sin() / root;
            assert!((y - wanted).abs() < 1e-12, "{y} for {wanted} at {t}");
        }
        assert!(own[1].iter().all(|y| *y == 0.0));
    }

    #[test]
    fn refuses_a_matrix_that_is_short_and_a_mode_without_damping() {
        let short =
            Instance::new(&ModalMatrix, &[2.0, 4.0, 2.0, 4.0], &[1.0; 16], T).err().unwrap();
        assert_eq!((short.quantity, short.value), ("residue", 4.0));
        let mut values = [1.0; 14];
        values[5] = 0.0;
        let undamped =
            Instance::new(&ModalMatrix, &[2.0, 4.0, 1.0, 4.0], &values, T).err().unwrap();
        assert_eq!((undamped.quantity, undamped.index), ("damping", Some(0)));
    }
}
