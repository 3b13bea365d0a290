//! The page of a tuning: step response, loop and sensitivity over frequency, gains and margins.

use control::{LoopCurves, loop_curves};
use identify::frequency::Complex;
use report::{
    Axis, Bode, Column, KeyFigure, Provenance, Report, Role, Section, Spectrum, Table, TimeSeries,
    Value, Verdict,
};

use super::{polar, sensitivities};
use crate::results::tune::{Tuned, TunedLoop};

/// Points of a curve over frequency.
const POINTS: usize = 400;

/// The page of a tuning.
pub(crate) fn tuning(result: &Tuned, provenance: Provenance) -> Report {
    let page = Report::new("tune", format!("Gains of axis {}", result.axis), verdict(result));
    let mut page = page.provenance(provenance);
    if let Some(reason) = &result.why_not {
        page = page.warning(format!("No ultimate gain: {reason}"));
    }
    if let Some(found) = &result.ultimate {
        page = page
            .key_figure(KeyFigure::new("Ultimate gain", found.gain, "command per position"))
            .key_figure(KeyFigure::new("Ultimate period", found.period, "s"));
    }
    for tuned in &result.loops {
        let (name, verdict) = (tuned.name, &tuned.verdict);
        let note = format!(
            "gain margin {:.2}, phase margin {:.1}°",
            verdict.gain_margin, verdict.phase_margin
        );
        let bandwidth = KeyFigure::new(
            format!("{name}: disturbances are attenuated up to"),
            Some(verdict.rejection_bandwidth).filter(|_| verdict.stable),
            "Hz",
        );
        page = page.key_figure(bandwidth.note(if verdict.stable {
            note
        } else {
            "unstable on the measured response".to_owned()
        }));
    }
    page.section(machine(result)).section(loops(result))
}

fn verdict(result: &Tuned) -> Verdict {
    let number = |x: f64| report::format_number(x, 4);
    let best = result.loops.iter().find(|tuned| tuned.name == "robust" && tuned.verdict.stable);
    match best {
        Some(tuned) => Verdict::pass(format!(
            "Robust gains kp {}, ki {}, kd {} keep a sensitivity of {:.2} and attenuate disturbances up to {} Hz.",
            number(tuned.gains.kp),
            number(tuned.gains.ki),
            number(tuned.gains.kd),
            tuned.verdict.sensitivity,
            number(tuned.verdict.rejection_bandwidth)
        )),
        None => Verdict::caution("No gains of a stable loop were found on the measured response."),
    }
}

fn machine(result: &Tuned) -> Section {
    let period = result.period_s;
    let mut sum = 0.0;
    let steps: Vec<f64> = result
        .impulse
        .iter()
        .map(|g| {
            sum += g;
            sum
        })
        .collect();
    let time: Vec<f64> = (1..=steps.len()).map(|k| k as f64 * period).collect();
    let figure = TimeSeries::new("Step response", &time)
        .panel("position per command")
        .measured("measured", "1", &steps);
    Section::new("The machine").figure(figure.caption(
        "Mean of repeated small steps around --middle: the linear response on which the gains are judged.",
    ))
}

fn loops(result: &Tuned) -> Section {
    let curves = |tuned: &TunedLoop| {
        thinned(loop_curves(&result.impulse, result.period_s, &tuned.gains, false))
    };
    let mut open = Bode::new("Machine and open loops", "1");
    let mut back =
        Spectrum::new("Remaining disturbance of the position", Axis::new("|1/(1 + L)|", "1"));
    for (k, tuned) in result.loops.iter().enumerate() {
        let found = curves(tuned);
        let f = &found.frequency;
        if k == 0 {
            let (magnitude, phase) = polar(&found.plant);
            open = open.response(Role::Measured, "machine", f, &magnitude, &phase, None);
        }
        let (magnitude, phase) = polar(&found.open);
        open = open.response(Role::Other, tuned.name, f, &magnitude, &phase, None);
        let left = sensitivities(&found.open);
        if tuned.verdict.stable {
            back = back.trace(Role::Other, tuned.name, f, &left);
        }
    }
    let columns = [
        Column::new("rule"),
        Column::new("kp"),
        Column::new("ki").unit("1/s"),
        Column::new("kd").unit("s"),
        Column::new("derivative filter").unit("s"),
        Column::new("gain margin"),
        Column::new("phase margin").unit("deg"),
        Column::new("sensitivity"),
        Column::new("up to").unit("Hz"),
        Column::new("stable"),
    ];
    let mut table = Table::new("Gains, in command per position, and their effect", columns);
    for tuned in &result.loops {
        let (gains, verdict) = (&tuned.gains, &tuned.verdict);
        table = table.row([
            Value::from(tuned.name),
            gains.kp.into(),
            gains.ki.into(),
            gains.kd.into(),
            gains.derivative_filter.into(),
            verdict.gain_margin.into(),
            verdict.phase_margin.into(),
            verdict.sensitivity.into(),
            verdict.rejection_bandwidth.into(),
            verdict.stable.into(),
        ]);
    }
    Section::new("The loops").table(table).figure(open).figure(back.limit(1.0, "no feedback"))
}

/// Evenly chosen points; the curves are dense.
fn thinned(curves: LoopCurves) -> LoopCurves {
    let stride = curves.frequency.len().div_ceil(POINTS).max(1);
    let of = |all: Vec<Complex>| all.into_iter().step_by(stride).collect();
    LoopCurves {
        frequency: curves.frequency.into_iter().step_by(stride).collect(),
        plant: of(curves.plant),
        open: of(curves.open),
    }
}
