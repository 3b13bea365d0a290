//! Test signals of the field, each with its limits as parameters.

mod binary;
pub(crate) mod chirp;
pub(crate) mod ellipse;
mod levels;
mod multisine;
mod reversal_curves;
mod sine;
mod triangle;

pub(crate) use binary::BINARY;
pub(crate) use chirp::CHIRPS;
pub(crate) use ellipse::ELLIPSE;
pub(crate) use levels::LEVELS;
pub(crate) use multisine::MULTISINES;
pub(crate) use reversal_curves::REVERSAL_CURVES;
pub(crate) use sine::SINE;
pub(crate) use triangle::TRIANGLES;
