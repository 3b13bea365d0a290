//! The files of an archive or folder.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::package::{Archive, EntryDefect, PackageError};

/// The files of an FMU, wherever they are.
pub(super) struct Content {
    pub(super) source: Source,
    /// Paths with forward slashes and sizes.
    pub(super) files: BTreeMap<String, u64>,
    /// The files that were read, so that a defect of theirs is reported.
    pub(super) read: BTreeSet<String>,
}

pub(super) enum Source {
    Archive(Box<Archive>),
    Folder(PathBuf),
}

impl Content {
    pub(super) fn of_archive(archive: Archive) -> Self {
        let sound = archive.entries.iter().filter(|e| !e.is_folder && !e.components.is_empty());
        let files = sound.map(|entry| (entry.path(), entry.size)).collect();
        Content { source: Source::Archive(Box::new(archive)), files, read: BTreeSet::new() }
    }

    pub(super) fn of_folder(folder: &Path) -> Result<Self, PackageError> {
        let mut files = BTreeMap::new();
        collect(folder, "", &mut files)
            .map_err(|source| PackageError::Read { path: folder.to_owned(), source })?;
        Ok(Content { source: Source::Folder(folder.to_owned()), files, read: BTreeSet::new() })
    }

    /// Whether reading large files is what the archive wants us to do.
    pub(super) fn is_bomb(&self) -> bool {
        let bomb = |defect: &EntryDefect| {
            matches!(defect, EntryDefect::Bomb { .. } | EntryDefect::Dense { .. })
        };
        match &self.source {
            Source::Archive(archive) => archive.all_defects().any(|(_, defect)| bomb(defect)),
            Source::Folder(_) => false,
        }
    }

    /// The bytes of a file; None if there is none, or a message.
    pub(super) fn read(&mut self, path: &str, limit: u64) -> Option<Result<Vec<u8>, String>> {
        let size = *self.files.get(path)?;
        self.read.insert(path.to_owned());
        if size > limit {
            return Some(Err(format!("it has {size} bytes; at most {limit} are read")));
        }
        match &mut self.source {
            Source::Folder(folder) => {
                Some(fs::read(folder.join(path)).map_err(|error| error.to_string()))
            }
            Source::Archive(archive) => {
                // The central directory is what was listed, so the entry is there.
                let read = archive.read(path)?;
                Some(read.map_err(|error| match error {
                    PackageError::Entry { defect, .. } => defect.to_string(),
                    other => other.to_string(),
                }))
            }
        }
    }
}

/// All files below a folder; links are not followed.
fn collect(folder: &Path, prefix: &str, files: &mut BTreeMap<String, u64>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        let file_type = entry.file_type()?;
        if file_type.is_dir() {
            collect(&entry.path(), &format!("{name}/"), files)?;
        } else if file_type.is_file() {
            files.insert(name, entry.metadata()?.len());
        }
    }
    Ok(())
}
