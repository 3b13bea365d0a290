//! The end of the program by a library that it has loaded, an FMU or a driver, is no success.
//!
//! Such a library may call `exit`, `quick_exit`, `_exit` or `_Exit`, while it is loaded as well, and the
//! program would end as if it had done what was asked for. Under [`guard`] its exit code is then 2, with a line
//! on standard error. That is so on Linux with glibc; elsewhere nothing is guarded, and a library that makes the
//! system's call by itself is not seen.
//!
//! If such a library crashes, so does the program, as the operating system wants it; but a line on standard error
//! names the FMU and the call that it was in, and the folder of temporary files is removed (Unix).

#[cfg(unix)]
mod crash;

use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

static FINISHED: AtomicBool = AtomicBool::new(false);
/// Tells what is loaded, for the message.
static NAMES: OnceLock<fn() -> Vec<String>> = OnceLock::new();

/// Passes on the FMU that this thread is inside of, by name, and the call, if there is one. It is called while a
/// signal is handled, so it may neither wait nor allocate.
pub type Inside = fn(&mut dyn FnMut(&[u8], &str));

/// From now on an end of this process before [`finished`] is no success, and a crash is reported. `names` tells
/// the FMUs that there are, without waiting for anybody.
pub fn guard(names: fn() -> Vec<String>, inside: Inside) {
    if NAMES.set(names).is_ok() {
        #[cfg(all(target_os = "linux", target_env = "gnu"))]
        linux::guard();
        #[cfg(unix)]
        crash::guard(inside);
        #[cfg(not(unix))]
        let _ = inside;
    }
}

/// A crash removes this folder, with everything in it.
pub fn temporary(folder: &Path) {
    #[cfg(unix)]
    crash::temporary(folder);
    #[cfg(not(unix))]
    let _ = folder;
}

/// The program ends of its own will.
pub fn finished() {
    FINISHED.store(true, Ordering::Relaxed);
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod linux {
    use std::ffi::{c_int, c_long, c_void};
    use std::io::Write;
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::{FINISHED, NAMES};

    unsafe extern "C" {
        fn on_exit(handler: extern "C" fn(c_int, *mut c_void), argument: *mut c_void) -> c_int;
        fn at_quick_exit(handler: extern "C" fn()) -> c_int;
        fn syscall(number: c_long, ...) -> c_long;
    }

    /// The number of the call that ends all threads.
    #[cfg(target_arch = "x86_64")]
    const EXIT_GROUP: c_long = 231;
    /// The number of that call on most architectures.
    #[cfg(not(target_arch = "x86_64"))]
    const EXIT_GROUP: c_long = 94;
    /// The code after a panic, which has its own message.
    const PANICKED: c_int = 101;

    /// The process that is guarded; its children are not.
    static GUARDED: AtomicU32 = AtomicU32::new(0);

    pub(super) fn guard() {
        GUARDED.store(std::process::id(), Ordering::Relaxed);
        // SAFETY: the handlers are functions of this program, and take no argument.
        unsafe {
            on_exit(left, std::ptr::null_mut());
            at_quick_exit(left_quickly);
        }
    }

    extern "C" fn left(code: c_int, _: *mut c_void) {
        if is_too_early(code) {
            end(2);
        }
    }

    extern "C" fn left_quickly() {
        if is_too_early(0) {
            end(2);
        }
    }

    /// Whether the program has not done what was asked for, which is reported.
    fn is_too_early(code: c_int) -> bool {
        let is_guarded = GUARDED.load(Ordering::Relaxed) == std::process::id();
        if !is_guarded || FINISHED.load(Ordering::Relaxed) || code == PANICKED {
            return false;
        }
        let names = NAMES.get().map(|names| names().join(", ")).unwrap_or_default();
        let names = if names.is_empty() { names } else { format!(" ({names})") };
        let _ = writeln!(
            std::io::stderr(),
            "error: an FMU{names} has ended this program from inside (exit); run it in a separate process, with --isolate, which keeps finished work"
        );
        true
    }

    fn end(code: c_int) -> ! {
        loop {
            // SAFETY: the call takes one number, and does not come back.
            unsafe { syscall(EXIT_GROUP, code) };
        }
    }

    /// The program's own `_exit`: libraries that are loaded later find it before that of the C library, which
    /// keeps its own for itself.
    #[unsafe(no_mangle)]
    extern "C" fn _exit(code: c_int) -> ! {
        end(if is_too_early(code) { 2 } else { code })
    }

    /// `_exit` under its name in the C standard.
    #[unsafe(no_mangle)]
    extern "C" fn _Exit(code: c_int) -> ! {
        _exit(code)
    }
}
