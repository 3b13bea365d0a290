//! What an FMU says: the logger callback and the messages it collected.

use std::collections::VecDeque;
use std::ffi::{c_char, c_void};
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::error::Status;
use super::registry::{self, Speaker};
use super::text::text_of;
use crate::fmi2::{fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status, fmi2String};
use crate::fmi3::{fmi3InstanceEnvironment, fmi3Status, fmi3String};

/// Messages kept per instance; older ones are dropped, so that a talkative FMU costs no memory.
const KEPT: usize = 256;
/// Messages that an error carries.
const IN_ERROR: usize = 8;

/// One message of an FMU.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Severity.
    pub status: Status,
    /// Log category; empty if the FMU gave none.
    pub category: String,
    /// The text; bytes that are not UTF-8 are replaced.
    pub text: String,
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.category.as_str() {
            "" => write!(f, "[{}] {}", self.status, self.text),
            category => write!(f, "[{}, {category}] {}", self.status, self.text),
        }
    }
}

/// The name of a variable by the letter of its type (`r`, `i`, `b`, `s`) and its value reference.
pub type NameOf = std::sync::Arc<dyn Fn(char, u32) -> Option<String> + Send + Sync>;

/// Called with each message at once, possibly from a thread of the FMU.
pub type OnMessage = std::sync::Arc<dyn Fn(&Message) + Send + Sync>;

/// The messages of one instance.
///
/// The environment pointer that the instance is given is looked up in a registry and never
/// followed: FMUs are known that call the logger with other pointers.
pub struct Log {
    messages: Mutex<VecDeque<Message>>,
    on_message: Option<OnMessage>,
    /// For references in messages, see [`resolved`].
    name_of: Option<NameOf>,
    /// Steps, and other calls, that returned *Warning* since it was last told of.
    warnings: [AtomicU64; 2],
    /// A step, a set or a get changed the floating-point mode. They may run in a cycle, which takes no
    /// lock: the message follows when messages are asked for.
    mode_changed: AtomicBool,
    /// It was said that the FMU passes a foreign environment pointer.
    foreign_noted: AtomicBool,
}

impl Log {
    /// An empty log; `on_message` sees each message as it comes, `name_of` resolves references in it.
    pub fn new(on_message: Option<OnMessage>, name_of: Option<NameOf>) -> Self {
        Log {
            messages: Mutex::default(),
            on_message,
            name_of,
            warnings: Default::default(),
            mode_changed: AtomicBool::new(false),
            foreign_noted: AtomicBool::new(false),
        }
    }

    /// All messages that are kept (the last 256), oldest first.
    pub fn messages(&self) -> Vec<Message> {
        self.tell_of_mode();
        self.lock().iter().cloned().collect()
    }

    /// The last messages, for an error.
    pub(crate) fn latest(&self) -> Vec<Message> {
        self.tell_of_mode();
        let messages = self.lock();
        messages.iter().skip(messages.len().saturating_sub(IN_ERROR)).cloned().collect()
    }

    pub(super) fn push(&self, message: Message) {
        if let Some(on_message) = &self.on_message {
            on_message(&message);
        }
        let mut messages = self.lock();
        if messages.len() == KEPT {
            messages.pop_front();
        }
        messages.push_back(message);
    }

    /// What the host has to say of this FMU; not to be called in a cycle.
    pub fn remark(&self, text: String) {
        let (status, category) = (Status::Warning, super::host::HOST.to_owned());
        self.push(Message { status, category, text });
    }

    /// Notes, without a lock, that a call returned *Warning*.
    pub(super) fn has_warned(&self, is_step: bool) {
        self.warnings[usize::from(!is_step)].fetch_add(1, Ordering::Relaxed);
    }

    /// Says how many calls returned *Warning*; not to be called in a cycle.
    pub(super) fn tell_of_warnings(&self) {
        for (count, which) in self.warnings.iter().zip(["step", "other"]) {
            let count = count.swap(0, Ordering::Relaxed);
            if count > 0 {
                let s = if count == 1 { "" } else { "s" };
                let text = format!("returned Warning from {count} {which} call{s}");
                let (status, category) = (Status::Warning, super::host::HOST.to_owned());
                self.push(Message { status, category, text });
            }
        }
    }

    /// Notes that a call left another floating-point mode, without a lock.
    pub(super) fn mode_has_changed(&self) {
        self.mode_changed.store(true, Ordering::Relaxed);
    }

    /// Passes on that the mode was changed, where it was; not to be called in a cycle.
    pub(super) fn tell_of_mode(&self) {
        if self.mode_changed.swap(false, Ordering::Relaxed) {
            let text = "a call left another floating-point mode (rounding, flush to zero or traps); \
                        it was put back (found after a step: its own, or gets and sets of any \
                        FMU since the step before)";
            let (status, category) = (Status::Warning, super::host::HOST.to_owned());
            self.push(Message { status, category, text: text.to_owned() });
        }
    }

    /// Says, once, that a message came with an environment pointer that no instance was given.
    fn note_foreign(&self, address: usize) {
        if !self.foreign_noted.swap(true, Ordering::Relaxed) {
            let text = format!(
                "calls the logger with an environment pointer that it was not given ({address:#x}); \
                 its messages are assigned by thread and name"
            );
            let (status, category) = (Status::Warning, super::host::HOST.to_owned());
            self.push(Message { status, category, text });
        }
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Message>> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

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
        let text = log.name_of.as_ref().map_or_else(|| text.clone(), |of| resolved(&text, of));
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
    fn a_terminal_is_not_told_what_to_do() {
        assert_eq!(shown("a\u{1b}[31m\tb\r\nc"), "a\\u{1b}[31m\tb\nc");
    }
}
