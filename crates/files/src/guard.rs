//! Which files a call has read and written, so that no output takes the place of an input.

use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

/// What is known of the running call; `None` for a library's user, whose files are his own affair.
static CALL: Mutex<Option<Call>> = Mutex::new(None);

#[derive(Debug, Default)]
struct Call {
    twice: HashSet<PathBuf>,
    read: HashSet<PathBuf>,
    written: HashSet<PathBuf>,
}

/// Begins to guard the files of a call. `named` are the files of its command line: one that is named
/// twice cannot be written.
pub fn guard<'a>(named: impl IntoIterator<Item = &'a Path>) {
    let mut seen = HashSet::new();
    let twice = named.into_iter().map(identity).filter(|path| !seen.insert(path.clone())).collect();
    *call() = Some(Call { twice, ..Call::default() });
}

/// Says that `path` is read: under [`guard`] it is not written any more, unless this call made it.
pub fn note_read(path: &Path) {
    if let Some(call) = call().as_mut() {
        call.read.insert(identity(path));
    }
}

/// Whether the regular or new file `target` may be written.
pub(crate) fn may_write(target: &Path) -> io::Result<()> {
    let call = call();
    let Some(call) = call.as_ref() else { return Ok(()) };
    let path = identity(target);
    let refuse = |rule: &str| Err(io::Error::new(io::ErrorKind::InvalidInput, rule));
    if call.twice.contains(&path) {
        return refuse(
            "is named twice in this call; an output is no input and no other output: give another file, as with -o FILE",
        );
    }
    if call.read.contains(&path) && !call.written.contains(&path) {
        return refuse("is also read by this command; give another file");
    }
    Ok(())
}

/// The temporary files that have not got their names yet.
pub(crate) fn unfinished() -> MutexGuard<'static, HashSet<PathBuf>> {
    static FILES: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(crate) fn note_written(target: &Path) {
    if let Some(call) = call().as_mut() {
        call.written.insert(identity(target));
    }
}

fn call() -> MutexGuard<'static, Option<Call>> {
    // Sets of paths are whole after a panic as well.
    CALL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// One path for one file, there or not.
fn identity(path: &Path) -> PathBuf {
    if let Ok(found) = path.canonicalize() {
        return found;
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}
