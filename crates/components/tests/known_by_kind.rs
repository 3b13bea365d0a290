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

/// The kinds of all components: those of this crate, and the learned ones by the text of their declarations.
fn kinds() -> Vec<String> {
    let mut files = Vec::new();
    sources(&root().join("crates/learned/src"), &mut files);
    let texts = files.iter().map(|file| fs::read_to_string(file).expect("a source file"));
    let learned = texts.flat_map(|text| {
        let named = text.split("kind: \"").skip(1).filter_map(|rest| rest.split('"').next());
        named.map(str::to_owned).collect::<Vec<_>>()
    });
    let own = COMPONENTS.iter().map(|component| component.declaration().kind.to_owned());
    let all: Vec<String> = own.chain(learned).collect();
    assert!(all.len() > COMPONENTS.len() + 3, "learned components declare their kinds otherwise");
    all
}

/// Code without comments, with one space for what is between words, so that a line's end separates nothing.
fn code_of(text: &str) -> String {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

/// The places in code that compare with a kind, match on it, or stand in a table of kinds.
fn decisions<'a>(code: &'a str, kinds: &[String]) -> Vec<&'a str> {
    let is_kind = |text: &str| kinds.iter().any(|kind| kind == text);
    let mut all = Vec::new();
    let mut rest = 0;
    while let Some(start) = code[rest..].find('"').map(|at| rest + at) {
        let Some(end) = code[start + 1..].find('"').map(|at| start + 1 + at) else { break };
        rest = end + 1;
        if !is_kind(&code[start + 1..end]) {
            continue;
        }
        let (before, after) = (code[..start].trim_end(), code[rest..].trim_start());
        let after_some = after.strip_prefix(')').map_or(after, str::trim_start);
        let in_table = after.strip_prefix(", \"").and_then(|next| next.split('"').next());
        if before.ends_with("==")
            || before.ends_with("!=")
            || after.starts_with("==")
            || after.starts_with("!=")
            || after.starts_with("=>")
            || (before.ends_with("Some(") && after_some.starts_with("=>"))
            || (before.ends_with("Some(") && before[..before.len() - 5].trim_end().ends_with("=="))
            // One of several in a pattern.
            || (before.ends_with('|') && !before.ends_with("_|"))
            || after.starts_with("| ")
            // A kind and one of its quantities in a pattern.
            || (before.ends_with('(') && after.starts_with(", \"") && after.split(['{', ';']).next().is_some_and(|pattern| pattern.contains("=>")))
            || ["starts_with(", "ends_with(", "contains(&", "contains(", "eq("].iter().any(|call| before.ends_with(call))
            || (before.ends_with(',') && before.rsplit(';').next().is_some_and(|own| own.contains("matches!(")) && after.starts_with(')'))
            // Two kinds side by side are a table.
            || in_table.is_some_and(is_kind)
        {
            let from = code[..start].char_indices().rev().nth(40).map_or(0, |(at, _)| at);
            let to = code[rest..].char_indices().nth(40).map_or(code.len(), |(at, _)| rest + at);
            all.push(&code[from..to]);
        }
    }
    all
}

#[test]
fn nobody_outside_decides_by_the_name_of_a_kind() {
    let mut files = Vec::new();
    for folder in ["crates", "src", "fmu-blueprint", "fmu-wrap", "modeldescription"] {
        sources(&root().join(folder), &mut files);
    }
    files.retain(|f| !f.starts_with(root().join("crates/components")));
    assert!(files.len() > 300, "the folders have moved");
    let kinds = kinds();
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in files {
        let text = fs::read_to_string(&file).expect("a source file");
        let product = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
        let path = file.strip_prefix(root()).expect("below the root").display().to_string();
        let code = code_of(product);
        let lines = decisions(&code, &kinds).into_iter().map(str::to_owned).collect::<Vec<_>>();
        if !lines.is_empty() {
            found.insert(path, lines);
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
    let kinds = ["mode", "delay"].map(str::to_owned);
    for code in [
        "if declaration.kind ==\n    \"mode\" {",
        "\"mode\" => 1,",
        "\"delay\" |\n \"other\" => 1,",
        "(\"mode\", \"frequency\") => Some(1),",
        "Some(\"mode\") => 1,",
        "matches!(kind, \"mode\")",
        "kind.starts_with(\"mode\")",
        "const KINDS: [&str; 2] = [\"mode\", \"delay\"];",
    ] {
        assert_eq!(decisions(&code_of(code), &kinds).len(), 1, "{code}");
    }
    for code in ["ComponentBlueprint::new(\"mode\")", "find(\"mode\") // kind == \"mode\""] {
        assert!(decisions(&code_of(code), &kinds).is_empty(), "{code}");
    }
}
