//! The page of a sweep: how its figures are distributed, and what they go with.

use std::path::Path;

use report::{Axis, Histogram, Report, Role, Section, Table as Rows, Verdict};
use sweep::{Cell, Column, ColumnKind, Table};

use super::results::Swept;
use crate::pages;

/// Curves of one histogram beyond which a grid is not told apart.
const MOST_SETS: usize = 4;
/// Most figures that are drawn.
const MOST_FIGURES: usize = 12;

/// The page of a table; the first `varied` columns are what varied.
pub(super) fn page(
    table: &Table,
    answer: &Swept,
    files: &[(&str, &Path)],
) -> anyhow::Result<Report> {
    let varied = table.about.varied;
    let columns = &table.about.columns;
    let results: Vec<usize> =
        (varied..columns.len()).filter(|&at| columns[at].kind == ColumnKind::Real).collect();
    let sentence = answer.sentence(results.first().map(|&at| columns[at].name.as_str()));
    let verdict = match answer.failed {
        0 => Verdict::neutral(sentence),
        _ => Verdict::caution(sentence),
    };
    let mut page = Report::new("sweep", "Many runs", verdict).provenance(pages::provenance(files)?);
    let mut distributions = Section::new("Distributions");
    for &at in results.iter().take(MOST_FIGURES) {
        if let Some(figure) = histogram(table, at) {
            distributions = distributions.figure(figure);
        }
    }
    page = page.section(distributions).section(answer.section());
    if let Some(section) = influence(table, &results) {
        page = page.section(section);
    }
    Ok(page.section(Section::new("Plan").code(table.about.plan.clone())))
}

/// The values of a column in the rows for which this holds, where they are numbers.
fn values(table: &Table, at: usize, holds: impl Fn(&[Cell]) -> bool) -> Vec<f64> {
    let rows = table.rows.iter().filter(|row| holds(&row.cells));
    rows.filter_map(|row| row.cells.get(at)?.number()).filter(|x| x.is_finite()).collect()
}

/// One histogram of all runs, or one curve for each value of the first column with few values.
fn histogram(table: &Table, at: usize) -> Option<Histogram> {
    let column = table.about.columns.get(at)?;
    let few = (0..table.about.varied).find_map(|varied| Some((varied, few_values(table, varied)?)));
    let sets: Vec<(String, Vec<f64>)> = match &few {
        None => vec![("all runs".to_owned(), values(table, at, |_| true))],
        Some((varied, cells)) => cells
            .iter()
            .map(|cell| {
                let name = format!("{} = {cell}", table.about.columns[*varied].name);
                (name, values(table, at, |cells| cells.get(*varied) == Some(cell)))
            })
            .collect(),
    };
    if sets.iter().all(|(_, values)| values.len() < 2) {
        return None;
    }
    let role = if sets.len() == 1 { Role::Model } else { Role::Other };
    let sets: Vec<(Role, &str, &[f64])> =
        sets.iter().map(|(name, values)| (role, name.as_str(), values.as_slice())).collect();
    let axis = Axis::new(&column.name, column.unit.clone().unwrap_or_default());
    Some(Histogram::new(column.name.clone(), axis, &sets))
}

/// The different values of a column, if it has two to [`MOST_SETS`] of them.
fn few_values(table: &Table, at: usize) -> Option<Vec<Cell>> {
    let mut found: Vec<Cell> = Vec::new();
    for cell in table.rows.iter().filter_map(|row| row.cells.get(at)) {
        if !found.contains(cell) {
            found.push(cell.clone());
        }
        if found.len() > MOST_SETS {
            return None;
        }
    }
    (found.len() > 1).then_some(found)
}

/// Rank correlations (Spearman) of what varied with what came out.
fn influence(table: &Table, results: &[usize]) -> Option<Section> {
    let numbers = |column: &Column| matches!(column.kind, ColumnKind::Real | ColumnKind::Integer);
    let causes: Vec<usize> =
        (0..table.about.varied).filter(|&at| numbers(&table.about.columns[at])).collect();
    let results = &results[..results.len().min(6)];
    if causes.is_empty() || results.is_empty() || table.rows.len() < 10 {
        return None;
    }
    let name = |at: usize| table.about.columns[at].name.clone();
    let mut headings = vec![report::Column::new("varied")];
    headings.extend(results.iter().map(|&at| report::Column::new(name(at)).decimals(2)));
    let mut rows =
        Rows::new("Rank correlation (Spearman) of each varied value with each figure", headings);
    for &cause in &causes {
        let mut row: Vec<report::Value> = vec![name(cause).into()];
        for &result in results {
            let pairs = table.rows.iter().filter_map(|row| {
                let pair = (row.cells.get(cause)?.number()?, row.cells.get(result)?.number()?);
                (pair.0.is_finite() && pair.1.is_finite()).then_some(pair)
            });
            let (x, y): (Vec<f64>, Vec<f64>) = pairs.unzip();
            row.push(spearman(&x, &y).map_or("-".into(), Into::into));
        }
        rows = rows.row(row);
    }
    let bound = 1.96 / (table.rows.len() as f64).sqrt();
    Some(
        Section::new("Correlations")
            .paragraph(format!(
                "Near 1 or −1: the figure grows or falls with the varied value. Chance alone stays below \
                 {bound:.2} in 95 of 100 cases."
            ))
            .table(rows),
    )
}

/// Spearman's rank correlation; none where one of both does not vary.
fn spearman(x: &[f64], y: &[f64]) -> Option<f64> {
    let (a, b) = (ranks(x), ranks(y));
    let middle = (a.len() as f64 - 1.0) / 2.0;
    let product = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).map(|(p, q)| (p - middle) * (q - middle)).sum()
    };
    let spread = (product(&a, &a) * product(&b, &b)).sqrt();
    (spread > 0.0).then(|| product(&a, &b) / spread)
}

/// Ranks from 0; equal values share the mean of theirs.
fn ranks(x: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..x.len()).collect();
    order.sort_by(|&a, &b| x[a].total_cmp(&x[b]));
    let mut ranks = vec![0.0; x.len()];
    let mut at = 0;
    while at < order.len() {
        let same = order[at..].iter().take_while(|&&i| x[i] == x[order[at]]).count();
        let mean = at as f64 + (same as f64 - 1.0) / 2.0;
        order[at..at + same].iter().for_each(|&i| ranks[i] = mean);
        at += same;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_and_their_correlation() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 0.0]), [2.5, 1.0, 2.5, 0.0]);
        let x = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(spearman(&x, &x.map(f64::exp)), Some(1.0));
        assert_eq!(spearman(&x, &x.map(|v| -v * v * v)), Some(-1.0));
        assert_eq!(spearman(&x, &[5.0; 4]), None);
        // By hand: 1 − 6 Σd²/(n(n² − 1)) with d = 0, 1, −1, 0.
        let close = spearman(&x, &[1.0, 3.0, 2.0, 4.0]).unwrap();
        assert!((close - 0.8).abs() < 1e-12);
    }
}
