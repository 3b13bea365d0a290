//! Creep: the slow part of the elongation after a change of the voltage.
//!
//! All three kinds are sums of first-order elements that each take their share of the way:
//! `y = direct·u + Σ share_i·z_i`, `τ_i z_i′ = u − z_i`. They differ in how shares and time
//! constants follow from the parameters.

mod elements;
mod fractional;
mod inverse_kelvin_voigt;
mod kelvin_voigt;
mod logarithmic;

pub use elements::crept;
pub use fractional::FractionalCreep;
pub use inverse_kelvin_voigt::InverseKelvinVoigtCreep;
pub use kelvin_voigt::KelvinVoigtCreep;
pub use logarithmic::LogarithmicCreep;

/// The components of this folder, in the order of the signal path.
pub(crate) static COMPONENTS: model::Registry =
    &[&KelvinVoigtCreep, &LogarithmicCreep, &FractionalCreep];
