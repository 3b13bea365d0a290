//! Set points of an NV200 from its analog input.
//!
//! `modsrc,1` connects it, on older instruments `modon,1` switches it on. The instrument does not state where the input
//! is, so the set point is led there, and back, by a limit of the slew rate. The recorder has two channels, of which one
//! takes the set point: there is none for the voltage.
//!
//! Source: piezosystem jena, manual of the NV200/D NET, section 8.5; documentation of the Python library nv200.

use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{CYCLE, LOOK, Nv200Station};
use crate::gateway::line::Broken;
use crate::gateway::station::{Follow, Input, Recorded};

/// Sources of set points: commands, the analog input.
const COMMANDS: f64 = 0.0;
const ANALOG: f64 = 1.0;
const GENERATOR: f64 = 3.0;
/// Slew rate while it is led, in %/ms, and the time that the whole range takes with it, with room.
const LED: f64 = 0.5;
const LEAD: Duration = Duration::from_millis(300);

impl Nv200Station {
    pub(super) fn analog_input(&mut self, number: u32) -> Result<Input, String> {
        if number != 1 {
            return Err(format!(
                "an NV200 has one input signal, its analog input: give --follow 1, not {number}"
            ));
        }
        let source = self.number("modsrc")?;
        // Neither commands nor its wave generator are input signals.
        let connected = if source == GENERATOR { COMMANDS } else { source };
        Ok(Input { connected: connected as u32, target: None })
    }

    /// Whether the analog input is on; none: an instrument without that switch.
    fn switch(&mut self) -> Result<Option<f64>, String> {
        let timeout = self.device.options.timeout;
        match self.exchange(|device| device.number("modon", timeout)) {
            Ok(on) => Ok(Some(on)),
            Err(Broken::Refused(text)) if text.contains("unknown command") => Ok(None),
            Err(broken) => Err(format!("modon: {broken}")),
        }
    }

    /// Lets set points come from here, and leads the set point there.
    fn connect(&mut self, source: f64, go_on: &dyn Fn() -> bool) -> Result<(), String> {
        let rate = self.number("sr")?;
        self.send(&format!("sr,{LED}"))?;
        let done = self.send(&format!("modsrc,{source}")).map(|()| {
            let until = Instant::now() + LEAD;
            while source == ANALOG && Instant::now() < until && go_on() {
                sleep(LOOK);
            }
        });
        let back = self.send(&format!("sr,{rate}"));
        done.and(back)
    }

    pub(super) fn follow_analog(
        &mut self,
        follow: &Follow,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Recorded, String> {
        let was_connected = self.number("modsrc")? == ANALOG;
        for command in [
            "recast,0".to_owned(),
            "recsrc,0,0".to_owned(),
            "recsrc,1,1".to_owned(),
            format!("recstr,{}", follow.every),
            format!("reclen,{}", follow.rows),
        ] {
            self.send(&command)?;
        }
        if was_connected {
            return self.record_analog(follow, go_on);
        }
        let switch = self.switch()?;
        let switched = if switch == Some(0.0) { self.send("modon,1") } else { Ok(()) };
        let recorded = switched
            .and_then(|()| self.connect(ANALOG, go_on))
            .and_then(|()| self.record_analog(follow, go_on));
        // Whatever has gone wrong: nothing stays connected that was not. It takes over where the axis is.
        let back = self.number("meas").and_then(|position| {
            let [least, greatest] = self.travel;
            let here = format!("set,{:.6}", position.clamp(least, greatest));
            self.send(&here)?;
            self.connect(COMMANDS, go_on)?;
            self.send(&here)
        });
        let off = if switch == Some(0.0) { self.send("modon,0") } else { Ok(()) };
        back.and(off).map_err(|error| {
            format!(
                "{error}; the analog input may still give the set points: `modsrc,0` disconnects it"
            )
        })?;
        recorded
    }

    fn record_analog(
        &mut self,
        follow: &Follow,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Recorded, String> {
        self.send("recrun,1")?;
        let period = f64::from(follow.every) * CYCLE;
        let ended = self.wait(follow.rows as f64 * period, go_on);
        if ended.is_err() {
            self.send("recrun,0")?;
        }
        ended?;
        let (position, command) = (self.channel(0, follow.rows)?, self.channel(1, follow.rows)?);
        Ok(Recorded { period, command, voltage: Vec::new(), position })
    }
}
