//! Files that appear whole or not at all.

use std::io::Write as _;
use std::path::Path;

use crate::error::ReportError;

/// Writes `text` to a new file beside `path` and renames it over `path`.
pub(crate) fn whole(path: &Path, text: &str) -> Result<(), ReportError> {
    try_whole(path, text).map_err(|source| ReportError::Write { path: path.to_path_buf(), source })
}

fn try_whole(path: &Path, text: &str) -> std::io::Result<()> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut file = tempfile::Builder::new()
        .prefix(".piezoloop-report-")
        .permissions_if_unix()
        .tempfile_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// Temporary files are private by default; a report is to be read by others as well.
trait Readable {
    fn permissions_if_unix(&mut self) -> &mut Self;
}

impl Readable for tempfile::Builder<'_, '_> {
    #[cfg(unix)]
    fn permissions_if_unix(&mut self) -> &mut Self {
        use std::os::unix::fs::PermissionsExt as _;
        self.permissions(std::fs::Permissions::from_mode(0o644))
    }

    #[cfg(not(unix))]
    fn permissions_if_unix(&mut self) -> &mut Self {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("page.html");
        whole(&path, "one").unwrap();
        whole(&path, "two").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = whole(Path::new("no/such/folder/page.html"), "").unwrap_err().to_string();
        assert!(error.contains("no/such/folder/page.html"), "{error}");
    }
}
