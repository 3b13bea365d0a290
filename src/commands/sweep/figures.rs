//! What is kept of a run's signals.

use std::io;

use cosim::record::Column as Recorded;
use sweep::{Cell, Column, ColumnKind, Plan, Take};

/// A figure of a signal, with its column found.
#[derive(Clone, Debug)]
pub(super) struct Figure {
    name: String,
    unit: Option<String>,
    column: usize,
    minus: Option<usize>,
    take: Take,
}

/// The figures of the plan, in the columns that are recorded.
pub(super) fn of_plan(plan: &Plan, recorded: &[Recorded]) -> anyhow::Result<Vec<Figure>> {
    let mut problems = Vec::new();
    let mut figures = Vec::new();
    for (name, line, measure) in &plan.measure {
        let mut find = |column: &str| {
            let found = recorded.iter().position(|there| there.name == column);
            if found.is_none() {
                let there: Vec<&str> = recorded.iter().map(|there| there.name.as_str()).collect();
                let rule = format!("there is no column \"{column}\"");
                let way_out = format!("recorded are {}", there.join(", "));
                problems.push(plan.problem(*line, &format!("measure.{name}"), &rule, &way_out));
            }
            found
        };
        let (column, minus) = (find(&measure.column), measure.minus.as_deref().map(find));
        if let (Some(column), None | Some(Some(_))) = (column, minus) {
            figures.push(figure(name.clone(), recorded, column, minus.flatten(), measure.take));
        }
    }
    if problems.is_empty() { Ok(figures) } else { Err(data::Problems::new(problems).into()) }
}

/// The figures of a closed loop: for each axis root mean square and peak of the error, least and
/// greatest command. `axes` are names of position, reference and command.
pub(super) fn of_loop(
    axes: &[(String, String, Option<String>)],
    recorded: &[Recorded],
) -> Vec<Figure> {
    let place = |name: &str| recorded.iter().position(|there| there.name == name);
    let mut figures = Vec::new();
    for (axis, (position, reference, command)) in (1..).zip(axes) {
        if let (Some(y), Some(r)) = (place(position), place(reference)) {
            for (name, take) in [("rms_error", Take::Rms), ("max_error", Take::Peak)] {
                figures.push(figure(format!("{name}[{axis}]"), recorded, y, Some(r), take));
            }
        }
        if let Some(u) = command.as_deref().and_then(place) {
            for (name, take) in [("min_command", Take::Min), ("max_command", Take::Max)] {
                figures.push(figure(format!("{name}[{axis}]"), recorded, u, None, take));
            }
        }
    }
    figures
}

fn figure(
    name: String,
    recorded: &[Recorded],
    column: usize,
    minus: Option<usize>,
    take: Take,
) -> Figure {
    let unit = recorded.get(column).and_then(|there| there.unit.clone());
    Figure { name, unit, column, minus, take }
}

/// The columns of figures.
pub(super) fn columns(figures: &[Figure]) -> Vec<Column> {
    let column =
        |figure: &Figure| Column::new(&figure.name, ColumnKind::Real, figure.unit.as_deref());
    figures.iter().map(column).collect()
}

/// Takes the figures while a run goes on; memory does not grow.
pub(super) struct Meter<'f> {
    figures: &'f [Figure],
    from: f64,
    sums: Vec<Sums>,
}

#[derive(Clone, Copy)]
struct Sums {
    count: f64,
    sum: f64,
    squares: f64,
    min: f64,
    max: f64,
    last: f64,
}

const NOTHING: Sums = Sums {
    count: 0.0,
    sum: 0.0,
    squares: 0.0,
    min: f64::INFINITY,
    max: f64::NEG_INFINITY,
    last: f64::NAN,
};

impl<'f> Meter<'f> {
    /// Rows before `from`, in s, do not count.
    pub(super) fn new(figures: &'f [Figure], from: f64) -> Self {
        Meter { figures, from, sums: vec![NOTHING; figures.len()] }
    }

    /// The figures; missing where no row counted.
    pub(super) fn cells(&self) -> Vec<Cell> {
        let cell = |(figure, sums): (&Figure, &Sums)| match figure.take {
            _ if sums.count == 0.0 => Cell::Missing,
            Take::Rms => Cell::Real((sums.squares / sums.count).sqrt()),
            Take::Mean => Cell::Real(sums.sum / sums.count),
            Take::Min => Cell::Real(sums.min),
            Take::Max => Cell::Real(sums.max),
            Take::Peak => Cell::Real(sums.max.abs().max(sums.min.abs())),
            Take::Last => Cell::Real(sums.last),
        };
        self.figures.iter().zip(&self.sums).map(cell).collect()
    }
}

impl cosim::Recorder for Meter<'_> {
    fn begin(&mut self, _: usize, _: &[Recorded], _: usize) -> io::Result<()> {
        self.sums.fill(NOTHING);
        Ok(())
    }

    #[inline]
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        // A row on the border counts, whatever its last bit.
        if time < self.from - 1e-12 {
            return Ok(());
        }
        for (figure, sums) in self.figures.iter().zip(&mut self.sums) {
            let off = figure.minus.map_or(0.0, |minus| values[minus]);
            let value = values[figure.column] - off;
            sums.count += 1.0;
            sums.sum += value;
            sums.squares += value * value;
            sums.min = sums.min.min(value);
            sums.max = sums.max.max(value);
            sums.last = value;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosim::Recorder;

    #[test]
    fn figures_of_a_signal() {
        let recorded =
            ["y", "r"].map(|name| Recorded { name: name.into(), unit: Some("um".into()) });
        let all = [Take::Rms, Take::Mean, Take::Min, Take::Max, Take::Peak, Take::Last];
        let figures: Vec<Figure> =
            all.iter().map(|take| figure("f".into(), &recorded, 0, Some(1), *take)).collect();
        let mut meter = Meter::new(&figures, 1.0);
        meter.begin(0, &recorded, 3).unwrap();
        for (time, y, r) in [(0.0, 9.0, 0.0), (1.0, -3.0, 1.0), (2.0, 2.0, 1.0), (3.0, 0.0, -1.0)] {
            meter.row(time, &[y, r]).unwrap();
        }
        let expected = [6.0_f64.sqrt(), -2.0 / 3.0, -4.0, 1.0, 4.0, 1.0];
        assert_eq!(meter.cells(), expected.map(Cell::Real));
        assert_eq!(Meter::new(&figures, 0.0).cells(), vec![Cell::Missing; 6]);
    }
}
