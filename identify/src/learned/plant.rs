//! A plant that is learned from records: an LS-SVM over stop operators, and the linear part behind it.
//!
//! ```text
//! y = D·H(u, stops of u),   stops as in P1, D a discrete transfer function
//! ```
//!
//! Widths and γ by the evidence, H and D in turn ([`Series`]); then H is projected on the fewest centres
//! that err hardly more. Offsets of records are those of the static model.

use data::ComponentBlueprint;
use data::Value;
use learned::features::{Features, Stops};
use model::Table;

use super::series::rows;
use super::{Arx, Frame, Machine, Recipe, Run, Series, Span, Turns, weigh_samples};
use crate::error::Error;
use crate::fit::response::LinearPart;
use crate::observer::Observer;
use crate::record::{Record, Rows};

/// Its name on the command line.
pub(crate) const NAME: &str = "lssvm-stops";
/// One sentence.
pub(crate) const SUMMARY: &str =
    "LS-SVM over stop operators, and a linear part: learned, of any shape";

/// Most samples that H is trained on.
const SAMPLES: usize = 1500;
/// Most centres that stay, and the part of the error that this may add.
const CENTRES: (usize, f64) = (400, 0.02);
/// Where the search for widths begins, as parts of the command's range: stops, command; γ.
const START: ([f64; 2], f64) = ([10.0, 0.3], 1e4);
/// Evaluations of that search, and most samples it looks at.
const SEARCH: (usize, usize) = (60, 700);
const ROUNDS: usize = 60;
/// Zeros and poles of D.
const ORDERS: [(usize, usize); 2] = [(2, 2), (3, 3)];
/// Its stages, for the observer.
const STAGES: usize = 3;

/// What is learned from.
pub(crate) struct Lesson<'a> {
    pub(crate) records: &'a [Record],
    pub(crate) fitted: &'a [Rows],
    /// Of each record, in position.
    pub(crate) offsets: &'a [f64],
    /// Of the records, in s.
    pub(crate) period: f64,
    /// What the other methods found; whole periods of its delay stay in front, its lag and mode are where D
    /// begins.
    pub(crate) known: LinearPart,
    pub(crate) stops: usize,
    /// Whether there is a linear part behind.
    pub(crate) dynamic: bool,
}

/// The components of a learned plant, and the table of the first.
pub(crate) struct Learned {
    pub(crate) chain: Vec<ComponentBlueprint>,
    pub(crate) table: Table,
    /// Numbers that were learned.
    pub(crate) numbers: usize,
}

impl Lesson<'_> {
    /// Learns the plant, whose table is that of the file `name`.
    ///
    /// # Errors
    /// [`Error::Learned`] where the training has no exact solution; [`Error::Stopped`].
    pub(crate) fn learn(&self, name: &str, observer: &mut dyn Observer) -> Result<Learned, Error> {
        let mut stage = |done: usize| {
            observer.progress("LS-SVM over stop operators", done, STAGES);
            if observer.stopped() { Err(Error::Stopped) } else { Ok(()) }
        };
        stage(0)?;
        let middle = self.offsets.iter().sum::<f64>() / self.offsets.len().max(1) as f64;
        let commands: Vec<Vec<f64>> =
            self.records.iter().zip(self.fitted).map(|(r, rows)| self.command(r, rows)).collect();
        let positions: Vec<Vec<f64>> = (self.records.iter().zip(self.fitted))
            .zip(self.offsets)
            .map(|((record, rows), offset)| {
                record.output()[..rows.end].iter().map(|y| y - (offset - middle)).collect()
            })
            .collect();
        let runs: Vec<Run<'_>> = (commands.iter().zip(&positions))
            .zip(self.fitted)
            .map(|((command, position), rows)| Run {
                command,
                position,
                start: position.first().copied().unwrap_or(0.0),
                first: rows.first,
            })
            .collect();
        let pairs: Vec<(&[f64], &[f64])> = runs.iter().map(|r| (r.command, r.position)).collect();
        let all = |signals: &[Vec<f64>]| Span::of(&signals.concat());
        let stops = Stops { count: self.stops, range: 1.0, period: self.period, rate_scale: 1e12 };
        let (command, position) = (all(&commands), all(&positions));
        let frame = Frame::new(Features::Stops(stops), command, position, Recipe::Plain, &pairs);
        let fail = |error: learned::Error| Error::Learned { message: error.to_string() };
        let samples = frame.samples(&pairs).map_err(fail)?.subset(&rows(&runs, usize::MAX));
        let group = |input: usize| usize::from(input >= self.stops);
        let found = weigh_samples(&frame, &samples, &group, (&START.0, START.1), SEARCH);
        stage(1)?;
        let none = Arx { b: vec![1.0], a: Vec::new() };
        let orders = if self.dynamic { &ORDERS[..] } else { &[] };
        let first = if self.dynamic { sampled(&self.known, self.period) } else { none.clone() };
        let turns = Turns { rounds: if self.dynamic { ROUNDS } else { 1 }, most: SAMPLES };
        let series = Series::train(&found.frame, found.settings, &runs, (&first, orders), turns);
        let series = series.map_err(fail)?;
        let error = series.error(&runs);
        let Series { machine, linear } = series;
        stage(2)?;
        let simulated: Vec<Vec<f64>> =
            runs.iter().map(|run| machine.simulate(run.command, run.start)).collect();
        let own: Vec<(&[f64], &[f64])> =
            commands.iter().zip(&simulated).map(|(u, h)| (&u[..], &h[..])).collect();
        let machine = machine.compress(&own, CENTRES.0, CENTRES.1 * error).unwrap_or(machine);
        let table = machine.table().map_err(|message| Error::Learned { message })?;
        let mut chain = vec![self.component(&machine, stops, name)];
        if linear != none {
            chain.push(
                ComponentBlueprint::new("arx")
                    .value("sample_time", self.period)
                    .value("b", &linear.b[..])
                    .value("a", &linear.a[..]),
            );
        }
        let of_d = if linear == none { 0 } else { linear.b.len() + linear.a.len() };
        Ok(Learned { chain, numbers: table.values().len() + of_d, table })
    }

    /// Whole periods of delay in front of the hysteresis.
    pub(crate) fn late(&self) -> usize {
        (self.known.delay / self.period + 1e-6) as usize
    }

    /// What the hysteresis is under at each row: at rest, then the command of the row before, late.
    fn command(&self, record: &Record, rows: &Rows) -> Vec<f64> {
        let before = 1 + self.late();
        let rest = std::iter::repeat_n(record.rest(), before);
        rest.chain(record.input().iter().copied()).take(rows.end).collect()
    }

    fn component(&self, machine: &Machine, stops: Stops, table: &str) -> ComponentBlueprint {
        let Frame { command, output, .. } = machine.frame;
        ComponentBlueprint::new(NAME)
            .value("table", Value::Text(table.to_owned()))
            .value("sample_time", self.period)
            .value("stops", stops.count as f64)
            .value("range", stops.range)
            .value("rate_scale", stops.rate_scale)
            .value("command_low", command.low)
            .value("command_high", command.high)
            .value("position_low", output.low)
            .value("position_high", output.high)
    }
}

/// Lag and mode under commands that are held over a sample, each sampled exactly by itself.
fn sampled(linear: &LinearPart, period: f64) -> Arx {
    let mut all = Arx { b: vec![1.0], a: Vec::new() };
    if let Some(bandwidth) = linear.bandwidth {
        let keep = (-std::f64::consts::TAU * bandwidth * period).exp();
        all = all.then(&Arx { b: vec![1.0 - keep], a: vec![-keep] });
    }
    if let Some(mode) = linear.mode.filter(|mode| mode.damping < 1.0) {
        let omega = std::f64::consts::TAU * mode.frequency;
        let (decay, turn) = (mode.damping * omega, omega * (1.0 - mode.damping.powi(2)).sqrt());
        let e = (-decay * period).exp();
        let (s, c) = (turn * period).sin_cos();
        let ring = decay / turn * s;
        let b = vec![1.0 - e * (c + ring), e * (e + ring - c)];
        all = all.then(&Arx { b, a: vec![-2.0 * e * c, e * e] });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::response::ModeShape;

    #[test]
    fn lag_and_mode_are_sampled_exactly_under_a_held_step() {
        let period = 1e-3;
        let mode = ModeShape { frequency: 60.0, damping: 0.1 };
        let step = vec![1.0; 40];
        let of = |bandwidth: Option<f64>, mode: Option<ModeShape>| {
            let input = [&[0.0][..], &step].concat();
            sampled(&LinearPart { delay: 0.0, bandwidth, mode }, period).simulate(&input, 0.0)
        };
        let (lag, ringing, both) =
            (of(Some(30.0), None), of(None, Some(mode)), of(Some(30.0), Some(mode)));
        let omega = std::f64::consts::TAU * 60.0;
        let (decay, turn) = (0.1 * omega, omega * 0.99_f64.sqrt());
        for k in 1..40 {
            let t = k as f64 * period;
            assert!((lag[k] - (1.0 - (-std::f64::consts::TAU * 30.0 * t).exp())).abs() < 1e-12);
            let truth =
                1.0 - (-decay * t).exp() * ((turn * t).cos() + decay / turn * (turn * t).sin());
            assert!((ringing[k] - truth).abs() < 1e-12, "{k}");
        }
        let last = Arx {
            b: vec![1.0 - (-std::f64::consts::TAU * 0.03).exp()],
            a: vec![-(-std::f64::consts::TAU * 0.03).exp()],
        };
        for (a, b) in last.simulate(&ringing, 0.0).iter().zip(&both) {
            assert!((a - b).abs() < 1e-12, "one behind the other");
        }
    }
}
