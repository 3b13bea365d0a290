//! The list of signals as documentation, in Markdown.

use std::fmt::Write;

use crate::parameter::Parameter;
use crate::registry::FAMILIES;
use crate::signal::Signal;
use crate::signal_type::SignalType;

const HEAD: &str = "\
# Signals

Written by `cargo run -p piezoloop-signals --example signals_reference > crates/signals/SIGNALS.md`.

Value n stands at t = n·T, n = 0 … N − 1, and acts until (n + 1)·T. Limits, samples, duration and
crest factor (of the alternating part) are those of the start values of all parameters.
";

/// Table of all signals: name, sentence, source, and channels, sample time, samples, duration and
/// crest factors with the start values of all parameters.
#[must_use]
pub fn table() -> String {
    let mut text = String::from(
        "| signal | what it is | source | channels | T | samples | duration | crest factor |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for signal in FAMILIES.iter().flat_map(|family| family.signals) {
        text.push_str(&row(signal));
    }
    text
}

/// The whole document: the table, then the reference.
#[must_use]
pub fn document() -> String {
    format!("{HEAD}\n{}\n{}", table(), reference())
}

/// Every signal with its equation, its parameters and its rules.
#[must_use]
pub fn reference() -> String {
    let mut text = String::new();
    for family in FAMILIES {
        text.push_str(&format!("## {}\n\n", family.title));
        for signal in family.signals {
            text.push_str(&section(signal));
        }
    }
    text
}

fn row(kind: &SignalType) -> String {
    // Start values keep every rule: a test generates all signals with them.
    let Ok(signal) = kind.generate(&[]) else { return String::new() };
    let channels: Vec<String> = kind
        .channels
        .iter()
        .map(|c| format!("{} {} to {}{}", c.name, number(c.low), number(c.high), shown(c.unit)))
        .collect();
    format!(
        "| `{}` | {} | {} | {} | {} s | {} | {} s | {} |\n",
        kind.name,
        cell(kind.summary),
        cell(kind.source),
        channels.join("; "),
        number(signal.period),
        signal.len(),
        number(signal.duration()),
        crest_factors(&signal),
    )
}

fn crest_factors(signal: &Signal) -> String {
    let one = |factor: Option<f64>| factor.map_or("-".to_owned(), |f| format!("{f:.2}"));
    let all: Vec<String> = signal.channels.iter().map(|c| one(c.crest_factor())).collect();
    all.join("; ")
}

fn section(kind: &SignalType) -> String {
    let mut text = format!(
        "### `{}`\n\n{}. Source: {}.\n\n{}\n\n| parameter | unit | start | least | greatest | |\n\
         |---|---|---|---|---|---|\n",
        kind.name, kind.summary, kind.source, kind.equation
    );
    for parameter in kind.parameters {
        text.push_str(&parameter_row(parameter));
    }
    text.push('\n');
    for rule in kind.rules {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "* `{}` {}.", rule.parameter, rule.text);
    }
    if !kind.rules.is_empty() {
        text.push('\n');
    }
    text
}

fn parameter_row(parameter: &Parameter) -> String {
    let Parameter { name, unit, description, start, min, max, .. } = parameter;
    let [start, min, max] = [start, min, max].map(|value| number(*value));
    format!("| `{name}` | {unit} | {start} | {min} | {max} | {} |\n", cell(description))
}

/// Text within a table's cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// A unit behind a number; 1 is not written.
fn shown(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// A number as short as its ten significant digits allow.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    let size = rounded.abs();
    if size != 0.0 && !(1e-3..1e7).contains(&size) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (20e-6, "2e-5"),
            (0.1 + 0.2, "0.3"),
            (4000.0, "4000"),
            (-0.0054, "-0.0054"),
            (1e9, "1e9"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn bars_do_not_break_the_table() {
        assert_eq!(cell("|x − round x|"), "\\|x − round x\\|");
    }
}
