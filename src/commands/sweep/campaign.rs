//! Campaigns: each run plays a machine or takes a log, and has it identified or diagnosed by this
//! tool's own commands, in a process of its own.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use cosim::Fmu;
use serde_json::Value;
use sweep::{Campaign, Cell, Column, ColumnKind, Design, Kind, Plan, Row, Target, Worker};

use super::materials::{self, Stage};
use super::signals::parameters;

/// A campaign, ready to be run on any thread.
pub(super) struct CampaignRuns {
    stage: Stage,
    plan: Plan,
    task: Task,
    program: PathBuf,
}

/// What a run asks.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Task {
    Identify,
    Diagnose,
}

/// Before the name of an option of the command that varies.
const OPTION: &str = "option.";

impl CampaignRuns {
    /// What the plan needs, checked.
    pub(super) fn new(stage: Stage, plan: Plan) -> anyhow::Result<Self> {
        let task = match &plan.kind {
            Kind::Identify(_) => Task::Identify,
            _ => Task::Diagnose,
        };
        let program = std::env::current_exe().context("this program does not find itself")?;
        let runs = CampaignRuns { stage, plan, task, program };
        let campaign = runs.campaign()?;
        let origin = runs.plan.origin.display();
        let varies = |name: &str| runs.plan.vary.iter().any(|(varied, _, _)| varied == name);
        if campaign.logs.is_empty() && !varies("log") {
            bail!("{origin}: there is no log; add logs = [\"FILE\"], or \"log\" under [vary]");
        }
        if task == Task::Diagnose && campaign.model.is_none() && !varies("model") {
            bail!("{origin}: there is no model to diagnose; add model = \"FILE\"");
        }
        if task == Task::Identify && (campaign.model.is_some() || !campaign.holdout.is_empty()) {
            bail!("{origin}: an identification takes no model and no holdout; leave them out");
        }
        Ok(runs)
    }

    fn campaign(&self) -> anyhow::Result<&Campaign> {
        match &self.plan.kind {
            Kind::Identify(campaign) | Kind::Diagnose(campaign) => Ok(campaign),
            _ => bail!("this plan is no campaign"),
        }
    }

    /// What may vary: parameters of the machine, the log, the model, options of the command.
    pub(super) fn targets(&self) -> anyhow::Result<Vec<Target>> {
        let campaign = self.campaign()?;
        let mut targets = match self.stage.path("machine.fmu") {
            Some(machine) => parameters(&Fmu::open(machine)?, "machine.", &campaign.start)?,
            None => Vec::new(),
        };
        targets.push(Target::new("log", ColumnKind::Text));
        if self.task == Task::Diagnose {
            targets.push(Target::new("model", ColumnKind::Text));
        }
        for (name, _, _) in &self.plan.vary {
            if name.starts_with(OPTION) {
                targets.push(Target::new(name, ColumnKind::Text));
            }
        }
        Ok(targets)
    }

    /// What each run leaves.
    pub(super) fn columns(&self) -> Vec<Column> {
        let columns: &[(&str, ColumnKind)] = match self.task {
            Task::Identify => &[
                ("structure", ColumnKind::Text),
                ("held_out_nrmse", ColumnKind::Real),
                ("fitted_nrmse", ColumnKind::Real),
                ("line_nrmse", ColumnKind::Real),
                ("parameters", ColumnKind::Integer),
                ("plant", ColumnKind::Text),
            ],
            Task::Diagnose => &[
                ("verdict", ColumnKind::Text),
                ("effects", ColumnKind::Text),
                ("probability", ColumnKind::Real),
                ("rms_as_given", ColumnKind::Real),
                ("rms_after", ColumnKind::Real),
                ("shrink", ColumnKind::Real),
            ],
        };
        columns.iter().map(|(name, kind)| Column::new(*name, *kind, None)).collect()
    }

    /// A worker for one thread.
    pub(super) fn hire<'r>(&'r self, design: &'r Design) -> CampaignWorker<'r> {
        CampaignWorker { runs: self, design }
    }

    /// One run in a folder of its own.
    fn attempt(&self, design: &Design, point: &[Cell]) -> anyhow::Result<Vec<Cell>> {
        let campaign = self.campaign()?;
        let folder = tempfile::tempdir().context("no temporary folder can be made")?;
        let named = design.variables().iter().map(|variable| variable.target.name.as_str());
        let values: Vec<(&str, String)> = named.zip(point.iter().map(Cell::to_string)).collect();
        let varied = |name: &str| values.iter().find(|(n, _)| *n == name).map(|(_, value)| value);
        let logs = match varied("log") {
            Some(log) => vec![self.stage.file(&materials::varied_log(log))?],
            None => self.files("log", campaign.logs.len())?,
        };
        let holdout = self.files("holdout", campaign.holdout.len())?;
        let mut starts: BTreeMap<&str, String> = BTreeMap::new();
        let fixed = campaign.start.iter().map(|(name, value)| (name.as_str(), value.to_string()));
        for (name, value) in fixed.chain(values.iter().map(|(name, value)| (*name, value.clone())))
        {
            if let Some(name) = name.strip_prefix("machine.") {
                starts.insert(name, value);
            }
        }
        let play = |files: Vec<PathBuf>, role: &str| -> anyhow::Result<Vec<PathBuf>> {
            let Some(machine) = self.stage.path("machine.fmu") else { return Ok(files) };
            let played = files.iter().enumerate().map(|(at, log)| {
                let out = folder.path().join(format!("{role}.{at}.csv"));
                self.play(&machine, log, &starts, &campaign.map, &out)?;
                Ok(out)
            });
            played.collect()
        };
        let (logs, holdout) = (play(logs, "played")?, play(holdout, "held")?);
        let mut arguments = Vec::new();
        let mut add = |name: &str, value: &Path| {
            arguments.extend([format!("--{name}"), value.to_string_lossy().into_owned()]);
        };
        logs.iter().for_each(|log| add("log", log));
        holdout.iter().for_each(|log| add("holdout", log));
        if self.task == Task::Diagnose {
            add("model", &self.model(varied("model").map(String::as_str))?);
        }
        arguments.extend(["--threads".to_owned(), "1".to_owned()]);
        arguments.extend(campaign.options.iter().cloned());
        for (name, value) in &values {
            let Some(option) = name.strip_prefix(OPTION) else { continue };
            match value.as_str() {
                "false" => {}
                "true" => arguments.push(format!("--{option}")),
                value => arguments.extend([format!("--{option}"), value.to_owned()]),
            }
        }
        match self.task {
            Task::Identify => self.identify(folder.path(), arguments, campaign),
            Task::Diagnose => self.diagnose(folder.path(), arguments, campaign),
        }
    }

    fn files(&self, role: &str, count: usize) -> anyhow::Result<Vec<PathBuf>> {
        (0..count).map(|at| self.stage.file(&format!("{role}.{at}.csv"))).collect()
    }

    fn model(&self, varied: Option<&str>) -> anyhow::Result<PathBuf> {
        let stem = varied.map_or_else(|| "model".to_owned(), materials::varied_model);
        let found =
            ["toml", "fmu"].iter().find_map(|end| self.stage.path(&format!("{stem}.{end}")));
        found.context("the campaign has no model")
    }

    /// Drives the machine by a log.
    fn play(
        &self,
        machine: &Path,
        log: &Path,
        starts: &BTreeMap<&str, String>,
        map: &BTreeMap<String, String>,
        out: &Path,
    ) -> anyhow::Result<()> {
        let mut arguments = vec!["simulate".to_owned(), machine.to_string_lossy().into_owned()];
        arguments.extend(["--log".to_owned(), log.to_string_lossy().into_owned()]);
        for (variable, column) in map {
            arguments.extend(["--map".to_owned(), format!("{variable}={column}")]);
        }
        for (name, value) in starts {
            arguments.extend(["--start".to_owned(), format!("{name}={value}")]);
        }
        arguments.extend(["--out".to_owned(), out.to_string_lossy().into_owned()]);
        self.call(Path::new("."), &arguments).map(|_| ())
    }

    fn identify(
        &self,
        folder: &Path,
        mut arguments: Vec<String>,
        campaign: &Campaign,
    ) -> anyhow::Result<Vec<Cell>> {
        let says = |option: &str| campaign.options.iter().any(|word| word.starts_with(option));
        if campaign.machine.is_some() && !says("--input") {
            arguments.extend(["--input", "command[1]"].map(str::to_owned));
            arguments.extend(["--output", "position[1]"].map(str::to_owned));
        }
        arguments.insert(0, "identify".to_owned());
        arguments.extend(["--out", "plant.toml"].map(str::to_owned));
        let answer = self.call(folder, &arguments)?;
        let axis = &answer["axes"][0];
        let candidates = axis["candidates"].as_array().context("the answer has no candidates")?;
        let taken = candidates.iter().find(|candidate| candidate["accepted"] == true);
        let taken = taken.context("the answer takes no candidate")?;
        let line = candidates.iter().find(|candidate| candidate["method"].is_null());
        let plant = std::fs::read_to_string(folder.join("plant.toml"))?;
        Ok(vec![
            word(&taken["structure"]),
            taken["held_out_nrmse"].as_f64().into(),
            taken["fitted_nrmse"].as_f64().into(),
            line.and_then(|line| line["held_out_nrmse"].as_f64()).into(),
            taken["parameters"].as_i64().map_or(Cell::Missing, Cell::Integer),
            Cell::Text(plant),
        ])
    }

    fn diagnose(
        &self,
        folder: &Path,
        mut arguments: Vec<String>,
        campaign: &Campaign,
    ) -> anyhow::Result<Vec<Cell>> {
        arguments.insert(0, "diagnose".to_owned());
        // A log that was played has the names of the model's variables.
        if campaign.machine.is_none() {
            for (variable, column) in &campaign.map {
                arguments.extend(["--map".to_owned(), format!("{variable}={column}")]);
            }
        }
        let gap = self.call(folder, &arguments)?;
        let effects = gap["effects"].as_array().context("the answer has no effects")?;
        let names: Vec<&str> =
            effects.iter().filter_map(|effect| effect["effect"].as_str()).collect();
        Ok(vec![
            word(&gap["verdict"]),
            if names.is_empty() { Cell::Missing } else { Cell::Text(names.join("+")) },
            effects.iter().filter_map(|e| e["probability"].as_f64()).reduce(f64::min).into(),
            gap["shrink"]["rms_as_given"].as_f64().into(),
            gap["shrink"]["rms_after"].as_f64().into(),
            gap["shrink"]["fraction"].as_f64().into(),
        ])
    }

    /// Calls this tool; the answer.
    fn call(&self, folder: &Path, arguments: &[String]) -> anyhow::Result<Value> {
        let output = Command::new(&self.program)
            .current_dir(folder)
            .args(arguments)
            .arg("--json")
            .stdin(Stdio::null())
            .output()
            .map_err(numerics::threads::refused)
            .context("this program cannot be started again")?;
        if !matches!(output.status.code(), Some(0 | 1)) {
            let message = String::from_utf8_lossy(&output.stderr);
            let described: Option<Value> =
                message.lines().rev().find_map(|line| serde_json::from_str(line).ok());
            let text = described
                .as_ref()
                .and_then(|described| described["error"].as_str())
                .unwrap_or(message.trim());
            bail!("{}: {text}", arguments.first().map_or("", String::as_str));
        }
        serde_json::from_slice(&output.stdout).context("the answer is no JSON")
    }
}

fn word(value: &Value) -> Cell {
    value.as_str().map_or(Cell::Missing, Cell::from)
}

/// Runs a campaign's runs on one thread.
pub(super) struct CampaignWorker<'r> {
    runs: &'r CampaignRuns,
    design: &'r Design,
}

impl Worker for CampaignWorker<'_> {
    fn run(&mut self, run: u64) -> Row {
        let results = self.runs.columns().len();
        super::row_of(self.design, results, run, |point| self.runs.attempt(self.design, point))
    }
}
