//! P0, laser beam pointing.

use identify::learned::{Frame, Machine, Recipe, Span, rms_difference};
use learned::features::{Features, Narx};
use learned::lssvm::Settings;

use super::{Figure, Response, driven, extremes, response, rest, rig, signal};
use crate::machines;

const RIG: &str = machines::P0;

/// P0: the greatest |u/150 V − θ| on the training signal, axis by axis, and the ranges on the PSDs.
pub(super) fn figures() -> anyhow::Result<Vec<Figure>> {
    let mut system = rig(RIG)?;
    let (u, period) = signal("p0-train-h", &[])?;
    let mut all = Vec::new();
    for axis in 1..=4 {
        let d = response(&mut system, axis, &u, period)?;
        let (min, max) = extremes(&d);
        let rising = d[d.len() / 20] > d[0];
        let angle = |d: f64| if rising { (d - min) / (max - min) } else { (max - d) / (max - min) };
        let error = u.iter().zip(&d).map(|(u, d)| (u / 150.0 - angle(*d)).abs());
        let error = 100.0 * error.fold(0.0, f64::max);
        let what = format!("axis {axis}: greatest |u − θ|, training signal H");
        let figure = Figure::new(RIG, what, "%", 19.6, error);
        all.push(if axis == 1 { figure } else { figure.note("the paper tells it of axis 1") });
    }
    system.reset();
    for (psd, paper, axes) in [("PSD 1", 720.0, [1, 2]), ("PSD 2", 495.0, [3, 4])] {
        let mut span = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        for corner in 0..16_u32 {
            let level = |axis: u32| if corner >> axis & 1 == 1 { 150.0 } else { 0.0 };
            let commands: Vec<f64> = (0..4).map(level).collect();
            let p = rest(&mut system, &commands)?;
            for (span, axis) in span.iter_mut().zip(axes) {
                let p: f64 = p[axis - 1];
                *span = (span.0.min(p), span.1.max(p));
            }
        }
        let range = (span[0].1 - span[0].0).hypot(span[1].1 - span[1].0);
        all.push(
            Figure::new(RIG, format!("range on {psd}, diagonal"), "um", paper, range).of_rig(),
        );
    }
    let what = "LS-SVM without D, frequency-varying signal";
    all.push(Figure::new(RIG, what, "%", 2.25, narx()?));
    Ok(all)
}

/// Rms in simulation of the paper's LS-SVM (N_h = 2, σ² = 2, γ = 10⁴), trained on signal H, on the
/// frequency-varying signal, in percent of the range of H.
fn narx() -> anyhow::Result<f64> {
    let of = |name: &str| driven(RIG, name, &[], 1.0);
    let (h, d) = (of("p0-train-h")?, of("p0-train-d")?);
    let rising = h.position[h.position.len() / 20] > h.position[0];
    let (min, max) = extremes(&h.position);
    let angle = |d: &f64| if rising { (d - min) / (max - min) } else { (max - d) / (max - min) };
    let scaled = |run: &Response| -> [Vec<f64>; 2] {
        [run.command.iter().map(|u| u / 150.0).collect(), run.after().iter().map(angle).collect()]
    };
    let [u, theta] = scaled(&h);
    let pairs = [(&u[..], &theta[..])];
    let narx = Features::Narx(Narx { commands: 2, outputs: 2 });
    let frame = Frame::new(narx, Span::UNIT, Span::UNIT, Recipe::Plain, &pairs);
    let (machine, _) = Machine::train(frame, &pairs, Settings { gamma: 1e4, sigma2: 2.0 })?;
    let [u, theta] = scaled(&d);
    Ok(100.0 * rms_difference(&machine.simulate(&u, angle(&d.position[0])), &theta))
}
