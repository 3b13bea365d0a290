//! Wave generator and data recorder of the emulated NV200.

use super::super::generator::Seen;
use super::{GENERATOR, MISSING, Nv200Instrument, POINTS, RANGE, VALUES};

pub(super) const NAMES: [&str; 16] = [
    "grun", "gsarb", "gearb", "goarb", "gcarb", "gtarb", "giarb", "gbarb", "recsrc", "recast",
    "recstr", "reclen", "recrun", "recidx", "recout", "recoutf",
];

type Answer = Result<String, u8>;

fn number<T: std::str::FromStr>(word: &str) -> Result<T, u8> {
    word.parse().map_err(|_| MISSING)
}

fn within<T: std::str::FromStr + PartialOrd>(word: &str, least: T, most: T) -> Result<T, u8> {
    let value = number::<T>(word)?;
    if (least..=most).contains(&value) { Ok(value) } else { Err(RANGE) }
}

impl Nv200Instrument {
    /// A command or a question of these.
    pub(super) fn record(&mut self, name: &str, values: &[&str]) -> Answer {
        let reply = |value: String| Ok(format!("{name},{value}\r\n"));
        let generator = &self.stage.generators[0];
        let recorder = &self.stage.recorder;
        match (name, values) {
            ("grun", []) => reply(u8::from(generator.is_running()).to_string()),
            ("gsarb", []) => reply(self.range[0].to_string()),
            ("gearb", []) => reply(self.range[1].to_string()),
            ("goarb", []) => reply(generator.first.to_string()),
            ("gcarb", []) => reply(generator.cycles.to_string()),
            ("gtarb", []) => reply(generator.hold.to_string()),
            ("giarb", []) => reply((self.range[0] + generator.index()).to_string()),
            ("gbarb", [index]) => {
                let index = within(index, 0, POINTS - 1)?;
                reply(format!("{index},{}", self.wave[index]))
            }
            ("recsrc", [channel]) => {
                let channel = within(channel, 0, 1)?;
                reply(format!("{channel},{}", number_of(recorder.sources[channel].1)))
            }
            ("recast", []) => reply(self.autostart.to_string()),
            ("recstr", []) => reply(recorder.every.to_string()),
            ("reclen", []) => reply(recorder.length.to_string()),
            ("recrun", []) => reply(u8::from(recorder.is_running()).to_string()),
            ("recidx", []) => reply(recorder.tables[0].len().to_string()),
            ("recout", [channel, first, count]) => {
                let (channel, first) = (within(channel, 0, 1)?, within(first, 0, VALUES - 1)?);
                let count = within(count, 1, VALUES - first)?;
                let values = self.values(channel, first, count);
                reply(format!("{channel},{first},{}", values.join(",")))
            }
            ("recoutf", [channel]) => {
                let channel = within(channel, 0, 1)?;
                let values = self.values(channel, 0, recorder.length);
                reply(format!("{channel},{}", values.join(",")))
            }
            _ => self.set_record(name, values).map(|()| String::new()),
        }
    }

    /// What is recorded; 0 where nothing is yet.
    fn values(&self, channel: usize, first: usize, count: usize) -> Vec<String> {
        let rest = self.stage.recorder.tables[channel].iter().skip(first).copied();
        let all = rest.chain(std::iter::repeat(0.0)).take(count);
        all.map(|value| format!("{value:.6}")).collect()
    }

    fn set_record(&mut self, name: &str, values: &[&str]) -> Result<(), u8> {
        let generator = &mut self.stage.generators[0];
        let recorder = &mut self.stage.recorder;
        match (name, values) {
            ("grun", ["0"]) => generator.stop(),
            ("grun", ["1"]) => self.run(),
            ("gsarb", [index]) => self.range[0] = within(index, 0, POINTS - 1)?,
            ("gearb", [index]) => self.range[1] = within(index, 0, POINTS - 1)?,
            ("goarb", [index]) => generator.first = within(index, 0, POINTS - 1)?,
            ("gcarb", [cycles]) => generator.cycles = within(cycles, 0, 65_535)?,
            ("gtarb", [hold]) => generator.hold = within(hold, 1, 65_535)?,
            ("gbarb", [index, value]) => {
                let index = within(index, 0, POINTS - 1)?;
                self.wave[index] = within(value, 0.0, 100.0)?;
            }
            ("recsrc", [channel, source]) => {
                let seen = seen_of(number(source)?).ok_or(RANGE)?;
                recorder.sources[within(channel, 0, 1)?] = (0, seen);
            }
            ("recast", [mode]) => self.autostart = within(mode, 0, 2)?,
            ("recstr", [every]) => recorder.every = within(every, 1, 65_535)?,
            ("reclen", [length]) => recorder.length = within(length, 1, VALUES)?,
            ("recrun", ["0"]) => recorder.stop(),
            ("recrun", ["1"]) => recorder.start(),
            _ => return Err(MISSING),
        }
        Ok(())
    }

    /// Starts the generator, where targets come from it.
    fn run(&mut self) {
        if self.source != GENERATOR {
            return;
        }
        let (axis, travel) = (self.stage.axes[0], self.stage.travel[0]);
        let [low, high] = if axis.servo { travel.range() } else { travel.volts };
        let [first, last] = self.range;
        let generator = &mut self.stage.generators[0];
        let points = self.wave.get(first..=last).unwrap_or_default();
        generator.table = points.iter().map(|x| low + 0.01 * x * (high - low)).collect();
        generator.start();
        if self.autostart == 2 {
            self.stage.recorder.start();
        }
    }
}

fn seen_of(source: u32) -> Option<Seen> {
    Some(match source {
        0 => Seen::Position,
        1 => Seen::Target,
        2 => Seen::Voltage,
        3 => Seen::Error,
        4 => Seen::AbsoluteError,
        _ => return None,
    })
}

fn number_of(seen: Seen) -> u32 {
    match seen {
        Seen::Nothing | Seen::Position => 0,
        Seen::Target => 1,
        Seen::Voltage => 2,
        Seen::Error => 3,
        Seen::AbsoluteError => 4,
    }
}
