//! Active damping of a resonance: the measured position is fed back in positive sense through a filter, beside
//! the law that tracks.
//!
//! ```text
//! y = u + gain·F(s)·(x − x_0),  x = measured − setpoint_weight·reference
//! integral-resonant-control    F = ω/(s + ω)
//! positive-position-feedback   F = ω²/(s² + 2·damping·ω·s + ω²)
//! non-minimum-phase-damping    F = (ω − s)/(ω + s),   ω = 2π·frequency
//! ```
//!
//! * gain in command per position, frequency in Hz; F(0) = 1. The inner loop alone is stable where
//!   gain·G(0) < 1, G being the machine, for machines whose modes all move with the command (negative
//!   imaginary) and without delay; with delays and lags it is found by computation (`invert --damping`).
//! * Integral resonant control is −k/s around the machine with a feedthrough d < 0 added, G + d; that is this
//!   low-pass with gain = −1/d and ω = −k·d.
//! * `setpoint_weight` is the share of the reference that is taken off the position: 1 with an inverse as
//!   feedforward, whose command then stays that of the machine without damping; 0 without one, where the law behind
//!   it sees the damped machine.
//! * x_0 is x at rest, or where the loop was closed: there y = u, without a jump. Disabled, y = u.
//! * Bilinear transform with the frequency kept (prewarped). All but the structure may be changed during a run.
//! * It stands behind the feedforward and in front of the law, whose limits hold for the sum. The law's
//!   `feedforward` output then holds y; the output `damping` is y − u.
//!
//! Limits: linear; a hysteresis in the machine changes its slope, and so the loop gain.
//!
//! Sources: S. S. Aphale, A. J. Fleming, S. O. R. Moheimani, Smart Materials and Structures 16 (2007) 439–446
//! (integral resonant control); J. L. Fanson, T. K. Caughey, AIAA Journal 28 (1990) 717–724 (positive position
//! feedback); A. Natu, H. HosseinNia, arXiv 2412.18374 (non-minimum-phase resonant control); A. Lanzon,
//! I. R. Petersen, IEEE Trans. Automatic Control 53 (2008) 1042–1046 (condition at zero frequency).

use core::f64::consts::PI;

use libm::tan;
use model::{
    Component, Conversion, Declaration, Example, Input, Output, Quantity, Sizes, Stage, Tick,
    Violation,
};

use super::limiter::{ENABLE, truth};
use crate::rules::{WRONG_LENGTH, require};

/// One of the three.
pub struct ActiveDamping {
    declaration: &'static Declaration,
    filter: Filter,
    example: Example,
}

#[derive(Clone, Copy, PartialEq)]
enum Filter {
    LowPass,
    SecondOrder,
    AllPass,
}

/// The component `integral-resonant-control`.
pub static INTEGRAL_RESONANT_CONTROL: ActiveDamping = ActiveDamping {
    declaration: &INTEGRAL_RESONANT,
    filter: Filter::LowPass,
    example: &[("gain", &[12.0]), ("frequency", &[400.0]), ("setpoint_weight", &[0.5])],
};

/// The component `positive-position-feedback`.
pub static POSITIVE_POSITION_FEEDBACK: ActiveDamping = ActiveDamping {
    declaration: &POSITIVE_POSITION,
    filter: Filter::SecondOrder,
    example: &[
        ("gain", &[12.0]),
        ("frequency", &[700.0]),
        ("damping", &[0.6]),
        ("setpoint_weight", &[0.0]),
    ],
};

/// The component `non-minimum-phase-damping`.
pub static NON_MINIMUM_PHASE_DAMPING: ActiveDamping = ActiveDamping {
    declaration: &NON_MINIMUM_PHASE,
    filter: Filter::AllPass,
    example: &[("gain", &[12.0]), ("frequency", &[900.0])],
};

const GAIN: Quantity =
    Quantity::new("gain", "{command}/{position}", "Static gain of the feedback").tunable();
const WEIGHT: Quantity = Quantity::new(
    "setpoint_weight",
    "1",
    "Share of the reference that is subtracted from the measured position; 1 with an inverse as feedforward",
)
.start(1.0)
.min(0.0)
.max(1.0)
.tunable();

static INTEGRAL_RESONANT: Declaration = Declaration {
    kind: "integral-resonant-control",
    name: "damping",
    summary: "Integral resonant control: a low-pass of the position in positive feedback damps a resonance",
    equation: "y = u + gain*F*(x - x0); F = w/(s + w); w = 2*pi*frequency; x = measured - \
               setpoint_weight*reference; x0 = x at rest and where the loop was closed",
    reference: "S. S. Aphale, A. J. Fleming, S. O. R. Moheimani, Smart Mater. Struct. 16 (2007) 439-446",
    stage: Stage::Control,
    conversion: Conversion::Control,
    inputs: &[Input::PATH, Input::axis("reference"), Input::axis("measured"), ENABLE],
    outputs: &[
        Output::PATH,
        Output::published("damping", "{command}", "What the active damping adds", false),
    ],
    parameters: &[
        GAIN,
        Quantity::new("frequency", "Hz", "Corner frequency of the low-pass").min(0.0).tunable(),
        WEIGHT,
    ],
    ..Declaration::PATH
};

static POSITIVE_POSITION: Declaration = Declaration {
    kind: "positive-position-feedback",
    summary: "Positive position feedback: a resonant low-pass of the position damps a resonance",
    equation: "y = u + gain*F*(x - x0); F = w^2/(s^2 + 2*damping*w*s + w^2); w = 2*pi*frequency; x = measured - \
               setpoint_weight*reference; x0 = x at rest and where the loop was closed",
    reference: "J. L. Fanson, T. K. Caughey, AIAA J. 28 (1990) 717-724",
    parameters: &[
        GAIN,
        Quantity::new("frequency", "Hz", "Natural frequency of the filter").min(0.0).tunable(),
        Quantity::new("damping", "1", "Damping ratio of the filter").min(0.0).tunable(),
        WEIGHT,
    ],
    ..INTEGRAL_RESONANT
};

static NON_MINIMUM_PHASE: Declaration = Declaration {
    kind: "non-minimum-phase-damping",
    summary: "Non-minimum-phase damping: feedback of the position through an all-pass, with constant gain and shifted phase",
    equation: "y = u + gain*F*(x - x0); F = (w - s)/(w + s); w = 2*pi*frequency; x = measured - \
               setpoint_weight*reference; x0 = x at rest and where the loop was closed",
    reference: "A. Natu, H. HosseinNia, arXiv 2412.18374 (2024)",
    parameters: &[
        GAIN,
        Quantity::new(
            "frequency",
            "Hz",
            "Frequency at which the phase of the all-pass is -90 degrees",
        )
        .min(0.0)
        .tunable(),
        WEIGHT,
    ],
    ..INTEGRAL_RESONANT
};

/// Gain, setpoint weight, and the filter's b_0, b_1, b_2, a_1, a_2.
const COEFFICIENTS: usize = 7;

impl Component for ActiveDamping {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn example(&self) -> Example {
        self.example
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: COEFFICIENTS, states: 4 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (gain, frequency, damping, weight) = match *parameters {
            [gain, frequency, weight] => (gain, frequency, 1.0, weight),
            [gain, frequency, damping, weight] => (gain, frequency, damping, weight),
            _ => return Err(WRONG_LENGTH),
        };
        let all = <&mut [f64; COEFFICIENTS]>::try_from(coefficients).map_err(|_| WRONG_LENGTH)?;
        require(
            frequency > 0.0 && frequency * period < 0.5,
            "frequency",
            frequency,
            "must be above 0 and below half the controller's sampling frequency",
        )?;
        require(damping > 0.0, "damping", damping, "must be above 0; 0.5 to 1 is usual")?;
        let w = tan(PI * frequency * period);
        let (part, keep) = (w / (1.0 + w), (1.0 - w) / (1.0 + w));
        let [b0, b1, b2, a1, a2] = match self.filter {
            Filter::LowPass => [part, part, 0.0, -keep, 0.0],
            Filter::AllPass => [-keep, 1.0, 0.0, -keep, 0.0],
            Filter::SecondOrder => {
                let (square, broad) = (w * w, 2.0 * damping * w);
                let sum = 1.0 + square + broad;
                let b = square / sum;
                [b, 2.0 * b, b, 2.0 * (square - 1.0) / sum, (1.0 + square - broad) / sum]
            }
        };
        *all = [gain, weight, b0, b1, b2, a1, a2];
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (
            &[_, weight, ..],
            &[u, reference, measured, enable],
            [origin, first, second, was_on],
            [y, added],
        ) = (coefficients, inputs, state, outputs)
        else {
            return;
        };
        (*origin, *first, *second) = (measured - weight * reference, 0.0, 0.0);
        (*y, *added, *was_on) = (u, 0.0, truth(enable != 0.0));
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (
            &[gain, weight, b0, b1, b2, a1, a2],
            &[u, reference, measured, enable],
            [origin, first, second, was_on],
            [y, added],
        ) = (coefficients, inputs, state, outputs)
        else {
            return;
        };
        (*y, *added) = (u, 0.0);
        if enable == 0.0 {
            *was_on = 0.0;
            return;
        }
        let position = measured - weight * reference;
        if *was_on == 0.0 {
            (*origin, *first, *second, *was_on) = (position, 0.0, 0.0, 1.0);
        }
        let moved = position - *origin;
        let filtered = b0 * moved + *first;
        *first = b1 * moved - a1 * filtered + *second;
        *second = b2 * moved - a2 * filtered;
        *added = gain * filtered;
        *y = u + *added;
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;
    use crate::linear::SecondOrder;
    use crate::testing::Instance;

    const PERIOD: f64 = 1e-5;

    fn of(damping: &'static ActiveDamping, parameters: &[f64]) -> Instance {
        Instance::new(damping, &[], parameters, PERIOD).unwrap()
    }

    /// Gain and turn (rad) of F at a frequency.
    fn response(damping: &'static ActiveDamping, parameters: &[f64], frequency: f64) -> (f64, f64) {
        let mut instance = of(damping, parameters);
        instance.rest(&[0.0, 0.0, 0.0, 1.0]);
        let (waves, samples) = (20, (1.0 / (frequency * PERIOD)).round() as usize);
        let (mut cosine, mut sine) = (0.0, 0.0);
        for k in 0..waves * samples {
            let turn = TAU * k as f64 / samples as f64;
            let y = instance.step(&[0.0, 0.0, turn.sin(), 1.0]);
            if k >= samples * waves / 2 {
                (cosine, sine) = (cosine + y * turn.cos(), sine + y * turn.sin());
            }
        }
        let scale = 2.0 / (samples * waves / 2) as f64;
        (scale * cosine.hypot(sine), cosine.atan2(sine))
    }

    #[test]
    fn each_filter_is_that_of_its_equation_at_its_own_frequency() {
        let (gain, turn) = response(&INTEGRAL_RESONANT_CONTROL, &[2.0, 1000.0, 0.0], 1000.0);
        assert!((gain - 2.0_f64.sqrt()).abs() < 1e-6 && (turn + TAU / 8.0).abs() < 1e-6);
        let (gain, turn) = response(&POSITIVE_POSITION_FEEDBACK, &[2.0, 1000.0, 0.4, 0.0], 1000.0);
        assert!((gain - 2.0 / 0.8).abs() < 1e-6 && (turn + TAU / 4.0).abs() < 1e-6);
        for frequency in [200.0, 1000.0, 4000.0] {
            let (gain, turn) = response(&NON_MINIMUM_PHASE_DAMPING, &[2.0, 1000.0, 0.0], frequency);
            let wanted =
                -2.0 * ((PI * frequency * PERIOD).tan() / (PI * 1000.0 * PERIOD).tan()).atan();
            assert!((gain - 2.0).abs() < 1e-6 && (turn - wanted).abs() < 1e-6, "{frequency}");
        }
    }

    /// Decay per radian of the first swings of a mode of 500 Hz with a damping ratio of 0.01 in positive feedback:
    /// the closed loop's polynomial in s tells the damping.
    fn damping_of(damping: &'static ActiveDamping, parameters: &[f64]) -> f64 {
        let mut instance = of(damping, parameters);
        let mode = SecondOrder::new(500.0, 0.01, 1.0, PERIOD);
        let mut state = [0.0; 2];
        instance.rest(&[0.0, 0.0, 0.0, 1.0]);
        let (mut position, mut energy) = (0.0, [0.0_f64; 2]);
        let waves = 4;
        let samples = (1.0 / (500.0 * PERIOD)).round() as usize;
        for k in 0..2 * waves * samples {
            let push = if k == 0 { 100.0 } else { 0.0 };
            let u = instance.step(&[push, 0.0, position, 1.0]);
            position = mode.step(u, &mut state);
            energy[k / (waves * samples)] += position * position;
        }
        -0.5 * (energy[1] / energy[0]).ln() / (TAU * waves as f64)
    }

    #[test]
    fn small_gains_damp_as_perturbation_theory_says() {
        // The poles of s² + 2ζω₁s + ω₁² = ω₁²·g·F(s) move by Δζ = −g·Im F(jω₁)/2 for small g.
        let free = damping_of(&INTEGRAL_RESONANT_CONTROL, &[0.0, 500.0, 0.0]);
        assert!((free - 0.01).abs() < 1e-4, "{free}");
        // At its corner: Im F = −1/2 for the low-pass, −1 for the all-pass, −1/2ζ_f for the second order.
        for (kind, parameters, wanted) in [
            (&INTEGRAL_RESONANT_CONTROL, &[0.02, 500.0, 0.0][..], 0.25 * 0.02),
            (&NON_MINIMUM_PHASE_DAMPING, &[0.02, 500.0, 0.0], 0.5 * 0.02),
            (&POSITIVE_POSITION_FEEDBACK, &[0.02, 500.0, 1.0, 0.0], 0.25 * 0.02),
        ] {
            let added = damping_of(kind, parameters) - free;
            assert!((added / wanted - 1.0).abs() < 0.06, "{added} for {wanted}");
        }
    }

    #[test]
    fn closing_the_loop_makes_no_jump_and_an_open_one_adds_nothing() {
        let mut instance = of(&NON_MINIMUM_PHASE_DAMPING, &[5.0, 700.0, 0.0]);
        assert_eq!(instance.rest(&[1.0, 0.3, 0.2, 0.0]), 1.0);
        assert_eq!(instance.step(&[1.5, 0.3, 0.9, 0.0]), 1.5);
        assert_eq!(instance.step(&[1.5, 0.3, 0.4, 1.0]), 1.5);
        assert!((instance.step(&[1.5, 0.3, 0.5, 1.0]) - 1.5).abs() > 0.1);
        assert!((instance.outputs[1] + 1.5 - instance.outputs[0]).abs() < 1e-15);
        // What is wanted is taken off where the weight is 1.
        let mut complete = of(&NON_MINIMUM_PHASE_DAMPING, &[5.0, 700.0, 1.0]);
        complete.rest(&[1.0, 0.2, 0.2, 1.0]);
        assert_eq!(complete.step(&[1.0, 0.7, 0.7, 1.0]), 1.0);
    }

    #[test]
    fn frequencies_beyond_half_the_sampling_rate_and_no_damping_are_refused() {
        let refused = |kind, parameters: &[f64]| {
            Instance::new(kind, &[], parameters, 1e-3).err().unwrap().quantity
        };
        assert_eq!(refused(&INTEGRAL_RESONANT_CONTROL, &[1.0, 500.0, 0.0]), "frequency");
        assert_eq!(refused(&NON_MINIMUM_PHASE_DAMPING, &[1.0, 0.0, 0.0]), "frequency");
        assert_eq!(refused(&POSITIVE_POSITION_FEEDBACK, &[1.0, 100.0, 0.0, 0.0]), "damping");
    }
}
