//! What a diagnosis stands on: noise that was stated too small, a tap, records that are left out.

use crate::common::machine::{Machine, Normal, blueprint};
use crate::common::truth::{Effect, input_side};
use data::Log;
use diagnose::{Files, Gap, Model, Noise, Request, Silent, Verdict, diagnose, examine};

fn gap_of(logs: Vec<Log>, sigma: f64, change: impl FnOnce(&mut Request)) -> Gap {
    let mut request = Request::new(Model::Blueprint(Box::new(blueprint())), logs);
    request.noise = Noise::Given(vec![(None, sigma)]);
    change(&mut request);
    diagnose(&request, &mut Silent).unwrap()
}

#[test]
fn readings_that_are_noisier_than_stated_lack_nothing_else() {
    let machine = Machine::new(51, 1.0);
    let stated = machine.sigma / 2.5;
    let gap = gap_of(machine.logs(), stated, |_| ());
    assert_eq!(gap.verdict, Verdict::Effects, "{}", gap.sentence);
    assert_eq!(gap.effects.len(), 1, "{}", gap.sentence);
    assert_eq!(gap.effects[0].effect, "sensor_noise", "{}", gap.sentence);
    let beside = gap.effects[0].parameters["sensor_noise.standard_deviation"].value;
    let expected = stated * (2.5f64 * 2.5 - 1.0).sqrt();
    assert!((beside / expected - 1.0).abs() < 0.1, "{beside} {expected}");
    assert!(!gap.leftover.present && gap.shrink.ci95.is_none(), "{:?}", gap.leftover);
    // Taken out of the library it is no longer the answer.
    let without = gap_of(machine.logs(), stated, |r| r.without = vec!["sensor_noise".into()]);
    assert!(without.effects.iter().all(|e| e.effect != "sensor_noise"), "{}", without.sentence);
}

#[test]
fn an_effect_is_not_taken_for_noise() {
    let machine = Machine::new(52, 1.0).with(Effect::ThermalDrift, 6.0);
    let gap = gap_of(machine.logs(), machine.sigma, |_| ());
    assert!(gap.effects.iter().all(|e| e.effect != "sensor_noise"), "{}", gap.sentence);
}

/// Logs whose readings walk, in each record in another way, and are noisier by this many times the noise.
fn walks(machine: &Machine, noisier: f64) -> Vec<Log> {
    let mut random = Normal::new(machine.seed);
    let logs = machine.logs().into_iter().map(|log| {
        let mut walk = 0.0;
        let mut drifted = |y: &f64| {
            walk += 0.3 * machine.sigma * random.draw();
            let noise = if noisier > 0.0 { noisier * machine.sigma * random.draw() } else { 0.0 };
            y + walk + noise
        };
        let y = log.column("y").unwrap().values.iter().map(&mut drifted).collect();
        let mut all = Log::new(log.origin(), log.time().to_vec()).unwrap();
        all.add_column("u", Some("V"), log.column("u").unwrap().values.to_vec()).unwrap();
        all.add_column("y", Some("um"), y).unwrap();
        all
    });
    logs.collect()
}

/// A walk that differs in each record is named from the rows around each row; a shrink that nobody gets is not promised.
#[test]
fn a_walk_is_named_and_promises_nothing() {
    const SEED: u64 = 52;
    let machine = Machine::new(SEED, 1.0);
    let mut request = Request::new(Model::Blueprint(Box::new(blueprint())), walks(&machine, 0.0));
    request.noise = Noise::Given(vec![(None, machine.sigma)]);
    let diagnosis = examine(&request, &mut Silent).unwrap();
    let gap = &diagnosis.gap;
    assert_eq!(gap.effects.len(), 1, "seed {SEED}: {}", gap.sentence);
    assert_eq!(gap.effects[0].effect, "thermal_drift", "seed {SEED}: {}", gap.sentence);
    assert!(gap.shrink.own_course.unwrap() > 0.8, "seed {SEED}: {}", gap.sentence);
    assert!(gap.shrink.fraction.unwrap() < 0.2, "seed {SEED}: {}", gap.sentence);
    assert!(gap.sentence.contains("no model predicts"), "{}", gap.sentence);
    // Page and figures show what a model predicts.
    for record in &gap.place.records {
        assert!(record.rms[1] > 0.7 * record.rms[0], "seed {SEED}: {record:?}");
    }
    let page = diagnosis.report(&Files::default()).to_html().unwrap();
    assert!(page.contains("no model predicts it") && !page.contains("power removed"));
}

/// Where too much is left beside the walk for a name, the sentence promises nothing of it either.
#[test]
fn a_walk_that_is_no_name_promises_nothing() {
    const SEED: u64 = 52;
    let machine = Machine::new(SEED, 1.0);
    let gap = gap_of(walks(&machine, 5.0), machine.sigma, |_| ());
    assert_eq!(gap.verdict, Verdict::Unknown, "seed {SEED}: {}", gap.sentence);
    let best = &gap.partial[0];
    assert_eq!(best.effect.effect, "thermal_drift", "seed {SEED}: {}", gap.sentence);
    assert!(best.own_course.unwrap() > 0.6, "seed {SEED}: {}", gap.sentence);
    assert!(best.rms_after > 0.9 * best.rms_before, "seed {SEED}: {}", gap.sentence);
    assert!(gap.sentence.contains("no model predicts"), "{}", gap.sentence);
    assert!(!gap.sentence.contains("would remove"), "{}", gap.sentence);
}

#[test]
fn a_monitor_says_that_a_lag_is_before_the_actuator() {
    let machine = Machine::new(53, 1.0).with(Effect::AmplifierBandwidth, 6.0);
    let mut logs = machine.logs();
    for (log, u) in logs.iter_mut().zip(machine.commands()) {
        // Read before the command of its row acts.
        let mut v = input_side(&machine, &u);
        v.rotate_right(1);
        v[0] = u[0];
        log.add_column("u_monitor", Some("V"), v).unwrap();
    }
    let gap = gap_of(logs, machine.sigma, |r| {
        let Noise::Given(all) = &mut r.noise else { return };
        all.push((Some("u_monitor".into()), 0.01));
    });
    let outputs: Vec<&str> = gap.outputs.iter().map(|o| o.output.as_str()).collect();
    assert_eq!(outputs, ["u_monitor", "y"]);
    assert_eq!(gap.outputs[0].verdict, Verdict::Effects, "{}", gap.sentence);
    assert!(
        ["amplifier_bandwidth", "delay"].contains(&gap.outputs[0].effects[0].as_str()),
        "{:?}",
        gap.outputs[0].effects
    );
    // Behind the monitor nothing is missing.
    assert!(
        matches!(gap.outputs[1].verdict, Verdict::Adequate | Verdict::Retune),
        "{:?}",
        gap.outputs[1].verdict
    );
}

#[test]
fn complete_records_that_are_left_out_agree() {
    let machine = Machine::new(54, 1.0).with(Effect::Creep, 6.0);
    let gap = gap_of(machine.logs(), machine.sigma, |_| ());
    let second = gap.shrink.second_opinion.expect("four records");
    assert_eq!(second.records.len(), 4);
    assert!(second.agrees && second.fraction > 0.6, "{second:?}");
    // Logs that are held out are an opinion of their own.
    let gap = gap_of(machine.logs(), machine.sigma, |r| r.holdout = machine.logs());
    assert!(gap.shrink.second_opinion.is_none());
}
