//! The archive or folder of an FMU: entries, folders, binaries, sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::content::{Content, Source};
use super::{binary, functions, read_and_check, sources};
use crate::description::{FmiVersion, ModelDescription};
use crate::package::{Archive, EntryDefect, Limits, PackageError, Platform, WASM, WASM_MANIFEST};
use crate::problem::{MODEL_DESCRIPTION, Problem, Topic};

/// Binaries beyond this size are not looked into.
const LARGEST_BINARY: u64 = 1 << 30;

pub(super) fn check(path: &Path, limits: &Limits) -> Result<Vec<Problem>, PackageError> {
    let mut problems = Vec::new();
    let mut content = match path.is_dir() {
        true => Content::of_folder(path)?,
        false => match Archive::open(path, limits) {
            Ok(archive) => Content::of_archive(archive),
            Err(error @ PackageError::Read { .. }) => return Err(error),
            Err(error) => return Ok(vec![not_an_archive(path, &error)]),
        },
    };
    let (description, in_xml) = describe(&mut content, limits);
    let version = description.as_ref().map_or(FmiVersion::V2, |d| d.fmi_version);
    if !path.is_dir() && path.extension().is_none_or(|extension| extension != "fmu") {
        let found = "the file does not end in .fmu".to_owned();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let problem = Problem::in_entry(version, Topic::Distribution, &name, found);
        problems.push(problem.rule("the extension must be .fmu").way_out("rename the file"));
    }
    if let Source::Archive(archive) = &content.source {
        entries(&mut problems, version, archive);
    }
    folders(&mut problems, version, &content.files);
    problems.extend(in_xml);
    if let Some(description) = description.filter(|_| !content.is_bomb()) {
        implementations(&mut problems, &description, &mut content, limits);
    }
    if !content.is_bomb() {
        unread_entries(&mut problems, version, &mut content);
    }
    Ok(problems)
}

fn not_an_archive(path: &Path, error: &PackageError) -> Problem {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let found = match error {
        PackageError::NotAnArchive { message, .. } => {
            format!("the file is not a readable zip archive ({message})")
        }
        PackageError::Entry { defect, .. } => defect.to_string(),
        other => other.to_string(),
    };
    Problem::in_entry(FmiVersion::V2, Topic::Distribution, &name, found)
        .rule("an FMU is a zip archive")
        .way_out("pack or fetch it again; nothing further was checked")
}

fn describe(content: &mut Content, limits: &Limits) -> (Option<ModelDescription>, Vec<Problem>) {
    let problem = |found: String| {
        Problem::in_entry(FmiVersion::V2, Topic::Distribution, MODEL_DESCRIPTION, found)
            .rule("modelDescription.xml must be at the root of the archive")
    };
    match content.read(MODEL_DESCRIPTION, limits.xml.bytes as u64) {
        Some(Ok(xml)) => read_and_check(&xml, &limits.xml),
        Some(Err(message)) => {
            let found = format!("it cannot be read: {message}");
            (None, vec![problem(found).way_out("pack the FMU again")])
        }
        None => {
            let below = |path: &&String| path.ends_with(&format!("/{MODEL_DESCRIPTION}"));
            let way_out = match content.files.keys().find(below) {
                Some(path) => format!("it is at {path}: zip the content, not the folder"),
                None => "add it".to_owned(),
            };
            (None, vec![problem("there is no such file".to_owned()).way_out(way_out)])
        }
    }
}

/// What the standard says about single entries of the archive.
fn entries(problems: &mut Vec<Problem>, version: FmiVersion, archive: &Archive) {
    let mut report = |entry: &str, found: String, rule: &str, way_out: &str| {
        let shown: String = entry.chars().take(120).flat_map(char::escape_debug).collect();
        let problem = Problem::in_entry(version, Topic::Distribution, &shown, found);
        problems.push(problem.rule(rule).way_out(way_out));
    };
    for (entry, defect) in archive.all_defects() {
        let (rule, way_out) = rule_of(defect);
        report(entry, defect.to_string(), rule, way_out);
    }
    for entry in &archive.entries {
        if entry.has_backslash {
            let found = "the name has a backslash".to_owned();
            let rule = "folders are separated by forward slashes only";
            report(&entry.name, found, rule, "pack with a tool that writes forward slashes");
        }
        // What needs another decompressor needs another version, too, and is reported already.
        if entry.version_needed > 20 && entry.defect.is_none() {
            let (major, minor) = (entry.version_needed / 10, entry.version_needed % 10);
            let found = format!("version {major}.{minor} of the zip format is needed");
            let rule = "version needed to extract must not be higher than 2.0";
            report(&entry.name, found, rule, "pack without zip64 and other extensions");
        }
        if entry.streamed_but_stored {
            let found = "it is stored with its size after the data".to_owned();
            let rule = "only deflated files may have general purpose bit 3 set";
            report(&entry.name, found, rule, "deflate it, or pack to a seekable file");
        }
    }
}

/// The rule that a defect breaks, and the way out.
fn rule_of(defect: &EntryDefect) -> (&'static str, &'static str) {
    match defect {
        EntryDefect::Traversal
        | EntryDefect::Absolute
        | EntryDefect::DriveLetter
        | EntryDefect::ControlCharacter { .. }
        | EntryDefect::NoName
        | EntryDefect::NameTooLong { .. } => {
            ("names are relative paths inside the FMU", "pack with relative paths")
        }
        EntryDefect::SymbolicLink | EntryDefect::SpecialFile => {
            ("an FMU consists of files and folders", "pack the file itself")
        }
        EntryDefect::Encrypted => ("encryption must not be used", "pack without a password"),
        EntryDefect::Compression { .. } => {
            ("the compression method is store or deflate", "pack with deflate")
        }
        EntryDefect::Duplicate | EntryDefect::FileAndFolder => {
            ("each path is there once", "remove one")
        }
        EntryDefect::Broken { .. } => ("every entry can be unpacked", "pack the FMU again"),
        EntryDefect::Overlap
        | EntryDefect::TooMany { .. }
        | EntryDefect::Bomb { .. }
        | EntryDefect::Dense { .. } => {
            ("importers protect themselves against such archives", "pack the FMU again")
        }
    }
}

/// Unpacks what nobody looked into yet, to nowhere: damage shows in the checksum.
fn unread_entries(problems: &mut Vec<Problem>, version: FmiVersion, content: &mut Content) {
    let Source::Archive(archive) = &mut content.source else { return };
    for entry in archive.entries.clone() {
        let path = entry.path();
        if entry.is_folder || entry.defect.is_some() || content.read.contains(&path) {
            continue;
        }
        if let Err(PackageError::Entry { defect, .. }) =
            archive.copy(&entry, &mut std::io::sink(), Path::new(&path))
        {
            let (rule, way_out) = rule_of(&defect);
            let problem =
                Problem::in_entry(version, Topic::Distribution, &path, defect.to_string());
            problems.push(problem.rule(rule).way_out(way_out));
        }
    }
}

/// What the standard says about the folders.
fn folders(problems: &mut Vec<Problem>, version: FmiVersion, files: &BTreeMap<String, u64>) {
    let has = |path: &str| files.contains_key(path);
    let has_folder = |folder: &str| files.keys().any(|path| path.starts_with(folder));
    let mut warn = |file: &str, found: &str, rule: &str, way_out: &str| {
        let problem = Problem::in_entry(version, Topic::Distribution, file, found.to_owned());
        problems.push(problem.rule(rule).way_out(way_out).warning());
    };
    let licenses = match version {
        FmiVersion::V2 => "licenses/",
        FmiVersion::V3 => "documentation/licenses/",
    };
    let entry_points = ["license.txt", "license.html", "license.spdx"];
    if has_folder(licenses) && !entry_points.iter().any(|name| has(&format!("{licenses}{name}"))) {
        let rule = "the entry point is license.txt, license.html or license.spdx";
        warn(licenses, "the folder has no entry point", rule, "add one of them");
    }
    let documents = files.keys().filter(|path| path.starts_with("documentation/"));
    let only_licenses = documents.clone().all(|path| path.starts_with(licenses));
    if documents.count() > 0 && !only_licenses && !has("documentation/index.html") {
        let rule = "the entry point of the documentation is index.html";
        warn("documentation/", "the folder has no index.html", rule, "add it");
    }
    let mut lower = BTreeMap::new();
    for path in files.keys() {
        if let Some(other) = lower.insert(path.to_lowercase(), path) {
            let found = format!("\"{other}\" differs in upper and lower case only");
            let rule = "on Windows and macOS one overwrites the other";
            warn(path, &found, rule, "rename one");
        }
    }
}

/// Binaries and sources: at least one, complete.
fn implementations(
    problems: &mut Vec<Problem>,
    description: &ModelDescription,
    content: &mut Content,
    limits: &Limits,
) {
    let version = description.fmi_version;
    let platforms: BTreeSet<String> = content
        .files
        .keys()
        .filter_map(|path| path.strip_prefix("binaries/")?.split_once('/'))
        .map(|(platform, _)| platform.to_owned())
        .collect();
    if platforms.is_empty() && !sources::are_there(description, content) {
        let found = "the FMU has neither binaries nor sources".to_owned();
        let problem = Problem::in_entry(version, Topic::Distribution, "binaries/", found);
        let way_out = match version {
            FmiVersion::V2 => "add binaries/linux64/<modelIdentifier>.so or the like",
            FmiVersion::V3 => "add binaries/x86_64-linux/<modelIdentifier>.so or the like",
        };
        problems.push(problem.rule("at least one implementation is required").way_out(way_out));
    }
    sources::check(problems, description, content, limits);
    for name in platforms {
        match name.as_str() {
            WASM => component(problems, description, content),
            name => platform(problems, description, content, name),
        }
    }
}

/// A WebAssembly component by the draft of FMI-LS-WASM: there, under the right name, a component, with its manifest.
fn component(problems: &mut Vec<Problem>, description: &ModelDescription, content: &mut Content) {
    /// How a component begins; a module, which is no component, has another version.
    const HEAD: &[u8; 8] = b"\0asm\x0d\0\x01\0";
    let version = description.fmi_version;
    let mut wrong = |path: &str, found: String, rule: &str, way_out: &str| {
        let problem = Problem::in_entry(version, Topic::Binaries, path, found);
        problems.push(problem.rule(rule).way_out(way_out));
    };
    let folder = format!("binaries/{WASM}/");
    if version == FmiVersion::V2 {
        let found = "an FMU of FMI 2.0 has a WebAssembly component".to_owned();
        wrong(&folder, found, "FMI-LS-WASM belongs to FMI 3.0", "pack it as FMI 3.0");
    }
    let identifiers: BTreeSet<&str> =
        description.interfaces().map(|(_, i)| i.model_identifier.as_str()).collect();
    for identifier in identifiers {
        let path = format!("{folder}{identifier}.wasm");
        match content.read(&path, LARGEST_BINARY) {
            None => {
                let found =
                    format!("there is no such file; the folder has {}", others(content, WASM));
                let rule = "the component must have the name of the modelIdentifier";
                wrong(&path, found, rule, "rename or add the component");
            }
            Some(Err(message)) => {
                let found = format!("it cannot be read: {message}");
                wrong(&path, found, "the component must be loadable", "pack the FMU again");
            }
            Some(Ok(bytes)) if !bytes.starts_with(HEAD) => {
                let found = match bytes.starts_with(b"\0asm") {
                    true => "it is a WebAssembly module",
                    false => "it does not begin as WebAssembly does",
                };
                let rule = "the file must be a component of the WebAssembly Component Model";
                wrong(
                    &path,
                    found.to_owned(),
                    rule,
                    "make a component of it, as \"wasm-tools component new\" does",
                );
            }
            Some(Ok(_)) => {}
        }
    }
    if !content.files.contains_key(WASM_MANIFEST) {
        let rule = "FMI-LS-WASM requires the manifest of the layered standard";
        wrong(WASM_MANIFEST, "there is no such file".to_owned(), rule, "add the manifest");
    }
}

/// The library of one platform: there, under the right name, for that platform, complete.
fn platform(
    problems: &mut Vec<Problem>,
    description: &ModelDescription,
    content: &mut Content,
    name: &str,
) {
    let version = description.fmi_version;
    // Vendors may introduce further platforms; nothing is known about those.
    let Some(platform) = Platform::from_name(name) else { return };
    let proper = platform.folder(version);
    if proper != name {
        let folder = format!("binaries/{name}/");
        let found = "the folder is named as in the other version of the standard".to_owned();
        let problem = Problem::in_entry(version, Topic::Binaries, &folder, found)
            .rule(format!("in FMI {} it is called {proper}", version.text()))
            .way_out("rename the folder");
        problems.push(problem);
    }
    let identifiers: BTreeSet<&str> =
        description.interfaces().map(|(_, i)| i.model_identifier.as_str()).collect();
    let required = functions::required_functions(description);
    for identifier in identifiers {
        let path = format!("binaries/{name}/{identifier}.{}", platform.extension);
        let in_entry = |found| Problem::in_entry(version, Topic::Binaries, &path, found);
        match content.read(&path, LARGEST_BINARY) {
            None => {
                let present = others(content, name);
                let rule = "the library must have the name of the modelIdentifier";
                let found = format!("there is no such file; the folder has {present}");
                problems.push(in_entry(found).rule(rule).way_out("rename or add the library"));
            }
            Some(Err(message)) => {
                let found = format!("it cannot be read: {message}");
                let rule = "the library must be loadable";
                problems.push(in_entry(found).rule(rule).way_out("pack the FMU again"));
            }
            Some(Ok(bytes)) => {
                for (found, rule, way_out) in binary::faults(&bytes, platform, &required) {
                    problems.push(in_entry(found).rule(rule).way_out(way_out));
                }
            }
        }
    }
}

/// The files of a platform's folder.
fn others(content: &Content, platform: &str) -> String {
    let folder = format!("binaries/{platform}/");
    let names = content.files.keys().filter_map(|path| path.strip_prefix(&folder));
    names.take(10).collect::<Vec<_>>().join(", ")
}
