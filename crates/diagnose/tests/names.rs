//! What the diagnosis says of machines whose truth is known. Their formulas are not the library's, and
//! their parameters are off by the tolerances.

use crate::common;
use common::diagnose_machine;
use common::machine::{Machine, RATE};
use common::truth::Effect;
use diagnose::{Gap, Model, Noise, Request, Silent, Verdict, diagnose};

fn gap_of(effect: Effect, size: f64, seed: u64, without: &[&str]) -> Gap {
    let machine = Machine::new(seed, 1.0).with(effect, size);
    diagnose_machine(&machine, machine.logs(), without)
}

/// The right name first, at six times the noise, and most of the gap gone on rows that were not used.
#[track_caller]
fn is_named(effect: Effect, name: &str) {
    let gap = gap_of(effect, 6.0, 100 + effect as u64, &[]);
    let tried: Vec<_> = gap
        .candidates
        .iter()
        .take(5)
        .map(|c| (&c.effect, c.training, c.holdout, c.score))
        .collect();
    assert_eq!(gap.verdict, Verdict::Effects, "{} {tried:?}", gap.sentence);
    assert_eq!(gap.effects[0].effect, name, "{} {tried:?}", gap.sentence);
    assert!(gap.effects[0].set.iter().any(|n| n == name));
    assert!(gap.shrink.fraction.unwrap() > 0.6, "{}", gap.sentence);
    let sum: f64 = gap.candidates.iter().map(|c| c.probability).sum();
    assert!(sum <= 1.0 + 1e-9, "{sum}");
}

macro_rules! named {
    ($($test:ident: $effect:ident, $name:literal;)*) => {
        $(#[test]
        fn $test() {
            is_named(Effect::$effect, $name);
        })*
    };
}

named! {
    creep_is_named: Creep, "creep";
    a_converter_is_named: DacQuantisation, "dac_quantisation";
    slew_is_named: AmplifierSlew, "amplifier_slew";
    saturation_is_named: AmplifierSaturation, "amplifier_saturation";
    missing_hysteresis_is_named: Hysteresis, "hysteresis";
    asymmetry_is_named: Asymmetry, "asymmetry";
    another_mode_is_named: ExtraMode, "extra_mode";
    hardening_is_named: Duffing, "duffing";
    lines_are_named: PeriodicDisturbance, "periodic_disturbance";
    hum_is_named: MainsHum, "mains_hum";
    a_neighbour_is_named: CrossCoupling, "cross_coupling";
    feed_through_is_named: Crosstalk, "crosstalk";
    sensor_curve_is_named: SensorNonlinearity, "sensor_nonlinearity";
    heat_is_named: SelfHeating, "self_heating";
    a_gain_out_of_tolerance_is_named: ActuatorGain, "actuator_gain";
}

/// Few steps ring the mode and leave twenty times the noise; many leave little more than the noise.
#[test]
fn converters_are_named_whatever_their_steps() {
    for (effect, size) in [
        (Effect::DacQuantisation, 20.0),
        (Effect::DacQuantisation, 2.0),
        (Effect::MissingCodes, 20.0),
        (Effect::MissingCodes, 2.0),
    ] {
        let gap = gap_of(effect, size, 30, &[]);
        let names: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
        assert_eq!(names, ["dac_quantisation"], "{effect:?}, {size}: {}", gap.sentence);
        assert!(gap.shrink.fraction.unwrap() > 0.9, "{effect:?}, {size}: {}", gap.sentence);
    }
}

#[test]
fn a_lag_is_named_within_its_group() {
    let gap = gap_of(Effect::Delay, 6.0, 3, &[]);
    assert_eq!(gap.effects[0].group.as_deref(), Some("lag"), "{}", gap.sentence);
    assert!(gap.effects[0].set.iter().any(|n| n == "delay"), "{:?}", gap.effects[0].set);
}

/// The names that are given, the frequency of a swing, and the explained part of the gap with them.
fn names_of(effects: &[(Effect, f64)], seed: u64) -> (Vec<String>, Option<f64>, f64) {
    let add = |machine: Machine, (effect, size): &(Effect, f64)| machine.with(*effect, *size);
    let machine = effects.iter().fold(Machine::new(seed, 1.0), add);
    let gap = diagnose_machine(&machine, machine.logs(), &[]);
    let mut names: Vec<String> = gap.effects.iter().map(|e| e.effect.clone()).collect();
    names.sort_unstable();
    let values = gap.effects.iter().flat_map(|e| &e.parameters);
    let swing = values.filter(|(name, _)| *name == "delay.frequency").map(|(_, p)| p.value).next();
    (names, swing, gap.shrink.fraction.unwrap_or(0.0))
}

#[test]
fn a_delay_that_swings_is_named_with_its_frequency_alone_and_beside_another_effect() {
    for (effects, names) in [
        (&[(Effect::SwingingDelay, 20.0)][..], &["delay"][..]),
        (&[(Effect::SwingingDelay, 20.0), (Effect::Duffing, 6.0)], &["delay", "duffing"]),
    ] {
        let (found, swing, fraction) = names_of(effects, 41);
        assert_eq!(found, names);
        assert!(swing.is_some_and(|f| (f / 3.3 - 1.0).abs() < 0.01), "{swing:?}");
        assert!(fraction > 0.97, "{fraction}");
    }
}

/// A model of the bare resonance, and a machine whose mode creeps.
#[test]
fn a_damping_far_above_the_models_is_named_with_its_value() {
    for damping in [0.3, 1.5] {
        let machine = Machine { damping, ..Machine::new(43, 1.0) };
        let gap = diagnose_machine(&machine, machine.logs(), &[]);
        let names: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
        assert_eq!(names, ["damping"], "{damping}: {}", gap.sentence);
        let found = gap.effects[0].parameters.iter().find(|(name, _)| name.contains("damping"));
        let value = found.map_or(f64::NAN, |(_, p)| p.value);
        assert!((value / damping - 1.0).abs() < 0.03, "{damping}: {:?}", gap.effects[0].parameters);
    }
}

#[test]
fn a_model_that_is_right_is_adequate() {
    let machine = Machine::new(11, 0.0);
    let gap = diagnose_machine(&machine, machine.logs(), &[]);
    assert_eq!(gap.verdict, Verdict::Adequate, "{}", gap.sentence);
    assert!(gap.effects.is_empty() && !gap.leftover.present);
}

#[test]
fn parameters_within_tolerance_are_no_effect() {
    let machine = Machine::new(12, 1.0);
    let gap = diagnose_machine(&machine, machine.logs(), &[]);
    assert_eq!(gap.verdict, Verdict::Retune, "{}", gap.sentence);
    assert!(gap.shrink.rms_as_given > 2.0 * gap.shrink.rms_before);
}

#[test]
fn parameters_that_the_fitted_rows_do_not_determine_are_no_effect() {
    let mut refitted = 0;
    for seed in 61..67 {
        let machine = Machine::new(seed, 1.0);
        // Small strokes, and large ones in the end, which alone move the wide plays.
        let stroke = |k: usize| if k < 4400 { 4.0 } else { 50.0 };
        let u: Vec<f64> =
            (0..6400).map(|k| 60.0 + stroke(k) * (k as f64 / RATE * 40.0).sin()).collect();
        let gap = diagnose_machine(&machine, vec![machine.log(0, &u)], &[]);
        assert!(gap.effects.is_empty(), "seed {seed}: {}", gap.sentence);
        assert_ne!(gap.verdict, Verdict::Unknown, "seed {seed}: {}", gap.sentence);
        refitted += usize::from(gap.warnings.iter().any(|w| w.contains("none is held out")));
    }
    assert!(refitted > 0);
}

#[test]
fn what_is_in_no_library_is_unknown() {
    for effect in [Effect::GainModulation, Effect::Glitches, Effect::AcCoupling] {
        let gap = gap_of(effect, 6.0, 20, &[]);
        assert_eq!(gap.verdict, Verdict::Unknown, "{effect:?}: {}", gap.sentence);
    }
}

#[test]
fn an_effect_that_was_taken_out_is_not_given_another_name() {
    let gap = gap_of(Effect::Creep, 10.0, 705, &["creep"]);
    assert_eq!(gap.verdict, Verdict::Unknown, "{}", gap.sentence);
    assert!(gap.candidates.iter().all(|c| c.effect != "creep"));
}

/// A mode so damped that it is none imitates a crosstalk and another damping.
#[test]
fn what_ends_at_a_bound_of_an_effect_imitates_it() {
    for (effect, own, seed) in
        [(Effect::Crosstalk, "crosstalk", 62), (Effect::Damping, "damping", 60)]
    {
        let gap = gap_of(effect, 20.0, seed, &[own]);
        assert_eq!(gap.verdict, Verdict::Unknown, "seed {seed}: {}", gap.sentence);
        let best = &gap.partial[0].effect;
        assert!(best.effect == "extra_mode" && best.explained > 0.8, "seed {seed}: {best:?}");
        assert!(best.probability <= 0.05, "seed {seed}: {}", best.probability);
        assert!(gap.sentence.contains("its fit ends at a bound"), "{}", gap.sentence);
        let tried = gap.candidates.iter().find(|c| c.effect == "extra_mode").unwrap();
        assert!(tried.left_out.as_ref().unwrap().contains("ends at a bound"), "{tried:?}");
    }
}

/// A spring may change the gain, and a memory may imitate a clearance: nothing else of them is there.
#[test]
fn a_gain_is_no_spring_and_a_clearance_is_no_memory() {
    for (effect, own, others) in [
        (Effect::ActuatorGain, "actuator_gain", &["resonance_shift", "creep", "asymmetry"][..]),
        (Effect::Backlash, "backlash", &["hysteresis"]),
    ] {
        for seed in [41, 42] {
            let gap = gap_of(effect, 6.0, seed, &[own]);
            let named: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
            let is_wrong = named.iter().any(|name| others.contains(name));
            assert!(!is_wrong, "{effect:?}, seed {seed}: {}", gap.sentence);
        }
    }
}

#[test]
fn an_effect_that_the_rows_held_out_do_not_show_is_named_from_the_others() {
    // Only steps come near the limit of the slope; the sweep that is held out does not.
    let machine = Machine::new(15, 1.0).with(Effect::AmplifierSlew, 3.0);
    let model = Model::Blueprint(Box::new(common::machine::blueprint()));
    let mut logs = machine.logs();
    let sweep = logs.pop().unwrap();
    let mut request = Request::new(model, logs);
    request.holdout = vec![sweep];
    request.noise = Noise::Given(vec![(None, machine.sigma)]);
    let gap = diagnose(&request, &mut Silent).unwrap();
    let held_out = (gap.shrink.rms_before / machine.sigma).powi(2);
    assert!(held_out < 1.2, "the rows that are held out show it: {held_out}");
    assert_eq!(gap.effects[0].effect, "amplifier_slew", "{}", gap.sentence);
}

#[test]
fn a_lag_that_imitates_a_delay_does_not_hide_what_is_beside_it() {
    let machine = Machine::new(16, 1.0).with(Effect::Delay, 20.0).with(Effect::Damping, 10.0);
    let gap = diagnose_machine(&machine, machine.logs(), &[]);
    let names: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
    assert!(names.contains(&"damping") && names.len() == 2, "{}", gap.sentence);
    assert!(gap.effects.iter().any(|e| e.group.as_deref() == Some("lag")), "{}", gap.sentence);
}

#[test]
fn noise_that_is_estimated_beside_an_effect_is_not_taken_from_it() {
    let machine = Machine::new(14, 1.0).with(Effect::ExtraMode, 20.0);
    let gap = estimated(&machine);
    let ratio = gap.shrink.noise_floor / machine.sigma;
    assert!((ratio - 1.0).abs() < 0.12, "{ratio}: {}", gap.sentence);
}

fn estimated(machine: &Machine) -> Gap {
    let model = Model::Blueprint(Box::new(common::machine::blueprint()));
    diagnose(&Request::new(model, machine.logs()), &mut Silent).unwrap()
}

#[test]
fn logs_that_do_not_move_the_machine_tell_nothing() {
    let machine = Machine::new(13, 0.0);
    let still: Vec<data::Log> = machine
        .logs()
        .iter()
        .take(1)
        .map(|log| {
            let n = log.len();
            let mut noise = common::machine::Normal::new(5);
            let mut still = data::Log::new("still.csv", log.time().to_vec()).unwrap();
            still.add_column("u", Some("V"), vec![60.0; n]).unwrap();
            let y = (0..n).map(|_| 4.0 + machine.sigma * noise.draw()).collect();
            still.add_column("y", Some("um"), y).unwrap();
            still
        })
        .collect();
    let gap = diagnose_machine(&machine, still, &[]);
    assert_eq!(gap.verdict, Verdict::InsufficientExcitation, "{}", gap.sentence);
}
