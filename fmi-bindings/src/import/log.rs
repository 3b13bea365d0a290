//! What an FMU says: the logger callback and the messages it collected.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::error::Status;
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

/// Called with each message at once, possibly from a thread of the FMU.
pub type OnMessage = std::sync::Arc<dyn Fn(&Message) + Send + Sync>;

/// The messages of one instance.
///
/// Its address is the instance's environment pointer, so it stays where it is.
pub struct Log {
    messages: Mutex<VecDeque<Message>>,
    on_message: Option<OnMessage>,
}

impl Log {
    /// An empty log; `on_message` sees each message as it comes.
    pub fn new(on_message: Option<OnMessage>) -> Self {
        Log { messages: Mutex::default(), on_message }
    }

    /// All messages that are kept (the last 256), oldest first.
    pub fn messages(&self) -> Vec<Message> {
        self.lock().iter().cloned().collect()
    }

    /// The last messages, for an error.
    pub(crate) fn latest(&self) -> Vec<Message> {
        let messages = self.lock();
        messages.iter().skip(messages.len().saturating_sub(IN_ERROR)).cloned().collect()
    }

    fn push(&self, message: Message) {
        if let Some(on_message) = &self.on_message {
            on_message(&message);
        }
        let mut messages = self.lock();
        if messages.len() == KEPT {
            messages.pop_front();
        }
        messages.push_back(message);
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Message>> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Receives the messages of an FMI 2.0 instance.
///
/// The standard's logger is variadic and its message a `printf` format. A variadic function cannot
/// be *defined* in Rust, so this one takes the five named arguments only: in the C calling
/// conventions of Linux, macOS and Windows on x86-64, and of Linux on AArch64, named arguments of
/// a variadic function travel as those of any other, and the caller removes the rest. The price:
/// a format's `%s` is shown as it stands, its value is not.
unsafe extern "C" fn receive(
    environment: fmi2ComponentEnvironment,
    _instance_name: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: the environment is null or the `Log` given at instantiation, which outlives the
    // instance; only shared access is made of it.
    let Some(log) = (unsafe { environment.cast::<Log>().as_ref() }) else { return };
    // SAFETY: the standard promises null or zero-terminated texts, valid during this call.
    let (category, text) = unsafe { (text_of(category), text_of(message)) };
    let message = Message { status: status.into(), category, text: text.replace("%%", "%") };
    // A panic of the user's closure must not unwind into the FMU's C code.
    let _ = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| log.push(message)));
}

/// Receives the messages of an FMI 3.0 instance.
pub(crate) unsafe extern "C" fn receive_v3(
    environment: fmi3InstanceEnvironment,
    status: fmi3Status,
    category: fmi3String,
    message: fmi3String,
) {
    // SAFETY: as in `receive`.
    let Some(log) = (unsafe { environment.cast::<Log>().as_ref() }) else { return };
    // SAFETY: the standard promises null or zero-terminated texts, valid during this call.
    let (category, text) = unsafe { (text_of(category), text_of(message)) };
    let message = Message { status: status.into(), category, text };
    // A panic of the user's closure must not unwind into the FMU's C code.
    let _ = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| log.push(message)));
}

/// The logger to hand to FMI 2.0 instances.
pub(crate) fn logger() -> fmi2CallbackLogger {
    type Named = unsafe extern "C" fn(
        fmi2ComponentEnvironment,
        fmi2String,
        fmi2Status,
        fmi2String,
        fmi2String,
    );
    let named: Named = receive;
    // SAFETY: both are C function pointers; see `receive` for the calling convention.
    unsafe { std::mem::transmute::<Named, fmi2CallbackLogger>(named) }
}
