//! `piezoloop estimate`: parameters of any FMU or blueprint from measurements.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use cli::{PageOptions, Screen};
use cosim::{Drive, Driven, Fmu, Memory, Signals, Value};
use data::Log;
use identify::calibration::{Calibration, Tunable, calibrate};
use modeldescription::variable::Causality;

use super::simulate;
use crate::fmus::{self, Addresses, Isolation};
use crate::inputs::{self, LogOptions, Readings};
use crate::messages::MessageOptions;
use crate::pages;
use crate::results::estimate::{Estimated, Found};
use crate::window::Window;

mod asked;
mod preset;
mod tuned;

use asked::{Asked, Own, asked_of};
use preset::{write_fmu, write_set};
use tuned::{Series, Weights};

/// Estimates parameters of an FMU from measurements
///
/// Takes a co-simulation FMU of any vendor, a blueprint (.toml) or a rig. The logs' inputs drive the FMU, and the
/// parameters are fitted to the measured outputs by least squares. Reports 95 % intervals, correlations, and
/// parameters that the logs do not determine.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop estimate plant.fmu --log a.csv --log b.csv --tune 'mass=0.2' --tune 'damping=1,0.1..10' -o set.ssv\n  piezoloop estimate mirror.fmu --log a.csv --tune damping --initial 'tilt=0,-1..1' --fmu tuned.fmu\n  piezoloop estimate plant.toml --log a.csv --held-out c.csv --tune 'axis[1].mechanics.damping=0.05'"
)]
pub(crate) struct Estimate {
    /// The FMU, a blueprint or the name of a rig
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// A log with inputs and measured outputs (may be given several times)
    #[arg(long, value_name = "FILE", required = true)]
    log: Vec<PathBuf>,
    /// A log that is not fitted, only judged (may be given several times)
    #[arg(long, value_name = "FILE")]
    held_out: Vec<PathBuf>,
    /// A parameter to estimate, with start value and bounds (both optional), as in mass=0.2,0.1..0.5; the default is
    /// the FMU's start value (may be given several times)
    #[arg(long, value_name = "NAME[=START[,LOW..HIGH]]", required = true)]
    tune: Vec<String>,
    /// An initial value that is estimated separately for every record, such as the start of a state; for held-out
    /// logs it is fitted with the parameters fixed (may be given several times)
    #[arg(long, value_name = "NAME[=START[,LOW..HIGH]]")]
    initial: Vec<String>,
    /// Compare this output only (may be given several times) [default: all measured outputs]
    #[arg(long = "output", value_name = "NAME")]
    outputs: Vec<String>,
    /// A fixed start value, as in stiffness=2e5 (may be given several times)
    #[arg(long = "start", value_name = "NAME=VALUE")]
    fixed: Vec<String>,
    /// Number of starting points of the search: the given one, and others around it
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = crate::ranges::integers(1_u64, 1000))]
    starts: u64,
    #[command(flatten)]
    options: LogOptions,
    #[command(flatten)]
    readings: Readings,
    #[command(flatten)]
    window: Window,
    #[command(flatten)]
    isolation: Isolation,
    #[command(flatten)]
    messages: MessageOptions,
    /// Write the estimates as a parameter set (SSV), for `system --parameters` and other tools
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write an FMU that contains the original and starts with the estimates, whatever the importer sets
    #[arg(long, value_name = "FILE.fmu")]
    fmu: Option<PathBuf>,
    #[command(flatten)]
    page: PageOptions,
}

impl Estimate {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        self.page.can_write()?;
        let result = self.execute()?;
        let files: Vec<(&str, &Path)> =
            self.log.iter().chain(&self.held_out).map(|f| ("log", f.as_path())).collect();
        self.page.finish(screen, &result, || pages::estimation(&result, &files))
    }

    fn execute(&self) -> anyhow::Result<Estimated> {
        for (outs, endings) in [(&self.out, inputs::PARAMETERS), (&self.fmu, inputs::FMU)] {
            outs.iter().try_for_each(|out| cli::can_write_as(out, endings))?;
        }
        inputs::are_apart(("--log", &self.log), ("--held-out", &self.held_out))?;
        let mut opened = fmus::open_in(&self.model, self.isolation.worker()?.as_ref())?;
        simulate::configure(self.fixed.iter().map(String::as_str), &mut opened.fmu)?;
        let fmu = &opened.fmu;
        let addresses = Addresses::of(fmu);
        let (mut asked, mut initial) = (Vec::new(), Vec::new());
        asked_of("--tune", &self.tune, fmu, &addresses, &mut asked)?;
        asked_of("--initial", &self.initial, fmu, &addresses, &mut initial)?;
        if let Some(twice) = initial.iter().find(|i| asked.iter().any(|a| a.name == i.name)) {
            bail!("`{}` is both a parameter of --tune and a value of --initial", twice.name);
        }
        let mut notes = Vec::new();
        let read = |file: &PathBuf| {
            let log = self.options.read(file)?;
            let map = addresses.columns(&self.options.names()?, &log)?;
            Ok(self.readings.held_for(fmu, &map, log))
        };
        let logs = self.log.iter().chain(&self.held_out).map(read);
        let logs: Vec<Log> = logs.collect::<anyhow::Result<_>>()?;
        // Its file may not be one of what was read.
        let ear = self.messages.ear()?;
        let tables: Vec<Vec<Signals<'_>>> = logs.iter().map(simulate::signals).collect();
        let mut series = Vec::new();
        for (number, (log, table)) in logs.iter().zip(&tables).enumerate() {
            let compared = self.compared(fmu, &addresses, log)?;
            let mut parameters = self.fixed(fmu, &addresses)?;
            let at = |a: &Asked| (a.name.clone(), Value::Real(a.tunable.start));
            parameters.extend(asked.iter().chain(&initial).map(at));
            let drive = Drive {
                map: addresses.columns(&self.options.names()?, log)?,
                parameters,
                record: compared.iter().map(|(output, ..)| output.clone()).collect(),
                ..Drive::default()
            };
            let slave = fmu.instantiate(opened.name.clone(), &ear.options(&opened.name))?;
            let driven = Driven::new(slave, table, &drive)?;
            let held_out = number >= self.log.len();
            series.push(Series::new(driven, log, compared, &self.window, held_out, &mut notes)?);
        }
        let own = self.own(&initial, &logs);
        let (own, held): (Vec<Asked>, Vec<Asked>) =
            own.into_iter().partition(|a| a.own.as_ref().is_some_and(|o| o.log < self.log.len()));
        asked.extend(own);
        let (used, judged) = series.split_at_mut(self.log.len());
        // Tells now, in words of the FMU, if it does not run at all.
        let own: Vec<f64> = asked.iter().map(|a| a.tunable.start).collect();
        let mut before = Vec::new();
        for (number, one) in used.iter_mut().chain(judged.iter_mut()).enumerate() {
            before.push(one.simulate(number, &asked, &own)?);
        }
        let mut weights = Weights::by_range(used);
        let tunables: Vec<Tunable> = asked.iter().map(|a| a.tunable).collect();
        let starts = tuned::starts(&tunables, self.starts as usize);
        let mut found = search(used, &asked, &tunables, &starts, &weights)?;
        if weights.len() > 1 {
            // Each output counts by what it leaves.
            let last = at_values(used, &asked, &found.values)?;
            weights = Weights::by_rest(used, &last);
            let again: Vec<Tunable> = tunables
                .iter()
                .zip(&found.values)
                .map(|(t, v)| Tunable { start: *v, ..*t })
                .collect();
            let first = found;
            found = search(used, &asked, &again, &[], &weights)?;
            found.starts = first.starts;
            found.evaluations += first.evaluations;
            found.failures += first.failures;
        }
        let mut fits = Vec::new();
        for (number, one) in used.iter_mut().chain(judged.iter_mut()).enumerate() {
            let (mut of, mut values) = (asked.clone(), found.values.clone());
            if number >= self.log.len() {
                // Its own initial values, with the parameters held.
                let mine: Vec<Asked> = held
                    .iter()
                    .filter(|a| a.own.as_ref().is_some_and(|own| own.log == number))
                    .cloned()
                    .collect();
                if !mine.is_empty() {
                    let began = initial_values(one, number, (&of, &values), &mine, &weights)?;
                    of.extend(mine);
                    values.extend(began);
                }
            }
            let after = one.simulate(number, &of, &values)?;
            let file = self.log.iter().chain(&self.held_out).nth(number);
            fits.extend(one.fits(file.cloned().unwrap_or_default(), &before[number], &after)?);
        }
        let set =
            self.out.as_deref().map(|out| write_set(out, &asked, &found.values)).transpose()?;
        let mut fmu_notes = Vec::new();
        if let Some(file) = &self.fmu {
            let fixed = self.fixed(fmu, &addresses)?;
            fmu_notes = write_fmu(file, &opened, &asked, &found.values, &fixed)?;
        }
        let residuals = used.iter().map(|one| one.lengths().iter().sum::<usize>()).sum();
        drop(series);
        notes.extend(self.remarks(&asked, &found));
        notes.extend(fmu_notes);
        if !held.is_empty() {
            notes.push(
                "held-out logs were judged with initial values that were fitted to them".to_owned(),
            );
        }
        notes.extend(ear.notes());
        let runs = found.evaluations * self.log.len();
        Ok(Estimated {
            model: opened.name.clone(),
            undetermined: found
                .undetermined
                .iter()
                .map(|group| group.iter().map(|k| asked[*k].label()).collect())
                .collect(),
            parameters: parameters(asked, &found),
            correlation: found.correlation,
            fits,
            weights: weights.0,
            squares: found.squares,
            residuals,
            starts: found.starts,
            runs,
            failed_runs: found.failures,
            set,
            fmu: self.fmu.clone(),
            messages: ear.received(),
            notes,
        })
    }

    /// Each initial value once for each record.
    fn own(&self, initial: &[Asked], logs: &[Log]) -> Vec<Asked> {
        let files: Vec<&PathBuf> = self.log.iter().chain(&self.held_out).collect();
        let mut all = Vec::new();
        for (log, read) in logs.iter().enumerate() {
            let file = files.get(log).map(|file| file.display().to_string()).unwrap_or_default();
            for (record, known) in read.records().iter().enumerate() {
                let label = match read.records().len() {
                    1 => file.clone(),
                    _ => format!("{file}, record {}", known.id),
                };
                let own = |label: &String| Some(Own { log, record, label: label.clone() });
                all.extend(initial.iter().map(|a| Asked { own: own(&label), ..a.clone() }));
            }
        }
        all
    }

    fn fixed(&self, fmu: &Fmu, addresses: &Addresses) -> anyhow::Result<Vec<(String, Value)>> {
        simulate::starts(self.fixed.iter().map(String::as_str), addresses, fmu)
    }

    /// The outputs that this log measures: output, column, unit.
    fn compared(
        &self,
        fmu: &Fmu,
        addresses: &Addresses,
        log: &Log,
    ) -> anyhow::Result<Vec<(String, String, String)>> {
        let names = self.options.names()?;
        let wanted: Vec<String> =
            self.outputs.iter().map(|name| addresses.variable(name)).collect();
        let outputs = fmu.names(Causality::Output);
        if let Some(unknown) = wanted.iter().find(|name| !outputs.contains(name)) {
            bail!(
                "--output {unknown}: the FMU has no such output; it has {}",
                simulate::list(&outputs)
            );
        }
        let mut compared = Vec::new();
        for output in outputs.iter().filter(|o| wanted.is_empty() || wanted.contains(o)) {
            let Some(column) = addresses.measured_column(output, &names, log) else { continue };
            let variable = fmu.variable(output)?;
            let unit = fmu.description().properties(&variable).unit.unwrap_or_default();
            compared.push((output.clone(), column, unit));
        }
        if compared.is_empty() {
            bail!(
                "{}: no column measures an output of the FMU, which are {}; say which does, as in --map {}=COLUMN",
                log.origin(),
                simulate::list(&outputs),
                outputs.first().map(String::as_str).unwrap_or("y")
            );
        }
        Ok(compared)
    }

    fn remarks(&self, asked: &[Asked], found: &Calibration) -> Vec<String> {
        let mut notes = Vec::new();
        for group in &found.undetermined {
            let names: Vec<String> = group.iter().map(|k| asked[*k].label()).collect();
            notes.push(match names.as_slice() {
                [one] => format!("the logs do not determine `{one}`: the compared outputs do not depend on it"),
                _ => format!("the logs determine {} only together: fix one of them with --start, or drive the FMU otherwise", simulate::list(&names)),
            });
        }
        for (k, asked) in asked.iter().enumerate() {
            if found.at_bound[k] {
                notes.push(format!(
                    "`{}` ends at its bound {}: it has no interval there",
                    asked.label(),
                    found.values[k]
                ));
            } else if found.half_width[k]
                .is_some_and(|half| half > asked.tunable.scale.max(found.values[k].abs()))
            {
                notes.push(format!(
                    "the logs hardly determine `{}`: its interval is wider than its value",
                    asked.label()
                ));
            }
        }
        if found.inflation > 1.0 {
            notes.push(format!(
                "the residuals are correlated, as if the model lacked an effect: the intervals are {:.2} times as wide as \
                 for white noise",
                found.inflation.sqrt()
            ));
        }
        if found.failures > 0 {
            notes.push(format!(
                "the FMU failed in {} of {} runs of the search, which went round them",
                found.failures, found.evaluations
            ));
        }
        let best = found.starts.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let elsewhere = found
            .starts
            .iter()
            .filter(|s| s.is_none_or(|s| s > best * (1.0 + 1e-3) + 1e-12))
            .count();
        if elsewhere > 0 {
            notes.push(format!(
                "{elsewhere} of {} starts led to a worse place; --starts N tries more",
                found.starts.len()
            ));
        }
        notes
    }
}

fn at_values(
    used: &mut [Series<'_>],
    asked: &[Asked],
    values: &[f64],
) -> anyhow::Result<Vec<Memory>> {
    let mut runs = Vec::new();
    for (number, one) in used.iter_mut().enumerate() {
        runs.push(one.simulate(number, asked, values)?);
    }
    Ok(runs)
}

/// The initial values with which a held-out log fits best, the shared values held.
fn initial_values(
    one: &mut Series<'_>,
    number: usize,
    (asked, values): (&[Asked], &[f64]),
    initial: &[Asked],
    weights: &Weights,
) -> anyhow::Result<Vec<f64>> {
    let all = [asked, initial].concat();
    let tunables: Vec<Tunable> = initial.iter().map(|a| a.tunable).collect();
    let lengths = one.lengths();
    let residuals = |own: &[f64]| {
        let run = one.simulate(number, &all, &[values, own].concat()).ok()?;
        one.residuals(&run, weights)
    };
    Ok(calibrate(&tunables, &[], &lengths, residuals)?.values)
}

fn search(
    used: &mut [Series<'_>],
    asked: &[Asked],
    tunables: &[Tunable],
    starts: &[Vec<f64>],
    weights: &Weights,
) -> anyhow::Result<Calibration> {
    let lengths: Vec<usize> = used.iter().flat_map(Series::lengths).collect();
    let residuals = |values: &[f64]| {
        let runs = at_values(used, asked, values).ok()?;
        let parts = used.iter().zip(&runs).map(|(one, run)| one.residuals(run, weights));
        Some(parts.collect::<Option<Vec<_>>>()?.concat())
    };
    Ok(calibrate(tunables, starts, &lengths, residuals)?)
}

fn parameters(asked: Vec<Asked>, found: &Calibration) -> Vec<Found> {
    let of = |(k, asked): (usize, Asked)| {
        let (value, half) = (found.values[k], found.half_width[k]);
        Found {
            name: asked.name,
            of: asked.own.map(|own| own.label),
            unit: asked.unit,
            start: asked.tunable.start,
            value,
            sigma: found.sigma[k],
            interval: half.map(|half| [value - half, value + half]),
            at_bound: found.at_bound[k],
        }
    };
    asked.into_iter().enumerate().map(of).collect()
}
