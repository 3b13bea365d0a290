//! The signals of the five papers.

mod p0;
mod p0_motion;
mod p1;
mod p2;
mod p3;
mod p4;

pub(crate) use p0::P0;
pub(crate) use p0_motion::P0_MOTIONS;
pub(crate) use p1::P1;
pub(crate) use p2::P2;
pub(crate) use p3::P3;
pub(crate) use p4::P4;
