//! `piezoloop bench emulate --protocol gcs`: an instrument of PI, with a piezo plant behind it.

use std::io::{self, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::bail;
use bench::emulate::{Instrument, Plant, Travel, travel};
use bench::gateway::gcs::{self, InstrumentServed};
use cosim::{Fmu, InstanceOptions};
use modeldescription::variable::Causality;
use serde::Serialize;

use super::channels;
use crate::answer::{Answer, Screen};
use crate::{fmus, interrupt};

/// Where an instrument listens when nothing else is said.
pub(super) fn here() -> SocketAddr {
    (Ipv4Addr::LOCALHOST, gcs::PORT).into()
}

/// What is played.
pub(super) struct Play<'a> {
    pub(super) plant: &'a Path,
    pub(super) at: SocketAddr,
    pub(super) rate: f64,
    pub(super) volts: Option<[f64; 2]>,
    pub(super) commands: &'a [String],
    pub(super) positions: &'a [String],
    pub(super) duration: Option<f64>,
}

#[derive(Serialize)]
struct Played {
    #[serde(flatten)]
    served: InstrumentServed,
}

impl Play<'_> {
    pub(super) fn run(&self, screen: &Screen) -> anyhow::Result<u8> {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        interrupt::hand_over(move |_| flag.store(true, Ordering::Relaxed))?;
        let opened = fmus::open(self.plant)?;
        let period_ns = (1e9 / self.rate).round() as u64;
        let commands = channels(&opened.fmu, self.commands, Causality::Input, "command");
        let positions = channels(&opened.fmu, self.positions, Causality::Output, "position");
        let make = || -> anyhow::Result<Plant> {
            let slave = opened.fmu.instantiate("instrument", &InstanceOptions::default())?;
            Ok(Plant::new(slave, &commands, &positions, &[], period_ns as f64 / 1e9)?)
        };
        let volts = commands.iter().map(|name| self.volts_of(&opened.fmu, name));
        let volts = volts.collect::<anyhow::Result<Vec<_>>>()?;
        let travel = travel(make()?, &volts)?;
        let shown =
            |(name, Travel { volts: [a, b], positions: [from, to] }): (&String, &Travel)| {
                format!("{name} {a} to {b} leads from {from:.6} to {to:.6}")
            };
        let axes: Vec<String> = commands.iter().zip(&travel).map(shown).collect();
        let line = format!(
            "instrument {} at gcs://{}: {} axes (GCS 2.0), {} steps per second; {}",
            opened.name,
            self.at,
            axes.len(),
            self.rate,
            axes.join("; ")
        );
        let mut instrument = Instrument::new(make()?, travel);
        let duration_ns = self.duration.map(|seconds| (seconds * 1e9) as u64);
        let ready = || screen.say(&line);
        let served = gcs::serve(&mut instrument, self.at, period_ns, duration_ns, &stop, ready)??;
        screen.show(&Played { served })
    }

    /// Least and greatest voltage of an input.
    fn volts_of(&self, fmu: &Fmu, name: &str) -> anyhow::Result<[f64; 2]> {
        let range = fmu.variable(name)?.properties;
        let declared = range.min.zip(range.max).map(|(min, max)| [min.as_f64(), max.as_f64()]);
        let Some(volts) = self.volts.or(declared) else {
            bail!("{name}: has no bounds in the plant; give --volts MIN..MAX");
        };
        if !volts.iter().all(|volt| volt.is_finite()) || volts[0] >= volts[1] {
            bail!(
                "{name}: {} to {} is no range of voltages; give --volts MIN..MAX",
                volts[0],
                volts[1]
            );
        }
        Ok(volts)
    }
}

impl Answer for Played {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let InstrumentServed { steps, connections, commands } = self.served;
        writeln!(out, "{steps} steps; {connections} connections, {commands} commands")
    }
}
