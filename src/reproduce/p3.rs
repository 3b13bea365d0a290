//! Nanopositioning at 20 kHz: Gaussian process over the command and its derivatives.

use anyhow::Context;
use identify::learned::{Frame, Machine, Recipe, Span, rms_difference};
use learned::features::{Derivatives, Features};
use learned::gp::{GaussianProcess, Hyperparameters, Search};

use super::figures::{self, Chapter};
use super::{Aim, Order, Reproduction, Response, Row, response};

const ID: &str = "P3";
const RIG: &str = "p3-truth";
/// Amplifier of the rig: the paper's volts are at the actuator.
const AMPLIFIER: f64 = 15.0;
/// Half length and cut-off (cycles per sample) of the low-pass in front of the differences.
const HALF: usize = 3;
const CUTOFF: f64 = 0.25;
const DIMENSIONS: [usize; 4] = [2, 6, 9, 12];

/// Name, signal, its settings, the paper's NRMSE for 2, 6, 9, 12 inputs.
type Test = (&'static str, &'static str, &'static [(&'static str, f64)], [f64; 4]);

const TESTS: [Test; 8] = [
    ("100 Hz", "p3-sine", &[("frequency", 100.0)], [0.4034, 0.1908, 0.1812, 0.1766]),
    ("200 Hz", "p3-sine", &[("frequency", 200.0)], [0.2165, 0.1712, 0.1691, 0.1673]),
    ("300 Hz", "p3-sine", &[("frequency", 300.0)], [0.9519, 0.9223, 0.9187, 0.9196]),
    ("500 Hz", "p3-sine", &[("frequency", 500.0)], [1.3732, 1.2974, 1.3116, 1.2749]),
    ("1 kHz", "p3-sine", &[("frequency", 1000.0)], [1.3183, 1.2875, 1.2874, 1.2855]),
    ("120 + 180 Hz", "p3-two-tone", &[], [2.1670, 2.1462, 1.9929, 1.6752]),
    ("four tones", "p3-four-tone", &[], [3.0209, 2.7079, 1.6165, 1.0759]),
    ("50 Hz triangle", "p3-triangle", &[], [2.2333, 2.1070, 2.0444, 2.0192]),
];

/// Tests whose figure for 12 inputs is to be reached.
const BOLD: [&str; 6] =
    ["100 Hz", "500 Hz", "1 kHz", "120 + 180 Hz", "four tones", "50 Hz triangle"];

fn trained(dimension: usize, chirp: &Response) -> anyhow::Result<Machine> {
    let derivatives = Derivatives::new(dimension, HALF, CUTOFF, [1.0; 4]).context("a dimension")?;
    let pairs = [(&chirp.command[..], chirp.after())];
    let features = Features::Derivatives(derivatives);
    let frame = Frame::new(features, Span::UNIT, Span::UNIT, Recipe::Standardised, &pairs);
    let samples = frame.samples(&pairs)?;
    let lengths = vec![(dimension as f64).sqrt(); 1];
    let start = Hyperparameters { signal: 5.0, noise: 0.01, lengths };
    let search = Search { start, evaluations: 60, most_samples: 1000 };
    let (process, _) = GaussianProcess::learn(&samples, &search)?;
    let mut frame = frame;
    for (width, scale) in frame.widths.iter_mut().zip(process.scales()) {
        *width /= scale;
    }
    Ok(Machine { frame, machine: process.scaled_machine() })
}

fn nrmse(machine: &Machine, run: &Response) -> f64 {
    let y = machine.simulate(&run.command, run.position[0]);
    let span = Span::of(run.after());
    100.0 * rms_difference(&y, run.after()) / (span.high - span.low)
}

/// The test signals, measured and simulated.
fn seen(tests: &[Response], machines: &[(&str, Machine)]) -> Chapter {
    let text =
        "The models are simulated from the command alone; of each signal the last 2000 samples.";
    let mut chapter = Chapter::new("the models on the test signals", text);
    for (run, test) in tests.iter().zip(&TESTS) {
        let from = run.after().len().saturating_sub(2000);
        let simulated: Vec<(&str, Vec<f64>)> = machines
            .iter()
            .rev()
            .map(|(name, m)| (*name, m.simulate(&run.command, run.position[0])))
            .collect();
        let models: Vec<(&str, &[f64])> =
            simulated.iter().map(|(name, y)| (*name, &y[from..])).collect();
        let measured = &run.after()[from..];
        chapter = chapter.figure(figures::model(test.0, "um", run.period, measured, &models));
    }
    chapter
}

pub(super) fn run(say: &dyn Fn(&str)) -> anyhow::Result<Reproduction> {
    let of = |name, settings| response(RIG, name, settings, 1.0 / AMPLIFIER);
    let chirp = of("p3-chirp", &[])?;
    let mut answer = Reproduction::default();
    let mut errors = Vec::new();
    let tests: anyhow::Result<Vec<Response>> = TESTS.iter().map(|t| of(t.1, t.2)).collect();
    let tests = tests?;
    let mut machines = Vec::new();
    for dimension in DIMENSIONS {
        say(&format!("{dimension} inputs"));
        let machine = trained(dimension, &chirp)?;
        errors.push(tests.iter().map(|run| nrmse(&machine, run)).collect::<Vec<f64>>());
        if dimension == 12 {
            let pairs = [(&chirp.command[..], chirp.after())];
            let whole = rms_difference(&machine.simulate(&chirp.command, 0.0), chirp.after());
            let small = machine.compress(&pairs, 600, 1.05 * whole);
            answer.remarks.push(match small {
                Some(small) => format!(
                    "compressed to {} of {} centres with 5 % more training error",
                    small.machine.count(),
                    machine.machine.count()
                ),
                None => "600 centres are not enough for 5 % more training error".into(),
            });
        }
        if dimension == 2 || dimension == 12 {
            machines.push((if dimension == 2 { "2 inputs" } else { "12 inputs" }, machine));
        }
    }
    answer.chapters.push(seen(&tests, &machines));
    for (k, (name, _, _, paper)) in TESTS.iter().enumerate() {
        for (d, dimension) in DIMENSIONS.iter().enumerate() {
            let reach = *dimension == 12 && BOLD.contains(name);
            let aim = if reach { Aim::Reach } else { Aim::Told };
            let what = format!("{dimension} inputs, {name}");
            answer.rows.push(Row::new(ID, what, "%", paper[d], errors[d][k], aim));
        }
        let what = format!("12 inputs better than 2, {name}");
        answer.orders.push(Order { paper_id: ID, what, holds: errors[3][k] < errors[0][k] });
    }
    answer.remarks.push(format!(
        "low-pass of {} taps before the differences, centred for these figures; in real time the \
         output is late by {} samples",
        2 * HALF + 1,
        HALF + 1
    ));
    Ok(answer)
}
