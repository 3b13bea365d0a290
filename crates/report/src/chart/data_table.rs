//! The numbers beside each chart.

use super::detail::Detail;
use super::svg::escape;
use super::view::Chart;
use crate::figure::{Bode, Figure, Histogram, Spectrum, TimeSeries, XyLoop};
use crate::number::{format_integer, format_number, format_unit};
use crate::summary::Summary;

/// A table to be opened beside a chart: one row per curve.
pub(super) fn details(figure: &Figure, chart: &Chart, detail: Detail, number: usize) -> String {
    let (headings, rows) = match figure {
        Figure::TimeSeries(figure) => time_series(figure),
        Figure::XyLoop(figure) => xy_loop(figure),
        Figure::Spectrum(figure) => spectrum(figure),
        Figure::Bode(figure) => bode(figure),
        Figure::Histogram(figure) => histogram(figure),
    };
    let mut html = format!(
        "<details class=\"data\"><summary>Data of figure {number}</summary>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Data of figure {number}\"><table><thead><tr>"
    );
    for (k, heading) in headings.iter().enumerate() {
        let class = if k < 1 { "" } else { " class=\"numeric\"" };
        html.push_str(&format!("<th scope=\"col\"{class}>{heading}</th>"));
    }
    html.push_str("</tr></thead><tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        for (k, cell) in row.iter().enumerate() {
            html.push_str(&match k {
                0 => format!("<th scope=\"row\">{}</th>", escape(cell)),
                _ => format!("<td class=\"numeric\">{}</td>", escape(cell)),
            });
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table></div>\n");
    html.push_str(&format!(
        "<p class=\"drawn\">{}</p></details>\n",
        escape(&drawn(figure, chart, detail))
    ));
    html
}

type Rows = (Vec<&'static str>, Vec<Vec<String>>);

/// What was left out of the drawing.
fn drawn(figure: &Figure, chart: &Chart, detail: Detail) -> String {
    let most = detail.curve();
    match figure {
        Figure::TimeSeries(_) => match chart.stretch() {
            1 => "All samples are drawn.".to_owned(),
            n => format!(
                "Drawn are the smallest and the largest of every {} samples; the statistics are of all samples.",
                format_integer(n as i64)
            ),
        },
        Figure::XyLoop(_) => {
            format!(
                "Loops of more than {most} points are drawn with the {most} that keep their shape; the statistics are of all points."
            )
        }
        Figure::Spectrum(_) | Figure::Bode(_) => {
            format!(
                "Curves of more than {most} lines are drawn with the extremes of equal stretches of the logarithmic axis."
            )
        }
        Figure::Histogram(figure) => {
            format!("{} bins of equal width.", figure.edges.len().saturating_sub(1))
        }
    }
}

fn number(x: Option<f64>) -> String {
    x.map_or_else(|| "–".to_owned(), |x| format_number(x, 5))
}

fn count(n: usize) -> String {
    format_integer(i64::try_from(n).unwrap_or(i64::MAX))
}

/// Statistics in the order of [`STATISTICS`].
fn statistics(unit: &str, summary: &Summary) -> Vec<String> {
    let Summary { samples, not_finite, min, max, mean, rms, std } = *summary;
    let mut cells = vec![format_unit(unit), count(samples), count(not_finite)];
    cells.extend([min, max, mean, std, rms, summary.range()].map(number));
    cells
}

const STATISTICS: [&str; 9] = [
    "Unit",
    "Samples",
    "Not finite",
    "Minimum",
    "Maximum",
    "Mean",
    "Std. dev.",
    "RMS",
    "Peak to peak",
];

fn with_statistics(first: &'static str) -> Vec<&'static str> {
    [first].into_iter().chain(STATISTICS).collect()
}

fn row(name: &str, cells: Vec<String>) -> Vec<String> {
    [name.to_owned()].into_iter().chain(cells).collect()
}

fn time_series(figure: &TimeSeries) -> Rows {
    let rows = figure.panels.iter().flat_map(|panel| {
        let unit = panel.unit.as_deref().unwrap_or_default();
        let several = figure.panels.len() > 1 && !panel.label.is_empty();
        panel.traces.iter().map(move |trace| {
            let name = match several && panel.label != trace.name {
                true => format!("{}, {}", trace.name, panel.label),
                false => trace.name.clone(),
            };
            row(&name, statistics(unit, &trace.summary))
        })
    });
    (with_statistics("Signal"), rows.collect())
}

fn xy_loop(figure: &XyLoop) -> Rows {
    let rows = figure.loops.iter().flat_map(|line| {
        let axes = [(&figure.x, &line.x_summary), (&figure.y, &line.y_summary)];
        axes.map(|(axis, summary)| {
            row(&format!("{}, {}", line.name, axis.label), statistics(&axis.unit, summary))
        })
    });
    (with_statistics("Loop, axis"), rows.collect())
}

fn spectrum(figure: &Spectrum) -> Rows {
    let rows = figure.traces.iter().map(|trace| {
        let ends = [trace.frequency.first().copied(), trace.frequency.last().copied()];
        let mut cells = vec![format_unit(&figure.y.unit), count(trace.lines)];
        cells.extend(ends.map(number));
        cells.extend([trace.peak.map(|peak| peak.1), trace.peak.map(|peak| peak.0)].map(number));
        row(&trace.name, cells)
    });
    let headings =
        vec!["Curve", "Unit", "Lines", "From [Hz]", "To [Hz]", "Largest value", "at [Hz]"];
    (headings, rows.collect())
}

fn bode(figure: &Bode) -> Rows {
    let rows = figure.responses.iter().map(|response| {
        let ends = [response.frequency.first().copied(), response.frequency.last().copied()];
        let mut cells = vec![format_unit(&figure.unit), count(response.lines)];
        cells.extend(ends.map(number));
        for found in [response.peak, response.least_coherence] {
            cells.extend([found.map(|(_, y)| y), found.map(|(f, _)| f)].map(number));
        }
        row(&response.name, cells)
    });
    let headings = vec![
        "Response",
        "Unit",
        "Lines",
        "From [Hz]",
        "To [Hz]",
        "Largest magnitude",
        "at [Hz]",
        "Least coherence",
        "at [Hz]",
    ];
    (headings, rows.collect())
}

fn histogram(figure: &Histogram) -> Rows {
    let rows =
        figure.sets.iter().map(|set| row(&set.name, statistics(&figure.x.unit, &set.summary)));
    (with_statistics("Set"), rows.collect())
}
