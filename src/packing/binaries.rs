//! Libraries for further platforms: `--binary` and `--libraries`.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use fmi_bindings::export::Library;
use modeldescription::package::Platform;
use modeldescription::{ModelDescription, check_library};

/// This library for all platforms in a folder.
pub(crate) fn binaries_in(folder: &Path, library: Library) -> anyhow::Result<Vec<Binary>> {
    binary_texts_in(folder, library)?.iter().map(|text| Binary::read(text)).collect()
}

/// This library for all platforms in a folder, as `PLATFORM=FILE`.
fn binary_texts_in(folder: &Path, library: Library) -> anyhow::Result<Vec<String>> {
    let entries = |folder: &Path| -> anyhow::Result<Vec<PathBuf>> {
        let read = std::fs::read_dir(folder)
            .with_context(|| format!("--libraries {}: no such folder", folder.display()))?;
        let mut paths = read.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>()?;
        paths.sort();
        Ok(paths)
    };
    let stem = library.stem();
    let mut found = Vec::new();
    for platform in entries(folder)?.iter().filter(|path| path.is_dir()) {
        let name = platform.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if Platform::from_name(&name).is_none() {
            continue;
        }
        let is_wanted = |path: &&PathBuf| {
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            file.strip_prefix("lib").unwrap_or(&file).split('.').next() == Some(stem)
        };
        let files = entries(platform)?;
        found.extend(files.iter().find(is_wanted).map(|file| format!("{name}={}", file.display())));
    }
    if found.is_empty() {
        bail!(
            "--libraries {}: no library {stem} lies in a folder of a platform there, such as \
             linux64/lib{stem}.so; dev/tools/portable makes such a folder",
            folder.display()
        );
    }
    Ok(found)
}

/// A library given with `--binary`.
pub(crate) struct Binary {
    /// As it was given, for messages.
    pub(super) text: String,
    pub(crate) platform: Platform,
    pub(crate) bytes: Vec<u8>,
}

impl Binary {
    /// Reads `PLATFORM=FILE`.
    pub(crate) fn read(text: &str) -> anyhow::Result<Self> {
        let Some((name, file)) = text.split_once('=') else {
            bail!("--binary {text}: write PLATFORM=FILE, as in win64=piezoloop_fmu_blueprint.dll");
        };
        let Some(platform) = Platform::from_name(name) else {
            bail!(
                "--binary {text}: \"{name}\" is no platform of FMI; use linux64, win64, darwin64, \
                 aarch64-linux, …"
            );
        };
        files::note_read(std::path::Path::new(file));
        let bytes = std::fs::read(file)
            .with_context(|| format!("--binary {text}: {file} cannot be read"))?;
        Ok(Self { text: text.to_owned(), platform, bytes })
    }

    /// Whether it is this library of this tool, for the platform that was given.
    pub(crate) fn check(
        &self,
        wanted: Library,
        description: &ModelDescription,
    ) -> anyhow::Result<()> {
        if let Some(fault) = check_library(&self.bytes, self.platform, description).first() {
            bail!("--binary {}: {fault}", self.text);
        }
        let found = Library::of(&self.bytes);
        if found == Some(wanted) {
            return Ok(());
        }
        bail!(
            "--binary {}: the file is {}; this FMU needs {}, built from the sources of this tool",
            self.text,
            found.map_or("no library of Piezoloop", Library::stem),
            wanted.stem()
        )
    }
}
