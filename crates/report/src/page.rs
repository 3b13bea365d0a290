//! The page: one HTML file with everything inside.

use std::path::Path;

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Value as Jinja};
use serde::Serialize;
use sha2::{Digest as _, Sha256};

use crate::chart::{self, Detail};
use crate::context::{Block, Report};
use crate::diagram::{Diagram, Lane, Look, Stage};
use crate::error::ReportError;
use crate::figure::Figure;
use crate::number::{format_decimals, format_integer, format_number, format_unit};
use crate::provenance::Provenance;
use crate::table::Table;
use crate::value::{KeyFigure, Outcome, Target, Value};
use crate::write;

const TEMPLATE: &str = include_str!("../assets/page.html");
const STYLE: &str = include_str!("../assets/page.css");
const CHART_STYLE: &str = include_str!("../assets/chart.css");
const AXES_SCRIPT: &str = include_str!("../assets/axes.js");
const LIVE_SCRIPT: &str =
    concat!(include_str!("../assets/live_drawing.js"), include_str!("../assets/live.js"));
const UPLOT: &str = include_str!("../assets/uPlot.iife.min.js");
const UPLOT_LICENCE: &str = include_str!("../assets/uPlot.LICENSE");
const UPLOT_STYLE: &str = include_str!("../assets/uPlot.min.css");

/// Significant digits of a number on the page.
const DIGITS: usize = 4;

/// Most bytes of a page; figures of a larger one are drawn with fewer points.
const MOST_BYTES: usize = 950_000;

impl Report {
    /// The page: one self-contained HTML file, with all points where they have room.
    ///
    /// # Errors
    /// [`ReportError::Template`] or [`ReportError::Json`] if rendering fails.
    pub fn to_html(&self) -> Result<String, ReportError> {
        let mut page = String::new();
        for detail in Detail::LEVELS {
            page = render_at(self, detail)?;
            if page.len() <= MOST_BYTES {
                break;
            }
        }
        Ok(page)
    }

    /// Writes the page, complete or not at all.
    ///
    /// # Errors
    /// [`Report::to_html`] fails, or [`ReportError::Write`].
    pub fn write_html(&self, path: impl AsRef<Path>) -> Result<(), ReportError> {
        write::complete(path.as_ref(), &self.to_html()?)
    }
}

fn render_at(report: &Report, detail: Detail) -> Result<String, ReportError> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?;
    environment.set_syntax(syntax);
    environment.add_template("page.html", TEMPLATE)?;
    let mut numbers = Numbering { detail, figures: 0, tables: 0, diagrams: 0, sections: 0 };
    let sections: Vec<SectionView> =
        report.sections.iter().map(|section| section_view(section, &mut numbers)).collect();
    let interactive = numbers.figures > 0;
    let styles = [CHART_STYLE, STYLE, if interactive { UPLOT_STYLE } else { "" }].concat();
    let scripts = if interactive { scripts() } else { Vec::new() };
    let view = PageView {
        title: &report.title,
        command: &report.command,
        sentence: &report.verdict.sentence,
        warnings: &report.warnings,
        provenance: &report.provenance,
        policy: content_policy(&styles, &scripts),
        outcome: outcome_class(report.verdict.outcome),
        outcome_word: verdict_word(report.verdict.outcome),
        key_figures: report.key_figures.iter().map(key_figure_view).collect(),
        sections,
        command_line: report.provenance.shell_line(),
        style: Jinja::from_safe_string(styles),
        scripts: scripts.into_iter().map(Jinja::from_safe_string).collect(),
    };
    let page = environment.get_template("page.html")?.render(Serde(&view))?;
    Ok(page)
}

/// The chart library with its licence, and the interactive layer.
fn scripts() -> Vec<String> {
    vec![
        format!("/*\n{UPLOT_LICENCE}*/\n{UPLOT}"),
        format!("(function () {{\n\"use strict\";\n{AXES_SCRIPT}\n{LIVE_SCRIPT}}})();\n"),
    ]
}

/// A policy under which the page can load nothing and run nothing but its own scripts.
fn content_policy(style: &str, scripts: &[String]) -> String {
    let script = match scripts {
        [] => "'none'".to_owned(),
        scripts => scripts.iter().map(|s| source_hash(s)).collect::<Vec<_>>().join(" "),
    };
    format!(
        "default-src 'none'; script-src {script}; style-src {}; img-src data:; base-uri 'none'; form-action 'none'",
        source_hash(style)
    )
}

/// A hash source of the Content Security Policy, level 3: `'sha256-<base64>'`.
fn source_hash(source: &str) -> String {
    format!("'sha256-{}'", base64(&Sha256::digest(source)))
}

/// Base 64 with padding, RFC 4648 section 4.
fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let group =
            chunk.iter().enumerate().fold(0_u32, |g, (i, b)| g | u32::from(*b) << (16 - 8 * i));
        for i in 0..4 {
            let digit = (group >> (18 - 6 * i)) & 63;
            text.push(if i <= chunk.len() { ALPHABET[digit as usize] as char } else { '=' });
        }
    }
    text
}

struct Numbering {
    detail: Detail,
    figures: usize,
    tables: usize,
    diagrams: usize,
    sections: usize,
}

/// What the template prints.
#[derive(Serialize)]
struct PageView<'a> {
    title: &'a str,
    command: &'a str,
    sentence: &'a str,
    warnings: &'a [String],
    provenance: &'a Provenance,
    policy: String,
    outcome: &'static str,
    outcome_word: &'static str,
    key_figures: Vec<KeyFigureView>,
    sections: Vec<SectionView>,
    command_line: String,
    style: Jinja,
    scripts: Vec<Jinja>,
}

#[derive(Serialize)]
struct SectionView {
    id: String,
    heading: String,
    blocks: Vec<BlockView>,
}

#[derive(Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
enum BlockView {
    Paragraph { text: String },
    List { items: Vec<String> },
    Code { text: String },
    Figures { figures: Vec<Jinja> },
    Table { table: TableView },
    Diagram { diagram: DiagramView },
}

#[derive(Serialize)]
struct DiagramView {
    number: usize,
    title: String,
    lanes: Vec<LaneView>,
}

#[derive(Serialize)]
struct LaneView {
    label: String,
    stages: Vec<StageView>,
}

#[derive(Serialize)]
struct StageView {
    class: &'static str,
    name: String,
    detail: String,
}

#[derive(Serialize)]
struct TableView {
    number: usize,
    caption: String,
    columns: Vec<ColumnView>,
    rows: Vec<Vec<CellView>>,
}

#[derive(Serialize)]
struct ColumnView {
    heading: String,
    unit: String,
    numeric: bool,
}

#[derive(Serialize)]
struct CellView {
    text: String,
    numeric: bool,
}

#[derive(Serialize)]
struct KeyFigureView {
    label: String,
    value: String,
    text: bool,
    unit: String,
    target: String,
    outcome: &'static str,
    outcome_word: &'static str,
    note: Option<String>,
}

fn section_view(section: &crate::context::Section, numbers: &mut Numbering) -> SectionView {
    numbers.sections += 1;
    let mut blocks: Vec<BlockView> = Vec::new();
    let mut row_open = false;
    for block in &section.blocks {
        let Block::Figure(figure) = block else {
            row_open = false;
            blocks.push(block_view(block, numbers));
            continue;
        };
        numbers.figures += 1;
        let html =
            Jinja::from_safe_string(chart::figure_html(figure, numbers.figures, numbers.detail));
        match blocks.last_mut() {
            Some(BlockView::Figures { figures }) if row_open && is_compact(figure) => {
                figures.push(html);
            }
            _ => blocks.push(BlockView::Figures { figures: vec![html] }),
        }
        row_open = is_compact(figure);
    }
    SectionView {
        id: format!("section-{}", numbers.sections),
        heading: section.heading.clone(),
        blocks,
    }
}

/// Figures that stand side by side when they follow one another.
fn is_compact(figure: &Figure) -> bool {
    matches!(figure, Figure::XyLoop(_) | Figure::Histogram(_))
}

fn block_view(block: &Block, numbers: &mut Numbering) -> BlockView {
    match block {
        Block::Paragraph(text) => BlockView::Paragraph { text: text.clone() },
        Block::List(items) => BlockView::List { items: items.clone() },
        Block::Code(text) => BlockView::Code { text: text.clone() },
        Block::Figure(_) => BlockView::Figures { figures: Vec::new() },
        Block::Diagram(diagram) => {
            numbers.diagrams += 1;
            BlockView::Diagram { diagram: diagram_view(diagram, numbers.diagrams) }
        }
        Block::Table(table) => {
            numbers.tables += 1;
            BlockView::Table { table: table_view(table, numbers.tables) }
        }
    }
}

fn diagram_view(diagram: &Diagram, number: usize) -> DiagramView {
    let stage = |stage: &Stage| StageView {
        class: match stage.look {
            Look::Signal => "signal",
            Look::Box => "box",
            Look::Shared => "shared",
            Look::Off => "off",
        },
        name: stage.name.clone(),
        detail: stage.detail.clone(),
    };
    let lane = |lane: &Lane| LaneView {
        label: lane.label.clone(),
        stages: lane.stages.iter().map(stage).collect(),
    };
    let lanes = diagram.lanes.iter().map(lane).collect();
    DiagramView { number, title: diagram.title.clone(), lanes }
}

fn table_view(table: &Table, number: usize) -> TableView {
    let width = table.rows.iter().map(Vec::len).fold(table.columns.len(), usize::max);
    let numeric = |k: usize| {
        let mut cells = table.rows.iter().filter_map(|row| row.get(k));
        cells.any(|cell| cell.as_f64().is_some())
    };
    let columns = (0..width)
        .map(|k| ColumnView {
            heading: table.columns.get(k).map_or_else(String::new, |c| c.heading.clone()),
            unit: table.columns.get(k).map_or_else(String::new, |c| format_unit(&c.unit)),
            numeric: numeric(k),
        })
        .collect();
    let cell = |row: &[Value], k: usize| {
        let value = row.get(k).unwrap_or(&Value::Missing);
        let decimals = table.columns.get(k).and_then(|column| column.decimals);
        let text = match (value, decimals) {
            (Value::Number(x), Some(decimals)) => format_decimals(*x, decimals),
            _ => value_text(value),
        };
        CellView { text, numeric: numeric(k) }
    };
    let rows = table.rows.iter().map(|row| (0..width).map(|k| cell(row, k)).collect()).collect();
    TableView { number, caption: table.caption.clone(), columns, rows }
}

fn value_text(value: &Value) -> String {
    match value {
        Value::Integer(n) => format_integer(*n),
        Value::Number(x) => format_number(*x, DIGITS),
        Value::Text(text) => text.clone(),
        Value::Missing => "–".to_owned(),
    }
}

fn key_figure_view(figure: &KeyFigure) -> KeyFigureView {
    let number = |x: f64| format_number(x, DIGITS);
    let unit = format_unit(&figure.unit);
    let with_unit = |text: String| if unit.is_empty() { text } else { format!("{text} {unit}") };
    let target = match figure.target {
        Some(Target::AtMost { limit }) => with_unit(format!("at most {}", number(limit))),
        Some(Target::AtLeast { limit }) => with_unit(format!("at least {}", number(limit))),
        Some(Target::Within { low, high }) => {
            with_unit(format!("{} to {}", number(low), number(high)))
        }
        None => String::new(),
    };
    KeyFigureView {
        label: figure.label.clone(),
        value: value_text(&figure.value),
        text: matches!(figure.value, Value::Text(_)),
        unit,
        target,
        outcome: outcome_class(figure.outcome),
        outcome_word: outcome_word(figure.outcome),
        note: figure.note.clone(),
    }
}

fn outcome_class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "pass",
        Outcome::Fail => "fail",
        Outcome::Caution => "caution",
        Outcome::None => "none",
    }
}

fn verdict_word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "Pass",
        Outcome::Fail => "Fail",
        Outcome::Caution => "Caution",
        Outcome::None => "",
    }
}

fn outcome_word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "Met",
        Outcome::Fail => "Not met",
        Outcome::Caution => "Caution",
        Outcome::None => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_as_in_rfc_4648_section_10() {
        for (bytes, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
