//! What comes of a call: a status, and what the importer hears about it.

/// Result of a call; the numbers are those of the standards' statuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Status {
    Ok = 0,
    Warning = 1,
    Discard = 2,
    Error = 3,
}

/// A message about a call: an event, or why it was not simply carried out.
#[derive(Debug)]
pub(super) struct Notice {
    pub(super) status: Status,
    pub(super) message: String,
}

/// `Err` also where a call went well and has an event to tell; the status says which.
pub(super) type Outcome = Result<(), Notice>;

impl Notice {
    pub(super) fn error(message: impl Into<String>) -> Self {
        Self { status: Status::Error, message: message.into() }
    }

    pub(super) fn discard(message: impl Into<String>) -> Self {
        Self { status: Status::Discard, message: message.into() }
    }

    pub(super) fn warning(message: impl Into<String>) -> Self {
        Self { status: Status::Warning, message: message.into() }
    }
}
