//! From a [`Blueprint`] to TOML: a fixed order, lines of reasonable length.

use std::fmt::Write;

use super::{AxisBlueprint, Blueprint, ComponentBlueprint, SignalBlueprint, Value};
use crate::toml_text::{key, quoted};
use model::Kind;

/// Longest line of a list.
const WIDTH: usize = 100;

pub(super) fn to_toml(blueprint: &Blueprint) -> String {
    let mut text = String::from("piezoloop = 1\n");
    let kind = match blueprint.kind {
        Kind::Plant => "plant",
        Kind::Controller => "controller",
    };
    line(&mut text, "kind", &quoted(kind));
    text_line(&mut text, "name", &blueprint.name);
    text_line(&mut text, "description", &blueprint.description);
    text_line(&mut text, "source", &blueprint.source);
    text_line(&mut text, "author", &blueprint.author);
    text_line(&mut text, "version", &blueprint.version);
    text_line(&mut text, "copyright", &blueprint.copyright);
    text_line(&mut text, "license", &blueprint.license);
    line(&mut text, "step", &inline(&blueprint.step));
    signal_line(&mut text, "temperature", &blueprint.temperature);
    for axis in &blueprint.axes {
        text.push_str("\n[[axis]]\n");
        write_axis(&mut text, axis);
    }
    for coupling in &blueprint.couplings {
        text.push_str("\n[[coupling]]\n");
        let axes: Vec<String> = coupling.axes.iter().map(|name| quoted(name)).collect();
        line(&mut text, "axes", &format!("[{}]", axes.join(", ")));
        text_line(&mut text, "after", &coupling.after);
        write_component(&mut text, &coupling.component);
    }
    for connection in &blueprint.connections {
        text.push_str("\n[[connection]]\n");
        line(&mut text, "from", &quoted(&connection.from));
        line(&mut text, "to", &quoted(&connection.to));
    }
    text
}

fn write_axis(text: &mut String, axis: &AxisBlueprint) {
    text_line(text, "name", &axis.name);
    for (key, signal) in [
        ("command", &axis.command),
        ("position", &axis.position),
        ("reference", &axis.reference),
        ("measured", &axis.measured),
        ("force", &axis.force),
        ("disturbance", &axis.disturbance),
        ("motion", &axis.motion),
    ] {
        signal_line(text, key, signal);
    }
    for component in &axis.components {
        text.push_str("\n[[axis.component]]\n");
        write_component(text, component);
    }
}

/// A line for a signal, or none where nothing of it is given.
fn signal_line(text: &mut String, key: &str, signal: &SignalBlueprint) {
    if *signal != SignalBlueprint::default() {
        line(text, key, &inline_signal(signal));
    }
}

fn inline_signal(signal: &SignalBlueprint) -> String {
    let mut items = Vec::new();
    for (key, text) in [("name", &signal.name), ("unit", &signal.unit)] {
        if !text.is_empty() {
            items.push(format!("{key} = {}", quoted(text)));
        }
    }
    for (key, value) in [("min", &signal.min), ("max", &signal.max), ("start", &signal.start)] {
        if let Some(value) = value {
            items.push(format!("{key} = {}", inline(value)));
        }
    }
    format!("{{ {} }}", items.join(", "))
}

fn write_component(text: &mut String, component: &ComponentBlueprint) {
    text_line(text, "type", &component.kind);
    text_line(text, "name", &component.name);
    if !component.enabled {
        line(text, "enabled", "false");
    }
    for (name, value) in &component.values {
        let name = key(name);
        let short = inline(value);
        match value {
            Value::List(items) if name.len() + 3 + short.len() > WIDTH => {
                line(text, &name, &folded(items));
            }
            _ => line(text, &name, &short),
        }
    }
    if !component.tolerance.is_empty() {
        let items: Vec<String> = component
            .tolerance
            .iter()
            .map(|(name, relative)| format!("{} = {}", key(name), number(*relative)))
            .collect();
        line(text, "tolerance", &format!("{{ {} }}", items.join(", ")));
    }
    text_line(text, "note", &component.note);
}

fn line(text: &mut String, key: &str, value: &str) {
    let _ = writeln!(text, "{key} = {value}");
}

/// A line for a text, or none where it is empty.
fn text_line(text: &mut String, key: &str, value: &str) {
    if !value.is_empty() {
        line(text, key, &quoted(value));
    }
}

/// A list over several lines.
fn folded(items: &[Value]) -> String {
    let mut text = String::from("[");
    let mut width = WIDTH;
    for item in items {
        let item = inline(item);
        if width + item.len() + 2 > WIDTH {
            text.push_str("\n   ");
            width = 3;
        }
        let _ = write!(text, " {item},");
        width += item.len() + 2;
    }
    text.push_str("\n]");
    text
}

fn inline(value: &Value) -> String {
    match value {
        Value::Number(value) => number(*value),
        Value::Text(text) => quoted(text),
        Value::List(items) => {
            let items: Vec<String> = items.iter().map(inline).collect();
            format!("[{}]", items.join(", "))
        }
    }
}

/// The shortest text that is read as the same number; whole numbers without a point.
fn number(value: f64) -> String {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    let is_negative_zero = value == 0.0 && value.is_sign_negative();
    if value.fract() == 0.0 && value.abs() < EXACT && !is_negative_zero {
        return format!("{value}");
    }
    match value {
        _ if value.is_nan() => "nan".into(),
        f64::INFINITY => "inf".into(),
        f64::NEG_INFINITY => "-inf".into(),
        _ => format!("{value:?}"),
    }
}
