//! A controller from a plant: what undoes its hysteresis, amplifier and sensor as feedforward, a PID loop, and
//! a coordinator where axes are coupled; then run on the plant itself.

use data::CheckedBlueprint;
use identify::{Error, NotInvertible, Observer, SettingsProblem};
use model::{Kind, NodeSpec, SystemSpec};

use crate::analysis::analyse;
use crate::axis::axis_design;
use crate::damping::Damping;
use crate::design::Feedback;
use crate::inversion::{ControlSettings, Inversion, refused};
use crate::learned_axis::sample_time;
use crate::linearised::setting;
use crate::work::Work;

/// Most internal steps of the plant in one period.
const SUBSTEPS: (f64, f64) = (50.0, 1e4);

/// Makes the controller of a plant: for each axis `reference-lead` where the plant has linear parts with memory,
/// what undoes the plant's static parts, creep and hysteresis ([`Feedforward`](crate::Feedforward)), and `pid` with the
/// limits of the command; `jacobian-coordinator` in front of coupled axes. The feedback is, of several shapes (integral;
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
