//! `gcs://IP:PORT`, `gcs:///dev/ttyUSB0`: an instrument of PI that speaks the General Command Set 2.0, over TCP or a
//! serial line.
//!
//! One exchange is one write and its answers: `MOV axis target …` (or `SVA`, open loop), `POS?`, `ERR?`.
//! What is no answer, comes half, late or not at all, is a lost sample; the line is then closed and
//! opened anew, and the instrument is asked again who it is and whether its servo still is as it was:
//! the answers of one connection stand in the order of its questions, so nothing old is ever taken for
//! new. GCS has no checksum and no heartbeat: an instrument whose cable is cut stays at its last target.
//!
//! Syntax: PI, E-727 user manual E727T0005, "GCS Syntax for Syntax Version 2.0".

mod speech;
mod station;
mod text;

use std::time::Duration;

use speech::Speech;
pub use station::GcsStation;
pub use text::{error_text, numbers};

use super::device::{Device, Exchanged};
use super::line::{Broken, Line, Options};
use super::protocol::Protocol;

/// The port of PI's controllers.
pub const PORT: u16 = 50_000;
/// Ends a command.
pub const END: &[u8] = b"\n";

/// How it is addressed and opened.
pub(super) static PROTOCOL: Protocol = Protocol {
    scheme: "gcs",
    port: PORT,
    end: END,
    example: "gcs://IP?axes=1,2",
    device: |line, options, safe| Ok(Box::new(GcsDevice::open(line, options, safe)?)),
    station: Some(|line, options| Ok(Box::new(GcsStation::open(line, options)?))),
};

/// Longest wait for an answer while it is opened.
const PATIENCE: Duration = Duration::from_secs(3);

/// An instrument behind a line.
#[derive(Debug)]
pub struct GcsDevice {
    speech: Speech,
    options: Options,
    identity: String,
    travel: Vec<(f64, f64)>,
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
        let (identity, travel) = (String::new(), Vec::new());
        let mut device = GcsDevice {
            speech: Speech::new(line),
            options,
            identity,
            travel,
            is_open: false,
            drives: false,
            restarted: false,
        };
        device.speech.open(PATIENCE)?;
        device.is_open = true;
        device.first(safe).map_err(|broken| match broken {
            Broken::Refused(text) => text,
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
            return Err(Broken::Refused(format!(
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
                return Err(Broken::Refused(format!(
                    "axis {axis} has a travel from {least} to {greatest}; the safe command {safe} of the plan is outside it: give safe and command_limits in [[axis]], in the instrument's unit"
                )));
            }
        }
        let channels = self.options.analog.len();
        if channels > 0 && channels != safe.len() {
            return Err(Broken::Refused(format!(
                "analog= names {channels} input signals for {} axes; give one for each",
                safe.len()
            )));
        }
        self.positions()?;
        self.check("asked")
    }

    /// Opens the line again; the instrument must be the one it was, with its servo as it was.
    fn again(&mut self) -> Result<(), Broken> {
        self.speech.open(self.options.timeout).map_err(|_| Broken::Late)?;
        self.is_open = true;
        let identity = self.ask("*IDN?", self.options.timeout)?;
        if identity.trim() != self.identity {
            // It is asked again before it is driven.
            self.close();
            let text =
                format!("another instrument answers: {}, not {}", identity.trim(), self.identity);
            return Err(Broken::Refused(text));
        }
        if self.drives {
            let names = self.options.axes.join(" ");
            let servo = self.ask_numbers(&format!("SVO? {names}"))?;
            let wanted = if self.options.open_loop { 0.0 } else { 1.0 };
            if let Some(axis) = servo.iter().position(|servo| *servo != wanted) {
                self.restarted = true;
                let state = if servo[axis] == 0.0 { "off" } else { "on" };
                let name = &self.options.axes[axis];
                return Err(Broken::Refused(format!(
                    "the instrument has restarted, or somebody else works with it: the servo of axis \
                     {name} is {state}"
                )));
            }
        }
        Ok(())
    }

    fn write(&mut self, text: &str) -> Result<(), Broken> {
        self.speech.write(text)
    }

    fn ask(&mut self, question: &str, timeout: Duration) -> Result<String, Broken> {
        self.speech.ask(question, timeout)
    }

    /// What is asked for the positions, and the names in the answer.
    fn question(&self) -> (String, Vec<String>) {
        let (name, items) = match self.options.analog.is_empty() {
            true => ("POS?", &self.options.axes),
            false => ("TSP?", &self.options.analog),
        };
        (format!("{name} {}", items.join(" ")), items.clone())
    }

    fn positions(&mut self) -> Result<Vec<f64>, Broken> {
        let (question, items) = self.question();
        let answer = self.ask(&question, self.options.timeout.max(PATIENCE))?;
        if answer.trim().is_empty() {
            return Err(Broken::Garbage(format!("{answer:?} to {question}")));
        }
        numbers(&answer, &items)
    }

    fn ask_numbers(&mut self, question: &str) -> Result<Vec<f64>, Broken> {
        let timeout = if self.travel.is_empty() { PATIENCE } else { self.options.timeout };
        let answer = self.ask(question, timeout)?;
        numbers(&answer, &self.options.axes)
    }

    /// Asks for the error.
    fn check(&mut self, what: &str) -> Result<(), Broken> {
        self.speech.check(what, self.options.timeout)
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
        let (question, items) = self.question();
        let moves = match (self.drives, self.options.open_loop) {
            (false, _) => String::new(),
            (true, false) => self.words("MOV", commands) + "\n",
            (true, true) => self.words("SVA", commands) + "\n",
        };
        self.write(&format!("{moves}{question}\nERR?\n"))?;
        let answer = self.speech.answer(self.options.timeout)?;
        let found = numbers(&answer, &items)?;
        let answer = self.speech.answer(self.options.timeout)?;
        text::error_of(&answer, moves.trim())?;
        // One exchange, two answers: what is left over answers nothing that was asked.
        if !self.speech.rest.is_empty() {
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
            Err(Broken::Refused(text)) => Exchanged::Failed(text),
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
        let from = match self.options.analog.is_empty() {
            true => String::new(),
            false => {
                format!("; positions from the input signals {}", self.options.analog.join(", "))
            }
        };
        Some(format!("{}; {mode}; axes {}{from}", self.identity, axes.join(", ")))
    }

    fn close(&mut self) {
        self.speech.close();
        self.is_open = false;
    }
}
