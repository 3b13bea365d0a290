//! The loggers that FMUs call: whose message it is, and what it reads.

use std::ffi::{c_char, c_void};

use super::log::{Message, NameOf};
use super::registry::{self, Speaker};
use super::status::Status;
use super::text::text_of;
use crate::fmi2::{fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status, fmi2String};
use crate::fmi3::{fmi3InstanceEnvironment, fmi3Status, fmi3String};

/// Receives the messages of an FMI 2.0 instance.
///
/// The standard's logger is variadic and its message a `printf` format. A variadic function cannot
/// be *defined* in stable Rust. On Linux this one takes a fixed number of arguments instead: in the
/// C calling conventions of x86-64 and AArch64 there, variadic integers and pointers travel as the
/// 6th and further words, variadic floating point values in the floating point registers, just as
/// those of a function that names them. Arguments that the caller did not give hold anything; what
/// is done with them cannot fail (see [`super::format`]).
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
#[rustfmt::skip]
unsafe extern "C" fn receive(
    environment: fmi2ComponentEnvironment,
    instance_name: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
    w0: usize, w1: usize, w2: usize, w3: usize, w4: usize, w5: usize, w6: usize, w7: usize,
    w8: usize,
    d0: f64, d1: f64, d2: f64, d3: f64, d4: f64, d5: f64, d6: f64, d7: f64,
) {
    use super::format::{Arguments, formatted, string_at};
    if message.is_null() {
        return;
    }
    let words = [w0, w1, w2, w3, w4, w5, w6, w7, w8];
    let doubles = [d0, d1, d2, d3, d4, d5, d6, d7];
    // An FMU that does not know its environment may not know its name either: it is read with care.
    let name = || Some(string_at(instance_name.addr())?.to_string_lossy().into_owned());
    // SAFETY: the standard promises zero-terminated texts, valid during this call.
    unsafe {
        let text = std::ffi::CStr::from_ptr(message);
        deliver(environment, name, status.into(), category, || {
            formatted(text, &Arguments { words, doubles })
        });
    }
}

/// Receives the messages of an FMI 2.0 instance.
///
/// Only the five named arguments are taken, which travel as those of any other function; a
/// format's `%s` is shown as it stands, its value is not.
#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
unsafe extern "C" fn receive(
    environment: fmi2ComponentEnvironment,
    _instance_name: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: the standard promises null or zero-terminated texts, valid during this call.
    unsafe {
        deliver(
            environment,
            || None,
            status.into(),
            category,
            || text_of(message).replace("%%", "%"),
        );
    }
}

/// Receives the messages of an FMI 3.0 instance, whose text is no format.
pub(crate) unsafe extern "C" fn receive_v3(
    environment: fmi3InstanceEnvironment,
    status: fmi3Status,
    category: fmi3String,
    message: fmi3String,
) {
    // SAFETY: as for FMI 2.0.
    unsafe { deliver(environment, || None, status.into(), category, || text_of(message)) };
}

/// Puts a message into its log.
///
/// # Safety
/// `category` is null or a zero-terminated text. The environment may be anything.
unsafe fn deliver(
    environment: *mut c_void,
    name: impl FnOnce() -> Option<String>,
    status: Status,
    category: *const c_char,
    text: impl FnOnce() -> String,
) {
    // A panic of the user's closure must not unwind into the FMU's C code.
    let _ = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        let log = match registry::speaker(environment, name) {
            Speaker::Own(log) => log,
            Speaker::Guessed(log) => {
                log.note_foreign(environment.addr());
                log
            }
            Speaker::Gone => return,
        };
        // SAFETY: promised by the caller.
        let category = unsafe { text_of(category) };
        let text = text();
        let text = log.name_of().map_or_else(|| text.clone(), |of| resolved(&text, of));
        let (category, text) = (shown(&category), shown(text.trim_end()));
        log.push(Message { status, category, text });
    }));
}

/// A message with its references to variables replaced by their names: `#r12#` is the real variable
/// with value reference 12, `##` a single `#` (FMI 2.0.5, section 2.1.5). What is no reference, or one
/// to nothing, stays.
fn resolved(text: &str, name_of: &NameOf) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('#') {
        out.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix('#') {
            out.push('#');
            rest = after;
            continue;
        }
        let found = rest.split_once('#').and_then(|(reference, after)| {
            let mut letters = reference.chars();
            let kind = letters.next().filter(|kind| "ribs".contains(*kind))?;
            Some((name_of(kind, letters.as_str().parse().ok()?)?, after))
        });
        match found {
            Some((name, after)) => {
                out.push_str(&name);
                rest = after;
            }
            None => out.push('#'),
        }
    }
    out.push_str(rest);
    out
}

/// A text that does nothing to a terminal: control characters are written out.
fn shown(text: &str) -> String {
    let is_plain = |c: char| !c.is_control() || matches!(c, '\n' | '\t');
    if text.chars().all(is_plain) {
        return text.to_owned();
    }
    let show = |c: char| if is_plain(c) { c.to_string() } else { c.escape_default().to_string() };
    text.replace("\r\n", "\n").chars().map(show).collect()
}

/// The logger to hand to FMI 2.0 instances.
pub(crate) fn logger() -> fmi2CallbackLogger {
    let receive = receive as *const ();
    // SAFETY: both are C function pointers; see `receive` for the calling convention.
    unsafe { std::mem::transmute::<*const (), fmi2CallbackLogger>(receive) }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn references_become_names() {
        let names: NameOf = Arc::new(|kind, reference| match (kind, reference) {
            ('r', 1) => Some("axis[1].u".to_owned()),
            ('i', 1) => Some("count".to_owned()),
            _ => None,
        });
        for (text, words) in [
            ("#r1# is high, #i1# too", "axis[1].u is high, count too"),
            ("##r1#, ## and #r1##r1#", "#r1#, # and axis[1].uaxis[1].u"),
            ("#r9# #x1# #r# #r1 #", "#r9# #x1# #r# #r1 #"),
            ("ends with #r1", "ends with #r1"),
            ("#", "#"),
        ] {
            assert_eq!(resolved(text, &names), words);
        }
    }

    #[test]
    fn a_terminal_is_not_controlled() {
        assert_eq!(shown("a\u{1b}[31m\tb\r\nc"), "a\\u{1b}[31m\tb\nc");
    }
}
