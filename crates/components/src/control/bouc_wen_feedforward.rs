//! Feedforward that uses a Bouc–Wen model itself, without an inverse of the hysteresis.
//!
//! ```text
//! D·u = inertia·y″ + lag·y′ + y + H       (M/K and B/K of the printed model)
//! H′ = α·D·u′ − β·|u′|·H − γ·u′·|H|
//! ```
//!
//! * y is the position that is wanted; gain D in position per command; inertia = M/K in s², lag = B/K
//!   in s; H in position. Derivatives of y by backward differences over the period T
//!   (y′ ≈ (y_k − y_{k−1})/T, y″ ≈ (y_k − 2y_{k−1} + y_{k−2})/T²); `limit` bounds what they add.
//! * Both equations are solved together over each sample: with Δu the change of u,
//!   (D − s)·Δu = inertia·y″ + lag·y′ + y + H_{k−1} − D·u_{k−1}, s = α·D − β·sgn(Δu)·H − γ·|H|. Where
//!   the model's slope D − s is not positive (the printed bimorph's right after a reversal, where its
//!   position runs on for 0.2 V), Δu follows with the slope D, which is the explicit form of eq. (4).
//! * At rest H = 0 and u = y/D.
//!
//! Limits: as the model: no rate-dependence but that of the mass, no creep.
//!
//! Source: Q. Xu, IEEE Trans. Industrial Electronics 60 (2013) 3927–3937, eqs. (1), (2), (4).

use libm::fabs;
use model::{Component, Conversion, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::hysteresis::play::between;
use crate::rules::{WRONG_LENGTH, require};

/// The component `bouc-wen-feedforward`.
pub struct BoucWenFeedforward;

static DECLARATION: Declaration = Declaration {
    kind: "bouc-wen-feedforward",
    name: "feedforward",
    summary: "Feedforward that uses a Bouc-Wen model itself, without an inverse",
    equation: "D*u = inertia*y'' + lag*y' + y + H; H' = alpha*D*u' - beta*|u'|*H - gamma*u'*|H|",
    reference: "Q. Xu, IEEE Trans. Ind. Electron. 60 (2013) 3927-3937, eqs. (1), (2), (4)",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    parameters: &[
        Quantity::new("gain", "{position}/{command}", "D, position per command without hysteresis")
            .tunable()
            .fitted(),
        Quantity::new("alpha", "1", "Share of the hysteresis").tunable().fitted(),
        Quantity::new("beta", "1/{command}", "Shape of the loop").tunable().fitted(),
        Quantity::new("gamma", "1/{command}", "Shape of the loop").tunable().fitted(),
        Quantity::new("lag", "s", "B/K").start(0.0).min(0.0).tunable(),
        Quantity::new("inertia", "s2", "M/K").start(0.0).min(0.0).tunable(),
        Quantity::new("limit", "{position}", "Greatest amount that the derivatives add")
            .start(1e9)
            .min(0.0)
            .tunable(),
    ],
    ..Declaration::PATH
};

impl Component for BoucWenFeedforward {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("gain", &[0.06]),
            ("alpha", &[0.2]),
            ("beta", &[0.02]),
            ("gamma", &[0.01]),
            ("lag", &[1e-4]),
            ("inertia", &[1e-7]),
            ("limit", &[0.5]),
        ]
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 7, states: 4 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[gain, alpha, beta, gamma, lag, inertia, limit], [d, a, b, g, first, second, bound]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        let rule = "must not be 0: it is the position per command";
        require(gain != 0.0, "gain", gain, rule)?;
        let rule = "must be below 1: the hysteresis takes that part of the gain away";
        require(alpha < 1.0, "alpha", alpha, rule)?;
        (*d, *a, *b, *g) = (gain, alpha * gain, beta, gamma);
        (*first, *second, *bound) = (lag / period, inertia / (period * period), limit);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[d, ..], &[y], [h, last_u, newer, older], [u]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *u = y / d;
        (*h, *last_u, *newer, *older) = (0.0, *u, y, y);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[d, a, b, g, first, second, bound], &[y], [h, last_u, newer, older], [u]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let addition = first * (y - *newer) + second * ((y - *newer) - (*newer - *older));
        let force = y + between(-bound, bound, addition) + *h - d * *last_u;
        let slope = |sign: f64| d - (a - b * sign * *h - g * fabs(*h));
        // The sign of the change is that of force over slope, where the slope has the gain's sign.
        let sign = if force * d >= 0.0 { 1.0 } else { -1.0 };
        let slope = slope(sign);
        let change = if slope * d > 1e-3 * d * d { force / slope } else { force / d };
        *h += (d - slope) * change;
        *u = *last_u + change;
        (*older, *newer, *last_u) = (*newer, y, *u);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, triangle};

    /// The bimorph's D, in um/V, with a loop whose position never runs backwards.
    const P: [f64; 7] = [24.373, 0.1947, 0.3, 0.1, 2.83e-7, 1.544e-7, 1e9];

    #[test]
    fn the_model_behind_it_gives_the_position() {
        // Quasi-static, so that y = D·u − H, with H integrated much finer than the sample time.
        let mut feedforward = Instance::new(&BoucWenFeedforward, &[], &P, 4e-3).unwrap();
        feedforward.rest(&[0.0]);
        let wanted = triangle(0.0, 130.0, 4000, 2);
        let (mut h, mut last) = (0.0_f64, 0.0_f64);
        for y in &wanted {
            let u = feedforward.step(&[*y]);
            let parts = 50;
            let du = (u - last) / f64::from(parts);
            for _ in 0..parts {
                h += P[1] * P[0] * du - P[2] * du.abs() * h - P[3] * du * h.abs();
            }
            last = u;
            assert!((P[0] * u - h - y).abs() < 0.02, "{y}: {}", P[0] * u - h);
        }
        assert!(h.abs() > 0.5, "there must be hysteresis: {h}");
    }

    #[test]
    fn a_mass_gets_its_force() {
        let p = [2.0, 0.0, 0.0, 0.0, 3e-3, 5e-6, 1e9];
        let mut feedforward = Instance::new(&BoucWenFeedforward, &[], &p, 1e-3).unwrap();
        feedforward.rest(&[0.0]);
        let t = |k: i32| f64::from(k) * 1e-3;
        let mut u = 0.0;
        for k in 1..50 {
            u = feedforward.step(&[7.0 * t(k) * t(k)]);
        }
        let rate = (7.0 * t(49) * t(49) - 7.0 * t(48) * t(48)) / 1e-3;
        let exact = (7.0 * t(49) * t(49) + 3e-3 * rate + 5e-6 * 14.0) / 2.0;
        assert!((u - exact).abs() < 1e-9, "{u} {exact}");
    }
}
