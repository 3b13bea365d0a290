//! Couplings and inputs on demand in blueprints: what they say, and every refusal with its line.

use data::Blueprint;
use model::{
    Causality, Component, Conversion, Declaration, Input, Quantity, Registry, Sizes, Stage,
    Structural, Tick, Violation,
};

static REGISTRY: Registry = &[
    &Sum(&GAIN),
    &Sum(&PUSH),
    &Sum(&CROSS),
    &Sum(&OPTICS),
    &Sum(&DETECTOR),
    &Sum(&SENSOR),
    &Sum(&LAW),
];

static GAIN: Declaration = Declaration {
    kind: "gain",
    name: "gain",
    conversion: Conversion::CommandToPosition,
    parameters: &[Quantity::new("gain", "{position}/{command}", "Gain")],
    ..Declaration::PATH
};
static PUSH: Declaration = Declaration {
    kind: "push",
    name: "push",
    stage: Stage::Mechanics,
    inputs: &[Input::PATH, Input::FORCE],
    parameters: &[Quantity::new("stiffness", "N/{position}", "Stiffness")],
    ..Declaration::PATH
};
static SENSOR: Declaration = Declaration {
    kind: "sensor",
    name: "sensor",
    stage: Stage::Sensor,
    parameters: &[Quantity::new("offset", "{position}", "Offset")],
    ..Declaration::PATH
};
static LAW: Declaration = Declaration {
    kind: "law",
    name: "law",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    parameters: &[Quantity::new("gain", "{command}/{position}", "Gain")],
    ..Declaration::PATH
};
const MATRIX: [Structural; 2] = [
    Structural::count("axes", "Number of axes", 2, 8),
    Structural::count("entries", "Number of entries", 4, 64),
];
static CROSS: Declaration = Declaration {
    kind: "cross",
    name: "cross",
    stage: Stage::Coupling,
    inputs: &[Input::EACH_PATH],
    structure: &MATRIX,
    parameters: &[Quantity::new("matrix", "1", "Matrix").per(1)],
    ..Declaration::PATH
};
static OPTICS: Declaration = Declaration {
    kind: "optics",
    name: "optics",
    conversion: Conversion::MotionToPosition,
    parameters: &[
        Quantity::new("matrix", "{position}/{command}", "Matrix").per(1),
        Quantity::new("offset", "{position}", "Offset").per(0),
    ],
    ..CROSS
};
static DETECTOR: Declaration = Declaration {
    kind: "detector",
    name: "detector",
    structure: &[MATRIX[0]],
    parameters: &[Quantity::new("half_size", "{position}", "Half size")],
    ..CROSS
};

/// Passes its path, or adds the paths of a coupling; only what the check says of it matters here.
struct Sum(&'static Declaration);

impl Component for Sum {
    fn declaration(&self) -> &'static Declaration {
        self.0
    }
    fn sizes(&self, _: &[f64], _: f64) -> Sizes {
        Sizes::default()
    }
    fn prepare(&self, _: &[f64], p: &[f64], _: f64, _: &mut [f64]) -> Result<(), Violation> {
        let broken =
            Violation { quantity: "matrix", index: Some(2), value: p[0], rule: "bad; mend" };
        if p[0] == 666.0 { Err(broken) } else { Ok(()) }
    }
    fn rest(&self, _: &[f64], inputs: &[f64], _: &mut [f64], outputs: &mut [f64]) {
        outputs.fill(inputs.iter().sum());
    }
    fn step(&self, c: &[f64], state: &mut [f64], _: Tick, inputs: &[f64], outputs: &mut [f64]) {
        self.rest(c, inputs, state, outputs);
    }
}

const PLANT: &str = r#"piezoloop = 1
kind = "plant"
name = "beam"
step = 1e-3

[[axis]]
name = "A"
command = { name = "u1", unit = "V" }
position = { name = "x", unit = "um" }
motion = { unit = "urad" }
force = { name = "f", unit = "mN", start = 2 }

[[axis.component]]
type = "gain"
gain = "5 urad/V"

[[axis.component]]
type = "push"
stiffness = 1

[[axis.component]]
type = "sensor"
offset = "1 mm"

[[axis]]
name = "B"
command = { name = "u2", unit = "V" }
position = { name = "y", unit = "um" }
motion = { unit = "urad" }

[[axis.component]]
type = "gain"
gain = 5

[[axis.component]]
type = "sensor"
offset = 0

[[coupling]]
type = "optics"
axes = ["A", "B"]
matrix = [[1, 0.1], ["0.2 m/rad", 2]]
offset = [-3, 4]
"#;

const CONTROLLER: &str = r#"piezoloop = 1
kind = "controller"
name = "law"
step = 1e-3

[[axis]]
command = { unit = "V" }
position = { unit = "um" }

[[axis.component]]
type = "law"
gain = 5
"#;

fn problems(text: &str) -> String {
    let blueprint = Blueprint::parse(text, "beam.toml").unwrap_or_else(|e| panic!("{e}"));
    blueprint.check(REGISTRY).map_or_else(|problems| problems.to_string(), |_| String::new())
}

fn with(old: &str, new: &str) -> String {
    assert!(PLANT.contains(old), "{old}");
    problems(&PLANT.replacen(old, new, 1))
}

#[test]
fn couplings_take_the_units_of_motion_in_front_and_of_position_behind() {
    let blueprint = Blueprint::parse(PLANT, "beam.toml").unwrap();
    let checked = blueprint.check(REGISTRY).unwrap_or_else(|e| panic!("{e}"));
    let table = checked.system().variables();
    let unit = |name: &str| table.get(table.find(name).expect(name)).unwrap().unit.clone();
    assert_eq!(unit("axis[1].gain.gain"), "urad/V");
    assert_eq!(unit("axis[1].push.stiffness"), "N/urad");
    assert_eq!(unit("axis[1].sensor.offset"), "um");
    assert_eq!(unit("coupling.optics.matrix[3]"), "um/urad");
    assert_eq!(unit("coupling.optics.offset[2]"), "um");
    let start = |name: &str| table.get(table.find(name).expect(name)).unwrap().start.unwrap();
    assert_eq!(start("coupling.optics.matrix[3]"), 0.2);
    assert_eq!(start("axis[1].sensor.offset"), 1000.0);
    assert_eq!((start("force[1]"), unit("force[1]").as_str()), (2.0, "mN"));
    assert_eq!(table.find("f"), table.find("force[1]"));
    let inputs: Vec<_> = table.with(Causality::Input).map(|(_, v)| v.name.as_str()).collect();
    assert_eq!(inputs, ["command[1]", "command[2]", "force[1]"]);
    let again = Blueprint::parse(&blueprint.to_toml(), "again.toml").unwrap();
    assert_eq!(again, blueprint);
}

#[test]
fn what_stands_behind_the_optics_has_the_unit_of_the_position() {
    let detector =
        "[[coupling]]\ntype = \"detector\"\naxes = [\"A\", \"B\"]\nhalf_size = \"5 mm\"\n";
    let half_size = |text: String| {
        let blueprint = Blueprint::parse(&text, "beam.toml").unwrap();
        let checked = blueprint.check(REGISTRY).map_err(|problems| problems.to_string())?;
        let table = checked.system().variables();
        let variable = table.get(table.find("coupling.detector.half_size").unwrap()).unwrap();
        Ok::<_, String>((variable.start.unwrap(), variable.unit.clone()))
    };
    assert_eq!(half_size(format!("{PLANT}{detector}")), Ok((5000.0, "um".to_owned())));
    // In front of the optics it would be a motion.
    let front = PLANT.replacen("[[coupling]]", &format!("{detector}[[coupling]]"), 1);
    let message = half_size(front).unwrap_err();
    assert!(message.contains("half_size") && message.contains("urad"), "{message}");
}

#[test]
fn what_is_wrong_with_a_coupling_is_reported_with_its_line() {
    for (old, new, wanted) in [
        (
            "axes = [\"A\", \"B\"]",
            "axes = [\"A\", \"C\"]",
            "beam.toml:41: coupling.optics.axes[2] = \"C\": is no axis of this model",
        ),
        (
            "axes = [\"A\", \"B\"]",
            "axes = [\"A\", \"A\"]",
            "beam.toml:41: coupling.optics.axes[2] = \"A\": is named twice",
        ),
        (
            "axes = [\"A\", \"B\"]",
            "axes = [\"A\"]",
            "beam.toml:41: coupling.optics.axes = 1: must be 2 to 8 axes",
        ),
        (
            "axes = [\"A\", \"B\"]",
            "axes = \"A\"",
            "beam.toml:41: coupling[1].axes = \"A\": must be a list of texts",
        ),
        (
            "offset = [-3, 4]",
            "offset = [-3, 4]\nafter = \"lens\"",
            "beam.toml:44: coupling.optics.after = \"lens\": axis A has no such component; name one that every coupled axis has, of gain, push, sensor",
        ),
        (
            "[\"0.2 m/rad\", 2]",
            "[\"0.2 m\", 2]",
            "beam.toml:42: coupling.optics.matrix[3] = \"0.2 m\": the unit m does not measure the same as um/urad",
        ),
        (
            "[\"0.2 m/rad\", 2]",
            "[0.2]",
            "beam.toml:42: coupling.optics.matrix[2]: must be a row of 2 values",
        ),
        (
            "matrix = [[1,",
            "matrix = [[666,",
            "beam.toml:42: coupling.optics.matrix[3] = 666 um/urad: bad; mend",
        ),
        (
            "type = \"optics\"",
            "type = \"gain\"",
            "coupling[1].type = \"gain\": couples no axes; put it in an [[axis.component]]",
        ),
        ("type = \"optics\"", "type = \"optic\"", "did you mean \"optics\"?"),
        (
            "type = \"push\"\nstiffness = 1",
            "type = \"cross\"",
            "\"cross\": is no part of one axis; put it in a [[coupling]]",
        ),
        ("unit = \"mN\"", "unit = \"mV\"", "force.unit = \"mV\": does not measure the same as N"),
        (
            "motion = { unit = \"urad\" }\nforce",
            "force",
            "axis[1].gain.gain = \"5 urad/V\": the unit urad/V does not measure the same as um/V",
        ),
        (
            "step = 1e-3",
            "step = 1e-3\ntemperature = { start = 20 }",
            "temperature: is read by no component",
        ),
    ] {
        let found = with(old, new);
        assert!(found.contains(wanted), "wanted {wanted}\nfound {found}");
    }
    let twice = format!("{PLANT}\n[[coupling]]\ntype = \"optics\"\naxes = [\"A\", \"B\"]\n");
    assert!(problems(&twice).contains("is the name of another coupling"), "{}", problems(&twice));
    let none = PLANT.split("[[coupling]]").next().unwrap();
    let found = problems(none);
    assert!(found.contains("the motion in urad is never turned into a position in um"), "{found}");
}

#[test]
fn a_controller_has_neither_force_nor_optics_nor_an_idle_motion() {
    let text = PLANT.replacen("\"plant\"", "\"controller\"", 1);
    let found = problems(&text);
    for place in ["axis[1].force", "coupling[1]"] {
        let wanted = format!("{place}: belongs to a plant; leave it out of a controller");
        assert!(found.contains(&wanted), "wanted {wanted}\nfound {found}");
    }
    let axis = "position = { unit = \"um\" }";
    let idle = CONTROLLER.replacen(axis, &format!("{axis}\nmotion = {{ unit = \"urad\" }}"), 1);
    let found = problems(&idle);
    let motion = "axis[1]: the position in um is never turned into a motion in urad";
    assert!(found.contains(motion), "{found}");
    assert_eq!(problems(CONTROLLER), "");
}
