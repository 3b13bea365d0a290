//! Which effects are believed, and how far.

/// Thresholds of the stage *belief*.
pub(crate) struct Thresholds;

impl Thresholds {
    /// Factor by which a further effect must reduce the remaining error.
    pub(crate) const CUT: f64 = 1.5;
    /// Factor by which a further effect must reduce the remaining error where nothing is left with it, however small
    /// it is.
    pub(crate) const CUT_TO_NOISE: f64 = 3.0;
    /// Factor by which a further effect must reduce the remaining error where it explains little of the gap and less
    /// than the noise is left with it: a repair of another effect's formula seldom cuts so much.
    pub(crate) const CUT_SHARPLY: f64 = 10.0;
    /// Error above the noise, in powers of the noise, that is next to nothing.
    pub(crate) const NEARLY_NOISE: f64 = 1.0;
    /// Part of the gap that is next to nothing, too, where the gap is large.
    pub(crate) const NEARLY_NOTHING: f64 = 0.003;
    /// Error that a pair may promise in the first order, to be fitted, over what it may leave at last.
    pub(crate) const OUT_OF_REACH: f64 = 30.0;
    /// Part of what two effects leave on held-out rows that a third one must take where it explains little of the gap:
    /// what repairs another effect's formula seldom takes nearly all of it on rows that no fit has seen.
    pub(crate) const THIRD_TAKES: f64 = 0.9;
    /// Score that the effects together must reach.
    pub(crate) const SCORE: f64 = 0.6;
    /// Part of the held-out gap's power that the effects together must explain.
    pub(crate) const POWER: f64 = 0.5;
    /// Part of the held-out gap's power with which a lower score is enough.
    pub(crate) const POWER_CLEAR: f64 = 0.9;
    /// Score that is enough with that part of the power.
    pub(crate) const SCORE_WITH_POWER: f64 = 0.35;
    /// Standard errors by which the blocks must be better with that part of the power: few large strokes are few
    /// blocks.
    pub(crate) const BLOCKS_WITH_POWER: f64 = 2.0;
    /// Distance below the limits of both score and power at which a set of effects is not looked at again.
    pub(crate) const HOPELESS: f64 = 0.2;
    /// Error of the re-tuned model, in powers of the noise, below which a gap is faint.
    pub(crate) const FAINT: f64 = 10.0;
    /// Part of the held-out gap's power that a line in the spectrum, or a course without a formula, must explain alone, and
    /// names outside groups where the gap is faint: from the benchmark, in which no such name was right below it.
    pub(crate) const POWER_OF_OWN: f64 = 0.8;
    /// Least part of the gap's power, or of the score, that each further effect must add.
    pub(crate) const FURTHER: (f64, f64) = (0.08, 0.15);
    /// Part of the held-out power from which a first effect is clear, or imitates a pair.
    pub(crate) const CLEAR: f64 = 0.8;
    /// Single effects, beside the best one, from which a pair is searched.
    pub(crate) const PAIR_RIVALS: usize = 3;
    /// Error that those single effects may leave, over that of the best one.
    pub(crate) const PAIR_NEAR: f64 = 3.0;
    /// Probability that the formulas of several effects are the machine's, from what they leave: two together imitate
    /// much that is in no library, and then leave more than they do of a pair.
    pub(crate) const OF_SEVERAL: f64 = 0.8;
    /// Least trust in each of several names, which says in addition that no other does nearly as well in its place;
    /// that is as good where most of the gap's power goes.
    pub(crate) const OF_CLEAR_NAMES: f64 = 0.6;
    /// Least probability that each of several effects is one, whatever its name, and no repair of the others'
    /// formulas.
    pub(crate) const LIKELY: f64 = 0.5;
    /// Most effects that are exchanged once the search stands.
    pub(crate) const MOST_SWAPS: usize = 2;
    /// Part of the fitted rows' gap that must go, and most coefficients of each effect, where the held-out rows have
    /// no gap to be explained.
    pub(crate) const FITTED_WELL: (f64, usize) = (0.9, 4);
    /// Loss of score below which an effect is dropped again.
    pub(crate) const DROPPED: f64 = 0.02;
    /// Probability that the names of the set together must reach.
    pub(crate) const SET: f64 = 0.95;
    /// Exponent with which the odds of a rival fall with the error that it leaves: odds = times^−SHARPNESS. From the
    /// benchmark: with 3, names of 30 to 70 % were right in 86 of 89 cases whose effect was in the library.
    pub(crate) const SHARPNESS: f64 = 6.0;
    /// Fall of the logarithm of the odds with each coefficient more, among formulas that leave alike: one that can
    /// imitate many others says little when it fits no better.
    pub(crate) const ORDER: f64 = 1.6;
    /// Factor up to which formulas leave alike.
    pub(crate) const ALIKE: f64 = 1.25;
    /// Logarithm of the odds, for each record, against a name whose formula does not predict the held-out rows and fits all
    /// rows as well as that of the name that does: few rows do not determine its parameters.
    pub(crate) const NOT_PREDICTED: f64 = 1.9;
    /// Most rivals that are fitted to all rows.
    pub(crate) const RIVALS_OPEN: usize = 4;
    /// Trust below which neither the name nor its group is given.
    pub(crate) const TRUSTED: f64 = 0.5;
    /// Probability that the cause is in the library where nothing is left; from the benchmark.
    pub(crate) const LIBRARY: f64 = 0.98;
    /// Probability that the cause is in the library where nothing is left and the name is one of a group; from the
    /// benchmark. What looks like the others of its group in a log looks like many things that are in no library.
    pub(crate) const LIBRARY_OF_GROUPS: f64 = 0.91;
    /// Part of the gap that is left where the cause is as likely in the library as not; from the benchmark.
    pub(crate) const LEFT_OF_UNKNOWN: f64 = 0.12;
    /// Exponent with which the odds of the library fall with the part of the gap that is left; from the benchmark.
    pub(crate) const STEEPNESS: f64 = 1.2;
    /// Rows below which a record says nothing of what causes its residual.
    pub(crate) const CAUSED_ROWS: usize = 512;
    /// Least number of blocks of a record, each of which is predicted by others.
    pub(crate) const CAUSED_BLOCKS: usize = 16;
    /// Most that a block may lose by its prediction, in powers of the noise.
    pub(crate) const CAUSED_LOST: f64 = 0.1;
    /// Most rows of such a block, which bounds the memory.
    pub(crate) const CAUSED_LONGEST: usize = 2048;
    /// Part of a function's power by which its coefficient is held down.
    pub(crate) const CAUSED_RIDGE: f64 = 1e-5;
    /// Probability of a name whose fit ends at a bound of the effect, over that of one that ends inside: of eleven in the
    /// benchmark none was right.
    pub(crate) const AT_BOUND: f64 = 0.05;
    /// Part of the noise's power that the right formula may leave unseen.
    pub(crate) const UNSEEN: f64 = 0.01;
    /// Part of the gap that a further effect takes away where it is as likely an effect as a repair of the others'
    /// formulas.
    pub(crate) const REPAIR: f64 = 0.01;
    /// Error that a further effect takes away, over what is left at last, where it is as likely an effect as a repair
    /// of the others' formulas.
    pub(crate) const REPAIRED: f64 = 30.0;
    /// Score, and standard errors by which the blocks must be better with it, that are enough for a first effect.
    pub(crate) const FIRST: (f64, f64) = (0.2, 3.0);
    /// Standard errors by which the blocks must be better with a further effect.
    pub(crate) const BLOCKS_FURTHER: f64 = 4.0;
    /// Groups of blocks, each of which is predicted by the others.
    pub(crate) const CAUSED_FOLDS: usize = 8;
    /// Low-passes of the command, and of the reading, that may cause what is left.
    pub(crate) const CAUSED_LOW_PASSES: usize = 7;
    /// Band-passes of the reading that may cause what is left.
    pub(crate) const CAUSED_BANDS: usize = 10;
    /// Triangles over each range that may cause what is left.
    pub(crate) const CAUSED_TRIANGLES: usize = 9;
}
