//! What the answer states beside the names.

/// Thresholds of the stage *answer*.
pub(crate) struct Thresholds;

impl Thresholds {
    /// Part of a frequency within which those of several outputs are the same.
    pub(crate) const SAME_FREQUENCY: f64 = 0.01;
    /// Part of a damping, or of another parameter of the model, within which those of several outputs are the same.
    pub(crate) const SAME_DAMPING: f64 = 0.2;
    /// Standard deviations of the difference within which two estimates are the same at any rate.
    pub(crate) const SAME_DEVIATIONS: f64 = 4.0;
    /// Least records for a second opinion.
    pub(crate) const SECOND_RECORDS: usize = 3;
    /// Most fits of a second opinion; with more records several are left out at once.
    pub(crate) const SECOND_FITS: usize = 6;
    /// Fraction of the second opinion, over that of the first one, from which they agree.
    pub(crate) const SECOND_AGREES: f64 = 0.5;
    /// Mean square, over the noise's, above which something is left.
    pub(crate) const LEFT: f64 = 1.15;
    /// Probability that white, even and normally distributed residuals are noise of the reading.
    pub(crate) const SURE_OF_NOISE: f64 = 0.97;
    /// Probability that values on a coarse grid are a converter's.
    pub(crate) const SURE_OF_STEPS: f64 = 0.97;
    /// Part of the remaining error that a further effect must take away to be stated.
    pub(crate) const LOOKS_LIKE: f64 = 0.3;
    /// Error with a common offset, over that with an offset of each record, above which the answer states the
    /// difference.
    pub(crate) const OWN_OFFSETS: f64 = 1.5;
    /// Correlation times of the remaining error that are tried, even on a logarithmic scale.
    pub(crate) const DISCREPANCY_TIMES: usize = 16;
    /// Sizes of the remaining error that are tried, even on a logarithmic scale.
    pub(crate) const DISCREPANCY_SIZES: usize = 40;
    /// Least size of the remaining error over the noise.
    pub(crate) const DISCREPANCY_LEAST: f64 = 1e-2;
    /// Lines of a Hann window per independent line.
    pub(crate) const HANN_LINES: f64 = 1.5;
    /// Fall of −2 ln L that two further numbers must bring.
    pub(crate) const DISCREPANCY_BRINGS: f64 = 6.0;
    /// Most rows of the next experiment.
    pub(crate) const EXPERIMENT_ROWS: usize = 20_000;
    /// Lines of a multisine.
    pub(crate) const EXPERIMENT_LINES: usize = 40;
    /// Error that a rival is to leave in the next experiment, over that of the best name. Twice would do (odds of one
    /// to 64); the prediction is linear.
    pub(crate) const EXPERIMENT_APART: f64 = 4.0;
    /// How many times as steep as the logs a signal may be: more only where less does not tell the rivals apart.
    pub(crate) const EXPERIMENT_STEEPER: [f64; 3] = [1.0, 3.0, 10.0];
    /// Part of the wanted misfit below which all signals are alike.
    pub(crate) const EXPERIMENT_FAINTEST: f64 = 1e-3;
    /// Misfit in noise variances below which two names are not separated.
    pub(crate) const EXPERIMENT_LEAST: f64 = 9.0;
    /// Frequency bands that are listed.
    pub(crate) const BANDS_LISTED: usize = 5;
    /// Part of the gap's power that differs between periods of the command: of an answer to it at most, and of what is
    /// none at least.
    pub(crate) const DIFFERS: (f64, f64) = (0.3, 0.8);
    /// Levels of the command at which rising and falling branches are compared.
    pub(crate) const BRANCH_LEVELS: usize = 12;
    /// Part of the gap that a repaired blueprint may leave, beyond what the effects' own formulas leave, without a
    /// word.
    pub(crate) const REPAIR_LOSS: f64 = 0.02;
    /// Draws of the bootstrap.
    pub(crate) const BOOTSTRAP_DRAWS: usize = 400;
    /// Least weight of the answer beside its rivals, where machines are drawn.
    pub(crate) const NAMED_LEAST: f64 = 0.05;
    /// Spread of the logarithm of the error left over the error before, from one set of records to another.
    pub(crate) const RATIO_SPREAD: f64 = 0.35;
    /// Rows of a stretch on which single waves can be seen.
    pub(crate) const STRETCH_SHOWN: usize = 600;
    /// Gap, in powers of the noise, below which no part of it is stated.
    pub(crate) const GAP_LEAST: f64 = 0.1;
    /// Student's 97.5 % over the normal one, about, for one record, two, three, four, and more.
    pub(crate) const STUDENT: [f64; 5] = [3.0, 2.2, 1.5, 1.5, 1.2];
    /// What the noise spreads of a new record's mean square, and its variance may be off, in powers of the noise.
    pub(crate) const NOISE_SPREAD: f64 = 0.12;
    /// Least distance of the ends of an interval from the part that is stated.
    pub(crate) const INTERVAL_LEAST: f64 = 0.01;
    /// Noise from differences of periods, over the one that is used, above which the answer states it.
    pub(crate) const PERIODS_MORE: f64 = 2.0;
    /// Mean square of a gap, over that up to which nothing is left, below which an estimated noise may be all of it.
    pub(crate) const GAP_SMALL: f64 = 4.0;
    /// Frequency, over half the sample rate, up to which a triangle is one.
    pub(crate) const EXPERIMENT_TRIANGLE: f64 = 0.1;
    /// Frequency, over half the sample rate, up to which a triangle has as many turns as may be.
    pub(crate) const EXPERIMENT_TURNS: f64 = 0.05;
    /// Part of a signal's size below which its name says that it was made smaller.
    pub(crate) const EXPERIMENT_SMALLER: f64 = 0.995;
    /// How many times as steep as the logs a signal is from which its name says so.
    pub(crate) const EXPERIMENT_STATED: f64 = 1.005;
    /// Least rows of a part of the range in which a gap is judged.
    pub(crate) const RANGE_ROWS: usize = 50;
    /// Half of the middle of the range, and where its ends begin, over half the range.
    pub(crate) const RANGE_PARTS: (f64, f64) = (0.4, 0.6);
    /// Power in one part of the range or the record, over that in the others, from which the gap is mostly there.
    pub(crate) const MOSTLY: f64 = 4.0;
    /// Power at both ends of the range over that in its middle, or the other way round, from which the gap is there.
    pub(crate) const CLEARLY: f64 = 2.0;
    /// Least rows on a branch at a level of the command.
    pub(crate) const BRANCH_ROWS: f64 = 20.0;
    /// Least levels of the command that have both branches.
    pub(crate) const BRANCH_FEWEST: f64 = 4.0;
    /// Mean square of the branches, in powers of the noise, below which they show nothing.
    pub(crate) const BRANCH_NOTHING: f64 = 0.1;
    /// Power of what is opposite on both branches over that of what is the same, or the other way round, from which the
    /// gap is one of them.
    pub(crate) const BRANCH_MOSTLY: f64 = 3.0;
    /// Part of the gap's power above which a curve over the command is a static map.
    pub(crate) const BRANCH_MAP: f64 = 0.5;
    /// Least rows of a quarter of a record in which a gap is judged.
    pub(crate) const QUARTER_ROWS: usize = 20;
    /// Part of the gap's power in the means of eighths of a record above which it is slow.
    pub(crate) const SLOW: f64 = 0.5;
    /// Coherence of a residual with a function of the command above which the command causes it.
    pub(crate) const COHERENT: f64 = 0.25;
    /// Lines that a frequency response has on a page.
    pub(crate) const RESPONSE_LINES: usize = 1000;
    /// Power of a command, over its greatest, from which a line of it shows a response: a triangle and a chirp in one
    /// record differ by this much.
    pub(crate) const RESPONSE_BAND: f64 = 1e-6;
    /// Lines below which a response says nothing.
    pub(crate) const RESPONSE_FEWEST: usize = 8;
}
