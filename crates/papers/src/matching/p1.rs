//! P1, nanopositioning stage P-752.21C.

use identify::learned::{Frame, Machine, Recipe, Span, rms_difference};
use learned::features::{Features, Narx};
use learned::lssvm::{Folds, Settings, Validation};
use learned::tune::grid_then_simplex;

use super::baseline::{Baseline, error};
use super::{Figure, Response, driven, rest, rig, rms};
use crate::machines;

const RIG: &str = machines::P1;

/// The machine under a signal of the paper.
pub(crate) fn recorded(letter: char) -> anyhow::Result<Response> {
    let (name, given) = machines::p1(letter);
    driven(RIG, &name, given, 1.0)
}

/// P1: range, and rms of the position about a straight line, signals A to G: that of signal A, as the paper does not
/// say which line it means.
pub(super) fn figures() -> anyhow::Result<Vec<Figure>> {
    let mut system = rig(RIG)?;
    let paper = [1.747, 2.057, 0.862, 1.771, 0.714, 0.444, 5.801];
    let (low, high) = (rest(&mut system, &[-2.0])?[0], rest(&mut system, &[12.0])?[0]);
    let range = Figure::new(RIG, "range, -20 to 120 V at the actuator", "um", 35.0, high - low);
    let mut all = vec![range.of_rig()];
    let runs = "abcdefg".chars().map(recorded).collect::<anyhow::Result<Vec<Response>>>()?;
    let of = |run: &Response| -> Vec<(f64, f64)> {
        run.command.iter().zip(&run.position).map(|(u, y)| (*u, y - run.position[0])).collect()
    };
    let first = of(&runs[0]);
    let gain = first.iter().map(|(u, y)| u * y).sum::<f64>()
        / first.iter().map(|(u, _)| u * u).sum::<f64>();
    for ((run, letter), paper) in runs.iter().zip("ABCDEFG".chars()).zip(paper) {
        let error = rms(of(run).into_iter().map(|(u, y)| y - gain * u));
        let figure =
            Figure::new(RIG, format!("do-nothing error, signal {letter}"), "um", paper, error);
        all.push(match letter {
            'C' | 'F' | 'G' => {
                figure.note("the waveform is assumed: the paper gives its band only")
            }
            _ => figure,
        });
    }
    let train: Vec<&Response> = runs.iter().take(3).collect();
    let preisach = Baseline {
        method: Some("preisach"),
        thresholds: vec![0.0, 1.0],
        levels: 20,
        dynamic: false,
    };
    let preisach = preisach.fit(&train)?;
    let g = &runs[6];
    let what = "Preisach model of A to C, signal G";
    let figure = Figure::new(RIG, what, "um", 1.3367, error(&preisach, g)?);
    all.push(figure.note("210 relays; the paper's 7260 leave 1.3367 um, its 1275 1.3620 um"));
    let what = "LS-SVM with NARX inputs of A to C, signal G";
    let [ahead, simulated] = narx(&train, g)?;
    let figure = Figure::new(RIG, what, "um", 0.1660, simulated);
    all.push(figure.note(format!("in simulation; one step ahead it leaves {ahead:.3} um")));
    Ok(all)
}

/// ln of σ² and of γ within which the settings are sought; the paper's Table 5 has ln γ of 8 to 10.
const BOUNDS: [(f64, f64); 2] = [(0.0, 12.0), (-2.0, 18.0)];

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
