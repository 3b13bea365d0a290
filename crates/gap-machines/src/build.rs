//! From a baseline and its effects to a chain of blocks.

use crate::baseline::{Baseline, COMMAND_SPAN};
use crate::blocks::{
    AcCoupling, Backlash, Block, BoucWen, Branch, Clamp, Coupling, Delay, Drift, ExtraMode,
    FeedThrough, Force, Gain, GainModulation, GainOverTime, GeneralisedPlay, Glitches, HeldSamples,
    Hum, Lags, LogCreep, Mode, NonlinearMode, Periodic, Plays, PlaysLaw, Quantiser, Relaxations,
    SelfHeating, SlewLimit, Slot, StaticMap, Telegraph, VaryingDelay, Vibration, Walk, White,
};
use crate::effect::{Effect, Formula, Insertion};
use crate::random::Random;

/// The blocks of one axis in the order of the signal path.
pub(crate) type Chain = Vec<Box<dyn Block>>;

/// What the effects ask of the path.
struct Plan {
    baseline: Baseline,
    blocks: Vec<(Slot, Box<dyn Block>)>,
    law: PlaysLaw,
    forces: Vec<Force>,
    period: f64,
    full_scale: f64,
    record: u64,
}

/// The chain of a machine. Random signals differ from record to record, hidden constants do not.
pub(crate) fn chain(
    baseline: &Baseline,
    insertions: &[Insertion],
    record: usize,
    period: f64,
) -> Chain {
    let mut plan = Plan {
        baseline: baseline.clone(),
        blocks: Vec::new(),
        law: PlaysLaw::Plain,
        forces: Vec::new(),
        period,
        full_scale: baseline.full_scale(),
        record: record as u64,
    };
    insertions.iter().for_each(|insertion| plan.insert(insertion));
    plan.assemble()
}

impl Plan {
    fn add(&mut self, slot: Slot, block: impl Block + 'static) {
        self.blocks.push((slot, Box::new(block)));
    }

    fn assemble(self) -> Chain {
        let Self { baseline: b, blocks, law, forces, period, .. } = self;
        let mut chain: Chain = Vec::new();
        let mut blocks: Vec<_> = blocks.into_iter().map(Some).collect();
        let mut take = |chain: &mut Chain, slot: Slot| {
            for entry in &mut blocks {
                if entry.as_ref().is_some_and(|(s, _)| *s == slot) {
                    chain.extend(entry.take().map(|(_, block)| block));
                }
            }
        };
        take(&mut chain, Slot::Timing);
        chain.extend(b.amplifier.map(|hz| boxed(Lags::of_bandwidth(hz, period))));
        take(&mut chain, Slot::Voltage);
        chain.push(boxed(Plays::new(&b.thresholds, &b.weights, law)));
        take(&mut chain, Slot::Elongation);
        chain.push(if forces.is_empty() {
            boxed(Mode::new(b.frequency, b.damping, period))
        } else {
            boxed(NonlinearMode::new(b.frequency, b.damping, forces, period))
        });
        take(&mut chain, Slot::Position);
        chain.extend(b.sensor.map(|hz| boxed(Lags::of_bandwidth(hz, period))));
        chain.push(boxed(Gain(b.gain)));
        take(&mut chain, Slot::Reading);
        chain
    }

    fn insert(&mut self, insertion: &Insertion) {
        let Insertion { effect, formula, magnitude: m, seed } = *insertion;
        let is_other = formula == Formula::Other;
        let hidden = Random::new(seed, &[1]);
        let signal = Random::new(seed, &[2, self.record]);
        match effect {
            Effect::Creep
            | Effect::PolarisationSaturation
            | Effect::ActuatorGain
            | Effect::SelfHeating => self.actuator(effect, m, is_other),
            Effect::Hysteresis
            | Effect::Asymmetry
            | Effect::RateDependence
            | Effect::InitialState => self.memory(effect, m, is_other, hidden, signal),
            Effect::AmplifierBandwidth | Effect::AmplifierSlew | Effect::AmplifierSaturation => {
                self.amplifier(effect, m, is_other);
            }
            Effect::Delay | Effect::DacQuantisation => self.timing(effect, m, is_other, hidden),
            // The clock is not on the path: [`crate::machine`] turns it.
            Effect::ClockOffset => {}
            Effect::ResonanceShift
            | Effect::Damping
            | Effect::ExtraMode
            | Effect::Duffing
            | Effect::Backlash
            | Effect::Friction
            | Effect::PeriodicDisturbance => self.mechanics(effect, m, is_other, hidden, signal),
            Effect::CrossCoupling
            | Effect::SensorNonlinearity
            | Effect::SensorBandwidth
            | Effect::SensorQuantisation
            | Effect::Crosstalk => self.sensor(effect, m, is_other),
            Effect::ThermalDrift | Effect::SensorNoise | Effect::MainsHum => {
                self.additive(effect, m, is_other, signal);
            }
            _ => self.stray(effect, m, hidden, signal),
        }
    }

    fn actuator(&mut self, effect: Effect, m: f64, is_other: bool) {
        let (h, full) = (self.period, self.full_scale);
        match (effect, is_other) {
            (Effect::Creep, false) => {
                let elements = [(0.3 * m, 0.05), (0.3 * m, 0.4), (0.4 * m, 3.0)];
                self.add(Slot::Elongation, Relaxations::new(&elements, h));
            }
            (Effect::Creep, true) => self.add(Slot::Elongation, LogCreep::new(m, 0.01, h)),
            (Effect::PolarisationSaturation, false) => self.add(
                Slot::Elongation,
                StaticMap::new(move |x| {
                    let part = 2.0 * x / full - 1.0;
                    x - m * 0.5 * full * part.powi(3)
                }),
            ),
            (Effect::PolarisationSaturation, true) => self.add(
                Slot::Elongation,
                StaticMap::new(move |x| {
                    let (part, bend) = (2.0 * x / full - 1.0, m.sqrt().max(1e-9));
                    0.5 * full * (1.0 + (bend * part).tanh() / bend)
                }),
            ),
            (Effect::ActuatorGain, false) => self.add(Slot::Reading, Gain(1.0 + m)),
            (Effect::ActuatorGain, true) => self.add(Slot::Reading, GainOverTime(m)),
            (_, false) => {
                self.add(Slot::Elongation, SelfHeating::new(m, 0.0, &[(1.0, 0.8)], h));
            }
            (_, true) => {
                let elements = [(0.5, 0.2), (0.5, 2.0)];
                self.add(Slot::Elongation, SelfHeating::new(0.5 * m, 0.1 * m, &elements, h));
            }
        }
    }

    fn memory(
        &mut self,
        effect: Effect,
        m: f64,
        is_other: bool,
        mut hidden: Random,
        mut signal: Random,
    ) {
        match (effect, is_other) {
            (Effect::Hysteresis, false) if self.baseline.weights.len() == 1 => {
                // A linear model: the machine has plays, and the line keeps its slope at full range.
                let total = self.baseline.weights[0];
                self.baseline.thresholds = vec![0.0, 5.0, 15.0, 30.0];
                let weights = [0.4, 0.35, 0.25].map(|share| 0.3 * m * total * share);
                let plays = weights.iter().zip(&self.baseline.thresholds[1..]);
                let slope: f64 = plays.map(|(w, r)| w * (1.0 - 2.0 * r / COMMAND_SPAN)).sum();
                self.baseline.weights = vec![total - slope];
                self.baseline.weights.extend(weights);
            }
            (Effect::Hysteresis, false) => {
                // Plays with r > 0 only: the wide ones up, the narrow ones down.
                let count = self.baseline.weights.len() as f64;
                for (i, weight) in self.baseline.weights.iter_mut().enumerate().skip(1) {
                    let slope = 2.0 * i as f64 / count - 1.0;
                    *weight *= (1.0 + m * (slope + 0.3 * hidden.between(-1.0, 1.0))).max(0.0);
                }
            }
            (Effect::Hysteresis, true) => {
                let width = hidden.between(8.0, 20.0);
                self.add(Slot::Elongation, BoucWen::new(m, width));
            }
            (Effect::Asymmetry, false) => {
                let (threshold, bend) = (hidden.between(1.0, 4.0), hidden.between(15.0, 25.0));
                let play = GeneralisedPlay::new(m, threshold, bend, COMMAND_SPAN);
                self.add(Slot::Elongation, play);
            }
            (Effect::Asymmetry, true) => {
                let width = hidden.between(6.0, 15.0);
                self.add(Slot::Elongation, Branch::new(m, COMMAND_SPAN, width));
            }
            (Effect::RateDependence, false) => {
                self.law = PlaysLaw::Rate { seconds: m, period: self.period };
            }
            (Effect::RateDependence, true) => {
                self.law = PlaysLaw::Lagged(Lags::new(m, 1, self.period));
            }
            _ => self.law = PlaysLaw::Start { share: m * signal.between(0.8, 1.0) },
        }
    }

    fn amplifier(&mut self, effect: Effect, m: f64, is_other: bool) {
        let h = self.period;
        match (effect, is_other) {
            (Effect::AmplifierBandwidth, false) => self.add(Slot::Voltage, Lags::new(m, 1, h)),
            (Effect::AmplifierBandwidth, true) => {
                self.add(Slot::Voltage, Lags::new(m / 3.0, 3, h));
            }
            (Effect::AmplifierSlew, false) => self.add(Slot::Voltage, SlewLimit::hard(1.0 / m, h)),
            (Effect::AmplifierSlew, true) => self.add(Slot::Voltage, SlewLimit::soft(1.0 / m, h)),
            (_, false) => self.add(Slot::Voltage, Clamp::hard(COMMAND_SPAN * (1.0 - m))),
            (_, true) => {
                let width = 0.03 * COMMAND_SPAN;
                self.add(Slot::Voltage, Clamp::soft(COMMAND_SPAN * (1.1 - 1.1 * m), width));
            }
        }
    }

    fn timing(&mut self, effect: Effect, m: f64, is_other: bool, mut hidden: Random) {
        match (effect, is_other) {
            (Effect::Delay, false) => self.add(Slot::Timing, Delay::new(m, self.period)),
            (Effect::Delay, true) => {
                let hz = hidden.between(2.0, 5.0);
                self.add(Slot::Timing, VaryingDelay::new(m, hz, self.period));
            }
            _ => self.add(Slot::Timing, Quantiser::new(m, is_other)),
        }
    }

    fn mechanics(
        &mut self,
        effect: Effect,
        m: f64,
        is_other: bool,
        mut hidden: Random,
        mut signal: Random,
    ) {
        let (h, half, f) = (self.period, 0.5 * self.full_scale, self.baseline.frequency);
        match (effect, is_other) {
            (Effect::ResonanceShift, _) => {
                self.baseline.frequency *= 1.0 - m;
                if is_other {
                    // A softer spring: the static gain grows as the square of the frequency falls.
                    self.add(Slot::Position, Gain((1.0 - m).powi(-2)));
                }
            }
            (Effect::Damping, false) => self.baseline.damping *= 1.0 + m,
            (Effect::Damping, true) => {
                self.baseline.damping *= 1.0 + 0.5 * m;
                let ratio = 0.5 * m * self.baseline.damping / (1.0 + 0.5 * m);
                self.forces.push(Force::SpeedDamping { ratio, scale: 0.1 * half });
            }
            (Effect::ExtraMode, _) => {
                let (f2, zeta) = (f * hidden.between(1.2, 1.8), hidden.between(0.01, 0.03));
                let block = if is_other { ExtraMode::pole_zero } else { ExtraMode::parallel };
                self.add(Slot::Position, block(m, f2, zeta, h));
            }
            (Effect::Duffing, _) => {
                let (cubic, quadratic) = if is_other { (-0.5 * m, -0.5 * m) } else { (m, 0.0) };
                self.forces.push(Force::Stiffness { cubic, quadratic, scale: 2.0 * half });
            }
            (Effect::Backlash, _) => {
                let stiff = if is_other { 0.15 } else { 0.0 };
                self.add(Slot::Elongation, Backlash::new(m, stiff));
            }
            (Effect::Friction, false) => {
                // As fast as the discretisation bears, but never slower than a fiftieth of the range.
                let smooth = (0.4 * m).max(0.005 * half);
                self.forces.push(Force::Coulomb { level: m, smooth });
            }
            (Effect::Friction, true) => {
                let distance = hidden.between(0.02, 0.05) * half;
                self.forces.push(Force::Dahl { level: m, distance, z: 0.0 });
            }
            _ => {
                // Away from the mains and its multiples.
                let hz = [23.0, 37.0, 68.0, 83.0, 114.0, 137.0][hidden.below(6)]
                    + hidden.between(-2.0, 2.0);
                self.add(Slot::Elongation, Periodic::new(m, hz, is_other, &mut signal));
            }
        }
    }

    fn sensor(&mut self, effect: Effect, m: f64, is_other: bool) {
        let (h, full) = (self.period, self.full_scale);
        match (effect, is_other) {
            (Effect::CrossCoupling, false) => self.add(Slot::Position, Coupling::prompt(m)),
            (Effect::CrossCoupling, true) => {
                let mode = (0.8 * self.baseline.frequency, 0.03);
                self.add(Slot::Position, Coupling::slow(m, 2e-3, mode, h));
            }
            (Effect::SensorNonlinearity, false) => self.add(
                Slot::Reading,
                StaticMap::new(move |y| {
                    let part = y / full;
                    y + m * full * part * (1.0 - part) * (1.0 + 0.6 * part)
                }),
            ),
            (Effect::SensorNonlinearity, true) => self.add(
                Slot::Reading,
                StaticMap::new(move |y| {
                    let part = y / full;
                    let growth = (2.0 * part).exp_m1() - 2.0_f64.exp_m1() * part;
                    y + m * full * ((6.0 * part).sin() + 0.3 * growth)
                }),
            ),
            (Effect::SensorBandwidth, false) => self.add(Slot::Reading, Lags::new(m, 1, h)),
            (Effect::SensorBandwidth, true) => self.add(Slot::Reading, Lags::new(m / 3.0, 3, h)),
            (Effect::SensorQuantisation, _) => {
                self.add(Slot::Reading, Quantiser::new(m, is_other));
            }
            _ => self.add(Slot::Reading, FeedThrough::new(m, is_other, h)),
        }
    }

    fn additive(&mut self, effect: Effect, m: f64, is_other: bool, mut signal: Random) {
        match (effect, is_other) {
            (Effect::ThermalDrift, false) => self.add(Slot::Reading, Drift::new(m, &mut signal)),
            (Effect::ThermalDrift, true) => {
                self.add(Slot::Reading, Walk::new(m, signal, self.period));
            }
            (Effect::MainsHum, false) => {
                self.add(Slot::Reading, Hum::new(m, 0.0, 50.0, &mut signal));
            }
            (Effect::MainsHum, true) => {
                self.add(Slot::Reading, Hum::new(m, 0.3, 50.03, &mut signal));
            }
            _ => self.add(Slot::Reading, White::new(m, signal)),
        }
    }

    fn stray(&mut self, effect: Effect, m: f64, mut hidden: Random, mut signal: Random) {
        let (h, full) = (self.period, self.full_scale);
        match effect {
            Effect::GainModulation => {
                let hz = hidden.between(5.0, 11.0);
                self.add(Slot::Reading, GainModulation::new(m, hz, &mut signal));
            }
            Effect::Vibration => {
                let hz = hidden.between(22.0, 38.0);
                self.add(Slot::Reading, Vibration::new(m, hz, signal, h));
            }
            Effect::Glitches => self.add(Slot::Reading, Glitches::new(m, signal, h)),
            Effect::PositionGrid => {
                let pitch = full / hidden.between(20.0, 30.0);
                let map = move |y: f64| y + m * (std::f64::consts::TAU * y / pitch).sin();
                self.add(Slot::Reading, StaticMap::new(map));
            }
            Effect::AcCoupling => self.add(Slot::Reading, AcCoupling::new(m, h)),
            Effect::HeldSamples => self.add(Slot::Reading, HeldSamples::new(m, signal, h)),
            _ => self.add(Slot::Reading, Telegraph::new(m, signal, h)),
        }
    }
}

fn boxed(block: impl Block + 'static) -> Box<dyn Block> {
    Box::new(block)
}
