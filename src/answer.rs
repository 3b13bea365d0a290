//! What a command answers, and how it reaches the screen. Only this file prints.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::fs::File;
use std::io::{self, Write};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

#[cfg(unix)]
use anyhow::Context;
use serde::Serialize;

/// The result of a command: data for machines, sentences for people.
pub(crate) trait Answer: Serialize {
    /// Writes the result for a person.
    fn write(&self, out: &mut dyn Write) -> io::Result<()>;

    /// Exit code: 0 as asked, 1 where the answer is a no.
    fn exit_code(&self) -> u8 {
        0
    }
}

/// Stands for the standard output where `--json` takes a file.
pub(crate) const STANDARD_OUTPUT: &str = "-";

/// The standard output, once it is kept for the answer.
static KEPT: OnceLock<File> = OnceLock::new();

/// From now on only the answer goes to standard output. What FMUs print, which would make JSON
/// unreadable, goes to standard error.
#[cfg(unix)]
pub(crate) fn keep_standard_output() -> anyhow::Result<()> {
    let kept = fmi_bindings::import::keep_standard_output()
        .context("the standard output cannot be kept for the answer")?;
    KEPT.get_or_init(|| kept);
    Ok(())
}

/// Elsewhere what FMUs print stands beside the answer.
#[cfg(not(unix))]
pub(crate) fn keep_standard_output() -> anyhow::Result<()> {
    Ok(())
}

/// The standard output as answers reach it.
pub(crate) fn standard_output() -> Box<dyn Write> {
    match KEPT.get() {
        Some(kept) => Box::new(kept),
        None => Box::new(io::stdout().lock()),
    }
}

/// What is said about the logs that were read.
#[derive(Debug)]
struct Notes {
    is_quiet: bool,
    all: Vec<String>,
}

static NOTES: Mutex<Notes> = Mutex::new(Notes { is_quiet: false, all: Vec::new() });

fn notes() -> MutexGuard<'static, Notes> {
    NOTES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Says what was assumed about a log, skipped or left out: at once on standard error, each sentence once,
/// and as `log_notes` in the answer's JSON.
pub(crate) fn note_on_log(said: &[String]) {
    let mut notes = notes();
    for note in said {
        if notes.all.contains(note) {
            continue;
        }
        if !notes.is_quiet {
            let _ = writeln!(io::stderr(), "note: {note}");
        }
        notes.all.push(note.clone());
    }
}

/// An answer with the notes on its logs.
#[derive(Serialize)]
struct Noted<'a, T> {
    #[serde(flatten)]
    answer: &'a T,
    log_notes: &'a [String],
}

/// The way out where a file cannot be written, for errors that only say why.
fn way_out(error: &anyhow::Error) -> Option<&'static str> {
    use io::ErrorKind::{PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    let kind = error.chain().find_map(|cause| Some(cause.downcast_ref::<io::Error>()?.kind()))?;
    match kind {
        StorageFull | QuotaExceeded => Some("free some space, or name a file on another disk"),
        ReadOnlyFilesystem => Some("name a file in a folder that can be written"),
        PermissionDenied => Some("name a file in a folder of yours, or change the permissions"),
        _ => None,
    }
}

/// How results are shown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Screen {
    /// As JSON.
    pub(crate) json: bool,
    /// Not at all.
    pub(crate) quiet: bool,
}

impl Screen {
    /// How results are shown from now on.
    pub(crate) fn new(json: bool, quiet: bool) -> Self {
        notes().is_quiet = quiet;
        Self { json, quiet }
    }

    /// Shows an answer and returns its exit code. A closed pipe is no error: the reader has enough.
    pub(crate) fn show(&self, answer: &dyn ErasedAnswer) -> anyhow::Result<u8> {
        let mut out = standard_output();
        let written = if self.json {
            writeln!(out, "{}", answer.json()?)
        } else if self.quiet {
            Ok(())
        } else {
            answer.write(&mut *out)
        };
        match written.and_then(|()| out.flush()) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(answer.exit_code()),
            Err(error) => Err(error.into()),
            Ok(()) => Ok(answer.exit_code()),
        }
    }

    /// A line for a person while a command works.
    pub(crate) fn say(&self, line: &str) {
        if !self.json && !self.quiet {
            let _ = writeln!(io::stdout(), "{line}");
        }
    }

    /// Shows an error on standard error.
    pub(crate) fn error(&self, error: &anyhow::Error) {
        let error = match way_out(error) {
            Some(way_out) => format!("{error:#}; {way_out}"),
            None => format!("{error:#}"),
        };
        let _ = if self.json {
            writeln!(io::stderr(), "{}", serde_json::json!({ "error": error }))
        } else {
            writeln!(io::stderr(), "error: {error}")
        };
    }
}

/// [`Answer`] without its type.
pub(crate) trait ErasedAnswer {
    fn json(&self) -> serde_json::Result<String>;
    fn write(&self, out: &mut dyn Write) -> io::Result<()>;
    fn exit_code(&self) -> u8;
}

impl<T: Answer> ErasedAnswer for T {
    fn json(&self) -> serde_json::Result<String> {
        let notes = notes();
        if notes.all.is_empty() {
            return serde_json::to_string_pretty(self);
        }
        let noted = Noted { answer: self, log_notes: &notes.all };
        // What is no table has no room for notes.
        serde_json::to_string_pretty(&noted).or_else(|_| serde_json::to_string_pretty(self))
    }
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        Answer::write(self, out)
    }
    fn exit_code(&self) -> u8 {
        Answer::exit_code(self)
    }
}
