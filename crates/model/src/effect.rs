//! Effects by name: the identifiers that commands, files and reports use.

use crate::Stage;

/// Effects that input and output alone cannot always separate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Amplifier bandwidth, sensor bandwidth, delay.
    Lag,
    /// Actuator gain, stiffness.
    Gain,
    /// Creep, thermal drift, self-heating.
    Slow,
    /// Sensor nonlinearity, polarisation saturation, soft amplifier saturation.
    StaticMap,
}

/// What is known about one physical cause beyond its equation.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// Fixed identifier, as in `creep`.
    pub name: &'static str,
    /// Stage on the signal path.
    pub stage: Stage,
    /// Confusion group.
    pub group: Option<Group>,
    /// How it shows in the residual.
    pub signature: &'static str,
    /// What the effect is confused with.
    pub confused_with: &'static [&'static str],
    /// Which experiment tells them apart.
    pub experiment: &'static str,
}

/// What happens on the signal path of a machine, as a reader looks for it: a row of `docs/effects.md`.
#[derive(Clone, Copy, Debug)]
pub struct Phenomenon {
    /// In words.
    pub name: &'static str,
    /// What its components have in common or what tells them apart; empty where there is nothing to say.
    pub remark: &'static str,
}
