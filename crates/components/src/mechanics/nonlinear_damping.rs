//! A mode whose damping depends on its velocity: smooth Coulomb friction, and damping that grows with the
//! speed.
//!
//! ```text
//! x″ + 2(ζ + growth·|x′|)ω x′ + ω²·[x + coulomb·tanh(x′/velocity)] = ω²·u
//! ```
//!
//! * frequency in Hz, damping ζ; coulomb in position: friction over the mode's stiffness; velocity in
//!   position per second: where the friction has come to 76 % of it; growth in seconds per position: of
//!   the damping ratio with the speed, as in squeezed air and at joints (0.1 % to 10 % of ζ at full speed).
//! * State: x and x′/ω. Each period is cut into parts of at most 0.1 rad, short against what the friction brakes at
//!   small velocities; in each the linear part is exact and the rest of the force is taken at its middle
//!   ([`ForcedMode`]). Without Coulomb friction parts have up to 0.4 rad, with a rule of fourth order.
//!   At rest x = u: friction that is smooth holds nothing in the end.
//!
//! Limits: at most 10 000 parts per period; sticking is that of `friction`.
//!
//! Source: A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, Wiley 1979, ch. 3 (quadratic damping); B.
//! Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083–1138 (Coulomb friction).

use core::f64::consts::TAU;

use libm::{ceil, fabs, fmax, sqrt, tanh};
use model::{Component, Declaration, Quantity, Role, Sizes, Stage, Tick, Violation};

use crate::forced::{ForcedMode, SMOOTH};
use crate::rules::{WRONG_LENGTH, require, second_order};
use crate::{effects, phenomena};

/// Greatest turn of the mode in one part of a period with Coulomb friction, in rad.
const TURN: f64 = 0.1;
/// Greatest part of a velocity that friction may take in one part.
const BRAKED: f64 = 0.5;

/// The component `nonlinear-damping`.
pub struct NonlinearDamping;

static DECLARATION: Declaration = Declaration {
    kind: "nonlinear-damping",
    name: "damping",
    summary: "Mode with Coulomb friction and speed-dependent damping",
    equation: "x'' + 2*(damping + growth*|x'|)*w*x' + w^2*(x + coulomb*tanh(x'/velocity)) = w^2*u; w \
               = 2*pi*frequency",
    reference: "A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, Wiley 1979, ch. 3",
    stage: Stage::Mechanics,
    effect: Some(&effects::DAMPING),
    phenomena: &[&phenomena::FRICTION],
    parameters: &[
        Quantity::new("frequency", "Hz", "Undamped natural frequency")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio at small velocities")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .min(0.0)
            .fitted(),
        Quantity::new("coulomb", "{position}", "Coulomb friction over stiffness")
            .start(0.0)
            .min(0.0)
            .fitted(),
        Quantity::new(
            "velocity",
            "{position}/s",
            "Velocity at which 76 % of the Coulomb friction acts",
        )
        .start(1.0)
        .min(0.0)
        .fitted(),
        Quantity::new("growth", "s/{position}", "Growth of the damping ratio with the speed")
            .start(0.0)
            .min(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

struct Law {
    omega: f64,
    coulomb: f64,
    velocity: f64,
    growth: f64,
    /// Turn of the mode in one part, in rad.
    turn: f64,
}

/// `forced mode | ω | coulomb | velocity | growth | turn of one part`.
#[inline]
fn split(coefficients: &[f64]) -> Option<(ForcedMode, Law)> {
    let (&mode, &[omega, coulomb, velocity, growth, turn]) = coefficients.split_first_chunk()?
    else {
        return None;
    };
    Some((ForcedMode::of(mode), Law { omega, coulomb, velocity, growth, turn }))
}

impl Law {
    /// What the force beyond the linear one costs, at a velocity over ω. No speed is braked by more than
    /// itself in a part.
    #[inline]
    fn beyond(&self, rate: f64) -> f64 {
        let v = self.omega * rate;
        let braking = 2.0 * self.growth * fabs(v);
        let held = braking * self.turn;
        self.coulomb * tanh(v / self.velocity) + braking * rate / sqrt(1.0 + held * held)
    }
}

impl Component for NonlinearDamping {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: ForcedMode::COEFFICIENTS + 5, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[frequency, damping, coulomb, velocity, growth], Some((mode, [w, c, v, g, turn]))) =
            (parameters, coefficients.split_first_chunk_mut())
        else {
            return Err(WRONG_LENGTH);
        };
        second_order(frequency, damping, period)?;
        require(coulomb >= 0.0, "coulomb", coulomb, "must be zero or positive")?;
        require(velocity > 0.0, "velocity", velocity, "must be above zero")?;
        require(growth >= 0.0, "growth", growth, "must be zero or positive")?;
        let omega = TAU * frequency;
        let angle = omega * period;
        // Friction at small velocities is a damping of ω²·coulomb/velocity.
        let braked = angle * omega * coulomb / velocity;
        let is_smooth = coulomb == 0.0;
        let turned = angle / if is_smooth { SMOOTH } else { TURN };
        let count = fmax(ceil(fmax(turned, braked / BRAKED)), 1.0);
        require(
            count <= 10_000.0,
            "velocity",
            velocity,
            "is too low for the internal step and this friction; make it higher or shorten `step`",
        )?;
        *mode = ForcedMode::new(frequency, damping, period, count, is_smooth).to_array();
        (*w, *c, *v, *g, *turn) = (omega, coulomb, velocity, growth, angle / count);
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [x, rate], [y]) = (inputs, state, outputs) else { return };
        (*x, *rate) = (u, 0.0);
        *y = u;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((mode, law)), &[u], Ok(state), [y]) =
            (split(coefficients), inputs, state.try_into(), outputs)
        else {
            return;
        };
        *y = mode.advance(u, state, |_, rate| law.beyond(rate));
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;
    use crate::testing::{Instance, Random};

    fn new(damping: f64, rest: [f64; 3], period: f64) -> Instance {
        let [coulomb, velocity, growth] = rest;
        let all = [100.0, damping, coulomb, velocity, growth];
        Instance::new(&NonlinearDamping, &[], &all, period).unwrap()
    }

    /// The turning points of a free oscillation from 1.
    fn turns(mut model: Instance, count: usize) -> Vec<f64> {
        model.rest(&[1.0]);
        let y: Vec<f64> = (0..4000).map(|_| model.step(&[0.0])).collect();
        let turn = |w: &&[f64]| (w[1] - w[0]) * (w[2] - w[1]) < 0.0;
        y.windows(3).filter(turn).map(|w| w[1].abs()).take(count).collect()
    }

    /// Free motion with dry friction only: each half turn takes 2·coulomb off the amplitude.
    #[test]
    fn coulomb_friction_takes_the_same_off_every_half_turn() {
        let all = turns(new(1e-9, [0.02, 0.5, 0.0], 1e-4), 10);
        for (k, pair) in all.windows(2).enumerate() {
            assert!((pair[0] - pair[1] - 0.04).abs() < 2e-3, "{k}: {all:?}");
        }
    }

    /// Quadratic damping: over a half turn amplitudes fall as 1/a grows by 8/3·growth·ω (small growth).
    #[test]
    fn damping_that_grows_with_the_speed_makes_the_inverse_amplitude_grow_evenly() {
        let growth = 0.02 / (TAU * 100.0);
        let all = turns(new(1e-9, [0.0, 1.0, growth], 1e-4), 10);
        for pair in all.windows(2) {
            let grown = 1.0 / pair[1] - 1.0 / pair[0];
            let wanted = 8.0 / 3.0 * growth * TAU * 100.0;
            assert!((grown / wanted - 1.0).abs() < 0.05, "{grown} for {wanted}: {all:?}");
        }
    }

    #[test]
    fn rows_of_a_log_do_what_short_steps_do() {
        let run = |parts: usize| {
            let mut model = new(0.02, [0.02, 20.0, 2e-5], 1e-3 / parts as f64);
            model.rest(&[0.0]);
            let rows = (0..300).map(|n| if n % 60 < 30 { 0.5 } else { -0.2 });
            rows.map(|u| (0..parts).fold(0.0, |_, _| model.step(&[u]))).collect::<Vec<f64>>()
        };
        let (complete, fine) = (run(1), run(40));
        let squares: f64 = complete.iter().zip(&fine).map(|(a, b)| (a - b).powi(2)).sum();
        assert!((squares / 300.0).sqrt() < 1e-3);
    }

    #[test]
    fn everything_is_finite_under_rough_inputs() {
        for period in [1e-6, 1e-4, 1e-2] {
            let mut model = new(0.02, [0.2, 1e2, 1e-6], period);
            model.rest(&[0.0]);
            for u in Random::new(5).signal(-1e3, 1e3, 500) {
                assert!(model.step(&[u]).is_finite());
            }
        }
    }
}
