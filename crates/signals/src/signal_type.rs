//! What a signal declares, and how settings are checked and turned into samples.

use crate::error::{Problem, SignalError};
use crate::parameter::{Parameter, SAMPLE_TIME};
use crate::signal::{Channel, Signal};

/// Greatest number of samples of one record.
pub const MAX_SAMPLES: usize = 10_000_000;

/// A kind of signal: everything known about it, declared once.
#[derive(Clone, Copy, Debug)]
pub struct SignalType {
    /// Name, as commands take it.
    pub name: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// Paper and place, or what stands in where the paper gives no formula.
    pub source: &'static str,
    /// The equation.
    pub equation: &'static str,
    /// Parameters with start values and bounds.
    pub parameters: &'static [Parameter],
    /// Channels.
    pub channels: &'static [ChannelType],
    /// Rules between parameters.
    pub rules: &'static [Rule],
    /// Number of samples N, a whole number, for settings that keep the rules.
    pub(crate) samples: fn(&Settings) -> f64,
    /// The values of each channel, N each, for settings that keep the rules.
    pub(crate) law: fn(&Settings) -> Vec<Vec<f64>>,
}

/// A channel as declared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelType {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// No value lies below this with the start values of all parameters.
    pub low: f64,
    /// No value lies above this with the start values of all parameters.
    pub high: f64,
}

impl ChannelType {
    /// A channel with its limits.
    pub(crate) const fn new(name: &'static str, unit: &'static str, low: f64, high: f64) -> Self {
        Self { name, unit, low, high }
    }
}

/// A rule between parameters.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The parameter that a refusal names.
    pub parameter: &'static str,
    /// What must hold and the way out, to follow the parameter's value.
    pub text: &'static str,
    /// Whether it holds; every value is within its own bounds when this is asked.
    pub(crate) holds: fn(&Settings) -> bool,
}

/// The values of all parameters of one signal, checked ([`SignalType::checked`]).
#[derive(Clone, Debug)]
pub struct Settings {
    parameters: &'static [Parameter],
    values: Vec<f64>,
    /// 0 until the rules are checked.
    samples: usize,
}

impl Settings {
    /// Value of a declared parameter.
    pub(crate) fn get(&self, parameter: &Parameter) -> f64 {
        let declared = self.value(parameter.name);
        // A law that asks for more than its signal declares is a mistake of this crate's.
        if cfg!(any(test, debug_assertions)) {
            assert!(declared.is_some(), "{} is not declared", parameter.name);
        }
        declared.unwrap_or(parameter.start)
    }

    /// Value of a whole parameter; its bounds fit.
    pub(crate) fn count(&self, parameter: &Parameter) -> usize {
        self.get(parameter) as usize
    }

    /// Value of the parameter of this name.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        let at = self.parameters.iter().position(|p| p.name == name)?;
        self.values.get(at).copied()
    }

    /// Number of samples N of the record.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Sample time T in s.
    pub(crate) fn sample_time(&self) -> f64 {
        self.get(&SAMPLE_TIME)
    }

    /// `law` at t = n·T, n = 0 … N − 1.
    pub(crate) fn sampled(&self, law: impl Fn(f64) -> f64) -> Vec<f64> {
        let period = self.sample_time();
        (0..self.samples).map(|n| law(n as f64 * period)).collect()
    }

    /// `seconds` in sample times, rounded to the nearest whole number.
    pub(crate) fn ticks(&self, seconds: f64) -> f64 {
        libm::round(seconds / self.sample_time())
    }
}

impl SignalType {
    /// The signal with these settings; a parameter that is not named keeps its start value.
    ///
    /// # Errors
    /// [`SignalError`] with every problem of the settings: unknown or repeated names, values out of
    /// their bounds, broken rules, records of no or too many samples.
    pub fn generate(&self, settings: &[(&str, f64)]) -> Result<Signal, SignalError> {
        let settings = self.checked(settings)?;
        let named = |(channel, values): (&ChannelType, Vec<f64>)| Channel {
            name: channel.name.to_owned(),
            unit: channel.unit.to_owned(),
            values,
        };
        let channels = self.channels.iter().zip((self.law)(&settings)).map(named).collect();
        Ok(Signal { period: settings.sample_time(), channels })
    }

    /// The parameter of this name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        self.parameters.iter().find(|p| p.name == name)
    }

    /// The values of all parameters, checked.
    ///
    /// # Errors
    /// [`SignalError`] with every problem of the settings.
    pub fn checked(&self, given: &[(&str, f64)]) -> Result<Settings, SignalError> {
        let (mut settings, mut problems) = self.merged(given);
        if problems.is_empty() {
            problems.extend(self.rules.iter().filter_map(|rule| self.broken(rule, &settings)));
        }
        if problems.is_empty() {
            let samples = (self.samples)(&settings);
            if (1.0..=MAX_SAMPLES as f64).contains(&samples) {
                settings.samples = samples as usize;
                return Ok(settings);
            }
            let sample_time = settings.sample_time();
            problems.push(Problem::Samples { samples, sample_time, max: MAX_SAMPLES });
        }
        Err(SignalError { signal: self.name, problems })
    }

    /// Start values with the given ones over them, and what is wrong with the given ones.
    fn merged(&self, given: &[(&str, f64)]) -> (Settings, Vec<Problem>) {
        let mut values: Vec<f64> = self.parameters.iter().map(|p| p.start).collect();
        let mut problems = Vec::new();
        let mut seen = vec![false; values.len()];
        for &(name, value) in given {
            let found = self.parameters.iter().zip(&mut values).zip(&mut seen);
            match found.into_iter().find(|((p, _), _)| p.name == name) {
                None => problems.push(self.unknown(name, value)),
                Some(((p, _), seen)) if *seen => {
                    problems.push(Problem::Twice { name: p.name, value });
                }
                Some(((p, slot), seen)) => {
                    problems.extend(out_of_bounds(p, value));
                    (*slot, *seen) = (value, true);
                }
            }
        }
        (Settings { parameters: self.parameters, values, samples: 0 }, problems)
    }

    fn unknown(&self, name: &str, value: f64) -> Problem {
        let known: Vec<&str> = self.parameters.iter().map(|p| p.name).collect();
        Problem::Unknown { name: name.to_owned(), value, known: known.join(", ") }
    }

    fn broken(&self, rule: &Rule, settings: &Settings) -> Option<Problem> {
        if (rule.holds)(settings) {
            return None;
        }
        let parameter = self.parameter(rule.parameter)?;
        let value = settings.get(parameter);
        Some(Problem::Rule { name: parameter.name, value, unit: parameter.unit, rule: rule.text })
    }
}

/// Whether a single value keeps its own bounds; a value that is no number keeps none.
fn out_of_bounds(parameter: &Parameter, value: f64) -> Option<Problem> {
    let &Parameter { name, unit, min, max, integer, .. } = parameter;
    if !(min..=max).contains(&value) {
        Some(Problem::OutOfRange { name, value, unit, min, max })
    } else if integer && value.fract() != 0.0 {
        Some(Problem::NotInteger { name, value })
    } else {
        None
    }
}
