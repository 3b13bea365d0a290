//! Scenes hold what they promise: sizes, tolerances, logs.

use super::*;

fn order(effects: Vec<Wish>) -> Order {
    Order {
        seed: 7,
        effects,
        setting: Setting::OpenLoop,
        rate: 4000.0,
        length: 0.5,
        is_linear: false,
        wrong_weights: 0.0,
        axes: 1,
        offset: 0.0,
        timing: Timing::Before,
        smooth: 0.0,
    }
}

fn wish(effect: Effect, formula: Formula, size: f64) -> Wish {
    Wish { effect, formula, size }
}

#[test]
fn without_an_effect_the_re_tuned_model_leaves_less_than_the_noise() {
    for setting in [Setting::OpenLoop, Setting::ClosedLoop, Setting::Operation] {
        let scene = Scene::draw(&Order { setting, ..order(Vec::new()) }).unwrap();
        assert!(scene.total < 0.15, "{setting:?}: {}", scene.total);
    }
}

#[test]
fn effects_have_their_size_in_all_settings() {
    for setting in [Setting::OpenLoop, Setting::ClosedLoop, Setting::Operation] {
        let effects = vec![wish(Effect::Creep, Formula::Other, 6.0)];
        let scene = Scene::draw(&Order { setting, ..order(effects) }).unwrap();
        assert!((scene.sizes[0] / 6.0 - 1.0).abs() < 0.05, "{:?}", scene.sizes);
        // Together is alone here; the log differs from what was sized by rounding only.
        assert!((scene.total / scene.sizes[0] - 1.0).abs() < 0.05, "{}", scene.total);
    }
}

#[test]
fn unseen_records_are_of_the_kinds_held_out_without_noise_and_not_the_same() {
    let scene = Scene::draw(&order(vec![wish(Effect::Creep, Formula::Standard, 6.0)])).unwrap();
    assert_eq!(scene.fit.len(), 4);
    for (seen, unseen) in scene.held_out.iter().zip(&scene.unseen) {
        assert_eq!(seen.kind, unseen.kind);
        assert_ne!(seen.commands[0], unseen.commands[0]);
        assert!(unseen.missed.unwrap() > scene.sigma[0]);
    }
}

#[test]
fn readings_after_their_command_are_those_before_the_next() {
    let plain = Scene::draw(&order(Vec::new())).unwrap();
    let moved = Scene::draw(&Order { timing: Timing::After, ..order(Vec::new()) }).unwrap();
    // Of which only the noise stands with another row.
    let (a, b) = (&plain.unseen[2].readings[0], &moved.unseen[2].readings[0]);
    assert_eq!(a[1..], b[..b.len() - 1]);
    assert_eq!(plain.fit[0].commands, moved.fit[0].commands);
}

#[test]
fn a_band_limited_course_goes_through_its_values_and_follows_a_sine_between_them() {
    let sine = |x: f64| 50.0 + 20.0 * (TAU * x / 9.0).sin();
    let values: Vec<f64> = (0..200).map(|k| sine(k as f64)).collect();
    let course = band_limited(&values);
    for (k, value) in values.iter().enumerate() {
        assert!((course[FINER * k] - value).abs() < 1e-9);
    }
    let worst = (FINER * 30..FINER * 170)
        .map(|k| (course[k] - sine(k as f64 / FINER as f64)).abs())
        .fold(0.0, f64::max);
    assert!(worst < 0.05, "{worst}");
    let scene = Scene::draw(&Order { timing: Timing::BandLimited, ..order(Vec::new()) });
    assert!(scene.is_ok());
}

#[test]
fn what_no_formula_has_is_as_large_as_stated() {
    let effects = vec![wish(Effect::Creep, Formula::Standard, 20.0)];
    let plain = Scene::draw(&order(effects.clone())).unwrap();
    let smooth = Scene::draw(&Order { smooth: 0.2, ..order(effects) }).unwrap();
    let all = plain.fit.iter().zip(&smooth.fit);
    let (mut squares, mut rows) = (0.0, 0);
    for (a, b) in all {
        squares += crate::rms(&a.readings[0], &b.readings[0]).powi(2) * a.readings[0].len() as f64;
        rows += a.readings[0].len();
    }
    let rms = (squares / rows as f64).sqrt() / plain.sigma[0];
    assert!((rms / 4.0 - 1.0).abs() < 0.3, "{rms}");
}

#[test]
fn what_is_played_is_answered_as_the_record_with_noise_of_its_own() {
    let effects = vec![wish(Effect::Creep, Formula::Standard, 6.0)];
    let scene = Scene::draw(&order(effects)).unwrap();
    let record = &scene.fit[1];
    assert_eq!(scene.play(&record.commands, 1), record.readings);
    let again = scene.play(&record.commands, 400);
    let apart: f64 = again[0].iter().zip(&record.readings[0]).map(|(a, b)| (a - b).powi(2)).sum();
    let rms = (apart / again[0].len() as f64).sqrt();
    assert!((rms / scene.sigma[0] / 2.0_f64.sqrt() - 1.0).abs() < 0.15, "{rms}");
}

#[test]
fn readings_share_their_offset() {
    let plain = Scene::draw(&order(Vec::new())).unwrap();
    let moved = Scene::draw(&Order { offset: 30.0, ..order(Vec::new()) }).unwrap();
    let all = |scene: &Scene| -> Vec<Record> {
        [&scene.fit[..], &scene.held_out, &scene.unseen].concat()
    };
    for (a, b) in all(&plain).iter().zip(&all(&moved)) {
        let pairs = a.readings[0].iter().zip(&b.readings[0]);
        assert!(pairs.into_iter().all(|(a, b)| (b - a - 30.0 * plain.sigma[0]).abs() < 2e-6));
    }
}

#[test]
fn the_noise_of_the_idle_record_is_as_stated() {
    let scene = Scene::draw(&Order { length: 4.0, ..order(Vec::new()) }).unwrap();
    let y = &scene.idle.readings[0];
    let rms = (y.iter().map(|y| y * y).sum::<f64>() / y.len() as f64).sqrt();
    assert!((rms / scene.sigma[0] - 1.0).abs() < 0.1, "{rms} {}", scene.sigma[0]);
}

#[test]
fn a_second_axis_and_a_wrong_model_change_what_they_should() {
    let two = Scene::draw(&Order { axes: 2, ..order(Vec::new()) }).unwrap();
    assert_eq!(two.fit[0].readings.len(), 2);
    assert_eq!(two.blueprint.matches("[[axis]]").count(), 2);
    let wrong = Scene::draw(&Order { wrong_weights: 0.3, ..order(Vec::new()) }).unwrap();
    // The effects (none) leave nothing, but the model misses what nobody saw.
    assert!(wrong.total < 0.15, "{}", wrong.total);
    assert!(wrong.unseen.iter().any(|r| r.missed.unwrap() > wrong.sigma[0]));
}
