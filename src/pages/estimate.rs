//! The page of an estimation: values with their intervals, and the fits.

use std::path::Path;

use report::{KeyFigure, Report, Verdict};

use super::provenance;
use crate::commands::estimate::Estimated;

/// The page of an estimation.
pub(crate) fn estimation(result: &Estimated, files: &[(&str, &Path)]) -> anyhow::Result<Report> {
    let names: Vec<&str> = result.parameters.iter().map(|found| found.name.as_str()).collect();
    let sentence =
        format!("{} of {}, from {} residuals.", names.join(", "), result.model, result.residuals);
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
