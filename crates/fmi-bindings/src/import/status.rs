//! What a call returned.

use std::fmt;

use crate::fmi2::fmi2Status;
use crate::fmi3::fmi3Status;

/// Result of a call to an FMU, of FMI 2.0 and 3.0 alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All well.
    Ok,
    /// Things are not quite right, the computation may go on.
    Warning,
    /// The call was not carried out, or only in part; the instance is still usable.
    Discard,
    /// The instance can only be reset or freed.
    Error,
    /// All instances of this FMU are corrupted; none may be called again.
    Fatal,
    /// The step runs asynchronously.
    Pending,
    /// A number the standard does not know.
    Unknown(u32),
}

impl From<fmi2Status> for Status {
    fn from(status: fmi2Status) -> Self {
        match status.0 {
            0 => Status::Ok,
            1 => Status::Warning,
            2 => Status::Discard,
            3 => Status::Error,
            4 => Status::Fatal,
            5 => Status::Pending,
            other => Status::Unknown(other),
        }
    }
}

/// The numbers of FMI 3.0 are those of 2.0, without *Pending*.
impl From<fmi3Status> for Status {
    fn from(status: fmi3Status) -> Self {
        match Status::from(fmi2Status(status.0)) {
            Status::Pending => Status::Unknown(status.0),
            known => known,
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Status::Ok => f.write_str("OK"),
            Status::Warning => f.write_str("Warning"),
            Status::Discard => f.write_str("Discard"),
            Status::Error => f.write_str("Error"),
            Status::Fatal => f.write_str("Fatal"),
            Status::Pending => f.write_str("Pending"),
            Status::Unknown(number) => write!(f, "{number} (not a status of the standard)"),
        }
    }
}
