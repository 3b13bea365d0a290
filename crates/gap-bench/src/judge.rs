//! One answer against one truth.

use gap_machines::Effect;

use crate::answer::{Answer, Named};
use crate::label::{Label, TrueEffect};

/// Groups within which one output without taps cannot always decide.
const UNDECIDED: [&str; 3] = ["lag", "slow", "static_map"];

/// Whether an answer says that something is missing.
pub(crate) fn is_alarm(answer: &Answer) -> bool {
    answer.verdict == "effects" || answer.verdict == "unknown"
}

/// The name that is put first, or the verdict where none is.
pub(crate) fn first(answer: &Answer) -> &str {
    answer.effects.first().map_or(&answer.verdict, |named| &named.effect)
}

/// Whether the first name is the truth.
pub(crate) fn is_first(answer: &Answer, truth: &TrueEffect) -> bool {
    first(answer) == truth.effect
}

/// Whether the truth is the only name.
pub(crate) fn is_exactly(answer: &Answer, truth: &TrueEffect) -> bool {
    matches!(&answer.effects[..], [named] if named.set == [truth.effect.as_str()])
}

/// Whether the truth is in the set of a named effect.
pub(crate) fn is_in_set(answer: &Answer, truth: &TrueEffect) -> bool {
    answer.effects.iter().any(|named| named.set.contains(&truth.effect))
}

/// Whether this name stands for this truth: a member of the groups lag, slow and static_map by a set
/// that holds it and stays within its group, any other by its own name.
pub(crate) fn stands_for(named: &Named, truth: &TrueEffect) -> bool {
    let group = truth.group.as_deref().filter(|group| UNDECIDED.contains(group));
    match group {
        Some(group) => {
            let is_within = |name: &String| group_of(name) == Some(group);
            named.set.contains(&truth.effect) && named.set.iter().all(is_within)
        }
        None => named.effect == truth.effect,
    }
}

/// Whether the first name stands for the only effect.
pub(crate) fn is_right(answer: &Answer, truth: &TrueEffect) -> bool {
    answer.effects.first().is_some_and(|named| stands_for(named, truth))
}

/// Names that stand for no truth.
pub(crate) fn wrong_names<'a>(answer: &'a Answer, label: &Label) -> Vec<&'a Named> {
    let is_wrong = |named: &&Named| !label.effects.iter().any(|truth| stands_for(named, truth));
    answer.effects.iter().filter(is_wrong).collect()
}

/// How many of the truths are named.
pub(crate) fn truths_named(answer: &Answer, label: &Label) -> usize {
    let is_named =
        |truth: &&TrueEffect| answer.effects.iter().any(|named| stands_for(named, truth));
    label.effects.iter().filter(is_named).count()
}

/// Whether a name lies outside the group of the only truth; one without a group is a group of its own.
pub(crate) fn is_outside(name: &str, truth: &TrueEffect) -> bool {
    let group = Effect::find(&truth.effect).and_then(Effect::group);
    name != truth.effect && (group.is_none() || group_of(name) != group)
}

fn group_of(name: &str) -> Option<&'static str> {
    Effect::find(name).and_then(Effect::group)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::answer::{Leftover, Shrink};

    /// An answer that names effects, each with its set.
    pub(crate) fn answer(named: &[(&str, &[&str])]) -> Answer {
        let effects = named.iter().map(|(effect, set)| Named {
            effect: (*effect).into(),
            output: "y1".into(),
            probability: 0.9,
            set: set.iter().map(|name| (*name).to_owned()).collect(),
        });
        Answer {
            verdict: if named.is_empty() { "adequate" } else { "effects" }.into(),
            effects: effects.collect(),
            shrink: Shrink::default(),
            leftover: Leftover::default(),
        }
    }

    pub(crate) fn truth(effect: &str) -> TrueEffect {
        TrueEffect {
            effect: effect.into(),
            is_other_formula: false,
            wanted_size: 6.0,
            size: 6.0,
            magnitude: 1.0,
            group: group_of(effect).map(str::to_owned),
        }
    }

    pub(crate) fn label(family: &str, effects: &[&str]) -> Label {
        Label {
            case: "c".into(),
            family: family.into(),
            effects: effects.iter().map(|name| truth(name)).collect(),
            without: Vec::new(),
            total: 6.0,
            sigma: 0.01,
            rows: 1000,
            rate: 4000.0,
            setting: "open loop".into(),
            missed: Vec::new(),
        }
    }

    #[test]
    fn in_a_group_the_set_decides_and_outside_the_first_name() {
        let lag = truth("delay");
        let swapped = answer(&[("sensor_bandwidth", &["sensor_bandwidth", "delay"])]);
        assert!(is_right(&swapped, &lag) && !is_first(&swapped, &lag));
        // A set that leaves the group is no answer, even with the right name first.
        assert!(!is_right(&answer(&[("delay", &["delay", "extra_mode"])]), &lag));
        // Nor is one without the truth.
        assert!(!is_right(&answer(&[("sensor_bandwidth", &["sensor_bandwidth"])]), &lag));
        let mode = truth("extra_mode");
        assert!(is_right(&answer(&[("extra_mode", &["extra_mode", "delay"])]), &mode));
        assert!(!is_right(&answer(&[("delay", &["delay", "extra_mode"])]), &mode));
        // The gain group is decided by name.
        let gain = truth("actuator_gain");
        let other = answer(&[("resonance_shift", &["resonance_shift", "actuator_gain"])]);
        assert!(!is_right(&other, &gain) && is_in_set(&other, &gain));
    }

    #[test]
    fn a_hard_rail_has_no_group() {
        let rail = TrueEffect { group: None, ..truth("amplifier_saturation") };
        let soft =
            answer(&[("sensor_nonlinearity", &["sensor_nonlinearity", "amplifier_saturation"])]);
        assert!(!is_right(&soft, &rail) && is_right(&soft, &truth("amplifier_saturation")));
    }

    #[test]
    fn outside_is_any_other_name_where_there_is_no_group() {
        assert!(is_outside("backlash", &truth("friction")));
        assert!(is_outside("backlash", &truth("delay")));
        assert!(!is_outside("sensor_bandwidth", &truth("delay")));
        assert!(!is_outside("delay", &truth("delay")));
    }

    #[test]
    fn pairs_count_each_truth_and_each_wrong_name() {
        let pair = label("pair", &["creep", "backlash"]);
        let both = answer(&[("backlash", &["backlash"]), ("creep", &["creep", "thermal_drift"])]);
        assert_eq!((truths_named(&both, &pair), wrong_names(&both, &pair).len()), (2, 0));
        let half = answer(&[("backlash", &["backlash"]), ("delay", &["delay"])]);
        assert_eq!((truths_named(&half, &pair), wrong_names(&half, &pair).len()), (1, 1));
    }

    #[test]
    fn a_verdict_without_a_name_is_no_name() {
        let nothing = answer(&[]);
        assert_eq!(first(&nothing), "adequate");
        assert!(!is_alarm(&nothing) && !is_right(&nothing, &truth("creep")));
        let unknown = Answer { verdict: "unknown".into(), ..nothing };
        assert!(is_alarm(&unknown));
    }
}
