//! A machine drawn at random, its effects brought to size, and its records.

use std::f64::consts::{PI, TAU};

use crate::baseline::{Baseline, COMMAND_SPAN, blueprint};
use crate::effect::{Effect, Formula, Insertion};
use crate::machine::{Drive, Machine};
use crate::random::Random;
use crate::records::{Kind, neighbour, noise};
use crate::size::{Unreachable, magnitude};
use crate::tune::{Tuner, spread};

/// Noise of the reading over full scale.
const NOISE: f64 = 1e-3;
/// Crossover of a closed loop in Hz.
const CROSSOVER: f64 = 6.0;

/// An effect that a machine shall have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Which.
    pub effect: Effect,
    /// The wish's formula.
    pub formula: Formula,
    /// Root mean square of what it changes after the re-tune, over the noise.
    pub size: f64,
}

/// How the records are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Setting {
    /// Experiments: several kinds of command.
    OpenLoop,
    /// Experiments in a loop, as its references; the log has the command that the loop gave.
    ClosedLoop,
    /// Production only: one log, nothing held out.
    Operation,
}

/// When a reading is taken, and how the command runs between the rows of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Timing {
    /// Before the command of its row acts; the command is held.
    Before,
    /// At the end of the period in which the command of its row acted; the command is held.
    After,
    /// At the instant of its row; the command runs on a band-limited course through its rows.
    BandLimited,
}

/// What is asked of the generator.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// Everything random follows from it.
    pub seed: u64,
    /// Effects of axis 1.
    pub effects: Vec<Wish>,
    /// How the records are made.
    pub setting: Setting,
    /// Sample rate in Hz.
    pub rate: f64,
    /// Length of the records over their usual one.
    pub length: f64,
    /// Whether the model is a straight line where the machine has hysteresis.
    pub is_linear: bool,
    /// Relative error of the weights of the model's plays, beyond tolerance; 0 for none.
    pub wrong_weights: f64,
    /// Number of axes, 1 or 2.
    pub axes: usize,
    /// Offset that all readings share, over the noise.
    pub offset: f64,
    /// When readings are taken.
    pub timing: Timing,
    /// A smooth function of position and time that no formula has beside the effects: root mean square over that of
    /// the effects; 0 for none.
    pub smooth: f64,
}

/// Signals of one record.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// What the record is.
    pub kind: Kind,
    /// Commands u1 and u2 in V; u2 is the neighbour's, also where the model has one axis.
    pub commands: [Vec<f64>; 2],
    /// Reading of each axis in µm.
    pub readings: Vec<Vec<f64>>,
    /// Root mean square in µm by which the re-tuned model misses axis 1, the mean of the record
    /// taken out; only for records that nobody sees.
    pub missed: Option<f64>,
}

/// A machine with its records.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What was asked for.
    pub order: Order,
    /// Blueprint of the model.
    pub blueprint: String,
    /// Records to fit.
    pub fit: Vec<Record>,
    /// Records to judge; none in production.
    pub held_out: Vec<Record>,
    /// The machine at rest.
    pub idle: Record,
    /// Records for the scorer only, without noise.
    pub unseen: Vec<Record>,
    /// Standard deviation of the noise per axis, in µm.
    pub sigma: Vec<f64>,
    /// Sample time in s.
    pub period: f64,
    /// The effects with their magnitudes.
    pub insertions: Vec<Insertion>,
    /// Size of each effect alone.
    pub sizes: Vec<f64>,
    /// Root mean square of what the re-tuned model leaves of all effects together, over the noise.
    pub total: f64,
}

/// What stays the same while magnitudes are searched.
struct Workshop<'a> {
    order: &'a Order,
    period: f64,
    /// What the blueprint says.
    model: Baseline,
    /// The machine without its effects.
    machine: Baseline,
    /// The one that sizes are measured against: the model, or the machine where the model is wrong.
    tuned: Baseline,
    sigma: f64,
}

impl Scene {
    /// Draws a machine and makes its records.
    ///
    /// # Errors
    /// An effect cannot reach its size on this machine.
    pub fn draw(order: &Order) -> Result<Self, Unreachable> {
        Workshop::new(order).scene()
    }

    /// A multisine record of the machine before it had its effects. It shows the mode, which a model that is identified
    /// from slow triangles lacks: a second effect that no label has.
    #[must_use]
    pub fn without_effects(&self) -> Record {
        let workshop = Workshop::new(&self.order);
        workshop.record(Kind::Multisine, 500, &[], true)
    }

    /// What the machine reads, with noise, while it is played these commands in V; `number` sets the noise apart
    /// from that of other records. The machine begins at rest under the first values.
    #[must_use]
    pub fn play(&self, commands: &[Vec<f64>; 2], number: usize) -> Vec<Vec<f64>> {
        let [command, neighbour] = commands.clone();
        let drive = Drive { command, neighbour, record: number };
        Workshop::new(&self.order).readings(&drive, &self.insertions, true)
    }
}

impl<'a> Workshop<'a> {
    fn new(order: &'a Order) -> Self {
        let mut random = Random::new(order.seed, &[10]);
        let rich = Baseline::draw(&mut random);
        let model = if order.is_linear { rich.linear() } else { rich };
        let off = model.off(&mut random);
        let is_wrong = order.wrong_weights > 0.0;
        let machine =
            if is_wrong { off.with_wrong_weights(order.wrong_weights, &mut random) } else { off };
        let tuned = if is_wrong { machine.clone() } else { model.clone() };
        let sigma = NOISE * model.full_scale();
        Self { order, period: 1.0 / order.rate, model, machine, tuned, sigma }
    }

    fn scene(&self) -> Result<Scene, Unreachable> {
        let (mut insertions, mut sizes) = (Vec::new(), Vec::new());
        for (number, wish) in self.order.effects.iter().enumerate() {
            let seed = Random::new(self.order.seed, &[20, number as u64]).next_u64();
            let with = |magnitude: f64| Insertion {
                effect: wish.effect,
                formula: wish.formula,
                magnitude,
                seed,
            };
            let size_of = |magnitude: f64| self.size(&[with(magnitude)]);
            let (found, size) = magnitude(wish.effect, wish.size, size_of)?;
            insertions.push(with(found));
            sizes.push(size);
        }
        Ok(self.records(insertions, sizes))
    }

    fn records(&self, insertions: Vec<Insertion>, sizes: Vec<f64>) -> Scene {
        let fit_kinds = self.fit_kinds();
        let fit = self.group(fit_kinds, 0, &insertions, true);
        let (held_out, unseen) = match self.order.setting {
            Setting::Operation => {
                (Vec::new(), self.group(&[Kind::Operation], 200, &insertions, false))
            }
            _ => (
                self.group(&Kind::HELD_OUT, 100, &insertions, true),
                self.group(&Kind::HELD_OUT, 200, &insertions, false),
            ),
        };
        let idle = self.group(&[Kind::Idle], 300, &insertions, true);
        let drives = drives(&fit, 0);
        let clean: Vec<f64> = self.clean(&insertions, &drives);
        let tuned = Tuner::new(&self.tuned, &drives, self.period, self.sigma).tune(&clean);
        // Where the model is wrong, the model itself is what is repaired.
        let before = Tuner::new(&self.model, &drives, self.period, self.sigma).tune(&clean);
        let mut unseen = unseen;
        for record in &mut unseen {
            let drive = drive_of(record, 0);
            let model = self.timed(&Machine::plain(&before.model, self.period), &drive);
            record.missed = record.readings.first().map(|y| spread(&model, y));
        }
        let axes: Vec<Baseline> = (0..self.order.axes).map(|axis| self.model_of(axis)).collect();
        Scene {
            order: self.order.clone(),
            blueprint: blueprint("machine", &axes.iter().collect::<Vec<_>>(), self.step()),
            fit,
            held_out,
            idle: idle.into_iter().next().unwrap_or_else(|| self.empty()),
            unseen,
            sigma: (0..self.order.axes).map(|axis| self.sigma_of(axis)).collect(),
            period: self.period,
            insertions,
            sizes,
            total: tuned.rms / self.sigma,
        }
    }

    fn empty(&self) -> Record {
        Record {
            kind: Kind::Idle,
            commands: [Vec::new(), Vec::new()],
            readings: vec![Vec::new(); self.order.axes],
            missed: None,
        }
    }

    fn fit_kinds(&self) -> &'static [Kind] {
        match self.order.setting {
            Setting::Operation => &[Kind::Operation],
            _ => &Kind::FIT,
        }
    }

    /// What is left over the noise of these effects after the re-tune, on the records to fit.
    fn size(&self, insertions: &[Insertion]) -> f64 {
        let kinds = self.fit_kinds();
        let drives: Vec<Drive> = match self.order.setting {
            Setting::ClosedLoop => drives(&self.group(kinds, 0, insertions, true), 0),
            _ => (0..kinds.len()).map(|i| self.wanted(kinds[i], i)).collect(),
        };
        let readings = self.clean(insertions, &drives);
        Tuner::new(&self.tuned, &drives, self.period, self.sigma).tune(&readings).rms / self.sigma
    }

    fn clean(&self, insertions: &[Insertion], drives: &[Drive]) -> Vec<f64> {
        let machine = self.axis(insertions);
        drives.iter().flat_map(|drive| machine.run(drive)).collect()
    }

    fn axis(&self, insertions: &[Insertion]) -> Machine {
        let baseline = self.machine.clone();
        Machine { baseline, insertions: insertions.to_vec(), period: self.period }
    }

    /// The model of axis 2 is another one, that of its machine within tolerance of it.
    fn model_of(&self, axis: usize) -> Baseline {
        if axis == 0 {
            return self.model.clone();
        }
        Baseline::draw(&mut Random::new(self.order.seed, &[11, axis as u64]))
    }

    fn sigma_of(&self, axis: usize) -> f64 {
        NOISE * self.model_of(axis).full_scale()
    }

    /// Records of these kinds. `first` numbers them, so that fit, held-out and unseen ones differ in
    /// their random numbers; held-out ones are smaller, unseen ones a little.
    fn group(
        &self,
        kinds: &[Kind],
        first: usize,
        insertions: &[Insertion],
        is_noisy: bool,
    ) -> Vec<Record> {
        let records = kinds.iter().enumerate();
        records.map(|(i, kind)| self.record(*kind, first + i, insertions, is_noisy)).collect()
    }

    /// The command, or the reference, of a record.
    fn wanted(&self, kind: Kind, number: usize) -> Drive {
        let rows = (kind.seconds() * self.order.length * self.order.rate).round() as usize;
        let mut random = Random::new(self.order.seed, &[12, number as u64]);
        let level = match number {
            0..100 => 1.0,
            100..200 => random.between(0.7, 0.9),
            _ => random.between(0.75, 0.95),
        };
        let mut command = kind.command(rows, self.period, level, &mut random);
        let mut other = match kind {
            Kind::Idle => vec![0.0; rows],
            _ => neighbour(rows, self.period, &mut random),
        };
        command.iter_mut().chain(&mut other).for_each(|u| *u = rounded(*u));
        Drive { command, neighbour: other, record: number }
    }

    fn record(
        &self,
        kind: Kind,
        number: usize,
        insertions: &[Insertion],
        is_noisy: bool,
    ) -> Record {
        let mut drive = self.wanted(kind, number);
        let machine = self.axis(insertions);
        let noise = self.noise(drive.command.len(), number, 0);
        let is_closed = self.order.setting == Setting::ClosedLoop && kind != Kind::Idle;
        if is_closed {
            let slope = self.model.full_scale() / COMMAND_SPAN;
            let heard: &[f64] = if is_noisy { &noise } else { &[] };
            drive.command = machine.run_loop(&drive, heard, slope, CROSSOVER).0;
            drive.command.iter_mut().for_each(|u| *u = rounded(*u));
        }
        let readings = self.readings(&drive, insertions, is_noisy);
        Record { kind, commands: [drive.command, drive.neighbour], readings, missed: None }
    }

    /// What all axes read under these commands.
    fn readings(&self, drive: &Drive, insertions: &[Insertion], is_noisy: bool) -> Vec<Vec<f64>> {
        let mut readings = vec![self.timed(&self.axis(insertions), drive)];
        self.add_smooth(&mut readings[0], drive.record);
        if self.order.axes > 1 {
            let second = Drive {
                command: drive.neighbour.clone(),
                neighbour: drive.command.clone(),
                record: drive.record,
            };
            let machine = self.model_of(1).off(&mut Random::new(self.order.seed, &[13]));
            readings.push(self.timed(&Machine::plain(&machine, self.period), &second));
        }
        for (axis, reading) in readings.iter_mut().enumerate() {
            if is_noisy {
                let noise = self.noise(reading.len(), drive.record, axis);
                reading.iter_mut().zip(noise).for_each(|(y, n)| *y += n);
            }
            let offset = self.order.offset * self.sigma_of(axis);
            reading.iter_mut().for_each(|y| *y = rounded(*y + offset));
        }
        readings
    }

    /// What a machine reads without noise, at the times of the order.
    fn timed(&self, machine: &Machine, drive: &Drive) -> Vec<f64> {
        match self.order.timing {
            Timing::Before => machine.run(drive),
            Timing::After => {
                // A row more, of which the first reading is left out.
                let mut longer = drive.clone();
                for values in [&mut longer.command, &mut longer.neighbour] {
                    values.extend(values.last().copied());
                }
                machine.run(&longer).split_off(1)
            }
            Timing::BandLimited => {
                let finer = Drive {
                    command: band_limited(&drive.command),
                    neighbour: band_limited(&drive.neighbour),
                    record: drive.record,
                };
                let machine = Machine { period: self.step(), ..machine.clone() };
                machine.run(&finer).into_iter().step_by(FINER).collect()
            }
        }
    }

    /// The internal step of machine and model in s. Parts in a row act on each other once per step, so a model with a
    /// coarser step than the machine's would be early by a part of it: an error that no label has.
    fn step(&self) -> f64 {
        match self.order.timing {
            Timing::BandLimited => self.period / FINER as f64,
            Timing::Before | Timing::After => self.period,
        }
    }

    /// Three waves over position and time with hidden numbers.
    fn add_smooth(&self, reading: &mut [f64], number: usize) {
        if self.order.smooth == 0.0 {
            return;
        }
        let size: f64 = self.order.effects.iter().map(|wish| wish.size.powi(2)).sum::<f64>().sqrt();
        let height = self.order.smooth * size * self.sigma * (2.0_f64 / 3.0).sqrt();
        let mut random = Random::new(self.order.seed, &[15]);
        let mut own = Random::new(self.order.seed, &[16, number as u64]);
        let waves: Vec<[f64; 3]> = (0..3)
            .map(|_| {
                let per_stroke = random.between(0.3, 1.2);
                let per_second = random.between(0.1, 1.0);
                [TAU * per_stroke, TAU * per_second, own.between(0.0, TAU)]
            })
            .collect();
        let stroke = self.model.full_scale();
        for (k, y) in reading.iter_mut().enumerate() {
            let (p, t) = (*y / stroke, k as f64 * self.period);
            *y += waves.iter().map(|[a, b, c]| height * (a * p + b * t + c).sin()).sum::<f64>();
        }
    }

    fn noise(&self, rows: usize, number: usize, axis: usize) -> Vec<f64> {
        let path = [14, number as u64, axis as u64];
        let mut random = Random::new(self.order.seed, &path);
        noise(rows, self.period, self.sigma_of(axis), &mut random)
    }
}

/// Steps of a band-limited command between two rows.
const FINER: usize = 4;

/// A course through the values without what lies above half their rate: a sum of sinc functions under a window of 16
/// values to each side, the ends held.
fn band_limited(values: &[f64]) -> Vec<f64> {
    const REACH: i64 = 16;
    let last = values.len().saturating_sub(1);
    let kernel = |x: f64| {
        let window = 0.5 + 0.5 * (PI * x / (REACH + 1) as f64).cos();
        if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) * window }
    };
    let at = |k: i64| values[(k.max(0) as usize).min(last)];
    let value = |step: usize| {
        let (row, part) = ((step / FINER) as i64, (step % FINER) as f64 / FINER as f64);
        let all = (-REACH..=REACH).map(|d| (d, kernel(d as f64 - part)));
        let (sum, weights) =
            all.fold((0.0, 0.0), |(sum, weights), (d, w)| (sum + w * at(row + d), weights + w));
        sum / weights
    };
    (0..values.len() * FINER).map(value).collect()
}

/// A value as a log holds it, with six digits behind the point.
#[must_use]
pub fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

fn drive_of(record: &Record, number: usize) -> Drive {
    let [command, neighbour] = record.commands.clone();
    Drive { command, neighbour, record: number }
}

fn drives(records: &[Record], first: usize) -> Vec<Drive> {
    records.iter().enumerate().map(|(i, record)| drive_of(record, first + i)).collect()
}

#[cfg(test)]
mod tests;
