//! `piezoloop diagnose`: where a model and its machine differ, which effect it is, what it is worth.

mod again;
mod baseline;
mod carried;
mod repaired;
mod source;
mod thresholds;
mod tolerances;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use cli::{Answer, PageOptions, Pages, STANDARD_OUTPUT, Screen};
use data::AtomicFile;
use diagnose::{Discrepancy, Files, Gap, Model, Noise, Observer, Request, Tolerance, Verdict};
use indicatif::ProgressBar;
use serde::Serialize;

use self::source::Source;
use self::thresholds::Thresholds;
use self::tolerances::check_tolerances;
use crate::fmus::Isolation;
use crate::inputs::{self, LogOptions};
use crate::pages;
use crate::ranges;

const NO_MODEL: &str = "no model is given; give one with --model, or --input COLUMN and --output COLUMN to identify a linear one from the logs";

/// Finds the effect that a model lacks, where the gap lies, and how much of it the effect explains
///
/// The model is a blueprint (.toml; effects are inserted at their physical place) or any co-simulation FMU (effects
/// act before and behind it, and inside it before its mode if the step response shows one). Parameters are first
/// re-tuned within their tolerance. A named effect must hold on rows that were not fitted. Without --model, a linear
/// model is identified from the logs, shown and diagnosed.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop diagnose --model plant.toml --log a.csv --log b.csv --map u=u1 --json gap.json --report gap.html\n  piezoloop diagnose --model plant.fmu --log a.csv --holdout b.csv --tune '*.frequency=0.02' --rest idle.csv\n  piezoloop diagnose --model plant.toml --log a.csv --repair repaired.toml\n  piezoloop diagnose --log a.csv --input u --output y --baseline linear.toml\n  piezoloop diagnose --log a.csv --input u --output y --frequency-response response.csv"
)]
pub(crate) struct Diagnose {
    /// The model: a blueprint, the name of a rig, or an FMU
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Without --model: column of the command of the linear model that is identified from the logs; once per axis
    #[arg(
        long = "input",
        value_name = "COLUMN",
        conflicts_with = "model",
        requires = "output_columns"
    )]
    inputs: Vec<String>,
    /// Without --model: column of the position; once per axis, in the order of the inputs
    #[arg(
        id = "output_columns",
        long = "output",
        value_name = "COLUMN",
        conflicts_with = "model",
        requires = "inputs"
    )]
    output_columns: Vec<String>,
    /// Without --model: fit the linear model to this frequency response instead of the logs. A table with the columns
    /// frequency and magnitude and phase, or real and imaginary part (.csv, .mat, .npz, .parquet, …), or what
    /// frequency-response -o wrote
    #[arg(long, value_name = "FILE", conflicts_with = "model", requires = "inputs")]
    frequency_response: Option<PathBuf>,
    /// Greatest number of modes to fit to --frequency-response
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = ranges::count(1, 100))]
    modes: usize,
    /// Write the linear model that was identified from the logs, a blueprint
    #[arg(long, value_name = "FILE", requires = "inputs")]
    baseline: Option<PathBuf>,
    /// A measured log (may be given several times)
    #[arg(long = "log", value_name = "FILE", required = true)]
    logs: Vec<PathBuf>,
    /// A log that is not fitted, only judged [default: the last 30 % of each record]
    #[arg(long, value_name = "FILE")]
    holdout: Vec<PathBuf>,
    /// Run-in in s at the start of each record: simulated, but neither fitted nor judged [default: 0, or
    /// longer if a log begins during a motion]
    #[arg(long, value_name = "S", value_parser = ranges::time())]
    drop: Option<f64>,
    /// Command between two rows of the logs: zoh (held), line, band-limited [default: held, unless the logs of a
    /// blueprint show otherwise]
    #[arg(long, value_name = "BETWEEN", value_parser = ["zoh", "line", "band-limited"])]
    between: Option<String>,
    /// Instant of a row's reading: before its command acts, with it, or after it has acted [default: before a held
    /// command, with one that moves, unless the logs of a blueprint show otherwise]
    #[arg(long, value_name = "READING", value_parser = ["before", "with", "after"])]
    reading: Option<String>,
    /// Accuracy that is good enough, as rms divided by the range of the output, for example 0.01; a smaller error
    /// counts as none [default: the noise]
    #[arg(long, value_name = "REL", default_value_t = 0.0, hide_default_value = true, value_parser = ranges::from(0.0, 1.0))]
    accuracy: f64,
    #[command(flatten)]
    options: LogOptions,
    /// Outputs to diagnose [default: all that the logs have]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    outputs: Vec<String>,
    /// Parameters that may deviate, with their tolerance (1 σ): GLOB=REL or NAME=+-ABS
    #[arg(long, value_name = "NAME=TOLERANCE")]
    tune: Vec<String>,
    /// Relative tolerance (1 σ) of each output's gain
    #[arg(long, value_name = "REL", default_value_t = 0.01, value_parser = ranges::above(0.0, 1e3))]
    gain_tolerance: f64,
    /// Standard deviation of the noise, in the log's unit [default: estimated]
    #[arg(
        long,
        value_name = "[OUTPUT=]SIGMA",
        conflicts_with = "rest",
        allow_hyphen_values = true
    )]
    noise: Vec<String>,
    /// A record of the machine at rest
    #[arg(long, value_name = "FILE")]
    rest: Option<PathBuf>,
    /// Greatest number of effects to name per output
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = ranges::count(0, 100))]
    max_effects: usize,
    /// Exclude an effect from the library (may be given several times)
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// Write the answer as JSON; without FILE to standard output
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = STANDARD_OUTPUT)]
    json: Option<PathBuf>,
    #[command(flatten)]
    page: PageOptions,
    /// Write an SVG picture of the first output's gap over its command, in the slowest record, before and after the
    /// repair
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Write the repaired model, .toml or .fmu
    #[arg(long, value_name = "FILE")]
    repair: Option<PathBuf>,
    /// Include all shared libraries of this folder, which has one subfolder per platform, as made by
    /// dev/tools/portable: the repaired FMU then runs on each of them that the original supports
    #[arg(long, value_name = "FOLDER", requires = "repair")]
    libraries: Option<PathBuf>,
    /// Write the signal of the next experiment, if one is proposed, as a CSV that can be played
    #[arg(long, value_name = "FILE")]
    next_experiment: Option<PathBuf>,
    #[command(flatten)]
    isolation: Isolation,
    /// Number of threads; 0: one per processor
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = ranges::threads())]
    threads: usize,
    /// Seed of the resampling
    #[arg(long, value_name = "S", default_value_t = 1, value_parser = ranges::seed())]
    seed: u64,
    /// Exit with code 1 if the gap's rms divided by the output's range is larger
    #[arg(long, value_name = "REL", value_parser = ranges::from(0.0, 1e15))]
    fail_above: Option<f64>,
}

/// The gap, and what was written.
#[derive(Serialize)]
#[serde(transparent)]
struct Diagnosed {
    gap: Gap,
    #[serde(skip)]
    written: Vec<PathBuf>,
    /// What the repaired model leaves out.
    #[serde(skip)]
    notes: Vec<String>,
    #[serde(skip)]
    fails: bool,
}

/// Shows how far a diagnosis is.
struct Bar(ProgressBar);

impl Observer for Bar {
    fn progress(&mut self, _stage: &'static str, done: usize, total: usize) {
        self.0.set_length(total as u64);
        self.0.set_position(done as u64);
    }
}

impl Diagnose {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let (answer, pages) = self.execute(screen)?;
        pages.show(screen, &answer)
    }

    fn execute(&self, screen: &Screen) -> anyhow::Result<(Diagnosed, Pages)> {
        let (picture, repair) = (self.picture.as_deref(), self.repair.as_deref());
        let outputs = [
            self.json_file(),
            picture,
            repair,
            self.next_experiment.as_deref(),
            self.baseline.as_deref(),
        ];
        self.page.can_write()?;
        for output in outputs.into_iter().flatten() {
            cli::can_write(output)?;
        }
        self.check_repair()?;
        if self.model.is_none() && self.inputs.is_empty() {
            bail!(NO_MODEL);
        }
        inputs::are_apart(("--log", &self.logs), ("--holdout", &self.holdout))?;
        let mut source = self.source(screen)?;
        let mut written = Vec::new();
        // Before the diagnosis, which may refuse it: coupled axes are packed first.
        if let (Source::Generated(identified), Some(file)) = (&source, &self.baseline) {
            identified.text.blueprint.write(file)?;
            written.push(file.clone());
        }
        let mut libraries = self.libraries(self.is_fmu())?;
        let mut request = self.request(&source)?;
        let unmatched = check_tolerances(&request)?;
        let reported =
            source.fmu().map_or(Ok(Vec::new()), |fmu| carried::add(&mut request, &fmu))?;
        let mut bar = Bar(cli::bar(screen, "diagnose", 1));
        let mut diagnosis = diagnose::examine(&request, &mut bar);
        if let Source::Generated(model) = &mut source {
            let first = model.text.text.clone();
            diagnosis = match diagnosis {
                Ok(found) => Ok(again::better(found, model, &request, &mut bar)?),
                refused => refused,
            };
            if let Some(file) = self.baseline.as_ref().filter(|_| model.text.text != first) {
                model.text.blueprint.write(file)?;
            }
        }
        let (mut notes, baseline) = match &source {
            Source::Generated(identified) => {
                (identified.notes.clone(), identified.baselines.clone())
            }
            _ => Default::default(),
        };
        let mut name = None;
        if let Err(diagnose::Error::Joined { model, reason }) = diagnosis {
            let (packed, note) = self.packed(&source, &mut request, (&model, &reason))?;
            (source, name) = (packed, Some(model));
            notes.push(note);
            libraries = self.libraries(true)?;
            diagnosis = diagnose::examine(&request, &mut bar);
        }
        bar.0.finish_and_clear();
        let mut diagnosis = diagnosis?;
        diagnosis.gap.baseline = baseline;
        diagnosis.gap.provenance.model = name.unwrap_or(diagnosis.gap.provenance.model);
        diagnosis.gap.warnings.extend(unmatched);
        diagnosis.gap.warnings.splice(0..0, notes.into_iter().chain(reported));
        // Before the answer, which speaks of the model that is handed back; where that cannot be
        // written the answer is there all the same.
        let is_repaired = matches!(diagnosis.gap.verdict, Verdict::Effects | Verdict::Retune);
        let repaired = self.repair.as_deref().filter(|_| is_repaired).map(|file| {
            let names = &request.names;
            self.write_repair(&mut diagnosis, (&source, file), names, &libraries)
        });
        if let Some(file) = self.json_file() {
            let text = serde_json::to_string_pretty(&diagnosis.gap)? + "\n";
            AtomicFile::write_all_of(file, text.as_bytes())
                .with_context(|| format!("{} cannot be written", file.display()))?;
            written.push(file.to_owned());
        }
        if let Some(file) = &self.picture {
            let svg = diagnosis.picture().context("there is no output to draw")?;
            AtomicFile::write_all_of(file, svg.as_bytes())
                .with_context(|| format!("{} cannot be written", file.display()))?;
            written.push(file.clone());
        }
        let mut notes = diagnosis.incidents();
        if let Some(file) = &self.repair {
            match repaired {
                Some(of_it) => {
                    notes.extend(of_it?);
                    written.push(file.clone());
                }
                None => notes.push(format!(
                    "{} is not written: there is no effect to add and no parameter to re-tune",
                    file.display()
                )),
            }
        }
        let mut experiment = None;
        if let Some(file) = &self.next_experiment {
            match diagnosis.next_experiment_csv() {
                Some(text) => {
                    AtomicFile::write_all_of(file, text.as_bytes())
                        .with_context(|| format!("{} cannot be written", file.display()))?;
                    written.push(file.clone());
                    experiment = Some(file.as_path());
                }
                None => notes.push(format!(
                    "{} is not written: nothing is undecided that a measurement could decide",
                    file.display()
                )),
            }
        }
        let repair = self.repair.as_deref().filter(|file| written.iter().any(|w| w == file));
        let files = Files { repair, notes: &notes, experiment };
        let pages = self.page.write(|| {
            let read: Vec<(&str, &Path)> =
                self.files().map(|path| ("input", path.as_path())).collect();
            let provenance = pages::provenance(&read)?.seed(self.seed);
            Ok(diagnosis.report(&files).provenance(provenance))
        })?;
        written.extend(pages.files.iter().cloned());
        let fails = self.fail_above.is_some_and(|most| diagnosis.gap.shrink.relative_gap > most);
        Ok((Diagnosed { gap: diagnosis.gap, written, notes, fails }, pages))
    }

    fn json_file(&self) -> Option<&Path> {
        self.json.as_deref().filter(|file| *file != Path::new(STANDARD_OUTPUT))
    }

    /// All files that are read.
    fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let model = self.model.as_ref().filter(|model| model.exists());
        let response = &self.frequency_response;
        model.into_iter().chain(response).chain(&self.logs).chain(&self.holdout).chain(&self.rest)
    }

    /// What is said of the commands between the rows, and of the instants of the readings.
    fn readings(&self) -> (Option<diagnose::Between>, Option<diagnose::Reading>) {
        let between = self.between.as_deref().and_then(diagnose::Between::find);
        (between, self.reading.as_deref().and_then(diagnose::Reading::find))
    }

    fn request(&self, source: &Source) -> anyhow::Result<Request> {
        let logs = |paths: &[PathBuf]| {
            paths.iter().map(|p| self.options.read(p)).collect::<anyhow::Result<Vec<_>>>()
        };
        let model = match source.fmu() {
            Some(path) => Model::Fmu(path),
            None => {
                let blueprint = source.blueprint()?.blueprint.clone();
                Model::Blueprint(Box::new(blueprint.check(learned::COMPONENTS)?))
            }
        };
        let mut request = Request::new(model, logs(&self.logs)?);
        request.holdout = logs(&self.holdout)?;
        request.drop = self.drop;
        (request.between, request.reading) = self.readings();
        request.accuracy = self.accuracy;
        request.names = self.options.names()?;
        if let Source::Generated(identified) = source {
            request.first = identified.readings;
            request.drop = Some(identified.run_in).filter(|drop| *drop > 0.0).or(self.drop);
            // Those of --input and --output are in the map of the model that was made.
            let is_own = |pair: &&String| {
                let name = pair.split_once('=').map_or(pair.as_str(), |(name, _)| name.trim());
                self.inputs.iter().chain(&self.output_columns).any(|own| own == name)
            };
            let given = self.options.map.iter().filter(|pair| !is_own(pair));
            let all: Vec<&String> = given.chain(&identified.map).collect();
            request.names = data::NameMap::parse(&all)?;
        }
        request.outputs.clone_from(&self.outputs);
        request.tolerances =
            self.tune.iter().map(|t| Tolerance::parse(t)).collect::<Result<_, _>>()?;
        request.gain_tolerance = self.gain_tolerance;
        request.noise = self.noise()?;
        request.max_effects = self.max_effects;
        request.without.clone_from(&self.without);
        request.threads = self.threads;
        request.seed = self.seed;
        request.worker = self.isolation.worker()?;
        Ok(request)
    }

    fn is_fmu(&self) -> bool {
        self.model.as_deref().is_some_and(|model| cli::ends_in(model, "fmu"))
    }

    fn noise(&self) -> anyhow::Result<Noise> {
        if let Some(rest) = &self.rest {
            return Ok(Noise::Rest(Box::new(self.options.read(rest)?)));
        }
        if self.noise.is_empty() {
            return Ok(Noise::Estimated);
        }
        let mut all = Vec::new();
        for text in &self.noise {
            let (output, sigma) = match text.split_once('=') {
                Some((output, sigma)) => (Some(output.trim().to_owned()), sigma),
                None => (None, text.as_str()),
            };
            let Ok(sigma) = sigma.trim().parse() else {
                bail!(
                    "--noise {text}: is no standard deviation; write SIGMA or OUTPUT=SIGMA, as in y=0.003"
                );
            };
            all.push((output, sigma));
        }
        Ok(Noise::Given(all))
    }
}

impl Answer for Diagnosed {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let gap = &self.gap;
        for warning in &gap.warnings {
            writeln!(out, "note: {warning}")?;
        }
        writeln!(out, "{}", gap.sentence)?;
        let by_output = gap.by_output();
        for (output, effects) in &by_output {
            if by_output.len() > 1 {
                writeln!(out, "  {output}:")?;
            }
            let indent = if by_output.len() > 1 { "    " } else { "  " };
            for (name, p) in effects.iter().flat_map(|effect| &effect.parameters) {
                let deviation = p.std.map_or(String::new(), |s| format!(" ± {s:.2e}"));
                let most = Thresholds::NOT_DETERMINED * p.value.abs();
                if p.value != 0.0 && p.std.is_some_and(|s| s > most) {
                    writeln!(out, "{indent}{name}: these logs do not determine it")?;
                } else {
                    writeln!(out, "{indent}{name} = {:.6}{deviation} {}", p.value, p.unit)?;
                }
            }
        }
        let more = |left: &&Discrepancy| left.rms > gap.shrink.noise_floor;
        if let Some(left) = gap.leftover.discrepancy.as_ref().filter(more) {
            let what = match &gap.leftover.looks_like {
                Some(name) => {
                    format!("; it looks like {} but may be something else", name.replace('_', " "))
                }
                // The sentence above says which candidate is the best.
                None if gap.verdict == Verdict::Unknown => String::new(),
                None => "; no further candidate explains it".to_owned(),
            };
            let part = report::format_number(100.0 * left.of_range, 2);
            writeln!(
                out,
                "Remaining error beyond the noise: {part} % of the range of {}{what}.",
                gap.place.output
            )?;
        }
        if let Some(next) = &gap.next_experiment {
            writeln!(out, "Next: {}.", next.sentence)?;
        }
        for note in &self.notes {
            writeln!(out, "note: {note}")?;
        }
        for file in &self.written {
            writeln!(out, "{}: written", file.display())?;
        }
        Ok(())
    }

    fn exit_code(&self) -> u8 {
        u8::from(self.fails)
    }
}
