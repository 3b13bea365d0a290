//! The stages of the signal path.

/// Where on the signal path a component sits; the order is the order of the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Quantisation, delay, clock.
    Timing,
    /// Amplifier.
    Amplifier,
    /// Actuator: hysteresis, creep, polarisation, temperature.
    Actuator,
    /// Modes, load, backlash, friction, disturbance force.
    Mechanics,
    /// Cross-coupling between axes.
    Coupling,
    /// Thermal drift, floor.
    Environment,
    /// Sensor.
    Sensor,
    /// Control law (controllers only).
    Control,
}

impl Stage {
    /// The identifier used in files and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Timing => "timing",
            Self::Amplifier => "amplifier",
            Self::Actuator => "actuator",
            Self::Mechanics => "mechanics",
            Self::Coupling => "coupling",
            Self::Environment => "environment",
            Self::Sensor => "sensor",
            Self::Control => "control",
        }
    }
}
