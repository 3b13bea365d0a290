//! An LS-SVM over stop operators and the linear part behind it.
//!
//! ```text
//! y = D·H(u, stops of u),   stops as in P1, D a discrete transfer function
//! ```
//!
//! Widths and γ by the evidence. H and D in turn, stiff at first; or D together with a curve, where that errs less on the last third of
//! what is fitted. Where a selection or the rate is asked for: each input divided by its standard deviation, one σ² and γ by that
//! selection (five parts in simulation mode, where none is given), no linear part, as in P1.

use learned::features::{Features, StopOperators};

use learned::lssvm::Settings;

use super::super::{BOUNDS, Frame, Machine, Recipe, Run, Seek, Selection, Series, Widths, select};
use super::{FitContext, SAMPLES, Stage, failed, none};
use crate::error::Error;
use crate::settings::FeatureChoice;

/// Widths of a stiff machine, as parts of the command's range: stops, command; γ.
const STIFF: ([f64; 2], f64) = ([100.0, 1.0], 1e5);
/// Evaluations of that search, and most samples it looks at.
const SEARCH: (usize, usize) = (60, 700);

/// Most samples that a selection looks at.
const TRIED: usize = 700;

/// How many times what training in turn leaves of its own rows the other may leave of rows that it has not seen.
const HOPELESS: f64 = 3.0;

/// Learns from one of these scenes, which differ in what is taken for a delay; the number of that one is given, too.
pub(super) fn learn(
    scenes: &[FitContext<'_>],
    stage: &mut Stage<'_>,
) -> Result<(usize, Series, Settings), Error> {
    if let Some(last) = scenes.last()
        && (last.learning.selection.is_some() || last.learning.features == FeatureChoice::Rate)
    {
        stage(0, 1)?;
        let (series, settings) = selected(last)?;
        return Ok((scenes.len() - 1, series, settings));
    }
    let total = scenes.len() + 3;
    // Together with a curve: on the first two thirds, judged on the rest.
    let mut best: Option<(f64, usize)> = None;
    for (number, scene) in scenes.iter().enumerate().filter(|(_, scene)| scene.dynamic) {
        stage(number, total)?;
        let (some, rest) = scene.parts();
        // What cannot be solved exactly is no candidate.
        if let Ok(Some((series, _))) = together(scene, &some) {
            let error = series.error(&rest);
            if best.is_none_or(|(least, _)| error < least) {
                best = Some((error, number));
            }
        }
    }
    stage(scenes.len(), total)?;
    let (number, last) = (scenes.len() - 1, &scenes[scenes.len() - 1]);
    let (turned, settings) = in_turn(last, last.runs)?;
    // What errs several times what the other leaves of its own rows is not compared.
    let best = best.filter(|(error, _)| *error < HOPELESS * turned.error(last.runs));
    let Some((error, found)) = best else { return Ok((number, turned, settings)) };
    stage(scenes.len() + 1, total)?;
    let (some, rest) = last.parts();
    let other = in_turn(last, &some).map_or(f64::INFINITY, |(series, _)| series.error(&rest));
    stage(total - 1, total)?;
    let better =
        if error < other { together(&scenes[found], scenes[found].runs) } else { Ok(None) };
    Ok(match better.ok().flatten() {
        Some((series, settings)) => (found, series, settings),
        None => (number, turned, settings),
    })
}

/// One σ² and γ over stops, command and, where it is asked for, its rate.
fn selected(scene: &FitContext<'_>) -> Result<(Series, Settings), Error> {
    let pairs = scene.pairs();
    let mut stops = StopOperators::new(scene.stops, 1.0, scene.period);
    if scene.learning.features == FeatureChoice::Rate {
        stops = stops.rated(1.0);
    }
    let features = Features::StopOperators(stops);
    let frame = Frame::new(features, scene.command, scene.position, Recipe::Standardised, &pairs);
    let (selection, seek) =
        scene.learning.selection.unwrap_or((Selection::CrossValidation(5), Seek::Grid));
    let found = select(&frame, &pairs, selection, (seek, &BOUNDS), TRIED).map_err(failed)?;
    let machine = Machine::of_selected(frame, &pairs, found.settings, SAMPLES).map_err(failed)?;
    Ok((Series { machine, linear: none() }, found.settings))
}

fn together(scene: &FitContext<'_>, runs: &[Run<'_>]) -> Result<Option<(Series, Settings)>, Error> {
    let (frame, group) = framed(scene);
    let widths = Widths {
        group: &group,
        stiff: (&STIFF.0, STIFF.1),
        search: SEARCH,
        greatest: f64::INFINITY,
    };
    let sampled = (scene.bandwidth, scene.period);
    let found = Series::train_cascade(&frame, widths, runs, sampled, SAMPLES).map_err(failed)?;
    Ok(found.map(|(series, found)| (series, found.settings)))
}

fn in_turn(scene: &FitContext<'_>, runs: &[Run<'_>]) -> Result<(Series, Settings), Error> {
    let (frame, group) = framed(scene);
    let widths = Widths {
        group: &group,
        stiff: (&STIFF.0, STIFF.1),
        search: SEARCH,
        greatest: f64::INFINITY,
    };
    let first = (&scene.first, scene.orders());
    let found = Series::train_weighed(&frame, widths, runs, first, SAMPLES).map_err(failed)?;
    Ok((found.0, found.1.settings))
}

/// The frame, and the group of each input: stops, command.
fn framed(scene: &FitContext<'_>) -> (Frame, impl Fn(usize) -> usize + use<>) {
    let pairs = scene.pairs();
    let stops = StopOperators::new(scene.stops, 1.0, scene.period);
    let features = Features::StopOperators(stops);
    let frame = Frame::new(features, scene.command, scene.position, Recipe::Plain, &pairs);
    let count = scene.stops;
    (frame.on_a_line(&pairs), move |input| usize::from(input >= count))
}
