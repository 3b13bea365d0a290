//! The effects of the machine. Strength 1 is a strong one; formulas differ from the library's.

use std::f64::consts::TAU;

use super::machine::{Machine, Normal, RATE};

/// What may be wrong with the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    Delay,
    AmplifierBandwidth,
    AmplifierSlew,
    AmplifierSaturation,
    DacQuantisation,
    Creep,
    Hysteresis,
    Asymmetry,
    RateDependence,
    PolarisationSaturation,
    ActuatorGain,
    InitialState,
    SelfHeating,
    ResonanceShift,
    Damping,
    ExtraMode,
    Duffing,
    Backlash,
    Friction,
    PeriodicDisturbance,
    CrossCoupling,
    ThermalDrift,
    SensorBandwidth,
    SensorNonlinearity,
    MainsHum,
    Crosstalk,
    ClockOffset,
    /// In nobody's library: the gain wanders at 7 Hz.
    GainModulation,
    /// In nobody's library: glitches at random times.
    Glitches,
    /// In nobody's library: band-limited vibration.
    Vibration,
    /// In nobody's library: an AC-coupled sensor.
    AcCoupling,
    /// A converter of which every fifth code is missing.
    MissingCodes,
    /// A delay that a bus lets swing by two fifths, in a triangle.
    SwingingDelay,
}

impl Effect {
    /// All that have a name in the library.
    pub const NAMED: [(Self, &'static str); 27] = [
        (Self::Delay, "delay"),
        (Self::AmplifierBandwidth, "amplifier_bandwidth"),
        (Self::AmplifierSlew, "amplifier_slew"),
        (Self::AmplifierSaturation, "amplifier_saturation"),
        (Self::DacQuantisation, "dac_quantisation"),
        (Self::Creep, "creep"),
        (Self::Hysteresis, "hysteresis"),
        (Self::Asymmetry, "asymmetry"),
        (Self::RateDependence, "rate_dependence"),
        (Self::PolarisationSaturation, "polarisation_saturation"),
        (Self::ActuatorGain, "actuator_gain"),
        (Self::InitialState, "initial_state"),
        (Self::SelfHeating, "self_heating"),
        (Self::ResonanceShift, "resonance_shift"),
        (Self::Damping, "damping"),
        (Self::ExtraMode, "extra_mode"),
        (Self::Duffing, "duffing"),
        (Self::Backlash, "backlash"),
        (Self::Friction, "friction"),
        (Self::PeriodicDisturbance, "periodic_disturbance"),
        (Self::CrossCoupling, "cross_coupling"),
        (Self::ThermalDrift, "thermal_drift"),
        (Self::SensorBandwidth, "sensor_bandwidth"),
        (Self::SensorNonlinearity, "sensor_nonlinearity"),
        (Self::MainsHum, "mains_hum"),
        (Self::Crosstalk, "crosstalk"),
        (Self::ClockOffset, "clock_offset"),
    ];
    /// Those that have none.
    pub const UNKNOWN: [Self; 4] =
        [Self::GainModulation, Self::Glitches, Self::Vibration, Self::AcCoupling];
}

fn lag(x: &mut [f64], frequency: f64) {
    let a = 1.0 - (-TAU * frequency / RATE).exp();
    let mut z = x[0];
    for v in x {
        z += a * (*v - z);
        *v = z;
    }
}

pub fn input_side(m: &Machine, u: &[f64]) -> Vec<f64> {
    let mut v = u.to_vec();
    for (effect, s) in &m.effects {
        match effect {
            Effect::Delay | Effect::SwingingDelay => {
                let old = v.clone();
                for (k, v) in v.iter_mut().enumerate() {
                    let turn = (3.3 * k as f64 / RATE).fract();
                    let swing = if *effect == Effect::Delay { 0.0 } else { 0.4 };
                    let shift = 20.0 * s * (1.0 + swing * (4.0 * (turn - 0.5).abs() - 1.0));
                    let at = (k as f64 - shift).max(0.0);
                    let (a, f) = (at.floor() as usize, at.fract());
                    *v = old[a] * (1.0 - f) + old[(a + 1).min(old.len() - 1)] * f;
                }
            }
            // Three unequal poles.
            Effect::AmplifierBandwidth => {
                for k in [1.0, 3.0, 8.0] {
                    lag(&mut v, k * 40.0 / s);
                }
            }
            // Different up and down.
            Effect::AmplifierSlew => {
                let (up, down) = (12.0 / s / RATE * 100.0, 14.0 / s / RATE * 100.0);
                let mut z = v[0];
                for v in &mut v {
                    z += (*v - z).clamp(-down, up);
                    *v = z;
                }
            }
            // A smooth knee.
            Effect::AmplifierSaturation => {
                let limit = 115.0 - 60.0 * s.min(1.5);
                for v in &mut v {
                    if *v > limit {
                        *v = limit + 3.0 * ((*v - limit) / 3.0).tanh() * 0.3;
                    }
                }
            }
            Effect::DacQuantisation => {
                let q = 20.0 * s;
                v.iter_mut().for_each(|v| *v = q * (*v / q).floor());
            }
            Effect::MissingCodes => {
                let q = 20.0 * s;
                for v in &mut v {
                    let code = (*v / q + 0.3).floor();
                    let code = if code.rem_euclid(5.0) == 2.0 { code - 1.0 } else { code };
                    *v = q * (code + 0.2);
                }
            }
            _ => {}
        }
    }
    v
}

pub fn actuator(m: &Machine, v: &[f64], neighbour: impl Fn() -> Vec<f64>, x: &mut Vec<f64>) {
    for (effect, s) in &m.effects {
        match effect {
            // Ten relaxations whose shares fall.
            Effect::Creep => {
                let old = x.clone();
                for k in 0..10 {
                    let tau = 0.005 * 2f64.powi(k);
                    let a = 1.0 - (-1.0 / (tau * RATE)).exp();
                    let mut z = old[0];
                    for (x, o) in x.iter_mut().zip(&old) {
                        z += a * (o - z);
                        *x += 0.03 * s * (1.0 + 0.02 * f64::from(k)) * z;
                    }
                }
            }
            // More loop: thresholds that are not the model's.
            Effect::Hysteresis => {
                for r in [7.0, 21.0, 37.0] {
                    let mut p = 0.0_f64;
                    for k in 0..v.len() {
                        let u = v[k.saturating_sub(1)];
                        p = (u - r).max((u + r).min(p));
                        x[k] += 0.02 * s * (p - u);
                    }
                }
            }
            // The loop opens towards the top.
            Effect::Asymmetry => {
                for r in [10.0, 30.0] {
                    let mut p = 0.0_f64;
                    for k in 0..v.len() {
                        let u = v[k.saturating_sub(1)];
                        p = (u - r).max((u + r).min(p));
                        x[k] += 0.03
                            * s
                            * (p - u)
                            * ((u - 60.0) / 60.0 + 0.3 * ((u - 60.0) / 60.0).powi(3));
                    }
                }
            }
            Effect::PolarisationSaturation => {
                for x in x.iter_mut() {
                    let e = (*x - 5.0) / 6.0;
                    *x -= s * (e - (2.0 * e).atan() * 0.5);
                }
            }
            Effect::ActuatorGain => x.iter_mut().for_each(|x| *x *= 1.0 + 0.3 * s),
            Effect::InitialState => {
                // The plays start at the other side.
                for r in [5.0, 10.0, 16.0, 24.0, 34.0, 46.0, 60.0] {
                    let (mut a, mut b) =
                        ((v[0] - r).max((v[0] + r).min(0.0)), v[0] + r * s.min(1.0));
                    for k in 0..v.len() {
                        let u = v[k.saturating_sub(1)];
                        a = (u - r).max((u + r).min(a));
                        b = (u - r).max((u + r).min(b));
                        x[k] += 0.007 * (b - a);
                    }
                }
            }
            Effect::CrossCoupling => {
                let mut n: Vec<f64> = neighbour().iter().map(|n| n - 60.0).collect();
                lag(&mut n, 120.0);
                x.iter_mut().zip(&n).for_each(|(x, n)| *x += 0.05 * s * n);
            }
            Effect::GainModulation => {
                let mut random = Normal::new(m.seed ^ 0x99);
                let (p, q) = (random.uniform() * TAU, random.uniform() * TAU);
                for (k, x) in x.iter_mut().enumerate() {
                    let t = k as f64 / RATE;
                    *x *= 1.0 + s * ((TAU * 7.3 * t + p).sin() + (TAU * 10.7 * t + q).sin());
                }
            }
            _ => {}
        }
    }
    // A clearance comes last.
    if let Some((_, s)) = m.effects.iter().find(|(e, _)| *e == Effect::Backlash) {
        // The clearance is not the same everywhere.
        let mut p = x[0];
        for x in x.iter_mut() {
            let half = s * (1.0 + 0.3 * (*x * 1.7).sin());
            p = (*x - half).max((*x + half).min(p));
            *x = p;
        }
    }
}

pub fn output_side(m: &Machine, record: usize, u: &[f64], mut y: Vec<f64>, h: f64) -> Vec<f64> {
    let mut random = Normal::new(m.seed ^ (0x1000 + record as u64));
    for (effect, s) in &m.effects {
        match effect {
            // A pair of pole and zero in series, by a state-space form with fine steps.
            Effect::ExtraMode => {
                let transition = components::linear::Transition::new(620.0, 0.015, h);
                let (mut x, mut rate) = (y[0], 0.0);
                let old = y.clone();
                for k in 1..y.len() {
                    let (e, r) = transition.apply(x - old[k], rate);
                    (x, rate) = (old[k] + e, r);
                    y[k] = old[k] + s * (x - old[k]) + 0.2 * s * rate;
                }
            }
            Effect::SelfHeating => {
                let mut warm = 0.0;
                for k in 1..y.len() {
                    // Losses of loops, a little steeper than the first power of the way.
                    let p = ((u[k] - u[k - 1]).abs() * (u[k] - 55.0).abs() / 50.0).powf(1.1);
                    warm += 0.0015 * (p - warm);
                    y[k] += 2.0 * s * warm;
                }
            }
            Effect::PeriodicDisturbance => {
                let (p, q) = (random.uniform() * TAU, random.uniform() * TAU);
                for (k, y) in y.iter_mut().enumerate() {
                    let t = k as f64 * h;
                    *y += s * ((TAU * 23.7 * t + p).sin() + 0.4 * (TAU * 47.4 * t + q).sin());
                }
            }
            Effect::ThermalDrift => {
                let mut walk = 0.0;
                let slope = random.draw() + 1.0;
                for (k, y) in y.iter_mut().enumerate() {
                    walk += 0.002 * random.draw();
                    *y += s * (slope * k as f64 / 6000.0 + walk);
                }
            }
            Effect::SensorBandwidth => {
                for k in [1.0, 2.0, 5.0] {
                    lag(&mut y, k * 60.0 / s);
                }
            }
            Effect::SensorNonlinearity => {
                y.iter_mut().for_each(|y| {
                    let e = (*y - 4.0) / 5.0;
                    *y += s * (0.5 * (e.exp() - e) + 0.3 * (2.0 * e).sin());
                });
            }
            Effect::MainsHum => {
                let (p, q) = (random.uniform() * TAU, random.uniform() * TAU);
                for (k, y) in y.iter_mut().enumerate() {
                    let t = k as f64 * h;
                    *y += s * ((TAU * 50.03 * t + p).sin() + 0.5 * (TAU * 150.09 * t + q).sin());
                }
            }
            Effect::Crosstalk => {
                let mut z = u[0];
                for k in 1..y.len() {
                    z += 0.7 * (u[k - 1] - z);
                    y[k] += 0.05 * s * (u[k - 1] - 60.0) + 0.1 * s * (u[k - 1] - z);
                }
            }
            Effect::ClockOffset => {
                let old = y.clone();
                for (k, y) in y.iter_mut().enumerate() {
                    let at = k as f64 * (1.0 - 1e-3 * s);
                    let (a, f) = (at.floor() as usize, at.fract());
                    *y = old[a] * (1.0 - f) + old[(a + 1).min(old.len() - 1)] * f;
                }
            }
            Effect::Glitches => {
                for y in &mut y {
                    if random.uniform() < 0.01 {
                        *y += s * random.draw() * 5.0;
                    }
                }
            }
            Effect::Vibration => {
                let mut z = (0.0, 0.0);
                let t = components::linear::Transition::new(30.0, 0.1, h);
                for y in &mut y {
                    z = t.apply(z.0 - random.draw(), z.1);
                    z.0 += 0.0;
                    *y += s * z.0;
                }
            }
            Effect::AcCoupling => {
                let a = 1.0 - (-TAU * 0.3 * s / RATE).exp();
                let mut z = y[0];
                for y in &mut y {
                    z += a * (*y - z);
                    *y -= z;
                }
            }
            _ => {}
        }
    }
    y
}
