//! `gcs://IP:PORT`: an instrument of PI that speaks the General Command Set 2.0, over TCP.
//!
//! One exchange is one write and its answers: `MOV axis target …` (or `SVA`, open loop), `POS?`, `ERR?`.
//! What is no answer, comes half, late or not at all, is a lost sample; the line is then closed and
//! opened anew, and the instrument is asked again who it is and whether its servo still is as it was:
//! the answers of one connection stand in the order of its questions, so nothing old is ever taken for
//! new. GCS has no checksum and no heartbeat: an instrument whose cable is cut stays at its last target.
//!
//! Syntax: PI, E-727 user manual E727T0005, "GCS Syntax for Syntax Version 2.0".

mod text;

use std::time::Duration;

pub use text::{error_text, numbers};

use super::device::{Device, Exchanged};
use super::line::{Broken, Line, Options};

/// The port of PI's controllers.
pub const PORT: u16 = 50_000;
/// Longest answer that is believed, bytes.
const LONGEST: usize = 16_384;
/// Longest wait for an answer while it is opened.
const PATIENCE: Duration = Duration::from_secs(3);

/// An instrument behind a line.
#[derive(Debug)]
pub struct GcsDevice {
    line: Box<dyn Line>,
    options: Options,
    identity: String,
    travel: Vec<(f64, f64)>,
    /// Answers that were read beyond the one that was asked for.
    rest: Vec<u8>,
    is_open: bool,
    /// It has been driven: its servo must stay as it was set.
    drives: bool,
    restarted: bool,
}

impl GcsDevice {
    /// Asks an instrument who it is, which axes it has and how far they go. `safe`: commands of the
    /// safe state, one for each axis.
    ///
    /// # Errors
    /// The line does not open, the answers are none, there are too few axes, or a safe command lies
    /// beyond an axis' travel.
    pub fn open(line: Box<dyn Line>, options: Options, safe: &[f64]) -> Result<Self, String> {
        let (identity, travel, rest) = (String::new(), Vec::new(), Vec::new());
        let mut device = GcsDevice {
            line,
            options,
            identity,
            travel,
            rest,
            is_open: false,
            drives: false,
            restarted: false,
        };
        device.line.open(PATIENCE)?;
        device.is_open = true;
        device.first(safe).map_err(|broken| match broken {
            Broken::Said(text) => text,
            other => format!("it does not answer in GCS 2.0: {other}"),
        })?;
        Ok(device)
    }

    fn first(&mut self, safe: &[f64]) -> Result<(), Broken> {
        self.identity = self.ask("*IDN?", PATIENCE)?.trim().to_owned();
        // What was wrong before is not this run's.
        self.ask("ERR?", PATIENCE)?;
        let all = self.ask("SAI?", PATIENCE)?;
        let has: Vec<&str> = all.split_whitespace().collect();
        if self.options.axes.is_empty() {
            self.options.axes =
                has.iter().take(safe.len()).map(|axis| (*axis).to_owned()).collect();
        }
        let known = self.options.axes.iter().all(|axis| has.contains(&axis.as_str()));
        if !known || self.options.axes.len() != safe.len() {
            return Err(Broken::Said(format!(
                "{}: has the axes {}, the run {} channels on {}; choose with ?axes=1,2",
                self.identity,
                has.join(", "),
                safe.len(),
                self.options.axes.join(", ")
            )));
        }
        let names = self.options.axes.join(" ");
        let least = self.ask_numbers(&format!("TMN? {names}"))?;
        let greatest = self.ask_numbers(&format!("TMX? {names}"))?;
        self.travel = least.into_iter().zip(greatest).collect();
        let axes = self.options.axes.iter().zip(&self.travel).zip(safe);
        for ((axis, (least, greatest)), safe) in axes {
            if !self.options.open_loop && !(*least..=*greatest).contains(safe) {
                return Err(Broken::Said(format!(
                    "axis {axis} has a travel from {least} to {greatest}; the safe command {safe} of the plan is outside it: give safe and command_limits in [[axis]], in the instrument's unit"
                )));
            }
        }
        self.ask_numbers(&format!("POS? {names}"))?;
        self.check("asked")
    }

    /// Opens the line again; the instrument must be the one it was, with its servo as it was.
    fn again(&mut self) -> Result<(), Broken> {
        self.rest.clear();
        self.line.open(self.options.timeout).map_err(|_| Broken::Late)?;
        self.is_open = true;
        let identity = self.ask("*IDN?", self.options.timeout)?;
        if identity.trim() != self.identity {
            let text =
                format!("another instrument answers: {}, not {}", identity.trim(), self.identity);
            return Err(Broken::Said(text));
        }
        if self.drives {
            let names = self.options.axes.join(" ");
            let servo = self.ask_numbers(&format!("SVO? {names}"))?;
            let wanted = if self.options.open_loop { 0.0 } else { 1.0 };
            if let Some(axis) = servo.iter().position(|servo| *servo != wanted) {
                self.restarted = true;
                let state = if servo[axis] == 0.0 { "off" } else { "on" };
                let name = &self.options.axes[axis];
                return Err(Broken::Said(format!(
                    "the instrument has restarted, or somebody else works with it: the servo of axis \
                     {name} is {state}"
                )));
            }
        }
        Ok(())
    }

    fn write(&mut self, text: &str) -> Result<(), Broken> {
        self.line.write(text.as_bytes()).map_err(|_| Broken::Late)
    }

    /// The answer to one question: up to a line feed without a blank before it.
    fn answer(&mut self, timeout: Duration) -> Result<String, Broken> {
        loop {
            if let Some(end) = text::end(&self.rest) {
                let answer: Vec<u8> = self.rest.drain(..end).collect();
                return String::from_utf8(answer).map_err(|_| Broken::Garbage("bytes".to_owned()));
            }
            if self.rest.len() > LONGEST {
                return Err(Broken::Garbage(format!("{LONGEST} bytes without an end")));
            }
            let mut bytes = [0; 1024];
            match self.line.read(&mut bytes, timeout) {
                Ok(0) | Err(_) => return Err(Broken::Late),
                Ok(length) => self.rest.extend(&bytes[..length]),
            }
        }
    }

    fn ask(&mut self, question: &str, timeout: Duration) -> Result<String, Broken> {
        self.write(&format!("{question}\n"))?;
        self.answer(timeout)
    }

    fn ask_numbers(&mut self, question: &str) -> Result<Vec<f64>, Broken> {
        let timeout = if self.travel.is_empty() { PATIENCE } else { self.options.timeout };
        let answer = self.ask(question, timeout)?;
        numbers(&answer, &self.options.axes)
    }

    /// Asks for the error.
    fn check(&mut self, what: &str) -> Result<(), Broken> {
        let answer = self.ask("ERR?", self.options.timeout)?;
        text::error_of(&answer, what)
    }

    fn words(&self, command: &str, values: &[f64]) -> String {
        let pairs = self.options.axes.iter().zip(values);
        pairs.fold(command.to_owned(), |text, (axis, value)| format!("{text} {axis} {value:.6}"))
    }

    fn turn(
        &mut self,
        enabled: bool,
        commands: &[f64],
        positions: &mut [f64],
    ) -> Result<(), Broken> {
        if !self.is_open {
            self.again()?;
        }
        if enabled && !self.drives {
            let servo = if self.options.open_loop { 0 } else { 1 };
            let all = self.options.axes.iter();
            let text = all.fold("SVO".to_owned(), |text, axis| format!("{text} {axis} {servo}"));
            self.write(&format!("{text}\n"))?;
            self.check(&text)?;
            self.drives = true;
        }
        let names = self.options.axes.join(" ");
        let moves = match (self.drives, self.options.open_loop) {
            (false, _) => String::new(),
            (true, false) => self.words("MOV", commands) + "\n",
            (true, true) => self.words("SVA", commands) + "\n",
        };
        self.write(&format!("{moves}POS? {names}\nERR?\n"))?;
        let answer = self.answer(self.options.timeout)?;
        let found = numbers(&answer, &self.options.axes)?;
        let answer = self.answer(self.options.timeout)?;
        text::error_of(&answer, moves.trim())?;
        // One exchange, two answers: what is left over answers nothing that was asked.
        if !self.rest.is_empty() {
            return Err(Broken::Garbage("more than was asked for".to_owned()));
        }
        positions.copy_from_slice(&found);
        Ok(())
    }
}

impl Device for GcsDevice {
    fn exchange(&mut self, enabled: bool, commands: &[f64], positions: &mut [f64]) -> Exchanged {
        if self.restarted {
            return Exchanged::Failed("the instrument has restarted".to_owned());
        }
        match self.turn(enabled, commands, positions) {
            Ok(()) => Exchanged::Sample { valid: true, powered: true },
            // The instrument speaks, and says no: the line is good.
            Err(Broken::Said(text)) => Exchanged::Failed(text),
            Err(Broken::Late | Broken::Garbage(_)) => {
                self.close();
                Exchanged::Nothing
            }
        }
    }

    fn describe(&mut self) -> Option<String> {
        let axes = self.options.axes.iter().zip(&self.travel);
        let axes: Vec<String> =
            axes.map(|(axis, (least, most))| format!("{axis} from {least} to {most}")).collect();
        let mode = if self.options.open_loop { "SVA, open loop" } else { "MOV, servo on" };
        Some(format!("{}; {mode}; axes {}", self.identity, axes.join(", ")))
    }

    fn close(&mut self) {
        self.line.close();
        self.is_open = false;
    }
}
