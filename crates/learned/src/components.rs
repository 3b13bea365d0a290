//! Components that run learned tables in real time.
//!
//! Each evaluates `y = bias + Σ w_i exp(−Σ_k (x_ik − z_k)²/s_k²)` on its own sample time; between its
//! samples the output is held. A table has one row more than support vectors: the first row is the
//! bias and the widths s_k, each other one a weight and a support vector. Where stop operators are projected on the
//! command, a second row between them is 0, the weights of the stops, 0, 0.
//!
//! A Gaussian process may have a second output, the standard deviation that it predicts; its centres and factors are the
//! table's last rows ([`Deviation`]).
//!
//! At rest the output is where a hundred steps with the input held lead to.

mod declarations;
mod feedforward;
pub mod plays;
mod term;

use model::{Component, ComponentRef, Declaration, Inverse, Sizes, Table, Tick, Violation};

use crate::features::{Derivatives, Features, Narx, StopOperators};
use crate::{Deviation, KernelSum};

/// All component types: those of the library, then those that run learned tables.
pub static COMPONENTS: model::Registry = &ALL;

const OWN: model::Registry = &[
    &declarations::LSSVM_NARX,
    &declarations::LSSVM_STOPS,
    &declarations::GAUSSIAN_PROCESS,
    &declarations::LSSVM_INVERSE,
    &declarations::LSSVM_STOPS_INVERSE,
    &declarations::GP_INVERSE,
    &feedforward::Feedforward,
    &term::Term,
    &plays::LearnedPlays,
    &plays::INVERSE,
];
static LISTS: [model::Registry; 2] = [components::COMPONENTS, OWN];

static ALL: [&dyn Component; model::count(&LISTS)] = model::joined(&LISTS);

/// Steps that lead to rest.
const STEPS_TO_REST: usize = 100;
/// How far beyond its range an output may go, in ranges.
const BEYOND: f64 = 1.0;

/// A kind of learned component without its table.
struct Family {
    declaration: &'static Declaration,
    /// What undoes it.
    inverses: &'static [Inverse],
    /// Takes positions and gives commands.
    inverse: bool,
    /// The inputs that the structure (without its sample time, which comes first) asks for.
    features: fn(f64, &[f64]) -> Option<Features>,
    /// The declaration with the output of a standard deviation, where the table may hold one.
    deviating: Option<&'static Declaration>,
}

/// A learned component with its table.
struct Loaded {
    family: &'static Family,
    features: Features,
    /// Of a straight line over the input.
    slope: f64,
    sum: KernelSum,
    /// What the loaded predicts of its own errors, with the declaration of this output.
    deviation: Option<(&'static Declaration, Deviation)>,
    table: Table,
}

fn narx(_period: f64, structure: &[f64]) -> Option<Features> {
    let &[commands, outputs] = structure else { return None };
    Some(Features::Narx(Narx { commands: commands as usize, outputs: outputs as usize }))
}

fn stops(period: f64, structure: &[f64]) -> Option<Features> {
    let &[count, range, rate_scale, ..] = structure else { return None };
    let (count, projection) = (count as usize, Vec::new());
    Some(Features::StopOperators(StopOperators { count, range, period, rate_scale, projection }))
}

fn derivatives(_period: f64, structure: &[f64]) -> Option<Features> {
    let &[dimension, half, cutoff, ..] = structure else { return None };
    Derivatives::new(dimension as usize, half as usize, cutoff, [1.0; 4]).map(Features::Derivatives)
}

impl Family {
    fn load(&'static self, structure: &[f64], table: &Table) -> Result<Loaded, String> {
        let mut features = structure
            .split_first()
            .and_then(|(period, rest)| (self.features)(*period, rest))
            .ok_or("the structure does not give a set of inputs; inputs are 2, 6, 9 or 12")?;
        let d = features.dimension();
        let (slope, is_projected, centres) = match (&features, structure) {
            (Features::StopOperators(_), &[.., slope, projected]) => (slope, projected > 0.5, 0),
            (Features::Derivatives(_), &[_, _, _, _, slope, ref rest @ ..]) => {
                (slope, false, rest.first().map_or(0, |count| *count as usize))
            }
            _ => (0.0, false, 0),
        };
        let behind = Deviation::rows(centres, d + 1);
        let (sum, before, behind) = kernels_of(table, d, [usize::from(is_projected), behind])?;
        if let (Features::StopOperators(stops), true) = (&mut features, is_projected) {
            stops.projection = before[1..=stops.count].to_vec();
        }
        let widths = &table.values()[1..=d];
        let deviation = match (centres, self.deviating) {
            (1.., Some(declaration)) => {
                Some((declaration, Deviation::of_table(behind, centres, widths)?))
            }
            _ => None,
        };
        Ok(Loaded { family: self, features, slope, sum, deviation, table: table.clone() })
    }
}

/// The kernels of a table over `d` inputs, and the rows between its head and its centres and behind these.
fn kernels_of(
    table: &Table,
    d: usize,
    [before, behind]: [usize; 2],
) -> Result<(KernelSum, &[f64], &[f64]), String> {
    let columns = table.columns();
    let least = 2 + before + behind;
    if columns != d + 1 || table.rows() < least {
        return Err(format!(
            "the table has {} rows of {columns} numbers, but this structure takes {d} inputs: {} numbers in \
             each row, in at least {least} rows; give the table that belongs to it",
            table.rows(),
            d + 1
        ));
    }
    if let Some(at) = table.values().iter().position(|x| !x.is_finite()) {
        return Err(format!(
            "row {}, column {} of the table is no finite number; train it again",
            at / columns + 1,
            at % columns + 1
        ));
    }
    let (head, rows) = table.values().split_at(columns);
    if let Some(at) = head[1..].iter().position(|width| *width <= 0.0) {
        return Err(format!(
            "width {} in the table's first row is {}, but must be positive; train it again",
            at + 1,
            head[at + 1]
        ));
    }
    let (before, rows) = rows.split_at(before * columns);
    let (rows, behind) = rows.split_at(rows.len() - behind * columns);
    let weights: Vec<f64> = rows.chunks_exact(columns).map(|row| row[0]).collect();
    let centres: Vec<f64> =
        rows.chunks_exact(columns).flat_map(|row| row[1..].iter().copied()).collect();
    Ok((KernelSum::new(d, &centres, &weights, &head[1..], head[0]), before, behind))
}

/// That a component runs a table, and has none.
fn no_table() -> Violation {
    let rule = "must be given: the file of the learned table, as in table = \"hysteresis.npy\"";
    Violation { quantity: "table", index: None, value: 0.0, rule }
}

/// Internal steps from one sample of the model to the next.
fn ratio(structure: &[f64], period: f64) -> Result<f64, Violation> {
    let sample = structure.first().copied().unwrap_or(0.0);
    let ratio = libm::round(sample / period);
    if ratio < 1.0 || libm::fabs(sample / period - ratio) > 1e-6 * ratio {
        let rule = "must be a whole number of internal steps; choose the model's step so";
        return Err(Violation { quantity: "sample_time", index: None, value: sample, rule });
    }
    Ok(ratio)
}

/// Refuses a range without width.
fn check_range(quantity: &'static str, low: f64, high: f64) -> Result<(), Violation> {
    if high <= low {
        let rule = "must be greater than the lower end of the range";
        return Err(Violation { quantity, index: None, value: high, rule });
    }
    Ok(())
}

impl Component for &'static Family {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn inverses(&self) -> &'static [Inverse] {
        self.inverses
    }

    fn takes_table(&self) -> bool {
        true
    }

    fn with_table(&self, structure: &[f64], table: &Table) -> Result<ComponentRef, String> {
        Ok(ComponentRef::shared(self.load(structure, table)?))
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes::default()
    }

    fn prepare(
        &self,
        _structure: &[f64],
        _parameters: &[f64],
        _period: f64,
        _coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        Err(no_table())
    }

    fn rest(&self, _: &[f64], _: &[f64], _: &mut [f64], outputs: &mut [f64]) {
        outputs.fill(0.0);
    }

    fn step(&self, _: &[f64], _: &mut [f64], _: Tick, _: &[f64], outputs: &mut [f64]) {
        outputs.fill(0.0);
    }
}

/// Steps from one sample to the next, the two ranges, and the deviations of a process.
struct Coefficients {
    ratio: u64,
    input: [f64; 2],
    output: [f64; 2],
    signal: f64,
    noise: f64,
}

fn read(coefficients: &[f64]) -> Option<Coefficients> {
    let &[ratio, a, b, c, d, signal, noise] = coefficients else { return None };
    Some(Coefficients { ratio: ratio as u64, input: [a, b], output: [c, d], signal, noise })
}

impl Loaded {
    /// One sample: from the scaled input to the scaled output.
    fn sample(&self, x: f64, state: &mut [f64]) -> f64 {
        let d = self.features.dimension();
        let (memory, room) = state.split_at_mut(self.features.memory());
        let Some((z, room)) = room.split_at_mut_checked(d) else { return 0.0 };
        self.features.step(x, memory, z);
        let y = (self.slope * x + self.sum.value(z, room)).clamp(-BEYOND, 1.0 + BEYOND);
        self.features.output(y, memory);
        y
    }

    /// Numbers of memory, input and room.
    fn own(&self) -> usize {
        self.features.memory() + 2 * self.features.dimension()
    }

    /// Centres of the deviation.
    fn centres(&self) -> usize {
        self.deviation.as_ref().map_or(0, |(_, deviation)| deviation.count())
    }

    /// Takes the last sample's deviation into the state's last number but one.
    fn deviate(&self, c: &Coefficients, state: &mut [f64]) {
        let (Some((_, deviation)), Some((held, state))) = (&self.deviation, state.split_last_mut())
        else {
            return;
        };
        let (own, room) = state.split_at_mut(self.own());
        let (memory, d) = (self.features.memory(), self.features.dimension());
        let left = deviation.left(&own[memory..memory + d], room);
        *held = libm::sqrt(c.signal * c.signal * left + c.noise * c.noise);
    }

    /// What is held: the position, and the deviation where there is one.
    fn write(&self, c: &Coefficients, state: &[f64], outputs: &mut [f64]) {
        let mut held = state.iter().rev();
        let mut outputs = outputs.iter_mut();
        if let (Some(y), Some(held)) = (outputs.next(), held.next()) {
            *y = c.output[0] + c.output[1] * held;
        }
        if let (Some(deviation), Some(held)) = (outputs.next(), held.next()) {
            *deviation = *held;
        }
    }
}

impl Component for Loaded {
    fn declaration(&self) -> &'static Declaration {
        self.deviation.as_ref().map_or(self.family.declaration, |(declaration, _)| declaration)
    }

    fn table(&self) -> Option<&Table> {
        Some(&self.table)
    }

    fn inverses(&self) -> &'static [Inverse] {
        self.family.inverses
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        // Memory, input, room, then kernels and the held deviation, and the held output.
        let deviation = if self.deviation.is_some() { self.centres() + 1 } else { 0 };
        Sizes { coefficients: 7, states: self.own() + deviation + 1 }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[command_low, command_high, position_low, position_high, ref rest @ ..] = parameters
        else {
            return Err(Violation {
                quantity: "sample_time",
                index: None,
                value: 0.0,
                rule: "this component was given a wrong number of values",
            });
        };
        let ratio = ratio(structure, period)?;
        check_range("command_high", command_low, command_high)?;
        check_range("position_high", position_low, position_high)?;
        let command = [command_low, command_high - command_low];
        let position = [position_low, position_high - position_low];
        let [input, output] =
            if self.family.inverse { [position, command] } else { [command, position] };
        let [a, b] = input;
        let [c, d] = output;
        let [signal, noise] = [0, 1].map(|at| rest.get(at).copied().unwrap_or(0.0));
        coefficients.copy_from_slice(&[ratio, a, b, c, d, signal, noise]);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some(c), &[u]) = (read(coefficients), inputs) else { return };
        let Some((held, own)) = state.split_last_mut() else { return };
        let x = (u - c.input[0]) / c.input[1];
        let memory = self.features.memory();
        // Where the way to rest begins: both ranges in proportion.
        self.features.rest(x, x.clamp(0.0, 1.0), &mut own[..memory]);
        for _ in 0..STEPS_TO_REST {
            *held = self.sample(x, own);
        }
        self.deviate(&c, own);
        self.write(&c, state, outputs);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some(c), &[u]) = (read(coefficients), inputs) else { return };
        if tick.index.is_multiple_of(c.ratio.max(1)) {
            let Some((held, own)) = state.split_last_mut() else { return };
            *held = self.sample((u - c.input[0]) / c.input[1], own);
            self.deviate(&c, own);
        }
        self.write(&c, state, outputs);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NARX: [f64; 3] = [5e-3, 1.0, 1.0];
    const RANGES: [f64; 4] = [0.0, 150.0, -1e-4, 1e-4];

    /// Two support vectors over u(t), u(t−1), y(t−1).
    fn table() -> Table {
        let rows = [0.2, 1.0, 1.5, 2.0, 0.4, 0.9, 0.8, 0.5, -0.3, 0.1, 0.2, 0.1];
        Table::new(4, rows.to_vec()).unwrap()
    }

    fn loaded() -> ComponentRef {
        declarations::LSSVM_NARX.with_table(&NARX, &table()).unwrap()
    }

    #[test]
    fn a_sample_is_the_kernel_sum_of_the_features_and_is_held_between() {
        let component = loaded();
        let period = 1e-3;
        let sizes = component.sizes(&NARX, period);
        let (mut k, mut state) = (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
        component.prepare(&NARX, &RANGES, period, &mut k).unwrap();
        let mut y = [0.0];
        component.rest(&k, &[0.0], &mut state, &mut y);
        let rows = table();
        let f = |z: [f64; 3]| {
            let v = rows.values();
            0.2 + (1..3)
                .map(|i| {
                    let row = &v[4 * i..4 * i + 4];
                    let squares = (0..3).map(|j| ((row[j + 1] - z[j]) / v[j + 1]).powi(2));
                    row[0] * (-squares.sum::<f64>()).exp()
                })
                .sum::<f64>()
        };
        let mut last = (y[0] + 1e-4) / 2e-4;
        assert!((f([0.0, 0.0, last]) - last).abs() < 1e-12, "no rest");
        let mut before = 0.0;
        for index in 1..=40_u64 {
            let u = 3.0 * index as f64;
            let tick = Tick { index, time: period * index as f64, period };
            component.step(&k, &mut state, tick, &[u], &mut y);
            if index % 5 == 0 {
                let now = f([u / 150.0, before / 150.0, last]);
                (last, before) = (now, u);
            }
            assert!((y[0] - (-1e-4 + 2e-4 * last)).abs() < 1e-15);
        }
    }

    #[test]
    fn stop_operators_stand_on_a_straight_line() {
        // One stop operator at 0.5, the input and its rate; one far support vector, so the line alone is left.
        let rows = [0.1, 1.0, 1.0, 1.0, 0.3, 50.0, 50.0, 50.0];
        let table = Table::new(4, rows.to_vec()).unwrap();
        let structure = |slope: f64| [1e-3, 1.0, 1.0, 1.0, slope, 0.0];
        let answer = |slope: f64, u: f64| {
            let component =
                declarations::LSSVM_STOPS.with_table(&structure(slope), &table).unwrap();
            let sizes = component.sizes(&structure(slope), 1e-3);
            let (mut k, mut state) = (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
            component.prepare(&structure(slope), &[0.0, 10.0, 0.0, 2.0], 1e-3, &mut k).unwrap();
            let mut y = [0.0];
            component.rest(&k, &[0.0], &mut state, &mut y);
            let tick = Tick { index: 1, time: 1e-3, period: 1e-3 };
            component.step(&k, &mut state, tick, &[u], &mut y);
            y[0]
        };
        assert!((answer(0.0, 5.0) - 0.2).abs() < 1e-12);
        // Scaled 0.5, and beyond the low end −0.3.
        assert!((answer(0.8, 5.0) - (0.2 + 2.0 * 0.8 * 0.5)).abs() < 1e-12);
        assert!((answer(0.8, -3.0) - (0.2 - 2.0 * 0.8 * 0.3)).abs() < 1e-12);
    }

    #[test]
    fn a_projection_adds_the_stops_to_the_command() {
        // One stop operator at 0.5 with weight −0.4; one support vector over the projected command.
        let rows = [0.1, 1e3, 0.5, 1e9, 0.0, -0.4, 0.0, 0.0, 2.0, 0.0, 0.3, 0.0];
        let table = Table::new(4, rows.to_vec()).unwrap();
        let structure = [1e-3, 1.0, 1.0, 1.0, 0.0, 1.0];
        let component = declarations::LSSVM_STOPS.with_table(&structure, &table).unwrap();
        let sizes = component.sizes(&structure, 1e-3);
        let (mut k, mut state) = (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
        component.prepare(&structure, &[0.0, 1.0, 0.0, 1.0], 1e-3, &mut k).unwrap();
        let mut y = [0.0];
        component.rest(&k, &[0.0], &mut state, &mut y);
        let mut at = |index: u64, u: f64| {
            let tick = Tick { index, time: 1e-3 * index as f64, period: 1e-3 };
            component.step(&k, &mut state, tick, &[u], &mut y);
            y[0]
        };
        // Up to 0.9 the stop ends at 0.5, down to 0.7 at 0.3.
        for (index, u, stop) in [(1, 0.9, 0.5), (2, 0.7, 0.3_f64)] {
            let x: f64 = (u - 0.4 * stop - 0.3) / 0.5;
            let expected = 0.1 + 2.0 * (-x * x).exp();
            assert!((at(index, u) - expected).abs() < 1e-5, "{u}");
        }
        let short = Table::new(4, rows[..8].to_vec()).unwrap();
        let text = declarations::LSSVM_STOPS.with_table(&structure, &short).err().unwrap();
        assert!(text.contains("at least 3 rows"), "{text}");
    }

    #[test]
    fn what_does_not_fit_is_reported_with_the_numbers() {
        let family = &declarations::LSSVM_NARX;
        let text = family.with_table(&[5e-3, 2.0, 1.0], &table()).err().unwrap();
        assert!(text.contains("4 inputs") && text.contains("3 rows of 4"), "{text}");
        let mut broken = table().values().to_vec();
        broken[6] = f64::NAN;
        let text = family.with_table(&NARX, &Table::new(4, broken).unwrap()).err().unwrap();
        assert!(text.contains("row 2, column 3"), "{text}");
        assert!(family.prepare(&NARX, &RANGES, 1e-3, &mut []).is_err());
        let component = loaded();
        let mut k = [0.0; 5];
        let violation = component.prepare(&NARX, &RANGES, 2e-3, &mut k).unwrap_err();
        assert_eq!(violation.quantity, "sample_time");
        assert!(component.prepare(&NARX, &[0.0, 0.0, 0.0, 1.0], 1e-3, &mut k).is_err());
    }

    #[test]
    fn kinds_are_unique_in_the_complete_list() {
        for (at, c) in COMPONENTS.iter().enumerate() {
            let kind = c.declaration().kind;
            assert!(COMPONENTS[..at].iter().all(|other| other.declaration().kind != kind));
        }
        assert!(COMPONENTS.len() > OWN.len() + 50);
    }
}
