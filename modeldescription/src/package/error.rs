//! Why an FMU cannot be opened or written.

use std::io;
use std::path::{Path, PathBuf};

use crate::read::ParseError;
use crate::write::WriteError;

/// Why an entry of an archive is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EntryDefect {
    /// The name climbs out of the FMU's folder.
    #[error("the name has a component \"..\" and may lead out of the FMU's folder")]
    Traversal,
    /// The name starts at the root of the file system.
    #[error("the name is an absolute path")]
    Absolute,
    /// The name starts with a drive.
    #[error("the name starts with a drive letter")]
    DriveLetter,
    /// The name holds a control character.
    #[error("the name holds the control character U+{character:04X}")]
    ControlCharacter {
        /// The character's number.
        character: u32,
    },
    /// The name is empty.
    #[error("the name is empty")]
    NoName,
    /// The name is too long.
    #[error("the name has {bytes} bytes; at most {limit} are allowed")]
    NameTooLong {
        /// Length of the name.
        bytes: usize,
        /// Longest name allowed.
        limit: usize,
    },
    /// A symbolic link.
    #[error("it is a symbolic link, which may lead out of the FMU's folder")]
    SymbolicLink,
    /// A device, pipe or socket.
    #[error("it is a device, pipe or socket")]
    SpecialFile,
    /// The entry is encrypted.
    #[error("it is encrypted")]
    Encrypted,
    /// Neither stored nor deflated.
    #[error("it is compressed by {method}; an FMU may use store and deflate only")]
    Compression {
        /// The compression method.
        method: String,
    },
    /// Two entries have the same name.
    #[error("the name stands in the archive twice")]
    Duplicate,
    /// A name that is a file here and a folder there.
    #[error("the name, or a part of it, is a file in one entry and a folder in another")]
    FileAndFolder,
    /// Entries share bytes of the archive.
    #[error("entries overlap each other inside the archive")]
    Overlap,
    /// Too many entries.
    #[error("the archive has {entries} entries; at most {limit} are unpacked")]
    TooMany {
        /// Number of entries.
        entries: usize,
        /// Most entries allowed.
        limit: usize,
    },
    /// The archive unpacks to far more bytes than it has.
    #[error(
        "the archive of {packed} bytes would unpack to {bytes} bytes (limit {limit}); it looks like a zip bomb"
    )]
    Bomb {
        /// Bytes of all entries, unpacked.
        bytes: u64,
        /// Bytes of the archive.
        packed: u64,
        /// Most bytes allowed.
        limit: u64,
    },
    /// An XML file that unpacks to far more than XML does, of which every reader makes many times its bytes.
    #[error(
        "its {packed} packed bytes are {bytes} bytes of XML, more than {ratio} times as many; if that is meant, \
         unpack the archive: a folder is read without this limit"
    )]
    Dense {
        /// Bytes, unpacked.
        bytes: u64,
        /// Bytes in the archive.
        packed: u64,
        /// Largest ratio.
        ratio: u64,
    },
    /// The content cannot be unpacked.
    #[error("its content is damaged: {message}")]
    Broken {
        /// What the decompressor says.
        message: String,
    },
}

/// Why an FMU cannot be opened or written.
#[derive(Debug, thiserror::Error)]
pub enum PackageError {
    /// A file cannot be read.
    #[error("cannot read \"{}\": {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write \"{}\": {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is no zip archive, or its end is missing.
    #[error("\"{}\" is not a readable zip archive ({message}); an FMU is a zip archive: is this the right file, or was the download or copy cut off?", archive.display())]
    NotAnArchive {
        /// The archive.
        archive: PathBuf,
        /// What the zip reader says.
        message: String,
    },
    /// The name of the library is none.
    #[error(
        "\"{}\": modelIdentifier=\"{}\" is no file name, and might lead out of the FMU; ask its maker for \
         one whose identifier is a C identifier",
        package.display(), identifier.escape_debug()
    )]
    Identifier {
        /// The FMU.
        package: PathBuf,
        /// The name.
        identifier: String,
    },
    /// An entry is refused.
    #[error("\"{}\"{}: {defect}; the archive was not unpacked", archive.display(), named(entry))]
    Entry {
        /// The archive.
        archive: PathBuf,
        /// The entry's name; empty if the archive itself is meant.
        entry: String,
        /// Why.
        defect: EntryDefect,
    },
    /// There is no model description.
    #[error("\"{}\" has no modelDescription.xml at its root{}", package.display(), hint(elsewhere))]
    NoDescription {
        /// The archive or folder.
        package: PathBuf,
        /// Where there is one instead.
        elsewhere: Option<String>,
    },
    /// The model description cannot be used.
    #[error("\"{}\": {source}", package.display())]
    Description {
        /// The archive or folder.
        package: PathBuf,
        /// Why.
        source: ParseError,
    },
    /// There is no shared library for this platform.
    #[error("\"{}\" has no binary for this platform: {wanted} does not exist; {}{}", package.display(), present(platforms), compilable(*has_sources))]
    NoBinary {
        /// The archive or folder.
        package: PathBuf,
        /// The file that would be loaded.
        wanted: String,
        /// The platforms the FMU has binaries for.
        platforms: Vec<String>,
        /// Whether it has C sources.
        has_sources: bool,
    },
    /// The model description names no interface type, so no binary.
    #[error("\"{}\": modelDescription.xml has neither CoSimulation nor ModelExchange, so no binary is named", package.display())]
    NoInterface {
        /// The archive or folder.
        package: PathBuf,
    },
    /// The model description cannot be written.
    #[error("the model description cannot be written: {0}")]
    Xml(#[from] WriteError),
    /// A name that may not be packed.
    #[error("\"{entry}\" cannot be packed: {reason}")]
    Name {
        /// The entry's name.
        entry: String,
        /// Why.
        reason: String,
    },
    /// The zip writer failed.
    #[error("\"{entry}\" cannot be packed: {message}")]
    Pack {
        /// The entry's name.
        entry: String,
        /// What the zip writer says.
        message: String,
    },
}

impl PackageError {
    pub(crate) fn entry(archive: &Path, entry: &str, defect: EntryDefect) -> Self {
        PackageError::Entry { archive: archive.to_owned(), entry: entry.to_owned(), defect }
    }
}

/// `, entry "name"`, with long names cut.
fn named(entry: &str) -> String {
    if entry.is_empty() {
        return String::new();
    }
    let mut shown: String = entry.chars().take(120).flat_map(char::escape_debug).collect();
    if entry.chars().nth(120).is_some() {
        shown.push('…');
    }
    format!(", entry \"{shown}\"")
}

fn hint(elsewhere: &Option<String>) -> String {
    match elsewhere {
        Some(path) => format!("; there is one at \"{path}\": zip the content, not the folder"),
        None => "; is it an FMU?".to_owned(),
    }
}

fn present(platforms: &[String]) -> String {
    match platforms {
        [] => "the FMU has no binaries at all (is it a source-code FMU?)".to_owned(),
        names => format!("the FMU has binaries for {}", names.join(", ")),
    }
}

/// The way out where there is no library, but C.
fn compilable(has_sources: bool) -> &'static str {
    if has_sources {
        "; it has C sources: compile them first, as with \"fmpy compile\""
    } else {
        ""
    }
}
