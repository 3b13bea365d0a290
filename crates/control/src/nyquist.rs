//! Whether a curve over the upper half of the unit circle goes round zero.

use nalgebra::Complex;

/// How often a curve has gone round zero.
#[derive(Default)]
pub(crate) struct Round {
    last: Option<Complex<f64>>,
    crossings: i32,
    begins_wrong: bool,
}

impl Round {
    /// The next point of the curve.
    pub(crate) fn go(&mut self, now: Complex<f64>) {
        match self.last {
            None => self.begins_wrong = now.re <= 0.0 || now.re.is_nan(),
            Some(last) if (last.im >= 0.0) != (now.im >= 0.0) => {
                let at = last.re - last.im * (now.re - last.re) / (now.im - last.im);
                if at < 0.0 || at.is_nan() {
                    self.crossings += if now.im < last.im { 1 } else { -1 };
                }
            }
            Some(_) => {}
        }
        self.last = Some(now);
    }

    /// Whether it has not: it began on the right and ends, real, on the right, and its crossings cancel.
    pub(crate) fn is_none(&self) -> bool {
        !self.begins_wrong && self.crossings == 0 && self.last.is_some_and(|last| last.re > 0.0)
    }
}
