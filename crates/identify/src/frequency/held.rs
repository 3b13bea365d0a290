//! From a fitted response to a plant that is driven by held inputs.
//!
//! A discrete model with at least one sample of delay is turned into the modes of the component `modal-matrix`
//! without loss: under inputs that are held over a sample their outputs at the samples are its own.

use core::f64::consts::{PI, TAU};

use components::linear::Transition;
use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint};
use model::Kind;
use nalgebra::{DMatrix, Matrix2, Vector2};

use super::Complex;
use super::modes::{Choice, RationalSettings, choose};
use super::rational::{Domain, Rational};
use super::response::FrequencyResponse;
use crate::error::Error;

/// Time constant in s of the running rms that softening modes follow.
const TIME_CONSTANT: f64 = 0.1;
/// Least half distance of the two poles of a mode in z.
const NEAREST: f64 = 1e-7;

/// One mode with its matrices, outputs × inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldMode {
    /// Undamped natural frequency in Hz.
    pub frequency: f64,
    /// Damping ratio; 1 or more for two real poles.
    pub damping: f64,
    /// What the displacement of the mode contributes.
    pub residue: DMatrix<f64>,
    /// What its rate over its angular frequency contributes.
    pub rate_residue: DMatrix<f64>,
}

/// How modes follow the amplitude: relative changes of frequency and damping, `shift·a^exponent` and
/// `growth·a^exponent`.
#[derive(Clone, Debug, PartialEq)]
pub struct Softening {
    /// Per mode: relative change of its frequency at the amplitude `rms`.
    pub shift: Vec<f64>,
    /// Per mode: relative change of its damping ratio there.
    pub growth: Vec<f64>,
    /// Power of the amplitude that they follow.
    pub exponent: f64,
    /// Rms of each input at which a = 1.
    pub rms: Vec<f64>,
}

/// A plant over inputs that are held for a sample; linear at one amplitude.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldPlant {
    /// Sample time in s.
    pub period: f64,
    /// What follows the input at once, outputs × inputs.
    pub direct: DMatrix<f64>,
    /// The modes, by frequency.
    pub modes: Vec<HeldMode>,
    /// Delay beyond the hold, in s; whole samples.
    pub delay: f64,
    /// How the modes follow the amplitude, where they do; they themselves are those of small motion then.
    pub softening: Option<Softening>,
}

/// How a plant is named.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantNames {
    /// Of the model.
    pub model: String,
    /// What the file says about where it comes from.
    pub description: String,
    /// Per input: name, unit, least and greatest value of the records.
    pub inputs: Vec<(String, String, (f64, f64))>,
    /// Per output: name and unit.
    pub outputs: Vec<(String, String)>,
}

impl PlantNames {
    /// The axes, each with its signals and no component.
    pub(super) fn axes(&self) -> impl Iterator<Item = AxisBlueprint> + '_ {
        let signals = self.inputs.iter().zip(&self.outputs);
        signals.map(|((input, unit, (low, high)), (output, position))| {
            let mut axis = AxisBlueprint::new(output, unit, position);
            axis.command =
                axis.command.named(input).between(*low, *high).start(0.0_f64.clamp(*low, *high));
            axis.position = axis.position.named(output);
            axis
        })
    }
}

/// The component of a delay in s; none where there is no delay.
pub(super) fn delay_of(delay: f64) -> Option<ComponentBlueprint> {
    let part = ComponentBlueprint::new("delay").value("longest", 2.0 * delay);
    (delay > 0.0).then(|| part.value("delay", delay))
}

/// Fits plants of 1 to `most` modes over held inputs with `period` in s; all that were tried, and the place
/// of that of least description length.
///
/// An output is read before the input of its row acts, so there is at least one sample between them:
/// the fit is of the response advanced by it.
///
/// # Errors
/// [`Error::NoSolution`] where no order has a fit with poles that a plant over time can have.
pub fn choose_held(
    measured: &FrequencyResponse,
    period: f64,
    settings: &RationalSettings,
    most: usize,
) -> Result<(HeldPlant, Choice), Error> {
    let mut advanced = measured.clone();
    for line in &mut advanced.lines {
        line.response *= Complex::from_polar(1.0, TAU * line.frequency * period);
    }
    let settings = RationalSettings { is_held: true, ..*settings };
    let (mut tried, _) = choose(&advanced, Domain::Discrete(period), &settings, most)?;
    tried.sort_by(|a, b| a.1.length.total_cmp(&b.1.length));
    let mut first = None;
    for (_, mut choice) in tried {
        choice.model.delay += period;
        match HeldPlant::of(&choice.model) {
            Ok(plant) => return Ok((plant, choice)),
            Err(error) => first = first.or(Some(error)),
        }
    }
    Err(first.unwrap_or(Error::no_solution("no order was tried")))
}

impl HeldPlant {
    /// The plant of a discrete model with at least one sample of delay.
    ///
    /// # Errors
    /// [`Error::NoSolution`] for a continuous model, one without delay, or a pole that no mode has: one at or
    /// beyond the unit circle, or on the negative real axis, where a signal changes its sign with every sample.
    pub fn of(model: &Rational) -> Result<Self, Error> {
        let Domain::Discrete(period) = model.domain else {
            return Err(Error::no_solution("a plant over held inputs needs a discrete model"));
        };
        let samples = (model.delay / period).round();
        if samples < 1.0 {
            return Err(Error::no_solution(
                "the output depends on the input of the same row; a plant needs a sample between them",
            ));
        }
        // z⁻¹·(D + r/(z − p)) = (D − r/p)·z⁻¹ + (r/p)/(z − p).
        let mut direct = model.direct.clone();
        let mut pairs = Vec::new();
        let mut lone: Vec<(f64, DMatrix<f64>)> = Vec::new();
        for (pole, residue) in model.poles.iter().zip(&model.residues) {
            if pole.norm() >= 1.0 || (pole.im == 0.0 && pole.re <= 0.0) {
                return Err(Error::no_solution(
                    "a pole of the fit is at half the sample rate or unstable, which no mode of a plant is; \
                     fit other modes",
                ));
            }
            let moved = residue.map(|r| r / *pole);
            let twice = if pole.im == 0.0 { 1.0 } else { 2.0 };
            direct -= moved.map(|r| twice * r.re);
            if pole.im == 0.0 {
                lone.push((pole.re, moved.map(|r| r.re)));
            } else {
                pairs.push((*pole, moved));
            }
        }
        let mut modes: Vec<HeldMode> = pairs
            .iter()
            .map(|(pole, residue)| {
                let second = residue.map(|r| r.conj());
                mode((*pole, residue), (pole.conj(), &second), period)
            })
            .collect::<Result<_, _>>()?;
        lone.sort_by(|a, b| b.0.total_cmp(&a.0));
        for two in lone.chunks(2) {
            let complex = |matrix: &DMatrix<f64>| matrix.map(|r| Complex::new(r, 0.0));
            let (p, r) = (Complex::new(two[0].0, 0.0), complex(&two[0].1));
            // A pole that is alone gets one twice as fast that carries nothing.
            let (q, s) = match two.get(1) {
                Some((q, s)) => (Complex::new(*q, 0.0), complex(s)),
                None => (p * p, r.map(|_| Complex::new(0.0, 0.0))),
            };
            modes.push(mode((p, &r), (q, &s), period)?);
        }
        modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        Ok(Self { period, direct, modes, delay: (samples - 1.0) * period, softening: None })
    }

    /// The linear plant at an amplitude relative to that of the softening.
    #[must_use]
    pub fn at_amplitude(&self, amplitude: f64) -> Self {
        let mut own = Self { softening: None, ..self.clone() };
        if let Some(softening) = &self.softening {
            let s = amplitude.powf(softening.exponent);
            let laws = softening.shift.iter().zip(&softening.growth);
            for (mode, (shift, growth)) in own.modes.iter_mut().zip(laws) {
                mode.frequency *= 1.0 + shift * s;
                mode.damping *= 1.0 + growth * s;
            }
        }
        own
    }

    /// The discrete model with the same outputs at the samples; of small motion.
    #[must_use]
    pub fn rational(&self) -> Rational {
        // r/(z − p) = z⁻¹·(r + r·p/(z − p)).
        let mut direct = self.direct.clone();
        let (mut poles, mut residues) = (Vec::new(), Vec::new());
        for mode in &self.modes {
            let t = Transition::new(mode.frequency, mode.damping, self.period);
            let (middle, half) = (0.5 * (t.same + t.rate), 0.5 * (t.same - t.rate));
            // Two poles that are one have no residues of their own.
            let square = half * half - t.cross * t.cross;
            let root = Complex::new(square, 0.0).sqrt();
            let root = if root.norm() < NEAREST { Complex::new(NEAREST, 0.0) } else { root };
            let rest = 1.0 - t.same;
            let residue = |p: Complex, other: Complex| {
                let slow = ((p - t.rate) * rest + t.cross * t.cross) / (p - other);
                let fast = ((p - t.same) * t.cross - t.cross * rest) / (p - other);
                mode.residue.zip_map(&mode.rate_residue, |r, q| slow * r + fast * q)
            };
            let (p, q) = (middle + root, middle - root);
            let all = if root.im == 0.0 { vec![(p, q), (q, p)] } else { vec![(p, q)] };
            let twice = if root.im == 0.0 { 1.0 } else { 2.0 };
            for (pole, other) in all {
                let own = residue(pole, other);
                direct += own.map(|r| twice * r.re);
                residues.push(own.map(|r| r * pole));
                poles.push(pole);
            }
        }
        let domain = Domain::Discrete(self.period);
        Rational { domain, poles, residues, direct, delay: self.delay + self.period }
    }

    /// The static gain, outputs × inputs.
    #[must_use]
    pub fn static_gain(&self) -> DMatrix<f64> {
        self.modes.iter().fold(self.direct.clone(), |sum, mode| sum + &mode.residue)
    }

    /// The checked blueprint: per axis the delay and the static gain of its own output, behind them the modes
    /// with matrices relative to these gains.
    ///
    /// # Errors
    /// [`Error::Model`] where there are not as many outputs as inputs, and with every problem of names or units.
    pub fn blueprint(&self, names: &PlantNames) -> Result<CheckedBlueprint, Error> {
        let refused = |message: String| Error::Model { name: names.model.clone(), message };
        let (outputs, inputs) = self.direct.shape();
        if outputs != inputs {
            return Err(refused(format!(
                "{inputs} inputs and {outputs} outputs: each axis of a plant has one of each; give as many"
            )));
        }
        let gain = self.static_gain();
        let own: Vec<f64> =
            (0..inputs).map(|k| Some(gain[(k, k)]).filter(|g| *g != 0.0).unwrap_or(1.0)).collect();
        let mut blueprint = Blueprint::new(Kind::Plant, &names.model, self.period);
        blueprint.description.clone_from(&names.description);
        for (axis, gain) in names.axes().zip(&own) {
            let axis = delay_of(self.delay).into_iter().fold(axis, AxisBlueprint::component);
            let axis =
                axis.component(ComponentBlueprint::new("actuator-gain").value("gain", *gain));
            blueprint = blueprint.axis(axis);
        }
        let rows = |matrix: &DMatrix<f64>| -> Vec<f64> {
            let relative = |i: usize, j: usize| matrix[(i, j)] / own[j];
            (0..outputs)
                .flat_map(|i| (0..inputs).map(move |j| (i, j)))
                .map(|(i, j)| relative(i, j))
                .collect()
        };
        let all = |of: fn(&HeldMode) -> &DMatrix<f64>| -> Vec<f64> {
            self.modes.iter().flat_map(|mode| rows(of(mode))).collect()
        };
        let each = |of: fn(&HeldMode) -> f64| -> Vec<f64> { self.modes.iter().map(of).collect() };
        let kind = if self.softening.is_some() { "softening-modes" } else { "modal-matrix" };
        let mut matrix = ComponentBlueprint::new(kind)
            .value("direct", rows(&self.direct))
            .value("frequency", each(|mode| mode.frequency))
            .value("damping", each(|mode| mode.damping))
            .value("residue", all(|mode| &mode.residue))
            .value("rate_residue", all(|mode| &mode.rate_residue));
        if let Some(softening) = &self.softening {
            // The component sees the inputs behind the axes' gains.
            let seen = softening.rms.iter().zip(&own).map(|(rms, gain)| rms * gain.abs());
            matrix = matrix
                .value("frequency_shift", softening.shift.clone())
                .value("damping_growth", softening.growth.clone())
                .value("amplitude", seen.collect::<Vec<f64>>())
                .value("exponent", softening.exponent)
                .value("time_constant", TIME_CONSTANT);
        }
        let coupled: Vec<&str> = names.outputs.iter().map(|(name, _)| name.as_str()).collect();
        blueprint = blueprint.coupling(&coupled, matrix);
        blueprint.check(components::COMPONENTS).map_err(|problems| refused(problems.to_string()))
    }
}

/// The mode with these two poles and residues in z.
fn mode(
    (p, r): (Complex, &DMatrix<Complex>),
    (q, s): (Complex, &DMatrix<Complex>),
    period: f64,
) -> Result<HeldMode, Error> {
    let (a, b) = (p.ln() / period, q.ln() / period);
    let omega = (a * b).re.sqrt();
    let (frequency, damping) = (omega / TAU, -(a + b).re / (2.0 * omega));
    if !(damping > 0.0 && omega * period < PI * 1e3) {
        return Err(Error::no_solution("a mode of the fit has no damping; fit fewer modes"));
    }
    let t = Transition::new(frequency, damping, period);
    // (zI − A)⁻¹·b with A = [same, cross; −cross, rate], b = (1 − same, cross): its residue at a pole.
    let weight = |pole: Complex, other: Complex| {
        let rest = 1.0 - t.same;
        let z = (pole - t.rate) * rest + t.cross * t.cross;
        let v = (pole - t.same) * t.cross - t.cross * rest;
        Vector2::new(z, v) / (pole - other)
    };
    let (w, x) = (weight(p, q), weight(q, p));
    let solved = Matrix2::new(w[0], w[1], x[0], x[1])
        .try_inverse()
        .ok_or(Error::no_solution("two poles of the fit are one; fit fewer modes"))?;
    let both = r.zip_map(s, |r, s| solved * Vector2::new(r, s));
    Ok(HeldMode {
        frequency,
        damping,
        residue: both.map(|c| c[0].re),
        rate_residue: both.map(|c| c[1].re),
    })
}

#[cfg(test)]
mod tests {
    use super::super::refine::functions;
    use super::*;

    /// Response of the plant in z, from its modes as they stand.
    fn response(plant: &HeldPlant, frequency: f64) -> DMatrix<Complex> {
        let z = Domain::Discrete(plant.period).variable(frequency);
        let mut sum = plant.direct.map(|d| Complex::new(d, 0.0) / z);
        for mode in &plant.modes {
            let (slow, fast) = functions(z, mode.frequency, mode.damping, plant.period);
            sum += mode.residue.zip_map(&mode.rate_residue, |r, q| slow * r + fast * q);
        }
        sum * Complex::from_polar(1.0, -TAU * frequency * plant.delay)
    }

    fn model(poles: Vec<Complex>, delay: f64) -> Rational {
        let residue = |k: usize, is_real: bool| {
            DMatrix::from_fn(2, 2, |i, j| {
                let re = 0.1 * (k + 1) as f64 - 0.07 * i as f64 + 0.03 * j as f64;
                Complex::new(re, if is_real { 0.0 } else { 0.2 - 0.1 * (i + j) as f64 })
            })
        };
        let residues = poles.iter().enumerate().map(|(k, p)| residue(k, p.im == 0.0)).collect();
        Rational {
            domain: Domain::Discrete(1e-3),
            poles,
            residues,
            direct: DMatrix::from_row_slice(2, 2, &[0.3, -0.1, 0.2, 0.4]),
            delay,
        }
    }

    #[test]
    fn modes_have_the_response_of_the_poles() {
        let pair = |r: f64, angle: f64| Complex::from_polar(r, angle);
        let real = |r: f64| Complex::new(r, 0.0);
        for (poles, samples) in [
            (vec![pair(0.97, 0.4), pair(0.9, 2.9)], 1.0),
            (vec![pair(0.97, 0.4), real(0.5)], 3.0),
            (vec![real(0.99), real(0.5), real(0.8), pair(0.6, 1.1)], 2.0),
        ] {
            let model = model(poles, samples * 1e-3);
            let plant = HeldPlant::of(&model).unwrap();
            assert_eq!(plant.delay, (samples - 1.0) * 1e-3);
            for frequency in [0.0, 3.0, 64.0, 200.0, 460.0] {
                let (own, expected) = (response(&plant, frequency), model.response(frequency));
                let error = (&own - &expected).norm() / expected.norm();
                assert!(error < 1e-10, "{frequency} Hz: {error:.1e} of {model:?}");
                let error =
                    (plant.rational().response(frequency) - &expected).norm() / expected.norm();
                assert!(error < 1e-10, "{frequency} Hz: {error:.1e} of {:?}", plant.rational());
            }
        }
    }

    #[test]
    fn a_plant_from_its_blueprint_moves_as_the_model() {
        let model = model(vec![Complex::from_polar(0.97, 0.4), Complex::new(0.5, 0.0)], 3e-3);
        let plant = HeldPlant::of(&model).unwrap();
        let signal = |name: &str| (name.to_owned(), "V".to_owned(), (-1.0, 1.0));
        let names = PlantNames {
            model: "mirror".into(),
            description: String::new(),
            inputs: vec![signal("u1"), signal("u2")],
            outputs: vec![("y1".into(), "um".into()), ("y2".into(), "um".into())],
        };
        let blueprint = plant.blueprint(&names).unwrap();
        let text = blueprint.blueprint().to_toml();
        let again = Blueprint::parse(&text, "again.toml").unwrap();
        let mut system = again.check(components::COMPONENTS).unwrap().build();
        let variable = |name: &str| blueprint.system().variables().find(name).unwrap();
        let signal = |k: usize, j: usize| {
            if k == 0 { 0.0 } else { ((k * (7 + 4 * j)) % 13) as f64 / 6.0 - 1.0 }
        };
        let inputs: Vec<Vec<f64>> =
            (0..2).map(|j| (0..300).map(|k| signal(k, j)).collect()).collect();
        let expected = model.simulate(&inputs, false).unwrap();
        system.initialise(0.0).unwrap();
        for k in 0..300 {
            if k > 0 {
                for (j, name) in ["command[1]", "command[2]"].iter().enumerate() {
                    system.set(variable(name), inputs[j][k - 1]).unwrap();
                }
                system.advance(k as f64 * 1e-3).unwrap();
            }
            for (i, name) in ["position[1]", "position[2]"].iter().enumerate() {
                // µm in the FMU, µm in the model.
                let y = system.get(variable(name)).unwrap();
                assert!((y - expected[i][k]).abs() < 1e-12, "row {k}: {y} for {}", expected[i][k]);
            }
        }
    }

    #[test]
    fn poles_that_no_mode_has_are_refused() {
        for pole in [Complex::new(-0.5, 0.0), Complex::from_polar(1.01, 0.3)] {
            assert!(HeldPlant::of(&model(vec![pole], 1e-3)).is_err(), "{pole}");
        }
        let prompt = model(vec![Complex::from_polar(0.9, 0.4)], 0.0);
        assert!(HeldPlant::of(&prompt).is_err());
    }
}
