//! `piezoloop calibrate`: the Jacobian of coupled axes from a log of their simultaneous motion.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use cli::{Answer, PageOptions, Screen};
use control::{Calibration, CalibrationRecord};
use data::{Blueprint, ComponentBlueprint, Value};
use model::{Component, Conversion, Kind};
use serde::Serialize;

use crate::inputs::{self, LogOptions};
use crate::pages;

/// Calibrates the Jacobian of coupled axes from a log of their simultaneous motion
///
/// p = J·theta + p0: the motions theta of all axes are known (commanded through inverse models) or measured, and the
/// coordinates p are measured. Least squares, row by row; structural zeros stay 0. If the motion does not determine
/// every column, the error names the axis.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop calibrate log.csv --motion theta1 --motion theta2 --position x1 --position y1\n  piezoloop calibrate log.csv --motion theta1 --motion theta2 --motion theta3 --motion theta4 --position x1 --position y1 --position x2 --position y2 --blueprint controller.toml -o calibrated.toml"
)]
pub(crate) struct Calibrate {
    /// Logs with motions and coordinates in the same rows
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Column of an axis' motion, in the order of the axes (once per axis)
    #[arg(long = "motion", required = true, value_name = "COLUMN")]
    motions: Vec<String>,
    /// Column of a coordinate, in the order of the rows (once per coordinate)
    #[arg(long = "position", required = true, value_name = "COLUMN")]
    positions: Vec<String>,
    /// A coordinate that does not depend on an axis, as in x1:theta3 (may be given several times)
    #[arg(long = "zero", value_name = "POSITION:MOTION")]
    zeros: Vec<String>,
    /// Blueprint with a jacobian-coordinator or optics-jacobian: its entries 0 are structural zeros, and its values
    /// are replaced. Or a controller of the motions: it gets a jacobian-coordinator, and its axes become those of the
    /// coordinates
    #[arg(long, value_name = "FILE")]
    blueprint: Option<PathBuf>,
    /// Longest delay of the sensors in s; the delay is fitted if this is above 0
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = crate::ranges::time())]
    longest_delay: f64,
    #[command(flatten)]
    options: LogOptions,
    /// Write the blueprint with J and p0 to this file
    #[arg(short = 'o', long = "out", value_name = "FILE", requires = "blueprint")]
    out: Option<PathBuf>,
    #[command(flatten)]
    page: PageOptions,
}

#[derive(Serialize)]
struct Calibrated {
    motions: Vec<String>,
    #[serde(flatten)]
    calibration: Calibration,
    delay_s: f64,
    blueprint: Option<PathBuf>,
}

impl Calibrate {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let logs: Vec<&Path> = self.logs.iter().map(PathBuf::as_path).collect();
        if let Some(out) = &self.out {
            cli::can_write_as(out, inputs::BLUEPRINT)?;
        }
        self.page.can_write()?;
        let mut blueprint = self.blueprint.as_deref().map(inputs::blueprint).transpose()?;
        let zeros = self.structural_zeros(blueprint.as_ref().map(|text| &text.blueprint))?;
        let (record, period, units) = self.record(zeros)?;
        let calibration = control::calibrate(&record)?;
        if let (Some(text), Some(out)) = (&mut blueprint, &self.out) {
            if jacobian(&text.blueprint).is_err() && text.blueprint.kind == Kind::Controller {
                coordinate(&mut text.blueprint, &calibration, &units[self.motions.len()..])?;
            }
            put(&mut text.blueprint, &calibration)?;
            text.blueprint.check(learned::COMPONENTS)?;
            text.blueprint.write(out)?;
        }
        let answer = Calibrated {
            motions: self.motions.clone(),
            delay_s: calibration.delay * period,
            calibration,
            blueprint: self.out.clone(),
        };
        let files: Vec<(&str, &Path)> = logs.iter().map(|log| ("log", *log)).collect();
        self.page.finish(screen, &answer, || {
            let provenance = pages::provenance(&files)?;
            Ok(pages::calibration(&answer.calibration, &record, period, &units, provenance))
        })
    }

    /// The record, its sample time, and the units of its columns.
    fn record(
        &self,
        zeros: Vec<Vec<bool>>,
    ) -> anyhow::Result<(CalibrationRecord, f64, Vec<Option<String>>)> {
        let mut record = CalibrationRecord {
            motions: self.motions.iter().map(|name| (name.clone(), Vec::new())).collect(),
            positions: self.positions.iter().map(|name| (name.clone(), Vec::new())).collect(),
            starts: Vec::new(),
            zeros,
            longest_delay: 0.0,
        };
        let mut units: Vec<Option<String>> = vec![None; self.motions.len() + self.positions.len()];
        let mut period = 0.0;
        for path in &self.logs {
            let log = self.options.read(path)?;
            let before = record.motions.first().map_or(0, |(_, values)| values.len());
            record.starts.extend(log.records().iter().map(|r| before + r.rows.start));
            let columns = record.motions.iter_mut().chain(&mut record.positions);
            for ((name, values), unit) in columns.zip(&mut units) {
                values.extend(inputs::column(&log, name, unit)?);
            }
            let (first, last) = (log.time().first(), log.time().last());
            let rows = log.len().max(2) as f64 - 1.0;
            period = last.zip(first).map_or(0.0, |(b, a)| (b - a) / rows);
        }
        if period > 0.0 {
            record.longest_delay = self.longest_delay / period;
        }
        Ok((record, period, units))
    }

    /// For each coordinate, the axes that it does not see.
    fn structural_zeros(&self, blueprint: Option<&Blueprint>) -> anyhow::Result<Vec<Vec<bool>>> {
        let (rows, columns) = (self.positions.len(), self.motions.len());
        let mut zeros = vec![vec![false; columns]; rows];
        for text in &self.zeros {
            let parts = text.split_once(':');
            let at = parts.and_then(|(position, motion)| {
                let row = self.positions.iter().position(|name| name == position)?;
                Some((row, self.motions.iter().position(|name| name == motion)?))
            });
            let Some((row, column)) = at else {
                bail!(
                    "--zero {text}: write POSITION:MOTION, of the positions {} and the motions {}",
                    self.positions.join(", "),
                    self.motions.join(", ")
                );
            };
            zeros[row][column] = true;
        }
        let Some(blueprint) = blueprint else { return Ok(zeros) };
        if blueprint.kind == Kind::Controller && jacobian(blueprint).is_err() {
            return Ok(zeros);
        }
        let matrix = jacobian(blueprint)?.component.get("matrix").map(flat).unwrap_or_default();
        if rows != columns || matrix.len() != rows * columns {
            bail!(
                "the blueprint's Jacobian has {} entries, and {rows} positions and {columns} motions \
                 were given; give as many of each as it couples axes",
                matrix.len()
            );
        }
        for (k, value) in matrix.iter().enumerate() {
            zeros[k / columns][k % columns] |= *value == 0.0;
        }
        Ok(zeros)
    }
}

/// The entries of a matrix, row by row.
fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Number(number) => vec![*number],
        Value::Text(_) => vec![f64::NAN],
        Value::List(items) => items.iter().flat_map(flat).collect(),
    }
}

/// The coupling of a blueprint that has a Jacobian.
fn jacobian(blueprint: &Blueprint) -> anyhow::Result<&data::CouplingBlueprint> {
    let mut couplings = blueprint.couplings.iter();
    couplings.find(|c| has_jacobian(&c.component)).context(
        "the blueprint has no jacobian-coordinator and no optics-jacobian; add one as a [[coupling]]",
    )
}

/// Puts a coordinator in front of a controller of motions: its positions become those of the coordinates, its
/// references start where the motions did.
fn coordinate(
    blueprint: &mut Blueprint,
    calibration: &Calibration,
    units: &[Option<String>],
) -> anyhow::Result<()> {
    let (axes, rows) = (blueprint.axes.len(), calibration.coordinates.len());
    if axes != rows || calibration.coordinates.iter().any(|fit| fit.row.len() != axes) {
        bail!(
            "the controller has {axes} axes, and {rows} positions of {} motions were given; give as many \
             of each as it has axes",
            calibration.coordinates.first().map_or(0, |fit| fit.row.len())
        );
    }
    let start = |value: &Option<Value>| match value {
        Some(Value::Number(number)) => *number,
        _ => 0.0,
    };
    let motions: Vec<f64> =
        blueprint.axes.iter().map(|axis| start(&axis.reference.start)).collect();
    for ((axis, fit), unit) in blueprint.axes.iter_mut().zip(&calibration.coordinates).zip(units) {
        let moved: f64 = fit.row.iter().zip(&motions).map(|(j, theta)| j * theta).sum();
        axis.reference.start = Some(Value::Number(fit.offset + moved));
        if axis.motion.unit.is_empty() {
            axis.motion.unit.clone_from(&axis.position.unit);
        }
        if let Some(unit) = unit {
            axis.position.unit.clone_from(unit);
        }
        (axis.position.min, axis.position.max) = (None, None);
    }
    let names: Vec<String> = (1..)
        .zip(&blueprint.axes)
        .map(|(n, a)| if a.name.is_empty() { format!("axis{n}") } else { a.name.clone() })
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let component = ComponentBlueprint::new("jacobian-coordinator");
    *blueprint = blueprint.clone().coupling(&names, component);
    Ok(())
}

/// Whether a component is a Jacobian between motions and positions, which measurements may replace.
fn has_jacobian(component: &ComponentBlueprint) -> bool {
    components::find(&component.kind).map(Component::declaration).is_some_and(|declared| {
        let is_between = [Conversion::MotionToPosition, Conversion::PositionToMotion];
        is_between.contains(&declared.conversion) && declared.parameters.iter().any(|q| q.fit)
    })
}

/// Puts J and p0 into a blueprint.
pub(crate) fn put(blueprint: &mut Blueprint, calibration: &Calibration) -> anyhow::Result<()> {
    jacobian(blueprint)?;
    let list = |values: &[f64]| Value::List(values.iter().map(|x| Value::Number(*x)).collect());
    let rows = calibration.coordinates.iter().map(|fit| list(&fit.row)).collect();
    let offsets: Vec<f64> = calibration.coordinates.iter().map(|fit| fit.offset).collect();
    let mut couplings = blueprint.couplings.iter_mut();
    if let Some(coupling) = couplings.find(|c| has_jacobian(&c.component)) {
        coupling.component.set("matrix", Value::List(rows));
        coupling.component.set("offset", list(&offsets));
    }
    Ok(())
}

impl Answer for Calibrated {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let Calibration { coordinates, condition, motion_condition, samples, .. } =
            &self.calibration;
        writeln!(out, "J, with the half widths of the 95 % intervals:")?;
        for fit in coordinates {
            let entries: Vec<String> = fit
                .row
                .iter()
                .zip(&fit.row_ci95)
                .map(|(value, width)| format!("{value:12.5} ± {width:<9.2e}"))
                .collect();
            writeln!(
                out,
                "{:>8}  {}  p0 {:.5} ± {:.2e}  rms residual {:.4}",
                fit.coordinate,
                entries.join(" "),
                fit.offset,
                fit.offset_ci95,
                fit.rms
            )?;
        }
        writeln!(out, "columns: {}; {samples} samples", self.motions.join(", "))?;
        if let Some(condition) = condition {
            writeln!(out, "condition number of J {condition:.3}")?;
        }
        writeln!(out, "condition number of the motions {motion_condition:.3}")?;
        if self.delay_s > 0.0 {
            writeln!(out, "the positions are {:.6} s late", self.delay_s)?;
        }
        match &self.blueprint {
            Some(file) => writeln!(out, "{}: written", file.display()),
            None => Ok(()),
        }
    }
}
