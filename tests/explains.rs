//! FMUs that explain themselves: fields, variables, page, icon, reference results; and `check` repeats
//! the results.

use crate::common;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use common::packed::{CONTROLLER, PLANT};
use common::{piezoloop, root, succeed};
use modeldescription::Package;
use modeldescription::variable::{Causality, DataType};

const REFERENCE: &str = "extra/io.github.piezoloop/reference";

fn packed(blueprint: &str, version: &str, folder: &Path) -> Package {
    succeed(&["pack", blueprint, "--fmi", version, "-o", "model.fmu"], folder);
    Package::open(folder.join("model.fmu")).expect("an FMU")
}

#[test]
fn every_variable_has_a_sentence_and_a_unit_and_the_page_names_all_ports() {
    let folder = tempfile::tempdir().expect("a folder");
    for (blueprint, version) in [(PLANT, "2"), (PLANT, "3"), (CONTROLLER, "2"), (CONTROLLER, "3")] {
        let package = packed(blueprint, version, folder.path());
        let description = package.description();
        let read = |path: &str| fs::read_to_string(package.folder().join(path));
        let page = read("documentation/index.html").expect("a page");
        for variable in &description.variables {
            let name = &variable.name;
            assert!(variable.description.is_some(), "{name}: no sentence");
            let unit = description.properties(variable).unit;
            let measured = variable.data_type == DataType::Float64
                && variable.causality != Causality::Independent;
            assert!(!measured || unit.is_some(), "{name}: no unit");
            if matches!(variable.causality, Causality::Input | Causality::Output) {
                assert!(page.contains(name.split('[').next().expect("a name")), "{name}");
            }
        }
        for words in ["Signal paths", "Parameters", "Reference results", "prefers-color-scheme"] {
            assert!(page.contains(words), "{words}");
        }
        assert!(page.len() < 1_000_000, "{} bytes", page.len());
        // What fmpy takes as its step without being told one: at most 1000 steps of the own size.
        let experiment = description.default_experiment.as_ref().expect("a default experiment");
        let steps = experiment.stop_time.expect("a stop") / experiment.step_size.expect("a step");
        assert!(steps <= 1000.0 + 1e-9, "{steps}");
        let (icon, other) = match version {
            "2" => ("model.png", "terminalsAndIcons/terminalsAndIcons.xml"),
            _ => ("terminalsAndIcons/icon.png", "model.png"),
        };
        assert!(package.folder().join(icon).is_file() && !package.folder().join(other).exists());
        let table = read(&format!("{REFERENCE}/output.csv")).expect("results");
        assert_eq!(table.lines().count(), 202);
        assert!(table.lines().next().is_some_and(|names| names.contains("[1]")), "{table}");
    }
}

/// The names that docs/fmi.md gives in its section on numbers without bounds.
fn documented_as_unbounded(page: &str) -> BTreeSet<&str> {
    let (_, after) = page.split_once("\n## Numbers without bounds\n").expect("the section");
    let section = after.split("\n## ").next().expect("text");
    let rows = section.lines().filter(|line| line.starts_with("| ") && line.contains('`'));
    rows.flat_map(|row| row.split('|').nth(2).expect("names").split('`').skip(1).step_by(2))
        .collect()
}

/// The last part of a variable's name, without its index.
fn last_part(name: &str) -> &str {
    let part = name.rsplit('.').next().expect("a part");
    part.split('[').next().expect("a name")
}

/// The FMUs of all rigs and of a controller; how many have a bound is what docs/fmi.md says.
#[test]
fn every_number_has_a_bound_or_a_reason_in_the_documentation() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = fs::read_to_string(root().join("docs/fmi.md")).expect("the page");
    let free = documented_as_unbounded(&page);
    let rigs = succeed(&["list", "rigs", "--json"], folder.path());
    let rigs: serde_json::Value = serde_json::from_str(&rigs).expect("JSON");
    let rigs = rigs.as_array().expect("a list").iter().map(|rig| rig["name"].as_str());
    let (mut numbers, mut bounded) = (0, 0);
    for blueprint in rigs.map(|name| name.expect("a name")).chain([CONTROLLER]) {
        let package = packed(blueprint, "2", folder.path());
        let description = package.description();
        for variable in &description.variables {
            if variable.data_type != DataType::Float64 {
                continue;
            }
            let (name, properties) = (&variable.name, description.properties(variable));
            let is_bounded = properties.min.is_some() || properties.max.is_some();
            let reason = free.contains(last_part(name));
            assert!(is_bounded || reason, "{blueprint}, {name}: neither a bound nor a reason");
            numbers += 1;
            bounded += usize::from(is_bounded);
            // What an importer must have of its users: the commands.
            if last_part(name) == "command" {
                assert!(properties.min.is_some() && properties.max.is_some(), "{blueprint} {name}");
            }
        }
    }
    let described =
        format!("bounds of {bounded} of the {numbers} numbers of the rigs and a controller");
    assert!(page.contains(&described), "docs/fmi.md should say: {described}");
}

#[test]
fn what_a_blueprint_says_of_its_maker_is_in_the_fmu() {
    let folder = tempfile::tempdir().expect("a folder");
    let stage = root().join("tests/blueprints/stage.toml");
    let blueprint = fs::read_to_string(&stage).expect("the blueprint");
    let described = "author = \"A. Smith, Motion Ltd\"\nversion = \"1.2\"\ncopyright = \"© Motion Ltd\"\n\
                license = \"proprietary\"\n";
    fs::write(folder.path().join("told.toml"), described.to_owned() + &blueprint).expect("a file");
    for version in ["2", "3"] {
        let package = packed("told.toml", version, folder.path());
        let description = package.description();
        assert_eq!(description.author.as_deref(), Some("A. Smith, Motion Ltd"));
        assert_eq!(description.version.as_deref(), Some("1.2"));
        assert_eq!(description.copyright.as_deref(), Some("© Motion Ltd"));
        assert!(description.license.as_deref().is_some_and(|text| text.starts_with("proprietary")));
        assert!(description.generation_tool.as_deref().is_some_and(|t| t.starts_with("Piezoloop")));
    }
    let package = packed(stage.to_str().expect("UTF-8"), "2", folder.path());
    let version = package.description().version.clone().expect("a version");
    assert!(version.starts_with("blueprint ") && version.len() == 22, "{version}");
}

/// Copies an unpacked FMU.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("a copy");
        }
    }
}

#[test]
fn check_repeats_the_reference_results_and_tells_a_difference() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for (blueprint, version) in [(PLANT, "2"), (CONTROLLER, "3")] {
        let package = packed(blueprint, version, at);
        let message = succeed(&["check", "model.fmu", "--strict", "--replay"], at);
        assert!(message.contains("reference results repeated, largest difference 0"), "{message}");

        // A value in the middle, off by a millionth of the range.
        let changed = at.join("changed");
        copy(package.folder(), &changed);
        let file = changed.join(REFERENCE).join("output.csv");
        let text = fs::read_to_string(&file).expect("results");
        let rows: Vec<Vec<f64>> = text
            .lines()
            .skip(1)
            .map(|row| row.split(',').map(|cell| cell.parse().expect("a number")).collect())
            .collect();
        let ends = rows
            .iter()
            .map(|row| row[1])
            .fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let mut row = rows[100].clone();
        row[1] += 1e-6 * (ends.1 - ends.0);
        lines[101] = row.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
        fs::write(&file, lines.join("\n") + "\n").expect("a file");
        let output = piezoloop(&["check", "changed", "--replay"], at);
        let message = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains("output.csv") && message.contains("1.000e-6"), "{message}");
        succeed(&["check", "changed"], at);

        // Nothing to compare with: said, not skipped.
        fs::write(changed.join(REFERENCE).join("reference.toml"), "format = 7\n").expect("a file");
        let output = piezoloop(&["check", "changed", "--replay"], at);
        let message = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(
            message.contains("cannot be repeated") && message.contains("reference.toml"),
            "{message}"
        );
        fs::remove_dir_all(&changed).expect("it goes");
    }
}
