//! What an inversion gives.

use std::io::{self, Write};
use std::path::PathBuf;

use cli::Answer;
use control::{Along, AxisResponses, Coordinator, CoupledFigures, DampingFigures, LoopFigures};
use serde::Serialize;

/// Error of a learned inverse, in parts of the range, from which it is pointed out.
const NOTED: f64 = 0.01;

#[derive(Serialize)]
pub(crate) struct Inverted {
    pub(crate) blueprint: PathBuf,
    pub(crate) period_s: f64,
    pub(crate) axes: Vec<LoopFigures>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) coordinators: Vec<Coordinator>,
    /// What the inverted does along the reference that was given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) along: Vec<Along>,
    /// What the page shows; empty without one.
    #[serde(skip)]
    pub(crate) responses: Vec<Shown>,
}

/// An axis on the page.
pub(crate) struct Shown {
    pub(crate) responses: AxisResponses,
    /// Units of command and position.
    pub(crate) units: [String; 2],
    /// The sensitivity that was allowed.
    pub(crate) allowed: f64,
}

/// What each way of feedforward does on a plant.
#[derive(Serialize)]
pub(crate) struct Ways {
    pub(crate) ways: Vec<DampingOption>,
}

#[derive(Serialize)]
pub(crate) struct DampingOption {
    pub(crate) name: &'static str,
    pub(crate) summary: &'static str,
    /// Of each axis; empty where the way does not suit.
    pub(crate) axes: Vec<LoopFigures>,
    /// Why it does not suit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) reason: Option<String>,
}

impl Answer for Inverted {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for axis in &self.axes {
            write_axis(axis, out)?;
        }
        for coordinator in &self.coordinators {
            writeln!(
                out,
                "{} ({}): coordinated through their Jacobian, condition number {:.3}{}{}",
                coordinator.axes.join(", "),
                coordinator.couplings.join(", "),
                coordinator.condition,
                if coordinator.note.is_empty() { "" } else { "; " },
                coordinator.note
            )?;
            if let Some(found) = &coordinator.preview {
                writeln!(
                    out,
                    "  dynamics undone by {} taps that know the reference ahead: the position follows {:.3} ms late; of a \
                     white reference {:.1} % are left, {:.1} % with the modes up to 2 % off",
                    found.taps,
                    1e3 * found.preview,
                    100.0 * found.left.0,
                    100.0 * found.left.1
                )?;
            }
            if let Some(found) = &coordinator.coupled_loop {
                write_coupled(found, out)?;
            }
        }
        for along in &self.along {
            write_along(along, out)?;
        }
        writeln!(out, "{}: written, sample time {} s", self.blueprint.display(), self.period_s)
    }
}

impl Answer for Ways {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for way in &self.ways {
            writeln!(out, "{}: {}", way.name, way.summary)?;
            if let Some(reason) = &way.reason {
                writeln!(out, "  does not suit: {reason}")?;
            }
            for axis in &way.axes {
                writeln!(out, "  axis {}: {}", axis.axis, axis.feedforward)?;
                write_checks(axis, out)?;
            }
        }
        Ok(())
    }
}

fn write_coupled(found: &CoupledFigures, out: &mut dyn Write) -> io::Result<()> {
    for [frequency, damping, depth] in &found.notches {
        writeln!(
            out,
            "  notch on all axes: {frequency:.2} Hz, damping {damping:.3}, depth {depth:.3}"
        )?;
    }
    let each: Vec<String> =
        found.integral_bandwidth.iter().map(|width| format!("{width:.2} Hz")).collect();
    writeln!(
        out,
        "  all axes together: greatest singular value of the sensitivity {:.3}, gain margin {:.2}, stable on {} \
         plants; integral control within the same sensitivity has bandwidths of {}",
        found.sensitivity,
        found.gain_margin,
        found.plants,
        each.join(", ")
    )
}

fn write_axis(axis: &LoopFigures, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "axis {}: {}", axis.axis, axis.shape)?;
    writeln!(out, "  feedforward: {}", axis.feedforward)?;
    writeln!(
        out,
        "  kp {:.6} ki {:.6} kd {:.6} (in command per position; ki also per second, kd times second)",
        axis.kp, axis.ki, axis.kd
    )?;
    writeln!(
        out,
        "  bandwidth {:.2} Hz, gain margin {:.2}, phase margin {:.1}°, sensitivity {:.2}, delay {:.3} ms, reachable positions {:.4} to {:.4}",
        axis.bandwidth,
        axis.gain_margin,
        axis.phase_margin,
        axis.sensitivity,
        1e3 * axis.delay,
        axis.reach.0,
        axis.reach.1
    )?;
    if let Some(damping) = &axis.damping {
        write_damping(damping, out)?;
    }
    write_checks(axis, out)?;
    for left in &axis.left_to_feedback {
        writeln!(out, "  note: {left}")?;
    }
    let Some(inverse) = &axis.inverse else { return Ok(()) };
    writeln!(
        out,
        "  inverse: {} support vectors, learned from {} waves of {:.4} to {:.4} Hz; on {} other waves the \
         position error is {:.3} % of the range, at most {:.2} %",
        inverse.centres,
        inverse.waves,
        inverse.band[0],
        inverse.band[1],
        inverse.judged,
        100.0 * inverse.error,
        100.0 * inverse.greatest
    )?;
    if inverse.error > NOTED {
        writeln!(
            out,
            "  note: that is more than {:.0} % of the range; try another --band, or a log with loops of \
             more sizes",
            100.0 * NOTED
        )?;
    }
    Ok(())
}

/// The inner loop, and what the whole loop is worth.
fn write_damping(damping: &DampingFigures, out: &mut dyn Write) -> io::Result<()> {
    let filter = damping.filter_damping.map_or_else(String::new, |d| format!(", damping {d:.3}"));
    writeln!(
        out,
        "  {}: gain {:.6} (command per position), {:.2} Hz{filter}; peak of the resonance {:.2} for {:.1}; noise from \
         sensor to command, as a position, {:.2}",
        damping.law,
        damping.gain,
        damping.frequency,
        damping.peak,
        damping.undamped_peak,
        damping.noise
    )?;
    writeln!(
        out,
        "  closed loop within 3 dB up to {:.1} Hz, {:.2} times the resonance of {:.1} Hz; up to {:.1} Hz at the worst of \
         {} plants (frequency 10 % off, damping halved and doubled, slopes of the hysteresis), all stable{}",
        damping.closed_loop_bandwidth,
        damping.closed_loop_bandwidth / damping.resonance,
        damping.resonance,
        damping.least_closed_loop_bandwidth,
        damping.plants,
        damping.bandwidth_with_feedforward.map_or_else(String::new, |width| format!(
            "; with the inverse feedforward up to {width:.1} Hz"
        ))
    )?;
    let notch = damping.notch_settling.map_or_else(String::new, |(given, longest)| {
        format!(
            "; PI with a notch and the same limits: {:.3} ms, {:.3} ms",
            1e3 * given,
            1e3 * longest
        )
    });
    writeln!(
        out,
        "  a step settles within 2 % in {:.3} ms at the mean slope, {:.3} ms at the worst one{notch}",
        1e3 * damping.settling,
        1e3 * damping.longest_settling
    )
}

/// What the controller does along the reference.
fn write_along(along: &Along, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "axis {} along the reference: rms error {:.4} % of its range, greatest {:.3} %",
        along.axis,
        100.0 * along.error,
        100.0 * along.greatest
    )?;
    let (Some(asked), Some(at)) = (along.asked, along.asked_at) else { return Ok(()) };
    let ends = [
        (asked.0, at.0, along.limits.0, asked.0 < along.limits.0),
        (asked.1, at.1, along.limits.1, asked.1 > along.limits.1),
    ];
    for (command, time, limit, is_beyond) in ends {
        if along.beyond > 0.0 && is_beyond {
            writeln!(
                out,
                "  this reference asks {} for {command:.4} at {time:.4} s, limit {limit}: beyond a limit for {:.2} % of \
                 the time, and there no controller follows",
                along.axis,
                100.0 * along.beyond
            )?;
        }
    }
    Ok(())
}

/// What the controller does on its own plant.
fn write_checks(axis: &LoopFigures, out: &mut dyn Write) -> io::Result<()> {
    for check in &axis.checks {
        let alone = check.feedforward.map_or_else(String::new, |error| {
            format!(", feedforward alone {:.4} %", 100.0 * error)
        });
        writeln!(
            out,
            "  on its own plant, {:.4} Hz over {:.0} % of the reach: rms error {:.4} % of it{alone}, feedback \
             alone {:.4} %",
            check.frequency,
            100.0 * check.swing,
            100.0 * check.closed_loop,
            100.0 * check.feedback
        )?;
    }
    Ok(())
}
