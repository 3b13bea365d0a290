//! How large the noise is, and up to which error nothing is left.

/// Thresholds of the stage *noise*.
pub(crate) struct Thresholds;

impl Thresholds {
    /// Most that the part of the noise that grows as 1/f may add to the white part, where only logs of a driven
    /// machine show it: more of it could be an effect.
    pub(crate) const MOST_COLOUR: f64 = 1.0;
    /// For noise: mean of the lines of a band that are below five times their median, over the mean of all lines.
    pub(crate) const TRIMMED_MEAN: f64 = 0.91;
    /// Least rows of a record in which noise that was stated too small is looked for.
    pub(crate) const WHITE_ROWS: usize = 200;
    /// How far the white levels of records may differ, relative, beside the spread of few rows, for all of a residual
    /// to be noise.
    pub(crate) const WHITE_LEVELS_ALIKE: f64 = 0.1;
    /// What may be left beside white noise for a residual to be noise: in variances of the stated noise, which may
    /// hold a part that grows as 1/f, and relative to the white part.
    pub(crate) const COLOUR_LEFT: (f64, f64) = (0.6, 0.1);
    /// How far the fourth moment of a residual that is noise may be from 3, that of the normal distribution.
    pub(crate) const FOURTH_MOMENT: f64 = 0.4;
    /// Accuracy to which a grid of readings is known, in steps.
    pub(crate) const GRID_OFF: f64 = 0.02;
    /// Part of the rows that may lie off the grid of readings.
    pub(crate) const GRID_STRAY: f64 = 1e-3;
    /// Least number of different readings that make a grid.
    pub(crate) const GRID_LEVELS: usize = 8;
    /// Least rows for each reading of a grid.
    pub(crate) const GRID_ROWS: usize = 8;
    /// Rows of a stretch in which repeated readings are counted.
    pub(crate) const STRETCH_ROWS: usize = 50;
    /// Part of the rows of a stretch that repeat the row before, in one of four stretches: steps of 2.3 standard
    /// deviations of the noise or more.
    pub(crate) const STRETCH_REPEATED: f64 = 0.5;
    /// Relative rounding of numbers of single precision.
    pub(crate) const SINGLE_PRECISION: f64 = 2.5e-7;
    /// Mean square, over the noise's, up to which nothing is left where the noise is estimated: logs of a driven
    /// machine show a part of it only.
    pub(crate) const ADEQUATE_ESTIMATED: f64 = 1.6;
    /// Mean square, over the noise's, up to which nothing is left where the noise was given: its standard deviation
    /// may be off by a tenth or so.
    pub(crate) const ADEQUATE_GIVEN: f64 = 1.3;
    /// Mean square, over the noise's, up to which nothing is left where the noise is that of a record at rest, which
    /// is one draw of it.
    pub(crate) const ADEQUATE_AT_REST: f64 = 1.35;
    /// Part of the remaining error that rounding must be, for the steps of the reading to be named.
    pub(crate) const STEPS_NAMED: f64 = 0.25;
    /// Noise after effects are found, over the noise before, below which the search is made again under the smaller
    /// one.
    pub(crate) const QUIETER: f64 = 0.95;
    /// Noise from differences of periods over noise from differences of neighbours, below which the command fills the
    /// whole band and the periods show the noise.
    pub(crate) const PERIODS_RICH: f64 = 0.5;
    /// Least part of the variance of the noise that is white.
    pub(crate) const LEAST_WHITE: f64 = 0.05;
    /// Least rows of the longest record at rest that shows a noise.
    pub(crate) const REST_ROWS: usize = 64;
    /// Least lines of a band of which those that stand out are left out.
    pub(crate) const TRIMMED_LINES: usize = 5;
    /// Power of a line, over the median of its band, above which it stands out.
    pub(crate) const TRIMMED_ABOVE: f64 = 5.0;
    /// Fall of [`Self::TRIMMED_MEAN`] from 1 with each line of a band of few.
    pub(crate) const TRIMMED_FALL: f64 = 0.03;
    /// Least lines of a band in which a record shows the slow part of the noise.
    pub(crate) const COLOUR_LINES: usize = 3;
    /// Highest frequency at which the slow part of the noise is looked for, over half the sample rate.
    pub(crate) const COLOUR_BELOW: f64 = 0.1;
    /// Least differences of rows that show a noise.
    pub(crate) const DIFFERENCES: usize = 20;
    /// Rows of repeated periods above which they show a noise.
    pub(crate) const REPEATED_ROWS: usize = 50;
    /// Part of its range within which a command repeats.
    pub(crate) const REPEATED_NEAR: f64 = 5e-4;
    /// Part of its range by which a command moves within a period.
    pub(crate) const REPEATED_MOVES: f64 = 0.1;
    /// Stated noise over that of the rounding alone, above which it holds the rounding.
    pub(crate) const HOLDS_ROUNDING: f64 = 0.9;
    /// Least step of a grid of readings, over what values of single precision are off.
    pub(crate) const GRID_STEP: f64 = 4.0;
}
