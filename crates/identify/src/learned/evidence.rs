//! Widths of groups of inputs, and the weight of the errors, by the evidence of the data.
//!
//! ```text
//! ln p(y) = −½ n ln(yᵀC⁻¹y/n) − ½ ln|C| + const,   C = k + I/γ
//! ```
//!
//! The scale of the process is at its optimum. A width for the command and another for all operators of a
//! hysteresis: a wide one makes the machine linear in its inputs, as the superposition of operators
//! wants it, and then it holds for loops that the records do not show.
//!
//! Reference: J. Suykens et al., Least Squares Support Vector Machines, World Scientific 2002,
//! chapter 4; C. Rasmussen, C. Williams, Gaussian Processes for Machine Learning, MIT Press 2006.

use learned::gp::{Hyperparameters, likelihood};
use learned::lssvm::{Samples, Settings};
use learned::tune::{Simplex, nelder_mead};

use super::Frame;

/// What the evidence chose.
#[derive(Clone, Debug, PartialEq)]
pub struct EvidenceWeighted {
    /// The frame with these widths.
    pub frame: Frame,
    /// γ, and σ² = 1 for the widths of the frame.
    pub settings: Settings,
    /// Factor of each group of inputs.
    pub factors: Vec<f64>,
    /// Evaluations of the evidence behind the coarse grid.
    pub evaluations: usize,
}

/// Steps of the coarse grid, as factors: of widths, and of γ.
const COARSE: (f64, f64) = (4.0, 10.0);

/// Seeks the widths of groups of inputs and γ from `start`: a factor on the frame's widths for each
/// group, and γ, which stays below `greatest`. `group` is the group of an input. Every k-th sample, at most `most`,
/// is looked at.
///
/// # Errors
/// [`learned::Error`] where samples are too few or not finite.
pub fn weigh(
    frame: &Frame,
    records: &[(&[f64], &[f64])],
    group: &dyn Fn(usize) -> usize,
    (start, gamma): (&[f64], f64),
    (evaluations, most): (usize, usize),
    greatest: f64,
) -> Result<EvidenceWeighted, learned::Error> {
    let samples = frame.samples(records)?;
    Ok(weigh_samples(frame, &samples, group, (start, gamma), (evaluations, most), greatest))
}

/// Where γ is larger, as long records with little noise ask for, the kernel matrix of a training on thousands of samples
/// cannot be solved exactly.
pub const GREATEST_GAMMA: f64 = 3e8;

/// Seeks the widths and γ on samples of the frame, by the rules of [`weigh`].
#[must_use]
pub fn weigh_samples(
    frame: &Frame,
    samples: &Samples,
    group: &dyn Fn(usize) -> usize,
    (start, gamma): (&[f64], f64),
    (evaluations, most): (usize, usize),
    greatest: f64,
) -> EvidenceWeighted {
    let few = samples.subset(&samples.rows_at_most(most.max(2)));
    // ln of the factors within 1000, of γ within 10⁶.
    let middle: Vec<f64> = start.iter().chain([&gamma]).map(|x| x.ln()).collect();
    let reach = |k: usize| if k < start.len() { 1e3_f64.ln() } else { 1e6_f64.ln() };
    let mut bounds: Vec<(f64, f64)> =
        middle.iter().enumerate().map(|(k, x)| (x - reach(k), x + reach(k))).collect();
    if let Some((low, high)) = bounds.last_mut() {
        *high = high.min(greatest.ln()).max(*low);
    }
    let mut lack = |p: &[f64]| evidence(&few, group, p).map_or(f64::INFINITY, |value| -value);
    let simplex = Simplex { edge: 0.04, evaluations, tolerance: 1e-6 };
    // The evidence has more than one summit: a coarse grid about the start says where to go up.
    let steps = [0.0, -1.0, 1.0];
    let grid = (0..3_usize.pow(middle.len() as u32)).map(|number| {
        let at = |(k, x): (usize, &f64)| {
            let step = steps[number / 3_usize.pow(k as u32) % 3];
            x + step * if k < start.len() { COARSE.0 } else { COARSE.1 }.ln()
        };
        middle.iter().enumerate().map(at).collect::<Vec<f64>>()
    });
    let summit = grid
        .map(|point| (lack(&point), point))
        .fold((f64::INFINITY, middle.clone()), |a, b| if b.0 < a.0 { b } else { a });
    let best = nelder_mead(&bounds, &summit.1, simplex, &mut lack, &mut |_, _| true);
    let factors: Vec<f64> = best.point[..start.len()].iter().map(|x| x.exp()).collect();
    let chosen = frame.stretched(group, &factors);
    let gamma = best.point.last().map_or(gamma, |x| x.exp());
    let settings = Settings { gamma, sigma2: 1.0 };
    EvidenceWeighted { frame: chosen, settings, factors, evaluations: best.evaluations }
}

/// The evidence at ln of the factors and of γ, up to a constant.
fn evidence(samples: &Samples, group: &dyn Fn(usize) -> usize, p: &[f64]) -> Option<f64> {
    let (gamma, factors) = p.split_last()?;
    // The kernel of a process is exp(−½ d²/l²).
    let length = |k: usize| {
        factors.get(group(k)).map_or(1.0, |x| x.exp()) * core::f64::consts::FRAC_1_SQRT_2
    };
    let parameters = Hyperparameters {
        signal: 1.0,
        noise: (-0.5 * gamma).exp(),
        lengths: (0..samples.dimension()).map(length).collect(),
    };
    let found = likelihood(samples, &parameters).ok()?;
    let n = samples.count() as f64;
    // Both derivatives together are that by the scale of all of C: yᵀC⁻¹y − n.
    let fit = found.gradient[0] + found.gradient[1] + n;
    let value = found.value + 0.5 * fit - 0.5 * n * (fit / n).ln();
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use components::hysteresis::play::Plays;
    use learned::features::{Features, StopOperators};

    use super::super::{Machine, Recipe, Span};
    use super::*;

    #[test]
    fn what_is_linear_gets_a_wide_kernel_and_holds_beyond_the_record() {
        // Plays behind a curved gain; the test reverses where no record of the training did.
        let features = StopOperators::new(8, 9.0, 1e-2);
        let truth = |u: &[f64]| -> Vec<f64> {
            let (plays, mut state) = (Plays { r: &[1.0, 2.0, 3.0], w: &[0.1; 3] }, [0.0; 3]);
            u.iter().map(|u| u + 0.02 * u * u + plays.step(*u, &mut state)).collect()
        };
        let wave = |top: f64| -> Vec<f64> {
            (0..240).map(|k| 0.5 * top * (1.0 - (0.08 * f64::from(k)).cos())).collect()
        };
        let (a, b, test) = (wave(5.0), wave(8.0), wave(6.5));
        let (ya, yb) = (truth(&a), truth(&b));
        let records = [(&a[..], &ya[..]), (&b[..], &yb[..])];
        let frame = Frame::new(
            Features::StopOperators(features),
            Span::UNIT,
            Span::UNIT,
            Recipe::Plain,
            &records,
        );
        let group = |k: usize| usize::from(k >= 8);
        let found =
            weigh(&frame, &records, &group, (&[3.0, 1.0], 1e4), (80, 480), f64::INFINITY).unwrap();
        let error = |frame: Frame, settings: Settings| {
            let (machine, _) = Machine::train(frame, &records, settings).unwrap();
            super::super::rms_difference(&machine.simulate(&test, 0.0), &truth(&test))
        };
        let ours = error(found.frame.clone(), found.settings);
        let plain = error(frame, Settings { gamma: 1e4, sigma2: 1.0 });
        assert!(found.factors[0] > 2.0 * found.factors[1], "{:?}", found.factors);
        assert!(ours < 0.5 * plain, "{ours} {plain}");
        assert!(ours < 0.05, "{ours}");
    }
}
