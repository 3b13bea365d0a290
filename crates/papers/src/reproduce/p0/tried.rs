//! Other ways inside the paper's method, each a row by itself.

use identify::learned::{Arx, Frame, Machine, Recipe, Selection, Span, held_out};
use learned::features::{Features, Narx};
use learned::lssvm::Settings;

use super::super::{Aim, Reproduction, Row};
use super::method::{GAMMA, Method, PERIOD, VALIDATED};
use super::{ID, Model, Record, Records, linear, percent};

/// Other ways inside the paper's method, each a row by itself: unpruned, with D, on the tests.
pub(super) fn tried(
    records: &Records,
    own: &Method,
    answer: &mut Reproduction,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<()> {
    let (h, d) = (&records.train_h, &records.train_d);
    let pairs = [(&h.u[..], &h.theta[..])];
    let narx = |past: usize, pairs: &[(&[f64], &[f64])]| {
        let narx = Features::Narx(Narx { commands: past, outputs: past });
        Frame::new(narx, Span::UNIT, Span::UNIT, Recipe::Plain, pairs)
    };
    // On record H without D, then with it on record D and the tests.
    let judged =
        |machine: Machine, [h, d]: [&Record; 2], tests: [&Record; 2]| -> Option<[f64; 4]> {
            let on_h = percent(&machine.simulate(&h.u, h.theta0), &h.theta);
            let model = Model::new(machine, &d.u, &d.theta, d.theta0).ok()?;
            let [one, two] = tests.map(|r| model.error(&r.u, &r.theta, r.theta0));
            Some([on_h, model.error(&d.u, &d.theta, d.theta0), one, two])
        };
    let both = [&records.tests[0], &records.tests[1]];
    let mut all: Vec<(String, Option<[f64; 4]>)> = Vec::new();
    say("tried: settings on a finer grid");
    // By H alone, and by what is left of the record of the frequency-varying signal with D.
    let mut best: [Option<(f64, usize, Settings, Machine)>; 2] = [None, None];
    for past in [1, 2, 3] {
        for sigma2 in [0.5, 1.0, 2.0, 4.0, 8.0] {
            for gamma in [1.0, 10.0, 1e2, 1e3, 1e5] {
                let settings = Settings { gamma, sigma2 };
                let Ok((machine, _)) = Machine::train(narx(past, &pairs), &pairs, settings) else {
                    continue;
                };
                let on_h = percent(&machine.simulate(&h.u, h.theta0), &h.theta);
                let with = Model::new(machine.clone(), &d.u, &d.theta, d.theta0)
                    .map_or(f64::INFINITY, |model| model.error(&d.u, &d.theta, d.theta0));
                for (best, error) in best.iter_mut().zip([on_h, on_h.hypot(with)]) {
                    if error.is_finite() && best.as_ref().is_none_or(|(least, ..)| error < *least) {
                        *best = Some((error, past, settings, machine.clone()));
                    }
                }
            }
        }
    }
    for (best, by) in best.into_iter().zip(["record H", "records H and D"]) {
        let Some((_, past, settings, machine)) = best else { continue };
        let what = format!(
            "75 settings by the simulation of {by} (N_h = {past}, sigma^2 = {}, gamma = {:.0e})",
            settings.sigma2, settings.gamma
        );
        all.push((what, judged(machine, [h, d], both)));
    }
    say("tried: smoothed angles, fewer samples a second");
    // Forwards and backwards, so that nothing is late.
    let lag = Arx::lag(SMOOTHED, PERIOD);
    let there = lag.simulate(&h.theta, h.theta[0]);
    let turned: Vec<f64> = there.into_iter().rev().collect();
    let mut smooth = lag.simulate(&turned, turned[0]);
    smooth.reverse();
    let clean = [(&h.u[..], &smooth[..])];
    let machine = Machine::train(own.frame.clone(), &clean, own.forward).ok();
    let what = format!("angles low-passed at {SMOOTHED} Hz forwards and backwards");
    all.push((what, machine.and_then(|(machine, _)| judged(machine, [h, d], both))));
    for rows in [2, 4, 8] {
        let (h, d) = (h.every(rows), d.every(rows));
        let tests = records.tests.each_ref().map(|test| test.every(rows));
        let pairs = [(&h.u[..], &h.theta[..])];
        let mut best: Option<(f64, Settings, Machine)> = None;
        for sigma2 in [0.5, 2.0, 8.0] {
            for gamma in [1e2, 1e4] {
                let settings = Settings { gamma, sigma2 };
                let Ok((machine, _)) = Machine::train(narx(2, &pairs), &pairs, settings) else {
                    continue;
                };
                let error = percent(&machine.simulate(&h.u, h.theta0), &h.theta);
                if best.as_ref().is_none_or(|(least, ..)| error < *least) {
                    best = Some((error, settings, machine));
                }
            }
        }
        let what = format!("a sample each {} ms, N_h = 2", 5 * rows);
        let [one, two] = &tests;
        all.push((what, best.and_then(|(.., machine)| judged(machine, [&h, &d], [one, two]))));
    }
    for (what, errors) in all {
        let add_row = errors.unwrap_or([f64::INFINITY; 4]);
        let on = ["signal H", "with D, frequency-varying", "with D, test 1", "with D, test 2"];
        for ((error, paper), on) in add_row.into_iter().zip([0.426, 0.957, 0.925, 1.18]).zip(on) {
            let what = format!("tried: {what}, {on}");
            answer.rows.push(Row::new(ID, what, "%", paper, error, Aim::ForComparison));
        }
    }
    say("tried: figure 8a");
    let slow = h.every(4);
    let smoothed = [(&h.u[..], &smooth[..])];
    let slowly = [(&slow.u[..], &slow.theta[..])];
    for (what, pairs, gamma) in [
        ("gamma = 1e2", &pairs, 1e2),
        ("angles low-passed at 10 Hz forwards and backwards", &smoothed, GAMMA),
        ("a sample each 20 ms", &slowly, GAMMA),
    ] {
        let settings = [Settings { gamma, sigma2: 2.0 }];
        let ten = Selection::CrossValidation(10);
        let error = held_out(&narx(2, pairs), pairs, ten, &settings, VALIDATED)?;
        let what = format!("tried: figure 8a, N_h = 2, sigma^2 = 2, {what}");
        let error = 100.0 * error.first().copied().unwrap_or(f64::INFINITY);
        answer.rows.push(Row::new(ID, what, "%", 0.5, error, Aim::ForComparison));
    }
    tried_inverses(records, own, answer, say)
}

/// Other inverses inside the paper's method, unpruned: other settings, and another forward model to learn from.
pub(super) fn tried_inverses(
    records: &Records,
    own: &Method,
    answer: &mut Reproduction,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<()> {
    say("tried: inverses");
    let (h, d) = (&records.train_h, &records.train_d);
    let narx = |past: usize| {
        let narx = Features::Narx(Narx { commands: past, outputs: past });
        Frame::new(narx, Span::UNIT, Span::UNIT, Recipe::Plain, &[])
    };
    let measured = [(&h.u[..], &h.theta[..])];
    let (forward, _) = Machine::train(own.frame.clone(), &measured, own.forward)?;
    let fine = Settings { gamma: 1e2, sigma2: 0.5 };
    let (other, _) = Machine::train(narx(1), &measured, fine)?;
    let sets = |forward: &Machine| forward.simulate(&h.u, h.theta0);
    let (clean, other_clean) = (sets(&forward), sets(&other));
    // By the simulation of the record that is learned from, or of the measured angles.
    let found = |clean: &[f64], asked: &[f64]| {
        let mut best: Option<(f64, usize, Settings, Machine)> = None;
        for past in [1, 2, 3] {
            for sigma2 in [0.5, 2.0, 8.0] {
                for gamma in [1e2, 1e4, 1e6] {
                    let settings = Settings { gamma, sigma2 };
                    let pairs = [(clean, &h.u[..])];
                    let Ok((machine, _)) = Machine::train(narx(past), &pairs, settings) else {
                        continue;
                    };
                    let error = percent(&machine.simulate(asked, h.u[0]), &h.u);
                    if error.is_finite() && best.as_ref().is_none_or(|(least, ..)| error < *least) {
                        best = Some((error, past, settings, machine));
                    }
                }
            }
        }
        best
    };
    for (what, best, forward) in [
        ("settings by the simulated angles", found(&clean, &clean), &forward),
        ("settings by the measured angles", found(&clean, &h.theta), &forward),
        (
            "settings by the measured angles, learned from a forward model of N_h = 1, sigma^2 = 0.5",
            found(&other_clean, &h.theta),
            &other,
        ),
    ] {
        let Some((_, past, settings, machine)) = best else { continue };
        let answer_of_d = forward.simulate(&d.u, d.theta0);
        let cancelled = (0..=3).find_map(|ahead| linear(&d.theta, &answer_of_d, PERIOD, ahead));
        let error = |record: &Record| {
            let theta = match &cancelled {
                Some(cancelled) => cancelled.simulate(&record.theta, record.theta[0]),
                None => record.theta.clone(),
            };
            percent(&machine.simulate(&theta, record.u[0]), &record.u)
        };
        let [one, two] = &records.tests;
        let on_h = percent(&machine.simulate(&h.theta, h.u[0]), &h.u);
        let rows = [
            ("signal H", 1.17, on_h),
            ("with D, frequency-varying", 1.25, error(d)),
            ("with D, test 1", 1.13, error(one)),
            ("with D, test 2", 2.51, error(two)),
        ];
        for (on, paper, error) in rows {
            let what = format!(
                "tried: inverse, {what} (N_h = {past}, sigma^2 = {}, gamma = {:.0e}), {on}",
                settings.sigma2, settings.gamma
            );
            answer.rows.push(Row::new(ID, what, "%", paper, error, Aim::ForComparison));
        }
    }
    Ok(())
}

/// Cut-off in Hz of the low-pass that is tried on angles.
pub(super) const SMOOTHED: f64 = 10.0;
