//! What a tuning gives.

use std::io::{self, Write};

use cli::Answer;
use control::{Gains, LoopVerdict, Ultimate};
use serde::Serialize;

/// What was found.
#[derive(Serialize)]
pub(crate) struct Tuned {
    pub(crate) axis: usize,
    pub(crate) period_s: f64,
    pub(crate) slope: f64,
    pub(crate) ultimate: Option<Ultimate>,
    pub(crate) why_not: Option<String>,
    pub(crate) loops: Vec<TunedLoop>,
    /// The machine's answer to a command of 1 over one sample.
    #[serde(skip)]
    pub(crate) impulse: Vec<f64>,
}

impl Answer for Tuned {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "axis {}: {:.6} position per command", self.axis, self.slope)?;
        match (&self.ultimate, &self.why_not) {
            (Some(found), _) => writeln!(
                out,
                "ultimate gain {:.6} command per position, period {:.6} s, amplitude {:.4}",
                found.gain, found.period, found.amplitude
            )?,
            (None, Some(reason)) => writeln!(out, "no ultimate gain: {reason}")?,
            (None, None) => {}
        }
        for TunedLoop { name, gains, verdict } in &self.loops {
            writeln!(
                out,
                "{name}: kp {:.6} ki {:.6} kd {:.6} derivative_filter {:.3e}",
                gains.kp, gains.ki, gains.kd, gains.derivative_filter
            )?;
            if !verdict.stable {
                writeln!(out, "  unstable on the measured response")?;
                continue;
            }
            writeln!(
                out,
                "  gain margin {:.2}, phase margin {:.1}°, sensitivity {:.2}, disturbances are attenuated up to {:.3} Hz",
                verdict.gain_margin,
                verdict.phase_margin,
                verdict.sensitivity,
                verdict.rejection_bandwidth
            )?;
            let at: Vec<String> = verdict
                .disturbance
                .iter()
                .map(|(f, part)| format!("{:.4} at {f:.3} Hz", part))
                .collect();
            writeln!(out, "  disturbance sensitivity {}", at.join(", "))?;
        }
        Ok(())
    }
}

/// Gains, and what they do.
#[derive(Serialize)]
pub(crate) struct TunedLoop {
    pub(crate) name: &'static str,
    pub(crate) gains: Gains,
    pub(crate) verdict: LoopVerdict,
}
