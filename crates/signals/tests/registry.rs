//! What must hold for every signal of the registry.

use std::collections::HashSet;
use std::path::Path;

use model::Unit;
use proptest::prelude::*;
use signals::{Parameter, Problem, Signal, SignalType, all, find, lookup};

#[test]
fn names_are_unique_and_found() {
    let mut seen = HashSet::new();
    for kind in all() {
        assert!(seen.insert(kind.name), "{} twice", kind.name);
        assert!(
            kind.name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
        );
        assert_eq!(find(kind.name).map(|found| found.name), Some(kind.name));
    }
    assert!(find("p9-unheard-of").is_none());
}

#[test]
fn an_unknown_signal_is_answered_with_all_names() {
    let text = lookup("p3-chrip").map(|kind| kind.name).unwrap_err().to_string();
    assert!(text.starts_with("no signal is named `p3-chrip`; known are p0-train-h, "), "{text}");
    assert!(all().all(|kind| text.contains(kind.name)));
}

#[test]
fn declarations_are_complete() {
    for kind in all() {
        for text in [kind.summary, kind.source, kind.equation] {
            assert!(text.len() > 5 && !text.ends_with('.') && !text.contains("  "), "{text}");
        }
        let mut names = HashSet::new();
        for p in kind.parameters {
            assert!(names.insert(p.name), "{}: {} twice", kind.name, p.name);
            assert!(Unit::parse(p.unit).is_ok(), "{}: unit {}", p.name, p.unit);
            assert!(p.description.ends_with('.'), "{}: {}", kind.name, p.description);
            assert!(
                p.min < p.max && (p.min..=p.max).contains(&p.start),
                "{}: {}",
                kind.name,
                p.name
            );
            assert!(!p.integer || [p.start, p.min, p.max].iter().all(|v| v.fract() == 0.0));
        }
        for channel in kind.channels {
            assert!(Unit::parse(channel.unit).is_ok() && !channel.name.contains(','));
        }
        for rule in kind.rules {
            assert!(kind.parameter(rule.parameter).is_some(), "{}: {}", kind.name, rule.parameter);
            assert!(rule.text.contains("; "), "{}: no way out: {}", kind.name, rule.text);
        }
    }
}

#[test]
fn start_values_give_a_record_within_its_stated_limits() {
    for kind in all() {
        let signal = kind.generate(&[]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(signal.channels.len(), kind.channels.len());
        for (channel, declared) in signal.channels.iter().zip(kind.channels) {
            let (low, high) = (channel.minimum(), channel.maximum());
            let (name, span) = (kind.name, declared.high - declared.low);
            assert_eq!(
                (channel.name.as_str(), channel.unit.as_str()),
                (declared.name, declared.unit)
            );
            assert_eq!(channel.values.len(), signal.len());
            assert!(low >= declared.low && high <= declared.high, "{name}: {low} to {high}");
            // Limits that nothing comes near would say little.
            assert!(high - low >= 0.75 * span, "{name} {}: {low} to {high}", channel.name);
        }
    }
}

#[test]
fn the_grid_is_exact() {
    let signal = find("sine").expect("known").generate(&[]).expect("valid");
    assert_eq!(signal.len(), 5000);
    assert_eq!(signal.time(4999), 4999.0 * 1e-3);
    // 0.3 s / 0.1 s is 2.9999999999999996 in floating point, and three samples all the same.
    let kind = find("rest").expect("known");
    for (duration, count) in [(0.3, 3), (0.30001, 4), (0.29, 3), (0.05, 1)] {
        let signal = kind.generate(&[("duration", duration), ("sample_time", 0.1)]).expect("valid");
        assert_eq!(signal.len(), count, "{duration} s");
    }
}

/// Whether one of some other values of a parameter is accepted and changes the signal.
fn matters(kind: &SignalType, parameter: &Parameter, normal: &Signal) -> bool {
    let start = parameter.start;
    let integer = |v: f64| if parameter.integer { v.round() } else { v };
    let others = [0.5 * start, 0.9 * start, start + 1.0, start + 0.1, 1.3 * start, 3.0 * start];
    others.into_iter().map(integer).filter(|v| *v != start).any(|value| {
        kind.generate(&[(parameter.name, value)]).is_ok_and(|changed| changed != *normal)
    })
}

#[test]
fn every_declared_parameter_changes_the_signal() {
    for kind in all() {
        let normal = kind.generate(&[]).expect("start values are valid");
        for parameter in kind.parameters {
            assert!(matters(kind, parameter, &normal), "{}: {}", kind.name, parameter.name);
        }
    }
}

#[test]
fn seeds_reproduce_and_differ() {
    let seeded: Vec<_> = all().filter(|kind| kind.parameter("seed").is_some()).collect();
    assert_eq!(seeded.len(), 7);
    for kind in seeded {
        let with = |seed: f64| kind.generate(&[("seed", seed)]).expect("a valid seed");
        assert!(with(12.0) == with(12.0), "{}", kind.name);
        assert!(with(12.0) != with(13.0), "{}", kind.name);
    }
}

/// The bits of random signals must not change from release to release: records name a seed.
#[test]
fn random_signals_keep_their_bits() {
    let sum = |name: &str| {
        let signal = find(name).expect("known").generate(&[]).expect("valid");
        let bits = signal.channels[0].values.iter().map(|v| v.to_bits());
        bits.fold(0u64, |sum, bits| sum.rotate_left(5).wrapping_add(bits))
    };
    let sums: Vec<u64> =
        ["p1-c", "p1-f", "p1-g", "multisine", "multisine-odd", "multisine-odd-random"]
            .map(sum)
            .to_vec();
    let expected: [u64; 6] = [
        16116606045848568583,
        12970191127427559446,
        9626519686212582950,
        4576630503037612190,
        13584005201707028509,
        4614008616289759607,
    ];
    assert_eq!(sums, expected);
}

#[test]
fn refusals_name_value_rule_and_way_out() {
    let kind = find("p3-sine").expect("known");
    let text = |settings: &[(&str, f64)]| kind.generate(settings).unwrap_err().to_string();
    assert_eq!(
        text(&[("freq", 3.0)]),
        "signal `p3-sine`: unknown parameter `freq` (= 3); the parameters are frequency, top, \
         sample_time, duration"
    );
    assert_eq!(
        text(&[("frequency", 12000.0)]),
        "signal `p3-sine`: frequency = 12000 Hz must not exceed half the sample rate, \
         1/(2·sample_time); lower it or sample faster"
    );
    assert_eq!(
        text(&[("top", 200.0)]),
        "signal `p3-sine`: top = 200 V is not within 0.001 to 150 V; give a value inside"
    );
    assert_eq!(
        text(&[("duration", 1e5)]),
        "signal `p3-sine`: the record would have 2000000000 samples of 0.00005 s; it needs 1 to \
         10000000: change sample_time or the length of the record"
    );
    let seed = find("p1-c").expect("known").generate(&[("seed", 1.5)]).unwrap_err().to_string();
    assert_eq!(seed, "signal `p1-c`: seed = 1.5 must be a whole number; 1 and 2 are the nearest");
}

#[test]
fn all_problems_come_at_once() {
    let kind = find("sine").expect("known");
    let given =
        [("hihg", 1.0), ("low", f64::NAN), ("frequency", -1.0), ("phase", 0.0), ("phase", 1.0)];
    let error = kind.generate(&given).unwrap_err();
    assert_eq!(error.problems.len(), 4, "{error}");
    assert!(matches!(error.problems[0], Problem::Unknown { .. }));
    assert!(matches!(error.problems[3], Problem::Twice { name: "phase", .. }));
    let rules = kind.generate(&[("low", 200.0), ("frequency", 1000.0)]).unwrap_err();
    assert_eq!(rules.problems.len(), 2, "{rules}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever is asked for: a record within the declared limits `low` and `high`, or a refusal,
    /// and never a value that is no number.
    #[test]
    fn any_settings_give_a_finite_record_or_a_refusal(
        at in 0..all().count(),
        draws in proptest::collection::vec((0.0..1.0f64, proptest::bool::weighted(0.95)), 12),
    ) {
        let kind = all().nth(at).expect("an index of the registry");
        let draw = |(p, (part, near)): (&Parameter, &(f64, bool))| {
            let value = if *near { p.start * (0.25 + 2.0 * part) } else { p.min + part * (p.max - p.min) };
            (p.name, if p.integer { value.round() } else { value })
        };
        let given: Vec<(&str, f64)> = kind.parameters.iter().zip(&draws).map(draw).collect();
        let Ok(settings) = kind.checked(&given) else { return Ok(()) };
        // A multisine costs lines times samples; short ones are enough here.
        prop_assume!(settings.samples() <= 200_000);
        prop_assume!(settings.value("samples_per_period").is_none_or(|n| n <= 1e4));
        let Ok(signal) = kind.generate(&given) else { return Ok(()) };
        for channel in &signal.channels {
            prop_assert!(channel.values.iter().all(|v| v.is_finite()), "{}", kind.name);
            let limits = (settings.value("low"), settings.value("high"));
            if let (Some(low), Some(high)) = limits {
                prop_assert!(channel.minimum() >= low && channel.maximum() <= high, "{}", kind.name);
            }
        }
    }
}

#[test]
fn the_written_reference_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("SIGNALS.md");
    let written = std::fs::read_to_string(&path).expect("SIGNALS.md is in the folder");
    assert!(
        written == signals::document(),
        "SIGNALS.md is not current; write it by the command in its first lines"
    );
    assert_eq!(signals::table().lines().count(), 2 + all().count());
}
