//! Which effects are tried, where, and how far each is fitted.

/// Thresholds of the stage *search*.
pub(crate) struct Thresholds;

impl Thresholds {
    /// Mean square of a reading, over what it was, up to which what was found in another axis moves it.
    pub(crate) const MOVED_BY_AXIS: f64 = 0.9;
    /// Times that each of the axes which a coupling joins may be taken over.
    pub(crate) const ROUNDS_OF_AXES: usize = 3;
    /// Least ratio to the noise with which a frequency band counts.
    pub(crate) const BAND_FLOOR: f64 = 1.3;
    /// Distance of a band's floor from the noise, in standard deviations of the band's mean power.
    pub(crate) const BAND_SPREAD: f64 = 1.6;
    /// Blocks of all records together, in which residuals are compared.
    pub(crate) const JUDGED_BLOCKS: usize = 400;
    /// Error power above the noise from which one record shows a gap, over that from which all rows together do: the part
    /// of the noise that grows as 1/f differs that much from record to record.
    pub(crate) const RECORD_ALONE: f64 = 3.0;
    /// Variance of the difference of the means of the first 70 and the last 30 % of a record, of noise with the
    /// density 1/f: ∫ |H|²/f df.
    pub(crate) const SLOW_DIFFERENCE: f64 = 2.9;
    /// Standard deviations by which slow noise may shift the held-out end of a record.
    pub(crate) const SLOW_DEVIATIONS: f64 = 2.0;
    /// Number of frequency bands.
    pub(crate) const BANDS: usize = 18;
    /// Longest segment of a spectrum in rows.
    pub(crate) const SEGMENT_LONGEST: usize = 4096;
    /// Shortest segment of a spectrum in rows.
    pub(crate) const SEGMENT_SHORTEST: usize = 256;
    /// Least segments of the longest stretch.
    pub(crate) const SEGMENTS: usize = 8;
    /// Most commands beside its own that a mode of a structure is looked for with.
    pub(crate) const SHARING_COMMANDS: usize = 3;
    /// Most frequencies at which a mode is looked for.
    pub(crate) const RESONANCES: usize = 4;
    /// Lines beside a peak that must be lower.
    pub(crate) const PEAK_BESIDE: usize = 2;
    /// Part of its frequency within which the median beside a peak is taken.
    pub(crate) const PEAK_MEDIAN: f64 = 0.2;
    /// Least height of a peak over the median beside it.
    pub(crate) const PEAK_ABOVE: f64 = 1.5;
    /// Most lines of a spectrum that are kept as disturbances.
    pub(crate) const LINES: usize = 6;
    /// How far a multiple of a command's line may be off, in parts of the frequency.
    pub(crate) const LINE_MULTIPLE: f64 = 0.25;
    /// Records that have a line from which it is a disturbance, where in all but one it may be an answer to the
    /// command.
    pub(crate) const LINE_RECORDS: usize = 3;
    /// Distance of two lines that are one, over the resolution: a place between lines is known well.
    pub(crate) const LINE_SAME: f64 = 0.25;
    /// Least error power, over that of the noise, that is searched for what acts in front of the mode.
    pub(crate) const LEFT_SOUGHT: f64 = 0.01;
    /// Frequencies of a jitter that are tried.
    pub(crate) const JITTER_TRIED: usize = 2;
    /// Part of the residual that a swing of the sample times must take to be tried, as the sums over the records of
    /// the effective values of both.
    pub(crate) const JITTER_LEAST: f64 = 0.1;
    /// Highest frequency of a jitter, times the sample time: faster jitter is noise.
    pub(crate) const JITTER_HIGHEST: f64 = 0.1;
    /// Length of the transform over that of the longest record, so that no peak lies between its lines.
    pub(crate) const JITTER_FINE: usize = 4;
    /// Least rows of a record that can show a jitter.
    pub(crate) const JITTER_ROWS: usize = 64;
    /// Most steps of a converter over the range.
    pub(crate) const CONVERTER_STEPS: usize = 1024;
    /// Resolution of the search for a converter's steps, in periods over the range.
    pub(crate) const CONVERTER_FINE: f64 = 0.25;
    /// Places over the range at which rows are gathered.
    pub(crate) const CONVERTER_PLACES: usize = 8192;
    /// Rows with which a place counts at most, over those of the median place.
    pub(crate) const CONVERTER_OFTEN: f64 = 4.0;
    /// Codes of which one is missing.
    pub(crate) const CONVERTER_CODES: [u32; 8] = [3, 4, 5, 6, 8, 10, 12, 16];
    /// Part of the residual's power that steps with missing codes must show to be tried, over that of one row.
    pub(crate) const CONVERTER_SHOWN: f64 = 100.0;
    /// Periods on either side of a line, with whose median it is compared.
    pub(crate) const CONVERTER_BESIDE: usize = 40;
    /// Least height of a line over the median beside it.
    pub(crate) const CONVERTER_OVER: f64 = 12.0;
    /// Largest width of a line in places.
    pub(crate) const CONVERTER_WIDE: usize = 4;
    /// Lines of a converter that are kept.
    pub(crate) const CONVERTER_LINES: usize = 5;
    /// Accuracy to which the periods of a line are known.
    pub(crate) const CONVERTER_KNOWN: f64 = 0.06;
    /// Accuracy to which the place of a step at the end of the range must be known, in steps.
    pub(crate) const CONVERTER_NEAR: f64 = 0.1;
    /// Places of a pattern per step.
    pub(crate) const CONVERTER_BINS: usize = 12;
    /// Part of the way to the rate of a row by which the smoothed rate moves, where thresholds grow up to a limit.
    pub(crate) const RATE_SATURATING: f64 = 0.3;
    /// Part of the way to the rate of a row by which the smoothed rate moves, where the loop grows.
    pub(crate) const RATE_GROWING: f64 = 0.1;
    /// Factor by which a resonance may have moved.
    pub(crate) const RESONANCE_FAR: f64 = 1.6;
    /// Lines of a train of pulses, as of a force that acts during a part of each turn.
    pub(crate) const PULSE_LINES: usize = 10;
    /// Families that are fitted after the screening.
    pub(crate) const FAMILIES_FITTED: usize = 7;
    /// Families that are fitted after the screening where an effect is found already.
    pub(crate) const FAMILIES_FITTED_BESIDE: usize = 5;
    /// Families whose best formula is fitted thoroughly.
    pub(crate) const FAMILIES_REFINED: usize = 4;
    /// Ranks by which a formula with fewer coefficients may be behind after a quick fit and still be fitted to the end.
    pub(crate) const PLAINER: f64 = 30.0;
    /// Most free numbers of a model that is fitted thoroughly while effects are still compared: each takes a
    /// simulation for every step of the fit.
    pub(crate) const MOST_FITTED_ANEW: usize = 24;
    /// Part of the best promise from which a formula that needs a thorough fit gets one.
    pub(crate) const PROMISING: f64 = 0.7;
    /// Weight of the training rows in the rank; the rest is that of the held-out rows.
    pub(crate) const TRAINING_WEIGHT: f64 = 0.5;
    /// Part of what was left before, below which a formula without the effect is fitted to its end.
    pub(crate) const WENT_FAR: f64 = 0.5;
    /// Error without the effect, over the error with it, that a formula must reach.
    pub(crate) const OVER_NULL: f64 = 1.1;
    /// Factors by which a time, rate or width starts elsewhere.
    pub(crate) const AWAY_FACTORS: [f64; 4] = [1.3, 1.0 / 1.3, 1.8, 1.0 / 1.8];
    /// Most moves of a fit to another start.
    pub(crate) const AWAY_ROUNDS: usize = 4;
    /// Most parameters that start elsewhere.
    pub(crate) const AWAY_MOVED: usize = 3;
    /// Shifts from which a released parameter of the model starts elsewhere, in parts of its value.
    pub(crate) const RELEASED_SHIFTS: [f64; 6] = [-0.03, 0.03, -0.07, 0.07, -0.15, 0.15];
    /// Least and greatest place of a resonance that is looked for along the range, over the model's.
    pub(crate) const RESONANCE_RANGE: [f64; 2] = [0.3, 3.0];
    /// Ratio of a place along the range to the one before: about the width of a light mode.
    pub(crate) const RESONANCE_STEP: f64 = 1.03;
    /// Most that such a place leaves, over what the fit left.
    pub(crate) const RESONANCE_LEFT: f64 = 2.0;
    /// How many times what another family leaves shows that the fit of a resonance ended on the way.
    pub(crate) const RESONANCE_TIMES_OTHERS: f64 = 100.0;
    /// Places from which it is fitted.
    pub(crate) const RESONANCE_STARTS: usize = 3;
    /// Error of a fit, over the promised one, above which the fit ended on the way.
    pub(crate) const STUCK: f64 = 4.0;
    /// Part of the gap that an effect must explain to start elsewhere: what explains little is not near.
    pub(crate) const AWAY_NEAR: f64 = 0.8;
    /// Parts of a search that are kept.
    pub(crate) const PARTS_KEPT: usize = 40;
    /// Relative difference of the mean squares up to which two fits of the same effects are one.
    pub(crate) const PARTS_SAME: f64 = 1e-3;
    /// Root mean square that a model leaves, over half the range of the readings, from which nearly all is loop.
    pub(crate) const ALL_LOOP: f64 = 0.2;
    /// Fall of the rank from which another formula of an effect, or another effect in its place, is better.
    pub(crate) const RANK_BETTER: f64 = 1.0;
    /// Least rows of a block in which residuals are compared.
    pub(crate) const JUDGED_ROWS: usize = 20;
    /// Least blocks whose losses are compared.
    pub(crate) const PAIRED_BLOCKS: f64 = 4.0;
    /// Mean square of a block, over the noise's, below which less is no better.
    pub(crate) const PAIRED_FLOOR: f64 = 0.5;
    /// Most correlation of neighbouring blocks that widens the error of their mean.
    pub(crate) const PAIRED_ALIKE: f64 = 0.9;
    /// Coherence, times the segments, from which a peak of an answer is no noise: that alone has one.
    pub(crate) const PEAK_COHERENT: f64 = 5.0;
    /// Least lines of a spectrum in which lines are looked for.
    pub(crate) const LINE_SPECTRUM: usize = 32;
    /// Part of the spectrum beside a line whose median it is compared with.
    pub(crate) const LINE_BESIDE: usize = 100;
    /// Least and most lines of that part.
    pub(crate) const LINE_BESIDE_LINES: (usize, usize) = (8, 200);
    /// Least density of what is beside a line, over the noise's.
    pub(crate) const LINE_FLOOR: f64 = 0.1;
    /// Least height of a line over the median beside it.
    pub(crate) const LINE_ABOVE: f64 = 30.0;
    /// Least rows of a segment from which a coherence is estimated.
    pub(crate) const COHERENCE_ROWS: usize = 16;
    /// Lines of a command that are looked for in the residual.
    pub(crate) const COMMAND_LINES: usize = 40;
    /// Highest multiple of a command's strongest line that is an answer to it.
    pub(crate) const COMMAND_ORDERS: f64 = 20.0;
    /// Part of the frequency within which a line is one of the mains.
    pub(crate) const MAINS_NEAR: f64 = 0.01;
    /// Highest multiple of the mains.
    pub(crate) const MAINS_ORDERS: i32 = 6;
    /// How far the frequency of the mains may be off, relative.
    pub(crate) const MAINS_OFF: f64 = 0.005;
    /// How far it may be off in a short record, in periods of the longest record.
    pub(crate) const MAINS_OFF_SHORT: f64 = 0.2;
    /// How far it may be off in any record, relative.
    pub(crate) const MAINS_OFF_MOST: f64 = 0.02;
    /// Least periods in the longest record of a mode from which a fit starts.
    pub(crate) const MODE_START_PERIODS: f64 = 5.0;
    /// Lowest and highest frequency of a mode from which a fit starts, times the sample time.
    pub(crate) const MODE_STARTS: (f64, f64) = (0.002, 0.4);
    /// Least periods in the longest record of a mode, or a modulation, that is missing.
    pub(crate) const MODE_PERIODS: f64 = 0.5;
    /// Highest frequency of a mode, or a modulation, that is missing, times the sample time.
    pub(crate) const MODE_HIGHEST: f64 = 0.49;
    /// Greatest damping of a mode that is missing: one that is damped more is a lag.
    pub(crate) const MODE_DAMPING: f64 = 0.12;
    /// Frequencies over the model's own up to which, and from which on, a missing mode is no shift of it.
    pub(crate) const MODE_APART: (f64, f64) = (0.87, 1.15);
    /// Least ratio of the ends of a band in which a missing mode is looked for.
    pub(crate) const MODE_BAND: f64 = 1.1;
    /// Lines that a train of pulses has at least, and the order that one of them must be above.
    pub(crate) const PULSE_SEEN: (usize, f64) = (3, 3.0);
    /// Order up to which the lowest line of a train of pulses may be that is seen.
    pub(crate) const PULSE_FIRST: i32 = 4;
    /// Least frequency of a train of pulses, over the resolution.
    pub(crate) const PULSE_RESOLVED: f64 = 4.0;

    /// Places along the range, over the model's.
    pub(crate) fn resonance_places() -> impl Iterator<Item = f64> {
        let [least, greatest] = Self::RESONANCE_RANGE;
        let steps = ((greatest / least).ln() / Self::RESONANCE_STEP.ln()).ceil() as i32;
        (0..=steps).map(move |k| least * Self::RESONANCE_STEP.powi(k))
    }
}
