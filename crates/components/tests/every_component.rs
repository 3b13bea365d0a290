//! What holds for every component type, tried on an example of each.
//!
//! A new component fails here until it declares an example, or has its section in `rigs/effects.toml`.

mod examples;

use components::{COMPONENTS, find};
use examples::{EXAMPLES, T, gain, node};
use model::{
    Causality, Component, DataType, Declaration, Input, Kind, NodeSpec, Source, System, Unit,
    unit_on_axis,
};
use proptest::prelude::*;

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

fn system_of(node: NodeSpec) -> System {
    System::new(&examples::system_of(node)).unwrap_or_else(|errors| panic!("{errors:?}"))
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
    for (kind, structure, values) in EXAMPLES.iter() {
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
        let mut system = system_of(node(example));
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
    for (kind, structure, values) in EXAMPLES.iter() {
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
    for (kind, structure, values) in EXAMPLES.iter() {
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
        for example in EXAMPLES.iter() {
            let mut complete = system_of(node(example));
            let mut cut = complete.clone();
            let fresh = complete.clone();
            let interval = 7.3 * T;
            for (k, x) in (0u32..).zip(&inputs) {
                let (from, to) = (f64::from(k) * interval, f64::from(k + 1) * interval);
                drive(&mut complete, *x);
                drive(&mut cut, *x);
                complete.advance(to).expect("finite");
                for c in &cuts {
                    cut.advance(from + c * interval).expect("finite");
                }
                let saved = cut.context().to_bytes();
                cut.reset();
                prop_assert_eq!(cut.context(), fresh.context(), "{}: reset", example.0);
                let saved = cut.context().with_bytes(&saved).expect("same length");
                cut.restore(&saved).expect("same model");
                cut.advance(to).expect("finite");
                prop_assert_eq!(bits(&complete), bits(&cut), "{}: partition", example.0);
            }
        }
    }

    /// A step can be done once more from the state that was noted before it: nothing else of the past
    /// goes into a step, such as outputs that are not written each time. Seen in the slopes of the
    /// outputs, for which a step of several hits is done once more up to the last but one.
    #[test]
    fn a_step_is_repeated_from_its_state(inputs in prop::collection::vec(0.0..1.0f64, 1..12)) {
        for example in EXAMPLES.iter() {
            let mut complete = system_of(node(example));
            let (mut past, mut room) = (complete.past(), complete.derivative_room());
            let mut single = complete.clone();
            let outputs: Vec<u32> = complete
                .variables()
                .with(Causality::Output)
                .filter(|(_, v)| v.data_type == DataType::Real)
                .map(|(reference, _)| reference)
                .collect();
            let read = |s: &System| outputs.iter().map(|o| s.get(*o).unwrap()).collect::<Vec<_>>();
            for (k, x) in (0u32..).zip(&inputs) {
                drive(&mut complete, *x);
                drive(&mut single, *x);
                let hit = |n: u32| f64::from(4 * k + n) * T;
                complete.advance_noted(hit(4), hit(0), &[], &mut past).expect("finite");
                for n in 1..4 {
                    single.advance(hit(n)).expect("finite");
                }
                let before = read(&single);
                single.advance(hit(4)).expect("finite");
                let moved = read(&single).into_iter().zip(before).map(|(y, x)| (y - x) / T);
                let mut slopes = vec![f64::NAN; outputs.len()];
                let write = |at: usize, slope| slopes[at] = slope;
                complete.output_slopes(&mut room, &past, &outputs, write).expect("outputs");
                prop_assert_eq!(slopes, moved.collect::<Vec<_>>(), "{}", example.0);
            }
        }
    }

    /// A disabled effect is an absent one, to the bit.
    #[test]
    fn disabled_is_absent(inputs in prop::collection::vec(0.0..1.0f64, 1..12)) {
        for example in EXAMPLES.iter() {
            let mut off = node(example);
            if !off.component.declaration().can_be_disabled() {
                continue;
            }
            off.enabled = false;
            let mut with = system_of(off);
            let mut without = system_of(gain("actuator-gain"));
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
