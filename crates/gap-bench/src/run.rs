//! Runs the cases: draws, asks, keeps the answers. A case that has been answered is not run again.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use gap_machines::Effect;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::answer::Answer;
use crate::case::{Case, Plan};
use crate::error::{Error, at};
use crate::families::is_ambiguous;
use crate::label::{Label, Miss};
use crate::prepare::{Folders, Prepared, Question, play, prepare, read_json, write_json};
use crate::tool::Tool;

/// How the cases are run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Where everything lies.
    pub folders: Folders,
    /// Cases at the same time; 0: one per processor.
    pub threads: usize,
    /// Whether logs are kept once their case is answered.
    pub keeps_logs: bool,
    /// Whether a single effect is also repaired by a diagnosis that is told its name.
    pub has_oracle: bool,
}

/// Truth and answer of one case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The truth; `None` where no machine could be drawn.
    pub label: Option<Label>,
    /// The answer; `None` where the tool failed.
    pub answer: Option<Answer>,
    /// What went wrong, if anything did.
    pub failure: Option<String>,
    /// How long the diagnosis took, in s.
    pub seconds: f64,
    /// What the repaired model does on records that the diagnosis never saw.
    pub realised: Option<Realised>,
    /// Answers after each further experiment, where several names were left.
    #[serde(default)]
    pub after_experiments: Vec<Answer>,
}

/// Root mean squares over the records that nobody saw, without noise, in µm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Realised {
    /// Of the re-tuned model.
    pub before: f64,
    /// Of the repaired model.
    pub after: f64,
    /// Of the model that was repaired by a diagnosis that was told the effect.
    pub oracle: Option<f64>,
}

impl Realised {
    /// Part of the gap's power that went.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        1.0 - (self.after / self.before).powi(2)
    }
}

/// What a folder of a benchmark says about itself.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Head {
    seed: u64,
    is_short: bool,
    version: String,
}

impl Head {
    fn text(&self) -> String {
        let form = if self.is_short { "short" } else { "full" };
        format!("seed {}, {form} form, version {}", self.seed, self.version)
    }
}

/// Runs cases and gives their outcomes in their order. `go_on` is told how many of them are done; where it answers
/// no, cases that are under way are finished, and of the others only those that an earlier call has answered are given.
///
/// # Errors
/// The folder holds another benchmark, or a file cannot be written. A tool that fails is an outcome.
pub fn run(
    plan: Plan,
    cases: &[Case],
    settings: &Settings,
    tool: &dyn Tool,
    go_on: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Vec<Outcome>, Error> {
    claim(plan, &settings.folders.root)?;
    let pool =
        numerics::threads::pool(settings.threads).map_err(|_| Error::Threads(settings.threads))?;
    let done = AtomicUsize::new(0);
    pool.install(|| {
        let outcomes = cases.par_iter().filter_map(|case| {
            let known = answered(case, settings).transpose();
            let is_next = known.is_some() || go_on(done.load(Ordering::Relaxed));
            let outcome = known.or_else(|| is_next.then(|| one(case, settings, tool)))?;
            go_on(done.fetch_add(1, Ordering::Relaxed) + 1);
            Some(outcome)
        });
        outcomes.collect()
    })
}

/// Begins a folder, or makes sure that it holds the same benchmark.
fn claim(plan: Plan, root: &Path) -> Result<(), Error> {
    at(root, std::fs::create_dir_all(root))?;
    let asked = Head {
        seed: plan.seed,
        is_short: plan.is_short,
        version: env!("CARGO_PKG_VERSION").into(),
    };
    let path = root.join("plan.json");
    match read_json::<Head>(&path)? {
        None => write_json(&path, &asked),
        Some(found) if found == asked => Ok(()),
        Some(found) => Err(Error::OtherPlan {
            path: root.to_path_buf(),
            found: found.text(),
            asked: asked.text(),
        }),
    }
}

fn file(case: &Case, settings: &Settings) -> PathBuf {
    settings.folders.truth(&case.id).join("outcome.json")
}

/// What an earlier call has made of a case.
fn answered(case: &Case, settings: &Settings) -> Result<Option<Outcome>, Error> {
    read_json(&file(case, settings))
}

fn one(case: &Case, settings: &Settings, tool: &dyn Tool) -> Result<Outcome, Error> {
    let folders = &settings.folders;
    let outcome = match prepare(case, folders, tool)? {
        Err(message) => Outcome {
            label: None,
            answer: None,
            failure: Some(message),
            seconds: 0.0,
            realised: None,
            after_experiments: Vec::new(),
        },
        Ok(prepared) => ask(case, prepared, settings, tool),
    };
    let truth = folders.truth(&case.id);
    at(&truth, std::fs::create_dir_all(&truth))?;
    write_json(&file(case, settings), &outcome)?;
    if !settings.keeps_logs {
        remove_logs(&folders.case(&case.id));
        remove_logs(&truth);
    }
    Ok(outcome)
}

fn ask(case: &Case, prepared: Prepared, settings: &Settings, tool: &dyn Tool) -> Outcome {
    let Prepared { label, question, scene } = prepared;
    let folder = settings.folders.case(&case.id);
    let unseen = settings.folders.truth(&case.id).join("unseen.csv");
    let begin = Instant::now();
    let mut arguments = question.arguments.clone();
    if is_ambiguous(case.family) {
        arguments.extend([NEXT.0, NEXT.1].map(str::to_owned));
    }
    let reply = diagnose(tool, &folder, &arguments, "gap.json", case.family == "long");
    let seconds = begin.elapsed().as_secs_f64();
    let Reply { answer, mut failure } = reply;
    let mut realised = None;
    let is_repaired = failure.is_none() && answer.as_ref().is_some_and(|a| a.verdict == "effects");
    if is_repaired && !label.missed.is_empty() {
        match simulate(tool, &folder.join(&question.repaired), &unseen) {
            Err(message) => failure = Some(format!("repaired model: {message}")),
            Ok(after) => {
                let before = Miss::pooled(&label.missed);
                let oracle = settings
                    .has_oracle
                    .then(|| error_with_truth(&label, &question, &folder, &unseen, tool))
                    .flatten();
                realised = Some(Realised { before, after, oracle });
            }
        }
    }
    let mut after_experiments = Vec::new();
    if is_ambiguous(case.family) && failure.is_none() {
        let mut last = answer.clone();
        for number in 1..=EXPERIMENTS {
            if !last.as_ref().is_some_and(Answer::has_rivals) || !folder.join(NEXT.1).exists() {
                break;
            }
            let log = format!("experiment-{number}.csv");
            if let Err(message) = play(&scene, &folder.join(NEXT.1), number, &folder.join(&log)) {
                failure = Some(message);
                break;
            }
            arguments.extend(["--log".to_owned(), log]);
            // A signal is asked for anew.
            let _ = std::fs::remove_file(folder.join(NEXT.1));
            let file = format!("gap-{number}.json");
            let reply = diagnose(tool, &folder, &arguments, &file, false);
            failure = reply.failure;
            last = reply.answer;
            after_experiments.extend(last.clone());
        }
    }
    Outcome { label: Some(label), answer, failure, seconds, realised, after_experiments }
}

/// Experiments that a machine with several names left is given.
const EXPERIMENTS: usize = 2;
/// The option that asks for a signal, and its file.
const NEXT: (&str, &str) = ("--next-experiment", "next.csv");

/// What a diagnosis left: an answer, a complaint, or both where only the repair failed.
struct Reply {
    answer: Option<Answer>,
    failure: Option<String>,
}

fn diagnose(
    tool: &dyn Tool,
    folder: &Path,
    question: &[String],
    file: &str,
    is_alone: bool,
) -> Reply {
    let threads = if is_alone { "2" } else { "1" };
    let mut arguments = question.to_vec();
    let more = ["--json", file, "--seed", "1", "--threads", threads];
    arguments.extend(more.map(str::to_owned));
    let path = folder.join(file);
    // An answer of an earlier call that was stopped is not this call's.
    let _ = std::fs::remove_file(&path);
    let failure = tool.diagnose(folder, &arguments).err();
    let read = std::fs::read_to_string(&path)
        .map_err(|error| format!("{file} was not written: {error}"))
        .and_then(|text| Answer::parse(&text).map_err(|error| format!("{file}: {error}")));
    match read {
        Ok(answer) => Reply { answer: Some(answer), failure },
        Err(message) => Reply { answer: None, failure: Some(failure.unwrap_or(message)) },
    }
}

/// The error of a model that was repaired with all candidates but the true one taken out.
fn error_with_truth(
    label: &Label,
    question: &Question,
    folder: &Path,
    unseen: &Path,
    tool: &dyn Tool,
) -> Option<f64> {
    let [truth] = &label.effects[..] else { return None };
    let mut arguments = question.arguments.clone();
    let repaired = format!("told-{}", question.repaired);
    for value in arguments.iter_mut().filter(|value| **value == question.repaired) {
        *value = repaired.clone();
    }
    let listed = Effect::ALL.iter().filter(|effect| !effect.is_stray());
    for other in listed.filter(|effect| effect.name() != truth.effect) {
        arguments.extend(["--without".to_owned(), other.name().to_owned()]);
    }
    let Reply { answer: Some(answer), failure: None } =
        diagnose(tool, folder, &arguments, "told.json", false)
    else {
        return None;
    };
    if answer.verdict != "effects" {
        return None;
    }
    simulate(tool, &folder.join(repaired), unseen).ok()
}

fn simulate(tool: &dyn Tool, model: &Path, log: &Path) -> Result<f64, String> {
    let rms = Miss::pooled(&tool.simulate(model, log)?);
    if !rms.is_finite() {
        return Err("its run has no fit of y1".to_owned());
    }
    Ok(rms)
}

/// Logs are large and can be made again; what remains says all.
fn remove_logs(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.extension().is_some_and(|e| e == "csv" || e == "fmu") {
            // What cannot be removed costs space and nothing else.
            let _ = std::fs::remove_file(path);
        }
    }
}
