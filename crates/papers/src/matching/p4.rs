//! P4, elliptical vibration cutting device.

use super::baseline::{Baseline, error};
use super::{Figure, Response, extremes, response, rig, signal};
use crate::machines;

const RIG: &str = machines::P4;
/// P4: stroke and loop width of the third 1 Hz loop of 0 to 120 V, and the static model fitted at 1 Hz.
pub(super) fn figures() -> anyhow::Result<Vec<Figure>> {
    let mut all = strokes_and_widths(RIG)?;
    let thresholds: Vec<f64> = (0..10).map(|i| 6.0 * f64::from(i)).collect();
    let printed = [(1, "Y", [0.0881, 0.0991, 0.1075]), (2, "Z", [0.1432, 0.1406, 0.1513])];
    for (axis, name, paper) in printed {
        let slow = loops(axis, "1")?;
        let model =
            Baseline { method: None, thresholds: thresholds.clone(), levels: 2, dynamic: false };
        let model = model.fit(&[&slow])?;
        for (frequency, paper) in ["1", "10", "100"].into_iter().zip(paper) {
            let what = format!("{name}: static model of 1 Hz at {frequency} Hz, rms");
            all.push(Figure::new(RIG, what, "um", paper, error(&model, &loops(axis, frequency)?)?));
        }
    }
    Ok(all)
}

fn strokes_and_widths(name: &'static str) -> anyhow::Result<Vec<Figure>> {
    let mut system = rig(name)?;
    let mut all = Vec::new();
    for (axis, of, stroke, width) in [(1, "Y", 5.53, 15.4), (2, "Z", 8.47, 9.3)] {
        let (u, period) = signal("p4-loop-1hz", &[])?;
        let y = response(&mut system, axis, &u, period)?;
        // The last of three periods: the first starts from the virgin curve.
        let last = 2 * u.len() / 3;
        let (u, y) = (&u[last..], &y[last..]);
        let (min, max) = extremes(y);
        let what = format!("{of}: stroke, 0 to 120 V at 1 Hz");
        all.push(Figure::new(name, what, "um", stroke, max - min).of_rig());
        let what = format!("{of}: greatest width of the loop");
        all.push(
            Figure::new(name, what, "%", width, 100.0 * loop_width(u, y) / (max - min)).of_rig(),
        );
    }
    Ok(all)
}

/// Loops of 0 to 120 V at a frequency in Hz.
fn loops(axis: usize, frequency: &str) -> anyhow::Result<Response> {
    let (command, period) = signal(&format!("p4-loop-{frequency}hz"), &[])?;
    let mut held = command.clone();
    held.push(command.last().copied().unwrap_or(0.0));
    let position = response(&mut rig(RIG)?, axis, &held, period)?;
    Ok(Response { command, position, period })
}

/// The greatest difference between the falling and the rising branch of one period of a loop.
fn loop_width(u: &[f64], y: &[f64]) -> f64 {
    let top = (0..u.len()).max_by(|a, b| u[*a].total_cmp(&u[*b])).unwrap_or(0);
    let rising = |x: f64| {
        let at = u[..=top].partition_point(|u| *u < x).min(top);
        let (left, right) = (at.saturating_sub(1), at);
        let step = u[right] - u[left];
        let part = if step > 0.0 { (x - u[left]) / step } else { 0.0 };
        y[left] + part * (y[right] - y[left])
    };
    (top..u.len()).map(|n| (y[n] - rising(u[n])).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_s_width_is_the_distance_of_its_branches() {
        let u = [0.0, 1.0, 2.0, 1.0, 0.0];
        assert_eq!(loop_width(&u, &[0.0, 0.5, 2.0, 1.5, 0.0]), 1.0);
    }
}
