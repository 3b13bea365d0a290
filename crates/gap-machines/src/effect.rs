//! The effects, each with two formulas and one size.

/// Which formula an effect has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Formula {
    /// The textbook's.
    Standard,
    /// Another formula of the same physics.
    Other,
}

/// One effect on a machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Insertion {
    /// Which.
    pub effect: Effect,
    /// The insertion's formula.
    pub formula: Formula,
    /// The insertion's size in a unit of its own, see [`Effect::reach`].
    pub magnitude: f64,
    /// Seed of its hidden constants and random signals.
    pub seed: u64,
}

macro_rules! effects {
    ($($(#[$doc:meta])* $variant:ident $name:literal $group:expr, $low:literal, $high:literal;)*) => {
        /// What a machine may do that its model does not.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Effect {
            $($(#[$doc])* $variant,)*
        }

        impl Effect {
            /// All effects of the generator.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// The identifier, as in `creep`.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// Confusion group, as in `slow`.
            #[must_use]
            pub const fn group(self) -> Option<&'static str> {
                match self { $(Self::$variant => $group,)* }
            }

            /// Least and greatest magnitude, between which a size is searched.
            #[must_use]
            pub const fn reach(self) -> (f64, f64) {
                match self { $(Self::$variant => ($low, $high),)* }
            }
        }
    };
}

effects! {
    /// Creep: elements or logarithmic; magnitude: share of the elongation (per decade).
    Creep "creep" Some("slow"), 1e-5, 1.0;
    /// Weights of the plays off, or a Bouc–Wen loop more; magnitude: relative, or µm.
    Hysteresis "hysteresis" None, 1e-3, 8.0;
    /// A generalised play, or loops that open at one end; magnitude: µm/V, or µm.
    Asymmetry "asymmetry" None, 1e-5, 10.0;
    /// Thresholds that grow with the rate, or a lag of the plays' input; magnitude: s.
    RateDependence "rate_dependence" None, 1e-8, 0.03;
    /// Flattening towards the ends: cubic, or tanh; magnitude: relative.
    PolarisationSaturation "polarisation_saturation" Some("static_map"), 1e-5, 2.0;
    /// Gain out of tolerance, constant or ageing; magnitude: relative.
    ActuatorGain "actuator_gain" Some("gain"), 1e-3, 2.0;
    /// Growth with the power of the drive, or a gain that grows with it; magnitude: µm, relative.
    SelfHeating "self_heating" Some("slow"), 1e-6, 30.0;
    /// One lag, or three in series; magnitude: s in total.
    AmplifierBandwidth "amplifier_bandwidth" Some("lag"), 1e-8, 0.02;
    /// Hard and even, or soft and uneven; magnitude: s/V, the inverse of the slope.
    AmplifierSlew "amplifier_slew" None, 1e-7, 1.0;
    /// Hard rail, or a soft knee; magnitude: share of the range that is cut off.
    AmplifierSaturation "amplifier_saturation" Some("static_map"), 1e-4, 0.9;
    /// Constant, or with a beat; magnitude: s.
    Delay "delay" Some("lag"), 1e-8, 0.02;
    /// Sample clock too fast, or wandering; magnitude: relative.
    ClockOffset "clock_offset" None, 1e-8, 0.02;
    /// Rounding, or downwards with missing codes; magnitude: V.
    DacQuantisation "dac_quantisation" None, 1e-4, 80.0;
    /// Rounding of the reading, or downwards with missing codes; magnitude: µm.
    SensorQuantisation "sensor_quantisation" None, 1e-5, 10.0;
    /// Mass, or stiffness; magnitude: relative shift of the frequency downwards.
    ResonanceShift "resonance_shift" Some("gain"), 1e-4, 0.9;
    /// More damping, or damping that grows with speed; magnitude: relative.
    Damping "damping" None, 1e-2, 200.0;
    /// Beside the path, or a pole-zero pair; magnitude: share of the static gain, relative shift.
    ExtraMode "extra_mode" None, 1e-6, 0.9;
    /// Hardening, or uneven softening; magnitude: relative change of stiffness at full scale.
    Duffing "duffing" None, 1e-6, 0.6;
    /// Dead, or with some stiffness within; magnitude: µm.
    Backlash "backlash" None, 1e-4, 9.0;
    /// Coulomb, or Dahl; magnitude: µm of elongation.
    Friction "friction" None, 1e-5, 4.0;
    /// At once, or through a lag and a mode; magnitude: µm/V.
    CrossCoupling "cross_coupling" None, 1e-7, 0.1;
    /// Polynomial, or sine and exponential; magnitude: relative.
    SensorNonlinearity "sensor_nonlinearity" Some("static_map"), 1e-6, 1.0;
    /// One lag, or three in series; magnitude: s in total.
    SensorBandwidth "sensor_bandwidth" Some("lag"), 1e-8, 0.02;
    /// Slope and exponential, or a random walk; magnitude: µm.
    ThermalDrift "thermal_drift" Some("slow"), 1e-4, 50.0;
    /// More noise than stated; magnitude: µm.
    SensorNoise "sensor_noise" None, 1e-4, 5.0;
    /// 50 Hz, or off frequency with a third harmonic; magnitude: µm.
    MainsHum "mains_hum" None, 1e-4, 5.0;
    /// A sine force, or blows; magnitude: µm of elongation.
    PeriodicDisturbance "periodic_disturbance" None, 1e-4, 5.0;
    /// Of the command, or of its rate; magnitude: µm/V, µm s/V.
    Crosstalk "crosstalk" None, 1e-9, 0.1;
    /// Memory of the plays at the begin of each record; magnitude: share of the thresholds.
    InitialState "initial_state" None, 1e-4, 1.0;
    /// In nobody's library: a gain that breathes; magnitude: relative.
    GainModulation "x_gain_modulation" None, 1e-5, 0.9;
    /// In nobody's library: random vibration in a narrow band; magnitude: µm.
    Vibration "x_vibration" None, 1e-4, 5.0;
    /// In nobody's library: jumps that decay; magnitude: µm.
    Glitches "x_glitches" None, 1e-4, 50.0;
    /// In nobody's library: an error that repeats with the position; magnitude: µm.
    PositionGrid "x_position_grid" None, 1e-4, 5.0;
    /// In nobody's library: droop; magnitude: corner in rad/s.
    AcCoupling "x_ac_coupling" None, 1e-5, 50.0;
    /// In nobody's library: readings that freeze; magnitude: s.
    HeldSamples "x_held_samples" None, 1e-4, 0.3;
    /// In nobody's library: popcorn noise; magnitude: µm.
    Telegraph "x_telegraph" None, 1e-4, 5.0;
}

impl Effect {
    /// The effect of this identifier.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|effect| effect.name() == name)
    }

    /// Whether it is in nobody's library: the right answer is that it is unknown.
    #[must_use]
    pub fn is_stray(self) -> bool {
        self.name().starts_with("x_")
    }

    /// Whether it is counted apart: it is part of the noise or of the start of a record.
    #[must_use]
    pub fn is_apart(self) -> bool {
        matches!(self, Self::SensorNoise | Self::SensorQuantisation | Self::InitialState)
    }

    /// Whether a model of the machine can predict it: it follows from the command alone, on the
    /// model's own clock.
    #[must_use]
    pub fn is_predictable(self) -> bool {
        !matches!(
            self,
            Self::ThermalDrift
                | Self::ClockOffset
                | Self::SensorNoise
                | Self::MainsHum
                | Self::PeriodicDisturbance
                | Self::InitialState
                | Self::Vibration
                | Self::Glitches
                | Self::HeldSamples
                | Self::Telegraph
                | Self::GainModulation
        )
    }

    /// Whether it stands apart from the signal path of one moment and so cannot be in a loop.
    #[must_use]
    pub fn is_open_loop_only(self) -> bool {
        self == Self::ClockOffset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_reaches_are_intervals() {
        for (i, effect) in Effect::ALL.iter().enumerate() {
            assert!(Effect::ALL[..i].iter().all(|other| other.name() != effect.name()));
            let (low, high) = effect.reach();
            assert!(0.0 < low && low < high, "{}", effect.name());
            assert_eq!(Effect::find(effect.name()), Some(*effect));
        }
    }

    #[test]
    fn groups_are_those_of_the_contract() {
        let of = |group| {
            let all = Effect::ALL.iter().filter(|e| e.group() == Some(group));
            all.map(|e| e.name()).collect::<Vec<_>>()
        };
        assert_eq!(of("lag"), ["amplifier_bandwidth", "delay", "sensor_bandwidth"]);
        assert_eq!(of("gain"), ["actuator_gain", "resonance_shift"]);
        assert_eq!(of("slow"), ["creep", "self_heating", "thermal_drift"]);
        assert_eq!(
            of("static_map"),
            ["polarisation_saturation", "amplifier_saturation", "sensor_nonlinearity"]
        );
    }
}
