//! `piezoloop bench`: the controller FMU in real time next to a machine, and a machine to try it on.

mod campaign;
mod emulate;
mod instrument;
mod measure;
mod recover;
mod replay;
mod run;
mod tune;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use bench::gateway::{self, Address, End, Gateway, Key, KeyedGateway};
use clap::{Args, Subcommand};
use cli::Screen;
use cosim::Fmu;
use modeldescription::variable::Causality;

/// Runs a controller FMU in real time with a machine, or emulates the machine
///
/// docs/gateway.md describes the packets between runner and machine.
#[derive(Args, Debug)]
#[command(
    after_help = "Example, in two terminals:\n  piezoloop bench emulate plant.fmu --gateway udp://127.0.0.1:9000 --rate 1k\n  piezoloop bench run controller.fmu --gateway udp://127.0.0.1:9000 --rate 1k --reference ref.csv --record run.parquet"
)]
pub(crate) struct Bench {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    Run(Box<run::Run>),
    Emulate(Box<emulate::Emulate>),
    Measure(Box<measure::Measure>),
    Tune(Box<tune::Tune>),
    Campaign(campaign::Run),
    Recover(recover::Recover),
    Replay(replay::Replay),
    /// Prints the packet's table of offsets
    Packet,
    /// Prints gateway.h, the C interface of plugin://FILE
    Header,
}

impl Bench {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        match self.command {
            Command::Run(command) => command.run(screen),
            Command::Emulate(command) => command.run(screen),
            Command::Measure(command) => command.run(screen),
            Command::Tune(command) => command.run(screen),
            Command::Campaign(command) => command.run(screen),
            Command::Recover(command) => command.run(screen),
            Command::Replay(command) => command.run(screen),
            Command::Header => {
                screen.say(gateway::C_HEADER.trim_end());
                Ok(0)
            }
            Command::Packet => {
                screen.say(bench::packet::layout_table().trim_end());
                Ok(0)
            }
        }
    }
}

/// The channels that are given; else those whose names begin with a word; else all.
fn channels(fmu: &Fmu, given: &[String], causality: Causality, word: &str) -> Vec<String> {
    if !given.is_empty() {
        return given.to_vec();
    }
    let all = fmu.names(causality);
    let some: Vec<String> = all.iter().filter(|name| name.starts_with(word)).cloned().collect();
    if some.is_empty() { all } else { some }
}

/// `run.parquet.journal` of `run.parquet`.
fn journal_of(record: &Path) -> PathBuf {
    let mut name = record.as_os_str().to_owned();
    name.push(".journal");
    PathBuf::from(name)
}

/// The key of a gateway on a network that others are on.
#[derive(Args, Debug, Clone, Default)]
pub(super) struct KeyOptions {
    /// Key file of 16 to 4096 bytes, the same for runner and machine: packets carry an authentication tag; packets
    /// with a wrong tag and replayed packets are refused (udp:// only)
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
}

/// An address, whose message clap puts behind the value.
pub(super) fn address(text: &str) -> Result<Address, String> {
    text.parse().map_err(|error: gateway::GatewayError| {
        error.to_string().replacen(&format!("gateway `{text}`: "), "", 1)
    })
}

/// Ways to write an address, as in `udp://IP:PORT, shm://NAME or gcs://IP:PORT`.
fn alternatives(all: &[String]) -> String {
    match all {
        [] => String::new(),
        [only] => only.clone(),
        [others @ .., last] => format!("{} or {last}", others.join(", ")),
    }
}

/// The help of an address of an instrument with its own wave generator and data recorder.
fn instrument_help() -> String {
    let known = gateway::PROTOCOLS.iter().filter(|protocol| protocol.station.is_some());
    let places = known.flat_map(|protocol| {
        ["IP", "/dev/ttyUSB0"].map(|place| format!("{}://{place}", protocol.scheme))
    });
    let all = alternatives(&places.collect::<Vec<_>>());
    format!("The instrument: {all}, with ?axes=N to choose an axis")
}

impl KeyOptions {
    fn is_given(&self) -> bool {
        self.key.is_some()
    }

    /// Puts the key around a gateway, and says in a line how it stands.
    fn protect(
        &self,
        gateway: Box<dyn Gateway>,
        address: &Address,
        end: End,
        channels: usize,
    ) -> anyhow::Result<(Box<dyn Gateway>, Option<String>)> {
        let Some(file) = &self.key else {
            let is_shared = matches!(address, Address::Udp(machine) if !machine.ip().is_loopback());
            let note = "note: without --key whoever reaches this port can command the machine and end the run";
            return Ok((gateway, is_shared.then(|| note.to_owned())));
        };
        if !matches!(address, Address::Udp(_)) {
            bail!("--key is for udp://IP:PORT only; {address} cannot be reached by others");
        }
        let key = Key::read(file)?;
        let mut line = format!(
            "key: HMAC-SHA-256, {:.2} us per cycle",
            1e6 * KeyedGateway::cost(&key, channels)
        );
        if others_read(file) {
            line.push_str(&format!("; others can read {0}: chmod 600 {0}", file.display()));
        }
        let session = getrandom::u64().context("the system gives no random number")?;
        Ok((Box::new(KeyedGateway::new(gateway, end, key, session)), Some(line)))
    }
}

/// Whether other users of this computer can read a file.
#[cfg(unix)]
fn others_read(file: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    std::fs::metadata(file).is_ok_and(|found| found.is_file() && found.mode() & 0o044 != 0)
}

#[cfg(not(unix))]
fn others_read(_: &Path) -> bool {
    false
}
