//! Mechanics: a mode with forces on it, clearance, friction.

use std::f64::consts::TAU;

use components::forced::{ForcedMode, SMOOTH};
use serde::{Deserialize, Serialize};

use crate::kernel::{Step, Wires, WrongCount, exactly};

/// What is added to the equation of motion of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Force {
    /// Cubic stiffness: `k₃·(x/X)²` of the linear force, X the far end of the range.
    Cubic,
    /// Quadratic and cubic stiffness.
    Uneven,
    /// Dry friction with a pre-sliding distance, over the stiffness.
    Friction,
    /// Damping that grows with the speed: `ratio·(x′/ω)·|x′/ω|/X`, X the far end of the range.
    SpeedDamping,
    /// Coulomb friction `size·tanh(x′/(ω·smooth))`, over the stiffness.
    Coulomb,
    /// Hysteresis of the spring (Bouc-Wen): `stiffness·z + straight·x`, with
    /// `z′ = x′·(1 − (sign(x′)·z + shape·|z|)/distance)`.
    BoucWen,
}

impl Force {
    /// Number of its parameters.
    #[must_use]
    pub fn count(self) -> usize {
        match self {
            Self::Cubic | Self::SpeedDamping => 1,
            Self::Uneven | Self::Friction | Self::Coulomb => 2,
            Self::BoucWen => 4,
        }
    }

    /// Parts of a step of this angle of the mode, in rad: friction turns quickly.
    fn parts(self, angle: f64) -> f64 {
        /// Greatest angle of a part with friction.
        const FRICTION: f64 = 0.25;
        let (greatest, most) = if self.is_smooth() { (SMOOTH, 64.0) } else { (FRICTION, 3.0) };
        (angle / greatest).ceil().clamp(1.0, most)
    }

    /// Whether it is a polynomial of where the mode is and how fast it moves, nearly: then a rule of fourth order
    /// gains what its order promises.
    fn is_smooth(self) -> bool {
        matches!(self, Self::Cubic | Self::Uneven | Self::SpeedDamping)
    }

    /// The force with its parameters; `far` is the far end of the range of the position.
    ///
    /// # Errors
    /// [`WrongCount`] where [`count`](Self::count) is another.
    pub fn acting(self, p: &[f64], far: f64) -> Result<Acting, WrongCount> {
        let p = match self.count() {
            1 => exactly(p).map(|[first]| [first, 0.0, 0.0, 0.0])?,
            2 => exactly(p).map(|[first, second]| [first, second, 0.0, 0.0])?,
            _ => exactly(p)?,
        };
        Ok(Acting { force: self, p, far })
    }
}

/// A force with its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Acting {
    force: Force,
    /// Parameters of that force, with zeros behind them.
    p: [f64; 4],
    far: f64,
}

impl Acting {
    /// Kind of force.
    #[must_use]
    pub fn force(&self) -> Force {
        self.force
    }

    /// The force over the linear stiffness, as a displacement: at the position x, `way` after the last
    /// one, with the rate over ω; z is the state of the friction, which stays where it does not go on.
    #[inline]
    pub fn pull(&self, (x, way, rate): (f64, f64, f64), z: &mut f64, goes_on: bool) -> f64 {
        let Self { force, p: [first, second, third, fourth], far } = *self;
        // The flexure is straight where the position is zero.
        let e = x / far;
        match force {
            Force::Cubic => x * first * e * e,
            Force::Uneven => x * (first * e + second * e * e),
            Force::Friction => {
                let decay = decay(way.abs() / second);
                let slide = way.signum() * (1.0 - decay) + *z * decay;
                if goes_on {
                    *z = slide;
                }
                first * slide
            }
            Force::SpeedDamping => first * rate * rate.abs() / far,
            Force::Coulomb => first * tanh(rate / second),
            Force::BoucWen => {
                let [distance, shape, straight] = [second, third, fourth];
                let own = bouc_wen((distance, shape), way, *z);
                if goes_on {
                    *z = own;
                }
                first * own + straight * x
            }
        }
    }
}

/// The state z of `z′ = x′·(1 − (sign(x′)·z + shape·|z|)/distance)` after a way of constant direction:
/// linear in z while z keeps its sign, so that the exponential is exact there.
#[inline]
fn bouc_wen((distance, shape): (f64, f64), way: f64, z: f64) -> f64 {
    let x = (1.0 + shape * (way.signum() * z.signum())) * (way.abs() / distance);
    // (1 − e^−x)/x. Ways of a part of a step are short: there by its series, to the last digits.
    let mean = if x.abs() < 1.0 / 16.0 {
        let x2 = x * x;
        let far = (1.0 / 120.0 - x * (1.0 / 720.0)) + x2 * (1.0 / 5040.0);
        (1.0 - 0.5 * x) + x2 * ((1.0 / 6.0 - x * (1.0 / 24.0)) + x2 * far)
    } else {
        (1.0 - libm::exp(-x)) / x
    };
    z * (1.0 - x * mean) + way * mean
}

/// `exp(−x)` for x ≥ 0 within 2e-11 of 1: friction needs it in every part of a step, and no more digits.
#[inline]
fn decay(x: f64) -> f64 {
    use std::f64::consts::{LN_2, LOG2_E};
    /// 2^(−k/8).
    const EIGHTHS: [f64; 8] = [
        1.0,
        0.917_004_043_204_671_2,
        0.840_896_415_253_714_5,
        0.771_105_412_703_970_4,
        0.707_106_781_186_547_5,
        0.648_419_777_325_504_8,
        0.594_603_557_501_360_5,
        0.545_253_866_332_628_8,
    ];
    /// Rounds what is added to it to a whole number, which then stands in the lowest bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    if x > 700.0 {
        return 0.0;
    }
    let rounded = x * (8.0 * LOG2_E) + ROUND;
    let eighths = rounded.to_bits() & 0xffff;
    let r = (rounded - ROUND) * (LN_2 / 8.0) - x;
    let r2 = r * r;
    let series = (1.0 + r) + r2 * ((0.5 + r * (1.0 / 6.0)) + r2 * (1.0 / 24.0 + r * (1.0 / 120.0)));
    series * EIGHTHS[(eighths & 7) as usize] * f64::from_bits((1023 - (eighths >> 3)) << 52)
}

/// The hyperbolic tangent, as exact as [`decay`].
#[inline]
fn tanh(x: f64) -> f64 {
    let decay = decay(2.0 * x.abs());
    ((1.0 - decay) / (1.0 + decay)).copysign(x)
}

/// A mode with forces of these kinds on it, for steps of `dt` seconds; the frequency is in Hz.
#[must_use]
pub fn forced_mode(
    (frequency, damping): (f64, f64),
    forces: impl IntoIterator<Item = Force>,
    dt: f64,
) -> ForcedMode {
    let angle = TAU * frequency * dt;
    let (mut parts, mut is_smooth) = (1.0, true);
    for force in forces {
        parts = force.parts(angle).max(parts);
        is_smooth &= force.is_smooth();
    }
    ForcedMode::new(frequency, damping, dt, parts, is_smooth)
}

/// Where a forced mode rests under the input u: the equilibrium by fixed-point steps, where `pull` is what the
/// forces are at a position, the way since the last one, and the rate over the natural frequency.
pub fn forced_rest(u: f64, mut pull: impl FnMut((f64, f64, f64)) -> f64) -> f64 {
    (0..50).fold(u, |x, _| u - pull((x, 0.0, 0.0)))
}

/// A mode of unit gain with one force on it. State: that of [`ForcedMode`], and the slide of a friction.
#[derive(Clone)]
pub(crate) struct Forced {
    frequency: f64,
    damping: f64,
    force: Acting,
    mode: ForcedMode,
}

impl Forced {
    pub(crate) fn new(frequency: f64, damping: f64, force: Acting) -> Self {
        let mode = forced_mode((frequency, damping), [force.force], 0.0);
        Self { frequency, damping, force, mode }
    }
}

impl Step<4> for Forced {
    fn set_step(&mut self, dt: f64) {
        self.mode = forced_mode((self.frequency, self.damping), [self.force.force], dt);
    }

    fn rest(&self, w: Wires) -> ([f64; 4], f64) {
        let mut slide = 0.0;
        let rest = forced_rest(w.x, |at| self.force.pull(at, &mut slide, true));
        ([rest, 0.0, rest, slide], rest)
    }

    fn step(&self, w: Wires, _t: f64, z: &mut [f64; 4]) -> f64 {
        let [position, rate, before, slide] = z;
        let mut mode = [*position, *rate, *before];
        let y = self.mode.step(w.x, &mut mode, |at, goes_on| self.force.pull(at, slide, goes_on));
        [*position, *rate, *before] = mode;
        y
    }
}

/// A displacement behind a pre-sliding spring, `z′ = x′/d·(1 − z·sign x′)`, exact over a step of constant
/// direction. State: z, and x before.
#[derive(Clone)]
pub(crate) struct Dahl {
    pub(crate) size: f64,
    pub(crate) distance: f64,
}

impl Step<2> for Dahl {
    fn rest(&self, w: Wires) -> ([f64; 2], f64) {
        ([0.0, w.x], w.x)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [slide, before]: &mut [f64; 2]) -> f64 {
        let way = (w.x - *before) / self.distance;
        *before = w.x;
        let decay = decay(way.abs());
        *slide = way.signum() * (1.0 - decay) + *slide * decay;
        w.x - self.size * *slide
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten rows per period, as a resonance near the end of a log's band has them.
    const MODE: (f64, f64) = (400.0, 1e-9);
    const ROW: f64 = 2.5e-4;

    /// Position, rate, position before, and state of the friction.
    type State = ([f64; 3], f64);

    fn step(mode: &ForcedMode, (force, p): (Force, &[f64]), u: f64, (z, slide): &mut State) -> f64 {
        let force = force.acting(p, 1.0).unwrap();
        mode.step(u, z, |at, goes_on| force.pull(at, slide, goes_on))
    }

    #[test]
    fn a_spring_that_bends_keeps_the_energy_of_its_oscillation() {
        for (force, p) in [(Force::Cubic, &[0.3][..]), (Force::Uneven, &[-0.2, 0.2])] {
            let mode = forced_mode(MODE, [force], ROW);
            let (square, cubic) = if p.len() == 1 { (0.0, p[0]) } else { (p[0], p[1]) };
            let energy = |z: &[f64; 3]| {
                let (x, rate) = (z[0], z[1]);
                0.5 * rate * rate + x * x * (0.5 + square * x / 3.0 + 0.25 * cubic * x * x)
            };
            let mut state = ([1.0, 0.0, 1.0], 0.0);
            let first = energy(&state.0);
            let worst = (0..200)
                .map(|_| {
                    step(&mode, (force, p), 0.0, &mut state);
                    (energy(&state.0) / first - 1.0).abs()
                })
                .fold(0.0, f64::max);
            assert!(worst < 2e-3, "{force:?}: energy off by {worst} after 20 periods");
        }
    }

    #[test]
    fn rows_of_the_log_do_what_short_steps_do() {
        const FINE: usize = 50;
        for (force, p, bound) in [
            (Force::Cubic, &[0.3][..], 2e-3),
            (Force::Uneven, &[-0.2, 0.3], 2e-3),
            (Force::Friction, &[0.05, 0.1], 0.01),
            (Force::Friction, &[0.1, 0.02], 0.01),
            (Force::SpeedDamping, &[0.4], 3e-3),
            (Force::Coulomb, &[0.05, 0.1], 0.01),
            (Force::BoucWen, &[0.5, 0.3, -0.5, -0.3], 0.01),
            (Force::BoucWen, &[0.4, 1.2, -1.4, -0.6], 0.01),
        ] {
            let run = |force: Force, p: &[f64], parts: usize| {
                let mode = forced_mode((400.0, 0.02), [force], ROW / parts as f64);
                let mut state = ([0.0; 3], 0.0);
                let rows = (0..300).map(|n| if n % 60 < 30 { 0.5 } else { -0.2 });
                let row = |u| (0..parts).map(|_| step(&mode, (force, p), u, &mut state)).last();
                rows.filter_map(row).collect::<Vec<f64>>()
            };
            let rms = |a: &[f64], b: &[f64]| {
                let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
                (squares / a.len() as f64).sqrt()
            };
            let (complete, fine) = (run(force, p, 1), run(force, p, FINE));
            let effect = rms(&fine, &run(Force::Cubic, &[0.0], 1));
            let part = rms(&complete, &fine) / effect;
            assert!(part < bound, "{force:?} {p:?}: {part} of what the force does");
        }
    }

    /// Positions under these commands, from rest at zero.
    fn positions(force: Force, p: &[f64], far: f64, commands: &[f64]) -> Vec<f64> {
        let mode = forced_mode((400.0, 0.02), [force], ROW);
        let (force, mut z, mut slide) = (force.acting(p, far).unwrap(), [0.0; 3], 0.0);
        let mut row = |u: &f64| mode.step(*u, &mut z, |at, on| force.pull(at, &mut slide, on));
        commands.iter().map(&mut row).collect()
    }

    /// The same of a component, of a mode of 400 Hz with a damping of 0.02.
    fn component(kind: &str, rest: &[f64], commands: &[f64]) -> Vec<f64> {
        let component = components::find(kind).unwrap();
        let (sizes, mut y) = (component.sizes(&[], ROW), [0.0]);
        let (mut k, mut z) = (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
        component.prepare(&[], &[&[400.0, 0.02], rest].concat(), ROW, &mut k).unwrap();
        component.rest(&k, &[0.0], &mut z, &mut y);
        let tick = |n: usize| model::Tick { index: n as u64, time: n as f64 * ROW, period: ROW };
        let mut row = |(n, u): (usize, &f64)| {
            component.step(&k, &mut z, tick(n), &[*u], &mut y);
            y[0]
        };
        commands.iter().enumerate().map(&mut row).collect()
    }

    /// What a diagnosis finds and what it writes into a blueprint: the same numbers.
    #[test]
    fn a_force_is_the_component_that_a_blueprint_gets() {
        let far = 1.7;
        let commands: Vec<f64> =
            (0..600).map(|n| 0.8 * (0.05 * f64::from(n)).sin() - 0.5 * f64::from(n % 3)).collect();
        let cubic = positions(Force::Cubic, &[0.04], far, &commands);
        assert_eq!(cubic, component("duffing", &[0.04, far], &commands));
        for [square, cubic] in [[0.1, 0.2], [-0.15, 0.1], [0.0, -0.1]] {
            let own = positions(Force::Uneven, &[square, cubic], far, &commands);
            let written = component("position-stiffness", &[square, cubic, 0.0, far], &commands);
            assert_eq!(own, written, "{square} {cubic}");
        }
        // The component holds back a speed that is braked by much of itself in a part.
        let own = positions(Force::SpeedDamping, &[0.2], far, &commands);
        let growth = 0.5 * 0.2 / (TAU * 400.0 * far);
        let written = component("nonlinear-damping", &[0.0, 1.0, growth], &commands);
        let plain = positions(Force::Cubic, &[0.0], far, &commands);
        let rms = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let part = rms(&own, &written) / rms(&own, &plain);
        assert!(part < 5e-3, "{part} of what the damping does");
    }

    /// Without a shape Bouc-Wen's law is Dahl's: `stiffness·distance` is the size of the friction.
    #[test]
    fn hysteresis_of_the_spring_without_a_shape_is_friction() {
        let (mut slide, mut z, mut before) = (0.0, 0.0, 0.0_f64);
        let friction = Force::Friction.acting(&[0.12, 0.3], 1.0).unwrap();
        let spring = Force::BoucWen.acting(&[0.4, 0.3, 0.0, 0.0], 1.0).unwrap();
        for n in 0..500 {
            let x = (0.05 * f64::from(n)).sin() * (1.0 + 0.002 * f64::from(n));
            let at = (x, x - before, 0.0);
            before = x;
            let dahl = friction.pull(at, &mut slide, true);
            let own = spring.pull(at, &mut z, true);
            assert!((own - dahl).abs() < 1e-9, "{n}: {own} and {dahl}");
        }
    }

    #[test]
    fn decay_and_tangent_are_those_of_the_library() {
        for k in 0..=80_000 {
            let x = f64::from(k) * 1e-3;
            assert!((decay(x) - (-x).exp()).abs() <= 2e-11, "exp(−{x})");
            assert!((tanh(x) - x.tanh()).abs() <= 2e-11 && tanh(-x) == -tanh(x), "tanh {x}");
        }
        assert!(decay(1e9) < 1e-300 && decay(f64::INFINITY) < 1e-300);
        assert_eq!((tanh(f64::INFINITY), tanh(-1e300)), (1.0, -1.0));
        assert!(decay(f64::NAN).is_nan() && tanh(f64::NAN).is_nan());
    }

    #[test]
    fn a_forced_mode_rests_where_it_is_in_equilibrium() {
        let spring = Force::Uneven.acting(&[0.1, 0.3], 2.0).unwrap();
        let damper = Force::SpeedDamping.acting(&[0.4], 2.0).unwrap();
        let pull = |at| spring.pull(at, &mut 0.0, true) + damper.pull(at, &mut 0.0, true);
        let mode = forced_mode((400.0, 0.1), [Force::Uneven, Force::SpeedDamping], ROW);
        let x = forced_rest(1.5, pull);
        let mut z = [x, 0.0, x];
        for _ in 0..100 {
            assert!((mode.step(1.5, &mut z, |at, _| pull(at)) - x).abs() < 1e-12);
        }
        assert!((x + pull((x, 0.0, 0.0)) - 1.5).abs() < 1e-12);
    }
}
