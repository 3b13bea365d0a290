//! What the interactive layer draws from: the view as JSON inside the page.

use serde::Serialize;

use super::packed::Ends;
use super::scale::{Mapping, Scale};
use super::view::{AxisView, Chart, DASHES, Kind, PanelView, TraceView};
use crate::figure::{Band, Limit, Marker};

#[derive(Serialize)]
struct Payload<'a> {
    kind: &'static str,
    equal: bool,
    /// How many samples a drawn pair of points stands for.
    stretch: usize,
    x: AxisData<'a>,
    /// Ends of the grid of all horizontal values, so that equal ones stay equal.
    ends: [f64; 2],
    /// Horizontal values of all curves, where they share them.
    #[serde(skip_serializing_if = "Option::is_none")]
    shared: Option<String>,
    panels: Vec<PanelData<'a>>,
    entries: Vec<EntryData<'a>>,
    bands: &'a [Band],
    markers: &'a [Marker],
}

#[derive(Serialize)]
struct AxisData<'a> {
    label: &'a str,
    unit: &'a str,
    heading: String,
    mapping: &'static str,
    offset: f64,
    exponent: i32,
    low: f64,
    high: f64,
}

#[derive(Serialize)]
struct PanelData<'a> {
    y: AxisData<'a>,
    weight: f64,
    traces: Vec<TraceData>,
    limits: &'a [Limit],
}

#[derive(Serialize)]
struct TraceData {
    entry: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    x: Option<String>,
    ends: [f64; 2],
    y: String,
}

#[derive(Serialize)]
struct EntryData<'a> {
    name: &'a str,
    colour: usize,
    dash: &'a [u8],
}

/// The chart's data, safe inside a `script` element; `None` if there is nothing to interact with.
pub(super) fn json(chart: &Chart) -> Option<String> {
    let kind = match chart.kind {
        Kind::Shared => "shared",
        Kind::Curves => "curves",
        Kind::Free => "free",
        Kind::Bars => return None,
    };
    let traces = || chart.panels.iter().flat_map(|panel| &panel.traces);
    if !traces().any(|trace| trace.y.iter().any(|y| y.is_finite())) {
        return None;
    }
    let ends = Ends::of(chart.x.scale.mapping, traces().flat_map(|trace| trace.x.iter()));
    let shared = match chart.kind {
        Kind::Shared => traces().next().map(|trace| ends.text(&trace.x)),
        _ => None,
    };
    let own = shared.is_none().then_some(ends);
    let payload = Payload {
        kind,
        equal: chart.equal_scale,
        stretch: chart.stretch(),
        x: axis(&chart.x),
        ends: ends.pair(),
        shared,
        panels: chart.panels.iter().map(|p| panel(p, own)).collect(),
        entries: chart
            .entries
            .iter()
            .map(|entry| EntryData {
                name: &entry.name,
                colour: entry.style.colour,
                dash: DASHES.get(entry.style.dash).copied().unwrap_or_default(),
            })
            .collect(),
        bands: chart.bands,
        markers: chart.markers,
    };
    // Numbers, strings and lists cannot fail to be written; if they did, the picture remains.
    serde_json::to_string(&payload).ok().map(|json| inside_script(&json))
}

fn axis(view: &AxisView) -> AxisData<'_> {
    let Scale { mapping, low, high } = view.scale;
    let mapping = match mapping {
        Mapping::Linear => "linear",
        Mapping::Degrees => "degrees",
        Mapping::Log => "log",
    };
    AxisData {
        label: &view.label,
        unit: &view.unit,
        heading: view.heading(&view.scale),
        mapping,
        offset: view.scale.offset(),
        exponent: view.scale.exponent(),
        low,
        high,
    }
}

/// `own`: the grid of the horizontal values, where each curve has its own.
fn panel<'a>(view: &'a PanelView, own: Option<Ends>) -> PanelData<'a> {
    let trace = |trace: &TraceView| {
        let ends = Ends::of(view.y.scale.mapping, trace.y.iter());
        TraceData {
            entry: trace.entry,
            x: own.map(|grid| grid.text(&trace.x)),
            ends: ends.pair(),
            y: ends.text(&trace.y),
        }
    };
    PanelData {
        y: axis(&view.y),
        weight: view.weight,
        traces: view.traces.iter().map(trace).collect(),
        limits: view.limits,
    }
}

/// JSON in which no character can end a `script` element or begin a comment in it.
fn inside_script(json: &str) -> String {
    let mut safe = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => {
                safe.push_str(&format!("\\u{:04x}", u32::from(c)));
            }
            c => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_cannot_leave_its_element() {
        let text = "</script><!--\u{2028}&";
        let safe = inside_script(&serde_json::to_string(text).unwrap());
        assert!(!safe.contains(['<', '>', '&', '\u{2028}']), "{safe}");
        assert_eq!(serde_json::from_str::<String>(&safe).unwrap(), text);
    }
}
