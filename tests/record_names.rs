//! Every legal name of FMI can be recorded in every format, and every record is read again: under the same
//! name, or under one that the run has said.
#![cfg(unix)]

use crate::common;

use std::collections::BTreeMap;
use std::fs;
use std::io::{Read, Write};
use std::path::Path;

use common::{json, succeed};

/// What tools and people call variables: indices, quotes, blanks, signs; what looks like a number, a comment, a
/// unit, a column of times or of records, or a path.
const NAMES: [&str; 48] = [
    "A[1,1]",
    "a,b",
    "q\"uote",
    "'quoted.name'",
    "x y",
    " lead",
    "trail ",
    "der(x,2)",
    "µ±°",
    "日本",
    "a [m]",
    "b (mm)",
    "c / um",
    "U in V",
    "1",
    "1e5",
    "-3",
    "nan",
    "true",
    "inf",
    "#hash",
    "%percent",
    "//c",
    ";semi",
    "tab|pipe",
    "a/b",
    "a\\b",
    "a.npy",
    "..",
    "../x",
    "Time",
    "TIME",
    "time",
    "t",
    "time_ms",
    "timestamps",
    "record",
    "Record",
    "realization",
    "index",
    "Zeit",
    "=f(x)",
    "{x}",
    "x:y",
    "unit:y",
    "y_2",
    "e\u{301}",
    "💥",
];

fn quoted(name: &str) -> String {
    let escaped = [('&', "&amp;"), ('"', "&quot;"), ('<', "&lt;")];
    escaped.iter().fold(name.to_owned(), |text, (from, to)| text.replace(*from, to))
}

/// The gain of 2 with its output under all these names as well.
fn fmu(folder: &Path) {
    let gain = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/gain.toml");
    succeed(&["pack", gain, "-o", "gain.fmu"], folder);
    let mut zip = zip::ZipArchive::new(fs::File::open(folder.join("gain.fmu")).unwrap()).unwrap();
    let mut out = zip::ZipWriter::new(fs::File::create(folder.join("names.fmu")).unwrap());
    for at in 0..zip.len() {
        let mut entry = zip.by_index(at).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut content = Vec::new();
        entry.read_to_end(&mut content).unwrap();
        if name == "modelDescription.xml" {
            content = described(std::str::from_utf8(&content).unwrap()).into_bytes();
        }
        out.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        out.write_all(&content).unwrap();
    }
    out.finish().unwrap();
}

fn described(xml: &str) -> String {
    let begin = xml.find("<ScalarVariable name=\"position[1]\"").unwrap();
    let end = begin + xml[begin..].find("</ScalarVariable>").unwrap() + "</ScalarVariable>".len();
    let own = xml[begin..end].to_owned();
    let number = xml[..begin].matches("<ScalarVariable").count() + 1;
    let all: String = NAMES
        .iter()
        .map(|name| own.replace("\"position[1]\"", &format!("\"{}\"", quoted(name))))
        .collect();
    let unknowns: String = (number..=number + NAMES.len())
        .map(|index| format!("<Unknown index=\"{index}\"/>"))
        .collect();
    let mut text = format!("{}{all}{}", &xml[..end], &xml[end..]);
    for list in ["Outputs", "InitialUnknowns"] {
        let (open, close) = (format!("<{list}>"), format!("</{list}>"));
        let (from, to) = (text.find(&open).unwrap() + open.len(), text.find(&close).unwrap());
        text.replace_range(from..to, &unknowns);
    }
    text
}

#[test]
fn every_legal_name_is_recorded_in_every_format_and_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fmu(at);
    fs::write(at.join("in.csv"), "time,u\n0,1\n0.001,2\n0.002,3\n0.003,5\n").unwrap();
    let mut system =
        "name = \"s\"\n[fmus]\np = \"names.fmu\"\n[inputs]\n\"p.command[1]\" = \"u\"\n[record]\n"
            .to_owned();
    for name in NAMES {
        let text = |name: &str| serde_json::to_string(name).unwrap();
        system += &format!("{} = {}\n", text(name), text(&format!("p.{name}")));
    }
    fs::write(at.join("system.toml"), system).unwrap();
    for ending in ["csv", "npy", "npz", "parquet"] {
        let simulate = ["simulate", "names.fmu", "--log", "in.csv", "--map", "command[1]=u"];
        let system = ["system", "system.toml", "--input", "in.csv"];
        for call in [&simulate[..], &system] {
            // Beside the file the units of the one before may stand.
            let out = format!("run.{ending}");
            let reported = json(&[call, &["-o", &out]].concat(), at);
            let renamed: BTreeMap<String, String> = reported["notes"]
                .as_array()
                .unwrap()
                .iter()
                .filter_map(|note| {
                    let rest = note.as_str()?.split_once("variable `")?.1;
                    let (name, rest) = rest.split_once("` is column `")?;
                    Some((name.to_owned(), rest.split_once("`, a name")?.0.to_owned()))
                })
                .collect();
            let begin = fs::read(at.join(&out)).unwrap();
            let magic: &[u8] = match ending {
                "npy" => b"\x93NUMPY",
                "npz" => b"PK",
                "parquet" => b"PAR1",
                _ => b"time,",
            };
            assert!(begin.starts_with(magic), "{call:?} {out}");
            let read = json(&["log", &out], at);
            let columns = read["logs"][0]["columns"].as_array().unwrap();
            let mut found = 0;
            for name in NAMES {
                let shown = name.escape_debug().to_string();
                let name = renamed.get(&shown).map_or(name, String::as_str);
                let column = columns.iter().find(|column| column["name"] == name);
                let column =
                    column.unwrap_or_else(|| panic!("{call:?} {out}: {name:?}: {columns:?}"));
                assert_eq!(
                    (column["min"].as_f64(), column["max"].as_f64()),
                    (Some(2.0), Some(6.0))
                );
                found += 1;
            }
            assert_eq!(read["logs"][0]["records"][0]["end_s"], 0.003, "{call:?} {out}");
            assert_eq!(found, NAMES.len());
        }
    }
}
