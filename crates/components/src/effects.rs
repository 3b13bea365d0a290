//! The physical causes of a gap between a machine and its model, by fixed identifier.
//!
//! Each record says where on the signal path the effect sits, how it shows in the residual once the
//! model's parameters have been re-tuned, what it is confused with, and which experiment tells them
//! apart.

use model::Stage::{Actuator, Amplifier, Coupling, Environment, Mechanics, Sensor, Timing};
use model::{Effect, Group};

/// All effects, in the order of the signal path.
pub static EFFECTS: [&Effect; 30] = [
    &DELAY,
    &CLOCK_OFFSET,
    &DAC_QUANTISATION,
    &AMPLIFIER_BANDWIDTH,
    &AMPLIFIER_SLEW,
    &AMPLIFIER_SATURATION,
    &CREEP,
    &HYSTERESIS,
    &ASYMMETRY,
    &RATE_DEPENDENCE,
    &POLARISATION_SATURATION,
    &ACTUATOR_GAIN,
    &SELF_HEATING,
    &INITIAL_STATE,
    &RESONANCE_SHIFT,
    &DAMPING,
    &EXTRA_MODE,
    &DUFFING,
    &BACKLASH,
    &FRICTION,
    &PERIODIC_DISTURBANCE,
    &CROSS_COUPLING,
    &THERMAL_DRIFT,
    &FLOOR_VIBRATION,
    &SENSOR_BANDWIDTH,
    &SENSOR_NONLINEARITY,
    &SENSOR_NOISE,
    &SENSOR_QUANTISATION,
    &MAINS_HUM,
    &CROSSTALK,
];

/// Transport delay of computing, bus and converter.
pub static DELAY: Effect = Effect {
    name: "delay",
    stage: Timing,
    group: Some(Group::Lag),
    signature: "phase falls linearly with frequency at every amplitude; a step starts late",
    confused_with: &["amplifier_bandwidth", "sensor_bandwidth"],
    experiment: "phase over frequency: a delay is straight up to the Nyquist frequency; onset of \
                 a step",
};

/// Offset and jitter of the sample clock.
pub static CLOCK_OFFSET: Effect = Effect {
    name: "clock_offset",
    stage: Timing,
    group: None,
    signature: "grows with record time times slope of the signal; jitter looks like noise that \
                grows with frequency and amplitude",
    confused_with: &["delay", "thermal_drift"],
    experiment: "compare the times of edges at the start and at the end of a long record",
};

/// Resolution of the command's converter.
pub static DAC_QUANTISATION: Effect = Effect {
    name: "dac_quantisation",
    stage: Timing,
    group: None,
    signature: "stairs at small signals, a fixed function of the command; visible only where a \
                step exceeds the noise",
    confused_with: &["sensor_noise", "friction"],
    experiment: "a slow ramp over a few steps of the converter",
};

/// Bandwidth of the amplifier into the actuator's capacitance.
pub static AMPLIFIER_BANDWIDTH: Effect = Effect {
    name: "amplifier_bandwidth",
    stage: Amplifier,
    group: Some(Group::Lag),
    signature: "phase from a tenth of the bandwidth on, independent of amplitude",
    confused_with: &["sensor_bandwidth", "delay", "rate_dependence"],
    experiment: "record the amplifier's monitor voltage; or large signals at a high rate, where a \
                 lag in front of the hysteresis shrinks its loop",
};

/// Current limit of the amplifier, as a limit of the voltage's slope.
pub static AMPLIFIER_SLEW: Effect = Effect {
    name: "amplifier_slew",
    stage: Amplifier,
    group: None,
    signature: "only large and fast signals: a sine becomes triangular, third harmonic; zero \
                below a threshold of the slope",
    confused_with: &["rate_dependence", "amplifier_saturation"],
    experiment: "the same frequency at half the amplitude: it disappears at once",
};

/// Voltage limits of the amplifier.
pub static AMPLIFIER_SATURATION: Effect = Effect {
    name: "amplifier_saturation",
    stage: Amplifier,
    group: Some(Group::StaticMap),
    signature: "flat top at one end of the range; zero inside",
    confused_with: &["polarisation_saturation", "sensor_nonlinearity"],
    experiment: "reduce the offset of the command; histogram of the position",
};

/// Slow elongation after a change of the voltage.
pub static CREEP: Effect = Effect {
    name: "creep",
    stage: Actuator,
    group: Some(Group::Slow),
    signature: "below 1 Hz, follows the sign of the last step and is proportional to it, straight \
                over the logarithm of time",
    confused_with: &["thermal_drift", "self_heating", "hysteresis"],
    experiment: "repeat a staircase up and down with holds of 0.1 to 100 s: creep restarts at \
                 each step, drift does not",
};

/// Memory between voltage and elongation.
pub static HYSTERESIS: Effect = Effect {
    name: "hysteresis",
    stage: Actuator,
    group: None,
    signature: "odd harmonics; width of the loop proportional to the amplitude, independent of \
                rate",
    confused_with: &["backlash", "creep", "amplifier_bandwidth"],
    experiment: "loops at two amplitudes and two rates: backlash keeps a constant width, a lag's \
                 width grows with the rate",
};

/// Different rising and falling branches of the hysteresis.
pub static ASYMMETRY: Effect = Effect {
    name: "asymmetry",
    stage: Actuator,
    group: None,
    signature: "even harmonics; opposite sign on the rising and the falling branch",
    confused_with: &["sensor_nonlinearity", "amplifier_saturation"],
    experiment: "slow triangle: the residual over the command, rising and falling apart",
};

/// Hysteresis whose loop grows with the rate.
pub static RATE_DEPENDENCE: Effect = Effect {
    name: "rate_dependence",
    stage: Actuator,
    group: None,
    signature: "grows with rate times amplitude",
    confused_with: &["amplifier_bandwidth", "delay", "extra_mode", "amplifier_slew"],
    experiment: "frequency response at 1 % of the amplitude: lag and delay remain, rate \
                 dependence vanishes",
};

/// Saturation of the strain towards both ends of the voltage range.
pub static POLARISATION_SATURATION: Effect = Effect {
    name: "polarisation_saturation",
    stage: Actuator,
    group: Some(Group::StaticMap),
    signature: "large signals only; odd harmonic, at the top and the bottom of the stroke",
    confused_with: &["amplifier_saturation", "sensor_nonlinearity"],
    experiment: "record the amplifier's monitor voltage; shift the working range",
};

/// Gain of the path: piezoelectric constant, its temperature and ageing, amplifier and sensor gain.
pub static ACTUATOR_GAIN: Effect = Effect {
    name: "actuator_gain",
    stage: Actuator,
    group: Some(Group::Gain),
    signature: "proportional to the signal at all frequencies below the first resonance",
    confused_with: &["resonance_shift", "sensor_nonlinearity"],
    experiment: "a second sensor or the monitor voltage; log the temperature",
};

/// Warming of the actuator by its own losses.
pub static SELF_HEATING: Effect = Effect {
    name: "self_heating",
    stage: Actuator,
    group: Some(Group::Slow),
    signature: "slow drift that depends on the power of the drive (frequency times voltage \
                squared)",
    confused_with: &["thermal_drift", "creep"],
    experiment: "alternate high and low power at the same mean",
};

/// Unknown memory of the hysteresis at the start of the record.
pub static INITIAL_STATE: Effect = Effect {
    name: "initial_state",
    stage: Actuator,
    group: None,
    signature: "only until the first full reversal",
    confused_with: &["hysteresis", "thermal_drift"],
    experiment: "a run-in cycle before the record, then compare",
};

/// Payload mass or stiffness that moves the resonance.
pub static RESONANCE_SHIFT: Effect = Effect {
    name: "resonance_shift",
    stage: Mechanics,
    group: Some(Group::Gain),
    signature: "around the resonance only, the phase of both signs; with a stiffness the static \
                gain moves as well",
    confused_with: &["extra_mode", "actuator_gain", "damping"],
    experiment: "add a known mass; plot gain against resonance frequency",
};

/// Damping of the resonance.
pub static DAMPING: Effect = Effect {
    name: "damping",
    stage: Mechanics,
    group: None,
    signature: "height of the resonance peak only",
    confused_with: &["resonance_shift"],
    experiment: "ring-down after a step",
};

/// A mode of the mechanics that the model lacks.
pub static EXTRA_MODE: Effect = Effect {
    name: "extra_mode",
    stage: Mechanics,
    group: None,
    signature: "narrow band; ringing after steps",
    confused_with: &["delay", "amplifier_bandwidth", "sensor_bandwidth"],
    experiment: "narrow multisine, or an impulse",
};

/// Stiffness that depends on the amplitude.
pub static DUFFING: Effect = Effect {
    name: "duffing",
    stage: Mechanics,
    group: None,
    signature: "the peak moves with the amplitude; jumps in sweeps up and down",
    confused_with: &["polarisation_saturation", "hysteresis"],
    experiment: "frequency response at three amplitudes",
};

/// Clearance or loose preload.
pub static BACKLASH: Effect = Effect {
    name: "backlash",
    stage: Mechanics,
    group: None,
    signature: "loop of constant width, dead band at reversals",
    confused_with: &["hysteresis", "friction"],
    experiment: "triangle of tiny amplitude: below the clearance the stroke vanishes",
};

/// Friction of guides and stick-slip drives.
pub static FRICTION: Effect = Effect {
    name: "friction",
    stage: Mechanics,
    group: None,
    signature: "steps at reversals, stairs; limit cycles in closed loop",
    confused_with: &["backlash", "hysteresis"],
    experiment: "pre-sliding test: below break-away it is a spring",
};

/// Process force or vibration at a fixed frequency.
pub static PERIODIC_DISTURBANCE: Effect = Effect {
    name: "periodic_disturbance",
    stage: Mechanics,
    group: None,
    signature: "lines at the disturbance's frequency and its harmonics; a cutting force only \
                while in cut",
    confused_with: &["hysteresis", "mains_hum"],
    experiment: "air cut against cut; record at zero command",
};

/// Motion of an axis by its neighbour's drive.
pub static CROSS_COUPLING: Effect = Effect {
    name: "cross_coupling",
    stage: Coupling,
    group: None,
    signature: "coherent with the other axis' input; where dynamic, at the other axis' resonance",
    confused_with: &["floor_vibration", "crosstalk"],
    experiment: "drive one axis at a time; orthogonal multisines",
};

/// Thermal growth of the structure and drift of the sensor.
pub static THERMAL_DRIFT: Effect = Effect {
    name: "thermal_drift",
    stage: Environment,
    group: Some(Group::Slow),
    signature: "not coherent with the command; continues at zero command",
    confused_with: &["creep", "self_heating"],
    experiment: "record at zero command before and after",
};

/// Vibration of the floor.
pub static FLOOR_VIBRATION: Effect = Effect {
    name: "floor_vibration",
    stage: Environment,
    group: None,
    signature: "not coherent with the command, not repeatable over periods",
    confused_with: &["sensor_noise", "periodic_disturbance"],
    experiment: "coherence with an accelerometer",
};

/// Bandwidth of the sensor and its filters.
pub static SENSOR_BANDWIDTH: Effect = Effect {
    name: "sensor_bandwidth",
    stage: Sensor,
    group: Some(Group::Lag),
    signature: "the reading lags although the voltage is prompt, independent of amplitude",
    confused_with: &["amplifier_bandwidth", "delay"],
    experiment: "monitor voltage and a second sensor",
};

/// Static nonlinearity of the sensor, the converters or the geometry.
pub static SENSOR_NONLINEARITY: Effect = Effect {
    name: "sensor_nonlinearity",
    stage: Sensor,
    group: Some(Group::StaticMap),
    signature: "a polynomial of the position, the same on both branches and at every rate",
    confused_with: &["asymmetry", "polarisation_saturation", "amplifier_saturation"],
    experiment: "interferometer as reference; shift the working range",
};

/// White and 1/f noise of the sensor.
pub static SENSOR_NOISE: Effect = Effect {
    name: "sensor_noise",
    stage: Sensor,
    group: None,
    signature: "the floor itself; does not repeat over periods",
    confused_with: &["floor_vibration", "sensor_quantisation"],
    experiment: "record at zero command",
};

/// Resolution of the reading's converter.
pub static SENSOR_QUANTISATION: Effect = Effect {
    name: "sensor_quantisation",
    stage: Sensor,
    group: None,
    signature: "uniform noise of variance q^2/12",
    confused_with: &["sensor_noise"],
    experiment: "histogram of the reading",
};

/// Hum of the mains and its harmonics.
pub static MAINS_HUM: Effect = Effect {
    name: "mains_hum",
    stage: Sensor,
    group: None,
    signature: "lines at 50, 100, 150 Hz (60, 120, 180 Hz), present at zero command",
    confused_with: &["periodic_disturbance", "extra_mode"],
    experiment: "record at zero command; change the supply",
};

/// Electrical feed-through from the drive to the reading.
pub static CROSSTALK: Effect = Effect {
    name: "crosstalk",
    stage: Sensor,
    group: None,
    signature: "prompt, before the mechanics can move; rises with frequency",
    confused_with: &["cross_coupling", "delay"],
    experiment: "fix the stage mechanically and drive it",
};

/// The effect of this identifier.
#[must_use]
pub fn find(name: &str) -> Option<&'static Effect> {
    EFFECTS.iter().copied().find(|e| e.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_unique_and_look_alikes_exist() {
        for (i, effect) in EFFECTS.iter().enumerate() {
            assert!(EFFECTS[..i].iter().all(|e| e.name != effect.name), "{} twice", effect.name);
            assert!(i == 0 || EFFECTS[i - 1].stage <= effect.stage, "{} out of order", effect.name);
            for other in effect.confused_with {
                assert!(find(other).is_some(), "{}: {other} is no effect", effect.name);
                assert_ne!(*other, effect.name);
            }
        }
    }

    #[test]
    fn effects_of_a_group_are_confused_with_each_other() {
        for effect in EFFECTS.iter().filter(|e| e.group.is_some()) {
            let mates = EFFECTS.iter().filter(|e| e.group == effect.group && e.name != effect.name);
            let known = mates.filter(|e| effect.confused_with.contains(&e.name)).count();
            assert!(known > 0, "{} names none of its group", effect.name);
        }
    }

    #[test]
    fn every_component_names_an_effect_of_the_table() {
        for component in crate::COMPONENTS {
            let declaration = component.declaration();
            let Some(effect) = declaration.effect else { continue };
            assert!(EFFECTS.iter().any(|e| e.name == effect.name), "{}", declaration.kind);
        }
    }
}
