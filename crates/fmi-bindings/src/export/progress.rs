//! Where an instance is in its life and in time.

use super::phase::Phase;

/// Where an instance is.
#[derive(Clone, Copy)]
pub(super) struct Progress {
    pub(super) phase: Phase,
    /// A value was set before the first step: the outputs do not follow it yet.
    pub(super) stale: bool,
    /// An input has a slope in the next step.
    pub(super) sloped: bool,
    /// The last communication point in s.
    pub(super) time: f64,
    pub(super) experiment: Experiment,
}

/// The experiment as the importer set it up.
#[derive(Clone, Copy)]
pub(super) struct Experiment {
    pub(super) defined: bool,
    /// In s.
    pub(super) start: f64,
    /// In s, ∞ where none is defined.
    pub(super) stop: f64,
}

impl Progress {
    /// The progress of an instance right after instantiation.
    pub(super) const NEW: Self = Self {
        phase: Phase::Instantiated,
        stale: true,
        sloped: false,
        time: 0.0,
        experiment: Experiment { defined: false, start: 0.0, stop: f64::INFINITY },
    };
}
