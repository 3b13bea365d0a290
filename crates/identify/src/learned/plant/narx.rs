//! An LS-SVM over past commands and its own past outputs, and the linear part behind it.
//!
//! ```text
//! h(t) = f(u(t) … u(t−N), h(t−1) … h(t−N)),   y = D·h
//! ```
//!
//! N, σ² and γ are those of least error in simulation mode, the own outputs fed back, on the last third of what is
//! fitted by a machine that was trained on the rest, or by the selection that was asked for.
//!
//! Source: laser beam pointing with LS-SVM models of four piezo axes, eqs. (1)-(8), (11), (12).

use learned::features::{Features, Narx};
use learned::lssvm::Settings;

use super::super::series::rows;
use super::super::{BOUNDS, Frame, Machine, Recipe, Series, select};
use super::{FitContext, Stage, failed, none};
use crate::error::Error;

/// Numbers of past commands and outputs.
const PAST: [usize; 4] = [1, 2, 3, 5];
const SIGMA2: [f64; 4] = [0.5, 2.0, 8.0, 32.0];
const GAMMA: [f64; 4] = [1e2, 1e4, 1e6, 1e8];
/// Most samples of a machine that is tried.
const TRIED: usize = 600;
const ROUNDS: usize = 12;

pub(super) fn learn(
    scene: &FitContext<'_>,
    stage: &mut Stage<'_>,
) -> Result<(Series, Settings), Error> {
    let pairs = scene.pairs();
    let (some, rest) = scene.parts();
    let mut best: Option<(f64, Frame, Settings)> = None;
    let total = PAST.len() * SIGMA2.len() + 1;
    for (k, past) in PAST.into_iter().enumerate() {
        let features = Features::Narx(Narx { commands: past, outputs: past });
        let frame = Frame::new(features, scene.command, scene.position, Recipe::Plain, &pairs);
        let early: Vec<_> = some.iter().map(|run| (run.command, run.position)).collect();
        let samples = frame.samples(&early).map_err(failed)?.subset(&rows(&some, TRIED));
        if let Some((selection, seek)) = scene.learning.selection {
            stage(k * SIGMA2.len(), total)?;
            let found =
                select(&frame, &pairs, selection, (seek, &BOUNDS), TRIED).map_err(failed)?;
            if best.as_ref().is_none_or(|(least, ..)| found.error < *least) {
                best = Some((found.error, frame.clone(), found.settings));
            }
            continue;
        }
        for (j, sigma2) in SIGMA2.into_iter().enumerate() {
            stage(k * SIGMA2.len() + j, total)?;
            for gamma in GAMMA {
                let settings = Settings { gamma, sigma2 };
                // What cannot be solved exactly is no candidate.
                let Ok((machine, _)) = Machine::train_on(frame.clone(), &samples, settings) else {
                    continue;
                };
                let error = Series { machine, linear: none() }.error(&rest);
                if best.as_ref().is_none_or(|(least, ..)| error < *least) {
                    best = Some((error, frame.clone(), settings));
                }
            }
        }
    }
    stage(total - 1, total)?;
    let runaway = || {
        Error::Learned {
        message: "fed back, the outputs of every machine that was tried run away in simulation; resample \
                  the log to fewer samples a wave, or take --model lssvm-stops"
            .to_owned(),
    }
    };
    let (_, frame, settings) = best.filter(|(error, ..)| error.is_finite()).ok_or_else(runaway)?;
    let series = scene.in_turn(&frame, settings, ROUNDS)?;
    let error = series.error(scene.runs);
    let span = scene.position.high - scene.position.low;
    if error < span { Ok((series, settings)) } else { Err(runaway()) }
}
