//! National Instruments' TDMS.

mod object;
mod scale;
mod segments;
mod values;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use self::object::{Object, Property};
use self::segments::File;
use super::broken;
use super::budget::Budget;
use super::names::Names;
use crate::log::group::{Found, Group, Raw, Refusal};
use crate::log::header_cell;

/// The channels of a group that were sampled at the same times are one group; times come from a channel `time`, else
/// from the waveform properties: `wf_increment`, from `wf_start_offset` on, and `wf_start_time` against the
/// file's first channel (groups of tests that were run one after the other have other times), else
/// from a channel of instants.
pub(super) fn read(path: &Path, budget: &mut Budget, is_timed: bool) -> Result<Found, Refusal> {
    let bytes = std::fs::read(path).map_err(|error| broken("TDMS", error))?;
    let mut file = File::read(&bytes, budget)?;
    let mut found = Found::default();
    if let Some(place) = file.cut.take() {
        found.notes.push(format!("the file is cut off {place}; what is whole is read"));
    }
    let properties = |file: &File, names: &[String]| {
        let object = file.objects.iter().find(|object| object.names == names);
        object.map_or_else(BTreeMap::new, |object| object.properties.clone())
    };
    let root = properties(&file, &[]);
    let mut channels: Vec<(String, Vec<Object>)> = Vec::new();
    let mut places = HashMap::new();
    let mut above = HashMap::new();
    for object in std::mem::take(&mut file.objects) {
        match object.names.as_slice() {
            [group] => drop(above.insert(group.clone(), object.properties)),
            [group, _] => {
                let at = *places.entry(group.clone()).or_insert(channels.len());
                if at == channels.len() {
                    channels.push((group.clone(), Vec::new()));
                }
                channels[at].1.push(object);
            }
            _ => {}
        }
    }
    let none = BTreeMap::new();
    let mut first = None;
    for (name, objects) in channels {
        let above = [above.get(&name).unwrap_or(&none), &root];
        group(&name, objects, above, is_timed, &mut first, &mut found);
    }
    Ok(found)
}

/// Adds the channels of a group.
fn group(
    name: &str,
    objects: Vec<Object>,
    above: [&BTreeMap<String, Property>; 2],
    is_timed: bool,
    first: &mut Option<(i64, u64)>,
    found: &mut Found,
) {
    let mut sampled: Vec<Sampled> = Vec::new();
    let mut left_out = Vec::new();
    let mut given = Names::default();
    // Where times are known, a channel "Time" is a channel.
    let has_time = is_timed || objects.iter().any(|object| object.names[1] == "time");
    for mut object in objects {
        let (title, in_name) = header_cell::split(&object.names[1]);
        let mut title = title.to_owned();
        let unit = ["unit_string", "NI_UnitDescription"].iter().find_map(|key| object.text(key));
        let unit = unit.filter(|unit| !unit.is_empty()).or(in_name).map(str::to_owned);
        if let Err(why) = scale::scaled(&mut object, &above) {
            object.why_not.get_or_insert(why);
        }
        if let Some(why) = object.why_not {
            left_out.push((title, why));
            continue;
        }
        if let Some((key, rows)) = &object.changed {
            found.notes.push(format!(
                "channel \"{name}/{title}\" has another {key} behind row {rows}: its times continue from the first one, so that a pause there is not seen"
            ));
        }
        let grid = Grid::of(&object, first);
        let mut values = object.values;
        let mut is_time = !object.instants.is_empty() || title.to_lowercase() == "time";
        if let Some(start) = object.instants.first() {
            let from = first.get_or_insert(*start);
            values = object.instants.iter().map(|instant| after(*instant, *from)).collect();
        } else if is_time && title != "time" {
            is_time = !has_time && values.windows(2).all(|pair| pair[0] < pair[1]);
        }
        if values.is_empty() {
            left_out.push((title, "has no values".into()));
            continue;
        }
        let same = sampled.iter().position(|sampled| sampled.fits(values.len(), grid));
        let at = same.unwrap_or_else(|| {
            sampled.push(Sampled {
                grid,
                rows: values.len(),
                columns: Vec::new(),
                has_time: false,
            });
            sampled.len() - 1
        });
        let sampled = &mut sampled[at];
        if grid.is_none() && sampled.grid.is_some() && !sampled.has_time {
            found.notes.push(format!(
                "channel \"{name}/{title}\" says no wf_increment: it is taken as sampled with the others of its length"
            ));
        }
        sampled.grid = sampled.grid.or(grid);
        let is_instants = !object.instants.is_empty();
        if is_time && !sampled.has_time {
            sampled.has_time = true;
            if title != "time" {
                found.notes.push(format!("channel \"{name}/{title}\" is taken as the time"));
            }
            let unit = if is_instants { Some("s".into()) } else { unit };
            sampled.columns.insert(0, Raw::new("time", unit, values));
        } else if is_instants {
            left_out.push((title, "holds dates, as another channel does".into()));
        } else {
            title = given.free(&title);
            sampled.columns.push(Raw::new(title, unit, values));
        }
    }
    let is_one = sampled.len() == 1;
    for part in sampled {
        let name = match (is_one, part.columns.first()) {
            (false, Some(first)) => format!("{name}/{}", first.name),
            _ => name.to_owned(),
        };
        let mut group = Group::new(name, part.with_times());
        for (name, why) in left_out.drain(..) {
            group.leave_out(name, why);
        }
        found.groups.push(group);
    }
    if let (false, Some(last)) = (left_out.is_empty(), found.groups.last_mut()) {
        left_out.into_iter().for_each(|(name, why)| last.leave_out(name, why));
    }
}

/// Channels that were sampled at the same times.
struct Sampled {
    /// `None` where no channel says it.
    grid: Option<Grid>,
    rows: usize,
    columns: Vec<Raw>,
    has_time: bool,
}

impl Sampled {
    fn fits(&self, rows: usize, grid: Option<Grid>) -> bool {
        let is_same = self.grid.zip(grid).is_none_or(|(own, other)| own.is_like(other));
        self.rows == rows && is_same
    }

    /// The columns with a column `time` before them, where there is none and the grid is known.
    fn with_times(mut self) -> Vec<Raw> {
        if let (Some(grid), false) = (self.grid, self.has_time) {
            // A whole number of Hz gives the times that a reader of decimals would give.
            let rate = (1.0 / grid.period).round();
            let is_exact = (rate * grid.period - 1.0).abs() < 1e-12;
            let after =
                |row: usize| if is_exact { row as f64 / rate } else { row as f64 * grid.period };
            let times = (0..self.rows).map(|row| grid.start + after(row)).collect();
            self.columns.insert(0, Raw::new("time", Some("s".into()), times));
        }
        self.columns
    }
}

/// When a channel was sampled: its first sample and its sample time, in s.
#[derive(Clone, Copy)]
struct Grid {
    start: f64,
    period: f64,
}

impl Grid {
    /// Whether two channels were sampled at the same times, as far as clocks can say: a converter
    /// gives its channels starts that differ in the last digits.
    fn is_like(self, other: Self) -> bool {
        let apart = (self.start - other.start).abs().max((self.period - other.period).abs());
        apart <= 1e-6 * self.period && (self.period / other.period - 1.0).abs() < 1e-9
    }

    /// `first` is the start of the file's first channel that has one.
    fn of(channel: &Object, first: &mut Option<(i64, u64)>) -> Option<Self> {
        let period = channel.number("wf_increment").filter(|period| *period > 0.0)?;
        let mut start = channel.number("wf_start_offset").unwrap_or(0.0);
        if let Some(Property::Instant(seconds, parts)) = channel.properties.get("wf_start_time") {
            let from = *first.get_or_insert((*seconds, *parts));
            start += after((*seconds, *parts), from);
        }
        Some(Self { start, period })
    }
}

/// Seconds from one instant to another: whole seconds, and parts of 2⁻⁶⁴ s.
fn after((seconds, parts): (i64, u64), (from, part): (i64, u64)) -> f64 {
    let parts = (parts as f64 - part as f64) / 2.0_f64.powi(64);
    seconds.saturating_sub(from) as f64 + parts
}
