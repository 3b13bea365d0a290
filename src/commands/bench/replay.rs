//! `piezoloop bench replay`: a record's controller, stepped again and compared by the bit.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use bench::cycle::Driver;
use bench::record::Recording;
use bench::replay::{Difference, Recipe, Replayed, replay};
use clap::Args;
use cli::{Answer, Screen, note_on_log};
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::fmus;

/// Steps the controller through a record again and compares every command bit by bit
///
/// A record of `bench run` or `bench campaign` contains the hash and path of its controller FMU, the plan, limits and
/// start values. References, positions and states are taken from the record; the computed and the sent commands must
/// have the same bits. The first difference is reported with cycle, signal and both values. Exit code 1: something
/// differs.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop bench replay run.parquet\n  piezoloop bench replay run.mf4 --fmu moved/controller.fmu --json"
)]
pub(crate) struct Replay {
    /// Records: .parquet, .csv (with its .about.json), .mf4, or the .journal of a killed run
    #[arg(required = true, value_name = "RECORD")]
    records: Vec<PathBuf>,
    /// The controller FMU, if it has moved since the recording
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Accept an FMU with another hash than the recorded one
    #[arg(long)]
    any_fmu: bool,
}

/// A record and what its replay found.
#[derive(Serialize)]
struct One {
    record: PathBuf,
    /// None: the plan's rows were the commands.
    controller: Option<PathBuf>,
    controller_sha256: Option<String>,
    /// Version of the program that recorded it.
    recorded_by: Option<String>,
    recorded_on: Option<String>,
    #[serde(flatten)]
    replayed: Replayed,
}

#[derive(Serialize)]
struct All {
    records: Vec<One>,
    different: usize,
}

impl Replay {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let records: Vec<One> =
            self.records.iter().map(|record| self.one(record)).collect::<Result<_, _>>()?;
        let is_different = |one: &&One| one.replayed.differing > 0;
        let different = records.iter().filter(is_different).count();
        screen.show(&All { records, different })
    }

    fn one(&self, record: &Path) -> anyhow::Result<One> {
        let recording = Recording::read(record)?;
        note_on_log(recording.notes());
        let Some(text) = recording.about("replay") else {
            let by = recording.about("tool").unwrap_or("another program");
            bail!(
                "{}: does not carry what a replay needs (it was written by {by}); record the run again",
                record.display()
            );
        };
        let recipe = Recipe::parse(text).map_err(|rule| {
            anyhow::anyhow!("{}: what it carries for a replay: {rule}", record.display())
        })?;
        let mut notes = Vec::new();
        let found = self.controller(record, &recording, &mut notes)?;
        let (driver, controller, controller_sha256) = match found {
            Some((file, hash)) => {
                let opened = fmus::open(&file)?;
                let driver = Driver::controller(
                    &opened.fmu,
                    &recipe.names(|axis| &axis.reference),
                    &recipe.names(|axis| &axis.measured),
                    &recipe.names(|axis| &axis.command),
                    &recipe.start,
                    recipe.period_ns as f64 / 1e9,
                );
                let driver = driver.with_context(|| format!("{}", file.display()))?;
                (driver, Some(file), Some(hash))
            }
            None => (Driver::Direct, None, None),
        };
        let mut replayed = replay(&recording, &recipe, driver)?;
        replayed.notes.splice(0..0, notes);
        let about = |key: &str| recording.about(key).map(str::to_owned);
        let (recorded_by, recorded_on) = (about("tool"), about("platform"));
        let record = record.to_owned();
        Ok(One { record, controller, controller_sha256, recorded_by, recorded_on, replayed })
    }

    /// The controller's file and its hash; none where the record had no controller.
    fn controller(
        &self,
        record: &Path,
        recording: &Recording,
        notes: &mut Vec<String>,
    ) -> anyhow::Result<Option<(PathBuf, String)>> {
        let name = record.display();
        let Some(path) = recording.about("controller").map(PathBuf::from) else {
            if recording.about("controller_model").is_some() && self.fmu.is_none() {
                bail!("{name}: does not say where its controller was; give it with --fmu FILE");
            }
            if recording.about("controller_model").is_none() {
                if let Some(fmu) = &self.fmu {
                    bail!(
                        "{name}: had no controller, so there is no use for --fmu {}",
                        fmu.display()
                    );
                }
                return Ok(None);
            }
            return self.hashed(self.fmu.clone().unwrap_or_default(), name, recording, notes);
        };
        if let Some(fmu) = &self.fmu {
            return self.hashed(fmu.clone(), name, recording, notes);
        }
        // Records and FMUs move together.
        let beside = path.file_name().map(|file| record.with_file_name(file));
        let file = [Some(path.clone()), beside].into_iter().flatten().find(|file| file.exists());
        let Some(file) = file else {
            bail!(
                "{name}: its controller {} is not there any more; give it with --fmu FILE",
                path.display()
            );
        };
        self.hashed(file, name, recording, notes)
    }

    fn hashed(
        &self,
        file: PathBuf,
        record: std::path::Display<'_>,
        recording: &Recording,
        notes: &mut Vec<String>,
    ) -> anyhow::Result<Option<(PathBuf, String)>> {
        let bytes = std::fs::read(&file).with_context(|| {
            format!("{}: cannot be read; give the FMU with --fmu FILE", file.display())
        })?;
        let hash = hex::encode(Sha256::digest(&bytes));
        let recorded = recording.about("controller_sha256").unwrap_or("none");
        if hash != recorded {
            let file = file.display();
            if !self.any_fmu {
                bail!(
                    "{file}: is not the controller of {record}: its SHA-256 is {hash}, the record's \
                     {recorded}; give the one that was run with --fmu FILE, or --any-fmu to compare another"
                );
            }
            notes.push(format!(
                "{file} is not the controller that was run: SHA-256 {hash}, recorded {recorded}"
            ));
        }
        Ok(Some((file, hash)))
    }
}

impl Answer for All {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for One { record, replayed, .. } in &self.records {
            let Replayed { rows, compared, differing, first_difference, notes, .. } = replayed;
            let record = record.display();
            match first_difference {
                None => {
                    writeln!(out, "{record}: {rows} rows, {compared} numbers: the same bits")?;
                }
                Some(first) => {
                    writeln!(
                        out,
                        "{record}: {rows} rows, {differing} of {compared} numbers differ"
                    )?;
                    let Difference { row, cycle, time, signal, recorded, replayed, .. } = first;
                    writeln!(
                        out,
                        "  first: cycle {cycle} ({time} s, row {row}), {signal}: recorded {recorded:?} \
                         ({}), replayed {replayed:?} ({})",
                        first.bits[0], first.bits[1]
                    )?;
                    if let Some(failure) = &first.failure {
                        writeln!(out, "  the controller said: {failure}")?;
                    }
                }
            }
            notes.iter().try_for_each(|note| writeln!(out, "  note: {note}"))?;
        }
        Ok(())
    }

    fn exit_code(&self) -> u8 {
        u8::from(self.different > 0)
    }
}
