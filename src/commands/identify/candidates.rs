//! The folder of `identify --all`: the plant of each model that was tried, and a list of them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::{Deserialize, Serialize};

use super::identifier;
use crate::results::identify::Identified;

/// Name of the list.
const LIST: &str = "candidates.json";

/// A plant of the list.
#[derive(Serialize, Deserialize)]
struct Entry {
    file: String,
    axis: String,
    structure: String,
    fitted_nrmse: Option<f64>,
    held_out_nrmse: Option<f64>,
}

/// A folder of our own.
pub(super) struct Folder {
    path: PathBuf,
    /// What an earlier call has written.
    earlier: Vec<Entry>,
}

impl Folder {
    /// Takes a folder that is new, empty or of an earlier call; before the work.
    pub(super) fn open(path: &Path) -> anyhow::Result<Self> {
        files::own_folder(path, &[LIST])
            .with_context(|| format!("--all {}: the folder cannot be used", path.display()))?;
        // No input: it is written anew.
        let earlier = match std::fs::read_to_string(path.join(LIST)) {
            Ok(text) => serde_json::from_str(&text).with_context(|| {
                format!("{}: is no list of an earlier call", path.join(LIST).display())
            })?,
            Err(_) => Vec::new(),
        };
        Ok(Self { path: path.to_owned(), earlier })
    }

    /// Writes the plants, `<axis>-<model>.toml`; of several structures of one model the last, which is
    /// the richest.
    pub(super) fn write(self, result: &Identified) -> anyhow::Result<()> {
        let mut richest = BTreeMap::new();
        for (number, axis) in result.axes.iter().enumerate() {
            for candidate in &axis.identification.candidates {
                let Some(plant) = &candidate.plant else { continue };
                let model = candidate.method.unwrap_or("line");
                richest.insert((number, model), (&axis.name, candidate, plant));
            }
        }
        let mut list = Vec::new();
        for ((_, model), (axis, candidate, _)) in &richest {
            let file = format!("{}-{model}.toml", identifier(axis));
            let path = self.path.join(&file);
            let is_ours = || self.earlier.iter().any(|entry| entry.file == file);
            files::check_beside(&path, is_ours)
                .with_context(|| format!("{} cannot be written", path.display()))?;
            list.push(Entry {
                file,
                axis: axis.to_string(),
                structure: candidate.structure.clone(),
                fitted_nrmse: candidate.fitted_nrmse,
                held_out_nrmse: candidate.held_out_nrmse,
            });
        }
        // Before the plants, so that those of a call that was ended are known as ours.
        let path = self.path.join(LIST);
        data::AtomicFile::write_all_of(&path, &serde_json::to_vec_pretty(&list)?)
            .with_context(|| format!("{} cannot be written", path.display()))?;
        for (entry, (_, _, plant)) in list.iter().zip(richest.values()) {
            plant.write(&self.path.join(&entry.file))?;
        }
        Ok(())
    }
}
