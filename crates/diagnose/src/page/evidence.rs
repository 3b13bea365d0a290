//! Pictures of a gap: over time, over frequency, over the command, counted.

use std::ops::Range;

use report::{Axis, Histogram, Role, Section, Spectrum, TimeSeries, XyLoop};

use crate::figures::{self, Answered};
use crate::outcome::Outcome;
use crate::spectrum::{self, Bands};
use crate::thresholds::answer::Thresholds;

/// Adds all pictures of an output.
pub(super) fn add(section: Section, o: &Outcome) -> Section {
    over_command(map(signals(section, o), o), o)
}

/// The command of some rows, in its unit.
fn command_of(o: &Outcome, rows: Range<usize>) -> Vec<f64> {
    let data = &o.task.data;
    let hits = data.row_hit[rows].iter();
    hits.map(|hit| data.command[*hit as usize] / o.task.command_factor).collect()
}

/// Measured, model, repaired model and what each leaves, on the stretch of the records in which the gap is largest.
pub(super) fn proof(o: &Outcome) -> Option<TimeSeries> {
    let data = &o.task.data;
    let largest = o.robust.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?.0;
    let record = data.records.iter().find(|record| record.rows.contains(&largest))?;
    let all = record.rows.clone();
    let first = largest.saturating_sub(Thresholds::STRETCH_SHOWN / 2).max(all.start);
    let rows = first..(first + Thresholds::STRETCH_SHOWN).min(all.end);
    let title = format!("{}: {} where the gap is largest", o.task.output, record.name);
    Some(over_time(o, title, rows))
}

/// Measured, model, repaired model and what each leaves, over time, in these rows.
fn over_time(o: &Outcome, title: String, rows: Range<usize>) -> TimeSeries {
    let data = &o.task.data;
    let scale = o.sigma / o.task.factor;
    let unit = o.task.unit.as_str();
    let in_unit = |v: &[f64]| v[rows.clone()].iter().map(|r| r * scale).collect::<Vec<f64>>();
    let y: Vec<f64> = data.y[rows.clone()].iter().map(|y| y / o.task.factor).collect();
    let without = |residual: &[f64]| y.iter().zip(residual).map(|(y, r)| y - r).collect::<Vec<_>>();
    let (before, after) = (in_unit(&o.before().residual), in_unit(&o.with_effects().residual));
    let is_repaired = o.is_explained();
    let mut figure = TimeSeries::new(title, &data.time[rows.clone()])
        .measured("measured", unit, &y)
        .model("model, re-tuned", unit, &without(&before));
    if is_repaired {
        figure = figure.other("model, repaired", unit, &without(&after));
    }
    figure = figure.panel("gap").residual("before", unit, &before);
    if is_repaired {
        figure = figure.other("after", unit, &after);
    }
    figure
}

/// How often the gap has each size, before and after.
fn histogram(o: &Outcome, record: &str, before: &[f64], after: &[f64]) -> Histogram {
    let mut sets = vec![(Role::Residual, "before", before)];
    if o.is_explained() {
        sets.push((Role::Other, "after", after));
    }
    let title = format!("{}: size of the gap, {record}", o.task.output);
    figures::histogram(title, o.task.unit.as_str(), &sets)
}

/// Measured, simulated and what is left, record by record; spectra before and after.
fn signals(mut section: Section, o: &Outcome) -> Section {
    let data = &o.task.data;
    let scale = o.sigma / o.task.factor;
    let unit = o.task.unit.as_str();
    for record in &data.records {
        let rows = record.rows.clone();
        let in_unit = |v: &[f64]| v[rows.clone()].iter().map(|r| r * scale).collect::<Vec<f64>>();
        let y: Vec<f64> = data.y[rows.clone()].iter().map(|y| y / o.task.factor).collect();
        let (before, after) = (in_unit(&o.before().residual), in_unit(&o.with_effects().residual));
        let model: Vec<f64> = y.iter().zip(&before).map(|(y, r)| y - r).collect();
        let title = format!("{}: {}", o.task.output, record.name);
        section = section.figure(over_time(o, title, rows.clone()));
        let mut errors = vec![(Role::Residual, "before", &before[..])];
        if o.is_explained() {
            errors.push((Role::Other, "after", &after));
        }
        let title = format!("Spectrum of the gap: {}", record.name);
        let mut spectrum = figures::spectrum(title, unit, data.sample_time, &errors);
        let floor = scale * (2.0 * data.sample_time).sqrt();
        spectrum = spectrum.limit(floor, "noise");
        section = section.figure(spectrum);
        section = section.figure(histogram(o, &record.name, &before, &after));
        // Of several inputs that move at once one record cannot tell the responses apart.
        let moves = |values: &Vec<f64>| values.windows(2).any(|w| w[0] != w[1]);
        if record.others.iter().any(moves) {
            continue;
        }
        let command = command_of(o, rows.clone());
        let mut outputs = vec![
            (Role::Measured, "measured", &y[..]),
            (Role::Model, "model, re-tuned", &model[..]),
        ];
        let repaired: Vec<f64> = y.iter().zip(&after).map(|(y, r)| y - r).collect();
        if o.is_explained() {
            outputs.push((Role::Other, "model, repaired", &repaired));
        }
        let answered = Answered { input: &command, outputs, period: data.sample_time };
        let title = format!("{}: frequency response, {}", o.task.output, record.name);
        let gain = format!("{unit}/{}", o.task.command_unit);
        if let Some(figure) = figures::bode(title, &gain, &answered) {
            section = section.figure(figure);
        }
    }
    section
}

/// Level of the gap over the noise, record by record and band by band, before and after.
fn map(mut section: Section, o: &Outcome) -> Section {
    let data = &o.task.data;
    let sample = data.sample_time;
    let longest = data.records.iter().map(|r| r.rows.len()).max().unwrap_or(0);
    let bands = Bands::new(longest, sample);
    if bands.ends.len() < 2 {
        return section;
    }
    let centre = |k: usize| (bands.ends[k] * bands.ends[k + 1]).sqrt();
    let axis = || Axis::new("over the noise", "dB");
    for record in &data.records {
        let level = |all: &[f64]| -> (Vec<f64>, Vec<f64>) {
            let powers = spectrum::band_powers(&all[record.rows.clone()], &bands, sample);
            let known = powers.iter().enumerate().filter(|(_, p)| p.is_finite() && **p > 0.0);
            known.map(|(k, p)| (centre(k), 10.0 * p.log10())).unzip()
        };
        let title = format!("{}: gap over the noise by band, {}", o.task.output, record.name);
        let (f, before) = level(&o.robust);
        let mut figure =
            Spectrum::new(title, axis()).linear().trace(Role::Residual, "before", &f, &before);
        if o.is_explained() {
            let (f, after) = level(&o.with_effects().residual);
            figure = figure.trace(Role::Other, "after", &f, &after);
        }
        section = section.figure(figure.limit(0.0, "noise"));
    }
    section
}

/// The gap over the command: loops are memory or lag, lines are maps.
fn over_command(section: Section, o: &Outcome) -> Section {
    let all = gap_over_command(o, "all records", 0..o.task.data.row_hit.len());
    section.figure(all.caption(
        "A loop means memory or lag, a line that is the same both ways a static map, a cloud a disturbance.",
    ))
}

/// The gap over the command of the record in which the command changes most slowly; a fast one is a
/// cloud.
pub(super) fn slowest(o: &Outcome) -> Option<XyLoop> {
    let records = o.task.data.records.iter().map(|record| {
        let command = command_of(o, record.rows.clone());
        let steps = command.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        (steps.fold(0.0, f64::max), record)
    });
    let (_, record) = records.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(gap_over_command(o, &record.name, record.rows.clone()))
}

/// Before and after, of these rows.
fn gap_over_command(o: &Outcome, name: &str, rows: Range<usize>) -> XyLoop {
    let command = command_of(o, rows.clone());
    let scale = o.sigma / o.task.factor;
    let in_unit = |all: &[f64]| all[rows.clone()].iter().map(|r| r * scale).collect::<Vec<f64>>();
    let title = format!("{}: gap over the command, {name}", o.task.output);
    let mut figure = XyLoop::new(
        title,
        Axis::new(o.task.input.as_str(), o.task.command_unit.as_str()),
        Axis::new("gap", o.task.unit.as_str()),
    )
    .line(Role::Residual, "before", &command, &in_unit(&o.robust));
    if o.is_explained() {
        let after = in_unit(&o.with_effects().residual);
        figure = figure.line(Role::Other, "after", &command, &after);
    }
    figure
}
