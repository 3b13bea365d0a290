//! The tool as a program, which carries the FMUs' libraries.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use data::Blueprint;

/// Name of the tool's program.
const NAME: &str = if cfg!(windows) { "piezoloop.exe" } else { "piezoloop" };

/// The program `piezoloop`: packs FMUs, and identifies as a user does.
#[derive(Clone, Debug)]
pub struct Tool {
    program: PathBuf,
}

impl Tool {
    /// The tool that is given; none: that in the folder of this program.
    ///
    /// # Errors
    /// Where there is no such program.
    pub fn find(given: Option<&Path>) -> anyhow::Result<Self> {
        if let Some(given) = given {
            let found = given.canonicalize();
            let program = found
                .with_context(|| format!("--tool {}: there is no such program", given.display()))?;
            return Ok(Self { program });
        }
        let own =
            std::env::current_exe().context("this program does not find itself; use --tool")?;
        // Tests are built into a folder below.
        let folders = own.ancestors().skip(1).take(2);
        let Some(program) = folders.map(|folder| folder.join(NAME)).find(|file| file.is_file())
        else {
            bail!(
                "{}: there is no such program, which packs the FMUs of the experiments; build it with `cargo build \
                 --release`, or give --tool PROGRAM",
                own.with_file_name(NAME).display()
            );
        };
        Ok(Self { program })
    }

    /// Packs the FMU `file` of a blueprint, which is written beside it.
    ///
    /// # Errors
    /// Where the blueprint cannot be built, or a file cannot be written.
    pub fn pack(&self, blueprint: &Blueprint, file: &Path) -> anyhow::Result<()> {
        let text = file.with_extension("toml");
        blueprint.check(learned::COMPONENTS)?.write(&text)?;
        self.pack_file(&text, file)
    }

    /// Packs the FMU `file` of a blueprint's file, or of the rig of this name.
    ///
    /// # Errors
    /// What the tool reports.
    pub fn pack_file(&self, what: &Path, file: &Path) -> anyhow::Result<()> {
        self.run([OsStr::new("pack"), what.as_os_str(), OsStr::new("-o"), file.as_os_str()])
    }

    /// Identifies with these arguments of `piezoloop identify`, which name the blueprint that it writes.
    ///
    /// # Errors
    /// What the tool reports.
    pub fn identify(&self, arguments: &[&str]) -> anyhow::Result<()> {
        self.run(["identify"].iter().chain(arguments).map(OsStr::new))
    }

    fn run<'a>(&self, arguments: impl IntoIterator<Item = &'a OsStr>) -> anyhow::Result<()> {
        let mut command = Command::new(&self.program);
        command.arg("--quiet").args(arguments).stdin(Stdio::null());
        let output = command
            .output()
            .with_context(|| format!("{} cannot be started", self.program.display()))?;
        if !output.status.success() {
            let message = String::from_utf8_lossy(&output.stderr);
            let message = message.trim();
            bail!("{}", message.strip_prefix("error: ").unwrap_or(message));
        }
        Ok(())
    }
}
