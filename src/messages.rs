//! What FMUs say: each message once with its count, and all of them in a file.

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::Context;
use clap::Args;
use cosim::{HOST, InstanceOptions, Message, Status};
use serde::Serialize;

/// Different messages that are kept; of the others it is said how many there were.
const KINDS: usize = 100;

/// Which messages of FMUs are shown or written.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct MessageOptions {
    /// Lowest severity of FMU messages that are shown; `info` switches the FMUs' logging on
    #[arg(long, value_name = "LEVEL", default_value = "warning")]
    log_level: Level,
    /// Write every message of the FMUs to this file as it arrives, one per line (status, FMU, category and text,
    /// separated by tabs); switches the FMUs' logging on
    #[arg(long, value_name = "FILE")]
    fmu_log: Option<PathBuf>,
}

/// How severe a message must be to be shown.
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    /// None is shown
    None,
    /// Discarded steps, errors
    Error,
    /// Warnings too
    #[default]
    Warning,
    /// All
    Info,
}

impl Level {
    fn of(status: Status) -> Self {
        match status {
            Status::Ok | Status::Pending => Level::Info,
            Status::Warning => Level::Warning,
            Status::Discard | Status::Error | Status::Fatal | Status::Unknown(_) => Level::Error,
        }
    }
}

impl MessageOptions {
    /// Begins to listen.
    pub(crate) fn ear(&self) -> anyhow::Result<NoteCollector> {
        let file = match &self.fmu_log {
            Some(path) => {
                // Not all at the end: it is read where a run has crashed, too.
                let file = files::in_place(path);
                Some(file.with_context(|| format!("{} cannot be written", path.display()))?)
            }
            None => None,
        };
        let logging_on = self.log_level == Level::Info || file.is_some();
        Ok(NoteCollector {
            heard: Arc::new(Mutex::new(Heard { file, ..Heard::default() })),
            level: self.log_level,
            logging_on,
        })
    }
}

/// Hears what FMUs say and what they change of the program that runs them.
#[derive(Clone)]
pub(crate) struct NoteCollector {
    heard: Arc<Mutex<Heard>>,
    level: Level,
    logging_on: bool,
}

#[derive(Default)]
struct Heard {
    received: Vec<FmuMessage>,
    /// Messages of further kinds.
    more: usize,
    file: Option<File>,
    /// Why the file is not complete.
    unwritten: Option<String>,
}

/// A message of an FMU.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FmuMessage {
    fmu: String,
    status: String,
    category: String,
    /// The first of those that differ in numbers only.
    text: String,
    count: usize,
    /// Whether the others have other numbers.
    numbers_differ: bool,
    #[serde(skip)]
    pattern: String,
}

impl NoteCollector {
    /// For an instance of this name.
    pub(crate) fn options(&self, fmu: &str) -> InstanceOptions {
        let (heard, fmu, level) = (Arc::clone(&self.heard), fmu.to_owned(), self.level);
        let hear = move |message: &Message| {
            let mut heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
            heard.write(&fmu, message);
            if message.category == HOST || Level::of(message.status) <= level {
                heard.keep(&fmu, message);
            }
        };
        let logging_on = self.logging_on;
        InstanceOptions {
            on_message: Some(Arc::new(hear)),
            logging_on,
            ..InstanceOptions::default()
        }
    }

    fn heard(&self) -> MutexGuard<'_, Heard> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What was said so far, in the order of the first of each kind; ask when the FMUs are gone.
    pub(crate) fn received(&self) -> Vec<FmuMessage> {
        self.heard().received.clone()
    }

    /// The messages so far as sentences.
    pub(crate) fn notes(&self) -> Vec<String> {
        let heard = self.heard();
        let mut notes: Vec<String> = heard.received.iter().map(FmuMessage::sentence).collect();
        if heard.more > 0 {
            notes.push(format!(
                "the FMUs sent {} more messages of other kinds; --fmu-log FILE writes them all",
                heard.more
            ));
        }
        notes.extend(heard.unwritten.clone());
        notes
    }
}

impl Heard {
    fn write(&mut self, fmu: &str, message: &Message) {
        let Some(file) = &mut self.file else { return };
        let Message { status, category, text } = message;
        let line = format!("{status}\t{fmu}\t{category}\t{}\n", text.replace('\n', "\\n"));
        if let Err(error) = file.write_all(line.as_bytes()) {
            self.unwritten = Some(format!("the file of --fmu-log is not complete: {error}"));
            self.file = None;
        }
    }

    fn keep(&mut self, fmu: &str, message: &Message) {
        let pattern = pattern(&message.text);
        let status = message.status.to_string();
        let room = self.received.len() < KINDS;
        let known = self.received.iter_mut().find(|received| {
            received.fmu == fmu
                && received.status == status
                && received.category == message.category
                && received.pattern == pattern
        });
        match known {
            Some(received) => {
                received.count += 1;
                received.numbers_differ |= received.text != message.text;
            }
            None if room => self.received.push(FmuMessage {
                fmu: fmu.to_owned(),
                status,
                category: message.category.clone(),
                text: message.text.clone(),
                count: 1,
                numbers_differ: false,
                pattern,
            }),
            None => self.more += 1,
        }
    }
}

impl FmuMessage {
    fn sentence(&self) -> String {
        let FmuMessage { fmu, status, category, text, count, .. } = self;
        let count = match count {
            1 => String::new(),
            _ if self.numbers_differ => format!(" ({count} times, with other numbers)"),
            _ => format!(" ({count} times)"),
        };
        match category.as_str() {
            HOST => format!("FMU `{fmu}`: {text}{count}"),
            "" => format!("FMU `{fmu}` says [{status}]: {text}{count}"),
            _ => format!("FMU `{fmu}` says [{status}, {category}]: {text}{count}"),
        }
    }
}

/// A text without its numbers.
fn pattern(text: &str) -> String {
    let mut pattern = String::with_capacity(text.len());
    let mut in_number = false;
    for c in text.chars() {
        // A sign, a point or an exponent within a number is one of its characters.
        let goes_on = in_number && matches!(c, '.' | 'e' | 'E' | '+' | '-');
        if !c.is_ascii_digit() && !goes_on {
            pattern.push(c);
        } else if !in_number {
            pattern.push('0');
        }
        in_number = c.is_ascii_digit() || goes_on;
    }
    pattern
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(status: Status, text: &str) -> Message {
        Message { status, category: String::new(), text: text.to_owned() }
    }

    #[test]
    fn each_kind_is_reported_once_with_its_count() {
        let mut heard = Heard::default();
        for k in 0..100 {
            heard.keep(
                "a",
                &message(Status::Warning, &format!("at {}e-3 s it slips", 0.5 * f64::from(k))),
            );
            heard.keep("a", &message(Status::Warning, "the same"));
        }
        heard.keep("b", &message(Status::Error, "the same"));
        let described: Vec<String> = heard.received.iter().map(FmuMessage::sentence).collect();
        assert_eq!(
            described,
            [
                "FMU `a` says [Warning]: at 0e-3 s it slips (100 times, with other numbers)",
                "FMU `a` says [Warning]: the same (100 times)",
                "FMU `b` says [Error]: the same"
            ]
        );
    }

    #[test]
    fn an_fmu_that_never_stops_costs_no_memory() {
        let mut heard = Heard::default();
        let word = |k: u32| {
            (0..8).map(|i| char::from(b'a' + (k >> (2 * i) & 3) as u8)).collect::<String>()
        };
        (0..5000).for_each(|k| heard.keep("a", &message(Status::Warning, &word(k))));
        assert_eq!((heard.received.len(), heard.more), (KINDS, 5000 - KINDS));
    }
}
