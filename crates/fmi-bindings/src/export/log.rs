//! Messages to the importer.

use std::ffi::{CStr, CString, c_void};

use super::LOG_CATEGORIES;
use super::notice::Status;
use crate::fmi2::{fmi2CallbackFunctions, fmi2CallbackLogger, fmi2Status};
use crate::fmi3::{fmi3LogMessageCallback, fmi3Status};

/// The importer's logger, in the dialect of its version of the standard.
#[derive(Clone, Copy)]
#[cfg_attr(target_family = "wasm", allow(dead_code))]
pub(super) enum Sink {
    /// The importer gave none.
    None,
    /// FMI 2.0: variadic, the message is a format.
    V2 { callback: fmi2CallbackLogger, environment: *mut c_void },
    /// FMI 3.0: the message is a text.
    V3 { callback: fmi3LogMessageCallback, environment: *mut c_void },
    /// What is around the model inside WebAssembly, in the dialect of FMI 2.0 or 3.0.
    #[cfg(target_family = "wasm")]
    Host { is_v2: bool },
}

impl Sink {
    /// The logger of FMI 2.0.
    pub(super) fn v2(callbacks: Option<fmi2CallbackFunctions>) -> Self {
        // There the importer's functions stay outside.
        #[cfg(target_family = "wasm")]
        {
            let _ = callbacks;
            Self::Host { is_v2: true }
        }
        #[cfg(not(target_family = "wasm"))]
        match callbacks {
            Some(fmi2CallbackFunctions {
                logger: Some(callback), componentEnvironment, ..
            }) => Self::V2 { callback, environment: componentEnvironment },
            _ => Self::None,
        }
    }

    /// The logger of FMI 3.0.
    pub(super) fn v3(callback: Option<fmi3LogMessageCallback>, environment: *mut c_void) -> Self {
        #[cfg(target_family = "wasm")]
        {
            let _ = (callback, environment);
            Self::Host { is_v2: false }
        }
        #[cfg(not(target_family = "wasm"))]
        callback.map_or(Self::None, |callback| Self::V3 { callback, environment })
    }

    /// Sends a message under the name of an instance.
    pub(super) fn send(self, instance: &CStr, status: Status, category: &CStr, message: &str) {
        match self {
            Self::None => {}
            Self::V2 { callback, environment } => {
                let text = finished(message, true);
                let (name, category) = (instance.as_ptr(), category.as_ptr());
                let status = fmi2Status(status as u32);
                // SAFETY: the importer's function with the signature of the standard; all texts
                // end with a zero byte and live until it returns; the format has no directives.
                unsafe { callback(environment, name, status, category, text.as_ptr()) };
            }
            Self::V3 { callback, environment } => {
                let text = finished(message, false);
                let status = fmi3Status(status as u32);
                // SAFETY: as above.
                unsafe { callback(environment, status, category.as_ptr(), text.as_ptr()) };
            }
            #[cfg(target_family = "wasm")]
            Self::Host { is_v2 } => {
                super::host::tell(status, category, &finished(message, is_v2));
            }
        }
    }

    /// What goes out while logging is off. FMI 2.0 §2.1.3 expects the messages that explain a
    /// status even then, for they are no debug logging; FMI 3.0 §2.3.1 forbids all.
    fn where_off(&self) -> Mask {
        match self {
            Self::V3 { .. } => 0,
            #[cfg(target_family = "wasm")]
            Self::Host { is_v2: false } => 0,
            _ => EXPLANATIONS,
        }
    }
}

/// Which categories go out, one bit each, in the order of [`LOG_CATEGORIES`].
type Mask = u8;

const ALL: Mask = 0b1111;
/// All but `logEvents`.
const EXPLANATIONS: Mask = 0b1110;

/// Sends messages under the instance's name.
pub(super) struct Logger {
    sink: Sink,
    instance: CString,
    enabled: Mask,
}

impl Logger {
    /// A logger for the instance with this name.
    pub(super) fn new(sink: Sink, instance: CString, logging_on: bool) -> Self {
        Self { sink, instance, enabled: if logging_on { ALL } else { sink.where_off() } }
    }

    /// Switches debug logging; without categories all are meant. Returns the names that are no
    /// category of this FMU.
    pub(super) fn set_debug_logging(&mut self, on: bool, categories: &[&CStr]) -> Vec<String> {
        self.enabled = match (on, categories.is_empty()) {
            (false, _) => self.sink.where_off(),
            (true, true) => ALL,
            (true, false) => 0,
        };
        let mut unknown = Vec::new();
        for category in categories.iter().filter(|_| on) {
            match LOG_CATEGORIES.iter().position(|(name, _)| name.as_bytes() == category.to_bytes())
            {
                Some(index) if LOG_CATEGORIES[index].0 == "logAll" => self.enabled = ALL,
                Some(index) => self.enabled |= 1 << index,
                None => unknown.push(category.to_string_lossy().into_owned()),
            }
        }
        unknown
    }

    /// Whether messages of this status go out; asked before a message is put together.
    pub(super) fn wants(&self, status: Status) -> bool {
        !matches!(self.sink, Sink::None) && self.enabled & (1 << status as u8) != 0
    }

    /// Sends a message in the category of its status.
    pub(super) fn send(&self, status: Status, message: &str) {
        if self.wants(status) {
            self.sink.send(&self.instance, status, category(status), message);
        }
    }
}

/// The category of a status: its number is the index in [`LOG_CATEGORIES`].
fn category(status: Status) -> &'static CStr {
    match status {
        Status::Ok => c"logEvents",
        Status::Warning => c"logStatusWarning",
        Status::Discard => c"logStatusDiscard",
        Status::Error => c"logStatusError",
    }
}

/// The text as the logger must get it: `#` doubled, because `#12#` means the variable with value
/// reference 12; where it is a `printf` format, `%` doubled, so that it has no directives whatever
/// an importer does with it.
fn finished(message: &str, is_format: bool) -> CString {
    let mut text = Vec::with_capacity(message.len() + 16);
    for byte in message.bytes() {
        match byte {
            0 => continue,
            b'#' => text.push(b'#'),
            b'%' if is_format => text.push(b'%'),
            _ => {}
        }
        text.push(byte);
    }
    CString::new(text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_has_no_directives_and_no_references() {
        assert_eq!(finished("5 %s of #3\0", true).as_c_str(), c"5 %%s of ##3");
        assert_eq!(finished("5 %s of #3", false).as_c_str(), c"5 %s of ##3");
    }

    #[test]
    fn each_status_has_its_category() {
        for status in [Status::Ok, Status::Warning, Status::Discard, Status::Error] {
            let name = category(status).to_str().unwrap();
            assert_eq!(name, LOG_CATEGORIES[status as usize].0);
        }
    }

    #[test]
    fn categories_are_switched_one_by_one() {
        unsafe extern "C" fn ignore(
            _: *mut c_void,
            _: *const std::ffi::c_char,
            _: fmi2Status,
            _: *const std::ffi::c_char,
            _: *const std::ffi::c_char,
        ) {
        }
        type Plain = unsafe extern "C" fn(
            *mut c_void,
            *const std::ffi::c_char,
            fmi2Status,
            *const std::ffi::c_char,
            *const std::ffi::c_char,
        );
        // SAFETY: never called here.
        let callback = unsafe { std::mem::transmute::<Plain, fmi2CallbackLogger>(ignore) };
        let sink = Sink::V2 { callback, environment: std::ptr::null_mut() };
        let mut logger = Logger::new(sink, c"x".into(), false);
        assert!(!logger.wants(Status::Ok) && logger.wants(Status::Error));
        assert!(logger.set_debug_logging(true, &[c"logStatusWarning"]).is_empty());
        assert!(logger.wants(Status::Warning) && !logger.wants(Status::Error));
        assert_eq!(logger.set_debug_logging(true, &[c"nonsense"]), ["nonsense"]);
        logger.set_debug_logging(true, &[c"logAll"]);
        assert!(logger.wants(Status::Ok) && logger.wants(Status::Error));
        logger.set_debug_logging(false, &[]);
        assert!(!logger.wants(Status::Ok) && logger.wants(Status::Discard));
    }
}
