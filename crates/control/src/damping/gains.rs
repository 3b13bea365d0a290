//! The gains of a damped loop, and its two laws: what tracks and what damps.

use core::f64::consts::PI;

use nalgebra::Complex;

use super::laws::{Damping, Filtering};

/// Gains over the steepest slope, frequencies in rad per sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gains {
    pub(super) law: Damping,
    /// Gain of the inner loop, or depth of the notch.
    pub(super) gain: f64,
    pub(super) angle: f64,
    pub(super) damping: f64,
    pub(super) kp: f64,
    /// ki·T.
    pub(super) ki: f64,
    /// kd/T.
    pub(super) kd: f64,
    /// What the derivative's filter keeps of its last value.
    pub(super) keep: f64,
}

impl Gains {
    /// From the values that are sought; `first`: the resonance in rad per sample.
    pub(super) fn of(law: Damping, x: &[f64], first: f64) -> Self {
        let (own, outer) = x.split_at(law.own_gains());
        let (angle, damping) = match law {
            Damping::Notch => (first, own[1]),
            _ => (own[1] * first, own.get(2).copied().unwrap_or(1.0)),
        };
        let (kd, keep) = match outer {
            [_, _, kd, corner] => (kd / first, (-corner * first).exp()),
            _ => (0.0, 0.0),
        };
        let angle = angle.min(0.8 * PI);
        Self { law, gain: own[0], angle, damping, kp: outer[0], ki: outer[1] * first, kd, keep }
    }

    /// C and D where z⁻¹ is `back`.
    pub(super) fn at(&self, back: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
        let one = Complex::new(1.0, 0.0);
        let difference = one - back;
        let mut outer = Complex::new(self.kp, 0.0) + self.ki / difference;
        if self.kd > 0.0 {
            outer += difference * (self.kd * (1.0 - self.keep)) / (one - back * self.keep);
        }
        let w = (0.5 * self.angle).tan();
        let at = Filtering { back, w, broad: 2.0 * self.damping * w };
        match self.law.filter(&at) {
            Some(inner) => (outer, inner * self.gain),
            // The notch is in line with the tracking law.
            None => {
                let ratio = outer * at.second_order(at.broad * self.gain);
                (ratio / at.second_order(at.broad), Complex::new(0.0, 0.0))
            }
        }
    }

    /// Standard deviation of C − D behind white noise, without the integral's sum of it.
    pub(super) fn noise(&self) -> f64 {
        const POINTS: usize = 64;
        let rest = Self { ki: 0.0, ..*self };
        let each = (0..POINTS).map(|k| {
            let angle = PI * (k as f64 + 0.5) / POINTS as f64;
            let (outer, inner) = rest.at(Complex::from_polar(1.0, -angle));
            (outer - inner).norm_sqr()
        });
        (each.sum::<f64>() / POINTS as f64).sqrt()
    }
}
