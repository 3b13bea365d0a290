//! Around every call: the instance's pointer, panics, the message of a notice.

use std::any::Any;
use std::cell::Cell;
use std::ffi::c_void;
use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::notice::{Notice, Status};

/// What an edge hands out pointers to.
pub(super) trait Guarded {
    /// Sends a message to the importer.
    fn send(&self, status: Status, message: &str);
    /// Notes that a call ended in an error.
    fn fail(&mut self) {}
}

/// Carries out one call on an instance; where it has a notice, the importer gets it and the status is the `Err`.
///
/// A null pointer is an error without a message, because nobody is there to log it.
///
/// # Safety
/// `pointer` is null or a `T` that an edge handed out and that is not freed, and no other
/// thread uses it during the call (FMI 2.0.5 §2.1, FMI 3.0 §2.2).
pub(super) unsafe fn call<T: Guarded, R>(
    pointer: *mut c_void,
    function: &str,
    body: impl FnOnce(&mut T) -> Result<R, Notice>,
) -> Result<R, Status> {
    let instance = pointer.cast::<T>();
    if instance.is_null() {
        return Err(Status::Error);
    }
    // Not through [`caught`]: moving a result that may hold a notice costs a nanosecond in each step.
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        #[cfg(test)]
        super::forced_panic_tests::strike();
        // SAFETY: not null, alive and used by this thread only, as the caller promises.
        body(unsafe { &mut *instance })
    }));
    let notice = match outcome {
        Ok(Ok(result)) => return Ok(result),
        Ok(Err(notice)) => notice,
        Err(payload) => Notice::error(panic_text(payload)),
    };
    // SAFETY: as above; the borrow of the body has ended.
    unsafe { report(instance, function, &notice) }
    Err(notice.status)
}

/// Tells the importer, and notes an error.
///
/// # Safety
/// The contract of [`call`], and `instance` is not null.
#[cold]
unsafe fn report<T: Guarded>(instance: *mut T, function: &str, notice: &Notice) {
    // SAFETY: as the caller promises. No exclusive borrow is alive while the importer's logger
    // runs, so that a logger may look at the instance.
    unsafe {
        if notice.status == Status::Error {
            (*instance).fail();
        }
        (*instance).send(notice.status, &format!("{function}: {}", notice.message));
    }
}

/// Frees an instance after its last duties; null is ignored.
///
/// # Safety
/// `pointer` is null or a `T` that an edge handed out; it is never used again.
pub(super) unsafe fn free<T>(pointer: *mut c_void, last: impl FnOnce(&mut T)) {
    if pointer.is_null() {
        return;
    }
    let freed = caught(|| {
        // SAFETY: it came from `Box::into_raw`, as the caller promises.
        let mut instance = unsafe { Box::from_raw(pointer.cast::<T>()) };
        last(&mut instance);
        Ok(())
    });
    // Nobody is left who could hear of it.
    drop(freed);
}

/// Runs the body of a function of the C edge; a panic becomes an error.
#[inline]
pub(super) fn caught<T>(body: impl FnOnce() -> Result<T, Notice>) -> Result<T, Notice> {
    let body = || {
        #[cfg(test)]
        super::forced_panic_tests::strike();
        body()
    };
    catch_unwind(AssertUnwindSafe(body))
        .unwrap_or_else(|payload| Err(Notice::error(panic_text(payload))))
}

/// Longest text of a panic that is kept.
const KEPT: usize = 400;

thread_local! {
    /// Where and why this thread last panicked. It has no destructor, because a thread-local with
    /// one would keep the library mapped after `dlclose`.
    static LAST_PANIC: Cell<Kept> = const { Cell::new(Kept { length: 0, bytes: [0; KEPT] }) };
}

#[derive(Clone, Copy)]
struct Kept {
    length: usize,
    bytes: [u8; KEPT],
}

impl std::fmt::Write for Kept {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        for byte in text.bytes().take(KEPT - self.length) {
            self.bytes[self.length] = byte;
            self.length += 1;
        }
        Ok(())
    }
}

/// Makes a panic in this library go to the importer's logger and nowhere else: nothing is printed,
/// and no backtrace is made even where `RUST_BACKTRACE` is set, because each loading of the library
/// would read its symbols anew and never give the memory back.
pub fn install_panic_hook() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        std::panic::set_hook(Box::new(|info| {
            let mut kept = Kept { length: 0, bytes: [0; KEPT] };
            let _ = write!(kept, "{info}");
            // There a panic ends the instance, and what is around it tells the importer.
            #[cfg(target_family = "wasm")]
            super::host::panicked(&kept.bytes[..kept.length]);
            LAST_PANIC.set(kept);
        }));
    });
}

/// The message of a panic: what the hook kept, else what the panic carries.
#[cold]
fn panic_text(payload: Box<dyn Any + Send>) -> String {
    let kept = LAST_PANIC.replace(Kept { length: 0, bytes: [0; KEPT] });
    let text = match kept.length {
        0 => match (payload.downcast_ref::<&str>(), payload.downcast_ref::<String>()) {
            (Some(text), _) => (*text).to_string(),
            (_, Some(text)) => text.clone(),
            _ => "no message".to_string(),
        },
        length => String::from_utf8_lossy(&kept.bytes[..length]).replace('\n', " "),
    };
    // A payload of an unknown type could panic again when it is dropped.
    std::mem::forget(payload);
    format!(
        "internal defect, please report it: {text}; other instances are not affected, and this \
         one can be reset or freed"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_that_says_why() {
        let notice = caught::<()>(|| std::panic::panic_any("the reason")).unwrap_err();
        assert_eq!(notice.status, Status::Error);
        assert!(notice.message.contains("the reason"), "{}", notice.message);
    }

    #[test]
    fn the_kept_text_is_cut_and_never_overflows() {
        let mut kept = Kept { length: 0, bytes: [0; KEPT] };
        for _ in 0..100 {
            let _ = write!(kept, "0123456789");
        }
        assert_eq!(kept.length, KEPT);
    }
}
