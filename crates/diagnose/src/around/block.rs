//! A block of the search as one that steps.

use surround::Block as Around;

use crate::block::{Block, GROWING, Loss, Memory, SATURATING, Span};
use crate::library::Piece;
use crate::outcome::Outcome;

/// The block that does step by step what this one does over a whole signal; none for what belongs
/// to a record and not to the machine.
pub(crate) fn around(o: &Outcome, piece: &Piece) -> Option<Around> {
    let zero = o.problem.data.aux.get(piece.aux).map_or(0.0, |aux| {
        // A neighbour at zero changes nothing; a temperature not where it was.
        if aux.is_command { 0.0 } else { aux.span.centre }
    });
    stepping(&piece.block, zero, o.problem.data.step)
}

/// The same without its outcome; `zero` is the value of the auxiliary signal that changes nothing, `step` that
/// of the grid in s.
fn stepping(block: &Block, zero: f64, step: f64) -> Option<Around> {
    // A part of the way in each row, as a time.
    let smoothing = |part: f64| -step / (-part).ln_1p();
    let plays = |memory: &Memory| (memory.r.clone(), memory.w.clone());
    Some(match block {
        Block::Delay => Around::Delay,
        Block::Quantiser(Span { half, .. }) => Around::Rounding { half: *half },
        Block::GappedQuantiser { span, every, missing } => {
            Around::MissingCodes { half: span.half, every: *every, missing: *missing }
        }
        Block::Lag(order) => Around::Lag { order: *order },
        Block::Lag2 => Around::SecondOrder,
        Block::Slew => Around::Slew,
        Block::UnevenSlew => Around::UnevenSlew,
        Block::SoftSlew => Around::SoftSlew,
        Block::ClampHigh => Around::LimitAbove,
        Block::ClampLow => Around::LimitBelow,
        Block::ClampBoth(span) => Around::Limits { centre: span.centre },
        Block::SoftHigh => Around::SoftLimitAbove,
        Block::Tanh(Span { centre, half }) => Around::Tanh { centre: *centre, half: *half },
        Block::Sigmoid(Span { centre, half }) => Around::SCurve { centre: *centre, half: *half },
        Block::Gain => Around::Gain,
        Block::AgeingGain => Around::AgeingGain,
        Block::LogCreep { longest } => Around::LogCreep { longest: *longest },
        Block::PowerCreep { shortest, longest } => {
            Around::PowerCreep { shortest: *shortest, longest: *longest }
        }
        Block::FixedCreep(times) => Around::FixedCreep { times: times.clone() },
        Block::FreeCreep(_) => Around::Creep,
        Block::Plays { bank, gain } => Around::Plays { r: bank.clone(), slope: *gain },
        Block::SkewedPlays { bank, span } => {
            Around::SkewedPlays { r: bank.clone(), centre: span.centre, half: span.half }
        }
        Block::BoucWen => Around::BoucWen,
        Block::GeneralisedPlay(Span { centre, half }) => {
            Around::GeneralisedPlay { centre: *centre, half: *half }
        }
        Block::CurvedPlays { memory, span } => Around::CurvedPlays {
            r: memory.r.clone(),
            w: memory.w.clone(),
            centre: span.centre,
            half: span.half,
        },
        Block::BentPlays { memory, span } => {
            let (r, w) = plays(memory);
            Around::BentPlays { r, w, centre: span.centre, half: span.half }
        }
        Block::RatePlays(memory) => {
            let (r, w) = plays(memory);
            Around::RatePlays { r, w }
        }
        Block::SaturatingPlays { memory, steepest } => {
            let (r, w) = plays(memory);
            let (law, smoothing) = (surround::Growth::Limited, Some(smoothing(SATURATING)));
            Around::GrowingPlays { r, w, law, scale: *steepest, smoothing }
        }
        Block::GrowingPlays { memory, steepest, law } => {
            let (r, w) = plays(memory);
            Around::GrowingPlays { r, w, law: *law, scale: *steepest, smoothing: None }
        }
        Block::LaggedPlays(memory) => {
            let (r, w) = plays(memory);
            Around::LaggedPlays { r, w }
        }
        Block::RateMemory { memory, half } => {
            let (r, w) = plays(memory);
            Around::RateMemory { r, w, half: *half, smoothing: smoothing(GROWING) }
        }
        Block::DeadZones(Span { centre, half }) => {
            Around::DeadZones { centre: *centre, half: *half }
        }
        Block::Heating { span, loss } => Around::Heating { half: span.half, loss: losses(*loss) },
        Block::Warming { span, loss, times } => {
            Around::Warming { half: span.half, loss: losses(*loss), times: times.clone() }
        }
        Block::HeatingGain { loss } => Around::HeatingGain { loss: losses(*loss) },
        Block::ParallelMode => Around::ParallelMode,
        Block::PoleZero => Around::PoleZero,
        &Block::BeforeMode { frequency, damping } => Around::BeforeMode { frequency, damping },
        Block::Backlash => Around::Backlash,
        Block::BridgedBacklash => Around::BridgedBacklash,
        Block::Dahl => Around::Dahl,
        Block::Polynomial { span, .. } => {
            Around::Polynomial { centre: span.centre, half: span.half }
        }
        Block::Sine(Span { centre, half }) => Around::Sine { centre: *centre, half: *half },
        Block::Aux { scale, .. } => Around::Auxiliary { scale: *scale, zero },
        Block::LaggedAux { scale } => Around::LaggedAuxiliary { scale: *scale, zero },
        Block::ModalAux { scale } => Around::ModalAuxiliary { scale: *scale, zero },
        Block::FeedThrough { scale, time } => Around::FeedThrough { scale: *scale, time: *time },
        // Between two clocks, or of the start of a record.
        _ => return None,
    })
}

fn losses(loss: Loss) -> surround::Loss {
    match loss {
        Loss::Rate(mean) => surround::Loss::Rate { mean },
        Loss::Apparent(mean) => surround::Loss::Apparent { mean },
        Loss::Loops(mean, span) => surround::Loss::Loops { mean, centre: span.centre },
    }
}

/// Whether a block reads an auxiliary signal.
pub(crate) fn reads_auxiliary(block: &Around) -> bool {
    matches!(
        block,
        Around::Auxiliary { .. } | Around::LaggedAuxiliary { .. } | Around::ModalAuxiliary { .. }
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::Wires;

    const STEP: f64 = 1e-4;

    /// All blocks that go around an FMU, with parameters at which they act.
    fn all() -> Vec<(Block, Vec<f64>)> {
        let span = Span { centre: 0.5, half: 2.0 };
        let memory = Memory { r: vec![0.2, 0.7], w: vec![0.3, 0.1] };
        let loss = Loss::Rate(1e4);
        let loops = Loss::Loops(1e3, span);
        vec![
            (Block::Delay, vec![3.4 * STEP]),
            (Block::Delay, vec![0.2 * STEP]),
            (Block::Quantiser(span), vec![40.0, 0.3]),
            (Block::GappedQuantiser { span, every: 5, missing: 3 }, vec![40.0, 0.3]),
            (Block::Lag(1), vec![300.0]),
            (Block::Lag(3), vec![700.0]),
            (Block::Lag2, vec![400.0, 0.6]),
            (Block::Slew, vec![200.0]),
            (Block::UnevenSlew, vec![250.0, 0.6]),
            (Block::SoftSlew, vec![900.0, 500.0]),
            (Block::ClampHigh, vec![1.2]),
            (Block::ClampLow, vec![-0.2]),
            (Block::ClampBoth(span), vec![0.9]),
            (Block::SoftHigh, vec![1.2, 0.2]),
            (Block::Tanh(span), vec![0.8]),
            (Block::Sigmoid(span), vec![0.1, 0.2]),
            (Block::Gain, vec![0.13]),
            (Block::AgeingGain, vec![0.13, -0.02]),
            (Block::BoucWen, vec![0.3, 0.7, 0.6]),
            (Block::GeneralisedPlay(span), vec![0.3, 0.2, 0.1, 0.05]),
            (Block::Sine(span), vec![0.1, 1.5, 0.3]),
            (
                Block::Warming { span, loss: Loss::Apparent(1e3), times: vec![0.02, 0.1] },
                vec![0.1, 0.05, 0.03],
            ),
            (Block::LogCreep { longest: 1.0 }, vec![0.02, 1e-3]),
            (Block::PowerCreep { shortest: 1e-3, longest: 1.0 }, vec![0.02, 0.3]),
            (Block::FixedCreep(vec![0.01, 0.1]), vec![0.02, 0.03]),
            (Block::FreeCreep(2), vec![0.02, 0.01, 0.05, 0.2]),
            (Block::Plays { bank: vec![0.2, 0.5], gain: false }, vec![0.3, -0.1]),
            (Block::Plays { bank: vec![0.2, 0.5], gain: true }, vec![0.4, 0.3, -0.1]),
            (Block::SkewedPlays { bank: vec![0.2, 0.5], span }, vec![0.3, -0.1]),
            (Block::CurvedPlays { memory: memory.clone(), span }, vec![0.4]),
            (Block::BentPlays { memory: memory.clone(), span }, vec![0.1, -0.2, 0.05, 0.3]),
            (Block::RatePlays(memory.clone()), vec![1e-3]),
            (Block::SaturatingPlays { memory: memory.clone(), steepest: 400.0 }, vec![0.8, 0.4]),
            (
                Block::GrowingPlays {
                    memory: memory.clone(),
                    steepest: 400.0,
                    law: surround::Growth::Logarithmic,
                },
                vec![0.5, 0.2, 7.0 * STEP],
            ),
            (Block::LaggedPlays(memory.clone()), vec![200.0]),
            (Block::RateMemory { memory, half: 2.0 }, vec![2e-3]),
            (Block::DeadZones(span), vec![0.2, -0.1]),
            (Block::Heating { span, loss }, vec![0.1, 0.05]),
            (Block::HeatingGain { loss: loops }, vec![0.1, 0.05]),
            (Block::ParallelMode, vec![0.1, 600.0, 0.03]),
            (Block::PoleZero, vec![500.0, 0.02, 1.1, 0.03]),
            (Block::BeforeMode { frequency: 700.0, damping: 0.1 }, vec![]),
            (Block::Backlash, vec![0.3]),
            (Block::BridgedBacklash, vec![0.3, 0.2]),
            (Block::Dahl, vec![0.1, 0.2]),
            (Block::Polynomial { span, order: 4 }, vec![0.1, -0.2, 0.05]),
            (Block::Aux { scale: 2.0, rate: false }, vec![0.3]),
            (Block::Aux { scale: 2.0, rate: true }, vec![0.3, 0.1]),
            (Block::LaggedAux { scale: 2.0 }, vec![0.3, 200.0]),
            (Block::ModalAux { scale: 2.0 }, vec![0.3, 200.0, 0.05]),
            (Block::FeedThrough { scale: 2.0, time: 1e-3 }, vec![0.3, 0.2]),
        ]
    }

    fn signal(seed: f64) -> Vec<f64> {
        let at = |n: usize| {
            let t = n as f64 * STEP;
            1.5 * (40.0 * t + seed).sin() + (311.0 * t * (1.0 + seed)).sin() + 0.2 * seed
        };
        (0..4000).map(at).collect()
    }

    #[test]
    fn a_stepping_block_does_what_the_fitted_one_does() {
        let (x, drive, aux) = (signal(0.1), signal(0.7), signal(1.3));
        for (block, p) in all() {
            let mut whole = vec![0.0; x.len()];
            block.run(
                &p,
                Wires { x: &x, drive: &drive, command: &drive, aux: &aux, step: STEP },
                &mut whole,
            );
            let around = stepping(&block, 0.0, STEP).expect("it goes around an FMU");
            if let Some(count) = around.parameters() {
                assert_eq!(count, p.len(), "{around:?}");
            }
            let mut state = surround::State::default();
            let mut changed = false;
            for n in 0..x.len() {
                let w = surround::Wires { x: x[n], drive: drive[n], aux: aux[n] };
                let y = match n {
                    0 => around.rest(&p, w, &mut state),
                    _ => around.step(&p, w, n as f64 * STEP, STEP, &mut state),
                };
                assert!((y - whole[n]).abs() < 1e-9, "{around:?} at {n}: {y} and {}", whole[n]);
                changed |= (y - x[n]).abs() > 1e-3;
            }
            assert!(changed, "{around:?} does nothing in this test");
        }
    }

    #[test]
    fn a_saved_state_goes_on_to_the_same_bits() {
        let (x, drive, aux) = (signal(0.1), signal(0.7), signal(1.3));
        for (block, p) in all() {
            let around = stepping(&block, 0.0, STEP).expect("it goes around an FMU");
            let wires = |n: usize| surround::Wires { x: x[n], drive: drive[n], aux: aux[n] };
            let mut state = surround::State::default();
            around.rest(&p, wires(0), &mut state);
            for n in 1..1000 {
                around.step(&p, wires(n), n as f64 * STEP, STEP, &mut state);
            }
            let mut numbers = Vec::new();
            state.save(&mut numbers);
            let mut other = surround::State::load(&mut numbers.into_iter()).expect("it reads");
            for n in 1000..1500 {
                let t = n as f64 * STEP;
                let a = around.step(&p, wires(n), t, STEP, &mut state);
                let b = around.step(&p, wires(n), t, STEP, &mut other);
                assert_eq!(a.to_bits(), b.to_bits(), "{around:?} at {n}");
            }
        }
    }

    #[test]
    fn a_stepping_mode_with_a_force_does_what_the_fitted_one_does() {
        let (frequency, damping, centre, half) = (300.0, 0.05, 0.5, 2.0);
        let mode = crate::chain::ComponentNode {
            component: model::ComponentRef::Static(&components::mechanics::MODE),
            structure: Vec::new(),
            values: vec![frequency, damping, 1.0],
            links: Vec::new(),
            reads_command: false,
        };
        let x = signal(0.1);
        for (force, p) in [
            (surround::Force::Cubic, &[0.3][..]),
            (surround::Force::Uneven, &[0.1, 0.3]),
            (surround::Force::Friction, &[0.05, 0.1]),
            (surround::Force::SpeedDamping, &[0.4]),
            (surround::Force::Coulomb, &[0.05, 0.02]),
        ] {
            let mut whole = vec![0.0; x.len()];
            let far = centre + half;
            crate::chain::forced(&mode, &[(force, p.to_vec(), far)], &[], &x, STEP, &mut whole)
                .unwrap();
            let around = Around::ForcedMode { frequency, damping, force, far };
            let plain = Around::Mode { frequency, damping };
            let (mut state, mut other) = Default::default();
            let mut changed = false;
            for n in 0..x.len() {
                let w = surround::Wires { x: x[n], drive: x[n], aux: 0.0 };
                let run = |block: &Around, p: &[f64], state: &mut surround::State| match n {
                    0 => block.rest(p, w, state),
                    _ => block.step(p, w, n as f64 * STEP, STEP, state),
                };
                let y = run(&around, p, &mut state);
                assert!((y - whole[n]).abs() < 1e-9, "{force:?} at {n}: {y} and {}", whole[n]);
                changed |= (y - run(&plain, &[], &mut other)).abs() > 1e-3;
            }
            assert!(changed, "{force:?} does nothing in this test");
        }
    }

    #[test]
    fn a_mode_that_is_taken_out_and_put_in_again_changes_nothing() {
        let (before, mode) = (
            Around::BeforeMode { frequency: 800.0, damping: 0.02 },
            Around::Mode { frequency: 800.0, damping: 0.02 },
        );
        let (mut a, mut b) = Default::default();
        for (n, x) in signal(0.3).into_iter().enumerate() {
            // Steps of several lengths.
            let dt = STEP * if n % 3 == 0 { 0.5 } else { 1.0 };
            let wires = |x| surround::Wires { x, drive: 0.0, aux: 0.0 };
            let run = |block: &Around, x: f64, state: &mut surround::State| match n {
                0 => block.rest(&[], wires(x), state),
                _ => block.step(&[], wires(x), 0.0, dt, state),
            };
            let inside = run(&before, x, &mut a);
            let y = run(&mode, inside, &mut b);
            assert!((y - x).abs() < 1e-9, "at {n}: {y} and {x}");
        }
    }
}
