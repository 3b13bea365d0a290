//! The checker finds each single defect, names it, and is silent about valid FMUs.
//!
//! The defects are the rows of the detection matrix in which established checkers were compared on 43
//! FMUs with one defect each, and more of the same kind.

mod common;

use std::fs;
use std::io::{Cursor, Write};
use std::sync::OnceLock;

use common::{library, stage, stage_3};
use modeldescription::package::Platform;
use modeldescription::{
    FmiVersion, ModelDescription, PackageBuilder, Problem, Severity, check, check_description,
    required_functions,
};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

fn complete_library() -> Vec<u8> {
    static LIBRARY: OnceLock<Vec<u8>> = OnceLock::new();
    let functions = || {
        let [two, three] = [stage(FmiVersion::V2), stage(FmiVersion::V3)];
        [required_functions(&two), required_functions(&three)].concat()
    };
    LIBRARY.get_or_init(|| library(&functions())).clone()
}

fn platform_folder(version: FmiVersion) -> &'static str {
    Platform::host().unwrap().folder(version)
}

/// A valid FMU with everything the standard asks for.
fn valid(description: &ModelDescription) -> PackageBuilder {
    let mut fmu = PackageBuilder::new(description).unwrap();
    fmu.binary(platform_folder(description.fmi_version), complete_library()).unwrap();
    fmu.resource("blueprint.toml", b"plays = 10".to_vec()).unwrap();
    fmu.documentation("index.html", b"<html/>".to_vec()).unwrap();
    fmu.license("license.txt", b"MIT".to_vec()).unwrap();
    fmu
}

fn problems_of_bytes(bytes: &[u8]) -> Vec<Problem> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.fmu");
    fs::write(&path, bytes).unwrap();
    check(&path).unwrap()
}

/// The archive with another description.
fn with_description(bytes: &[u8], xml: &str) -> Vec<u8> {
    repacked(bytes, |name, content| {
        let content =
            if name == "modelDescription.xml" { xml.as_bytes().to_vec() } else { content };
        Some((name.to_owned(), content))
    })
}

/// The archive with each entry changed, or left out.
fn repacked(bytes: &[u8], change: impl Fn(&str, Vec<u8>) -> Option<(String, Vec<u8>)>) -> Vec<u8> {
    let mut old = ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut new = ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..old.len() {
        let mut entry = old.by_index(index).unwrap();
        let mut content = Vec::new();
        std::io::copy(&mut entry, &mut content).unwrap();
        let name = entry.name().unwrap().into_owned();
        if let Some((name, content)) = change(&name, content) {
            new.start_file(name, SimpleFileOptions::default()).unwrap();
            new.write_all(&content).unwrap();
        }
    }
    new.finish().unwrap().into_inner()
}

fn listing(problems: &[Problem]) -> String {
    problems.iter().map(|problem| format!("{problem}\n")).collect()
}

/// Exactly one problem, that says this, and an error with a rule, a way out and a section.
fn assert_found(defect: &str, problems: &[Problem], says: &str) {
    let [problem] = problems else {
        panic!("{defect}: not one problem but {}:\n{}", problems.len(), listing(problems));
    };
    let text = problem.to_string();
    assert!(text.contains(says), "{defect}: {says:?} is not in {text}");
    assert!(!problem.rule.is_empty() && !problem.way_out.is_empty(), "{defect}: {text}");
    assert!(problem.section.starts_with("FMI "), "{defect}: {text}");
    assert_eq!(problem.severity, Severity::Error, "{defect}: {text}");
}

#[test]
fn valid_fmus_have_no_problem() {
    for description in [stage(FmiVersion::V2), stage(FmiVersion::V3), stage_3()] {
        let found = problems_of_bytes(&valid(&description).to_bytes().unwrap());
        assert!(found.is_empty(), "{}", listing(&found));
    }
}

/// Defects of the model description: a name, the text that is replaced, its replacement, and what the
/// problem says.
type XmlDefect = (&'static str, &'static str, &'static str, &'static str);

const MATRIX: [XmlDefect; 37] = [
    (
        "output missing in Outputs",
        "      <Unknown index=\"8\" dependencies=\"\"/>\n",
        "",
        "Outputs lacks \"mode\" (index 8)",
    ),
    (
        "variable that is no output in Outputs",
        "<Unknown index=\"8\" dependencies=\"\"/>\n",
        "<Unknown index=\"8\" dependencies=\"\"/><Unknown index=\"9\" dependencies=\"\"/>",
        "Outputs has \"axis[1].'velocity #1'\" (index 9) of causality local",
    ),
    (
        "InitialUnknowns incomplete",
        "<Unknown index=\"4\"/>",
        "",
        "InitialUnknowns lacks \"axis[1].stiffness\"",
    ),
    (
        "InitialUnknowns with an input",
        "    <InitialUnknowns>\n",
        "    <InitialUnknowns>\n<Unknown index=\"1\"/>",
        "InitialUnknowns has \"axis[1].command\" (index 1) of causality input",
    ),
    (
        "InitialUnknowns unordered",
        "<Unknown index=\"2\"/>\n      <Unknown index=\"4\"/>",
        "<Unknown index=\"4\"/><Unknown index=\"2\"/>",
        "index 2 after index 4",
    ),
    (
        "InitialUnknowns with a duplicate",
        "<Unknown index=\"4\"/>",
        "<Unknown index=\"4\"/><Unknown index=\"4\"/>",
        "InitialUnknowns has \"axis[1].stiffness\" (index 4) twice",
    ),
    (
        "input with initial",
        "causality=\"input\" variability=\"continuous\"",
        "causality=\"input\" variability=\"continuous\" initial=\"exact\"",
        "causality input must not state initial",
    ),
    (
        "input without start",
        "max=\"120.0\" start=\"0.0\"",
        "max=\"120.0\"",
        "\"axis[1].command\" has no start value",
    ),
    (
        "exact without start",
        "<Real start=\"-1.5e-300\"/>",
        "<Real/>",
        "initial exact must have a start value",
    ),
    (
        "calculated with start",
        "<Real unit=\"N/m\"/>",
        "<Real unit=\"N/m\" start=\"1\"/>",
        "initial calculated must have no start value",
    ),
    (
        "continuous parameter",
        "causality=\"parameter\" variability=\"tunable\"",
        "causality=\"parameter\" variability=\"continuous\"",
        "causality parameter allows variability fixed, tunable",
    ),
    (
        "String with the default variability",
        "name=\"label\" valueReference=\"7\" causality=\"parameter\" variability=\"fixed\"",
        "name=\"label\" valueReference=\"7\" initial=\"exact\"",
        "of type String has variability=\"continuous\" (the default)",
    ),
    ("undefined unit", "<Real unit=\"N/m\"/>", "<Real unit=\"N/mm\"/>", "unit=\"N/mm\""),
    ("undefined displayUnit", "displayUnit=\"nm\"", "displayUnit=\"pm\"", "displayUnit=\"pm\""),
    (
        "duplicate name",
        "name=\"enabled\"",
        "name=\"plays\"",
        "\"plays\" is there twice, first at line 48",
    ),
    ("illegal structured name", "name=\"plays\"", "name=\"plays[x]\"", "a digit is expected here"),
    (
        "min above max",
        "<Real unit=\"N/m\"/>",
        "<Real unit=\"N/m\" min=\"2\" max=\"1\"/>",
        "min must not exceed max",
    ),
    (
        "start below min",
        "max=\"120.0\" start=\"0.0\"",
        "max=\"120.0\" start=\"-20.5\"",
        "from -20 to 120",
    ),
    ("start above max", "max=\"100\" start=\"10\"", "max=\"100\" start=\"101\"", "start=\"101\""),
    (
        "flag that is neither true nor false",
        "modelIdentifier=\"stage\"",
        "modelIdentifier=\"stage\" needsExecutionTool=\"yes\"",
        "needsExecutionTool=\"yes\"",
    ),
    (
        "dependencies out of range",
        "dependencies=\"1\" dependenciesKind",
        "dependencies=\"99\" dependenciesKind",
        "depends on index 99",
    ),
    (
        "two settable variables with one value reference",
        "valueReference=\"9\"",
        "valueReference=\"3\"",
        "at most one of several aliases",
    ),
    (
        "alias with another unit",
        "valueReference=\"4\"",
        "valueReference=\"2\"",
        "has the unit N/m, not um",
    ),
    ("stopTime before startTime", "startTime=\"0.0\"", "startTime=\"1.0\"", "is before startTime"),
    ("negative stepSize", "stepSize=\"5e-5\"", "stepSize=\"-5e-5\"", "it must be positive"),
    ("duplicate log category", "logEvents", "logStatusError", "\"logStatusError\" is there twice"),
    (
        "canSerializeFMUstate without canGetAndSetFMUstate",
        " canGetAndSetFMUstate=\"true\"",
        "",
        "canSerialize… requires canGetAndSet…",
    ),
    (
        "dependency on a fixed parameter in Outputs",
        "dependencies=\"1\" dependenciesKind=\"dependent\"",
        "dependencies=\"5\"",
        "depends on \"plays\" (index 5), a variable of causality parameter",
    ),
    (
        "dependencies unordered",
        "dependencies=\"1\" dependenciesKind=\"dependent\"",
        "dependencies=\"10 1\"",
        "depends on index 1 after 10",
    ),
    (
        "dependenciesKind of another length",
        "dependenciesKind=\"dependent\"",
        "dependenciesKind=\"dependent dependent\"",
        "has 1 dependencies and 2 kinds",
    ),
    (
        "dependenciesKind without dependencies",
        "dependencies=\"1\" dependenciesKind",
        "dependenciesKind",
        "dependenciesKind without dependencies",
    ),
    ("wrong fmiVersion", "fmiVersion=\"2.0\"", "fmiVersion=\"2.0.5\"", "must be \"2.0\""),
    ("no guid", " guid=\"0123456789abcdef\"", "", "guid is missing or empty"),
    (
        "impossible date",
        "2026-11-21T00:00:00Z",
        "2026-11-31T00:00:00Z",
        "it must be an xs:dateTime",
    ),
    (
        "independent variable with start",
        "<Real unit=\"s\"/>",
        "<Real unit=\"s\" start=\"0\"/>",
        "causality independent must have no start value",
    ),
    (
        "undefined type",
        "declaredType=\"Length\" displayUnit=\"nm\"",
        "declaredType=\"Width\"",
        "declaredType=\"Width\"",
    ),
    (
        "unknown attribute",
        "<Integer min",
        "<Integer unit=\"um\" min",
        "<Integer> has the attribute unit=\"um\"",
    ),
];

#[test]
fn each_defect_of_the_description_is_found() {
    let xml = stage(FmiVersion::V2).to_xml().unwrap();
    for (defect, from, to, says) in MATRIX {
        assert_eq!(xml.matches(from).count(), 1, "{defect}: {from}");
        let changed = xml.replacen(from, to, 1);
        let found = check_description(changed.as_bytes());
        assert_found(defect, &found, says);
        assert!(found[0].line.is_some(), "{defect}: {}", found[0]);
        let packed = with_description(&valid(&stage(FmiVersion::V2)).to_bytes().unwrap(), &changed);
        assert_found(defect, &problems_of_bytes(&packed), says);
    }
}

/// The line is that of the element with the defect.
#[test]
fn problems_name_the_line() {
    let xml = stage(FmiVersion::V2).to_xml().unwrap();
    let changed = xml.replacen("displayUnit=\"nm\"", "displayUnit=\"pm\"", 1);
    let line = 1 + changed.lines().position(|line| line.contains("axis[1].position")).unwrap();
    let [problem] = &check_description(changed.as_bytes())[..] else { panic!() };
    assert_eq!(problem.line, Some(line as u32));
    assert_eq!(problem.file, "modelDescription.xml");
    assert_eq!(problem.section, "FMI 2.0.5, 2.2.7");
    assert!(problem.to_string().starts_with(&format!("modelDescription.xml:{line}: error: ")));
    let json = serde_json::to_value(problem).unwrap();
    assert_eq!(json["severity"], "error");
    assert_eq!(json["line"], line);
}

#[test]
fn defects_of_the_binaries_are_found() {
    let fmu = stage(FmiVersion::V2);
    let folder = platform_folder(FmiVersion::V2);
    let binary = |content: Option<Vec<u8>>| {
        let bytes = valid(&fmu).to_bytes().unwrap();
        problems_of_bytes(&repacked(&bytes, |name, old| match (&content, name) {
            (None, name) if name.starts_with("binaries/") => None,
            (Some(new), name) if name.starts_with("binaries/") => {
                Some((name.to_owned(), new.clone()))
            }
            _ => Some((name.to_owned(), old)),
        }))
    };
    assert_found("no binary", &binary(None), "neither binaries nor sources");
    let garbage = binary(Some(b"this is no library".to_vec()));
    assert_found("garbage", &garbage, "the file is no library");
    assert!(garbage[0].file.starts_with(&format!("binaries/{folder}/stage.")), "{}", garbage[0]);
    let functions = required_functions(&fmu);
    let incomplete: Vec<&str> =
        functions.iter().copied().filter(|name| *name != "fmi2SerializeFMUstate").collect();
    assert_eq!(incomplete.len(), 33);
    let found = binary(Some(library(&incomplete)));
    assert_found("missing function", &found, "does not export fmi2SerializeFMUstate");
}

#[test]
fn a_library_in_the_folder_of_another_platform_is_found() {
    let mut fmu = valid(&stage(FmiVersion::V2));
    let other = ["win64", "linux64"].into_iter().find(|p| *p != platform_folder(FmiVersion::V2));
    fmu.binary(other.unwrap(), complete_library()).unwrap();
    let found = problems_of_bytes(&fmu.to_bytes().unwrap());
    assert_found("wrong platform", &found, "it must fit its folder");
}

#[test]
fn the_binary_must_have_the_name_of_the_model_identifier() {
    let bytes = valid(&stage(FmiVersion::V2)).to_bytes().unwrap();
    let renamed =
        repacked(&bytes, |name, content| Some((name.replace("/stage.", "/libstage."), content)));
    assert_found("other name", &problems_of_bytes(&renamed), "the folder has libstage.");
    let mut description = stage(FmiVersion::V2);
    description.co_simulation.as_mut().unwrap().common.model_identifier = "1-stage".to_owned();
    let found = problems_of_bytes(&valid(&description).to_bytes().unwrap());
    assert_found("no C identifier", &found, "it must be a C identifier");
}

/// Changes the raw bytes of a valid archive.
fn with_bytes(change: impl Fn(&mut Vec<u8>)) -> Vec<Problem> {
    let mut bytes = valid(&stage(FmiVersion::V2)).to_bytes().unwrap();
    change(&mut bytes);
    problems_of_bytes(&bytes)
}

/// Sets a byte in the local and in the central header of an entry (APPNOTE 4.3.7, 4.3.12).
fn set_in_headers(bytes: &mut [u8], name: &str, (local, central): (usize, usize), value: u8) {
    for at in 46..bytes.len() {
        if bytes[at..].starts_with(name.as_bytes()) {
            if bytes[at - 46..].starts_with(b"PK\x01\x02") {
                bytes[at - 46 + central] = value;
            } else if bytes[at - 30..].starts_with(b"PK\x03\x04") {
                bytes[at - 30 + local] = value;
            }
        }
    }
}

const ENTRY: &str = "resources/blueprint.toml";

fn rename(bytes: &mut [u8], to: &str) {
    assert_eq!(to.len(), ENTRY.len());
    for at in 0..bytes.len() - ENTRY.len() {
        if bytes[at..].starts_with(ENTRY.as_bytes()) {
            bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        }
    }
}

#[test]
fn defects_of_the_archive_are_found() {
    let found = with_bytes(|bytes| rename(bytes, "resources\\blueprint.toml"));
    assert_found("backslash", &found, "the name has a backslash");
    let found = with_bytes(|bytes| set_in_headers(bytes, ENTRY, (8, 10), 14));
    assert_found("LZMA", &found, "it is compressed by LZMA");
    let found = with_bytes(|bytes| set_in_headers(bytes, ENTRY, (6, 8), 1));
    assert_found("encrypted", &found, "it is encrypted");
    let found = with_bytes(|bytes| rename(bytes, "../../../etc/shadow.toml"));
    assert_found("traversal", &found, "may lead out of the FMU's folder");
    let found = with_bytes(|bytes| rename(bytes, "/etc/shadow.............."[..24].as_ref()));
    assert_found("absolute", &found, "absolute path");
    let found = with_bytes(|bytes| set_in_headers(bytes, ENTRY, (4, 6), 45));
    assert_found("zip64", &found, "version 4.5 of the zip format is needed");
    // The file type in the upper half of the external attributes: 0o120000 is a symbolic link.
    let found = with_bytes(|bytes| set_in_headers(bytes, ENTRY, (13, 41), 0xa1));
    assert_found("symbolic link", &found, "it is a symbolic link");
    // A byte of the checksum, in both headers.
    let found = with_bytes(|bytes| set_in_headers(bytes, ENTRY, (14, 16), 0x55));
    assert_found("damaged content", &found, "its content is damaged");
    let found = with_bytes(|bytes| bytes.truncate(bytes.len() / 2));
    assert_found("cut off", &found, "not a readable zip archive");
    let duplicate = {
        let mut fmu = valid(&stage(FmiVersion::V2));
        fmu.resource("blueprint.tom2", Vec::new()).unwrap();
        let mut bytes = fmu.to_bytes().unwrap();
        let twin = b"resources/blueprint.tom2";
        for at in 0..bytes.len() - twin.len() {
            if bytes[at..].starts_with(twin) {
                bytes[at..at + twin.len()].copy_from_slice(ENTRY.as_bytes());
            }
        }
        problems_of_bytes(&bytes)
    };
    assert_found("duplicate entry", &duplicate, "the name stands in the archive twice");
}

#[test]
fn the_description_must_be_at_the_root() {
    let bytes = valid(&stage(FmiVersion::V2)).to_bytes().unwrap();
    let below = repacked(&bytes, |name, content| Some((format!("stage/{name}"), content)));
    assert_found("zipped folder", &problems_of_bytes(&below), "stage/modelDescription.xml");
    let without = repacked(&bytes, |name, content| {
        (name != "modelDescription.xml").then(|| (name.to_owned(), content))
    });
    assert_found("none", &problems_of_bytes(&without), "there is no such file");
    let broken = with_description(&bytes, "<fmiModelDescription>");
    assert_found("not well-formed", &problems_of_bytes(&broken), "it is cut off");
    let entities = with_description(&bytes, "<!DOCTYPE x><fmiModelDescription/>");
    assert_found("entities", &problems_of_bytes(&entities), "DOCTYPE");
}

#[test]
fn the_file_must_end_in_fmu_and_be_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.zip");
    fs::write(&path, valid(&stage(FmiVersion::V2)).to_bytes().unwrap()).unwrap();
    assert_found("extension", &check(&path).unwrap(), "the extension must be .fmu");
    assert!(check(folder.path().join("nothing.fmu")).is_err());
}

#[test]
fn a_folder_is_checked_as_an_archive_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut zip = ZipArchive::new(Cursor::new(valid(&stage(FmiVersion::V2)).to_bytes().unwrap()));
    zip.as_mut().unwrap().extract(folder.path()).unwrap();
    assert_eq!(listing(&check(folder.path()).unwrap()), "");
    fs::remove_dir_all(folder.path().join("binaries")).unwrap();
    assert_found("no binary", &check(folder.path()).unwrap(), "neither binaries nor sources");
}

#[test]
fn what_is_allowed_but_troublesome_is_a_warning() {
    let mut fmu = valid(&stage(FmiVersion::V2));
    fmu.resource("Blueprint.toml", Vec::new()).unwrap();
    let found = problems_of_bytes(&fmu.to_bytes().unwrap());
    let [problem] = &found[..] else { panic!("{}", listing(&found)) };
    assert_eq!(problem.severity, Severity::Warning);
    assert!(problem.to_string().contains("upper and lower case"), "{problem}");
    let xml = stage(FmiVersion::V2).to_xml().unwrap();
    let with_fraction = xml.replace("T00:00:00Z", "T00:00:00.5+01:00");
    let found = check_description(with_fraction.as_bytes());
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].severity, Severity::Warning);
}

/// All problems are reported, not the first only.
#[test]
fn several_defects_are_all_found() {
    let mut xml = stage(FmiVersion::V2).to_xml().unwrap();
    let chosen =
        ["undefined unit", "undefined displayUnit", "negative stepSize", "wrong fmiVersion"];
    for (_, from, to, _) in MATRIX.iter().filter(|(defect, ..)| chosen.contains(defect)) {
        xml = xml.replacen(from, to, 1);
    }
    let found = check_description(xml.as_bytes());
    assert_eq!(found.len(), chosen.len(), "{}", listing(&found));
    let lines: Vec<_> = found.iter().map(|problem| problem.line).collect();
    assert!(lines.is_sorted(), "{lines:?}");
}
