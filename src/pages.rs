//! Results as reports.

use std::path::Path;

use report::{
    Axis, InputFile, KeyFigure, Provenance, Report, Section, Table, TimeSeries, Verdict, XyLoop,
};

use crate::commands::identify::{AxisResult, Identified};
use crate::commands::simulate::Simulated;

/// Provenance of this call: tool, version, command line, files.
pub(crate) fn provenance(files: &[(&str, &Path)]) -> anyhow::Result<Provenance> {
    let mut all = Provenance::new("piezoloop", crate::VERSION).command_line(std::env::args());
    for (role, path) in files {
        all = all.file(InputFile::read(*role, path)?);
    }
    Ok(all)
}

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
                "axis {}: {:.2} % of range on rows that the fit did not see, where a straight line leaves {:.2} %",
                axis.name,
                100.0 * record.held_out.nrmse,
                100.0 * record.baseline_held_out.nrmse
            )
        })
        .collect();
    Verdict::neutral(format!("The identified plant, simulated, leaves {}.", parts.join("; ")))
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
        let loops = hysteresis_loop(axis, record, &simulated, held);
        let series = TimeSeries::new(format!("Axis {}: {}", axis.name, fit.record), &time)
            .measured("measured", unit, record.output())
            .model("plant", unit, &simulated)
            .panel("error")
            .residual("measured − plant", unit, &fit.residual)
            .other("measured − straight line", unit, &fit.baseline_residual);
        all.push(
            Section::new(format!("Axis {}", axis.name))
                .paragraph(id.rules)
                .figure(loops)
                .figure(series),
        );
    }
    if let Some(section) = comparison(axis) {
        all.push(section);
    }
    let columns =
        ["structure", "fitted, % of range", "held out, % of range", "numbers", "s", "taken", "why"];
    let mut table = Table::new("Structures that were tried", columns);
    for candidate in &id.candidates {
        let percent = |part: Option<f64>| {
            part.map_or("failed".to_owned(), |part| format!("{:.3}", 100.0 * part))
        };
        table = table.row([
            candidate.structure.clone(),
            percent(candidate.fitted_nrmse),
            percent(candidate.held_out_nrmse),
            candidate.parameters.to_string(),
            format!("{:.1}", candidate.seconds),
            if candidate.accepted { "yes" } else { "" }.to_owned(),
            candidate.reason.clone(),
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
    let mut spectra = Table::new(
        "Amplitude of the residual at the strongest frequencies of the position",
        ["method", "frequency in Hz", "amplitude"],
    );
    let frequencies = strongest(&record.output()[span.clone()], record.period());
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
        loops = loops.model(method, &record.input()[span.clone()], &errors);
        for &frequency in &frequencies {
            let amplitude = amplitude(&errors, frequency * record.period());
            spectra =
                spectra.row::<report::Value>([method.into(), frequency.into(), amplitude.into()]);
        }
    }
    let heading = format!("Methods compared, axis {}", axis.name);
    Some(Section::new(heading).figure(loops).figure(series).table(spectra))
}

/// Amplitude of `values` at a frequency in parts of the sample rate, with Hann's window.
fn amplitude(values: &[f64], frequency: f64) -> f64 {
    let count = values.len().max(1) as f64;
    let (mut real, mut imaginary) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let k = k as f64;
        let window = 1.0 - (std::f64::consts::TAU * k / count).cos();
        let (sin, cos) = (std::f64::consts::TAU * frequency * k).sin_cos();
        real += window * value * cos;
        imaginary += window * value * sin;
    }
    2.0 * real.hypot(imaginary) / count
}

/// The frequencies, in Hz, of the highest peaks of a signal's spectrum, ascending; at most five.
fn strongest(values: &[f64], period: f64) -> Vec<f64> {
    const LINES: usize = 400;
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count.max(1.0);
    let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
    // Lines of the window's width, denser at the low end, where machines move.
    let most = (0.5 * count).min(f64::from(u32::MAX));
    let ratio = most.max(2.0).powf(1.0 / LINES as f64);
    let mut lines: Vec<usize> =
        (0..=LINES).map(|i| ratio.powi(i as i32).round() as usize).collect();
    lines.dedup();
    let mut peaks: Vec<(f64, f64)> = lines
        .iter()
        .map(|line| *line as f64 / count)
        .map(|frequency| (amplitude(&centred, frequency), frequency / period))
        .collect();
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut found: Vec<f64> = Vec::new();
    for (_, frequency) in peaks {
        let apart = found.iter().all(|f| (frequency / f - 1.0).abs() > 0.2);
        if apart && found.len() < 5 {
            found.push(frequency);
        }
    }
    found.sort_by(f64::total_cmp);
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

/// The page of a simulation.
pub(crate) fn simulation(result: &Simulated) -> anyhow::Result<Report> {
    let sentence = match result.fits.first() {
        Some(fit) => format!(
            "{} against {}: rmse {:.4} {}, largest error {:.4} {} (offset {:.4} {} taken out).",
            fit.output,
            fit.against,
            fit.rmse,
            fit.unit,
            fit.max_error,
            fit.unit,
            fit.offset,
            fit.unit
        ),
        None => format!("{} rows of {} were simulated.", result.rows, result.model),
    };
    let mut page =
        Report::new("simulate", format!("Run of {}", result.model), Verdict::neutral(sentence))
            .provenance(provenance(&[])?);
    for note in &result.notes {
        page = page.warning(note);
    }
    for fit in &result.fits {
        let label = format!("{}, record {}", fit.output, fit.record);
        page = page.key_figure(KeyFigure::new(label, fit.rmse, fit.unit.as_str()).note("rmse"));
    }
    let memory = &result.signals;
    for (number, rows) in memory.records().iter().enumerate() {
        let mut figure = TimeSeries::new(format!("Record {number}"), &memory.time()[rows.clone()]);
        for series in memory.series() {
            let unit = series.column.unit.as_deref().unwrap_or("");
            figure = figure.model(&series.column.name, unit, &series.values[rows.clone()]);
            let measured = result.measured.iter().find(|(name, _)| name == &series.column.name);
            if let Some(values) = measured.and_then(|(_, values)| values.get(rows.clone())) {
                figure = figure.measured(format!("{} measured", series.column.name), unit, values);
            }
        }
        page = page.section(Section::new(format!("Record {number}")).figure(figure));
    }
    Ok(page)
}
