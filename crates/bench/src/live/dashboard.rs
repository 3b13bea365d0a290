//! What a live view shows.

use crate::cycle::Column;
use crate::record::Latest;
use crate::safety::{Reason, State};

/// Columns by their meaning.
#[derive(Clone, Debug)]
pub struct Dashboard {
    columns: Vec<Column>,
    axes: usize,
    plays_commands: bool,
}

/// One axis at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisView {
    /// Name of the position.
    pub name: String,
    /// Unit of the position.
    pub unit: String,
    /// Unit of the command.
    pub command_unit: String,
    /// What the axis view follows; not a number where the plan plays commands.
    pub reference: f64,
    /// Where it is.
    pub position: f64,
    /// What was sent.
    pub command: f64,
}

impl Dashboard {
    /// A view of rows with these columns, see [`columns`](crate::cycle::columns).
    #[must_use]
    pub fn new(columns: &[Column]) -> Self {
        let own = columns.iter().filter(|column| column.name.starts_with("bench.")).count();
        let axes = columns.len().saturating_sub(1 + own) / 3;
        let plays_commands = columns.iter().any(|column| column.name.starts_with("planned."));
        Dashboard { columns: columns.to_vec(), axes, plays_commands }
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The axes of a row.
    #[must_use]
    pub fn axes(&self, latest: &Latest) -> Vec<AxisView> {
        let value = |place: usize| latest.row.get(place).copied().unwrap_or(f64::NAN);
        let unit = |place: usize| {
            self.columns.get(place).and_then(|column| column.unit.clone()).unwrap_or_default()
        };
        (0..self.axes)
            .map(|axis| {
                let [reference, position, command] =
                    [0, 1, 2].map(|group| 1 + group * self.axes + axis);
                AxisView {
                    name: self.columns[position].name.clone(),
                    unit: unit(position),
                    command_unit: unit(command),
                    reference: if self.plays_commands { f64::NAN } else { value(reference) },
                    position: value(position),
                    command: value(command),
                }
            })
            .collect()
    }

    /// A value of the bench's own columns, as in `state`.
    #[must_use]
    pub fn own(&self, latest: &Latest, name: &str) -> f64 {
        let is = |column: &Column| column.name.strip_prefix("bench.") == Some(name);
        let place = self.columns.iter().position(is);
        place.and_then(|place| latest.row.get(place)).copied().unwrap_or(f64::NAN)
    }

    /// Greatest value of one of the bench's own columns in the newest rows.
    #[must_use]
    pub fn greatest(&self, latest: &Latest, name: &str) -> f64 {
        let is = |column: &Column| column.name.strip_prefix("bench.") == Some(name);
        let place = self.columns.iter().position(is);
        place.and_then(|place| latest.range.get(place)).map_or(f64::NAN, |range| range.1)
    }

    /// State and reason of a row; `None` before the first.
    #[must_use]
    pub fn state(&self, latest: &Latest) -> Option<(State, Reason)> {
        let state = State::of(self.own(latest, "state") as u8)?;
        let reason = Reason::of(self.own(latest, "reason") as u8)?;
        (!latest.row.is_empty()).then_some((state, reason))
    }
}
