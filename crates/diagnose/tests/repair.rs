//! What is promised of a repaired blueprint is what it does.

use crate::common::machine::{Machine, blueprint};
use crate::common::truth::Effect;
use components::COMPONENTS;
use diagnose::{Model, Noise, Request, Silent, diagnose, examine};

fn request(machine: &Machine) -> Request {
    let mut request = Request::new(Model::Blueprint(Box::new(blueprint())), machine.logs());
    request.noise = Noise::Given(vec![(None, machine.sigma)]);
    request
}

/// The answer's root mean squares before and after, and that of the written blueprint as it is.
fn before_after_written(effect: Effect) -> [f64; 3] {
    let machine = Machine::new(300 + effect as u64, 1.0).with(effect, 10.0);
    let mut first = examine(&request(&machine), &mut Silent).unwrap();
    assert!(!first.gap.effects.is_empty(), "{effect:?}: {}", first.gap.sentence);
    let found = first.gap.shrink.clone();
    let (repaired, _) = first.repair(blueprint().blueprint());
    let promised = &first.gap.shrink;
    assert_eq!(promised.as_found, found.fraction, "{effect:?}");
    assert_eq!(first.gap.outputs[0].shrink, *promised);
    let mut again = request(&machine);
    again.model = Model::Blueprint(Box::new(repaired.check(COMPONENTS).unwrap()));
    again.max_effects = 0;
    let second = diagnose(&again, &mut Silent).unwrap();
    [promised.rms_before, promised.rms_after, second.shrink.rms_as_given]
}

/// Which machines: the answer's figures are those of the blueprint; its component takes the gap away.
const MACHINES: [(Effect, bool, bool); 8] = [
    (Effect::Asymmetry, true, true),
    (Effect::AmplifierSaturation, true, true),
    (Effect::Crosstalk, true, true),
    (Effect::PolarisationSaturation, true, true),
    (Effect::SelfHeating, true, false),
    (Effect::CrossCoupling, true, false),
    (Effect::Friction, false, true),
    (Effect::Duffing, false, true),
];

#[test]
fn the_answer_speaks_of_the_blueprint_that_is_handed_back_and_its_component_takes_the_gap_away() {
    for (effect, is_as_written, takes_away) in MACHINES {
        let [before, after, written] = before_after_written(effect);
        if is_as_written {
            assert!((written / after - 1.0).abs() < 1e-3, "{effect:?}: {written} is not {after}");
            assert!(after < 1.02 * before, "{effect:?}: {after} is worse than {before}");
        }
        if takes_away {
            assert!(after < 0.3 * before, "{effect:?}: {after} of {before}");
        }
    }
}

/// Both are named. No component holds two forces: the one that is written stays, and the other is told.
#[test]
fn of_two_forces_on_a_mode_both_are_named_and_one_is_written() {
    let machine = Machine::new(42, 1.0).with(Effect::Friction, 15.0).with(Effect::Duffing, 15.0);
    let mut first = examine(&request(&machine), &mut Silent).unwrap();
    let names: Vec<String> = first.gap.effects.iter().map(|e| e.effect.clone()).collect();
    assert!(names.contains(&"duffing".to_owned()), "{}", first.gap.sentence);
    assert!(names.len() == 2 && names.contains(&"friction".to_owned()), "{names:?}");
    assert!(first.gap.shrink.fraction > Some(0.95), "{:?}", first.gap.shrink);
    let (repaired, notes) = first.repair(blueprint().blueprint());
    let is_reported =
        |name: &&String| notes.iter().any(|note| note.starts_with(&format!("{name} (")));
    let described: Vec<_> = names.iter().filter(is_reported).collect();
    assert_eq!(described.len(), 1, "{names:?}: {notes:?}");
    let written = names.iter().find(|name| !described.contains(name)).unwrap();
    let found = format!("{written}, found by diagnosis");
    let all = &repaired.axes[0].components;
    assert!(all.iter().any(|c| c.note == found), "{found}: {all:?}");
}
