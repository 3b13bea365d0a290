//! What each play of unit weight, seen through the linear parts, answers to a record's input.
//!
//! The components themselves compute it, so that a fit and the plant that is written from it agree
//! to rounding.

use components::hysteresis::play::play;
use model::{Component, Tick, Violation};

use crate::error::Error;

/// The linear parts of an axis around its hysteresis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LinearPart {
    /// Transport delay in s.
    pub(crate) delay: f64,
    /// Bandwidth of the amplifier in Hz.
    pub(crate) bandwidth: Option<f64>,
    /// Mode of the mechanics.
    pub(crate) mode: Option<ModeShape>,
}

/// Frequency (Hz) and damping ratio of a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ModeShape {
    pub(crate) frequency: f64,
    pub(crate) damping: f64,
}

/// One component with one path input, ready to run.
pub(crate) struct Part {
    component: &'static dyn Component,
    coefficients: Vec<f64>,
    state: Vec<f64>,
    period: f64,
    index: u64,
}

impl Part {
    /// # Errors
    /// [`Error::Model`] where the component refuses its parameters.
    pub(crate) fn new(
        component: &'static dyn Component,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
    ) -> Result<Self, Error> {
        let sizes = component.sizes(structure, period);
        let mut coefficients = vec![0.0; sizes.coefficients];
        component.prepare(structure, parameters, period, &mut coefficients).map_err(
            |violation: Violation| Error::Model {
                name: component.declaration().kind.to_owned(),
                message: violation.to_string(),
            },
        )?;
        Ok(Self { component, coefficients, state: vec![0.0; sizes.states], period, index: 0 })
    }

    /// What the component remembers.
    pub(crate) fn state(&self) -> &[f64] {
        &self.state
    }

    /// The output at rest under this input.
    pub(crate) fn rest(&mut self, input: f64) -> f64 {
        let mut output = [input];
        self.index = 0;
        self.component.rest(&self.coefficients, &[input], &mut self.state, &mut output);
        output[0]
    }

    /// The output after a step under this input.
    pub(crate) fn step(&mut self, input: f64) -> f64 {
        let mut output = [input];
        self.index += 1;
        let time = self.index as f64 * self.period;
        let tick = Tick { index: self.index, time, period: self.period };
        self.component.step(&self.coefficients, &mut self.state, tick, &[input], &mut output);
        output[0]
    }
}

/// The response of each play to `input` held over `period`: one column per threshold, and one row
/// per sample, read before the sample's input acts. The machine starts at rest under `rest`.
/// `substeps` internal steps are made per period.
///
/// # Errors
/// [`Error::Model`] where a component refuses its parameters.
pub(crate) fn responses(
    rest: f64,
    input: &[f64],
    period: f64,
    substeps: usize,
    thresholds: &[f64],
    linear: &LinearPart,
) -> Result<Vec<Vec<f64>>, Error> {
    let step = period / substeps as f64;
    let mut before = before_hysteresis(linear, step)?;
    let mut after = Vec::with_capacity(thresholds.len());
    for _ in thresholds {
        after.push(after_hysteresis(linear, step)?);
    }
    let mut columns = vec![Vec::with_capacity(input.len()); thresholds.len()];
    let Some((_, held)) = input.split_last() else { return Ok(columns) };
    let start = before.iter_mut().fold(rest, |signal, part| part.rest(signal));
    let mut plays: Vec<f64> = thresholds.iter().map(|r| play(start, *r, 0.0)).collect();
    for ((column, after), play) in columns.iter_mut().zip(&mut after).zip(&plays) {
        column.push(after.as_mut().map_or(*play, |part| part.rest(*play)));
    }
    for &command in held {
        for substep in 1..=substeps {
            let signal = before.iter_mut().fold(command, |signal, part| part.step(signal));
            let bank = columns.iter_mut().zip(&mut after).zip(&mut plays).zip(thresholds);
            for (((column, after), state), r) in bank {
                *state = play(signal, *r, *state);
                let output = after.as_mut().map_or(*state, |part| part.step(*state));
                if substep == substeps {
                    column.push(output);
                }
            }
        }
    }
    Ok(columns)
}

pub(crate) fn before_hysteresis(linear: &LinearPart, step: f64) -> Result<Vec<Part>, Error> {
    let mut parts = Vec::new();
    if linear.delay > 0.0 {
        let delay = &components::timing::Delay;
        parts.push(Part::new(delay, &[linear.delay], &[linear.delay], step)?);
    }
    if let Some(bandwidth) = linear.bandwidth {
        let lag = &components::amplifier::AmplifierLag;
        parts.push(Part::new(lag, &[], &[bandwidth, 1.0], step)?);
    }
    Ok(parts)
}

pub(crate) fn after_hysteresis(linear: &LinearPart, step: f64) -> Result<Option<Part>, Error> {
    let Some(ModeShape { frequency, damping }) = linear.mode else { return Ok(None) };
    let mode = &components::mechanics::MODE;
    Part::new(mode, &[], &[frequency, damping, 1.0], step).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_read_before_its_input_acts() {
        let input = [0.0, 1.0, 2.0, 3.0];
        let columns = responses(input[0], &input, 0.1, 1, &[0.0, 0.5], &LinearPart::default());
        let columns = columns.expect("runs");
        assert_eq!(columns[0], [0.0, 0.0, 1.0, 2.0]);
        assert_eq!(columns[1], [0.0, 0.0, 0.5, 1.5]);
    }

    #[test]
    fn at_rest_the_plays_are_on_the_virgin_curve() {
        let columns =
            responses(2.0, &[2.0; 3], 0.1, 4, &[0.5], &LinearPart::default()).expect("runs");
        assert_eq!(columns[0], [1.5; 3]);
    }

    #[test]
    fn delay_shifts_and_substeps_do_not_change_a_static_model() {
        let input: Vec<f64> = (0..200).map(|k| (f64::from(k) * 0.37).sin()).collect();
        let linear = LinearPart { delay: 0.2, ..LinearPart::default() };
        let one = responses(input[0], &input, 0.1, 1, &[0.0, 0.3], &linear).expect("runs");
        let four = responses(input[0], &input, 0.1, 4, &[0.0, 0.3], &linear).expect("runs");
        assert_eq!(one, four);
        assert_eq!(one[0][3..], input[..197]);
    }
}
