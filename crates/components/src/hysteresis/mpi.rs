//! The modified rate-dependent Prandtl–Ishlinskii model (MPI) of the Gaussian-process paper.
//!
//! ```text
//! y = offset + linear·u + cubic·u³ + Σ w_i F_i
//! F_i ← max(u − ρ_i, min(u + ρ_i, F_i)),   ρ_i = scale·r_i + rate·|u̇|
//! ```
//!
//! * linear, cubic, offset: the paper's a2, a1, a3; w its q; ten plays there. scale without unit
//!   and rate in s are its two parameters of the play.
//! * State: one number per play, the five of `rate`.
//!
//! Limits: the paper only cites its rate-modified play; the threshold that grows with the rate
//! (Al Janaideh) stands in for it. The cubic is symmetric about command 0.
//!
//! Source: Hysteresis Modeling and Compensation of Piezoelectric Actuators Using Gaussian Process
//! with High-Dimensional Input, appendix A (the polynomial and the number of parameters); M. Al
//! Janaideh, P. Krejčí, IEEE/ASME Transactions on Mechatronics 18 (2013) 1498–1507 (the play).

use libm::{fabs, fmax};
use model::{
    Component, Conversion, Declaration, Fit, Inverse, Quantity, Role, Scale, Search, Sizes, Stage,
    Tick, Violation,
};

use super::numeric_inverse::{Forward, NumericInverse, Rates, mean_slope};
use super::play::Plays;
use super::prandtl_ishlinskii::{OFFSET, R, STRUCTURE, W, check_plays};
use super::rate;
use super::rate_dependent_play::{COMMAND_MAX, COMMAND_MIN, GROWTH, RATE, widened, widened_frozen};
use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `mpi`.
pub struct Mpi;

/// The component `inverse-mpi`.
pub static INVERSE: NumericInverse<Mpi> =
    NumericInverse { forward: &Mpi, declaration: &INVERSE_DECLARATION };

const LINEAR: Quantity =
    Quantity::new("linear", "{position}/{command}", "Linear part without hysteresis")
        .role(Role::Slope)
        .fitted();
const CUBIC: Quantity = Quantity::new(
    "cubic",
    "{position}/{command}/{command}/{command}",
    "Cubic part without hysteresis",
)
.start(0.0)
.fitted();
const SCALE: Quantity =
    Quantity::new("scale", "1", "Factor of all thresholds").start(1.0).min(0.0).fitted();

static DECLARATION: Declaration = Declaration {
    kind: "mpi",
    name: "hysteresis",
    summary: "Modified rate-dependent Prandtl-Ishlinskii hysteresis: plays and a cubic polynomial",
    equation: "y = offset + linear*u + cubic*u^3 + sum(w[i]*F[i]); F[i] = max(u - t[i], min(u + \
               t[i], F[i])); t[i] = scale*r[i] + rate*|u'|",
    reference: "polynomial: the Gaussian-process paper's appendix A; play: M. Al Janaideh, P. \
                Krejci, IEEE/ASME Trans. Mechatronics 18 (2013) 1498-1507",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::RATE_DEPENDENCE),
    phenomena: &[&phenomena::RATE_DEPENDENT_HYSTERESIS],
    structure: STRUCTURE,
    parameters: &[R, W, OFFSET, LINEAR, CUBIC, SCALE, RATE],
    ..Declaration::PATH
};

static INVERSE_DECLARATION: Declaration = Declaration {
    kind: "inverse-mpi",
    name: "feedforward",
    summary: "Inverse of an mpi model, solved at each step",
    equation: "forward(u) = y, with u' = y'/(mean slope of the largest loop)",
    reference: "M. Al Janaideh, P. Krejci, IEEE/ASME Trans. Mechatronics 18 (2013) 1498-1507",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: STRUCTURE,
    parameters: &[R, W, OFFSET, LINEAR, CUBIC, SCALE, RATE, COMMAND_MIN, COMMAND_MAX],
    ..Declaration::PATH
};

/// `scaled r | w | offset | linear | cubic | rate | 1/T`.
fn split(coefficients: &[f64]) -> Option<(Plays<'_>, [f64; 5])> {
    let (arrays, &scalars) = coefficients.split_last_chunk::<5>()?;
    let (r, w) = arrays.split_at(arrays.len() / 2);
    Some((Plays { r, w }, scalars))
}

fn polynomial(offset: f64, linear: f64, cubic: f64, u: f64) -> f64 {
    offset + (linear + cubic * u * u) * u
}

static FIT: Fit = Fit {
    summary: "Modified rate-dependent Prandtl-Ishlinskii: plays that widen with the rate, and a cubic",
    powers: &[("linear", 1), ("cubic", 3)],
    search: &[
        Search { name: "scale", scale: Scale::Own, start: 1.0, lower: 0.3, upper: 1.5 },
        GROWTH,
    ],
    starts: &[&[1.0, 0.0], &[1.0, 1e-4], &[1.0, 1e-3], &[1.0, 1e-2]],
};

impl Component for Mpi {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("r", &[4.0, 12.0]),
            ("w", &[0.02, 0.01]),
            ("offset", &[0.3]),
            ("linear", &[0.05]),
            ("cubic", &[1e-08]),
            ("scale", &[1.1]),
            ("rate", &[1e-05]),
        ]
    }

    fn plays(&self, _structure: &[f64], parameters: &[f64], each: &mut dyn FnMut(f64, f64)) {
        let Some((plays, [.., scale, _])) = split(parameters) else { return };
        plays.r.iter().zip(plays.w).for_each(|(r, w)| each(scale * r, *w));
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::iteration("inverse-mpi")] }
    }

    fn fit(&self) -> Option<&'static Fit> {
        Some(&FIT)
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let plays = DECLARATION.length(0, structure);
        Sizes { coefficients: 2 * plays + 5, states: plays + rate::STATES }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (Some((arrays, &[offset, linear, cubic, scale, growth])), Some((inner, scalars))) =
            (parameters.split_last_chunk::<5>(), coefficients.split_last_chunk_mut::<5>())
        else {
            return Err(WRONG_LENGTH);
        };
        let (r, w) = arrays.split_at(arrays.len() / 2);
        check_plays(Plays { r, w })?;
        require(scale > 0.0, "scale", scale, "must be above zero; 1 leaves the thresholds")?;
        kept(arrays, inner)?;
        inner.iter_mut().take(r.len()).for_each(|r| *r *= scale);
        *scalars = [offset, linear, cubic, growth, 1.0 / period];
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((plays, [offset, linear, cubic, ..])), &[u], Some((sum, memory)), [y]) = (
            split(coefficients),
            inputs,
            state.split_last_chunk_mut::<{ rate::STATES }>(),
            outputs,
        ) else {
            return;
        };
        *memory = rate::rest(u);
        *y = polynomial(offset, linear, cubic, u) + plays.rest(u, sum);
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
            Some((plays, [offset, linear, cubic, growth, per_period])),
            &[u],
            Some((sum, memory)),
            [y],
        ) = (
            split(coefficients),
            inputs,
            state.split_last_chunk_mut::<{ rate::STATES }>(),
            outputs,
        )
        else {
            return;
        };
        rate::update(memory, u, per_period);
        *y =
            polynomial(offset, linear, cubic, u) + widened(plays, u, growth * fabs(memory[1]), sum);
    }
}

impl Forward for Mpi {
    fn frozen(&self, coefficients: &[f64], state: &[f64], [rate, _]: Rates, u: f64) -> f64 {
        let Some((plays, [offset, linear, cubic, growth, _])) = split(coefficients) else {
            return 0.0;
        };
        polynomial(offset, linear, cubic, u) + widened_frozen(plays, u, growth * fabs(rate), state)
    }

    fn mean_slope(&self, coefficients: &[f64], limits: [f64; 2]) -> f64 {
        split(coefficients)
            .map_or(1.0, |(plays, [_, linear, ..])| mean_slope(plays, linear, limits))
    }

    fn check(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        [low, high]: [f64; 2],
    ) -> Result<(), Violation> {
        let Some((_, &[_, linear, cubic, ..])) = parameters.split_last_chunk::<5>() else {
            return Err(WRONG_LENGTH);
        };
        let rule = "a model without a rising linear part has no inverse; give one above 0";
        require(linear > 0.0, "linear", linear, rule)?;
        let most = fmax(low * low, high * high);
        require(
            linear + 3.0 * cubic * most > 0.0,
            "cubic",
            cubic,
            "the polynomial folds back between command_min and command_max; narrow them",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::RateDependentPlay;
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn without_the_cubic_it_is_the_rate_dependent_play() {
        let signal = Random::new(3).signal(-60.0, 120.0, 500);
        let p = [1.5, 4.0, 10.0, 0.01, 0.02, 0.01, 0.3, 0.05, 0.0, 2.0, 1e-4];
        let mpi = Instance::new(&Mpi, &[3.0], &p, 1e-4).unwrap().response(5.0, &signal);
        let p = [3.0, 8.0, 20.0, 0.01, 0.02, 0.01, 0.3, 0.05, 1e-4];
        let play = Instance::new(&RateDependentPlay, &[3.0], &p, 1e-4);
        for (a, b) in mpi.iter().zip(play.unwrap().response(5.0, &signal)) {
            assert!((a - b).abs() < 1e-13, "{a} {b}");
        }
    }

    #[test]
    fn the_static_inverse_is_exact() {
        let p = [1.5, 4.0, 10.0, 0.01, 0.02, 0.01, 0.3, 0.05, -1e-7, 2.0, 0.0];
        let mut forward = Instance::new(&Mpi, &[3.0], &p, 1e-4).unwrap();
        let p = [&p[..], &[-50.0, 150.0]].concat();
        let mut inverse = Instance::new(&INVERSE, &[3.0], &p, 1e-4).unwrap();
        forward.rest(&[inverse.rest(&[2.0])]);
        for y in Random::new(4).signal(0.0, 8.0, 1000) {
            assert!((forward.step(&[inverse.step(&[y])]) - y).abs() < 1e-9 * 8.0);
        }
    }

    #[test]
    fn a_polynomial_that_folds_back_has_no_inverse() {
        let p = [1.5, 0.01, 0.3, 0.05, -1e-5, 1.0, 0.0, -50.0, 150.0];
        let error = Instance::new(&INVERSE, &[1.0], &p, 1e-4).err();
        assert_eq!(error.map(|v| v.quantity), Some("cubic"));
    }

    #[test]
    fn values_are_those_of_the_polynomial_and_the_play() {
        // y = 0.5 + (2 + u^2/4)*u + u, at rest and in motion.
        let mut model = Instance::new(&Mpi, &[1.0], &[0.0, 1.0, 0.5, 2.0, 0.25, 1.0, 0.0], 1e-4);
        let model = model.as_mut().unwrap();
        assert_eq!([model.rest(&[2.0]), model.rest(&[-4.0])], [8.5, -27.5]);
        assert_eq!([model.step(&[2.0]), model.step(&[-4.0])], [8.5, -27.5]);
    }

    #[test]
    fn a_scale_of_zero_is_refused() {
        let error = Instance::new(&Mpi, &[1.0], &[0.0, 1.0, 0.5, 2.0, 0.25, 0.0, 0.0], 1e-4).err();
        assert_eq!(error.map(|v| v.quantity), Some("scale"));
    }
}
