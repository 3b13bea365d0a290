//! Shared libraries: for the right platform, exporting the functions of the standard.

use std::collections::HashSet;

use object::{Architecture, BinaryFormat, NameOrOrdinal, Object, ObjectKind};

use crate::package::Platform;

/// What was found, the rule and the way out.
pub(super) type Fault = (String, String, String);

/// What is wrong with a library that should serve this platform and export these functions.
pub(super) fn faults(library: &[u8], platform: Platform, required: &[&str]) -> Vec<Fault> {
    let wanted = wanted(platform);
    // A universal library of macOS holds one library per architecture.
    let slice = match universal_slice(library, wanted.architecture) {
        Some(Some(slice)) => slice,
        Some(None) => {
            let found = format!("the universal library has no part for {}", platform.tuple);
            return vec![fault(found, "it must fit its folder", "add that architecture")];
        }
        None => library,
    };
    let parsed = match object::File::parse(slice) {
        Ok(parsed) => parsed,
        Err(error) => {
            let found = format!("the file is no library: {error}");
            let rule = format!("it must be a shared library ({})", wanted.name);
            return vec![fault(found, &rule, "add the library that was built for this platform")];
        }
    };
    let mut faults = Vec::new();
    if parsed.format() != wanted.format || parsed.architecture() != wanted.architecture {
        let found = format!(
            "the library is {:?} for {:?}, not {}",
            parsed.format(),
            parsed.architecture(),
            wanted.name
        );
        let way_out = "put it into the folder of its platform";
        faults.push(fault(found, "it must fit its folder", way_out));
    }
    if !matches!(parsed.kind(), ObjectKind::Dynamic) {
        let found = format!("the file is of kind {:?}", parsed.kind());
        faults.push(fault(found, "it must be a shared library", "link it as one"));
    }
    faults.extend(missing_functions(&parsed, required));
    faults
}

fn fault(found: String, rule: &str, way_out: &str) -> Fault {
    (found, rule.to_owned(), way_out.to_owned())
}

fn missing_functions(library: &object::File<'_>, required: &[&str]) -> Option<Fault> {
    let exports = match library.exports() {
        Ok(exports) => exports,
        Err(error) => return Some(not_listed(&error)),
    };
    let mut exported = HashSet::new();
    for export in exports {
        match export {
            Ok(export) => {
                // Functions without a name cannot be found by it.
                if let NameOrOrdinal::Name(name) = export.name() {
                    exported.insert(plain(library, name).to_vec());
                }
            }
            Err(error) => return Some(not_listed(&error)),
        }
    }
    let missing: Vec<&str> =
        required.iter().copied().filter(|name| !exported.contains(name.as_bytes())).collect();
    if missing.is_empty() {
        return None;
    }
    let found = format!("the library does not export {}", missing.join(", "));
    let rule = "all functions of the interface type must be present, also those for capabilities \
                that are not offered";
    Some(fault(found, rule, "export them"))
}

fn not_listed(error: &object::Error) -> Fault {
    let found = format!("its exported functions cannot be listed: {error}");
    fault(found, "the library must be intact", "build it again")
}

/// The name as it stands in C; on macOS an underscore is put in front.
fn plain<'a>(library: &object::File<'_>, name: &'a [u8]) -> &'a [u8] {
    match (library.format(), name) {
        (BinaryFormat::MachO, [b'_', rest @ ..]) => rest,
        _ => name,
    }
}

/// What a library of a platform looks like.
struct Wanted {
    format: BinaryFormat,
    architecture: Architecture,
    name: String,
}

fn wanted(platform: Platform) -> Wanted {
    let (machine, system) = platform.tuple.split_once('-').unwrap_or_default();
    let (format, name) = match system {
        "windows" => (BinaryFormat::Pe, "PE"),
        "darwin" => (BinaryFormat::MachO, "Mach-O"),
        _ => (BinaryFormat::Elf, "ELF"),
    };
    let architecture = match machine {
        "aarch64" => Architecture::Aarch64,
        "aarch32" => Architecture::Arm,
        "x86" => Architecture::I386,
        _ => Architecture::X86_64,
    };
    Wanted { format, architecture, name: format!("{name} for {machine}") }
}

/// The part of a universal Mach-O library for an architecture; None if it is no such library.
fn universal_slice(library: &[u8], architecture: Architecture) -> Option<Option<&[u8]>> {
    use object::read::macho::{FatArch, MachOFatFile32};
    let universal = MachOFatFile32::parse(library).ok()?;
    let part = universal.arches().iter().find(|part| part.architecture() == architecture);
    Some(part.and_then(|part| part.data(library).ok()))
}
