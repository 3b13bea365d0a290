//! Mechanics beyond one linear mode.

use std::f64::consts::TAU;

use super::linear::Mode;
use super::{Block, Tick};
use crate::random::Random;

/// A force on the mode, as the elongation that would cause it, of position x and speed s = x′/ω.
#[derive(Clone, Debug)]
pub(crate) enum Force {
    /// `−x (cubic (x/X)² + quadratic x/X)`.
    Stiffness {
        /// Relative growth of the stiffness at full scale.
        cubic: f64,
        /// Relative growth of the stiffness at full scale, odd in x.
        quadratic: f64,
        /// Full scale X in µm.
        scale: f64,
    },
    /// Damping that grows with the speed: `−2 ratio s |s|/S`.
    SpeedDamping {
        /// Damping ratio that is added at the speed S.
        ratio: f64,
        /// Speed S in µm.
        scale: f64,
    },
    /// Coulomb friction `−level·tanh(s/smooth)`.
    Coulomb {
        /// Level in µm.
        level: f64,
        /// Speed over ω at which it is reached, in µm.
        smooth: f64,
    },
    /// Dahl friction `−level·z`, `z′ = x′/distance·(1 − z·sgn x′)`.
    Dahl {
        /// Level in µm.
        level: f64,
        /// Distance in µm within which it builds up.
        distance: f64,
        /// State, in [−1, 1].
        z: f64,
    },
}

impl Force {
    /// The force at position x and speed s, after a move by dx.
    fn at(&mut self, x: f64, s: f64, dx: f64) -> f64 {
        match self {
            Self::Stiffness { cubic, quadratic, scale } => {
                let part = x / *scale;
                -x * (*cubic * part * part + *quadratic * part)
            }
            Self::SpeedDamping { ratio, scale } => -2.0 * *ratio * s * s.abs() / *scale,
            Self::Coulomb { level, smooth } => -*level * (s / *smooth).tanh(),
            Self::Dahl { level, distance, z } => {
                let part = dx / *distance;
                // Exact for a move in one direction.
                *z = part.signum() + (*z - part.signum()) * (-part.abs()).exp();
                -*level * *z
            }
        }
    }
}

/// A mode with forces: each of [`SUBSTEPS`] is exact for the forces at its begin.
#[derive(Clone, Debug)]
pub(crate) struct NonlinearMode {
    mode: Mode,
    forces: Vec<Force>,
    x: f64,
    speed: f64,
    last: f64,
}

/// Steps per period.
const SUBSTEPS: usize = 8;

impl NonlinearMode {
    pub(crate) fn new(frequency: f64, damping: f64, forces: Vec<Force>, period: f64) -> Self {
        let mode = Mode::new(frequency, damping, period / SUBSTEPS as f64);
        Self { mode, forces, x: 0.0, speed: 0.0, last: 0.0 }
    }

    fn force(&mut self) -> f64 {
        let (x, s, dx) = (self.x, self.speed, self.x - self.last);
        self.last = x;
        self.forces.iter_mut().map(|force| force.at(x, s, dx)).sum()
    }
}

impl Block for NonlinearMode {
    fn rest(&mut self, input: f64, _tick: &Tick) -> f64 {
        for force in &mut self.forces {
            if let Force::Dahl { z, .. } = force {
                *z = 0.0;
            }
        }
        (self.x, self.last, self.speed) = (input, input, 0.0);
        let has_stiffness = self.forces.iter().any(|f| matches!(f, Force::Stiffness { .. }));
        for _ in 0..if has_stiffness { 200 } else { 0 } {
            // Half-way relaxation towards x = input + force(x).
            self.last = self.x;
            self.x += 0.5 * (input + self.force() - self.x);
        }
        self.last = self.x;
        self.mode.set(self.x);
        self.x
    }

    fn step(&mut self, input: f64, _tick: &Tick) -> f64 {
        for _ in 0..SUBSTEPS {
            let total = input + self.force();
            self.x = self.mode.follow(total);
            self.speed = self.mode.rate();
        }
        self.x
    }
}

/// Clearance: `y = x − (1 − stiff)·(x − P_b[x])`, P_b a play of half the width b.
#[derive(Clone, Debug)]
pub(crate) struct Backlash {
    half: f64,
    stiff: f64,
    play: f64,
}

impl Backlash {
    /// The full width in µm, and the share of the motion that passes within it.
    pub(crate) fn new(width: f64, stiff: f64) -> Self {
        Self { half: 0.5 * width, stiff, play: 0.0 }
    }

    fn output(&self, x: f64) -> f64 {
        x - (1.0 - self.stiff) * (x - self.play)
    }
}

impl Block for Backlash {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.play = (x - self.half).max((x + self.half).min(0.0));
        self.output(x)
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.play = (x - self.half).max((x + self.half).min(self.play));
        self.output(x)
    }
}

/// A further mode: `y = direct·x + gain·M[x]`, M a mode with static gain 1.
#[derive(Clone, Debug)]
pub(crate) struct ExtraMode {
    direct: f64,
    gain: f64,
    mode: Mode,
}

impl ExtraMode {
    /// A mode beside the direct path that takes the share `gain` of the static gain.
    pub(crate) fn parallel(gain: f64, frequency: f64, damping: f64, period: f64) -> Self {
        Self { direct: 1.0 - gain, gain, mode: Mode::new(frequency, damping, period) }
    }

    /// A pair of poles and zeros in series,
    /// `(s²+2ζω s+ω_z²)/(s²+2ζω s+ω²)·ω²/ω_z²`, ω_z = (1 + shift) ω.
    pub(crate) fn pole_zero(shift: f64, frequency: f64, damping: f64, period: f64) -> Self {
        let direct = (1.0 + shift).powi(-2);
        Self { direct, gain: 1.0 - direct, mode: Mode::new(frequency, damping, period) }
    }
}

impl Block for ExtraMode {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.mode.set(x);
        (self.direct + self.gain) * x
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.direct * x + self.gain * self.mode.follow(x)
    }
}

/// A force that repeats: a sine, or blows that last three tenths of the period.
#[derive(Clone, Debug)]
pub(crate) struct Periodic {
    level: f64,
    hz: f64,
    phase: f64,
    is_blow: bool,
}

impl Periodic {
    /// Level in µm and frequency in Hz, with a random phase.
    pub(crate) fn new(level: f64, hz: f64, is_blow: bool, random: &mut Random) -> Self {
        Self { level, hz, phase: random.unit(), is_blow }
    }

    fn value(&self, time: f64) -> f64 {
        let turn = (self.hz * time + self.phase).fract();
        if !self.is_blow {
            return self.level * (TAU * turn).sin();
        }
        let blow = if turn < 0.3 { (TAU * turn / 0.6).sin() } else { 0.0 };
        // Less the mean, 0.3·2/π.
        self.level * (blow - 0.6 / std::f64::consts::PI)
    }
}

impl Block for Periodic {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        x
    }
    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        x + self.value(tick.time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_forces_it_is_the_linear_mode() {
        let tick = Tick::default();
        let mut linear = Mode::new(300.0, 0.04, 2.5e-4);
        let force = Force::Stiffness { cubic: 0.0, quadratic: 0.0, scale: 5.0 };
        let mut other = NonlinearMode::new(300.0, 0.04, vec![force], 2.5e-4);
        assert_eq!(linear.rest(2.0, &tick), other.rest(2.0, &tick));
        for k in 0..400 {
            let u = f64::from(k % 37);
            assert!((linear.step(u, &tick) - other.step(u, &tick)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_hard_spring_rests_at_the_root_of_its_cubic_and_stays_there() {
        let tick = Tick::default();
        let force = Force::Stiffness { cubic: 0.1, quadratic: 0.0, scale: 5.0 };
        let mut mode = NonlinearMode::new(300.0, 0.04, vec![force], 2.5e-4);
        let x = mode.rest(4.0, &tick);
        assert!((x * (1.0 + 0.1 * (x / 5.0).powi(2)) - 4.0).abs() < 1e-12, "{x}");
        for _ in 0..100 {
            assert!((mode.step(4.0, &tick) - x).abs() < 1e-9);
        }
    }

    #[test]
    fn coulomb_friction_makes_an_amplitude_fall_by_the_same_amount_per_cycle() {
        // Free motion with friction only: 4·level per cycle.
        let (f, h, level) = (50.0, 1e-4, 0.01);
        let force = Force::Coulomb { level, smooth: 1e-4 };
        let mut mode = NonlinearMode::new(f, 1e-6, vec![force], h);
        mode.rest(1.0, &Tick::default());
        let per_cycle = (1.0 / (f * h)).round() as usize;
        let peaks: Vec<f64> = (0..3)
            .map(|_| (0..per_cycle).map(|_| mode.step(0.0, &Tick::default())).fold(0.0, f64::max))
            .collect();
        for pair in peaks[..].windows(2) {
            assert!(((pair[0] - pair[1]) / (4.0 * level) - 1.0).abs() < 0.1, "{peaks:?}");
        }
    }

    #[test]
    fn dahl_friction_builds_up_over_its_distance() {
        let mut force = Force::Dahl { level: 1.0, distance: 0.1, z: 0.0 };
        let once = force.at(0.0, 0.0, 0.1);
        assert!((once + (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
        assert!((force.at(0.0, 0.0, 10.0) + 1.0).abs() < 1e-12);
        assert!((force.at(0.0, 0.0, -10.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_pole_zero_pair_is_silent_at_its_zero_and_one_at_rest() {
        let (h, f) = (1e-5, 400.0);
        let mut pair = ExtraMode::pole_zero(0.3, f, 1e-3, h);
        assert!((pair.rest(3.0, &Tick::default()) - 3.0).abs() < 1e-12);
        pair.rest(0.0, &Tick::default());
        let largest = (0..400_000)
            .map(|k| pair.step((TAU * 1.3 * f * f64::from(k) * h).sin(), &Tick::default()))
            .skip(300_000)
            .fold(0.0, |m: f64, y| m.max(y.abs()));
        assert!(largest < 0.03, "{largest}");
    }

    #[test]
    fn a_clearance_swallows_small_motion() {
        let mut gap = Backlash::new(0.5, 0.0);
        gap.rest(0.0, &Tick::default());
        for x in [0.1, 0.2, 0.1, -0.2] {
            assert_eq!(gap.step(x, &Tick::default()), 0.0);
        }
        assert_eq!(gap.step(1.0, &Tick::default()), 0.75);
    }
}
