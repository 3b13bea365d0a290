//! The URI under which an FMU finds its resources.

use std::path::Path;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_encode};

/// Everything but RFC 3986's unreserved characters and the slash.
const ESCAPED: &AsciiSet =
    &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');

/// `file:///…` for an absolute path, without a slash at the end; bytes outside RFC 3986's
/// unreserved characters are percent-encoded.
///
/// ```
/// # use piezoloop_fmi_bindings::import::resource::uri;
/// # if cfg!(unix) {
/// assert_eq!(uri("/my é/resources".as_ref()), "file:///my%20%C3%A9/resources");
/// # }
/// ```
pub fn uri(path: &Path) -> String {
    let encoded = percent_encode(&bytes(path), ESCAPED).to_string();
    let encoded = encoded.trim_end_matches('/');
    let slash = if encoded.starts_with('/') { "" } else { "/" };
    format!("file://{slash}{encoded}")
}

#[cfg(unix)]
fn bytes(path: &Path) -> Vec<u8> {
    use std::os::unix::ffi::OsStrExt;
    path.as_os_str().as_bytes().to_vec()
}

#[cfg(not(unix))]
fn bytes(path: &Path) -> Vec<u8> {
    path.to_string_lossy().replace('\\', "/").into_bytes()
}
