//! Which numbers have bounds, and that a built system refuses what is outside them.

use std::collections::BTreeMap;
use std::path::Path;

use learned::COMPONENTS;
use model::{
    AxisSpec, BuildError, ComponentRef, Connections, Kind, NodeSpec, Quantity, SetError, System,
    SystemSpec, Variable, Within,
};

const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// The names in the table of docs/fmi.md that says which parameters have no bound, and how often.
fn documented() -> BTreeMap<String, usize> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/fmi.md");
    let page = std::fs::read_to_string(page).expect("the page");
    let (_, after) = page.split_once("\n## Numbers without bounds\n").expect("the section");
    let section = after.split("\n## ").next().expect("text");
    let mut names = BTreeMap::new();
    for row in section.lines().filter(|line| line.starts_with("| parameter")) {
        let cell = row.split('|').nth(2).expect("a column of names");
        for name in cell.split('`').skip(1).step_by(2) {
            *names.entry(name.to_owned()).or_default() += 1;
        }
    }
    names
}

fn is_free(quantity: &Quantity) -> bool {
    quantity.within == Within::Any && (quantity.min, quantity.max) == FREE
}

#[test]
fn the_quantities_without_a_bound_are_those_of_the_documentation() {
    let documented = documented();
    let all = || COMPONENTS.iter().map(|component| component.declaration());
    for declaration in all() {
        for quantity in declaration.parameters.iter().filter(|quantity| is_free(quantity)) {
            let name = format!("{}.{}", declaration.kind, quantity.name);
            let known = documented.contains_key(quantity.name);
            assert!(known, "{name} has no bound, and docs/fmi.md gives no reason");
        }
    }
    for (name, times) in documented {
        assert_eq!(times, 1, "{name} stands in docs/fmi.md more than once");
        let mut quantities = all().flat_map(|declaration| declaration.parameters);
        let still = quantities.any(|quantity| quantity.name == name && is_free(quantity));
        assert!(still, "docs/fmi.md says that {name} has no bound, but it has");
    }
}

fn node(kind: &str, structure: &[f64], values: &[f64]) -> NodeSpec {
    let component = COMPONENTS.iter().find(|c| c.declaration().kind == kind).expect("registered");
    NodeSpec {
        component: ComponentRef::from(*component),
        name: component.declaration().name.into(),
        structure: structure.to_vec(),
        values: values.to_vec(),
        enabled: true,
    }
}

fn system(kind: Kind, components: Vec<NodeSpec>) -> Result<System, Vec<BuildError>> {
    let axis = AxisSpec {
        name: "Y".into(),
        command_unit: "V".into(),
        position_unit: "um".into(),
        command_range: (-20.0, 120.0),
        position_range: (0.0, 6.0),
        start: 1.0,
        aliases: vec![],
        components,
    };
    let connections = Connections::default();
    System::new(&SystemSpec { name: "t".into(), kind, period: 1e-4, axes: vec![axis], connections })
}

fn variable<'a>(system: &'a System, name: &str) -> (u32, &'a Variable) {
    let reference = system.variables().find(name).unwrap_or_else(|| panic!("{name}"));
    (reference, system.variables().get(reference).expect("in the table"))
}

fn bounds(system: &System, name: &str) -> (f64, f64) {
    let (_, variable) = variable(system, name);
    (variable.min, variable.max)
}

fn feedforward() -> NodeSpec {
    node("feedforward-gain", &[], &[20.0, 0.0])
}

/// A controller whose pid has these limits.
fn controller(low: f64, high: f64) -> Result<System, Vec<BuildError>> {
    // kp, ki, kd, derivative_filter, output_min, output_max, feedforward_gain, rate_max,
    // tracking_time, hold, safe.
    let values = [1.0, 0.0, 0.0, 0.0, low, high, 1.0, 0.0, 0.0, 1.0, 0.0];
    system(Kind::Controller, vec![feedforward(), node("pid", &[], &values)])
}

#[test]
fn a_plant_and_a_controller_carry_the_ranges_of_their_axis() {
    let plant = system(Kind::Plant, vec![node("actuator-gain", &[], &[0.05, 0.0])]).expect("one");
    assert_eq!(bounds(&plant, "command[1]"), (-20.0, 120.0));
    assert_eq!(bounds(&plant, "position[1]"), (0.0, 6.0));
    let controller = controller(0.0, 100.0).expect("one");
    for name in ["reference[1]", "measured[1]"] {
        assert_eq!(bounds(&controller, name), (0.0, 6.0), "{name}");
    }
    for name in ["command[1]", "axis[1].pid.output_min", "axis[1].pid.output_max"] {
        assert_eq!(bounds(&controller, name), (-20.0, 120.0), "{name}");
    }
}

/// Whatever its inputs are, and its limits so far as they can be set.
#[test]
fn the_command_of_a_controller_with_limits_is_never_beyond_its_bounds() {
    let errors = controller(-20.0, 120.5).expect_err("a limit beyond the commands");
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert_eq!(errors[0].place, "axis[1].pid.output_max");
    assert!(errors[0].message.starts_with("120.5 V is outside -20 to 120 V"), "{errors:?}");

    let mut controller = controller(0.0, 100.0).expect("one");
    let [reference, measured, high, command] =
        ["reference[1]", "measured[1]", "axis[1].pid.output_max", "command[1]"]
            .map(|name| variable(&controller, name).0);
    let refused = controller.set(high, 120.5).expect_err("beyond the commands");
    let expected = SetError::OutOfRange { reference: high, value: 120.5, min: -20.0, max: 120.0 };
    assert_eq!(refused, expected);
    controller.initialise(0.0).expect("it rests");
    let mut reached = 0;
    for (k, limit) in [100.0, 120.0, 60.0].into_iter().cycle().take(30).enumerate() {
        controller.set(high, limit).expect("a command");
        // Inputs may be beyond what the axis is made for.
        let far = if k % 2 == 0 { 1e6 } else { -1e6 };
        controller.set(reference, far).expect("any number");
        controller.set(measured, -far).expect("any number");
        controller.advance((k + 1) as f64 * 1e-4).expect("a step");
        let found = controller.get(command).expect("an output");
        assert!((-20.0..=120.0).contains(&found), "{k}: {found}");
        reached += usize::from(found == limit);
    }
    assert!(reached >= 10, "{reached}");
}

/// What the length of a memory bounds: up to there it is taken, beyond it is refused at once.
#[test]
fn structural_settings_bound_what_needs_their_room() {
    let gain = || node("actuator-gain", &[], &[0.05, 0.0]);
    let creep = node("logarithmic-creep", &[0.01, 100.0], &[0.02, 0.1]);
    let plant = vec![node("delay", &[0.005], &[0.001]), gain(), creep];
    let clock = vec![node("clock-offset", &[0.02], &[0.01, 0.0, 0.0, 1.0]), gain()];
    let preview = vec![node("reference-preview", &[0.03], &[0.0]), feedforward()];
    let observer =
        vec![node("disturbance-observer", &[0.04], &[10.0, 0.0, 0.0, 1.0]), feedforward()];
    for (kind, components, name, (least, greatest)) in [
        (Kind::Plant, plant.clone(), "axis[1].delay.delay", (0.0, 0.005)),
        (Kind::Plant, plant, "axis[1].creep.reference", (0.01, 100.0)),
        (Kind::Plant, clock, "axis[1].clock.initial", (0.0, 0.02)),
        (Kind::Controller, preview, "axis[1].preview.preview", (0.0, 0.03)),
        (Kind::Controller, observer, "axis[1].observer.delay", (0.0, 0.04)),
    ] {
        let mut system = system(kind, components).unwrap_or_else(|e| panic!("{name}: {e:?}"));
        assert_eq!(bounds(&system, name), (least, greatest), "{name}");
        let (reference, _) = variable(&system, name);
        for value in [least, 0.5 * (least + greatest), greatest] {
            system.set(reference, value).unwrap_or_else(|e| panic!("{name} = {value}: {e}"));
            system.initialise(0.0).unwrap_or_else(|e| panic!("{name}: {}", system.explain(&e)));
        }
        for value in [least - 1e-3, greatest * 1.001] {
            let refused = system.set(reference, value).expect_err(name);
            assert!(matches!(refused, SetError::OutOfRange { .. }), "{name}: {refused}");
        }
    }
}
