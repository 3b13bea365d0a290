//! Where a blueprint came from: file, lines, and what was already wrong with its words.

use std::collections::HashMap;

use crate::Problem;

/// File and lines of a blueprint. It is no part of what the blueprint says, so all are equal.
#[derive(Clone, Debug, Default)]
pub(super) struct Origin {
    pub(super) file: String,
    /// Lines by key path, as in `axis[1].component[2].w[3]`.
    pub(super) lines: HashMap<String, usize>,
    /// Problems that were found while reading, with their key paths.
    pub(super) problems: Vec<(String, Problem)>,
    /// Records whose values were taken.
    pub(super) records: Vec<String>,
}

impl PartialEq for Origin {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Origin {
    /// What messages call the blueprint.
    pub(super) fn name(&self) -> &str {
        if self.file.is_empty() { "blueprint" } else { &self.file }
    }

    /// The line of a key, or of the nearest key above it that has one.
    pub(super) fn line(&self, key: &str) -> Option<usize> {
        let mut key = key;
        loop {
            if let Some(line) = self.lines.get(key) {
                return Some(*line);
            }
            key = &key[..key.rfind(['.', '['])?];
        }
    }

    /// Whether something was wrong with this key already when it was read.
    pub(super) fn is_spoilt(&self, key: &str) -> bool {
        self.problems.iter().any(|(spoilt, _)| spoilt == key)
    }
}

/// A key's two names: the path in the file and the one that messages show.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// As in `axis[1].component[2].w`.
    pub(super) key: String,
    /// As in `axis[1].hysteresis.w`.
    pub(super) shown: String,
}

impl Place {
    pub(super) fn new(key: &str) -> Self {
        Self { key: key.into(), shown: key.into() }
    }
    /// The key `name` below.
    pub(super) fn child(&self, name: &str) -> Self {
        let join = |path: &str| {
            if path.is_empty() { name.to_string() } else { format!("{path}.{name}") }
        };
        Self { key: join(&self.key), shown: join(&self.shown) }
    }
    /// Item number `number`, from 1.
    pub(super) fn item(&self, number: usize) -> Self {
        let join = |path: &str| format!("{path}[{number}]");
        Self { key: join(&self.key), shown: join(&self.shown) }
    }
    /// The same key, shown as `name` below `parent`.
    pub(super) fn shown_as(self, parent: &Self, name: &str) -> Self {
        Self { key: self.key, shown: parent.child(name).shown }
    }
}
