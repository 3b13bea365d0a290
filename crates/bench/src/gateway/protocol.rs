//! What an instrument declares of how it is spoken to.

use std::fmt;

use super::device::Device;
use super::line::{self, Line};
use super::station::Station;

/// A device that is opened, and what hinders it.
pub type OpenedDevice = Result<Box<dyn Device>, String>;
/// Opens an instrument behind a line to work with its own wave generator and data recorder, or says what hinders it.
pub type OpenStation = fn(Box<dyn Line>, line::Options) -> Result<Box<dyn Station>, String>;

/// What an instrument speaks, as its own file declares it.
pub struct Protocol {
    /// What its addresses begin with, without `://`.
    pub scheme: &'static str,
    /// The TCP port where an address gives none.
    pub port: u16,
    /// What ends a command on the line.
    pub end: &'static [u8],
    /// An address with options, for messages.
    pub example: &'static str,
    /// Opens it behind a line; the last argument: the commands of the safe state, one for each channel.
    pub device: fn(Box<dyn Line>, line::Options, &[f64]) -> OpenedDevice,
    /// Opens it to work with its own wave generator and data recorder, if it has them.
    pub station: Option<OpenStation>,
}

impl fmt::Debug for Protocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.scheme)
    }
}

/// Each scheme is declared once.
impl PartialEq for Protocol {
    fn eq(&self, other: &Self) -> bool {
        self.scheme == other.scheme
    }
}

impl Eq for Protocol {}
