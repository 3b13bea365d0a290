//! The readers under test. Each gives what it said, empty where it accepted the file.

use std::borrow::Cow;
use std::fmt::Display;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::instrument;
use bench::campaign::Campaign;
use bench::emulate::Script;
use cosim::Plan;
use data::{Blueprint, CheckedBlueprint, Log, ReadOptions};
use modeldescription::package::{Limits, PackageBuilder};
use modeldescription::ssp::{ParameterMapping, ParameterSet, Ssp, SystemStructure};
use modeldescription::xml::XmlLimits;
use modeldescription::{ModelDescription, Package, check, check_description};

/// How inputs of a target are mutated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Words and lines.
    Text,
    /// Entries and records of a zip archive.
    Zip,
    /// Bytes and numbers.
    Binary,
}

/// A reader.
#[derive(Clone, Debug)]
pub struct Target {
    /// Name, which is that of its folder of inputs.
    pub name: Cow<'static, str>,
    /// How its inputs are mutated.
    pub kind: Kind,
    /// Ending of the file that it reads.
    ending: &'static str,
    read: fn(&[u8], &Path) -> String,
}

/// All readers.
#[must_use]
pub fn targets() -> Vec<Target> {
    let format = |format: &data::Format| Target {
        name: format!("log-{}", format.name).into(),
        kind: if format.ending == "npz" { Kind::Zip } else { Kind::Binary },
        ending: format.ending,
        read: log,
    };
    OTHERS.iter().cloned().chain(Log::FORMATS.iter().map(format)).collect()
}

/// All readers but those of logs that are no texts, which declare themselves.
const OTHERS: &[Target] = &[
    target("fmu-archive", Kind::Zip, "fmu", fmu_archive),
    target("fmu-unpacked", Kind::Zip, "fmu", fmu_unpacked),
    target("model-description", Kind::Text, "xml", model_description),
    target("ssp-archive", Kind::Zip, "ssp", ssp_archive),
    target("ssp-structure", Kind::Text, "ssd", ssp_structure),
    target("ssp-values", Kind::Text, "ssv", ssp_values),
    target("blueprint", Kind::Text, "toml", blueprint),
    target("system-plan", Kind::Text, "toml", system_plan),
    target("bench-plan", Kind::Text, "toml", bench_plan),
    target("sweep-plan", Kind::Text, "toml", sweep_plan),
    target("osp-system", Kind::Text, "xml", osp_system),
    target("estimate-options", Kind::Text, "txt", estimate_options),
    target("fmu-sources", Kind::Zip, "fmu", fmu_archive),
    target("log-csv", Kind::Text, "csv", log),
    target("log-text", Kind::Text, "txt", log_text),
    target("dataset", Kind::Text, "dataset.toml", dataset),
    target("learned-table", Kind::Binary, "npy", learned_table),
    target("bench-record", Kind::Text, "journal", instrument::record),
    target("line-gcs", Kind::Text, "txt", instrument::gcs),
    target("line-nv200", Kind::Text, "txt", instrument::nv200),
    target("driver", Kind::Text, "txt", instrument::driver),
    #[cfg(feature = "gap")]
    target("gap-json", Kind::Text, "json", gap_json),
];

const fn target(
    name: &'static str,
    kind: Kind,
    ending: &'static str,
    read: fn(&[u8], &Path) -> String,
) -> Target {
    Target { name: Cow::Borrowed(name), kind, ending, read }
}

impl Target {
    /// The target of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        targets().into_iter().find(|target| target.name == name)
    }

    /// Lets the reader read an input; what it says, nothing where it accepts it.
    ///
    /// # Errors
    /// The scratch file cannot be written.
    pub fn run(&self, input: &[u8], scratch: &Scratch) -> io::Result<String> {
        scratch.hold(input)?;
        Ok((self.read)(input, &scratch.path))
    }

    /// A file for it in this folder.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn scratch(&self, folder: &Path) -> io::Result<Scratch> {
        let path = folder.join(format!("input.{}", self.ending));
        let file = OpenOptions::new().write(true).create(true).truncate(true).open(&path)?;
        Ok(Scratch { path, file })
    }
}

/// The file that holds the present input: readers of files read it, and it is there after a crash.
#[derive(Debug)]
pub struct Scratch {
    path: PathBuf,
    file: File,
}

impl Scratch {
    fn hold(&self, input: &[u8]) -> io::Result<()> {
        self.file.set_len(input.len() as u64)?;
        let mut file = &self.file;
        file.seek(SeekFrom::Start(0))?;
        file.write_all(input)
    }

    /// Where it lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// The inputs that a target starts from: its files in `corpus/`, in the order of their names.
///
/// # Errors
/// The folder cannot be read.
pub fn corpus(target: &Target) -> io::Result<Vec<Vec<u8>>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(&*target.name);
    let mut paths = fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<io::Result<Vec<_>>>()?;
    paths.sort();
    paths.into_iter().map(fs::read).collect()
}

fn message<T>(result: Result<T, impl Display>) -> String {
    result.map_or_else(|error| error.to_string(), |_| String::new())
}

fn all<T: Display>(problems: &[T]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Bounds for inputs of some kilobytes, so that what they unpack to is small too.
fn limits() -> Limits {
    Limits {
        free_bytes: 1 << 20,
        total_bytes: 1 << 24,
        xml: XmlLimits::default(),
        ..Limits::default()
    }
}

fn fmu_archive(_: &[u8], file: &Path) -> String {
    check(file).map_or_else(|error| error.to_string(), |problems| all(&problems))
}

fn fmu_unpacked(_: &[u8], file: &Path) -> String {
    match Package::open_within(file, &limits()) {
        Ok(package) => {
            let inside = package.folder().starts_with(tempfile::env::temp_dir());
            assert!(inside, "unpacked to {}", package.folder().display());
            message(package.binary())
        }
        Err(error) => error.to_string(),
    }
}

/// What is read is checked, and, where it is accepted, written and read again as the same.
fn model_description(input: &[u8], _: &Path) -> String {
    let mut described = all(&check_description(input));
    match ModelDescription::parse(input) {
        Ok(read) => {
            if let Ok(text) = read.to_xml() {
                let again = ModelDescription::parse(text.as_bytes());
                let again = again.unwrap_or_else(|error| panic!("{error}\n{text}"));
                assert_eq!(again.variables.len(), read.variables.len());
                described += &message(PackageBuilder::new(&again));
            }
        }
        Err(error) => described += &error.to_string(),
    }
    described
}

fn ssp_archive(_: &[u8], file: &Path) -> String {
    match Ssp::open_within(file, &limits()) {
        Ok(ssp) => message(
            ssp.structure().flatten("SystemStructure.ssd").map_err(|problems| all(&problems)),
        ),
        Err(error) => error.to_string(),
    }
}

fn ssp_structure(input: &[u8], _: &Path) -> String {
    match SystemStructure::parse(input, "SystemStructure.ssd") {
        Ok(read) => {
            if let Ok(text) = read.to_xml() {
                let again = SystemStructure::parse(text.as_bytes(), "again.ssd");
                assert!(again.is_ok(), "{:?}\n{text}", again.map(|_| ()).map_err(|p| all(&p)));
            }
            message(read.flatten("SystemStructure.ssd").map_err(|problems| all(&problems)))
        }
        Err(problems) => all(&problems),
    }
}

fn ssp_values(input: &[u8], _: &Path) -> String {
    let set = ParameterSet::parse(input, "values.ssv").map_err(|problems| all(&problems));
    if let Ok(Ok(text)) = set.as_ref().map(ParameterSet::to_xml) {
        let again = ParameterSet::parse(text.as_bytes(), "again.ssv");
        assert!(again.is_ok(), "{:?}\n{text}", again.map(|_| ()).map_err(|p| all(&p)));
    }
    let mapping = ParameterMapping::parse(input, "values.ssm").map_err(|problems| all(&problems));
    message(set) + &message(mapping)
}

/// What is accepted is built, and written and read again as the same.
fn blueprint(input: &[u8], _: &Path) -> String {
    let Ok(text) = std::str::from_utf8(input) else { return "is no UTF-8".into() };
    let checked = match Blueprint::parse(text, "input.toml") {
        Ok(read) => read.check(learned::COMPONENTS),
        Err(problems) => return problems.to_string(),
    };
    match checked {
        Ok(checked) => {
            let written = checked.blueprint().to_toml();
            let again = Blueprint::parse(&written, "again.toml");
            let again = again.unwrap_or_else(|error| panic!("{error}\n{written}"));
            assert!(again == *checked.blueprint(), "{written}");
            played(&checked, 1e-3)
        }
        Err(problems) => problems.to_string(),
    }
}

/// What a plant or controller says that is run for so long.
fn played(checked: &CheckedBlueprint, seconds: f64) -> String {
    let mut system = checked.build();
    let run = system.initialise(0.0).and_then(|()| system.advance(seconds));
    message(run.map_err(|error| system.explain(&error)))
}

/// The table of a learned model, as the tool and a packed FMU read it, in models of two, three and four inputs.
fn learned_table(_: &[u8], file: &Path) -> String {
    const PLANT: &str = r#"piezoloop = 1
kind = "plant"
name = "learned"
step = 0.005
[[axis]]
name = "x"
command = { name = "u", unit = "V", min = 0, max = 150, start = 0 }
position = { name = "y", unit = "um" }
[[axis.component]]
type = "lssvm-narx"
table = "input.npy"
sample_time = 0.005
past_outputs = 1
command_high = 150
position_high = 80
past_inputs = "#;
    static PLANTS: OnceLock<[Blueprint; 3]> = OnceLock::new();
    let plant = |past_inputs: usize| {
        let origin = file.with_file_name("learned.toml");
        let plant = Blueprint::parse(&format!("{PLANT}{past_inputs}"), &origin.to_string_lossy());
        plant.unwrap_or_else(|problems| panic!("{problems}"))
    };
    // All inputs lie in the file of the first one.
    let plants = PLANTS.get_or_init(|| [0, 1, 2].map(plant));
    let read = |plant: &Blueprint| match plant.clone().check(learned::COMPONENTS) {
        Ok(checked) => played(&checked, 0.02),
        Err(problems) => problems.to_string(),
    };
    let message = plants.each_ref().map(read);
    if message.iter().any(String::is_empty) { String::new() } else { message.concat() }
}

fn system_plan(input: &[u8], file: &Path) -> String {
    let Ok(text) = std::str::from_utf8(input) else { return "is no UTF-8".into() };
    message(Plan::parse_toml(text, file))
}

/// The bench's three texts: a plan, a script of faults, a campaign of them.
fn bench_plan(input: &[u8], _: &Path) -> String {
    let Ok(text) = std::str::from_utf8(input) else { return "is no UTF-8".into() };
    let faults = message(Script::parse(text, "input.toml"));
    let campaign = message(Campaign::parse(text, "input.toml"));
    let plan = message(bench::plan::Plan::parse(text, "input.toml"));
    // Each text is one of the three.
    match faults.is_empty() || campaign.is_empty() || plan.is_empty() {
        true => String::new(),
        false => faults + &campaign + &plan,
    }
}

fn sweep_plan(input: &[u8], file: &Path) -> String {
    let Ok(text) = std::str::from_utf8(input) else { return "is no UTF-8".into() };
    message(sweep::Plan::parse(text, file))
}

fn osp_system(input: &[u8], file: &Path) -> String {
    let Ok(text) = std::str::from_utf8(input) else { return "is no UTF-8".into() };
    message(Plan::parse_osp(text, file))
}

/// What `estimate` is asked to find, an option a line.
fn estimate_options(input: &[u8], _: &Path) -> String {
    let Ok(text) = std::str::from_utf8(input) else { return "is no UTF-8".into() };
    let read = |line| match cosim::Sought::parse(line) {
        Ok(sought) => {
            let bounds = sought.bounds.map(|(low, high)| [low, high]);
            let numbers = sought.start.into_iter().chain(bounds.into_iter().flatten());
            assert!(numbers.into_iter().all(f64::is_finite), "{line}");
            assert!(line.contains(&sought.name), "{line}");
            String::new()
        }
        Err(why) => why,
    };
    text.lines().map(read).collect()
}

/// A bound for inputs of some kilobytes, as in `limits`.
fn log_options() -> ReadOptions {
    ReadOptions { memory: Some(16 << 20), ..ReadOptions::default() }
}

fn log(_: &[u8], file: &Path) -> String {
    read_log(file, &log_options())
}

/// A text, with what a caller may say of it; which, its length decides.
fn log_text(input: &[u8], file: &Path) -> String {
    let mut options = log_options();
    match input.len() % 8 {
        0 => options.rate = Some(1000.0),
        1 => options.columns = ["t", "u [V]", "y [um]"].map(str::to_owned).to_vec(),
        2 => options.resample = Some(data::Resample::Fastest),
        3 => options.time = Some("u".to_owned()),
        _ => {}
    }
    read_log(file, &options)
}

/// What stands beside a log.
fn dataset(_: &[u8], file: &Path) -> String {
    let log = file.with_file_name("input.csv");
    if !log.is_file() {
        let text = "t,u,y,1\n0,1,2,3\n1,2,3,4\n2,3,4,5\n";
        if let Err(error) = fs::write(&log, text) {
            return error.to_string();
        }
    }
    read_log(&log, &log_options())
}

/// A log that is accepted holds finite numbers in times that grow.
fn read_log(file: &Path, options: &ReadOptions) -> String {
    match Log::read(file, options) {
        Ok(log) => {
            assert!(log.time().iter().all(|time| time.is_finite()));
            for column in log.columns() {
                assert_eq!(column.values.len(), log.len(), "{}", column.name);
                assert!(column.values.iter().all(|value| value.is_finite()), "{}", column.name);
            }
            for record in log.records() {
                let times = &log.time()[record.rows.clone()];
                assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
            }
            String::new()
        }
        Err(problems) => problems.to_string(),
    }
}

/// What is read is written as JSON and read again as the same.
#[cfg(feature = "gap")]
fn gap_json(input: &[u8], _: &Path) -> String {
    let Ok(text) = std::str::from_utf8(input) else { return "is no UTF-8".into() };
    let answer = message(gap_bench::Answer::parse(text));
    match serde_json::from_str::<diagnose::Gap>(text) {
        Ok(gap) => {
            let written = serde_json::to_string(&gap);
            let written = written.unwrap_or_else(|error| panic!("{error}"));
            let again = serde_json::from_str::<diagnose::Gap>(&written);
            assert!(again.is_ok_and(|again| again == gap), "{written}");
            answer
        }
        Err(error) => answer + &error.to_string(),
    }
}
