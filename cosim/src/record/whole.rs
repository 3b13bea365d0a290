//! Files that appear whole.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// The name a file gets when it is complete.
pub(super) struct Whole {
    path: PathBuf,
}

impl Whole {
    pub(super) fn new(path: &Path) -> Self {
        Whole { path: path.to_path_buf() }
    }

    /// A temporary file beside it, which vanishes unless it is persisted.
    pub(super) fn temporary(&self) -> io::Result<NamedTempFile> {
        let folder = match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        NamedTempFile::new_in(folder)
    }

    /// Gives the file its name, in place of a file that has it.
    pub(super) fn persist(&self, file: NamedTempFile) -> io::Result<()> {
        readable_by_others(file.as_file())?;
        file.persist(&self.path)?;
        Ok(())
    }
}

/// Temporary files are private; this one becomes a file like others.
#[cfg(unix)]
fn readable_by_others(file: &File) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable_by_others(_: &File) -> io::Result<()> {
    Ok(())
}
