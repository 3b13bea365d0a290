//! What can go wrong at the C edge.

use std::fmt;
use std::path::PathBuf;

use super::log::Message;
use super::status::Status;

/// A call the FMU did not carry out.
#[derive(Clone, Debug, PartialEq)]
pub struct CallError {
    /// Name of the instance.
    pub fmu: String,
    /// Name of the function, as the standard spells it.
    pub call: &'static str,
    /// What the function returned.
    pub status: Status,
    /// The last messages of the FMU, oldest first.
    pub messages: Vec<Message>,
}

impl fmt::Display for CallError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FMU `{}`: {} returned {}", self.fmu, self.call, self.status)?;
        write_messages(f, &self.messages)
    }
}

impl std::error::Error for CallError {}

fn write_messages(f: &mut fmt::Formatter<'_>, messages: &[Message]) -> fmt::Result {
    if messages.is_empty() {
        return f.write_str("; the FMU logged no message (switch its logging on to learn more)");
    }
    f.write_str("; the FMU says:")?;
    messages.iter().try_for_each(|message| write!(f, "\n  {message}"))
}

/// The messages of a failed instantiation, as text.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedText(pub Vec<Message>);

impl fmt::Display for LoggedText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_messages(f, &self.0)
    }
}

/// An error of the import side.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system does not load the library.
    #[error(
        "{path}: the FMU's library does not load: {reason}. It must be built for this machine \
         ({os}, {arch}) and find all libraries it depends on",
        path = path.display(), os = std::env::consts::OS, arch = std::env::consts::ARCH
    )]
    Load {
        /// The library's file.
        path: PathBuf,
        /// What the loader of the operating system says.
        reason: String,
    },
    /// Functions that nobody can do without are missing.
    #[error("{path}: the FMU's library lacks {}, which co-simulation needs; \
             is it an FMI {version} co-simulation FMU?", names.join(", "), path = path.display())]
    MissingFunctions {
        /// The library's file.
        path: PathBuf,
        /// Version of the standard that was asked for.
        version: &'static str,
        /// All missing functions of those that are needed.
        names: Vec<&'static str>,
    },
    /// The library speaks another version or other C types.
    #[error("{path}: {function} answers \"{found}\", expected \"{expected}\"", path = path.display())]
    WrongVersion {
        /// The library's file.
        path: PathBuf,
        /// Function that was asked.
        function: &'static str,
        /// The function's answer.
        found: String,
        /// The answer that this importer understands.
        expected: &'static str,
    },
    /// A function of the standard that this FMU's library does not have.
    #[error(
        "FMU `{fmu}`: its library has no {function}, though the standard requires it; \
             what was asked for needs it"
    )]
    MissingFunction {
        /// Name of the instance.
        fmu: String,
        /// The missing function.
        function: &'static str,
    },
    /// The FMU refused to make an instance.
    #[error(
        "FMU `{fmu}`: {function} returned no instance (GUID \"{guid}\", resources \
             {resources}){logged}"
    )]
    Instantiate {
        /// Name of the instance.
        fmu: String,
        /// The function that was called.
        function: &'static str,
        /// The GUID given: it must be the one built into the library.
        guid: String,
        /// The resource location given.
        resources: String,
        /// The messages of the FMU.
        logged: LoggedText,
    },
    /// A call failed.
    #[error(transparent)]
    Call(#[from] Box<CallError>),
    /// After a fatal status no function of the FMU may be called.
    #[error(
        "FMU `{fmu}`: {call} not called, because an earlier call returned Fatal and the \
             standard forbids every further call; start the program anew to use this FMU again"
    )]
    Dead {
        /// Name of the instance.
        fmu: String,
        /// The call that was not made.
        call: &'static str,
    },
    /// Two slices that belong together differ in length.
    #[error("FMU `{fmu}`: {call} was given {references} value references and {values} values")]
    Length {
        /// Name of the instance.
        fmu: String,
        /// The call that was not made.
        call: &'static str,
        /// Number of value references.
        references: usize,
        /// Number of values.
        values: usize,
    },
    /// A text with a zero byte cannot be given to C.
    #[error("FMU `{fmu}`: {what} \"{text}\" holds a zero byte, which C cannot carry")]
    ZeroByte {
        /// Name of the instance.
        fmu: String,
        /// What the text is.
        what: &'static str,
        /// The text, with the zero byte escaped.
        text: String,
    },
    /// A saved state that this instance does not hold.
    #[error("FMU `{fmu}`: this saved state was freed before, or belongs to another instance")]
    UnknownState {
        /// Name of the instance.
        fmu: String,
    },
}

impl Error {
    /// The status, if a call of the FMU was the cause.
    pub fn status(&self) -> Option<Status> {
        match self {
            Error::Call(error) => Some(error.status),
            _ => None,
        }
    }
}
