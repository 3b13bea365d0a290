//! The page of a calibration: the Jacobian with its intervals, measured and computed coordinates.

use control::{Calibration, CalibrationRecord};
use report::{
    Axis, Column, KeyFigure, Provenance, Report, Role, Section, Table, TimeSeries, Value, Verdict,
    XyLoop,
};

use diagnose::figures as response;

use super::differences;

/// The page of a calibration; the samples of `record` are `period` s apart.
pub(crate) fn calibration(
    found: &Calibration,
    record: &CalibrationRecord,
    period: f64,
    provenance: Provenance,
) -> Report {
    let worst = found.coordinates.iter().map(|fit| fit.rms).fold(0.0, f64::max);
    let sentence = format!(
        "{} coordinates of {} motions from {} samples: the largest rms residual is {:.4}.",
        found.coordinates.len(),
        record.motions.len(),
        found.samples,
        worst
    );
    let mut page =
        Report::new("calibrate", "The Jacobian of coupled axes", Verdict::neutral(sentence))
            .provenance(provenance)
            .key_figure(
                KeyFigure::new("Condition number of the motions", found.motion_condition, "")
                    .note("1: fully independent motions"),
            );
    if let Some(condition) = found.condition {
        page = page.key_figure(KeyFigure::new("Condition number of J", condition, ""));
    }
    if record.longest_delay > 0.0 {
        page = page.key_figure(KeyFigure::new("Delay of the positions", found.delay * period, "s"));
    }
    let mut section = Section::new("Coordinates").table(table(found, record));
    for (k, (name, measured)) in record.positions.iter().enumerate() {
        let Some(computed) = computed(found, record, k) else { continue };
        let residual = differences(measured, &computed);
        let time: Vec<f64> = (0..measured.len()).map(|row| row as f64 * period).collect();
        let axis = |what: &str| Axis::new(what, "");
        section = section
            .figure(
                XyLoop::new(
                    format!("{name}: computed against measured"),
                    axis("measured"),
                    axis("computed"),
                )
                .model("samples", measured, &computed)
                .equal_scale(),
            )
            .figure(response::histogram(
                format!("{name}: residuals"),
                "",
                &[(Role::Residual, "measured − computed", &residual)],
            ))
            .figure(
                TimeSeries::new(format!("{name}, all records in sequence"), &time)
                    .panel(name)
                    .measured("measured", "", measured)
                    .model("J·θ + p0", "", &computed)
                    .panel("residual")
                    .residual("measured − computed", "", &residual),
            );
    }
    page.section(section)
}

fn table(found: &Calibration, record: &CalibrationRecord) -> Table {
    let first = [Column::new("coordinate")].into_iter();
    let motions = record.motions.iter().map(|(name, _)| Column::new(name.as_str()));
    let last = ["p0", "rms residual"].map(Column::new);
    let columns = first.chain(motions).chain(last);
    let mut table = Table::new("J and p0, with half-widths of the 95 % intervals", columns);
    let number = |x: f64| report::format_number(x, 5);
    for fit in &found.coordinates {
        let entries = fit.row.iter().zip(&fit.row_ci95).map(|(value, width)| match *value {
            0.0 => Value::from("0"),
            value => format!("{} ± {}", number(value), report::format_number(*width, 2)).into(),
        });
        let offset =
            format!("{} ± {}", number(fit.offset), report::format_number(fit.offset_ci95, 2));
        let name = std::iter::once(Value::from(fit.coordinate.as_str()));
        table = table.row(name.chain(entries).chain([Value::from(offset), fit.rms.into()]));
    }
    table
}

/// J·θ + p0 of one coordinate, the motions as late as the positions are.
fn computed(
    found: &Calibration,
    record: &CalibrationRecord,
    coordinate: usize,
) -> Option<Vec<f64>> {
    let fit = found.coordinates.get(coordinate)?;
    let rows = record.positions.get(coordinate)?.1.len();
    let late = |values: &[f64], row: usize| {
        let at = (row as f64 - found.delay).max(0.0);
        let (low, part) = (at.floor() as usize, at.fract());
        let value = |k: usize| values.get(k).or(values.last()).copied().unwrap_or(f64::NAN);
        value(low) * (1.0 - part) + if part > 0.0 { value(low + 1) * part } else { 0.0 }
    };
    let row = |k: usize| {
        let sum = fit.row.iter().zip(&record.motions).map(|(j, (_, theta))| j * late(theta, k));
        fit.offset + sum.sum::<f64>()
    };
    Some((0..rows).map(row).collect())
}
