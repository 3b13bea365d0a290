//! P1, nanopositioning stage P-752.21C.

use identify::learned::{Frame, Machine, Recipe, Span, rms_difference};
use learned::features::{Features, Narx};
use learned::lssvm::{Folds, Settings, Validation};
use learned::tune::grid_then_simplex;

use super::baseline::{Baseline, error};
use super::{Figure, response, rest, rig, rms, signal};
use crate::reproduce::{self, Response};

const RIG: &str = "p1-truth";

/// P1: range, and rms of the position about the straight line of the nominal gain, signals A to G.
pub(super) fn figures() -> anyhow::Result<Vec<Figure>> {
    let gain = rest(&mut rig("p1")?, &[1.0])?[0] - rest(&mut rig("p1")?, &[0.0])?[0];
    let mut system = rig(RIG)?;
    let paper = [1.747, 2.057, 0.862, 1.771, 0.714, 0.444, 5.801];
    let (low, high) = (rest(&mut system, &[0.0])?[0], rest(&mut system, &[10.0])?[0]);
    let mut all =
        vec![Figure::new(RIG, "range, 0 to 100 V at the actuator", "um", 35.0, high - low)];
    for (letter, paper) in "abcdefg".chars().zip(paper) {
        let (u, period) = signal(&format!("p1-{letter}"), &[])?;
        let y = response(&mut system, 1, &u, period)?;
        let error = rms(u.iter().zip(&y).map(|(u, y)| y - gain * u));
        let what = format!("do-nothing error, signal {}", letter.to_ascii_uppercase());
        let figure = Figure::new(RIG, what, "um", paper, error);
        all.push(match letter {
            'c' | 'f' | 'g' => {
                figure.note("the wave form stands in: the paper gives its band only")
            }
            _ => figure,
        });
    }
    let of = |letter: &str| reproduce::response(RIG, &format!("p1-{letter}"), &[], 1.0);
    let train = [of("a")?, of("b")?, of("c")?];
    let train: Vec<&Response> = train.iter().collect();
    let preisach = Baseline { method: Some("preisach"), thresholds: vec![0.0, 1.0], levels: 20 };
    let preisach = preisach.fit(&train)?;
    let g = &of("g")?;
    let what = "Preisach model of A to C, signal G";
    let figure = Figure::new(RIG, what, "um", 1.3367, error(&preisach, g)?);
    all.push(figure.note("210 relays; the paper's 7260 leave 1.3367 um, its 1275 1.3620 um"));
    let what = "LS-SVM with NARX inputs of A to C, signal G one step ahead";
    let [ahead, simulated] = narx(&train, g)?;
    let figure = Figure::new(RIG, what, "um", 0.1660, ahead);
    all.push(figure.note(format!(
        "the paper does not say whether it ran on its own past outputs: that leaves {simulated:.3} um"
    )));
    Ok(all)
}

/// ln of σ² and of γ within which the settings are sought; the paper's Table 5 has ln γ of 8 to 10.
const BOUNDS: [(f64, f64); 2] = [(0.0, 9.0), (-2.0, 14.0)];

/// Rms one step ahead and in simulation of an LS-SVM with NARX inputs of orders 3 and 3, its settings
/// by five-fold cross-validation. The folds are blocks: a sample between two that the machine was
/// trained with judges nothing.
fn narx(train: &[&Response], test: &Response) -> anyhow::Result<[f64; 2]> {
    let pairs: Vec<(&[f64], &[f64])> = train.iter().map(|r| (&r.command[..], r.after())).collect();
    let narx = Features::Narx(Narx { commands: 3, outputs: 3 });
    let frame = Frame::new(narx, Span::UNIT, Span::UNIT, Recipe::Standardised, &pairs);
    let samples = frame.samples(&pairs)?;
    let mut validation = Validation::new(&samples, &Folds::blocks(samples.count(), 5))?;
    let mut row = |s: f64, gammas: &[f64]| -> Vec<f64> {
        let gammas: Vec<f64> = gammas.iter().map(|g| g.exp()).collect();
        let none = vec![f64::INFINITY; gammas.len()];
        validation.one_step(s.exp(), &gammas).unwrap_or(none)
    };
    let best = grid_then_simplex(&BOUNDS, &mut row, &mut |_, _| true);
    let settings = Settings { sigma2: best.point[0].exp(), gamma: best.point[1].exp() };
    let machine = Machine::train(frame, &pairs, settings)?.0;
    let ahead = machine.one_step(&test.command, test.after())?;
    let simulated = machine.simulate(&test.command, test.position[0]);
    Ok([ahead, simulated].map(|model| rms_difference(&model, test.after())))
}
