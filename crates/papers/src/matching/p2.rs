//! P2, piezo bimorph.

use model::System;

use super::{Figure, extremes, response, rig, rms, signal};
use crate::machines;

/// P2: range, resonance, and the Bouc–Wen model with the printed parameters beside the rig.
pub(super) fn figures() -> anyhow::Result<Vec<Figure>> {
    const RIG: &str = machines::P2;
    let mut system = rig(RIG)?;
    let mut all = Vec::new();
    for (name, paper, note) in [
        ("p2-train", 1.9, ""),
        ("p2-test-1", 2.8, "the signal is assumed: the paper shows it as a figure only"),
        ("p2-test-2", 1.9, "the signal is assumed: the paper shows it as a figure only"),
    ] {
        let (u, period) = signal(name, &[])?;
        let y = response(&mut system, 1, &u, period)?;
        let model = response(&mut rig("p2")?, 1, &u, period)?;
        let (min, max) = extremes(&y);
        if name == "p2-train" {
            all.push(Figure::new(RIG, "range, training signal", "um", 236.0, max - min).of_rig());
        }
        let start = y[0] - model[0];
        let error = rms(y.iter().zip(&model).map(|(y, m)| y - m - start));
        let what = format!("Bouc-Wen with the printed parameters, {name}, rms of range");
        let figure = Figure::new(RIG, what, "%", paper, 100.0 * error / (max - min));
        all.push(figure.note(note));
    }
    all.insert(1, Figure::new(RIG, "resonance", "Hz", 404.0, ringing(&mut system)?).of_rig());
    Ok(all)
}

/// The frequency at which a rig rings after a small jump, from crossings of its mean.
fn ringing(system: &mut System) -> anyhow::Result<f64> {
    const PERIOD: f64 = 1e-4;
    let u: Vec<f64> = (0..4000).map(|n| if n < 10 { 0.0 } else { 0.2 }).collect();
    let y = response(system, 1, &u, PERIOD)?;
    let tail = &y[200..2200];
    let mean = tail.iter().sum::<f64>() / tail.len() as f64;
    let crossings = tail.windows(2).filter(|w| (w[0] < mean) != (w[1] < mean)).count();
    Ok(0.5 * crossings as f64 / (tail.len() as f64 * PERIOD))
}
