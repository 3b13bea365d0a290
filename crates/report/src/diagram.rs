//! Diagrams: signal paths as rows of boxes.

use serde::{Deserialize, Serialize};

/// Signal paths, one below the other; each is a list of its stages and reads as one without a picture.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diagram {
    /// What is shown.
    pub title: String,
    /// The paths.
    pub lanes: Vec<Lane>,
}

/// One signal path, from left to right.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lane {
    /// The lane's name, such as an axis.
    pub label: String,
    /// The lane's stages.
    pub stages: Vec<Stage>,
}

/// One stage of a [`Lane`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stage {
    /// What the stage looks like.
    pub look: Look,
    /// The stage's name.
    pub name: String,
    /// A few words more, such as its type or unit; may be empty.
    pub detail: String,
}

/// What a [`Stage`] looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Look {
    /// A signal that comes in or goes out.
    Signal,
    /// A component.
    Box,
    /// A component that several paths share.
    Shared,
    /// A component that does not act.
    Off,
}

impl Diagram {
    /// A diagram without paths.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), lanes: Vec::new() }
    }

    /// Appends a path.
    #[must_use]
    pub fn lane(mut self, lane: Lane) -> Self {
        self.lanes.push(lane);
        self
    }
}

impl Lane {
    /// A path without stages.
    pub fn new(label: impl Into<String>) -> Self {
        Self { label: label.into(), stages: Vec::new() }
    }

    /// Appends a stage.
    #[must_use]
    pub fn stage(mut self, look: Look, name: impl Into<String>, detail: impl Into<String>) -> Self {
        self.stages.push(Stage { look, name: name.into(), detail: detail.into() });
        self
    }
}
