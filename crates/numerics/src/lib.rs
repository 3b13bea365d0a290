//! Numerical methods that several crates need, behind functions that are not generic: they are compiled
//! here once, and not again in each crate that calls them.

pub mod fft;
pub mod spectrum;
pub mod threads;

/// A complex number.
pub type Complex = rustfft::num_complex::Complex<f64>;
