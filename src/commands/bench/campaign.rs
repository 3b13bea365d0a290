//! `piezoloop bench campaign`: many scripts of faults, each with the end that is expected.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use bench::campaign::{Campaign, Trial};
use bench::emulate::{Behaviour, Emulator, Plant, Script, Timing};
use bench::plan::{Plan, Prepared};
use bench::record::{About, Converted, Format, Journal, convert};
use bench::virtual_run::VirtualRun;
use clap::Args;
use cli::{Answer, PageOptions, Screen};
use cosim::InstanceOptions;
use modeldescription::variable::Causality;
use serde::Serialize;

use super::channels;
use crate::fmus::{self, Opened};
use crate::pages;

/// Runs a campaign of faults in virtual time, and checks the end of each trial
///
/// The campaign (TOML) contains a bench plan, a plant and cases: faults, the cycles at which they occur, and the
/// expected state, reason and deadline. Runner, safety, packets and faults are those of `bench run` and `bench
/// emulate`; only the clock is virtual. Exit code 1: a case ended otherwise.
#[derive(Args, Debug)]
#[command(
    name = "campaign",
    after_help = "Example:\n  piezoloop bench campaign faults.toml\ndocs/gateway.md describes the file."
)]
pub(crate) struct Run {
    /// The campaign (TOML)
    campaign: PathBuf,
    /// The bench plan [default: the campaign's]
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// The plant: an FMU, a blueprint or the name of a rig [default: the campaign's]
    #[arg(long, value_name = "PLANT")]
    plant: Option<PathBuf>,
    /// The controller FMU [default: the plan's; without one, the plan's sequence is the command]
    #[arg(long, value_name = "FMU")]
    controller: Option<PathBuf>,
    /// Folder for the records of the trials, NUMBER.parquet, which `bench replay` reads
    #[arg(long, value_name = "FOLDER")]
    records: Option<PathBuf>,
    /// Format of these records
    #[arg(long, value_name = "KIND", default_value = "parquet", requires = "records")]
    records_as: RecordKind,
    #[command(flatten)]
    page: PageOptions,
}

/// Kind of a record.
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
enum RecordKind {
    Parquet,
    Csv,
    Mf4,
}

#[derive(Serialize)]
struct Tried {
    trials: Vec<Trial>,
    failed: usize,
    /// Records of the trials, in their order.
    records: Vec<Converted>,
}

/// What every trial is made of.
struct Bench {
    plan: Plan,
    controller: Option<Opened>,
    controller_file: Option<PathBuf>,
    plant: Opened,
    commands: Vec<String>,
    positions: Vec<String>,
    safe: Vec<f64>,
    heartbeat: u32,
}

impl Run {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let file = &self.campaign;
        self.page.can_write()?;
        let text =
            files::read_text(file).with_context(|| format!("{} cannot be read", file.display()))?;
        let campaign = Campaign::parse(&text, &file.display().to_string())?;
        let beside = |named: &Path| file.parent().unwrap_or(Path::new("")).join(named);
        let or = |given: &Option<PathBuf>, named: &Option<PathBuf>, what: &str| {
            let found = given.clone().or_else(|| named.as_deref().map(beside));
            found.with_context(|| {
                let file = file.display();
                format!("{file}: no {what} is given; write {what} = \"…\" there, or --{what} …")
            })
        };
        let plan = Plan::read(&or(&self.plan, &campaign.plan, "plan")?)?;
        let plant = or(&self.plant, &campaign.plant, "plant")?;
        // The name of a rig is no file beside the campaign.
        let plant = match (&campaign.plant, self.plant.is_none() && !plant.exists()) {
            (Some(named), true) => fmus::open(named)?,
            _ => fmus::open(&plant)?,
        };
        let given = self.controller.clone();
        let controller = given.or_else(|| plan.controller.as_ref().map(|file| plan.beside(file)));
        let controller_file = controller.clone().filter(|file| file.exists());
        let controller = controller.as_deref().map(fmus::open).transpose()?;
        let bench = Bench {
            commands: channels(&plant.fmu, &[], Causality::Input, "command"),
            positions: channels(&plant.fmu, &[], Causality::Output, "position"),
            plan,
            controller,
            controller_file,
            plant,
            safe: campaign.safe.clone(),
            heartbeat: campaign.heartbeat.unwrap_or(100).max(1),
        };
        let prepared = bench.prepare()?;
        prepared.notes.iter().for_each(|note| screen.say(&format!("note: {note}")));
        let settle = prepared.settings.settle;
        let keeper = self.keeper(prepared)?;
        let mut records = Vec::new();
        let trials = campaign.run(
            settle,
            |script| {
                let virtual_run = bench.virtual_run(script)?;
                Ok(if keeper.is_some() { virtual_run.recorded() } else { virtual_run })
            },
            |trial, virtual_run| -> anyhow::Result<()> {
                let Some(keeper) = &keeper else { return Ok(()) };
                records.push(keeper.keep(records.len() + 1, trial, virtual_run)?);
                Ok(())
            },
        )?;
        let failed = trials.iter().filter(|trial| !trial.problems.is_empty()).count();
        let answer = Tried { trials, failed, records };
        let read = [("campaign", file.as_path())];
        self.page.finish(screen, &answer, || {
            Ok(pages::campaign(&answer.trials, pages::provenance(&read)?))
        })
    }
}

/// Writes the records of the trials.
struct Keeper {
    folder: PathBuf,
    kind: RecordKind,
    about: About,
}

impl Run {
    fn keeper(&self, prepared: Prepared) -> anyhow::Result<Option<Keeper>> {
        let Some(folder) = self.records.clone() else { return Ok(None) };
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("--records {}: cannot be made", folder.display()))?;
        let Prepared { columns, provenance, .. } = prepared;
        let about = About { columns, provenance };
        Ok(Some(Keeper { folder, kind: self.records_as, about }))
    }
}

impl Keeper {
    fn keep(&self, number: usize, trial: &Trial, bench: &VirtualRun) -> anyhow::Result<Converted> {
        let (ending, format) = match self.kind {
            RecordKind::Parquet => ("parquet", Format::Parquet),
            RecordKind::Csv => ("csv", Format::Csv),
            RecordKind::Mf4 => ("mf4", Format::Mf4),
        };
        let record = self.folder.join(format!("{number:04}.{ending}"));
        let path = super::journal_of(&record);
        let mut journal = Journal::create(&path, &self.about)?;
        let width = self.about.columns.len().max(1);
        bench.record().chunks(BLOCK * width).try_for_each(|rows| journal.write(rows))?;
        let journal = journal.finish()?;
        let more = serde_json::json!({ "trial": trial, "clock": "virtual time" });
        let more = more.as_object().cloned().unwrap_or_default();
        let converted = convert(&journal, &record, format, &more)?;
        std::fs::remove_file(&journal)
            .with_context(|| format!("{} cannot be deleted", journal.display()))?;
        Ok(converted)
    }
}

/// Rows of a block of a journal.
const BLOCK: usize = 1024;

impl Bench {
    fn prepare(&self) -> anyhow::Result<Prepared> {
        let fmu = self.controller.as_ref().map(|opened| &opened.fmu);
        Ok(self.plan.prepare(fmu, self.controller_file.as_deref())?)
    }

    /// Runner and machine for one trial.
    fn virtual_run(&self, script: Script) -> anyhow::Result<VirtualRun> {
        let Prepared { cycle, settings, .. } = self.prepare()?;
        if cycle.axes() != self.commands.len() {
            bail!(
                "the plan has {} axes, the plant {} commands ({})",
                cycle.axes(),
                self.commands.len(),
                self.commands.join(", ")
            );
        }
        let period_ns = settings.period_ns;
        let slave = self.plant.fmu.instantiate("machine", &InstanceOptions::default())?;
        let step = period_ns as f64 / 1e9;
        let mut plant = Plant::new(slave, &self.commands, &self.positions, &self.safe, step)?;
        let safe = match self.safe.is_empty() {
            true => plant.commands()?,
            false => self.safe.clone(),
        };
        let heartbeat = self.heartbeat;
        let behaviour = Behaviour { timing: Timing::Clock, period_ns, heartbeat, safe };
        Ok(VirtualRun::new(cycle, Emulator::new(plant, behaviour, script), period_ns))
    }
}

impl Answer for Tried {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for trial in &self.trials {
            let Trial { case, at, state, reason, took, problems, .. } = trial;
            if problems.is_empty() {
                writeln!(out, "{case}, from cycle {at}: {state}, {reason} ({took} cycles)")?;
            } else {
                writeln!(out, "FAILED {case}, from cycle {at}: {}", problems.join("; "))?;
            }
        }
        let (all, failed) = (self.trials.len(), self.failed);
        writeln!(out, "{} of {all} trials ended as expected", all - failed)?;
        match self.records.first().and_then(|first| first.file.parent()) {
            Some(folder) => writeln!(out, "{}: {all} records written", folder.display()),
            None => Ok(()),
        }
    }

    fn exit_code(&self) -> u8 {
        u8::from(self.failed > 0)
    }
}
