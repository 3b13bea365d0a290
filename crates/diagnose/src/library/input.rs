//! Timing and amplifier.

use components::effects;
use model::Effect;
use surround::{Block, Span};

use super::Setting;
use crate::converter::Gaps;
use crate::formula::{Family, Formula, Free, Slot};
use crate::nuisance::Nuisance;
use crate::path_block::RecordBlock;
use crate::thresholds::search::Thresholds;

pub(super) fn add(s: &Setting<'_>, all: &mut Vec<Family>) {
    all.push(delay(s));
    all.push(clock(s));
    all.push(Family::new(&effects::DAC_QUANTISATION, quantiser(s)));
    let (lags, slews, limits) = (lags(s, Slot::Amplifier), slew(s), saturation(s));
    // Where all is linear, order says nothing.
    let beside = at_the_output(s, &lags).into_iter().map(Formula::beside_others).collect();
    let (of_slews, of_limits) = (at_the_output(s, &slews), at_the_output(s, &limits));
    all.push(Family::new(&effects::AMPLIFIER_BANDWIDTH, [lags, beside].concat()));
    all.push(Family::new(&effects::AMPLIFIER_SLEW, [slews, of_slews].concat()));
    all.push(Family::new(&effects::AMPLIFIER_SATURATION, [limits, of_limits].concat()));
}

/// What an amplifier does to its command as something that it does to its output: right before the actuator, where the
/// model has a lag or the like of the amplifier in between.
fn at_the_output(s: &Setting<'_>, formulas: &[Formula]) -> Vec<Formula> {
    let place = |slot| s.base.slots.get(&slot);
    if place(Slot::Amplifier) == place(Slot::BeforeActuator) {
        return Vec::new();
    }
    let mut all: Vec<Formula> = formulas.iter().filter(|f| !f.is_stand_in).cloned().collect();
    for formula in &mut all {
        formula.name = format!("{}, right before the actuator", formula.name).into();
        formula.pieces.iter_mut().for_each(|piece| piece.slot = Slot::BeforeActuator);
    }
    all
}

fn delay(s: &Setting<'_>) -> Family {
    let longest = (50.0 * s.sample).min(0.1 * s.length);
    let least = if s.data.within.is_some() { 1e-4 } else { 0.01 };
    let time = Free::log("delay", "s", least * s.sample, longest).step(0.05);
    let starts = |all: &[f64]| all.iter().map(|k| vec![k * s.sample]).collect::<Vec<_>>();
    let rows = [0.3, 1.0, 3.0, 10.0];
    // What is late before a machine is late behind it, where nothing else drives it. There it moves smoothly from row to
    // row, so that parts of a row are exact, and no box must be run again.
    let is_still = |values: &Vec<f64>| values.windows(2).all(|w| w[0] == w[1]);
    let is_alone = s.data.records.iter().all(|record| record.others.iter().all(is_still));
    let slot = if s.base.is_white || !is_alone { Slot::Command } else { Slot::Reading };
    let transport = Formula::new("transport delay");
    // In parts of a row the command of a model in steps of a row is a mean, to which it does not quite answer so.
    if let Some(parts) = s.data.within.filter(|_| s.base.is_white || is_alone) {
        let block = RecordBlock::Instant { parts, is_late: false };
        let within = Formula::new("transport delay, exact within a row");
        let within = within.block(Slot::Reading, block, vec![time.clone()]);
        let mut family = instants(
            &effects::DELAY,
            within.starts(starts(&[0.01, 0.1, 0.3, 1.0, 3.0, 10.0])),
            "transport delay that swings",
            s,
        );
        family
            .formulas
            .push(transport.block(slot, Block::Delay, vec![time]).starts(starts(&rows)).stand_in());
        return family;
    }
    let constant = transport.block(slot, Block::Delay, vec![time]).starts(starts(&rows));
    instants(&effects::DELAY, constant, "transport delay that swings", s)
}

fn clock(s: &Setting<'_>) -> Family {
    let offset = Free::linear("offset", "1", -1e-2, 1e-2).step(1e-6);
    let constant = Formula::new("offset of the clock")
        .block(Slot::Reading, RecordBlock::Clock, vec![offset])
        .start(&[0.0]);
    instants(&effects::CLOCK_OFFSET, constant, "offset of a clock that wanders", s)
}

/// A clock whose instants swing about those of this formula, where some frequency is seen in the residual.
fn swinging(formula: &Formula, name: &'static str, s: &Setting<'_>) -> Option<Formula> {
    let mut all = Formula { name: name.into(), ..formula.clone() };
    all.starts.clear();
    for start in &formula.starts {
        all.starts.extend(s.swings.iter().map(|f| [&start[..], &[*f]].concat()));
    }
    all.nuisance = Some(Nuisance::Jitter { parameter: formula.parameters.len() });
    all.screened = formula.parameters.len();
    // Less than a period in a record is a ramp.
    let lowest = 1.0 / s.length;
    let frequency =
        Free::log("frequency", "Hz", lowest, 2.0 * Thresholds::JITTER_HIGHEST / s.sample);
    all.parameters.push(frequency.step(1e-3 * lowest));
    (!all.starts.is_empty()).then_some(all)
}

/// A family of instants that are off by a rule, with its formula alone and with instants that swing about
/// it; where the swing alone is as good there is no such rule.
fn instants(
    effect: &'static Effect,
    formula: Formula,
    name: &'static str,
    s: &Setting<'_>,
) -> Family {
    let swings = swinging(&formula, name, s);
    let mut family = Family::new(effect, std::iter::once(formula).chain(swings).collect());
    let nothing = Formula::new("nothing").start(&[]);
    family.nulls = swinging(&nothing, "instants that swing", s).into_iter().collect();
    family
}

fn quantiser(s: &Setting<'_>) -> Vec<Formula> {
    converter(Slot::Command, s.command, &s.steps, s.gaps)
}

/// A converter at the command or at the reading.
pub(super) fn converter(
    slot: Slot,
    span: Span,
    seen: &[(f64, f64)],
    gaps: Option<Gaps>,
) -> Vec<Formula> {
    let steps = || Free::log("steps over the range", "1", 2.0, 65536.0).step(1e-3).jumps();
    let phase = || Free::linear("phase", "1", -2.0, 2.0).step(0.02);
    let mut all = Vec::new();
    if !seen.is_empty() {
        all.push(
            Formula::new("rounding to steps")
                .block(slot, Block::Rounding { half: span.half }, vec![steps(), phase()])
                .starts(seen.iter().map(|(steps, phase)| vec![*steps, *phase]))
                .screened(0),
        );
    }
    if let Some(gaps) = gaps {
        let Gaps { every, missing, .. } = gaps;
        let block = Block::MissingCodes { half: span.half, every, missing };
        all.push(
            Formula::new("steps with codes missing")
                .block(slot, block, vec![steps(), phase()])
                .start(&[gaps.steps, gaps.phase])
                .screened(0),
        );
    }
    all
}

/// Bandwidths to start from: from where a lag is a thousandth of the range per sample.
pub(super) fn bandwidths(s: &Setting<'_>) -> Vec<f64> {
    let nyquist = 0.5 / s.sample;
    [1.0, 0.3, 0.1, 0.03, 0.01].map(|k| k * nyquist).to_vec()
}

pub(super) fn lags(s: &Setting<'_>, slot: Slot) -> Vec<Formula> {
    let (low, high) = (1.0 / s.length.max(s.sample), 50.0 / s.sample);
    let bandwidth = |name| Free::log(name, "Hz", low, high);
    let starts = |k: f64| bandwidths(s).into_iter().map(move |f| vec![k * f]);
    let second = bandwidths(s).into_iter().flat_map(|f| [0.5, 0.9].map(|d| vec![1.4 * f, d]));
    vec![
        Formula::new("first order")
            .block(slot, Block::Lag { order: 1 }, vec![bandwidth("bandwidth")])
            .starts(starts(1.0)),
        Formula::new("second order")
            .block(
                slot,
                Block::SecondOrder,
                vec![bandwidth("bandwidth"), Free::log("damping", "1", 0.2, 3.0)],
            )
            .starts(second)
            .screened(1),
        Formula::new("third order, equal poles")
            .block(slot, Block::Lag { order: 3 }, vec![bandwidth("bandwidth of each pole")])
            .starts(starts(2.5)),
    ]
}

fn slew(s: &Setting<'_>) -> Vec<Formula> {
    let rate = || Free::log("slope limit", "{command}/s", 1e-4 * s.steepest, 2.0 * s.steepest);
    let starts = [0.8, 0.5, 0.3, 0.15, 0.07, 0.03].map(|k| k * s.steepest);
    // A limit that no slope comes near is none.
    let near = Free::log("slope limit", "{command}/s", 1e-4 * s.steepest, s.steepest);
    // So fast that the limit alone shows: a slower approach is a lag.
    let bandwidth = Free::log("bandwidth", "Hz", 0.2 / s.sample, 10.0 / s.sample);
    let down = Free::log("slope limit down over that up", "1", 0.2, 5.0);
    vec![
        Formula::new("limits of the slope up and down")
            .block(Slot::Amplifier, Block::UnevenSlew, vec![rate(), down])
            .starts(starts.map(|r| vec![r, 1.0]))
            .screened(1),
        Formula::new("limit of the slope")
            .block(Slot::Amplifier, Block::Slew, vec![rate()])
            .starts(starts.map(|r| vec![r])),
        Formula::new("current limit with a lag")
            .block(Slot::Amplifier, Block::SoftSlew, vec![near, bandwidth])
            .starts(starts.map(|r| vec![r, 0.3 / s.sample]))
            .screened(1),
    ]
}

fn saturation(s: &Setting<'_>) -> Vec<Formula> {
    let (c, h) = (s.command.centre, s.command.half);
    let named = |name| Free::linear(name, "{command}", c - h, c + h).step(2e-3 * h);
    let limit = || named("limit");
    let parts = [0.95, 0.9, 0.8, 0.65, 0.5];
    let width = Free::log("width of the bend", "{command}", 1e-3 * h, h);
    let knee = Free::linear("knee", "{command}", c - h, c + h).step(2e-3 * h);
    let height = Free::log("height of the bend", "{command}", 1e-3 * h, h);
    let half = Free::log("half width", "{command}", 0.02 * h, h).step(2e-3);
    let size = || Free::log("size over the half range", "1", 0.3, 30.0);
    vec![
        Formula::new("limit at the top")
            .block(Slot::Amplifier, Block::LimitAbove, vec![limit()])
            .starts(parts.map(|k| vec![c + k * h])),
        Formula::new("limit at the bottom")
            .block(Slot::Amplifier, Block::LimitBelow, vec![limit()])
            .starts(parts.map(|k| vec![c - k * h])),
        Formula::new("limits at both ends")
            .block(Slot::Amplifier, Block::Limits { centre: s.command.centre }, vec![half])
            .starts(parts.map(|k| vec![k * h])),
        // Amplifiers are seldom limited evenly about the middle of a log.
        Formula::new("a limit at each end")
            .block(Slot::Amplifier, Block::LimitAbove, vec![named("upper limit")])
            .block(Slot::Amplifier, Block::LimitBelow, vec![named("lower limit")])
            .starts(parts.map(|k| vec![c + k * h, c - k * h])),
        Formula::new("soft limit at the top")
            .block(Slot::Amplifier, Block::SoftLimitAbove, vec![limit(), width])
            .starts(parts.map(|k| vec![c + k * h, 0.05 * h])),
        Formula::new("bend above a knee, up to a limit")
            .block(Slot::Amplifier, Block::KneeAbove, vec![knee, height])
            .starts(parts.map(|k| vec![c + (k - 0.1) * h, 0.1 * h])),
        Formula::new("soft limits at both ends")
            .block(Slot::Amplifier, Block::Tanh(s.command), vec![size()])
            .start(&[5.0])
            .start(&[2.0]),
        powers(s, Slot::Amplifier),
    ]
}

/// A bent characteristic of the command, as components have it.
pub(super) fn powers(s: &Setting<'_>, slot: Slot) -> Formula {
    let power = |name| Free::linear(name, "1", -1.0, 1.0).step(1e-3);
    Formula::new("second and third power of the command")
        .block(slot, Block::Polynomial(s.command), vec![power("a2"), power("a3")])
        .start(&[0.0, 0.0])
        .stand_in()
}
