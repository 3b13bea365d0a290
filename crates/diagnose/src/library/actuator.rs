//! Actuator: memory, creep, polarisation, temperature.

use components::effects;
use model::Range;
use surround::{Block, Growth, Loss, Memory, Operator};

use super::Setting;
use crate::formula::{Family, Formula, Free, Slot};
use crate::path_block::RecordBlock;
use crate::thresholds::search::Thresholds;

/// Names of the parameters of a bank of plays.
const WEIGHTS: [&str; 8] = [
    "weight 1", "weight 2", "weight 3", "weight 4", "weight 5", "weight 6", "weight 7", "weight 8",
];
const WEIGHT: &str = "{position}/{command}";

pub(super) fn add(s: &Setting<'_>, all: &mut Vec<Family>) {
    let memory = s.base.memory.clone().unwrap_or_else(|| generic(s));
    all.push(Family::new(&effects::CREEP, creep(s)));
    let mut family = Family::new(&effects::HYSTERESIS, hysteresis(s));
    // A loop of the same width at every amplitude is a clearance, and no memory.
    family.nulls = super::mechanics::backlash(s);
    if let Some(spring) = super::mechanics::hysteresis_of_the_spring(s) {
        family.formulas.push(spring);
        // What brakes or yields alike at every amplitude and speed is another damping or frequency, whether or not the gain
        // goes with it.
        let own = [&effects::DAMPING, &effects::RESONANCE_SHIFT];
        family.nulls.extend(own.iter().filter_map(|e| super::mechanics::released(s, e)));
        family.nulls.extend(super::mechanics::stiffness(s));
    }
    all.push(family);
    let mut family = Family::new(&effects::ASYMMETRY, asymmetry(s, &memory));
    // A play of the same width along the whole range is hysteresis or clearance.
    family.nulls = vec![even_play(s)];
    all.push(family);
    if s.base.memory.is_some() {
        all.push(Family::new(&effects::RATE_DEPENDENCE, rate(s, &memory)));
    }
    all.push(Family::new(&effects::POLARISATION_SATURATION, polarisation(s)));
    all.push(Family::new(&effects::ACTUATOR_GAIN, vec![gain(), ageing()]));
    all.push(Family::new(&effects::SELF_HEATING, heating(s)));
    all.push(Family::new(&effects::INITIAL_STATE, initial(s, &memory)));
    if s.base.memory.is_some() {
        Operator::all().for_each(|operator| add_operator(s, operator, &memory, all));
    }
}

/// An operator with the model's plays, as a formula of the effect that its component stands for.
fn add_operator(s: &Setting<'_>, operator: Operator, memory: &Memory, all: &mut Vec<Family>) {
    let Some(effect) = operator.component().declaration().effect else { return };
    let missing = operator.missing();
    let (mut parameters, mut starts) = (Vec::new(), vec![Vec::new()]);
    for free in missing.free {
        let quantities = operator.component().declaration().parameters;
        let unit = quantities.iter().find(|q| q.name == free.quantity).map_or("1", |q| q.unit);
        let (parameter, own) = match free.range {
            Range::Between { lower, upper, starts } => {
                (Free::linear(free.name, unit, lower, upper), starts.to_vec())
            }
            Range::Growth => {
                let time = growth_unit(s);
                let own = vec![0.02 * time, 0.2 * time];
                (Free::log(free.name, unit, 1e-5 * time, 10.0 * time), own)
            }
            Range::Bandwidth => {
                let (low, high) = (1.0 / s.length, 50.0 / s.sample);
                (Free::log(free.name, unit, low, high), super::input::bandwidths(s))
            }
        };
        parameters.push(parameter);
        let with = |start: &Vec<f64>| own.iter().map(|v| [&start[..], &[*v]].concat()).collect();
        starts = starts.iter().flat_map::<Vec<Vec<f64>>, _>(with).collect();
    }
    let block = Block::Operator { component: operator, memory: memory.clone() };
    let formula =
        Formula::new(missing.name).block(Slot::AfterActuator, block, parameters).starts(starts);
    match all.iter_mut().find(|family| family.effect.name == effect.name) {
        Some(family) => family.formulas.push(formula),
        None => all.push(Family::new(effect, vec![formula])),
    }
}

/// The time in s by which thresholds that grow with the command's rate move by half its range. Not over the steepest
/// rate: steps are far steeper than what lies between them.
fn growth_unit(s: &Setting<'_>) -> f64 {
    s.command.half / s.slope_power.sqrt().max(f64::MIN_POSITIVE)
}

/// Another gain.
pub(crate) fn gain() -> Formula {
    let gain = Free::linear("gain", "1", -0.9, 4.0).step(1e-3);
    Formula::new("gain").block(Slot::AfterMechanics, Block::Gain, vec![gain]).start(&[0.0])
}

/// A gain that changes with the logarithm of time.
fn ageing() -> Formula {
    let gain = Free::linear("gain", "1", -0.9, 4.0).step(1e-3);
    let growth = Free::linear("growth per decade", "1", -0.5, 0.5).step(1e-3);
    Formula::new("gain that ages")
        .block(Slot::AfterMechanics, Block::AgeingGain, vec![gain, growth])
        .start(&[0.0, 0.0])
}

/// Thresholds over the amplitude of the command, closer together at small ones.
fn bank(s: &Setting<'_>, count: usize) -> Vec<f64> {
    let full = 2.0 * s.command.half;
    (1..=count).map(|k| full * (k as f64 / (count + 1) as f64).powf(1.4)).collect()
}

/// A memory of the usual shape, about 15 % of the stroke, for a model without one.
fn generic(s: &Setting<'_>) -> Memory {
    let r = bank(s, 4);
    let slope = s.position.half / s.command.half;
    let w = vec![0.1 * slope; r.len()];
    Memory { r, w }
}

fn creep(s: &Setting<'_>) -> Vec<Formula> {
    let slot = Slot::BeforeMechanics;
    let (shortest, longest) = (5.0 * s.sample, 3.0 * s.length);
    let share = |name| Free::log(name, "1", 1e-6, 0.8);
    let time = |name| Free::log(name, "s", shortest, longest);
    let times: Vec<f64> = (0..4)
        .map(|k| {
            shortest.max(s.length * 1e-3)
                * (longest / shortest.max(s.length * 1e-3)).powf((f64::from(k) + 0.5) / 4.0)
        })
        .collect();
    let middle = [0.3, 0.1, 0.03, 0.01, 0.003].map(|k| k * s.length);
    vec![
        Formula::new("logarithmic")
            .block(
                slot,
                Block::LogCreep { longest: 10.0 * s.length },
                vec![share("gain per decade"), time("shortest time")],
            )
            .starts([1e-3, 1e-2].map(|k| vec![0.01, (k * s.length).max(2.0 * shortest)]))
            .screened(1),
        Formula::new("power law")
            .block(
                slot,
                Block::PowerCreep { shortest, longest: 10.0 * s.length },
                vec![share("gain per decade"), Free::linear("exponent", "1", -1.0, 1.0).step(0.02)],
            )
            .start(&[0.01, 0.0])
            .screened(1),
        Formula::new("one element")
            .block(slot, Block::Creep, vec![share("share"), time("time constant")])
            .starts(middle.map(|t| vec![0.01, t])),
        Formula::new("two elements")
            .block(
                slot,
                Block::Creep,
                vec![
                    share("share 1"),
                    time("time constant 1"),
                    share("share 2"),
                    time("time constant 2"),
                ],
            )
            .starts([
                vec![0.01, middle[1], 0.01, middle[4]],
                vec![0.01, middle[0], 0.01, middle[2]],
            ]),
        Formula::new("four elements")
            .block(
                slot,
                Block::FixedCreep { times },
                vec![share("share 1"), share("share 2"), share("share 3"), share("share 4")],
            )
            .start(&[0.005; 4]),
    ]
}

fn hysteresis(s: &Setting<'_>) -> Vec<Formula> {
    let slope = s.slope();
    let half = s.command.half;
    // A force over a way is nearly all loop, which bends within a small part of the range. Elsewhere so narrow a loop is a
    // clearance.
    let is_all_loop = s.leaves > Thresholds::ALL_LOOP;
    let weight = |name: &'static str, width: f64| {
        let times = if is_all_loop { (half / width).max(1.0) } else { 1.0 };
        let most = 3.0 * slope * times;
        Free::linear(name, WEIGHT, -most, most).step(1e-3 * slope)
    };
    let with = |name, r: Vec<f64>, gain: bool| {
        let straight = gain.then(|| weight("slope", r[0]));
        let own = WEIGHTS.iter().zip(&r).map(|(name, r)| weight(name, *r));
        let parameters: Vec<Free> = straight.into_iter().chain(own).collect();
        let start = vec![0.0; parameters.len()];
        Formula::new(name)
            .block(Slot::AfterActuator, Block::Plays { r, slope: gain }, parameters)
            .start(&start)
    };
    let narrowest = if is_all_loop { 0.002 * half } else { 0.02 * half };
    let narrow = is_all_loop.then_some(0.01);
    let bouc_wen = Formula::new("Bouc-Wen")
        .block(
            Slot::AfterActuator,
            Block::BoucWen,
            vec![
                weight("gain", narrowest),
                Free::log("width", "{command}", narrowest, 2.0 * half),
                Free::linear("part that depends on the direction", "1", 0.0, 1.0).step(0.02),
            ],
        )
        .starts([0.1, 0.3].into_iter().chain(narrow).map(|k| vec![0.02 * slope, k * half, 0.5]))
        .screened(1);
    let mut all = vec![
        bouc_wen,
        with("two plays", bank(s, 2), false),
        with("four plays", bank(s, 4), false),
        with("four plays and slope", bank(s, 4), true),
        with("eight plays and slope", bank(s, 8), true),
    ];
    if is_all_loop {
        all.push(with("eight plays and slope, most of them narrow", narrow_bank(s, 8), true));
    }
    all
}

/// Thresholds from 0.4 to 35 % of the range, each so many times the one before.
fn narrow_bank(s: &Setting<'_>, count: usize) -> Vec<f64> {
    let (least, most) = (0.008 * s.command.half, 0.7 * s.command.half);
    let times = (most / least).powf(1.0 / (count - 1) as f64);
    (0..count).map(|k| least * times.powi(k as i32)).collect()
}

fn asymmetry(s: &Setting<'_>, memory: &Memory) -> Vec<Formula> {
    let slot = Slot::AfterActuator;
    let slope = s.slope();
    let weight =
        |k: usize| Free::linear(WEIGHTS[k], WEIGHT, -3.0 * slope, 3.0 * slope).step(1e-3 * slope);
    let curvature = Free::linear("curvature", "1", -3.0, 3.0).step(0.01);
    let dead = |name| Free::linear(name, "1", -1.0, 1.0).step(1e-3);
    let skewed = |name, count: usize| {
        let block = Block::SkewedPlays { r: bank(s, count), span: s.command };
        Formula::new(name)
            .block(slot, block, (0..count).map(weight).collect())
            .start(&vec![0.0; count])
    };
    // What is inside a box cannot be exchanged: its own plays are bent instead.
    let own = s.base.memory.as_ref().filter(|_| !s.base.is_white);
    let bend = |name| Free::linear(name, "1", -0.5, 0.5).step(1e-3);
    let bent = own.map(|memory| {
        let block = Block::BentPlays { memory: memory.clone(), span: s.command };
        let names = [
            "slope, rising",
            "square, rising",
            "cube, rising",
            "slope, falling",
            "square, falling",
            "cube, falling",
            "wider on both sides",
        ];
        Formula::new("envelopes that bend independently")
            .block(slot, block, names.map(bend).to_vec())
            .start(&[0.0; 7])
    });
    let all = vec![
        skewed("loop width that grows along the range", 2),
        skewed("loop width that grows along the range, four plays", 4),
        Formula::new("play whose width changes along the range")
            .block(
                slot,
                Block::GeneralisedPlay(s.command),
                vec![
                    Free::linear("weight", WEIGHT, -slope, slope).step(1e-3 * slope),
                    Free::linear("half width", "1", 0.0, 1.0).step(2e-3),
                    Free::linear("growth of the width", "1", -1.0, 1.0).step(2e-3),
                    Free::linear("curvature of the width", "1", -1.0, 1.0).step(2e-3),
                ],
            )
            .start(&[0.01 * slope, 0.15, 0.15, 0.05])
            .start(&[0.01 * slope, 0.15, -0.15, 0.05])
            .screened(1),
        Formula::new("curved envelopes")
            .block(
                slot,
                Block::CurvedPlays { memory: memory.clone(), span: s.command },
                vec![curvature],
            )
            .start(&[0.2])
            .start(&[-0.2]),
    ];
    // Without plays they are a static curve.
    let zones = s.base.memory.as_ref().map(|_| {
        Formula::new("dead zones behind the plays")
            .block(
                slot,
                Block::DeadZones(s.position),
                vec![dead("slope above"), dead("slope below")],
            )
            .start(&[0.0, 0.0])
    });
    all.into_iter().chain(zones).chain(bent).collect()
}

/// The play whose width changes, with the same width everywhere.
fn even_play(s: &Setting<'_>) -> Formula {
    let slope = s.slope();
    let none = |name| Free::linear(name, "1", -1e-9, 1e-9);
    Formula::new("play of one width")
        .block(
            Slot::AfterActuator,
            Block::GeneralisedPlay(s.command),
            vec![
                Free::linear("weight", WEIGHT, -slope, slope).step(1e-3 * slope),
                Free::linear("half width", "1", 0.0, 1.0).step(2e-3),
                none("growth of the width"),
                none("curvature of the width"),
            ],
        )
        .start(&[0.01 * slope, 0.15, 0.0, 0.0])
}

fn rate(s: &Setting<'_>, memory: &Memory) -> Vec<Formula> {
    let slot = Slot::AfterActuator;
    let unit = growth_unit(s);
    let time = || Free::log("time", "s", 1e-5 * unit, 10.0 * unit);
    let growing = |name, law| {
        let (memory, scale) = (memory.clone(), s.steepest);
        let block = Block::GrowingPlays { memory, law, scale, smoothing: None };
        let parameters = vec![
            Free::linear("growth", "1", 0.0, 20.0).step(0.01),
            Free::log("rate of reference", "1", 1e-4, 30.0),
            Free::log("smoothing", "s", 0.3 * s.sample, 0.1 * s.length),
        ];
        let starts = [0.3, 0.05].into_iter().flat_map(|k| [2.0, 10.0].map(|t| (k, t)));
        Formula::new(name)
            .block(slot, block, parameters)
            .starts(starts.map(|(k, t)| vec![0.1, k, t * s.sample]))
    };
    let own = [
        ("thresholds that grow with the smoothed rate, up to a limit", Growth::Limited),
        ("thresholds that grow with the logarithm of the smoothed rate", Growth::Logarithmic),
    ];
    let own = own.into_iter().filter(|_| !s.base.is_white);
    let own = own.map(|(name, law)| growing(name, law));
    let all = vec![
        Formula::new("thresholds that grow in proportion, up to a limit")
            .block(
                slot,
                Block::GrowingPlays {
                    memory: memory.clone(),
                    law: Growth::Limited,
                    scale: s.steepest,
                    smoothing: Some(surround::time_of(Thresholds::RATE_SATURATING, s.data.step)),
                },
                vec![
                    Free::linear("growth", "1", 0.0, 20.0).step(0.01),
                    Free::log("rate of half the growth", "1", 1e-3, 30.0),
                ],
            )
            .start(&[0.3, 0.3])
            .start(&[0.3, 0.03]),
        Formula::new("loop that grows with the rate")
            .block(
                slot,
                Block::RateMemory {
                    memory: memory.clone(),
                    half: s.command.half,
                    smoothing: surround::time_of(Thresholds::RATE_GROWING, s.data.step),
                },
                vec![time()],
            )
            .start(&[0.1 * unit]),
    ];
    all.into_iter().chain(own).collect()
}

fn polarisation(s: &Setting<'_>) -> Vec<Formula> {
    let size = || Free::log("flattening", "1", 1e-5, 0.6);
    let shift = Free::linear("shift of the centre", "1", -1.0, 1.0).step(0.01);
    vec![
        Formula::new("S-curve")
            .block(Slot::AfterActuator, Block::SCurve(s.position), vec![size(), shift])
            .start(&[0.02, 0.0])
            .start(&[0.02, 0.4])
            .start(&[0.02, -0.4]),
        Formula::new("hyperbolic tangent")
            .block(
                Slot::AfterActuator,
                Block::Tanh(s.position),
                vec![Free::log("size over the half range", "1", 0.3, 30.0)],
            )
            .start(&[5.0])
            .start(&[2.0]),
        super::input::powers(s, Slot::BeforeActuator),
    ]
}

fn heating(s: &Setting<'_>) -> Vec<Formula> {
    if s.slope_power <= 0.0 {
        return Vec::new();
    }
    let time = || Free::log("time constant", "s", 20.0 * s.sample, 10.0 * s.length);
    let growth = |name| Free::linear(name, "1", -1.0, 1.0).step(1e-3);
    let starts = || [0.3, 0.05].map(|k| vec![0.01, k * s.length]);
    let mut all = Vec::new();
    for (name, gain_name, loss) in [
        (
            "growth with the drive's loops",
            "gain that changes with the drive's loops",
            Loss::Loops { mean: s.loop_power.max(f64::MIN_POSITIVE), centre: s.command.centre },
        ),
        (
            "growth with the square of the drive's rate",
            "gain that changes with the square of the drive's rate",
            Loss::Rate { mean: s.slope_power },
        ),
        (
            "growth with the drive's apparent power",
            "gain that changes with the drive's apparent power",
            Loss::Apparent { mean: s.apparent_power.max(f64::MIN_POSITIVE) },
        ),
    ] {
        let slot = Slot::AfterMechanics;
        let growing = Block::Heating { half: s.position.half, loss };
        all.push(
            Formula::new(name)
                .block(slot, growing, vec![growth("growth"), time()])
                .starts(starts()),
        );
        let times = [0.03, 0.2, 1.0].map(|k| k * s.length).to_vec();
        let parts = ["growth, fast", "growth", "growth, slow", "gain"].map(growth);
        all.push(
            Formula::new("growth over three times, and gain")
                .block(slot, Block::Warming { half: s.position.half, loss, times }, parts.to_vec())
                .start(&[0.0; 4]),
        );
        let gain = Block::HeatingGain { loss };
        all.push(
            Formula::new(gain_name)
                .block(slot, gain, vec![growth("growth"), time()])
                .starts(starts()),
        );
    }
    all
}

fn initial(s: &Setting<'_>, memory: &Memory) -> Vec<Formula> {
    let place = Free::linear("place in the loop", "1", -1.0, 1.0).step(0.05);
    vec![
        Formula::new("memory at the start")
            .block(Slot::AfterActuator, RecordBlock::StartMemory(memory.clone()), vec![place])
            .start(&[0.9])
            .start(&[-0.9])
            .start(&[0.3])
            .start(&[-0.3]),
    ]
    .into_iter()
    .filter(|_| s.base.memory.is_some())
    .collect()
}
