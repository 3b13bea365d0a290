//! Opens a page by the system's own opener.

use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};

/// The system's opener, and what it wants before the file.
const OPENER: (&str, &[&str]) = if cfg!(windows) {
    // The empty text is the window's title, which `start` would take the file for.
    ("cmd", &["/C", "start", ""])
} else if cfg!(target_os = "macos") {
    ("open", &[])
} else {
    ("xdg-open", &[])
};

/// So long an opener may fail; one that still runs has become the browser.
const PATIENCE: Duration = Duration::from_secs(2);

/// Opens a file in the browser.
pub(super) fn open(file: &Path) -> anyhow::Result<()> {
    let (program, arguments) = OPENER;
    let way_out = || format!("open {} in a browser", file.display());
    let mut child = Command::new(program)
        .args(arguments)
        .arg(file)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .with_context(|| format!("--plot: {program} cannot be started; {}", way_out()))?;
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        match child.try_wait()? {
            Some(status) if status.success() => return Ok(()),
            Some(status) => bail!("--plot: {program} failed ({status}); {}", way_out()),
            None => sleep(Duration::from_millis(10)),
        }
    }
    Ok(())
}
