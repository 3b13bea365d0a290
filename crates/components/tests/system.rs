//! Chains of components keep the contract of built systems.
//!
//! Hits do not depend on how an interval is cut, states can be saved and continued bit for bit, a
//! reset system is a fresh one, a disabled effect is an absent one, and refusals carry full names.

use components::{COMPONENTS, find};
use model::{AxisSpec, Connections, Kind, NodeSpec, StepError, System, SystemSpec};
use numerics::random::SplitMix64;
use proptest::prelude::*;

const T: f64 = 1e-4;

fn node(kind: &str, name: &str, structure: &[f64], values: &[f64]) -> NodeSpec {
    NodeSpec {
        component: find(kind).unwrap_or_else(|| panic!("{kind} is not registered")).into(),
        name: name.into(),
        structure: structure.to_vec(),
        values: values.to_vec(),
        enabled: true,
    }
}

fn axis(name: &str, components: Vec<NodeSpec>) -> AxisSpec {
    AxisSpec {
        name: name.into(),
        command_unit: "V".into(),
        position_unit: "um".into(),
        command_range: (-1000.0, 1000.0),
        position_range: (f64::NEG_INFINITY, f64::INFINITY),
        start: 0.0,
        aliases: vec![Some("u".into()), Some("y".into())],
        components,
    }
}

fn system(kind: Kind, axes: Vec<AxisSpec>) -> System {
    let connections = Connections::default();
    let spec = SystemSpec { name: "test".into(), kind, period: T, axes, connections };
    System::new(&spec).unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn hysteresis() -> NodeSpec {
    let values = [0.0, 6.0, 12.0, 18.0, 0.01354, 0.0279, 0.0, 0.004014, 0.2];
    node("prandtl-ishlinskii", "hysteresis", &[4.0], &values)
}

fn plant_axis() -> Vec<NodeSpec> {
    vec![
        node("delay", "delay", &[0.01], &[2.35e-4]),
        node("amplifier-lag", "amplifier", &[], &[800.0, 1.0]),
        hysteresis(),
        node("mode", "mode", &[], &[482.6, 0.02, 1.0]),
        node("sensor-lag", "sensor", &[], &[1500.0]),
    ]
}

fn plant() -> System {
    system(Kind::Plant, vec![axis("Y", plant_axis()), axis("Z", plant_axis())])
}

fn controller() -> System {
    let mut values = hysteresis();
    values.component = find("inverse-prandtl-ishlinskii").expect("registered").into();
    let pid =
        node("pid", "pid", &[], &[2.0, 300.0, 1e-4, 0.0, 0.0, 120.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    system(Kind::Controller, vec![axis("Y", vec![values, pid])])
}

fn vr(system: &System, name: &str) -> u32 {
    system.variables().find(name).unwrap_or_else(|| panic!("no variable {name}"))
}

fn all_bits(system: &System) -> Vec<u64> {
    (0..system.variables().len() as u32)
        .map(|reference| system.get(reference).expect("in the table").to_bits())
        .collect()
}

fn drive(system: &mut System, inputs: &[f64]) {
    for (reference, value) in (0..).zip(inputs) {
        system.set(reference, *value).expect("an input");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// With inputs constant over an interval, every partition of it gives the same bits.
    #[test]
    fn partitions_do_not_matter(
        commands in prop::collection::vec((-50.0..150.0f64, -50.0..150.0f64), 1..6),
        mut cuts in prop::collection::vec(0.0..1.0f64, 0..12),
    ) {
        cuts.sort_by(f64::total_cmp);
        let interval = 23.7 * T;
        let (mut complete, mut cut) = (plant(), plant());
        for (k, (y, z)) in (0u32..).zip(&commands) {
            drive(&mut complete, &[*y, *z]);
            drive(&mut cut, &[*y, *z]);
            let (from, to) = (f64::from(k) * interval, f64::from(k + 1) * interval);
            complete.advance(to).expect("advances");
            for c in &cuts {
                cut.advance(from + c * (to - from)).expect("advances");
            }
            cut.advance(to).expect("advances");
            prop_assert_eq!(all_bits(&complete), all_bits(&cut));
        }
    }

    /// A state that was saved, as a copy or as bytes, continues with the same bits.
    #[test]
    fn saved_states_continue(
        before in prop::collection::vec(-50.0..150.0f64, 1..20),
        after in prop::collection::vec(-50.0..150.0f64, 1..20),
    ) {
        let mut original = plant();
        for (k, u) in before.iter().enumerate() {
            drive(&mut original, &[*u, -u]);
            original.advance((k + 1) as f64 * 3.0 * T).expect("advances");
        }
        let saved = original.context().clone();
        let bytes = saved.to_bytes();
        let (mut copied, mut read) = (plant(), plant());
        copied.restore(&saved).expect("same model");
        let context = read.context().with_bytes(&bytes).expect("same length");
        read.restore(&context).expect("same model");
        for (k, u) in after.iter().enumerate() {
            let time = original.time() + (k % 4) as f64 * T;
            for system in [&mut original, &mut copied, &mut read] {
                drive(system, &[-u, *u]);
                system.advance(time).expect("advances");
            }
            prop_assert_eq!(all_bits(&original), all_bits(&copied));
            prop_assert_eq!(all_bits(&original), all_bits(&read));
        }
    }

    /// A reset system behaves as a fresh one.
    #[test]
    fn reset_is_fresh(commands in prop::collection::vec(-50.0..150.0f64, 1..30)) {
        let (mut used, mut fresh) = (plant(), plant());
        for u in &commands {
            drive(&mut used, &[*u, 1.0]);
            used.advance(used.time() + 2.0 * T).expect("advances");
        }
        let gain = vr(&used, "axis[2].mode.gain");
        used.set(gain, 0.5).expect("in range");
        used.reset();
        prop_assert_eq!(used.context(), fresh.context());
        for (k, u) in commands.iter().enumerate() {
            for system in [&mut used, &mut fresh] {
                drive(system, &[*u, -u]);
                system.advance((k + 1) as f64 * T).expect("advances");
            }
            prop_assert_eq!(all_bits(&used), all_bits(&fresh));
        }
    }

    /// Finite inputs give finite outputs.
    #[test]
    fn finite_in_finite_out(commands in prop::collection::vec(-1e9..1e9f64, 1..200)) {
        let mut plant = plant();
        for (k, u) in commands.iter().enumerate() {
            drive(&mut plant, &[*u, -u]);
            plant.advance((k + 1) as f64 * T).expect("finite");
        }
        let mut controller = controller();
        for (k, u) in commands.iter().enumerate() {
            drive(&mut controller, &[*u, u * 0.7, f64::from(u8::from(k % 5 != 0))]);
            controller.advance((k + 1) as f64 * T).expect("finite");
            let command = controller.get(vr(&controller, "command[1]")).expect("an output");
            prop_assert!((0.0..=120.0).contains(&command), "{}", command);
        }
    }
}

#[test]
fn disabled_effects_are_absent_to_the_bit() {
    let chain = plant_axis();
    let switchable: Vec<usize> =
        (0..chain.len()).filter(|i| chain[*i].component.declaration().can_be_disabled()).collect();
    assert_eq!(switchable.len(), 4);
    for at in switchable {
        let (mut with, mut without) = (chain.clone(), chain.clone());
        with[at].enabled = false;
        let name = without.remove(at).name;
        let mut with = system(Kind::Plant, vec![axis("Y", with)]);
        let mut without = system(Kind::Plant, vec![axis("Y", without)]);
        for k in 1..300 {
            let u = 60.0 + 70.0 * (0.13 * f64::from(k)).sin();
            let mut positions = [0u64; 2];
            for (system, bits) in [&mut with, &mut without].into_iter().zip(&mut positions) {
                drive(system, &[u]);
                system.advance(f64::from(k) * T).expect("advances");
                *bits = system.get(vr(system, "position[1]")).expect("an output").to_bits();
            }
            assert_eq!(positions[0], positions[1], "{name} at step {k}");
        }
    }
}

#[test]
fn a_delay_of_zero_is_no_delay_to_the_bit() {
    let rest = vec![hysteresis(), node("mode", "mode", &[], &[482.6, 0.02, 1.0])];
    let mut delayed = rest.clone();
    delayed.insert(0, node("delay", "delay", &[0.01], &[0.0]));
    let mut with = system(Kind::Plant, vec![axis("Y", delayed)]);
    let mut without = system(Kind::Plant, vec![axis("Y", rest)]);
    for k in 1..300 {
        let u = if k == 5 { -0.0 } else { 120.0 * (0.3 * f64::from(k)).sin() };
        for system in [&mut with, &mut without] {
            drive(system, &[u]);
            system.advance(f64::from(k) * T).expect("advances");
        }
        let position = |s: &System| s.get(vr(s, "position[1]")).expect("an output").to_bits();
        assert_eq!(position(&with), position(&without));
    }
}

#[test]
fn a_tunable_gain_acts_at_the_next_step() {
    let mut controller = controller();
    let kp = vr(&controller, "axis[1].pid.kp");
    let ki = vr(&controller, "axis[1].pid.ki");
    let kd = vr(&controller, "axis[1].pid.kd");
    for gain in [ki, kd] {
        controller.set(gain, 0.0).expect("tunable");
    }
    drive(&mut controller, &[1.0, 0.5, 1.0]);
    controller.initialise(0.0).expect("initialises");
    let feedback = vr(&controller, "feedback[1]");
    controller.advance(T).expect("advances");
    let before = controller.get(feedback).expect("an output");
    assert!((before - 2.0 * 0.5).abs() < 1e-12, "{before}");
    controller.set(kp, 4.0).expect("tunable");
    assert_eq!(controller.get(feedback), Some(before));
    controller.advance(2.0 * T).expect("advances");
    let after = controller.get(feedback).expect("an output");
    assert!((after - 4.0 * 0.5).abs() < 1e-12, "{after}");
}

#[test]
fn a_chain_of_gains_steps_in_place_to_the_bit() {
    let gain = || node("actuator-gain", "gain", &[], &[0.7, 0.3]);
    let chain = || system(Kind::Plant, vec![axis("Y", vec![gain()])]);
    let (mut quick, mut slow) = (chain(), chain());
    let (mut past, mut known) = (quick.past(), slow.past());
    assert!(quick.is_affine() && !plant().is_affine() && !controller().is_affine());
    let mut random = SplitMix64::new(1);
    for k in 0..500_u32 {
        let command = 1600.0 * random.uniform() - 800.0;
        for system in [&mut quick, &mut slow] {
            drive(system, &[command]);
        }
        let (from, to) = (f64::from(k) * T, f64::from(k + 1) * T);
        assert!(quick.affine_step(to, from, &mut past), "step {k}");
        assert_eq!(slow.advance_noted(to, from, &[], &mut known), Ok(1));
        assert_eq!(quick.context().to_bytes(), slow.context().to_bytes());
        assert_eq!(past.to_bytes(), known.to_bytes());
    }
    assert!(quick.affine_step(500.2 * T, 500.0 * T, &mut past));
    assert_eq!(slow.advance_noted(500.2 * T, 500.0 * T, &[], &mut known), Ok(0));
    assert_eq!(past.to_bytes(), known.to_bytes());
    // Two hits, no time, a value out of range: the other way does these.
    for time in [502.0 * T, f64::NAN, f64::INFINITY] {
        assert!(!quick.affine_step(time, 500.0 * T, &mut past), "{time}");
    }
    assert_eq!(quick.context().to_bytes(), slow.context().to_bytes());
    let enormous = node("actuator-gain", "gain", &[], &[1e308, 0.0]);
    let mut quick = system(Kind::Plant, vec![axis("Y", vec![enormous])]);
    drive(&mut quick, &[100.0]);
    let mut past = quick.past();
    assert!(!quick.affine_step(T, 0.0, &mut past));
    assert!(matches!(
        quick.advance_noted(T, 0.0, &[], &mut past),
        Err(StepError::NotFinite { .. })
    ));
}

#[test]
fn a_controller_at_rest_gives_its_feedforward() {
    let (mut controller, mut plant) =
        (controller(), system(Kind::Plant, vec![axis("Y", vec![hysteresis()])]));
    drive(&mut plant, &[60.0]);
    plant.initialise(0.0).expect("initialises");
    let position = plant.get(vr(&plant, "position[1]")).expect("an output");
    drive(&mut controller, &[position, 0.0, 1.0]);
    controller.initialise(0.0).expect("initialises");
    let value = |name| controller.get(vr(&controller, name)).expect("an output");
    assert!((value("command[1]") - 60.0).abs() < 1e-9, "{}", value("command[1]"));
    assert_eq!(value("feedback[1]"), 0.0);
    assert_eq!(value("saturated[1]"), 0.0);
}

#[test]
fn violations_carry_the_full_name() {
    let mut plant = plant();
    let r = vr(&plant, "axis[2].hysteresis.r[3]");
    plant.set(r, 6.0).expect("within its own bounds");
    let error = plant.initialise(0.0).expect_err("two equal thresholds");
    assert!(matches!(error, StepError::Parameters { .. }));
    let text = plant.explain(&error);
    assert!(text.starts_with("axis[2].hysteresis.r[3] = 6 (SI): "), "{text}");

    let mut controller = controller();
    let limit = vr(&controller, "axis[1].pid.output_min");
    controller.set(limit, 130.0).expect("within its own bounds");
    let error = controller.advance(T).expect_err("crossed limits");
    let text = controller.explain(&error);
    assert!(text.starts_with("axis[1].pid.output_min = 130 (SI): "), "{text}");

    let mut chain = plant_axis();
    chain[0].values = vec![0.02];
    let axes = vec![axis("Y", chain)];
    let connections = Connections::default();
    let spec = SystemSpec { name: "t".into(), kind: Kind::Plant, period: T, axes, connections };
    let errors = System::new(&spec).expect_err("a delay beyond the longest");
    assert!(errors[0].message.starts_with("axis[1].delay.delay = 0.02 (SI): "), "{errors:?}");
}

#[test]
fn declarations_are_complete_and_unambiguous() {
    for (i, component) in COMPONENTS.iter().enumerate() {
        let d = component.declaration();
        assert!(std::ptr::eq(find(d.kind).expect("found").declaration(), d), "{} twice", d.kind);
        assert!(COMPONENTS[..i].iter().all(|c| c.declaration().kind != d.kind));
        for text in [d.kind, d.name, d.summary, d.equation, d.reference] {
            assert!(!text.is_empty() && text.trim() == text, "{}: {text:?}", d.kind);
            assert!(!text.contains("  "), "{}: {text:?}", d.kind);
        }
        assert!(!d.outputs.is_empty() && !d.inputs.is_empty(), "{}", d.kind);
        let names =
            || d.structure.iter().map(|s| s.name).chain(d.parameters.iter().map(|q| q.name));
        for (k, name) in names().enumerate() {
            assert!(names().take(k).all(|n| n != name), "{}: {name} twice", d.kind);
            assert!(!matches!(name, "type" | "name" | "enabled" | "tolerance" | "note"), "{name}");
        }
        for q in d.parameters {
            let unit = model::unit_on_axis(q.unit, "V", "um");
            assert!(model::Unit::parse(&unit).is_ok(), "{}.{}: {unit}", d.kind, q.name);
            assert!(q.start.is_none_or(|s| (q.min..=q.max).contains(&s)), "{}.{}", d.kind, q.name);
        }
    }
}
