//! A controller from a plant: the inverse of its hysteresis as feedforward, exact or learned from what a
//! learned hysteresis answers, and a PID loop.

use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, SignalBlueprint};
use model::{AxisSpec, Kind};
use serde::Serialize;

use identify::{Error, NotInvertible, SettingsProblem};

use super::learned_axis::{LearnedAxis, sample_time};
use super::linearised::{
    Actuation, Operator, delays, impulse_response, lags, linear_axis, modes, operator,
};
use super::loop_shape::{Limits, Response, Shape, Shaped, shape};
use super::undone::Undone;
use identify::Observer;
use identify::learned::{InverseFigures, Machine, inverse};

/// Relative shifts of the modes' frequencies for which the loop keeps its margins.
const SHIFTS: [f64; 3] = [1.0, 0.9, 1.1];

/// Time constants of the derivative's filter that are tried, over that of the lowest mode.
const FILTERS: [f64; 4] = [0.0, 0.05, 0.15, 0.4];
/// Frequencies of the zeros of a PID that damps a mode, relative to the mode's.
const ZERO_FREQUENCIES: [f64; 7] = [0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8];
/// Damping ratios of these zeros.
const ZERO_DAMPINGS: [f64; 5] = [0.5, 0.7, 1.0, 1.5, 2.5];

/// Proportional parts that are tried on a learned linear part, in samples of lag.
const PROPORTIONAL: [f64; 8] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// Choices about a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlSettings {
    /// Name of the controller; `None`: the plant's with `_controller` behind it.
    pub name: Option<String>,
    /// Sample time in s; `None`: that of what was learned, else the plant's internal step.
    pub period: Option<f64>,
    /// Greatest frequency in Hz of the commands that a learned inverse is learned from; `None`: the
    /// bandwidth of the learned linear part, but at least 50 samples a wave.
    pub band: Option<f64>,
    /// Largest sensitivity |1/(1 + L)| that the loop may have, above 1. It implies a gain margin of
    /// M/(M−1) and a phase margin of 2·asin(1/2M): 3 and 39° for the default of 1.5.
    pub sensitivity: f64,
    /// Most that white sensor noise may be amplified on its way to the command, with the command
    /// expressed as the position that it stands for: standard deviation over standard deviation.
    pub noise: f64,
}

impl Default for ControlSettings {
    fn default() -> Self {
        Self { name: None, period: None, band: None, sensitivity: 1.5, noise: 10.0 }
    }
}

/// A controller and what is known of its loops.
#[derive(Clone, Debug, Serialize)]
pub struct Inversion {
    /// The controller, ready to be written.
    #[serde(skip)]
    pub controller: CheckedBlueprint,
    /// The loop of each axis.
    pub axes: Vec<LoopFigures>,
}

/// The loop of one axis, on the plant linearised at its steepest slope, with one period for
/// computing. Margins and sensitivity are the worst over the plant as given and with the modes'
/// frequencies 10 % lower and higher, and hold for every smaller slope of the hysteresis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopFigures {
    /// Name of the axis.
    pub axis: String,
    /// What the feedback does.
    pub shape: String,
    /// Steepest slope in position per command.
    pub slope: f64,
    /// Proportional gain in command per position.
    pub kp: f64,
    /// Integral gain in command per position and second.
    pub ki: f64,
    /// Derivative gain in command-seconds per position.
    pub kd: f64,
    /// Time constant of the derivative's filter in s.
    pub derivative_filter: f64,
    /// Lowest frequency at which the loop gain is 1, in Hz.
    pub bandwidth: f64,
    /// By how much the loop gain may grow before the loop becomes unstable.
    pub gain_margin: f64,
    /// In degrees.
    pub phase_margin: f64,
    /// Greatest |1/(1 + L)|.
    pub sensitivity: f64,
    /// Standard deviation of the command per standard deviation of white sensor noise, without the
    /// loop's answer.
    pub noise_gain: f64,
    /// Least and greatest position that the command's bounds always allow, also after the opposite
    /// bound was visited.
    pub reach: (f64, f64),
    /// The inverse, where it was learned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inverse: Option<InverseFigures>,
}

/// Makes the controller of a plant: for each axis `reference-lead` where the plant has lags or modes,
/// `inverse-prandtl-ishlinskii` (for a linear actuator `feedforward-gain`; for `lssvm-stops` the inverse of its
/// discrete linear part, `arx`, and `lssvm-stops-inverse`), and `pid` with the limits of the command. The feedback is, of several
/// shapes (integral; integral with a proportional part against the lags; PID that inverts or damps
/// the lowest mode), the one with the largest integral gain whose sensitivity and noise stay below
/// their limits.
///
/// # Errors
/// [`Error::Settings`]; [`Error::NotInvertible`] with every reason on every axis; [`Error::Model`]
/// where the controller's names do not fit; [`Error::Stopped`] where the observer asks to stop.
pub fn invert(
    plant: &CheckedBlueprint,
    settings: &ControlSettings,
    observer: &mut dyn Observer,
) -> Result<Inversion, Error> {
    let spec = plant.spec();
    let learned = sample_time(&spec.axes);
    let period = settings.period.or(learned).unwrap_or(spec.period);
    check(settings, period, learned.is_some())?;
    if spec.kind != Kind::Plant {
        return Err(Error::NotInvertible(vec![NotInvertible {
            place: spec.name.clone(),
            reason: "is a controller; give the blueprint of a plant".to_owned(),
        }]));
    }
    let mut reasons = Vec::new();
    let mut loops = Vec::new();
    for (index, axis) in spec.axes.iter().enumerate() {
        match axis_loop(plant, index, period, settings) {
            Ok(found) => loops.push((axis, found)),
            Err(found) => reasons.extend(
                found
                    .into_iter()
                    .map(|reason| NotInvertible { place: format!("axis {}", axis.name), reason }),
            ),
        }
    }
    if !reasons.is_empty() {
        return Err(Error::NotInvertible(reasons));
    }
    let name = settings.name.clone().unwrap_or_else(|| format!("{}_controller", spec.name));
    let mut controller = Blueprint::new(Kind::Controller, &name, period);
    let mut figures = Vec::new();
    for ((axis, (actuation, shaped)), blueprint) in loops.iter().zip(&plant.blueprint().axes) {
        let mut found = loop_figures(axis, actuation, shaped, period);
        let chain = match actuation {
            Actuation::Operator(operator) => {
                let lead = lead(axis, None, period, found.reach);
                lead.into_iter().chain([feedforward(operator)]).collect()
            }
            Actuation::Learned(learned) => {
                let inverted = learned_inverse(learned, settings, &axis.name, observer)?;
                found.inverse = Some(inverted.1);
                let file = format!("{}.npy", axis.name);
                let table = inverted.0.table().map_err(|message| Error::Learned { message })?;
                controller.tables.insert(file.clone(), table);
                let inverse = inverted.0.component(true, &file, period);
                let undone = Undone::of(&learned.linear, period);
                let lead = lead(axis, Some(&undone), period, found.reach);
                lead.into_iter().chain(filter(&undone, period)).chain([inverse]).collect()
            }
        };
        controller.axes.push(controller_axis(axis, blueprint, actuation, chain, &found));
        figures.push(found);
    }
    controller.description = format!("Inverse feedforward and PID for {}", spec.name);
    controller.source = format!("inverted from {}", plant.blueprint().source);
    let controller = controller
        .check(learned::COMPONENTS)
        .map_err(|problems| Error::Model { name, message: problems.to_string() })?;
    Ok(Inversion { controller, axes: figures })
}

fn check(settings: &ControlSettings, period: f64, learned: bool) -> Result<(), Error> {
    let mut problems = Vec::new();
    if let Some(value) = settings.band.filter(|_| !learned) {
        let rule = "is for plants that were learned (lssvm-stops); leave it out";
        problems.push(SettingsProblem { setting: "band", value, rule });
    }
    if !(period.is_finite() && period > 0.0) {
        let rule = "the controller's sample time is a positive time in s";
        problems.push(SettingsProblem { setting: "period", value: period, rule });
    }
    if !(settings.sensitivity > 1.0 && settings.sensitivity <= 10.0) {
        let rule = "lies above 1 and up to 10; 1.2 is cautious, 1.5 usual, 2 brisk";
        let value = settings.sensitivity;
        problems.push(SettingsProblem { setting: "sensitivity", value, rule });
    }
    if settings.noise.is_nan() || settings.noise <= 0.0 {
        let rule = "is above 0; 10 is usual, 3 suits a coarse sensor";
        problems.push(SettingsProblem { setting: "noise", value: settings.noise, rule });
    }
    if problems.is_empty() { Ok(()) } else { Err(Error::Settings(problems)) }
}

/// The inverse of a learned axis, and what is known of it.
fn learned_inverse(
    learned: &LearnedAxis,
    settings: &ControlSettings,
    name: &str,
    observer: &mut dyn Observer,
) -> Result<(Machine, InverseFigures), Error> {
    let at_axis = |reason: String| {
        Error::NotInvertible(vec![NotInvertible { place: format!("axis {name}"), reason }])
    };
    let purpose = learned.purpose(settings.band).map_err(at_axis)?;
    inverse::learn(&learned.forward, &purpose, observer).map_err(|error| match error {
        Error::Stopped => error,
        error => at_axis(error.to_string()),
    })
}

/// The component of the filter, where it does anything.
fn filter(undone: &Undone, period: f64) -> Option<ComponentBlueprint> {
    let none: &[f64] = &[0.0];
    let a = if undone.filter.a.is_empty() { none } else { &undone.filter.a };
    undone.filters().then(|| {
        ComponentBlueprint::new("arx")
            .value("sample_time", period)
            .value("b", &undone.filter.b[..])
            .value("a", a)
            .note("the plant's discrete linear part, undone")
    })
}

fn axis_loop(
    plant: &CheckedBlueprint,
    index: usize,
    period: f64,
    settings: &ControlSettings,
) -> Result<(Actuation, Shaped), Vec<String>> {
    let spec = plant.spec();
    let axis = &spec.axes[index];
    let actuation = match LearnedAxis::of(plant, index, period)? {
        Some(learned) => Actuation::Learned(Box::new(learned)),
        None => Actuation::Operator(operator(axis)?),
    };
    let (low, high) = axis.command_range;
    if !(low.is_finite() && high.is_finite() && low < high) {
        return Err(vec![format!(
            "the command's bounds are {low} to {high}, and a controller needs limits; give min and \
             max of the command"
        )]);
    }
    let (modes, fixed) = (modes(axis), actuation.modes());
    let shifts = if modes.is_empty() { &SHIFTS[..1] } else { &SHIFTS[..] };
    // A plant identified from a slow log is looked at on the controller's grid: its linear parts are
    // exact at any step.
    let step = spec.period.min(period);
    let mut variants = Vec::new();
    for shift in shifts {
        let linear = linear_axis(axis, &actuation, *shift);
        let impulse = impulse_response(linear, step, period).map_err(|reason| vec![reason])?;
        let shifted = modes.iter().map(|(frequency, _)| frequency * shift);
        let shifted: Vec<f64> = shifted.chain(fixed.iter().map(|mode| mode.0)).collect();
        variants.push(Response::new(&impulse, period, &shifted));
    }
    let slope = actuation.slope();
    let limits = Limits { sensitivity: settings.sensitivity, noise: settings.noise };
    let loops = shapes(axis, &actuation, period)
        .into_iter()
        .filter_map(|s| shape(&variants, s, slope, limits));
    let best = loops.max_by(|a, b| a.ki.abs().total_cmp(&b.ki.abs()));
    let best = best.ok_or_else(|| {
        vec![
            "no feedback gain keeps the margins; allow a larger sensitivity or a shorter period"
                .to_owned(),
        ]
    })?;
    Ok((actuation, best))
}

/// The shapes that suit the axis.
fn shapes(axis: &AxisSpec, actuation: &Actuation, period: f64) -> Vec<Shape> {
    let omega = |frequency: f64| core::f64::consts::TAU * frequency;
    let (mut modes, lags) = (modes(axis), lags(axis));
    modes.extend(actuation.modes());
    let lag: f64 = lags.iter().sum::<f64>()
        + modes.iter().map(|(f, zeta)| 2.0 * zeta / omega(*f)).sum::<f64>();
    let mut shapes = vec![Shape { name: "integral", a: 0.0, b: 0.0, filter: 0.0 }];
    if lag > 0.0 {
        shapes.push(Shape {
            name: "integral, with the lags cancelled",
            a: lag,
            b: 0.0,
            filter: 0.0,
        });
    }
    if matches!(actuation, Actuation::Learned(_)) {
        // The lag that a discrete linear part stands for is tried.
        let name = "integral and proportional";
        let tried =
            PROPORTIONAL.map(|samples| Shape { name, a: samples * period, b: 0.0, filter: 0.0 });
        shapes.extend(tried);
    }
    let lowest = modes.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((frequency, damping)) = lowest {
        let omega = omega(*frequency);
        let second_order = |name, omega: f64, damping: f64, filter| Shape {
            name,
            a: 2.0 * damping / omega,
            b: 1.0 / (omega * omega),
            filter,
        };
        for filter in FILTERS.map(|relative| relative / omega) {
            shapes.push(second_order("PID that inverts the lowest mode", omega, *damping, filter));
            for (relative, damping) in ZERO_FREQUENCIES.into_iter().flat_map(with_dampings) {
                let name = "PID that damps the lowest mode";
                shapes.push(second_order(name, relative * omega, damping, filter));
            }
        }
    }
    shapes
}

fn with_dampings(frequency: f64) -> impl Iterator<Item = (f64, f64)> {
    ZERO_DAMPINGS.into_iter().map(move |damping| (frequency, damping))
}

fn loop_figures(
    axis: &AxisSpec,
    actuation: &Actuation,
    shaped: &Shaped,
    period: f64,
) -> LoopFigures {
    let Shaped { shape, ki, .. } = *shaped;
    let (kp, kd) = (ki * shape.a, ki * shape.b);
    let ends = actuation.reach(axis.command_range);
    LoopFigures {
        axis: axis.name.clone(),
        shape: shape.name.to_owned(),
        slope: actuation.slope(),
        kp,
        ki,
        kd,
        derivative_filter: shape.filter,
        bandwidth: shaped.bandwidth,
        gain_margin: shaped.gain_margin,
        phase_margin: shaped.phase_margin.to_degrees(),
        sensitivity: shaped.sensitivity,
        noise_gain: ki.abs() * shape.noise(period),
        reach: (ends.0.min(ends.1), ends.0.max(ends.1)),
        inverse: None,
    }
}

/// What the feedforward adds to the reference for the linear parts of the path, to second order in
/// the frequency: the product of `1 + τs` for each lag, `e^{ds}` for each delay and for the one
/// period until the position answers, `1 + 2ζs/ω + s²/ω²` for each mode, and what a filter in front of the
/// inverse leaves to it. `None` where there are none but the period.
fn lead(
    axis: &AxisSpec,
    undone: Option<&Undone>,
    period: f64,
    reach: (f64, f64),
) -> Option<ComponentBlueprint> {
    let (modes, lags, delays) = (modes(axis), lags(axis), delays(axis));
    let undone = undone.filter(|undone| undone.filters());
    let none = modes.is_empty() && lags.iter().chain(&delays).all(|time| *time == 0.0);
    if none && undone.is_none() {
        return None;
    }
    let (mut first, mut second) = (period, 0.5 * period * period);
    let mut times = |a: f64, b: f64| (first, second) = (first + a, second + a * first + b);
    if let Some(undone) = undone {
        times(undone.lag, undone.inertia);
    }
    for lag in lags {
        times(lag, 0.0);
    }
    for delay in delays {
        times(delay, 0.5 * delay * delay);
    }
    for (frequency, damping) in modes {
        let omega = core::f64::consts::TAU * frequency;
        times(2.0 * damping / omega, 1.0 / (omega * omega));
    }
    let limit = 0.5 * (reach.1 - reach.0);
    let component = ComponentBlueprint::new("reference-lead");
    let (lag, inertia) = (first.max(0.0), second.max(0.0));
    Some(component.value("lag", lag).value("inertia", inertia).value("limit", limit))
}

/// The exact inverse of an operator.
fn feedforward(operator: &Operator) -> ComponentBlueprint {
    if operator.linear {
        ComponentBlueprint::new("feedforward-gain")
            .value("gain", 1.0 / operator.slope())
            .value("offset", operator.offset)
    } else {
        ComponentBlueprint::new("inverse-prandtl-ishlinskii")
            .value("r", &operator.r)
            .value("w", &operator.w)
            .value("offset", operator.offset)
    }
}

fn controller_axis(
    axis: &AxisSpec,
    plant: &AxisBlueprint,
    actuation: &Actuation,
    chain: Vec<ComponentBlueprint>,
    figures: &LoopFigures,
) -> AxisBlueprint {
    let (low, high) = axis.command_range;
    let note = format!(
        "{}: loop gain 1 at {:.4} Hz, gain margin {:.1}, phase margin {:.0} deg, maximum sensitivity \
         {:.2}",
        figures.shape,
        figures.bandwidth,
        figures.gain_margin,
        figures.phase_margin,
        figures.sensitivity
    );
    let pid = ComponentBlueprint::new("pid")
        .value("kp", figures.kp)
        .value("ki", figures.ki)
        .value("kd", figures.kd)
        .value("derivative_filter", figures.derivative_filter)
        .value("output_min", low)
        .value("output_max", high)
        .note(&note);
    let mut controller = AxisBlueprint::new(&axis.name, &axis.command_unit, &axis.position_unit);
    controller.command = controller.command.named(&plant.command.name).between(low, high);
    (controller.position.min, controller.position.max) =
        (plant.position.min.clone(), plant.position.max.clone());
    let position = &plant.position.name;
    controller.reference = SignalBlueprint::default().start(actuation.at_rest(axis.start));
    if !position.is_empty() {
        controller.reference = controller.reference.named(&format!("{position}_reference"));
        controller.measured = SignalBlueprint::default().named(position);
    }
    controller.components = chain;
    controller.component(pid)
}
