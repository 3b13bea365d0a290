//! `setmess://IP`, `setmess:///dev/ttyUSB0`: a piezo amplifier with a sensor that knows two requests, over TCP or a
//! serial line.
//!
//! `set,VOLTS` is answered by the same line, `mess` by `mess,POSITION`, what it refuses by `error,TEXT`; a carriage
//! return ends each. One exchange is `set` and `mess`; before the first command with ENABLE it is `mess` alone. What is
//! no answer, comes half, late, doubled or not at all, is a lost sample; the line is then closed and opened anew. There
//! is no checksum and no heartbeat: an amplifier whose cable is cut stays at its last voltage.

use std::time::Duration;

use super::device::{Device, Exchanged};
use super::line::{Broken, Line, Options};
use super::protocol::Protocol;

/// How it is addressed and opened.
pub(super) static PROTOCOL: Protocol = Protocol {
    scheme: "setmess",
    port: 10_001,
    end: b"\r",
    example: "setmess://IP?timeout=5e-3",
    device: |line, options, safe| Ok(Box::new(SetMess::open(line, &options, safe)?)),
    station: None,
};

/// Longest answer that is believed, bytes.
const LONGEST: usize = 256;
/// Longest wait for the line while it is opened first.
const PATIENCE: Duration = Duration::from_secs(3);
/// A voltage is sent with so many digits.
const SAME: f64 = 1e-6;

/// An amplifier behind a line.
#[derive(Debug)]
pub struct SetMess {
    line: Box<dyn Line>,
    timeout: Duration,
    rest: Vec<u8>,
    is_open: bool,
    is_driven: bool,
    first: f64,
}

impl SetMess {
    /// Asks an amplifier where it is. `safe`: the command of the safe state.
    ///
    /// # Errors
    /// The run has not one axis, the options name axes or signals, the line does not open, or the answer is none.
    pub fn open(mut line: Box<dyn Line>, options: &Options, safe: &[f64]) -> Result<Self, String> {
        if safe.len() != 1 || options.axes.len() + options.analog.len() > 0 {
            let axes = safe.len();
            return Err(format!(
                "it has one axis and one sensor (the run {axes}); axes= and analog= are not for it"
            ));
        }
        line.open(PATIENCE)?;
        let (timeout, rest) = (options.timeout, Vec::new());
        let mut device =
            SetMess { line, timeout, rest, is_open: true, is_driven: false, first: 0.0 };
        let first = device.ask("mess");
        device.first = first.map_err(|broken| format!("it does not answer mess: {broken}"))?;
        Ok(device)
    }

    /// The number behind the name in the answer to a request.
    fn ask(&mut self, request: &str) -> Result<f64, Broken> {
        self.line.write(format!("{request}\r").as_bytes()).map_err(|_| Broken::Late)?;
        let end = loop {
            if let Some(end) = self.rest.iter().position(|byte| *byte == b'\r') {
                break end;
            }
            if self.rest.len() > LONGEST {
                return Err(Broken::Garbage(format!("{LONGEST} bytes without an end")));
            }
            let mut bytes = [0; LONGEST];
            match self.line.read(&mut bytes, self.timeout) {
                Ok(0) | Err(_) => return Err(Broken::Late),
                Ok(length) => self.rest.extend(&bytes[..length]),
            }
        };
        let answer: Vec<u8> = self.rest.drain(..=end).collect();
        let answer = String::from_utf8_lossy(&answer);
        let garbage = || Broken::Garbage(format!("{answer:?} where {request} was asked"));
        let (name, value) = answer.trim().split_once(',').ok_or_else(garbage)?;
        if name == "error" {
            return Err(Broken::Refused(format!("{request}: {value}")));
        }
        let is_asked = request.split(',').next() == Some(name);
        let number = value.parse::<f64>().ok().filter(|number| is_asked && number.is_finite());
        number.ok_or_else(garbage)
    }

    fn turn(&mut self, enabled: bool, command: f64) -> Result<f64, Broken> {
        if !self.is_open {
            self.rest.clear();
            self.line.open(self.timeout).map_err(|_| Broken::Late)?;
            self.is_open = true;
        }
        self.is_driven |= enabled;
        if self.is_driven {
            let acts = self.ask(&format!("set,{command:.6}"))?;
            if (acts - command).abs() > SAME {
                return Err(Broken::Garbage(format!("{acts} V where {command} V were set")));
            }
        }
        let position = self.ask("mess")?;
        // One request, one answer.
        if self.rest.is_empty() {
            Ok(position)
        } else {
            Err(Broken::Garbage("more than was asked for".to_owned()))
        }
    }
}

impl Device for SetMess {
    fn exchange(&mut self, enabled: bool, commands: &[f64], positions: &mut [f64]) -> Exchanged {
        match self.turn(enabled, commands[0]) {
            Ok(position) => {
                positions[0] = position;
                Exchanged::Sample { valid: true, powered: true }
            }
            Err(Broken::Refused(text)) => Exchanged::Failed(text),
            Err(Broken::Late | Broken::Garbage(_)) => {
                self.close();
                Exchanged::Nothing
            }
        }
    }

    fn describe(&mut self) -> Option<String> {
        Some(format!("amplifier with set and mess, at {}", self.first))
    }

    fn close(&mut self) {
        self.line.close();
        self.is_open = false;
    }
}
