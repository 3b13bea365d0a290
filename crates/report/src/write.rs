//! Files that appear complete or not at all.

use std::path::Path;

use crate::error::ReportError;

/// Writes `text` as the complete file `path`.
pub(crate) fn complete(path: &Path, text: &str) -> Result<(), ReportError> {
    files::AtomicFile::write_all_of(path, text.as_bytes())
        .map_err(|source| ReportError::Write { path: path.to_path_buf(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("page.html");
        complete(&path, "one").unwrap();
        complete(&path, "two").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = complete(Path::new("no/such/folder/page.html"), "").unwrap_err().to_string();
        assert!(error.contains("no/such/folder/page.html"), "{error}");
    }
}
