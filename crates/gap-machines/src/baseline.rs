//! The part of a machine that its model knows.

use std::fmt::Write as _;

use crate::random::Random;

/// One axis as its model has it: amplifier lag → plays → mode → sensor lag → gain.
#[derive(Clone, Debug, PartialEq)]
pub struct Baseline {
    /// Bandwidth of the amplifier in Hz, if it has one.
    pub amplifier: Option<f64>,
    /// Thresholds of the plays in V, increasing from 0.
    pub thresholds: Vec<f64>,
    /// Weights of the plays in µm/V.
    pub weights: Vec<f64>,
    /// Natural frequency of the mechanics in Hz.
    pub frequency: f64,
    /// Damping ratio of the mechanics.
    pub damping: f64,
    /// Bandwidth of the sensor in Hz, if it has one.
    pub sensor: Option<f64>,
    /// Gain of the reading; 1 in a model.
    pub gain: f64,
}

/// Standard deviations of what may be off, relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Of the gain of the reading.
    pub gain: f64,
    /// Of each weight of the plays.
    pub weight: f64,
    /// Of the natural frequency.
    pub frequency: f64,
    /// Of the damping ratio.
    pub damping: f64,
    /// Of the bandwidths of amplifier and sensor.
    pub bandwidth: f64,
}

/// The tolerances of all machines here.
pub const TOLERANCES: Tolerances =
    Tolerances { gain: 0.01, weight: 0.05, frequency: 0.01, damping: 0.15, bandwidth: 0.05 };

/// Range of the command in V.
pub const COMMAND_SPAN: f64 = 100.0;

impl Baseline {
    /// A model with hysteresis; half of them have an amplifier and a sensor with a bandwidth.
    #[must_use]
    pub fn draw(random: &mut Random) -> Self {
        let has_bandwidths = random.unit() < 0.5;
        let total = random.between(0.08, 0.12);
        let memory = random.between(0.15, 0.3);
        let thresholds: Vec<f64> = [0.0, 3.0, 7.0, 12.0, 18.0, 25.0, 33.0, 42.0].to_vec();
        let shares: Vec<f64> =
            thresholds[1..].iter().map(|r| (-r / 25.0).exp() * random.between(0.6, 1.4)).collect();
        let sum: f64 = shares.iter().sum();
        let mut weights = vec![total * (1.0 - memory)];
        weights.extend(shares.iter().map(|share| total * memory * share / sum));
        Self {
            amplifier: has_bandwidths.then(|| random.between(800.0, 2500.0)),
            thresholds,
            weights,
            frequency: random.between(200.0, 450.0),
            damping: random.between(0.02, 0.06),
            sensor: has_bandwidths.then(|| random.between(1500.0, 5000.0)),
            gain: 1.0,
        }
    }

    /// The model with a straight line in place of its plays.
    #[must_use]
    pub fn linear(&self) -> Self {
        let weights = vec![self.weights.iter().sum()];
        Self { thresholds: vec![0.0], weights, ..self.clone() }
    }

    /// A machine whose values are off by what the tolerances say.
    #[must_use]
    pub fn off(&self, random: &mut Random) -> Self {
        let factors: Vec<f64> =
            self.deviations().iter().map(|sd| 1.0 + sd * random.normal_within(2.5)).collect();
        self.scaled(&factors)
    }

    /// The model with each weight of its plays off by this standard deviation, far from tolerance.
    #[must_use]
    pub fn with_wrong_weights(&self, deviation: f64, random: &mut Random) -> Self {
        let mut all = self.clone();
        for weight in &mut all.weights {
            *weight *= 1.0 + deviation * random.normal_within(2.5);
        }
        all
    }

    /// Relative standard deviations of the parameters, in the order of [`scaled`](Self::scaled).
    #[must_use]
    pub fn deviations(&self) -> Vec<f64> {
        let t = TOLERANCES;
        let mut all = vec![t.gain, t.frequency, t.damping];
        all.extend(self.amplifier.iter().chain(&self.sensor).map(|_| t.bandwidth));
        all.extend(self.weights.iter().map(|_| t.weight));
        all
    }

    /// The model with every parameter times its factor.
    #[must_use]
    pub fn scaled(&self, factors: &[f64]) -> Self {
        let mut all = self.clone();
        let mut factors = factors.iter();
        let mut scale = |x: &mut f64| *x *= factors.next().copied().unwrap_or(1.0);
        scale(&mut all.gain);
        scale(&mut all.frequency);
        scale(&mut all.damping);
        all.amplifier.iter_mut().for_each(&mut scale);
        all.sensor.iter_mut().for_each(&mut scale);
        all.weights.iter_mut().for_each(&mut scale);
        all
    }

    /// Full scale: the position at the end of the range, in µm.
    #[must_use]
    pub fn full_scale(&self) -> f64 {
        let plays = self.thresholds.iter().zip(&self.weights);
        self.gain * plays.map(|(r, w)| w * (COMMAND_SPAN - r).max(0.0)).sum::<f64>()
    }
}

/// The blueprint of a model, as text: one axis per baseline, commands `u1`, `u2`, … in V, positions
/// `y1`, `y2`, … in µm, internal step in s.
#[must_use]
pub fn blueprint(name: &str, axes: &[&Baseline], step: f64) -> String {
    let mut text = format!("piezoloop = 1\nkind = \"plant\"\nname = \"{name}\"\nstep = {step:e}\n");
    for (index, axis) in axes.iter().enumerate() {
        let number = index + 1;
        let _ = write!(
            text,
            "\n[[axis]]\nname = \"Axis{number}\"\ncommand = {{ name = \"u{number}\", unit = \"V\", min = \
             -20, max = 120, start = 0 }}\nposition = {{ name = \"y{number}\", unit = \"um\" }}\n"
        );
        components(&mut text, axis);
    }
    text
}

fn components(text: &mut String, axis: &Baseline) {
    let t = TOLERANCES;
    let mut add = |kind: &str, name: &str, values: &str| {
        let _ =
            write!(text, "\n[[axis.component]]\ntype = \"{kind}\"\nname = \"{name}\"\n{values}\n");
    };
    let bandwidth =
        |hz: f64| format!("bandwidth = {hz:?}\ntolerance = {{ bandwidth = {} }}", t.bandwidth);
    if let Some(hz) = axis.amplifier {
        add("amplifier-lag", "amplifier", &bandwidth(hz));
    }
    if let [gain] = axis.weights[..] {
        let values = format!("gain = {gain:?}\ntolerance = {{ gain = {} }}", t.weight);
        add("actuator-gain", "actuator", &values);
    } else {
        let values = format!(
            "r = {:?}\nw = {:?}\ntolerance = {{ w = {} }}",
            axis.thresholds, axis.weights, t.weight
        );
        add("prandtl-ishlinskii", "hysteresis", &values);
    }
    let values = format!(
        "frequency = {:?}\ndamping = {:?}\ntolerance = {{ frequency = {}, damping = {} }}",
        axis.frequency, axis.damping, t.frequency, t.damping
    );
    add("mode", "mechanics", &values);
    if let Some(hz) = axis.sensor {
        add("sensor-lag", "sensor", &bandwidth(hz));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_has_a_deviation_and_a_factor() {
        for seed in 0..20 {
            let model = Baseline::draw(&mut Random::new(seed, &[]));
            let n = model.deviations().len();
            assert_eq!(n, 3 + 2 * usize::from(model.sensor.is_some()) + model.weights.len());
            assert_eq!(model.scaled(&vec![1.0; n]), model);
            for i in 0..n {
                let mut factors = vec![1.0; n];
                factors[i] = 1.1;
                assert_ne!(model.scaled(&factors), model, "parameter {i}");
            }
            assert!((5.0..12.0).contains(&model.full_scale()));
        }
    }

    #[test]
    fn machines_stay_within_their_tolerance() {
        let mut random = Random::new(1, &[]);
        let model = Baseline::draw(&mut random);
        for _ in 0..100 {
            let machine = model.off(&mut random);
            assert!((machine.frequency / model.frequency - 1.0).abs() <= 0.025);
            assert!((machine.damping / model.damping - 1.0).abs() <= 0.375);
        }
    }

    #[test]
    fn the_blueprint_names_what_the_baseline_has() {
        let model =
            Baseline { amplifier: Some(1000.0), ..Baseline::draw(&mut Random::new(1, &[])) };
        let text = blueprint("m", &[&model, &model.linear()], 2.5e-4);
        assert_eq!(text.matches("[[axis]]").count(), 2);
        assert_eq!(text.matches("amplifier-lag").count(), 2);
        assert_eq!(text.matches("prandtl-ishlinskii").count(), 1);
        assert_eq!(text.matches("actuator-gain").count(), 1);
    }
}
