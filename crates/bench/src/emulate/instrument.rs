//! An instrument that speaks GCS 2.0: digital servo controller and piezo plant, for `bench emulate
//! --protocol gcs`. PI's own client, PIPython, works with it.
//!
//! Open loop (`SVO axis 0`, `SVA`): the voltage acts on the plant. Closed loop (`SVO axis 1`, `MOV`):
//! an integrator u += K·(target − y)/g per step, g the plant's static gain, brings the position there.

use super::plant::{Plant, PlantError};

/// Share of the error that one step of the servo takes away from a plant without dynamics.
const INTEGRAL: f64 = 0.03;
/// Within this share of the travel an axis is on its target.
const ON_TARGET: f64 = 1e-3;
/// Steps in which the plant comes to rest when its ends are measured.
const REST: usize = 2000;

/// How far an axis goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// Voltages.
    pub volts: [f64; 2],
    /// Positions at these.
    pub positions: [f64; 2],
}

impl Travel {
    fn gain(&self) -> f64 {
        let gain = (self.positions[1] - self.positions[0]) / (self.volts[1] - self.volts[0]);
        if gain.is_finite() && gain != 0.0 { gain } else { 1.0 }
    }

    /// The least and the greatest position.
    fn range(&self) -> [f64; 2] {
        let [a, b] = self.positions;
        [a.min(b), a.max(b)]
    }

    /// Whether a target is one, to the digits that are told.
    fn reaches(&self, target: f64) -> bool {
        let [least, greatest] = self.range();
        (least - 1e-6..=greatest + 1e-6).contains(&target)
    }
}

/// Measures how far each axis of a plant goes between two voltages: it is used up.
///
/// # Errors
/// The plant failed.
pub fn travel(mut plant: Plant, volts: &[[f64; 2]]) -> Result<Vec<Travel>, PlantError> {
    let mut ends = [0, 1].map(|_| vec![0.0; plant.axes()]);
    for (end, positions) in ends.iter_mut().enumerate() {
        let commands: Vec<f64> = volts.iter().map(|volts| volts[end]).collect();
        for _ in 0..REST {
            plant.step(&commands)?;
        }
        plant.read(positions);
    }
    let axis =
        |axis: usize| Travel { volts: volts[axis], positions: [ends[0][axis], ends[1][axis]] };
    Ok((0..volts.len()).map(axis).collect())
}

/// The instrument.
#[derive(Debug)]
pub struct Instrument {
    plant: Plant,
    travel: Vec<Travel>,
    axes: Vec<Axis>,
    error: i32,
    /// A line that is not whole yet.
    line: Vec<u8>,
    commands: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    servo: bool,
    target: f64,
    volts: f64,
    position: f64,
}

const UNKNOWN_COMMAND: i32 = 2;
const SYNTAX: i32 = 1;
const SERVO_OFF: i32 = 5;
const LIMITS: i32 = 7;
const STOPPED: i32 = 10;
const NO_AXIS: i32 = 15;

const HELP: &str = "The following commands are valid: \n#5 Request Motion Status \n#7 Request Controller Ready Status \n#24 Stop All Axes \n\
    *IDN? Get Device Identification \nCSV? Get Current Syntax Version \nERR? Get Error Number \nHLP? Get List Of Available Commands \n\
    HLT Halt Motion Smoothly \nMOV Set Target Position \nMOV? Get Target Position \nMVR Set Target Relative \nONT? Get On-Target State \nOVF? Get Overflow State \n\
    POS? Get Real Position \nRBT Reboot System \nSAI? Get List Of Current Axis Identifiers \nSTP Stop All Axes \nSVA Set Open-Loop Axis Value \n\
    SVA? Get Open-Loop Axis Value \nSVO Set Servo Mode \nSVO? Get Servo Mode \nTMN? Get Minimum Commandable Position \n\
    TMX? Get Maximum Commandable Position \nVER? Get Versions \nVOL? Get Voltage Of Output Signal Channel \nend of help\n";

impl Instrument {
    /// An instrument around a plant at rest: servo off.
    #[must_use]
    pub fn new(plant: Plant, travel: Vec<Travel>) -> Self {
        let axes = vec![Axis::default(); plant.axes()];
        let mut made = Instrument { plant, travel, axes, error: 0, line: Vec::new(), commands: 0 };
        made.look();
        made
    }

    /// Commands and questions so far.
    #[must_use]
    pub fn commands(&self) -> u64 {
        self.commands
    }

    /// Voltages that act, axis by axis.
    #[must_use]
    pub fn volts(&self) -> Vec<f64> {
        self.axes.iter().map(|axis| axis.volts).collect()
    }

    /// Targets and servo states, axis by axis.
    #[must_use]
    pub fn targets(&self) -> Vec<(f64, bool)> {
        self.axes.iter().map(|axis| (axis.target, axis.servo)).collect()
    }

    /// One step of servo and plant.
    ///
    /// # Errors
    /// The plant failed.
    pub fn step(&mut self) -> Result<(), PlantError> {
        for (axis, travel) in self.axes.iter_mut().zip(&self.travel) {
            if axis.servo {
                axis.volts += INTEGRAL * (axis.target - axis.position) / travel.gain();
            }
            let [least, greatest] = travel.volts;
            axis.volts = axis.volts.clamp(least.min(greatest), greatest.max(least));
        }
        self.plant.step(&self.volts())?;
        self.look();
        Ok(())
    }

    fn look(&mut self) {
        let mut positions = vec![0.0; self.axes.len()];
        self.plant.read(&mut positions);
        self.axes.iter_mut().zip(positions).for_each(|(axis, position)| axis.position = position);
    }

    /// Power off and on: servo off, the voltage next to 0, no error.
    pub fn reboot(&mut self) {
        for (axis, travel) in self.axes.iter_mut().zip(&self.travel) {
            let [a, b] = travel.volts;
            (axis.servo, axis.volts) = (false, 0.0_f64.clamp(a.min(b), a.max(b)));
            axis.target = axis.position;
        }
        (self.error, self.line) = (0, Vec::new());
    }

    /// The client is gone: half a line is none.
    pub fn hang_up(&mut self) {
        self.line.clear();
    }

    /// Takes bytes of the client; the return value is what is answered.
    pub fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
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
                24 => self.stop(),
                byte if self.line.len() < 4096 => self.line.push(*byte),
                _ => self.error = SYNTAX,
            }
        }
        answer
    }

    /// Bit i: axis i is not on its target.
    fn moving(&self) -> u32 {
        let moves =
            (0..self.axes.len()).filter(|axis| self.axes[*axis].servo && !self.is_on_target(*axis));
        moves.fold(0, |bits, axis| bits | 1 << axis.min(31))
    }

    fn is_on_target(&self, axis: usize) -> bool {
        let [least, greatest] = self.travel[axis].range();
        let Axis { servo, target, position, .. } = self.axes[axis];
        servo && (target - position).abs() <= ON_TARGET * (greatest - least)
    }

    fn stop(&mut self) {
        self.axes.iter_mut().for_each(|axis| axis.target = axis.position);
        self.error = STOPPED;
    }

    fn command(&mut self, line: &str) -> String {
        let words: Vec<&str> = line.split_whitespace().collect();
        let Some((name, rest)) = words.split_first() else { return String::new() };
        self.commands += 1;
        let done = match name.to_ascii_uppercase().as_str() {
            "*IDN?" => Ok(format!(
                "Piezoloop, emulated GCS 2.0 controller, 0, {}\n",
                env!("CARGO_PKG_VERSION")
            )),
            "CSV?" => Ok("2.0\n".to_owned()),
            "VER?" => Ok(format!("FW_EMU: V{} \nGCS: 2.0\n", env!("CARGO_PKG_VERSION"))),
            "HLP?" => Ok(HELP.to_owned()),
            "ERR?" => Ok(format!("{}\n", std::mem::take(&mut self.error))),
            "SAI?" => Ok(lines((1..=self.axes.len()).map(|axis| axis.to_string()))),
            "POS?" => self.tell(rest, |_, axis| format!("{:+.6}", axis.position)),
            "MOV?" => self.tell(rest, |_, axis| format!("{:+.6}", axis.target)),
            "SVA?" | "VOL?" => self.tell(rest, |_, axis| format!("{:+.6}", axis.volts)),
            "SVO?" => self.tell(rest, |_, axis| u8::from(axis.servo).to_string()),
            "TMN?" => self.tell(rest, |travel, _| format!("{:+.6}", travel.range()[0])),
            "TMX?" => self.tell(rest, |travel, _| format!("{:+.6}", travel.range()[1])),
            "OVF?" => self.tell(rest, |travel, axis| {
                u8::from(axis.servo && travel.volts.contains(&axis.volts)).to_string()
            }),
            "ONT?" => self.places(rest).map(|places| {
                lines(
                    places.iter().map(|n| format!("{}={}", n + 1, u8::from(self.is_on_target(*n)))),
                )
            }),
            "MOV" => self.moved(rest, false),
            "MVR" => self.moved(rest, true),
            "SVA" => self.pairs(rest).and_then(|pairs| {
                if pairs.iter().any(|(n, _)| self.axes[*n].servo) {
                    return Err(SERVO_OFF);
                }
                let inside = |(n, value): &(usize, f64)| {
                    let [a, b] = self.travel[*n].volts;
                    (a.min(b)..=a.max(b)).contains(value)
                };
                if !pairs.iter().all(inside) {
                    return Err(LIMITS);
                }
                pairs.iter().for_each(|(n, value)| self.axes[*n].volts = *value);
                Ok(String::new())
            }),
            "SVO" => self.pairs(rest).map(|pairs| {
                for (n, value) in pairs {
                    let axis = &mut self.axes[n];
                    // It takes over where it is.
                    axis.target = if axis.servo { axis.target } else { axis.position };
                    axis.servo = value != 0.0;
                }
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
            _ => Err(UNKNOWN_COMMAND),
        };
        done.unwrap_or_else(|error| {
            self.error = error;
            String::new()
        })
    }

    fn moved(&mut self, words: &[&str], is_relative: bool) -> Result<String, i32> {
        let mut pairs = self.pairs(words)?;
        if is_relative {
            pairs.iter_mut().for_each(|(n, value)| *value += self.axes[*n].target);
        }
        if pairs.iter().any(|(n, _)| !self.axes[*n].servo) {
            return Err(SERVO_OFF);
        }
        let inside = |(n, value): &(usize, f64)| self.travel[*n].reaches(*value);
        // All or none.
        if !pairs.iter().all(inside) {
            return Err(LIMITS);
        }
        pairs.iter().for_each(|(n, value)| self.axes[*n].target = *value);
        Ok(String::new())
    }

    /// The axes of these names; of none, all.
    fn places(&self, words: &[&str]) -> Result<Vec<usize>, i32> {
        if words.is_empty() {
            return Ok((0..self.axes.len()).collect());
        }
        let place = |word: &&str| {
            let number = word.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
            number.filter(|n| *n < self.axes.len()).ok_or(NO_AXIS)
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

    fn tell(&self, words: &[&str], of: impl Fn(&Travel, &Axis) -> String) -> Result<String, i32> {
        let places = self.places(words)?;
        let line = |n: &usize| format!("{}={}", n + 1, of(&self.travel[*n], &self.axes[*n]));
        Ok(lines(places.iter().map(line)))
    }
}

/// An answer: each line but the last ends with a blank.
fn lines(all: impl Iterator<Item = String>) -> String {
    all.collect::<Vec<_>>().join(" \n") + "\n"
}
