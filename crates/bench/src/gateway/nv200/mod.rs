//! `nv200://IP`, `nv200:///dev/ttyUSB0`: an NV200 of piezosystem jena, over the telnet port of its network module or its
//! serial line (USB).
//!
//! One exchange is `cl`, `set,TARGET`, `meas`, each with its answer up to XON. What is no answer, comes half,
//! late or not at all, is a lost sample; the line is then closed and opened anew, and the instrument is
//! asked again who it is, whether its loop is as it was and which target it has. The protocol has no
//! checksum and no heartbeat: an instrument whose cable is cut stays at its last target.
//!
//! Source: piezosystem jena, Python library nv200 1.6.0.

mod station;

use std::time::Duration;

pub use station::Nv200Station;

use super::device::{Device, Exchanged};
use super::line::{Broken, Line, Options};
use super::protocol::Protocol;

/// The port of the instrument's network module.
pub const PORT: u16 = 23;
/// Ends a command.
pub const END: &[u8] = b"\r";

/// How it is addressed and opened.
pub(super) static PROTOCOL: Protocol = Protocol {
    scheme: "nv200",
    port: PORT,
    end: END,
    example: "nv200://IP?mode=open",
    device: |line, options, safe| Ok(Box::new(Nv200Device::open(line, options, safe)?)),
    station: Some(|line, options| Ok(Box::new(Nv200Station::open(line, options)?))),
};

const XON: u8 = 0x11;
/// Telnet: the two bytes behind it are for the terminal.
const IAC: u8 = 0xff;
/// Longest answer that is believed, bytes.
const LONGEST: usize = 262_144;
/// Longest wait for an answer while it is opened.
const PATIENCE: Duration = Duration::from_secs(3);
/// An instrument tells its target to so many digits.
const SAME_TARGET: f64 = 2e-3;

/// An instrument behind a line.
#[derive(Debug)]
pub struct Nv200Device {
    line: Box<dyn Line>,
    options: Options,
    identity: String,
    about: String,
    rest: Vec<u8>,
    is_open: bool,
    /// The newest targets, once it is driven; of the last it is not known whether it arrived.
    sent: Option<[f64; 2]>,
    restarted: bool,
}

impl Nv200Device {
    /// Asks an instrument who it is and how far it goes. `safe`: the command of the safe state.
    ///
    /// # Errors
    /// The line does not open, the answers are none, the run has not one axis, or its safe command lies
    /// beyond the travel.
    pub fn open(line: Box<dyn Line>, options: Options, safe: &[f64]) -> Result<Self, String> {
        if safe.len() != 1 {
            return Err(format!("an NV200 has one axis, the run {}", safe.len()));
        }
        let mut device = Nv200Device::connect(line, options)?;
        device.first(safe[0]).map_err(explained)?;
        Ok(device)
    }

    /// Opens the line and asks who is there.
    fn connect(line: Box<dyn Line>, options: Options) -> Result<Self, String> {
        if !options.axes.is_empty() || !options.analog.is_empty() {
            return Err(
                "an NV200 has one axis and one sensor; axes= and analog= are not for it".into()
            );
        }
        let mut device = Nv200Device {
            line,
            options,
            identity: String::new(),
            about: String::new(),
            rest: Vec::new(),
            is_open: false,
            sent: None,
            restarted: false,
        };
        device.line.open(PATIENCE)?;
        device.is_open = true;
        device.identity = device.who(PATIENCE).map_err(explained)?;
        if !device.identity.starts_with("NV200") {
            return Err(format!("{}: is no NV200", device.identity));
        }
        Ok(device)
    }

    fn first(&mut self, safe: f64) -> Result<(), Broken> {
        let names = if self.options.open_loop { ["avmin", "avmax"] } else { ["posmin", "posmax"] };
        let [least, greatest] = names.map(|name| self.number(name, PATIENCE));
        let (least, greatest) = (least?, greatest?);
        if !(least..=greatest).contains(&safe) {
            return Err(Broken::Refused(format!(
                "its travel is from {least} to {greatest}; the safe command {safe} of the plan is outside it: give \
                 safe and command_limits in [[axis]], in the instrument's unit"
            )));
        }
        let actuator = self.ask("desc", PATIENCE)?;
        let mode = if self.options.open_loop { "open loop" } else { "closed loop" };
        self.about =
            format!("{}, actuator {actuator}; {mode}, from {least} to {greatest}", self.identity);
        Ok(())
    }

    /// Opens the line again; the instrument must be the one it was, and as it was.
    fn again(&mut self) -> Result<(), Broken> {
        self.rest.clear();
        let timeout = self.options.timeout;
        self.line.open(timeout).map_err(|_| Broken::Late)?;
        self.is_open = true;
        let identity = self.who(timeout)?;
        if identity != self.identity {
            // It is asked again before it is driven.
            self.close();
            return Err(Broken::Refused(format!(
                "another instrument answers: {identity}, not {}",
                self.identity
            )));
        }
        self.is_as_it_was(true)
    }

    /// Whether its loop still is as it was set, and its target one that was sent: after a restart a
    /// target would be a voltage.
    fn is_as_it_was(&mut self, asks_target: bool) -> Result<(), Broken> {
        let Some(sent) = self.sent else { return Ok(()) };
        let loop_is = self.number("cl", self.options.timeout)?;
        let target = match asks_target {
            true => self.number("set", self.options.timeout)?,
            false => sent[1],
        };
        let wanted = if self.options.open_loop { 0.0 } else { 1.0 };
        let is_known = sent.iter().any(|sent| (sent - target).abs() <= SAME_TARGET);
        if loop_is == wanted && is_known {
            return Ok(());
        }
        self.restarted = true;
        Err(Broken::Refused(format!(
            "the instrument has restarted, or somebody else works with it: cl is {loop_is}, its target {target}"
        )))
    }

    fn write(&mut self, text: &str) -> Result<(), Broken> {
        self.line.write(format!("{text}\r\n").as_bytes()).map_err(|_| Broken::Late)
    }

    /// What comes up to a byte, without what is for terminals.
    fn until(&mut self, end: u8, timeout: Duration) -> Result<String, Broken> {
        loop {
            if let Some(at) = self.rest.iter().position(|byte| *byte == end) {
                let taken: Vec<u8> = self.rest.drain(..=at).collect();
                let mut text = Vec::new();
                let mut option = 0;
                for byte in taken {
                    match byte {
                        _ if option > 0 => option -= 1,
                        IAC => option = 2,
                        byte if byte >= b' ' => text.push(byte),
                        _ => {}
                    }
                }
                return String::from_utf8(text).map_err(|_| Broken::Garbage("bytes".to_owned()));
            }
            if self.rest.len() > LONGEST {
                return Err(Broken::Garbage(format!("{LONGEST} bytes without an end")));
            }
            let mut bytes = [0; 512];
            match self.line.read(&mut bytes, timeout) {
                Ok(0) | Err(_) => return Err(Broken::Late),
                Ok(length) => self.rest.extend(&bytes[..length]),
            }
        }
    }

    fn who(&mut self, timeout: Duration) -> Result<String, Broken> {
        self.write("")?;
        let text = self.until(b'\n', timeout)?;
        Ok(name_in(&text))
    }

    /// Drops answers that come too late, until the instrument says who it is, which it does once they are all there.
    fn settle(&mut self, patience: Duration) -> Result<(), Broken> {
        self.write("")?;
        let (timeout, identity) = (self.options.timeout, self.identity.clone());
        let tries = (patience.as_secs_f64() / timeout.as_secs_f64()).ceil() as usize;
        let is_there = (0..tries)
            .any(|_| self.until(b'\n', timeout).is_ok_and(|text| name_in(&text) == identity));
        if !is_there {
            return Err(Broken::Late);
        }
        // With it goes the XON behind the name, which a command would take for its own.
        self.number("meas", timeout).map(|_| ())
    }

    /// The value of a question: the text behind its name.
    fn ask(&mut self, name: &str, timeout: Duration) -> Result<String, Broken> {
        self.write(name)?;
        // XON of the answer before may still stand in front.
        let mut text = String::new();
        for _ in 0..3 {
            text = self.until(XON, timeout)?;
            if !text.is_empty() {
                break;
            }
        }
        accepted(&text, name)?;
        let (answered, value) = text.split_once(',').unwrap_or((&text, ""));
        let asked = name.split(',').next().unwrap_or_default();
        if answered.trim() != asked || value.is_empty() {
            return Err(Broken::Garbage(format!("{text:?} where {name} was asked for")));
        }
        Ok(value.trim().to_owned())
    }

    fn number(&mut self, name: &str, timeout: Duration) -> Result<f64, Broken> {
        let text = self.ask(name, timeout)?;
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| Broken::Garbage(format!("{text:?} where {name} was asked for")))
    }

    /// A command: answered by XON alone, or by an error.
    fn command(&mut self, text: &str) -> Result<(), Broken> {
        self.write(text)?;
        let answer = self.until(XON, self.options.timeout)?;
        accepted(&answer, text)?;
        if answer.is_empty() {
            Ok(())
        } else {
            Err(Broken::Garbage(format!("{answer:?} after {text}")))
        }
    }

    fn turn(&mut self, enabled: bool, command: f64) -> Result<f64, Broken> {
        match self.is_open {
            true => self.is_as_it_was(false)?,
            false => self.again()?,
        }
        if enabled && self.sent.is_none() {
            self.command(if self.options.open_loop { "cl,0" } else { "cl,1" })?;
            self.command("modsrc,0")?;
            self.sent = Some([command; 2]);
        }
        if let Some(sent) = &mut self.sent {
            *sent = [sent[1], command];
            self.command(&format!("set,{command:.6}"))?;
        }
        let position = self.number("meas", self.options.timeout)?;
        // One question, one answer: what is left over answers nothing that was asked.
        if self.rest.iter().any(|byte| *byte > b' ' && *byte < 0x7f) {
            return Err(Broken::Garbage("more than was asked for".to_owned()));
        }
        Ok(position)
    }
}

/// Who answers an empty line.
fn name_in(prompt: &str) -> String {
    prompt.trim_matches([' ', '<', '>']).to_owned()
}

/// Why an instrument does not open.
fn explained(broken: Broken) -> String {
    match broken {
        Broken::Refused(text) => text,
        other => format!("it does not answer as an NV200: {other}"),
    }
}

/// Whether an answer is an error.
fn accepted(answer: &str, command: &str) -> Result<(), Broken> {
    let Some(code) = answer.trim().strip_prefix("error") else { return Ok(()) };
    let code = code.trim_start_matches(',').trim();
    let text = match code {
        "2" => "unknown command",
        "3" => "a parameter is missing",
        "4" => "the range is exceeded",
        "5" => "too many parameters",
        "6" => "locked or read only",
        "7" => "underload",
        "8" => "overload",
        "9" => "parameter too low",
        "10" => "parameter too high",
        _ => "not specified",
    };
    Err(Broken::Refused(format!("{command}: NV200 error {code}: {text}")))
}

impl Device for Nv200Device {
    fn exchange(&mut self, enabled: bool, commands: &[f64], positions: &mut [f64]) -> Exchanged {
        if self.restarted {
            return Exchanged::Failed("the instrument has restarted".to_owned());
        }
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
        Some(self.about.clone())
    }

    fn close(&mut self) {
        self.line.close();
        self.is_open = false;
    }
}
