//! The linear parts around a hysteresis.
//!
//! The components themselves compute them, so that a fit and the plant that is written from it agree
//! to rounding.

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
