//! The versions of FMI.

/// Version of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub enum FmiVersion {
    /// FMI 2.0 (written as `2.0`).
    V2,
    /// FMI 3.0 (written as `3.0`).
    V3,
}

impl FmiVersion {
    /// The value of the attribute `fmiVersion`.
    pub fn text(self) -> &'static str {
        match self {
            FmiVersion::V2 => "2.0",
            FmiVersion::V3 => "3.0",
        }
    }
}
