//! The fits: weights and shape of a method, delay, linear parts.

mod centred;
pub(crate) mod coordinates;
pub(crate) mod delay;
pub(crate) mod linear_part;
pub(crate) mod operator;
pub(crate) mod residual;
pub(crate) mod response;
pub(crate) mod swarm;
