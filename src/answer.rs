//! What a command answers, and how it reaches the screen. Only this file prints.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::io::{self, Write};

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

/// How results are shown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Screen {
    /// As JSON.
    pub(crate) json: bool,
    /// Not at all.
    pub(crate) quiet: bool,
}

impl Screen {
    /// Shows an answer and returns its exit code. A closed pipe is no error: the reader has enough.
    pub(crate) fn show(&self, answer: &dyn ErasedAnswer) -> anyhow::Result<u8> {
        let mut out = io::stdout().lock();
        let written = if self.json {
            writeln!(out, "{}", answer.json()?)
        } else if self.quiet {
            Ok(())
        } else {
            answer.write(&mut out)
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
        let _ = if self.json {
            let text = serde_json::json!({ "error": format!("{error:#}") });
            writeln!(io::stderr(), "{text}")
        } else {
            writeln!(io::stderr(), "error: {error:#}")
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
        serde_json::to_string_pretty(self)
    }
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        Answer::write(self, out)
    }
    fn exit_code(&self) -> u8 {
        Answer::exit_code(self)
    }
}
