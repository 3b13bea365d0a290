//! Ctrl-C, SIGTERM and SIGHUP: a wish to end. Work that can hand over what it has does so; every
//! other call ends at once, and leaves no temporary file or folder.

use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::bail;
use tempfile::TempDir;

/// What a signal does.
enum Manner {
    /// Ends the program.
    Ends,
    /// Is noted; a second one ends the program.
    IsNoted,
    /// Goes, with its number from 1, to the command.
    GoesTo(Box<dyn Fn(usize) + Send>),
}

static MANNER: Mutex<Manner> = Mutex::new(Manner::Ends);
static ASKED: AtomicBool = AtomicBool::new(false);
static COUNT: AtomicUsize = AtomicUsize::new(0);
static IS_CAUGHT: AtomicBool = AtomicBool::new(false);
/// A signal is ending the program.
static IS_ENDING: AtomicBool = AtomicBool::new(false);
/// The folder of all temporary files of this call.
static FOLDER: Mutex<Option<TempDir>> = Mutex::new(None);

/// Held by the program as long as it works: the temporary files go with it.
pub struct Tidy;

impl Drop for Tidy {
    fn drop(&mut self) {
        tidy();
    }
}

/// Puts temporary files in one folder and catches signals. Where the system gives no folder or no
/// thread for that, the commands that need one say so.
pub fn begin() -> Tidy {
    let folder = tempfile::Builder::new().prefix("piezoloop-").tempdir();
    if let Ok(folder) = folder
        && tempfile::env::override_temp_dir(folder.path()).is_ok()
    {
        exits::temporary(folder.path());
        *held(&FOLDER) = Some(folder);
    }
    IS_CAUGHT.store(catch().is_ok(), Ordering::Relaxed);
    Tidy
}

/// A temporary folder that outlives this call.
pub fn lasting_folder() -> std::path::PathBuf {
    let own = held(&FOLDER).as_ref().and_then(|own| own.path().parent().map(Path::to_owned));
    own.unwrap_or_else(std::env::temp_dir)
}

/// From now on a signal is noted; a second one ends the program at once.
///
/// # Errors
/// Where signals cannot be caught.
pub fn listen() -> anyhow::Result<()> {
    instead(Manner::IsNoted)
}

/// From now on signals go to the command, with their number from 1.
///
/// # Errors
/// Where signals cannot be caught.
pub fn hand_over(to: impl Fn(usize) + Send + 'static) -> anyhow::Result<()> {
    instead(Manner::GoesTo(Box::new(to)))
}

fn instead(manner: Manner) -> anyhow::Result<()> {
    if !IS_CAUGHT.load(Ordering::Relaxed) {
        bail!(
            "signals cannot be caught: the system gives no thread for that; allow more (ulimit -u, a container's limit of processes)"
        );
    }
    *held(&MANNER) = manner;
    Ok(())
}

/// Whether the end was asked for.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

fn held<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// At the end of the work, when nobody uses the temporary folder any more.
fn tidy() {
    files::abandon();
    // A folder that cannot be removed is only untidy.
    drop(held(&FOLDER).take());
}

/// In the midst of the work: whoever unpacks or writes there would make anew what is removed. The folder
/// goes by another name first, and a file takes the place of the old one until the end.
fn tidy_at_work() {
    IS_ENDING.store(true, Ordering::Relaxed);
    files::abandon();
    let Some(folder) = held(&FOLDER).take().map(TempDir::keep) else { return };
    let mut gone = Vec::new();
    for number in 0..10 {
        let name = folder.with_extension(format!("gone{number}"));
        if std::fs::rename(&folder, &name).is_ok() {
            gone.push(name);
        }
        // Somebody may have made the folder again in between.
        if std::fs::File::create_new(&folder).is_ok() {
            break;
        }
    }
    for place in gone.iter().chain([&folder]).filter(|place| place.is_dir()) {
        // What is open there may yet get a file.
        for _ in 0..10 {
            match std::fs::remove_dir_all(place) {
                Ok(()) => break,
                Err(_) => std::thread::sleep(std::time::Duration::from_millis(5)),
            }
        }
    }
    let _ = std::fs::remove_file(&folder);
}

/// Where a signal is ending the program, waits for that: what fails meanwhile fails by it.
pub fn wait_if_ending() {
    while IS_ENDING.load(Ordering::Relaxed) {
        std::thread::park();
    }
}

/// A signal came; whether the program shall end now.
fn ends() -> bool {
    let count = COUNT.fetch_add(1, Ordering::Relaxed) + 1;
    match &*held(&MANNER) {
        Manner::Ends => true,
        Manner::IsNoted => ASKED.swap(true, Ordering::Relaxed),
        Manner::GoesTo(command) => {
            command(count);
            false
        }
    }
}

#[cfg(unix)]
fn catch() -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut all = vec![SIGINT, SIGTERM];
    // `nohup` has it ignored, and means it.
    if !is_ignored(SIGHUP) {
        all.push(SIGHUP);
    }
    let mut signals = signal_hook::iterator::Signals::new(all)?;
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for signal in signals.forever() {
            if ends() {
                tidy_at_work();
                exits::finished();
                // As if it had not been caught, so that a shell sees what happened.
                let _ = signal_hook::low_level::emulate_default_handler(signal);
                std::process::exit(128 + signal);
            }
        }
    })?;
    Ok(())
}

/// Whether this program was started with a signal ignored, as far as the system tells.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else { return false };
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(not(unix))]
fn catch() -> io::Result<()> {
    let caught = ctrlc::set_handler(|| {
        if ends() {
            tidy_at_work();
            exits::finished();
            std::process::exit(130);
        }
    });
    caught.map_err(io::Error::other)
}
