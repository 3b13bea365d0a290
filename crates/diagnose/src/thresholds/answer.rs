//! What the answer states beside the names.

/// Thresholds of the stage *answer*.
pub(crate) struct Thresholds;

impl Thresholds {
    /// Part of a frequency within which those of several outputs are the same.
    pub(crate) const SAME_FREQUENCY: f64 = 0.01;
    /// As [`Self::SAME_FREQUENCY`], of a damping or of another parameter of the model.
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
}
