//! Questions and answers of GCS 2.0 over a line.

use std::time::Duration;

use super::text;
use crate::gateway::line::{Broken, Line};

/// Longest answer that is believed, bytes.
const LONGEST: usize = 16_384;
/// Longest array that is believed, bytes.
const LONGEST_ARRAY: usize = 64 << 20;

/// A line, and what was read beyond the answer that was asked for.
#[derive(Debug)]
pub(super) struct Speech {
    line: Box<dyn Line>,
    pub(super) rest: Vec<u8>,
}

impl Speech {
    pub(super) fn new(line: Box<dyn Line>) -> Self {
        Speech { line, rest: Vec::new() }
    }

    pub(super) fn open(&mut self, timeout: Duration) -> Result<(), String> {
        self.rest.clear();
        self.line.open(timeout)
    }

    pub(super) fn close(&mut self) {
        self.line.close();
    }

    pub(super) fn write(&mut self, text: &str) -> Result<(), Broken> {
        self.line.write(text.as_bytes()).map_err(|_| Broken::Late)
    }

    /// The answer to one question: up to a line feed without a blank before it.
    pub(super) fn answer(&mut self, timeout: Duration) -> Result<String, Broken> {
        self.up_to(timeout, LONGEST)
    }

    fn up_to(&mut self, timeout: Duration, most: usize) -> Result<String, Broken> {
        let mut seen = 0;
        loop {
            // A line feed that came first needs the byte before it.
            let from = usize::saturating_sub(seen, 1);
            if let Some(end) = text::end(&self.rest, from) {
                let answer: Vec<u8> = self.rest.drain(..end).collect();
                return String::from_utf8(answer).map_err(|_| Broken::Garbage("bytes".to_owned()));
            }
            seen = self.rest.len();
            if seen > most {
                return Err(Broken::Garbage(format!("{most} bytes without an end")));
            }
            let mut bytes = [0; 8192];
            match self.line.read(&mut bytes, timeout) {
                Ok(0) | Err(_) => return Err(Broken::Late),
                Ok(length) => self.rest.extend(&bytes[..length]),
            }
        }
    }

    pub(super) fn ask(&mut self, question: &str, timeout: Duration) -> Result<String, Broken> {
        self.write(&format!("{question}\n"))?;
        self.answer(timeout)
    }

    /// Asks for the error of what was sent.
    pub(super) fn check(&mut self, what: &str, timeout: Duration) -> Result<(), Broken> {
        let answer = self.ask("ERR?", timeout)?;
        text::error_of(&answer, what)
    }

    /// What became of a question that was not answered in time: its answer after all, or why there is none. Where two
    /// answers come to the question for the error, the first is the late one.
    pub(super) fn late(&mut self, question: &str, timeout: Duration) -> Result<String, Broken> {
        let first = self.ask("ERR?", timeout)?;
        match self.answer(timeout) {
            Ok(error) => text::error_of(&error, question).map(|()| first),
            Err(Broken::Late) => text::error_of(&first, question).and(Err(Broken::Late)),
            Err(other) => Err(other),
        }
    }

    /// Drops answers that come too late, until the instrument says who it is, which it does once they are all there.
    pub(super) fn settle(
        &mut self,
        identity: &str,
        timeout: Duration,
        patience: Duration,
    ) -> Result<(), Broken> {
        self.write("*IDN?\n")?;
        let tries = (patience.as_secs_f64() / timeout.as_secs_f64()).ceil() as usize;
        let is_there =
            (0..tries).any(|_| self.answer(timeout).is_ok_and(|answer| answer.trim() == identity));
        if is_there { Ok(()) } else { Err(Broken::Late) }
    }

    /// A command: no answer but that of the question for its error.
    pub(super) fn command(&mut self, command: &str, timeout: Duration) -> Result<(), Broken> {
        self.write(&format!("{command}\n"))?;
        self.check(command, timeout)
    }

    /// An array: its sample time in s, and its columns.
    pub(super) fn array(
        &mut self,
        question: &str,
        timeout: Duration,
    ) -> Result<(f64, Vec<Vec<f64>>), Broken> {
        self.write(&format!("{question}\n"))?;
        let answer = match self.up_to(timeout, LONGEST_ARRAY) {
            // No array: the instrument may say why.
            Err(Broken::Late) => {
                return Err(self.check(question, timeout).err().unwrap_or(Broken::Late));
            }
            answer => answer?,
        };
        text::array(&answer).ok_or_else(|| {
            let start: String = answer.chars().take(80).collect();
            Broken::Garbage(format!("{start:?} where {question} was asked for"))
        })
    }
}
