//! Texts on their way to and from C.

use std::ffi::{CStr, CString, c_char};

use super::error::Error;

/// A text for C.
pub(crate) fn c_text(fmu: &str, what: &'static str, text: &str) -> Result<CString, Error> {
    CString::new(text).map_err(|_| Error::ZeroByte {
        fmu: fmu.to_owned(),
        what,
        text: text.escape_debug().to_string(),
    })
}

/// Text of a C string; null is empty.
///
/// # Safety
/// `text` is null or points to a zero-terminated string.
pub(crate) unsafe fn text_of(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: promised by the caller.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}
