//! Wave generator, data recorder and servo parameters of a digital piezo controller of PI (E-727 and its like).
//!
//! Axis n has wave generator n and output channel n; wave table n and record tables 1 to 3 are used, their old content
//! is lost. The law of the servo: P, T_i and T_d in parallel; notch filters with frequency and rejection.
//!
//! Source: PI, E-727 user manual E727T0005, "Data Recorder", "Wave Generator", "Control Details", "How to
//! work with the Analog Input".

use std::thread::sleep;
use std::time::Duration;

use super::PATIENCE;
use super::speech::Speech;
use super::text;
use crate::gateway::line::{Broken, Line, Options, Patience, in_turn};
use crate::gateway::station::{Follow, Input, Law, NotchValues, Place, Recorded, Station, Wave};

/// Points in one command.
const BUNCH: usize = 100;
/// Most points of a wave, most rows of a record: below what such controllers have for each table.
const MOST: (usize, usize) = (32_768, 32_768);
/// Longest wait for an array.
const ARRAY: Duration = Duration::from_secs(10);
/// Wait between two looks at the recorder.
const LOOK: Duration = Duration::from_millis(20);

/// The input signal that gives the targets of an axis, and what is added to it.
const SOURCE: u32 = 0x0600_0500;
const ADDED: u32 = 0x0600_0501;
const SERVO_TIME: u32 = 0x0E00_0200;
const P: u32 = 0x0700_0300;
const TI: u32 = 0x0700_0301;
const TD: u32 = 0x0700_0302;
const NOTCH_FREQUENCY: [u32; 2] = [0x0800_0100, 0x0800_0101];
const NOTCH_REJECTION: [u32; 2] = [0x0800_0200, 0x0800_0201];
/// P and T_d must be greater than 0.
const LEAST: f64 = 1e-9;
/// A rejection from which a notch filter is none.
const OFF: f64 = 0.999;
/// Rejections that are tried; the manual recommends 0.05.
const REJECTIONS: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.4];

/// One axis of such a controller.
#[derive(Debug)]
pub struct GcsStation {
    speech: Speech,
    timeout: Duration,
    identity: String,
    axis: String,
    /// Of the axis among all, from 1: its wave generator and output channel.
    number: usize,
    travel: [f64; 2],
    cycle: f64,
    is_open_loop: bool,
    /// An answer may still come that nobody waits for.
    is_late: bool,
}

impl GcsStation {
    /// Asks a controller who it is, and for travel and servo cycle of one axis.
    ///
    /// # Errors
    /// The line does not open, the answers are none, or the axis is not there.
    pub fn open(line: Box<dyn Line>, options: Options) -> Result<Self, String> {
        if options.axes.len() > 1 || !options.analog.is_empty() {
            return Err(
                "one axis at a time is played, read by its own sensor; give ?axes=1 and no analog="
                    .into(),
            );
        }
        let mut station = GcsStation {
            speech: Speech::new(line),
            timeout: options.timeout,
            identity: String::new(),
            axis: String::new(),
            number: 0,
            travel: [0.0; 2],
            cycle: 0.0,
            is_open_loop: options.open_loop,
            is_late: false,
        };
        station.speech.open(PATIENCE)?;
        station.identity = station.ask("*IDN?")?.trim().to_owned();
        // What was wrong before is not this call's.
        station.ask("ERR?")?;
        let all = station.ask("SAI?")?;
        let has: Vec<&str> = all.split_whitespace().collect();
        let wanted = options.axes.first().cloned().or_else(|| has.first().map(|a| (*a).to_owned()));
        let place = has.iter().position(|axis| Some(*axis) == wanted.as_deref());
        let Some((place, axis)) = place.zip(wanted) else {
            return Err(format!(
                "{}: has the axes {}; choose with ?axes=1",
                station.identity,
                has.join(", ")
            ));
        };
        (station.number, station.axis) = (place + 1, axis);
        station.travel = [station.number_of("TMN?")?, station.number_of("TMX?")?];
        station.cycle = station.parameter("1", SERVO_TIME)?;
        if !(station.cycle > 1e-6 && station.cycle < 1.0) {
            return Err(format!("its servo cycle (parameter 0x0E000200) is {} s", station.cycle));
        }
        Ok(station)
    }

    /// A question; one that the instrument does not know is not answered, but it says so afterwards.
    fn ask(&mut self, question: &str) -> Result<String, String> {
        let timeout = self.timeout;
        let answer = self.exchange(|speech| match speech.ask(question, timeout) {
            Err(Broken::Late) => speech.late(question, timeout),
            answer => answer,
        });
        answer.map_err(|broken| format!("{question}: {broken}"))
    }

    fn send(&mut self, command: &str) -> Result<(), String> {
        let timeout = self.timeout;
        let answer = self.exchange(|speech| speech.command(command, timeout));
        answer.map_err(|broken| broken.to_string())
    }

    /// One exchange, once a late answer has come.
    fn exchange<T>(
        &mut self,
        exchange: impl FnOnce(&mut Speech) -> Result<T, Broken>,
    ) -> Result<T, Broken> {
        let (identity, timeout) = (&self.identity, self.timeout);
        let settle = |speech: &mut Speech| speech.settle(identity, timeout, PATIENCE);
        in_turn(&mut self.is_late, &mut self.speech, settle, exchange)
    }

    /// The number of the axis behind a question.
    fn number_of(&mut self, question: &str) -> Result<f64, String> {
        let question = format!("{question} {}", self.axis);
        let answer = self.ask(&question)?;
        let found = text::numbers(&answer, std::slice::from_ref(&self.axis));
        found.map(|found| found[0]).map_err(|broken| format!("{question}: {broken}"))
    }

    fn parameter(&mut self, item: &str, id: u32) -> Result<f64, String> {
        let question = format!("SPA? {item} 0x{id:08X}");
        let answer = self.ask(&question)?;
        let value = answer.rsplit_once('=').and_then(|(_, value)| value.trim().parse::<f64>().ok());
        value.filter(|x| x.is_finite()).ok_or_else(|| format!("{question}: answered {answer:?}"))
    }

    fn set_parameter(&mut self, id: u32, value: f64) -> Result<(), String> {
        let axis = self.axis.clone();
        self.send(&format!("SPA {axis} 0x{id:08X} {value:.9e}"))?;
        let found = self.parameter(&axis, id)?;
        // Parameters are single-precision numbers there.
        if (found - value).abs() > 1e-4 * value.abs().max(1e-12) {
            return Err(format!("parameter 0x{id:08X} is {found} after {value} was written"));
        }
        Ok(())
    }

    /// Lets an input signal give the targets of the axis; 0: none.
    fn connect(&mut self, number: u32) -> Result<(), String> {
        let axis = self.axis.clone();
        self.send("CCL 1 advanced")?;
        let done = self.send(&format!("SPA {axis} 0x{SOURCE:08X} {number}"));
        let level = self.send("CCL 0");
        done.and(level)?;
        match self.connected()? {
            found if found == number => Ok(()),
            found => Err(format!("parameter 0x{SOURCE:08X} is {found} after {number} was written")),
        }
    }

    /// The input signal that gives the targets of the axis; 0: none.
    fn connected(&mut self) -> Result<u32, String> {
        let axis = self.axis.clone();
        Ok(self.parameter(&axis, SOURCE)? as u32)
    }

    fn configure(&mut self, wave: &Wave) -> Result<(), String> {
        let n = self.number;
        self.send(&format!("WGO {n} 0"))?;
        self.send(&format!("WCL {n}"))?;
        for (k, points) in wave.points.chunks(BUNCH).enumerate() {
            let append = if k == 0 { "X" } else { "&" };
            let values: Vec<String> = points.iter().map(|x| format!("{x:.6}")).collect();
            let (first, count) = (1 + k * BUNCH, points.len());
            self.send(&format!("WAV {n} {append} PNT {first} {count} {}", values.join(" ")))?;
        }
        self.send(&format!("WSL {n} {n}"))?;
        self.send(&format!("WTR {n} {} 0", wave.hold))?;
        self.send(&format!("WGC {n} {}", wave.cycles))?;
        self.send(&format!("WOS {n} 0"))?;
        self.record_every(wave.every)
    }

    /// What is recorded, and how often.
    fn record_every(&mut self, every: u32) -> Result<(), String> {
        let (n, axis) = (self.number, self.axis.clone());
        self.send(&format!("RTR {every}"))?;
        // Target, voltage of the output channel, position.
        self.send(&format!("DRC 1 {axis} 1"))?;
        self.send(&format!("DRC 2 {n} 7"))?;
        self.send(&format!("DRC 3 {axis} 2"))
    }

    fn record(
        &mut self,
        (rows, every, closed): (usize, u32, bool),
        go_on: &dyn Fn() -> bool,
    ) -> Result<Recorded, String> {
        let seconds = rows as f64 * f64::from(every) * self.cycle;
        let mut patience = Patience::new(1.2 * seconds + 5.0);
        loop {
            let answer = self.ask("DRL? 1")?;
            let count = answer.rsplit_once('=').and_then(|(_, n)| n.trim().parse::<usize>().ok());
            let count = count.ok_or_else(|| format!("DRL? 1: answered {answer:?}"))?;
            if count >= rows {
                break;
            }
            if patience.is_over() {
                return Err(format!(
                    "the recorder holds {count} rows of {rows} and goes on no more"
                ));
            }
            if !go_on() {
                return Err(format!(
                    "interrupted after {count} rows of {rows}: nothing is written"
                ));
            }
            sleep(LOOK);
        }
        let question = format!("DRR? 1 {rows} 1 2 3");
        let (period, columns) = self
            .exchange(|speech| speech.array(&question, ARRAY))
            .map_err(|broken| format!("{question}: {broken}"))?;
        let wanted = f64::from(every) * self.cycle;
        if (period / wanted - 1.0).abs() > 1e-3 {
            return Err(format!("it recorded every {period} s, where {wanted} s were asked for"));
        }
        let [target, voltage, position] = <[Vec<f64>; 3]>::try_from(columns)
            .map_err(|columns| format!("{question}: {} columns, not 3", columns.len()))?;
        let command = if closed { target } else { voltage.clone() };
        Ok(Recorded { period: wanted, command, voltage, position })
    }
}

impl Station for GcsStation {
    fn describe(&self) -> String {
        format!("{}; axis {}", self.identity, self.axis)
    }

    fn number(&self) -> usize {
        self.number
    }

    fn cycle(&self) -> f64 {
        self.cycle
    }

    fn most(&self) -> (usize, usize) {
        MOST
    }

    fn travel(&self) -> [f64; 2] {
        self.travel
    }

    fn is_open_loop(&self) -> bool {
        self.is_open_loop
    }

    fn place(&mut self) -> Result<Place, String> {
        let question = format!("VOL? {}", self.number);
        let answer = self.ask(&question)?;
        let voltage = text::numbers(&answer, &[self.number.to_string()])
            .map_err(|broken| format!("{question}: {broken}"))?[0];
        Ok(Place {
            closed: self.number_of("SVO?")? != 0.0,
            target: self.number_of("MOV?")?,
            voltage,
            position: self.number_of("POS?")?,
        })
    }

    fn servo(&mut self, closed: bool) -> Result<(), String> {
        let axis = self.axis.clone();
        self.send(&format!("SVO {axis} {}", u8::from(closed)))
    }

    fn command(&mut self, closed: bool, value: f64) -> Result<(), String> {
        let name = if closed { "MOV" } else { "SVA" };
        let axis = self.axis.clone();
        self.send(&format!("{name} {axis} {value:.6}"))
    }

    fn run(&mut self, wave: &Wave) -> Result<Recorded, String> {
        let n = self.number;
        self.configure(wave)?;
        self.send(&format!("WGO {n} 1"))?;
        let recorded = self.record((wave.rows, wave.every, wave.closed), &|| true);
        self.send(&format!("WGO {n} 0"))?;
        self.send("RTR 1")?;
        recorded
    }

    fn input(&mut self, number: u32) -> Result<Input, String> {
        let answer = self.ask("TSC?")?;
        let most =
            answer.trim().parse::<u32>().map_err(|_| format!("TSC?: answered {answer:?}"))?;
        if !(1..=most).contains(&number) {
            return Err(format!(
                "it has the input signals 1 to {most}, not {number}; its manual says which of them is its analog input"
            ));
        }
        let (axis, item) = (self.axis.clone(), number.to_string());
        let connected = self.connected()?;
        let question = format!("TSP? {item}");
        let answer = self.ask(&question)?;
        let value =
            text::numbers(&answer, &[item]).map_err(|broken| format!("{question}: {broken}"))?[0];
        Ok(Input { connected, target: Some(value + self.parameter(&axis, ADDED)?) })
    }

    fn follow(&mut self, follow: &Follow, go_on: &dyn Fn() -> bool) -> Result<Recorded, String> {
        let before = self.connected()?;
        self.record_every(follow.every)?;
        let connected = if before == follow.input { Ok(()) } else { self.connect(follow.input) };
        let recorded = connected
            .and_then(|()| self.send("DRT 0 4 0"))
            .and_then(|()| self.record((follow.rows, follow.every, true), go_on));
        // Whatever has gone wrong: nothing stays connected that was not.
        let back = if before == follow.input { Ok(()) } else { self.connect(before) };
        back.map_err(|error| {
            format!(
                "{error}; input signal {} may still give the targets: `SPA {} 0x{SOURCE:08X} 0` disconnects it",
                follow.input, self.axis
            )
        })?;
        let rate = self.send("RTR 1");
        let recorded = recorded?;
        rate.map(|()| recorded)
    }

    fn law(&mut self) -> Result<Law, String> {
        let axis = self.axis.clone();
        let ti = self.parameter(&axis, TI)?;
        let mut law = Law {
            kp: self.parameter(&axis, P)?,
            ki: if ti > 0.0 { 1.0 / ti } else { 0.0 },
            kd: self.parameter(&axis, TD)?,
            notches: Vec::new(),
        };
        for place in 0..2 {
            let frequency = self.parameter(&axis, NOTCH_FREQUENCY[place])?;
            let zeros = self.parameter(&axis, NOTCH_REJECTION[place])?;
            if zeros < OFF {
                law.notches.push(NotchValues { frequency, zeros, poles: 1.0 });
            }
        }
        Ok(law)
    }

    fn set_law(&mut self, law: &Law) -> Result<(), String> {
        self.send("CCL 1 advanced")?;
        let mut done = self.set_parameter(P, law.kp.max(LEAST));
        done = done
            .and_then(|()| self.set_parameter(TI, if law.ki > 0.0 { 1.0 / law.ki } else { 0.0 }));
        done = done.and_then(|()| self.set_parameter(TD, law.kd.max(LEAST)));
        for place in 0..2 {
            done = done.and_then(|()| match law.notches.get(place) {
                Some(notch) => {
                    self.set_parameter(NOTCH_FREQUENCY[place], notch.frequency)?;
                    self.set_parameter(NOTCH_REJECTION[place], notch.zeros)
                }
                None => self.set_parameter(NOTCH_REJECTION[place], 1.0),
            });
        }
        let level = self.send("CCL 0");
        done.and(level)
    }

    fn notches(&self, frequency: f64) -> (usize, Vec<NotchValues>) {
        let notch = |zeros: f64| NotchValues { frequency, zeros, poles: 1.0 };
        (2, REJECTIONS.map(notch).to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gateway::line::slow::Slow;

    fn says(question: &str) -> Option<String> {
        let answer = match question {
            "*IDN?" => "a controller",
            "ERR?" => "0",
            "SAI?" => "1",
            "TMN? 1" => "1=0",
            "TMX? 1" => "1=100",
            "SPA? 1 0x0E000200" => "1=0.001",
            "SPA? 1 0x07000301" => "1=30",
            _ => return None,
        };
        Some(format!("{answer}\n"))
    }

    /// A late answer is that of its own question, or nobody's.
    #[test]
    fn a_late_answer_is_not_taken_for_that_of_the_next_question() {
        for (late, found) in [(0, Some(30.0)), (1, Some(30.0)), (2, None), (20, None)] {
            let options = Options::parse("timeout=0.01", 0.01).unwrap();
            let line = Slow::new(late, says, |question| question.ends_with("301"));
            let mut station = GcsStation::open(line, options).unwrap();
            assert_eq!(station.parameter("1", 0x0700_0301).ok(), found, "{late}");
            assert_eq!(station.number_of("TMX?"), Ok(100.0), "{late}");
            assert_eq!(station.send("SVO 1 1"), Ok(()), "{late}");
        }
    }
}
