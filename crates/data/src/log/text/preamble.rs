//! What stands above the table: keys with values, names and units by number or by row.

use super::cells::{Dialect, Kind, comment};
use super::decode;
use crate::log::{ColumnUnit, RATES, units::SECOND};

/// Keys of the sample time, in small letters without signs.
const PERIOD: [&str; 25] = [
    "sampletime",
    "deltax",
    "xdelta",
    "increment",
    "xincrement",
    "xincr",
    "tincr",
    "tinc",
    "sampleinterval",
    "samplinginterval",
    "sampleperiod",
    "samplingperiod",
    "samplingtime",
    "hresolution",
    "horizontalresolution",
    "timeincrement",
    "timestep",
    "timeinterval",
    "timeperpoint",
    "timeresolution",
    "dt",
    "deltat",
    "interval",
    "horizontalinterval",
    "wfincrement",
];
/// Keys of the sample rate in Hz.
const RATE: [&str; 14] = [
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "samplespersecond",
    "samplingfreq",
    "sampleclock",
    "scanrate",
    "rate",
    "fs",
    "samplefreq",
    "abtastrate",
    "abtastfrequenz",
    "acquisitionrate",
];
/// Keys of the first time.
const START: [&str; 10] = [
    "x0",
    "start",
    "xorigin",
    "xorg",
    "xzero",
    "xstart",
    "hoffset",
    "t0",
    "tstart",
    "wfstartoffset",
];
/// Rows that name the columns, and rows that have their units.
const NAMES: [&str; 9] = [
    "tracename",
    "name",
    "names",
    "channelname",
    "channel",
    "signal",
    "signalname",
    "label",
    "source",
];
const UNITS: [&str; 8] =
    ["vunit", "unit", "units", "verticalunits", "yunit", "yunitlabel", "unitlabel", "yunits"];

/// What the preamble says about the table below it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in super::super) struct Preamble {
    /// Sample rate in Hz.
    pub(in super::super) rate: Option<f64>,
    /// Time of the first row in s.
    pub(in super::super) start: Option<f64>,
    /// Cells of a row of names behind its key, or names by number.
    pub(super) names: Vec<String>,
    pub(super) units: Vec<String>,
    /// A key of times that has other numbers for other channels.
    pub(super) apart: Option<String>,
}

impl Preamble {
    /// Reads a line: `key, value`, `key = value`, `key: value`.
    pub(super) fn line(&mut self, line: &[u8], dialect: Dialect) {
        let line = comment(line).unwrap_or(line);
        let cells: Vec<String> =
            dialect.split(line).iter().map(|cell| decode::text(cell)).collect();
        let by_cells = cells.iter().position(|cell| !cell.is_empty()).and_then(|at| {
            let (key, rest) = (cells.get(at)?, cells.get(at + 1..)?);
            let value = rest.iter().find(|cell| !cell.is_empty())?;
            (!key.contains(['=', ':'])).then(|| (key.clone(), value.clone(), rest.to_vec()))
        });
        let text = decode::text(line.trim_ascii());
        let by_sign = || {
            let (key, value) = text.split_once('=').or_else(|| text.split_once(": "))?;
            Some((key.trim().to_owned(), value.trim().trim_matches('"').to_owned(), Vec::new()))
        };
        let by_cells = by_cells.filter(|_| dialect.separator != b' ');
        if let Some((key, value, rest)) = by_cells.or_else(by_sign) {
            self.entry(&key, &value, &rest);
        }
    }

    /// Takes the numbers that stand below keys, as in `Start,Increment`.
    pub(super) fn columns(&mut self, keys: &[String], values: &[String], dialect: Dialect) {
        for (key, value) in keys.iter().zip(values) {
            if dialect.kind(value.as_bytes()) == Kind::Number {
                self.entry(key, value, &[]);
            }
        }
    }

    fn entry(&mut self, key: &str, value: &str, rest: &[String]) {
        let title = key;
        let (key, unit) = match key.split_once(['(', '[']) {
            Some((key, unit)) => (key, unit.trim_end_matches([')', ']'])),
            None => (key, rest.get(1).map_or("", String::as_str)),
        };
        // The same value for a second channel is no unit.
        let unit = if number(unit).is_some() { "" } else { unit };
        let key: String = key
            .chars()
            .filter(char::is_ascii_alphanumeric)
            .map(|c| c.to_ascii_lowercase())
            .collect();
        let key = key.as_str();
        let others = || {
            let values = rest.iter().skip_while(|cell| cell.is_empty());
            values.take_while(|cell| !cell.is_empty()).filter_map(|other| number(other))
        };
        if (PERIOD.contains(&key) || RATE.contains(&key) || START.contains(&key))
            && number(value).is_some_and(|value| others().any(|other| other != value))
        {
            self.apart.get_or_insert_with(|| title.trim().to_owned());
        }
        let numbered =
            |before: &str| key.strip_prefix(before).and_then(|at| at.parse::<usize>().ok());
        for (before, list) in [("name", &mut self.names), ("unit", &mut self.units)] {
            if let Some(at) = numbered(before).filter(|at| *at == list.len()) {
                debug_assert_eq!(at, list.len());
                list.push(value.to_owned());
                return;
            }
        }
        if NAMES.contains(&key) && !rest.is_empty() {
            self.names = rest.to_vec();
        } else if UNITS.contains(&key) && !rest.is_empty() {
            self.units = rest.to_vec();
        } else if PERIOD.contains(&key) {
            let period = quantity(value, unit, &SECOND).filter(|period| RATES.contains(period));
            // A whole number of Hz gives the times that a reader of decimals would give.
            let rate = period.map(|period| 1.0 / period);
            let rounded = |rate: f64| {
                if (rate.round() / rate - 1.0).abs() < 1e-9 { rate.round() } else { rate }
            };
            self.rate = self.rate.or(rate.map(rounded));
        } else if RATE.contains(&key) {
            let hertz = SECOND.times(SECOND, -2);
            self.rate =
                self.rate.or(quantity(value, unit, &hertz).filter(|rate| RATES.contains(rate)));
        } else if START.contains(&key) {
            self.start = self.start.or(quantity(value, unit, &SECOND));
        }
    }
}

fn number(text: &str) -> Option<f64> {
    text.replace(',', ".").parse().ok()
}

/// A number with its unit behind it or beside it; without one it is in the SI unit. `Analog:1e-7` is 1e-7.
fn quantity(value: &str, unit: &str, target: &model::Unit) -> Option<f64> {
    let value = value.rsplit(':').next()?.trim();
    let end =
        value.find(|c: char| !(c.is_ascii_digit() || "+-.,eE".contains(c))).unwrap_or(value.len());
    let (number, behind) = value.split_at(end);
    // "1E" of "1 E…" is no number, "1e-3" is one.
    let number: f64 = number.replace(',', ".").parse().ok()?;
    let text = if behind.trim().is_empty() { unit.trim() } else { behind.trim() };
    let own = match text {
        "" => *target,
        "S" => SECOND,
        text => ColumnUnit::parse(text).ok()?.unit,
    };
    own.convert(number, target).filter(|number| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(lines: &[&str]) -> Preamble {
        let mut preamble = Preamble::default();
        lines.iter().for_each(|line| preamble.line(line.as_bytes(), Dialect::PLAIN));
        preamble
    }

    #[test]
    fn rates_starts_names_and_units() {
        assert_eq!(of(&["# SAMPLE_TIME = 0.00005"]).rate, Some(20_000.0));
        assert_eq!(of(&[";Sample rate,1000"]).rate, Some(1000.0));
        assert_eq!(of(&["; Samplerate: 1 MHz"]).rate, Some(1e6));
        assert_eq!(of(&["Sample Interval,Analog:0.0000001"]).rate, Some(1e7));
        assert_eq!(of(&["Sample Interval,4.0e+01,us"]).rate, Some(25_000.0));
        assert_eq!(of(&["Sampling Rate [kHz],20"]).rate, Some(20_000.0));
        let both =
            of(&["\"HResolution\",1.0E-05", "\"HOffset\",-5e-2", "\"TraceName\",\"CH1\",\"CH2\""]);
        assert_eq!((both.rate, both.start), (Some(100_000.0), Some(-0.05)));
        assert_eq!(both.names, ["CH1", "CH2"]);
        let gcs =
            of(&["# NAME0 = Target Position of axis1", "# NAME1 = Current Position of axis1"]);
        assert_eq!(gcs.names[1], "Current Position of axis1");
        assert_eq!(of(&["Date,2026/11/25", "Rate,fast", "sample rate,0"]), Preamble::default());
    }
}
