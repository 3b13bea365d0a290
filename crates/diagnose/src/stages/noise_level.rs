//! The size of the noise, where it is not known, and how far it is known.

use crate::candidate::Found;
use crate::data_set::DataSet;
use crate::noise::{self, Shape};
use crate::task::Task;
use crate::thresholds::noise::Thresholds;

/// Ratio and shape of the noise in what the effects leave, where the noise was estimated from residuals that held the
/// gap and is clearly less.
pub(super) fn quieter(task: &Task, found: &Found) -> Option<(f64, Shape)> {
    let is_estimated = task.noise.source == "second differences";
    if !is_estimated || found.last.picks.is_empty() {
        return None;
    }
    let estimate = estimated(&task.data, &found.last.judged.residual);
    Some(estimate).filter(|(ratio, _)| *ratio > 0.0 && *ratio < Thresholds::QUIETER)
}

/// The noise over what residuals are given in, and its shape, from the residuals themselves.
fn estimated(data: &DataSet, residual: &[f64]) -> (f64, Shape) {
    let sample = data.sample_time;
    let (low, high) = (1.0 / data.longest(), 0.5 / sample);
    let rows = || data.records.iter().map(|r| r.rows.clone());
    let finest = noise::fourth_differences(residual, rows()).unwrap_or(1.0).min(1.0);
    let corner = noise::corner_under(residual, rows(), finest * finest, sample);
    let colour = noise::coloured(corner, low, high);
    (finest * colour.sqrt(), Shape { white: 1.0 / colour, corner })
}

/// Settles the size of the noise in `task` and gives its shape and the part of its power up to which nothing is left:
/// the less is known about the noise, the larger that part.
pub(super) fn settle_noise(task: &mut Task, residual: &[f64]) -> (Shape, f64) {
    let data = &task.data;
    let sample = data.sample_time;
    let (low, high) = (1.0 / data.longest(), 0.5 / sample);
    let rows = || data.records.iter().map(|r| r.rows.clone());
    // In standard deviations of what was taken for the noise so far.
    let finest = noise::fourth_differences(residual, rows()).unwrap_or(1.0);
    let noise = &mut task.noise;
    let (shape, sure) = match (noise.source.as_str(), task.rest_corner) {
        ("steps of the reading", _) => (Shape::WHITE, Thresholds::ADEQUATE_ESTIMATED),
        (_, Some(corner)) => {
            let white = 1.0 / noise::coloured(corner, low, high);
            (Shape { white, corner }, Thresholds::ADEQUATE_AT_REST)
        }
        ("given", None) => {
            (Shape::with_white(finest * finest, low, high), Thresholds::ADEQUATE_GIVEN)
        }
        _ => {
            let (ratio, shape) = estimated(data, residual);
            noise.sigma *= ratio;
            (shape, Thresholds::ADEQUATE_ESTIMATED)
        }
    };
    noise.corner = Some(shape.corner).filter(|c| *c > 0.0);
    (shape, sure)
}
