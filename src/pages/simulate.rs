//! The page of a simulation: signals, errors, loops; of a closed loop the path in the plane too.

use std::ops::Range;

use report::{Axis, KeyFigure, Report, Role, Section, TimeSeries, Verdict, XyLoop};

use diagnose::figures as response;

use super::{differences, provenance};
use crate::results::simulate::{OutputFit, Simulated};

/// The page of a simulation.
pub(crate) fn simulation(
    result: &Simulated,
    files: &[(&str, &std::path::Path)],
) -> anyhow::Result<Report> {
    let title = format!("Run of {}", result.model);
    let mut page = Report::new("simulate", title, Verdict::neutral(sentence(result)))
        .provenance(provenance(files)?);
    for note in &result.notes {
        page = page.warning(note);
    }
    for fit in &result.fits {
        let name = if result.signals.records().len() > 1 {
            format!("{}, record {}", fit.output, fit.record)
        } else {
            fit.output.clone()
        };
        let note = match fit.nrmse_percent {
            Some(part) => format!("{part:.3} % of the range of {}", fit.against),
            None => format!("{} does not move", fit.against),
        };
        page = page
            .key_figure(KeyFigure::new(format!("{name}: rmse"), fit.rmse, &*fit.unit).note(note))
            .key_figure(KeyFigure::new(
                format!("{name}: largest error"),
                fit.max_error,
                fit.unit.as_str(),
            ));
    }
    let records = result.signals.records();
    for (number, rows) in records.iter().enumerate() {
        let heading = match records.len() {
            1 => "Signals".to_owned(),
            _ => format!("Record {number}"),
        };
        let run = Run { result, rows: rows.clone() };
        let compared = run.compared();
        let (signals, errors) = (run.signals(&compared).into(), run.errors(&compared));
        let mut section = Section::new(heading);
        for figure in run.planes().into_iter().chain([signals]).chain(errors) {
            section = section.figure(figure);
        }
        page = page.section(section);
    }
    Ok(page.section(result.times.section()))
}

fn sentence(result: &Simulated) -> String {
    match result.fits.first() {
        Some(fit) => format!(
            "{} against {}: rmse {} {}, largest error {} {} (offset {} {} removed).",
            fit.output,
            fit.against,
            report::format_number(fit.rmse, 3),
            fit.unit,
            report::format_number(fit.max_error, 3),
            fit.unit,
            report::format_number(fit.offset, 3),
            fit.unit
        ),
        None => {
            let rows = data::counted(result.rows, "row");
            format!("Simulated: {rows} of {}.", result.model)
        }
    }
}

/// An output that is held against something, and its errors.
type Compared<'a> = (&'a OutputFit, Vec<f64>);

/// One record of a run.
struct Run<'a> {
    result: &'a Simulated,
    rows: Range<usize>,
}

impl<'a> Run<'a> {
    fn time(&self) -> &'a [f64] {
        &self.result.signals.time()[self.rows.clone()]
    }

    /// A signal of the run, or a column that measures one.
    fn values(&self, name: &str) -> Option<&'a [f64]> {
        self.result.signals.values(name)?.get(self.rows.clone())
    }

    fn unit(&self, name: &str) -> &'a str {
        let mut all = self.result.signals.series().iter();
        all.find(|s| s.column.name == name).and_then(|s| s.column.unit.as_deref()).unwrap_or("")
    }

    /// What the output is held against: what was measured, or the reference of a loop.
    fn against(&self, fit: &OutputFit) -> Option<(Role, &'a [f64])> {
        let measured = self.result.measured.iter().find(|(name, _)| *name == fit.output);
        match measured {
            Some((_, values)) => Some((Role::Measured, values.get(self.rows.clone())?)),
            None => Some((Role::Reference, self.values(&fit.against)?)),
        }
    }

    fn signals(&self, compared: &[Compared<'_>]) -> TimeSeries {
        let mut figure = TimeSeries::new("Signals over time", self.time());
        for series in self.result.signals.series() {
            let name = &series.column.name;
            let (unit, values) = (self.unit(name), &series.values[self.rows.clone()]);
            let measured = self.result.measured.iter().find(|(own, _)| own == name);
            let measured = measured.and_then(|(_, values)| values.get(self.rows.clone()));
            let role = match name.split(['[', '.']).next() {
                Some("reference") => Role::Reference,
                Some("position") => Role::Model,
                _ if measured.is_some() => Role::Model,
                _ => Role::Other,
            };
            if let Some(values) = measured {
                figure = figure.measured(format!("{name} measured"), unit, values);
            }
            figure = figure.signal(role, name, unit, values);
        }
        for (k, (fit, errors)) in compared.iter().enumerate() {
            figure = if k == 0 { figure.panel("error") } else { figure };
            figure = figure.residual(
                format!("{} − {}", fit.against, fit.output),
                fit.unit.as_str(),
                errors,
            );
        }
        figure
    }

    /// The outputs that are held against something in this record, and their errors, the offset of each
    /// taken out as in its figures.
    fn compared(&self) -> Vec<Compared<'a>> {
        let mut all: Vec<Compared<'a>> = Vec::new();
        for fit in &self.result.fits {
            let (Some((_, wanted)), Some(got)) = (self.against(fit), self.values(&fit.output))
            else {
                continue;
            };
            if all.iter().all(|(known, _)| known.output != fit.output) {
                let errors = differences(wanted, got).iter().map(|e| e - fit.offset).collect();
                all.push((fit, errors));
            }
        }
        all
    }

    /// Histogram and spectrum of the errors.
    fn errors(&self, compared: &[Compared<'_>]) -> Vec<report::Figure> {
        let mut all = Vec::new();
        let time = self.time();
        let period = match time {
            [first, .., last] => (last - first) / (time.len() - 1) as f64,
            _ => 0.0,
        };
        for (fit, errors) in compared {
            let set = [(Role::Residual, fit.output.as_str(), &errors[..])];
            let title = format!("Error of {}", fit.output);
            all.push(response::histogram(title, &fit.unit, &set).into());
            let title = format!("Spectrum of the error of {}", fit.output);
            all.push(response::spectrum(title, &fit.unit, period, &set).into());
        }
        all
    }

    /// Loops of each position over its command, and the path of the first two axes.
    fn planes(&self) -> Vec<report::Figure> {
        let mut all: Vec<report::Figure> = Vec::new();
        if let (Some(x), Some(y)) = (self.values("position[1]"), self.values("position[2]"))
            && self.unit("position[1]") == self.unit("position[2]")
        {
            let axis = |n: u8| Axis::new(format!("axis {n}"), self.unit("position[1]"));
            let mut path = XyLoop::new("Path of axes 1 and 2", axis(1), axis(2)).equal_scale();
            let wanted = (self.values("reference[1]"), self.values("reference[2]"));
            if let (Some(x), Some(y)) = wanted {
                path = path.line(Role::Reference, "reference", x, y);
            }
            all.push(path.model("position", x, y).into());
        }
        for series in self.result.signals.series() {
            let name = series.column.name.as_str();
            let Some(rest) = name.strip_prefix("position") else { continue };
            let command = format!("command{rest}");
            let Some(u) = self.values(&command) else { continue };
            let title = format!("{name} over {command}");
            let mut figure = XyLoop::new(
                title,
                Axis::new(command.as_str(), self.unit(&command)),
                Axis::new(name, self.unit(name)),
            );
            let measured = self.result.measured.iter().find(|(own, _)| own == name);
            if let Some(values) = measured.and_then(|(_, values)| values.get(self.rows.clone())) {
                figure = figure.measured("measured", u, values);
            }
            all.push(figure.model("simulated", u, &series.values[self.rows.clone()]).into());
        }
        all
    }
}
