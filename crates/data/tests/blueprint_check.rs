//! What the check of a blueprint accepts, and every problem that it reports.

use crate::common::{PLANT, REGISTRY};
use data::{AxisBlueprint, Blueprint, ComponentBlueprint, SignalBlueprint};
use model::Kind;

/// The problems of a text, one per line.
fn problems(text: &str) -> Vec<String> {
    let blueprint = Blueprint::parse(text, "plant.toml").unwrap_or_else(|e| panic!("{e}"));
    match blueprint.check(REGISTRY) {
        Ok(_) => Vec::new(),
        Err(problems) => problems.as_slice().iter().map(ToString::to_string).collect(),
    }
}

/// The only problem of [`PLANT`] with `old` replaced by `new`.
fn only_problem(old: &str, new: &str) -> String {
    assert!(PLANT.contains(old), "{old}");
    let found = problems(&PLANT.replacen(old, new, 1));
    assert_eq!(found.len(), 1, "{found:#?}");
    found[0].clone()
}

#[test]
fn a_good_blueprint_gives_values_in_the_units_of_its_axis() {
    let checked = Blueprint::parse(PLANT, "plant.toml").unwrap().check(REGISTRY).unwrap();
    let spec = checked.spec();
    assert_eq!(spec.name, "stage");
    assert_eq!(spec.period, 20e-6);
    assert_eq!(spec.axes[0].start, 5.0);
    assert_eq!(spec.axes[0].command_range, (0.0, 120.0));
    assert_eq!(checked.parameter(1, "hysteresis", "r"), Some(&[0.0, 6.0, 12.0][..]));
    assert_eq!(checked.parameter(1, "hysteresis", "w"), Some(&[0.01354, 0.0279, 0.0][..]));
    assert_eq!(checked.parameter(1, "hysteresis", "offset"), Some(&[0.0][..]));
    assert_eq!(checked.parameter(1, "lag", "bandwidth"), Some(&[2100.0][..]));
    assert_eq!(checked.parameter(2, "lag", "bandwidth"), None);
    assert_eq!(checked.parameter(0, "lag", "bandwidth"), None);
    assert!(!spec.axes[0].components[2].enabled);
    let system = checked.build();
    let variables = system.variables();
    assert_eq!(variables.find("u"), variables.find("command[1]"));
    assert_eq!(variables.find("y"), variables.find("position[1]"));
    let w3 = variables.get(variables.find("axis[1].hysteresis.w[3]").unwrap()).unwrap();
    assert_eq!((w3.unit.as_str(), w3.start), ("um/V", Some(0.0)));
}

#[test]
fn what_is_built_in_code_is_checked_the_same() {
    let axis = AxisBlueprint {
        command: SignalBlueprint::of_unit("V").named("u").between(0.0, 100.0).start(10.0),
        ..AxisBlueprint::new("Y", "V", "um")
    };
    let plays = ComponentBlueprint::new("plays").value("r", [0.0, 1.0]).value("w", [0.5, 0.5]);
    let good =
        Blueprint::new(Kind::Plant, "stage", 1e-4).axis(axis.clone().component(plays.clone()));
    let checked = good.check(REGISTRY).unwrap();
    assert_eq!(checked.parameter(1, "plays", "w"), Some(&[0.5, 0.5][..]));

    let bad =
        Blueprint::new(Kind::Plant, "stage", 1e-4).axis(axis.component(plays.value("w", [0.5])));
    let text = bad.check(REGISTRY).unwrap_err().to_string();
    assert_eq!(
        text,
        "blueprint: axis[1].plays.w = 1 values: must have 2 values, as many as plays and the other \
         lists say; give 2 values here, or correct the others"
    );
}

#[test]
fn a_controller_has_its_own_signals() {
    let text = r#"piezoloop = 1
kind = "controller"
name = "c"
step = 5e-5
[[axis]]
command = { name = "u", unit = "V", min = 0, max = 120 }
position = { unit = "um" }
reference = { name = "r", start = 2 }
measured = { name = "y" }
[[axis.component]]
type = "law"
kp = 0.5
"#;
    let checked = Blueprint::parse(text, "c.toml").unwrap().check(REGISTRY).unwrap();
    assert_eq!(checked.spec().axes[0].start, 2.0);
    assert_eq!(checked.spec().axes[0].name, "axis1");
    let variables = checked.system().variables();
    for (alias, name) in [("u", "command[1]"), ("r", "reference[1]"), ("y", "measured[1]")] {
        assert_eq!(variables.find(alias), variables.find(name), "{alias}");
        assert!(variables.find(name).is_some());
    }
    let ranged = text.replace("{ unit = \"um\" }", "{ unit = \"um\", min = \"-500 nm\", max = 6 }");
    let checked = Blueprint::parse(&ranged, "c.toml").unwrap().check(REGISTRY).unwrap();
    assert_eq!(checked.spec().axes[0].position_range, (-0.5, 6.0));
    let again = Blueprint::parse(&checked.blueprint().to_toml(), "again.toml").unwrap();
    assert_eq!(again.check(REGISTRY).unwrap().spec().axes[0].position_range, (-0.5, 6.0));
    let found =
        problems(&ranged.replace("max = 6", "max = 1").replace("0.5\n", "0.5\npark = 121\n"));
    let wanted = [
        "plant.toml:8: axis[1].reference.start = 2 um: must be at most 1 um; give a smaller value",
        "plant.toml:13: axis[1].law.park = 121 V: is no command of this axis, which are 0 V to 120 V; \
         give one of these, or widen min and max of the axis' command",
    ];
    assert_eq!(found, wanted);
    let found = problems(&ranged.replace("max = 6", "max = -1"));
    let rule = "plant.toml:7: axis[1].position.max = -1 um: must be at least min = -0.5 um; ";
    assert!(found.len() == 1 && found[0].starts_with(rule), "{found:#?}");

    let wrong = text
        .replace("position = { unit = \"um\" }", "position = { unit = \"um\", name = \"p\" }")
        .replace("start = 2 }", "unit = \"um\" }")
        .replace("max = 120 }", "max = 120, start = 0 }");
    let found = problems(&wrong);
    assert_eq!(found.len(), 3, "{found:#?}");
    assert!(found.iter().all(|problem| problem.contains("means nothing here; leave it out")));
}

#[test]
fn a_step_too_short_for_any_run_is_reported() {
    let with = |step: &str| {
        format!(
            "piezoloop = 1\nkind = \"plant\"\nname = \"short\"\nstep = {step}\n\n[[axis]]\nname = \"X\"\n\
             command = {{ name = \"u\", unit = \"V\" }}\nposition = {{ name = \"y\", unit = \"um\" }}\n"
        )
    };
    let step = |problem: &String| problem.contains("step =");
    let found = problems(&with("1e-32"));
    let words = "plant.toml:4: step = 1e-32 s: is shorter than 1 ns";
    assert!(found.iter().any(|problem| problem.contains(words)), "{found:#?}");
    assert!(!problems(&with("1e-9")).iter().any(step));
}

#[test]
fn every_problem_is_reported_at_its_line() {
    let text = r#"piezoloop = 1
kind = "plant"
name = "EVC 1"
step = 0
colour = "red"

[[axis]]
name = "Y"
command = { name = "u", unit = "V", min = 10, max = 0 }
position = { name = "u", unit = "furlong" }

[[axis.component]]
type = "lagg"

[[axis.component]]
type = "lag"
bandwith = 10

[[axis.component]]
type = "lag"
bandwidth = "10 um"
tolerance = { speed = 1 }

[[axis]]
name = "Y"
position = { unit = "um" }
"#;
    let expected = [
        "plant.toml:3: name = \"EVC 1\": is no name that FMI tools accept; ",
        "plant.toml:4: step = 0 s: is no internal step; ",
        "plant.toml:5: colour: is no key of a blueprint here; known are ",
        "plant.toml:9: axis[1].command.max = 0 V: must be at least min = 10 V; ",
        "plant.toml:10: axis[1].position.unit = \"furlong\": no unit symbol ",
        "plant.toml:10: axis[1].position.name = \"u\": is the short name of another signal; ",
        "plant.toml:13: axis[1].component[1].type = \"lagg\": is no type of component; did you mean \"lag\"? known types are plays, gain, lag, delay, law",
        "plant.toml:17: axis[1].lag.bandwith: is no key of lag; did you mean \"bandwidth\"? known are ",
        "plant.toml:15: axis[1].lag.bandwidth: is missing: Bandwidth; give it in Hz",
        "plant.toml:19: axis[1].lag.name = \"lag\": is the name of another component; ",
        "plant.toml:21: axis[1].lag.bandwidth = \"10 um\": the unit um does not measure the same as Hz; ",
        "plant.toml:22: axis[1].lag.tolerance.speed: is no parameter of lag; parameters are bandwidth",
        "plant.toml:25: axis[2].name = \"Y\": is the name of another axis; ",
        "plant.toml:24: axis[2].command.unit: is missing",
        "plant.toml:24: axis[2]: the chain ends with the wrong signal: ",
    ];
    let found = problems(text);
    for wanted in expected {
        assert!(found.iter().any(|f| f.starts_with(wanted)), "{wanted}\nnot in\n{found:#?}");
    }
    assert_eq!(found.len(), expected.len(), "{found:#?}");
}

#[test]
fn values_are_checked_one_by_one() {
    let cases = [
        (
            "[0, \"6000 mV\", 12]",
            "[0, -1, 12]",
            ":20: axis[1].hysteresis.r[2] = -1 V: must be at least 0 V; give a greater value",
        ),
        (
            "[0, \"6000 mV\", 12]",
            "[0, nan, 12]",
            ":20: axis[1].hysteresis.r[2] = NaN: is not a finite number; give a finite number in V",
        ),
        (
            "[0, \"6000 mV\", 12]",
            "[0, [6], 12]",
            ":20: axis[1].hysteresis.r[2] = 1 values: must be one value",
        ),
        (
            "[0, \"6000 mV\", 12]",
            "[0, true, 12]",
            ":20: axis[1].hysteresis.r[2] = true: must be a number",
        ),
        (
            "[0, \"6000 mV\", 12]",
            "[0, 12, 6]",
            ":20: axis[1].hysteresis.r[3] = 6 V: thresholds must grow; sort them",
        ),
        ("[0, \"6000 mV\", 12]", "3", ":20: axis[1].hysteresis.r: must be a list; "),
        (
            "[0, \"6000 mV\", 12]",
            "[0, 6]",
            ":21: axis[1].hysteresis.w = 3 values: must have 2 values, as many as plays and the other lists say; ",
        ),
        (
            "r = [0, \"6000 mV\", 12]",
            "",
            "axis[1].hysteresis.r: is missing: Thresholds; give it in V",
        ),
        (
            "\"2.1 kHz\"",
            "[1]",
            ":15: axis[1].lag.bandwidth = 1 values: must be one value, not a list; ",
        ),
        (
            "\"2.1 kHz\"",
            "\"2,1 kHz\"",
            ":15: axis[1].lag.bandwidth = \"2,1 kHz\": has a decimal comma; ",
        ),
        ("\"2.1 kHz\"", "\"0 kHz\"", ":15: axis[1].lag.bandwidth = 0 Hz: must be at least 1 Hz; "),
        (
            "\"2.1 kHz\"",
            "2e6",
            ":15: axis[1].lag.bandwidth = 2000000 Hz: must be at most 1000000 Hz; ",
        ),
        ("\"2.1 kHz\"", "1979-05-27", ":15: axis[1].lag.bandwidth = 1979-05-27: must be a number"),
        (
            "\"20 us\"",
            "\"20 um\"",
            ":6: step = \"20 um\": the unit um does not measure the same as s; ",
        ),
        ("\"20 us\"", "inf", ":6: step = inf: is not a finite number; "),
        (
            "start = \"5000 mV\"",
            "start = 200",
            ":10: axis[1].command.start = 200 V: must be at most 120 V; ",
        ),
        (
            "min = 0, max = 120, start = \"5000 mV\"",
            "min = 1, max = 120",
            "axis[1].command.start: is missing, and its default 0 is outside 1 to 120 V; ",
        ),
        (
            "w = 0.05",
            "w = -1",
            ":22: axis[1].hysteresis.tolerance.w = -1: must be finite and at least 0; ",
        ),
        (
            "enabled = false",
            "enabled = 0",
            ":28: axis[1].sensor.enabled = 0: must be a truth value; write true or false",
        ),
        ("name = \"sensor\"", "name = \"sensor[1]\"", "is no name that FMI tools accept; "),
        ("name = \"sensor\"", "name = \"Sensör\"", "is no name that FMI tools accept; "),
        ("name = \"sensor\"", "name = \"1st\"", "is no name that FMI tools accept; "),
        ("name = \"sensor\"", "name = \"a,b\"", "is no name that FMI tools accept; "),
        ("name = \"u\"", "name = \"time\"", ":10: axis[1].command.name = \"time\": is taken: "),
        ("name = \"stage\"", "", "plant.toml: name: is missing; "),
        (
            "kind = \"plant\"",
            "kind = \"plants\"",
            ":2: kind = \"plants\": is no kind of blueprint; ",
        ),
        (
            "piezoloop = 1",
            "",
            "plant.toml: piezoloop: is missing, so the format of the file is unknown; write piezoloop = 1",
        ),
        ("unit = \"V\"", "unit = \"V,s\"", ":10: axis[1].command.unit = \"V,s\": "),
    ];
    for (old, new, wanted) in cases {
        let found = only_problem(old, new);
        assert!(found.contains(wanted), "wanted {wanted}\nfound  {found}");
    }
}

#[test]
fn structural_settings_are_counted_given_or_by_default() {
    let with = |old: &str, new: &str| {
        let text = PLANT.replacen(old, new, 1);
        Blueprint::parse(&text, "plant.toml").unwrap().check(REGISTRY)
    };
    assert!(with("r = [0", "plays = 3\nr = [0").is_ok());
    let wanted = "must have 4 values, as many as plays";
    let found = with("r = [0", "plays = 4\nr = [0").unwrap_err();
    assert_eq!(found.to_string().matches(wanted).count(), 2, "{found}");
    let found = with("r = [0", "plays = 2.5\nr = [0").unwrap_err().to_string();
    assert!(found.contains("plays = 2.5: must be a whole number"), "{found}");
    let found = with("r = [0", "plays = 51\nr = [0").unwrap_err().to_string();
    assert!(found.contains("plays = 51: must be at most 50;"), "{found}");
    let found = with("[0, \"6000 mV\", 12]", "[]").unwrap_err().to_string();
    assert!(found.contains("r = 0 values: plays is the length of this list"), "{found}");
    let delay = with("type = \"lag\"\nbandwidth = \"2.1 kHz\"", "type = \"delay\"").unwrap();
    assert_eq!(delay.spec().axes[0].components[0].structure, [1e-3]);
}

#[test]
fn the_order_of_signals_is_reported_at_the_component() {
    let second = PLANT.replacen("type = \"lag\"\nname", "type = \"gain\"\ngain = 1\nname", 1);
    let second = second.replacen("enabled = false\nbandwidth = 5000\n", "", 1);
    let found = problems(&second);
    assert_eq!(found.len(), 1, "{found:#?}");
    let wanted =
        "plant.toml:25: axis[1].sensor: gain takes a command, but the signal is a position here; ";
    assert!(found[0].starts_with(wanted), "{found:#?}");

    let nothing = "piezoloop = 1\nkind = \"plant\"\nname = \"p\"\nstep = 1e-3\n[[axis]]\n\
                   command = { unit = \"V\" }\nposition = { unit = \"um\" }\n";
    let found = problems(nothing);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(
        found[0].starts_with("plant.toml:5: axis[1]: the chain ends with the wrong signal: add ")
    );

    // An unknown type hides what it does to the signal, so that nothing is reported about the order.
    let unknown = PLANT.replacen("type = \"plays\"", "type = \"play\"", 1);
    let found = problems(&unknown);
    assert_eq!(found.len(), 1, "{found:#?}");
    // A wrong value elsewhere does not hide the order.
    let both = second.replacen("\"2.1 kHz\"", "-1", 1);
    assert_eq!(problems(&both).len(), 2);
    let both = second.replacen("\"20 us\"", "0", 1);
    assert_eq!(problems(&both).len(), 2);
}

#[test]
fn what_cannot_be_switched_off_is_reported() {
    let found = only_problem("name = \"hysteresis\"", "name = \"hysteresis\"\nenabled = false");
    assert!(
        found.contains("axis[1].hysteresis: enabled = false: plays cannot be switched off"),
        "{found}"
    );
}

#[test]
fn a_model_that_no_machine_can_hold_is_refused_before_memory_is_asked_for() {
    let found =
        only_problem("type = \"lag\"\nbandwidth = \"2.1 kHz\"", "type = \"delay\"\nlongest = 1e6");
    assert!(found.contains("axis[1].delay: needs 50000000"), "{found}");
    let found = problems(&PLANT.replacen("\"20 us\"", "1e-300", 1).replacen(
        "type = \"lag\"\nbandwidth = \"2.1 kHz\"",
        "type = \"delay\"",
        1,
    ));
    assert_eq!(found.len(), 1, "{found:#?}");
}

#[test]
fn what_is_no_toml_is_reported_with_every_line() {
    let error = Blueprint::parse("piezoloop = \nname = \"a\nkind 3\n", "p.toml").unwrap_err();
    let lines: Vec<_> = error.as_slice().iter().map(|problem| problem.line).collect();
    assert_eq!(lines, [Some(1), Some(2), Some(3)], "{error}");
    assert!(error.to_string().starts_with("p.toml:1: is not valid TOML: "), "{error}");
}

#[test]
fn another_format_is_reported_alone() {
    let text = PLANT.replacen("piezoloop = 1", "piezoloop = 2\nnew_key = 1", 1);
    let error = Blueprint::parse(&text, "p.toml").unwrap_err();
    assert_eq!(error.as_slice().len(), 1);
    assert!(error.to_string().starts_with("p.toml:1: piezoloop = 2: is a format "), "{error}");
}

#[test]
fn sections_of_the_wrong_kind_are_reported() {
    for (old, new, wanted) in [
        ("[[axis]]", "[axis]", "axis: must be a list of sections; write the header [[axis]]"),
        ("position = { name = \"y\", unit = \"um\" }", "position = \"um\"", "must be a table"),
        ("tolerance = { w = 0.05 }", "tolerance = 0.05", "must be a table"),
        ("name = \"y\", ", "name = \"y\", gain = 3, ", "axis[1].position.gain: is no key"),
    ] {
        let text = PLANT.replacen(old, new, 1);
        let found = match Blueprint::parse(&text, "p.toml") {
            Ok(blueprint) => blueprint.check(REGISTRY).unwrap_err().to_string(),
            Err(error) => error.to_string(),
        };
        let is_syntax = found.contains("is not valid TOML");
        assert!(is_syntax || found.contains(wanted), "wanted {wanted}\nfound {found}");
    }
}

#[test]
fn a_file_that_is_absent_or_no_text_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("absent.toml");
    let error = Blueprint::read(&path).unwrap_err().to_string();
    assert!(error.contains("absent.toml: cannot be read: "), "{error}");
    std::fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
    let error = Blueprint::read(&path).unwrap_err().to_string();
    assert!(error.ends_with("save it as UTF-8 text"), "{error}");
}
