//! Mechanics and coupling.

use components::effects;
use model::Effect;
use surround::Block;

use super::Setting;
use crate::chain::Force;
use crate::chain::OWN_COMMAND;
use crate::formula::{Family, Formula, Free, Slot};
use crate::nuisance::Nuisance;
use crate::thresholds::search::Thresholds;

pub(super) fn add(s: &Setting<'_>, all: &mut Vec<Family>) {
    all.push(Family::new(&effects::RESONANCE_SHIFT, resonance(s)));
    all.push(Family::new(&effects::DAMPING, damping(s)));
    let mut family = Family::new(&effects::EXTRA_MODE, extra_mode(s));
    // A mode that its own command does not move is a coupling.
    family.nulls = shared_mode(s, false).into_iter().collect();
    all.push(family);
    if s.base.mode.is_some() {
        let mut family = Family::new(&effects::DUFFING, duffing(s));
        // A spring that is stiffer at every amplitude bends nothing, whether or not the gain goes with it.
        family.nulls = released(s, &effects::RESONANCE_SHIFT).into_iter().collect();
        family.nulls.extend(stiffness(s));
        all.push(family);
    }
    all.push(Family::new(&effects::BACKLASH, backlash(s)));
    let mut family = Family::new(&effects::FRICTION, friction(s));
    // What brakes at every speed alike is damping.
    family.nulls = released(s, &effects::DAMPING).into_iter().collect();
    all.push(family);
    let mut family = Family::new(&effects::PERIODIC_DISTURBANCE, periodic(s));
    // A line that grows with the position is a gain that changes, and no disturbance.
    family.nulls = vec![modulation(s)];
    all.push(family);
    all.push(Family::new(&effects::CROSS_COUPLING, coupling(s)));
}

/// The model's own parameters of an effect.
fn own(s: &Setting<'_>, effect: &Effect) -> Vec<usize> {
    let all = s.base.parameters.iter().enumerate();
    all.filter(|(_, p)| p.effect == Some(effect.name)).map(|(k, _)| k).collect()
}

/// Those without their tolerance, and nothing else.
pub(super) fn released(s: &Setting<'_>, effect: &Effect) -> Option<Formula> {
    let releases = own(s, effect);
    let formula = Formula::new("the model's own parameter").start(&[]);
    (!releases.is_empty()).then_some(Formula { releases, ..formula })
}

/// The model's own parameter; for a black box without one, or whose parameter may be another mode's: the poles of a
/// resonance moved, as a filter behind the model.
fn resonance(s: &Setting<'_>) -> Vec<Formula> {
    let mut all = stiffness(s);
    if s.base.is_white || (s.base.mode.is_some() && !all.is_empty()) {
        return all;
    }
    // A pair of poles far from the model's own is another mode, or a lag.
    let (low, high) = match s.resonance {
        Some(f) => (f / Thresholds::RESONANCE_FAR, f * Thresholds::RESONANCE_FAR),
        None => (0.5 / s.length, 0.45 / s.sample),
    };
    let parameters = vec![
        Free::log("frequency", "Hz", low, high),
        Free::log("damping", "1", 1e-3, 1.0),
        Free::linear("frequency of the model's resonance over it", "1", 0.5, 2.0).step(2e-3),
        Free::log("damping of the model's resonance", "1", 1e-3, 1.0),
    ];
    let inside = frequencies(s, 16).into_iter().filter(|f| *f > low && *f < high);
    let mut starts: Vec<Vec<f64>> = inside.map(|f| vec![f, 0.03, 1.02, 0.03]).collect();
    if let Some((f, damping)) = s.base.mode_values() {
        starts.extend([0.97, 1.03].map(|k| vec![k * f, damping, 1.0 / k, damping]));
    }
    all.push(
        Formula::new("poles moved, behind the model")
            .block(Slot::AfterMechanics, Block::PoleZero, parameters)
            .starts(starts)
            .screened(3),
    );
    all
}

/// A spring that is softer or stiffer moves the frequency and the static gain.
pub(super) fn stiffness(s: &Setting<'_>) -> Vec<Formula> {
    let releases = own(s, &effects::RESONANCE_SHIFT);
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
    let releases = own(s, &effects::DAMPING);
    if releases.is_empty() {
        return Vec::new();
    }
    // The damping of modes that no single place of the path holds.
    if s.base.mode.is_none() {
        return released(s, &effects::DAMPING).into_iter().collect();
    }
    let mut formula = Formula::new("damping that grows with the speed").start(&[0.1]);
    formula.parameters = vec![Free::linear("growth", "1", 0.0, 100.0).step(1e-2)];
    formula.force = Some((Force::SpeedDamping, s.position.centre, s.position.half));
    formula.releases = releases;
    vec![formula]
}

/// Frequencies over the band of the log, even on a logarithmic scale.
fn frequencies(s: &Setting<'_>, count: usize) -> Vec<f64> {
    let (low, high) = (
        (Thresholds::MODE_START_PERIODS / s.length).max(Thresholds::MODE_STARTS.0 / s.sample),
        Thresholds::MODE_STARTS.1 / s.sample,
    );
    (0..count).map(|k| low * (high / low).powf((k as f64 + 0.5) / count as f64)).collect()
}

/// Lowest and highest frequency of a mode, or a modulation, that the log can show.
fn band(s: &Setting<'_>) -> (f64, f64) {
    (Thresholds::MODE_PERIODS / s.length, Thresholds::MODE_HIGHEST / s.sample)
}

/// A mode that the model lacks is lightly damped and lies apart from the model's own: a pair beside
/// that one would be a shift of it, and a well damped one a lag.
fn extra_mode(s: &Setting<'_>) -> Vec<Formula> {
    let (low, high) = band(s);
    let bands = match s.resonance {
        Some(own) => {
            vec![(Thresholds::MODE_APART.1 * own, high), (low, Thresholds::MODE_APART.0 * own)]
        }
        None => vec![(low, high)],
    };
    let damping = |name| Free::log(name, "1", 1e-3, Thresholds::MODE_DAMPING);
    let mut all = Vec::new();
    for (low, high) in bands.into_iter().filter(|(low, high)| Thresholds::MODE_BAND * low < *high) {
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
                .screened(2)
                .inside()
                .resonates(1),
        );
        all.push(
            Formula::new("pair of pole and zero")
                .block(
                    Slot::AfterMechanics,
                    Block::PoleZero,
                    vec![frequency(), damping("damping"), ratio, damping("damping of the zero")],
                )
                .starts(starts.iter().map(|f| vec![*f, 0.02, 1.01, 0.02]))
                .screened(3)
                .inside()
                .resonates(0),
        );
    }
    all.extend(shared_mode(s, true));
    all.retain(|f| !f.starts.is_empty());
    all
}

/// A mode of a structure that all commands move, or all others: one frequency and damping, a weight for each command.
fn shared_mode(s: &Setting<'_>, by_own: bool) -> Option<Formula> {
    if let Some(joint) = s.base.joint() {
        return mode_of_joint(s, joint.other_axes().count(), by_own);
    }
    let neighbours: Vec<usize> =
        s.data.aux.iter().enumerate().filter(|(_, a)| a.is_command).map(|(k, _)| k).collect();
    let is_possible = (1..=Thresholds::SHARING_COMMANDS).contains(&neighbours.len());
    // The axes of a blueprint that nothing couples share no structure.
    if s.base.is_white || !is_possible {
        return None;
    }
    let count = usize::from(by_own) + neighbours.len();
    let mut formula = weighted_mode(s, "mode that all commands move", WEIGHTS.get(..count)?, 24);
    let own = by_own.then_some((OWN_COMMAND, s.command.half, 0.0));
    let others = neighbours.iter().map(|k| {
        let aux = &s.data.aux[*k];
        (*k, aux.span.half, aux.zero())
    });
    for (number, (aux, half, zero)) in own.into_iter().chain(others).enumerate() {
        let scale = half / s.position.half;
        let block = Block::ModalAuxiliary { scale, zero };
        let takes = vec![number, count, count + 1];
        formula = formula.sharing(Slot::AfterMechanics, block, takes).aux(aux);
    }
    Some(formula)
}

/// A mode with these weights, its frequency and its damping as parameters, and so many starts over the band.
fn weighted_mode(
    s: &Setting<'_>,
    name: &'static str,
    weights: &[&'static str],
    starts: usize,
) -> Formula {
    let count = weights.len();
    let (low, high) = band(s);
    let mut formula = Formula::new(name).screened(count).resonates(count);
    formula.starts_at_promise = true;
    let weight = |name: &&'static str| Free::linear(name, "1", -2.0, 2.0).step(1e-3);
    formula.parameters = weights.iter().map(weight).collect();
    formula.parameters.push(Free::log("frequency", "Hz", low, high).step(2e-3));
    formula.parameters.push(Free::log("damping", "1", 1e-3, Thresholds::MODE_DAMPING));
    let start = |f: f64| [vec![1e-3; count], vec![f, 0.03]].concat();
    formula.starts(frequencies(s, starts).into_iter().map(start))
}

/// A further mode of the coupling that joins several axes: all paths in front of it move it, or those of the others.
fn mode_of_joint(s: &Setting<'_>, others: usize, by_own: bool) -> Option<Formula> {
    let weights = WEIGHTS.get(usize::from(!by_own)..1 + others)?;
    let name = if by_own { "mode that all axes move" } else { "mode that the other axes move" };
    // A lightly damped mode is seen from a start within its width.
    let mut formula = weighted_mode(s, name, weights, 72);
    formula.joint_mode = Some(by_own);
    formula.is_fitted_anew = true;
    Some(formula)
}

/// Names of the weights of a mode that all commands move, the path's own command first.
const WEIGHTS: [&str; 1 + Thresholds::SHARING_COMMANDS] = [
    "weight",
    "weight of the second command",
    "weight of the third command",
    "weight of the fourth command",
];

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

/// Clearance before the mechanics, with these starts of its half width.
fn clearance(s: &Setting<'_>) -> Formula {
    let (half, starts) = half_width(s);
    Formula::new("clearance before the mechanics")
        .block(Slot::BeforeMechanics, Block::Backlash, vec![half])
        .starts(starts)
}

fn half_width(s: &Setting<'_>) -> (Free, [Vec<f64>; 4]) {
    let h = s.position.half;
    let half = Free::log("half width", "{position}", 1e-5 * h, 0.8 * h).step(0.05);
    (half, [0.003, 0.01, 0.03, 0.1].map(|k| vec![k * h]))
}

pub(super) fn backlash(s: &Setting<'_>) -> Vec<Formula> {
    let (half, starts) = half_width(s);
    let bridge = Free::linear("share within the clearance", "1", 0.0, 0.5).step(0.01);
    vec![
        clearance(s),
        Formula::new("clearance behind the mechanics")
            .block(Slot::AfterMechanics, Block::Backlash, vec![half.clone()])
            .starts(starts.clone()),
        Formula::new("clearance with a spring across it, before the mechanics")
            .block(Slot::BeforeMechanics, Block::BridgedBacklash, vec![half, bridge])
            .starts(starts.map(|start| vec![start[0], 0.1]))
            .inside(),
    ]
}

fn friction(s: &Setting<'_>) -> Vec<Formula> {
    let h = s.position.half;
    let size = || Free::log("friction over stiffness", "{position}", 1e-5 * h, 0.5 * h);
    let distance = || Free::log("pre-sliding distance", "{position}", 1e-4 * h, h);
    let starts = || [(0.01, 0.01), (0.01, 0.1), (0.001, 0.01)].map(|(a, d)| vec![a * h, d * h]);
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
        .starts([(0.005, 0.003), (0.005, 0.02), (0.0007, 0.003)].map(|(a, k)| vec![a * h, k * h]));
    // A bend so wide that no speed leaves it is damping.
    let smooth = Free::log("speed of full friction over ω", "{position}", 1e-4 * h, 0.03 * h);
    coulomb.parameters = vec![size(), smooth];
    coulomb.force = Some((Force::Coulomb, s.position.centre, h));
    // In series it would be a memory of the actuator.
    vec![inside, coulomb]
}

/// A spring whose own force has memory: a part of it, of a stiffness of its own, yields or hardens with the
/// way since the last reversal (Bouc-Wen). It bends over a good part of the range; what slides after a short
/// way is friction. With a part that depends on the size of more than 1 it would give back energy that it never took
/// (Erlicher and Point, 2004).
pub(super) fn hysteresis_of_the_spring(s: &Setting<'_>) -> Option<Formula> {
    s.base.mode?;
    let (c, h) = (s.position.centre, s.position.half);
    let mut formula = Formula::new("Bouc-Wen in the mode").screened(4).inside();
    formula.parameters = vec![
        Free::log("stiffness of the part with memory", "1", 1e-3, 10.0),
        Free::log("distance", "{position}", 0.1 * h, 30.0 * h),
        Free::linear("part that depends on the size", "1", -3.0, 1.0).step(0.02),
        Free::linear("stiffness beside the model's", "1", -0.9, 3.0).step(2e-3),
    ];
    formula.starts = [(0.1, 0.3), (0.3, 0.5), (0.3, 1.5)]
        .map(|(stiffness, d)| vec![stiffness, d * h, 0.0, -0.6 * stiffness])
        .to_vec();
    formula.force = Some((Force::BoucWen, c, h));
    formula.is_fitted_anew = true;
    Some(formula)
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
    let mut all = vec![formula("one line", 1), formula("line with two harmonics", 3)];
    let resolution = 1.0 / s.length;
    if let Some(fundamental) = fundamental(&s.lines, resolution) {
        let mut pulses = formula("pulses: line with nine harmonics", Thresholds::PULSE_LINES);
        pulses.starts = vec![vec![fundamental]];
        all.push(pulses);
    }
    all
}

/// The largest frequency of which most lines are multiples, where these are at least three and one of
/// them is above the third.
fn fundamental(lines: &[f64], resolution: f64) -> Option<f64> {
    let orders = |f: f64| -> Vec<f64> {
        let order = |line: &f64| {
            let order = (line / f).round();
            let is_near = (line - order * f).abs() < resolution * order.sqrt();
            (is_near && order <= Thresholds::PULSE_LINES as f64).then_some(order)
        };
        lines.iter().filter_map(order).collect()
    };
    // A train whose first line is hidden still has its second to fourth.
    let lowest = lines.iter().copied().fold(f64::INFINITY, f64::min);
    let all = (1..=Thresholds::PULSE_FIRST)
        .map(|part| lowest / f64::from(part))
        .filter(|f| *f > Thresholds::PULSE_RESOLVED * resolution);
    let most = |a: &f64, b: &f64| orders(*a).len().cmp(&orders(*b).len()).then(a.total_cmp(b));
    let best = all.max_by(most)?;
    let orders = orders(best);
    let (least, above) = Thresholds::PULSE_SEEN;
    (orders.len() >= least && orders.iter().any(|order| *order > above)).then_some(best)
}

fn modulation(s: &Setting<'_>) -> Formula {
    let (low, high) = band(s);
    let frequency = Free::log("frequency", "Hz", low, high).step(1e-3 * low);
    let mut f =
        Formula::new("gain that changes with time").starts(s.lines.iter().map(|f| vec![*f]));
    f.parameters = vec![frequency];
    f.nuisance = Some(Nuisance::Modulation { parameter: 0 });
    f
}

fn coupling(s: &Setting<'_>) -> Vec<Formula> {
    let joint = s.base.joint();
    let by_others = joint.and_then(|joint| mode_of_joint(s, joint.other_axes().count(), false));
    let mut all: Vec<Formula> = by_others.into_iter().collect();
    for (k, aux) in s.data.aux.iter().enumerate().filter(|(_, a)| a.is_command) {
        let (scale, zero) = (aux.span.half / s.position.half, aux.zero());
        let weight = |name| Free::linear(name, "1", -2.0, 2.0).step(1e-3);
        let bandwidth = Free::log("bandwidth", "Hz", 1.0 / s.length, 10.0 / s.sample);
        let frequency = Free::log("frequency", "Hz", 1.0 / s.length, 0.45 / s.sample).step(2e-3);
        let damping = Free::log("damping", "1", 1e-3, 1.0);
        let pair = vec![weight("weight"), weight("weight of the rate")];
        all.extend([
            Formula::new("static, before the mechanics")
                .block(
                    Slot::BeforeMechanics,
                    Block::Auxiliary { scale, zero },
                    vec![weight("weight")],
                )
                .aux(k)
                .start(&[0.0]),
            Formula::new("static and rate")
                .block(Slot::AfterMechanics, Block::Auxiliary { scale, zero }, pair)
                .aux(k)
                .start(&[0.0, 0.0]),
            Formula::new("through a lag")
                .block(
                    Slot::AfterMechanics,
                    Block::LaggedAuxiliary { scale, zero },
                    vec![weight("weight"), bandwidth],
                )
                .aux(k)
                .starts(super::input::bandwidths(s).into_iter().map(|f| vec![0.01, f])),
            Formula::new("through a mode")
                .block(
                    Slot::AfterMechanics,
                    Block::ModalAuxiliary { scale, zero },
                    vec![weight("weight"), frequency, damping],
                )
                .aux(k)
                .starts(frequencies(s, 16).into_iter().map(|f| vec![0.01, f, 0.05]))
                .screened(2),
        ]);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::fundamental;

    #[test]
    fn pulses_are_known_by_lines_that_are_multiples_of_one_frequency() {
        let near = |found: Option<f64>, wanted: f64| (found.unwrap() / wanted - 1.0).abs() < 1e-2;
        // In the order of their strength; the fifth is none where a fifth of the turn is on.
        assert!(near(fundamental(&[111.1, 37.05, 74.1, 148.2, 259.3], 0.5), 37.05));
        // The first line may be hidden under one of the command's.
        assert!(near(fundamental(&[74.1, 111.1, 148.2, 222.2, 259.3], 0.5), 37.05));
        assert_eq!(fundamental(&[50.3, 100.6, 150.9], 0.5), None, "two harmonics are no train");
        assert_eq!(fundamental(&[31.0, 74.1, 111.9], 0.5), None, "lines of their own");
        assert_eq!(fundamental(&[], 0.5), None);
    }
}
