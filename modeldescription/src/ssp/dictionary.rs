//! Signal dictionaries: signals that elements share by their names (SSB).

use super::connector::{Connector, Source};
use crate::description::{Line, Unit};

/// A list of signals. All connectors of one name, at all references to it, are one signal.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalDictionary {
    /// Name, unique in its system; references look it up there and in the systems around.
    pub name: String,
    /// Where the list comes from.
    pub source: Source,
    /// The signals, each a connector of kind inout; none where the list is not loaded.
    pub signals: Option<Vec<Connector>>,
    /// Units that the list brings along.
    pub units: Vec<Unit>,
    /// Where it stands.
    pub line: Line,
}

/// An element that stands for a signal dictionary.
#[derive(Debug, Clone, PartialEq)]
pub struct DictionaryReference {
    /// Name, unique in the enclosing system.
    pub name: String,
    /// Name of the dictionary.
    pub dictionary: String,
    /// The signals that are connected here.
    pub connectors: Vec<Connector>,
    /// Where it stands.
    pub line: Line,
}

impl SignalDictionary {
    /// A list inside the SSD.
    pub fn inline(name: impl Into<String>, signals: Vec<Connector>) -> Self {
        let (name, signals) = (name.into(), Some(signals));
        SignalDictionary { name, source: Source::Inline, signals, units: Vec::new(), line: Line(0) }
    }
}
