//! `piezoloop bench emulate --protocol gcs` or `nv200`: an instrument, with a piezo plant behind it.

use std::io::{self, Write};
use std::net::Ipv4Addr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, bail};
use bench::emulate::{GcsInstrument, Instrument, Nv200Instrument, Plant, Signals, Travel, travel};
use bench::gateway::{self, InstrumentServed, Place, gcs, nv200};
use cli::{Answer, Screen};
use cosim::{Fmu, InstanceOptions};
use data::{Log, ReadOptions, SampleTime};
use modeldescription::variable::Causality;
use serde::Serialize;

use super::channels;
use crate::fmus;

/// What an instrument speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Gcs,
    Nv200,
}

impl Kind {
    /// All that can be emulated.
    pub(super) const ALL: [Self; 2] = [Self::Gcs, Self::Nv200];

    /// The instrument of the addresses of a protocol.
    pub(super) fn of(protocol: &gateway::Protocol) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.named().0 == protocol.scheme)
    }

    /// Where it listens when nothing else is said. The port of the real NV200 is for administrators.
    pub(super) fn here(self) -> Place {
        let port = match self {
            Kind::Gcs => gcs::PORT,
            Kind::Nv200 => 50_000 + nv200::PORT,
        };
        Place::Net((Ipv4Addr::LOCALHOST, port).into())
    }

    /// What its addresses begin with, and the protocol's name.
    pub(super) fn named(self) -> (&'static str, &'static str) {
        match self {
            Kind::Gcs => ("gcs", "GCS 2.0"),
            Kind::Nv200 => ("nv200", "NV200"),
        }
    }
}

/// What is played.
pub(super) struct Play<'a> {
    pub(super) plant: &'a Path,
    pub(super) kind: Kind,
    pub(super) at: Place,
    pub(super) rate: f64,
    pub(super) volts: Option<[f64; 2]>,
    pub(super) analog: Option<&'a Path>,
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
        cli::interrupt::hand_over(move |_| flag.store(true, Ordering::Relaxed))?;
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
        let (scheme, protocol) = self.kind.named();
        let line = format!(
            "instrument {} at {scheme}://{}: {} axes ({protocol}), {} steps per second; {}",
            opened.name,
            self.at,
            axes.len(),
            self.rate,
            axes.join("; ")
        );
        let signals = self.analog.map(|file| signals(file, commands.len())).transpose()?;
        let mut instrument: Box<dyn Instrument> = match (self.kind, signals) {
            (Kind::Gcs, None) => Box::new(GcsInstrument::new(make()?, travel)),
            (Kind::Gcs, Some(signals)) => {
                Box::new(GcsInstrument::new(make()?, travel).with_signals(signals))
            }
            (Kind::Nv200, signals) => {
                let instrument = Nv200Instrument::new(make()?, travel).with_context(|| {
                    format!(
                        "an NV200 has one axis, {} has {}; choose with --commands and --positions",
                        opened.name,
                        commands.len()
                    )
                })?;
                match signals {
                    Some(signals) => Box::new(instrument.with_signals(signals)),
                    None => Box::new(instrument),
                }
            }
        };
        let duration_ns = self.duration.map(|seconds| (seconds * 1e9) as u64);
        let ready = || screen.say(&line);
        let served =
            gateway::serve(&mut *instrument, &self.at, period_ns, duration_ns, &stop, ready)??;
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

/// Most volts at an analog input.
const MOST_VOLTS: f64 = 10.0;

/// What is led to the analog inputs, from a log.
fn signals(file: &Path, inputs: usize) -> anyhow::Result<Signals> {
    let name = file.display();
    let log = Log::read(file, &ReadOptions::default())?;
    cli::note_on_log(&log.notes());
    let [record] = log.records() else {
        bail!(
            "{name}: has {} records; give a log with one, which is repeated",
            log.records().len()
        );
    };
    let period = log.sample_time(record, SampleTime::TOLERANCE)?.period;
    let columns = log.columns();
    if columns.is_empty() || columns.len() > inputs {
        bail!(
            "{name}: has {} columns for {inputs} analog inputs; give one in V for each, at most {inputs}",
            columns.len()
        );
    }
    let volts = |column: &data::Column| -> anyhow::Result<Vec<f64>> {
        let volts = match column.unit {
            Some(_) => log.convert(&column.name, "V")?,
            None => column.values.clone(),
        };
        if let Some(bad) = volts.iter().find(|v| !v.is_finite() || v.abs() > MOST_VOLTS) {
            bail!(
                "{name}: {} has {bad} V; an analog input takes -{MOST_VOLTS} to {MOST_VOLTS} V",
                column.name
            );
        }
        Ok(volts)
    };
    let columns = columns.iter().map(volts).collect::<anyhow::Result<_>>()?;
    Ok(Signals { period, columns })
}

impl Answer for Played {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let InstrumentServed { steps, connections, commands } = self.served;
        writeln!(out, "{steps} steps; {connections} connections, {commands} commands")
    }
}
