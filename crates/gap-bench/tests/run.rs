//! A benchmark from end to end with a tool made by hand.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use data::{Log, ReadOptions};
use gap_bench::{Error, Folders, Miss, Outcome, Plan, Scores, Settings, Tool, run, select};

const PLAN: Plan = Plan { seed: 3, is_short: true };

/// Names creep in whatever it sees, and writes down what it was given.
#[derive(Default)]
struct Creep {
    calls: AtomicUsize,
    seen: Mutex<Vec<(Vec<String>, Vec<String>)>>,
}

impl Tool for Creep {
    fn pack(&self, blueprint: &Path, fmu: &Path) -> Result<(), String> {
        std::fs::copy(blueprint, fmu).map(|_| ()).map_err(|error| error.to_string())
    }

    fn identify(&self, log: &Path, blueprint: &Path) -> Result<(), String> {
        Log::read(log, &ReadOptions::default()).map_err(|error| error.to_string())?;
        std::fs::write(blueprint, "identified").map_err(|error| error.to_string())
    }

    fn diagnose(&self, folder: &Path, arguments: &[String]) -> Result<(), String> {
        self.calls.fetch_add(1, Ordering::Relaxed);
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        for log in files.iter().filter(|name| name.ends_with(".csv")) {
            Log::read(&folder.join(log), &ReadOptions::default()).map_err(|e| e.to_string())?;
        }
        self.seen.lock().unwrap().push((arguments.to_vec(), files));
        let json = r#"{"verdict":"effects","effects":[{"effect":"creep","output":"y1",
            "probability":0.5,"set":["creep"]}],"shrink":{"fraction":0.5,"ci95":[0.4,1]},
            "leftover":{"present":false}}"#;
        let at = arguments.iter().position(|a| a == "--json").ok_or("no --json")?;
        std::fs::write(folder.join(&arguments[at + 1]), json).map_err(|e| e.to_string())
    }

    fn simulate(&self, _model: &Path, log: &Path) -> Result<Vec<Miss>, String> {
        let log = Log::read(log, &ReadOptions::default()).map_err(|error| error.to_string())?;
        Ok(log.records().iter().map(|r| Miss { rms: 0.01, rows: r.rows.len() }).collect())
    }
}

fn settings(folder: &Path) -> Settings {
    Settings {
        folders: Folders { root: folder.to_path_buf() },
        threads: 2,
        keeps_logs: false,
        has_oracle: false,
    }
}

fn outcomes(folder: &Path, tool: &Creep, text: &str) -> Result<Vec<Outcome>, Error> {
    let cases = select(PLAN.cases(), Some(text))?;
    run(PLAN, &cases, &settings(folder), tool, &|_| true)
}

#[test]
fn a_benchmark_goes_on_where_it_was_stopped_and_scores_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let tool = Creep::default();
    let first = outcomes(folder.path(), &tool, "4").unwrap();
    assert_eq!((first.len(), tool.calls.load(Ordering::Relaxed)), (4, 4));
    let more = outcomes(folder.path(), &tool, "6").unwrap();
    assert_eq!(tool.calls.load(Ordering::Relaxed), 6);
    assert_eq!(more[..4], first[..]);
    let scores = Scores::of(&more);
    assert_eq!((scores.answered, scores.failed.len()), (6, 0));
    // Another seed is another benchmark.
    let cases = Plan { seed: 4, ..PLAN }.cases();
    let other =
        run(Plan { seed: 4, ..PLAN }, &cases[..1], &settings(folder.path()), &tool, &|_| true);
    let message = other.unwrap_err().to_string();
    assert!(message.contains("seed 3") && message.contains("seed 4"), "{message}");
}

#[test]
fn a_benchmark_that_is_stopped_gives_what_is_answered_and_goes_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let tool = Creep::default();
    let cases = select(PLAN.cases(), Some("6")).unwrap();
    let settings = Settings { threads: 1, ..settings(folder.path()) };
    let some = run(PLAN, &cases, &settings, &tool, &|done| done < 3).unwrap();
    assert_eq!((some.len(), tool.calls.load(Ordering::Relaxed)), (3, 3));
    // Nothing new, and what is there.
    let again = run(PLAN, &cases, &settings, &tool, &|_| false).unwrap();
    assert_eq!((again == some, tool.calls.load(Ordering::Relaxed)), (true, 3));
    let all = run(PLAN, &cases, &settings, &tool, &|_| true).unwrap();
    assert_eq!((all.len(), tool.calls.load(Ordering::Relaxed)), (6, 6));
}

#[test]
fn the_tool_sees_a_model_logs_and_no_label() {
    let folder = tempfile::tempdir().unwrap();
    let tool = Creep::default();
    let all =
        outcomes(folder.path(), &tool, "removed,closed-loop,operation,two-axes,black-box,none:2");
    let all = all.unwrap();
    let seen = tool.seen.lock().unwrap();
    assert_eq!(seen.len(), all.len());
    let known = ["model.toml", "model.fmu", "question.json", "rest.csv"];
    for (arguments, files) in seen.iter() {
        for file in files {
            let is_log = file.ends_with(".csv");
            assert!(is_log || known.contains(&file.as_str()), "{file}");
        }
        let files_named: Vec<_> =
            arguments.iter().filter(|a| a.ends_with(".csv") || a.contains("model.")).collect();
        assert!(files_named.iter().all(|name| files.contains(name)), "{arguments:?} {files:?}");
        // No name of an effect but the one that is taken out on purpose.
        let effects = gap_machines::Effect::ALL.iter().map(|effect| effect.name());
        for effect in effects {
            // A tolerance names a parameter, not an effect.
            let mut pairs = arguments.windows(2).filter(|pair| pair[0] != "--tune");
            let is_known = pairs.all(|pair| !pair[1].contains(effect) || pair[0] == "--without");
            assert!(is_known, "{arguments:?}");
        }
    }
    // Logs go once they have served; the question stays.
    let kept = std::fs::read_dir(folder.path().join("cases")).unwrap().map(|e| e.unwrap().path());
    for case in kept {
        assert!(case.join("question.json").exists() && case.join("gap.json").exists());
        assert!(!case.join("multisine.csv").exists());
    }
}

#[test]
fn realised_shrink_is_that_of_the_repaired_model_on_unseen_records() {
    let folder = tempfile::tempdir().unwrap();
    let all = outcomes(folder.path(), &Creep::default(), "single").unwrap();
    let predictable: Vec<_> = all.iter().filter(|outcome| outcome.realised.is_some()).collect();
    assert!(!predictable.is_empty() && predictable.len() < all.len());
    for outcome in predictable {
        let (label, realised) = (outcome.label.as_ref().unwrap(), outcome.realised.unwrap());
        assert_eq!(realised.before, Miss::pooled(&label.missed));
        assert!((realised.after - 0.01).abs() < 1e-12);
        let effect = gap_machines::Effect::find(&label.effects[0].effect).unwrap();
        assert!(effect.is_predictable(), "{}", effect.name());
    }
}
