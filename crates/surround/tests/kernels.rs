//! Every block: whole signals, single steps and a repaired FMU give the same bits, and a wrong number of parameters
//! is an error.

use components::hysteresis::LaggingPlay;
use model::{Range, Tick};
use surround::{
    Block, Effect, Force, Growth, Kernel, Loss, Memory, Operator, Original, Parameter, Piece, Port,
    Repair, Side, Signals, Span, State, Stepped, Surround, Variable, Wires,
};

const STEP: f64 = 1e-4;
const ROWS: usize = 4000;

/// Every block with parameters at which it acts.
fn all() -> Vec<(Block, Vec<f64>)> {
    let span = Span { centre: 0.5, half: 2.0 };
    let memory = Memory { r: vec![0.2, 0.7, 0.9, 1.1, 1.3], w: vec![0.3, 0.1, 0.05, -0.1, 0.2] };
    let half = span.half;
    let r = || memory.r.clone();
    let mode = |force| Block::ForcedMode { frequency: 300.0, damping: 0.05, force, far: 2.5 };
    let operators = Operator::all().map(|component| {
        let free = component.missing().free.iter();
        let p = free.map(|free| match free.range {
            Range::Between { lower, upper, .. } => 0.3 * lower + 0.7 * upper,
            Range::Growth => 1e-3,
            Range::Bandwidth => 200.0,
        });
        let p = p.collect();
        (Block::Operator { component, memory: memory.clone() }, p)
    });
    let operators: Vec<_> = operators.collect();
    let all = vec![
        (Block::Factor, vec![1.3]),
        (Block::Offset, vec![0.2]),
        (Block::Delay, vec![3.4 * STEP]),
        (Block::Delay, vec![0.2 * STEP]),
        (Block::Delay, vec![3.0 * STEP]),
        (Block::Rounding { half }, vec![40.0, 0.3]),
        (Block::MissingCodes { half, every: 5, missing: 3 }, vec![40.0, 0.3]),
        (Block::Lag { order: 1 }, vec![300.0]),
        (Block::Lag { order: 3 }, vec![700.0]),
        (Block::SecondOrder, vec![400.0, 0.6]),
        (Block::BeforeMode { frequency: 700.0, damping: 0.1 }, vec![]),
        (Block::Mode { frequency: 700.0, damping: 0.1 }, vec![]),
        (mode(Force::Cubic), vec![0.3]),
        (mode(Force::Uneven), vec![0.1, 0.3]),
        (mode(Force::Friction), vec![0.05, 0.1]),
        (mode(Force::SpeedDamping), vec![0.4]),
        (mode(Force::Coulomb), vec![0.05, 0.02]),
        (mode(Force::BoucWen), vec![0.4, 0.1, -0.5, -0.3]),
        (Block::Slew, vec![200.0]),
        (Block::UnevenSlew, vec![250.0, 0.6]),
        (Block::SoftSlew, vec![900.0, 500.0]),
        (Block::LimitAbove, vec![1.2]),
        (Block::LimitBelow, vec![-0.2]),
        (Block::Limits { centre: span.centre }, vec![0.9]),
        (Block::SoftLimitAbove, vec![1.2, 0.2]),
        (Block::KneeAbove, vec![1.0, 0.3]),
        (Block::Tanh(span), vec![0.8]),
        (Block::SCurve(span), vec![0.1, 0.2]),
        (Block::Gain, vec![0.13]),
        (Block::AgeingGain, vec![0.13, -0.02]),
        (Block::DeadZones(span), vec![0.2, -0.1]),
        (Block::Polynomial(span), vec![0.1, -0.2]),
        (Block::Polynomial(span), vec![0.1, -0.2, 0.05]),
        (Block::Sine(span), vec![0.1, 1.5, 0.3]),
        (Block::Creep, vec![0.02, 0.01, 0.05, 0.2]),
        (Block::LogCreep { longest: 1.0 }, vec![0.02, 1e-3]),
        (Block::PowerCreep { shortest: 1e-3, longest: 1.0 }, vec![0.02, 0.3]),
        (Block::FixedCreep { times: vec![0.01, 0.1] }, vec![0.02, 0.03]),
        (Block::Plays { r: r(), slope: false }, vec![0.3, -0.1, 0.2, 0.05, 0.1]),
        (Block::Plays { r: r(), slope: true }, vec![0.4, 0.3, -0.1, 0.2, 0.05, 0.1]),
        (Block::SkewedPlays { r: r(), span }, vec![0.3, -0.1, 0.2, 0.05, 0.1]),
        (Block::CurvedPlays { memory: memory.clone(), span }, vec![0.4]),
        (
            Block::BentPlays { memory: memory.clone(), span },
            vec![0.1, -0.2, 0.04, 0.05, 0.3, -0.1, 0.02],
        ),
        (Block::RatePlays(memory.clone()), vec![1e-3]),
        (growing(&memory, Growth::Limited, Some(3.0 * STEP)), vec![0.8, 0.4]),
        (growing(&memory, Growth::Logarithmic, None), vec![0.5, 0.2, 7.0 * STEP]),
        (Block::LaggedPlays(memory.clone()), vec![200.0]),
        (Block::RateMemory { memory, half, smoothing: 9.0 * STEP }, vec![2e-3]),
        (Block::BoucWen, vec![0.3, 0.7, 0.6]),
        (Block::GeneralisedPlay(span), vec![0.3, 0.2, 0.1, 0.05]),
        (Block::Heating { half, loss: Loss::Rate { mean: 1e4 } }, vec![0.1, 0.05]),
        (Block::HeatingGain { loss: Loss::Loops { mean: 1e3, centre: 0.5 } }, vec![0.1, 0.05]),
        (
            Block::Warming { half, loss: Loss::Apparent { mean: 1e3 }, times: vec![0.02, 0.1] },
            vec![0.1, 0.05, 0.03],
        ),
        (Block::ParallelMode, vec![0.1, 600.0, 0.03]),
        (Block::ParallelMode, vec![1.2, 600.0, 0.03]),
        (Block::PoleZero, vec![500.0, 0.02, 1.1, 0.03]),
        (Block::Backlash, vec![0.3]),
        (Block::BridgedBacklash, vec![0.3, 0.2]),
        (Block::Dahl, vec![0.1, 0.2]),
        (Block::Auxiliary { scale: 2.0, zero: 0.1 }, vec![0.3]),
        (Block::Auxiliary { scale: 2.0, zero: 0.1 }, vec![0.3, 0.1]),
        (Block::LaggedAuxiliary { scale: 2.0, zero: 0.1 }, vec![0.3, 200.0]),
        (Block::ModalAuxiliary { scale: 2.0, zero: 0.1 }, vec![0.3, 200.0, 0.05]),
        (Block::FeedThrough { scale: 2.0, time: 1e-3 }, vec![0.3, 0.2]),
    ];
    all.into_iter().chain(operators).collect()
}

fn growing(memory: &Memory, law: Growth, smoothing: Option<f64>) -> Block {
    Block::GrowingPlays { memory: memory.clone(), law, scale: 400.0, smoothing }
}

/// How many numbers of parameters a block takes. A new block must be added here and in [`all`].
fn takes(block: &Block, given: usize) -> bool {
    let count = match block {
        Block::Polynomial(_) => return given >= 1,
        Block::Creep => return given >= 2 && given.is_multiple_of(2),
        Block::Auxiliary { .. } => return given == 1 || given == 2,
        Block::FixedCreep { times } => times.len(),
        Block::Operator { component, .. } => component.missing().free.len(),
        Block::Warming { times, .. } => times.len() + 1,
        Block::Plays { r, slope } => r.len() + usize::from(*slope),
        Block::SkewedPlays { r, .. } => r.len(),
        Block::ForcedMode { force, .. } => force.count(),
        Block::BeforeMode { .. } | Block::Mode { .. } => 0,
        Block::Factor
        | Block::Offset
        | Block::RatePlays(_)
        | Block::LaggedPlays(_)
        | Block::RateMemory { .. }
        | Block::Delay
        | Block::Lag { .. }
        | Block::Slew
        | Block::LimitAbove
        | Block::LimitBelow
        | Block::Limits { .. }
        | Block::Tanh(_)
        | Block::Gain
        | Block::CurvedPlays { .. }
        | Block::Backlash => 1,
        Block::Rounding { .. }
        | Block::MissingCodes { .. }
        | Block::SecondOrder
        | Block::SoftSlew
        | Block::UnevenSlew
        | Block::AgeingGain
        | Block::SoftLimitAbove
        | Block::KneeAbove
        | Block::SCurve(_)
        | Block::DeadZones(_)
        | Block::LogCreep { .. }
        | Block::PowerCreep { .. }
        | Block::Heating { .. }
        | Block::HeatingGain { .. }
        | Block::Dahl
        | Block::BridgedBacklash
        | Block::LaggedAuxiliary { .. }
        | Block::FeedThrough { .. } => 2,
        Block::Sine(_) | Block::ParallelMode | Block::ModalAuxiliary { .. } | Block::BoucWen => 3,
        Block::GrowingPlays { smoothing, .. } => 2 + usize::from(smoothing.is_none()),
        Block::PoleZero | Block::GeneralisedPlay(_) => 4,
        Block::BentPlays { .. } => 7,
    };
    given == count
}

fn signal(seed: f64) -> Vec<f64> {
    let at = |n: usize| {
        let t = n as f64 * STEP;
        1.5 * (40.0 * t + seed).sin() + (311.0 * t * (1.0 + seed)).sin() + 0.2 * seed
    };
    (0..ROWS).map(at).collect()
}

/// Path, drive and auxiliary signal.
fn signals() -> [Vec<f64>; 3] {
    [signal(0.1), signal(0.7), signal(1.3)]
}

fn wires([x, drive, aux]: &[Vec<f64>; 3], n: usize) -> Wires {
    Wires { x: x[n], drive: drive[n], aux: aux[n] }
}

fn complete(kernel: &Kernel, [x, drive, aux]: &[Vec<f64>; 3]) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    kernel.run(Signals { x, drive, aux }, &mut out);
    out
}

/// A repaired FMU's effect that is this block behind the original; inputs are the drive and the auxiliary signal.
fn repair(block: &Block, p: &[f64]) -> Repair {
    let variable = |reference| Variable { reference, start: vec![0.0] };
    let port = |reference: u32| Port {
        name: reference.to_string(),
        variable: variable(reference),
        element: 0,
        own: false,
        unit: "1".to_owned(),
        factor: 1.0,
        offset: 0.0,
    };
    let parameter = |(k, start): (usize, &f64)| Parameter {
        name: format!("p{k}"),
        description: String::new(),
        unit: "1".to_owned(),
        factor: 1.0,
        start: *start,
        min: None,
        max: None,
        reference: 10 + k as u32,
    };
    let piece = Piece {
        side: Side::Output,
        port: 0,
        drive: 0,
        auxiliary: Some(1),
        place: 0,
        parameters: (0..p.len()).collect(),
        block: block.clone(),
    };
    let effect = Effect {
        name: "effect".to_owned(),
        description: String::new(),
        enabled: true,
        reference: 4,
        parameters: p.iter().enumerate().map(parameter).collect(),
        blocks: vec![piece],
    };
    let text = || "1".to_owned();
    Repair {
        format: surround::FORMAT,
        token: text(),
        step: STEP,
        divide: true,
        original: Original { fmi: text(), identifier: text(), token: text(), sha256: text() },
        inputs: vec![port(1), port(2)],
        outputs: vec![port(3)],
        changes: Vec::new(),
        effects: vec![effect],
        sizes: Vec::new(),
        presets: Vec::new(),
    }
}

#[track_caller]
fn same_bits(block: &Block, one: &[f64], other: &[f64]) {
    let differs = one.iter().zip(other).position(|(a, b)| a.to_bits() != b.to_bits());
    if let Some(n) = differs {
        panic!("{block:?} at {n}: {} and {}", one[n], other[n]);
    }
    assert_eq!(one.len(), other.len());
}

#[test]
fn a_repaired_fmu_computes_what_whole_signals_give_bit_for_bit() {
    let all_signals = signals();
    for (block, p) in all() {
        let kernel = block.prepare(&p, STEP).unwrap();
        let wanted = complete(&kernel, &all_signals);
        let mut fmu = Surround::new(repair(&block, &p)).unwrap();
        let mut shown = Vec::new();
        for n in 0..ROWS {
            let w = wires(&all_signals, n);
            fmu.take(1, &[w.drive]);
            fmu.take(2, &[w.aux]);
            if n == 0 {
                fmu.rest_inputs()
            } else {
                fmu.step_inputs(STEP)
            }
            fmu.outputs()[0].inner[0] = w.x;
            if n == 0 {
                fmu.rest_outputs()
            } else {
                fmu.step_outputs(STEP)
            }
            shown.push(fmu.shown(3).unwrap()[0]);
        }
        same_bits(&block, &shown, &wanted);
        let acts = wanted.iter().zip(&all_signals[0]).any(|(y, x)| (y - x).abs() > 1e-3);
        assert!(acts, "{block:?} does nothing in this test");
    }
}

/// What a diagnosis hands back are these components with these values.
#[test]
fn a_block_that_is_a_component_is_that_component_bit_for_bit() {
    let all_signals = signals();
    let mut count = 0;
    for (block, p) in all() {
        let kernel = block.prepare(&p, STEP).unwrap();
        let components = kernel.components();
        if components.is_empty() {
            continue;
        }
        count += 1;
        let mut path = all_signals[0].clone();
        for Stepped { component, structure, parameters } in components {
            let sizes = component.sizes(structure, STEP);
            let (mut coefficients, mut state) =
                (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
            component.prepare(structure, parameters, STEP, &mut coefficients).unwrap();
            for (n, x) in path.iter_mut().enumerate() {
                let inputs = [*x, all_signals[1][n]];
                let inputs = &inputs[..component.declaration().inputs.len()];
                let mut y = [0.0];
                let tick = Tick { index: n as u64, time: n as f64 * STEP, period: STEP };
                match n {
                    0 => component.rest(&coefficients, inputs, &mut state, &mut y),
                    _ => component.step(&coefficients, &mut state, tick, inputs, &mut y),
                }
                [*x] = y;
            }
        }
        same_bits(&block, &path, &complete(&kernel, &all_signals));
    }
    assert!(count > 21, "only {count} blocks are components");
}

#[test]
fn a_wrong_number_of_parameters_is_an_error_for_every_block() {
    for (block, p) in all() {
        assert!(takes(&block, p.len()), "{block:?}");
        for given in 0..=p.len() + 2 {
            let parameters: Vec<f64> =
                (0..given).map(|k| p.get(k).copied().unwrap_or(1.0)).collect();
            let prepared = block.prepare(&parameters, STEP);
            assert_eq!(prepared.is_ok(), takes(&block, given), "{block:?} with {given}");
            let read = Surround::new(repair(&block, &parameters));
            assert_eq!(read.is_ok(), takes(&block, given), "{block:?} with {given} in a file");
            if let (Err(wrong), Err(error)) = (prepared, read) {
                assert_eq!(wrong.given, given);
                let text = format!("effect: {given} parameters instead of {}", wrong.wanted);
                assert!(error.to_string().contains(&text), "{error}");
            }
        }
    }
}

#[test]
fn a_saved_state_goes_on_to_the_same_bits() {
    let all_signals = signals();
    for (block, p) in all() {
        let kernel = block.prepare(&p, STEP).unwrap();
        let mut state = State::default();
        assert!(!kernel.fits(&state) || kernel.map(0.0).is_some() || block == Block::AgeingGain);
        kernel.rest(wires(&all_signals, 0), &mut state);
        let at = |n: usize| n as f64 * STEP;
        for n in 1..1000 {
            kernel.step(wires(&all_signals, n), at(n), &mut state);
        }
        let mut numbers = Vec::new();
        state.save(&mut numbers);
        let mut other = State::load(&mut numbers.into_iter()).expect("it reads");
        assert!(kernel.fits(&other), "{block:?}");
        for n in 1000..1500 {
            let a = kernel.step(wires(&all_signals, n), at(n), &mut state);
            let b = kernel.step(wires(&all_signals, n), at(n), &mut other);
            assert_eq!(a.to_bits(), b.to_bits(), "{block:?} at {n}");
        }
    }
}

#[test]
fn a_step_of_another_length_goes_on_from_the_state() {
    let all_signals = signals();
    for (block, p) in all() {
        let mut kernel = block.prepare(&p, STEP).unwrap();
        let half = block.prepare(&p, 0.5 * STEP).unwrap();
        let mut state = State::default();
        kernel.rest(wires(&all_signals, 0), &mut state);
        let mut t = 0.0;
        for n in 1..500 {
            let w = wires(&all_signals, n);
            let mut other = state.clone();
            let (dt, expected) = if n % 3 == 0 { (0.5 * STEP, Some(&half)) } else { (STEP, None) };
            t += dt;
            kernel.set_step(dt);
            let y = kernel.step(w, t, &mut state);
            if let Some(half) = expected {
                assert_eq!(y.to_bits(), half.step(w, t, &mut other).to_bits(), "{block:?} at {n}");
            }
        }
    }
}

#[test]
fn a_mode_that_is_taken_out_and_put_in_again_changes_nothing() {
    let prepare = |block: Block| block.prepare(&[], STEP).unwrap();
    let mut before = prepare(Block::BeforeMode { frequency: 800.0, damping: 0.02 });
    let mut mode = prepare(Block::Mode { frequency: 800.0, damping: 0.02 });
    let (mut a, mut b) = (State::default(), State::default());
    for (n, x) in signal(0.3).into_iter().enumerate() {
        // Steps of several lengths.
        let dt = STEP * if n % 3 == 0 { 0.5 } else { 1.0 };
        before.set_step(dt);
        mode.set_step(dt);
        let wires = |x| Wires { x, ..Wires::default() };
        let y = match n {
            0 => mode.rest(wires(before.rest(wires(x), &mut a)), &mut b),
            _ => mode.step(wires(before.step(wires(x), 0.0, &mut a)), 0.0, &mut b),
        };
        assert!((y - x).abs() < 1e-9, "at {n}: {y} and {x}");
    }
}

#[test]
fn files_that_earlier_versions_wrote_are_read() {
    #[derive(Debug, serde::Deserialize, serde::Serialize)]
    struct File {
        block: Block,
    }
    let read = |text: &str| toml::from_str::<File>(&format!("[block]\n{text}")).map(|f| f.block);
    let span = Span { centre: 0.5, half: 2.0 };
    let memory = Memory { r: vec![0.2, 0.7], w: vec![0.3, 0.1] };
    let range = "centre = 0.5\nhalf = 2.0\n";
    let plays = "r = [0.2, 0.7]\nw = [0.3, 0.1]\n";
    for (text, wanted) in [
        (format!("kind = \"tanh\"\n{range}"), Block::Tanh(span)),
        (format!("kind = \"s-curve\"\n{range}"), Block::SCurve(span)),
        (format!("kind = \"dead-zones\"\n{range}"), Block::DeadZones(span)),
        (format!("kind = \"polynomial\"\n{range}"), Block::Polynomial(span)),
        (format!("kind = \"sine\"\n{range}"), Block::Sine(span)),
        (format!("kind = \"generalised-play\"\n{range}"), Block::GeneralisedPlay(span)),
        (
            format!("kind = \"skewed-plays\"\nr = [0.2, 0.7]\n{range}"),
            Block::SkewedPlays { r: memory.r.clone(), span },
        ),
        (
            format!("kind = \"curved-plays\"\n{plays}{range}"),
            Block::CurvedPlays { memory: memory.clone(), span },
        ),
        (
            format!("kind = \"bent-plays\"\n{plays}{range}"),
            Block::BentPlays { memory: memory.clone(), span },
        ),
        (format!("kind = \"rate-plays\"\n{plays}"), Block::RatePlays(memory.clone())),
        (format!("kind = \"lagged-plays\"\n{plays}"), Block::LaggedPlays(memory.clone())),
        (
            format!("kind = \"operator\"\ncomponent = \"lagging-play\"\n{plays}"),
            Block::Operator {
                component: Operator::of(&LaggingPlay).unwrap(),
                memory: memory.clone(),
            },
        ),
        (
            format!("kind = \"growing-plays\"\n{plays}law = \"limited\"\nscale = 400.0\nsmoothing = 0.003\n"),
            growing(&memory, Growth::Limited, Some(0.003)),
        ),
        (
            format!("kind = \"growing-plays\"\n{plays}law = \"logarithmic\"\nscale = 400.0\n"),
            growing(&memory, Growth::Logarithmic, None),
        ),
        (
            format!("kind = \"rate-memory\"\n{plays}half = 2.0\nsmoothing = 0.01\n"),
            Block::RateMemory { memory: memory.clone(), half: 2.0, smoothing: 0.01 },
        ),
        (
            "kind = \"heating\"\nhalf = 2.0\n[block.loss]\nof = \"loops\"\nmean = 3.0\ncentre = 0.5\n".to_owned(),
            Block::Heating { half: 2.0, loss: Loss::Loops { mean: 3.0, centre: 0.5 } },
        ),
    ] {
        assert_eq!(read(&text).unwrap(), wanted);
        let written = toml::to_string(&File { block: wanted }).unwrap();
        assert_eq!(written, format!("[block]\n{}", text.replace("[block.loss]", "\n[block.loss]")));
        let with = format!("edge = 1.0\n{text}");
        assert!(read(&with).unwrap_err().to_string().contains("edge"), "{with}");
    }
}
