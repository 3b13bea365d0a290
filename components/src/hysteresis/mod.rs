//! Hysteresis of the piezoceramic: memory between command and elongation.

pub mod play;

mod inverse_prandtl_ishlinskii;
mod prandtl_ishlinskii;

pub use inverse_prandtl_ishlinskii::InversePrandtlIshlinskii;
pub use prandtl_ishlinskii::PrandtlIshlinskii;
