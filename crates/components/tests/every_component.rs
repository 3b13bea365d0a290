//! What holds for every component type, tried on an example of each.
//!
//! A new component fails here until it has its line in `EXAMPLES`.

use components::{COMPONENTS, find};
use model::{
    AxisSpec, Causality, Component, Connections, Conversion, CouplingSpec, DataType, Declaration,
    Input, Kind, NodeSpec, Source, Stage, System, SystemSpec, Unit, unit_on_axis,
};
use proptest::prelude::*;

const T: f64 = 1e-4;

/// Kind, structure, parameters in the declared units with V and um.
type Example = (&'static str, &'static [f64], &'static [f64]);

const EXAMPLES: &[Example] = &[
    ("delay", &[0.01], &[2.35e-4]),
    ("clock-offset", &[0.01], &[2e-3, 5e-5, 1e-5, 4.0]),
    ("dac-quantisation", &[], &[0.01]),
    ("amplifier-lag", &[], &[800.0, 1.1]),
    ("amplifier-second-order", &[], &[900.0, 0.7, 1.0]),
    ("amplifier-rc", &[], &[100.0, 1e-6, 0.05, 1.1, 2e-6]),
    ("amplifier-slew", &[], &[5000.0]),
    ("amplifier-foldback", &[], &[0.02, 0.1, 1e-6, 0.5]),
    ("amplifier-clamp", &[], &[-20.0, 120.0, 2.0]),
    ("amplifier-nonlinearity", &[], &[0.1, 1e-3, -2e-3, 50.0, 70.0]),
    ("piezo-charge", &[], &[1.8e-6, 2e-6]),
    ("polarisation-saturation", &[], &[0.02, 50.0, 70.0]),
    ("actuator-gain", &[], &[0.05, 0.3]),
    ("actuator-temperature", &[], &[0.002, 35.0, 20.0]),
    ("actuator-ageing", &[], &[0.03, 10.0]),
    ("self-heating", &[], &[0.02, 1e-6, 50.0, 20.0, 1e-3, 0.01, 1.0, 1.0]),
    ("prandtl-ishlinskii", &[3.0], &[0.0, 8.0, 20.0, 0.05, 0.02, 0.01, 0.3]),
    (
        "modified-prandtl-ishlinskii",
        &[3.0, 2.0],
        &[0.0, 8.0, 20.0, 0.05, 0.02, 0.01, -1.0, 3.0, 0.1, -0.2, 0.3],
    ),
    (
        "skewed-play",
        &[3.0],
        &[
            0.0, 8.0, 20.0, 0.05, 0.02, 0.01, 0.0, 0.004, -0.002, 0.3, 0.01, 0.2, 0.1, -0.05, 50.0,
            70.0,
        ],
    ),
    (
        "generalised-play",
        &[3.0],
        &[
            0.0, 8.0, 20.0, 0.05, 0.02, 0.01, 0.3, 180.0, 0.006, -0.05, 2.0, 200.0, 0.0055, 0.02,
            3.0,
        ],
    ),
    ("preisach", &[6.0], &[0.5, 1.0, 0.2, 0.1, 0.3, 0.7, -20.0, 120.0, 0.3]),
    ("bouc-wen", &[], &[0.06, 0.2, 0.02, 0.01, 0.002, 1.3, 0.3]),
    ("duhem", &[], &[0.06, 0.04, 0.05, 0.3]),
    ("dahl", &[], &[0.06, 0.4, 20.0, 0.3]),
    ("rate-dependent-play", &[2.0], &[4.0, 12.0, 0.02, 0.01, 0.3, 0.05, 1e-5]),
    ("lagging-play", &[2.0], &[4.0, 12.0, 0.02, 0.01, 0.3, 0.05, 150.0]),
    ("grpi", &[2.0], &[0.0, 12.0, 0.05, 0.01, 0.3, 1.02, -1e-5, 0.99, 2e-5]),
    ("mpi", &[2.0], &[4.0, 12.0, 0.02, 0.01, 0.3, 0.05, 1e-8, 1.1, 1e-5]),
    (
        "dynamic-prandtl-ishlinskii",
        &[2.0, 4.0],
        &[0.0, 12.0, 0.05, 0.01, -1e-8, -1e-8, 1e-8, 1e-8, 1e-13, 1e-13, 1e-13, 1e-13, 0.3],
    ),
    ("remanence", &[], &[0.5, 40.0]),
    ("kelvin-voigt-creep", &[2.0], &[0.02, 0.03, 0.1, 5.0]),
    ("logarithmic-creep", &[0.01, 1e4], &[0.015, 0.1]),
    ("fractional-creep", &[1e-3, 100.0], &[0.05]),
    ("load-force", &[], &[20.0]),
    ("mode", &[], &[482.6, 0.02, 1.1]),
    ("mode-pair", &[], &[482.6, 0.02, 1200.0, 0.01, 0.1]),
    ("arx", &[2e-4, 2.0, 2.0], &[0.2, -0.1, -1.2, 0.3]),
    ("collocated-mode", &[], &[482.6, 0.02, 350.0, 0.03]),
    ("loaded-mode", &[], &[482.6, 0.02, 0.3, 0.05, 1e4]),
    ("duffing", &[], &[482.6, 0.02, 0.02, 5.0]),
    ("position-stiffness", &[], &[482.6, 0.02, 0.1, 0.05, 3.0, 5.0]),
    ("friction", &[], &[482.6, 0.02, 0.05, 0.07, 0.01, 100.0]),
    ("nonlinear-damping", &[], &[482.6, 0.02, 0.05, 40.0, 1e-6]),
    ("backlash", &[], &[0.05, 0.2]),
    ("cutting-force", &[], &[0.1, 100.0, 0.3, 0.5]),
    ("vibration", &[2.0], &[30.0, 70.0, 0.02, 0.01, 0.5, 1.0]),
    ("command-coupling", &[2.0, 4.0], &[0.0, 1e-3, 2e-3, 0.0]),
    ("displacement-coupling", &[2.0, 4.0], &[0.0, 0.02, -0.03, 0.0]),
    ("mode-coupling", &[2.0, 4.0], &[0.0, 1e-3, 2e-3, 0.0, 480.0, 290.0, 0.02, 0.03]),
    (
        "modal-matrix",
        &[2.0, 4.0, 1.0, 4.0],
        &[0.3, 0.0, 0.0, 0.2, 480.0, 0.02, 0.7, 0.1, -0.2, 0.8, 0.01, 0.0, 0.0, -0.01],
    ),
    ("optics-jacobian", &[2.0, 4.0], &[1.0, 0.02, -0.03, 0.9, 3.0, -2.0]),
    ("psd-pincushion", &[2.0], &[0.01, 5000.0]),
    ("thermal-drift", &[], &[1e-3, 0.1, 100.0, 0.05, 1.0]),
    ("thermal-expansion", &[], &[0.02, 0.01, 20.0]),
    ("disturbance", &[], &[1.0]),
    ("floor-vibration", &[], &[0.01, 10.0, 0.1, 5.0]),
    ("sensor-lag", &[], &[1500.0]),
    ("sensor-second-order", &[], &[1500.0, 0.7]),
    ("sensor-butterworth", &[5.0], &[1500.0]),
    ("sensor-scale", &[], &[1.02, 0.1]),
    ("sensor-polynomial", &[], &[1e-3, 2e-3, 3.0, 5.0]),
    ("sensor-quad-cell", &[], &[30.0, 3.0]),
    ("sensor-noise", &[0.01], &[0.002, 10.0, 6.0]),
    ("sensor-drift", &[], &[0.05, 7.0]),
    ("mains-hum", &[2.0], &[0.01, 0.005, 0.2, 0.4, 50.0]),
    ("crosstalk", &[], &[1e-3, 1e-6]),
    ("sensor-quantisation", &[], &[0.001]),
    ("inverse-prandtl-ishlinskii", &[3.0], &[0.0, 8.0, 20.0, 0.05, 0.02, 0.01, 0.3]),
    (
        "inverse-modified-prandtl-ishlinskii",
        &[3.0, 2.0],
        &[0.0, 8.0, 20.0, 0.05, 0.02, 0.01, -1.0, 3.0, 0.1, -0.2, 0.3],
    ),
    (
        "inverse-generalised-play",
        &[3.0],
        &[
            0.0, 8.0, 20.0, 0.05, 0.02, 0.01, 0.3, 180.0, 0.006, -0.05, 2.0, 200.0, 0.0055, 0.02,
            3.0,
        ],
    ),
    ("inverse-preisach", &[6.0], &[0.5, 1.0, 0.2, 0.1, 0.3, 0.7, -20.0, 120.0, 0.3]),
    ("inverse-bouc-wen", &[], &[0.06, 0.2, 0.02, 0.01, 0.002, 1.0, 0.3, -20.0, 150.0]),
    ("inverse-duhem", &[], &[0.06, 0.04, 0.05, 0.3, -20.0, 150.0]),
    ("inverse-dahl", &[], &[0.06, 0.4, 20.0, 0.3, -20.0, 150.0]),
    (
        "inverse-rate-dependent-play",
        &[2.0],
        &[4.0, 12.0, 0.02, 0.01, 0.3, 0.05, 1e-5, -20.0, 150.0],
    ),
    ("inverse-grpi", &[2.0], &[0.0, 12.0, 0.05, 0.01, 0.3, 1.02, -1e-5, 0.99, 2e-5, -20.0, 150.0]),
    ("inverse-mpi", &[2.0], &[4.0, 12.0, 0.02, 0.01, 0.3, 0.05, 1e-8, 1.1, 1e-5, -20.0, 150.0]),
    (
        "inverse-dynamic-prandtl-ishlinskii",
        &[2.0, 4.0],
        &[
            0.0, 12.0, 0.05, 0.01, -1e-8, -1e-8, 1e-8, 1e-8, 1e-13, 1e-13, 1e-13, 1e-13, 0.3,
            -20.0, 150.0,
        ],
    ),
    ("jacobian-coordinator", &[2.0, 4.0], &[1.0, 0.02, -0.03, 0.9, 3.0, -2.0, 1000.0]),
    ("reference-preview", &[0.01], &[2.35e-4]),
    ("reference-filter", &[], &[200.0, 0.8]),
    ("disturbance-observer", &[0.1], &[10.0, 1e-3, 2.35e-4, 0.5]),
    ("reference-lead", &[], &[1e-3, 1e-7, 0.5]),
    ("inverse-kelvin-voigt-creep", &[2.0], &[0.02, 0.03, 0.1, 5.0]),
    ("reference-curve", &[3.0], &[0.0, 4.0, 9.0, 0.1, 3.8, 9.5]),
    ("feedforward-gain", &[], &[15.0, 0.3]),
    ("bouc-wen-feedforward", &[], &[0.06, 0.2, 0.02, 0.01, 1e-4, 1e-7, 0.5]),
    ("command-curve", &[3.0], &[0.0, 50.0, 120.0, -2.0, 52.0, 118.0]),
    ("notch", &[], &[480.0, 0.5, 0.1]),
    ("repetitive", &[0.01, 5.0], &[0.5, 3e-4, 0.99, 20.0]),
    ("pid", &[], &[2.0, 300.0, 1e-4, 0.0, 0.0, 120.0, 0.9, 5e5, 0.0, 1.0, 20.0]),
    ("incremental-pid", &[], &[2.0, 300.0, 1e-4, 0.0, 120.0, 0.9, 5e5, 1.0, 20.0]),
];

fn node((kind, structure, values): &Example) -> NodeSpec {
    let component = find(kind).unwrap_or_else(|| panic!("{kind} is not registered"));
    let name = component.declaration().name.to_string();
    let (structure, values) = (structure.to_vec(), values.to_vec());
    NodeSpec { component: component.into(), name, structure, values, enabled: true }
}

/// The input ports of an instance; those of a coupling for two axes.
fn ports(declaration: &Declaration) -> Vec<Input> {
    let times = |port: &Input| match port.source {
        Source::EachPath | Source::Each(_) => 2,
        _ => 1,
    };
    declaration.inputs.iter().flat_map(|port| vec![*port; times(port)]).collect()
}

fn outputs_of(declaration: &Declaration) -> usize {
    declaration.outputs.len() * if declaration.is_coupling() { 2 } else { 1 }
}

fn gain(kind: &'static str) -> NodeSpec {
    let mut node = node(&(kind, &[], &[0.05, 0.3]));
    if kind == "feedforward-gain" {
        node.values = vec![20.0, 0.3];
    }
    node.name = "linear".into();
    node
}

/// A model of one axis with this component where its kind of signal is; of two axes around a
/// coupling.
fn around(node: NodeSpec) -> System {
    let declaration = node.component.declaration();
    if declaration.conversion == Conversion::PositionToMotion {
        let linear = || vec![gain("feedforward-gain")];
        let axes = vec![axis("x", linear()), axis("y", linear())];
        let coupling = CouplingSpec { node, axes: vec![0, 1], after: None };
        return system(Kind::Controller, axes, vec![coupling]);
    }
    if declaration.is_coupling() {
        let axes =
            vec![axis("x", vec![gain("actuator-gain")]), axis("y", vec![gain("actuator-gain")])];
        let coupling = CouplingSpec { node, axes: vec![0, 1], after: None };
        return system(Kind::Plant, axes, vec![coupling]);
    }
    let before =
        declaration.stage <= Stage::Amplifier || declaration.kind == "polarisation-saturation";
    let (kind, components) = match declaration.conversion {
        Conversion::CommandToPosition => (Kind::Plant, vec![node]),
        Conversion::None if declaration.stage == Stage::Control => {
            (Kind::Controller, vec![node, gain("feedforward-gain")])
        }
        Conversion::None if before => (Kind::Plant, vec![node, gain("actuator-gain")]),
        Conversion::None | Conversion::MotionToPosition | Conversion::PositionToMotion => {
            (Kind::Plant, vec![gain("actuator-gain"), node])
        }
        Conversion::PositionToCommand => (Kind::Controller, vec![node]),
        Conversion::Control => (Kind::Controller, vec![gain("feedforward-gain"), node]),
    };
    system(kind, vec![axis("x", components)], Vec::new())
}

fn axis(name: &str, components: Vec<NodeSpec>) -> AxisSpec {
    AxisSpec {
        name: name.into(),
        command_unit: "V".into(),
        position_unit: "um".into(),
        command_range: (-1000.0, 1000.0),
        position_range: (f64::NEG_INFINITY, f64::INFINITY),
        start: 0.0,
        aliases: vec![],
        components,
    }
}

fn system(kind: Kind, axes: Vec<AxisSpec>, couplings: Vec<CouplingSpec>) -> System {
    let connections = Connections { couplings, ..Connections::default() };
    let spec = SystemSpec { name: "test".into(), kind, period: T, axes, connections };
    System::new(&spec).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Sets command, or reference and measured, from one number in 0 … 1.
fn drive(system: &mut System, x: f64) {
    let inputs: &[(&str, f64)] = match system.kind() {
        Kind::Plant => &[("command[1]", 120.0)],
        Kind::Controller => &[("reference[1]", 6.0), ("measured[1]", 5.9)],
    };
    for (name, range) in inputs {
        let reference = system.variables().find(name).expect("an input");
        system.set(reference, x * range).expect("in range");
    }
}

fn bits(system: &System) -> Vec<u64> {
    let all = 0..system.variables().len() as u32;
    all.map(|reference| system.get(reference).expect("in the table").to_bits()).collect()
}

#[test]
fn every_component_has_one_example_in_the_order_of_the_registry() {
    let registered: Vec<_> = COMPONENTS.iter().map(|c| c.declaration().kind).collect();
    let examples: Vec<_> = EXAMPLES.iter().map(|e| e.0).collect();
    assert_eq!(registered, examples);
}

#[test]
fn examples_are_within_the_declared_bounds_and_units() {
    for (kind, structure, values) in EXAMPLES {
        let d = find(kind).expect("registered").declaration();
        assert_eq!(d.structure.len(), structure.len(), "{kind}");
        assert_eq!(d.parameter_count(structure), values.len(), "{kind}");
        for (setting, value) in d.structure.iter().zip(*structure) {
            assert!((setting.min..=setting.max).contains(value), "{kind}.{}", setting.name);
            assert!(Unit::parse(setting.unit).is_ok(), "{kind}.{}", setting.name);
        }
        let mut at = 0;
        for (index, quantity) in d.parameters.iter().enumerate() {
            for value in &values[at..at + d.length(index, structure)] {
                let (min, max) = (quantity.min, quantity.max);
                assert!((min..=max).contains(value), "{kind}.{}", quantity.name);
            }
            at += d.length(index, structure);
            let unit = unit_on_axis(quantity.unit, "V", "um");
            assert!(Unit::parse(&unit).is_ok(), "{kind}.{}: {unit}", quantity.name);
        }
    }
}

/// The outputs at rest under an input are those after the input was held: the state at rest is an
/// equilibrium. Functions of time, noise and drift move on by themselves.
#[test]
fn rest_is_an_equilibrium() {
    let moves_on = [
        "actuator-ageing",
        "cutting-force",
        "vibration",
        "thermal-drift",
        "floor-vibration",
        "sensor-noise",
        "sensor-drift",
        "mains-hum",
        "pid",
        "incremental-pid",
        "repetitive",
        "disturbance-observer",
    ];
    for example in EXAMPLES.iter().filter(|e| !moves_on.contains(&e.0)) {
        let mut system = around(node(example));
        for x in [0.0, 0.37, 1.0] {
            drive(&mut system, x);
            system.initialise(0.0).expect("valid");
            let at_rest = bits(&system).into_iter().map(f64::from_bits).collect::<Vec<_>>();
            system.advance(50.0 * T).expect("finite");
            for (reference, before) in (0u32..).zip(&at_rest) {
                let after = system.get(reference).expect("in the table");
                let close = (after - before).abs() <= 1e-9 * before.abs().max(1e-3);
                let name = &system.variables().as_slice()[reference as usize].name;
                assert!(close, "{}: {name} {before} → {after} at {x}", example.0);
            }
        }
    }
}

/// Ports whose input at rest shows in the outputs are declared so.
#[test]
fn outputs_at_rest_depend_on_declared_ports_only() {
    for (kind, structure, values) in EXAMPLES {
        let component: &dyn Component = find(kind).expect("registered");
        let d = component.declaration();
        let sizes = component.sizes(structure, T);
        let mut coefficients = vec![0.0; sizes.coefficients];
        component.prepare(structure, values, T, &mut coefficients).expect("valid");
        let rest = |inputs: &[f64]| {
            let mut outputs = vec![0.0; outputs_of(d)];
            component.rest(&coefficients, inputs, &mut vec![0.0; sizes.states], &mut outputs);
            outputs
        };
        let inputs = ports(d);
        let base = vec![1.0; inputs.len()];
        for (port, input) in inputs.iter().enumerate() {
            let mut other = base.clone();
            other[port] = 0.0;
            let changes = rest(&base) != rest(&other);
            assert!(!changes || input.at_rest, "{kind}: {} acts at rest", input.name);
            if let Source::Path = input.source {
                assert!(input.at_rest, "{kind}");
            }
        }
    }
}

/// No parameter set of zeros, ones or huge numbers makes a component panic, and slices of wrong
/// lengths are refused or ignored.
#[test]
fn nothing_panics_on_bad_slices_and_values() {
    for (kind, structure, values) in EXAMPLES {
        let component: &dyn Component = find(kind).expect("registered");
        let sizes = component.sizes(structure, T);
        let mut coefficients = vec![0.0; sizes.coefficients];
        for fill in [0.0, 1.0, -1.0, 1e300, f64::MIN_POSITIVE, f64::NAN, f64::INFINITY] {
            let all = vec![fill; values.len()];
            let accepted = component.prepare(structure, &all, T, &mut coefficients).is_ok();
            if accepted {
                let inputs = vec![fill; ports(component.declaration()).len()];
                let mut outputs = vec![0.0; outputs_of(component.declaration())];
                let mut state = vec![fill; sizes.states];
                let tick = model::Tick { index: 1, time: T, period: T };
                component.step(&coefficients, &mut state, tick, &inputs, &mut outputs);
            }
        }
        component.prepare(structure, values, T, &mut coefficients).expect("valid");
        // A damaged saved state.
        let inputs = vec![0.5; ports(component.declaration()).len()];
        let mut outputs = vec![0.0; outputs_of(component.declaration())];
        for fill in [f64::NAN, f64::INFINITY, -1.0, 1e300] {
            let mut state = vec![fill; sizes.states];
            let tick = model::Tick { index: u64::MAX, time: T, period: T };
            component.step(&coefficients, &mut state, tick, &inputs, &mut outputs);
        }
        for length in 0..=values.len() + 1 {
            let short = vec![1.0; length];
            let _ = component.prepare(structure, &short, T, &mut coefficients);
            let _ = component.prepare(structure, values, T, &mut vec![0.0; length]);
            let tick = model::Tick { index: 1, time: T, period: T };
            let mut state = vec![0.0; length];
            component.step(&short, &mut state, tick, &inputs, &mut outputs);
            component.rest(&short, &inputs, &mut state, &mut outputs);
            component.step(&coefficients, &mut state, tick, &[], &mut []);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Partition of an interval, saving and restoring, reset: the same bits for every component,
    /// and finite outputs.
    #[test]
    fn every_component_keeps_the_contract(
        inputs in prop::collection::vec(0.0..1.0f64, 1..12),
        mut cuts in prop::collection::vec(0.0..1.0f64, 0..6),
    ) {
        cuts.sort_by(f64::total_cmp);
        for example in EXAMPLES {
            let mut whole = around(node(example));
            let mut cut = whole.clone();
            let fresh = whole.clone();
            let interval = 7.3 * T;
            for (k, x) in (0u32..).zip(&inputs) {
                let (from, to) = (f64::from(k) * interval, f64::from(k + 1) * interval);
                drive(&mut whole, *x);
                drive(&mut cut, *x);
                whole.advance(to).expect("finite");
                for c in &cuts {
                    cut.advance(from + c * interval).expect("finite");
                }
                let saved = cut.context().to_bytes();
                cut.reset();
                prop_assert_eq!(cut.context(), fresh.context(), "{}: reset", example.0);
                let saved = cut.context().with_bytes(&saved).expect("same length");
                cut.restore(&saved).expect("same model");
                cut.advance(to).expect("finite");
                prop_assert_eq!(bits(&whole), bits(&cut), "{}: partition", example.0);
            }
        }
    }

    /// A step can be done once more from the state that was noted before it: nothing else of the past
    /// goes into a step, such as outputs that are not written each time. Seen in the slopes of the
    /// outputs, for which a step of several hits is done once more up to the last but one.
    #[test]
    fn a_step_is_repeated_from_its_state(inputs in prop::collection::vec(0.0..1.0f64, 1..12)) {
        for example in EXAMPLES {
            let mut whole = around(node(example));
            let (mut past, mut room) = (whole.past(), whole.derivative_room());
            let mut single = whole.clone();
            let outputs: Vec<u32> = whole
                .variables()
                .with(Causality::Output)
                .filter(|(_, v)| v.data_type == DataType::Real)
                .map(|(reference, _)| reference)
                .collect();
            let read = |s: &System| outputs.iter().map(|o| s.get(*o).unwrap()).collect::<Vec<_>>();
            for (k, x) in (0u32..).zip(&inputs) {
                drive(&mut whole, *x);
                drive(&mut single, *x);
                let hit = |n: u32| f64::from(4 * k + n) * T;
                whole.advance_noted(hit(4), hit(0), &[], &mut past).expect("finite");
                for n in 1..4 {
                    single.advance(hit(n)).expect("finite");
                }
                let before = read(&single);
                single.advance(hit(4)).expect("finite");
                let moved = read(&single).into_iter().zip(before).map(|(y, x)| (y - x) / T);
                let mut slopes = vec![f64::NAN; outputs.len()];
                let write = |at: usize, slope| slopes[at] = slope;
                whole.output_slopes(&mut room, &past, &outputs, write).expect("outputs");
                prop_assert_eq!(slopes, moved.collect::<Vec<_>>(), "{}", example.0);
            }
        }
    }

    /// A disabled effect is an absent one, to the bit.
    #[test]
    fn disabled_is_absent(inputs in prop::collection::vec(0.0..1.0f64, 1..12)) {
        for example in EXAMPLES {
            let mut off = node(example);
            if !off.component.declaration().can_be_disabled() {
                continue;
            }
            off.enabled = false;
            let mut with = around(off);
            let mut without = around(gain("actuator-gain"));
            for (k, x) in (1u32..).zip(&inputs) {
                let mut positions = [0u64; 2];
                for (system, position) in [&mut with, &mut without].into_iter().zip(&mut positions) {
                    drive(system, *x);
                    system.advance(f64::from(k) * 3.0 * T).expect("finite");
                    let reference = system.variables().find("position[1]").expect("an output");
                    *position = system.get(reference).expect("an output").to_bits();
                }
                prop_assert_eq!(positions[0], positions[1], "{}", example.0);
            }
        }
    }
}
