//! What the repaired model is made of.

/// Thresholds of the stage *repair*.
pub(crate) struct Thresholds;

impl Thresholds {
    /// Part of the gap's power that another formula must take, beside that of the other effects.
    pub(crate) const STAND_IN_WORTH: f64 = 0.02;
    /// Standard errors from which an offset is shared by all records.
    pub(crate) const OFFSET_SHARED: f64 = 2.0;
    /// Part of the noise below which an offset is none.
    pub(crate) const OFFSET_LEAST: f64 = 0.1;
    /// Most rows under which plays without negative weights are fitted to found ones.
    pub(crate) const PLAYS_ROWS: usize = 20_000;
    /// Mean square under the written axis, over that of the fitted formulas, above which the axis is tuned again.
    pub(crate) const WRITTEN_OFF: f64 = 1.02;
    /// Standard deviation within which values of components that were found may be tuned again, relative.
    pub(crate) const WRITTEN_DEVIATION: f64 = 0.2;
    /// Most changes of the written offset until what is left of it is far below the noise.
    pub(crate) const OFFSET_TURNS: usize = 4;
    /// Error power with an offset behind all parts, over that with one in the actuator, from which it stands there.
    pub(crate) const OFFSET_BEHIND: f64 = 0.95;
    /// Part of the noise below which what is left of the written offset is nothing.
    pub(crate) const OFFSET_SMALL: f64 = 1e-3;
    /// Straight pieces on each side of zero.
    pub(crate) const ZONES: usize = 24;
    /// How far the pieces reach beyond the range of the logs, over that range.
    pub(crate) const ZONES_BEYOND: f64 = 0.05;
    /// Least change of slope that is written.
    pub(crate) const ZONES_SLOPE: f64 = 1e-9;
    /// How far the gain of a mode may be from 1 that is the first of a model without one.
    pub(crate) const ALL_THROUGH_MODE: f64 = 0.15;
}
