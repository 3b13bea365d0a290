//! PI: the General Command Set 2.0. PI's own client, PIPython, works with it.

mod parameters;
mod recording;
mod waves;

use super::generator::{Recorder, Seen};
use super::{Axis, Instrument, Signals, Stage, Travel};
use crate::plant::{Plant, PlantError};

/// The instrument.
#[derive(Debug)]
pub struct GcsInstrument {
    stage: Stage,
    error: i32,
    /// A line that is not whole yet.
    line: Vec<u8>,
    commands: u64,
    /// Wave tables, and which of them each generator plays (from 1; 0: none).
    tables: Vec<Vec<f64>>,
    plays: Vec<usize>,
    /// What starts the recorder, as in DRT.
    trigger: u8,
    /// Of the protection of parameters.
    level: u8,
}

/// Wave tables, and tables of the data recorder.
const TABLES: usize = 8;
/// Values of all tables of the recorder together.
const MOST_VALUES: usize = 262_144;

const UNKNOWN_COMMAND: i32 = 2;
const SYNTAX: i32 = 1;
const SERVO_OFF: i32 = 5;
const LIMITS: i32 = 7;
const STOPPED: i32 = 10;
const NO_AXIS: i32 = 15;
const OUT_OF_RANGE: i32 = 17;
const UNKNOWN_PARAMETER: i32 = 54;
const PASSWORD: i32 = 56;
const RECORDER_TABLE: i32 = 57;
const RECORDER_OPTION: i32 = 58;
const PROTECTED: i32 = 60;
const READ_ONLY: i32 = 64;
const TOO_LARGE: i32 = 67;
const ANALOG_ACTIVE: i32 = 72;
const GENERATOR_ACTIVE: i32 = 73;
const NO_WAVE: i32 = 75;
const LONGEST: usize = 65_536;

const HELP: &str = "The following commands are valid: \n#5 Request Motion Status \n#9 Get Wave Generator Status \n#7 Request Controller Ready Status \n#24 Stop All Axes \n\
    *IDN? Get Device Identification \nAOS Set Analog Input Offset \nAOS? Get Analog Input Offset \nCCL Set Command Level \nCCL? Get Command Level \nDRC Set Data Recorder Configuration \n\
    DRC? Get Data Recorder Configuration \nDRL? Get Number Of Recorded Points \nDRR? Get Recorded Data Values \n\
    DRT Set Data Recorder Trigger Source \nDRT? Get Data Recorder Trigger Source \nGWD? Get Wave Table Data \n\
    HDR? Get All Data Recorder Options \nHPA? Get List Of Available Parameters \nRPA Reset Volatile Memory Parameters \n\
    RTR Set Record Table Rate \nRTR? Get Record Table Rate \nSEP? Get Nonvolatile Memory Parameters \n\
    SPA Set Volatile Memory Parameters \nSPA? Get Volatile Memory Parameters \nSTE Start Step And Response Measurement \n\
    TAD? Get ADC Value Of Input Signal \nTNR? Get Number Of Record Tables \nTNS? Get Normalized Input Signal Value \n\
    TPC? Get Number Of Output Signal Channels \nTSC? Get Number Of Input Signal Channels \nTSP? Get Input Signal Position Value \n\
    TWG? Get Number Of Wave Generators \nWAV Set Waveform Definition \nWAV? Get Waveform Definition \nWCL Clear Wave Table Data \n\
    WGC Set Number Of Wave Generator Cycles \nWGC? Get Number Of Wave Generator Cycles \nWGO Set Wave Generator Start/Stop Mode \n\
    WGO? Get Wave Generator Start/Stop Mode \nWMS? Get Maximum Number Of Wave Table Points \nWOS Set Wave Generator Output Offset \n\
    WOS? Get Wave Generator Output Offset \nWPA Save Parameters To Nonvolatile Memory \nWSL Set Connection Of Wave Table To Wave Generator \n\
    WSL? Get Connection Of Wave Table To Wave Generator \nWTR Set Wave Generator Table Rate \nWTR? Get Wave Generator Table Rate \nCSV? Get Current Syntax Version \nERR? Get Error Number \nHLP? Get List Of Available Commands \n\
    HLT Halt Motion Smoothly \nMOV Set Target Position \nMOV? Get Target Position \nMVR Set Target Relative \nONT? Get On-Target State \nOVF? Get Overflow State \n\
    POS? Get Real Position \nRBT Reboot System \nSAI? Get List Of Current Axis Identifiers \nSTP Stop All Axes \nSVA Set Open-Loop Axis Value \n\
    SVA? Get Open-Loop Axis Value \nSVO Set Servo Mode \nSVO? Get Servo Mode \nTMN? Get Minimum Commandable Position \n\
    TMX? Get Maximum Commandable Position \nVER? Get Versions \nVOL? Get Voltage Of Output Signal Channel \nend of help\n";

impl GcsInstrument {
    /// An instrument around a plant at rest: servo off.
    #[must_use]
    pub fn new(plant: Plant, travel: Vec<Travel>) -> Self {
        let axes = plant.axes();
        let sources = (0..TABLES).map(|table| (table % axes, Seen::Position)).collect();
        let recorder = Recorder::new(sources, MOST_VALUES / TABLES);
        let stage = Stage::new(plant, travel, recorder);
        GcsInstrument {
            stage,
            error: 0,
            line: Vec::new(),
            commands: 0,
            tables: vec![Vec::new(); TABLES],
            plays: vec![0; axes],
            trigger: 0,
            level: 0,
        }
    }

    /// Leads voltages to its analog inputs.
    #[must_use]
    pub fn with_signals(mut self, signals: Signals) -> Self {
        self.stage.inputs.signals = Some(signals);
        self
    }

    /// Bit i: axis i is not on its target.
    fn moving(&self) -> u32 {
        let moves = (0..self.stage.axes.len())
            .filter(|axis| self.stage.axes[*axis].servo && !self.stage.is_on_target(*axis));
        moves.fold(0, |bits, axis| bits | 1 << axis.min(31))
    }

    /// Bit i: wave generator i runs.
    fn playing(&self) -> u32 {
        let runs = (0..self.plays.len()).filter(|n| self.stage.generators[*n].is_running());
        runs.fold(0, |bits, n| bits | 1 << n.min(31))
    }

    fn stop(&mut self) {
        self.stage.generators.iter_mut().for_each(super::generator::Generator::stop);
        self.stage.inputs.now.sources.fill(0);
        self.stage.axes.iter_mut().for_each(|axis| axis.target = axis.position);
        self.error = STOPPED;
    }

    fn command(&mut self, line: &str) -> String {
        let words: Vec<&str> = line.split_whitespace().collect();
        let Some((name, rest)) = words.split_first() else { return String::new() };
        self.commands += 1;
        let name = name.to_ascii_uppercase();
        if self.trigger == recording::NEXT && !name.ends_with('?') && name != "DRT" {
            self.trigger = 0;
            self.stage.recorder.start();
        }
        let done = match name.as_str() {
            "*IDN?" => Ok(format!(
                "Piezoloop, emulated GCS 2.0 controller, 0, {}\n",
                env!("CARGO_PKG_VERSION")
            )),
            "CSV?" => Ok("2.0\n".to_owned()),
            "VER?" => Ok(format!("FW_EMU: V{} \nGCS: 2.0\n", env!("CARGO_PKG_VERSION"))),
            "HLP?" => Ok(HELP.to_owned()),
            "ERR?" => Ok(format!("{}\n", std::mem::take(&mut self.error))),
            "SAI?" => Ok(lines((1..=self.stage.axes.len()).map(|axis| axis.to_string()))),
            "POS?" => self.each_axis(rest, |_, axis| format!("{:+.6}", axis.position)),
            "MOV?" => self.each_axis(rest, |_, axis| format!("{:+.6}", axis.target)),
            "SVA?" | "VOL?" => self.each_axis(rest, |_, axis| format!("{:+.6}", axis.volts)),
            "SVO?" => self.each_axis(rest, |_, axis| u8::from(axis.servo).to_string()),
            "TMN?" => self.each_axis(rest, |travel, _| format!("{:+.6}", travel.range()[0])),
            "TMX?" => self.each_axis(rest, |travel, _| format!("{:+.6}", travel.range()[1])),
            "OVF?" => self.each_axis(rest, |travel, axis| {
                u8::from(axis.servo && travel.volts.contains(&axis.volts)).to_string()
            }),
            "ONT?" => self.places(rest).map(|places| {
                lines(
                    places
                        .iter()
                        .map(|n| format!("{}={}", n + 1, u8::from(self.stage.is_on_target(*n)))),
                )
            }),
            "MOV" => self.moved(rest, false),
            "MVR" => self.moved(rest, true),
            "SVA" => self.pairs(rest).and_then(|pairs| {
                self.may_move(&pairs)?;
                if pairs.iter().any(|(n, _)| self.stage.axes[*n].servo) {
                    return Err(SERVO_OFF);
                }
                let inside = |(n, value): &(usize, f64)| {
                    let [a, b] = self.stage.travel[*n].volts;
                    (a.min(b)..=a.max(b)).contains(value)
                };
                if !pairs.iter().all(inside) {
                    return Err(LIMITS);
                }
                pairs.iter().for_each(|(n, value)| self.stage.axes[*n].volts = *value);
                Ok(String::new())
            }),
            "SVO" => self.pairs(rest).map(|pairs| {
                pairs.iter().for_each(|(n, value)| self.stage.servo(*n, *value != 0.0));
                String::new()
            }),
            "STP" | "HLT" => {
                self.stop();
                Ok(String::new())
            }
            "RBT" => {
                self.reboot();
                Ok(String::new())
            }
            name => self
                .generate(name, rest)
                .or_else(|| self.record(name, rest))
                .or_else(|| self.parameter(name, rest))
                .unwrap_or(Err(UNKNOWN_COMMAND)),
        };
        done.unwrap_or_else(|error| {
            self.error = error;
            String::new()
        })
    }

    fn moved(&mut self, words: &[&str], is_relative: bool) -> Result<String, i32> {
        let mut pairs = self.pairs(words)?;
        if is_relative {
            pairs.iter_mut().for_each(|(n, value)| *value += self.stage.axes[*n].target);
        }
        self.may_move(&pairs)?;
        if pairs.iter().any(|(n, _)| !self.stage.axes[*n].servo) {
            return Err(SERVO_OFF);
        }
        let inside = |(n, value): &(usize, f64)| self.stage.travel[*n].reaches(*value);
        // All or none.
        if !pairs.iter().all(inside) {
            return Err(LIMITS);
        }
        pairs.iter().for_each(|(n, value)| self.stage.axes[*n].target = *value);
        if self.trigger == recording::MOVES {
            self.stage.recorder.start();
        }
        Ok(String::new())
    }

    /// No axis is commanded while an analog input or a wave generator commands it.
    fn may_move(&self, pairs: &[(usize, f64)]) -> Result<(), i32> {
        if pairs.iter().any(|(n, _)| self.stage.analog(*n).is_some()) {
            return Err(ANALOG_ACTIVE);
        }
        let is_busy = pairs.iter().any(|(n, _)| self.stage.generators[*n].is_running());
        if is_busy { Err(GENERATOR_ACTIVE) } else { Ok(()) }
    }

    /// The axes of these names; of none, all.
    fn places(&self, words: &[&str]) -> Result<Vec<usize>, i32> {
        if words.is_empty() {
            return Ok((0..self.stage.axes.len()).collect());
        }
        let place = |word: &&str| {
            let number = word.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
            number.filter(|n| *n < self.stage.axes.len()).ok_or(NO_AXIS)
        };
        words.iter().map(place).collect()
    }

    fn pairs(&self, words: &[&str]) -> Result<Vec<(usize, f64)>, i32> {
        if words.is_empty() || !words.len().is_multiple_of(2) {
            return Err(SYNTAX);
        }
        let pair = |pair: &[&str]| {
            let value = pair[1].parse::<f64>().ok().filter(|value| value.is_finite());
            Ok((self.places(&pair[..1])?[0], value.ok_or(SYNTAX)?))
        };
        words.chunks(2).map(pair).collect()
    }

    fn each_axis(
        &self,
        words: &[&str],
        of: impl Fn(&Travel, &Axis) -> String,
    ) -> Result<String, i32> {
        let places = self.places(words)?;
        let line =
            |n: &usize| format!("{}={}", n + 1, of(&self.stage.travel[*n], &self.stage.axes[*n]));
        Ok(lines(places.iter().map(line)))
    }
}

impl Instrument for GcsInstrument {
    fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut answer = Vec::new();
        for byte in bytes {
            match byte {
                b'\n' | b'\r' => {
                    let line = std::mem::take(&mut self.line);
                    answer.extend(self.command(&String::from_utf8_lossy(&line)).bytes());
                }
                5 => answer.extend(format!("{:X}\n", self.moving()).bytes()),
                // Ready, in PI's code page.
                7 => answer.extend([0xb1, b'\n']),
                9 => answer.extend(format!("{:X}\n", self.playing()).bytes()),
                24 => self.stop(),
                byte if self.line.len() < LONGEST => self.line.push(*byte),
                _ => self.error = SYNTAX,
            }
        }
        answer
    }

    fn step(&mut self) -> Result<(), PlantError> {
        self.stage.step()
    }

    fn reboot(&mut self) {
        self.stage.reboot();
        (self.error, self.line, self.trigger, self.level) = (0, Vec::new(), 0, 0);
        self.tables.iter_mut().for_each(Vec::clear);
        self.plays.iter_mut().for_each(|table| *table = 0);
    }

    fn hang_up(&mut self) {
        self.line.clear();
    }

    fn commands(&self) -> u64 {
        self.commands
    }

    fn targets(&self) -> Vec<(f64, bool)> {
        self.stage.targets()
    }
}

/// An answer: each line but the last ends with a blank.
fn lines(all: impl Iterator<Item = String>) -> String {
    all.collect::<Vec<_>>().join(" \n") + "\n"
}
