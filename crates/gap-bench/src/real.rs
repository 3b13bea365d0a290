//! Machines that were measured: a folder of them, each with what its makers document.
//!
//! ```toml
//! # FOLDER/NAME/machine.toml
//! model = "model.toml"            # what a user has: a blueprint or an FMU; may be left out where the next two are there
//! input = "u"                     # without a model: the column of the command
//! output = "y"                    # without a model: the column of the reading
//! logs = ["run_1.csv"]            # what the diagnosis gets
//! holdout = ["run_2.csv"]         # what it is judged on; may be left out
//! drop = 0.5                      # seconds of run-in; may be left out
//! options = ["--noise", "0.003"]  # further options of diagnose; may be left out
//! right = ["hysteresis"]          # documented effects, any of them as the first name; none: no name is right
//! also = ["creep"]                # names that may stand beside it; may be left out
//! ```

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use report::{Report, Section, Table, Value, Verdict};
use serde::{Deserialize, Serialize};

use crate::answer::Answer;
use crate::error::{Error, at};
use crate::tool::Tool;

/// File that makes a folder a machine's.
const FILE: &str = "machine.toml";
/// Probability from which an invented name is a bad one.
const SURE: f64 = 0.8;

/// What is known of a machine.
#[derive(Clone, Debug, PartialEq, Deserialize)]
struct Machine {
    model: Option<PathBuf>,
    input: Option<String>,
    output: Option<String>,
    logs: Vec<PathBuf>,
    #[serde(default)]
    holdout: Vec<PathBuf>,
    #[serde(default)]
    drop: f64,
    #[serde(default)]
    options: Vec<String>,
    right: Vec<String>,
    #[serde(default)]
    also: Vec<String>,
}

/// What an answer is against what is documented.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The first name is documented and none is invented beside it; or no name where none is right.
    Right,
    /// A documented name is there, but not first, or an invented one stands beside it.
    Partly,
    /// The set of the first name holds a documented one.
    InSet,
    /// No name where one was to be had.
    Unknown,
    /// An invented first name, or one at all where none is right.
    Wrong,
    /// No answer.
    Broken,
}

impl Judgement {
    /// In words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Partly => "partly",
            Self::InSet => "in set",
            Self::Unknown => "unknown",
            Self::Wrong => "wrong",
            Self::Broken => "broken",
        }
    }
}

/// One machine and the answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Name of its folder.
    pub machine: String,
    /// What the answer is.
    pub judgement: Judgement,
    /// Largest probability of a name that is not documented; 0: none.
    pub invented: f64,
    /// Names with their probabilities, or the verdict, or why there is no answer.
    #[serde(rename = "said")]
    pub stated: String,
    /// Documented names.
    pub right: Vec<String>,
    /// Root mean square that the model with its effects leaves of held-out rows over that of the re-tuned one.
    pub left: Option<f64>,
    /// Seconds that the answer took.
    pub seconds: f64,
}

/// All machines of a folder.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Real {
    /// One by one, by name.
    pub machines: Vec<Measured>,
}

/// Diagnoses the machines in a folder, each as its user would; `only` are names, none: all. `go_on` is told how many are
/// done and says whether to go on; `files` gets one folder per machine, with the answer and the repaired model.
///
/// # Errors
/// No machine there, or one whose file makes no sense.
pub fn real(
    folder: &Path,
    only: &[String],
    files: &Path,
    tool: &dyn Tool,
    go_on: &dyn Fn(usize) -> bool,
) -> Result<Real, Error> {
    let machines = read(folder, only)?;
    let mut all = Vec::new();
    for (name, home, machine) in &machines {
        if !go_on(all.len()) {
            break;
        }
        let own = files.join(name);
        at(&own, std::fs::create_dir_all(&own))?;
        all.push(machine.ask(name, home, &own, tool));
    }
    Ok(Real { machines: all })
}

fn refuse(path: &Path, message: String) -> Error {
    Error::Machine { path: path.to_path_buf(), message }
}

fn read(folder: &Path, only: &[String]) -> Result<Vec<(String, PathBuf, Machine)>, Error> {
    let mut all = Vec::new();
    for entry in at(folder, std::fs::read_dir(folder))? {
        let home = at(folder, entry)?.path();
        let file = home.join(FILE);
        let name = home.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        if !file.is_file() || !(only.is_empty() || only.contains(&name)) {
            continue;
        }
        let text = at(&file, std::fs::read_to_string(&file))?;
        let machine: Machine = toml::from_str(&text).map_err(|e| refuse(&file, e.to_string()))?;
        if machine.logs.is_empty() {
            return Err(refuse(&file, "logs is empty; name at least one measured log".to_owned()));
        }
        if machine.model.is_none() && (machine.input.is_none() || machine.output.is_none()) {
            let message = "there is no model; name one, or the columns of command and reading as input and output";
            return Err(refuse(&file, message.to_owned()));
        }
        all.push((name, home, machine));
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    if let Some(name) = only.iter().find(|name| !all.iter().any(|(own, ..)| own == *name)) {
        return Err(refuse(folder, format!("{name} is no folder in it with a {FILE}")));
    }
    if all.is_empty() {
        return Err(refuse(folder, format!("no folder in it has a {FILE}")));
    }
    Ok(all)
}

impl Machine {
    fn arguments(&self, home: &Path, out: &Path) -> Vec<String> {
        let text = |path: &Path| path.to_string_lossy().into_owned();
        let ending = self.model.as_ref().and_then(|model| model.extension());
        let ending = ending.map_or("toml".into(), |e| e.to_string_lossy());
        let repaired = out.join(format!("repaired.{ending}"));
        let model = self.model.as_ref().map(|model| text(&home.join(model)));
        let of = |option: &str, value: &Option<String>| {
            let value = value.clone();
            value.map_or_else(Vec::new, |value| vec![option.to_owned(), value])
        };
        let mut all = of("--model", &model);
        if model.is_none() {
            all.extend(of("--input", &self.input));
            all.extend(of("--output", &self.output));
        }
        for (option, files) in [("--log", &self.logs), ("--holdout", &self.holdout)] {
            all.extend(files.iter().flat_map(|f| [option.to_owned(), text(&home.join(f))]));
        }
        if self.drop > 0.0 {
            all.extend(["--drop".to_owned(), self.drop.to_string()]);
        }
        all.extend(self.options.iter().cloned());
        all.extend(["--json".to_owned(), text(&out.join("gap.json"))]);
        all.extend(["--repair".to_owned(), text(&repaired)]);
        all
    }

    fn ask(&self, name: &str, home: &Path, out: &Path, tool: &dyn Tool) -> Measured {
        let begin = Instant::now();
        let answer = tool.diagnose(out, &self.arguments(home, out)).and_then(|()| {
            let text = std::fs::read_to_string(out.join("gap.json")).map_err(|e| e.to_string())?;
            Answer::parse(&text)
        });
        let seconds = begin.elapsed().as_secs_f64();
        let (judgement, invented, stated, left) = match answer {
            Err(message) => (Judgement::Broken, 0.0, message, None),
            Ok(answer) => {
                let (judgement, invented) = self.judge(&answer);
                let named = |n: &crate::answer::Named| format!("{} {:.2}", n.effect, n.probability);
                let names: Vec<String> = answer.effects.iter().map(named).collect();
                let stated =
                    if names.is_empty() { answer.verdict.clone() } else { names.join(", ") };
                let (before, after) = (answer.shrink.rms_before, answer.shrink.rms_after);
                let left = before.zip(after).filter(|(b, _)| *b > 0.0).map(|(b, a)| a / b);
                (judgement, invented, stated, left)
            }
        };
        let (machine, right) = (name.to_owned(), self.right.clone());
        Measured { machine, judgement, invented, stated, right, left, seconds }
    }

    /// The judgement, and the largest probability of an invented name.
    fn judge(&self, answer: &Answer) -> (Judgement, f64) {
        let is_right = |name: &String| self.right.contains(name);
        let is_known = |name: &String| is_right(name) || self.also.contains(name);
        let stated = match answer.verdict.as_str() {
            "effects" => &answer.effects[..],
            _ => &[],
        };
        let most = |of: &dyn Fn(&String) -> bool| {
            let all = stated.iter().filter(|n| of(&n.effect)).map(|n| n.probability);
            all.fold(0.0, f64::max)
        };
        let Some(first) = stated.first() else {
            let is_none = self.right.is_empty();
            return (if is_none { Judgement::Right } else { Judgement::Unknown }, 0.0);
        };
        let invented = most(&|name| !is_known(name));
        let has_invented = stated.iter().any(|n| !is_known(&n.effect));
        if is_right(&first.effect) && !has_invented {
            (Judgement::Right, 0.0)
        } else if stated.iter().any(|n| is_right(&n.effect)) {
            (Judgement::Partly, invented)
        } else if first.set.iter().any(is_right) {
            (Judgement::InSet, invented)
        } else {
            (Judgement::Wrong, most(&|name| !is_right(name)))
        }
    }
}

impl Real {
    /// Machines whose answer is right.
    #[must_use]
    pub fn right(&self) -> usize {
        self.machines.iter().filter(|m| m.judgement == Judgement::Right).count()
    }

    /// Machines with an invented name of a high probability.
    #[must_use]
    pub fn sure_and_invented(&self) -> usize {
        self.machines.iter().filter(|m| m.invented >= SURE).count()
    }

    fn summary(&self) -> String {
        format!(
            "{} of {} machines right, {} with an invented name of {SURE} or more",
            self.right(),
            self.machines.len(),
            self.sure_and_invented()
        )
    }

    /// Writes the table and the summary.
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_text(&self, out: &mut dyn Write) -> io::Result<()> {
        for m in &self.machines {
            let left = m.left.map_or("–".to_owned(), |left| format!("{left:.3}"));
            let (judgement, seconds) = (m.judgement.text(), m.seconds);
            let (machine, stated) = (&m.machine, &m.stated);
            writeln!(out, "{judgement:8} {machine:20} {stated:60} leaves {left}  {seconds:.0} s")?;
        }
        writeln!(out, "{}", self.summary())
    }

    /// The page, without its provenance.
    #[must_use]
    pub fn page(&self) -> Report {
        let is_good = self.sure_and_invented() == 0 && self.right() == self.machines.len();
        let sentence = format!("{}.", self.summary());
        let verdict = if is_good { Verdict::pass(sentence) } else { Verdict::caution(sentence) };
        let columns = ["machine", "answer", "said", "documented", "leaves", "s"];
        let mut table = Table::new("Against what their makers document", columns);
        for m in &self.machines {
            table = table.row([
                Value::from(m.machine.as_str()),
                m.judgement.text().into(),
                m.stated.as_str().into(),
                m.right.join(", ").into(),
                m.left.map(|left| (1e3 * left).round() / 1e3).into(),
                Value::from(m.seconds.round()),
            ]);
        }
        let section = Section::new("Machines")
            .paragraph(
                "Right: the first name is documented and no wrong one is given, or no name is given where none is right. Partly: a documented name is given, but not first, or together with a wrong one. \
                 Leaves: root mean square of the held-out rows with the effects over that of the re-tuned model.",
            )
            .table(table);
        Report::new("gap-bench", "Measured machines", verdict).section(section)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::{Leftover, Named, Shrink};

    fn machine(right: &[&str], also: &[&str]) -> Machine {
        let own = |all: &[&str]| all.iter().map(ToString::to_string).collect();
        Machine {
            model: Some("m.toml".into()),
            input: None,
            output: None,
            logs: vec!["a.csv".into()],
            holdout: Vec::new(),
            drop: 0.0,
            options: Vec::new(),
            right: own(right),
            also: own(also),
        }
    }

    fn answer(names: &[(&str, f64, &[&str])]) -> Answer {
        let named = |(effect, probability, set): &(&str, f64, &[&str])| Named {
            effect: (*effect).to_owned(),
            output: "y".to_owned(),
            probability: *probability,
            set: set.iter().map(ToString::to_string).collect(),
        };
        let verdict = if names.is_empty() { "unknown" } else { "effects" };
        Answer {
            verdict: verdict.to_owned(),
            effects: names.iter().map(named).collect(),
            shrink: Shrink::default(),
            leftover: Leftover::default(),
        }
    }

    #[test]
    fn answers_are_judged_by_what_is_documented() {
        let m = machine(&["duffing"], &["creep"]);
        let judge = |names: &[(&str, f64, &[&str])]| m.judge(&answer(names));
        assert_eq!(judge(&[("duffing", 0.9, &["duffing"])]), (Judgement::Right, 0.0));
        let beside = [("duffing", 0.9, &["duffing"][..]), ("creep", 0.9, &["creep"])];
        assert_eq!(judge(&beside), (Judgement::Right, 0.0));
        let more = [("duffing", 0.9, &["duffing"][..]), ("delay", 0.7, &["delay"])];
        assert_eq!(judge(&more), (Judgement::Partly, 0.7));
        let set = [("backlash", 0.6, &["backlash", "duffing"][..])];
        assert_eq!(judge(&set), (Judgement::InSet, 0.6));
        assert_eq!(judge(&[("delay", 0.95, &["delay"])]), (Judgement::Wrong, 0.95));
        assert_eq!(judge(&[]), (Judgement::Unknown, 0.0));
        let none = machine(&[], &[]);
        assert_eq!(none.judge(&answer(&[])).0, Judgement::Right);
        assert_eq!(none.judge(&answer(&[("delay", 0.9, &["delay"])])), (Judgement::Wrong, 0.9));
    }

    /// Writes the answer that stands beside the model.
    struct Fixed;

    impl Tool for Fixed {
        fn pack(&self, _: &Path, _: &Path) -> Result<(), String> {
            Ok(())
        }
        fn identify(&self, _: &Path, _: &Path) -> Result<(), String> {
            Ok(())
        }
        fn diagnose(&self, _: &Path, arguments: &[String]) -> Result<(), String> {
            let of = |option: &str| {
                let at = arguments.iter().position(|a| a == option).ok_or("no such option")?;
                Ok::<_, String>(PathBuf::from(&arguments[at + 1]))
            };
            // Without a model the answer stands beside the log.
            let log = || Ok(of("--log")?.with_file_name("model.toml"));
            let model = of("--model").or_else(|_: String| log().and(of("--input")).and(log()))?;
            let text = std::fs::read_to_string(&model).map_err(|e| e.to_string())?;
            std::fs::write(of("--json")?, text).map_err(|e| e.to_string())
        }
        fn simulate(&self, _: &Path, _: &Path) -> Result<Vec<crate::label::Miss>, String> {
            Ok(Vec::new())
        }
    }

    #[test]
    fn a_folder_of_machines_is_asked_one_by_one() {
        let folder = tempfile::tempdir().unwrap();
        let says = serde_json::to_string(&answer(&[("creep", 0.9, &["creep"])])).unwrap();
        let model = "model = 'model.toml'";
        let columns = "input = 'u'\noutput = 'y'";
        for (name, text, from) in
            [("b", says.as_str(), model), ("a", "{}", model), ("c", says.as_str(), columns)]
        {
            let home = folder.path().join(name);
            std::fs::create_dir(&home).unwrap();
            std::fs::write(home.join("model.toml"), text).unwrap();
            let text = format!("{from}\nlogs = ['a.csv']\nright = ['creep']\n");
            std::fs::write(home.join(FILE), text).unwrap();
        }
        std::fs::create_dir(folder.path().join("no machine")).unwrap();
        let out = tempfile::tempdir().unwrap();
        let all = real(folder.path(), &[], out.path(), &Fixed, &|_| true).unwrap();
        let judged: Vec<_> =
            all.machines.iter().map(|m| (m.machine.as_str(), m.judgement)).collect();
        let wanted = [("a", Judgement::Broken), ("b", Judgement::Right), ("c", Judgement::Right)];
        assert_eq!(judged, wanted);
        assert_eq!((all.right(), all.sure_and_invented()), (2, 0));
        let error = real(folder.path(), &["d".to_owned()], out.path(), &Fixed, &|_| true);
        let message = error.unwrap_err().to_string();
        assert!(message.contains("d is no folder"), "{message}");
        let file = folder.path().join("a").join(FILE);
        std::fs::write(&file, "logs = ['a.csv']\nright = []\ninput = 'u'\n").unwrap();
        let error = real(folder.path(), &[], out.path(), &Fixed, &|_| true).unwrap_err();
        assert!(error.to_string().contains("as input and output"), "{error}");
        std::fs::write(folder.path().join("a").join(FILE), "model = 'm'").unwrap();
        let error = real(folder.path(), &[], out.path(), &Fixed, &|_| true).unwrap_err();
        assert!(error.to_string().contains("logs"), "{error}");
    }
}
