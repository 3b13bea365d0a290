//! The fits: weights of the plays, delay, linear parts.

pub(crate) mod delay;
pub(crate) mod least_squares;
pub(crate) mod levenberg_marquardt;
pub(crate) mod linear_part;
pub(crate) mod operator;
pub(crate) mod response;
pub(crate) mod swarm;
pub(crate) mod weights;
