//! Results as pages: what each command shows, where it goes, and who opens it.

mod bench;
mod calibrate;
mod estimate;
mod frequency_response;
mod identify;
mod invert;
mod simulate;
mod system;
mod tune;

use std::path::Path;

use ::identify::frequency::Complex;
use diagnose::figures::unwrapped;
use report::{InputFile, Provenance};

pub(crate) use bench::{Rows, campaign, run as bench_run};
pub(crate) use calibrate::calibration;
pub(crate) use estimate::estimation;
pub(crate) use frequency_response::frequency_response;
pub(crate) use identify::{identification, picture, sections};
pub(crate) use invert::inversion;
pub(crate) use simulate::simulation;
pub(crate) use system::system;
pub(crate) use tune::tuning;

/// Provenance of this call: tool, version, command line, files.
pub(crate) fn provenance(files: &[(&str, &Path)]) -> anyhow::Result<Provenance> {
    let mut all = Provenance::new("piezoloop", crate::VERSION).command_line(std::env::args());
    for (role, path) in files {
        all = all.file(InputFile::read(*role, path)?);
    }
    Ok(all)
}

/// Magnitudes, and phases without jumps.
fn polar(values: &[Complex]) -> (Vec<f64>, Vec<f64>) {
    let phase = unwrapped(values.iter().map(|z| z.arg()).collect());
    (values.iter().map(|z| z.norm()).collect(), phase)
}

/// |1/(1 + L)| of an open loop L.
fn sensitivities(open: &[Complex]) -> Vec<f64> {
    open.iter().map(|l| 1.0 / (Complex::new(1.0, 0.0) + l).norm()).collect()
}

/// Root mean square of the finite values.
fn rms(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|x| x.is_finite());
    let (count, squares): (f64, f64) = finite.fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x * x));
    if count > 0.0 { (squares / count).sqrt() } else { f64::NAN }
}

/// Greatest absolute finite value.
fn greatest(values: &[f64]) -> f64 {
    values.iter().filter(|x| x.is_finite()).fold(0.0, |most, x| most.max(x.abs()))
}

/// Differences, value by value.
fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
