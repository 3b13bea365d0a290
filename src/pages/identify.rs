//! The page of an identification: loop, time series, residuals and their spectra, frequency response,
//! what was tried, parameters.

use std::path::Path;

use report::{Axis, Column, KeyFigure, Report, Role, Section, Table, TimeSeries, Verdict, XyLoop};

use diagnose::figures::{self as response, Answered};
use numerics::spectrum;

use super::provenance;
use crate::results::identify::{AxisResult, Identified};

/// The page of an identification.
pub(crate) fn identification(result: &Identified, logs: &[&Path]) -> anyhow::Result<Report> {
    let files: Vec<_> = logs.iter().map(|path| ("log", *path)).collect();
    let mut page =
        Report::new("identify", "Identification", verdict(result)).provenance(provenance(&files)?);
    for note in &result.notes {
        page = page.warning(note);
    }
    for axis in &result.axes {
        page = key_figures(page, axis);
    }
    for axis in &result.axes {
        for section in sections(axis) {
            page = page.section(section);
        }
    }
    Ok(page)
}

fn verdict(result: &Identified) -> Verdict {
    let parts: Vec<String> = result
        .axes
        .iter()
        .flat_map(|axis| axis.identification.records.iter().map(move |record| (axis, record)))
        .map(|(axis, record)| {
            format!(
                "{:.2} % of range for axis {} (a straight line: {:.2} %)",
                100.0 * record.held_out.nrmse,
                axis.name,
                100.0 * record.baseline_held_out.nrmse
            )
        })
        .collect();
    Verdict::neutral(format!(
        "The simulated plant has an error on held-out rows of {}.",
        parts.join("; ")
    ))
}

fn key_figures(mut page: Report, axis: &AxisResult) -> Report {
    for record in &axis.identification.records {
        let label = format!("{}: held-out rmse", axis.name);
        page = page.key_figure(
            KeyFigure::new(label, 100.0 * record.held_out.nrmse, "% of range")
                .note(format!("straight line: {:.2} %", 100.0 * record.baseline_held_out.nrmse)),
        );
    }
    page
}

/// Loop, time series and parameters of one axis.
pub(crate) fn sections(axis: &AxisResult) -> Vec<Section> {
    let id = &axis.identification;
    let unit = id.unit.as_str();
    let mut all = Vec::new();
    for (fit, record) in id.records.iter().zip(&axis.records) {
        let rows = fit.held_out.rows;
        let time: Vec<f64> =
            (0..record.len()).map(|k| record.start() + k as f64 * record.period()).collect();
        let simulated: Vec<f64> = fit.simulation.iter().map(|y| y + fit.held_out.offset).collect();
        let held = rows.first..rows.end;
        let loops = hysteresis_loop(axis, record, &simulated, held.clone());
        let series = TimeSeries::new(format!("Axis {}: {}", axis.name, fit.record), &time)
            .measured("measured", unit, record.output())
            .model("plant", unit, &simulated)
            .panel("error")
            .residual("measured − plant", unit, &fit.residual)
            .other("measured − straight line", unit, &fit.baseline_residual);
        let band = (record.time(held.start), record.time(held.end.saturating_sub(1)));
        let mut section = Section::new(format!("Axis {}: {}", axis.name, fit.record))
            .paragraph(sentence(id.rules))
            .figure(loops)
            .figure(histogram(axis, fit))
            .figure(series.band(band.0, band.1, "held out"));
        for figure in frequencies(axis, record, fit, &simulated) {
            section = section.figure(figure);
        }
        all.push(section);
    }
    if let Some(section) = comparison(axis) {
        all.push(section);
    }
    let columns = [
        Column::new("structure"),
        Column::new("fitted").unit("% of range").decimals(3),
        Column::new("held out").unit("% of range").decimals(3),
        Column::new("numbers"),
        Column::new("time").unit("s").decimals(1),
        Column::new("taken"),
        Column::new("why"),
    ];
    let mut table = Table::new("Structures tried", columns);
    for candidate in &id.candidates {
        let percent = |part: Option<f64>| -> report::Value {
            part.map_or("failed".into(), |part| (100.0 * part).into())
        };
        table = table.row([
            candidate.structure.as_str().into(),
            percent(candidate.fitted_nrmse),
            percent(candidate.held_out_nrmse),
            candidate.parameters.into(),
            candidate.seconds.into(),
            if candidate.accepted { "yes" } else { "" }.into(),
            candidate.reason.as_str().into(),
        ]);
    }
    let columns = [
        "parameter",
        "value",
        "standard deviation",
        "unit",
        "the data",
        "goes with",
        "correlation",
    ];
    let mut parameters = Table::new("Parameters", columns);
    for p in &id.parameters {
        parameters = parameters.row::<report::Value>([
            p.name.as_str().into(),
            p.value.into(),
            p.deviation.into(),
            p.unit.as_str().into(),
            verdict_of(p.verdict).into(),
            p.correlated.as_ref().map_or("", |c| c.with.as_str()).into(),
            p.correlated.as_ref().map(|c| c.coefficient).into(),
        ]);
    }
    all.push(Section::new(format!("Model of axis {}", axis.name)).table(table).table(parameters));
    all
}

/// A text as a sentence.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// Residuals of the held-out rows, counted.
fn histogram(axis: &AxisResult, fit: &identify::RecordFit) -> report::Histogram {
    let rows = fit.held_out.rows;
    let errors = [
        (Role::Residual, "plant", rows.of(&fit.residual)),
        (Role::Other, "straight line", rows.of(&fit.baseline_residual)),
    ];
    let title = format!("Residuals, axis {}, held-out rows", axis.name);
    response::histogram(title, &axis.identification.unit, &errors)
}

/// Response from command to position, and what the residuals are made of.
fn frequencies(
    axis: &AxisResult,
    record: &identify::Record,
    fit: &identify::RecordFit,
    simulated: &[f64],
) -> Vec<report::Figure> {
    let unit = axis.identification.unit.as_str();
    let rows = fit.held_out.rows;
    let errors = [
        (Role::Residual, "plant", rows.of(&fit.residual)),
        (Role::Other, "straight line", rows.of(&fit.baseline_residual)),
    ];
    let title = format!("Spectrum of the residuals, axis {}, held-out rows", axis.name);
    let mut all = vec![response::spectrum(title, unit, record.period(), &errors).into()];
    let outputs =
        vec![(Role::Measured, "measured", record.output()), (Role::Model, "plant", simulated)];
    let answered = Answered { input: record.input(), outputs, period: record.period() };
    let title = format!("Frequency response, axis {}, whole record", axis.name);
    let gain = format!("{unit}/{}", axis.command_unit);
    all.extend(response::bode(title, &gain, &answered).map(report::Figure::from));
    all
}

/// Every method's best structure on the held-out rows of the first record: residuals over the command,
/// over time, and their spectra.
fn comparison(axis: &AxisResult) -> Option<Section> {
    let (fit, record) = (axis.identification.records.first()?, axis.records.first()?);
    let unit = axis.identification.unit.as_str();
    let rows = fit.held_out.rows;
    let span = rows.first..rows.end;
    let name = format!("Axis {}: residuals of all methods, held-out rows", axis.name);
    let time: Vec<f64> = span.clone().map(|k| record.time(k)).collect();
    let mut series = TimeSeries::new(name, &time);
    let mut loops = XyLoop::new(
        format!("Axis {}: residual over the command, held-out rows", axis.name),
        Axis::new("command", &axis.command_unit),
        Axis::new("measured − model", unit),
    );
    let columns = [
        Column::new("method"),
        Column::new("frequency").unit("Hz"),
        Column::new("amplitude").unit(unit),
    ];
    let mut spectra = Table::new(
        "Amplitude of the residual at the strongest frequencies of the position",
        columns,
    );
    let peaks = strongest(&record.output()[span.clone()], record.period());
    let mut seen: Vec<&str> = Vec::new();
    for candidate in axis.identification.candidates.iter().rev() {
        let (Some(method), Some(simulation)) = (candidate.method, candidate.simulations.first())
        else {
            continue;
        };
        if seen.contains(&method) {
            continue;
        }
        seen.push(method);
        let errors: Vec<f64> = span.clone().map(|k| record.output()[k] - simulation[k]).collect();
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        let errors: Vec<f64> = errors.iter().map(|e| e - mean).collect();
        series = series.other(method, unit, &errors);
        loops = loops.line(Role::Other, method, &record.input()[span.clone()], &errors);
        let amplitudes = spectrum::amplitudes(&errors);
        for &(line, frequency) in &peaks {
            let amplitude = amplitudes[line].into();
            spectra = spectra.row::<report::Value>([method.into(), frequency.into(), amplitude]);
        }
    }
    if seen.len() < 2 {
        return None;
    }
    let heading = format!("Methods compared, axis {}", axis.name);
    Some(Section::new(heading).figure(loops).figure(series).table(spectra))
}

/// The lines of the highest peaks of a signal's spectrum with their frequencies in Hz, ascending; at most five.
fn strongest(values: &[f64], period: f64) -> Vec<(usize, f64)> {
    const LINES: usize = 400;
    let (count, amplitudes) = (values.len() as f64, spectrum::amplitudes(values));
    // Lines of the window's width, denser at the low end, where machines move.
    let most = (0.5 * count).min(f64::from(u32::MAX));
    let ratio = most.max(2.0).powf(1.0 / LINES as f64);
    let mut lines: Vec<usize> =
        (0..=LINES).map(|i| ratio.powi(i as i32).round() as usize).collect();
    lines.dedup();
    lines.retain(|line| *line < amplitudes.len());
    lines.sort_by(|a, b| amplitudes[*b].total_cmp(&amplitudes[*a]));
    let mut found: Vec<(usize, f64)> = Vec::new();
    for line in lines {
        let frequency = line as f64 / count / period;
        let apart = found.iter().all(|(_, f)| (frequency / f - 1.0).abs() > 0.2);
        if apart && found.len() < 5 {
            found.push((line, frequency));
        }
    }
    found.sort_unstable_by_key(|(line, _)| *line);
    found
}

fn verdict_of(verdict: identify::Verdict) -> &'static str {
    match verdict {
        identify::Verdict::Determined => "determine it",
        identify::Verdict::Uncertain => "leave it uncertain",
        identify::Verdict::AtBound => "hold it at its bound",
        identify::Verdict::NotExcited => "do not excite it",
    }
}

fn hysteresis_loop(
    axis: &AxisResult,
    record: &identify::Record,
    simulated: &[f64],
    rows: std::ops::Range<usize>,
) -> XyLoop {
    XyLoop::new(
        format!("Loop, axis {}, held-out rows", axis.name),
        Axis::new("command", &axis.command_unit),
        Axis::new("position", &axis.identification.unit),
    )
    .measured("measured", &record.input()[rows.clone()], &record.output()[rows.clone()])
    .model("plant", &record.input()[rows.clone()], &simulated[rows])
}

/// The loop of the first record of an axis as a picture.
pub(crate) fn picture(axis: &AxisResult) -> Option<String> {
    let (fit, record) = (axis.identification.records.first()?, axis.records.first()?);
    let rows = fit.held_out.rows;
    let simulated: Vec<f64> = fit.simulation.iter().map(|y| y + fit.held_out.offset).collect();
    let figure = hysteresis_loop(axis, record, &simulated, rows.first..rows.end);
    Some(report::Figure::from(figure).to_svg())
}
