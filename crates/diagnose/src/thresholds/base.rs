//! How the logs are read, and the model that effects are added to.

/// Thresholds of the stage *base*.
pub(crate) struct Thresholds;

impl Thresholds {
    /// Part of each record, at its end, that is held out where no log is given to be held out.
    pub(crate) const HELD_OUT: f64 = 0.3;
    /// Most inner steps of all logs together, over the number that is allowed between two rows.
    pub(crate) const MOST_STEPS: f64 = 200.0;
    /// Most rows that enter the normal equations; of more, an even selection is fitted (all are simulated).
    pub(crate) const MOST_FIT_ROWS: usize = 8_000;
    /// Largest deviation of times from a uniform grid, in sample times.
    pub(crate) const UNIFORM_TIMES: f64 = 1e-3;
    /// Error power that another reading of the logs must leave, over what the usual reading leaves.
    pub(crate) const READING_LESS: f64 = 0.7;
    /// Frequency, times the sample time, from which a mode may be a command that moves between the rows.
    pub(crate) const MODE_NEAR_NYQUIST: f64 = 0.45;
    /// Error power that another reading must leave, over what the usual one leaves, to be tried where a released lag was
    /// found.
    pub(crate) const READING_TRIED_FOR_LAG: f64 = 0.95;
    /// Error power that the re-tuned model may leave under another reading, over that under the usual one, where one effect is
    /// tried with it in place of several.
    pub(crate) const READING_TRIED_FOR_ONE: f64 = 1.2;
    /// Error power that another reading may leave with fewer effects, over that with them.
    pub(crate) const READING_FOR_EFFECT: f64 = 1.1;
    /// Steps from row to row of a model that has one, where a command moves that acts on a curved part.
    pub(crate) const FINER_STEPS: usize = 2;
    /// Error power that it must leave, over what the model's own step leaves.
    pub(crate) const FINER_LESS: f64 = 0.95;
    /// Steps from row to row in which readings within the rows of a held command are simulated.
    pub(crate) const WITHIN_ROW: usize = 4;
    /// Rows of an FMU's log in which it is seen first whether readings are within the rows.
    pub(crate) const WITHIN_SEEN: usize = 4000;
    /// Where readings within the rows are looked for, in rows later.
    pub(crate) const WITHIN_LATER: (f64, f64) = (-1.5, 1.0);
    /// Parts of a row by which a held command looks like one that moves to the next row.
    pub(crate) const LATE_AS_MOVING: (f64, f64) = (0.35, 0.65);
    /// Least motion of the reading while the command stands, over its range and over the noise, for another rest
    /// state.
    pub(crate) const START_MOVES: (f64, f64) = (0.05, 10.0);
    /// Largest distance of the reading from where it comes to rest, over the motion: it swings, and goes nowhere else.
    pub(crate) const START_SWINGS: f64 = 1.5;
    /// Least rows for which the command stands at the start.
    pub(crate) const START_ROWS: usize = 4;
    /// Where the command of the rest state is looked for, in half ranges of the command about its centre.
    pub(crate) const REST_FAR: f64 = 3.0;
    /// Bisections in the search for the command of the rest state.
    pub(crate) const REST_HALVINGS: usize = 50;
    /// Blocks of a record by which its start is compared with the rest.
    pub(crate) const RUN_IN_BLOCKS: usize = 200;
    /// Least rows of a block by which the start of a record is compared with the rest.
    pub(crate) const RUN_IN_ROWS: usize = 8;
    /// Part of a record that a run-in may take.
    pub(crate) const RUN_IN_LONGEST: f64 = 0.1;
    /// Mean square of a record's first block over the largest one behind the longest run-in, above which the log
    /// begins during a motion.
    pub(crate) const RUN_IN_STANDS_OUT: f64 = 9.0;
    /// Least error in one of the first two rows, over the effective value of the first block, for a log that begins
    /// during a motion.
    pub(crate) const RUN_IN_AT_ONCE: f64 = 0.2;
    /// Part of the later blocks in which less is left than in the last block of the run-in.
    pub(crate) const RUN_IN_USUAL: f64 = 0.9;
    /// Least correlation of a monitor with the command.
    pub(crate) const MONITOR_LIKE: f64 = 0.9;
    /// How far the slope of a monitor against the command may be from 1: a monitor in another scale is none.
    pub(crate) const MONITOR_SCALE: f64 = 0.25;
    /// Sets of commands for which the sum over the other axes of a coupling is kept.
    pub(crate) const COMMANDS_KEPT: usize = 4;
    /// Values of a coupling's parameters for which that sum is kept, with each set of commands.
    pub(crate) const SUMS_KEPT: usize = 6;
    /// Parameters of one array that are free one by one; a longer array is free in groups.
    pub(crate) const MOST_OF_ARRAY: usize = 12;
    /// Standard deviation of a parameter without a tolerance, relative to its value, as a scale.
    pub(crate) const FREE_DEVIATION: f64 = 0.1;
    /// Bounds of a parameter with a prior, in its standard deviations.
    pub(crate) const PRIOR_BOX: f64 = 3.0;
    /// Part of its value that a released parameter can lose.
    pub(crate) const RELEASED_DOWN: f64 = 0.95;
    /// Largest value that a released parameter can reach, over its own.
    pub(crate) const RELEASED_UP: f64 = 10.0;
    /// Damping ratio that a released one can reach whatever its value: a mode that creeps, three times over critical.
    /// The model's may be that of a bare resonance, the machine's that of a damped one.
    pub(crate) const RELEASED_DAMPING: f64 = 3.0;
    /// Largest condition number of couplings that are inverted.
    pub(crate) const CONDITION: f64 = 1000.0;
    /// Relative deviation from a straight line that is rounding.
    pub(crate) const AFFINE_ROUNDING: f64 = 1e-9;
    /// Steps over which a component is tried for being linear.
    pub(crate) const LINEAR_STEPS: usize = 400;
    /// Crashes and hangs of an FMU after which the search is given up: each costs a process, a hang all of the time
    /// that is allowed.
    pub(crate) const MOST_LOST: usize = 8;
    /// Most rows of an FMU's answer to a small step of its input.
    pub(crate) const ENTRY_ROWS: usize = 4000;
    /// Rows of that answer before the step.
    pub(crate) const ENTRY_BEFORE: usize = 50;
    /// Size of that small step, over half the range of the command.
    pub(crate) const ENTRY_SIZE: f64 = 0.1;
    /// Part of a step by which the input of an FMU's mode may differ from a step, or from a lag's answer to it.
    pub(crate) const ENTRY_ROUGH: f64 = 0.05;
    /// Part of a signal's effective value that may be something else than the decay of modes.
    pub(crate) const MODE_OTHER: f64 = 1e-3;
    /// Most values of an FMU that are kept, of commands and answers together.
    pub(crate) const KEPT_VALUES: usize = 8_000_000;
    /// Levels over the range of the command at which an FMU's plays are looked for.
    pub(crate) const PLAY_LEVELS: usize = 48;
    /// Rows that a level is held for, where nothing but the mode moves.
    pub(crate) const PLAY_HELD: usize = 8;
    /// What is left of a lag's answer at the end of a level.
    pub(crate) const PLAY_SETTLED: f64 = 1e-6;
    /// Part of the slope below which the weight of a play is rounding.
    pub(crate) const PLAY_NOTHING: f64 = 1e-4;
    /// Part of the slope that all plays together must have.
    pub(crate) const PLAY_SOME: f64 = 2e-3;
    /// Rows of a record under which the plays must do what the FMU does.
    pub(crate) const PLAY_CHECKED: usize = 20_000;
    /// Part of what the plays do by which the FMU may differ.
    pub(crate) const PLAY_OFF: f64 = 0.05;
    /// Part of a parameter's relative change by which it must move the mode of an FMU, to be the mode's own.
    pub(crate) const MOVES_MODE: f64 = 0.1;
    /// Least records from which it is seen that a course is not caused.
    pub(crate) const COURSE_RECORDS: usize = 4;
    /// Blocks of a record whose means show a course.
    pub(crate) const COURSE_BLOCKS: usize = 96;
    /// Time constants of low-passes of the command, over the length of the record.
    pub(crate) const COURSE_LOW_PASSES: [f64; 3] = [0.01, 0.06, 0.4];
    /// Thresholds of plays of the command, over half its range.
    pub(crate) const COURSE_PLAYS: [f64; 3] = [0.1, 0.35, 0.8];
    /// Part of a course's power that its own command explains beyond those of other records, above which it is caused.
    pub(crate) const COURSE_CAUSED: f64 = 0.12;
    /// Part of a course's power that the sum of the other records' courses explains, above which it returns.
    pub(crate) const COURSE_REPEATS: f64 = 0.5;
    /// Knots of such a course in a record; pieces half as long as their distance are compared with the rows around.
    pub(crate) const OWN_KNOTS: usize = 32;
    /// Ridge of the regression, over the largest power of a function.
    pub(crate) const COURSE_RIDGE: f64 = 1e-4;
    /// Half range of the simulated output, over the noise, above which the command moves the machine.
    pub(crate) const MOVES: f64 = 3.0;
    /// Least rows of a record behind its run-in: fewer are too few to judge anything.
    pub(crate) const RECORD_ROWS: usize = 60;
    /// Correlation with the command from which a column is no auxiliary signal of its own.
    pub(crate) const AUXILIARY_ALIKE: f64 = 0.95;
}
