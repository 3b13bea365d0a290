//! The tool `piezoloop`: identify, invert, pack, simulate, check, list, demo.
// Doc comments of commands are their help texts, with names such as axis[1].
#![allow(rustdoc::broken_intra_doc_links)]

mod answer;
mod commands;
mod documentation;
mod effects;
mod effects_docs;
mod fmus;
mod inputs;
mod libraries;
mod matching;
mod pages;
mod progress;
mod window;

use std::process::ExitCode;

use clap::Parser;

/// Closes the loop between a piezo-actuated machine and its model.
#[derive(Parser, Debug)]
#[command(name = "piezoloop", version = VERSION, about, long_about = None, arg_required_else_help = true)]
#[command(
    after_help = "Example:\n  piezoloop demo\n\nEach command has its own help with an example: piezoloop identify --help"
)]
struct Cli {
    /// Print the result as JSON
    #[arg(long, global = true)]
    json: bool,
    /// Print nothing but errors
    #[arg(long, short, global = true, conflicts_with = "json")]
    quiet: bool,
    #[command(subcommand)]
    command: commands::Command,
}

/// Version and commit.
const VERSION: &str = match env!("PIEZOLOOP_COMMIT").as_bytes() {
    [] => env!("CARGO_PKG_VERSION"),
    _ => concat!(env!("CARGO_PKG_VERSION"), " (", env!("PIEZOLOOP_COMMIT"), ")"),
};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let screen = answer::Screen { json: cli.json, quiet: cli.quiet };
    match cli.command.run(&screen) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            screen.error(&error);
            ExitCode::from(2)
        }
    }
}
