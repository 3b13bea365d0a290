//! The page of a system's run: the recorded signals, and how long the FMUs took.

use std::path::Path;

use report::{KeyFigure, Report, Role, Section, TimeSeries, Verdict};

use super::provenance;
use crate::results::system::{Drawn, Ran};

/// How many signals are drawn.
const MOST_SIGNALS: usize = 30;

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
        page = page.key_figure(KeyFigure::new("Simulated seconds per second", factor, ""));
    }
    if let Some(section) = signals(&result.drawn) {
        page = page.section(section);
    }
    Ok(page.section(result.times.section()))
}

/// The recorded variables over time, those of one unit in one panel.
fn signals(drawn: &Drawn) -> Option<Section> {
    if drawn.columns.is_empty() || drawn.time.is_empty() {
        return None;
    }
    let title = match drawn.stride {
        1 => "Signals over time".to_owned(),
        stride => format!("Signals over time, one of {stride} rows"),
    };
    let unit = |k: usize| drawn.columns[k].unit.as_deref().unwrap_or("");
    let shown = drawn.columns.len().min(MOST_SIGNALS);
    let mut units: Vec<&str> = Vec::new();
    for k in 0..shown {
        if !units.contains(&unit(k)) {
            units.push(unit(k));
        }
    }
    let mut figure = TimeSeries::new(title, &drawn.time);
    for own in units {
        for k in (0..shown).filter(|k| unit(*k) == own) {
            let name = drawn.columns[k].name.as_str();
            let role = if name.starts_with("reference") { Role::Reference } else { Role::Other };
            figure = figure.signal(role, name, own, &drawn.values[k]);
        }
    }
    let mut section = Section::new("Signals").figure(figure);
    if shown < drawn.columns.len() {
        section = section.paragraph(format!(
            "The first {shown} of {} recorded variables are drawn; the record has all.",
            drawn.columns.len()
        ));
    }
    Some(section)
}
