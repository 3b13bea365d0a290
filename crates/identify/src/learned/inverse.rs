//! The inverse of a learned hysteresis, learned from what the forward model answers.
//!
//! Its inputs are the stop operators of the position, its samples the forward model's answers to waves over
//! the range of commands ([`Waves`]) and to two slow ones over all of it. It is judged on waves that no
//! sample is taken from: the position that its command leads to, beside the one that was asked for.

use learned::features::{Features, StopOperators};
use serde::Serialize;

use super::{Frame, Machine, Recipe, SEED, Span, SyntheticData, Waves, rms_difference, weigh};
use crate::error::Error;
use crate::observer::Observer;

/// Waves that are learned from, and waves that judge.
const WAVES: (usize, usize) = (24, 6);
/// Most samples of the waves, and of the slow ones over the whole range.
const SAMPLES: (usize, usize) = (2500, 500);
/// Samples of the shortest wave, at least; the longest is so many times as long.
pub const SHORTEST: f64 = 50.0;
const LONGEST: f64 = 20.0;
/// Most samples of one signal.
const ROWS: f64 = 4000.0;
/// Where the search for widths begins, as parts of the range: stops, position; γ. Its evaluations, and most
/// samples it looks at.
const START: ([f64; 2], f64) = ([10.0, 0.3], 1e4);
const SEARCH: (usize, usize) = (60, 700);
/// Most centres that stay, and the part of the error, and of the command's range, that this may add.
const CENTRES: (usize, f64, f64) = (1000, 0.05, 1e-4);
/// The law of the waves is asked for these frequencies in its own time, in Hz.
const BAND: [f64; 2] = [20.0 / LONGEST, 20.0];
/// Fewest stop operators.
const STOPS: usize = 10;
/// Error from which an inverse is refused, as a part of the position's range.
const MOST_ERROR: f64 = 0.1;
const STAGE: &str = "inverse by an LS-SVM";

/// What an inverse is learned for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Purpose {
    /// Sample time in s.
    pub period: f64,
    /// Least and greatest command, within the range that the forward model was shown.
    pub commands: [f64; 2],
    /// Greatest frequency of the waves in Hz.
    pub highest: f64,
}

/// What is known of a learned inverse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InverseFigures {
    /// Support vectors.
    pub centres: usize,
    /// Waves that it was learned from.
    pub waves: usize,
    /// Least and greatest frequency of the waves in Hz.
    pub band: [f64; 2],
    /// Waves that judge it.
    pub judged: usize,
    /// Root mean square of the position that its command leads to less the one that was asked for, on
    /// those, as a part of the position's range.
    pub error: f64,
    /// The greatest of these differences, as a part of that range.
    pub greatest: f64,
}

/// Learns the inverse of `forward`, from command to position.
///
/// # Errors
/// [`Error::Learned`] where it errs by more than 10 % of the range, or the training fails;
/// [`Error::Stopped`].
pub fn learn(
    forward: &Machine,
    purpose: &Purpose,
    observer: &mut dyn Observer,
) -> Result<(Machine, InverseFigures), Error> {
    let mut stage = |done: usize| {
        observer.progress(STAGE, done, 3);
        if observer.stopped() { Err(Error::Stopped) } else { Ok(()) }
    };
    stage(0)?;
    let Features::StopOperators(own) = &forward.frame.features else {
        let message = "only a model over stop operators is inverted".to_owned();
        return Err(Error::Learned { message });
    };
    let fail = |error: learned::Error| Error::Learned { message: error.to_string() };
    let Span { low, high } = forward.frame.command;
    let scaled = |u: f64| (u - low) / (high - low);
    let range = purpose.commands.map(scaled);
    let command = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| low + (high - low) * x).collect() };
    let answer = |x: &[f64]| forward.simulate(&command(x), forward.frame.output.low);
    // In the law's own time the highest frequency is always the same.
    let shortest = 1.0 / (purpose.highest * purpose.period);
    let rows = (LONGEST * shortest).min(ROWS) as usize;
    let period = 1.0 / (BAND[1] * shortest);
    let waves = Waves { count: WAVES.0, rows, period, band: BAND, range, seed: SEED };
    let slow = slow(range, rows);
    let synthetic = SyntheticData::new(&[&slow], Some(waves), answer)?;
    let pairs = synthetic.pairs();
    let heights: Vec<f64> = pairs.iter().flat_map(|(h, _)| *h).copied().collect();
    let stops = StopOperators::new(own.count.max(STOPS), 1.0, purpose.period)
        .rated(own.rate_scale.max(1e12));
    let count = stops.count;
    let group = |input: usize| usize::from(input >= count);
    let features = Features::StopOperators(stops);
    let (position, full) = (Span::of(&heights), Span { low: range[0], high: range[1] });
    let frame = Frame::new(features, position, full, Recipe::Plain, &pairs).on_a_line(&pairs);
    let found =
        weigh(&frame, &pairs, &group, (&START.0, START.1), SEARCH, f64::INFINITY).map_err(fail)?;
    stage(1)?;
    let every = |rows: usize, most: usize| rows.div_ceil(most).max(1);
    let steps = (every(slow.len(), SAMPLES.1), every(waves.count * rows, SAMPLES.0));
    let samples = synthetic.samples(&found.frame, steps.0, steps.1).map_err(fail)?;
    let (trained, _) = Machine::train_on(found.frame, &samples, found.settings).map_err(fail)?;
    stage(2)?;
    let few = &pairs[..pairs.len().min(1 + WAVES.1)];
    let own_error = trained.frame.error(&trained.machine, few);
    let limit = (1.0 + CENTRES.1) * own_error + CENTRES.2 * (range[1] - range[0]);
    let small = trained.compress(few, CENTRES.0, limit).unwrap_or(trained);
    let unseen = Waves { count: WAVES.1, seed: SEED + WAVES.0, ..waves }.commands()?;
    let (mut squares, mut count, mut greatest) = (0.0, 0, 0.0_f64);
    for x in &unseen {
        let asked = answer(x);
        let tried = small.simulate(&asked, x[0]);
        let held: Vec<f64> = tried.iter().map(|x| x.clamp(range[0], range[1])).collect();
        let led = answer(&held);
        squares += rms_difference(&led, &asked).powi(2) * asked.len() as f64;
        count += asked.len();
        let differences = led.iter().zip(&asked).map(|(a, b)| (a - b).abs());
        greatest = differences.fold(greatest, f64::max);
    }
    let height = position.high - position.low;
    let figures = InverseFigures {
        centres: small.machine.count(),
        waves: waves.count,
        band: [purpose.highest / LONGEST, purpose.highest],
        judged: unseen.len(),
        error: (squares / count.max(1) as f64).sqrt() / height,
        greatest: greatest / height,
    };
    if figures.error.is_nan() || figures.error > MOST_ERROR {
        let message = format!(
            "the learned inverse has an error of {:.2} % of the position's range on {} waves that it was not trained on; at most {:.0} % is accepted; give another --band, or identify the plant from \
             a log with loops of several sizes",
            100.0 * figures.error,
            figures.judged,
            100.0 * MOST_ERROR
        );
        return Err(Error::Learned { message });
    }
    // From position to command again.
    let mut inverse = small;
    let ends = command(&[full.low, full.high]);
    inverse.frame.output = Span { low: ends[0], high: ends[1] };
    Ok((inverse, figures))
}

/// Two cosine waves over the whole range, and one back from its middle.
fn slow([least, greatest]: [f64; 2], rows: usize) -> Vec<f64> {
    let wave = |k: usize| {
        let turn = 3.0 * core::f64::consts::TAU * k as f64 / rows as f64;
        let top = if 3 * k < 2 * rows { greatest } else { 0.5 * (least + greatest) };
        least + 0.5 * (top - least) * (1.0 - turn.cos())
    };
    (0..rows).map(wave).collect()
}
