//! Hysteresis of the piezoceramic: memory between command and elongation.

pub mod dead_zone;
pub mod play;

mod generalised_play;
mod inverse_prandtl_ishlinskii;
mod modified_prandtl_ishlinskii;
mod prandtl_ishlinskii;

pub use generalised_play::{GeneralisedPlay, InverseGeneralisedPlay};
pub use inverse_prandtl_ishlinskii::InversePrandtlIshlinskii;
pub use modified_prandtl_ishlinskii::{
    InverseModifiedPrandtlIshlinskii, ModifiedPrandtlIshlinskii,
};
pub use prandtl_ishlinskii::PrandtlIshlinskii;
