//! piezosystem jena NV200: its text protocol, one axis. The maker's own library for Python works with it.
//!
//! A command `name,value` or a question `name` ends with a carriage return; the answer to a question is
//! `name,value`, an error `error,N`; after each, XON says that the next may come. An empty line asks who
//! is there. Set points come from commands, from the wave generator, or from the analog input:
//!
//! ```text
//! set point = least + u / (10 V) · (greatest − least), within its range; modon 0: u = 0
//! ```
//!
//! Commands and the analog input go through a limit of the slew rate. Source: piezosystem jena, Python library nv200
//! 1.6.0, and its documentation; manual of the NV200/D NET, section 8.5.

mod analog;
mod recording;

use super::generator::{Recorder, Seen};
use super::{Instrument, Signals, Stage, Travel};
use crate::plant::{Plant, PlantError};

const XON: u8 = 0x11;
/// Telnet: the two bytes behind it are for the terminal.
const IAC: u8 = 0xff;

const UNKNOWN: u8 = 2;
const MISSING: u8 = 3;
const RANGE: u8 = 4;
const COUNT: u8 = 5;
const READ_ONLY: u8 = 6;

/// The instrument.
#[derive(Debug)]
pub struct Nv200Instrument {
    stage: Stage,
    /// Where targets come from; 0: commands.
    source: u8,
    line: Vec<u8>,
    /// Bytes of a telnet option that are still to come.
    option: u8,
    commands: u64,
    /// What starts the recorder; 0: a command of its own, 1: `set`, 2: the wave generator.
    autostart: u8,
    /// Points of the wave generator in %, first and last of the loop.
    wave: Vec<f64>,
    range: [usize; 2],
    /// Notch filter: on, frequency and width in Hz.
    notch: (bool, [f64; 2]),
    /// Whether the analog input is on.
    analog: bool,
    /// Limit of the slew rate of the set point in %/ms.
    slew: f64,
    /// A commanded set point that the limited one has not reached yet.
    wanted: Option<f64>,
}

/// Set points come from the wave generator.
const GENERATOR: u8 = 3;
/// Points of the wave generator, values of each recorder channel.
const POINTS: usize = 1024;
const VALUES: usize = 6144;

impl Nv200Instrument {
    /// An instrument around a plant of one axis at rest, open loop; none for another number of axes.
    #[must_use]
    pub fn new(plant: Plant, travel: Vec<Travel>) -> Option<Self> {
        let is_one = plant.axes() == 1 && travel.len() == 1;
        let recorder = Recorder::new(vec![(0, Seen::Position), (0, Seen::Target)], VALUES);
        let stage = Stage::new(plant, travel, recorder);
        is_one.then(|| Nv200Instrument {
            stage,
            source: 0,
            line: Vec::new(),
            option: 0,
            commands: 0,
            autostart: 0,
            wave: vec![0.0; POINTS],
            range: [0, POINTS - 1],
            notch: (false, [1000.0, 100.0]),
            analog: false,
            slew: analog::NO_LIMIT,
            wanted: None,
        })
    }

    /// Leads a voltage to its analog input.
    #[must_use]
    pub fn with_signals(mut self, signals: Signals) -> Self {
        self.stage.inputs.signals = Some(signals);
        self
    }

    fn command(&mut self, line: &str) -> String {
        let mut words = line.trim().split(',').map(str::trim);
        let name = words.next().unwrap_or_default().to_ascii_lowercase();
        let values: Vec<&str> = words.collect();
        if name.is_empty() {
            return "NV200/D_NET>\r\n".to_owned();
        }
        self.commands += 1;
        let done = match values[..] {
            _ if recording::NAMES.contains(&&*name) => self.record(&name, &values),
            [] => self.ask(&name),
            [value] => self.set(&name, value).map(|()| String::new()),
            _ => Err(COUNT),
        };
        done.unwrap_or_else(|code| format!("error,{code}\r\n"))
    }

    fn ask(&self, name: &str) -> Result<String, u8> {
        let (axis, travel) = (self.stage.axes[0], self.stage.travel[0]);
        let [low, high] = travel.volts;
        let value = match name {
            "meas" => format!("{:.6}", axis.position),
            "set" => format!("{:.6}", if axis.servo { axis.target } else { axis.volts }),
            "cl" => u8::from(axis.servo).to_string(),
            "posmin" => format!("{:.6}", travel.range()[0]),
            "posmax" => format!("{:.6}", travel.range()[1]),
            "avmin" => format!("{:.6}", low.min(high)),
            "avmax" => format!("{:.6}", low.max(high)),
            "unitcl" => "um".to_owned(),
            "unitol" => "V".to_owned(),
            "modsrc" => self.source.to_string(),
            "modon" => u8::from(self.analog).to_string(),
            "sr" => self.slew.to_string(),
            "ctrlmode" => "0".to_owned(),
            "desc" => "EMULATED".to_owned(),
            "acserno" => "0".to_owned(),
            "acmeasure" => "2".to_owned(),
            "temp" => "25.0".to_owned(),
            "kp" => self.stage.servos[0].proportional.to_string(),
            "ki" => (self.stage.servos[0].integral / self.stage.period()).to_string(),
            "kd" => (self.stage.servos[0].derivative * self.stage.period()).to_string(),
            "notchon" => u8::from(self.notch.0).to_string(),
            "notchf" => self.notch.1[0].to_string(),
            "notchb" => self.notch.1[1].to_string(),
            // An actuator with a capacitive sensor; bit 3: closed loop, bit 5: notch filter.
            "stat" => {
                (1 | 1 << 2 | u32::from(axis.servo) << 3 | u32::from(self.notch.0) << 5).to_string()
            }
            _ => return Err(UNKNOWN),
        };
        Ok(format!("{name},{value}\r\n"))
    }

    fn set(&mut self, name: &str, text: &str) -> Result<(), u8> {
        let number = || text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or(MISSING);
        match name {
            "set" => {
                let value = number()?;
                let (axis, travel) = (&mut self.stage.axes[0], self.stage.travel[0]);
                let [low, high] = travel.volts;
                let inside = match axis.servo {
                    true => travel.reaches(value),
                    false => (low.min(high)..=low.max(high)).contains(&value),
                };
                if !inside {
                    return Err(RANGE);
                }
                // Only where targets are those of commands.
                if self.source == 0 {
                    if self.slew < analog::NO_LIMIT {
                        self.wanted = Some(value);
                    } else {
                        *(if axis.servo { &mut axis.target } else { &mut axis.volts }) = value;
                    }
                    if self.autostart == 1 {
                        self.stage.recorder.start();
                    }
                }
                Ok(())
            }
            "kp" | "ki" | "kd" => {
                let value = Some(number()?).filter(|x| (0.0..=1e4).contains(x)).ok_or(RANGE)?;
                let period = self.stage.period();
                let servo = &mut self.stage.servos[0];
                match name {
                    "kp" => servo.proportional = value,
                    "ki" => servo.integral = value * period,
                    _ => servo.derivative = value / period,
                }
                Ok(())
            }
            "notchon" | "notchf" | "notchb" => self.set_notch(name, number()?),
            "modon" => match number()? {
                on @ (0.0 | 1.0) => {
                    self.analog = on == 1.0;
                    Ok(())
                }
                _ => Err(RANGE),
            },
            "sr" => {
                let value = number()?;
                if !(analog::SLOWEST..=analog::NO_LIMIT).contains(&value) {
                    return Err(RANGE);
                }
                self.slew = value;
                Ok(())
            }
            "cl" => match number()? {
                closed @ (0.0 | 1.0) => {
                    self.wanted = None;
                    self.stage.servo(0, closed == 1.0);
                    Ok(())
                }
                _ => Err(RANGE),
            },
            "modsrc" => match number()? {
                source @ (0.0 | 1.0 | 2.0 | 3.0) => {
                    (self.source, self.wanted) = (source as u8, None);
                    if self.source != GENERATOR {
                        self.stage.generators[0].stop();
                    }
                    Ok(())
                }
                _ => Err(RANGE),
            },
            _ if self.ask(name).is_ok() => Err(READ_ONLY),
            _ => Err(UNKNOWN),
        }
    }

    fn set_notch(&mut self, name: &str, value: f64) -> Result<(), u8> {
        let (mut on, [mut frequency, mut width]) = self.notch;
        match (name, value) {
            ("notchon", 0.0 | 1.0) => on = value == 1.0,
            ("notchf", 1.0..=1e4) => frequency = value,
            ("notchb", 1.0..=1e4) => width = value,
            _ => return Err(RANGE),
        }
        if width > 2.0 * frequency {
            return Err(RANGE);
        }
        self.notch = (on, [frequency, width]);
        let least = 0.45 / self.stage.period();
        let frequency = if on { frequency.min(least) } else { 0.0 };
        self.stage.notch(0, 0, [frequency, 0.0, 0.5 * width / frequency.max(1e-9)]);
        Ok(())
    }
}

impl Instrument for Nv200Instrument {
    fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut answer = Vec::new();
        for byte in bytes {
            match byte {
                _ if self.option > 0 => self.option -= 1,
                &IAC => self.option = 2,
                b'\r' => {
                    let line = std::mem::take(&mut self.line);
                    answer.extend(self.command(&String::from_utf8_lossy(&line)).bytes());
                    answer.push(XON);
                }
                b'\n' | 0 => {}
                byte if self.line.len() < 256 => self.line.push(*byte),
                _ => {}
            }
        }
        answer
    }

    fn step(&mut self) -> Result<(), PlantError> {
        self.lead();
        self.stage.step()
    }

    fn reboot(&mut self) {
        self.stage.reboot();
        (self.source, self.line, self.autostart) = (0, Vec::new(), 0);
        (self.range, self.notch) = ([0, POINTS - 1], (false, [1000.0, 100.0]));
        self.wave = vec![0.0; POINTS];
        (self.analog, self.slew, self.wanted) = (false, analog::NO_LIMIT, None);
    }

    fn hang_up(&mut self) {
        (self.line, self.option) = (Vec::new(), 0);
    }

    fn commands(&self) -> u64 {
        self.commands
    }

    fn targets(&self) -> Vec<(f64, bool)> {
        self.stage.targets()
    }
}
