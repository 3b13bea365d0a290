//! Tables in which signals have times of their own: several columns of time, each before its signals.

use std::io::{BufRead, BufReader, Read};

use super::layout::Layout;
use super::preamble::Preamble;
use super::rows::{is_name_of, is_same_unit, other_unit};
use super::{BUFFER, Source, decode};
use crate::Problems;
use crate::log::group::{Found, Group, Raw};
use crate::log::header_cell::name_and_unit;
use crate::log::lines::Place;
use crate::log::ticks::{self, Base, Start};
use crate::log::{Log, cell, time_column};

/// Whether a cell of the header names a column of times.
fn is_time(cell: &str) -> bool {
    time_column::of_name(name_and_unit(cell).0).is_some()
}

/// Says why the signals cannot be used that have another unit in this part than in the first.
fn compare(
    layout: &Layout,
    is_time: &[bool],
    head: &Preamble,
    place: Place,
    why: &mut [Option<String>],
) {
    let stated = |preamble: &Preamble| {
        let units = preamble.units.iter().map(|unit| unit.trim().to_owned());
        units.filter(|unit| !unit.is_empty()).collect::<Vec<_>>()
    };
    let (first, other) = (stated(&layout.preamble), stated(head));
    let is_signal =
        |at: &usize| !is_time[*at] && layout.kinds.get(*at).is_some_and(|kind| kind.is_value());
    let signals = (0..is_time.len()).filter(is_signal);
    for (nth, at) in signals.enumerate() {
        let [first, other] =
            [&first, &other].map(|units| units.get(nth).map_or("", String::as_str));
        if !is_same_unit(first, other) {
            why[at].get_or_insert_with(|| other_unit(first, other, place));
        }
    }
}

/// Reads them as groups: those with the same times are one log.
pub(super) fn read(
    bytes: impl Read,
    layout: &Layout,
    source: &Source<'_>,
) -> Result<Log, Problems> {
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); layout.header.len()];
    let is_time: Vec<bool> = layout.header.iter().map(|cell| is_time(cell)).collect();
    let mut bases = vec![Base::default(); layout.header.len()];
    // The part of the file in which a row stands, and whether its head is being read.
    let (mut parts, mut is_head) = (Vec::new(), false);
    let mut part = 0_u32;
    let mut other_units = vec![None; layout.header.len()];
    let mut head = Preamble::default();
    let mut head_line = 0;
    let mut text = Vec::new();
    let mut bytes = BufReader::with_capacity(BUFFER, bytes);
    for line in layout.line.. {
        text.clear();
        if bytes.read_until(b'\n', &mut text).map_err(|error| source.broken(error))? == 0 {
            break;
        }
        if text.trim_ascii().is_empty() || super::cells::comment(&text).is_some() {
            continue;
        }
        let row = layout.dialect.split(&text);
        // LabVIEW writes a head before each part that it appends, others the names again.
        let is_names = row.len() > 1
            && row.iter().zip(&layout.header).all(|(cell, name)| is_name_of(name, cell));
        if is_head || is_names || row.first().is_some_and(|cell| **cell == *b"Channels") {
            part += u32::from(is_names);
            if !is_head {
                (head, head_line) = (Preamble::default(), line);
            }
            is_head = !is_names;
            match is_head {
                true => head.line(&text, layout.dialect),
                false => compare(layout, &is_time, &head, Place::Line(head_line), &mut other_units),
            }
            continue;
        }
        parts.push(f64::from(part));
        for (column, at) in columns.iter_mut().zip(0..) {
            let cell = row.get(at).map_or(&[][..], |cell| cell);
            if cell.trim_ascii().is_empty()
                || !layout.kinds.get(at).is_some_and(|kind| kind.is_value())
            {
                // Shorter columns end before the others; a gap inside one is reported by its row.
                column.push(f64::NAN);
                continue;
            }
            if column.is_empty()
                && is_time[at]
                && let Some(first) = ticks::integer(cell)
            {
                bases[at] = Base::of(first);
            }
            let number = match layout.dialect.has_commas {
                _ if !bases[at].is_none() => bases[at].cell(cell),
                true => cell::parse_with_comma(cell),
                false => cell::parse(cell),
            };
            column.push(number.map_err(|(rule, way_out)| {
                let problem = source.problem(rule, way_out).line(line).at(&layout.header[at]);
                Problems::from(problem.value(format!("\"{}\"", decode::text(cell))))
            })?);
        }
    }
    let mut groups: Vec<Group> = Vec::new();
    let columns = layout.header.iter().zip(columns).zip(&layout.kinds);
    for ((((cell, mut values), kind), base), other) in columns.zip(bases).zip(other_units) {
        let start = if base.is_none() { Start::None } else { Start::Long(base) };
        let (name, unit) = name_and_unit(cell);
        let end = values.iter().rposition(|value| !value.is_nan()).map_or(0, |at| at + 1);
        values.truncate(end);
        if time_column::of_name(name).is_some() {
            let unit = if unit == Some("S") {
                Some("s")
            } else {
                unit.or(time_column::of_name(name).flatten())
            };
            let time = Raw::new("time", unit.map(str::to_owned), values).after(start);
            groups.push(Group::new("", vec![time]));
            continue;
        }
        let Some(group) = groups.last_mut() else { continue };
        if !kind.is_value() {
            if !name.is_empty() {
                group.leave_out(name, "holds no numbers");
            }
            continue;
        }
        if let Some(why) = other {
            group.leave_out(name, why);
            continue;
        }
        if group.name.is_empty() {
            name.clone_into(&mut group.name);
        }
        group.columns.push(Raw::new(name, unit.map(str::to_owned), values).after(start));
    }
    let (mut groups, empty): (Vec<_>, Vec<_>) =
        groups.into_iter().partition(|group| group.columns.len() > 1);
    if let Some(first) = groups.first_mut() {
        first.left_out.extend(empty.into_iter().flat_map(|group| group.left_out));
    }
    for group in &mut groups {
        let rows = group.columns.iter().map(|raw| raw.values.len()).max().unwrap_or(0);
        group.columns.iter_mut().for_each(|raw| raw.values.resize(rows, f64::NAN));
        if part > 0 {
            group.columns.push(Raw::new("record", None, parts[..rows].to_vec()));
        }
    }
    let mut found = Found::from(groups);
    if part > 0 {
        let parts = part + 1;
        found.notes.push(format!("has {parts} parts with a header each, which are records"));
    }
    found.notes.push("has several columns of time, each of the signals behind it".into());
    found.log(source.origin, source.options, source.datasets)
}
