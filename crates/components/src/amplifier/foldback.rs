//! Average current limit of the amplifier: after fast driving for a while it falls back.
//!
//! ```text
//! |v′| ≤ peak/capacitance while q ≤ continuous², else ≤ continuous/capacitance
//! time_constant·q′ = (capacitance·v′)² − q
//! ```
//!
//! * peak ≥ continuous in A; capacitance in F; time_constant in s (0.01–10): how long the amplifier
//!   can give more than the continuous current: √q is the rms current over it.
//! * State: v and q. v runs straight towards the input and stops there, so it is exact over a step;
//!   q sees the mean current of the step. At rest v = u and q = 0.
//!
//! Limits: the limit is chosen once per step; constant capacitance; the same limit for charging and
//! discharging.

use libm::{fabs, fmin};
use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::linear::approach;
use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `amplifier-foldback`.
pub struct AmplifierFoldback;

static DECLARATION: Declaration = Declaration {
    kind: "amplifier-foldback",
    name: "foldback",
    summary: "Average current limit of the amplifier, which acts after sustained fast driving",
    equation: "|v'| <= i/capacitance; i = peak while q <= continuous^2, else continuous; \
               time_constant*q' = (capacitance*v')^2 - q",
    reference: "A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning \
                Systems, Springer 2014, ch. 14",
    stage: Stage::Amplifier,
    effect: Some(&effects::AMPLIFIER_SLEW),
    phenomena: &[&phenomena::FOLDBACK],
    parameters: &[
        Quantity::new("continuous", "A", "Greatest rms current").min(0.0).fitted(),
        Quantity::new("peak", "A", "Greatest current at any time").min(0.0).fitted(),
        Quantity::new("capacitance", "C/{command}", "Capacitance of the actuator").min(0.0),
        Quantity::new("time_constant", "s", "Averaging time of the rms current")
            .start(1.0)
            .min(0.0),
    ],
    ..Declaration::PATH
};

impl Component for AmplifierFoldback {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 4, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[continuous, peak, capacitance, time_constant], [fast, slow, average, fraction]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        let rule = "must be above zero; set enabled = false for no limit";
        require(continuous > 0.0, "continuous", continuous, rule)?;
        require(peak >= continuous, "peak", peak, "must be at least `continuous`")?;
        require(capacitance > 0.0, "capacitance", capacitance, "must be above zero")?;
        require(time_constant > 0.0, "time_constant", time_constant, "must be above zero")?;
        // Ways of the voltage in a step, at either limit; q as the square of such a way.
        (*fast, *slow) = (peak / capacitance * period, continuous / capacitance * period);
        (*average, *fraction) = (*slow * *slow, approach(time_constant, period));
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [v, q], [y]) = (inputs, state, outputs) else { return };
        (*v, *q, *y) = (u, 0.0, u);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[fast, slow, average, fraction], &[u], [v, q], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let most = if *q <= average { fast } else { slow };
        let way = fmin(fabs(u - *v), most);
        *v = if way < most { u } else { *v + way.copysign(u - *v) };
        *q += fraction * (way * way - *q);
        *y = *v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    /// 1 µF: 0.1 A are 100 V/ms, 0.02 A are 20 V/ms.
    const P: [f64; 4] = [0.02, 0.1, 1e-6, 0.5];

    #[test]
    fn one_step_runs_at_the_peak_current_and_ends_on_the_input() {
        let mut amplifier = Instance::new(&AmplifierFoldback, &[], &P, 1e-4).unwrap();
        amplifier.rest(&[0.0]);
        for expected in [10.0, 20.0, 25.0, 25.0] {
            assert!((amplifier.step(&[25.0]) - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn steady_fast_driving_falls_back_to_the_continuous_rms_current() {
        let mut amplifier = Instance::new(&AmplifierFoldback, &[], &P, 1e-4).unwrap();
        let mut last = amplifier.rest(&[0.0]);
        let (mut early, mut late) = (0.0, 0.0);
        for n in 0..100_000u32 {
            let u = if (n / 20).is_multiple_of(2) { 100.0 } else { -100.0 };
            let v = amplifier.step(&[u]);
            let current = 1e-6 * (v - last) / 1e-4;
            last = v;
            match n {
                0..100 => early += current * current / 100.0,
                50_000.. => late += current * current / 50_000.0,
                _ => {}
            }
        }
        // At the peak current but for ten steps on the first plateau.
        assert!((early / (0.9 * 0.1 * 0.1) - 1.0).abs() < 1e-9, "{early}");
        assert!((f64::sqrt(late) / 0.02 - 1.0).abs() < 0.03, "{late}");
    }

    #[test]
    fn slow_driving_passes_unchanged() {
        let mut amplifier = Instance::new(&AmplifierFoldback, &[], &P, 1e-4).unwrap();
        amplifier.rest(&[0.0]);
        for n in 0..20_000 {
            let u = 50.0 * (0.002 * f64::from(n)).sin();
            assert_eq!(amplifier.step(&[u]), u);
        }
    }
}
