//! A parameter of a signal, declared once, on one line.

/// Name, unit, sentence, start value and bounds of a number that shapes a signal. It always has a
/// start value, so that every signal can be generated without any setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name, as settings give it.
    pub name: &'static str,
    /// Unit (`1` for a count).
    pub unit: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// Value where none is given, in [`unit`](Self::unit).
    pub start: f64,
    /// Least value allowed.
    pub min: f64,
    /// Greatest value allowed.
    pub max: f64,
    /// Whether it must be a whole number.
    pub integer: bool,
}

impl Parameter {
    /// A real number.
    pub(crate) const fn real(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        [start, min, max]: [f64; 3],
    ) -> Self {
        Self { name, unit, description, start, min, max, integer: false }
    }

    /// A count or another whole number.
    pub(crate) const fn integer(
        name: &'static str,
        description: &'static str,
        [start, min, max]: [u64; 3],
    ) -> Self {
        let [start, min, max] = [start as f64, min as f64, max as f64];
        Self { name, unit: "1", description, start, min, max, integer: true }
    }

    /// This parameter with another start value.
    pub(crate) const fn start(mut self, value: f64) -> Self {
        self.start = value;
        self
    }

    /// This parameter with another greatest value.
    pub(crate) const fn max(mut self, value: f64) -> Self {
        self.max = value;
        self
    }
}

/// Time between two samples.
pub(crate) const SAMPLE_TIME: Parameter =
    Parameter::real("sample_time", "s", "Time T between two samples.", [1e-3, 1e-7, 10.0]);

/// Length of a record whose length is free.
pub(crate) const DURATION: Parameter = Parameter::real(
    "duration",
    "s",
    "Length of the record; the samples lie at n·T from 0 to just below it.",
    [1.0, 1e-6, 1e5],
);

/// Frequency of a periodic signal.
pub(crate) const FREQUENCY: Parameter =
    Parameter::real("frequency", "Hz", "Frequency.", [1.0, 1e-6, 1e6]);

/// Lower limit of a signal.
pub(crate) const LOW: Parameter =
    Parameter::real("low", "V", "Least value of the signal.", [0.0, -1e4, 1e4]);

/// Upper limit of a signal.
pub(crate) const HIGH: Parameter =
    Parameter::real("high", "V", "Greatest value of the signal.", [100.0, -1e4, 1e4]);

/// Seed of the random numbers.
pub(crate) const SEED: Parameter = Parameter::integer(
    "seed",
    "Seed of the random numbers (ChaCha8); the same seed gives the same bits on every machine.",
    [1, 0, 1 << 53],
);

/// Length of a smooth rise.
pub(crate) const RISE: Parameter = Parameter::real(
    "rise",
    "s",
    "Time that a change of level takes, as a half cosine wave; 0 jumps within one sample.",
    [0.0, 0.0, 1e5],
);
