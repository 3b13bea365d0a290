//! A controller from a plant: what undoes its hysteresis, amplifier and sensor as feedforward, a PID loop, and
//! a coordinator where axes are coupled; then run on the plant itself.

use data::CheckedBlueprint;
use identify::learned::InverseFigures;
use identify::{Error, NotInvertible, Observer, SettingsProblem};
use model::{Kind, NodeSpec, SystemSpec};
use serde::Serialize;

use crate::analysis::analyse;
use crate::axis::axis_design;
use crate::check::Check;
use crate::coupled_loop::CoupledFigures;
use crate::damping::{Damping, DampingFigures};
use crate::design::{CommandActs, Feedback};
use crate::feedforward::Feedforward;
use crate::learned_axis::sample_time;
use crate::linearised::setting;
use crate::preview::PreviewFigures;
use crate::work::Work;

/// Most internal steps of the plant in one period.
const SUBSTEPS: (f64, f64) = (50.0, 1e4);

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
    /// How the feedforward is made.
    pub feedforward: Feedforward,
    /// The law that acts on the error.
    pub feedback: Feedback,
    /// How the first resonance is damped, in an inner loop; the law is then PID or PI.
    pub damping: Damping,
    /// When a command acts: what the margins allow for.
    pub acts: CommandActs,
    /// Whether coupled axes are controlled in pairs (two a mirror), each by its own sensor only.
    pub independent: bool,
    /// Whether a controller that errs more than feedback alone on its own plant is given all the same.
    pub force: bool,
}

impl Default for ControlSettings {
    fn default() -> Self {
        Self {
            name: None,
            period: None,
            band: None,
            sensitivity: 1.5,
            noise: 10.0,
            feedforward: Feedforward::Automatic,
            feedback: Feedback::Pid,
            damping: Damping::None,
            acts: CommandActs::Either,
            independent: false,
            force: false,
        }
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
    /// The coordinators of coupled axes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coordinators: Vec<Coordinator>,
}

/// What is known of a coordinator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coordinator {
    /// Names of the axes.
    pub axes: Vec<String>,
    /// Types of the couplings that it undoes.
    pub couplings: Vec<String>,
    /// Condition number of the Jacobian.
    pub condition: f64,
    /// The loop of all its axes, where the coupling has dynamics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupled_loop: Option<CoupledFigures>,
    /// The inverse of the coupling's dynamics, where one is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preview: Option<PreviewFigures>,
    /// What the coordinator does not undo; empty where the coupling is static and straight.
    pub note: String,
}

/// The loop of one axis, on the plant linearised at its steepest slope with all its linear components. Margins
/// and sensitivity are the worst over the plant as given and with the modes' frequencies 10 % lower and higher,
/// with the command acting at once and one period later ([`CommandActs`]), and hold for every smaller slope of
/// the hysteresis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopFigures {
    /// Name of the axis.
    pub axis: String,
    /// What the feedforward is.
    pub feedforward: String,
    /// What the feedback does.
    pub shape: String,
    /// Steepest slope in position (motion where axes are coupled by optics) per command.
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
    /// Mean time from a command to the position in s, with all linear components and half a period of hold.
    pub delay: f64,
    /// Least and greatest position that the command's bounds always allow, also after the opposite
    /// bound was visited, as simulated; of coupled axes, that all of them may use at once.
    pub reach: (f64, f64),
    /// The inner loop that damps the first resonance, where there is one. Margins and sensitivity are then those of
    /// the whole loop over the plants of its grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<DampingFigures>,
    /// What the controller does on its own plant.
    pub checks: Vec<Check>,
    /// What is left to feedback, and what it costs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_to_feedback: Vec<String>,
    /// The inverse, where it was learned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inverse: Option<InverseFigures>,
}

/// Makes the controller of a plant: for each axis `reference-lead` where the plant has linear parts with memory,
/// what undoes the plant's static parts, creep and hysteresis ([`Feedforward`]), and `pid` with the limits of the
/// command; `jacobian-coordinator` in front of coupled axes. The feedback is, of several shapes (integral;
/// integral with a proportional part against the lags; PID that inverts or damps the lowest mode), the one with
/// the largest integral gain whose sensitivity and noise stay below their limits. Of several ways of feedforward
/// the one is taken that errs least on the plant itself.
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
    check_settings(settings, period, learned.is_some())?;
    if spec.kind != Kind::Plant {
        let reason = "is a controller; give the blueprint of a plant".to_owned();
        return Err(refused(vec![NotInvertible { place: spec.name.clone(), reason }]));
    }
    if settings.damping != Damping::None
        && !matches!(settings.feedback, Feedback::Pid | Feedback::Pi)
    {
        let reason = format!(
            "--damping {} is designed together with PID or PI, not with {}; take --feedback pid or pi",
            settings.damping.name(),
            settings.feedback.name()
        );
        return Err(refused(vec![NotInvertible { place: spec.name.clone(), reason }]));
    }
    let step = step_of(spec, period)
        .map_err(|reason| refused(vec![NotInvertible { place: spec.name.clone(), reason }]))?;
    let analysed = analyse(plant, (step, period)).map_err(refused)?;
    if settings.damping != Damping::None && analysed.groups.iter().any(|group| group.is_dynamic) {
        let reason = format!(
            "--damping {} damps the mode of a single axis, but a coupling with dynamics joins these axes; they get notches \
             that are designed for all of them together; leave --damping out",
            settings.damping.name()
        );
        return Err(refused(vec![NotInvertible { place: spec.name.clone(), reason }]));
    }
    let mut reasons = Vec::new();
    let mut designs = Vec::new();
    for index in 0..spec.axes.len() {
        match axis_design(plant, &analysed, index, settings, (step, period)) {
            Ok(found) => designs.push(found),
            Err(found) => reasons.extend(found.into_iter().map(|reason| NotInvertible {
                place: format!("axis {}", spec.axes[index].name),
                reason,
            })),
        }
    }
    if !reasons.is_empty() {
        return Err(refused(reasons));
    }
    let (coupled, previews) = (Vec::new(), Vec::new());
    let mut work =
        Work { plant, settings, analysed: &analysed, designs, step, period, coupled, previews };
    work.couple()?;
    let runs = work.slowed()?;
    work.learn(observer)?;
    work.choose(&runs, observer)?;
    work.finish(&runs)
}

pub(crate) fn refused(reasons: Vec<NotInvertible>) -> Error {
    Error::NotInvertible(reasons)
}

fn check_settings(settings: &ControlSettings, period: f64, learned: bool) -> Result<(), Error> {
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

/// The internal step with which the plant is looked at: its own, but no more than 50 of them in a period. Linear
/// parts are exact at any step; what has a sample time of its own keeps it.
pub(crate) fn step_of(spec: &SystemSpec, period: f64) -> Result<f64, String> {
    let nodes = spec.axes.iter().flat_map(|axis| &axis.components);
    let sampled = |node: &NodeSpec| node.enabled && setting(node, "sample_time").is_some();
    let steps = (period / spec.period).round().max(1.0);
    if nodes.clone().any(sampled) {
        if steps > SUBSTEPS.1 {
            return Err(format!(
                "a period of {period} s has {steps:.3e} internal steps of a plant with its own sample time; \
                 give at most {} s",
                SUBSTEPS.1 * spec.period
            ));
        }
        return Ok(spec.period.min(period));
    }
    Ok(if steps > SUBSTEPS.0 { period / SUBSTEPS.0 } else { spec.period.min(period) })
}
