//! A measured frequency response.

use nalgebra::DMatrix;

use super::Complex;

/// The response at one line.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// In Hz.
    pub frequency: f64,
    /// Outputs × inputs, in output units per input unit.
    pub response: DMatrix<Complex>,
    /// Standard deviation of each element, distortion and noise together.
    pub deviation: DMatrix<f64>,
    /// Per output: the share of its power that the inputs explain linearly (multiple coherence).
    pub coherence: Vec<f64>,
    /// Per output: amplitude of the line.
    pub amplitude: Vec<f64>,
    /// Per output: amplitude of what is not linear in the inputs, noise and distortion, over the mean of
    /// all periods.
    pub total: Vec<f64>,
    /// Per output: amplitude of the noise, over the mean of all periods; `None` without periods.
    pub noise: Option<Vec<f64>>,
    /// What this line says alone, without its neighbours; `None` without periods.
    pub alone: Option<Alone>,
}

/// The response of one line by itself: it scatters more than that of the local polynomials, and no resonance is
/// too narrow for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Alone {
    /// Outputs × inputs, in output units per input unit.
    pub response: DMatrix<Complex>,
    /// How strongly the inputs act, all together.
    pub strength: f64,
}

/// A measured frequency response.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyResponse {
    /// Line by line, in order of frequency.
    pub lines: Vec<Line>,
    /// Sample time in s.
    pub sample_time: f64,
    /// Samples per period, where the excitation is periodic.
    pub period: Option<usize>,
    /// Experiments and periods of each.
    pub experiments: usize,
    /// Periods of each experiment.
    pub periods: usize,
    /// Even and odd distortion at lines that are not excited.
    pub distortion: Distortion,
}

impl FrequencyResponse {
    /// A response that was measured elsewhere, for a sample time in s: per line its frequency in Hz, and response and
    /// standard deviation of each element, row by row. Nothing is known of noise and distortion.
    #[must_use]
    pub fn given(
        (outputs, inputs): (usize, usize),
        lines: Vec<(f64, Vec<Complex>, Vec<f64>)>,
        sample_time: f64,
    ) -> Self {
        let line = |(frequency, response, deviation): (f64, Vec<Complex>, Vec<f64>)| Line {
            frequency,
            response: DMatrix::from_row_slice(outputs, inputs, &response),
            deviation: DMatrix::from_row_slice(outputs, inputs, &deviation),
            coherence: vec![1.0; outputs],
            amplitude: vec![1.0; outputs],
            total: vec![0.0; outputs],
            noise: None,
            alone: None,
        };
        Self {
            lines: lines.into_iter().map(line).collect(),
            sample_time,
            period: None,
            experiments: 1,
            periods: 1,
            distortion: Distortion::default(),
        }
    }
}

/// Output at the lines between the excited ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Distortion {
    /// Frequency, and per output the amplitude, at even lines.
    pub even: Vec<(f64, Vec<f64>)>,
    /// Frequency, and per output the amplitude, at odd lines.
    pub odd: Vec<(f64, Vec<f64>)>,
}
