//! The signals of `bench tune`, and what their records say.

use bench::gateway::station::{self, Recorded, Station, Wave};
use control::{Line, NarrowMode, measured_response, multisine};
use serde::Serialize;

/// Periods of the triangle; the first is run-in.
const PERIODS: u32 = 3;
/// Most points of a triangle.
const POINTS: usize = 2000;
/// Multisines with other phases, periods of each (the first is run-in), and the highest line as a part of the rate.
const REALIZATIONS: u64 = 3;
const SINES: u32 = 2;
const HIGHEST: f64 = 0.45;
/// Points of the multisine: as many as are needed for lines this close, in Hz, at most these.
const CLOSE: f64 = 1.5;
const MOST: usize = 8192;
/// Servo cycles per point of the slow multisine, where one alone has its lines too far apart.
const SLOW: u32 = 8;

/// The plant around the middle, servo off.
pub(super) struct Response {
    /// Position per volt, continuous.
    pub(super) lines: Vec<Line>,
    /// Modes between the lines.
    pub(super) narrow: Vec<NarrowMode>,
    /// The record of the last multisine.
    pub(super) record: Recorded,
}

/// Signals for an axis.
#[derive(Clone, Debug)]
pub(super) struct Bed {
    pub(super) middle: f64,
    pub(super) amplitude: f64,
    cycle: f64,
    /// Points of the triangle, and servo cycles for each.
    points: usize,
    hold: u32,
    most: (usize, usize),
}

/// What a loop does.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Loop {
    /// Rms of target minus position over the triangle.
    pub(super) rms_error: f64,
    /// Beyond the step, as a part of it.
    pub(super) overshoot: f64,
    /// From 10 to 90 %; `null`: not within the record.
    pub(super) rise_time_s: Option<f64>,
    /// Until it stays within 2 %.
    pub(super) settling_time_s: Option<f64>,
}

impl Bed {
    pub(super) fn new(station: &dyn Station, middle: f64, amplitude: f64, frequency: f64) -> Self {
        let (cycle, most) = (station.cycle(), station.most());
        let cycles = (1.0 / (frequency * cycle)).round().max(8.0);
        let longest = POINTS.min(most.0).min(most.1 / PERIODS as usize);
        let hold = (cycles / longest as f64).ceil().max(1.0);
        let points = (cycles / hold).round() as usize;
        Bed { middle, amplitude, cycle, points, hold: hold as u32, most }
    }

    /// Of the triangle, in Hz.
    pub(super) fn frequency(&self) -> f64 {
        1.0 / (self.points as f64 * f64::from(self.hold) * self.cycle)
    }

    /// A triangle around 0 of amplitude 1, from its middle on.
    fn triangle(&self) -> Vec<f64> {
        let at = |k: usize| {
            let x = (k as f64 / self.points as f64 + 0.25).fract();
            1.0 - 4.0 * (x - 0.5).abs()
        };
        (0..self.points).map(at).collect()
    }

    /// Lines of the triangle: frequency in Hz, mean square.
    pub(super) fn reference(&self) -> Vec<(f64, f64)> {
        let odd = |n: usize| {
            let n = (2 * n + 1) as f64;
            let amplitude = self.amplitude * 8.0 / (core::f64::consts::PI * n).powi(2);
            (n * self.frequency(), 0.5 * amplitude * amplitude)
        };
        let below = 0.4 / self.cycle;
        (0..200).map(odd).take_while(|(f, _)| *f < below).collect()
    }

    /// Triangle and step in the loop, of this share of the amplitude; the record of the triangle.
    pub(super) fn measure(
        &self,
        station: &mut dyn Station,
        share: f64,
    ) -> Result<(Loop, Recorded), String> {
        let size = share * self.amplitude;
        let points = self.triangle().iter().map(|x| self.middle + size * x).collect();
        let mut wave = Wave::complete(true, points, self.hold, PERIODS);
        // Row by row of the servo, where there is room: the law is looked for in it.
        let all = wave.rows * self.hold as usize;
        if all <= self.most.1 {
            (wave.every, wave.rows) = (1, all);
        }
        let record = station::play(station, &wave)?;
        let run_in = record.position.len() / PERIODS as usize;
        let pairs = || record.command[run_in..].iter().zip(&record.position[run_in..]);
        let square = pairs().map(|(r, y)| (r - y).powi(2)).sum::<f64>();
        let rms_error = (square / pairs().count() as f64).sqrt();
        let step = self.step(station, size)?;
        let (overshoot, rise_time_s, settling_time_s) = figures(&step, size);
        Ok((Loop { rms_error, overshoot, rise_time_s, settling_time_s }, record))
    }

    /// A faster triangle in the loop, recorded in every servo cycle: the law is looked for in it.
    pub(super) fn every_cycle(&self, station: &mut dyn Station) -> Result<Recorded, String> {
        let points = self.points.min(1000);
        let at = |k: usize| {
            let x = (k as f64 / points as f64 + 0.25).fract();
            self.middle + self.amplitude * (1.0 - 4.0 * (x - 0.5).abs())
        };
        let wave = Wave::complete(true, (0..points).map(at).collect(), 1, PERIODS);
        station::play(station, &wave)
    }

    /// A step from the middle up by `size`.
    fn step(&self, station: &mut dyn Station, size: f64) -> Result<Recorded, String> {
        let points = self.points.clamp(16, 1000);
        let before = points / 8;
        let at = |k: usize| if k < before { self.middle } else { self.middle + size };
        let wave = Wave::complete(true, (0..points).map(at).collect(), self.hold, 1);
        station::play(station, &wave)
    }

    /// The response of the plant around the middle, servo off.
    pub(super) fn response(&self, station: &mut dyn Station) -> Result<Response, String> {
        // The voltage of the middle, and how far the amplitude is in volts.
        let mut volts = [0.0; 3];
        let far = 0.5 * self.amplitude;
        for (volt, target) in volts.iter_mut().zip([-far, far, 0.0]) {
            station::lead(station, true, self.middle + target)?;
            station::settled(station, 1e-3 * self.amplitude)?;
            *volt = station.place()?.voltage;
        }
        let size = 0.5 * (volts[1] - volts[0]).abs();
        if size.is_nan() || size <= 0.0 {
            return Err(format!(
                "the voltage is {volts:?} V for three targets: the axis does not move"
            ));
        }
        station::lead(station, false, volts[2])?;
        let needed = (1.0 / (CLOSE * self.cycle)) as usize;
        let most = MOST.min(self.most.0).min(self.most.1 / SINES as usize);
        let points = needed.next_power_of_two().clamp(64, most);
        let slow = needed > 2 * points;
        let mut found = Response { lines: vec![], narrow: vec![], record: Recorded::default() };
        for hold in if slow { vec![1, SLOW] } else { vec![1] } {
            let count = (HIGHEST * points as f64) as usize;
            let sample = f64::from(hold) * self.cycle;
            let mut records = Vec::new();
            for realization in 0..REALIZATIONS {
                let sine = multisine(points, count, realization);
                let wave = Wave::complete(
                    false,
                    sine.iter().map(|x| volts[2] + size * x).collect(),
                    hold,
                    SINES,
                );
                records.push(station::play(station, &wave)?);
            }
            let signals: Vec<[&[f64]; 2]> =
                records.iter().map(|record| [&record.voltage[..], &record.position]).collect();
            let (lines, narrow) = measured_response(&signals, points, count, sample);
            // The slow one knows the lower frequencies better.
            let below = if hold > 1 {
                0.7 * count as f64 / (points as f64 * sample)
            } else {
                f64::INFINITY
            };
            found.lines.retain(|(f, _)| *f > below);
            found.lines.extend(lines.into_iter().filter(|(f, _)| *f <= below));
            found.narrow.retain(|mode| mode.frequency_hz > below);
            found.narrow.extend(narrow.into_iter().filter(|mode| mode.frequency_hz <= below));
            found.record = records.pop().unwrap_or_default();
        }
        found.lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(found)
    }
}

/// Overshoot, rise time and settling time of a step up by `size`.
fn figures(step: &Recorded, size: f64) -> (f64, Option<f64>, Option<f64>) {
    let before = step.position.len() / 8;
    let start = step.position[..before.max(1)].iter().sum::<f64>() / before.max(1) as f64;
    let share: Vec<f64> = step.position[before..].iter().map(|y| (y - start) / size).collect();
    let greatest = share.iter().fold(0.0_f64, |most, y| most.max(*y));
    let passes = |level: f64| share.iter().position(|y| *y >= level);
    let rise = passes(0.1).zip(passes(0.9)).map(|(a, b)| (b - a) as f64 * step.period);
    let last = share.iter().rposition(|y| (y - 1.0).abs() > 0.02).map_or(0, |k| k + 1);
    let settled = (last < share.len()).then_some(last as f64 * step.period);
    (greatest - 1.0, rise, settled)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_a_first_order_step_are_known() {
        let (period, lag) = (1e-3, 20e-3);
        let position = |k: usize| match k.checked_sub(100) {
            Some(k) => 5.0 + 2.0 * (1.0 - (-(k as f64) * period / lag).exp()),
            None => 5.0,
        };
        let step =
            Recorded { period, position: (0..800).map(position).collect(), ..Recorded::default() };
        let (overshoot, rise, settled) = figures(&step, 2.0);
        assert!(overshoot <= 0.0);
        assert!((rise.unwrap() / (lag * 9f64.ln()) - 1.0).abs() < 0.05, "{rise:?}");
        assert!((settled.unwrap() / (lag * 50f64.ln()) - 1.0).abs() < 0.05, "{settled:?}");
        assert_eq!(figures(&step, 4.0).2, None, "never there");
    }
}
