//! Packs an FMU.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter};

use super::error::PackageError;
use super::platform::Platform;
use crate::description::{FmiVersion, ModelDescription};
use crate::problem::MODEL_DESCRIPTION;

/// An FMU in the making.
///
/// The same content gives the same bytes, whenever and wherever it is packed: entries are sorted,
/// time stamps are that of the zip format's first day, permissions are fixed.
#[derive(Debug, Clone)]
pub struct PackageBuilder {
    version: FmiVersion,
    model_identifiers: Vec<String>,
    description: String,
    entries: BTreeMap<String, Vec<u8>>,
}

impl PackageBuilder {
    /// Starts an FMU with this description.
    ///
    /// # Errors
    /// If the description cannot be written as XML.
    pub fn new(description: &ModelDescription) -> Result<Self, PackageError> {
        let mut model_identifiers: Vec<String> = description
            .interfaces()
            .map(|(_, interface)| interface.model_identifier.clone())
            .collect();
        model_identifiers.dedup();
        Ok(PackageBuilder {
            version: description.fmi_version,
            model_identifiers,
            description: description.to_xml()?,
            entries: BTreeMap::new(),
        })
    }

    /// Adds the shared library for a platform, named as in FMI 2.0 (`linux64`) or 3.0
    /// (`x86_64-linux`); it goes to the folder that the FMU's version prescribes, under the name
    /// that the description's `modelIdentifier` prescribes. A ZIP archive with the library as its only entry is copied as
    /// it is compressed.
    ///
    /// # Errors
    /// If the platform is unknown or its library is there already.
    pub fn binary(&mut self, platform: &str, library: Vec<u8>) -> Result<&mut Self, PackageError> {
        let known = Platform::from_name(platform).ok_or_else(|| PackageError::Name {
            entry: format!("binaries/{platform}"),
            reason: format!(
                "the platform is unknown; known are {}",
                super::PLATFORMS.map(|p| p.folder(self.version)).join(", ")
            ),
        })?;
        for identifier in self.model_identifiers.clone() {
            let folder = known.folder(self.version);
            let path = format!("binaries/{folder}/{identifier}.{}", known.extension);
            self.entry(path, library.clone())?;
        }
        Ok(self)
    }

    /// Adds a file that the FMU reads when it runs, below `resources/`.
    ///
    /// # Errors
    /// The path is refused, or taken already.
    pub fn resource(&mut self, path: &str, content: Vec<u8>) -> Result<&mut Self, PackageError> {
        self.entry(format!("resources/{path}"), content)
    }

    /// Adds a file of the FMU as C, below `sources/`; the description (2.0) or a file
    /// `buildDescription.xml` (3.0) says which are compiled.
    ///
    /// # Errors
    /// The path is refused, or taken already.
    pub fn source(&mut self, path: &str, content: Vec<u8>) -> Result<&mut Self, PackageError> {
        self.entry(format!("sources/{path}"), content)
    }

    /// Adds a WebAssembly component by the draft of FMI-LS-WASM, with its manifest; for FMI 3.0 only.
    ///
    /// # Errors
    /// The path is refused, or taken already.
    pub fn component(&mut self, component: &[u8]) -> Result<&mut Self, PackageError> {
        for identifier in self.model_identifiers.clone() {
            let path = format!("binaries/{}/{identifier}.wasm", super::WASM);
            self.entry(path, component.to_vec())?;
        }
        let manifest = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
            <fmiLayeredStandardManifest xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\" \
            fmi-ls:fmi-ls-name=\"org.modelica.fmi-ls-wasm\" fmi-ls:fmi-ls-version=\"0.1.0\" \
            fmi-ls:fmi-ls-description=\"FMI Layered Standard for WebAssembly\"/>\n";
        self.entry(super::WASM_MANIFEST, manifest.into())
    }

    /// Takes the shared libraries out again.
    pub fn remove_binaries(&mut self) -> &mut Self {
        let wasm = format!("binaries/{}/", super::WASM);
        let is_library = |path: &str| path.starts_with("binaries/") && !path.starts_with(&wasm);
        self.entries.retain(|path, _| !is_library(path));
        self
    }

    /// Adds a file for people, below `documentation/`; they start at `index.html`.
    ///
    /// # Errors
    /// The path is refused, or taken already.
    pub fn documentation(
        &mut self,
        path: &str,
        content: Vec<u8>,
    ) -> Result<&mut Self, PackageError> {
        self.entry(format!("documentation/{path}"), content)
    }

    /// Adds a licence, below `licenses/` (2.0) or `documentation/licenses/` (3.0); the entry point
    /// is `license.txt` or `license.html`.
    ///
    /// # Errors
    /// The path is refused, or taken already.
    pub fn license(&mut self, path: &str, content: Vec<u8>) -> Result<&mut Self, PackageError> {
        match self.version {
            FmiVersion::V2 => self.entry(format!("licenses/{path}"), content),
            FmiVersion::V3 => self.entry(format!("documentation/licenses/{path}"), content),
        }
    }

    /// Adds a file for tools, below `extra/`; the next folder is the tool's reversed domain.
    ///
    /// # Errors
    /// The path is refused, or taken already.
    pub fn extra(&mut self, path: &str, content: Vec<u8>) -> Result<&mut Self, PackageError> {
        self.entry(format!("extra/{path}"), content)
    }

    /// Adds any file, at a path with forward slashes.
    ///
    /// # Errors
    /// If the path is not a plain relative path or is there already.
    pub fn entry(
        &mut self,
        path: impl Into<String>,
        content: Vec<u8>,
    ) -> Result<&mut Self, PackageError> {
        let path = path.into();
        if let Some(reason) = self.refusal(&path) {
            return Err(PackageError::Name { entry: path, reason });
        }
        self.entries.insert(path, content);
        Ok(self)
    }

    fn refusal(&self, path: &str) -> Option<String> {
        let plain = |part: &str| !part.is_empty() && part != "." && part != "..";
        let below = format!("{path}/");
        let is_folder = |name: &String| name.starts_with(&below);
        let is_below_file = |name: &String| path.starts_with(&format!("{name}/"));
        if path.contains('\\') || path.contains(':') || path.chars().any(char::is_control) {
            Some("it has a backslash, a colon or a control character".to_owned())
        } else if !path.split('/').all(plain) {
            Some("it must be a relative path without empty parts, \".\" and \"..\"".to_owned())
        } else if path == MODEL_DESCRIPTION || self.entries.contains_key(path) {
            Some("there is such an entry already".to_owned())
        } else if self.entries.keys().any(|name| is_folder(name) || is_below_file(name)) {
            Some("another entry makes it, or a part of it, both a file and a folder".to_owned())
        } else {
            None
        }
    }

    /// The bytes of the `.fmu`.
    ///
    /// # Errors
    /// If the zip writer fails.
    pub fn to_bytes(&self) -> Result<Vec<u8>, PackageError> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        add(&mut zip, MODEL_DESCRIPTION, self.description.as_bytes())?;
        // Importers pass NULL for a folder that is not there, and not every FMU survives that.
        if !self.entries.keys().any(|path| path.starts_with("resources/")) {
            zip.add_directory("resources/", options(0o755))
                .map_err(|e| failed("resources/", &e))?;
        }
        for (path, content) in &self.entries {
            add(&mut zip, path, content)?;
        }
        let bytes = zip.finish().map_err(|error| failed("end of archive", &error))?;
        Ok(bytes.into_inner())
    }

    /// Writes the `.fmu`; the file appears complete or not at all.
    ///
    /// # Errors
    /// If the zip writer fails or the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), PackageError> {
        let path = path.as_ref();
        let bytes = self.to_bytes()?;
        files::AtomicFile::write_all_of(path, &bytes)
            .map_err(|source| PackageError::Write { path: path.to_owned(), source })
    }
}

/// Writes an archive of these entries, each with its path; the file appears complete or not at all.
pub(crate) fn write_archive<'a>(
    path: &Path,
    entries: impl Iterator<Item = (&'a str, &'a [u8])>,
) -> Result<(), PackageError> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in entries {
        add(&mut zip, name, content)?;
    }
    let bytes = zip.finish().map_err(|error| failed("end of archive", &error))?;
    files::AtomicFile::write_all_of(path, &bytes.into_inner())
        .map_err(|source| PackageError::Write { path: path.to_owned(), source })
}

fn add(
    zip: &mut ZipWriter<Cursor<Vec<u8>>>,
    path: &str,
    content: &[u8],
) -> Result<(), PackageError> {
    let is_binary = path.starts_with("binaries/");
    // Of no system is that the begin of a library.
    if is_binary && content.starts_with(b"PK\x03\x04") {
        let mut archive =
            ZipArchive::new(Cursor::new(content)).map_err(|error| failed(path, &error))?;
        let only = archive.by_index_raw(0).map_err(|error| failed(path, &error))?;
        return zip.raw_copy_file_rename(only, path).map_err(|error| failed(path, &error));
    }
    let permissions = if is_binary { 0o755 } else { 0o644 };
    zip.start_file(path, options(permissions)).map_err(|error| failed(path, &error))?;
    zip.write_all(content).map_err(|error| failed(path, &error))
}

fn options(permissions: u32) -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(6))
        .last_modified_time(DateTime::default())
        .system(System::Unix)
        .unix_permissions(permissions)
}

fn failed(entry: &str, error: &dyn std::error::Error) -> PackageError {
    PackageError::Pack { entry: entry.to_owned(), message: error.to_string() }
}
