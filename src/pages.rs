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
    let mut table =
        Table::new("Structures that were tried", ["structure", "held-out rmse", "taken", "why"]);
    for candidate in &id.candidates {
        let rmse =
            candidate.held_out_rmse.map_or("failed".to_owned(), |e| format!("{e:.5} {unit}"));
        let taken = if candidate.accepted { "yes" } else { "" };
        table = table.row([
            candidate.structure.clone(),
            rmse,
            taken.to_owned(),
            candidate.reason.clone(),
        ]);
    }
    let mut parameters =
        Table::new("Parameters", ["parameter", "value", "standard deviation", "unit", "the data"]);
    for p in &id.parameters {
        parameters = parameters.row::<report::Value>([
            p.name.as_str().into(),
            p.value.into(),
            p.deviation.into(),
            p.unit.as_str().into(),
            verdict_of(p.verdict).into(),
        ]);
    }
    all.push(Section::new(format!("Model of axis {}", axis.name)).table(table).table(parameters));
    all
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
