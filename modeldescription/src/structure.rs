//! `<ModelStructure>`: which variables are unknown, and what they depend on.

use crate::names::named;
use crate::xml::Line;

named! {
    /// How an unknown depends on a known.
    DependencyKind {
        /// In any way.
        Dependent = "dependent",
        /// By a factor that is known before initialisation.
        Constant = "constant",
        /// By a factor that is known once initialisation has ended.
        Fixed = "fixed",
        /// By a factor that tunable parameters change.
        Tunable = "tunable",
        /// By a factor that changes at events.
        Discrete = "discrete",
    }
}

/// An unknown and what it depends on.
///
/// Variables are meant by their position counted from 1 in FMI 2.0 and by their value reference in
/// FMI 3.0, see [`crate::ModelDescription::referenced`].
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// The unknown variable.
    pub variable: u32,
    /// The knowns it depends on; none given means all of them, an empty list means none.
    pub dependencies: Option<Vec<u32>>,
    /// How it depends on each of them.
    pub dependency_kinds: Option<Vec<DependencyKind>>,
    /// Where the element stands.
    pub line: Line,
}

impl Unknown {
    /// An unknown whose dependencies are not stated, so that it may depend on all knowns.
    pub fn new(variable: u32) -> Self {
        Unknown { variable, dependencies: None, dependency_kinds: None, line: Line(0) }
    }

    /// An unknown that depends on these knowns only.
    pub fn depending_on(variable: u32, dependencies: Vec<u32>) -> Self {
        Unknown { dependencies: Some(dependencies), ..Unknown::new(variable) }
    }
}

/// `<ModelStructure>`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModelStructure {
    /// All outputs.
    pub outputs: Vec<Unknown>,
    /// Derivatives of the continuous states.
    pub derivatives: Vec<Unknown>,
    /// Clocked states (3.0).
    pub clocked_states: Vec<Unknown>,
    /// Variables that initialisation computes.
    pub initial_unknowns: Vec<Unknown>,
    /// Event indicators (3.0).
    pub event_indicators: Vec<Unknown>,
    /// Where the element stands.
    pub line: Line,
}
