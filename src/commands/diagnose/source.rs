//! The model that a diagnosis starts from.

use std::path::PathBuf;

use anyhow::{Context, bail};
use cli::Screen;
use diagnose::{Model, Request, Tolerance};
use tempfile::TempDir;

use super::{Diagnose, baseline};
use crate::inputs::{self, BlueprintText};
use crate::packing;

/// Name of an FMU that is made for the diagnosis alone.
const PACKED: &str = "packed.fmu";

/// The model that is diagnosed.
pub(super) enum Source {
    /// An FMU.
    Fmu(PathBuf),
    /// A blueprint or a rig.
    Blueprint(Box<BlueprintText>),
    /// Made of the logs.
    Generated(Box<baseline::Generated>),
    /// A blueprint whose axes cannot be looked at one by one, as the FMU `PACKED` in a temporary folder.
    Packed(TempDir),
}

impl Source {
    /// The blueprint, where it is one.
    pub(super) fn blueprint(&self) -> anyhow::Result<&BlueprintText> {
        match self {
            Self::Blueprint(text) => Ok(text),
            Self::Generated(identified) => Ok(&identified.text),
            Self::Fmu(_) | Self::Packed(_) => bail!("an FMU has no blueprint of its own"),
        }
    }

    /// The FMU, where it is one.
    pub(super) fn fmu(&self) -> Option<PathBuf> {
        match self {
            Self::Fmu(path) => Some(path.clone()),
            Self::Packed(folder) => Some(folder.path().join(PACKED)),
            Self::Blueprint(_) | Self::Generated(_) => None,
        }
    }
}

impl Diagnose {
    /// The model as it was given, or as it is made of the logs.
    pub(super) fn source(&self, screen: &Screen) -> anyhow::Result<Source> {
        match &self.model {
            Some(model) if self.is_fmu() => Ok(Source::Fmu(model.clone())),
            Some(model) => Ok(Source::Blueprint(Box::new(inputs::blueprint(model)?))),
            None => {
                let asked = baseline::Asked {
                    logs: &self.logs,
                    inputs: &self.inputs,
                    outputs: &self.output_columns,
                    options: &self.options,
                    drop: self.drop.filter(|drop| *drop > 0.0),
                    readings: self.readings(),
                    response: self.frequency_response.as_deref().map(|table| (table, self.modes)),
                };
                Ok(Source::Generated(Box::new(baseline::identified(&asked, screen)?)))
            }
        }
    }

    /// A blueprint whose axes cannot be looked at one by one, as an FMU that the request asks for instead, and what is
    /// said of it.
    pub(super) fn packed(
        &self,
        source: &Source,
        request: &mut Request,
        (model, reason): (&str, &str),
    ) -> anyhow::Result<(Source, String)> {
        let text = source.blueprint()?;
        if let Some(file) = self.repair.as_deref().filter(|file| cli::ends_in(file, "toml")) {
            bail!(
                "--repair {}: {model} {reason}, so that effects cannot be written into its blueprint; give a name that \
                 ends in .fmu, and effects are put around its FMU",
                file.display()
            );
        }
        let folder = tempfile::tempdir().context("no temporary folder can be made")?;
        let file = folder.path().join(PACKED);
        packing::pack_to_run(text, &file)?;
        if let Model::Blueprint(checked) = &request.model {
            // Of several the last one counts: what the command line says.
            request.tolerances.splice(0..0, Tolerance::of_blueprint(checked));
        }
        request.model = Model::Fmu(file);
        let note = format!(
            "{model} {reason}: it is diagnosed as an FMU, packed for this, whose inputs all act; effects act before and \
             behind it and in its own frequencies and dampings, and --repair writes an .fmu"
        );
        Ok((Source::Packed(folder), note))
    }
}
