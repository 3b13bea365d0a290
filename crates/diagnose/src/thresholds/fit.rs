//! How parameters are fitted.

/// Thresholds of the stage *fit*.
pub(crate) struct Thresholds;

impl Thresholds {
    /// Tuned parameters of an FMU from which its sensitivities are costly: each is a run over all records.
    pub(crate) const MANY_TUNED: usize = 8;
    /// Records that are simulated at once.
    pub(crate) const ABREAST: usize = 4;
    /// Most iterations of a fit.
    pub(crate) const ITERATIONS: usize = 16;
    /// Fall of the cost below which an iteration ends the fit.
    pub(crate) const SMALL_FALL: f64 = 0.2;
    /// Fall of the cost above which a thorough fit computes all sensitivities anew.
    pub(crate) const LARGE_FALL: f64 = 20.0;
    /// Most iterations where the sensitivities of an FMU are corrected from step to step.
    pub(crate) const ITERATIONS_CORRECTED: usize = 40;
    /// Part of a step's change of the residual that its sensitivities may miss: with more they are computed anew.
    pub(crate) const CHANGE_MISSED: f64 = 0.7;
    /// Error of a candidate, over that of the best one, up to which it is fitted to its end where that is costly.
    pub(crate) const FAR: f64 = 3.0;
    /// Fall of the cost, since all sensitivities of an FMU were computed anew, up to which they still hold.
    pub(crate) const STILL_FRESH: f64 = 4.0;
    /// Rows per independent row.
    pub(crate) const CORRELATED_ROWS: f64 = 10.0;
    /// Most rows that count as independent: in a structured residual more rows are no more knowledge.
    pub(crate) const MOST_EFFECTIVE: f64 = 4000.0;
    /// Changes by which the number of steps of a converter is settled, in steps.
    pub(crate) const STEP_DISTANCES: [f64; 6] = [0.16, 0.08, 0.04, 0.02, 0.01, 0.005];
    /// Length in s of the blocks that a robust fit weighs.
    pub(crate) const ROBUST_BLOCK: f64 = 0.05;
    /// Least rows of such a block.
    pub(crate) const ROBUST_ROWS: usize = 8;
    /// Mean square, over the noise's, at which a block counts half in a robust fit.
    pub(crate) const ROBUST_HALF: f64 = 2.0;
    /// Fits of a robust fit.
    pub(crate) const ROBUST_ROUNDS: usize = 2;
    /// Least rows that count as independent.
    pub(crate) const LEAST_EFFECTIVE: f64 = 50.0;
}
