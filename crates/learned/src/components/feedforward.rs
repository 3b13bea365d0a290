//! Feedforward that uses a learned hysteresis term itself, without an inverse.
//!
//! ```text
//! u = (inertia·y″ + lag·y′ + y − offset)/gain − ĥ,   ĥ_k = f(y_k … y_{k−n}, ĥ_{k−1} … ĥ_{k−l})
//! ```
//!
//! The model ÿ + 2ξω·ẏ + ω²·y = d·u + h divided by d: gain = d/ω², lag = 2ξ/ω, inertia = 1/ω², and h in
//! units of the command. Derivatives are backward differences over the sample time.

use model::{
    Component, ComponentRef, Conversion, Declaration, Quantity, Sizes, Stage, Table, Tick,
    Violation,
};

use super::declarations::{FEEDFORWARD_STRUCTURE, NARX_SOURCE_XU};
use super::{Family, STEPS_TO_REST};
use crate::KernelSum;
use crate::features::Features;

static DECLARATION: Declaration = Declaration {
    kind: "lssvm-feedforward",
    name: "feedforward",
    summary: "Feedforward without an inverse, by a hysteresis term that an LS-SVM learned over the position and its own past",
    equation: "u = (inertia*y'' + lag*y' + y - offset)/gain - h; h(t) = bias + sum(w[i]*exp(-|x[i] - \
               z|^2)); z = [y(t), y(t-1), ..., h(t-1), ...], scaled",
    reference: NARX_SOURCE_XU,
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: FEEDFORWARD_STRUCTURE,
    parameters: &[
        Quantity::new("gain", "{position}/{command}", "Position per command without hysteresis")
            .tunable(),
        Quantity::new("offset", "{position}", "Position at zero command").start(0.0).tunable(),
        Quantity::new("lag", "s", "Damping over stiffness").start(0.0).min(0.0).tunable(),
        Quantity::new("inertia", "s2", "Mass over stiffness").start(0.0).min(0.0).tunable(),
        Quantity::new("h_low", "{command}", "Hysteresis term that corresponds to 0 in the table")
            .start(0.0),
        Quantity::new("h_high", "{command}", "Hysteresis term that corresponds to 1 in the table"),
        Quantity::new("position_low", "{position}", "Position that corresponds to 0 in the table")
            .start(0.0),
        Quantity::new("position_high", "{position}", "Position that corresponds to 1 in the table"),
    ],
    ..Declaration::PATH
};

/// The component `lssvm-feedforward` without its table.
pub(super) struct Feedforward;

/// The component `lssvm-feedforward` with its table.
struct Loaded {
    features: Features,
    sum: KernelSum,
    table: Table,
}

/// Only for its loading of tables.
static TABLES: &Family = &Family {
    declaration: &DECLARATION,
    inverses: &[],
    inverse: true,
    features: super::narx,
    deviating: None,
};

impl Component for Feedforward {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn takes_table(&self) -> bool {
        true
    }

    fn with_table(&self, structure: &[f64], table: &Table) -> Result<ComponentRef, String> {
        let loaded = TABLES.load(structure, table)?;
        let super::Loaded { features, sum, table, .. } = loaded;
        Ok(ComponentRef::shared(Loaded { features, sum, table }))
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        TABLES.sizes(structure, period)
    }

    fn prepare(&self, s: &[f64], p: &[f64], period: f64, k: &mut [f64]) -> Result<(), Violation> {
        TABLES.prepare(s, p, period, k)
    }

    fn rest(&self, _: &[f64], _: &[f64], _: &mut [f64], outputs: &mut [f64]) {
        outputs.fill(0.0);
    }

    fn step(&self, _: &[f64], _: &mut [f64], _: Tick, _: &[f64], outputs: &mut [f64]) {
        outputs.fill(0.0);
    }
}

impl Loaded {
    /// The scaled hysteresis term of one sample.
    fn sample(&self, x: f64, state: &mut [f64]) -> f64 {
        let (memory, room) = state.split_at_mut(self.features.memory());
        let Some((z, room)) = room.split_at_mut_checked(self.features.dimension()) else {
            return 0.0;
        };
        self.features.step(x, memory, z);
        let h = self.sum.value(z, room).clamp(-super::BEYOND, 1.0 + super::BEYOND);
        self.features.output(h, memory);
        h
    }
}

/// State in front of that of the features: held term, two past positions.
const HELD: usize = 3;

impl Component for Loaded {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn table(&self) -> Option<&Table> {
        Some(&self.table)
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        let states = HELD + self.features.memory() + 2 * self.features.dimension();
        Sizes { coefficients: 9, states }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let wrong = |quantity, value, rule| Violation { quantity, index: None, value, rule };
        let (
            &[gain, offset, lag, inertia, h_low, h_high, low, high],
            Some(&sample),
            Ok(coefficients),
        ) = (parameters, structure.first(), <&mut [f64; 9]>::try_from(coefficients))
        else {
            let rule = "this component was given a wrong number of values";
            return Err(wrong("sample_time", 0.0, rule));
        };
        let ratio = super::ratio(structure, period)?;
        if gain == 0.0 {
            return Err(wrong("gain", gain, "must not be 0: it is the position per command"));
        }
        for (quantity, low, high) in [("h_high", h_low, h_high), ("position_high", low, high)] {
            super::check_range(quantity, low, high)?;
        }
        let (first, second) = (lag / sample, inertia / (sample * sample));
        *coefficients =
            [ratio, gain, offset, first, second, h_low, h_high - h_low, low, high - low];
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[_, gain, offset, _, _, h_low, h_span, low, span], &[y], [u]) =
            (coefficients, inputs, outputs)
        else {
            return;
        };
        let Some(([held, newer, older], own)) = state.split_first_chunk_mut::<HELD>() else {
            return;
        };
        let x = (y - low) / span;
        self.features.rest(x, 0.5, &mut own[..self.features.memory()]);
        for _ in 0..STEPS_TO_REST {
            *held = self.sample(x, own);
        }
        (*newer, *older) = (y, y);
        *u = (y - offset) / gain - (h_low + h_span * *held);
        // What is held is the command.
        *held = *u;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[ratio, gain, offset, first, second, h_low, h_span, low, span], &[y], [u]) =
            (coefficients, inputs, outputs)
        else {
            return;
        };
        let Some(([held, newer, older], own)) = state.split_first_chunk_mut::<HELD>() else {
            return;
        };
        if tick.index.is_multiple_of((ratio as u64).max(1)) {
            let h = h_low + h_span * self.sample((y - low) / span, own);
            let lead = first * (y - *newer) + second * ((y - *newer) - (*newer - *older));
            *held = (y + lead - offset) / gain - h;
            (*older, *newer) = (*newer, y);
        }
        *u = *held;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_linear_part_less_the_learned_term() {
        // One support vector over y(t), h(t−1).
        let rows = vec![0.1, 1.0, 2.0, 0.5, 0.4, 0.3];
        let structure = [1e-3, 0.0, 1.0];
        let table = Table::new(3, rows).expect("rows");
        let component = Feedforward.with_table(&structure, &table).expect("it fits");
        let p = [2.0, 0.5, 3e-3, 4e-6, -1.0, 3.0, 0.0, 10.0];
        let sizes = component.sizes(&structure, 1e-3);
        let (mut k, mut state) = (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
        component.prepare(&structure, &p, 1e-3, &mut k).expect("valid");
        let f = |y: f64, h: f64| {
            0.1 + 0.5 * (-((y / 10.0 - 0.4).powi(2) + ((h - 0.3) / 2.0).powi(2))).exp()
        };
        let mut u = [0.0];
        component.rest(&k, &[1.0], &mut state, &mut u);
        let mut h = (0..200).fold(0.5, |h, _| f(1.0, h));
        assert!((u[0] - (0.5 / 2.0 - (-1.0 + 4.0 * h))).abs() < 1e-9, "{u:?}");
        let mut past = [1.0, 1.0];
        for index in 1..50_u64 {
            let y = 1.0 + 0.05 * index as f64;
            let tick = Tick { index, time: 1e-3 * index as f64, period: 1e-3 };
            component.step(&k, &mut state, tick, &[y], &mut u);
            h = f(y, h);
            let lead = 3e-3 * (y - past[0]) / 1e-3 + 4.0 * ((y - past[0]) - (past[0] - past[1]));
            let expected = (y + lead - 0.5) / 2.0 - (-1.0 + 4.0 * h);
            assert!((u[0] - expected).abs() < 1e-9, "{index}: {u:?} {expected}");
            past = [y, past[0]];
        }
    }
}
