//! Which files a call has read and written, so that no output takes the place of an input.

use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

/// What is known of the running call; `None` for a library's user, whose files are his own affair.
static CALL: Mutex<Option<Call>> = Mutex::new(None);

#[derive(Debug, Default)]
struct Call {
    named: HashSet<PathBuf>,
    twice: HashSet<PathBuf>,
    read: HashSet<PathBuf>,
    written: HashSet<PathBuf>,
    /// What was to be written, as it was named, in that order.
    wanted: Vec<(PathBuf, PathBuf)>,
}

/// Begins to guard the files of a call. `named` are the files of its command line: one that is named
/// twice cannot be written.
pub fn guard<'a>(named: impl IntoIterator<Item = &'a Path>) {
    let mut seen = HashSet::new();
    let twice = named.into_iter().map(identity).filter(|path| !seen.insert(path.clone())).collect();
    *call() = Some(Call { named: seen, twice, ..Call::default() });
}

/// Notes that `path` is read: under [`guard`] it is not written any more, unless this call created it.
pub fn note_read(path: &Path) {
    if let Some(call) = call().as_mut() {
        call.read.insert(identity(path));
    }
}

/// Says that a folder is read, as [`note_read`] does of each file below it: an unpacked archive.
pub fn note_read_below(folder: &Path) {
    // A folder of an archive has a few files; a circle of links ends at some depth.
    let mut left = vec![(folder.to_owned(), 0)];
    while let Some((folder, depth)) = left.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            match entry.path() {
                path if path.is_dir() && depth < 16 => left.push((path, depth + 1)),
                path => note_read(&path),
            }
        }
    }
}

/// Whether the file `path`, which the user did not name, may be written beside one that he did: where he
/// named it for something else, or this call has written it, not; where it is there, if `is_ours`.
///
/// # Errors
/// What speaks against it.
pub fn check_beside(path: &Path, is_ours: impl FnOnce() -> bool) -> io::Result<()> {
    let refuse = |kind, rule: &str| Err(io::Error::new(kind, rule));
    let own = identity(path);
    if let Some(call) = call().as_ref()
        && (call.named.contains(&own) || call.written.contains(&own))
    {
        return refuse(
            io::ErrorKind::InvalidInput,
            "would be written beside another output, but is a file of this call itself; give one of them another name",
        );
    }
    match std::fs::symlink_metadata(path) {
        Ok(_) if !is_ours() => refuse(
            io::ErrorKind::AlreadyExists,
            "is there and was not written by this program; move it away, or give the output another name",
        ),
        _ => Ok(()),
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
            "this command already uses the file; an output must differ from all inputs and other outputs: give another file, as with -o FILE",
        );
    }
    if call.read.contains(&path) && !call.written.contains(&path) {
        return refuse("this command also reads the file; give another file");
    }
    Ok(())
}

/// The temporary files that have not got their names yet.
pub(crate) fn unfinished() -> MutexGuard<'static, HashSet<PathBuf>> {
    static FILES: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The files that the call was to write so far, as it named them, and whether each is written.
#[must_use]
pub fn wanted() -> Vec<(PathBuf, bool)> {
    let call = call();
    let Some(call) = call.as_ref() else { return Vec::new() };
    let file = |(path, named): &(PathBuf, PathBuf)| (named.clone(), call.written.contains(path));
    call.wanted.iter().map(file).collect()
}

/// Says that the file `target` is to be written, which was named like this.
pub(crate) fn note_wanted(target: &Path, named: &Path) {
    if let Some(call) = call().as_mut() {
        let path = identity(target);
        if call.wanted.iter().all(|(other, _)| *other != path) {
            call.wanted.push((path, named.to_owned()));
        }
    }
}

/// Says that `target` stands as this call wants it: it was written, or was the same already.
pub fn note_written(target: &Path) {
    if let Some(call) = call().as_mut() {
        call.written.insert(identity(target));
    }
}

fn call() -> MutexGuard<'static, Option<Call>> {
    // Sets of paths are complete after a panic as well.
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
