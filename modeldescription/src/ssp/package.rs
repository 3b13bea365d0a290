//! SSP archives: open one safely, pack one.

use std::collections::BTreeMap;
use std::path::{Component as PathPart, Path, PathBuf};

use percent_encoding::percent_decode_str;
use tempfile::TempDir;

use super::SYSTEM_STRUCTURE;
use super::connector::Source;
use super::problem::{Format, SspError, problem};
use super::structure::*;
use super::{read, values};
use crate::package::{Archive, Limits, PackageError, unpack, write_archive};
use crate::problem::Problem;
use crate::xml::XmlLimits;

/// An SSP that lies unpacked in a folder, with all parameter files loaded.
#[derive(Debug)]
pub struct Ssp {
    path: PathBuf,
    folder: PathBuf,
    /// The SSD's file name.
    name: String,
    structure: SystemStructure,
    _unpacked: Option<TempDir>,
}

impl Ssp {
    /// Opens an SSP: an archive is unpacked into a new temporary folder, which is removed when this
    /// is dropped; a folder, or a single `.ssd`, is read where it lies. Sources of an archive lie
    /// inside it; those of a folder may lie beside it (`../plant.fmu`).
    ///
    /// # Errors
    /// An archive that is refused, or everything that is wrong in its files.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, SspError> {
        Ssp::open_within(path, &Limits::default())
    }

    /// [`Ssp::open`] with other limits than the default.
    ///
    /// # Errors
    /// An archive that is refused, or everything that is wrong in its files.
    pub fn open_within(path: impl AsRef<Path>, limits: &Limits) -> Result<Self, SspError> {
        let path = path.as_ref();
        let is_ssd = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ssd"));
        let (folder, unpacked) = if path.is_dir() {
            (path.to_path_buf(), None)
        } else if is_ssd {
            (path.parent().unwrap_or(Path::new("")).to_path_buf(), None)
        } else {
            let unpacked = unpack(path, limits)?;
            (unpacked.path().to_path_buf(), Some(unpacked))
        };
        let folder = std::path::absolute(if folder.as_os_str().is_empty() {
            Path::new(".")
        } else {
            &folder
        })
        .map_err(|source| PackageError::Read { path: path.to_owned(), source })?;
        let file = match path.file_name() {
            Some(name) if is_ssd => folder.join(name),
            _ => folder.join(SYSTEM_STRUCTURE),
        };
        if !file.is_file() {
            return Err(SspError::NoStructure { path: path.to_owned() });
        }
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let within = if unpacked.is_some() { Within::Archive } else { Within::Folder };
        let mut problems = Vec::new();
        let structure = content(&file, &limits.xml)
            .map_err(|source| PackageError::Read { path: file, source })
            .map(|bytes| read::read(&bytes, &name, &limits.xml, &mut problems))?;
        let structure = structure.map(|mut structure| {
            let problems = &mut problems;
            let mut loader = Loader { folder: &folder, name: &name, within, limits, problems };
            loader.system(&mut structure.system);
            structure
        });
        match structure {
            Some(structure) if problems.is_empty() => {
                Ok(Ssp { path: path.to_owned(), folder, name, structure, _unpacked: unpacked })
            }
            _ => Err(SspError::Problems(problems)),
        }
    }

    /// The archive or folder that was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file name of the SSD, for messages.
    pub fn file_name(&self) -> &str {
        &self.name
    }

    /// What the SSD says, with the parameter sets and mappings of other files in their places.
    pub fn structure(&self) -> &SystemStructure {
        &self.structure
    }

    /// The file that a relative URI of the SSD means.
    ///
    /// # Errors
    /// A sentence: it leads out of the SSP, has a scheme, or there is no such file.
    pub fn file(&self, source: &str) -> Result<PathBuf, String> {
        let within = if self._unpacked.is_some() { Within::Archive } else { Within::Folder };
        resolve(&self.folder, source, within)
    }
}

/// Where the sources of an SSP may lie.
#[derive(Clone, Copy, PartialEq)]
enum Within {
    /// Inside the archive.
    Archive,
    /// In the folder or, by `..`, beside it: a folder is its owner's.
    Folder,
}

/// Reads a file, at most one byte more than is allowed, which the XML reader then refuses.
fn content(file: &Path, limits: &XmlLimits) -> std::io::Result<Vec<u8>> {
    use std::io::Read;
    files::note_read(file);
    let mut bytes = Vec::new();
    let most = (limits.bytes as u64).saturating_add(1);
    std::fs::File::open(file)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The relative path that a URI means.
fn relative(source: &str, within: Within) -> Result<PathBuf, String> {
    let decoded = percent_decode_str(source).decode_utf8().map_err(|_| {
        format!("the source \"{source}\" does not decode to UTF-8; percent-encode it as UTF-8")
    })?;
    let relative = Path::new(&*decoded);
    let scheme = source.split(['/', '?', '#']).next().is_some_and(|first| first.contains(':'));
    let plain = relative.components().all(|part| match part {
        PathPart::Normal(_) | PathPart::CurDir => true,
        PathPart::ParentDir => within == Within::Folder,
        _ => false,
    });
    if scheme || !plain || decoded.contains('\0') {
        return Err(format!(
            "the source \"{source}\" leads out of the SSP; write a relative path inside it, such \
             as resources/plant.fmu"
        ));
    }
    Ok(relative.components().filter(|part| !matches!(part, PathPart::CurDir)).collect())
}

/// A relative URI below a folder.
fn resolve(folder: &Path, source: &str, within: Within) -> Result<PathBuf, String> {
    let file = folder.join(relative(source, within)?);
    // Of a plain folder, an unpacked FMU too.
    if file.is_file() || (within == Within::Folder && file.join("modelDescription.xml").is_file()) {
        return Ok(file);
    }
    Err(format!("there is no file \"{source}\" in the SSP; add it or correct the name"))
}

/// A file inside a component, which is an archive, an FMU as a rule.
fn within(component: &Path, source: &str, limits: &Limits) -> Result<Vec<u8>, String> {
    let parts: Vec<String> = relative(source, Within::Archive)?
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    let mut archive = Archive::open(component, limits).map_err(|error| error.to_string())?;
    if let Some((entry, defect)) = archive.all_defects().next() {
        return Err(PackageError::entry(component, entry, defect.clone()).to_string());
    }
    match archive.read(&parts.join("/")) {
        Some(read) => read.map_err(|error| error.to_string()),
        None => Err(format!(
            "there is no file \"{source}\" in {}; add it, or remove sourceBase if it stands in the \
             SSP itself",
            component.display()
        )),
    }
}

/// Loads the files of parameter bindings.
struct Loader<'a> {
    folder: &'a Path,
    name: &'a str,
    within: Within,
    limits: &'a Limits,
    problems: &'a mut Vec<Problem>,
}

impl Loader<'_> {
    fn system(&mut self, system: &mut System) {
        system.bindings.iter_mut().for_each(|binding| self.binding(binding, None));
        for list in &mut system.dictionaries {
            if let Some((file, bytes)) = self.load(&list.source, None, list.line.0) {
                read::load_dictionary(&bytes, &file, &self.limits.xml, self.problems, list);
            }
        }
        for element in &mut system.elements {
            match element {
                Element::System(system) => self.system(system),
                Element::Dictionary(_) => {}
                Element::Component(component) => {
                    let source = Some(component.source.as_str());
                    component.bindings.iter_mut().for_each(|one| self.binding(one, source));
                }
            }
        }
    }

    /// Loads what a binding names; `component` is the source of the component that has it.
    fn binding(&mut self, binding: &mut Binding, component: Option<&str>) {
        let limits = &self.limits.xml;
        if let Some((file, bytes)) = self.load(&binding.source, component, binding.line.0) {
            binding.values = values::read_set(&bytes, &file, limits, self.problems);
        }
        let Some(mapping) = &mut binding.mapping else { return };
        if let Some((file, bytes)) = self.load(&mapping.source, component, mapping.line.0) {
            mapping.mapping = values::read_mapping(&bytes, &file, limits, self.problems);
        }
    }

    fn load(
        &mut self,
        source: &Source,
        component: Option<&str>,
        line: u32,
    ) -> Option<(String, Vec<u8>)> {
        let loaded = match (source, component) {
            (Source::Inline, _) => return None,
            (Source::File(file), _) => resolve(self.folder, file, self.within).and_then(|path| {
                let bytes = content(&path, &self.limits.xml).map_err(|e| format!("{file}: {e}"))?;
                Ok((file.clone(), bytes))
            }),
            (Source::InComponent(file), Some(component)) => {
                resolve(self.folder, component, self.within)
                    .and_then(|archive| within(&archive, file, self.limits))
                    .map(|bytes| (format!("{component}/{file}"), bytes))
            }
            (Source::InComponent(file), None) => Err(format!(
                "the source \"{file}\" is relative to a component, but the binding is a system's; \
                 remove sourceBase"
            )),
        };
        loaded
            .map_err(|found| {
                let problem = problem(Format::Structure, self.name, line, found);
                let rule = "the SSP carries what its SSD names";
                self.problems.push(problem.rule(rule));
            })
            .ok()
    }
}

/// An SSP in the making; the same content gives the same bytes.
#[derive(Debug, Clone)]
pub struct SspBuilder {
    structure: String,
    entries: BTreeMap<String, Vec<u8>>,
}

impl SspBuilder {
    /// Starts an SSP with this structure; parameter sets and mappings that it holds but that
    /// come from files are packed as these files.
    ///
    /// # Errors
    /// If it cannot be written as XML, or names files outside the SSP.
    pub fn new(structure: &SystemStructure) -> Result<Self, SspError> {
        let mut builder = SspBuilder { structure: structure.to_xml()?, entries: BTreeMap::new() };
        builder.parameters(&structure.system)?;
        Ok(builder)
    }

    fn parameters(&mut self, system: &System) -> Result<(), SspError> {
        let inner = system.elements.iter().flat_map(|element| match element {
            Element::Component(component) => component.bindings.as_slice(),
            Element::System(_) | Element::Dictionary(_) => &[],
        });
        for binding in system.bindings.iter().chain(inner) {
            if let (Source::File(file), Some(values)) = (&binding.source, &binding.values) {
                self.entry(file, values.to_xml()?.into_bytes())?;
            }
            let mapping = binding.mapping.as_ref();
            let stored = mapping.and_then(|m| Some((&m.source, m.mapping.as_ref()?)));
            if let Some((Source::File(file), mapping)) = stored {
                self.entry(file, mapping.to_xml()?.into_bytes())?;
            }
        }
        for list in &system.dictionaries {
            if let (Source::File(file), Some(_)) = (&list.source, &list.signals) {
                self.entry(file, list.to_xml()?.into_bytes())?;
            }
        }
        for element in &system.elements {
            if let Element::System(system) = element {
                self.parameters(system)?;
            }
        }
        Ok(())
    }

    /// Adds a file at a relative path, such as `resources/plant.fmu`.
    ///
    /// # Errors
    /// A path that is not plain and relative, or that holds something else already.
    pub fn entry(&mut self, path: &str, content: Vec<u8>) -> Result<&mut Self, SspError> {
        let plain = |part: &str| !part.is_empty() && part != "." && part != "..";
        let odd = path.contains(['\\', ':']) || path.chars().any(char::is_control);
        let other = self.entries.get(path).is_some_and(|there| *there != content);
        let reason = if odd || !path.split('/').all(plain) {
            "it must be a relative path with forward slashes, without \".\", \"..\" and colons"
        } else if path == SYSTEM_STRUCTURE || other {
            "there is another entry of this name"
        } else {
            self.entries.insert(path.to_owned(), content);
            return Ok(self);
        };
        let (entry, reason) = (path.to_owned(), reason.to_owned());
        Err(PackageError::Name { entry, reason }.into())
    }

    /// Writes the `.ssp`; the file appears complete or not at all.
    ///
    /// # Errors
    /// If the zip writer fails or the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), SspError> {
        let entries =
            self.entries.iter().map(|(path, content)| (path.as_str(), content.as_slice()));
        let structure = std::iter::once((SYSTEM_STRUCTURE, self.structure.as_bytes()));
        Ok(write_archive(path.as_ref(), structure.chain(entries))?)
    }
}
