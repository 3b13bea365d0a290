//! Where results are written: whether a file can be, before the work.

use std::path::Path;

use anyhow::{Context, bail};

/// Endings of pages, and of the same as data.
pub(crate) const REPORT: &[&str] = &["html", "htm", "json"];

/// Whether a file's name ends in this, in letters of any size: `fmu` for `plant.FMU`.
#[must_use]
pub fn ends_in(file: &Path, ending: &str) -> bool {
    file.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending))
}

/// Whether a file can be written there; told before the work, so that no result is lost.
///
/// # Errors
/// Where it cannot; the message says why.
pub fn can_write(output: &Path) -> anyhow::Result<()> {
    // A pipe is opened once, by who writes to it.
    if std::fs::metadata(output).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Ok(());
    }
    let begun = data::AtomicFile::create(output);
    begun.map(drop).with_context(|| format!("{} cannot be written", output.display()))
}

/// As [`can_write`], and whether its ending is one of these: by another one it would be read as what it is not.
/// A name without an ending says nothing of the kind, and a pipe or device none.
///
/// # Errors
/// Where it cannot, or has another ending.
pub fn can_write_as(output: &Path, endings: &[&str]) -> anyhow::Result<()> {
    can_write(output)?;
    let is_other = std::fs::metadata(output).is_ok_and(|found| !found.is_file());
    let ending = output.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    if let Some(ending) = ending.filter(|ending| !is_other && !endings.contains(&ending.as_str())) {
        let (last, others) = endings.split_last().context("there is an ending")?;
        let known = match others {
            [] => format!(".{last}"),
            others => format!(".{} or .{last}", others.join(", .")),
        };
        bail!(
            "{}: .{ending} is not written here; give a name that ends in {known}",
            output.display()
        );
    }
    Ok(())
}
