//! What is known of a blueprint while it is checked.

use model::{NodeSpec, SystemSpec};

use super::origin::Place;

/// The specification as far as it is known. Values that are wrong are replaced by harmless
/// ones, so that the rest can be checked too.
pub(super) struct Draft {
    pub(super) spec: SystemSpec,
    pub(super) axes: Vec<DraftAxis>,
    /// For each coupling of the specification: its place, and whether its values are those of the
    /// file.
    pub(super) couplings: Vec<(Place, bool)>,
}

/// Beside an axis of the specification.
#[derive(Default)]
pub(super) struct DraftAxis {
    /// For each component of the specification: its place in the file, and whether its values are
    /// those of the file.
    pub(super) components: Vec<(Place, bool)>,
    /// For each of these components, the unit that `{position}` stands for.
    pub(super) position_units: Vec<String>,
    /// Whether components are missing because their type is unknown.
    pub(super) has_gaps: bool,
}

/// A component of the draft.
pub(super) struct DraftNode {
    pub(super) node: NodeSpec,
    pub(super) is_clean: bool,
}
