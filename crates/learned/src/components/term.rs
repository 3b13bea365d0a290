//! A straight line with a hysteresis term that an LS-SVM learned.
//!
//! ```text
//! y = offset + gain·(u + h),   h by model I, II or III
//! ```
//!
//! The model ÿ + 2ξω·ẏ + ω²·y = d·u + h divided by ω², without its mode, which is a component behind this one: gain = d/ω², h in units
//! of the command. The inputs of the three models are those of [`crate::features::term`]. A model II is undone by itself:
//! its term, of the position that is wanted, is what the feedforward takes off.

use model::{
    Component, ComponentRef, Conversion, Declaration, Inverse, Quantity, Sizes, Stage, Structural,
    Table, Tick, Undoing, Violation,
};

use super::declarations::{NARX_SOURCE_XU, SAMPLE_TIME, count};
use super::{STEPS_TO_REST, kernels_of, ratio};
use crate::KernelSum;
use crate::features::term::{Range, Term as Features, TermSignals};

const STRUCTURE: &[Structural] = &[
    SAMPLE_TIME,
    count("past_inputs", "Number of past values of each signal among the inputs", 0.0, 100.0),
    count("past_outputs", "Number of past hysteresis terms among the inputs", 0.0, 100.0),
    count("inputs", "Signals among the inputs: 1 the command, 2 the position, 3 both", 1.0, 3.0),
];

static DECLARATION: Declaration = Declaration {
    kind: "lssvm-term",
    name: "hysteresis",
    summary: "Straight line with a hysteresis term that an LS-SVM learned over commands, positions or both, and its own past",
    equation: "y = offset + gain*(u + h); h(t) = bias + sum(w[i]*exp(-|x[i] - z|^2)); z = [u(t), u(t-1), ..., h(t-1), ...], \
               [y(t), y(t-1), ..., h(t-1), ...] or [u(t), ..., y(t-1), ..., h(t-1), ...], scaled",
    reference: NARX_SOURCE_XU,
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&components::effects::HYSTERESIS),
    structure: STRUCTURE,
    parameters: &[
        Quantity::new("gain", "{position}/{command}", "Position per command without hysteresis"),
        Quantity::new("offset", "{position}", "Position at zero command without hysteresis")
            .start(0.0),
        Quantity::new("command_low", "{command}", "Command that corresponds to 0 in the table")
            .start(0.0),
        Quantity::new("command_high", "{command}", "Command that corresponds to 1 in the table"),
        Quantity::new("h_low", "{command}", "Hysteresis term that corresponds to 0 in the table")
            .start(0.0),
        Quantity::new("h_high", "{command}", "Hysteresis term that corresponds to 1 in the table"),
        Quantity::new("position_low", "{position}", "Position that corresponds to 0 in the table")
            .start(0.0),
        Quantity::new("position_high", "{position}", "Position that corresponds to 1 in the table"),
    ],
    ..Declaration::PATH
};

/// Of a model II.
const INVERSE_FREE: &[Inverse] =
    &[Inverse { kind: "lssvm-feedforward", undoing: Undoing::InverseFree }];

/// The component `lssvm-term` without its table.
pub(super) struct Term;

/// The component `lssvm-term` with its table.
struct Loaded {
    signals: TermSignals,
    past: usize,
    terms: usize,
    sum: KernelSum,
    table: Table,
}

impl Component for Term {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn takes_table(&self) -> bool {
        true
    }

    fn with_table(&self, structure: &[f64], table: &Table) -> Result<ComponentRef, String> {
        let &[_, past, terms, inputs] = structure else {
            return Err("the structure does not give a set of inputs".to_owned());
        };
        let signals = match inputs as usize {
            1 => TermSignals::Command,
            2 => TermSignals::Position,
            _ => TermSignals::Both,
        };
        let (past, terms) = (past as usize, terms as usize);
        let dimension = features(signals, past, terms, &COEFFICIENTS_OF_NONE).dimension();
        let sum = kernels_of(table, dimension, [0, 0])?.0;
        Ok(ComponentRef::shared(Loaded { signals, past, terms, sum, table: table.clone() }))
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes::default()
    }

    fn prepare(&self, _: &[f64], _: &[f64], _: f64, _: &mut [f64]) -> Result<(), Violation> {
        Err(super::no_table())
    }

    fn rest(&self, _: &[f64], _: &[f64], _: &mut [f64], outputs: &mut [f64]) {
        outputs.fill(0.0);
    }

    fn step(&self, _: &[f64], _: &mut [f64], _: Tick, _: &[f64], outputs: &mut [f64]) {
        outputs.fill(0.0);
    }
}

/// Steps from one sample to the next, line, ranges.
const COEFFICIENTS: usize = 9;
const COEFFICIENTS_OF_NONE: [f64; COEFFICIENTS] = [1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0];

fn features(signals: TermSignals, past: usize, terms: usize, k: &[f64; COEFFICIENTS]) -> Features {
    let &[_, gain, offset, command, width, h, depth, position, height] = k;
    let range = |low: f64, span: f64| Range { low, span };
    Features {
        signals,
        past,
        terms,
        gain,
        offset,
        command: range(command, width),
        position: range(position, height),
        term: range(h, depth),
    }
}

impl Loaded {
    fn features(&self, coefficients: &[f64]) -> Option<(u64, Features)> {
        let k = <&[f64; COEFFICIENTS]>::try_from(coefficients).ok()?;
        Some(((k[0] as u64).max(1), features(self.signals, self.past, self.terms, k)))
    }
}

impl Component for Loaded {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn table(&self) -> Option<&Table> {
        Some(&self.table)
    }

    fn inverses(&self) -> &'static [Inverse] {
        if self.signals == TermSignals::Position { INVERSE_FREE } else { &[] }
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        let features = features(self.signals, self.past, self.terms, &COEFFICIENTS_OF_NONE);
        // Held position, memory, input, room.
        Sizes {
            coefficients: COEFFICIENTS,
            states: 1 + features.memory() + 2 * features.dimension(),
        }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (
            &[gain, offset, command_low, command_high, h_low, h_high, position_low, position_high],
            Ok(coefficients),
        ) = (parameters, <&mut [f64; COEFFICIENTS]>::try_from(coefficients))
        else {
            let rule = "this component was given a wrong number of values";
            return Err(Violation { quantity: "sample_time", index: None, value: 0.0, rule });
        };
        let ratio = ratio(structure, period)?;
        if gain == 0.0 {
            let rule = "must not be 0: it is the position per command";
            return Err(Violation { quantity: "gain", index: None, value: gain, rule });
        }
        for (quantity, low, high) in [
            ("command_high", command_low, command_high),
            ("h_high", h_low, h_high),
            ("position_high", position_low, position_high),
        ] {
            super::check_range(quantity, low, high)?;
        }
        *coefficients = [
            ratio,
            gain,
            offset,
            command_low,
            command_high - command_low,
            h_low,
            h_high - h_low,
            position_low,
            position_high - position_low,
        ];
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((_, features)), &[u], [y]) = (self.features(coefficients), inputs, outputs)
        else {
            return;
        };
        let Some((held, own)) = state.split_last_mut() else { return };
        let (memory, room) = own.split_at_mut(features.memory());
        let Some((z, room)) = room.split_at_mut_checked(features.dimension()) else { return };
        // Where the way to rest begins: a term in the middle of its range.
        let middle = features.term.low + 0.5 * features.term.span;
        features.rest(u, features.position(u, middle), memory);
        for _ in 0..STEPS_TO_REST {
            *held = features.respond(&self.sum, u, memory, (&mut *z, &mut *room));
        }
        *y = *held;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((ratio, features)), &[u], [y]) = (self.features(coefficients), inputs, outputs)
        else {
            return;
        };
        let Some((held, own)) = state.split_last_mut() else { return };
        if tick.index.is_multiple_of(ratio) {
            let (memory, room) = own.split_at_mut(features.memory());
            let Some((z, room)) = room.split_at_mut_checked(features.dimension()) else { return };
            *held = features.respond(&self.sum, u, memory, (z, room));
        }
        *y = *held;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: f64 = 2e-2;
    const VALUES: [f64; 8] = [2.0, 0.5, 0.0, 10.0, -1.0, 2.0, 0.0, 25.0];

    fn loaded(inputs: f64, dimension: usize) -> (ComponentRef, Vec<f64>, Vec<f64>, [f64; 4]) {
        let part = |i: usize| libm::sin(2.3 * i as f64).abs();
        let mut rows = vec![0.4];
        rows.extend(vec![0.9; dimension]);
        for i in 0..20 {
            rows.push(0.2 * libm::cos(i as f64));
            rows.extend((0..dimension).map(|k| part(i * dimension + k)));
        }
        let table = Table::new(dimension + 1, rows).expect("rows");
        let structure = [T, 2.0, 2.0, inputs];
        let component = Term.with_table(&structure, &table).expect("it fits");
        let sizes = component.sizes(&structure, T);
        let (mut k, state) = (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
        component.prepare(&structure, &VALUES, T, &mut k).expect("valid");
        (component, k, state, structure)
    }

    #[test]
    fn each_model_holds_the_line_with_its_term_between_samples() {
        for (inputs, dimension) in [(1.0, 5), (2.0, 5), (3.0, 8)] {
            let (component, mut k, _, structure) = loaded(inputs, dimension);
            component.prepare(&structure, &VALUES, T / 4.0, &mut k).expect("a fourth of it");
            let sizes = component.sizes(&structure, T / 4.0);
            let mut state = vec![0.0; sizes.states];
            let mut y = [0.0];
            component.rest(&k, &[3.0], &mut state, &mut y);
            let mut last = y[0];
            for index in 1..200_u64 {
                let u = 5.0 - 4.0 * libm::cos(0.05 * index as f64);
                let tick = Tick { index, time: T / 4.0 * index as f64, period: T / 4.0 };
                component.step(&k, &mut state, tick, &[u], &mut y);
                assert!((-8.0..35.0).contains(&y[0]), "{y:?}");
                assert!(index % 4 == 0 || y[0] == last, "{index}");
                last = y[0];
            }
        }
    }

    #[test]
    fn a_model_of_the_position_is_inverted_by_its_own_term() {
        let (component, k, mut state, structure) = loaded(2.0, 5);
        let inverse = component.inverses()[0];
        assert!(loaded(1.0, 5).0.inverses().is_empty() && loaded(3.0, 8).0.inverses().is_empty());
        let found = super::super::COMPONENTS.iter().find(|c| c.declaration().kind == inverse.kind);
        let own = &structure[..3];
        let table = component.table().expect("its table");
        let back = found.expect("registered").with_table(own, table).expect("the same table");
        let sizes = back.sizes(own, T);
        let (mut other, mut memory) = (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
        let values = [VALUES[0], VALUES[1], 0.0, 0.0, VALUES[4], VALUES[5], VALUES[6], VALUES[7]];
        back.prepare(own, &values, T, &mut other).expect("valid");
        let (mut y, mut u) = ([0.0], [0.0]);
        component.rest(&k, &[3.0], &mut state, &mut y);
        back.rest(&other, &y, &mut memory, &mut u);
        assert!((u[0] - 3.0).abs() < 1e-6, "{u:?}");
        for index in 1..300_u64 {
            let expected =
                5.0 - 4.0 * libm::cos(0.05 * index as f64) + libm::sin(0.13 * index as f64);
            let tick = Tick { index, time: T * index as f64, period: T };
            component.step(&k, &mut state, tick, &[expected], &mut y);
            back.step(&other, &mut memory, tick, &y, &mut u);
            assert!((u[0] - expected).abs() < 1e-6, "{index}: {u:?} {expected}");
        }
    }

    #[test]
    fn what_does_not_fit_is_reported() {
        let table = Table::new(4, vec![0.1, 1.0, 1.0, 1.0, 0.2, 0.1, 0.1, 0.1]).expect("rows");
        let text = Term.with_table(&[T, 2.0, 2.0, 3.0], &table).err().expect("refused");
        assert!(text.contains("8 inputs"), "{text}");
        let (component, mut k, _, structure) = loaded(1.0, 5);
        let mut values = VALUES;
        values[0] = 0.0;
        let violation = component.prepare(&structure, &values, T, &mut k).expect_err("refused");
        assert_eq!(violation.quantity, "gain");
        values = VALUES;
        values[5] = -1.0;
        let violation = component.prepare(&structure, &values, T, &mut k).expect_err("refused");
        assert_eq!(violation.quantity, "h_high");
        assert!(component.prepare(&structure, &VALUES, 0.3 * T, &mut k).is_err());
    }
}
