//! Wave generator, data recorder and servo parameters of an NV200.
//!
//! The generator has 1024 points in % of the range, the recorder two channels of 6144 values, both in steps of 50 µs. The
//! recorder is started by the generator; its rows are taken to begin with the generator's first point, and the command of
//! a row is that point.
//!
//! Source: piezosystem jena, Python library nv200 1.6.0.

mod analog;

use std::thread::sleep;
use std::time::Duration;

use super::{Nv200Device, PATIENCE, explained};
use crate::gateway::line::{Broken, Line, Options, Patience, in_turn};
use crate::gateway::station::{Follow, Input, Law, NotchValues, Place, Recorded, Station, Wave};

/// Step of generator, recorder and servo, in s.
const CYCLE: f64 = 50e-6;
/// Points of the generator, values of a recorder channel.
const MOST: (usize, usize) = (1024, 6144);
/// Longest wait for the recorder's values.
const ARRAY: Duration = Duration::from_secs(10);
/// Wait between two looks at the recorder.
const LOOK: Duration = Duration::from_millis(20);
/// Widths of the notch filter that are tried, as parts of its frequency.
const WIDTHS: [f64; 5] = [0.1, 0.3, 0.6, 1.0, 2.0];

/// Such an instrument.
#[derive(Debug)]
pub struct Nv200Station {
    device: Nv200Device,
    travel: [f64; 2],
    volts: [f64; 2],
    /// Points of the generator that were written, in %; one command for each takes long.
    points: Vec<String>,
    /// An answer may still come that nobody waits for.
    is_late: bool,
}

impl Nv200Station {
    /// Asks an instrument who it is and how far it goes.
    ///
    /// # Errors
    /// The line does not open, or the answers are none.
    pub fn open(line: Box<dyn Line>, options: Options) -> Result<Self, String> {
        let mut device = Nv200Device::connect(line, options)?;
        let mut number = |name: &str| device.number(name, PATIENCE).map_err(explained);
        let travel = [number("posmin")?, number("posmax")?];
        let volts = [number("avmin")?, number("avmax")?];
        Ok(Nv200Station { device, travel, volts, points: Vec::new(), is_late: false })
    }

    fn number(&mut self, name: &str) -> Result<f64, String> {
        let timeout = self.device.options.timeout;
        let number = self.exchange(|device| device.number(name, timeout));
        number.map_err(|broken| format!("{name}: {broken}"))
    }

    fn send(&mut self, command: &str) -> Result<(), String> {
        let done = self.exchange(|device| device.command(command));
        done.map_err(|broken| format!("{command}: {broken}"))
    }

    /// One exchange, once a late answer has come.
    fn exchange<T>(
        &mut self,
        exchange: impl FnOnce(&mut Nv200Device) -> Result<T, Broken>,
    ) -> Result<T, Broken> {
        let settle = |device: &mut Nv200Device| device.settle(PATIENCE);
        in_turn(&mut self.is_late, &mut self.device, settle, exchange)
    }

    /// What a recorder channel holds.
    fn channel(&mut self, channel: usize, rows: usize) -> Result<Vec<f64>, String> {
        let question = format!("recoutf,{channel}");
        let answer = self
            .exchange(|device| device.ask(&question, ARRAY))
            .map_err(|broken| format!("{question}: {broken}"))?;
        let values = answer.split(',').skip(1).map(|word| word.trim().parse::<f64>());
        let values = values.collect::<Result<Vec<_>, _>>();
        let values = values.map_err(|_| format!("{question}: a value is no number"))?;
        if values.len() < rows || values.iter().any(|x| !x.is_finite()) {
            return Err(format!("{question}: {} values, not {rows}", values.len()));
        }
        Ok(values[..rows].to_vec())
    }

    fn configure(&mut self, wave: &Wave) -> Result<(), String> {
        let [least, greatest] = if wave.closed { self.travel } else { self.volts };
        self.send("grun,0")?;
        for (index, value) in wave.points.iter().enumerate() {
            let percent = format!("{:.6}", 100.0 * (value - least) / (greatest - least));
            if self.points.get(index) != Some(&percent) {
                self.send(&format!("gbarb,{index},{percent}"))?;
                self.points.resize(self.points.len().max(index + 1), String::new());
                self.points[index] = percent;
            }
        }
        for command in [
            format!("gtarb,{}", wave.hold),
            "gsarb,0".to_owned(),
            format!("gearb,{}", wave.points.len() - 1),
            "goarb,0".to_owned(),
            format!("gcarb,{}", wave.cycles),
            "recsrc,0,0".to_owned(),
            "recsrc,1,2".to_owned(),
            format!("recstr,{}", wave.every),
            format!("reclen,{}", wave.rows),
            "recast,2".to_owned(),
            "modsrc,3".to_owned(),
        ] {
            self.send(&command)?;
        }
        Ok(())
    }

    fn wait(&mut self, seconds: f64, go_on: &dyn Fn() -> bool) -> Result<(), String> {
        let mut patience = Patience::new(1.2 * seconds + 5.0);
        while self.number("recrun")? != 0.0 {
            if patience.is_over() {
                return Err("the recorder does not come to its end".to_owned());
            }
            if !go_on() {
                return Err("interrupted while it recorded: nothing is written".to_owned());
            }
            sleep(LOOK);
        }
        Ok(())
    }

    fn record(&mut self, wave: &Wave) -> Result<Recorded, String> {
        self.wait(wave.duration(CYCLE), &|| true)?;
        let (position, voltage) = (self.channel(0, wave.rows)?, self.channel(1, wave.rows)?);
        let command = match wave.closed {
            true => (0..wave.rows).map(|row| wave.at(row)).collect(),
            false => voltage.clone(),
        };
        Ok(Recorded { period: f64::from(wave.every) * CYCLE, command, voltage, position })
    }
}

impl Station for Nv200Station {
    fn describe(&self) -> String {
        self.device.identity.clone()
    }

    fn number(&self) -> usize {
        1
    }

    fn cycle(&self) -> f64 {
        CYCLE
    }

    fn most(&self) -> (usize, usize) {
        MOST
    }

    fn travel(&self) -> [f64; 2] {
        self.travel
    }

    fn is_open_loop(&self) -> bool {
        self.device.options.open_loop
    }

    fn place(&mut self) -> Result<Place, String> {
        let closed = self.number("cl")? != 0.0;
        let set = self.number("set")?;
        let position = self.number("meas")?;
        // With the servo on only the recorder knows the voltage.
        let voltage = match closed {
            false => set,
            true => {
                for command in ["recast,0", "recsrc,1,2", "recstr,1", "reclen,1", "recrun,1"] {
                    self.send(command)?;
                }
                self.wait(CYCLE, &|| true)?;
                self.channel(1, 1)?[0]
            }
        };
        Ok(Place { closed, target: if closed { set } else { position }, voltage, position })
    }

    fn servo(&mut self, closed: bool) -> Result<(), String> {
        self.send("modsrc,0")?;
        self.send(&format!("cl,{}", u8::from(closed)))
    }

    fn command(&mut self, _: bool, value: f64) -> Result<(), String> {
        self.send(&format!("set,{value:.6}"))
    }

    fn run(&mut self, wave: &Wave) -> Result<Recorded, String> {
        let prepared = self.configure(wave);
        let recorded = match prepared {
            Ok(()) => self.send("grun,1").and_then(|()| self.record(wave)),
            Err(error) => Err(error),
        };
        self.send("grun,0")?;
        self.send("recast,0")?;
        // The last point of the wave goes on as a command.
        let last = wave.points.last().copied().unwrap_or_default();
        self.command(wave.closed, last)?;
        self.send("modsrc,0")?;
        self.command(wave.closed, last)?;
        recorded
    }

    fn input(&mut self, number: u32) -> Result<Input, String> {
        self.analog_input(number)
    }

    fn follow(&mut self, follow: &Follow, go_on: &dyn Fn() -> bool) -> Result<Recorded, String> {
        self.follow_analog(follow, go_on)
    }

    fn law(&mut self) -> Result<Law, String> {
        let notch = NotchValues {
            frequency: self.number("notchf")?,
            zeros: 0.0,
            poles: 0.5 * self.number("notchb")? / self.number("notchf")?.max(1.0),
        };
        let is_on = self.number("notchon")? != 0.0;
        Ok(Law {
            kp: self.number("kp")?,
            ki: self.number("ki")?,
            kd: self.number("kd")?,
            notches: if is_on { vec![notch] } else { Vec::new() },
        })
    }

    fn set_law(&mut self, law: &Law) -> Result<(), String> {
        for (name, value) in [("kp", law.kp), ("ki", law.ki), ("kd", law.kd)] {
            self.send(&format!("{name},{value:.9}"))?;
        }
        // Narrow first: the width is bounded by the frequency.
        self.send("notchb,1")?;
        if let Some(notch) = law.notches.first() {
            self.send(&format!("notchf,{:.3}", notch.frequency))?;
            self.send(&format!("notchb,{:.3}", 2.0 * notch.poles * notch.frequency))?;
        }
        self.send(&format!("notchon,{}", u8::from(!law.notches.is_empty())))?;
        let found = self.law()?;
        let differ = |a: f64, b: f64| (a - b).abs() > 1e-3 * b.abs().max(1e-6);
        let is_other = [(found.kp, law.kp), (found.ki, law.ki), (found.kd, law.kd)]
            .iter()
            .any(|(found, wanted)| differ(*found, *wanted));
        if is_other || found.notches.len() != law.notches.len() {
            return Err(format!("the instrument has {found:?} after {law:?} was written"));
        }
        Ok(())
    }

    fn notches(&self, frequency: f64) -> (usize, Vec<NotchValues>) {
        let notch = |width: f64| NotchValues { frequency, zeros: 0.0, poles: 0.5 * width };
        (1, WIDTHS.map(notch).to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gateway::line::slow::Slow;

    fn says(question: &str) -> Option<String> {
        let answer = match question {
            "" => "NV200/D_NET>\r\n",
            "posmin" | "avmin" => "0",
            "posmax" | "avmax" => "100",
            "meas" => "50",
            "kp" => "0.5",
            "ki" => "30",
            "ki,-1" => "error,4\r\n",
            "cl,1" => "",
            _ => "error,2\r\n",
        };
        let is_value = answer.parse::<f64>().is_ok();
        let text = if is_value { format!("{question},{answer}\r\n") } else { answer.into() };
        Some(format!("{text}\u{11}"))
    }

    /// A late answer is nobody's.
    #[test]
    fn a_late_answer_is_not_taken_for_that_of_the_next_question() {
        for late in [0, 1, 2, 20] {
            let options = Options::parse("timeout=0.01", 0.01).unwrap();
            let line = Slow::new(late, says, |question| matches!(question, "kp" | "cl,1"));
            let station = &mut Nv200Station::open(line, options).unwrap();
            assert_eq!(station.number("kp").ok(), (late == 0).then_some(0.5), "{late}");
            assert_eq!(station.number("ki"), Ok(30.0), "{late}");
            assert_eq!(station.send("cl,1").is_ok(), late == 0, "{late}");
            let refused = station.send("ki,-1").unwrap_err();
            assert!(refused.contains("the range is exceeded"), "{late}: {refused}");
            assert_eq!(station.number("meas"), Ok(50.0), "{late}");
            assert_eq!(station.send("cl,1").is_ok(), late == 0, "{late}");
            assert_eq!(station.number("ki"), Ok(30.0), "{late}");
        }
    }
}
