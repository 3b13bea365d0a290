//! Random sequences of calls, legal and illegal.

use proptest::prelude::*;
use proptest::strategy::Union;

use super::reference::{Kind, NUMBERS, Op, SLOTS, STEPS};

fn kind() -> impl Strategy<Value = Kind> {
    prop_oneof![
        6 => Just(Kind::Real),
        1 => Just(Kind::Integer),
        2 => Just(Kind::Boolean),
        1 => Just(Kind::String),
    ]
}

/// Mostly small numbers that are good.
fn number() -> impl Strategy<Value = usize> {
    prop_oneof![3 => 0..5_usize, 1 => 0..NUMBERS.len()]
}

fn reference(count: u32) -> impl Strategy<Value = u32> {
    prop_oneof![20 => 0..count, 1 => Just(count), 1 => count + 1..count + 3, 1 => Just(u32::MAX)]
}

fn rarely() -> impl Strategy<Value = bool> {
    prop_oneof![15 => Just(false), 1 => Just(true)]
}

fn excess() -> impl Strategy<Value = u8> {
    prop_oneof![15 => Just(0_u8), 1 => 1..3_u8]
}

fn stop() -> impl Strategy<Value = Option<usize>> {
    prop_oneof![2 => Just(None), 1 => number().prop_map(Some)]
}

/// One call on a model with this number of variables.
fn op(count: u32) -> Union<BoxedStrategy<Op>> {
    let slot = 0..SLOTS;
    let references = prop::collection::vec(reference(count), 0..4);
    let items = prop::collection::vec((reference(count), number()), 0..3);
    Union::new_weighted(vec![
        (1, (0..4_u8).prop_map(|category| Op::Debug { category }).boxed()),
        (3, (number(), stop()).prop_map(|(start, stop)| Op::SetUp { start, stop }).boxed()),
        (6, (number(), stop()).prop_map(|(start, stop)| Op::Enter { start, stop }).boxed()),
        (6, Just(Op::Exit).boxed()),
        (1, Just(Op::Terminate).boxed()),
        (3, Just(Op::Reset).boxed()),
        (
            4,
            (kind(), references, rarely(), excess())
                .prop_map(|(kind, references, null, excess)| Op::Get {
                    kind,
                    references,
                    null,
                    excess,
                })
                .boxed(),
        ),
        (
            5,
            (kind(), items, rarely(), excess())
                .prop_map(|(kind, items, null, excess)| Op::Set { kind, items, null, excess })
                .boxed(),
        ),
        (3, (slot.clone(), rarely()).prop_map(|(slot, null)| Op::Save { slot, null }).boxed()),
        (3, slot.clone().prop_map(|slot| Op::Restore { slot }).boxed()),
        (1, slot.clone().prop_map(|slot| Op::Free { slot }).boxed()),
        (1, slot.clone().prop_map(|slot| Op::Size { slot }).boxed()),
        (
            2,
            (slot.clone(), rarely())
                .prop_map(|(slot, short)| Op::Serialize { slot, short })
                .boxed(),
        ),
        (
            2,
            (slot, prop_oneof![4 => Just(None), 1 => (0..600_usize).prop_map(Some)])
                .prop_map(|(slot, damage)| Op::Deserialize { slot, damage })
                .boxed(),
        ),
        (
            1,
            (reference(count), reference(count), number())
                .prop_map(|(unknown, known, seed)| Op::Derivative { unknown, known, seed })
                .boxed(),
        ),
        (
            1,
            (reference(count), 0..3_i32)
                .prop_map(|(reference, order)| Op::OutputSlope { reference, order })
                .boxed(),
        ),
        (
            10,
            (
                prop_oneof![12 => Just(0_usize), 1 => 1..4_usize],
                prop_oneof![5 => 0..3_usize, 1 => 0..STEPS.len()],
            )
                .prop_map(|(ahead, size)| Op::Step { ahead, size })
                .boxed(),
        ),
        (1, (0..10_usize).prop_map(|which| Op::Never { which }).boxed()),
        (1, (0..5_usize).prop_map(|which| Op::Inquiry { which }).boxed()),
        (1, Just(Op::Renew).boxed()),
    ])
}

/// A life of up to 40 calls.
pub fn sequence(count: u32) -> impl Strategy<Value = Vec<Op>> {
    prop::collection::vec(op(count), 1..40)
}
