//! Voltage limits of the amplifier, hard or soft.
//!
//! ```text
//! v = u inside,  v = low or high beyond;   within ±softness of a limit a parabola:
//! v = u − (u − high + softness)²/(4·softness)
//! ```
//!
//! * low, high, softness in command. softness 0 is a hard limit; else the slope falls from 1 to 0
//!   over 2·softness about the limit. Below that the input passes bit for bit.
//! * No state.
//!
//! Limits: static; the same softness at both ends.

use model::{Component, Declaration, Quantity, Sizes, Stage, Violation};

use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `amplifier-clamp`.
pub struct AmplifierClamp;

static DECLARATION: Declaration = Declaration {
    kind: "amplifier-clamp",
    name: "clamp",
    summary: "Voltage limits of the amplifier, hard or soft",
    equation: "v = min(max(u, low), high), with a parabola within softness of a limit",
    reference: "A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning \
                Systems, Springer 2014, ch. 14",
    stage: Stage::Amplifier,
    effect: Some(&effects::AMPLIFIER_SATURATION),
    phenomena: &[&phenomena::VOLTAGE_LIMITS],
    parameters: &[
        Quantity::new("low", "{command}", "Least voltage").fitted(),
        Quantity::new("high", "{command}", "Greatest voltage").fitted(),
        Quantity::new("softness", "{command}", "Half width of the bend at each limit")
            .start(0.0)
            .min(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

/// `max(d, 0)` with a parabola within `softness` of 0.
fn excess(d: f64, softness: f64) -> f64 {
    if d >= softness {
        d
    } else if d <= -softness {
        0.0
    } else {
        (d + softness) * (d + softness) / (4.0 * softness)
    }
}

impl Component for AmplifierClamp {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 3, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[low, high, softness] = parameters else { return Err(WRONG_LENGTH) };
        require(low < high, "low", low, "must be below high")?;
        let rule = "the two bends overlap; softness is at most half of high - low";
        require(2.0 * softness <= high - low, "softness", softness, rule)?;
        kept(parameters, coefficients)
    }

    #[cfg_attr(feature = "records", inline)]
    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[low, high, softness], &[u], [y]) = (coefficients, inputs, outputs) else { return };
        *y = low + excess(u - low, softness);
        if u - high > -softness {
            *y = high - excess(high - u, softness);
        } else if u - low >= softness {
            *y = u;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    fn clamp(softness: f64) -> Instance {
        Instance::new(&AmplifierClamp, &[], &[-20.0, 120.0, softness], 1e-3).unwrap()
    }

    #[test]
    fn hard_limits_pass_the_inside_to_the_bit() {
        let mut hard = clamp(0.0);
        for u in [-20.0, -19.9, 0.1, 119.999, 120.0] {
            assert_eq!(hard.step(&[u]).to_bits(), f64::to_bits(u));
        }
        assert_eq!((hard.step(&[-21.0]), hard.step(&[1e6])), (-20.0, 120.0));
    }

    #[test]
    fn soft_limits_bend_smoothly_and_never_exceed() {
        let mut soft = clamp(10.0);
        assert_eq!(soft.step(&[110.0]), 110.0);
        assert_eq!(soft.step(&[130.0]), 120.0);
        assert_eq!(soft.step(&[120.0]), 117.5);
        assert_eq!(soft.step(&[-20.0]), -17.5);
        let (mut last, mut last_slope) = (soft.step(&[-60.0]), 0.0);
        for k in 1..=2200 {
            let v = soft.step(&[-60.0 + 0.1 * f64::from(k)]);
            let slope = (v - last) / 0.1;
            assert!((-20.0..=120.0).contains(&v) && (-1e-9..=1.0 + 1e-9).contains(&slope));
            assert!((slope - last_slope).abs() < 0.006, "the slope jumps at step {k}");
            (last, last_slope) = (v, slope);
        }
    }
}
