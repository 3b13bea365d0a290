//! What happens on the signal path, in words: the rows of the catalogue in `docs/effects.md`. Each
//! component declares for which of them it stands.

use model::Phenomenon;

macro_rules! phenomena {
    ($($name:ident: $text:literal $(, $remark:literal)?;)*) => {
        $(
            #[doc = $text]
            pub static $name: Phenomenon =
                Phenomenon { name: $text, remark: concat!($($remark)?) };
        )*

        /// All phenomena, in the order of the signal path.
        pub static PHENOMENA: &[&Phenomenon] = &[$(&$name),*];
    };
}

phenomena! {
    TRANSPORT_DELAY: "transport delay: computing, hold, bus";
    CLOCK_OFFSET: "sample-clock offset and jitter";
    COMMAND_QUANTISATION: "quantisation of the command";
    AMPLIFIER_LAG: "amplifier lag of first order, R_out C", "`amplifier-rc` from resistance and capacitance, with the motional current";
    AMPLIFIER_SECOND_ORDER: "amplifier of second order, LC";
    CURRENT_LIMIT: "current limit, slew rate";
    FOLDBACK: "average current limit, foldback";
    VOLTAGE_LIMITS: "voltage limits", "hard or soft";
    CONVERTER_NONLINEARITY: "integral nonlinearity and offset of converter and amplifier";
    CHARGE: "voltage, charge and current of the actuator", "outputs; changes nothing";
    TIP_MOTION: "position and velocity of the tip", "outputs; changes nothing";
    THERMAL_NETWORK: "temperature from a thermal network, heat into it", "input `actuator_temperature[i]`, output `heat[i]`";
    HYSTERESIS: "hysteresis";
    ASYMMETRIC_HYSTERESIS: "asymmetric hysteresis", "`bouc-wen` by its `delta`";
    RATE_DEPENDENT_HYSTERESIS: "rate-dependent hysteresis";
    REMANENCE: "unknown past, remanence";
    CREEP: "creep";
    POLARISATION_SATURATION: "saturation of the polarisation";
    ACTUATOR_GAIN: "gain of the actuator, d33";
    GAIN_OVER_TEMPERATURE: "gain over temperature";
    AGEING: "ageing, depolarisation";
    SELF_HEATING: "self-heating";
    LOAD_FORCE: "load force, blocking force", "input `force[i]`";
    PAYLOAD: "external stiffness, payload mass", "gain and resonance move together";
    POSITION_STIFFNESS: "stiffness over the position";
    MODE: "mode, damping";
    SECOND_MODE: "second mode, non-collocated pair";
    AMPLITUDE_STIFFNESS: "stiffness over the amplitude";
    BACKLASH: "backlash, loose preload";
    FRICTION: "friction, stick-slip";
    CUTTING_FORCE: "cutting force", "as a force from outside, or in position once per ellipse";
    VIBRATION: "vibration at fixed frequencies";
    ELLIPSE_ERROR: "phase and amplitude error of an ellipse", "one on each axis, with its own values";
    STATIC_COUPLING: "static cross-coupling";
    DYNAMIC_COUPLING: "dynamic cross-coupling, shared mode", "the last one with frequencies and damping that follow the amplitude";
    OPTICS: "optics: coordinates from several axes";
    ABBE_ERROR: "Abbe, rotation and cosine error", "the rotation's share of the neighbour; the cosine as the quadratic term";
    THERMAL_GROWTH: "thermal growth", "the second from an input `temperature`";
    DISTURBANCE: "disturbance from a log", "input `disturbance[i]`";
    FLOOR_VIBRATION: "floor vibration, beam turbulence, mirror wobble", "noise through a mode";
    SENSOR_BANDWIDTH: "sensor bandwidth, anti-alias filter";
    SENSOR_SCALE: "sensor gain and offset, background light", "background b of the sum: gain 1/(1 + b)";
    SENSOR_NONLINEARITY: "sensor nonlinearity";
    PINCUSHION: "pincushion of a position-sensitive detector";
    QUAD_CELL_SATURATION: "quad-cell saturation";
    SENSOR_NOISE: "sensor noise, white and 1/f";
    SENSOR_DRIFT: "sensor drift";
    MAINS_HUM: "mains hum";
    CROSSTALK: "ground loop, amplifier-sensor crosstalk";
    READING_QUANTISATION: "quantisation of the reading";
    CONTROLLER_DIFFERENCE: "differences of controller or firmware", "no effect of the plant: feed the controller with the measured position and compare its command first";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phenomenon_has_a_component_and_every_component_of_a_machine_a_phenomenon() {
        let all = || crate::COMPONENTS.iter().map(|component| component.declaration());
        for phenomenon in PHENOMENA {
            let stood_for = all().any(|d| d.phenomena.iter().any(|p| p.name == phenomenon.name));
            assert!(stood_for, "{} has no component", phenomenon.name);
        }
        for d in all().filter(|d| d.stage != model::Stage::Control) {
            assert!(!d.phenomena.is_empty(), "{} stands for nothing", d.kind);
        }
    }
}
