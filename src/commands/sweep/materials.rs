//! Everything that a sweep reads, as bytes: it runs from them, here or on another machine.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use cosim::plan::Plan as SystemPlan;
use data::UnitPlace;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use sweep::{Campaign, Kind, Law, Plan};

use crate::inputs::{self, LogOptions};
use crate::packing;

/// The plan and all that it names: blueprints packed as FMUs, logs as CSV with their units.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Materials {
    /// The plan's file, for messages.
    origin: String,
    plan: String,
    /// In the place of the plan's.
    seed: Option<u64>,
    /// The tool that gathered them; another one may compute other bits.
    tool: String,
    files: Vec<File>,
}

/// A file of a sweep.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct File {
    name: String,
    content: Vec<u8>,
    /// What the results depend on; of an FMU that was packed, what it was packed from: the FMU
    /// itself says when that was.
    source: Vec<u8>,
}

impl File {
    fn new(name: impl Into<String>, content: Vec<u8>) -> Self {
        let source = Sha256::digest(&content).to_vec();
        File { name: name.into(), content, source }
    }
}

/// First bytes of a bundle.
const MAGIC: &[u8] = b"piezoloop-bundle/1\n";

impl Materials {
    /// Reads a plan and everything it names.
    pub(super) fn gather(file: &Path, seed: Option<u64>) -> anyhow::Result<Self> {
        let text = files::read_text(file).with_context(|| {
            format!("{} cannot be read; give the plan of a sweep", file.display())
        })?;
        let plan = Plan::parse(&text, file)?;
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        let mut gatherer = Gatherer { folder, files: Vec::new() };
        gatherer.all(&plan)?;
        Ok(Materials {
            origin: file.display().to_string(),
            plan: text,
            seed,
            tool: crate::VERSION.to_owned(),
            files: gatherer.files,
        })
    }

    /// As bytes, for another machine.
    pub(super) fn to_bytes(&self) -> anyhow::Result<Vec<u8>> {
        Ok([MAGIC, &postcard::to_allocvec(self)?].concat())
    }

    /// From bytes.
    pub(super) fn from_bytes(bytes: &[u8]) -> anyhow::Result<Self> {
        let content = bytes.strip_prefix(MAGIC).context("these bytes are no bundle of a sweep")?;
        let materials: Materials =
            postcard::from_bytes(content).context("the bundle of the sweep is broken")?;
        if materials.tool != crate::VERSION {
            bail!(
                "the bundle was made by Piezoloop {}, this is {}: install the same version on all \
                 machines",
                materials.tool,
                crate::VERSION
            );
        }
        // They become files of a temporary folder, and are made by whoever made the bundle.
        if let Some(file) = materials.files.iter().find(|file| !is_file_name(&file.name)) {
            bail!(
                "the bundle of the sweep is broken: {:?} is not the name of a file in its folder; bundle the \
                 plan again",
                file.name
            );
        }
        Ok(materials)
    }

    /// What the results depend on, as SHA-256.
    pub(super) fn fingerprint(&self) -> anyhow::Result<String> {
        let files: Vec<_> = self.files.iter().map(|file| (&file.name, &file.source)).collect();
        let relevant = (&self.plan, self.seed, &self.tool, files);
        let digest = Sha256::digest(postcard::to_allocvec(&relevant)?);
        Ok(hex::encode(digest))
    }

    /// The plan, with the seed that was asked for.
    pub(super) fn plan(&self) -> anyhow::Result<Plan> {
        let mut plan = Plan::parse(&self.plan, Path::new(&self.origin))?;
        plan.seed = self.seed.unwrap_or(plan.seed);
        Ok(plan)
    }

    /// Lays the files out in a folder of their own.
    pub(super) fn lay(&self) -> anyhow::Result<Stage> {
        let folder = tempfile::tempdir().context("no temporary folder can be made")?;
        for File { name, content, .. } in &self.files {
            std::fs::write(folder.path().join(name), content)
                .context("the temporary folder cannot be written")?;
        }
        Ok(Stage { folder })
    }
}

/// The files of a sweep in a temporary folder.
pub(super) struct Stage {
    folder: tempfile::TempDir,
}

impl Stage {
    /// Where a file is, if the sweep has it.
    pub(super) fn path(&self, name: &str) -> Option<PathBuf> {
        Some(self.folder.path().join(name)).filter(|path| path.is_file())
    }

    /// Where a file is that the sweep must have.
    pub(super) fn file(&self, name: &str) -> anyhow::Result<PathBuf> {
        self.path(name).with_context(|| format!("the sweep has no file {name}"))
    }
}

/// Reads the files of a plan.
struct Gatherer {
    folder: PathBuf,
    files: Vec<File>,
}

impl Gatherer {
    fn all(&mut self, plan: &Plan) -> anyhow::Result<()> {
        match &plan.kind {
            Kind::Loop(closed) => {
                self.fmu("plant", &closed.plant, closed.all_effects)?;
                self.fmu("controller", &closed.controller, false)?;
                self.log("reference.csv", &closed.reference, &closed.unit)
            }
            Kind::System(system) => {
                self.system(&system.file)?;
                for (at, set) in system.parameters.iter().enumerate() {
                    let bytes = self.read(set)?;
                    self.files.push(File::new(format!("parameters.{at}.ssv"), bytes));
                }
                match &system.input {
                    Some(input) => self.log("input.csv", input, &system.unit),
                    None => Ok(()),
                }
            }
            Kind::Identify(campaign) => self.campaign(plan, campaign),
            Kind::Diagnose(campaign) => self.campaign(plan, campaign),
        }
    }

    fn campaign(&mut self, plan: &Plan, campaign: &Campaign) -> anyhow::Result<()> {
        if let Some(machine) = &campaign.machine {
            self.fmu("machine", machine, false)?;
        }
        if let Some(model) = &campaign.model {
            self.model("model", model)?;
        }
        for (role, logs) in [("log", &campaign.logs), ("holdout", &campaign.holdout)] {
            for (at, log) in logs.iter().enumerate() {
                self.log(&format!("{role}.{at}.csv"), log, &campaign.unit)?;
            }
        }
        for (name, _, law) in &plan.vary {
            let (Law::Grid(values) | Law::Choice(values)) = law else { continue };
            for value in values.iter().map(ToString::to_string) {
                match name.as_str() {
                    "log" => self.log(&varied_log(&value), &value, &campaign.unit)?,
                    "model" => self.model(&varied_model(&value), &value)?,
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// A file beside the plan, else the name as it stands, which may be a rig's.
    fn resolve(&self, what: &str) -> PathBuf {
        let beside = self.folder.join(what);
        if beside.exists() { beside } else { PathBuf::from(what) }
    }

    fn read(&self, what: &str) -> anyhow::Result<Vec<u8>> {
        let path = self.folder.join(what);
        files::note_read(&path);
        std::fs::read(&path).with_context(|| format!("{} cannot be read", path.display()))
    }

    /// An FMU as it is; a blueprint or a rig is packed.
    fn fmu(&mut self, role: &str, what: &str, all_effects: bool) -> anyhow::Result<()> {
        let path = self.resolve(what);
        let file = fmu_file(format!("{role}.fmu"), &path, all_effects);
        self.files.push(file.with_context(|| format!("{role} = \"{what}\""))?);
        Ok(())
    }

    /// A model that is diagnosed: as FMU nobody looks inside, as blueprint one does.
    fn model(&mut self, role: &str, what: &str) -> anyhow::Result<()> {
        let path = self.resolve(what);
        let (ending, bytes) = if cli::ends_in(&path, "fmu") {
            ("fmu", archive(&path)?)
        } else {
            let source = inputs::blueprint(&path)?;
            if !source.blueprint.check(learned::COMPONENTS)?.table_files().is_empty() {
                bail!(
                    "{}: a blueprint with learned tables cannot go to other machines as text; pack it \
                     and give the FMU",
                    path.display()
                );
            }
            ("toml", source.text.into_bytes())
        };
        self.files.push(File::new(format!("{role}.{ending}"), bytes));
        Ok(())
    }

    fn log(
        &mut self,
        role: &str,
        what: &str,
        units: &std::collections::BTreeMap<String, String>,
    ) -> anyhow::Result<()> {
        let unit = units.iter().map(|(column, unit)| format!("{column}={unit}")).collect();
        let options = LogOptions { unit, ..LogOptions::default() };
        let log = options.read(&self.folder.join(what))?;
        let folder = tempfile::tempdir().context("no temporary folder can be made")?;
        let file = folder.path().join("log.csv");
        log.write(&file, UnitPlace::Header)?;
        self.files.push(File::new(role, std::fs::read(file)?));
        Ok(())
    }

    fn system(&mut self, what: &str) -> anyhow::Result<()> {
        let path = self.folder.join(what);
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("ssp") => {
                let bytes = self.read(what)?;
                self.files.push(File::new("system.ssp", bytes));
            }
            Some("toml") => {
                let bytes = self.read(what)?;
                for (at, fmu) in SystemPlan::read(&path)?.fmus.iter().enumerate() {
                    let file = fmu_file(format!("system.{at}.fmu"), &fmu.path, false);
                    let place = || format!("{}: FMU {}", path.display(), fmu.name);
                    self.files.push(file.with_context(place)?);
                }
                self.files.push(File::new("system.toml", bytes));
            }
            _ => bail!("{}: a sweep takes a system as .toml or .ssp", path.display()),
        }
        Ok(())
    }
}

/// The name of a log that varies.
pub(super) fn varied_log(value: &str) -> String {
    format!("log-{}.csv", hashed(value))
}

/// The name of a model that varies, without its ending.
pub(super) fn varied_model(value: &str) -> String {
    format!("model-{}", hashed(value))
}

fn hashed(value: &str) -> String {
    hex::encode(&Sha256::digest(value)[..8])
}

/// Whether a name is that of a file in a folder, and leads nowhere else.
fn is_file_name(name: &str) -> bool {
    !matches!(name, "" | "." | "..")
        && !name.contains(['/', '\\', ':'])
        && !name.chars().any(char::is_control)
}

/// The bytes of an FMU.
fn archive(path: &Path) -> anyhow::Result<Vec<u8>> {
    if path.is_dir() {
        bail!(
            "{}: is a folder; a sweep takes an FMU as one file, which can go to other machines: zip what is \
             in the folder",
            path.display()
        );
    }
    files::note_read(path);
    std::fs::read(path).with_context(|| format!("{} cannot be read", path.display()))
}

fn fmu_file(name: String, path: &Path, all_effects: bool) -> anyhow::Result<File> {
    if cli::ends_in(path, "fmu") {
        if all_effects {
            bail!("{}: all-effects needs a blueprint or a rig; this is an FMU", path.display());
        }
        return Ok(File::new(name, archive(path)?));
    }
    let mut source = inputs::blueprint(path)?;
    if all_effects {
        crate::effects::add_all(&mut source.blueprint)?;
        source.text = source.blueprint.to_toml();
    }
    let mut hash = Sha256::new_with_prefix(&source.text);
    for (name, table) in source.blueprint.check(learned::COMPONENTS)?.table_files() {
        hash.update(name);
        hash.update(Sha256::digest(table));
    }
    let folder = tempfile::tempdir().context("no temporary folder can be made")?;
    let file = folder.path().join("packed.fmu");
    packing::pack_to_run(&source, &file)?;
    Ok(File { name, content: std::fs::read(file)?, source: hash.finalize().to_vec() })
}
