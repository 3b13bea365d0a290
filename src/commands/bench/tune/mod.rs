//! `piezoloop bench tune`: better servo values for an instrument, from its own wave generator and data recorder.

mod experiment;
mod trial;

use std::io::{self, BufRead as _, IsTerminal as _, Write};
use std::path::PathBuf;
use std::time::Instant;

use anyhow::bail;
use bench::gateway::station::{self, Law, NotchValues, Station};
use bench::gateway::{self, Address};
use clap::Args;
use cli::{Answer, Screen, rounded};
use control::{NarrowMode, ServoLaw, ServoLimits, ServoPlant, ServoVerdict, law_in_record};
use data::UnitPlace;
use serde::Serialize;

use self::experiment::{Bed, Loop, Response};
use self::trial::{CALMER, come_to_rest, is_wild, with_part};
use super::measure::log_of;
use crate::{inputs, ranges};

/// Share of the voltage's changes that the law must explain, so that its values mean what they shall.
const EXPLAINED: f64 = 0.9;
/// Part to which the gains are lowered if the loop as it is oscillates.
const LOWERED: f64 = 0.01;

/// Proposes better PID and notch values for the servo of an instrument, and writes them on confirmation
///
/// The instrument plays and records: a triangle and a step in its loop as it is, then, with the servo off, a multisine
/// around the middle of the travel. The frequency response of the plant and the law that is found in the record give
/// the values with the least error for the triangle under a bound on the sensitivity. With --write they are
/// written after a question (--yes: without), tried with a tenth of the triangle first, and measured again. If the error is
/// not smaller, or if the step overshoots too far even with an eighth of the gains, and so with values for a tenth of
/// --noise, the old values are restored and the exit code is 1. With --write --yes also a loop that oscillates is measured:
/// with lower gains. Values are written until the next power-up only.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop bench tune gcs://10.0.0.5\n  piezoloop bench tune 'gcs:///dev/ttyUSB0?axes=2' --frequency 10 --amplitude 5 --write\n  piezoloop bench tune nv200://10.0.0.6 --write --yes"
)]
pub(crate) struct Tune {
    #[arg(value_name = "ADDRESS", value_parser = super::address, help = super::instrument_help())]
    gateway: Address,
    /// Frequency of the triangle in Hz [default: 5, or what the wave generator reaches]
    #[arg(long, value_name = "HZ", default_value_t = 5.0, value_parser = ranges::from(0.01, 10_000.0))]
    frequency: f64,
    /// Amplitude of the triangle, in the unit of the axis [default: a tenth of the travel]
    #[arg(long, value_name = "POSITION", value_parser = ranges::above(0.0, 1e15))]
    amplitude: Option<f64>,
    /// Middle of all signals, in the unit of the axis [default: the middle of the travel]
    #[arg(long, value_name = "POSITION", value_parser = ranges::signal())]
    middle: Option<f64>,
    /// Largest allowed sensitivity |1/(1+L)| of the loop
    #[arg(long, value_name = "M", default_value_t = 1.5, value_parser = ranges::above(1.0, 100.0))]
    sensitivity: f64,
    /// Largest allowed amplification of sensor noise by the law (its output, converted to position, relative to the
    /// sensor noise)
    #[arg(long, value_name = "RATIO", default_value_t = 10.0, value_parser = ranges::above(0.0, 1e9))]
    noise: f64,
    /// Largest allowed overshoot of the measured step, as a part of it; what the old values overshoot is allowed, too
    #[arg(long, value_name = "PART", default_value_t = 0.5, value_parser = ranges::from(0.0, 100.0))]
    overshoot: f64,
    /// Write the values to the instrument, after a question
    #[arg(long)]
    write: bool,
    /// Answer the question with yes
    #[arg(long, requires = "write")]
    yes: bool,
    /// Also write the record of the multisine to this log (CSV), for `frequency-response` and `identify`
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Unit of the axis
    #[arg(long, value_name = "UNIT", default_value = "um")]
    position_unit: String,
}

/// What was found.
#[derive(Serialize)]
struct Tuned {
    instrument: String,
    servo_cycle_s: f64,
    unit: String,
    middle: f64,
    amplitude: f64,
    frequency_hz: f64,
    /// Position per voltage at rest.
    gain: f64,
    resonances_hz: Vec<f64>,
    /// Modes so light that they fall between the lines of the multisine.
    narrow_modes: Vec<NarrowMode>,
    /// Voltage per output of the law, and the share of the voltage's changes that the law explains.
    law_scale: f64,
    law_explained: f64,
    /// Part of the gains with which the plant was measured, because the loop as it is oscillates; `null`: it does not.
    gains_lowered_to: Option<f64>,
    before: Measured,
    proposed: Law,
    predicted: ServoVerdict,
    /// `null`: not written.
    after: Option<Measured>,
    restored: bool,
    /// Why the old values were restored.
    refused: Option<String>,
    seconds: f64,
}

/// A loop as it was measured.
#[derive(Clone, Serialize)]
struct Measured {
    law: Law,
    #[serde(flatten)]
    found: Loop,
}

/// What was measured before anything is proposed.
struct Seen {
    before: Measured,
    lowered: Option<f64>,
    plant: ServoPlant,
    narrow: Vec<NarrowMode>,
    scale: f64,
    explained: f64,
    gain: f64,
}

impl Tune {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let begin = Instant::now();
        if let Some(log) = &self.log {
            cli::can_write_as(log, inputs::CSV)?;
        }
        if self.write && !self.yes && !io::stdin().is_terminal() {
            bail!("--write: asks before it writes, and nobody can answer here; give --yes too");
        }
        let mut station = gateway::open_station(&self.gateway)?;
        let bed = self.bed(&*station)?;
        let cycle = station.cycle();
        let origin = station.place().map_err(anyhow::Error::msg)?;
        let measured = self.measure(&mut *station, &bed, screen);
        // Where it was, whatever came.
        let back = if origin.closed { origin.target } else { origin.voltage };
        let returned = station::lead(&mut *station, origin.closed, back);
        let Seen { before, lowered, plant, narrow, scale, explained, gain } = measured?;
        returned.map_err(anyhow::Error::msg)?;
        let Some((law, predicted)) = self.design(&*station, &bed, &plant, self.noise) else {
            bail!(
                "no values keep the sensitivity below {}: the plant does not answer steadily (its response at the lowest line is {:.3e}); give a larger --amplitude, or --sensitivity 2",
                self.sensitivity,
                gain
            );
        };
        let mut answer = Tuned {
            instrument: station.describe(),
            servo_cycle_s: cycle,
            unit: self.position_unit.clone(),
            middle: bed.middle,
            amplitude: bed.amplitude,
            frequency_hz: bed.frequency(),
            gain,
            resonances_hz: plant.resonances().into_iter().take(3).collect(),
            narrow_modes: narrow,
            law_scale: scale,
            law_explained: explained,
            gains_lowered_to: lowered,
            before,
            proposed: values(&law),
            predicted,
            after: None,
            restored: false,
            refused: None,
            seconds: 0.0,
        };
        if self.write && self.agrees(screen, &answer)? {
            let mut tried = self.try_law(&mut *station, &bed, &answer, false);
            if tried.as_ref().is_ok_and(is_wild)
                && let Some((law, found)) =
                    self.design(&*station, &bed, &plant, CALMER * self.noise)
            {
                screen.say("a proposal that answers a step less abruptly");
                (answer.proposed, answer.predicted) = (values(&law), found);
                if self.agrees(screen, &answer)? {
                    tried = self.try_law(&mut *station, &bed, &answer, true);
                }
            }
            let returned = station::lead(&mut *station, origin.closed, back);
            let (after, refusal) = tried?;
            answer.restored = refusal.is_some();
            (answer.after, answer.refused) = (after, refusal.map(|refusal| refusal.why));
            returned.map_err(anyhow::Error::msg)?;
        }
        answer.seconds = begin.elapsed().as_secs_f64();
        screen.show(&answer)
    }

    /// The law with the least error under the limits, and what it shall do; none: none keeps them.
    fn design(
        &self,
        station: &dyn Station,
        bed: &Bed,
        plant: &ServoPlant,
        noise: f64,
    ) -> Option<(ServoLaw, ServoVerdict)> {
        let limits = ServoLimits { sensitivity: self.sensitivity, noise };
        let filters = |frequency: f64| {
            let (count, all) = station.notches(frequency);
            (count, all.iter().map(|n| [n.frequency, n.zeros, n.poles]).collect())
        };
        plant.design(&bed.reference(), limits, filters)
    }

    fn bed(&self, station: &dyn Station) -> anyhow::Result<Bed> {
        let [least, greatest] = station.travel();
        let middle = self.middle.unwrap_or(0.5 * (least + greatest));
        let amplitude = self.amplitude.unwrap_or(0.1 * (greatest - least));
        if middle - amplitude < least || middle + amplitude > greatest {
            bail!(
                "--middle {middle} --amplitude {amplitude}: leaves the travel from {least} to {greatest}; give smaller ones"
            );
        }
        Ok(Bed::new(station, middle, amplitude, self.frequency))
    }

    /// The loop as it is, and the plant as its law sees it. The law is afterwards what it was.
    fn measure(
        &self,
        station: &mut dyn Station,
        bed: &Bed,
        screen: &Screen,
    ) -> anyhow::Result<Seen> {
        let law = station.law().map_err(anyhow::Error::msg)?;
        screen.say(&format!("{}: the loop as it is", station.describe()));
        let (found, mut scale, mut explained) = loop_as_it_is(station, bed, &law)?;
        let before = Measured { law: law.clone(), found };
        let mut lowered = None;
        let seen = (|| {
            if self.yes && !is_explained(scale, explained) {
                let percent = 100.0 * LOWERED;
                screen.say(&format!("the loop oscillates: again with {percent} % of its gains"));
                let slower = with_part(&law, LOWERED);
                lowered = Some(LOWERED);
                station.set_law(&slower).map_err(anyhow::Error::msg)?;
                come_to_rest(station, bed).map_err(anyhow::Error::msg)?;
                (_, scale, explained) = loop_as_it_is(station, bed, &slower)?;
            }
            if !is_explained(scale, explained) {
                let way_out = if self.yes {
                    "give a smaller --amplitude"
                } else {
                    "give a smaller --amplitude, or --write --yes, which lower the gains for the measurement"
                };
                bail!(
                    "the voltage does not follow the law that is read back (kp {}, ki {}/s, kd {} s explain {:.0} % of its changes): another control mode is on, the loop is unstable, or the axis is at the end of its voltages: {way_out}",
                    law.kp,
                    law.ki,
                    law.kd,
                    100.0 * explained.max(0.0)
                );
            }
            screen.say("the plant, servo off");
            bed.response(station).map_err(anyhow::Error::msg)
        })();
        if lowered.is_some() {
            station
                .set_law(&law)
                .map_err(|error| anyhow::anyhow!("the old values cannot be restored: {error}"))?;
        }
        let Response { lines, narrow, record } = seen?;
        if let Some(file) = &self.log {
            log_of(&record, station.number(), false, &self.position_unit, file)?
                .write(file, UnitPlace::Sidecar)?;
        }
        let gain = lines.first().map_or(0.0, |(_, g)| g.norm() * g.re.signum());
        let plant = ServoPlant::new(&lines, &narrow, scale, station.cycle());
        Ok(Seen { before, lowered, plant, narrow, scale, explained, gain })
    }

    fn agrees(&self, screen: &Screen, answer: &Tuned) -> anyhow::Result<bool> {
        if self.yes {
            return Ok(true);
        }
        screen.say(&format!(
            "write {} to the instrument, until its next power-up? [y/N]",
            text_of(&answer.proposed)
        ));
        let mut line = String::new();
        io::stdin().lock().read_line(&mut line)?;
        Ok(matches!(line.trim(), "y" | "Y" | "yes"))
    }
}

/// What the loop does with a law: its figures, voltage per output of the law, and the explained share.
fn loop_as_it_is(
    station: &mut dyn Station,
    bed: &Bed,
    law: &Law,
) -> anyhow::Result<(Loop, f64, f64)> {
    let (found, mut record) = bed.measure(station, 1.0).map_err(anyhow::Error::msg)?;
    if record.period > 1.5 * station.cycle() {
        record = bed.every_cycle(station).map_err(anyhow::Error::msg)?;
    }
    let error: Vec<f64> = record.command.iter().zip(&record.position).map(|(r, y)| r - y).collect();
    let signals = [&error[..], &record.voltage];
    let (scale, explained) = law_in_record(&filters_of(law), signals, station.cycle());
    // An error beyond the whole triangle is that of a loop that oscillates.
    let is_steady = found.rms_error < bed.amplitude;
    Ok((found, scale, if is_steady { explained } else { 0.0 }))
}

fn is_explained(scale: f64, explained: f64) -> bool {
    explained >= EXPLAINED && scale != 0.0
}

fn values(law: &ServoLaw) -> Law {
    let notch = |[frequency, zeros, poles]: &[f64; 3]| NotchValues {
        frequency: *frequency,
        zeros: *zeros,
        poles: *poles,
    };
    Law { kp: law.kp, ki: law.ki, kd: law.kd, notches: law.notches.iter().map(notch).collect() }
}

fn filters_of(law: &Law) -> ServoLaw {
    let notches = law.notches.iter().map(|n| [n.frequency, n.zeros, n.poles]).collect();
    ServoLaw { kp: law.kp, ki: law.ki, kd: law.kd, notches }
}

fn text_of(law: &Law) -> String {
    let notches: Vec<String> = law
        .notches
        .iter()
        .map(|n| format!(", notch {:.1} Hz ({:.3}/{:.3})", n.frequency, n.zeros, n.poles))
        .collect();
    format!("kp {:.5}, ki {:.4}/s, kd {:.3e} s{}", law.kp, law.ki, law.kd, notches.concat())
}

impl Measured {
    fn write(&self, out: &mut dyn Write, unit: &str) -> io::Result<()> {
        let Loop { rms_error, overshoot, rise_time_s, settling_time_s } = &self.found;
        let time = |time: &Option<f64>| match time {
            Some(time) => format!("{:.2} ms", 1e3 * time),
            None => "not within the record".to_owned(),
        };
        writeln!(
            out,
            "  rms error {rms_error:.5} {unit}; step: rise {}, overshoot {:.0} %, settled to 2 % after {}",
            time(rise_time_s),
            100.0 * overshoot,
            time(settling_time_s)
        )
    }
}

impl Answer for Tuned {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "{}; triangle of {:.3} Hz, {} ± {} {}",
            self.instrument,
            self.frequency_hz,
            rounded(self.middle),
            rounded(self.amplitude),
            self.unit
        )?;
        let peaks: Vec<String> = self.resonances_hz.iter().map(|f| format!("{f:.1} Hz")).collect();
        let peaks = if peaks.is_empty() { "none".to_owned() } else { peaks.join(", ") };
        writeln!(out, "plant: {:.5} {} per V, resonances: {peaks}", self.gain, self.unit)?;
        for NarrowMode { frequency_hz, damping } in &self.narrow_modes {
            writeln!(
                out,
                "  light mode between the lines: {frequency_hz:.2} Hz, damping {damping:.2e}"
            )?;
        }
        writeln!(out, "before: {}", text_of(&self.before.law))?;
        self.before.write(out, &self.unit)?;
        if let Some(part) = self.gains_lowered_to {
            let percent = 100.0 * part;
            writeln!(out, "  it oscillates: the plant was measured with {percent} % of its gains")?;
        }
        writeln!(out, "proposed: {}", text_of(&self.proposed))?;
        let found = &self.predicted;
        writeln!(
            out,
            "  sensitivity {:.2}, gain margin {:.2}, phase margin {:.1}°, bandwidth {:.1} Hz, predicted rms error {:.5} {}",
            found.sensitivity,
            found.gain_margin,
            found.phase_margin,
            found.bandwidth,
            found.rms_error,
            self.unit
        )?;
        match &self.after {
            Some(after) => {
                writeln!(out, "after: {}", text_of(&after.law))?;
                after.write(out, &self.unit)?;
                let ratio = self.before.found.rms_error / after.found.rms_error;
                writeln!(out, "  the error is {ratio:.1} times smaller")?;
            }
            None if self.restored => {}
            None => writeln!(
                out,
                "not written; --write does, and measures whether its step overshoots"
            )?,
        }
        if let Some(why) = &self.refused {
            writeln!(out, "{why}; the old values are restored")?;
        }
        writeln!(out, "{:.0} s", self.seconds)
    }

    fn exit_code(&self) -> u8 {
        u8::from(self.restored)
    }
}
