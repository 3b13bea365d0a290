//! What a step and a run are made of, in FMI 2.0 and 3.0 alike.

/// Time span and accuracy of a run (`fmi2SetupExperiment`, `fmi3EnterInitializationMode`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Experiment {
    /// Start, s.
    pub start: f64,
    /// End, s, if it is fixed; the FMU may refuse steps beyond it.
    pub stop: Option<f64>,
    /// Relative tolerance for an FMU with error control.
    pub tolerance: Option<f64>,
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepResult {
    /// The FMU is at the end of the step.
    Completed,
    /// The FMU stopped before.
    Discarded {
        /// Time it reached, s, if it tells.
        reached: Option<f64>,
        /// It wants to end the simulation.
        terminated: bool,
    },
}
