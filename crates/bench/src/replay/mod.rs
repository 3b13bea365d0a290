//! The record is the replay: the controller steps through the recorded references and positions
//! again, and every number that it computes and that was sent is compared with the record, bit by bit.
//!
//! The states are taken as they were recorded: they follow from what the line did. What follows from
//! them and from the controller (blending, slewing, limits, the way to the safe value) is computed
//! anew. A row without a fresh sample repeats the position before it, as the controller saw it; a
//! deadline that was missed has no row, and the controller made no step there.

mod recipe;

pub use recipe::{Recipe, RecipeAxis};

use serde::Serialize;

use crate::cycle::{Driver, computed};
use crate::record::{ReadError, Recording};
use crate::safety::{Reason, Shaper, State};

/// What a replay found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Replayed {
    /// Rows of the record.
    pub rows: u64,
    /// Cycles from its first row to its last, those without a row included.
    pub cycles: u64,
    /// Numbers that were compared.
    pub compared: u64,
    /// Numbers that differ.
    pub differing: u64,
    /// The first of them.
    pub first_difference: Option<Difference>,
    /// What was missed, held or lost in the record.
    pub notes: Vec<String>,
}

/// A number that is not what was recorded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Row of the record, from 0.
    pub row: u64,
    /// Cycle since time 0.
    pub cycle: u64,
    /// The difference's time in s.
    pub time: f64,
    /// Column.
    pub signal: String,
    /// As it was recorded.
    pub recorded: f64,
    /// As it is now.
    pub replayed: f64,
    /// Bits of both, hexadecimal.
    pub bits: [String; 2],
    /// What the controller says, where it failed.
    pub failure: Option<String>,
}

/// The columns of a record that a replay reads.
struct Columns<'a> {
    time: &'a [f64],
    state: &'a [f64],
    reason: &'a [f64],
    missing: &'a [f64],
    skipped: &'a [f64],
    references: Vec<&'a [f64]>,
    positions: Vec<&'a [f64]>,
    commands: Vec<&'a [f64]>,
    /// What the controller computed; empty without one.
    computed: Vec<&'a [f64]>,
}

impl<'a> Columns<'a> {
    fn of(
        recording: &'a Recording,
        recipe: &Recipe,
        has_controller: bool,
    ) -> Result<Self, ReadError> {
        let all = |names: Vec<String>| -> Result<Vec<&'a [f64]>, ReadError> {
            names.iter().map(|name| recording.column(name)).collect()
        };
        let commands = recipe.names(|axis| &axis.command);
        let own = if has_controller { &commands[..] } else { &[] };
        Ok(Columns {
            time: recording.column("time")?,
            state: recording.column("bench.state")?,
            reason: recording.column("bench.reason")?,
            missing: recording.column("bench.missing")?,
            skipped: recording.column("bench.skipped")?,
            references: all(recipe.names(|axis| &axis.column))?,
            positions: all(recipe.names(|axis| &axis.position))?,
            computed: all(own.iter().map(|name| computed(name)).collect())?,
            commands: all(commands)?,
        })
    }

    fn cycle(&self, row: usize, period_ns: u64) -> u64 {
        (self.time[row] * 1e9 / period_ns as f64).round() as u64
    }

    fn state(&self, row: usize) -> Option<State> {
        State::ALL.into_iter().find(|state| f64::from(*state as u8) == self.state[row])
    }
}

/// Steps a new instance of the controller through a record. `driver` must be as the record's was:
/// fresh, with its start values.
///
/// # Errors
/// A column that the recipe names is not there, or a row has no state.
pub fn replay(
    recording: &Recording,
    recipe: &Recipe,
    driver: Driver,
) -> Result<Replayed, ReadError> {
    let has_controller = matches!(driver, Driver::Controller(_));
    let columns = Columns::of(recording, recipe, has_controller)?;
    let mut again = Again::new(recipe, driver);
    let mut comparison = Comparison::default();
    for row in 0..columns.time.len() {
        let state = columns
            .state(row)
            .ok_or_else(|| recording.broken(format!("row {row}: bench.state is no state")))?;
        comparison.row = row;
        again.row(&columns, row, state, &mut comparison);
    }
    let found = comparison.first.take().map(|(row, signal, recorded, replayed)| Difference {
        row: row as u64,
        cycle: columns.cycle(row, recipe.period_ns),
        time: columns.time[row],
        signal: again.name(signal, recipe),
        recorded,
        replayed,
        bits: [recorded, replayed].map(|value| format!("{:016x}", value.to_bits())),
        failure: again.driver.failure(),
    });
    let ends = columns.time.len().checked_sub(1);
    let cycle = |row| columns.cycle(row, recipe.period_ns);
    Ok(Replayed {
        rows: columns.time.len() as u64,
        cycles: ends.map_or(0, |last| 1 + cycle(last).saturating_sub(cycle(0))),
        compared: comparison.compared,
        differing: comparison.differing,
        first_difference: found,
        notes: notes(&columns, recipe.period_ns),
    })
}

/// Which number is compared.
#[derive(Clone, Copy, Debug)]
enum Signal {
    Computed(usize),
    Command(usize),
    State,
    Reason,
}

#[derive(Debug, Default)]
struct Comparison {
    row: usize,
    compared: u64,
    differing: u64,
    first: Option<(usize, Signal, f64, f64)>,
}

impl Comparison {
    fn compare(&mut self, signal: Signal, recorded: f64, replayed: f64) {
        self.compared += 1;
        if recorded.to_bits() != replayed.to_bits() {
            self.differing += 1;
            self.first.get_or_insert((self.row, signal, recorded, replayed));
        }
    }
}

/// Controller and shaper, as [`Cycle`](crate::cycle::Cycle) has them.
struct Again {
    driver: Driver,
    shaper: Shaper,
    before: State,
    failed: bool,
    references: Vec<f64>,
    positions: Vec<f64>,
    wanted: Vec<f64>,
}

impl Again {
    fn new(recipe: &Recipe, driver: Driver) -> Self {
        let limits = recipe.limits();
        let zeros = || vec![0.0; limits.len()];
        Again {
            driver,
            shaper: Shaper::new(&limits, recipe.blend, recipe.period_ns as f64 / 1e9),
            before: State::Idle,
            failed: false,
            references: zeros(),
            positions: zeros(),
            wanted: zeros(),
        }
    }

    fn row(&mut self, columns: &Columns<'_>, row: usize, state: State, to: &mut Comparison) {
        if self.before == State::Ready && state == State::Running {
            self.shaper.take_over();
        }
        for (mine, all) in
            [(&mut self.references, &columns.references), (&mut self.positions, &columns.positions)]
        {
            mine.iter_mut().zip(all).for_each(|(value, column)| *value = column[row]);
        }
        if !self.failed && state != State::Idle {
            self.step(columns, row, state, to);
        }
        for (axis, column) in columns.computed.iter().enumerate() {
            to.compare(Signal::Computed(axis), column[row], self.wanted[axis]);
        }
        let commands = self.shaper.shape(state, &self.wanted);
        for (axis, column) in columns.commands.iter().enumerate() {
            to.compare(Signal::Command(axis), column[row], commands[axis]);
        }
        self.before = state;
    }

    /// The controller's step; that it failed, or not, must stand in the record.
    fn step(&mut self, columns: &Columns<'_>, row: usize, state: State, to: &mut Comparison) {
        let done = self.driver.step(&self.references, &self.positions, &mut self.wanted);
        let finite = self.wanted.iter().all(|command| command.is_finite());
        let because =
            [Reason::ControllerFailed, Reason::CommandNotFinite].map(|r| f64::from(r as u8));
        if done && finite {
            let begins = state == State::Fault && self.before != State::Fault;
            if begins && because.contains(&columns.reason[row]) {
                to.compare(Signal::Reason, columns.reason[row], 0.0);
            }
            return;
        }
        self.failed = !done;
        to.compare(Signal::State, columns.state[row], f64::from(State::Fault as u8));
        if self.before != State::Fault {
            let reason = because[usize::from(done)];
            to.compare(Signal::Reason, columns.reason[row], reason);
        }
        self.wanted.copy_from_slice(self.shaper.commands());
    }

    fn name(&self, signal: Signal, recipe: &Recipe) -> String {
        match signal {
            Signal::Computed(axis) => computed(&recipe.axes[axis].command),
            Signal::Command(axis) => recipe.axes[axis].command.clone(),
            Signal::State => "bench.state".to_owned(),
            Signal::Reason => "bench.reason".to_owned(),
        }
    }
}

/// What the rows say about what was missed, held and lost.
fn notes(columns: &Columns<'_>, period_ns: u64) -> Vec<String> {
    let rows = 0..columns.time.len();
    let drives = |row: usize| columns.state(row).is_some_and(State::drives);
    let held =
        rows.clone().filter(|row| drives(*row) && columns.missing[*row] > 0.0).count() as u64;
    let (mut skipped, mut lost, mut idle, mut first_lost) = (0, 0, 0, None);
    for row in rows.skip(1) {
        let ahead = columns.cycle(row, period_ns).saturating_sub(columns.cycle(row - 1, period_ns));
        let missed = columns.skipped[row] as u64;
        skipped += missed;
        let gap = ahead.saturating_sub(1 + missed);
        // A machine that went silent before the start leads back to idle, which has no rows.
        if gap > 0 && columns.state(row) == Some(State::Ready) {
            idle += gap;
        } else if gap > 0 {
            lost += gap;
            first_lost.get_or_insert(row);
        }
    }
    let mut notes = Vec::new();
    let mut note = |count: u64, what: &str| {
        if count > 0 {
            notes.push(format!("{count} {what}"));
        }
    };
    note(skipped, "deadlines were missed: they have no row, the controller made no step there");
    note(held, "rows have an older position (bench.missing): the controller stepped with it again");
    note(idle, "cycles have no row: the machine was silent before the start (idle)");
    if let Some(row) = first_lost {
        let what = format!(
            "rows are missing in the record, from row {row} on: the controller made steps there \
             that cannot be replayed, and what comes after them may differ"
        );
        note(lost, &what);
    }
    notes
}
