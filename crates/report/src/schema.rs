//! The name of the report's JSON.

/// Name and version of the report's JSON.
pub const SCHEMA: &str = "piezoloop.report/1";
