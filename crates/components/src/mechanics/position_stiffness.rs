//! A mode whose stiffness depends on the position: guides and flexures off their middle.
//!
//! ```text
//! x″ + 2ζω x′ + ω²·s(ξ)·x = ω²·u,   s = 1 + linear·ξ + quadratic·ξ²
//! ξ = (x − centre)/half_range, from −1 to 1
//! ```
//!
//! * frequency in Hz, damping: at the centre; linear, quadratic without unit: growth of the
//!   stiffness from the centre to the end of the range (0.01–0.2); centre, half_range in position:
//!   where the stiffness is known; outside it stays as at the end.
//! * A working point has its own resonance, √s times that at the centre, and its own gain, 1/s. The
//!   cubic stiffness of `duffing` depends on the deflection from zero; this one on where the stage
//!   stands.
//! * State: x and x′/ω. Each period is cut into parts of at most 0.4 rad, or 0.6 rad of the stiffest motion; in
//!   each the linear part is exact and the rest of the force is integrated by a rule of fourth order
//!   ([`ForcedMode`]).
//!
//! Limits: the force must rise with the position; at most 10 000 parts per period.
//!
//! Source: S. Henein, Conception des guidages flexibles, PPUR 2001.

use libm::{fmax, fmin, sqrt};
use model::{Component, Declaration, Quantity, Role, Sizes, Stage, Tick, Violation};

use crate::forced::ForcedMode;
use crate::hysteresis::play::between;
use crate::rules::{WRONG_LENGTH, require, second_order};
use crate::solve::newton;
use crate::{effects, phenomena};

/// The component `position-stiffness`.
pub struct PositionStiffness;

static DECLARATION: Declaration = Declaration {
    kind: "position-stiffness",
    name: "stiffness",
    summary: "Mode whose stiffness depends on the position",
    equation: "x'' + 2*damping*w*x' + w^2*s*x = w^2*u; s = 1 + linear*xi + quadratic*xi^2; xi = (x \
               - centre)/half_range, from -1 to 1; w = 2*pi*frequency",
    reference: "S. Henein, Conception des guidages flexibles, PPUR 2001",
    stage: Stage::Mechanics,
    effect: Some(&effects::RESONANCE_SHIFT),
    phenomena: &[&phenomena::POSITION_STIFFNESS],
    parameters: &[
        Quantity::new("frequency", "Hz", "Natural frequency at the centre")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio at the centre")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .min(0.0)
            .fitted(),
        Quantity::new("linear", "1", "Relative growth of the stiffness towards the upper end")
            .start(0.0)
            .fitted(),
        Quantity::new("quadratic", "1", "Relative growth of the stiffness towards both ends")
            .start(0.0)
            .fitted(),
        Quantity::new("centre", "{position}", "Middle of the range").start(0.0),
        Quantity::new("half_range", "{position}", "Half of the range").min(0.0),
    ],
    ..Declaration::PATH
};

/// s(ξ) of the stiffness.
#[derive(Clone, Copy)]
struct Law {
    linear: f64,
    quadratic: f64,
    centre: f64,
    half: f64,
}

impl Law {
    /// The place ξ of a position, if the range had no ends, and in the range.
    #[inline]
    fn place(&self, x: f64) -> [f64; 2] {
        let free = (x - self.centre) / self.half;
        [free, between(-1.0, 1.0, free)]
    }

    /// The part of the force beyond the linear one, over the stiffness at the centre: (s − 1)·x.
    #[inline]
    fn beyond(&self, x: f64) -> f64 {
        let [_, xi] = self.place(x);
        x * (self.linear * xi + self.quadratic * xi * xi)
    }

    /// s and its slope over the position.
    #[inline]
    fn stiffness(&self, x: f64) -> [f64; 2] {
        let [free, xi] = self.place(x);
        let slope = (self.linear + 2.0 * self.quadratic * xi) / self.half;
        let s = 1.0 + xi * (self.linear + self.quadratic * xi);
        [s, if xi == free { slope } else { 0.0 }]
    }

    /// Least and greatest value of 1 + a·ξ + b·ξ² from −1 to 1.
    fn extremes(one: f64, a: f64, b: f64) -> [f64; 2] {
        let at = |xi: f64| one + xi * (a + b * xi);
        let vertex = between(-1.0, 1.0, if b == 0.0 { 1.0 } else { -a / (2.0 * b) });
        let all = [at(-1.0), at(1.0), at(vertex)];
        [all.into_iter().fold(f64::INFINITY, fmin), all.into_iter().fold(f64::NEG_INFINITY, fmax)]
    }

    /// Least and greatest s, and slope of the force s·x.
    fn bounds(&self) -> [[f64; 2]; 2] {
        let c = self.centre / self.half;
        let (a, b) = (self.linear, self.quadratic);
        // d(s·x)/dx = s + (ξ + c)·ds/dξ.
        let slope = Self::extremes(1.0 + a * c, 2.0 * (a + b * c), 3.0 * b);
        [Self::extremes(1.0, a, b), slope]
    }

    /// The position at which s·x = u.
    fn equilibrium(&self, u: f64) -> f64 {
        let [[least, most], _] = self.bounds();
        let (a, b) = (u / least, u / most);
        newton([fmin(a, b), fmax(a, b)], u, |x| {
            let [s, slope] = self.stiffness(x);
            [s * x - u, s + slope * x]
        })
    }
}

/// `forced mode | linear | quadratic | centre | half range`.
#[inline]
fn split(coefficients: &[f64]) -> Option<(ForcedMode, Law)> {
    let (&mode, &[linear, quadratic, centre, half]) = coefficients.split_first_chunk()? else {
        return None;
    };
    Some((ForcedMode::of(mode), Law { linear, quadratic, centre, half }))
}

impl Component for PositionStiffness {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: ForcedMode::COEFFICIENTS + 4, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[frequency, damping, linear, quadratic, centre, half], Some((mode, law))) =
            (parameters, coefficients.split_first_chunk_mut())
        else {
            return Err(WRONG_LENGTH);
        };
        second_order(frequency, damping, period)?;
        require(half > 0.0, "half_range", half, "must be above zero")?;
        let [[softest, _], [least, most]] = Law { linear, quadratic, centre, half }.bounds();
        require(
            least > 0.0 && softest > 0.0,
            "linear",
            linear,
            "the force would fall with the position somewhere in the range, so that a command has \
             several positions; give smaller `linear` and `quadratic`",
        )?;
        let law: &mut [f64; 4] = law.try_into().map_err(|_| WRONG_LENGTH)?;
        *mode = ForcedMode::smooth(frequency, damping, period, sqrt(most))?.to_array();
        *law = [linear, quadratic, centre, half];
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((_, law)), &[u], [x, v], [y]) = (split(coefficients), inputs, state, outputs)
        else {
            return;
        };
        (*x, *v) = (law.equilibrium(u), 0.0);
        *y = *x;
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
        *y = mode.advance(u, state, |x, _| law.beyond(x));
    }
}

#[cfg(test)]
mod tests {
    use super::super::MODE;
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn without_growth_it_is_the_mode() {
        let signal = Random::new(2).signal(-1.0, 1.0, 200);
        let p = [400.0, 0.02, 0.0, 0.0, 0.3, 2.0];
        let stage = Instance::new(&PositionStiffness, &[], &p, 1e-4);
        let mode = Instance::new(&MODE, &[], &[400.0, 0.02, 1.0], 1e-4);
        let (a, b) = (stage.unwrap().response(0.0, &signal), mode.unwrap().response(0.0, &signal));
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-11));
    }

    /// Frequency and gain of small motions about a working point are those of its stiffness.
    #[test]
    fn a_working_point_has_its_own_resonance_and_gain() {
        let p = [200.0, 1e-6, 0.1, 0.05, 0.0, 10.0];
        for u in [-8.0, -3.0, 2.0, 9.0] {
            let mut stage = Instance::new(&PositionStiffness, &[], &p, 1e-5).unwrap();
            let x = stage.rest(&[u]);
            let xi = x / 10.0;
            let s = 1.0 + 0.1 * xi + 0.05 * xi * xi;
            assert!((s * x - u).abs() < 1e-10);
            for _ in 0..100 {
                assert!((stage.step(&[u]) - x).abs() < 1e-10, "{u} is no rest");
            }
            // d(s·x)/dx at x.
            let tangent = s + xi * (0.1 + 0.1 * xi);
            stage.state[0] += 1e-4;
            let (mut crossings, mut last) = (0, 1e-4);
            for _ in 0..100_000 {
                let e = stage.step(&[u]) - x;
                crossings += u32::from(last < 0.0 && e >= 0.0);
                last = e;
            }
            let expected = 200.0 * tangent.sqrt();
            assert!((f64::from(crossings) / expected - 1.0).abs() < 0.01, "{u}: {crossings}");
        }
    }

    #[test]
    fn a_force_that_falls_with_the_position_is_refused() {
        let refused = |p: [f64; 6]| {
            Instance::new(&PositionStiffness, &[], &p, 1e-4).err().map(|v| v.quantity)
        };
        assert_eq!(refused([100.0, 0.02, -0.6, 0.0, 0.0, 1.0]), Some("linear"));
        assert_eq!(refused([100.0, 0.02, 0.2, -1.5, 0.0, 1.0]), Some("linear"));
        assert_eq!(refused([100.0, 0.02, 0.2, 0.1, 0.0, 0.0]), Some("half_range"));
        assert_eq!(refused([100.0, 0.02, 0.2, 0.1, 0.0, 1.0]), None);
    }
}
