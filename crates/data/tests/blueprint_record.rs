//! Parameter records: values of a specimen that components of a blueprint take.

use data::{Blueprint, ParameterRecord, Value};

const AXIS: &str = "piezoloop = 1\nkind = \"plant\"\nname = \"t\"\nstep = 1e-5\n[[axis]]\nname = \
                    \"x\"\ncommand = { unit = \"V\" }\nposition = { unit = \"um\" }\n";

fn blueprint(rest: &str) -> Blueprint {
    let text = format!(
        "{AXIS}[[axis.component]]\ntype = \"actuator-gain\"\ngain = 0.1\n[[axis.component]]\n{rest}"
    );
    Blueprint::parse(&text, "test.toml").unwrap_or_else(|e| panic!("{e}"))
}

fn described(blueprint: &Blueprint) -> String {
    blueprint.check(components::COMPONENTS).err().map_or_else(String::new, |e| e.to_string())
}

#[test]
fn a_component_takes_what_it_does_not_say_itself() {
    let blueprint = blueprint("type = \"mode\"\nrecord = \"p-752-21c\"\ndamping = 0.05\n");
    let checked = blueprint.check(components::COMPONENTS).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(checked.parameter(1, "mode", "frequency"), Some(&[2100.0][..]));
    assert_eq!(checked.parameter(1, "mode", "damping"), Some(&[0.05][..]));
    assert_eq!(blueprint.records(), ["p-752-21c"]);
    let note = &blueprint.axes[0].components[1].note;
    assert!(note.starts_with("record p-752-21c: frequency (maker's data"), "{note}");
    assert!(!note.contains("damping"), "{note}");
}

#[test]
fn the_written_text_needs_no_record() {
    let first = blueprint("type = \"mode\"\nrecord = \"p-752-21c\"\n");
    let again = Blueprint::parse(&first.to_toml(), "again").unwrap_or_else(|e| panic!("{e}"));
    assert!(again.records().is_empty());
    assert_eq!(first, again);
}

#[test]
fn wrong_records_are_reported_with_their_line() {
    let unknown = described(&blueprint("type = \"mode\"\nrecord = \"p-752-21\"\n"));
    assert!(unknown.contains("test.toml:14"), "{unknown}");
    assert!(unknown.contains("record = p-752-21: is no record") && unknown.contains("p-752-21c"));
    let other = described(&blueprint("type = \"backlash\"\nrecord = \"p-752-21c\"\n"));
    assert!(other.contains("has no values for backlash") && other.contains("mode, load-force"));
}

#[test]
fn a_record_may_be_a_file_beside_the_blueprint() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = "piezoloop_record = 1\nname = \"mine\"\n[mode]\nfrequency = { value = \"1.5 kHz\", \
                  source = \"ring-down of 3 May\" }\ndamping = { value = 0.01, source = \"the same\" }\n";
    std::fs::write(folder.path().join("mine.toml"), record).expect("writes");
    let text = format!(
        "{AXIS}[[axis.component]]\ntype = \"actuator-gain\"\ngain = 0.1\n[[axis.component]]\ntype = \
         \"mode\"\nrecord = \"mine.toml\"\n"
    );
    let path = folder.path().join("stage.toml");
    std::fs::write(&path, &text).expect("writes");
    let blueprint = Blueprint::read(&path).unwrap_or_else(|e| panic!("{e}"));
    let checked = blueprint.check(components::COMPONENTS).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(checked.parameter(1, "mode", "frequency"), Some(&[1500.0][..]));
    std::fs::remove_file(folder.path().join("mine.toml")).expect("removes");
    let missing = described(&Blueprint::read(&path).unwrap_or_else(|e| panic!("{e}")));
    assert!(missing.contains("mine.toml: cannot be read"), "{missing}");
}

#[test]
fn a_record_is_checked_when_it_is_read() {
    let text = "name = \"\"\nsize = 3\n[mode]\nfrequency = 3\ndamping = { value = 0.1 }\ngain = { \
                source = \"x\" }\nrate = { value = 1, source = \"x\", sigma = 2 }\n";
    let errors = ParameterRecord::parse(text, "r.toml").expect_err("wrong").to_string();
    for words in [
        "r.toml:1: name",
        "r.toml:2: size = 3: is no key of a record",
        "r.toml:4: mode.frequency = 3: must have a value and a source",
        "r.toml:5: mode.damping: has no source",
        "r.toml:6: mode.gain: has no value",
        "r.toml:7: mode.rate.sigma: is no key",
        "piezoloop_record: is missing",
    ] {
        assert!(errors.contains(words), "{words} is not in:\n{errors}");
    }
    let good =
        "piezoloop_record = 1\nname = \"a\"\n[mode]\nfrequency = { value = 5, source = \"x\" }\n";
    let record = ParameterRecord::parse(good, "r.toml").unwrap_or_else(|e| panic!("{e}"));
    let values = record.values("mode").expect("a section");
    assert_eq!((values[0].name.as_str(), &values[0].value), ("frequency", &Value::Number(5.0)));
    assert!(record.values("delay").is_none());
}
