//! A chart as SVG.

use super::detail::Detail;
use super::scale::{Scale, Ticks};
use super::svg::{escape, path, px};
use super::view::{BarsView, Chart, Kind, PanelView, TraceView};
use crate::number::{format_integer, format_number};
use crate::reduce;

/// Width of a character of a label, about, in pixels.
const CHARACTER: f64 = 6.6;
/// Height of a panel's heading.
const HEADING: f64 = 24.0;
/// Room below a panel for the labels of its ticks.
const TICK_LABELS: f64 = 20.0;
/// Room below the last panel for the heading of the horizontal axis.
const X_HEADING: f64 = 20.0;
/// A curve whose length exceeds this many widths is too dense for dashes.
const DENSE: f64 = 8.0;

/// Sizes in pixels.
pub(super) struct Layout<'a> {
    width: f64,
    plot_height: f64,
    max_points: usize,
    legend: Option<&'a str>,
}

impl<'a> Layout<'a> {
    /// For a page of full width.
    pub(super) fn wide(chart: &Chart, detail: Detail) -> Self {
        let (width, plot_height) = match (chart.compact, chart.panels.len()) {
            (true, _) => (440.0, 290.0),
            (false, 0 | 1) => (880.0, 260.0),
            (false, 2) => (880.0, 190.0),
            (false, _) => (880.0, 150.0),
        };
        let plot_height = if chart.kind == Kind::Curves { plot_height * 1.15 } else { plot_height };
        Self { width, plot_height, max_points: detail.wide, legend: None }
    }

    /// For a telephone.
    pub(super) fn narrow(chart: &Chart, detail: Detail) -> Self {
        let plot_height = if chart.compact { 250.0 } else { 170.0 };
        Self { width: 360.0, plot_height, max_points: detail.narrow, legend: None }
    }

    /// The layout of a picture of its own: title, legend and style sheet are inside.
    pub(super) fn with_legend(self, chart: &Chart, style: &'a str) -> Self {
        let width = if chart.compact { 560.0 } else { self.width };
        let plot_height = if chart.compact { 360.0 } else { self.plot_height };
        Self { legend: Some(style), width, plot_height, ..self }
    }
}

/// Where a panel's plot lies, and its scales.
struct Frame {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: Scale,
    y: Scale,
}

impl Frame {
    /// Horizontal place within the plot.
    fn across(&self, x: f64) -> f64 {
        self.x.fraction(x) * self.width
    }

    /// Vertical place within the plot, downwards.
    fn down(&self, y: f64) -> f64 {
        (1.0 - self.y.fraction(y)) * self.height
    }

    fn x_ticks(&self) -> Ticks {
        self.x.ticks(((self.width / 80.0) as usize).clamp(3, 10))
    }

    fn y_ticks(&self) -> Ticks {
        self.y.ticks(((self.height / 32.0) as usize).clamp(3, 7))
    }
}

/// The chart as an `svg` element; `id` makes the identifiers inside unique on the page.
pub(super) fn picture(chart: &Chart, layout: Layout, id: &str) -> String {
    let mut body = String::new();
    let top = match layout.legend {
        Some(_) => title_and_legend(&mut body, chart, layout.width),
        None => 0.0,
    };
    let frames = frames(chart, &layout, top);
    for (k, (panel, frame)) in chart.panels.iter().zip(&frames).enumerate() {
        heading(&mut body, &panel.y.heading(&frame.y), 0.0, frame.top - 10.0, "start");
        axes(&mut body, frame, k + 1 == frames.len());
        plot(&mut body, chart, panel, frame, layout.max_points);
        marks(&mut body, chart, panel, frame, k == 0);
    }
    let Some(frame) = frames.last() else {
        no_data(&mut body, layout.width / 2.0, top + 40.0);
        return envelope(chart, &layout, top + 60.0, id, &body);
    };
    let bottom = frame.top + frame.height + TICK_LABELS;
    let right = frame.left + frame.width;
    heading(&mut body, &chart.x.heading(&frame.x), right, bottom + 12.0, "end");
    envelope(chart, &layout, bottom + X_HEADING, id, &body)
}

/// Where the panels' plots lie: one below the other, with a common left edge.
fn frames(chart: &Chart, layout: &Layout, top: f64) -> Vec<Frame> {
    let mut heading_top = top;
    let mut frames: Vec<Frame> = chart
        .panels
        .iter()
        .map(|panel| {
            let (x, y) = (chart.x.scale, panel.y.scale);
            let height = (panel.weight * layout.plot_height).round();
            let top = heading_top + HEADING;
            heading_top = top + height + 6.0;
            Frame { left: 0.0, top, width: layout.width, height, x, y }
        })
        .collect();
    let labels = frames.iter().flat_map(|frame| frame.y_ticks().major);
    let left = labels
        .map(|tick| tick.label.chars().count() as f64 * CHARACTER + 14.0)
        .fold(34.0, f64::max)
        .min(120.0);
    for frame in &mut frames {
        frame.left = left;
        frame.width = layout.width - left - 16.0;
        if chart.equal_scale {
            equalise(frame);
        }
    }
    frames
}

fn no_data(body: &mut String, x: f64, y: f64) {
    body.push_str(&format!(
        "<text class=\"empty\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">no data</text>",
        px(x),
        px(y)
    ));
}

/// The `svg` element around the drawing; a picture of its own has a margin and its style inside.
fn envelope(chart: &Chart, layout: &Layout, height: f64, id: &str, body: &str) -> String {
    let margin = if layout.legend.is_some() { 14.0 } else { 0.0 };
    let (width, height) = (layout.width + 2.0 * margin, (height + 2.0 * margin).ceil());
    let style = layout.legend.map_or_else(String::new, |style| {
        format!(
            "<style>{style}</style><rect class=\"paper\" x=\"-{m}\" y=\"-{m}\" width=\"100%\" height=\"100%\"/>",
            m = px(margin)
        )
    });
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart-picture\" viewBox=\"{m} {m} {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\" aria-labelledby=\"{id}-title {id}-desc\"><title id=\"{id}-title\">{}</title><desc id=\"{id}-desc\">{}</desc>{style}{body}</svg>",
        escape(chart.title),
        escape(&chart.description),
        m = px(-margin),
        w = px(width),
        h = px(height),
    )
}

/// One length per unit on both axes: the axis with more pixels per unit shows more.
fn equalise(frame: &mut Frame) {
    let per_pixel = |scale: &Scale, pixels: f64| (scale.high - scale.low) / pixels;
    let (x, y) = (per_pixel(&frame.x, frame.width), per_pixel(&frame.y, frame.height));
    let grow = |scale: &mut Scale, range: f64| {
        let middle = scale.low / 2.0 + scale.high / 2.0;
        (scale.low, scale.high) = (middle - range / 2.0, middle + range / 2.0);
    };
    if !(x.is_finite() && y.is_finite()) {
        return;
    }
    if x < y {
        grow(&mut frame.x, y * frame.width);
    } else {
        grow(&mut frame.y, x * frame.height);
    }
}

fn heading(body: &mut String, text: &str, x: f64, y: f64, anchor: &str) {
    body.push_str(&format!(
        "<text class=\"axis\" x=\"{}\" y=\"{}\" text-anchor=\"{anchor}\">{}</text>",
        px(x),
        px(y),
        escape(text)
    ));
}

/// Title and legend, wrapped to the width; returns where they end.
fn title_and_legend(body: &mut String, chart: &Chart, width: f64) -> f64 {
    let title = escape(chart.title);
    body.push_str(&format!("<text class=\"title\" x=\"0\" y=\"14\">{title}</text>"));
    let (mut x, mut y) = (0.0, 36.0);
    for entry in &chart.entries {
        let needs = 40.0 + entry.name.chars().count() as f64 * CHARACTER;
        if x + needs > width && x > 0.0 {
            (x, y) = (0.0, y + 18.0);
        }
        body.push_str(&format!(
            "<path class=\"trace {}\" d=\"M{} {}h26\"/><text class=\"tick\" x=\"{}\" y=\"{}\">{}</text>",
            entry.style.classes(true),
            px(x),
            px(y - 4.0),
            px(x + 32.0),
            px(y),
            escape(&entry.name)
        ));
        x += needs + 14.0;
    }
    y + 8.0
}

/// Grid, axis lines, labels of the ticks.
fn axes(body: &mut String, frame: &Frame, with_x_labels: bool) {
    let (x, y) = (frame.x_ticks(), frame.y_ticks());
    let mut grid = (String::new(), String::new());
    let vertical = |at: f64| {
        format!("M{} {}v{}", px(frame.left + frame.across(at)), px(frame.top), px(frame.height))
    };
    let horizontal = |at: f64| {
        format!("M{} {}h{}", px(frame.left), px(frame.top + frame.down(at)), px(frame.width))
    };
    x.minor.iter().for_each(|at| grid.0.push_str(&vertical(*at)));
    y.minor.iter().for_each(|at| grid.0.push_str(&horizontal(*at)));
    x.major.iter().for_each(|tick| grid.1.push_str(&vertical(tick.value)));
    y.major.iter().for_each(|tick| grid.1.push_str(&horizontal(tick.value)));
    body.push_str(&format!(
        "<path class=\"grid minor\" d=\"{}\"/><path class=\"grid\" d=\"{}\"/>",
        grid.0, grid.1
    ));
    body.push_str(&format!(
        "<path class=\"frame\" d=\"M{l} {t}v{h}h{w}\"/>",
        l = px(frame.left),
        t = px(frame.top),
        h = px(frame.height),
        w = px(frame.width)
    ));
    for tick in &y.major {
        body.push_str(&format!(
            "<text class=\"tick\" x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            px(frame.left - 7.0),
            px(frame.top + frame.down(tick.value) + 4.0),
            tick.label
        ));
    }
    if with_x_labels {
        for tick in &x.major {
            body.push_str(&format!(
                "<text class=\"tick\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                px(frame.left + frame.across(tick.value)),
                px(frame.top + frame.height + 16.0),
                tick.label
            ));
        }
    }
}

/// Bands, bars and curves, clipped to the plot by an `svg` element of their own.
fn plot(body: &mut String, chart: &Chart, panel: &PanelView, frame: &Frame, max_points: usize) {
    body.push_str(&format!(
        "<svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" overflow=\"hidden\">",
        px(frame.left),
        px(frame.top),
        px(frame.width),
        px(frame.height)
    ));
    for band in chart.bands {
        let (from, to) = (frame.across(band.from), frame.across(band.to));
        if from.is_finite() && to.is_finite() {
            body.push_str(&format!(
                "<rect class=\"band\" x=\"{}\" y=\"0\" width=\"{}\" height=\"{}\"/>",
                px(from.min(to)),
                px((to - from).abs()),
                px(frame.height)
            ));
        }
    }
    for bars in &panel.bars {
        draw_bars(body, chart, bars, frame);
    }
    for trace in &panel.traces {
        draw_trace(body, chart, trace, frame, max_points);
    }
    body.push_str("</svg>");
    let finite = |trace: &TraceView| trace.y.iter().any(|y| y.is_finite());
    let counted = |bars: &BarsView| bars.counts.iter().any(|n| *n > 0);
    if !panel.traces.iter().any(finite) && !panel.bars.iter().any(counted) {
        no_data(body, frame.left + frame.width / 2.0, frame.top + frame.height / 2.0);
    }
}

fn draw_trace(
    body: &mut String,
    chart: &Chart,
    trace: &TraceView,
    frame: &Frame,
    max_points: usize,
) {
    let Some(entry) = chart.entries.get(trace.entry) else { return };
    let kept: Vec<usize> = match chart.kind {
        Kind::Shared => reduce::extremes(&trace.y, max_points),
        Kind::Curves => reduce::log_extremes(&trace.x, &[&trace.y], max_points),
        // Loops have been thinned once; what is left is their shape.
        Kind::Free | Kind::Bars => (0..trace.x.len().min(trace.y.len())).collect(),
    };
    let at = |values: &[f64], i: usize| values.get(i).copied().unwrap_or(f64::NAN);
    let points: Vec<(f64, f64)> = kept
        .iter()
        .map(|&i| (frame.across(at(&trace.x, i)), frame.down(at(&trace.y, i))))
        .collect();
    let dashed = length(&points) < DENSE * frame.width;
    let classes = entry.style.classes(dashed);
    body.push_str(&format!(
        "<path class=\"trace {classes}\" d=\"{}\"/>",
        path(points.iter().copied())
    ));
    if points.len() <= FEW_POINTS {
        for (x, y) in points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
            body.push_str(&format!(
                "<circle class=\"dot {classes}\" cx=\"{}\" cy=\"{}\" r=\"2.2\"/>",
                px(*x),
                px(*y)
            ));
        }
    }
}

/// Up to this many points of a curve are drawn as dots, too.
pub(super) const FEW_POINTS: usize = 60;

/// Length of a line in pixels, gaps left out.
fn length(points: &[(f64, f64)]) -> f64 {
    points
        .windows(2)
        .map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1))
        .filter(|length| length.is_finite())
        .sum()
}

fn draw_bars(body: &mut String, chart: &Chart, bars: &BarsView, frame: &Frame) {
    let Some(entry) = chart.entries.get(bars.entry) else { return };
    for (edges, &count) in bars.edges.windows(2).zip(bars.counts).filter(|(_, n)| **n > 0) {
        let (from, to) = (frame.across(edges[0]), frame.across(edges[1]));
        let top = frame.down(count as f64);
        let values = [format_number(edges[0], 4), format_number(edges[1], 4)].join(" to ");
        body.push_str(&format!(
            "<rect class=\"bar c{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"><title>{}: {values} {}: {}</title></rect>",
            entry.style.colour,
            px(from + 0.5),
            px(top),
            px((to - from - 1.0).max(0.5)),
            px(frame.height - top),
            escape(&entry.name),
            escape(&chart.x.unit),
            format_integer(count as i64)
        ));
    }
}

/// Limits, markers and the labels of all marks.
fn marks(body: &mut String, chart: &Chart, panel: &PanelView, frame: &Frame, with_labels: bool) {
    let mut labels = Labels::default();
    for limit in panel.limits {
        let y = frame.top + frame.down(limit.value);
        body.push_str(&format!(
            "<path class=\"limit\" d=\"M{} {}h{}\"/><text class=\"mark\" x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            px(frame.left),
            px(y),
            px(frame.width),
            px(frame.left + frame.width - 4.0),
            px(if y - frame.top < 14.0 { y + 13.0 } else { y - 4.0 }),
            escape(&limit.label)
        ));
    }
    for band in chart.bands.iter().filter(|_| with_labels) {
        let from = frame.across(band.from.max(frame.x.low)).clamp(0.0, frame.width);
        labels.put(body, frame, from, &band.label);
    }
    for marker in chart.markers {
        let across = frame.across(marker.at);
        if !(0.0..=frame.width).contains(&across) {
            continue;
        }
        body.push_str(&format!(
            "<path class=\"marker\" d=\"M{} {}v{}\"/>",
            px(frame.left + across),
            px(frame.top),
            px(frame.height)
        ));
        if with_labels {
            labels.put(body, frame, across, &marker.label);
        }
    }
}

/// Labels along the top of a plot, each in the first row where it has room.
#[derive(Default)]
struct Labels {
    placed: Vec<(f64, f64, usize)>,
}

impl Labels {
    fn put(&mut self, body: &mut String, frame: &Frame, across: f64, text: &str) {
        let width = text.chars().count() as f64 * CHARACTER + 6.0;
        let turned = across + width > frame.width && across > width;
        let from = if turned { across - width } else { across };
        let hits = |row: usize, placed: &[(f64, f64, usize)]| {
            placed.iter().any(|(a, b, r)| *r == row && from < *b && *a < from + width)
        };
        let row = (0..6).find(|row| !hits(*row, &self.placed)).unwrap_or(0);
        self.placed.push((from, from + width, row));
        body.push_str(&format!(
            "<text class=\"mark\" x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>",
            px(frame.left + across + if turned { -4.0 } else { 4.0 }),
            px(frame.top + 13.0 + 14.0 * row as f64),
            if turned { "end" } else { "start" },
            escape(text)
        ));
    }
}
