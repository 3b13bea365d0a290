//! `piezoloop frequency-response`: what a machine does linearly, line by line, and how well that is known.

mod plant;
pub(crate) mod table;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use cli::{PageOptions, Screen, rounded};
use data::{Log, SampleTime};
use identify::frequency::{
    self, Choice, Domain, Experiment, FrequencyResponse as Response, Level, MeasureSettings,
    RationalSettings,
};

use crate::inputs::{self, LogOptions, Readings};
use crate::results::frequency_response::{Fit, Measured, OutputLevels, Signal};
use crate::{pages, ranges};

/// Power of a line, as a part of the greatest, up to which a record without periods counts as excited;
/// coherence tells how good such a line is.
const BAND: f64 = 1e-4;

/// Ratio of the inputs' rms up to which records are of one level.
const SAME_LEVEL: f64 = 1.2;

/// Measures a frequency response, with coherence, noise and distortion
///
/// Takes multisines, swept sines or any other broadband signal, for one axis or several coupled ones. (Several axes
/// need at least as many experiments as inputs; each record of a log is one experiment.) Uses the local polynomial
/// method. If the records consist of complete periods, noise and distortion are separated, and lines that a multisine
/// omits show even and odd nonlinearities. Modes and a delay are fitted to the response. With --plant they are
/// written as a plant that can be packed, simulated and diagnosed.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop frequency-response sweep.csv --input u --output y --report page.html\n  piezoloop frequency-response mirror-*.csv --input u1 --input u2 --output x --output y --modes 4 -o response.csv\n  piezoloop frequency-response mirror.csv --input u1 --input u2 --output y1 --output y2 --modes 4 --plant mirror.toml\n  piezoloop frequency-response low.csv high.csv --input u --output y --modes 4 --plant stage.toml --softening"
)]
pub(crate) struct FrequencyResponse {
    /// Logs; each record of each is an experiment
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Column of an input (once per input)
    #[arg(long = "input", required = true, value_name = "COLUMN")]
    inputs: Vec<String>,
    /// Column of an output (once per output)
    #[arg(long = "output", required = true, value_name = "COLUMN")]
    outputs: Vec<String>,
    /// Samples of one period [default: detected, if the record repeats]
    #[arg(long, value_name = "SAMPLES", value_parser = ranges::count(2, 1_000_000_000))]
    period: Option<usize>,
    /// Omit the first S seconds of each record: the transient before steady state
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = ranges::time())]
    skip: f64,
    /// Greatest number of lines at which the response is computed
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = ranges::count(1, 1_000_000))]
    lines: usize,
    /// Greatest number of modes to fit; fewer are used if the response does not support them; 0: no fit
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = ranges::count(0, 100))]
    modes: usize,
    /// Number of real poles to fit in addition to the modes, such as that of an amplifier
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = ranges::count(0, 100))]
    lags: usize,
    /// Longest delay to try in the fit, in s
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = ranges::time())]
    longest_delay: f64,
    #[command(flatten)]
    options: LogOptions,
    #[command(flatten)]
    readings: Readings,
    /// Also write the response to this CSV file, one row per line
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
    /// Also write the fit as a plant: one axis per input and output, and their common modes
    #[arg(long, value_name = "FILE")]
    plant: Option<PathBuf>,
    /// Refine the modes of the plant to the least error of its simulated outputs, with equal weight for all lines,
    /// instead of weights from the scatter of each line
    #[arg(long, requires = "plant")]
    refine: bool,
    /// Fit modes whose frequency and damping depend on the amplitude: records of several levels of excitation,
    /// distinguished by the rms of their inputs, are fitted together
    #[arg(long, requires = "plant")]
    softening: bool,
    #[command(flatten)]
    page: PageOptions,
}

impl FrequencyResponse {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let logs: Vec<&Path> = self.logs.iter().map(PathBuf::as_path).collect();
        for (outs, endings) in [(&self.out, inputs::CSV), (&self.plant, inputs::BLUEPRINT)] {
            outs.iter().try_for_each(|out| cli::can_write_as(out, endings))?;
        }
        self.page.can_write()?;
        let answer = self.execute()?;
        if let Some(out) = &self.out {
            table::write(&answer, out)?;
        }
        if let Some(plant) = &answer.plant {
            plant.checked.write(&plant.blueprint)?;
        }
        let files: Vec<(&str, &Path)> = logs.iter().map(|log| ("log", *log)).collect();
        self.page.finish(screen, &answer, || {
            Ok(pages::frequency_response(&answer, pages::provenance(&files)?))
        })
    }

    fn execute(&self) -> anyhow::Result<Measured> {
        let mut signals: Vec<Signal> = self
            .inputs
            .iter()
            .chain(&self.outputs)
            .map(|name| Signal { name: name.clone(), unit: None })
            .collect();
        let (experiments, sample_time) = self.experiments(&mut signals)?;
        let settings = MeasureSettings {
            period: self.period,
            most_lines: self.lines.max(1),
            band: BAND,
            ..MeasureSettings::new(sample_time)
        };
        let mut notes = Vec::new();
        let (levels, response) = if self.softening {
            let levels = self.levels(&experiments, &settings)?;
            // That in the middle is nearest to all others.
            let (count, middle) = &levels[levels.len() / 2];
            notes.push(format!(
                "the response is that of level {} of {}, {count} records",
                levels.len() / 2 + 1,
                levels.len()
            ));
            let response = middle.response.clone();
            (levels, response)
        } else {
            (Vec::new(), frequency::measure(&experiments, &settings)?)
        };
        let outputs = signals.split_off(self.inputs.len());
        let (plant, model) = match &self.plant {
            None => (None, self.fit(&response, &mut notes)),
            Some(file) => {
                if self.modes == 0 {
                    bail!(
                        "--plant {}: --modes 0 fits none; give the most that it may have",
                        file.display()
                    );
                }
                let source = plant::Source {
                    experiments: &experiments,
                    sample_time,
                    response: &response,
                    levels: &levels,
                    refine: self.refine,
                    inputs: &signals,
                    outputs: &outputs,
                    logs: &self.logs,
                };
                let (plant, choice) =
                    plant::fitted(&source, file, &self.fit_settings(), self.modes, &mut notes)?;
                (Some(plant), Some(choice))
            }
        };
        let levels = outputs.iter().enumerate().map(|(k, output)| {
            let coherence = || response.lines.iter().map(|line| line.coherence[k]);
            OutputLevels {
                name: output.name.clone(),
                levels: response.levels(k),
                least_coherence: coherence().fold(1.0, f64::min),
                mean_coherence: coherence().sum::<f64>() / response.lines.len().max(1) as f64,
            }
        });
        let levels: Vec<OutputLevels> = levels.collect();
        let edge = |line: Option<&frequency::Line>| line.map_or(0.0, |line| line.frequency);
        Ok(Measured {
            inputs: signals,
            levels,
            sample_time_s: sample_time,
            experiments: response.experiments,
            period_samples: response.period,
            periods: response.periods,
            lines: response.lines.len(),
            from_hz: edge(response.lines.first()),
            to_hz: edge(response.lines.last()),
            fit: model.as_ref().map(fit_of),
            plant,
            notes,
            written: self.out.clone(),
            response,
            outputs,
            model,
        })
    }

    /// The experiments by the rms of their inputs, from the least on: how many, and what they measure.
    fn levels(
        &self,
        experiments: &[Experiment],
        settings: &MeasureSettings,
    ) -> anyhow::Result<Vec<(usize, Level)>> {
        let size = |e: &Experiment| {
            plant::rms_of(std::slice::from_ref(e)).iter().map(|r| r * r).sum::<f64>().sqrt()
        };
        let mut sorted: Vec<(f64, &Experiment)> =
            experiments.iter().map(|e| (size(e), e)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let groups: Vec<&[(f64, &Experiment)]> =
            sorted.chunk_by(|a, b| b.0 <= SAME_LEVEL * a.0).collect();
        if groups.len() < 2 {
            bail!(
                "--softening needs records of two levels of excitation or more, whose inputs differ in rms by more \
                 than {:.0} %; the {} given have one",
                100.0 * (SAME_LEVEL - 1.0),
                experiments.len()
            );
        }
        let measured = groups.iter().map(|group| {
            let own: Vec<Experiment> = group.iter().map(|(_, e)| (*e).clone()).collect();
            let response = frequency::measure(&own, settings).with_context(|| {
                let names: Vec<&str> = own.iter().map(|e| e.name.as_str()).collect();
                format!("the level of {}", names.join("; "))
            })?;
            Ok((own.len(), Level { response, rms: plant::rms_of(&own) }))
        });
        measured.collect()
    }

    /// The records of all logs as experiments on one grid.
    fn experiments(&self, signals: &mut [Signal]) -> anyhow::Result<(Vec<Experiment>, f64)> {
        let mut experiments = Vec::new();
        let mut grid: Option<(f64, String)> = None;
        for path in &self.logs {
            let commands =
                signals.iter().take(self.inputs.len()).map(|signal| signal.name.as_str());
            let log = self.readings.held(self.options.read(path)?, commands);
            let columns = signals
                .iter_mut()
                .map(|signal| inputs::column(&log, &signal.name, &mut signal.unit))
                .collect::<anyhow::Result<Vec<_>>>()?;
            for record in log.records() {
                let name = format!("{}, record {}", path.display(), record.id);
                let period = log.sample_time(record, SampleTime::TOLERANCE)?.period;
                match &grid {
                    None => grid = Some((period, name.clone())),
                    Some((first, of)) if (period / first - 1.0).abs() > 1e-6 => bail!(
                        "{name} has a sample every {period} s, {of} every {first} s: all experiments need \
                         one sample time; resample one of them"
                    ),
                    Some(_) => {}
                }
                let first = record.rows.start + self.skipped(&log, record)?;
                let part = |values: &Vec<f64>| values[first..record.rows.end].to_vec();
                let mut all: Vec<Vec<f64>> = columns.iter().map(part).collect();
                let outputs = all.split_off(self.inputs.len());
                experiments.push(Experiment { name, inputs: all, outputs });
            }
        }
        let (period, _) = grid.context("the logs have no record")?;
        Ok((experiments, period))
    }

    /// Rows of a record that --skip leaves out.
    fn skipped(&self, log: &Log, record: &data::Record) -> anyhow::Result<usize> {
        let time = &log.time()[record.rows.clone()];
        let start = time.first().copied().unwrap_or_default();
        // A row that lies on the border up to rounding stays.
        let skipped = time.iter().take_while(|t| *t - start < self.skip * (1.0 - 1e-9)).count();
        if skipped == time.len() {
            bail!(
                "--skip {} leaves nothing of record {}, which is {} s long",
                self.skip,
                record.id,
                rounded(time.last().copied().unwrap_or_default() - start)
            );
        }
        Ok(skipped)
    }

    fn fit_settings(&self) -> RationalSettings {
        RationalSettings {
            single: self.lags,
            longest_delay: self.longest_delay,
            ..RationalSettings::default()
        }
    }

    /// A rational model, where one was asked for and can be had.
    fn fit(&self, response: &Response, notes: &mut Vec<String>) -> Option<Choice> {
        if self.modes == 0 {
            return None;
        }
        match frequency::choose(response, Domain::Continuous, &self.fit_settings(), self.modes) {
            Ok((mut tried, best)) => Some(tried.swap_remove(best).1),
            Err(error) => {
                notes.push(format!("no modes were fitted: {error}"));
                None
            }
        }
    }
}

fn fit_of(choice: &Choice) -> Fit {
    let gain = choice.model.response(0.0);
    Fit {
        modes: choice.model.modes(),
        delay_s: choice.model.delay,
        misfit: choice.misfit,
        static_gain: gain.row_iter().map(|row| row.iter().map(|g| g.re).collect()).collect(),
    }
}
