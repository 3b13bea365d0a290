//! Calls of the C functions: their messages, their status, and those that differ by a type only.

use std::cell::RefCell;
use std::ffi::CStr;

use super::bindings::fmi::fmi3::callbacks;
use super::co_simulation::Status;
use crate::fmi3::fmi3Status;

thread_local! {
    /// The instance that is called, for its messages.
    static CALLED: RefCell<String> = const { RefCell::new(String::new()) };
}

/// The instance of this name is called next.
pub(super) fn begin(name: &str) {
    CALLED.with_borrow_mut(|called| name.clone_into(called));
}

/// A message to the importer.
pub(in crate::export) fn say(status: u32, category: &CStr, message: &CStr) {
    tell(status_of(fmi3Status(status)), &category.to_string_lossy(), &message.to_string_lossy());
}

/// The text of a panic, behind which the component traps.
pub(in crate::export) fn panicked(text: &[u8]) {
    let text = String::from_utf8_lossy(text);
    tell(Status::Fatal, "logStatusError", &format!("internal defect, please report it: {text}"));
}

pub(super) fn tell(status: Status, category: &str, message: &str) {
    let name = CALLED.with_borrow(String::clone);
    callbacks::log_message(&name, status, category, message);
}

pub(super) fn status_of(status: fmi3Status) -> Status {
    match status.0 {
        0 => Status::Ok,
        1 => Status::Warning,
        2 => Status::Discard,
        3 => Status::Error,
        _ => Status::Fatal,
    }
}

/// Values where the call may be trusted, else its status.
pub(super) fn answer<T>(status: fmi3Status, values: T) -> Result<T, Status> {
    match status_of(status) {
        Status::Ok | Status::Warning => Ok(values),
        status => Err(status),
    }
}

/// Getter and setter of a type whose values are plain.
macro_rules! values {
    ($($get:ident $fmi_get:ident $set:ident $fmi_set:ident $type:ty;)*) => { $(
        fn $get(&self, references: Vec<u32>) -> Result<Vec<$type>, Status> {
            let mut values = vec![<$type>::default(); self.size(&references)];
            // SAFETY: arrays of the lengths given.
            let status = unsafe {
                v3::$fmi_get(self.handle(), references.as_ptr(), references.len(), values.as_mut_ptr(), values.len())
            };
            answer(status, values)
        }

        fn $set(&self, references: Vec<u32>, values: Vec<$type>) -> Status {
            // SAFETY: arrays of the lengths given.
            status_of(unsafe {
                v3::$fmi_set(self.handle(), references.as_ptr(), references.len(), values.as_ptr(), values.len())
            })
        }
    )* };
}

/// A call without further arguments.
macro_rules! plain {
    ($($name:ident $fmi:ident;)*) => { $(
        fn $name(&self) -> Status {
            // SAFETY: the handle of this instance.
            status_of(unsafe { v3::$fmi(self.handle()) })
        }
    )* };
}

pub(super) use {plain, values};
