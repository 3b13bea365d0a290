//! Couplings between axes: one component over several signal paths.
//!
//! A coupling has one path port per axis and writes all paths at once, so it has no order among its
//! axes and no circular signals.

mod command;
mod displacement;
mod jacobian;
pub(crate) mod matrix;
mod modal_matrix;
mod mode;
mod pincushion;
mod softening_modes;

pub use command::CommandCoupling;
pub use displacement::DisplacementCoupling;
pub use jacobian::OpticsJacobian;
pub use modal_matrix::ModalMatrix;
pub use mode::ModeCoupling;
pub use pincushion::PsdPincushion;
pub use softening_modes::SofteningModes;

/// The components of this folder, in the order of the signal path.
pub(crate) static COMPONENTS: model::Registry = &[
    &CommandCoupling,
    &DisplacementCoupling,
    &ModeCoupling,
    &ModalMatrix,
    &SofteningModes,
    &OpticsJacobian,
    &PsdPincushion,
];
