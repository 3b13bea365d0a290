//! An LS-SVM over stop operators and the linear part behind it.
//!
//! ```text
//! y = D·H(u, stops of u),   stops as in P1, D a discrete transfer function
//! ```
//!
//! Widths and γ by the evidence, H and D in turn, stiff at first.

use learned::features::{Features, Stops};

use super::super::{Frame, Recipe, Series, Widths};
use super::{SAMPLES, Scene, Stage, failed};
use crate::error::Error;

/// Widths of a stiff machine, as parts of the command's range: stops, command; γ.
const STIFF: ([f64; 2], f64) = ([100.0, 1.0], 1e5);
/// Evaluations of that search, and most samples it looks at.
const SEARCH: (usize, usize) = (60, 700);

pub(super) fn learn(scene: &Scene<'_>, stage: &mut Stage<'_>) -> Result<Series, Error> {
    stage(0, 3)?;
    let pairs = scene.pairs();
    let stops = Stops {
        count: scene.stops,
        range: 1.0,
        period: scene.period,
        rate_scale: 1e12,
        projection: Vec::new(),
    };
    let features = Features::Stops(stops);
    let frame = Frame::new(features, scene.command, scene.position, Recipe::Plain, &pairs);
    let frame = frame.on_a_line(&pairs);
    let group = |input: usize| usize::from(input >= scene.stops);
    let widths = Widths { group: &group, stiff: (&STIFF.0, STIFF.1), search: SEARCH };
    stage(1, 3)?;
    let (orders, first) = (scene.orders(), &scene.first);
    let (series, _) = Series::train_weighed(&frame, widths, scene.runs, (first, orders), SAMPLES)
        .map_err(failed)?;
    stage(2, 3)?;
    Ok(series)
}
