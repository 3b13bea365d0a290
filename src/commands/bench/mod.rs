//! `piezoloop bench`: the controller FMU in real time next to a machine, and a machine to try it on.

mod campaign;
mod emulate;
mod recover;
mod run;

use clap::{Args, Subcommand};
use cosim::Fmu;
use modeldescription::variable::Causality;

use crate::answer::Screen;

/// Runs a controller FMU in real time next to a machine, or plays the machine
///
/// docs/gateway.md describes the packet that both exchange.
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
    Campaign(campaign::Run),
    Recover(recover::Recover),
    /// Print the packet's table of offsets
    Packet,
}

impl Bench {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        match self.command {
            Command::Run(command) => command.run(screen),
            Command::Emulate(command) => command.run(screen),
            Command::Campaign(command) => command.run(screen),
            Command::Recover(command) => command.run(screen),
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

/// `MIN..MAX` of a command line.
fn range(text: &str) -> Result<[f64; 2], String> {
    let parsed = text.split_once("..").and_then(|(min, max)| {
        let (min, max) = (min.trim().parse::<f64>().ok()?, max.trim().parse::<f64>().ok()?);
        (min < max).then_some([min, max])
    });
    parsed.ok_or_else(|| "write MIN..MAX with MIN < MAX, as in 0..120".to_owned())
}
