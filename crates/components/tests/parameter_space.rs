//! What holds over the whole parameter space of every component, not at one example of each: finite
//! stays finite, passive components add no energy, operators forget what their theory says.
//!
//! `PIEZOLOOP_DRAWS=20000 cargo test --release -p piezoloop-components --test parameter_space` draws
//! more.
#![allow(clippy::print_stdout)]

use components::{COMPONENTS, find};
use model::{Component, Quantity, Tick};
use numerics::random::SplitMix64;

const T: f64 = 5e-5;

struct Dice(SplitMix64);

impl Dice {
    fn new(seed: u64) -> Self {
        Self(SplitMix64::from_state(seed))
    }
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }
    fn below(&mut self, n: usize) -> usize {
        (self.0.bits() % n as u64) as usize
    }
    /// Positive, each decade alike.
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(self.between(low.log10(), high.log10()))
    }
}

fn draws() -> usize {
    std::env::var("PIEZOLOOP_DRAWS").ok().and_then(|n| n.parse().ok()).unwrap_or(1500)
}

/// A value within the declared bounds: the bounds themselves, zero, or a number of any decade.
fn value(dice: &mut Dice, quantity: &Quantity) -> f64 {
    let (min, max) = (quantity.min.max(-1e6), quantity.max.min(1e6));
    let any = match dice.below(12) {
        0 => min,
        1 => max,
        2 => 0.0,
        3 => 1.0,
        4 => dice.between(min, max),
        _ => {
            let sign = if min < 0.0 && dice.below(2) == 0 { -1.0 } else { 1.0 };
            sign * dice.decades(1e-6, 1e4)
        }
    };
    any.clamp(min, max)
}

/// Structure and parameters, sorted where the rules want rising thresholds, some of the time.
fn drawn(dice: &mut Dice, component: &dyn Component) -> (Vec<f64>, Vec<f64>) {
    let declaration = component.declaration();
    let structure: Vec<f64> = declaration
        .structure
        .iter()
        .map(|setting| {
            // Lengths of memory stay short: what is tried are numbers, not gigabytes.
            let (min, max) =
                (setting.min, setting.max.min(if setting.integer { 6.0 } else { 0.02 }));
            let x = dice.between(min, max.max(min));
            if setting.integer { x.round() } else { x }
        })
        .collect();
    // The square of the number of axes, where a matrix is as long.
    let structure = match structure.as_slice() {
        [axes, _] if declaration.is_coupling() => {
            let axes = if declaration.structure[1].name.is_empty() { *axes } else { 2.0 };
            vec![axes, 4.0]
        }
        _ if declaration.is_coupling() && structure.len() == 1 => vec![2.0],
        // A matrix per mode.
        [_, _, modes, _] if matches!(declaration.kind, "modal-matrix" | "softening-modes") => {
            vec![2.0, 4.0, *modes, 4.0 * modes]
        }
        _ => structure,
    };
    let mut values = Vec::new();
    for (index, quantity) in declaration.parameters.iter().enumerate() {
        let count = declaration.length(index, &structure);
        let mut some: Vec<f64> = (0..count).map(|_| value(dice, quantity)).collect();
        if count > 1 && dice.below(3) > 0 {
            some.sort_by(f64::total_cmp);
        }
        values.extend(some);
    }
    (structure, values)
}

fn input_count(component: &dyn Component) -> usize {
    let times = |source| match source {
        model::Source::EachPath | model::Source::Each(_) => 2,
        _ => 1,
    };
    component.declaration().inputs.iter().map(|port| times(port.source)).sum()
}

fn output_count(component: &dyn Component) -> usize {
    let declaration = component.declaration();
    declaration.outputs.len() * if declaration.is_coupling() { 2 } else { 1 }
}

/// A component at work.
struct Live<'a> {
    component: &'a dyn Component,
    coefficients: Vec<f64>,
    state: Vec<f64>,
    outputs: Vec<f64>,
    index: u64,
}

impl<'a> Live<'a> {
    /// At rest under these inputs; `None` where the parameters break a rule.
    fn new(
        component: &'a dyn Component,
        structure: &[f64],
        values: &[f64],
        inputs: &[f64],
    ) -> Option<Self> {
        let sizes = component.sizes(structure, T);
        let mut coefficients = vec![0.0; sizes.coefficients];
        component.prepare(structure, values, T, &mut coefficients).ok()?;
        let mut live = Self {
            component,
            coefficients,
            state: vec![0.0; sizes.states],
            outputs: vec![0.0; output_count(component)],
            index: 0,
        };
        component.rest(&live.coefficients, inputs, &mut live.state, &mut live.outputs);
        Some(live)
    }

    fn step(&mut self, inputs: &[f64]) -> f64 {
        self.index += 1;
        let tick = Tick { index: self.index, time: self.index as f64 * T, period: T };
        self.component.step(&self.coefficients, &mut self.state, tick, inputs, &mut self.outputs);
        self.outputs[0]
    }
}

/// Laws and filters that may be unstable by their parameters' own meaning: their outputs may grow
/// without bound, and the system then ends the run with an error that names the output.
const MAY_GROW: [&str; 10] = [
    "arx",
    "pid",
    "incremental-pid",
    "repetitive",
    "disturbance-observer",
    "bouc-wen-feedforward",
    "inverse-kelvin-voigt-creep",
    "actuator-ageing",
    "thermal-drift",
    "sensor-drift",
];

/// Rules tie their parameters together (stability, zeros on the diagonal, a delay that fits), so that hardly
/// a set drawn blindly is within them; `every_component` tries an example of each.
const TIED: [&str; 6] = [
    "arx",
    "command-coupling",
    "displacement-coupling",
    "mode-coupling",
    "preview-coordinator",
    "repetitive",
];

#[test]
fn finite_inputs_give_finite_outputs_wherever_the_parameters_are() {
    let (mut never, mut wrong) = (Vec::new(), Vec::new());
    let (mut all, mut accepted) = (0, 0);
    for component in COMPONENTS.iter().copied() {
        let kind = component.declaration().kind;
        let mut dice = Dice::new(kind.bytes().map(u64::from).sum());
        let mut taken = 0;
        for draw in 0..draws() {
            let (structure, values) = drawn(&mut dice, component);
            let count = input_count(component);
            let scale = dice.decades(1e-9, 1e3);
            let mut inputs: Vec<f64> =
                (0..count).map(|_| scale * dice.between(-1.0, 1.0)).collect();
            let Some(mut live) = Live::new(component, &structure, &values, &inputs) else {
                continue;
            };
            taken += 1;
            for step in 0..200 {
                // Jumps, ramps and rests.
                if dice.below(3) > 0 {
                    let which = dice.below(count.max(1));
                    if let Some(input) = inputs.get_mut(which) {
                        *input = scale * dice.between(-1.0, 1.0);
                    }
                }
                live.step(&inputs);
                let finite = live.outputs.iter().all(|y| y.is_finite());
                if !finite && !MAY_GROW.contains(&kind) && !wrong.iter().any(|(k, _)| *k == kind) {
                    let what = format!(
                        "draw {draw}, step {step}: {:?} from {inputs:?} with {structure:?} {values:?}",
                        live.outputs
                    );
                    wrong.push((kind, what));
                }
                if !finite {
                    break;
                }
            }
        }
        (all, accepted) = (all + draws(), accepted + taken);
        if taken < draws() / 200 && !TIED.contains(&kind) {
            never.push((kind, taken));
        }
    }
    println!("{all} parameter sets drawn, {accepted} within the rules");
    for (kind, what) in &wrong {
        println!("{kind}: {what}");
    }
    assert!(wrong.is_empty(), "{} components", wrong.len());
    assert!(never.is_empty(), "hardly a parameter set was within the rules: {never:?}");
}

/// Greatest ratio of a second-order system's output to its input, in the maximum norm:
/// `coth(πζ / (2√(1−ζ²)))`, the integral over |impulse response|.
fn second_order_gain(damping: f64) -> f64 {
    if damping >= 1.0 {
        return 1.0;
    }
    1.0 / (core::f64::consts::PI * damping / (2.0 * (1.0 - damping * damping).sqrt())).tanh()
}

#[test]
fn passive_components_add_no_energy() {
    let mut dice = Dice::new(7);
    for _ in 0..draws() {
        let (damping, gain) = (dice.decades(1e-3, 1.5), dice.decades(1e-2, 1e2));
        let frequency = dice.decades(10.0, 0.4 / T);
        for (kind, values, bound) in [
            ("mode", vec![frequency, damping, gain], gain * second_order_gain(damping)),
            ("sensor-second-order", vec![frequency, damping], second_order_gain(damping)),
            (
                "amplifier-second-order",
                vec![frequency, damping, gain],
                gain * second_order_gain(damping),
            ),
            ("amplifier-lag", vec![frequency, gain], gain),
            ("sensor-lag", vec![frequency], 1.0),
        ] {
            let component = find(kind).unwrap();
            let Some(mut live) = Live::new(component, &[], &values, &[0.0]) else { continue };
            let mut most: f64 = 0.0;
            let mut input = 1.0;
            for step in 0..2000 {
                // Bang-bang at any rate is the worst that a bounded input can do.
                if dice.below(20) == 0
                    || (step as f64 * T * frequency * 2.0).fract() < T * frequency * 2.0
                {
                    input = -input;
                }
                most = most.max(live.step(&[input]).abs());
            }
            assert!(most <= bound * 1.02 + 1e-9, "{kind} {values:?}: {most}, bound {bound}");
            // Left alone, no later swing is larger than the first ones, up to what sampling hides of a peak.
            let length = ((1.0 / (T * frequency)).ceil() as usize).max(400);
            let windows: Vec<f64> = (0..6)
                .map(|_| (0..length).map(|_| live.step(&[0.0]).abs()).fold(0.0, f64::max))
                .collect();
            for later in &windows[1..] {
                assert!(*later <= windows[0] * 1.02 + 1e-12, "{kind} {values:?}: {windows:?}");
            }
        }
    }
}

/// An operator with random parameters: kind, structure, parameters, greatest threshold.
fn operator(dice: &mut Dice) -> (&'static str, Vec<f64>, Vec<f64>) {
    let plays = 1 + dice.below(6);
    let mut thresholds: Vec<f64> = (0..plays).map(|_| dice.between(0.0, 40.0)).collect();
    thresholds.sort_by(f64::total_cmp);
    let weights: Vec<f64> = (0..plays).map(|_| dice.decades(1e-3, 1.0)).collect();
    match dice.below(2) {
        0 => {
            let offset = vec![dice.between(-1.0, 1.0)];
            ("prandtl-ishlinskii", vec![plays as f64], [thresholds, weights, offset].concat())
        }
        _ => {
            // Weights of the cells of a triangle with `levels` levels, bounds, offset.
            let declaration = find("preisach").unwrap().declaration();
            let levels = 1 + dice.below(5);
            let cells = levels * (levels + 1) / 2;
            let structure = vec![cells as f64];
            let mut values = Vec::new();
            for (index, quantity) in declaration.parameters.iter().enumerate() {
                let count = declaration.length(index, &structure);
                values.extend((0..count).map(|_| match quantity.name {
                    "low" => -100.0,
                    "high" => 100.0,
                    _ => dice.decades(1e-3, 1.0),
                }));
            }
            ("preisach", structure, values)
        }
    }
}

/// The outputs at the inputs in turn, each input reached in some steps.
fn played(live: &mut Live<'_>, from: f64, inputs: &[f64]) -> Vec<f64> {
    let mut last = from;
    let play = |live: &mut Live<'_>, last: &mut f64, to: f64| {
        let mut y = f64::NAN;
        for part in 1..=7 {
            y = live.step(&[*last + (to - *last) * f64::from(part) / 7.0]);
        }
        *last = to;
        y
    };
    inputs.iter().map(|to| play(live, &mut last, *to)).collect()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + a.abs())
}

#[test]
fn operators_forget_what_a_larger_excursion_wipes_out() {
    let mut dice = Dice::new(11);
    let mut done = 0;
    for _ in 0..draws() {
        let (kind, structure, values) = operator(&mut dice);
        let component = find(kind).unwrap();
        let some = |dice: &mut Dice| (0..6).map(|_| dice.between(-60.0, 60.0)).collect::<Vec<_>>();
        let (one, other, then) = (some(&mut dice), some(&mut dice), some(&mut dice));
        let mut after = Vec::new();
        for history in [&one, &other] {
            let Some(mut live) = Live::new(component, &structure, &values, &[0.0]) else { break };
            // Beyond all thresholds up and down: nothing is left of the history.
            played(&mut live, 0.0, &[history.as_slice(), &[-99.9, 99.9]].concat());
            after.push(played(&mut live, 99.9, &then));
        }
        let [a, b] = after.as_slice() else { continue };
        done += 1;
        assert!(a.iter().zip(b).all(|(a, b)| close(*a, *b)), "{kind} {values:?}: {a:?} {b:?}");
    }
    assert!(done > draws() / 3, "{done} operators of {}", draws());
}

#[test]
fn minor_loops_close_and_are_congruent() {
    let mut dice = Dice::new(13);
    let mut done = 0;
    for _ in 0..draws() {
        let (kind, structure, values) = operator(&mut dice);
        let component = find(kind).unwrap();
        let (low, high) = (dice.between(-60.0, 0.0), dice.between(0.0, 60.0));
        let mut heights = Vec::new();
        for history in [[-90.0, 90.0, 61.0], [90.0, -90.0, 61.0]] {
            let Some(mut live) = Live::new(component, &structure, &values, &[0.0]) else { break };
            played(&mut live, 0.0, &history);
            // Down to the loop's lower end, round it twice: return-point memory closes it.
            let y = played(&mut live, 61.0, &[low, high, low, high, low]);
            assert!(close(y[1], y[3]) && close(y[2], y[4]), "{kind} {values:?}: {y:?}");
            heights.push(y[3] - y[2]);
        }
        let [a, b] = heights.as_slice() else { continue };
        done += 1;
        assert!(close(*a, *b), "{kind} {values:?}: {a} {b}");
    }
    assert!(done > draws() / 3, "{done} operators of {}", draws());
}

#[test]
fn results_are_the_same_bits_in_every_run_and_thread() {
    let run = || {
        let mut sum = Vec::new();
        for component in COMPONENTS.iter().copied() {
            let mut dice = Dice::new(17);
            for _ in 0..40 {
                let (structure, values) = drawn(&mut dice, component);
                let inputs: Vec<f64> =
                    (0..input_count(component)).map(|_| dice.0.uniform()).collect();
                let Some(mut live) = Live::new(component, &structure, &values, &inputs) else {
                    continue;
                };
                for _ in 0..50 {
                    live.step(&inputs);
                }
                sum.extend(live.outputs.iter().map(|y| y.to_bits()));
            }
        }
        sum
    };
    let alone = run();
    let threads: Vec<_> = (0..4).map(|_| std::thread::spawn(run)).collect();
    for thread in threads {
        assert!(thread.join().unwrap() == alone);
    }
}
