//! An FMU as C: the files that are compiled are named and there, and so is what they include.

use std::collections::BTreeSet;

use super::content::Content;
use crate::description::{FmiVersion, ModelDescription};
use crate::package::Limits;
use crate::problem::{Problem, Topic};
use crate::xml;

const BUILD: &str = "sources/buildDescription.xml";
/// What the importer has; a copy in the FMU would win over it.
const HEADERS: [&str; 6] = [
    "fmi2TypesPlatform.h",
    "fmi2FunctionTypes.h",
    "fmi2Functions.h",
    "fmi3PlatformTypes.h",
    "fmi3FunctionTypes.h",
    "fmi3Functions.h",
];
/// What each compiler of C11 has, also where it is named in quotation marks (ISO/IEC 9899:2011, 7.1.2).
const OF_C: [&str; 29] = [
    "assert.h",
    "complex.h",
    "ctype.h",
    "errno.h",
    "fenv.h",
    "float.h",
    "inttypes.h",
    "iso646.h",
    "limits.h",
    "locale.h",
    "math.h",
    "setjmp.h",
    "signal.h",
    "stdalign.h",
    "stdarg.h",
    "stdatomic.h",
    "stdbool.h",
    "stddef.h",
    "stdint.h",
    "stdio.h",
    "stdlib.h",
    "stdnoreturn.h",
    "string.h",
    "tgmath.h",
    "threads.h",
    "time.h",
    "uchar.h",
    "wchar.h",
    "wctype.h",
];
/// Sources beyond this size are not looked into.
const LARGEST_SOURCE: u64 = 1 << 26;

pub(super) fn are_there(description: &ModelDescription, content: &Content) -> bool {
    let named = description.interfaces().any(|(_, interface)| !interface.source_files.is_empty());
    named || content.files.contains_key(BUILD)
}

pub(super) fn check(
    problems: &mut Vec<Problem>,
    description: &ModelDescription,
    content: &mut Content,
    limits: &Limits,
) {
    let version = description.fmi_version;
    let mut found = Found { version, problems, folders: BTreeSet::from([String::new()]) };
    let mut named: BTreeSet<String> =
        description.interfaces().flat_map(|(_, i)| &i.source_files).cloned().collect();
    for file in named.iter().filter(|file| !content.files.contains_key(&below(file))) {
        let rule = "every <File> of <SourceFiles> must be below sources/";
        found.error(
            &below(file),
            "there is no such file".into(),
            rule,
            "add it or remove it from the list",
        );
    }
    let has_folder = content.files.keys().any(|path| path.starts_with("sources/"));
    match content.read(BUILD, limits.xml.bytes as u64) {
        Some(Ok(bytes)) => named.extend(found.build(&bytes, description, content, limits)),
        Some(Err(message)) => {
            found.error(
                BUILD,
                format!("it cannot be read: {message}"),
                "it says how to build",
                "pack the FMU again",
            );
        }
        None if version == FmiVersion::V3 && has_folder => {
            let rule = "a folder sources must tell how to build them";
            found.error(BUILD, "there is no such file".into(), rule, "add it");
        }
        None => {}
    }
    found.includes(named, content);
    let shipped = |path: &&String| {
        path.strip_prefix("sources/")
            .is_some_and(|path| HEADERS.iter().any(|h| path.rsplit('/').next() == Some(h)))
    };
    for path in content.files.keys().filter(shipped) {
        let rule = "the headers of the standard are the importer's: a copy defeats its prefix for function names";
        found.warning(path, "the FMU has its own copy".into(), rule, "leave it out");
    }
}

struct Found<'a> {
    version: FmiVersion,
    problems: &'a mut Vec<Problem>,
    /// Where includes are looked for, below `sources/`, with a slash at the end.
    folders: BTreeSet<String>,
}

impl Found<'_> {
    fn problem(&self, file: &str, found: String, rule: &str, way_out: &str) -> Problem {
        Problem::in_entry(self.version, Topic::Distribution, file, found)
            .rule(rule)
            .way_out(way_out)
    }

    fn error(&mut self, file: &str, found: String, rule: &str, way_out: &str) {
        let problem = self.problem(file, found, rule, way_out);
        self.problems.push(problem);
    }

    fn warning(&mut self, file: &str, found: String, rule: &str, way_out: &str) {
        let problem = self.problem(file, found, rule, way_out).warning();
        self.problems.push(problem);
    }

    /// The files that a build description names.
    fn build(
        &mut self,
        bytes: &[u8],
        description: &ModelDescription,
        content: &Content,
        limits: &Limits,
    ) -> Vec<String> {
        let document = match xml::parse(bytes, &limits.xml) {
            Ok(document) if document.root.name == "fmiBuildDescription" => document,
            Ok(document) => {
                let found = format!("its root is <{}>", document.root.name);
                self.error(BUILD, found, "the root is <fmiBuildDescription>", "name it so");
                return Vec::new();
            }
            Err(error) => {
                self.error(BUILD, error.to_string(), "it is well-formed XML", "write it anew");
                return Vec::new();
            }
        };
        let configurations =
            document.root.children.iter().filter(|c| c.name == "BuildConfiguration");
        let mut files = Vec::new();
        let mut built = BTreeSet::new();
        for configuration in configurations {
            built.insert(configuration.attribute("modelIdentifier").unwrap_or_default());
            for set in configuration.children.iter().filter(|c| c.name == "SourceFileSet") {
                let names = |kind: &str| {
                    let all = set.children.iter().filter(move |c| c.name == kind);
                    all.filter_map(|c| c.attribute("name")).map(str::to_owned).collect::<Vec<_>>()
                };
                let directories = names("IncludeDirectory").into_iter();
                self.folders
                    .extend(directories.map(|name| format!("{}/", name.trim_end_matches('/'))));
                files.extend(names("SourceFile"));
            }
        }
        for (_, interface) in description.interfaces() {
            let identifier = interface.model_identifier.as_str();
            // Told once, where two interfaces have it.
            if built.insert(identifier) {
                let found = format!("no <BuildConfiguration> has modelIdentifier=\"{identifier}\"");
                self.error(
                    BUILD,
                    found,
                    "each modelIdentifier of the description is built",
                    "add one",
                );
            }
        }
        for file in files.iter().filter(|file| !content.files.contains_key(&below(file))) {
            let rule = "every <SourceFile> must be below sources/";
            self.error(
                &below(file),
                "there is no such file".into(),
                rule,
                "add it or remove it from the list",
            );
        }
        files
    }

    /// Follows `#include "…"` from these files on.
    fn includes(&mut self, named: BTreeSet<String>, content: &mut Content) {
        let mut seen = named.clone();
        let mut open: Vec<String> = named.into_iter().collect();
        while let Some(file) = open.pop() {
            let Some(Ok(bytes)) = content.read(&below(&file), LARGEST_SOURCE) else { continue };
            let folder =
                file.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
            for name in included(&bytes) {
                let tried = self.folders.iter().chain([&folder]);
                let paths = tried.filter_map(|folder| joined(folder, &name));
                let hit = paths.into_iter().find(|path| content.files.contains_key(&below(path)));
                match hit {
                    Some(path) if seen.insert(path.clone()) => open.push(path),
                    Some(_) => {}
                    None if HEADERS.contains(&name.as_str()) || OF_C.contains(&name.as_str()) => {}
                    None => {
                        let found = format!("it includes \"{name}\", which is not there");
                        let rule = "sources must be complete but for the headers of the standard";
                        self.warning(
                            &below(&file),
                            found,
                            rule,
                            "add the file, unless no compiler reaches that line",
                        );
                    }
                }
            }
        }
    }
}

fn below(file: &str) -> String {
    format!("sources/{file}")
}

/// The files that `#include "…"` names.
fn included(bytes: &[u8]) -> BTreeSet<String> {
    let lines = bytes.split(|byte| *byte == b'\n').filter_map(|line| {
        let rest = line
            .trim_ascii_start()
            .strip_prefix(b"#")?
            .trim_ascii_start()
            .strip_prefix(b"include")?;
        let name = rest.trim_ascii_start().strip_prefix(b"\"")?;
        let end = name.iter().position(|byte| *byte == b'"')?;
        String::from_utf8(name[..end].to_vec()).ok()
    });
    lines.collect()
}

/// The path of a file in a folder, `..` followed; none outside of `sources/`.
fn joined(folder: &str, name: &str) -> Option<String> {
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(name.split('/')) {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}
