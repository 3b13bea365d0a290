//! The page of a controller: margins, loop, sensitivity, step and waves on its own plant.

use core::f64::consts::TAU;

use control::{AxisResponses, FrequencyCurves, LoopFigures, TimeRun};
use identify::frequency::Complex;
use report::{
    Axis, Bode, Column, KeyFigure, Provenance, Report, Role, Section, Spectrum, Table, TimeSeries,
    Value, Verdict, XyLoop, format_number,
};

use super::{differences, greatest, polar, rms, sensitivities};
use crate::results::invert::{Inverted, Shown};

/// How far a Nyquist plot reaches from zero.
const REACH: f64 = 2.5;
/// Points of a circle.
const CIRCLE: usize = 180;

/// The page of a controller.
pub(crate) fn inversion(result: &Inverted, provenance: Provenance) -> Report {
    let title = format!("Controller {}", result.blueprint.display());
    let mut page = Report::new("invert", title, verdict(result)).provenance(provenance);
    for (axis, shown) in result.axes.iter().zip(&result.responses) {
        for note in &shown.responses.notes {
            page = page.warning(format!("Axis {}: {note}", axis.axis));
        }
        if shown.responses.curves.is_none() {
            continue;
        }
        let name = |what: &str| format!("Axis {}: {what}", axis.axis);
        let number = |x: f64| format_number(x, 3);
        let margins = format!(
            "gain margin {}, phase margin {}°, bandwidth {} Hz",
            number(axis.gain_margin),
            number(axis.phase_margin),
            number(axis.bandwidth)
        );
        let figure = KeyFigure::new(name("sensitivity, max |S|"), axis.sensitivity, "");
        page = page.key_figure(figure.at_most(shown.allowed).note(margins));
    }
    page = page.section(design(result));
    for (axis, shown) in result.axes.iter().zip(&result.responses) {
        page = page.section(frequency(axis, shown)).section(time(axis, shown));
    }
    page
}

fn verdict(result: &Inverted) -> Verdict {
    let errors = result.axes.iter().filter_map(|axis| Some((axis, axis.checks.first()?)));
    let worst = errors.max_by(|a, b| a.1.closed_loop.total_cmp(&b.1.closed_loop));
    let Some((axis, check)) = worst else {
        return Verdict::neutral("The controller was written and not run on its plant.");
    };
    let number = |x: f64| format_number(x, 3);
    let sentence = format!(
        "Along a wave of {} Hz over {} % of its reach the error of the controller on its own plant is {} % of it (rms), that of feedback alone {} %{}.",
        number(check.frequency),
        number(100.0 * check.swing),
        number(100.0 * check.closed_loop),
        number(100.0 * check.feedback),
        if result.axes.len() > 1 {
            format!(" (axis {}, the worst)", axis.axis)
        } else {
            String::new()
        }
    );
    let is_better = check.closed_loop <= check.feedback;
    if is_better { Verdict::pass(sentence) } else { Verdict::caution(sentence) }
}

/// Gains, margins and errors of all axes.
fn design(result: &Inverted) -> Section {
    let columns = [
        Column::new("axis"),
        Column::new("feedback"),
        Column::new("feedforward"),
        Column::new("kp"),
        Column::new("ki").unit("1/s"),
        Column::new("kd").unit("s"),
        Column::new("bandwidth").unit("Hz"),
        Column::new("gain margin"),
        Column::new("phase margin").unit("deg"),
        Column::new("max |S|"),
        Column::new("noise gain"),
        Column::new("delay").unit("s"),
    ];
    let mut gains = Table::new("Gains, in command per position, and margins", columns);
    for axis in &result.axes {
        gains = gains.row([
            Value::from(axis.axis.as_str()),
            axis.shape.as_str().into(),
            axis.feedforward.as_str().into(),
            axis.kp.into(),
            axis.ki.into(),
            axis.kd.into(),
            axis.bandwidth.into(),
            axis.gain_margin.into(),
            axis.phase_margin.into(),
            axis.sensitivity.into(),
            axis.noise_gain.into(),
            axis.delay.into(),
        ]);
    }
    let columns = [
        Column::new("axis"),
        Column::new("wave").unit("Hz"),
        Column::new("controller").unit("% of reach"),
        Column::new("feedforward alone").unit("% of reach"),
        Column::new("feedback alone").unit("% of reach"),
    ];
    let mut checks = Table::new("Rms errors of the check on its own plant", columns);
    for axis in &result.axes {
        for check in &axis.checks {
            checks = checks.row([
                Value::from(axis.axis.as_str()),
                check.frequency.into(),
                (100.0 * check.closed_loop).into(),
                check.feedforward.map(|error| 100.0 * error).into(),
                (100.0 * check.feedback).into(),
            ]);
        }
    }
    let mut notes: Vec<String> = Vec::new();
    for axis in &result.axes {
        notes
            .extend(axis.left_to_feedback.iter().map(|left| format!("axis {}: {left}", axis.axis)));
    }
    for coordinator in &result.coordinators {
        let mut text = format!(
            "{}: coordinated through their Jacobian, condition number {}",
            coordinator.axes.join(", "),
            format_number(coordinator.condition, 3)
        );
        if let Some(found) = &coordinator.coupled_loop {
            text += &format!(
                "; all axes together: greatest singular value of the sensitivity {}, gain margin {}, stable on {} plants",
                format_number(found.sensitivity, 3),
                format_number(found.gain_margin, 3),
                found.plants
            );
        }
        notes.push(text);
    }
    for along in &result.along {
        notes.push(format!(
            "axis {} along the reference: rms error {} % of its range, greatest {} %",
            along.axis,
            format_number(100.0 * along.error, 3),
            format_number(100.0 * along.greatest, 3)
        ));
    }
    let section = Section::new("The design").table(gains).table(checks);
    if notes.is_empty() { section } else { section.list(notes) }
}

/// Open loop, Nyquist plot, sensitivity.
fn frequency(axis: &LoopFigures, shown: &Shown) -> Section {
    let section = Section::new(format!("Axis {}: the loop over frequency", axis.axis));
    let Some(curves) = &shown.responses.curves else {
        return section.paragraph("The axis has no feedback: there is no loop.");
    };
    let mut text = format!(
        "Computed from the controller as it is written: L = C·G with the plant at its steepest slope, S = 1/(1 + L). L \
         and T are those of the plant as given with the later command; the worst |S| is that of {} plants (modes up to \
         10 % off, commands that act at once and a period later where either is allowed{}).",
        curves.plants,
        if axis.damping.is_some() { ", damping halved and doubled, three slopes" } else { "" }
    );
    if curves.is_coupled {
        text += " A coupling with dynamics joins this axis to others: these curves are those of the axis alone; the margins of all axes together are under the design.";
    }
    section
        .paragraph(text)
        .figure(bode(axis, curves))
        .figure(nyquist(shown, curves))
        .figure(sensitivity(axis, shown, curves))
}

fn bode(axis: &LoopFigures, curves: &FrequencyCurves) -> Bode {
    let (magnitude, phase) = polar(&curves.open);
    let f = &curves.frequency;
    let figure =
        Bode::new("Open loop L", "1").response(Role::Model, "L", f, &magnitude, &phase, None);
    figure.marker(axis.bandwidth, "loop gain 1").caption(format!(
        "Over all plants: gain margin {}, phase margin {}°.",
        format_number(axis.gain_margin, 3),
        format_number(axis.phase_margin, 3)
    ))
}

fn nyquist(shown: &Shown, curves: &FrequencyCurves) -> XyLoop {
    let near: Vec<Complex> = curves.open.iter().map(|l| l * (REACH / l.norm()).min(1.0)).collect();
    let x: Vec<f64> = near.iter().map(|l| l.re).collect();
    let y: Vec<f64> = near.iter().map(|l| l.im).collect();
    let turn = |k: usize| TAU * k as f64 / CIRCLE as f64;
    let radius = 1.0 / shown.allowed;
    let round: Vec<f64> = (0..=CIRCLE).map(|k| radius * turn(k).cos() - 1.0).collect();
    let up: Vec<f64> = (0..=CIRCLE).map(|k| radius * turn(k).sin()).collect();
    let figure = XyLoop::new("Nyquist plot", Axis::new("Re L", "1"), Axis::new("Im L", "1"));
    figure
        .model("L", &x, &y)
        .line(Role::Reference, format!("|S| = {}", format_number(shown.allowed, 3)), &round, &up)
        .equal_scale()
        .caption(format!(
            "The curve stays outside of the circle around -1, within which |S| is larger than allowed. Where |L| is above \
             {REACH}, the curve is drawn at {REACH}."
        ))
}

fn sensitivity(axis: &LoopFigures, shown: &Shown, curves: &FrequencyCurves) -> Spectrum {
    let own = sensitivities(&curves.open);
    let closed: Vec<f64> = curves.closed.iter().map(|t| t.norm()).collect();
    let f = &curves.frequency;
    let figure = Spectrum::new("Sensitivity and closed loop", Axis::new("|S|, |T|", "1"))
        .trace(Role::Model, "|S|", f, &own)
        .trace(Role::Residual, "worst |S|", f, &curves.worst)
        .trace(Role::Other, "|T|, feedback alone", f, &closed)
        .limit(shown.allowed, "allowed |S|");
    match &axis.damping {
        Some(damping) => figure.marker(damping.resonance, "resonance"),
        None => figure,
    }
}

/// Step and waves.
fn time(axis: &LoopFigures, shown: &Shown) -> Section {
    let AxisResponses { period, runs, .. } = &shown.responses;
    let period = *period;
    let mut section = Section::new(format!("Axis {}: on its own plant", axis.axis));
    for run in runs {
        section = section.figure(run_figure(run, period, &shown.units));
    }
    section
}

fn run_figure(run: &TimeRun, period: f64, [command, position]: &[String; 2]) -> TimeSeries {
    let time: Vec<f64> = (0..run.reference.len()).map(|k| k as f64 * period).collect();
    let title = match run.wave {
        None => "Step of the reference".to_owned(),
        Some(frequency) => format!("Wave of {} Hz", format_number(frequency, 4)),
    };
    let errors = |values: &[f64]| differences(&run.reference, values);
    let complete = errors(&run.complete.0);
    let mut figure = TimeSeries::new(title, &time)
        .panel("position")
        .reference("reference", position, &run.reference)
        .model("controller", position, &run.complete.0)
        .other("feedback alone", position, &run.feedback)
        .panel("error")
        .residual("controller", position, &complete);
    if let Some(alone) = &run.feedforward {
        figure = figure.other("feedforward alone", position, &errors(alone));
    }
    figure = figure.other("feedback alone", position, &errors(&run.feedback));
    figure = figure.panel("command").other("command", command, &run.complete.1);
    let number = |x: f64| format!("{} {position}", format_number(x, 3));
    figure.caption(format!(
        "Error of the controller, behind the run-in: rms {}, at most {}.",
        number(rms(&complete)),
        number(greatest(&complete))
    ))
}
