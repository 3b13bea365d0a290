//! Modes that all axes share, whose frequency and damping follow the amplitude of the motion, as clamped and glued
//! joints and the hysteresis of the actuators make them: the frequency falls, the damping grows.
//!
//! ```text
//! y_i = Σ_j D_ij·x_j + Σ_k Σ_j (R_kij·z_kj + Q_kij·z_kj′/ω_k)
//! z_kj″ + 2·ζ_k·ω_k·z_kj′ + ω_k²·z_kj = ω_k²·x_j
//! ω_k = 2π·frequency_k·(1 + frequency_shift_k·s),   ζ_k = damping_k·(1 + damping_growth_k·s)
//! s = min(a^exponent, 1.5),   a² = mean over j of v_j/amplitude_j²
//! time_constant·m_j′ = x_j − m_j,   time_constant·v_j′ = (x_j − m_j)² − v_j
//! ```
//!
//! * D, R and Q as those of `modal-matrix`. frequency and damping are those of small motion; at the
//!   amplitude they have become frequency·(1 + frequency_shift) and damping·(1 + damping_growth).
//! * a is the amplitude: the rms of the axes' motions x_j in front about their running mean, over the last
//!   time_constant (in s), relative to `amplitude`. Beyond 1.5 s stays: the law is known up to the amplitude it
//!   was measured at.
//! * State: m_j, a², z_kj and z_kj′/ω_k. Exact at any period for a constant a, as the input is held over
//!   a step; a is that of the step's beginning. Up to eight axes.
//!
//! Limits: one amplitude for all modes; what changes within a period of the motion, and with it harmonics, is
//! not in it (the describing function of a play or of Coulomb friction, not the play itself).
//!
//! Source: L. Gaul, R. Nitsche, Appl. Mech. Rev. 54 (2001) 93-106 (friction in joints, by its linear equivalent);
//! fitted by `piezoloop frequency-response --softening`.

use libm::{exp, pow};
use model::{Component, Declaration, Input, Quantity, Role, Sizes, Stage, Tick, Violation};

use super::modal_matrix::{STRUCTURE, counts, has_matrices, read};
use crate::linear::Transition;
use crate::rules::{WRONG_LENGTH, require, second_order};
use crate::{effects, phenomena};

/// The component `softening-modes`.
pub struct SofteningModes;

/// Greatest s.
const MOST: f64 = 1.5;
/// Coefficients of a mode in front of R and Q: frequency, damping, shift, growth.
const LAW: usize = 4;
/// Coefficients of the amplitude: fall of the mean over a step, half the exponent, period.
const AMPLITUDE: usize = 3;

static DECLARATION: Declaration = Declaration {
    kind: "softening-modes",
    name: "modes",
    summary: "Modes that all axes share, with frequency and damping that follow the amplitude",
    equation: "y[i] = sum(direct[i,j]*x[j]) + sum(residue[k,i,j]*z[k,j] + rate_residue[k,i,j]*z[k,j]'/w[k]); \
               z'' + 2*d*w*z' + w^2*z = w^2*x; w = 2*pi*frequency*(1 + frequency_shift*s); \
               d = damping*(1 + damping_growth*s); s = min(a^exponent, 1.5); a^2 = mean(v[j]/amplitude[j]^2); \
               time_constant*m' = x - m; time_constant*v' = (x - m)^2 - v",
    reference: "L. Gaul, R. Nitsche, Appl. Mech. Rev. 54 (2001) 93-106",
    stage: Stage::Coupling,
    phenomena: &[&phenomena::DYNAMIC_COUPLING],
    inputs: &[Input::EACH_PATH],
    structure: &STRUCTURE,
    parameters: &[
        Quantity::new("direct", "1", "Motion per motion outside the listed modes, row by row")
            .per(1)
            .fitted(),
        Quantity::new("frequency", "Hz", "Undamped natural frequency of each mode, small motion")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .per(2)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio of each mode, small motion")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .per(2)
            .min(0.0)
            .fitted(),
        Quantity::new(
            "frequency_shift",
            "1",
            "Relative change of each mode's frequency at `amplitude`, negative where it softens",
        )
        .per(2)
        .fitted(),
        Quantity::new(
            "damping_growth",
            "1",
            "Relative change of each mode's damping ratio at `amplitude`",
        )
        .per(2)
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
        Quantity::new(
            "amplitude",
            "{position}",
            "Rms of each axis' motion before the coupling at which shift and growth are given",
        )
        .per(0)
        .min(0.0),
        Quantity::new("exponent", "1", "Exponent of the amplitude in shift and growth")
            .min(0.0)
            .start(1.0)
            .fitted(),
        Quantity::new("time_constant", "s", "Time constant of the running rms").min(0.0).start(0.1),
    ],
    ..Declaration::PATH
};

impl Component for SofteningModes {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let (n, modes) = counts(structure);
        Sizes {
            coefficients: AMPLITUDE + n + n * n + modes * (LAW + 2 * n * n),
            states: n + 1 + 2 * n * modes,
        }
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
        if parameters.len() != entries + modes * (LAW + 2 * entries) + n + 2
            || coefficients.len() != AMPLITUDE + n + entries + modes * (LAW + 2 * entries)
        {
            return Err(WRONG_LENGTH);
        }
        let (direct, rest) = parameters.split_at(entries);
        let (law, rest) = rest.split_at(LAW * modes);
        let (residues, rest) = rest.split_at(modes * entries);
        let (rate_residues, rest) = rest.split_at(modes * entries);
        let (amplitudes, rest) = rest.split_at(n);
        let &[exponent, time_constant] = rest else { return Err(WRONG_LENGTH) };
        for (index, amplitude) in amplitudes.iter().enumerate() {
            let weight = 1.0 / (amplitude * amplitude * n as f64);
            require(
                *amplitude > 0.0 && weight.is_finite() && weight > 0.0,
                "amplitude",
                *amplitude,
                "must be above zero, and its square must not vanish: the motion is measured by it; give the rms \
                 that the shifts were identified at",
            )
            .map_err(|v| Violation { index: Some(index), ..v })?;
        }
        require(
            exponent > 0.0,
            "exponent",
            exponent,
            "must be above zero; 1 is proportional to the amplitude, 2 to its square",
        )?;
        require(
            time_constant > 0.0,
            "time_constant",
            time_constant,
            "must be above zero; give some periods of the slowest motion, such as 0.1",
        )?;
        let (head, rest) = coefficients.split_at_mut(AMPLITUDE);
        head.copy_from_slice(&[exp(-period / time_constant), 0.5 * exponent, period]);
        let (weights, rest) = rest.split_at_mut(n);
        for (weight, amplitude) in weights.iter_mut().zip(amplitudes) {
            *weight = 1.0 / (amplitude * amplitude * n as f64);
        }
        let (own_direct, own) = rest.split_at_mut(entries);
        own_direct.copy_from_slice(direct);
        for (index, slot) in own.chunks_exact_mut(LAW + 2 * entries).enumerate() {
            let of = |what: usize| law.get(what * modes + index).copied().unwrap_or(0.0);
            let (frequency, damping, shift, growth) = (of(0), of(1), of(2), of(3));
            let at = |v: Violation| Violation { index: Some(index), ..v };
            second_order(frequency, damping, period).map_err(at)?;
            let rule =
                "must leave frequency and damping above zero up to 1.5 times: greater than -0.66";
            require(1.0 + MOST * shift > 0.0, "frequency_shift", shift, rule).map_err(at)?;
            require(1.0 + MOST * growth > 0.0, "damping_growth", growth, rule).map_err(at)?;
            second_order(frequency * (1.0 + MOST * shift), damping * (1.0 + MOST * growth), period)
                .map_err(at)?;
            let (own_law, matrices) = slot.split_at_mut(LAW);
            own_law.copy_from_slice(&[frequency, damping, shift, growth]);
            let (r, q) = matrices.split_at_mut(entries);
            let place = index * entries..(index + 1) * entries;
            r.copy_from_slice(residues.get(place.clone()).ok_or(WRONG_LENGTH)?);
            q.copy_from_slice(rate_residues.get(place).ok_or(WRONG_LENGTH)?);
        }
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let n = inputs.len();
        let Some((_, own)) = coefficients.split_at_checked(AMPLITUDE + n) else { return };
        let Some((mean, rest)) = state.split_at_mut_checked(n) else { return };
        let Some((power, modes)) = rest.split_at_mut_checked(1) else { return };
        mean.copy_from_slice(inputs);
        power.fill(0.0);
        for mode in modes.chunks_exact_mut(2 * n.max(1)) {
            let (z, v) = mode.split_at_mut(n);
            z.copy_from_slice(inputs);
            v.fill(0.0);
        }
        read(n, LAW, own, inputs, modes, outputs);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let n = inputs.len();
        let Some((&[fall, half_exponent, period], rest)) =
            coefficients.split_first_chunk::<AMPLITUDE>()
        else {
            return;
        };
        let Some((weights, own)) = rest.split_at_checked(n) else { return };
        let Some((_, laws)) = own.split_at_checked(n * n) else { return };
        let Some((mean, rest)) = state.split_at_mut_checked(n) else { return };
        let Some(([power], modes)) = rest.split_first_chunk_mut::<1>() else { return };
        let s = pow(*power, half_exponent).min(MOST);
        let width = LAW + 2 * n * n;
        for (slot, mode) in laws.chunks_exact(width).zip(modes.chunks_exact_mut(2 * n.max(1))) {
            let &[frequency, damping, shift, growth, ..] = slot else { return };
            let transition = Transition::new(
                frequency * (1.0 + shift * s),
                damping * (1.0 + growth * s),
                period,
            );
            let (z, v) = mode.split_at_mut(n);
            for ((z, v), x) in z.iter_mut().zip(v).zip(inputs) {
                let (e, rate) = transition.apply(*z - x, *v);
                (*z, *v) = (x + e, rate);
            }
        }
        // Exact for inputs that are held over the step.
        let mut sum = 0.0;
        for ((mean, x), weight) in mean.iter_mut().zip(inputs).zip(weights) {
            let way = x - *mean;
            sum += weight * way * way;
            *mean += (1.0 - fall) * way;
        }
        // What is beyond all bounds is as far beyond the law's own.
        *power = (fall * (*power + (1.0 - fall) * sum)).min(f64::MAX);
        read(n, LAW, own, inputs, modes, outputs);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coupling::ModalMatrix;
    use crate::testing::{Instance, Random};

    const T: f64 = 1e-4;

    /// Values of one axis with one mode.
    fn one(f: f64, d: f64, shift: f64, growth: f64, exponent: f64, tau: f64) -> [f64; 10] {
        [0.2, f, d, shift, growth, 0.8, 0.05, 2.0, exponent, tau]
    }

    const ONE: [f64; 4] = [1.0, 1.0, 1.0, 1.0];

    #[test]
    fn without_shift_and_growth_it_is_the_matrix_of_modes() {
        let mut random = Random::new(3);
        let direct = [0.1, -0.2, 0.3, 0.4];
        let (f, d) = ([300.0, 720.0], [0.02, 1.4]);
        let residues: [f64; 16] = core::array::from_fn(|_| random.between(-1.0, 1.0));
        let structure = [2.0, 4.0, 2.0, 8.0];
        let linear = [&direct[..], &f, &d, &residues].concat();
        let soft = [&direct[..], &f, &d, &[0.0; 4], &residues, &[3.0, 5.0, 1.0, 0.02]].concat();
        let mut a = Instance::new(&ModalMatrix, &structure, &linear, T).unwrap();
        let mut b = Instance::new(&SofteningModes, &structure, &soft, T).unwrap();
        for own in [&mut a, &mut b] {
            own.outputs = std::vec![0.0; 2];
            own.rest(&[1.0, -2.0]);
        }
        for _ in 0..300 {
            assert_eq!(a.outputs, b.outputs);
            let inputs = [random.between(-9.0, 9.0), random.between(-9.0, 9.0)];
            a.step(&inputs);
            b.step(&inputs);
        }
    }

    /// After a long sine of this rms, the mode rings down with the frequency and damping of the law.
    #[test]
    fn frequency_and_damping_follow_the_amplitude() {
        let (f, d, shift, growth) = (400.0, 0.02, -0.1, 0.5);
        for (exponent, ratio) in [(1.0, 0.5), (2.0, 0.5), (0.5, 1.0), (1.0, 4.0)] {
            let values = one(f, d, shift, growth, exponent, 0.05);
            let mut own = Instance::new(&SofteningModes, &ONE, &values, T).unwrap();
            own.rest(&[7.0]);
            // Sine about 7 whose rms is the given part of the amplitude of 2.
            let top = ratio * 2.0 * core::f64::consts::SQRT_2;
            for k in 0..20_000 {
                own.step(&[7.0 + top * libm::sin(core::f64::consts::TAU * 1000.0 * k as f64 * T)]);
            }
            let s = pow(ratio, exponent).min(MOST);
            let power = own.state[1];
            assert!((libm::sqrt(power) / ratio - 1.0).abs() < 2e-3, "{power} at {ratio}");
            let now = Transition::new(f * (1.0 + shift * s), d * (1.0 + growth * s), T);
            let before = [own.state[2] - 7.0, own.state[3]];
            own.step(&[7.0]);
            let wanted = now.apply(before[0], before[1]);
            let after = [own.state[2] - 7.0, own.state[3]];
            let error = (after[0] - wanted.0).abs().max((after[1] - wanted.1).abs());
            assert!(error < 1e-3 * before[0].abs().max(before[1].abs()), "{error}");
        }
    }

    #[test]
    fn the_running_mean_square_is_that_of_the_equation() {
        let values = one(400.0, 0.02, -0.1, 0.5, 1.0, 0.01);
        let mut own = Instance::new(&SofteningModes, &ONE, &values, T).unwrap();
        own.rest(&[1.0]);
        let mut random = Random::new(8);
        let (mut m, mut v) = (1.0, 0.0);
        for _ in 0..200 {
            let x = random.between(-3.0, 5.0);
            own.step(&[x]);
            // The equation in 200 small steps by the midpoint rule.
            let h = T / 200.0 / 0.01;
            for _ in 0..200 {
                let half = m + 0.5 * h * (x - m);
                let middle = v + 0.5 * h * ((x - m) * (x - m) - v);
                v += h * ((x - half) * (x - half) - middle);
                m += h * (x - half);
            }
            assert!((own.state[0] - m).abs() < 1e-8 && (own.state[1] - v / 4.0).abs() < 1e-8);
        }
    }

    #[test]
    fn refuses_laws_that_leave_no_mode() {
        let refused = |values: [f64; 10]| {
            let v = Instance::new(&SofteningModes, &ONE, &values, T).err().unwrap();
            (v.quantity, v.index)
        };
        assert_eq!(refused(one(400.0, 0.02, -0.7, 0.0, 1.0, 0.1)), ("frequency_shift", Some(0)));
        assert_eq!(refused(one(400.0, 0.02, 0.0, -0.7, 1.0, 0.1)), ("damping_growth", Some(0)));
        assert_eq!(refused(one(400.0, 0.02, 0.0, 0.0, 0.0, 0.1)).0, "exponent");
        assert_eq!(refused(one(400.0, 0.02, 0.0, 0.0, 1.0, 0.0)).0, "time_constant");
        let mut values = one(400.0, 0.02, 0.0, 0.0, 1.0, 0.1);
        values[7] = 0.0;
        assert_eq!(refused(values), ("amplitude", Some(0)));
    }
}
