//! What the ceramic adds behind its hysteresis.

use super::{Block, Tick};

/// Creep of Kelvin–Voigt elements: `y = x + Σ g_i z_i`, `τ_i z_i′ + z_i = x`; the part of an element
/// that is at once complete is none.
#[derive(Clone, Debug)]
pub(crate) struct Relaxations {
    /// Gain and step fraction of each element.
    elements: Vec<(f64, f64)>,
    state: Vec<f64>,
    start: f64,
}

impl Relaxations {
    /// Elements as gain and time constant in s.
    pub(crate) fn new(elements: &[(f64, f64)], period: f64) -> Self {
        let elements: Vec<_> =
            elements.iter().map(|(gain, tau)| (*gain, -(-period / tau).exp_m1())).collect();
        let state = vec![0.0; elements.len()];
        Self { elements, state, start: 0.0 }
    }
}

impl Block for Relaxations {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        // Creep is told from rest: at rest it is complete, and the static gain contains it.
        self.start = x;
        self.state.fill(x);
        x + self.elements.iter().map(|(g, _)| g * x).sum::<f64>()
    }

    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        let mut y = x;
        for ((gain, fraction), z) in self.elements.iter().zip(&mut self.state) {
            *z += fraction * (x - *z);
            y += gain * *z;
        }
        y
    }
}

/// Logarithmic creep `y = x + g·Σ Δx_k·lg(1 + (t − t_k)/t₀)`, as ten relaxations over five decades of
/// time whose sum follows the logarithm.
pub(crate) struct LogCreep(Relaxations);

impl LogCreep {
    /// Creep of the share `gain` per decade of time, from `first` in s on.
    pub(crate) fn new(gain: f64, first: f64, period: f64) -> Self {
        // ln(1 + s) = ∫ (1 − e^(−s x)) e^(−x)/x dx: two elements per decade of time constants.
        let elements: Vec<(f64, f64)> = (0..10)
            .map(|i| {
                let tau = first * 10.0_f64.powf(0.25 + 0.5 * f64::from(i));
                (gain * 0.5 * (-first / tau).exp(), tau)
            })
            .collect();
        Self(Relaxations::new(&elements, period))
    }
}

impl Block for LogCreep {
    fn rest(&mut self, x: f64, tick: &Tick) -> f64 {
        self.0.rest(x, tick)
    }
    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        self.0.step(x, tick)
    }
}

/// A static map of the path's signal.
pub(crate) struct StaticMap(Box<dyn Fn(f64) -> f64 + Send>);

impl StaticMap {
    pub(crate) fn new(map: impl Fn(f64) -> f64 + Send + 'static) -> Self {
        Self(Box::new(map))
    }
}

impl Block for StaticMap {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        (self.0)(x)
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        (self.0)(x)
    }
}

/// Warming by losses: each element is `τ θ′ + θ = |v v′|/reference`; the elongation grows by
/// `growth·Σ share·θ`, the gain by the factor `1 + softening·Σ share·θ`.
#[derive(Clone, Debug)]
pub(crate) struct SelfHeating {
    /// Growth in µm, and relative growth of the gain.
    growth: f64,
    softening: f64,
    /// Share and step fraction of each element.
    elements: Vec<(f64, f64)>,
    theta: Vec<f64>,
    last: f64,
    period: f64,
}

/// Power of losses |v v′| in V²/s at which an element warms to 1: 100 V, 5 Hz.
const REFERENCE_POWER: f64 = 5.0e4;

impl SelfHeating {
    /// Elements as share and time constant in s.
    pub(crate) fn new(growth: f64, softening: f64, elements: &[(f64, f64)], period: f64) -> Self {
        let elements: Vec<_> =
            elements.iter().map(|(share, tau)| (*share, -(-period / tau).exp_m1())).collect();
        let theta = vec![0.0; elements.len()];
        Self { growth, softening, elements, theta, last: 0.0, period }
    }
}

impl Block for SelfHeating {
    fn rest(&mut self, x: f64, tick: &Tick) -> f64 {
        self.theta.fill(0.0);
        self.last = tick.command;
        x
    }

    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        let rate = (tick.command - self.last) / self.period;
        let power = (tick.command * rate).abs() / REFERENCE_POWER;
        self.last = tick.command;
        let mut warm = 0.0;
        for ((share, fraction), theta) in self.elements.iter().zip(&mut self.theta) {
            *theta += fraction * (power - *theta);
            warm += share * *theta;
        }
        x * (1.0 + self.softening * warm) + self.growth * warm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithmic_creep_is_straight_over_the_logarithm_of_time() {
        let (h, gain) = (1e-3, 0.01);
        let mut creep = LogCreep::new(gain, 0.01, h);
        creep.rest(0.0, &Tick::default());
        let mut at = |t: f64, done: &mut usize| {
            let n = (t / h).round() as usize;
            let mut y = 0.0;
            while *done < n {
                y = creep.step(1.0, &Tick::default());
                *done += 1;
            }
            y
        };
        let mut done = 0;
        let values: Vec<f64> = [0.1, 1.0, 10.0].iter().map(|t| at(*t, &mut done)).collect();
        for pair in values.windows(2) {
            assert!(((pair[1] - pair[0]) / gain - 1.0).abs() < 0.05, "{values:?}");
        }
    }

    #[test]
    fn an_element_goes_its_way_with_its_time_constant() {
        let mut creep = Relaxations::new(&[(0.1, 0.5)], 1e-3);
        assert_eq!(creep.rest(2.0, &Tick::default()), 2.2);
        for k in 1..1000 {
            let exact = 3.0 + 0.1 * (3.0 - (-f64::from(k) * 1e-3 / 0.5_f64).exp());
            assert!((creep.step(3.0, &Tick::default()) - exact).abs() < 1e-12);
        }
    }

    #[test]
    fn warmth_follows_the_power_and_not_the_sign() {
        let mut hot = SelfHeating::new(1.0, 0.0, &[(1.0, 0.1)], 1e-3);
        hot.rest(0.0, &Tick { command: 100.0, ..Tick::default() });
        let mut y = 0.0;
        for k in 0..2000 {
            // 100 V with a slope of ±500 V/s: the reference power.
            let command = 100.0 + if k % 2 == 0 { 0.5 } else { 0.0 };
            y = hot.step(0.0, &Tick { command, ..Tick::default() });
        }
        assert!((y - 1.0).abs() < 0.02, "{y}");
    }
}
