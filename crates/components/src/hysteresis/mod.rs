//! Hysteresis of the piezoceramic: memory between command and elongation.

pub mod dead_zone;
pub mod numeric_inverse;
pub mod play;
pub mod rate;

mod bouc_wen;
mod bouc_wen_inverse;
mod dahl;
mod duhem;
mod duhem_inverse;
mod dynamic_prandtl_ishlinskii;
mod generalised_play;
mod grpi;
mod inverse_prandtl_ishlinskii;
mod lagging_play;
mod modified_prandtl_ishlinskii;
mod mpi;
mod prandtl_ishlinskii;
mod preisach;
mod preisach_inverse;
mod rate_dependent_play;
mod skewed_play;

pub use bouc_wen::BoucWen;
pub use bouc_wen_inverse::INVERSE_BOUC_WEN;
pub use dahl::Dahl;
pub use duhem::Duhem;
pub use duhem_inverse::{INVERSE_DAHL, INVERSE_DUHEM};
pub use dynamic_prandtl_ishlinskii::{
    DynamicPrandtlIshlinskii, INVERSE as INVERSE_DYNAMIC_PRANDTL_ISHLINSKII,
};
pub use generalised_play::{GeneralisedPlay, InverseGeneralisedPlay};
pub use grpi::{Grpi, INVERSE as INVERSE_GRPI};
pub use inverse_prandtl_ishlinskii::InversePrandtlIshlinskii;
pub use lagging_play::LaggingPlay;
pub use modified_prandtl_ishlinskii::{
    InverseModifiedPrandtlIshlinskii, ModifiedPrandtlIshlinskii,
};
pub use mpi::{INVERSE as INVERSE_MPI, Mpi};
pub use prandtl_ishlinskii::PrandtlIshlinskii;
pub use preisach::Preisach;
pub use preisach_inverse::InversePreisach;
pub use rate_dependent_play::{INVERSE as INVERSE_RATE_DEPENDENT_PLAY, RateDependentPlay};
pub use skewed_play::SkewedPlay;

/// The models, and what they leave behind.
pub static OPERATORS: model::Registry = &[
    &PrandtlIshlinskii,
    &ModifiedPrandtlIshlinskii,
    &SkewedPlay,
    &GeneralisedPlay,
    &Preisach,
    &BoucWen,
    &Duhem,
    &Dahl,
    &RateDependentPlay,
    &LaggingPlay,
    &Grpi,
    &Mpi,
    &DynamicPrandtlIshlinskii,
    &super::actuator::Remanence,
];

/// What undoes them in front of the machine.
pub(crate) static INVERSES: model::Registry = &[
    &InversePrandtlIshlinskii,
    &InverseModifiedPrandtlIshlinskii,
    &InverseGeneralisedPlay,
    &InversePreisach,
    &INVERSE_BOUC_WEN,
    &INVERSE_DUHEM,
    &INVERSE_DAHL,
    &INVERSE_RATE_DEPENDENT_PLAY,
    &INVERSE_GRPI,
    &INVERSE_MPI,
    &INVERSE_DYNAMIC_PRANDTL_ISHLINSKII,
];

/// What an actuator of plays, or without memory, becomes with one thing more.
pub(crate) fn extended(by: model::Extension) -> Option<&'static dyn model::Component> {
    use model::Extension;
    match by {
        Extension::Plays => Some(&PrandtlIshlinskii),
        Extension::Skew => Some(&SkewedPlay),
        Extension::Bend => Some(&ModifiedPrandtlIshlinskii),
        _ => None,
    }
}
