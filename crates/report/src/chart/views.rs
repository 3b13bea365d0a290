//! From each kind of figure to a chart.

use std::borrow::Cow;

use super::scale::{Mapping, Scale};
use super::view::{AxisView, BarsView, Chart, Entry, Kind, PanelView, TraceView, styles};
use crate::figure::{Bode, Figure, Histogram, Limit, Response, Role, Spectrum, TimeSeries, XyLoop};
use crate::number::{format_number, format_unit};

/// Room above and below the curves, in parts of their range.
const MARGIN: f64 = 0.05;

/// The chart of a figure.
pub(super) fn of(figure: &Figure) -> Chart<'_> {
    match figure {
        Figure::TimeSeries(figure) => time_series(figure),
        Figure::XyLoop(figure) => xy_loop(figure),
        Figure::Spectrum(figure) => spectrum(figure),
        Figure::Bode(figure) => bode(figure),
        Figure::Histogram(figure) => histogram(figure),
    }
}

fn entries<'a>(named: impl Iterator<Item = (&'a String, Role)>) -> Vec<Entry> {
    let named: Vec<(&String, Role)> = named.collect();
    let roles: Vec<Role> = named.iter().map(|(_, role)| *role).collect();
    let looks = styles(&roles);
    named
        .into_iter()
        .zip(looks)
        .map(|((name, _), style)| Entry { name: name.clone(), style })
        .collect()
}

fn names(entries: &[Entry]) -> String {
    let names: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
    names.join(", ")
}

/// `from 0 to 10 s`.
fn extent(scale: &Scale, unit: &str) -> String {
    let text =
        format!("from {} to {} {unit}", format_number(scale.low, 4), format_number(scale.high, 4));
    text.trim_end().to_owned()
}

fn time_series(figure: &TimeSeries) -> Chart<'_> {
    let x = AxisView::new(
        &figure.x.label,
        &figure.x.unit,
        Scale::spanning(Mapping::Linear, figure.time.iter().copied(), 0.0),
    );
    let (named, numbers) = legend(&figure.panels);
    let entries = entries(named.into_iter());
    let panels = figure
        .panels
        .iter()
        .zip(numbers)
        .map(|(panel, numbers)| {
            let values = panel.traces.iter().flat_map(|trace| trace.values.iter().copied());
            let limits = panel.limits.iter().map(|limit| limit.value);
            let scale = Scale::spanning(Mapping::Linear, values.chain(limits), MARGIN);
            let traces = panel
                .traces
                .iter()
                .zip(numbers)
                .map(|(trace, entry)| TraceView {
                    entry,
                    x: Cow::from(&figure.time),
                    y: Cow::from(&trace.values),
                })
                .collect();
            PanelView {
                y: AxisView::new(
                    panel_label(&panel.label, &panel.traces),
                    panel.unit.as_deref().unwrap_or_default(),
                    scale,
                ),
                weight: 1.0,
                traces,
                bars: Vec::new(),
                limits: &panel.limits,
            }
        })
        .collect();
    Chart {
        title: &figure.title,
        description: format!(
            "Signals over {} {}: {}.",
            x.label,
            extent(&x.scale, &x.unit),
            names(&entries)
        ),
        kind: Kind::Shared,
        compact: false,
        samples: figure.samples,
        equal_scale: false,
        x,
        panels,
        entries,
        bands: &figure.bands,
        markers: &figure.markers,
    }
}

/// Names and roles of the legend, and for each panel the number of each trace's entry. A name that comes
/// again in another panel, with the same role, is the same curve to the legend.
fn legend(panels: &[crate::figure::Panel]) -> (Vec<(&String, Role)>, Vec<Vec<usize>>) {
    let mut named: Vec<(&String, Role)> = Vec::new();
    let mut numbers = Vec::new();
    for panel in panels {
        let before = named.len();
        let mut own: Vec<usize> = Vec::new();
        for trace in &panel.traces {
            let this = (&trace.name, trace.role);
            let known = named[..before].iter().position(|entry| *entry == this);
            let number = known.filter(|number| !own.contains(number)).unwrap_or_else(|| {
                named.push(this);
                named.len() - 1
            });
            own.push(number);
        }
        numbers.push(own);
    }
    (named, numbers)
}

/// A panel's own label; a panel of one signal may carry the signal's name.
fn panel_label<'a>(label: &'a str, traces: &'a [crate::figure::Trace]) -> &'a str {
    match traces {
        [only] if label.is_empty() => &only.name,
        _ => label,
    }
}

fn xy_loop(figure: &XyLoop) -> Chart<'_> {
    let entries = entries(figure.loops.iter().map(|line| (&line.name, line.role)));
    let xs = figure.loops.iter().flat_map(|line| line.x.iter().copied());
    let ys = figure.loops.iter().flat_map(|line| line.y.iter().copied());
    let x = AxisView::new(
        &figure.x.label,
        &figure.x.unit,
        Scale::spanning(Mapping::Linear, xs, MARGIN),
    );
    let y = AxisView::new(
        &figure.y.label,
        &figure.y.unit,
        Scale::spanning(Mapping::Linear, ys, MARGIN),
    );
    let traces = figure
        .loops
        .iter()
        .enumerate()
        .map(|(entry, line)| TraceView { entry, x: Cow::from(&line.x), y: Cow::from(&line.y) })
        .collect();
    Chart {
        title: &figure.title,
        description: format!(
            "{} {} over {} {}: {}.",
            y.label,
            extent(&y.scale, &y.unit),
            x.label,
            extent(&x.scale, &x.unit),
            names(&entries)
        ),
        kind: Kind::Free,
        compact: true,
        samples: 0,
        equal_scale: figure.equal_scale,
        x,
        panels: vec![PanelView { y, weight: 1.0, traces, bars: Vec::new(), limits: &[] }],
        entries,
        bands: &[],
        markers: &[],
    }
}

/// The frequency axis of curves, without margin.
fn frequency_axis(frequencies: impl Iterator<Item = f64>) -> AxisView {
    AxisView::new("frequency", "Hz", Scale::spanning(Mapping::Log, frequencies, 0.0))
}

fn spectrum(figure: &Spectrum) -> Chart<'_> {
    let entries = entries(figure.traces.iter().map(|trace| (&trace.name, trace.role)));
    let x = frequency_axis(figure.traces.iter().flat_map(|t| t.frequency.iter().copied()));
    let mapping = if figure.linear { Mapping::Linear } else { Mapping::Log };
    let values = figure.traces.iter().flat_map(|trace| trace.values.iter().copied());
    let limits = figure.limits.iter().map(|limit| limit.value);
    let y = AxisView::new(
        &figure.y.label,
        &figure.y.unit,
        Scale::spanning(mapping, values.chain(limits), MARGIN),
    );
    let traces = figure
        .traces
        .iter()
        .enumerate()
        .map(|(entry, trace)| TraceView {
            entry,
            x: Cow::from(&trace.frequency),
            y: Cow::from(&trace.values),
        })
        .collect();
    Chart {
        title: &figure.title,
        description: format!(
            "{} over frequency {}: {}.",
            y.label,
            extent(&x.scale, "Hz"),
            names(&entries)
        ),
        kind: Kind::Curves,
        compact: false,
        samples: 0,
        equal_scale: false,
        x,
        panels: vec![PanelView {
            y,
            weight: 1.2,
            traces,
            bars: Vec::new(),
            limits: &figure.limits,
        }],
        entries,
        bands: &figure.bands,
        markers: &figure.markers,
    }
}

fn bode(figure: &Bode) -> Chart<'_> {
    let entries = entries(figure.responses.iter().map(|r| (&r.name, r.role)));
    let x = frequency_axis(figure.responses.iter().flat_map(|r| r.frequency.iter().copied()));
    let magnitude = response_panel(figure, "magnitude", &figure.unit, Mapping::Log, |r| {
        Some(Cow::from(&r.magnitude))
    });
    let phase = response_panel(figure, "phase", "deg", Mapping::Degrees, |r| {
        Some(r.phase.iter().map(|rad| (rad.to_degrees() * 1e3).round() / 1e3).collect())
    });
    let mut panels = vec![magnitude, PanelView { weight: 0.7, ..phase }];
    if figure.responses.iter().any(|r| r.coherence.is_some()) {
        let coherence = response_panel(figure, "coherence", "", Mapping::Linear, |r| {
            r.coherence.as_deref().map(Cow::from)
        });
        panels.push(PanelView { weight: 0.4, ..coherence });
        if let Some(panel) = panels.last_mut() {
            panel.y.scale = Scale { mapping: Mapping::Linear, low: 0.0, high: 1.05 };
        }
    }
    Chart {
        title: &figure.title,
        description: format!(
            "Magnitude in {}, phase{} over frequency {}: {}.",
            format_unit(&figure.unit),
            if panels.len() > 2 { " and coherence" } else { "" },
            extent(&x.scale, "Hz"),
            names(&entries)
        ),
        kind: Kind::Curves,
        compact: false,
        samples: 0,
        equal_scale: false,
        x,
        panels,
        entries,
        bands: &figure.bands,
        markers: &figure.markers,
    }
}

/// One panel of a Bode plot; responses without that curve are absent from it.
fn response_panel<'a>(
    figure: &'a Bode,
    label: &str,
    unit: &str,
    mapping: Mapping,
    curve: impl Fn(&'a Response) -> Option<Cow<'a, [f64]>>,
) -> PanelView<'a> {
    let traces: Vec<TraceView> = figure
        .responses
        .iter()
        .enumerate()
        .filter_map(|(entry, r)| {
            curve(r).map(|y| TraceView { entry, x: Cow::from(&r.frequency), y })
        })
        .collect();
    let values = traces.iter().flat_map(|trace| trace.y.iter().copied());
    let scale = Scale::spanning(mapping, values, MARGIN);
    PanelView {
        y: AxisView::new(label, unit, scale),
        weight: 1.0,
        traces,
        bars: Vec::new(),
        limits: &[] as &[Limit],
    }
}

fn histogram(figure: &Histogram) -> Chart<'_> {
    let entries = entries(figure.sets.iter().map(|set| (&set.name, set.role)));
    let marks = figure.markers.iter().map(|marker| marker.at);
    let x = AxisView::new(
        &figure.x.label,
        &figure.x.unit,
        Scale::spanning(Mapping::Linear, figure.edges.iter().copied().chain(marks), 0.02),
    );
    let most = figure.sets.iter().flat_map(|set| &set.counts).copied().max().unwrap_or(0);
    let high = if most == 0 { 1.0 } else { most as f64 * (1.0 + MARGIN) };
    let y = AxisView::new("count", "", Scale { mapping: Mapping::Linear, low: 0.0, high });
    let bars = figure
        .sets
        .iter()
        .enumerate()
        .map(|(entry, set)| BarsView { entry, edges: &figure.edges, counts: &set.counts })
        .collect();
    Chart {
        title: &figure.title,
        description: format!(
            "Histogram of {} {}: {}.",
            x.label,
            extent(&x.scale, &x.unit),
            names(&entries)
        ),
        kind: Kind::Bars,
        compact: true,
        samples: 0,
        equal_scale: false,
        x,
        panels: vec![PanelView { y, weight: 1.0, traces: Vec::new(), bars, limits: &[] }],
        entries,
        bands: &[],
        markers: &figure.markers,
    }
}
