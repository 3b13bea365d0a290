//! A discrete transfer function: the linear part that the laser beam paper puts behind its hysteresis.
//!
//! `y_k = Σ b_i·u_{k−i+1} − Σ a_j·y_{k−j}`
//!
//! * b of `numerator` and a of `denominator` coefficients (a_1 is that of y_{k−1}), at its own sample
//!   time, a whole number of internal steps; between samples y is held.
//! * State: past inputs and outputs. At rest y = u·Σb/(1 + Σa).
//! * Refused where it is unstable (a pole on or outside the unit circle, by the Schur-Cohn test).
//!
//! Limits: linear; it makes up for a lag of its sample time at most.
//!
//! Source: laser beam pointing with four piezo axes, eq. (11).

use libm::{fabs, round};
use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Tick, Violation};

use crate::phenomena;
use crate::rules::{WRONG_LENGTH, require};

/// The component `arx`.
pub struct Arx;

static DECLARATION: Declaration = Declaration {
    kind: "arx",
    name: "dynamics",
    summary: "Discrete transfer function (ARX model) at its own sample time",
    equation: "y(k) = sum(b[i]*u(k-i+1)) - sum(a[j]*y(k-j))",
    reference: "laser beam pointing with four piezo axes, eq. (11)",
    stage: Stage::Mechanics,
    phenomena: &[&phenomena::CONTROLLER_DIFFERENCE],
    structure: &[
        Structural {
            name: "sample_time",
            unit: "s",
            description: "Sample time of the transfer function, a whole number of internal steps",
            start: None,
            min: 1e-9,
            max: 1e3,
            integer: false,
        },
        Structural::count("numerator", "Number of coefficients b", 1, 64),
        Structural::count("denominator", "Number of coefficients a", 1, 64),
    ],
    parameters: &[
        Quantity::new("b", "1", "Coefficient of each input, the present one first").per(1).fitted(),
        Quantity::new("a", "1", "Coefficient of each past output, the last one first")
            .per(2)
            .fitted(),
    ],
    ..Declaration::PATH
};

/// Numbers of coefficients b and a.
fn orders(structure: &[f64]) -> (usize, usize) {
    let order = |at: usize| structure.get(at).map_or(0, |n| *n as usize);
    (order(1), order(2))
}

impl Component for Arx {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let (zeros, poles) = orders(structure);
        // Ratio, order of b, static gain; b, a; room for the test of stability.
        Sizes { coefficients: 3 + zeros + 3 * poles, states: zeros + poles }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (zeros, poles) = orders(structure);
        let (Some(&sample), Some(([ratio, order, gain], rest))) =
            (structure.first(), coefficients.split_first_chunk_mut::<3>())
        else {
            return Err(WRONG_LENGTH);
        };
        if parameters.len() != zeros + poles || rest.len() != zeros + 3 * poles {
            return Err(WRONG_LENGTH);
        }
        *ratio = round(sample / period);
        let off = fabs(sample / period - *ratio);
        let rule = "must be a whole number of internal steps; choose the model's step so";
        require(*ratio >= 1.0 && off <= 1e-6 * *ratio, "sample_time", sample, rule)?;
        *order = zeros as f64;
        let (own, room) = rest.split_at_mut(zeros + poles);
        own.copy_from_slice(parameters);
        let (b, a) = parameters.split_at(zeros);
        let (now, next) = room.split_at_mut(poles);
        now.copy_from_slice(a);
        if let Some(reflection) = unstable(now, next) {
            let rule = "makes the transfer function unstable (a pole on or outside the unit circle); \
                        fit it with fewer coefficients or over a longer record";
            return Err(Violation { quantity: "a", index: None, value: reflection, rule });
        }
        *gain = b.iter().sum::<f64>() / (1.0 + a.iter().sum::<f64>());
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((&[_, order, gain], _)), &[u], [y]) =
            (coefficients.split_first_chunk::<3>(), inputs, outputs)
        else {
            return;
        };
        let (past, own) = state.split_at_mut((order as usize).min(state.len()));
        past.fill(u);
        *y = gain * u;
        own.fill(*y);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((&[ratio, order, _], rest)), &[u], [y]) =
            (coefficients.split_first_chunk::<3>(), inputs, outputs)
        else {
            return;
        };
        let (past, own) = state.split_at_mut((order as usize).min(state.len()));
        if tick.index.is_multiple_of((ratio as u64).max(1)) {
            let (b, a) = rest.split_at(past.len().min(rest.len()));
            shift(past, u);
            let forward: f64 = b.iter().zip(&*past).map(|(b, u)| b * u).sum();
            let back: f64 = a.iter().zip(&*own).map(|(a, y)| a * y).sum();
            shift(own, forward - back);
        }
        *y = own.first().copied().unwrap_or(u);
    }
}

/// Puts `value` in front.
fn shift(values: &mut [f64], value: f64) {
    for at in (1..values.len()).rev() {
        values[at] = values[at - 1];
    }
    if let Some(first) = values.first_mut() {
        *first = value;
    }
}

/// The reflection coefficient on or beyond ±1 of `1 + Σ a_j z^−j`, where there is one. `a` is spent.
fn unstable(a: &mut [f64], room: &mut [f64]) -> Option<f64> {
    for order in (1..=a.len()).rev() {
        let k = a[order - 1];
        // Not a number is unstable.
        if k.is_nan() || fabs(k) >= 1.0 {
            return Some(k);
        }
        for i in 0..order - 1 {
            room[i] = (a[i] - k * a[order - 2 - i]) / (1.0 - k * k);
        }
        a[..order - 1].copy_from_slice(&room[..order - 1]);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, Random};

    /// The laser beam's: b then a.
    const G: [f64; 6] = [0.276897, -0.540637, 0.263941, -2.72054, 2.45461, -0.733864];
    const S: [f64; 3] = [5e-3, 3.0, 3.0];

    #[test]
    fn it_is_the_difference_equation_and_holds_between() {
        let mut arx = Instance::new(&Arx, &S, &G, 1e-3).unwrap();
        let rest = arx.rest(&[0.5]);
        // The printed coefficients give 0.9757.
        assert!((rest / 0.5 - 0.201e-3 / 0.206e-3).abs() < 1e-9, "{}", rest / 0.5);
        let (mut u, mut y) = ([0.5; 3], [rest; 3]);
        for (n, x) in (1..).zip(Random::new(8).signal(0.0, 1.0, 2000)) {
            let found = arx.step(&[x]);
            if n % 5 == 0 {
                u = [x, u[0], u[1]];
                let new = G[0] * u[0] + G[1] * u[1] + G[2] * u[2]
                    - G[3] * y[0]
                    - G[4] * y[1]
                    - G[5] * y[2];
                y = [new, y[0], y[1]];
            }
            assert!((found - y[0]).abs() < 1e-9, "{n}: {found} {}", y[0]);
        }
    }

    #[test]
    fn unstable_ones_are_refused() {
        let s = [1e-3, 1.0, 2.0];
        // Poles at 0.5 ± 0.9j and at 1.
        for a in [[-1.0, 1.06], [-1.5, 0.5], [f64::NAN, 0.0]] {
            let found = Instance::new(&Arx, &s, &[1.0, a[0], a[1]], 1e-3).err();
            assert_eq!(found.map(|v| v.quantity), Some("a"), "{a:?}");
        }
        // 0.5 ± 0.8j.
        assert!(Instance::new(&Arx, &s, &[1.0, -1.0, 0.89], 1e-3).is_ok());
        let found = Instance::new(&Arx, &s, &[1.0, 0.0, 0.0], 0.7e-3).err();
        assert_eq!(found.map(|v| v.quantity), Some("sample_time"));
    }
}
