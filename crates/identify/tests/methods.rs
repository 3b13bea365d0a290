//! Every method finds the machine that it can describe.

#![allow(clippy::print_stdout, reason = "figures and seeds are shown with --nocapture")]

use crate::common::target;
use data::{AxisBlueprint, Blueprint, ComponentBlueprint};
use identify::learned::{Seek, Selection};
use identify::{
    Columns, Dynamics, Error, FeatureChoice, Identification, Learning, Methods, Observer, Record,
    Search, Settings, Silent, Swarm, Verdict, identify, methods, simulate,
};
use learned::COMPONENTS;
use model::Kind;
use numerics::random::SplitMix64;

const PERIOD: f64 = 1e-3;

/// Sines of 1, 4 and 13 Hz with falling amplitude.
fn command() -> Vec<f64> {
    let sine = |k: usize| {
        let t = k as f64 * PERIOD;
        let slow = (std::f64::consts::TAU * t).sin() * (-0.15 * t).exp();
        let fast = (std::f64::consts::TAU * 4.0 * t).sin();
        50.0 + 30.0 * slow + 12.0 * fast + 6.0 * (std::f64::consts::TAU * 13.0 * t).sin()
    };
    (0..6000).map(sine).collect()
}

fn log(component: ComponentBlueprint, noise: f64) -> Record {
    let mut axis = AxisBlueprint::new("Y", "V", "um");
    axis.components = vec![component];
    measured(axis, noise)
}

fn measured(axis: AxisBlueprint, noise: f64) -> Record {
    let truth = Blueprint::new(Kind::Plant, "truth", PERIOD).axis(axis);
    let truth = truth.check(COMPONENTS).unwrap_or_else(|e| panic!("{e}"));
    let input = command();
    let time: Vec<f64> = (0..input.len()).map(|k| k as f64 * PERIOD).collect();
    let columns = |output| Columns {
        name: "simulated",
        time: &time,
        input_name: "u",
        input: &input,
        output_name: "y",
        output,
    };
    let record = Record::new(columns(&input)).unwrap_or_else(|e| panic!("{e:?}"));
    let mut output = simulate(&truth, &record).unwrap_or_else(|e| panic!("{e}"));
    let mut random = SplitMix64::new(11);
    output.iter_mut().for_each(|y| *y += noise * random.normal());
    Record::new(columns(&output)).unwrap_or_else(|e| panic!("{e:?}"))
}

fn found(record: &Record, method: &str, search: Search) -> Identification {
    let settings = Settings {
        plays: 12,
        dynamics: Dynamics::Static,
        methods: Methods::Named(vec![method.to_owned()]),
        longest_delay: Some(2.0 * PERIOD),
        search,
        ..Settings::default()
    };
    identify(std::slice::from_ref(record), &target("found"), &settings, &mut Silent)
        .unwrap_or_else(|e| panic!("{method}: {e}"))
}

fn bouc_wen() -> ComponentBlueprint {
    ComponentBlueprint::new("bouc-wen")
        .value("gain", 0.05)
        .value("alpha", 0.4)
        .value("beta", 0.06)
        .value("gamma", 0.02)
        .value("delta", 0.01)
}

fn parameter<'a>(id: &'a Identification, name: &str) -> &'a identify::Estimate {
    let found = id.parameters.iter().find(|p| p.name == name);
    found.unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn asymmetric_bouc_wen_is_found_to_the_noise_by_both_searches() {
    let record = log(bouc_wen(), 0.002);
    let swarm = Swarm { particles: 40, iterations: 60, ..Swarm::default() };
    for search in [Search::LevenbergMarquardt, Search::ParticleSwarm(swarm)] {
        let id = found(&record, "bouc-wen-asymmetric", search);
        let rmse = id.records[0].held_out.rmse;
        println!("seeds 1 and 11, {search:?}: {rmse}");
        assert!(rmse < 0.0024, "{rmse}");
        let decay = parameter(&id, "beta + gamma");
        assert!((decay.value / 0.08 - 1.0).abs() < 0.1, "{decay:?}");
    }
}

#[test]
fn the_swarm_s_answer_depends_on_the_seed_and_not_on_the_threads() {
    let record = log(bouc_wen(), 0.002);
    let run = |seed: u64, threads: usize| {
        let swarm = Swarm { particles: 8, iterations: 5, seed, threads, ..Swarm::default() };
        found(&record, "bouc-wen", Search::ParticleSwarm(swarm)).parameters
    };
    assert_eq!(run(3, 1), run(3, 3));
    assert_ne!(run(3, 1), run(4, 1));
}

#[test]
fn growth_with_the_rate_is_found_and_absent_rate_is_reported() {
    let r = [5.0, 10.0, 15.0, 20.0];
    let play = |rate: f64| {
        ComponentBlueprint::new("rate-dependent-play")
            .value("r", r)
            .value("w", [0.01, 0.008, 0.004, 0.002])
            .value("gain", 0.03)
            .value("rate", rate)
    };
    let id = found(&log(play(2e-3), 0.001), "rate-dependent-play", Search::default());
    let rate = parameter(&id, "hysteresis.rate");
    println!("{rate:?}");
    assert!((rate.value / 2e-3 - 1.0).abs() < 0.15, "{rate:?}");
    let id = found(&log(play(0.0), 0.001), "rate-dependent-play", Search::default());
    let rate = parameter(&id, "hysteresis.rate");
    assert!(rate.value < 2e-4 && rate.verdict != Verdict::Determined, "{rate:?}");
}

#[test]
fn every_method_writes_the_plant_that_it_fitted() {
    let record = log(bouc_wen(), 0.002);
    for (name, _) in methods().filter(|(name, _)| *name != "prandtl-ishlinskii") {
        let id = found(&record, name, Search::default());
        let candidate = id.candidates.iter().find(|c| c.method == Some(name));
        let candidate = candidate.unwrap_or_else(|| panic!("{name} was not tried"));
        let (Some(fitted), Some(held)) = (candidate.fitted_nrmse, candidate.held_out_nrmse) else {
            panic!("{name}: {}", candidate.reason)
        };
        println!("{name}: fitted {:.3} %, held out {:.3} %", 100.0 * fitted, 100.0 * held);
        // A plant beside its fit would be off by far more than by what it cannot describe.
        assert!(held < 0.05 && fitted < 0.05, "{name}: {fitted} {held}");
        assert_eq!(id.method, name);
    }
}

/// Asks to stop after the first method beside the static model.
struct Impatient {
    seen: Vec<&'static str>,
}

impl Observer for Impatient {
    fn progress(&mut self, stage: &'static str, _done: usize, _total: usize) {
        if self.seen.last() != Some(&stage) {
            self.seen.push(stage);
        }
    }

    fn stopped(&self) -> bool {
        self.seen.contains(&"rate-dependent-play")
    }
}

#[test]
fn stopping_returns_the_best_of_what_is_finished() {
    let record = log(bouc_wen(), 0.002);
    let settings = Settings {
        plays: 8,
        dynamics: Dynamics::Static,
        methods: Methods::Sensible,
        ..Settings::default()
    };
    let mut impatient = Impatient { seen: Vec::new() };
    let id = identify(&[record], &target("found"), &settings, &mut impatient).expect("a model");
    assert!(id.stopped);
    assert!(id.method.starts_with("bouc-wen"), "{}", id.method);
    assert!(id.candidates.iter().all(|c| c.method != Some("preisach")));
}

#[test]
fn an_unknown_method_is_named_with_those_that_exist() {
    let record = log(bouc_wen(), 0.002);
    let methods = Methods::Named(vec!["preisac".to_owned()]);
    let settings = Settings { methods, ..Settings::default() };
    let error = identify(&[record], &target("x"), &settings, &mut Silent).expect_err("unknown");
    assert!(matches!(error, Error::NoMethod { .. }));
    assert!(error.to_string().contains("\"preisac\"") && error.to_string().contains("preisach"));
}

#[test]
fn no_other_model_stands_in_where_none_of_the_named_methods_has_one() {
    let input = command();
    let line: Vec<f64> = input.iter().map(|u| 0.05 * u).collect();
    let time: Vec<f64> = (0..input.len()).map(|k| k as f64 * PERIOD).collect();
    let record = Record::new(Columns {
        name: "straight",
        time: &time,
        input_name: "u",
        input: &input,
        output_name: "y",
        output: &line,
    })
    .unwrap_or_else(|e| panic!("{e:?}"));
    let run = |names: &[&str]| {
        let methods = Methods::Named(names.iter().map(|name| (*name).to_owned()).collect());
        let dynamics = Dynamics::Static;
        let settings = Settings { plays: 12, dynamics, methods, ..Settings::default() };
        identify(std::slice::from_ref(&record), &target("x"), &settings, &mut Silent)
    };
    let error = run(&["bouc-wen", "mpi"]).map(|id| id.method).expect_err("a line has no loop");
    assert!(matches!(&error, Error::NoModel { failures } if failures.len() == 2));
    for part in ["method \"bouc-wen\"", "method \"mpi\"", "must be above zero"] {
        assert!(error.to_string().contains(part), "{part} in {error}");
    }
    assert_eq!(run(&["bouc-wen", "grpi"]).expect("one of them").method, "grpi");
    let method =
        run(&["bouc-wen", "prandtl-ishlinskii"]).expect("the static model was named").method;
    assert_eq!(method, "prandtl-ishlinskii");
}

/// Loops that a line cannot follow, behind them a lag.
fn lagging_loop() -> Record {
    let mut axis = AxisBlueprint::new("Y", "V", "um");
    let lag = ComponentBlueprint::new("sensor-lag").value("bandwidth", 60.0);
    axis.components = vec![bouc_wen(), lag];
    measured(axis, 0.002)
}

#[test]
fn past_outputs_and_derivatives_are_learned_and_run_as_written() {
    let record = lagging_loop();
    for (method, kinds, limit) in
        [("lssvm-narx", &["lssvm-narx", "arx"][..], 0.01), ("gp", &["gaussian-process"][..], 0.02)]
    {
        let methods = Methods::Named(vec![method.to_owned()]);
        let settings = Settings { plays: 20, methods, ..Settings::default() };
        let id = identify(std::slice::from_ref(&record), &target("found"), &settings, &mut Silent)
            .unwrap_or_else(|e| panic!("{method}: {e}"));
        let fit = &id.records[0];
        let (held, line) = (fit.held_out.nrmse, fit.baseline_held_out.nrmse);
        let candidate = id.candidates.last().unwrap_or_else(|| panic!("no candidate"));
        println!(
            "{method}: held out {:.3} %, a line {:.2} %; {} numbers in {:.1} s",
            100.0 * held,
            100.0 * line,
            candidate.parameters,
            candidate.seconds
        );
        assert!(held < limit && held < 0.5 * line, "{method}: {held} {line}");
        let plant = id.plant.blueprint();
        let found: Vec<&str> = plant.axes[0].components.iter().map(|c| c.kind.as_str()).collect();
        assert!(found.ends_with(kinds), "{found:?}");
        let again = simulate(&id.plant, &record).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again, candidate.simulations[0]);
        // Only a process says how far off it may be.
        assert_eq!(candidate.predicted.is_some(), method == "gp");
        if let Some(predicted) = &candidate.predicted {
            println!("{predicted:?}, rmse {}", fit.held_out.rmse);
            assert!((100..=201).contains(&predicted.rows), "{predicted:?}");
            assert!(predicted.noise > 0.0 && predicted.noise <= predicted.median, "{predicted:?}");
            assert!(predicted.median <= predicted.greatest, "{predicted:?}");
            let ratio = predicted.median / fit.held_out.rmse;
            assert!((0.2..5.0).contains(&ratio) && predicted.within > 0.5, "{predicted:?}");
            assert_eq!(predicted.output, None);
        }
    }
}

#[test]
fn a_process_has_its_deviation_as_an_output() {
    let record = lagging_loop();
    let run = |method: &str, features: FeatureChoice| {
        let methods = Methods::Named(vec![method.to_owned()]);
        let learning = Learning { deviation: true, features, ..Learning::default() };
        let settings = Settings { plays: 20, methods, learning, ..Settings::default() };
        identify(std::slice::from_ref(&record), &target("found"), &settings, &mut Silent)
    };
    let id = run("gp", FeatureChoice::Inputs(6)).unwrap_or_else(|e| panic!("{e}"));
    let predicted = id.candidates.last().and_then(|candidate| candidate.predicted.clone());
    let predicted = predicted.unwrap_or_else(|| panic!("nothing predicted"));
    let output = predicted.output.clone().unwrap_or_else(|| panic!("no output"));
    println!("{predicted:?}");
    assert!(output.centres > 5 && output.apart < 0.05, "{output:?}");
    // The plant runs it, row by row.
    let mut plant = id.plant.build();
    let [command, deviation] = ["command[1]", "deviation[1]"]
        .map(|name| plant.variables().find(name).unwrap_or_else(|| panic!("no {name}")));
    let mut all = Vec::new();
    for row in 0..record.len() {
        let held = record.input()[row.saturating_sub(1)];
        plant.set(command, held).unwrap_or_else(|e| panic!("{e}"));
        match row {
            0 => plant.initialise(record.time(0)).unwrap_or_else(|e| panic!("{e:?}")),
            _ => plant.advance(record.time(row)).map(|_| ()).unwrap_or_else(|e| panic!("{e:?}")),
        }
        all.push(plant.get(deviation).unwrap_or_else(|| panic!("no value")));
    }
    let mut held_out = all[all.len() / 2..].to_vec();
    held_out.sort_by(f64::total_cmp);
    let (median, greatest) = (held_out[held_out.len() / 2], held_out[held_out.len() - 1]);
    println!("median {median}, greatest {greatest}");
    assert!((median / predicted.median - 1.0).abs() < 0.05, "{median} {predicted:?}");
    assert!(held_out[0] >= predicted.noise && greatest > 0.9 * predicted.greatest);
    let error = run("lssvm-narx", FeatureChoice::Usual)
        .map(|id| id.method)
        .expect_err("refused")
        .to_string();
    assert!(error.contains("--deviation belongs to gp"), "{error}");
}

#[test]
fn inputs_selection_and_pruning_are_as_asked_for() {
    let record = lagging_loop();
    let run = |method: &str, learning: Learning| {
        let methods = Methods::Named(vec![method.to_owned()]);
        let settings = Settings { plays: 20, methods, learning, ..Settings::default() };
        identify(std::slice::from_ref(&record), &target("found"), &settings, &mut Silent)
    };
    let cross = Selection::CrossValidation(5);
    let pruned =
        Learning { selection: Some((cross, Seek::Grid)), prune: Some(80), ..Learning::default() };
    let rate = Learning { features: FeatureChoice::Rate, ..Learning::default() };
    let both = Learning { features: FeatureChoice::Both, ..Learning::default() };
    let twelve = Learning { features: FeatureChoice::Inputs(12), ..Learning::default() };
    for (method, learning) in [("lssvm-narx", pruned), ("lssvm-stops", rate), ("gp", twelve)] {
        let id = run(method, learning).unwrap_or_else(|e| panic!("{method}: {e}"));
        let fit = &id.records[0];
        let (held, line) = (fit.held_out.nrmse, fit.baseline_held_out.nrmse);
        println!("{method}: held out {:.3} %, a line {:.2} %", 100.0 * held, 100.0 * line);
        assert!(held < 0.02 && held < 0.5 * line, "{method}: {held} {line}");
        let plant = id.plant.blueprint();
        let kind = if method == "gp" { "gaussian-process" } else { method };
        let component = plant.axes[0].components.iter().find(|c| c.kind == kind);
        let component = component.unwrap_or_else(|| panic!("{method}"));
        let number = |name: &str| match component.get(name) {
            Some(data::Value::Number(x)) => *x,
            other => panic!("{method}: {name} is {other:?}"),
        };
        let rows = plant.tables.values().next().map_or(0, model::Table::rows);
        match method {
            // Bias and widths in one row.
            "lssvm-narx" => assert!((80..=84).contains(&(rows - 1)), "{rows}"),
            "lssvm-stops" => assert!(number("rate_scale") < 1e6),
            _ => assert_eq!(number("inputs"), 12.0),
        }
    }
    for (method, learning, message) in [
        ("gp", pruned, "is not pruned"),
        ("lssvm-narx", rate, "the rate belongs to lssvm-stops"),
        ("lssvm-stops", twelve, "belong to gp"),
        ("lssvm-term", rate, "the rate belongs to lssvm-stops"),
        ("gp", both, "belong to lssvm-term"),
    ] {
        let error = run(method, learning).map(|id| id.method).expect_err("refused").to_string();
        assert!(error.contains(message), "{error}");
    }
}

/// A slow loop without a lag: the term beside the line is all that there is.
fn slow_loop() -> Record {
    let mut axis = AxisBlueprint::new("Y", "V", "um");
    axis.components = vec![bouc_wen()];
    measured(axis, 0.002)
}

#[test]
fn a_hysteresis_term_is_learned_over_commands_positions_or_both() {
    let record = slow_loop();
    for (features, inputs, limit) in [
        (FeatureChoice::Command, 1.0, 0.02),
        (FeatureChoice::Position, 2.0, 0.02),
        (FeatureChoice::Both, 3.0, 0.02),
    ] {
        let methods = Methods::Named(vec!["lssvm-term".to_owned()]);
        let learning = Learning { features, ..Learning::default() };
        let settings = Settings { plays: 20, methods, learning, ..Settings::default() };
        let id = identify(std::slice::from_ref(&record), &target("found"), &settings, &mut Silent)
            .unwrap_or_else(|e| panic!("{features:?}: {e}"));
        let fit = &id.records[0];
        let (held, line) = (fit.held_out.nrmse, fit.baseline_held_out.nrmse);
        println!("{features:?}: held out {:.3} %, a line {:.2} %", 100.0 * held, 100.0 * line);
        assert!(held < limit && held < 0.5 * line, "{features:?}: {held} {line}");
        let plant = id.plant.blueprint();
        let component = plant.axes[0].components.last().unwrap_or_else(|| panic!("none"));
        assert_eq!(component.kind, "lssvm-term");
        assert_eq!(component.get("inputs"), Some(&data::Value::Number(inputs)));
        let again = simulate(&id.plant, &record).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again, id.candidates.last().unwrap_or_else(|| panic!("none")).simulations[0]);
    }
}

#[test]
fn what_no_operator_describes_is_learned_with_its_lag() {
    let mut axis = AxisBlueprint::new("Y", "V", "um");
    axis.components = vec![
        ComponentBlueprint::new("delay")
            .value("longest", 10.0 * PERIOD)
            .value("delay", 3.0 * PERIOD),
        bouc_wen(),
        ComponentBlueprint::new("sensor-polynomial")
            .value("quadratic", 0.3)
            .value("cubic", 0.1)
            .value("centre", 2.5)
            .value("half_range", 2.5),
        ComponentBlueprint::new("sensor-lag").value("bandwidth", 20.0),
    ];
    let record = measured(axis, 0.002);
    let run = |method: &str, dynamics: Dynamics| {
        let methods = Methods::Named(vec![method.to_owned()]);
        let settings = Settings { plays: 20, dynamics, methods, ..Settings::default() };
        identify(std::slice::from_ref(&record), &target("found"), &settings, &mut Silent)
            .unwrap_or_else(|e| panic!("{method}: {e}"))
    };
    let learned = run("lssvm-stops", Dynamics::Automatic);
    let still = run("lssvm-stops", Dynamics::Static);
    let operator = run("bouc-wen", Dynamics::Automatic);
    let rmse = |id: &Identification| id.records[0].held_out.rmse;
    println!(
        "learned {}, without a linear part {}, Bouc-Wen {}",
        rmse(&learned),
        rmse(&still),
        rmse(&operator)
    );
    assert!(learned.records[0].held_out.nrmse < 0.01, "{:?}", learned.records[0].held_out);
    assert!(rmse(&learned) < 0.5 * rmse(&still) && rmse(&learned) < 0.5 * rmse(&operator));
    let plant = learned.plant.blueprint();
    let kinds: Vec<&str> = plant.axes[0].components.iter().map(|c| c.kind.as_str()).collect();
    assert!(kinds.ends_with(&["lssvm-stops", "arx"]), "{kinds:?}");
    let again = simulate(&learned.plant, &record).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(again, learned.candidates.last().map_or(&[][..], |c| &c.simulations[0]));
}

/// Plays with creep between two curves, and a network over them that one method knows and the others do not.
#[test]
fn a_network_over_plays_learns_what_two_curves_leave() {
    let r: Vec<f64> = (0..12).map(|i| 4.0 * f64::from(i)).collect();
    let w: Vec<f64> = (0..12).map(|i| if i == 0 { 0.1 } else { 0.012 }).collect();
    let weight = [1.5, 0.0, 1.0, -2.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    let weight: Vec<f64> = weight.into_iter().chain(weight.map(|a| 0.5 - a)).collect();
    let truth = ComponentBlueprint::new("learned-plays")
        .value("r", r)
        .value("w", w)
        .value("share", [0.01])
        .value("time_constant", [0.5])
        .value("height", [0.03, -0.02])
        .value("bias", [0.2, -0.3])
        .value("weight", weight)
        .value("centre", 50.0)
        .value("half_range", 50.0)
        .value("position_centre", 7.0)
        .value("position_half_range", 7.0);
    let record = log(truth, 0.002);
    let run = |method: &str| found(&record, method, Search::LevenbergMarquardt);
    let (learned, curved) = (run("learned-plays"), run("curved-prandtl-ishlinskii"));
    let rmse = |id: &Identification| id.records[0].held_out.rmse;
    println!("network {}, two curves alone {}, noise 0.002", rmse(&learned), rmse(&curved));
    assert!(rmse(&learned) < 0.35 * rmse(&curved));
    let reason = learned.candidates.last().map_or("", |candidate| &candidate.reason);
    assert!(reason.contains("plays fitted anew with it: -"), "{reason}");
    let count = learned.candidates.last().map(|candidate| candidate.parameters);
    assert!(count.is_some_and(|count| count <= 500), "{count:?}");
    // Every run gives the same numbers, and the plant is the one that was judged.
    assert_eq!(run("learned-plays").plant.blueprint(), learned.plant.blueprint());
    let again = simulate(&learned.plant, &record).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(again, learned.candidates.last().map_or(&[][..], |c| &c.simulations[0]));
}
