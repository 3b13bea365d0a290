//! How every file is written: completely or not at all, through links and devices, with the permissions
//! that it had, and under [`guard`] never over an input.

mod guard;

pub use guard::{check_beside, guard, note_read, note_read_below, note_written, wanted};
use guard::{note_wanted, unfinished};

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes to a temporary file in the same folder; [`commit`](Self::commit) gives it its name.
/// Dropped before that, nothing remains and an older file stays as it was.
///
/// A target that exists and is no regular file (a pipe, `/dev/stdout`) is written to directly; a
/// symbolic link stays one, its file is written. A file that is replaced keeps its permissions.
#[derive(Debug)]
pub struct AtomicFile {
    target: PathBuf,
    /// The temporary file; `None` once committed, or for a pipe.
    temporary: Option<PathBuf>,
    writer: Option<BufWriter<File>>,
}

/// Numbers the temporary files of this process.
static COUNTER: AtomicU64 = AtomicU64::new(0);

impl AtomicFile {
    /// Starts to write the file `target`.
    ///
    /// # Errors
    /// The folder is absent or not writable, or `target` is a folder or write-protected.
    pub fn create(target: &Path) -> io::Result<Self> {
        let named = target;
        // A symbolic link stays one: its file is replaced. The whole path, so that another working
        // folder, which a foreign FMU may bring about, does not move the file.
        let target = fs::canonicalize(target).or_else(|_| std::path::absolute(follow(target)?))?;
        match fs::metadata(&target) {
            Ok(found) if found.is_dir() => {
                return Err(io::Error::new(
                    io::ErrorKind::IsADirectory,
                    "is a folder; give the name of a file in it",
                ));
            }
            Ok(found) if found.is_file() && found.permissions().readonly() => {
                return Err(io::Error::new(
                    io::ErrorKind::PermissionDenied,
                    "is write-protected; take the protection off or give another file",
                ));
            }
            // Opened to write only: a socket or the like is refused by the system.
            Ok(found) if !found.is_file() => {
                let file = OpenOptions::new().write(true).open(&target)?;
                return Ok(Self { target, temporary: None, writer: Some(BufWriter::new(file)) });
            }
            _ => {}
        }
        guard::may_write(&target)?;
        note_wanted(&target, named);
        let name = target.file_name().ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidInput, "has no file name; give one")
        })?;
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let name = format!(".{}.{}-{number}.tmp", name.to_string_lossy(), std::process::id());
        let temporary = target.with_file_name(name);
        let mut files = unfinished();
        let file = OpenOptions::new().write(true).create_new(true).open(&temporary)?;
        files.insert(temporary.clone());
        drop(files);
        // Before anything is in it: a private file stays private. A failure removes the temporary one.
        let permissions = fs::metadata(&target).map(|found| found.permissions());
        let mut begun = Self { target, temporary: Some(temporary), writer: None };
        if let Ok(permissions) = permissions {
            file.set_permissions(permissions)?;
        }
        begun.writer = Some(BufWriter::with_capacity(1 << 16, file));
        Ok(begun)
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// The disk is full, or the file cannot be renamed; nothing remains then.
    pub fn commit(mut self) -> io::Result<()> {
        if let Some(mut writer) = self.writer.take() {
            writer.flush()?;
        }
        if let Some(temporary) = &self.temporary {
            // Not while somebody abandons it: the program ends by what ends it, not by a file that is gone.
            let mut files = unfinished();
            fs::rename(temporary, &self.target)?;
            files.remove(temporary);
            drop(files);
            self.temporary = None;
            note_written(&self.target);
        }
        Ok(())
    }

    /// Writes `bytes` as the complete file `target`.
    ///
    /// # Errors
    /// The file cannot be created, written or renamed.
    pub fn write_all_of(target: &Path, bytes: &[u8]) -> io::Result<()> {
        let mut file = Self::create(target)?;
        file.write_all(bytes)?;
        file.commit()
    }
}

/// The file that a chain of links names where that file is not there.
fn follow(link: &Path) -> io::Result<PathBuf> {
    let mut path = link.to_owned();
    for _ in 0..40 {
        match fs::metadata(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            // A circle of links, for one.
            Err(error) => return Err(error),
            Ok(_) => return Ok(path),
        }
        let Ok(next) = fs::read_link(&path) else { return Ok(path) };
        path = path.parent().map_or(next.clone(), |folder| folder.join(&next));
    }
    Err(io::Error::new(
        io::ErrorKind::InvalidInput,
        "is a symbolic link that leads round in a circle",
    ))
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.writer {
            Some(writer) => writer.write(bytes),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }
    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

/// What is written so far can be overwritten; not through a pipe.
impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match &mut self.writer {
            Some(writer) => writer.seek(to),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        drop(self.writer.take());
        if let Some(temporary) = self.temporary.take() {
            // Nothing can be done about a failure here, and the target is untouched.
            let _ = fs::remove_file(&temporary);
            unfinished().remove(&temporary);
        }
    }
}

/// A file that is read while it is written, and after a crash: in its place from the first byte on.
///
/// # Errors
/// The file cannot be created.
pub fn in_place(target: &Path) -> io::Result<File> {
    if fs::metadata(target).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return OpenOptions::new().write(true).open(target);
    }
    drop(AtomicFile::create(target)?);
    let file = File::create(target)?;
    note_written(target);
    Ok(file)
}

/// Longest text that [`read_text`] reads, in bytes.
pub const LONGEST_TEXT: u64 = 16 << 20;

/// Reads a file of settings, a blueprint, a plan or what describes a log, which is an input from then on.
///
/// # Errors
/// It cannot be read, is longer than `longest` bytes, or is no UTF-8.
pub fn read_text_within(path: &Path, longest: u64) -> io::Result<String> {
    note_read(path);
    let mut bytes = Vec::new();
    File::open(path)?.take(longest.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > longest {
        let rule = format!("it is longer than {longest} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, rule));
    }
    let is_archive = bytes.starts_with(b"PK\x03\x04");
    String::from_utf8(bytes).map_err(|_| {
        let rule = if is_archive {
            "it is an FMU or another zip archive, no text"
        } else {
            "it is no text in UTF-8"
        };
        io::Error::new(io::ErrorKind::InvalidData, rule)
    })
}

/// [`read_text_within`] [`LONGEST_TEXT`].
///
/// # Errors
/// It cannot be read, is too long, or is no UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    read_text_within(path, LONGEST_TEXT)
}

/// Removes what this process has begun and not finished, for a program that ends at once: whoever finishes
/// or begins a file waits from then on.
pub fn abandon() {
    let mut files = unfinished();
    for file in files.drain() {
        // It is only untidy.
        let _ = fs::remove_file(file);
    }
    std::mem::forget(files);
}

/// The folder for what a command makes: new, empty, or one that an earlier call has made, which left
/// one of `marks` there.
///
/// # Errors
/// It cannot be made, or holds other things.
pub fn own_folder(folder: &Path, marks: &[&str]) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let is_marked = marks.iter().any(|mark| folder.join(mark).exists());
    match fs::read_dir(folder)?.next() {
        Some(found) if !is_marked => {
            let found = found?.file_name();
            let rule = format!(
                "holds \"{}\" and is of no earlier call; give a new or an empty folder",
                found.to_string_lossy()
            );
            Err(io::Error::new(io::ErrorKind::InvalidInput, rule))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn appears_only_when_committed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert!(!path.exists());
        file.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["run.csv"]);
    }

    #[test]
    fn a_dropped_file_leaves_the_old_one_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        fs::write(&path, "old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        drop(file);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["run.csv"]);
    }

    #[test]
    fn a_write_protected_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        fs::write(&path, "old").unwrap();
        let mut protected = fs::metadata(&path).unwrap().permissions();
        protected.set_readonly(true);
        fs::set_permissions(&path, protected).unwrap();
        let error = AtomicFile::write_all_of(&path, b"new").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::PermissionDenied);
        assert!(error.to_string().contains("write-protected"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["run.csv"]);
    }

    #[test]
    fn refuses_folders_and_absent_folders() {
        let folder = tempfile::tempdir().unwrap();
        assert!(AtomicFile::create(folder.path()).is_err());
        assert!(AtomicFile::create(&folder.path().join("no/run.csv")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_stay_and_permissions_are_kept() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("private"), "old").unwrap();
        fs::set_permissions(at("private"), fs::Permissions::from_mode(0o600)).unwrap();
        symlink("private", at("link")).unwrap();
        symlink("absent", at("dangling")).unwrap();
        symlink("/dev/null", at("device")).unwrap();
        symlink("b", at("a")).unwrap();
        symlink("a", at("b")).unwrap();
        for name in ["link", "dangling", "device"] {
            AtomicFile::write_all_of(&at(name), b"new").unwrap();
            assert!(fs::symlink_metadata(at(name)).unwrap().is_symlink(), "{name}");
        }
        assert!(AtomicFile::write_all_of(&at("a"), b"new").is_err());
        assert_eq!(fs::read(at("private")).unwrap(), b"new");
        assert_eq!(fs::read(at("absent")).unwrap(), b"new");
        assert_eq!(fs::metadata(at("private")).unwrap().permissions().mode() & 0o777, 0o600);
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
