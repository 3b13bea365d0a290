//! `piezoloop completions`, `piezoloop man`: what a shell and a manual know about the tool.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use clap_complete::Shell;
use cli::{Answer, Screen};
use data::AtomicFile;
use serde::Serialize;

use crate::usage;

/// Prints a script with which a shell completes commands and options
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop completions bash > ~/.local/share/bash-completion/completions/piezoloop\n  piezoloop completions zsh > ~/.zfunc/_piezoloop\n  piezoloop completions powershell >> $PROFILE"
)]
pub(crate) struct Completions {
    /// The shell
    shell: Shell,
}

/// Writes manual pages (troff), one for the tool and one for each command
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  piezoloop man -o ~/.local/share/man/man1\n  man piezoloop-identify"
)]
pub(crate) struct Man {
    /// The folder to write to; created if it does not exist
    #[arg(short = 'o', long = "out", value_name = "FOLDER")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Script {
    shell: String,
    script: String,
}

impl Answer for Script {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(self.script.as_bytes())
    }
}

#[derive(Serialize)]
struct Pages {
    files: Vec<PathBuf>,
}

impl Answer for Pages {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        self.files.iter().try_for_each(|file| writeln!(out, "{}", file.display()))
    }
}

impl Completions {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut usage::command(), "piezoloop", &mut script);
        let script = String::from_utf8(script).context("the completion script is no UTF-8")?;
        screen.show(&Script { shell: self.shell.to_string(), script })
    }
}

impl Man {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let mut tool = usage::command().disable_help_subcommand(true);
        // Hands the global options on to the commands.
        tool.build();
        std::fs::create_dir_all(&self.out)
            .with_context(|| format!("{}: cannot be made", self.out.display()))?;
        let mut files = Vec::new();
        pages(&tool, &self.out, &mut files)?;
        screen.show(&Pages { files })
    }
}

/// The page of a command and those of its own commands.
fn pages(command: &clap::Command, folder: &Path, files: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned();
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone()).render(&mut page)?;
    let path = folder.join(format!("{name}.1"));
    let is_ours = || std::fs::read_to_string(&path).is_ok_and(|page| page.contains("piezoloop"));
    files::check_beside(&path, is_ours)
        .with_context(|| format!("{}: cannot be written", path.display()))?;
    AtomicFile::write_all_of(&path, &page)
        .with_context(|| format!("{}: cannot be written", path.display()))?;
    files.push(path);
    let shown = command.get_subcommands().filter(|command| !command.is_hide_set());
    shown.into_iter().try_for_each(|command| pages(command, folder, files))
}
