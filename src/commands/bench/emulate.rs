//! `piezoloop bench emulate`: another process that plays the machine.

use std::io::{self, Write};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, bail};
use bench::emulate::{Behaviour, Emulator, Injected, Plant, Script, Serve, Served, Timing, serve};
use bench::gateway::{Address, End, Place, Refused, Site};
use clap::Args;
use cli::{Answer, Screen};
use cosim::InstanceOptions;
use modeldescription::variable::Causality;
use serde::Serialize;

use super::instrument::Kind;
use super::{KeyOptions, channels};
use crate::{fmus, ranges};

/// Emulates the machine in real time with any plant FMU, and injects faults
///
/// Faults come from a script (TOML) or from --inject, as in loss,probability=0.01,from=1,to=2. Kinds: delay, jitter
/// (seconds); loss, duplicate, corrupt (probability); reorder (probability, seconds); stuck, nan (axis); saturation
/// (axis, min, max); quantisation (axis, step); offset (axis, value); invalid; power-loss; restart. All take from and
/// to in s of the machine's time; faults of packets also take direction=measurement, command or both.
///
/// --protocol gcs emulates an instrument of PI instead (General Command Set 2.0 over TCP), nv200 one of piezosystem
/// jena: a digital servo in front of the plant. Both work without faults, key and heartbeat, which these protocols
/// lack.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop bench emulate plant.fmu --gateway udp://127.0.0.1:9000 --rate 1k\n  piezoloop bench emulate evc-truth --gateway shm://stage --rate 2k --inject delay,seconds=1e-3 --inject quantisation,step=0.02\n  piezoloop bench emulate p1 --protocol gcs --rate 1k"
)]
pub(crate) struct Emulate {
    /// The plant: an FMU, a blueprint or the name of a rig
    plant: PathBuf,
    #[arg(long, value_name = "ADDRESS", value_parser = super::address, required_unless_present = "protocol", help = gateway_help())]
    gateway: Option<Address>,
    /// Protocol [default: that of the address]
    #[arg(long, value_name = "NAME")]
    protocol: Option<Protocol>,
    /// Voltage range of an instrument, if the plant's inputs have no bounds
    #[arg(long, value_name = "MIN..MAX", value_parser = ranges::limits())]
    volts: Option<[f64; 2]>,
    /// Voltages at the analog inputs of an instrument: a log with one record of equally spaced rows and a column in V for
    /// each input, from the first; it is repeated [default: of an instrument of PI the inputs are wired to second sensors
    /// of the axes, of an NV200 there are 0 V]
    #[arg(long, value_name = "FILE")]
    analog: Option<PathBuf>,
    /// The runner's address; packets from others are ignored [default: 127.0.0.1 and the next port]
    #[arg(long, value_name = "IP:PORT")]
    peer: Option<SocketAddr>,
    /// Steps per second, as in 10k
    #[arg(long, value_name = "HZ", value_parser = ranges::rate())]
    rate: f64,
    /// When the machine steps
    #[arg(long, value_name = "WHEN", default_value = "clock")]
    timing: When,
    /// Script of faults
    #[arg(long, value_name = "FILE")]
    faults: Option<PathBuf>,
    /// A fault: KIND,KEY=VALUE,… (may be given several times)
    #[arg(long, value_name = "FAULT")]
    inject: Vec<String>,
    /// Seed of all random numbers [default: the script's]
    #[arg(long, value_name = "S", value_parser = ranges::seed())]
    seed: Option<u64>,
    /// Steps without a command after which the machine stops itself
    #[arg(long, value_name = "STEPS", default_value_t = 100, value_parser = ranges::integers(1, u32::MAX))]
    heartbeat: u32,
    /// Safe values: commands while the machine is stopped [default: the plant's start values]
    #[arg(long, value_name = "VALUES", value_delimiter = ',', value_parser = ranges::signal())]
    safe: Vec<f64>,
    /// The plant's inputs [default: command…, otherwise all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    commands: Vec<String>,
    /// The plant's outputs, one for each input [default: position…, otherwise all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    positions: Vec<String>,
    #[command(flatten)]
    key: KeyOptions,
    /// End after this time in s [default: run until stopped]
    #[arg(long, value_name = "S", value_parser = ranges::above(0.0, ranges::LONGEST))]
    duration: Option<f64>,
}

/// What a machine speaks.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Protocol {
    /// The bench's packet
    Packet,
    /// General Command Set 2.0 of PI
    Gcs,
    /// Text protocol of piezosystem jena's NV200
    Nv200,
}

impl Protocol {
    /// The instrument that speaks it.
    fn instrument(self) -> Option<Kind> {
        match self {
            Self::Packet => None,
            Self::Gcs => Some(Kind::Gcs),
            Self::Nv200 => Some(Kind::Nv200),
        }
    }
}

/// When the machine steps.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum When {
    /// At its own deadlines, like a real machine
    Clock,
    /// Once per command: independent of this computer's jitter, so that the log is the same each time
    Commands,
}

#[derive(Serialize)]
struct Played {
    #[serde(flatten)]
    served: Served,
    /// Packets that were refused for their tags; none: there is no key.
    keyed: Option<Refused>,
}

/// The help of `--gateway`.
fn gateway_help() -> String {
    let mut forms = Address::forms(End::Machine);
    forms.extend(Kind::ALL.map(|kind| format!("{}://IP:PORT", kind.named().0)));
    let defaults = Kind::ALL.map(|kind| {
        let name = kind.named().0;
        format!("{name}: {name}://{}", kind.here())
    });
    format!(
        "Address of the machine: {} [default for --protocol {}]. With a file, as in gcs:///tmp/stage, the instrument is at \
         a serial line: a pseudo terminal to which the file becomes a link",
        super::alternatives(&forms),
        defaults.join(", for ")
    )
}

fn other_protocol(address: &Address) -> String {
    format!("{address}: does not go with that --protocol; the address says what is spoken there")
}

impl Emulate {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let gateway = match (self.protocol, &self.gateway) {
            (given, Some(address @ Address::Instrument { protocol, at, options })) => {
                let kind = Kind::of(protocol);
                if given.is_some_and(|given| kind.is_none() || given.instrument() != kind) {
                    bail!("{}", other_protocol(address));
                }
                let Some(kind) = kind else {
                    let known = Kind::ALL.map(|kind| kind.named().0).join(" or ");
                    bail!("{address}: there is no emulator of {}; give {known}", protocol.scheme)
                };
                return self.instrument(screen, kind, at.clone(), options);
            }
            (given, None) => match given.and_then(Protocol::instrument) {
                Some(kind) => return self.instrument(screen, kind, kind.here(), ""),
                None => bail!("give --gateway ADDRESS"),
            },
            (Some(Protocol::Gcs | Protocol::Nv200), Some(address)) => {
                bail!("{}", other_protocol(address))
            }
            (None | Some(Protocol::Packet), Some(address)) => address.clone(),
        };
        if self.volts.is_some() {
            bail!("--volts needs --protocol gcs or nv200");
        }
        if self.analog.is_some() {
            bail!(
                "--analog needs --protocol gcs or nv200: what is emulated here has no analog inputs"
            );
        }
        let script = self.script()?;
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        cli::interrupt::hand_over(move |_| flag.store(true, Ordering::Relaxed))?;
        let opened = fmus::open(&self.plant)?;
        let period_ns = (1e9 / self.rate).round() as u64;
        let commands = channels(&opened.fmu, &self.commands, Causality::Input, "command");
        let positions = channels(&opened.fmu, &self.positions, Causality::Output, "position");
        if !self.safe.is_empty() && self.safe.len() != commands.len() {
            bail!("--safe has {} values for {} commands", self.safe.len(), commands.len());
        }
        let slave = opened.fmu.instantiate("machine", &InstanceOptions::default())?;
        let step = period_ns as f64 / 1e9;
        let mut plant = Plant::new(slave, &commands, &positions, &self.safe, step)?;
        let safe = match self.safe.is_empty() {
            true => plant.commands()?,
            false => self.safe.clone(),
        };
        let timing = match self.timing {
            When::Clock => Timing::Clock,
            When::Commands => Timing::Commands,
        };
        let behaviour = Behaviour { timing, period_ns, heartbeat: self.heartbeat, safe };
        let mut emulator = Emulator::new(plant, behaviour, script);
        let address = gateway;
        let gateway = bench::gateway::open(&address, End::Machine, self.peer, &Site::default())?;
        let (mut gateway, line) =
            self.key.protect(gateway, &address, End::Machine, commands.len())?;
        line.into_iter().for_each(|line| screen.say(&line));
        let realtime = bench::clock::become_realtime();
        let names = (commands.join(", "), positions.join(", "));
        screen.say(&format!(
            "machine {} at {}: {} -> {}, {} steps per second; {}",
            opened.name, address, names.0, names.1, self.rate, realtime.line
        ));
        let duration_ns = self.duration.map(|seconds| (seconds * 1e9) as u64);
        let serve_until = Serve { stop: &stop, duration_ns };
        let served = serve(&mut emulator, &mut *gateway, &serve_until)?;
        screen.show(&Played { served, keyed: gateway.refused() })
    }

    /// Plays an instrument.
    fn instrument(
        &self,
        screen: &Screen,
        kind: Kind,
        at: Place,
        options: &str,
    ) -> anyhow::Result<u8> {
        let given = [
            (self.faults.is_some(), "--faults"),
            (!self.inject.is_empty(), "--inject"),
            (self.seed.is_some(), "--seed"),
            (self.peer.is_some(), "--peer"),
            (!self.safe.is_empty(), "--safe"),
            (self.heartbeat != 100, "--heartbeat"),
            (self.key.is_given(), "--key"),
            (self.timing == When::Commands, "--timing commands"),
            (!options.is_empty(), "options behind the address"),
        ];
        let some: Vec<&str> = given.iter().filter(|(is, _)| *is).map(|(_, name)| *name).collect();
        if !some.is_empty() {
            bail!("an instrument has no {}", some.join(", no "));
        }
        super::instrument::Play {
            plant: &self.plant,
            kind,
            at,
            rate: self.rate,
            volts: self.volts,
            analog: self.analog.as_deref(),
            commands: &self.commands,
            positions: &self.positions,
            duration: self.duration,
        }
        .run(screen)
    }

    fn script(&self) -> anyhow::Result<Script> {
        let mut script = match &self.faults {
            Some(file) => {
                let text = files::read_text(file)
                    .with_context(|| format!("{} cannot be read", file.display()))?;
                Script::parse(&text, &file.display().to_string())?
            }
            None => Script::default(),
        };
        for text in &self.inject {
            script.faults.push(Script::parse_fault(text)?);
        }
        script.seed = self.seed.unwrap_or(script.seed);
        Ok(script)
    }
}

impl Answer for Played {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let served = &self.served;
        writeln!(
            out,
            "{} steps; commands: {} used, {} lost, {} reordered, {} duplicate, {} corrupt{}",
            served.steps,
            served.commands.used,
            served.commands.lost,
            served.commands.reordered,
            served.commands.duplicate,
            served.commands.corrupt,
            if served.stopped { "; the machine stopped itself" } else { "" }
        )?;
        if let Some(Refused { forged, replayed }) = self.keyed {
            writeln!(
                out,
                "  key: {forged} packets without a right tag, {replayed} of another run or come before"
            )?;
        }
        for (what, injected) in [
            ("commands", &served.injected_into_commands),
            ("measurements", &served.injected_into_measurements),
        ] {
            let Injected { packets, lost, reordered, duplicated, corrupted } = injected;
            writeln!(
                out,
                "  injected into {packets} {what}: {lost} lost, {reordered} held back, {duplicated} doubled, {corrupted} damaged"
            )?;
        }
        Ok(())
    }
}
