//! Blocks of a signal path, from first principles.
//!
//! A block maps a signal that is held over each period to a signal read at the period's end. The
//! sizes of all of them are in volts, micrometres and seconds.

mod amplifier;
mod elongation;
mod hysteresis;
mod linear;
mod mechanics;
mod reading;
mod stray;
mod timing;

pub(crate) use amplifier::{Clamp, SlewLimit};
pub(crate) use elongation::{LogCreep, Relaxations, SelfHeating, StaticMap};
pub(crate) use hysteresis::{BoucWen, Branch, GeneralisedPlay, Plays, PlaysLaw};
pub(crate) use linear::{Lags, Mode};
pub(crate) use mechanics::{Backlash, ExtraMode, Force, NonlinearMode, Periodic};
pub(crate) use reading::{
    Coupling, Drift, FeedThrough, Gain, GainOverTime, Hum, Quantiser, Walk, White,
};
pub(crate) use stray::{AcCoupling, GainModulation, Glitches, HeldSamples, Telegraph, Vibration};
pub(crate) use timing::{Delay, VaryingDelay};

/// What is known in a period beside the path's own signal.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tick {
    /// Time in s at which the period ends.
    pub(crate) time: f64,
    /// The command of this axis over the period.
    pub(crate) command: f64,
    /// The command of the neighbouring axis over the period.
    pub(crate) neighbour: f64,
}

/// One element of a signal path.
pub(crate) trait Block: Send {
    /// At rest under an input that was always there; the state becomes that of rest.
    fn rest(&mut self, input: f64, tick: &Tick) -> f64;
    /// One period later.
    fn step(&mut self, input: f64, tick: &Tick) -> f64;
}

/// Places on the signal path, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Slot {
    /// Between the recorded command and the amplifier.
    Timing,
    /// Between amplifier and hysteresis: a voltage.
    Voltage,
    /// Behind the hysteresis: a free elongation.
    Elongation,
    /// Behind the mechanics: a position.
    Position,
    /// Behind the sensor: a reading.
    Reading,
}
