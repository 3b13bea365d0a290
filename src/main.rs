//! The tool `piezoloop`: identify, invert, pack, simulate, check, list, demo.
// Doc comments of commands are their help texts, with names such as axis[1].
#![allow(rustdoc::broken_intra_doc_links)]

mod commands;
mod documentation;
mod effects;
mod effects_docs;
mod fmus;
mod inputs;
mod libraries;
mod messages;
mod packing;
mod pages;
mod ports;
mod progress;
mod ranges;
mod records;
mod reference;
mod results;
mod times;
mod usage;
mod window;
mod wrapped;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser};

/// Closes the loop between a piezo-actuated machine and its model: identify, invert, pack as FMU, simulate, diagnose.
#[derive(Parser, Debug)]
#[command(name = "piezoloop", version = VERSION, about, long_about = None, arg_required_else_help = true)]
#[command(
    after_help = "Example:\n  piezoloop demo\n\nEach command has its own help with an example: piezoloop identify --help"
)]
struct Cli {
    /// Print the result as JSON
    // A path like that of `diagnose --json FILE`, which takes the place of this one there.
    #[arg(long, global = true, help_heading = COMMON, num_args = 0, default_missing_value = cli::STANDARD_OUTPUT)]
    json: Option<PathBuf>,
    /// Print errors only
    #[arg(long, short, global = true, help_heading = COMMON)]
    quiet: bool,
    /// Greatest number of internal steps between two rows of a log; beyond it the log's time is taken to be in a
    /// wrong unit
    #[arg(long, global = true, help_heading = COMMON, value_name = "N", default_value_t = data::inner_steps::MOST, hide_short_help = true)]
    #[arg(value_parser = ranges::integers(1_u64, 1_000_000_000_000))]
    most_steps: u64,
    #[command(subcommand)]
    command: commands::Command,
}

/// Heading of the options that every command has.
const COMMON: &str = "Options of every command";

/// Version and commit.
const VERSION: &str = match env!("PIEZOLOOP_COMMIT").as_bytes() {
    [] => env!("CARGO_PKG_VERSION"),
    _ => concat!(env!("CARGO_PKG_VERSION"), " (", env!("PIEZOLOOP_COMMIT"), ")"),
};

/// The files and folders that the command line names.
fn named(matches: &ArgMatches) -> impl Iterator<Item = &PathBuf> {
    let mut deepest = matches;
    while let Some((_, inner)) = deepest.subcommand() {
        deepest = inner;
    }
    let of = |id: &clap::Id| deepest.try_get_many::<PathBuf>(id.as_str()).ok().flatten();
    deepest.ids().filter_map(of).flatten()
}

fn main() -> ExitCode {
    let matches = usage::matches();
    let named: Vec<PathBuf> = named(&matches).cloned().collect();
    files::guard(named.iter().map(PathBuf::as_path));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let json = cli.json.as_deref() == Some(Path::new(cli::STANDARD_OUTPUT));
    if json && cli.quiet {
        let message = "the argument '--json' cannot be used with '--quiet': it prints the result";
        Cli::command().error(clap::error::ErrorKind::ArgumentConflict, message).exit();
    }
    let screen = cli::Screen::new(json, cli.quiet);
    let is_worker = matches!(cli.command, commands::Command::FmuWorker);
    // A worker ends with its master; that one asks how far steps may go.
    data::inner_steps::allow(if is_worker { u64::MAX } else { cli.most_steps });
    let _tidy = (!is_worker).then(cli::interrupt::begin);
    // How a worker ends its master tells.
    if !is_worker {
        exits::guard(cosim::instances, cosim::called);
    }
    let kept = if json { cli::keep_standard_output() } else { Ok(()) };
    let outcome = kept.and_then(|()| cli.command.run(&screen));
    cli::interrupt::wait_if_ending();
    exits::finished();
    match outcome {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            screen.error(&error, &named);
            ExitCode::from(2)
        }
    }
}
