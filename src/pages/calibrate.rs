//! The page of a calibration: the Jacobian with its intervals, measured and computed coordinates.

use control::{Calibration, CalibrationRecord};
use report::{
    Axis, Column, KeyFigure, Provenance, Report, Role, Section, Table, TimeSeries, Value, Verdict,
    XyLoop,
};

use diagnose::figures as response;

use super::differences;

/// The page of a calibration; the samples of `record` are `period` s apart. `units` are those of its motions, then
/// those of its positions.
pub(crate) fn calibration(
    found: &Calibration,
    record: &CalibrationRecord,
    period: f64,
    units: &[Option<String>],
    provenance: Provenance,
) -> Report {
    let unit =
        |k: usize| units.get(record.motions.len() + k).and_then(Option::as_deref).unwrap_or("");
    let fits = found.coordinates.iter().enumerate();
    let worst = fits.max_by(|(_, a), (_, b)| a.rms.total_cmp(&b.rms)).map(|(k, fit)| {
        let size =
            format!("{} {}", report::format_number(fit.rms, 3), report::format_unit(unit(k)));
        format!("the largest rms residual is {} ({})", size.trim_end(), fit.coordinate)
    });
    let sentence = format!(
        "{} of {} from {}: {}.",
        data::counted(found.coordinates.len(), "coordinate"),
        data::counted(record.motions.len(), "motion"),
        data::counted(found.samples, "sample"),
        worst.unwrap_or_default()
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
    let mut section = Section::new("Coordinates").table(table(found, record, units));
    for (k, (name, measured)) in record.positions.iter().enumerate() {
        let Some(computed) = computed(found, record, k) else { continue };
        let residual = differences(measured, &computed);
        let time: Vec<f64> = (0..measured.len()).map(|row| row as f64 * period).collect();
        let unit = unit(k);
        let axis = |what: &str| Axis::new(what, unit);
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
                unit,
                &[(Role::Residual, "measured − computed", &residual)],
            ))
            .figure(
                TimeSeries::new(format!("{name}, all records in sequence"), &time)
                    .panel(name)
                    .measured("measured", unit, measured)
                    .model("J·θ + p0", unit, &computed)
                    .panel("residual")
                    .residual("measured − computed", unit, &residual),
            );
    }
    page.section(section)
}

fn table(found: &Calibration, record: &CalibrationRecord, units: &[Option<String>]) -> Table {
    let unit = |k: usize| units.get(k).and_then(Option::as_deref).filter(|unit| !unit.is_empty());
    let first = [Column::new("coordinate")].into_iter();
    let motions = record.motions.iter().enumerate().map(|(k, (name, _))| match unit(k) {
        Some(unit) => Column::new(format!("per {} of {name}", report::format_unit(unit))),
        None => Column::new(format!("per unit of {name}")),
    });
    let last = ["p0", "rms residual"].map(Column::new);
    let columns = first.chain(motions).chain(last);
    let mut table = Table::new("J and p0, with half-widths of the 95 % intervals", columns);
    for (k, fit) in found.coordinates.iter().enumerate() {
        let entries = fit.row.iter().zip(&fit.row_ci95).map(|(value, width)| match *value {
            0.0 => Value::from("0"),
            value => with_half_width(value, *width).into(),
        });
        let offset = with_half_width(fit.offset, fit.offset_ci95);
        let name = match unit(record.motions.len() + k) {
            Some(unit) => format!("{} [{}]", fit.coordinate, report::format_unit(unit)),
            None => fit.coordinate.clone(),
        };
        let row = std::iter::once(Value::from(name)).chain(entries);
        table = table.row(row.chain([Value::from(offset), fit.rms.into()]));
    }
    table
}

/// A value with the decimals that its interval determines: two digits of the half-width.
fn with_half_width(value: f64, width: f64) -> String {
    if !(width > 0.0 && width.is_finite()) {
        return format!(
            "{} ± {}",
            report::format_number(value, 5),
            report::format_number(width, 2)
        );
    }
    // One decimal more than the first digit of the half-width.
    let last = 10.0_f64.powi(width.log10().floor() as i32 - 1);
    let rounded = (value / last).round() * last;
    format!("{} ± {}", report::format_number(rounded, 12), report::format_number(width, 2))
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

#[cfg(test)]
mod tests {
    use super::with_half_width;

    #[test]
    fn a_value_has_the_decimals_of_its_interval() {
        assert_eq!(with_half_width(-2.27e-13, 0.0281), "0 ± 0.028");
        assert_eq!(with_half_width(-514.999_87, 0.0316), "−515 ± 0.032");
        assert_eq!(with_half_width(7.012_34, 0.0224), "7.012 ± 0.022");
        assert_eq!(with_half_width(123_456.0, 120.0), "123\u{202f}460 ± 120");
        assert_eq!(with_half_width(1.25, 0.0), "1.25 ± 0");
        assert_eq!(with_half_width(1.25, f64::NAN), "1.25 ± –");
    }
}
