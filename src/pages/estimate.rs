//! The page of an estimation: values with their intervals, and the fits.

use std::path::Path;

use report::{KeyFigure, Report, Section, TimeSeries, Verdict};

use super::provenance;
use crate::results::estimate::{Estimated, Found, LogFit};

/// Figures of measured and simulated outputs; the errors of all are among the key figures.
const MOST_FIGURES: usize = 6;

/// The page of an estimation.
pub(crate) fn estimation(result: &Estimated, files: &[(&str, &Path)]) -> anyhow::Result<Report> {
    let sentence = sentence(result);
    let verdict = if result.undetermined.is_empty() {
        Verdict::pass(sentence)
    } else {
        Verdict::caution(format!("{sentence} The logs do not determine all of them."))
    };
    let title = format!("Parameters of {}", result.model);
    let mut page = Report::new("estimate", title, verdict).provenance(provenance(files)?);
    for note in &result.notes {
        page = page.warning(note);
    }
    for found in &result.parameters {
        let note = match found.interval {
            Some([low, high]) => format!(
                "95 % interval {} to {}; start value {}",
                report::format_number(low, 6),
                report::format_number(high, 6),
                report::format_number(found.start, 6)
            ),
            None => "no interval".to_owned(),
        };
        let unit = found.unit.clone().unwrap_or_default();
        page = page.key_figure(KeyFigure::new(found.name.clone(), found.value, unit).note(note));
    }
    let mut section = Section::new("Measured and simulated");
    for fit in result.fits.iter().take(MOST_FIGURES) {
        section = section.figure(figure(fit));
    }
    if let Some(further) = result.fits.len().checked_sub(MOST_FIGURES).filter(|n| *n > 0) {
        section = section.paragraph(format!(
            "{further} further outputs and records are not drawn; their errors are above."
        ));
    }
    page = page.section(section);
    for fit in &result.fits {
        let how = if fit.held_out { ", held out" } else { "" };
        let log = fit.log.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let name = format!("{log}, {}, record {}{how}: rmse", fit.fit.output, fit.fit.record);
        let note = format!("{} with the start values", report::format_number(fit.rmse_at_start, 4));
        page = page
            .key_figure(KeyFigure::new(name, fit.fit.raw_rmse, fit.fit.unit.as_str()).note(note));
    }
    Ok(page)
}

/// The values with their intervals, and how far the error falls.
fn sentence(result: &Estimated) -> String {
    let value = |found: &Found| {
        let number = |x: f64| report::format_number(x, 4);
        let unit = found.unit.as_deref().filter(|unit| *unit != "1").unwrap_or_default();
        let interval = match found.interval {
            Some([low, high]) => format!(" (95 %: {} to {})", number(low), number(high)),
            None => String::new(),
        };
        format!("{} = {} {unit}", found.name, number(found.value)).trim_end().to_owned() + &interval
    };
    let values: Vec<String> = result.parameters.iter().map(value).collect();
    let error = result.fits.first().map(|fit| {
        let number = |x: f64| report::format_number(x, 3);
        let (before, after) = (number(fit.rmse_at_start), number(fit.fit.raw_rmse));
        let (output, unit) = (&fit.fit.output, &fit.fit.unit);
        format!("; the rms error of {output} changes from {before} to {after} {unit}")
    });
    format!("{}: {}{}.", result.model, values.join(", "), error.unwrap_or_default())
}

/// Measured and simulated on the same axes, and the residuals.
fn figure(fit: &LogFit) -> TimeSeries {
    let (output, unit, curves) = (&fit.fit.output, fit.fit.unit.as_str(), &fit.curves);
    let less = |simulated: &[f64]| -> Vec<f64> {
        curves.measured.iter().zip(simulated).map(|(y, s)| y - s).collect()
    };
    let log = fit.log.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let how = if fit.held_out { ", held out" } else { "" };
    TimeSeries::new(format!("{output}: {log}, record {}{how}", fit.fit.record), &curves.time)
        .measured("measured", unit, &curves.measured)
        .model("simulated", unit, &curves.estimated)
        .panel("residual")
        .other("residual with the start values", unit, &less(&curves.start))
        .residual("residual with the estimates", unit, &less(&curves.estimated))
}
