//! When a linear model identified from the logs is taken, and how far its parameters may be off.

/// Thresholds of the linear model.
pub(super) struct Thresholds;

impl Thresholds {
    /// Part of what the linear plant leaves that the one with plays must leave at most, for its linear parts to be
    /// taken.
    pub(super) const WITH_PLAYS: f64 = 0.9;
    /// Part of the mean square that parts in a row leave of a response that modes side by side must leave at most, to
    /// be taken: many modes follow the scatter of a nonlinear machine, too.
    pub(super) const SIDE_BY_SIDE: f64 = 0.25;
    /// How many times as much a command straight between the rows may leave as one that acts at once, of which a delay
    /// makes the same.
    pub(super) const STRAIGHT: f64 = 1.1;
    /// Standard errors of which a tolerance consists.
    pub(super) const ERRORS: f64 = 1.0;
    /// Standard errors by which a delay must be seen.
    pub(super) const SEEN: f64 = 2.0;
    /// Least tolerance: what a linear model of a machine that is none takes into its parameters.
    pub(super) const LEAST: f64 = 0.1;
    /// Least tolerance of a damping.
    pub(super) const LEAST_OF_DAMPING: f64 = 0.5;
    /// Part of the range that a linear model must leave, for its dynamics to be taken for an imitation.
    pub(super) const IMITATES: f64 = 0.05;
    /// How many times as much an answer with fewer effects may leave.
    pub(super) const AS_MUCH: f64 = 1.1;
    /// Standard deviation of a parameter, over its value, above which the logs do not determine it.
    pub(super) const NOT_DETERMINED: f64 = 1e3;
}
