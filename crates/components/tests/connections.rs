//! Ports beyond the signal path: couplings between axes, inputs on demand, signals read back.

use components::find;
use model::{
    AxisSpec, BuildError, Causality, Connections, CouplingSpec, InputSpec, Kind, NodeSpec, System,
    SystemSpec,
};

const T: f64 = 1e-4;

fn node(kind: &str, name: &str, structure: &[f64], values: &[f64]) -> NodeSpec {
    let component = find(kind).unwrap_or_else(|| panic!("{kind} is not registered"));
    let (structure, values) = (structure.to_vec(), values.to_vec());
    NodeSpec { component: component.into(), name: name.into(), structure, values, enabled: true }
}

fn axis(name: &str, components: Vec<NodeSpec>) -> AxisSpec {
    AxisSpec {
        name: name.into(),
        command_unit: "V".into(),
        position_unit: "um".into(),
        command_range: (-200.0, 200.0),
        position_range: (f64::NEG_INFINITY, f64::INFINITY),
        start: 0.0,
        aliases: vec![],
        components,
    }
}

fn chain(gain: f64, frequency: f64) -> Vec<NodeSpec> {
    vec![
        node("actuator-gain", "gain", &[], &[gain, 0.0]),
        node("mode", "mechanics", &[], &[frequency, 0.05, 1.0]),
        node("sensor-lag", "sensor", &[], &[1000.0]),
    ]
}

fn build(axes: Vec<AxisSpec>, connections: Connections) -> Result<System, Vec<BuildError>> {
    System::new(&SystemSpec { name: "t".into(), kind: Kind::Plant, period: T, axes, connections })
}

fn coupling(node: NodeSpec, after: Option<&str>) -> CouplingSpec {
    CouplingSpec { node, axes: vec![0, 1], after: after.map(Into::into) }
}

fn coupled(node: NodeSpec, after: Option<&str>) -> Result<System, Vec<BuildError>> {
    let axes = vec![axis("Y", chain(0.05, 480.0)), axis("Z", chain(0.08, 290.0))];
    let couplings = vec![coupling(node, after)];
    build(axes, Connections { couplings, ..Connections::default() })
}

fn vr(system: &System, name: &str) -> u32 {
    system.variables().find(name).unwrap_or_else(|| panic!("no variable {name}"))
}

fn value(system: &System, name: &str) -> f64 {
    system.get(vr(system, name)).expect("in the table")
}

fn set(system: &mut System, name: &str, value: f64) {
    system.set(vr(system, name), value).unwrap_or_else(|e| panic!("{}", system.explain_set(&e)));
}

fn messages(built: Result<System, Vec<BuildError>>) -> Vec<String> {
    built.expect_err("refused").iter().map(ToString::to_string).collect()
}

#[test]
fn static_coupling_adds_the_neighbours_motion_and_nothing_else() {
    let matrix = [0.0, 0.02, 0.0, 0.0];
    let with = node("displacement-coupling", "cross", &[2.0, 4.0], &matrix);
    let mut with = coupled(with, None).expect("valid");
    let alone = vec![axis("Y", chain(0.05, 480.0)), axis("Z", chain(0.08, 290.0))];
    let mut alone = build(alone, Connections::default()).expect("valid");
    let mut swapped =
        build(vec![axis("Y", chain(0.08, 290.0))], Connections::default()).expect("valid");
    assert_eq!(value(&with, "coupling.cross.matrix[2]"), 0.02);
    for n in 1..400 {
        let t = f64::from(n) * T;
        let (u, v) = (10.0 * (300.0 * t).sin(), 20.0 * (700.0 * t).cos());
        for system in [&mut with, &mut alone] {
            set(system, "command[1]", u);
            set(system, "command[2]", v);
            system.advance(t).expect("finite");
        }
        set(&mut swapped, "command[1]", v);
        swapped.advance(t).expect("finite");
        // All blocks are linear, so the neighbour's share is what the sensor makes of its motion.
        let share = value(&with, "position[1]") - value(&alone, "position[1]");
        let expected = 0.02 * value(&swapped, "position[1]");
        assert!((share - expected).abs() < 1e-12, "{n}: {share} {expected}");
        assert_eq!(value(&with, "position[2]"), value(&alone, "position[2]"));
    }
}

#[test]
fn command_and_mode_coupling_agree_at_rest_and_the_mode_rings() {
    let matrix = [0.0, 3e-3, 0.0, 0.0];
    let prompt = node("command-coupling", "cross", &[2.0, 4.0], &matrix);
    let with_mode = [&matrix[..], &[480.0, 290.0, 0.05, 0.01]].concat();
    let ringing = node("mode-coupling", "cross", &[2.0, 4.0], &with_mode);
    let (mut prompt, mut ringing) =
        (coupled(prompt, None).expect("valid"), coupled(ringing, None).expect("valid"));
    let mut peaks = [0.0_f64; 2];
    for (system, peak) in [&mut prompt, &mut ringing].into_iter().zip(&mut peaks) {
        set(system, "command[2]", 100.0);
        for n in 1..20_000 {
            system.advance(f64::from(n) * T).expect("finite");
            *peak = peak.max(value(system, "position[1]"));
        }
        assert!((value(system, "position[1]") - 0.3).abs() < 1e-12);
    }
    assert!(peaks[0] < 0.3 + 1e-12 && peaks[1] > 0.5, "{peaks:?}");
}

#[test]
fn optics_turn_angles_into_coordinates_and_change_the_unit() {
    let axes = vec![axis("A", vec![node("actuator-gain", "gain", &[], &[0.01, 0.0])]); 2];
    let values = [500.0, 3.0, 14.0, -515.0, -260.0, 272.0];
    let optics = node("optics-jacobian", "optics", &[2.0, 4.0], &values);
    let couplings = vec![coupling(optics, None)];
    let motion_units = vec![Some("1".into()); 2];
    let connections = Connections { couplings, motion_units, ..Connections::default() };
    let mut system = build(axes, connections).expect("valid");
    let unit = |name: &str| system.variables().get(vr(&system, name)).expect("known").unit.clone();
    assert_eq!(unit("axis[1].gain.gain"), "1/V");
    assert_eq!(unit("coupling.optics.matrix[1]"), "um");
    assert_eq!(unit("position[2]"), "um");
    set(&mut system, "command[1]", 40.0);
    set(&mut system, "command[2]", 90.0);
    system.initialise(0.0).expect("valid");
    assert!((value(&system, "position[1]") - (500.0 * 0.4 + 3.0 * 0.9 - 260.0)).abs() < 1e-9);
    assert!((value(&system, "position[2]") - (14.0 * 0.4 - 515.0 * 0.9 + 272.0)).abs() < 1e-9);
}

/// A force F on the mode of stiffness k moves it by F/k at rest and rings at its frequency.
#[test]
fn the_load_force_is_an_input_only_where_it_is_read() {
    let mut loaded = chain(0.05, 480.0);
    loaded.insert(1, node("load-force", "load", &[], &[20.0]));
    let axes = vec![axis("Y", chain(0.05, 480.0)), axis("Z", loaded)];
    let inputs = vec![InputSpec {
        variable: "force[2]".into(),
        alias: Some("f".into()),
        unit: "mN".into(),
        start: 0.0,
    }];
    let mut system = build(axes, Connections { inputs, ..Connections::default() }).expect("valid");
    let names: Vec<_> =
        system.variables().with(Causality::Input).map(|(_, v)| v.name.clone()).collect();
    assert_eq!(names, ["command[1]", "command[2]", "force[2]"]);
    assert_eq!(system.variables().find("f"), Some(2));
    let position = system.variables().get(vr(&system, "position[2]")).expect("known");
    assert_eq!(position.initial_dependencies, Some(vec![1, 2]));
    set(&mut system, "force[2]", 30_000.0);
    let mut peak = 0.0_f64;
    for n in 1..10_000 {
        system.advance(f64::from(n) * T).expect("finite");
        peak = peak.max(value(&system, "position[2]"));
    }
    assert!((value(&system, "position[2]") - 1.5).abs() < 1e-9);
    assert!(peak > 2.5, "{peak}");
}

/// Charge reads the displacement, which is computed later: at rest both agree, in motion the charge
/// is one hit behind.
#[test]
fn charge_follows_the_displacement_of_the_hit_before() {
    let mut components = chain(0.05, 480.0);
    components.insert(0, node("piezo-charge", "electrical", &[], &[2e-6, 4e-6]));
    let mut system = build(vec![axis("Y", components)], Connections::default()).expect("valid");
    set(&mut system, "command[1]", 50.0);
    system.initialise(0.0).expect("valid");
    let charge = |v: f64, x: f64| 2e-6 * v + 4e-6 * x;
    assert!((value(&system, "charge[1]") - charge(50.0, 2.5)).abs() < 1e-18);
    assert_eq!(value(&system, "voltage[1]"), 50.0);
    assert_eq!(value(&system, "current[1]"), 0.0);
    set(&mut system, "command[1]", 60.0);
    system.advance(T).expect("finite");
    assert!((value(&system, "charge[1]") - charge(60.0, 2.5)).abs() < 1e-18);
    assert!((value(&system, "current[1]") - 2e-6 * 10.0 / T).abs() < 1e-12);
    let saved = system.context().clone();
    system.advance(5.0 * T).expect("finite");
    let after = value(&system, "charge[1]");
    system.restore(&saved).expect("same model");
    system.advance(5.0 * T).expect("finite");
    assert_eq!(value(&system, "charge[1]").to_bits(), after.to_bits());
}

#[test]
fn wrong_connections_are_refused_by_name() {
    let matrix = node("displacement-coupling", "cross", &[2.0, 4.0], &[0.0, 0.1, 0.1, 0.0]);
    let text = messages(coupled(matrix.clone(), Some("gearbox"))).join("\n");
    assert!(text.contains("coupling.cross.after: axis Y has no component \"gearbox\""), "{text}");

    let text = messages(coupled(node("mode", "cross", &[], &[1.0, 0.1, 1.0]), None)).join("\n");
    assert!(text.contains("mode is part of one axis; put it in an [[axis.component]]"), "{text}");

    let text = messages(build(vec![axis("Y", vec![matrix.clone()])], Connections::default()));
    assert!(text.join("\n").contains("put it in a [[coupling]] section"), "{text:?}");

    let mut bad = matrix.clone();
    bad.values[0] = 0.5;
    let text = messages(coupled(bad, None)).join("\n");
    assert!(text.contains("coupling.cross.matrix[1] = 0.5 (SI): is on the diagonal"), "{text}");

    let inputs =
        vec![InputSpec { variable: "force[1]".into(), alias: None, unit: "N".into(), start: 0.0 }];
    let axes = vec![axis("Y", chain(1.0, 100.0))];
    let text = messages(build(axes, Connections { inputs, ..Connections::default() })).join("\n");
    assert!(text.contains("force[1]: is read by no component"), "{text}");

    let motion_units = vec![Some("1".into())];
    let axes = vec![axis("Y", chain(1.0, 100.0))];
    let connections = Connections { motion_units, ..Connections::default() };
    let text = messages(build(axes, connections)).join("\n");
    assert!(text.contains("the motion in 1 is never turned into a position in um"), "{text}");

    let mut other = axis("Z", chain(0.08, 290.0));
    other.position_unit = "urad".into();
    let axes = vec![axis("Y", chain(0.05, 480.0)), other];
    let couplings = vec![coupling(matrix.clone(), None)];
    let text = messages(build(axes, Connections { couplings, ..Connections::default() }));
    assert!(text.join("\n").contains("give the axes that it couples the same units"), "{text:?}");
}

/// Two couplings at the same place act in their order; opposite orders are refused.
#[test]
fn couplings_have_one_order() {
    let cross =
        |name: &str| node("displacement-coupling", name, &[2.0, 4.0], &[0.0, 0.1, 0.2, 0.0]);
    let axes = || vec![axis("Y", chain(0.05, 480.0)), axis("Z", chain(0.08, 290.0))];
    let couplings = vec![coupling(cross("one"), None), coupling(cross("two"), None)];
    let mut system =
        build(axes(), Connections { couplings, ..Connections::default() }).expect("valid");
    set(&mut system, "command[1]", 100.0);
    system.initialise(0.0).expect("valid");
    // (1 + K)² on (5, 0): K has 0.1 and 0.2 beside the diagonal.
    assert!((value(&system, "position[1]") - 5.0 * 1.02).abs() < 1e-12);
    assert!((value(&system, "position[2]") - 5.0 * 0.4).abs() < 1e-12);

    let mut crossed = axes();
    crossed[1].components.swap(1, 2);
    let couplings =
        vec![coupling(cross("one"), Some("mechanics")), coupling(cross("two"), Some("sensor"))];
    let text = messages(build(crossed, Connections { couplings, ..Connections::default() }));
    assert!(text.join("\n").contains("is behind another coupling on one axis"), "{text:?}");
}
