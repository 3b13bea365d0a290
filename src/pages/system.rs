//! The page of a system's run: what was run, and how long the FMUs took.

use std::path::Path;

use report::{KeyFigure, Report, Verdict};

use super::provenance;
use crate::commands::system::Ran;

/// The page of a system's run.
pub(crate) fn system(result: &Ran, files: &[(&str, &Path)]) -> anyhow::Result<Report> {
    let sentence = format!(
        "{} by {}, {}, {} s to {} s in steps of {} s.",
        data::counted(result.fmus.len(), "FMU"),
        result.algorithm,
        data::counted(result.rows, "row"),
        result.start_s,
        result.stop_s,
        result.step_s
    );
    let title = format!("Run of {}", result.system);
    let mut page = Report::new("system", title, Verdict::neutral(sentence));
    page = page.provenance(provenance(files)?);
    for note in &result.notes {
        page = page.warning(note);
    }
    if let Some(factor) = result.times.real_time_factor() {
        page = page.key_figure(KeyFigure::new("times real time", factor, ""));
    }
    Ok(page.section(result.times.section()))
}
