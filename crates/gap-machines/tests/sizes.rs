//! Every effect can be had at the stated sizes, on machines of every draw.

use gap_machines::{Effect, Formula, Order, Scene, Setting, Timing, Wish};

fn draw(effect: Effect, formula: Formula, size: f64, seed: u64) -> Result<Scene, String> {
    let order = Order {
        seed,
        effects: vec![Wish { effect, formula, size }],
        setting: Setting::OpenLoop,
        rate: 4000.0,
        length: 0.4,
        is_linear: false,
        wrong_weights: 0.0,
        axes: 1,
        offset: 0.0,
        timing: Timing::Before,
        smooth: 0.0,
    };
    Scene::draw(&order).map_err(|error| error.to_string())
}

fn every_effect_changes_the_reading_by(size: f64, formula: Formula) {
    for &effect in Effect::ALL {
        // Not every machine can show every size: others are drawn until one can.
        let scene = (1..8).find_map(|seed| draw(effect, formula, size, seed).ok());
        let Some(scene) = scene else {
            // A start apart from rest passes at the first reversal.
            assert_eq!(effect, Effect::InitialState, "{formula:?} {size}");
            continue;
        };
        let error = scene.total / size - 1.0;
        assert!(error.abs() < 0.21, "{} {formula:?}: {}", effect.name(), scene.total);
    }
}

#[test]
fn every_effect_of_the_standard_formula_has_the_small_size() {
    every_effect_changes_the_reading_by(2.0, Formula::Standard);
}

#[test]
fn every_effect_of_the_standard_formula_has_the_large_size() {
    every_effect_changes_the_reading_by(20.0, Formula::Standard);
}

#[test]
fn every_effect_of_the_other_formula_has_the_small_size() {
    every_effect_changes_the_reading_by(2.0, Formula::Other);
}

#[test]
fn every_effect_of_the_other_formula_has_the_large_size() {
    every_effect_changes_the_reading_by(20.0, Formula::Other);
}

#[test]
fn the_same_order_gives_the_same_records() {
    let run = || draw(Effect::ThermalDrift, Formula::Other, 6.0, 3).unwrap();
    let (a, b) = (run(), run());
    assert_eq!(a.fit, b.fit);
    assert_eq!(a.unseen, b.unseen);
    assert_ne!(a.fit, draw(Effect::ThermalDrift, Formula::Other, 6.0, 4).unwrap().fit);
}
