//! The zip archive of an FMU, read as if its maker wished us harm.
//!
//! Nothing here writes: an archive is opened, its entries are listed, and every entry that must not
//! be unpacked is reported with the reason.

use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use zip::{CompressionMethod, ZipArchive};

use super::error::{EntryDefect, PackageError};

/// Longest name of a file or folder that file systems hold, in bytes.
const PART_BYTES: usize = 255;

/// Bounds of an archive.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Most entries.
    pub entries: usize,
    /// Most bytes of all entries together, unpacked.
    pub total_bytes: u64,
    /// Largest ratio of unpacked to packed bytes once [`Limits::free_bytes`] are passed.
    pub expansion: u64,
    /// Up to so many unpacked bytes the ratio does not matter.
    pub free_bytes: u64,
    /// Largest ratio of unpacked to packed bytes of an XML file once [`Limits::free_xml_bytes`] are passed.
    pub xml_expansion: u64,
    /// Up to so many bytes of an XML file the ratio does not matter.
    pub free_xml_bytes: u64,
    /// Longest name of an entry in bytes.
    pub name_bytes: usize,
    /// Bounds of `modelDescription.xml`.
    pub xml: crate::xml::XmlLimits,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            entries: 100_000,
            total_bytes: 8 << 30,
            expansion: 200,
            free_bytes: 256 << 20,
            xml_expansion: 100,
            free_xml_bytes: 1 << 20,
            name_bytes: 1024,
            xml: crate::xml::XmlLimits::default(),
        }
    }
}

/// An entry of the archive.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) index: usize,
    /// The name as it stands in the archive.
    pub(crate) name: String,
    /// The name's components below the FMU's folder; empty if the name is not safe.
    pub(crate) components: Vec<String>,
    pub(crate) is_folder: bool,
    pub(crate) size: u64,
    /// Why the entry must not be unpacked.
    pub(crate) defect: Option<EntryDefect>,
    /// What the standard forbids although it can be unpacked.
    pub(crate) version_needed: u16,
    pub(crate) has_backslash: bool,
    pub(crate) streamed_but_stored: bool,
}

impl Entry {
    /// The name with forward slashes and without `.` components.
    pub(crate) fn path(&self) -> String {
        self.components.join("/")
    }
}

/// An open archive and its entries.
pub(crate) struct Archive {
    path: PathBuf,
    zip: ZipArchive<BufReader<File>>,
    pub(crate) entries: Vec<Entry>,
    /// The defect of the archive as a whole, and the entry at which it shows.
    pub(crate) defects: Vec<(String, EntryDefect)>,
}

impl Archive {
    /// Opens an archive and looks at all its entries.
    pub(crate) fn open(path: &Path, limits: &Limits) -> Result<Self, PackageError> {
        let cannot_read = |source| PackageError::Read { path: path.to_owned(), source };
        files::note_read(path);
        let file = File::open(path).map_err(cannot_read)?;
        let packed = file.metadata().map_err(cannot_read)?.len();
        let not_a_zip = |error: zip::result::ZipError| PackageError::NotAnArchive {
            archive: path.to_owned(),
            message: error.to_string(),
        };
        let mut zip = ZipArchive::new(BufReader::new(file)).map_err(not_a_zip)?;
        let mut defects = Vec::new();
        if zip.len() > limits.entries {
            let defect = EntryDefect::TooMany { entries: zip.len(), limit: limits.entries };
            return Err(PackageError::entry(path, "", defect));
        }
        let start = zip.central_directory_start();
        let headers = central_directory(path, start, limits).map_err(cannot_read)?;
        if zip.has_duplicate_names() {
            let again = first_duplicate(&headers).map(|name| (name, EntryDefect::Duplicate));
            defects.extend(again);
        }
        if zip.has_overlapping_entries().map_err(not_a_zip)? {
            defects.push((String::new(), EntryDefect::Overlap));
        }
        let versions: HashMap<&[u8], u16> =
            headers.iter().map(|header| (header.name.as_slice(), header.version_needed)).collect();
        let mut entries = Vec::with_capacity(zip.len());
        for index in 0..zip.len() {
            entries.push(entry(&zip, index, &versions, limits).map_err(not_a_zip)?);
        }
        defects.extend(bomb(&entries, packed, limits));
        defects.extend(same_path_twice(&entries));
        Ok(Archive { path: path.to_owned(), zip, entries, defects })
    }

    /// All reasons not to unpack the archive, with the entry at which each shows.
    pub(crate) fn all_defects(&self) -> impl Iterator<Item = (&str, &EntryDefect)> {
        let of_entries =
            self.entries.iter().filter_map(|e| Some((e.name.as_str(), e.defect.as_ref()?)));
        let of_archive = self.defects.iter().map(|(name, defect)| (name.as_str(), defect));
        of_archive.chain(of_entries)
    }

    /// Passes the content of an entry to `sink`, the file `target`, at most as many bytes as the entry
    /// declares.
    pub(crate) fn copy(
        &mut self,
        entry: &Entry,
        sink: &mut impl Write,
        target: &Path,
    ) -> Result<(), PackageError> {
        let broken = |message: String| {
            PackageError::entry(&self.path, &entry.name, EntryDefect::Broken { message })
        };
        let content = self.zip.by_index(entry.index).map_err(|error| broken(error.to_string()))?;
        let mut sink = Sink { inner: sink, failed: None };
        let copied = io::copy(&mut content.take(entry.size + 1), &mut sink);
        // A full disk is not the archive's fault.
        if let Some(source) = sink.failed {
            return Err(PackageError::Write { path: target.to_owned(), source });
        }
        let copied = copied.map_err(|error| broken(error.to_string()))?;
        match copied == entry.size {
            true => Ok(()),
            false => Err(broken(format!("it declares {} bytes and holds others", entry.size))),
        }
    }

    /// The content of the file at this path, if there is one.
    pub(crate) fn read(&mut self, path: &str) -> Option<Result<Vec<u8>, PackageError>> {
        let found = self.entries.iter().find(|e| !e.is_folder && e.path() == path)?.clone();
        let mut bytes = Vec::new();
        Some(self.copy(&found, &mut bytes, Path::new(path)).map(|()| bytes))
    }
}

fn entry(
    zip: &ZipArchive<BufReader<File>>,
    index: usize,
    versions: &HashMap<&[u8], u16>,
    limits: &Limits,
) -> zip::result::ZipResult<Entry> {
    let data = zip.by_index_data(index)?;
    let name = data.name()?.into_owned();
    let is_folder = name.ends_with(['/', '\\']);
    let (components, name_defect) = match safe_components(&name, limits.name_bytes) {
        Ok(components) => (components, None),
        Err(defect) => (Vec::new(), Some(defect)),
    };
    let compression = data.compression();
    Ok(Entry {
        index,
        components,
        is_folder,
        size: data.size(),
        defect: name_defect
            .or_else(|| special_file(data.unix_mode()))
            .or_else(|| data.encrypted().then_some(EntryDefect::Encrypted))
            .or_else(|| unsupported(compression))
            .or_else(|| dense(&name, data.size(), data.compressed_size(), limits)),
        version_needed: versions.get(data.name_raw()).copied().unwrap_or_default(),
        has_backslash: name.contains('\\'),
        streamed_but_stored: compression == CompressionMethod::Stored
            && data.flags().is_using_data_descriptor(),
        name,
    })
}

/// The components of a name below the FMU's folder. Backslashes, though not allowed, are understood
/// as separators, as Windows would.
fn safe_components(name: &str, limit: usize) -> Result<Vec<String>, EntryDefect> {
    if name.len() > limit {
        return Err(EntryDefect::NameTooLong { bytes: name.len(), limit });
    }
    if let Some(character) = name.chars().find(|c| c.is_control()) {
        return Err(EntryDefect::ControlCharacter { character: character.into() });
    }
    if name.starts_with(['/', '\\']) {
        return Err(EntryDefect::Absolute);
    }
    let mut letters = name.chars();
    if letters.next().is_some_and(|c| c.is_ascii_alphabetic()) && letters.next() == Some(':') {
        return Err(EntryDefect::DriveLetter);
    }
    let parts = name.split(['/', '\\']).filter(|part| !part.is_empty() && *part != ".");
    let components: Vec<String> = parts.map(str::to_owned).collect();
    if let Some(part) = components.iter().find(|part| part.len() > PART_BYTES) {
        return Err(EntryDefect::NameTooLong { bytes: part.len(), limit: PART_BYTES });
    }
    match () {
        () if components.iter().any(|part| part == "..") => Err(EntryDefect::Traversal),
        () if components.is_empty() && !name.ends_with(['/', '\\']) => Err(EntryDefect::NoName),
        () => Ok(components),
    }
}

/// XML that becomes too much of too little.
fn dense(name: &str, bytes: u64, packed: u64, limits: &Limits) -> Option<EntryDefect> {
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
    let is_xml = ["xml", "ssd", "ssv", "ssm", "ssb"].iter().any(|x| ending.eq_ignore_ascii_case(x));
    let ratio = limits.xml_expansion;
    let is_dense = is_xml && bytes > limits.free_xml_bytes && bytes / packed.max(1) > ratio;
    is_dense.then_some(EntryDefect::Dense { bytes, packed, ratio })
}

/// Tells what cannot be written from what cannot be read.
struct Sink<'a, W> {
    inner: &'a mut W,
    failed: Option<io::Error>,
}

impl<W: Write> Write for Sink<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.inner.write(bytes).map_err(|error| {
            let kind = error.kind();
            // What is only tried again is no failure.
            self.failed = (kind != io::ErrorKind::Interrupted).then_some(error);
            kind.into()
        })
    }
    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Links, devices, pipes and sockets; the file type is in the upper bits of the Unix mode.
fn special_file(mode: Option<u32>) -> Option<EntryDefect> {
    match mode.unwrap_or(0) & 0o170_000 {
        0 | 0o100_000 | 0o040_000 => None,
        0o120_000 => Some(EntryDefect::SymbolicLink),
        _ => Some(EntryDefect::SpecialFile),
    }
}

fn unsupported(method: CompressionMethod) -> Option<EntryDefect> {
    let name = match method {
        CompressionMethod::Stored | CompressionMethod::Deflated => return None,
        CompressionMethod::DEFLATE64 => "Deflate64".to_owned(),
        CompressionMethod::BZIP2 => "bzip2".to_owned(),
        CompressionMethod::LZMA => "LZMA".to_owned(),
        CompressionMethod::ZSTD => "Zstandard".to_owned(),
        CompressionMethod::XZ => "xz".to_owned(),
        other => other.to_string(),
    };
    Some(EntryDefect::Compression { method: name })
}

fn bomb(entries: &[Entry], packed: u64, limits: &Limits) -> Option<(String, EntryDefect)> {
    let total = entries.iter().fold(0_u64, |sum, entry| sum.saturating_add(entry.size));
    let too_dense = total > limits.free_bytes && total / packed.max(1) > limits.expansion;
    if total <= limits.total_bytes && !too_dense {
        return None;
    }
    let largest = entries.iter().max_by_key(|entry| entry.size)?;
    let limit = if too_dense { limits.free_bytes } else { limits.total_bytes };
    Some((largest.name.clone(), EntryDefect::Bomb { bytes: total, packed, limit }))
}

/// Different names for the same path (`a/b` and `a//b`), or a file where another entry has a folder.
fn same_path_twice(entries: &[Entry]) -> Vec<(String, EntryDefect)> {
    let mut files = HashSet::new();
    let mut defects = Vec::new();
    let safe = || entries.iter().filter(|entry| !entry.components.is_empty());
    for entry in safe().filter(|entry| !entry.is_folder) {
        if !files.insert(entry.components.as_slice()) {
            defects.push((entry.name.clone(), EntryDefect::Duplicate));
        }
    }
    for entry in safe() {
        let lengths = 1..entry.components.len() + usize::from(entry.is_folder);
        let clash = lengths
            .filter_map(|length| entry.components.get(..length))
            .any(|path| files.contains(path));
        if clash {
            defects.push((entry.name.clone(), EntryDefect::FileAndFolder));
        }
    }
    defects
}

/// What a header of the central directory says that the zip reader does not tell.
struct Header {
    name: Vec<u8>,
    version_needed: u16,
    /// CRC-32 and sizes, packed and unpacked, as they stand there.
    content: [u8; 12],
}

/// The headers of the central directory, which starts at this offset (APPNOTE 4.3.12).
fn central_directory(path: &Path, start: u64, limits: &Limits) -> io::Result<Vec<Header>> {
    const LENGTH: usize = 46;
    let mut file = BufReader::new(File::open(path)?);
    file.seek(SeekFrom::Start(start))?;
    let mut headers = Vec::new();
    let mut fixed = [0_u8; LENGTH];
    while headers.len() <= limits.entries && file.read_exact(&mut fixed).is_ok() {
        if !fixed.starts_with(b"PK\x01\x02") {
            break;
        }
        let number = |at: usize| {
            let low = fixed.get(at).copied().unwrap_or_default();
            let high = fixed.get(at + 1).copied().unwrap_or_default();
            u16::from_le_bytes([low, high])
        };
        // The upper byte is the system the archive was made on.
        let version_needed = number(6) & 0xff;
        let mut name = vec![0_u8; number(28).into()];
        file.read_exact(&mut name)?;
        file.seek_relative(i64::from(number(30)) + i64::from(number(32)))?;
        let mut content = [0; 12];
        if let Some(there) = fixed.get(16..28) {
            content.copy_from_slice(there);
        }
        headers.push(Header { name, version_needed, content });
    }
    Ok(headers)
}

/// The first name that stands twice in the central directory for different files. The same file may
/// (CRC-32 and size), as CMake adds files and folders again that it is given twice.
fn first_duplicate(headers: &[Header]) -> Option<String> {
    let mut seen = HashMap::new();
    let again = headers.iter().find(|header| {
        *seen.entry(header.name.as_slice()).or_insert(header.content) != header.content
    })?;
    Some(String::from_utf8_lossy(&again.name).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn safe_names_stay_below_the_folder() {
        for (name, path) in [
            ("modelDescription.xml", "modelDescription.xml"),
            ("./resources//a b/ü.txt", "resources/a b/ü.txt"),
            ("resources\\table.csv", "resources/table.csv"),
            ("resources/..hidden", "resources/..hidden"),
            ("resources/", "resources"),
        ] {
            assert_eq!(safe_components(name, 1024).map(|c| c.join("/")), Ok(path.to_owned()));
        }
    }

    #[test]
    fn unsafe_names_are_refused() {
        let long = "x".repeat(1025);
        for (name, defect) in [
            ("../evil", EntryDefect::Traversal),
            ("a/../../evil", EntryDefect::Traversal),
            ("a\\..\\..\\evil", EntryDefect::Traversal),
            ("a/..", EntryDefect::Traversal),
            ("/etc/passwd", EntryDefect::Absolute),
            ("\\\\server\\share", EntryDefect::Absolute),
            ("C:\\evil", EntryDefect::DriveLetter),
            ("c:evil", EntryDefect::DriveLetter),
            ("a\0b", EntryDefect::ControlCharacter { character: 0 }),
            ("", EntryDefect::NoName),
            (".", EntryDefect::NoName),
            (&long, EntryDefect::NameTooLong { bytes: 1025, limit: 1024 }),
        ] {
            assert_eq!(safe_components(name, 1024), Err(defect), "{name:?}");
        }
    }

    #[test]
    fn only_files_and_folders_are_unpacked() {
        assert_eq!(special_file(None), None);
        assert_eq!(special_file(Some(0o100_644)), None);
        assert_eq!(special_file(Some(0o040_755)), None);
        assert_eq!(special_file(Some(0o120_777)), Some(EntryDefect::SymbolicLink));
        for device in [0o010_644, 0o020_644, 0o060_644, 0o140_644] {
            assert_eq!(special_file(Some(device)), Some(EntryDefect::SpecialFile));
        }
    }
}
