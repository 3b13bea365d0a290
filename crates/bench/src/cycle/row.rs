//! The columns of a row.

/// A column of a record.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Unit; `None` for one that is not known.
    pub unit: Option<String>,
    /// One sentence.
    pub description: String,
}

/// Columns beside time and those of the axes: name, unit, sentence.
const SCALARS: [(&str, &str, &str); 13] = [
    ("bench.state", "1", "0 idle, 1 ready, 2 running, 3 hold, 4 safe, 5 fault"),
    ("bench.reason", "1", "Why, see the table of reasons"),
    ("bench.missing", "1", "Cycles since the position was received; 0: in this cycle"),
    ("bench.row", "1", "Row of the plan that is played; -1 before and after"),
    ("bench.wake", "us", "How long after its deadline the cycle began"),
    ("bench.work", "us", "How long the cycle before it worked"),
    ("bench.round_trip", "us", "From the command to its answer; 0 without a sample"),
    ("bench.skipped", "1", "Deadlines before this cycle that were missed"),
    ("bench.lost", "1", "Samples lost so far"),
    ("bench.late", "1", "Samples too late so far"),
    ("bench.duplicate", "1", "Duplicate samples so far"),
    ("bench.reordered", "1", "Samples out of order so far"),
    ("bench.corrupt", "1", "Damaged packets so far"),
];

/// Before the name of a command: what the controller computed, before limits and blending.
const COMPUTED: &str = "bench.computed.";

/// The column of what the controller computed for this command.
#[must_use]
pub fn computed(command: &str) -> String {
    format!("{COMPUTED}{command}")
}

/// Number of values of a row.
pub(crate) const fn length(axes: usize, has_controller: bool) -> usize {
    1 + (if has_controller { 4 } else { 3 }) * axes + SCALARS.len()
}

/// Columns of a row: time, references, positions, commands, then the bench's own; with a controller
/// also what it computed. The three lists are name and unit of each axis.
#[must_use]
pub fn columns(
    references: &[(String, Option<String>)],
    positions: &[(String, Option<String>)],
    commands: &[(String, Option<String>)],
    has_controller: bool,
) -> Vec<Column> {
    let column = |name: &str, unit: Option<String>, description: &str| Column {
        name: name.to_owned(),
        unit,
        description: description.to_owned(),
    };
    let of = |all: &[(String, Option<String>)], sentence: &str| -> Vec<Column> {
        all.iter().map(|(name, unit)| column(name, unit.clone(), sentence)).collect()
    };
    let mut all = vec![column("time", Some("s".to_owned()), "Deadline of the cycle")];
    all.extend(of(references, "What the controller follows"));
    all.extend(of(positions, "Newest good sample"));
    all.extend(of(commands, "What was sent"));
    all.extend(SCALARS.iter().map(|(name, unit, sentence)| {
        column(name, Some((*unit).to_owned()).filter(|unit| unit != "1"), sentence)
    }));
    if has_controller {
        let names = commands.iter().map(|(name, unit)| (computed(name), unit.clone()));
        let sentence = "What the controller computed, before limits and blending";
        all.extend(of(&names.collect::<Vec<_>>(), sentence));
    }
    all
}
