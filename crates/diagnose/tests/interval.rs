//! The interval of what an answer takes away holds on new records, also where the logs say little.

use crate::common::machine::{Machine, blueprint};
use crate::common::truth::Effect;
use components::COMPONENTS;
use data::{CheckedBlueprint, Log};
use diagnose::{Gap, Model, Noise, Request, Silent, diagnose, examine};

fn request(machine: &Machine, model: CheckedBlueprint, logs: Vec<Log>) -> Request {
    let mut request = Request::new(Model::Blueprint(Box::new(model)), logs);
    request.noise = Noise::Given(vec![(None, machine.sigma)]);
    request
}

/// What a model leaves of these logs as it is.
fn left(machine: &Machine, model: CheckedBlueprint, logs: Vec<Log>) -> Gap {
    let mut request = request(machine, model, logs);
    request.max_effects = 0;
    diagnose(&request, &mut Silent).unwrap()
}

/// The stated interval of an answer to these logs, and the part of the gap's power that its blueprint takes away in others;
/// nothing where it has no answer.
fn stated_and_realised(
    machine: &Machine,
    logs: Vec<Log>,
    others: Vec<Log>,
) -> Option<([f64; 2], f64)> {
    let mut first = examine(&request(machine, blueprint(), logs), &mut Silent).unwrap();
    let (repaired, _) = first.repair(blueprint().blueprint());
    let stated = first.gap.shrink.ci95?;
    let power = |rms: f64| rms.powi(2) - machine.sigma.powi(2);
    let before = left(machine, blueprint(), others.clone()).shrink.rms_before;
    let repaired = repaired.check(COMPONENTS).unwrap();
    let after = left(machine, repaired, others).shrink.rms_as_given;
    Some((stated, 1.0 - power(after) / power(before)))
}

#[test]
fn an_interval_holds_on_other_records_of_a_machine_whose_log_says_little() {
    let effects = [
        Effect::Creep,
        Effect::AmplifierSaturation,
        Effect::AmplifierBandwidth,
        Effect::Hysteresis,
        Effect::SensorBandwidth,
    ];
    let (mut inside, mut all) = (0, 0);
    for (k, effect) in effects.into_iter().cycle().take(20).enumerate() {
        let machine = Machine::new(700 + k as u64, 1.0).with(effect, 6.0);
        let logs = machine.logs();
        // The start of a staircase.
        let short = machine.log(9, &machine.commands()[2][..1600]);
        if let Some(([low, high], realised)) = stated_and_realised(&machine, vec![short], logs) {
            all += 1;
            inside += u32::from((low..=high).contains(&realised));
        }
    }
    // Of the intervals of held-out rows alone nine of these sixteen held.
    assert!(all >= 12 && 4 * inside >= 3 * all, "{inside} of {all}");
}
