//! Figures that several pages draw of records: frequency responses with their coherence, histograms and
//! spectra of errors.

use std::f64::consts::{PI, TAU};

use identify::frequency::{Experiment, FrequencyResponse, Line, MeasureSettings, measure};
use report::{Axis, Bode, Histogram, Role, Spectrum};

use crate::thresholds::answer::Thresholds;

/// One input with signals that answer it.
pub struct Answered<'a> {
    /// The input.
    pub input: &'a [f64],
    /// Role, name and values of each.
    pub outputs: Vec<(Role, &'a str, &'a [f64])>,
    /// Sample time in s.
    pub period: f64,
}

/// The responses of all outputs, by one estimator (local polynomials), with their coherence; `None` where
/// the input does not excite enough lines.
pub fn bode(title: impl Into<String>, unit: &str, record: &Answered<'_>) -> Option<Bode> {
    let outputs = record.outputs.iter().map(|(_, _, values)| values.to_vec()).collect();
    let experiment =
        Experiment { name: "record".into(), inputs: vec![record.input.to_vec()], outputs };
    let settings = MeasureSettings {
        most_lines: Thresholds::RESPONSE_LINES,
        band: Thresholds::RESPONSE_BAND,
        ..MeasureSettings::new(record.period)
    };
    let found = measure(&[experiment], &settings).ok()?;
    if found.lines.len() < Thresholds::RESPONSE_FEWEST {
        return None;
    }
    let mut figure = Bode::new(title, unit).caption(caption(&found));
    for (k, (role, name, _)) in record.outputs.iter().enumerate() {
        let at = |line: &Line| line.response[(k, 0)];
        let column =
            |get: &dyn Fn(&Line) -> f64| -> Vec<f64> { found.lines.iter().map(get).collect() };
        let frequency = column(&|line| line.frequency);
        let magnitude = column(&|line| at(line).norm());
        let phase = unwrapped(column(&|line| at(line).arg()));
        let coherence = column(&|line| line.coherence.get(k).copied().unwrap_or(f64::NAN));
        figure = figure.response(*role, *name, &frequency, &magnitude, &phase, Some(&coherence));
    }
    Some(figure)
}

fn caption(found: &FrequencyResponse) -> String {
    let how = match found.period {
        Some(samples) => format!("{} periods of {samples} samples", found.periods),
        None => "a record without periods".to_owned(),
    };
    format!(
        "Local polynomial method over {how}. Coherence: the share of a signal's power that follows linearly \
         from the command; hysteresis and noise lower it."
    )
}

/// Phases without jumps of a turn.
pub fn unwrapped(phases: Vec<f64>) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last: Option<f64> = None;
    let mut all = Vec::with_capacity(phases.len());
    for phase in phases {
        if let Some(before) = last {
            turns -= ((phase - before) / TAU).round() * TAU;
        }
        last = Some(phase);
        all.push(phase + turns);
    }
    // The first phase lies within half a turn of 0.
    debug_assert!(all.first().is_none_or(|phase| phase.abs() <= PI + 1e-9));
    all
}

/// Name, role and values of errors.
pub type Errors<'a> = [(Role, &'a str, &'a [f64])];

/// How often errors occur.
pub fn histogram(title: impl Into<String>, unit: &str, errors: &Errors<'_>) -> Histogram {
    Histogram::new(title, Axis::new("error", unit), errors)
}

/// Amplitude densities of errors.
pub fn spectrum(
    title: impl Into<String>,
    unit: &str,
    period: f64,
    errors: &Errors<'_>,
) -> Spectrum {
    let axis = Axis::new("amplitude density", format!("{unit}/√Hz"));
    let all = errors.iter().fold(Spectrum::new(title, axis), |figure, (role, name, values)| {
        figure.density(*role, *name, values, period)
    });
    all.caption("Welch's method, Hann's window; the root of the integral of its square over frequency is the rms.")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_has_its_magnitude_and_phase_and_full_coherence() {
        let (period, tau) = (1e-3, 0.01);
        let keep = f64::exp(-period / tau);
        let (mut state, mut y) = (1_u64, 0.0);
        let (mut input, mut output) = (Vec::new(), Vec::new());
        for _ in 0..8192 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let u = (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5;
            output.push(y);
            y = keep * y + (1.0 - keep) * u;
            input.push(u);
        }
        let outputs = vec![(Role::Measured, "y", &output[..])];
        let record = Answered { input: &input, outputs, period };
        let figure = bode("t", "1", &record).expect("a response");
        let found = &figure.responses[0];
        for (f, m) in found.frequency.iter().zip(&found.magnitude) {
            let angle = TAU * f * period;
            let (re, im) = (1.0 - keep * angle.cos(), keep * angle.sin());
            let exact = (1.0 - keep) / re.hypot(im);
            assert!((m / exact - 1.0).abs() < 0.02, "{f}: {m} for {exact}");
        }
        let (_, least) = found.least_coherence.expect("coherence");
        assert!(least > 0.99, "{least}");
    }

    #[test]
    fn phases_do_not_jump() {
        let turning: Vec<f64> = (0..50).map(|k| -0.5 * f64::from(k)).collect();
        let wrapped = turning.iter().map(|p| (p + PI).rem_euclid(TAU) - PI).collect();
        for (a, b) in unwrapped(wrapped).iter().zip(&turning) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}
