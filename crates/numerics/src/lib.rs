//! Numerical methods that several crates need, behind functions whose bulk is not generic: it is compiled
//! here once, and not again in each crate that calls it.

pub mod fft;
pub mod least_squares;
pub mod levenberg_marquardt;
pub mod qr;
pub mod random;
pub mod spectrum;
pub mod threads;

/// The middle one of the values in order, of an even number the upper one of two; `None` of no values. It reorders them.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// A complex number.
pub type Complex = rustfft::num_complex::Complex<f64>;
