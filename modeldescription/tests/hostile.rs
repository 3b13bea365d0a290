//! Archives that are made to do harm: each is refused by reader and checker with a message, nothing is
//! written outside, and the memory it takes is bounded and measured in a process of its own.
#![cfg(target_os = "linux")]
#![allow(clippy::print_stdout)]

mod common;

use std::fs::{self, File};
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;
use std::process::Command;

use common::stage;
use modeldescription::ssp::Ssp;
use modeldescription::{FmiVersion, Package};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Most memory that refusing any of them may take, the test program itself included.
const MOST_KB: u64 = 500_000;

type Zip = ZipWriter<BufWriter<File>>;

fn xml() -> String {
    stage(FmiVersion::V2).to_xml().unwrap()
}

fn entry(zip: &mut Zip, name: &str, content: &[u8]) {
    zip.start_file(name, SimpleFileOptions::default()).unwrap();
    zip.write_all(content).unwrap();
}

/// An entry of repeated bytes.
fn long_entry(zip: &mut Zip, name: &str, head: &[u8], block: &[u8], times: usize, tail: &[u8]) {
    zip.start_file(name, SimpleFileOptions::default().large_file(true)).unwrap();
    zip.write_all(head).unwrap();
    (0..times).for_each(|_| zip.write_all(block).unwrap());
    zip.write_all(tail).unwrap();
}

fn archive(path: &Path, fill: impl FnOnce(&mut Zip)) {
    let mut zip = ZipWriter::new(BufWriter::new(File::create(path).unwrap()));
    fill(&mut zip);
    zip.finish().unwrap().flush().unwrap();
}

/// A valid FMU with one more entry, whose name is then replaced in the bytes of the file.
fn renamed(path: &Path, name: &str) {
    let placeholder = "p".repeat(name.len());
    archive(path, |zip| {
        entry(zip, "modelDescription.xml", xml().as_bytes());
        entry(zip, &placeholder, b"harm");
    });
    replace(path, placeholder.as_bytes(), name.as_bytes());
}

fn replace(path: &Path, from: &[u8], to: &[u8]) {
    let mut bytes = fs::read(path).unwrap();
    let places: Vec<usize> =
        (0..=bytes.len() - from.len()).filter(|at| bytes[*at..].starts_with(from)).collect();
    assert!(!places.is_empty());
    places.iter().for_each(|at| bytes[*at..at + to.len()].copy_from_slice(to));
    fs::write(path, bytes).unwrap();
}

/// A model description with this in the place of its variables.
fn description(path: &Path, variables: impl FnOnce(&mut Vec<u8>)) {
    let mut text =
        b"<?xml version=\"1.0\"?>\n<fmiModelDescription fmiVersion=\"2.0\" modelName=\"m\" \
        guid=\"g\"><CoSimulation modelIdentifier=\"m\"/><ModelVariables>"
            .to_vec();
    variables(&mut text);
    text.extend(b"</ModelVariables><ModelStructure/></fmiModelDescription>");
    archive(path, |zip| entry(zip, "modelDescription.xml", &text));
}

const VARIABLE: &str = "<ScalarVariable name=\"v\" valueReference=\"1\"><Real/></ScalarVariable>";

fn bomb(path: &Path) {
    archive(path, |zip| {
        entry(zip, "modelDescription.xml", xml().as_bytes());
        long_entry(zip, "resources/bomb.bin", b"", &[0; 1 << 20], 1024, b"");
    });
}

/// Many central records that point to the same compressed bytes: each entry alone is harmless.
fn overlapping(path: &Path) {
    archive(path, |zip| {
        entry(zip, "modelDescription.xml", xml().as_bytes());
        long_entry(zip, "resources/00000.bin", b"", &[0; 1 << 20], 200, b"");
    });
    let bytes = fs::read(path).unwrap();
    let end = bytes.windows(4).rposition(|w| w == b"PK\x05\x06").unwrap();
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let (size, start) = (number(end + 12), number(end + 16));
    let central = &bytes[start..start + size];
    let last = central.windows(4).rposition(|w| w == b"PK\x01\x02").unwrap();
    let mut out = bytes[..start].to_vec();
    out.extend(central);
    for k in 1..200 {
        let name = central[last..].windows(5).position(|w| w == b"00000").unwrap();
        let mut record = central[last..].to_vec();
        record[name..name + 5].copy_from_slice(format!("{k:05}").as_bytes());
        out.extend(record);
    }
    let (count, length) = (2 + 199_u16, (out.len() - start) as u32);
    let mut tail = bytes[end..].to_vec();
    tail[8..10].copy_from_slice(&count.to_le_bytes());
    tail[10..12].copy_from_slice(&count.to_le_bytes());
    tail[12..16].copy_from_slice(&length.to_le_bytes());
    out.extend(tail);
    fs::write(path, out).unwrap();
}

fn entities(path: &Path) {
    let mut text = String::from("<?xml version=\"1.0\"?>\n<!DOCTYPE l [<!ENTITY e0 \"lol\">");
    for k in 1..12 {
        let body = format!("&e{};", k - 1).repeat(10);
        text += &format!("<!ENTITY e{k} \"{body}\">");
    }
    text += "]><fmiModelDescription fmiVersion=\"2.0\" modelName=\"&e11;\" guid=\"g\"/>";
    archive(path, |zip| entry(zip, "modelDescription.xml", text.as_bytes()));
}

fn external_entity(path: &Path) {
    let text = "<!DOCTYPE l [<!ENTITY x SYSTEM \"file:///etc/passwd\">]>\
                <fmiModelDescription fmiVersion=\"2.0\" modelName=\"&x;\" guid=\"g\"/>";
    archive(path, |zip| entry(zip, "modelDescription.xml", text.as_bytes()));
}

fn symbolic_link(path: &Path) {
    archive(path, |zip| {
        entry(zip, "modelDescription.xml", xml().as_bytes());
        zip.add_symlink("resources", "/etc", SimpleFileOptions::default()).unwrap();
        zip.add_symlink("binaries", "../..", SimpleFileOptions::default()).unwrap();
    });
}

fn encrypted(path: &Path) {
    renamed(path, "resources/x");
    // The flag of encryption, in local and central header.
    let mut bytes = fs::read(path).unwrap();
    for at in 46..bytes.len() - 11 {
        if bytes[at..].starts_with(b"resources/x") {
            if bytes[at - 46..].starts_with(b"PK\x01\x02") {
                bytes[at - 46 + 8] |= 1;
            } else {
                bytes[at - 30 + 6] |= 1;
            }
        }
    }
    fs::write(path, bytes).unwrap();
}

fn truncated(path: &Path) {
    renamed(path, "resources/x");
    let file = fs::OpenOptions::new().write(true).open(path).unwrap();
    file.set_len(fs::metadata(path).unwrap().len() * 2 / 3).unwrap();
}

/// The end record says that there are four thousand million entries (zip64) and there is one.
fn absurd_count(path: &Path) {
    renamed(path, "resources/x");
    let mut file = fs::OpenOptions::new().write(true).open(path).unwrap();
    file.seek(SeekFrom::End(-22 + 8)).unwrap();
    file.write_all(&[0xfe; 4]).unwrap();
}

/// A text of `length` bytes inside an attribute.
fn long_name(path: &Path, length: usize) {
    description(path, |text| {
        text.extend(b"<ScalarVariable name=\"");
        text.extend(vec![b'n'; length]);
        text.extend(b"\" valueReference=\"1\"><Real/></ScalarVariable>");
    });
}

fn deep(path: &Path) {
    description(path, |text| {
        (0..1_000_000).for_each(|_| text.extend(b"<a>"));
        (0..1_000_000).for_each(|_| text.extend(b"</a>"));
    });
}

fn many_attributes(path: &Path) {
    description(path, |text| {
        text.extend(b"<ScalarVariable");
        (0..500_000).for_each(|k| text.extend(format!(" a{k}=\"\"").bytes()));
        text.extend(b"/>");
    });
}

fn many_elements(path: &Path) {
    description(path, |text| {
        (0..5_000_000).for_each(|_| text.extend(b"<a/>"));
    });
}

/// A gigabyte of variables of the same name, which compress well.
fn endless_description(path: &Path) {
    archive(path, |zip| {
        let block = VARIABLE.repeat(4096);
        let head = b"<fmiModelDescription fmiVersion=\"2.0\"><ModelVariables>";
        let times = (1 << 30) / block.len();
        long_entry(zip, "modelDescription.xml", head, block.as_bytes(), times, b"");
    });
}

fn many_entries(path: &Path) {
    archive(path, |zip| {
        entry(zip, "modelDescription.xml", xml().as_bytes());
        (0..120_000).for_each(|k| entry(zip, &format!("resources/{k}"), b""));
    });
}

/// Name, how it is made, what the message says.
type Case = (&'static str, fn(&Path), &'static str);

const CASES: [Case; 22] = [
    ("path traversal", |p| renamed(p, "../../../../../../harm.txt"), "lead out"),
    ("traversal in the middle", |p| renamed(p, "resources/../../../harm.txt"), "lead out"),
    ("traversal with backslashes", |p| renamed(p, "..\\..\\..\\..\\harm.txt"), "lead out"),
    ("absolute path", |p| renamed(p, "/tmp/harm/harm.txt"), "absolute"),
    ("drive letter", |p| renamed(p, "C:\\harm\\harm.txt"), "drive"),
    ("symbolic links", symbolic_link, "symbolic link"),
    ("control characters in a name", |p| renamed(p, "resources/\u{1}\u{7}\n"), "control"),
    ("bomb of 1 GB", bomb, "looks like a zip bomb"),
    ("bomb of overlapping entries, 40 GB", overlapping, "overlap"),
    ("120 000 entries", many_entries, "120001 entries"),
    ("count that is not true", absurd_count, "zip"),
    ("encrypted", encrypted, "encrypted"),
    ("truncated", truncated, "zip"),
    ("name of an entry of 60 kB", |p| renamed(p, &"n".repeat(60_000)), "60000"),
    ("entities that expand to 300 GB", entities, "DOCTYPE"),
    ("entity of a file", external_entity, "DOCTYPE"),
    ("variable name of 10 MB", |p| long_name(p, 10 << 20), "bytes"),
    ("variable name of 2 MB", |p| long_name(p, 2 << 20), "bytes"),
    ("a million nested elements", deep, "the nesting of elements"),
    ("half a million attributes", many_attributes, "attributes"),
    ("five million elements", many_elements, "elements"),
    ("description of 1 GB", endless_description, "bytes"),
];

/// Everything below a folder.
fn listing(folder: &Path) -> Vec<String> {
    let mut all = Vec::new();
    for found in fs::read_dir(folder).unwrap().flatten() {
        all.push(found.path().display().to_string());
        if found.file_type().unwrap().is_dir() {
            all.extend(listing(&found.path()));
        }
    }
    all.sort();
    all
}

const CHILD: &str = "the_child_opens_what_it_is_given";

#[test]
fn every_hostile_archive_is_refused_within_bounded_memory() {
    let (mut most, mut wrong) = (0, Vec::new());
    for (name, make, says) in CASES {
        let outer = tempfile::tempdir().unwrap();
        let inner = outer.path().join("a/b/c");
        fs::create_dir_all(inner.join("tmp")).unwrap();
        let file = inner.join("hostile.fmu");
        make(&file);
        let before = listing(outer.path());
        let output = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", CHILD, "--nocapture", "--test-threads=1"])
            .env("HOSTILE_ARCHIVE", &file)
            .env("TMPDIR", inner.join("tmp"))
            .current_dir(&inner)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {text}{errors}");
        let line = |key: &str| {
            let found = text.lines().find_map(|line| line.strip_prefix(key));
            found.unwrap_or_else(|| panic!("{name}: no {key} in {text}")).to_owned()
        };
        for reader in ["open: ", "check: ", "ssp: "] {
            let message = line(reader);
            // An SSP has no model description to be wrong.
            let is_archives = reader != "ssp: " || !message.contains("SystemStructure.ssd");
            let names_file = message.contains("hostile.fmu") || reader == "check: ";
            // What is packed that densely is refused before it is read, but by the checker.
            let is_dense = reader != "check: " && message.contains("more than 100 times as many");
            if !names_file || (is_archives && !is_dense && !message.contains(says)) {
                wrong.push(format!("{name}, {says:?} is not in {reader}{message}"));
            }
        }
        assert_eq!(listing(outer.path()), before, "{name}: nothing is left behind");
        let peak: u64 = line("peak kB: ").parse().unwrap();
        println!("{name}: {peak} kB");
        if peak > MOST_KB {
            wrong.push(format!("{name}: {peak} kB"));
        }
        most = most.max(peak);
    }
    println!("at most {most} kB");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Run by the test above in a process of its own.
#[test]
fn the_child_opens_what_it_is_given() {
    let Some(file) = std::env::var_os("HOSTILE_ARCHIVE") else { return };
    let one_line = |text: String| text.replace('\n', " | ");
    let opened = Package::open(&file).map(|package| package.folder().to_owned());
    println!("\nopen: {}", one_line(opened.unwrap_err().to_string()));
    let problems = modeldescription::check(&file).unwrap();
    let all: Vec<String> = problems.iter().take(5).map(ToString::to_string).collect();
    println!("check: {}", one_line(all.join(" | ")));
    let system = Ssp::open(&file).map(|_| ());
    println!("ssp: {}", one_line(system.unwrap_err().to_string()));
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    println!("peak kB: {}", peak.trim().trim_end_matches(" kB"));
}
