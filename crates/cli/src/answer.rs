//! What a command answers, and how it reaches the screen. Only this file prints.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

#[cfg(unix)]
use anyhow::Context;
use serde::Serialize;

/// The result of a command: data for machines, sentences for people.
pub trait Answer: Serialize {
    /// Writes the result for a person.
    fn write(&self, out: &mut dyn Write) -> io::Result<()>;

    /// Exit code: 0 as asked, 1 where the answer is a no.
    fn exit_code(&self) -> u8 {
        0
    }
}

/// Stands for the standard output where `--json` takes a file.
pub const STANDARD_OUTPUT: &str = "-";

/// The standard output, once it is kept for the answer.
static KEPT: OnceLock<File> = OnceLock::new();

/// From now on only the answer goes to standard output. What FMUs print, which would make JSON
/// unreadable, goes to standard error.
#[cfg(unix)]
pub fn keep_standard_output() -> anyhow::Result<()> {
    let kept = fmi_bindings::import::keep_standard_output()
        .context("the standard output cannot be kept for the answer")?;
    KEPT.get_or_init(|| kept);
    Ok(())
}

/// Elsewhere what FMUs print stands beside the answer.
#[cfg(not(unix))]
pub fn keep_standard_output() -> anyhow::Result<()> {
    Ok(())
}

/// The standard output as answers reach it.
pub fn standard_output() -> Box<dyn Write> {
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
pub fn note_on_log(on_log: &[String]) {
    let mut notes = notes();
    for note in on_log {
        if notes.all.contains(note) {
            continue;
        }
        if !notes.is_quiet {
            let _ = writeln!(io::stderr(), "note: {}", harmless(note));
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

/// The files that a call which fails has written, and those that it was to write and has not. Temporary ones
/// are nobody's affair.
fn files_of_the_call() -> (Vec<String>, Vec<String>) {
    let temporary = tempfile::env::temp_dir();
    let is_kept = |(file, _): &(PathBuf, bool)| !file.starts_with(&temporary);
    let (written, missing): (Vec<_>, Vec<_>) =
        files::wanted().into_iter().filter(is_kept).partition(|(_, is_written)| *is_written);
    let names = |files: Vec<(PathBuf, bool)>| {
        files.into_iter().map(|(file, _)| file.display().to_string()).collect()
    };
    (names(written), names(missing))
}

/// What an error says, from what was to be done to the cause: each text once.
pub fn sentence(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |message, cause| {
        if message.is_empty() || cause.contains(&message) {
            cause
        } else if message.contains(&cause) {
            message
        } else {
            format!("{message}: {cause}")
        }
    })
}

/// A number for the screen, rounded to nine significant digits.
pub fn rounded(x: f64) -> f64 {
    format!("{x:.8e}").parse().unwrap_or(x)
}

/// The file beside an absent one that was probably meant.
fn meant(absent: &Path, message: &str) -> Option<PathBuf> {
    let is_it = message.to_lowercase().contains("no such file")
        && message.contains(&*absent.to_string_lossy())
        && !absent.exists();
    let folder = match absent.parent()? {
        here if here.as_os_str().is_empty() => Path::new("."),
        folder => folder,
    };
    let name = absent.file_name()?.to_string_lossy().into_owned();
    let there = if is_it { std::fs::read_dir(folder).ok()? } else { return None };
    let there: Vec<String> =
        there.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    let ending = absent.extension();
    let is_alike = |name: &&str| Path::new(name).extension() == ending;
    let near = data::nearest(&name, there.iter().map(String::as_str).filter(is_alike))?;
    Some(absent.with_file_name(near))
}

/// A text whose control characters are written out: what comes from files and FMUs moves no cursor,
/// changes no colour and no title of a terminal.
fn harmless(text: &str) -> Cow<'_, str> {
    let is_control = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(is_control) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match is_control(c) {
            // As JSON has it too, where they stand in a text only.
            true => shown.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => shown.push(c),
        }
    }
    Cow::Owned(shown)
}

/// How results are shown.
#[derive(Clone, Copy, Debug)]
pub struct Screen {
    /// As JSON.
    pub json: bool,
    /// Not at all.
    pub quiet: bool,
}

impl Screen {
    /// How results are shown from now on.
    pub fn new(json: bool, quiet: bool) -> Self {
        notes().is_quiet = quiet;
        Self { json, quiet }
    }

    /// Shows an answer and returns its exit code. A closed pipe is no error: the reader has enough.
    pub fn show(&self, answer: &dyn ErasedAnswer) -> anyhow::Result<u8> {
        let mut message = Vec::new();
        if self.json {
            writeln!(message, "{}", answer.json()?)?;
        } else if !self.quiet {
            answer.write(&mut message)?;
        }
        let mut out = standard_output();
        let written = out.write_all(harmless(&String::from_utf8_lossy(&message)).as_bytes());
        match written.and_then(|()| out.flush()) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(answer.exit_code()),
            Err(error) => Err(error.into()),
            Ok(()) => Ok(answer.exit_code()),
        }
    }

    /// A line for a person while a command works.
    pub fn say(&self, line: &str) {
        if !self.json && !self.quiet {
            let _ = writeln!(io::stdout(), "{}", harmless(line));
        }
    }

    /// Shows an error on standard error; `named` are the files of the call.
    pub fn error(&self, error: &anyhow::Error, named: &[PathBuf]) {
        let mut message = sentence(error);
        if let Some(way_out) = way_out(error) {
            message = format!("{message}; {way_out}");
        }
        if let Some(meant) = named.iter().find_map(|path| meant(path, &message)) {
            message = format!("{message}; did you mean {}?", meant.display());
        }
        let error = harmless(&message);
        let (written, missing) = files_of_the_call();
        let _ = if self.json {
            let mut described = serde_json::json!({ "error": error });
            if !written.is_empty() {
                described["written"] = written.into();
                described["not_written"] = missing.into();
            }
            writeln!(io::stderr(), "{described}")
        } else {
            let mut described = format!("error: {error}");
            if !written.is_empty() {
                described += &format!("\n  written before: {}", harmless(&written.join(", ")));
                if !missing.is_empty() {
                    described += &format!("; not written: {}", harmless(&missing.join(", ")));
                }
            }
            writeln!(io::stderr(), "{described}")
        };
    }
}

/// [`Answer`] without its type.
pub trait ErasedAnswer {
    /// The answer as JSON, with the notes on the logs that were read.
    ///
    /// # Errors
    /// Where a value cannot be written as JSON.
    fn json(&self) -> serde_json::Result<String>;
    /// See [`Answer::write`].
    ///
    /// # Errors
    /// Where `out` cannot be written to.
    fn write(&self, out: &mut dyn Write) -> io::Result<()>;
    /// See [`Answer::exit_code`].
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
