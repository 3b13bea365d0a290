//! The page of a reproduction: the figures beside the paper's, what they rest on, and what was seen.

use data::Blueprint;
use report::{KeyFigure, Outcome, Provenance, Report, Section, Table, Value, Verdict as Word};

use crate::reproduce::{Aim, Reproduction, Row, Verdict, stand_ins};

/// The page of some reproductions.
///
/// # Errors
/// Where the blueprint of a rig cannot be read.
pub fn reproduction(all: &[Reproduction], provenance: Provenance) -> anyhow::Result<Report> {
    let rows = || all.iter().flat_map(|one| &one.rows);
    let orders = || all.iter().flat_map(|one| &one.orders);
    let count = |verdict: Verdict| rows().filter(|row| row.verdict == verdict).count();
    let (reached, missed) = (count(Verdict::Reached), count(Verdict::NotReached));
    let held = orders().filter(|order| order.holds).count();
    let judged = reached + missed;
    let sentence = match (judged, orders().count()) {
        (0, 0) => "No figure is judged.".to_owned(),
        (_, orders) => format!(
            "{reached} of {judged} figures that the papers report are reached or beaten on our machines, and {held} of {orders} rankings of methods hold."
        ),
    };
    let verdict = match (missed, held == orders().count(), judged) {
        (_, _, 0) => Word::neutral(sentence),
        (0, true, _) => Word::pass(sentence),
        _ => Word::caution(sentence),
    };
    let mut page = Report::new("reproduce", "The papers' tables on our machines", verdict)
        .provenance(provenance);
    for one in all {
        page = page.key_figure(key_figure(one));
    }
    for one in all {
        page = page.section(figures(one));
        for chapter in &one.chapters {
            let heading = format!("{}: {}", one.paper.to_uppercase(), chapter.heading);
            let mut section = Section::new(heading).paragraph(chapter.text.as_str());
            for figure in &chapter.figures {
                section = section.figure(figure.clone());
            }
            page = page.section(section);
        }
        page = page.section(assumptions(one)?);
    }
    Ok(page)
}

fn key_figure(one: &Reproduction) -> KeyFigure {
    let of = |verdict| one.rows.iter().filter(|row| row.verdict == verdict).count();
    let (reached, missed) = (of(Verdict::Reached), of(Verdict::NotReached));
    let label = format!("{}, {}", one.paper.to_uppercase(), one.part);
    let held = one.orders.iter().filter(|order| order.holds).count();
    let figure = KeyFigure::new(label, format!("{reached} of {}", reached + missed), "reached");
    let outcome = match (missed, reached) {
        (0, 0) => Outcome::None,
        (0, _) => Outcome::Pass,
        _ => Outcome::Caution,
    };
    figure.outcome(outcome).note(format!("{held} of {} rankings hold", one.orders.len()))
}

fn figures(one: &Reproduction) -> Section {
    let paper = one.paper.to_uppercase();
    let ratio = |row: &Row, at: usize| finite(ratio(row).map(|ratio| ratio[at]));
    let columns: [Shown<'_>; 9] = [
        ("figure", &|row| in_unit(&row.what, row.unit).into()),
        ("paper", &|row| row.paper.into()),
        ("its method here", &|row| row.own.into()),
        ("ours", &|row| finite(row.ours)),
        ("another way", &|row| finite(row.other)),
        ("ratio to the baseline, paper", &|row| ratio(row, 0)),
        ("ratio to the baseline, here", &|row| ratio(row, 1)),
        ("verdict", &|row| row.verdict.words().unwrap_or_default().into()),
        ("decisive assumptions", &|row| stand_ins::rests_on(row.paper_id, &row.what).into()),
    ];
    let table = filled(format!("Figures of {paper}, {}", one.part), &columns, &one.rows);
    let mut orders = Table::new(format!("Rankings of methods, {paper}"), ["ranking", "holds"]);
    for order in &one.orders {
        orders = orders.row([Value::from(order.what.as_str()), order.holds.into()]);
    }
    let remarks: Vec<&String> =
        one.remarks.iter().filter(|remark| !remark.starts_with("match")).collect();
    let mut section = Section::new(format!("{paper}: {}", one.part)).paragraph(
        "All but the paper's figures are measured on a machine that could be the paper's. A row is judged by its own figure, or by \
         its ratio to the method that the paper compares with, which may be a quarter more than in the paper; the last column \
         names the assumed parts that decide a figure most.",
    );
    if !one.left_out.is_empty() {
        let left_out = one.left_out.join("; ");
        section = section.paragraph(format!("A quick reproduction, which leaves out: {left_out}."));
    }
    section = section.table(table);
    if !one.orders.is_empty() {
        section = section.table(orders);
    }
    if !remarks.is_empty() {
        section = section.list(remarks);
    }
    if one.matched.is_empty() { section } else { section.table(matched(one)) }
}

/// A column: its head, and what it has of a row.
type Shown<'a> = (&'a str, &'a dyn Fn(&Row) -> Value);

/// The table of these rows, without the columns that are empty in all of them.
fn filled(caption: String, columns: &[Shown<'_>], rows: &[Row]) -> Table {
    let is_empty = |value: Value| match value {
        Value::Text(text) => text.is_empty(),
        value => value == Value::Missing,
    };
    let used: Vec<_> =
        columns.iter().filter(|(_, of)| !rows.iter().all(|row| is_empty(of(row)))).collect();
    let table = Table::new(caption, used.iter().map(|(head, _)| *head));
    rows.iter().fold(table, |table, row| table.row(used.iter().map(|(_, of)| of(row))))
}

fn finite(value: Option<f64>) -> Value {
    value.map_or_else(|| Value::from(""), Value::from)
}

fn ratio(row: &Row) -> Option<[f64; 2]> {
    match row.aim {
        Aim::Ratio { paper, own } => Some([paper, own]),
        _ => None,
    }
}

/// `greatest error [µm]`.
fn in_unit(what: &str, unit: &str) -> String {
    match report::format_unit(unit).as_str() {
        "" => what.to_owned(),
        unit => format!("{what} [{unit}]"),
    }
}

/// How near the machine is to the paper's, without the paper's method.
fn matched(one: &Reproduction) -> Table {
    let caption = format!("The rig {} beside the paper's machine, without its method", one.rig);
    let columns = ["figure", "paper", "ours", "within 25 %"];
    one.matched.iter().fold(Table::new(caption, columns), |table, figure| {
        table.row([
            Value::from(in_unit(&figure.what, figure.unit)),
            figure.paper.into(),
            figure.ours.into(),
            figure.within.into(),
        ])
    })
}

fn assumptions(one: &Reproduction) -> anyhow::Result<Section> {
    let paper = one.paper.to_uppercase();
    let columns = ["axis", "part", "values", "what is known"];
    let mut table = Table::new(format!("Assumed parts of the rig {}", one.rig), columns);
    if let Some(rig) = rigs::find(one.rig) {
        for part in stand_ins::of(&Blueprint::parse(rig.blueprint, rig.name)?) {
            table = table.row([
                part.axes.join(", "),
                part.component.clone(),
                part.values.clone(),
                part.note.clone(),
            ]);
        }
    }
    Ok(Section::new(format!("{paper}: assumed parts, {}", one.part))
        .paragraph(
            "The paper does not describe these parts of its machine. They were assumed; values are in the units of the blueprint.",
        )
        .table(table))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_no_row_fills_are_left_out() {
        let row = |ours, verdict| Row {
            paper_id: "P1",
            what: "error".into(),
            unit: "um",
            paper: 0.1,
            own: f64::NAN,
            ours,
            other: None,
            aim: Aim::Reach,
            verdict,
        };
        let columns: [Shown<'_>; 5] = [
            ("figure", &|row| in_unit(&row.what, row.unit).into()),
            ("own", &|row| row.own.into()),
            ("ours", &|row| finite(row.ours)),
            ("other", &|row| finite(row.other)),
            ("verdict", &|row| row.verdict.words().unwrap_or_default().into()),
        ];
        let rows = [row(None, Verdict::NotJudged), row(Some(0.2), Verdict::NotReached)];
        let heads = |rows: &[Row]| -> Vec<String> {
            let table = filled("a table".into(), &columns, rows);
            table.columns.iter().map(|column| column.heading.clone()).collect()
        };
        assert_eq!(heads(&rows), ["figure", "ours", "verdict"]);
        assert_eq!(heads(&rows[..1]), ["figure"]);
    }
}
