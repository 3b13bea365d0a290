//! A crash is reported, then it happens.
//!
//! The handler of a signal may find the program in any state: it calls only what POSIX allows there, and
//! `posix_spawn`, which allocates nothing in the C libraries that there are. So it has its texts and places ready.

use std::ffi::{c_char, c_int, c_void};
use std::mem::MaybeUninit;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::ptr;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};

use super::{FINISHED, Inside};

/// What a crash is, as the operating system has it.
const SIGNALS: [(c_int, &str); 5] = [
    (libc::SIGSEGV, "SIGSEGV"),
    (libc::SIGBUS, "SIGBUS"),
    (libc::SIGFPE, "SIGFPE"),
    (libc::SIGILL, "SIGILL"),
    (libc::SIGABRT, "SIGABRT"),
];
/// Most bytes of the folder's path, with the zero at its end.
const LONGEST_PATH: usize = 1024;

/// The process that is guarded; its children are not.
static GUARDED: AtomicI32 = AtomicI32::new(0);
static INSIDE: OnceLock<Inside> = OnceLock::new();
static FOLDER: OnceLock<[u8; LONGEST_PATH]> = OnceLock::new();
/// Who handled the signals before: Rust's runtime, which knows a stack that has overflowed.
static EARLIER: [OnceLock<libc::sigaction>; SIGNALS.len()] = [const { OnceLock::new() }; 5];
/// A crash was reported; it may bring about another one.
static REPORTED: AtomicBool = AtomicBool::new(false);

type Handler = unsafe extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void);

pub(super) fn guard(inside: Inside) {
    // SAFETY: asks for a number.
    GUARDED.store(unsafe { libc::getpid() }, Ordering::Relaxed);
    let _ = INSIDE.set(inside);
    for ((signal, _), earlier) in SIGNALS.iter().zip(&EARLIER) {
        let mut before = MaybeUninit::<libc::sigaction>::zeroed();
        // SAFETY: both are of the operating system's type, all of whose members may be zero; the handler is
        // a function of this program, for the flags given. It runs on the thread's other stack, where it has
        // one: that of an overflow is full.
        unsafe {
            let mut own: libc::sigaction = std::mem::zeroed();
            own.sa_sigaction = crashed as Handler as usize;
            own.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigemptyset(&raw mut own.sa_mask);
            if libc::sigaction(*signal, &raw const own, before.as_mut_ptr()) == 0 {
                let _ = earlier.set(before.assume_init());
            }
        }
    }
}

pub(super) fn temporary(folder: &Path) {
    let bytes = folder.as_os_str().as_bytes();
    if bytes.len() < LONGEST_PATH {
        let mut path = [0; LONGEST_PATH];
        path[..bytes.len()].copy_from_slice(bytes);
        let _ = FOLDER.set(path);
    }
}

unsafe extern "C" fn crashed(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    // SAFETY: asks for a number.
    let is_guarded = unsafe { libc::getpid() } == GUARDED.load(Ordering::Relaxed);
    if is_guarded && !REPORTED.swap(true, Ordering::Relaxed) {
        report(signal);
        remove_folder();
    }
    let place = SIGNALS.iter().position(|known| known.0 == signal);
    let earlier = place.and_then(|place| EARLIER.get(place)).and_then(OnceLock::get);
    // SAFETY: with this flag the earlier handler is a function of these arguments, and no constant; the signal
    // is blocked until this handler returns, and then ends the program as if it had not been caught.
    unsafe {
        if let Some(earlier) = earlier.filter(|e| {
            e.sa_flags & libc::SA_SIGINFO != 0
                && e.sa_sigaction != libc::SIG_DFL
                && e.sa_sigaction != libc::SIG_IGN
        }) {
            let handler = std::mem::transmute::<usize, Handler>(earlier.sa_sigaction);
            handler(signal, info, context);
        }
        libc::signal(signal, libc::SIG_DFL);
        libc::raise(signal);
    }
}

/// Writes what has crashed.
fn report(signal: c_int) {
    let name = SIGNALS.iter().find(|known| known.0 == signal).map_or("a signal", |known| known.1);
    let mut line = Line::default();
    let mut is_inside = false;
    if let Some(inside) = INSIDE.get() {
        inside(&mut |fmu, call| {
            is_inside = true;
            line.add(b"error: ");
            if fmu.is_empty() {
                line.add(b"an FMU: ");
            } else {
                line.add(b"FMU `");
                line.add_name(fmu);
                line.add(b"`: ");
            }
            line.add(call.as_bytes());
            line.add(b" has not returned, because the FMU crashed (");
            line.add(name.as_bytes());
            line.add(
                b"), and this program with it; with --isolate (simulate, system, sweep, tune, diagnose) it runs in a separate process, and finished work is kept\n",
            );
        });
    }
    if !is_inside {
        line.add(b"error: this program has crashed (");
        line.add(name.as_bytes());
        line.add(if FINISHED.load(Ordering::Relaxed) {
            b") at its end, after its work was done, in no call of an FMU"
        } else {
            b"), in no call of an FMU"
        });
        line.add(b": by a library that it has loaded (a thread of an FMU, a driver), or a defect of this program\n");
    }
    line.write();
}

/// Removes the folder of temporary files by another process: this one's memory may be in disorder.
fn remove_folder() {
    let Some(folder) = FOLDER.get() else { return };
    let arguments: [*const c_char; 5] =
        [c"rm".as_ptr(), c"-rf".as_ptr(), c"--".as_ptr(), folder.as_ptr().cast(), ptr::null()];
    let environment: [*const c_char; 1] = [ptr::null()];
    let mut child = 0;
    // SAFETY: the texts end with a zero, the lists with null; all live as long as the program.
    unsafe {
        let started = libc::posix_spawn(
            &raw mut child,
            c"/bin/rm".as_ptr(),
            ptr::null(),
            ptr::null(),
            arguments.as_ptr().cast(),
            environment.as_ptr().cast(),
        );
        if started == 0 {
            while libc::waitpid(child, ptr::null_mut(), 0) < 0
                && std::io::Error::last_os_error().kind() == std::io::ErrorKind::Interrupted
            {
            }
        }
    }
}

/// A line, which is written at once unless it is very long.
struct Line {
    bytes: [u8; 512],
    length: usize,
}

impl Default for Line {
    fn default() -> Self {
        Line { bytes: [0; 512], length: 0 }
    }
}

impl Line {
    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if self.length == self.bytes.len() {
                self.write();
            }
            self.bytes[self.length] = *byte;
            self.length += 1;
        }
    }

    /// A name from a file does nothing to the terminal.
    fn add_name(&mut self, name: &[u8]) {
        for byte in name {
            self.add(&[if byte.is_ascii_control() { b'?' } else { *byte }]);
        }
    }

    fn write(&mut self) {
        // SAFETY: the bytes are there. What cannot be written is lost.
        let _ = unsafe { libc::write(2, self.bytes.as_ptr().cast(), self.length) };
        self.length = 0;
    }
}
