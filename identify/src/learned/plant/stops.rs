//! An LS-SVM over stop operators and the linear part behind it.
//!
//! ```text
//! y = D·H(u, stops of u),   stops as in P1, D a discrete transfer function
//! ```
//!
//! Widths and γ by the evidence, H and D in turn.

use learned::features::{Features, Stops};

use super::super::series::rows;
use super::super::{Frame, Recipe, Series, weigh_samples};
use super::{Scene, Stage, failed};
use crate::error::Error;

/// Where the search for widths begins, as parts of the command's range: stops, command; γ.
const START: ([f64; 2], f64) = ([10.0, 0.3], 1e4);
/// Evaluations of that search, and most samples it looks at.
const SEARCH: (usize, usize) = (60, 700);
const ROUNDS: usize = 60;

pub(super) fn learn(scene: &Scene<'_>, stage: &mut Stage<'_>) -> Result<Series, Error> {
    stage(0, 3)?;
    let pairs = scene.pairs();
    let stops = Stops { count: scene.stops, range: 1.0, period: scene.period, rate_scale: 1e12 };
    let features = Features::Stops(stops);
    let frame = Frame::new(features, scene.command, scene.position, Recipe::Plain, &pairs);
    let samples = frame.samples(&pairs).map_err(failed)?.subset(&rows(scene.runs, usize::MAX));
    let group = |input: usize| usize::from(input >= scene.stops);
    let found = weigh_samples(&frame, &samples, &group, (&START.0, START.1), SEARCH);
    stage(1, 3)?;
    let series = scene.in_turn(&found.frame, found.settings, ROUNDS)?;
    stage(2, 3)?;
    Ok(series)
}
