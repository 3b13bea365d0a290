//! The messages of an FMU, and what the host remarks on it.

use std::collections::VecDeque;
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::status::Status;

/// Category of the messages about what an FMU changed.
pub const HOST: &str = "host";
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
    /// For references in messages.
    name_of: Option<NameOf>,
    /// Steps, and other calls, that returned *Warning* since the last remark on them.
    warnings: [AtomicU64; 2],
    /// A step, a set or a get changed the floating-point mode. They may run in a cycle, which takes no
    /// lock: the message follows when messages are asked for.
    mode_changed: AtomicBool,
    /// It was remarked that the FMU passes a foreign environment pointer.
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
        self.push(Message { status: Status::Warning, category: HOST.to_owned(), text });
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
                self.remark(text);
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
            self.remark(text.to_owned());
        }
    }

    /// Says, once, that a message came with an environment pointer that no instance was given.
    pub(super) fn note_foreign(&self, address: usize) {
        if !self.foreign_noted.swap(true, Ordering::Relaxed) {
            let text = format!(
                "calls the logger with an environment pointer that it was not given ({address:#x}); \
                 its messages are assigned by thread and name"
            );
            self.remark(text);
        }
    }

    /// What resolves references in messages.
    pub(super) fn name_of(&self) -> Option<&NameOf> {
        self.name_of.as_ref()
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Message>> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
