//! Universal files of modal testing, dataset 58 (functions at nodes), as text or with binary values (58b).
//!
//! Layout after the I-DEAS universal file format of SDRC, University of Cincinnati's reference. A dataset stands between
//! lines `    -1`; of 58 the time responses become columns, those with the same times one group.

use std::collections::HashMap;
use std::path::Path;

use super::broken;
use super::budget::Budget;
use super::names::Names;
use crate::log::group::{Found, Group, Raw, Refusal};

/// The line that begins and ends a dataset.
const DELIMITER: &[u8] = b"    -1";
/// Lines of a dataset 58 before its values.
const HEAD: usize = 11;
/// Function type of a time response, and that of an unknown function.
const TIME_RESPONSE: i64 = 1;
const GENERAL: i64 = 0;
/// Specific data type of an abscissa in time.
const TIME: i64 = 17;

/// Whether a file that begins like this is one.
pub(super) fn is_begin(start: &[u8]) -> bool {
    let mut lines = start.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii_end);
    let number = |line: &[u8]| line.starts_with(b"   ") && line[3..].iter().any(u8::is_ascii_digit);
    lines.next() == Some(DELIMITER) && lines.next().is_some_and(number)
}

/// All time responses of a file.
pub(super) fn read(path: &Path, budget: &mut Budget, _: bool) -> Result<Found, Refusal> {
    let bytes = std::fs::read(path).map_err(|error| broken("a universal file", error))?;
    let mut rest = Lines(&bytes);
    let mut found = Found::default();
    let (mut names, mut by_times) = (Names::default(), HashMap::new());
    let (mut left, mut has_units) = (0, false);
    while let Some(line) = rest.next() {
        if line != DELIMITER {
            continue;
        }
        let Some(kind) = rest.next() else { break };
        let text = String::from_utf8_lossy(kind);
        let function = match text.trim_start().strip_prefix("58") {
            Some(binary) if binary.starts_with(['b', 'B']) => {
                Some(Function::read(&mut rest, Some(&binary[1..]))?)
            }
            Some("") => Some(Function::read(&mut rest, None)?),
            _ => {
                has_units |= text.trim() == "164";
                None
            }
        };
        if function.is_none() {
            rest.find(|line| *line == DELIMITER);
        }
        let Some(function) = function else { continue };
        let Some((times, name, unit, values)) = function.signal(budget)? else {
            left += 1;
            continue;
        };
        let key: Vec<u64> = match &times {
            Times::Even { start, step } => {
                vec![start.to_bits(), step.to_bits(), values.len() as u64]
            }
            Times::Each(times) => times.iter().map(|time| time.to_bits()).collect(),
        };
        let at = *by_times.entry(key).or_insert(found.groups.len());
        if at == found.groups.len() {
            budget.column(values.len() as u64)?;
            let times = match times {
                Times::Even { start, step } => {
                    (0..values.len()).map(|k| start + k as f64 * step).collect()
                }
                Times::Each(times) => times,
            };
            let time = Raw::new("time", Some("s".into()), times);
            found.groups.push(Group::new((at + 1).to_string(), vec![time]));
        }
        found.groups[at].columns.push(Raw::new(names.free(&name), unit, values));
    }
    if left > 0 {
        found.notes.push(format!(
            "{left} functions that are no real time responses (spectra, frequency responses) are left out"
        ));
    }
    if has_units {
        found.notes.push("the units of dataset 164 are not used, those of the axes are".to_owned());
    }
    if found.groups.is_empty() {
        let rule = format!("is a universal file without a time response ({left} other functions)");
        return Err((rule, "export the time histories as dataset 58".to_owned()));
    }
    Ok(found)
}

/// Lines of a file, without their ends.
struct Lines<'a>(&'a [u8]);

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        if self.0.is_empty() {
            return None;
        }
        let end = self.0.iter().position(|byte| *byte == b'\n').unwrap_or(self.0.len());
        let line = &self.0[..end];
        self.0 = self.0.get(end + 1..).unwrap_or(&[]);
        Some(line.trim_ascii_end())
    }
}

enum Times {
    Even { start: f64, step: f64 },
    Each(Vec<f64>),
}

/// A function as it stands in the file.
struct Function<'a> {
    head: Vec<String>,
    values: Values<'a>,
}

enum Values<'a> {
    Text(Vec<&'a [u8]>),
    Binary { bytes: &'a [u8], is_little: bool },
}

impl<'a> Function<'a> {
    /// Reads on behind the dataset's number; `binary` is what stands behind `58b`.
    fn read(rest: &mut Lines<'a>, binary: Option<&str>) -> Result<Self, Refusal> {
        let head = rest.take(HEAD).map(|line| String::from_utf8_lossy(line).into_owned());
        let head: Vec<String> = head.collect();
        let short = || broken("a universal file", "it ends within a dataset 58");
        if head.len() < HEAD {
            return Err(short());
        }
        let values = match binary {
            None => Values::Text(rest.take_while(|line| *line != DELIMITER).collect()),
            Some(text) => {
                let numbers: Vec<usize> =
                    text.split_whitespace().map_while(|word| word.parse().ok()).collect();
                let &[order, float, _, length, ..] = numbers.as_slice() else {
                    return Err(broken("a universal file", "58b does not say its bytes"));
                };
                if float != 2 {
                    let why =
                        format!("58b has floating point format {float}, 2 (IEEE 754) is read");
                    return Err(broken("a universal file", why));
                }
                let bytes = rest.0.get(..length).ok_or_else(short)?;
                rest.0 = &rest.0[length..];
                rest.find(|line| *line == DELIMITER);
                Values::Binary { bytes, is_little: order == 1 }
            }
        };
        Ok(Self { head, values })
    }

    /// A field of fixed place of a line.
    fn field(&self, line: usize, from: usize, to: usize) -> &str {
        let line = self.head[line].as_str();
        line.get(from..to.min(line.len())).unwrap_or("").trim()
    }

    fn integer(&self, line: usize, from: usize, to: usize) -> Option<i64> {
        self.field(line, from, to).parse().ok()
    }

    /// Times, name, unit and values; none where it is no real function of time.
    #[expect(clippy::type_complexity, reason = "one call")]
    fn signal(
        &self,
        budget: &mut Budget,
    ) -> Result<Option<(Times, String, Option<String>, Vec<f64>)>, Refusal> {
        let broken = |why: &str| broken("a universal file", format!("a dataset 58 {why}"));
        let of_time = match self.integer(5, 0, 5) {
            Some(TIME_RESPONSE) => true,
            Some(GENERAL) => self.integer(7, 0, 10) == Some(TIME),
            _ => false,
        };
        // 2 and 4 are real, of 4 and 8 bytes.
        let (ordinate, even) = (self.integer(6, 0, 10), self.integer(6, 20, 30));
        let is_double = ordinate == Some(4);
        if !of_time || !(is_double || ordinate == Some(2)) {
            return Ok(None);
        }
        let count = self.integer(6, 10, 20).and_then(|count| u64::try_from(count).ok());
        let count = count.ok_or_else(|| broken("does not say how many values it has"))?;
        let is_even = even == Some(1);
        let mut numbers = self.numbers(is_double, is_even, count, budget)?;
        let per_value = if is_even { 1 } else { 2 };
        let there = (numbers.len() / per_value) as u64;
        if there < count {
            return Err(broken(&format!("has {there} of {count} values; the file is cut off")));
        }
        numbers.truncate(count as usize * per_value);
        let number = |from, to| real(self.field(6, from, to)).filter(|x| x.is_finite());
        let (times, values) = if is_even {
            let step = number(43, 56).filter(|step| *step > 0.0);
            let step = step.ok_or_else(|| broken("has no spacing above zero"))?;
            (Times::Even { start: number(30, 43).unwrap_or(0.0), step }, numbers)
        } else {
            let each = |at: usize| numbers.iter().skip(at).step_by(2).copied().collect();
            (Times::Each(each(0)), each(1))
        };
        let unit = self.field(8, 47, 67);
        let unit = (!unit.eq_ignore_ascii_case("none")).then(|| unit.to_owned());
        Ok(Some((times, self.name(), unit, values)))
    }

    /// The first line of the function's text, else the place where it was measured.
    fn name(&self) -> String {
        let text = self.head[0].trim();
        if !text.is_empty() && !text.eq_ignore_ascii_case("none") {
            return text.to_owned();
        }
        let axis = match self.integer(5, 51, 55).unwrap_or(0) {
            0 => "",
            1 => "+x",
            -1 => "-x",
            2 => "+y",
            -2 => "-y",
            3 => "+z",
            -3 => "-z",
            _ => " rotation",
        };
        format!("node{}{axis}", self.integer(5, 41, 51).unwrap_or(0))
    }

    fn numbers(
        &self,
        is_double: bool,
        is_even: bool,
        count: u64,
        budget: &mut Budget,
    ) -> Result<Vec<f64>, Refusal> {
        let widths = match (is_double, is_even) {
            (true, true) => [20, 20],
            (true, false) => [13, 20],
            (false, _) => [13, 13],
        };
        match &self.values {
            Values::Text(lines) => {
                let mut all = Vec::new();
                for line in lines {
                    let text = String::from_utf8_lossy(line);
                    budget.column(text.len().div_ceil(13) as u64)?;
                    let why = || format!("\"{}\" is no row of numbers", text.trim());
                    let row = row(&text, widths);
                    all.extend(row.ok_or_else(|| broken("a universal file", why()))?);
                }
                Ok(all)
            }
            Values::Binary { bytes, is_little } => {
                budget.column(bytes.len().div_ceil(4) as u64)?;
                // Times beside doubles have 4 bytes by the standard, 8 as many programs write them.
                let has_short_times = is_double && !is_even && (bytes.len() as u64) < 16 * count;
                Ok(unpacked(bytes, *is_little, is_double, has_short_times))
            }
        }
    }
}

/// A number as Fortran writes it.
fn real(text: &str) -> Option<f64> {
    text.trim().replace(['D', 'd'], "e").parse().ok()
}

/// The numbers of a line: apart by blanks, or where these are missing by the widths of their fields in turn.
fn row(text: &str, widths: [usize; 2]) -> Option<Vec<f64>> {
    let words: Option<Vec<f64>> = text.split_whitespace().map(real).collect();
    words.or_else(|| {
        let (mut all, mut at) = (Vec::new(), 0);
        for width in widths.into_iter().cycle() {
            if text.get(at..).is_none_or(|rest| rest.trim().is_empty()) {
                return Some(all);
            }
            all.push(real(text.get(at..(at + width).min(text.len()))?)?);
            at += width;
        }
        None
    })
}

/// IEEE numbers of 4 or 8 bytes; before each double may stand a time of 4 bytes.
fn unpacked(bytes: &[u8], is_little: bool, is_double: bool, has_short_times: bool) -> Vec<f64> {
    let (mut all, mut rest) = (Vec::new(), bytes);
    loop {
        let is_time = has_short_times && all.len() % 2 == 0;
        if is_double && !is_time {
            let Some((head, tail)) = rest.split_first_chunk::<8>() else { return all };
            all.push(if is_little { f64::from_le_bytes(*head) } else { f64::from_be_bytes(*head) });
            rest = tail;
        } else {
            let Some((head, tail)) = rest.split_first_chunk::<4>() else { return all };
            let value =
                if is_little { f32::from_le_bytes(*head) } else { f32::from_be_bytes(*head) };
            all.push(f64::from(value));
            rest = tail;
        }
    }
}
