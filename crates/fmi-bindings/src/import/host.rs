//! What an FMU may leave changed of the program that runs it: the floating-point mode of the thread,
//! the working folder, the standard output. The first two are put back, with a message.

use std::path::PathBuf;

use super::log::Log;

/// Rounding, flush to zero and traps of this thread, without the flags that computing sets.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct FloatMode(u64);

impl FloatMode {
    /// The present mode.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    pub(super) fn now() -> Self {
        let mut word = 0_u32;
        // SAFETY: writes the control and status word into the four bytes of `word`.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut word, options(nostack, preserves_flags));
        }
        // Bits 0 to 5 are set by computing.
        FloatMode(u64::from(word) & !0x3f)
    }

    /// Makes this the mode.
    #[cfg(target_arch = "x86_64")]
    fn set(self) {
        let word = self.0 as u32;
        // SAFETY: a word that was read before, which has no reserved bit.
        unsafe {
            std::arch::asm!(
                "ldmxcsr [{}]", in(reg) &raw const word, options(nostack, preserves_flags, readonly)
            );
        }
    }

    /// The present mode.
    #[cfg(target_arch = "aarch64")]
    #[inline]
    pub(super) fn now() -> Self {
        let word: u64;
        // SAFETY: reads the control register, which every program may.
        unsafe {
            std::arch::asm!("mrs {}, fpcr", out(reg) word, options(nomem, nostack, preserves_flags));
        }
        FloatMode(word)
    }

    /// Makes this the mode.
    #[cfg(target_arch = "aarch64")]
    fn set(self) {
        // SAFETY: a word that was read before.
        unsafe {
            std::arch::asm!("msr fpcr, {}", in(reg) self.0, options(nomem, nostack, preserves_flags));
        }
    }

    /// Elsewhere the mode is not looked at.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    #[inline]
    pub(super) fn now() -> Self {
        FloatMode(0)
    }

    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    fn set(self) {}

    /// Puts this mode back where a call has left another one.
    #[inline]
    pub(super) fn keep(self, log: &Log) {
        if FloatMode::now() != self {
            self.set();
            log.mode_has_changed();
        }
    }
}

/// The working folder.
pub(super) struct Folder(Option<PathBuf>);

impl Folder {
    /// The present one.
    pub(super) fn now() -> Self {
        Folder(std::env::current_dir().ok())
    }

    /// Goes back to it where a call has left another one.
    pub(super) fn keep(&self, log: &Log, call: &str) {
        let Some(home) = &self.0 else { return };
        match std::env::current_dir() {
            Ok(now) if now == *home => {}
            now => {
                let now =
                    now.map_or_else(|_| "one that is gone".to_owned(), |p| p.display().to_string());
                let back = match std::env::set_current_dir(home) {
                    Ok(()) => "it was put back".to_owned(),
                    Err(error) => format!("{} cannot be entered again: {error}", home.display()),
                };
                log.remark(format!("by {call} the working folder had become {now}; {back}"));
            }
        }
    }
}

/// The standard output, which from now on nobody else writes to: what FMUs print goes to standard
/// error. To be called once, before anything is printed.
///
/// # Errors
/// If the operating system refuses; then nothing is changed.
#[cfg(unix)]
pub fn keep_standard_output() -> std::io::Result<std::fs::File> {
    use std::os::fd::AsFd;
    unsafe extern "C" {
        fn dup2(from: i32, to: i32) -> i32;
    }
    let kept = std::io::stdout().as_fd().try_clone_to_owned()?;
    // SAFETY: both are open; the standard output then means what standard error means.
    if unsafe { dup2(2, 1) } < 0 {
        return Err(std::io::Error::last_os_error());
    }
    Ok(kept.into())
}
