//! Linear part in the frequency domain: frequency response with its quality, and rational fits.
//!
//! * [`measure`]: the frequency response matrix from multisines, swept sines or any other rich signal,
//!   with coherence, noise level and nonlinear distortion.
//! * [`Rational`]: a common-denominator fit of all its elements, with modes and delay.
//! * [`refined`], [`softened`]: its modes as a plant of least output error, at one level or following the amplitude.

mod chain;
mod excitation;
mod held;
mod levels;
mod local;
mod modes;
mod rational;
mod refine;
mod relocate;
mod response;

pub use chain::{Chain, choose_chain, hold};
pub use excitation::{Experiment, period_of};
pub use held::{HeldMode, HeldPlant, PlantNames, Softening, choose_held};
pub use levels::Levels;
pub use local::{MeasureSettings, measure};
pub use modes::{Choice, Mode, RationalSettings, choose, fit_with_delay};
pub use rational::{Domain, Rational};
pub use refine::{Level, refined, relative, softened};
pub use response::{Alone, Distortion, FrequencyResponse, Line};

/// A complex number.
pub type Complex = nalgebra::Complex<f64>;
