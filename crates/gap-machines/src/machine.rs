//! A machine: a baseline and what its model does not know.

use crate::baseline::{Baseline, COMMAND_SPAN};
use crate::blocks::Tick;
use crate::build::chain;
use crate::effect::{Effect, Formula, Insertion};

/// A machine that runs.
#[derive(Clone, Debug)]
pub struct Machine {
    /// What its model has, with the machine's own values.
    pub baseline: Baseline,
    /// What its model does not have.
    pub insertions: Vec<Insertion>,
    /// Sample time in s.
    pub period: f64,
}

/// What drives a machine through one record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drive {
    /// Command in V.
    pub command: Vec<f64>,
    /// The neighbour's command in V.
    pub neighbour: Vec<f64>,
    /// Number of the record, for signals that differ between records.
    pub record: usize,
}

impl Machine {
    /// A machine that is as its model says.
    #[must_use]
    pub fn plain(baseline: &Baseline, period: f64) -> Self {
        Self { baseline: baseline.clone(), insertions: Vec::new(), period }
    }

    /// The reading in µm without noise; row k is read before command k acts.
    #[must_use]
    pub fn run(&self, drive: &Drive) -> Vec<f64> {
        let rows = drive.command.len();
        let clock = self.insertions.iter().find(|i| i.effect == Effect::ClockOffset);
        let spare = clock.map_or(0, |c| (c.magnitude * rows as f64) as usize + 2000);
        let mut chain = chain(&self.baseline, &self.insertions, drive.record, self.period);
        let mut readings = Vec::with_capacity(rows + spare);
        let last = rows.saturating_sub(1);
        for k in 0..rows + spare {
            let at =
                |values: &[f64], k: usize| values.get(k.min(last)).copied().unwrap_or_default();
            // Reading k follows from the command of the period before it.
            let held = k.saturating_sub(1);
            let tick = Tick {
                time: k as f64 * self.period,
                command: at(&drive.command, held),
                neighbour: at(&drive.neighbour, held),
            };
            let mut x = tick.command;
            for block in &mut chain {
                x = if k == 0 { block.rest(x, &tick) } else { block.step(x, &tick) };
            }
            readings.push(x);
        }
        match clock {
            Some(clock) => turned(&readings, rows, clock, self.period),
            None => readings,
        }
    }

    /// Command and reading (without noise) of the machine in a loop that follows `reference`, given
    /// in V of command: feedforward `r` and an integrator of crossover `hz` on the measured reading.
    #[must_use]
    pub fn run_loop(
        &self,
        reference: &Drive,
        noise: &[f64],
        slope: f64,
        hz: f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let mut chain = chain(&self.baseline, &self.insertions, reference.record, self.period);
        let gain = std::f64::consts::TAU * hz * self.period / slope;
        let (mut integral, mut commands, mut readings) = (0.0, Vec::new(), Vec::new());
        let mut held = Tick::default();
        for (k, wanted) in reference.command.iter().enumerate() {
            let neighbour = reference.neighbour.get(k).copied().unwrap_or_default();
            if k == 0 {
                held = Tick { time: 0.0, command: *wanted, neighbour };
            }
            let mut x = held.command;
            for block in &mut chain {
                x = if k == 0 { block.rest(x, &held) } else { block.step(x, &held) };
            }
            readings.push(x);
            let measured = x + noise.get(k).copied().unwrap_or_default();
            // The machine rests under its first command, which is the reference itself.
            if k > 0 {
                integral += gain * (slope * wanted - measured);
            }
            integral = integral.clamp(-0.3 * COMMAND_SPAN, 0.3 * COMMAND_SPAN);
            let command = (wanted + integral).clamp(-20.0, 120.0);
            commands.push(command);
            held = Tick { time: (k + 1) as f64 * self.period, command, neighbour };
        }
        (commands, readings)
    }
}

/// Readings by a clock that is fast by the magnitude, or wanders as well: the reading at log time t is
/// that of `t + e·t`, or of `t + e·t + 0.1 s·e·sin(2π·1.3 Hz·t)`; between samples by a cubic.
fn turned(readings: &[f64], rows: usize, clock: &Insertion, period: f64) -> Vec<f64> {
    let e = clock.magnitude;
    (0..rows)
        .map(|k| {
            let t = k as f64 * period;
            let wander = match clock.formula {
                Formula::Standard => 0.0,
                Formula::Other => 0.1 * (std::f64::consts::TAU * 1.3 * t).sin(),
            };
            between(readings, (k as f64 + e * (t + wander) / period).max(0.0))
        })
        .collect()
}

/// Lagrange's cubic through the four samples around a place.
fn between(values: &[f64], place: f64) -> f64 {
    let integer = place.floor();
    let x = place - integer;
    let get = |offset: f64| {
        let index = (integer + offset).clamp(0.0, values.len().saturating_sub(1) as f64);
        values.get(index as usize).copied().unwrap_or_default()
    };
    let (a, b, c, d) = (get(-1.0), get(0.0), get(1.0), get(2.0));
    -a * x * (x - 1.0) * (x - 2.0) / 6.0 + b * (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0
        - c * (x + 1.0) * x * (x - 2.0) / 2.0
        + d * (x + 1.0) * x * (x - 1.0) / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::records::{Kind, neighbour};

    const H: f64 = 2.5e-4;

    fn drive() -> Drive {
        let mut random = Random::new(3, &[]);
        let command = Kind::Multisine.command(4000, H, 1.0, &mut random);
        Drive { command, neighbour: neighbour(4000, H, &mut random), record: 0 }
    }

    #[test]
    fn a_cubic_is_met_between_samples() {
        let values: Vec<f64> = (0..20).map(|k| f64::from(k).powi(3)).collect();
        assert!((between(&values, 7.3) - 7.3_f64.powi(3)).abs() < 1e-9);
        assert_eq!(between(&values, 5.0), 125.0);
    }

    #[test]
    fn at_rest_nothing_moves() {
        let baseline = Baseline::draw(&mut Random::new(1, &[]));
        let machine = Machine::plain(&baseline, H);
        let idle = Drive { command: vec![40.0; 50], neighbour: vec![10.0; 50], record: 0 };
        let readings = machine.run(&idle);
        assert!(readings.iter().all(|y| (y - readings[0]).abs() < 1e-12));
    }

    #[test]
    fn every_effect_of_size_zero_is_nearly_nothing_and_of_its_reach_something() {
        let baseline = Baseline::draw(&mut Random::new(1, &[]));
        let plain = Machine::plain(&baseline, H).run(&drive());
        for &effect in Effect::ALL {
            for formula in [Formula::Standard, Formula::Other] {
                let change = |magnitude: f64| {
                    let insertions = vec![Insertion { effect, formula, magnitude, seed: 5 }];
                    let machine = Machine { insertions, ..Machine::plain(&baseline, H) };
                    let squares = machine
                        .run(&drive())
                        .iter()
                        .zip(&plain)
                        .map(|(a, b)| (a - b).powi(2))
                        .sum::<f64>();
                    (squares / plain.len() as f64).sqrt()
                };
                let (low, high) = effect.reach();
                let (small, large) = (change(low), change(0.3 * high));
                assert!(small < 0.02, "{} {formula:?}: {small}", effect.name());
                assert!(
                    large > 0.01 && large.is_finite(),
                    "{} {formula:?}: {large}",
                    effect.name()
                );
            }
        }
    }

    #[test]
    fn a_loop_follows_its_reference_and_its_command_explains_the_reading() {
        let baseline = Baseline::draw(&mut Random::new(2, &[]));
        let machine = Machine::plain(&baseline, H);
        let mut random = Random::new(3, &[]);
        let command = Kind::RisingTriangle.command(8000, H, 1.0, &mut random);
        let reference = Drive { command, neighbour: vec![0.0; 8000], record: 0 };
        let slope = baseline.full_scale() / COMMAND_SPAN;
        let (command, reading) = machine.run_loop(&reference, &[], slope, 8.0);
        let error = |y: &[f64]| {
            let squares =
                y.iter().zip(&reference.command).skip(2000).map(|(y, r)| (y - slope * r).powi(2));
            (squares.sum::<f64>() / 6000.0).sqrt()
        };
        let open = machine.run(&reference);
        assert!(error(&reading) < 0.5 * error(&open), "{} {}", error(&reading), error(&open));
        let again = machine.run(&Drive { command, ..reference });
        assert!(again.iter().zip(&reading).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn signals_differ_between_records_and_constants_do_not() {
        let baseline = Baseline::draw(&mut Random::new(1, &[]));
        let run = |effect, magnitude, record| {
            let insertions =
                vec![Insertion { effect, formula: Formula::Standard, magnitude, seed: 5 }];
            Machine { insertions, ..Machine::plain(&baseline, H) }.run(&Drive { record, ..drive() })
        };
        assert_ne!(run(Effect::MainsHum, 0.1, 0), run(Effect::MainsHum, 0.1, 1));
        assert_eq!(run(Effect::ExtraMode, 0.1, 0), run(Effect::ExtraMode, 0.1, 1));
    }
}
