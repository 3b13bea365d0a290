//! From a case to files: what the diagnosis gets, and what it does not.

use std::path::{Path, PathBuf};

use data::{AtomicFile, Log, ReadOptions, UnitPlace};
use gap_machines::{Kind, Order, Record, Scene, TOLERANCES, rounded};
use serde::{Deserialize, Serialize};

use crate::case::{Case, NoiseHint};
use crate::error::{Error, at};
use crate::label::Label;
use crate::tool::{Tool, names_of_fmu};

/// Machines that are drawn until one can have the effects at their sizes.
const DRAWS: u64 = 60;

/// Where the files of a benchmark lie.
#[derive(Clone, Debug)]
pub struct Folders {
    /// The folder of the benchmark.
    pub root: PathBuf,
}

impl Folders {
    /// The folder of a case: all that the diagnosis sees.
    #[must_use]
    pub fn case(&self, id: &str) -> PathBuf {
        self.root.join("cases").join(id)
    }

    /// What only the scorer reads.
    #[must_use]
    pub fn truth(&self, id: &str) -> PathBuf {
        self.root.join("truth").join(id)
    }
}

/// The question, as the arguments of `diagnose`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Question {
    /// Arguments; files are named as they lie in the case's folder.
    pub arguments: Vec<String>,
    /// The repaired model that is asked for.
    pub repaired: String,
}

/// A case whose files are written.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The truth.
    pub label: Label,
    /// What is asked.
    pub question: Question,
    /// The machine, for further measurements.
    pub scene: Scene,
}

/// Draws the machine of a case and writes its files.
///
/// # Errors
/// A file cannot be written. Where no machine can have the effects, there is a text in place of the
/// label.
pub fn prepare(
    case: &Case,
    folders: &Folders,
    tool: &dyn Tool,
) -> Result<Result<Prepared, String>, Error> {
    let scene = match draw(&case.order) {
        Ok(scene) => scene,
        Err(message) => return Ok(Err(message)),
    };
    let (folder, truth) = (folders.case(&case.id), folders.truth(&case.id));
    for path in [&folder, &truth] {
        at(path, std::fs::create_dir_all(path))?;
    }
    write(&folder.join("model.toml"), scene.blueprint.as_bytes())?;
    if case.is_identified {
        let path = truth.join("before.csv");
        log(&[&scene.without_effects()], scene.period, &path)?;
        if let Err(message) = tool.identify(&path, &folder.join("model.toml")) {
            return Ok(Err(format!("no model is identified: {message}")));
        }
    }
    if case.is_black_box {
        if let Err(message) = tool.pack(&folder.join("model.toml"), &folder.join("model.fmu")) {
            return Ok(Err(format!("the model cannot be packed: {message}")));
        }
        let blueprint = folder.join("model.toml");
        at(&blueprint, std::fs::remove_file(&blueprint))?;
    }
    for record in scene.fit.iter().chain(&scene.held_out) {
        log(&[record], scene.period, &folder.join(file_of(&scene, record)))?;
    }
    if case.noise == NoiseHint::Rest {
        log(&[&scene.idle], scene.period, &folder.join("rest.csv"))?;
    }
    let label = Label::new(case, &scene);
    if !label.missed.is_empty() {
        log(&scene.unseen.iter().collect::<Vec<_>>(), scene.period, &truth.join("unseen.csv"))?;
    }
    let question = question(case, &scene);
    write_json(&folder.join("question.json"), &question)?;
    write_json(&truth.join("label.json"), &label)?;
    Ok(Ok(Prepared { label, question, scene }))
}

fn draw(order: &Order) -> Result<Scene, String> {
    let mut last = String::new();
    for number in 0..DRAWS {
        let seed = order.seed.wrapping_add(number);
        match Scene::draw(&Order { seed, ..order.clone() }) {
            Ok(scene) => return Ok(scene),
            Err(error) => last = error.to_string(),
        }
    }
    Err(last)
}

/// Kinds that are fitted and held out have a file each.
fn file_of(scene: &Scene, record: &Record) -> String {
    let is_held_out = scene.held_out.iter().any(|other| std::ptr::eq(other, record));
    let name = record.kind.name();
    if is_held_out { format!("{name}-held-out.csv") } else { format!("{name}.csv") }
}

fn question(case: &Case, scene: &Scene) -> Question {
    let extension = if case.is_black_box { "fmu" } else { "toml" };
    let repaired = format!("repaired.{extension}");
    let mut arguments = vec!["--model".to_owned(), format!("model.{extension}")];
    let mut add = |option: &str, value: String| arguments.extend([option.to_owned(), value]);
    for record in &scene.fit {
        add("--log", file_of(scene, record));
    }
    for record in &scene.held_out {
        add("--holdout", file_of(scene, record));
    }
    match case.noise {
        NoiseHint::Given(factor) => {
            for (index, sigma) in scene.sigma.iter().enumerate() {
                add("--noise", format!("y{}={:.4e}", index + 1, sigma * factor));
            }
        }
        NoiseHint::Rest => add("--rest", "rest.csv".to_owned()),
        NoiseHint::Nothing => {}
    }
    for effect in &case.without {
        add("--without", effect.clone());
    }
    add("--repair", repaired.clone());
    if case.is_black_box {
        arguments.extend(names_of_fmu());
        arguments.extend(tolerances_of_fmu());
    }
    Question { arguments, repaired }
}

/// An FMU does not say how far its parameters may be off; its user does.
fn tolerances_of_fmu() -> Vec<String> {
    let t = TOLERANCES;
    let all = [
        ("*.w*", t.weight),
        ("*.frequency", t.frequency),
        ("*.damping", t.damping),
        ("*.bandwidth", t.bandwidth),
    ];
    all.iter().flat_map(|(name, sd)| ["--tune".to_owned(), format!("{name}={sd}")]).collect()
}

/// Plays a signal that the diagnosis asks for (columns `time`, `u1` and perhaps `u2`) on the machine and writes the
/// log of it. A neighbour that is not named rests at 50 V, the middle of its range.
///
/// # Errors
/// The signal or the log, as a text.
pub(crate) fn play(scene: &Scene, signal: &Path, number: usize, path: &Path) -> Result<(), String> {
    let asked = Log::read(signal, &ReadOptions::default()).map_err(|error| error.to_string())?;
    let column = |name: &str| -> Option<Vec<f64>> {
        let column = asked.column(name)?;
        Some(column.values.iter().map(|u| rounded(*u)).collect())
    };
    let command = column("u1").ok_or("the signal of the next experiment has no column u1")?;
    let neighbour = column("u2").unwrap_or_else(|| vec![50.0; command.len()]);
    let commands = [command, neighbour];
    let readings = scene.play(&commands, 400 + number);
    let record = Record { kind: Kind::Operation, commands, readings, missed: None };
    log(&[&record], scene.period, path).map_err(|error| error.to_string())
}

/// Writes records as one log; several are numbered.
fn log(records: &[&Record], period: f64, path: &Path) -> Result<(), Error> {
    let lengths: Vec<(i64, usize)> =
        records.iter().zip(1..).map(|(r, id)| (id, r.commands[0].len())).collect();
    let time: Vec<f64> =
        lengths.iter().flat_map(|(_, n)| (0..*n).map(|k| k as f64 * period)).collect();
    let origin = path.display().to_string();
    let mut log = match records {
        [_] => Log::new(&origin, time)?,
        _ => Log::with_records(&origin, time, &lengths)?,
    };
    for axis in 0..2 {
        let values = records.iter().flat_map(|r| r.commands[axis].iter().copied()).collect();
        log.add_column(&format!("u{}", axis + 1), Some("V"), values)?;
    }
    let axes = records.first().map_or(0, |record| record.readings.len());
    for axis in 0..axes {
        let values = records.iter().flat_map(|r| r.readings[axis].iter().copied()).collect();
        log.add_column(&format!("y{}", axis + 1), Some("um"), values)?;
    }
    Ok(log.write(path, UnitPlace::Header)?)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    at(path, AtomicFile::write_all_of(path, bytes))
}

/// Writes a value as JSON.
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let text = serde_json::to_vec_pretty(value)
        .map_err(|error| Error::Content { path: path.to_path_buf(), message: error.to_string() })?;
    write(path, &text)
}

/// Reads a value from JSON; `None` where there is no such file.
pub(crate) fn read_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<Option<T>, Error> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(Error::File { path: path.to_path_buf(), source }),
    };
    let value = serde_json::from_str(&text)
        .map_err(|error| Error::Content { path: path.to_path_buf(), message: error.to_string() })?;
    Ok(Some(value))
}
