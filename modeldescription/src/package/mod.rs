//! FMU packages: pack a `.fmu`, open one safely.

mod archive;
mod build;
mod error;
mod platform;

use std::fs::{self, File, OpenOptions};
use std::path::{Path, PathBuf};

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_encode};
use tempfile::TempDir;

pub(crate) use archive::Archive;
pub use archive::Limits;
pub use build::PackageBuilder;
pub(crate) use build::write_archive;
pub use error::{EntryDefect, PackageError};
pub use platform::{PLATFORMS, Platform, WASM, WASM_MANIFEST};

use crate::description::ModelDescription;
use crate::problem::MODEL_DESCRIPTION;
use crate::read::{self, ParseError};

/// An FMU that lies unpacked in a folder.
///
/// [`Package::open`] unpacks an archive into a new temporary folder, which is removed when the
/// package is dropped.
#[derive(Debug)]
pub struct Package {
    /// The archive or folder the user named.
    path: PathBuf,
    folder: PathBuf,
    description: ModelDescription,
    /// Keeps the temporary folder as long as the package lives.
    _unpacked: Option<TempDir>,
}

/// Whether a name is that of a file in a folder, and leads nowhere else.
fn is_file_name(name: &str) -> bool {
    !name.is_empty()
        && name != "."
        && name != ".."
        && !name.contains(['/', '\\', ':'])
        && !name.chars().any(char::is_control)
}

impl Package {
    /// Opens an FMU: an archive is unpacked, a folder is read where it lies.
    ///
    /// # Errors
    /// If the file is no zip archive, an entry is refused (see [`EntryDefect`]; then nothing stays
    /// behind), or `modelDescription.xml` is missing or cannot be used.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, PackageError> {
        Package::open_within(path, &Limits::default())
    }

    /// [`Package::open`] with other limits than the default.
    ///
    /// # Errors
    /// The archive, an entry or the description is refused.
    pub fn open_within(path: impl AsRef<Path>, limits: &Limits) -> Result<Self, PackageError> {
        let path = path.as_ref();
        let unpacked = match path.is_dir() {
            true => {
                files::note_read_below(path);
                None
            }
            false => Some(unpack(path, limits)?),
        };
        let folder = unpacked.as_ref().map_or(path, |folder| folder.path());
        let cannot_read = |source| PackageError::Read { path: path.to_owned(), source };
        let folder = std::path::absolute(folder).map_err(cannot_read)?;
        let description = read_description(path, &folder, limits)?;
        Ok(Package { path: path.to_owned(), folder, description, _unpacked: unpacked })
    }

    /// The archive or folder that was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder the FMU lies in, an absolute path.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What the FMU says about itself.
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// The shared library for the platform this program runs on.
    ///
    /// # Errors
    /// If there is none; the error names the platforms there are binaries for.
    pub fn binary(&self) -> Result<PathBuf, PackageError> {
        let identifier = self.model_identifier()?;
        let binaries = self.folder.join("binaries");
        let host = Platform::host();
        let version = self.description.fmi_version;
        let file = format!("{identifier}.{}", host.map_or("so", |platform| platform.extension));
        let folders = host.map_or_else(Vec::new, |platform| platform.folders(version));
        let found =
            folders.iter().map(|name| binaries.join(name).join(&file)).find(|f| f.is_file());
        found.ok_or_else(|| PackageError::NoBinary {
            package: self.path.clone(),
            wanted: match folders.first() {
                Some(folder) => format!("binaries/{folder}/{file}"),
                None => format!("a folder for {}-{}", std::env::consts::ARCH, std::env::consts::OS),
            },
            platforms: self.platforms(),
            has_sources: self.has_sources(),
        })
    }

    /// The WebAssembly component of the draft FMI-LS-WASM, where there is one.
    pub fn component(&self) -> Option<PathBuf> {
        let file = format!("{}.wasm", self.model_identifier().ok()?);
        let file = self.folder.join("binaries/wasm32-wasip2").join(file);
        file.is_file().then_some(file)
    }

    /// Co-simulation is preferred where an FMU offers several interface types.
    fn model_identifier(&self) -> Result<&str, PackageError> {
        let co_simulation = self.description.co_simulation.as_ref().map(|cs| &cs.common);
        let first = self.description.interfaces().next().map(|(_, interface)| interface);
        match co_simulation.or(first) {
            Some(interface) if is_file_name(&interface.model_identifier) => {
                Ok(&interface.model_identifier)
            }
            Some(interface) => Err(PackageError::Identifier {
                package: self.path.clone(),
                identifier: interface.model_identifier.clone(),
            }),
            None => Err(PackageError::NoInterface { package: self.path.clone() }),
        }
    }

    /// Names of the platform folders below `binaries/`, sorted.
    pub fn platforms(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.join("binaries")).into_iter().flatten().flatten();
        let folders = entries.filter(|entry| entry.path().is_dir());
        let mut names: Vec<String> =
            folders.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Whether it has C sources.
    pub fn has_sources(&self) -> bool {
        self.folder.join("sources").is_dir()
    }

    /// The folder `resources`, an absolute path; what `fmi3Instantiate…` gets.
    pub fn resources(&self) -> PathBuf {
        self.folder.join("resources")
    }

    /// The folder `resources` as URI, `file:///…` with everything but letters, digits and `-._~`
    /// percent-encoded as UTF-8 (RFC 3986); what `fmi2Instantiate` gets.
    pub fn resources_uri(&self) -> String {
        file_uri(&self.resources())
    }
}

const PATH: &AsciiSet =
    &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');
/// The colon after the drive stays as it is.
const WINDOWS_PATH: &AsciiSet = &PATH.remove(b':');

/// An absolute path as `file` URI (RFC 8089).
pub fn file_uri(path: &Path) -> String {
    let bytes = path.as_os_str().as_encoded_bytes();
    if cfg!(windows) {
        let text = String::from_utf8_lossy(bytes).replace('\\', "/");
        return format!("file:///{}", percent_encode(text.as_bytes(), WINDOWS_PATH));
    }
    format!("file://{}", percent_encode(bytes, PATH))
}

fn read_description(
    package: &Path,
    folder: &Path,
    limits: &Limits,
) -> Result<ModelDescription, PackageError> {
    let file = folder.join(MODEL_DESCRIPTION);
    let cannot_use = |source| PackageError::Description { package: package.to_owned(), source };
    match fs::metadata(&file) {
        Err(_) => {
            let elsewhere = description_one_level_down(folder);
            return Err(PackageError::NoDescription { package: package.to_owned(), elsewhere });
        }
        Ok(metadata) if metadata.len() > limits.xml.bytes as u64 => {
            let bytes = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
            let error = crate::xml::XmlError::TooLarge { bytes, limit: limits.xml.bytes };
            return Err(cannot_use(ParseError::Xml(error)));
        }
        Ok(_) => {}
    }
    let bytes = fs::read(&file).map_err(|source| PackageError::Read { path: file, source })?;
    read::usable(&bytes, &limits.xml).map_err(cannot_use)
}

/// Where the description is if somebody zipped the folder instead of its content.
fn description_one_level_down(folder: &Path) -> Option<String> {
    let mut below = fs::read_dir(folder).ok()?.flatten();
    below
        .find(|entry| entry.path().join(MODEL_DESCRIPTION).is_file())
        .map(|entry| format!("{}/{MODEL_DESCRIPTION}", entry.file_name().to_string_lossy()))
}

/// Unpacks an archive into a new temporary folder; all of it or nothing.
pub(crate) fn unpack(path: &Path, limits: &Limits) -> Result<TempDir, PackageError> {
    let mut archive = Archive::open(path, limits)?;
    if let Some((entry, defect)) = archive.all_defects().next() {
        return Err(PackageError::entry(path, entry, defect.clone()));
    }
    let cannot_write = |path: &Path, source| PackageError::Write { path: path.to_owned(), source };
    let folder = tempfile::Builder::new()
        .prefix("fmu-")
        .tempdir()
        .map_err(|source| cannot_write(&std::env::temp_dir(), source))?;
    // Importers hand the folder on to FMUs that read it whether they ship it or not.
    let resources = folder.path().join("resources");
    fs::create_dir(&resources).map_err(|source| cannot_write(&resources, source))?;
    for entry in archive.entries.clone() {
        let target = folder.path().join(entry.components.iter().collect::<PathBuf>());
        let parent = if entry.is_folder { Some(target.as_path()) } else { target.parent() };
        if let Some(parent) = parent {
            fs::create_dir_all(parent).map_err(|source| cannot_write(parent, source))?;
        }
        if !entry.is_folder {
            let mut file = create(&target).map_err(|source| cannot_write(&target, source))?;
            archive.copy(&entry, &mut file, &target)?;
        }
    }
    Ok(folder)
}

/// A file that did not exist before: nothing is overwritten and no link is followed.
fn create(path: &Path) -> std::io::Result<File> {
    OpenOptions::new().write(true).create_new(true).open(path)
}
