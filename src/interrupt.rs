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
/// The folder of all temporary files of this call.
static FOLDER: Mutex<Option<TempDir>> = Mutex::new(None);

/// Held by the program as long as it works: the temporary files go with it.
pub(crate) struct Tidy;

impl Drop for Tidy {
    fn drop(&mut self) {
        tidy();
    }
}

/// Puts temporary files in one folder and catches signals. Where the system gives no folder or no
/// thread for that, the commands that need one say so.
pub(crate) fn begin() -> Tidy {
    let folder = tempfile::Builder::new().prefix("piezoloop-").tempdir();
    if let Ok(folder) = folder
        && tempfile::env::override_temp_dir(folder.path()).is_ok()
    {
        *held(&FOLDER) = Some(folder);
    }
    IS_CAUGHT.store(catch().is_ok(), Ordering::Relaxed);
    Tidy
}

/// A temporary folder that outlives this call.
pub(crate) fn lasting_folder() -> std::path::PathBuf {
    let own = held(&FOLDER).as_ref().and_then(|own| own.path().parent().map(Path::to_owned));
    own.unwrap_or_else(std::env::temp_dir)
}

/// From now on a signal is noted; a second one ends the program at once.
///
/// # Errors
/// Where signals cannot be caught.
pub(crate) fn listen() -> anyhow::Result<()> {
    instead(Manner::IsNoted)
}

/// From now on signals go to the command, with their number from 1.
///
/// # Errors
/// Where signals cannot be caught.
pub(crate) fn hand_over(to: impl Fn(usize) + Send + 'static) -> anyhow::Result<()> {
    instead(Manner::GoesTo(Box::new(to)))
}

fn instead(manner: Manner) -> anyhow::Result<()> {
    if !IS_CAUGHT.load(Ordering::Relaxed) {
        bail!(
            "signals cannot be caught: the system gives no thread for that; allow more (ulimit -u)"
        );
    }
    *held(&MANNER) = manner;
    Ok(())
}

/// Whether the end was asked for.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

fn held<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

fn tidy() {
    files::abandon();
    // A folder that cannot be removed is only untidy.
    drop(held(&FOLDER).take());
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
                tidy();
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
            tidy();
            exits::finished();
            std::process::exit(130);
        }
    });
    caught.map_err(io::Error::other)
}
