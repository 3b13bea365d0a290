//! Warmth of an actuator from the power of its drive.

use libm::expm1;
use serde::{Deserialize, Serialize};

use crate::block::Wires;

/// What warms an actuator, over its mean in the log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "of", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Loss {
    /// The square of the drive's rate.
    Rate {
        /// Its mean.
        mean: f64,
    },
    /// The rate times the drive, voltage times current.
    Apparent {
        /// Its mean.
        mean: f64,
    },
    /// The rate times the distance from the centre.
    Loops {
        /// Its mean.
        mean: f64,
        /// The centre.
        centre: f64,
    },
}

impl Loss {
    /// The power at a drive with this rate, over its mean.
    fn power(self, drive: f64, rate: f64) -> f64 {
        match self {
            Self::Rate { mean } => rate * rate / mean,
            Self::Apparent { mean } => (rate * drive).abs() / mean,
            Self::Loops { mean, centre } => (rate * (drive - centre)).abs() / mean,
        }
    }

    /// The warmth after a step: `τ T′ = P/mean − T`; the state is T and the drive before.
    pub(crate) fn warmth(self, time: f64, drive: f64, dt: f64, z: &mut [f64]) -> f64 {
        let [warmth, before, ..] = z else { return 0.0 };
        if dt > 0.0 {
            let rate = (drive - *before) / dt;
            *before = drive;
            let power = self.power(drive, rate);
            *warmth += -expm1(-dt / time) * (power - *warmth);
        }
        *warmth
    }
}

/// Several warmths, each with its growth; the last parameter is a gain that goes with their mean.
pub(crate) fn warming(
    half: f64,
    loss: Loss,
    times: &[f64],
    p: &[f64],
    w: Wires,
    dt: f64,
    z: &mut [f64],
) -> f64 {
    let (Some((gain, growths)), Some((warmth, [before, rest]))) =
        (p.split_last(), z.split_last_chunk_mut::<2>())
    else {
        return w.x;
    };
    let power = if dt > 0.0 { loss.power(w.drive, (w.drive - *before) / dt) } else { 0.0 };
    *before = w.drive;
    let (mut grown, mut mean) = (0.0, 0.0);
    for ((z, time), growth) in warmth.iter_mut().zip(times).zip(growths) {
        *z += -expm1(-dt / time) * (power - *z);
        grown += growth * *z;
        mean += *z / times.len() as f64;
    }
    w.x + half * grown + gain * mean * (w.x - *rest)
}
