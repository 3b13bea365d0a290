//! Charts: one view of a figure, drawn as SVG and handed to the interactive layer.

mod data_table;
mod detail;
mod draw;
mod packed;
mod payload;
mod scale;
mod svg;
mod view;
mod views;

use crate::figure::Figure;
pub(crate) use detail::Detail;
use svg::escape;

/// Colours and strokes, shared by the page and by pictures of their own.
const STYLE: &str = include_str!("../../assets/chart.css");

/// A figure as it stands in the page: title, legend, the picture in two widths, notes, data.
pub(crate) fn figure_html(figure: &Figure, number: usize, detail: Detail) -> String {
    let mut chart = views::of(figure);
    detail.thin(&mut chart);
    let chart = chart;
    let id = format!("figure-{number}");
    let mut html = format!(
        "<figure class=\"chart{}\" id=\"{id}\">\n<figcaption><span class=\"numbered\">Figure {number}</span> {}</figcaption>\n",
        if chart.compact { " compact" } else { "" },
        escape(figure.title())
    );
    html.push_str(&legend(&chart));
    html.push_str("<div class=\"plot\">\n<div class=\"picture wide\">");
    html.push_str(&draw::picture(
        &chart,
        draw::Layout::wide(&chart, detail),
        &format!("{id}-wide"),
    ));
    html.push_str("</div>\n<div class=\"picture narrow\">");
    html.push_str(&draw::picture(
        &chart,
        draw::Layout::narrow(&chart, detail),
        &format!("{id}-narrow"),
    ));
    html.push_str("</div>\n</div>\n");
    if let Some(caption) = figure.caption() {
        html.push_str(&format!("<p class=\"caption\">{}</p>\n", escape(caption)));
    }
    for note in figure.notes() {
        html.push_str(&format!("<p class=\"note\">{}</p>\n", escape(note)));
    }
    html.push_str(&data_table::details(figure, &chart, detail, number));
    html.push_str("</figure>\n");
    if let Some(json) = payload::json(&chart) {
        html.push_str(&format!(
            "<script type=\"application/json\" data-chart=\"{id}\">{json}</script>\n"
        ));
    }
    html
}

impl Figure {
    /// The figure as a picture of its own: an SVG file with legend, light and dark.
    pub fn to_svg(&self) -> String {
        let chart = views::of(self);
        let layout = draw::Layout::wide(&chart, Detail::LEVELS[0]).with_legend(&chart, STYLE);
        draw::picture(&chart, layout, "figure")
    }
}

/// The legend; the interactive layer turns its items into switches with a read-out.
fn legend(chart: &view::Chart) -> String {
    let mut html = String::from("<ul class=\"legend\">\n");
    for (k, entry) in chart.entries.iter().enumerate() {
        html.push_str(&format!(
            "<li data-entry=\"{k}\"><svg class=\"swatch\" width=\"28\" height=\"10\" aria-hidden=\"true\"><path class=\"trace {}\" d=\"M1 5h26\"/></svg><span class=\"name\">{}</span></li>\n",
            entry.style.classes(true),
            escape(&entry.name)
        ));
    }
    html.push_str("</ul>\n");
    html
}
