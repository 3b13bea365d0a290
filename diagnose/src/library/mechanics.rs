//! Mechanics and coupling.

use components::effects;

use super::{Family, Formula, Free, Setting, Slot};
use crate::block::Block;
use crate::chain::Force;
use crate::nuisance::Nuisance;

pub(super) fn add(s: &Setting<'_>, all: &mut Vec<Family>) {
    all.push(Family::new(&effects::RESONANCE_SHIFT, resonance(s)));
    all.push(Family::new(&effects::DAMPING, damping(s)));
    all.push(Family::new(&effects::EXTRA_MODE, extra_mode(s)));
    if s.base.mode.is_some() {
        all.push(Family::new(&effects::DUFFING, duffing(s)));
    }
    all.push(Family::new(&effects::BACKLASH, backlash(s)));
    all.push(Family::new(&effects::FRICTION, friction(s)));
    let mut family = Family::new(&effects::PERIODIC_DISTURBANCE, periodic(s));
    // A line that grows with the position is a gain that changes, and no disturbance.
    family.null = Some(modulation(s));
    all.push(family);
    all.push(Family::new(&effects::CROSS_COUPLING, coupling(s)));
}

/// For a black box: the poles of a resonance moved, as a filter behind the model.
fn resonance(s: &Setting<'_>) -> Vec<Formula> {
    if s.base.is_white {
        return stiffness(s);
    }
    let parameters = vec![
        Free::log("frequency", "Hz", 0.5 / s.length, 0.45 / s.sample),
        Free::log("damping", "1", 1e-3, 1.0),
        Free::linear("frequency of the model's resonance over it", "1", 0.5, 2.0).step(2e-3),
        Free::log("damping of the model's resonance", "1", 1e-3, 1.0),
    ];
    let starts = frequencies(s, 16).into_iter().map(|f| vec![f, 0.03, 1.02, 0.03]);
    vec![
        Formula::new("poles moved, behind the model")
            .block(Slot::AfterMechanics, Block::PoleZero, parameters)
            .starts(starts)
            .screened(3),
    ]
}

/// A spring that is softer or stiffer moves the frequency and the static gain.
fn stiffness(s: &Setting<'_>) -> Vec<Formula> {
    let own = s.base.parameters.iter().enumerate();
    let releases: Vec<usize> =
        own.filter(|(_, p)| p.effect == Some("resonance_shift")).map(|(k, _)| k).collect();
    if releases.is_empty() {
        return Vec::new();
    }
    let gain = Free::linear("gain", "1", -0.9, 4.0).step(1e-3);
    let mut formula = Formula::new("stiffness: the model's own parameter, and the gain")
        .block(Slot::AfterMechanics, Block::Gain, vec![gain])
        .start(&[0.0]);
    formula.releases = releases;
    vec![formula]
}

/// Damping that grows with the speed, beside the model's own.
fn damping(s: &Setting<'_>) -> Vec<Formula> {
    let own = s.base.parameters.iter().enumerate();
    let releases: Vec<usize> =
        own.filter(|(_, p)| p.effect == Some("damping")).map(|(k, _)| k).collect();
    if s.base.mode.is_none() || releases.is_empty() {
        return Vec::new();
    }
    let mut formula = Formula::new("damping that grows with the speed").start(&[0.1]);
    formula.parameters = vec![Free::linear("growth", "1", 0.0, 100.0).step(1e-2)];
    formula.force = Some((Force::SpeedDamping, s.position.centre, s.position.half));
    formula.releases = releases;
    vec![formula]
}

/// Frequencies over the band of the log, even on a logarithmic scale.
fn frequencies(s: &Setting<'_>, count: usize) -> Vec<f64> {
    let (low, high) = ((5.0 / s.length).max(0.002 / s.sample), 0.4 / s.sample);
    (0..count).map(|k| low * (high / low).powf((k as f64 + 0.5) / count as f64)).collect()
}

/// A mode that the model lacks is lightly damped and lies apart from the model's own: a pair beside
/// that one would be a shift of it, and a well damped one a lag.
fn extra_mode(s: &Setting<'_>) -> Vec<Formula> {
    let (low, high) = (0.5 / s.length, 0.49 / s.sample);
    let bands = match s.resonance {
        Some(own) => vec![(1.15 * own, high), (low, 0.87 * own)],
        None => vec![(low, high)],
    };
    let damping = |name| Free::log(name, "1", 1e-3, 0.12);
    let mut all = Vec::new();
    for (low, high) in bands.into_iter().filter(|(low, high)| 1.1 * low < *high) {
        let starts: Vec<f64> =
            frequencies(s, 24).into_iter().filter(|f| *f > low && *f < high).collect();
        let frequency = || Free::log("frequency", "Hz", low, high).step(2e-3);
        let gain = Free::linear("gain", "1", -1.0, 1.0).step(1e-3);
        let ratio = Free::linear("zero over pole", "1", 0.5, 2.0).step(2e-3);
        all.push(
            Formula::new("parallel mode")
                .block(
                    Slot::AfterMechanics,
                    Block::ParallelMode,
                    vec![gain, frequency(), damping("damping")],
                )
                .starts(starts.iter().map(|f| vec![0.02, *f, 0.03]))
                .screened(2),
        );
        all.push(
            Formula::new("pair of pole and zero")
                .block(
                    Slot::AfterMechanics,
                    Block::PoleZero,
                    vec![frequency(), damping("damping"), ratio, damping("damping of the zero")],
                )
                .starts(starts.iter().map(|f| vec![*f, 0.02, 1.01, 0.02]))
                .screened(3),
        );
    }
    all.retain(|f| !f.starts.is_empty());
    all
}

fn duffing(s: &Setting<'_>) -> Vec<Formula> {
    let (c, h) = (s.position.centre, s.position.half);
    let cubic = || Free::linear("cubic stiffness", "1", -0.3, 3.0).step(1e-4);
    let square = Free::linear("quadratic stiffness", "1", -0.5, 0.5).step(1e-4);
    let mut first = Formula::new("cubic stiffness").start(&[0.005]);
    first.parameters = vec![cubic()];
    first.force = Some((Force::Cubic, c, h));
    let mut second = Formula::new("quadratic and cubic stiffness").start(&[0.0, 0.005]);
    second.parameters = vec![square, cubic()];
    second.force = Some((Force::Uneven, c, h));
    vec![first, second]
}

fn backlash(s: &Setting<'_>) -> Vec<Formula> {
    let h = s.position.half;
    let half = || Free::log("half width", "{position}", 1e-5 * h, 0.8 * h).step(0.05);
    let starts = || [0.003, 0.01, 0.03, 0.1].map(|k| vec![k * h]);
    vec![
        Formula::new("clearance before the mechanics")
            .block(Slot::BeforeMechanics, Block::Backlash, vec![half()])
            .starts(starts()),
        Formula::new("clearance behind the mechanics")
            .block(Slot::AfterMechanics, Block::Backlash, vec![half()])
            .starts(starts()),
    ]
}

fn friction(s: &Setting<'_>) -> Vec<Formula> {
    let h = s.position.half;
    let size = || Free::log("friction over stiffness", "{position}", 1e-5 * h, 0.5 * h);
    let distance = || Free::log("pre-sliding distance", "{position}", 1e-4 * h, h);
    let starts = || [0.01, 0.1].map(|k| vec![0.01 * h, k * h]);
    let series = Formula::new("pre-sliding spring, before the mechanics")
        .block(Slot::BeforeMechanics, Block::Dahl, vec![size(), distance()])
        .starts(starts());
    if s.base.mode.is_none() {
        return vec![series];
    }
    let mut inside = Formula::new("dry friction in the mode").starts(starts());
    inside.parameters = vec![size(), distance()];
    inside.force = Some((Force::Friction, s.position.centre, h));
    let mut coulomb = Formula::new("Coulomb friction in the mode")
        .starts([0.003, 0.02].map(|k| vec![0.005 * h, k * h]));
    // A bend so wide that no speed leaves it is damping.
    let smooth = Free::log("speed of full friction over ω", "{position}", 1e-4 * h, 0.03 * h);
    coulomb.parameters = vec![size(), smooth];
    coulomb.force = Some((Force::Coulomb, s.position.centre, h));
    // In series it would be a memory of the actuator.
    vec![inside, coulomb]
}

fn periodic(s: &Setting<'_>) -> Vec<Formula> {
    if s.lines.is_empty() {
        return Vec::new();
    }
    let resolution = 0.5 / s.length;
    let formula = |name, harmonics| {
        let frequency =
            Free::log("frequency", "Hz", resolution, 0.49 / s.sample).step(1e-3 * resolution);
        let mut f = Formula::new(name).starts(s.lines.iter().map(|f| vec![*f])).screened(0);
        f.parameters = vec![frequency];
        f.nuisance = Some(Nuisance::Lines { parameter: 0, harmonics });
        f
    };
    vec![formula("one line", 1), formula("line with two harmonics", 3)]
}

fn modulation(s: &Setting<'_>) -> Formula {
    let resolution = 0.5 / s.length;
    let frequency =
        Free::log("frequency", "Hz", resolution, 0.49 / s.sample).step(1e-3 * resolution);
    let mut f =
        Formula::new("gain that changes with time").starts(s.lines.iter().map(|f| vec![*f]));
    f.parameters = vec![frequency];
    f.nuisance = Some(Nuisance::Modulation { parameter: 0 });
    f
}

fn coupling(s: &Setting<'_>) -> Vec<Formula> {
    let mut all = Vec::new();
    for (k, aux) in s.data.aux.iter().enumerate().filter(|(_, a)| a.is_command) {
        let scale = aux.span.half / s.position.half;
        let weight = |name| Free::linear(name, "1", -2.0, 2.0).step(1e-3);
        let bandwidth = Free::log("bandwidth", "Hz", 1.0 / s.length, 10.0 / s.sample);
        let frequency = Free::log("frequency", "Hz", 1.0 / s.length, 0.45 / s.sample).step(2e-3);
        let damping = Free::log("damping", "1", 1e-3, 1.0);
        let pair = vec![weight("weight"), weight("weight of the rate")];
        all.extend([
            Formula::new("static, before the mechanics")
                .block(
                    Slot::BeforeMechanics,
                    Block::Aux { scale, rate: false },
                    vec![weight("weight")],
                )
                .aux(k)
                .start(&[0.0]),
            Formula::new("static and rate")
                .block(Slot::AfterMechanics, Block::Aux { scale, rate: true }, pair)
                .aux(k)
                .start(&[0.0, 0.0]),
            Formula::new("through a lag")
                .block(
                    Slot::AfterMechanics,
                    Block::LaggedAux { scale },
                    vec![weight("weight"), bandwidth],
                )
                .aux(k)
                .starts(super::input::bandwidths(s).into_iter().map(|f| vec![0.01, f])),
            Formula::new("through a mode")
                .block(
                    Slot::AfterMechanics,
                    Block::ModalAux { scale },
                    vec![weight("weight"), frequency, damping],
                )
                .aux(k)
                .starts(frequencies(s, 16).into_iter().map(|f| vec![0.01, f, 0.05]))
                .screened(2),
        ]);
    }
    all
}
