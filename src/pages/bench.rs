//! The pages of `bench run` and `bench campaign`: what the machine did, and what the clock did.

use std::path::Path;

use bench::campaign::Trial;
use bench::record::JournalReader;
use bench::runner::{Outcome, Percentiles};
use report::{
    Axis, Column, Histogram, KeyFigure, Outcome as Mark, Provenance, Report, Role, Section, Table,
    TimeSeries, Value, Verdict, XyLoop,
};

use super::{differences, greatest, rms};

/// The rows of a run as they were recorded.
pub(crate) struct Rows {
    pub(crate) columns: Vec<bench::cycle::Column>,
    /// Column by column.
    pub(crate) values: Vec<Vec<f64>>,
    /// Rows before them.
    left_out: usize,
}

impl Rows {
    /// The newest rows of a journal, at most so many.
    pub(crate) fn newest(journal: &Path, most: usize) -> anyhow::Result<Self> {
        let mut reader = JournalReader::open(journal)?;
        let columns = reader.about().columns.clone();
        let mut values = vec![Vec::new(); columns.len()];
        let mut all = 0;
        while let Some(block) = reader.block()? {
            for row in block.chunks_exact(columns.len().max(1)) {
                all += 1;
                values.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
            }
            let count = values.first().map_or(0, Vec::len);
            // Now and then, so that what goes is moved seldom.
            if count > 2 * most {
                values.iter_mut().for_each(|column| drop(column.drain(..count - most)));
            }
        }
        let left_out = all - values.first().map_or(0, Vec::len).min(most);
        values.iter_mut().for_each(|column| {
            let first = column.len().saturating_sub(most);
            column.drain(..first);
        });
        Ok(Self { columns, values, left_out })
    }

    fn find(&self, name: &str) -> Option<(&[f64], &str)> {
        let at = self.columns.iter().position(|column| column.name == name)?;
        let unit = self.columns[at].unit.as_deref().unwrap_or("");
        Some((self.values.get(at)?, unit))
    }

    fn time(&self) -> &[f64] {
        self.values.first().map_or(&[], Vec::as_slice)
    }

    /// The columns of the axes: reference, position and command of each, where there are names.
    fn axes(&self) -> Vec<[usize; 3]> {
        let own = self.columns.iter().skip(1).take_while(|c| !c.name.starts_with("bench."));
        let count = own.count() / 3;
        (0..count).map(|axis| [1 + axis, 1 + count + axis, 1 + 2 * count + axis]).collect()
    }

    fn column(&self, at: usize) -> (&str, &[f64], &str) {
        let column = &self.columns[at];
        (&column.name, &self.values[at], column.unit.as_deref().unwrap_or(""))
    }
}

/// The page of a run; `rows` are those that were recorded.
pub(crate) fn run(outcome: &Outcome, rows: &Rows, provenance: Provenance) -> Report {
    let sentence = format!(
        "The run ended in the state {}: {}; {} cycles, {} overruns, {} deadlines missed, {} samples lost.",
        outcome.state,
        outcome.reason,
        outcome.cycles,
        outcome.overruns,
        outcome.skipped,
        outcome.measurements.lost
    );
    let late = outcome.overruns + outcome.skipped + outcome.measurements.lost > 0;
    let verdict = match (outcome.is_good(), late) {
        (false, _) => Verdict::fail(sentence),
        (true, true) => Verdict::caution(sentence),
        (true, false) => Verdict::pass(sentence),
    };
    let mut page = Report::new("bench", "Real-time run", verdict).provenance(provenance);
    if let Some(failure) = &outcome.failure {
        page = page.warning(format!("The controller failed: {failure}"));
    }
    if let Some(refused) = &outcome.refused {
        page = page.warning(format!("Packets were refused: {refused}"));
    }
    if outcome.unrecorded > 0 {
        page = page.warning(format!(
            "Missing in the record: {}.",
            data::counted(outcome.unrecorded as usize, "row")
        ));
    }
    if rows.left_out > 0 {
        page = page.warning(format!(
            "The figures omit what comes first, {}; counts and percentiles include all rows.",
            data::counted(rows.left_out, "row")
        ));
    }
    for [reference, position, _] in rows.axes() {
        let ((_, wanted, unit), (name, got, own)) = (rows.column(reference), rows.column(position));
        // Without a controller the plan's sequence is the commands.
        if unit != own {
            continue;
        }
        let errors = differences(wanted, got);
        let label = format!("{name}: rms error");
        let note = format!(
            "largest {} {}",
            report::format_number(greatest(&errors), 4),
            report::format_unit(unit)
        );
        page = page.key_figure(KeyFigure::new(label, rms(&errors), unit).note(note));
    }
    let share = |p: &Percentiles| format!("99 %: {:.0} µs, largest {:.0} µs", p.p99_us, p.max_us);
    page = page
        .key_figure(
            KeyFigure::new("Wake-up after the deadline, median", outcome.wake.p50_us, "us")
                .note(share(&outcome.wake)),
        )
        .key_figure(
            KeyFigure::new("Work of a cycle, median", outcome.work.p50_us, "us")
                .note(share(&outcome.work)),
        )
        .key_figure(
            KeyFigure::new("Round trip, median", outcome.round_trip.p50_us, "us")
                .note(share(&outcome.round_trip)),
        );
    page.section(machine(rows)).section(clock(outcome, rows)).section(events(rows))
}

/// Paths, loops, signals.
fn machine(rows: &Rows) -> Section {
    let mut section = Section::new("The machine");
    let axes = rows.axes();
    if let [first, second, ..] = axes[..] {
        let at = |axis: [usize; 3], k: usize| rows.column(axis[k]);
        let ((_, x, unit), (_, y, other)) = (at(first, 1), at(second, 1));
        if unit == other {
            let axis = |name: &str| Axis::new(name, unit);
            let figure = XyLoop::new("Path of the first two axes", axis("axis 1"), axis("axis 2"))
                .line(Role::Reference, "reference", at(first, 0).1, at(second, 0).1)
                .measured("position", x, y)
                .equal_scale();
            section = section.figure(figure);
        }
    }
    for axis in &axes {
        let (name, y, unit) = rows.column(axis[1]);
        let (command, u, volt) = rows.column(axis[2]);
        let figure = XyLoop::new(
            format!("{name} over {command}"),
            Axis::new(command, volt),
            Axis::new(name, unit),
        );
        section = section.figure(figure.measured("recorded", u, y));
    }
    for axis in &axes {
        let [(_, r, of), (name, y, unit), (command, u, volt)] = axis.map(|at| rows.column(at));
        let title = format!("{name}: reference, position, command");
        let mut figure = TimeSeries::new(title, rows.time()).panel("position");
        if of == unit {
            figure = figure
                .reference("reference", unit, r)
                .measured("position", unit, y)
                .panel("error")
                .residual("reference − position", unit, &differences(r, y));
        } else {
            figure = figure.measured("position", unit, y);
        }
        figure = figure.panel("command");
        if of != unit {
            figure = figure.reference("played", of, r);
        }
        section = section.figure(figure.model(command, volt, u));
    }
    section
}

/// Wake-up, work and round trip, over time and counted.
fn clock(outcome: &Outcome, rows: &Rows) -> Section {
    let names =
        [("bench.wake", "wake-up"), ("bench.work", "work"), ("bench.round_trip", "round trip")];
    let mut section = Section::new("The clock");
    let mut over_time = TimeSeries::new("Times of the cycles", rows.time());
    for (column, name) in names {
        let Some((values, _)) = rows.find(column) else { continue };
        over_time = over_time.other(name, "us", values);
        let finite: Vec<f64> = values.iter().copied().filter(|x| *x > 0.0).collect();
        let sets = [(Role::Other, name, &finite[..])];
        let axis = Axis::new(name, "us");
        section = section.figure(Histogram::new(format!("How often: {name}"), axis, &sets));
    }
    let columns = ["what", "count", "50 %", "99 %", "99.9 %", "99.99 %", "greatest"];
    let columns = columns.iter().enumerate().map(|(k, heading)| {
        let column = Column::new(*heading);
        if k > 1 { column.unit("us").decimals(1) } else { column }
    });
    let mut table = Table::new("Times of the cycles", columns);
    for (name, p) in [
        ("wake-up", outcome.wake),
        ("work", outcome.work),
        ("processor time of it", outcome.processor),
        ("round trip", outcome.round_trip),
    ] {
        table = table.row([
            Value::from(name),
            p.count.into(),
            p.p50_us.into(),
            p.p99_us.into(),
            p.p999_us.into(),
            p.p9999_us.into(),
            p.max_us.into(),
        ]);
    }
    let m = &outcome.measurements;
    let mut counts = Table::new("Samples and commands", ["what", "count"]);
    for (what, count) in [
        ("samples used", m.used),
        ("samples lost", m.lost),
        ("samples late", m.late),
        ("samples duplicate", m.duplicate),
        ("samples out of order", m.reordered),
        ("packets corrupt", m.corrupt),
        ("packets mismatched", m.mismatched),
        ("samples not finite", m.not_finite),
        ("samples invalid", m.invalid),
        ("commands limited", outcome.clipped),
        ("commands not sent", outcome.unsent),
        ("overruns", outcome.overruns),
        ("deadlines missed", outcome.skipped),
    ] {
        counts = counts.row([Value::from(what), count.into()]);
    }
    section.figure(over_time).table(table).table(counts)
}

/// When the state changed.
fn events(rows: &Rows) -> Section {
    const STATES: [&str; 6] = ["idle", "ready", "running", "hold", "safe", "fault"];
    let mut table =
        Table::new("Changes of the state", [Column::new("time").unit("s"), "state".into()]);
    if let Some((states, _)) = rows.find("bench.state") {
        let mut last = f64::NAN;
        for (time, state) in rows.time().iter().zip(states) {
            if *state != last {
                let name = STATES.get(*state as usize).copied().unwrap_or("unknown");
                table = table.row([Value::from(*time), name.into()]);
            }
            last = *state;
        }
    }
    Section::new("Events").table(table)
}

/// The page of a campaign of faults.
pub(crate) fn campaign(trials: &[Trial], provenance: Provenance) -> Report {
    let failed = trials.iter().filter(|trial| !trial.problems.is_empty()).count();
    let sentence = match failed {
        0 => format!("All {} trials ended as expected.", trials.len()),
        _ => format!("{failed} of {} trials did not end as expected.", trials.len()),
    };
    let verdict = if failed == 0 { Verdict::pass(sentence) } else { Verdict::fail(sentence) };
    let columns = [
        Column::new("case"),
        Column::new("at").unit("cycles"),
        Column::new("state"),
        Column::new("reason"),
        Column::new("after").unit("cycles"),
        Column::new("problems"),
    ];
    let mut table = Table::new("Trials", columns);
    for trial in trials {
        table = table.row([
            Value::from(trial.case.as_str()),
            trial.at.into(),
            trial.state.into(),
            trial.reason.as_str().into(),
            trial.took.into(),
            trial.problems.join("; ").into(),
        ]);
    }
    let mark = if failed == 0 { Mark::Pass } else { Mark::Fail };
    Report::new("bench campaign", "Fault campaign in virtual time", verdict)
        .key_figure(KeyFigure::new("Trials", trials.len(), ""))
        .key_figure(KeyFigure::new("Ended otherwise", failed, "").outcome(mark))
        .section(Section::new("Trials").table(table))
        .provenance(provenance)
}
