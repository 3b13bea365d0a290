//! Packing and opening FMUs, hostile ones included.

mod common;

use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use common::{fmpy_problems, library, python, stage};
use modeldescription::description::*;
use modeldescription::package::{EntryDefect, Limits, Platform, file_uri};
use modeldescription::{FmiVersion, Package, PackageBuilder, PackageError, required_functions};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

fn host_folder(version: FmiVersion) -> &'static str {
    Platform::host().unwrap().folder(version)
}

fn packed(version: FmiVersion) -> PackageBuilder {
    let mut fmu = PackageBuilder::new(&stage(version)).unwrap();
    fmu.binary(host_folder(version), b"no library".to_vec()).unwrap();
    fmu.binary("win64", b"no library".to_vec()).unwrap();
    fmu.resource("blueprint.toml", b"plays = 10".to_vec()).unwrap();
    fmu.documentation("index.html", b"<html/>".to_vec()).unwrap();
    fmu.license("license.txt", b"MIT".to_vec()).unwrap();
    fmu.extra("org.piezoloop/notes.txt", b"hm".to_vec()).unwrap();
    fmu
}

/// An archive whose entries are the test's; a valid description comes first.
fn archive(folder: &Path, add: impl Fn(&mut ZipWriter<Cursor<Vec<u8>>>)) -> PathBuf {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file("modelDescription.xml", SimpleFileOptions::default()).unwrap();
    zip.write_all(stage(FmiVersion::V2).to_xml().unwrap().as_bytes()).unwrap();
    add(&mut zip);
    let path = folder.join("hostile.fmu");
    fs::write(&path, zip.finish().unwrap().into_inner()).unwrap();
    path
}

fn file(zip: &mut ZipWriter<Cursor<Vec<u8>>>, name: &str, content: &[u8]) {
    zip.start_file(name, SimpleFileOptions::default()).unwrap();
    zip.write_all(content).unwrap();
}

/// Replaces a name in the bytes of an archive; the zip writer would not write it.
fn rename(path: &Path, from: &str, to: &str) {
    assert_eq!(from.len(), to.len());
    let mut bytes = fs::read(path).unwrap();
    let places: Vec<usize> =
        (0..bytes.len()).filter(|&i| bytes[i..].starts_with(from.as_bytes())).collect();
    assert_eq!(places.len(), 2, "local and central header");
    for place in places {
        bytes[place..place + to.len()].copy_from_slice(to.as_bytes());
    }
    fs::write(path, bytes).unwrap();
}

fn refusal(path: &Path) -> (String, EntryDefect) {
    let before = everything_below(path.parent().unwrap());
    let error = Package::open(path).unwrap_err();
    assert!(error.to_string().contains("hostile.fmu"), "{error}");
    assert_eq!(everything_below(path.parent().unwrap()), before, "something was written");
    match error {
        PackageError::Entry { entry, defect, .. } => (entry, defect),
        other => panic!("{other}"),
    }
}

fn everything_below(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    let below: Vec<_> =
        paths.iter().filter(|p| p.is_dir()).flat_map(|p| everything_below(p)).collect();
    paths.extend(below);
    paths.sort();
    paths
}

#[test]
fn what_is_packed_is_found_again() {
    let folder = tempfile::tempdir().unwrap();
    for version in [FmiVersion::V2, FmiVersion::V3] {
        let path = folder.path().join("stage.fmu");
        packed(version).write(&path).unwrap();
        let package = Package::open(&path).unwrap();
        assert_eq!(package.description(), &stage(version));
        let binary = package.binary().unwrap();
        assert!(binary.is_absolute());
        assert_eq!(fs::read(&binary).unwrap(), b"no library");
        assert_eq!(binary.file_stem().unwrap(), "stage");
        let blueprint = package.resources().join("blueprint.toml");
        assert_eq!(fs::read(blueprint).unwrap(), b"plays = 10");
        assert!(package.resources_uri().starts_with("file:///"));
        let unpacked = package.folder().to_owned();
        drop(package);
        assert!(!unpacked.exists(), "the temporary folder is still there");
    }
}

#[test]
fn folders_are_those_of_the_version() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.fmu");
    packed(FmiVersion::V2).write(&path).unwrap();
    let two = Package::open(&path).unwrap();
    assert!(two.folder().join("binaries/win64/stage.dll").is_file());
    assert!(two.folder().join("licenses/license.txt").is_file());
    packed(FmiVersion::V3).write(&path).unwrap();
    let three = Package::open(&path).unwrap();
    assert!(three.folder().join("binaries/x86_64-windows/stage.dll").is_file());
    assert!(three.folder().join("documentation/licenses/license.txt").is_file());
}

#[test]
fn the_same_content_gives_the_same_bytes() {
    let first = packed(FmiVersion::V2).to_bytes().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(2100));
    assert!(first == packed(FmiVersion::V2).to_bytes().unwrap());
}

#[test]
fn archives_keep_to_the_rules_of_the_zip_format() {
    let bytes = packed(FmiVersion::V2).to_bytes().unwrap();
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    assert_eq!(zip.by_index_data(0).unwrap().name().unwrap(), "modelDescription.xml");
    for index in 0..zip.len() {
        let entry = zip.by_index_data(index).unwrap();
        let name = entry.name().unwrap().into_owned();
        assert!(entry.version_needed() <= 20, "{name}: {}", entry.version_needed());
        assert!(!entry.flags().is_using_data_descriptor(), "{name}");
        assert!(!name.contains('\\') && !entry.is_symlink(), "{name}");
    }
    assert!(zip.by_name("resources/").is_err(), "the folder has a file");
    let bare = PackageBuilder::new(&stage(FmiVersion::V2)).unwrap().to_bytes().unwrap();
    let mut zip = zip::ZipArchive::new(Cursor::new(bare)).unwrap();
    assert!(zip.by_name("resources/").unwrap().is_dir());
}

#[test]
fn fmpy_accepts_the_package() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    for version in [FmiVersion::V2, FmiVersion::V3] {
        let path = folder.path().join("stage.fmu");
        packed(version).write(&path).unwrap();
        assert_eq!(fmpy_problems(&python, &path), "");
    }
}

#[test]
fn packing_refuses_bad_names() {
    let mut fmu = packed(FmiVersion::V2);
    for name in [
        "../x",
        "/x",
        "a//b",
        "a\\b",
        "C:x",
        "./x",
        "",
        "a/",
        "modelDescription.xml",
        "resources/blueprint.toml",
        "resources/blueprint.toml/x",
        "resources",
    ] {
        let error = fmu.entry(name, Vec::new()).unwrap_err();
        assert!(matches!(error, PackageError::Name { .. }), "{name}: {error}");
    }
    let error = fmu.binary("vax", Vec::new()).unwrap_err().to_string();
    assert!(error.contains("vax") && error.contains("linux64"), "{error}");
}

#[test]
fn writing_replaces_the_complete_file_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.fmu");
    fs::write(&path, "old").unwrap();
    packed(FmiVersion::V2).write(&path).unwrap();
    assert_eq!(everything_below(folder.path()), [path]);
    let nowhere = folder.path().join("no/such/folder/stage.fmu");
    let error = packed(FmiVersion::V2).write(&nowhere).unwrap_err();
    assert!(error.to_string().contains("no/such/folder"), "{error}");
}

#[test]
fn names_that_lead_outside_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, defect) in [
        ("../../../../evil.txt", EntryDefect::Traversal),
        ("a/b/../../../ev.txt.", EntryDefect::Traversal),
        ("..\\..\\..\\..\\evil.txt", EntryDefect::Traversal),
        ("/tmp/evil/evil/e.txt", EntryDefect::Absolute),
        ("C:\\evil\\evil\\e.txt.", EntryDefect::DriveLetter),
    ] {
        let placeholder = "x".repeat(name.len());
        let path = archive(folder.path(), |zip| file(zip, &placeholder, b"evil"));
        rename(&path, &placeholder, name);
        assert_eq!(refusal(&path), (name.to_owned(), defect));
    }
}

#[test]
fn links_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = archive(folder.path(), |zip| {
        zip.add_symlink("resources", "/etc", SimpleFileOptions::default()).unwrap();
    });
    assert_eq!(refusal(&path), ("resources".to_owned(), EntryDefect::SymbolicLink));
}

#[test]
fn the_same_name_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = archive(folder.path(), |zip| {
        file(zip, "resources/a.txt", b"one");
        file(zip, "resources/b.txt", b"two");
    });
    rename(&path, "resources/b.txt", "resources/a.txt");
    assert_eq!(refusal(&path), ("resources/a.txt".to_owned(), EntryDefect::Duplicate));
    let path = archive(folder.path(), |zip| {
        file(zip, "resources/a.txt", b"one");
        file(zip, "resources//a.txt", b"two");
    });
    assert_eq!(refusal(&path), ("resources//a.txt".to_owned(), EntryDefect::Duplicate));
    let path = archive(folder.path(), |zip| {
        file(zip, "resources/a", b"one");
        file(zip, "resources/a/b", b"two");
    });
    assert_eq!(refusal(&path), ("resources/a/b".to_owned(), EntryDefect::FileAndFolder));
}

#[test]
fn encrypted_entries_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = archive(folder.path(), |zip| file(zip, "resources/secret.bin", b"secret"));
    let mut bytes = fs::read(&path).unwrap();
    set_in_headers(&mut bytes, "resources/secret.bin", (6, 8), 1);
    fs::write(&path, bytes).unwrap();
    assert_eq!(refusal(&path), ("resources/secret.bin".to_owned(), EntryDefect::Encrypted));
}

#[test]
fn other_compression_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = archive(folder.path(), |zip| file(zip, "resources/packed.bin", b"packed"));
    let mut bytes = fs::read(&path).unwrap();
    set_in_headers(&mut bytes, "resources/packed.bin", (8, 10), 14);
    fs::write(&path, bytes).unwrap();
    let defect = EntryDefect::Compression { method: "LZMA".to_owned() };
    assert_eq!(refusal(&path), ("resources/packed.bin".to_owned(), defect));
}

/// Sets a byte in the local and in the central header of an entry (APPNOTE 4.3.7, 4.3.12).
fn set_in_headers(bytes: &mut [u8], name: &str, (local, central): (usize, usize), value: u8) {
    for at in 0..bytes.len() {
        if bytes[at..].starts_with(name.as_bytes()) {
            if at >= 30 && bytes[at - 30..].starts_with(b"PK\x03\x04") {
                bytes[at - 30 + local] = value;
            } else if at >= 46 && bytes[at - 46..].starts_with(b"PK\x01\x02") {
                bytes[at - 46 + central] = value;
            }
        }
    }
}

#[test]
fn cut_off_archives_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let complete = packed(FmiVersion::V2).to_bytes().unwrap();
    let path = folder.path().join("cut.fmu");
    for length in [0, 3, complete.len() / 2, complete.len() - 1] {
        fs::write(&path, &complete[..length]).unwrap();
        let error = Package::open(&path).unwrap_err();
        assert!(matches!(error, PackageError::NotAnArchive { .. }), "{length}: {error}");
        assert!(error.to_string().contains("cut.fmu"), "{error}");
    }
}

#[test]
fn damaged_content_is_refused_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = archive(folder.path(), |zip| {
        let stored =
            SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        zip.start_file("resources/table.bin", stored).unwrap();
        zip.write_all(b"0123456789").unwrap();
    });
    let mut bytes = fs::read(&path).unwrap();
    let at = bytes.windows(10).position(|w| w == b"0123456789").unwrap();
    bytes[at] = b'9';
    fs::write(&path, bytes).unwrap();
    let (entry, defect) = refusal(&path);
    assert_eq!(entry, "resources/table.bin");
    assert!(matches!(defect, EntryDefect::Broken { .. }), "{defect}");
}

#[test]
fn bombs_are_refused_before_anything_is_unpacked() {
    let folder = tempfile::tempdir().unwrap();
    let path = archive(folder.path(), |zip| file(zip, "resources/zeros.bin", &vec![0; 2 << 20]));
    let dense = Limits { free_bytes: 1 << 20, ..Limits::default() };
    let large = Limits { total_bytes: 1 << 20, ..Limits::default() };
    let many = Limits { entries: 1, ..Limits::default() };
    for limits in [dense, large] {
        let error = Package::open_within(&path, &limits).unwrap_err();
        let text = error.to_string();
        let is_bomb = matches!(error, PackageError::Entry { defect: EntryDefect::Bomb { .. }, .. });
        assert!(is_bomb && text.contains("zeros.bin"), "{text}");
    }
    let error = Package::open_within(&path, &many).unwrap_err().to_string();
    assert!(error.contains("2 entries; at most 1"), "{error}");
    assert!(Package::open(&path).is_ok());
}

/// Of little packed XML many times as much memory is made where it is read.
#[test]
fn dense_xml_is_refused_in_an_archive_and_read_in_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let many = format!("<a>{}</a>", "<a/>".repeat(1 << 19));
    let path = archive(folder.path(), |zip| file(zip, "extra/many.xml", many.as_bytes()));
    assert!(fs::metadata(&path).unwrap().len() < 64 << 10);
    let error = Package::open(&path).unwrap_err();
    let text = error.to_string();
    let is_dense = matches!(error, PackageError::Entry { defect: EntryDefect::Dense { .. }, .. });
    assert!(is_dense && text.contains("more than 100 times") && text.contains("unpack"), "{text}");
    // One megabyte may be as dense as it likes.
    let few = "<a/>".repeat(1 << 18);
    let path = archive(folder.path(), |zip| file(zip, "extra/few.xml", few.as_bytes()));
    assert!(Package::open(&path).is_ok());
}

/// An entry that says it is small and is not: no more is unpacked than it says.
#[test]
fn an_entry_that_lies_about_its_size_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = archive(folder.path(), |zip| file(zip, "resources/zeros.bin", &vec![0; 1 << 20]));
    let mut bytes = fs::read(&path).unwrap();
    for byte in 0..4 {
        let value = if byte == 0 { 10 } else { 0 };
        set_in_headers(&mut bytes, "resources/zeros.bin", (22 + byte, 24 + byte), value);
    }
    fs::write(&path, bytes).unwrap();
    let (entry, defect) = refusal(&path);
    assert_eq!(entry, "resources/zeros.bin");
    assert!(matches!(defect, EntryDefect::Broken { .. }), "{defect}");
}

#[test]
fn a_hostile_description_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hostile.fmu");
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let xml = b"<!DOCTYPE a [<!ENTITY x \"ha\">]><fmiModelDescription/>";
    file(&mut zip, "modelDescription.xml", xml);
    fs::write(&path, zip.finish().unwrap().into_inner()).unwrap();
    let error = Package::open(&path).unwrap_err().to_string();
    assert!(error.contains("hostile.fmu") && error.contains("DOCTYPE"), "{error}");
}

#[test]
fn a_zipped_folder_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.fmu");
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    file(&mut zip, "stage/modelDescription.xml", b"<fmiModelDescription/>");
    fs::write(&path, zip.finish().unwrap().into_inner()).unwrap();
    let error = Package::open(&path).unwrap_err().to_string();
    assert!(error.contains("stage/modelDescription.xml"), "{error}");
    let nothing = Package::open(folder.path().join("nothing.fmu")).unwrap_err().to_string();
    assert!(nothing.contains("cannot read") && nothing.contains("nothing.fmu"), "{nothing}");
}

#[test]
fn a_missing_binary_names_those_that_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.fmu");
    let mut fmu = PackageBuilder::new(&stage(FmiVersion::V2)).unwrap();
    fmu.binary("win32", Vec::new()).unwrap().binary("darwin64", Vec::new()).unwrap();
    fmu.write(&path).unwrap();
    if ["win32", "darwin64"].contains(&host_folder(FmiVersion::V2)) {
        return;
    }
    let error = Package::open(&path).unwrap().binary().unwrap_err().to_string();
    assert!(error.contains("binaries for darwin64, win32"), "{error}");
    assert!(error.contains(host_folder(FmiVersion::V2)), "{error}");
}

#[test]
fn an_unpacked_folder_is_read_where_it_lies() {
    let folder = tempfile::tempdir().unwrap();
    let below = folder.path().join("Stage é %20");
    fs::create_dir(&below).unwrap();
    fs::write(below.join("modelDescription.xml"), stage(FmiVersion::V2).to_xml().unwrap()).unwrap();
    let package = Package::open(&below).unwrap();
    assert_eq!(package.folder(), below);
    assert!(package.resources_uri().ends_with("/Stage%20%C3%A9%20%2520/resources"));
    drop(package);
    assert!(below.exists());
}

#[cfg(unix)]
#[test]
fn uris_are_percent_encoded() {
    assert_eq!(file_uri(Path::new("/a b/ü#%?.x~_-")), "file:///a%20b/%C3%BC%23%25%3F.x~_-");
}

/// FMI 2.0 packages that name the platform as FMI 3.0 does are common.
#[test]
fn folders_of_the_other_version_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let platform = Platform::host().unwrap();
    let binaries = folder.path().join("binaries").join(platform.tuple);
    fs::create_dir_all(&binaries).unwrap();
    let library = binaries.join(format!("stage.{}", platform.extension));
    fs::write(&library, "").unwrap();
    let xml = stage(FmiVersion::V2).to_xml().unwrap();
    fs::write(folder.path().join("modelDescription.xml"), xml).unwrap();
    assert_eq!(Package::open(folder.path()).unwrap().binary().unwrap(), library);
}

#[test]
fn a_model_exchange_fmu_has_a_binary_too() {
    let mut description = stage(FmiVersion::V2);
    let common = description.co_simulation.take().unwrap().common;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.fmu");
    PackageBuilder::new(&description).unwrap().write(&path).unwrap();
    let error = Package::open(&path).unwrap().binary().unwrap_err();
    assert!(matches!(error, PackageError::NoInterface { .. }), "{error}");
    description.model_exchange = Some(ModelExchange { common, ..ModelExchange::default() });
    let mut fmu = PackageBuilder::new(&description).unwrap();
    fmu.binary(host_folder(FmiVersion::V2), Vec::new()).unwrap().write(&path).unwrap();
    assert!(Package::open(&path).unwrap().binary().is_ok());
}

/// Whatever the bytes: an answer, never a panic, and nothing outside the temporary folder.
#[test]
fn damaged_archives_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.fmu");
    let description = stage(FmiVersion::V2);
    let mut fmu = PackageBuilder::new(&description).unwrap();
    let functions = library(&required_functions(&description));
    fmu.binary(host_folder(FmiVersion::V2), functions).unwrap();
    fmu.resource("blueprint.toml", b"plays = 10".to_vec()).unwrap();
    let complete = fmu.to_bytes().unwrap();
    let mut random = 0x2545_f491_4f6c_dd1d_u64;
    let mut next = |below: usize| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % below as u64) as usize
    };
    let (mut opened, mut refused) = (0, 0);
    for _ in 0..600 {
        let mut bytes = complete.clone();
        for _ in 0..=next(4) {
            // Half of the damage goes to the central directory at the end.
            let from = if next(2) == 0 { bytes.len() - 400 } else { 0 };
            let at = from + next(bytes.len() - from);
            bytes[at] = next(256) as u8;
        }
        fs::write(&path, &bytes).unwrap();
        let checked = modeldescription::check(&path);
        match Package::open(&path) {
            Ok(_) => opened += 1,
            Err(_) => {
                refused += 1;
                assert!(!checked.unwrap().is_empty(), "check finds nothing");
            }
        }
        assert_eq!(everything_below(folder.path()), std::slice::from_ref(&path));
    }
    assert!(opened > 10 && refused > 100, "{opened} opened, {refused} refused");
}
