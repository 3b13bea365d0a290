//! What a component is to others stands in what it declares: nothing outside this crate decides by the
//! name of its kind.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use components::COMPONENTS;

/// Files that still do, by the end of their path, and at most in so many lines. Take a line off where one goes.
const STILL: &[(&str, usize)] = &[
    // A key of an axis that a kind is named like.
    ("blueprint/read.rs", 1),
    // An option of an instrument that a kind is named like.
    ("gateway/line.rs", 2),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All product files in Rust below a folder.
fn sources(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let path = entry.expect("a folder's entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            if !matches!(name.as_str(), "tests" | "target" | "benches" | "examples") {
                sources(&path, all);
            }
        } else if name.ends_with(".rs") && !name.ends_with("tests.rs") {
            all.push(path);
        }
    }
}

/// Whether a line of code compares with a kind, or is the arm of a match on one.
fn decides(line: &str, kind: &str) -> bool {
    let code = line.split("//").next().unwrap_or_default();
    let text = format!("\"{kind}\"");
    code.match_indices(&text).any(|(at, _)| {
        let (before, after) = (code[..at].trim_end(), code[at + text.len()..].trim_start());
        before.ends_with("==")
            || before.ends_with("!=")
            || after.starts_with("=>")
            || after.starts_with("==")
            // One of several in a pattern.
            || ((before.ends_with('|') && !before.ends_with("_|")) || after.starts_with("| "))
            // A kind and one of its quantities in a pattern.
            || (before.ends_with('(') && after.starts_with(", \"") && code.contains("=>"))
    })
}

#[test]
fn nobody_outside_decides_by_the_name_of_a_kind() {
    let mut files = Vec::new();
    for folder in ["crates", "src", "fmu-blueprint", "fmu-wrap", "modeldescription"] {
        sources(&root().join(folder), &mut files);
    }
    files.retain(|f| !f.starts_with(root().join("crates/components")));
    assert!(files.len() > 300, "the folders have moved");
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in files {
        let text = fs::read_to_string(&file).expect("a source file");
        let product = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
        let path = file.strip_prefix(root()).expect("below the root").display().to_string();
        let is_kind = |line: &&str| {
            line.contains('"')
                && COMPONENTS.iter().any(|component| decides(line, component.declaration().kind))
        };
        for line in product.lines().filter(is_kind) {
            found.entry(path.clone()).or_default().push(line.trim().to_owned());
        }
    }
    found.retain(|path, lines| {
        let allowed = STILL.iter().filter(|(end, _)| path.ends_with(end)).map(|(_, n)| *n).max();
        lines.len() > allowed.unwrap_or(0)
    });
    assert!(
        found.is_empty(),
        "let the component declare what is asked (Role, releases, Extension, …): {found:#?}"
    );
}

#[test]
fn a_decision_is_distinguished_from_a_kind_that_is_written() {
    for line in [
        "if declaration.kind == \"mode\" {",
        "\"mode\" => 1,",
        "\"delay\" | \"mode\" => 1,",
        "(\"mode\", \"frequency\") => Some(1),",
    ] {
        assert!(decides(line, "mode"), "{line}");
    }
    for line in ["ComponentBlueprint::new(\"mode\")", "find(\"mode\") // kind == \"mode\""] {
        assert!(!decides(line, "mode"), "{line}");
    }
}
