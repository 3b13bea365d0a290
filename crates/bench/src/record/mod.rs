//! The record: rows from the ring buffer into a journal that survives a kill, and from the journal
//! into a log file.

mod convert;
mod journal;
mod read;
mod recorder;

pub use convert::{ConvertError, Converted, Format, convert};
pub use journal::{About, Journal, JournalError, JournalReader};
pub use read::{ReadError, Recording};
pub use recorder::{Latest, Recorded, Recorder, View};
