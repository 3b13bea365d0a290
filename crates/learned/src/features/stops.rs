//! Stop operators, the command and its rate: the memory of hysteresis without a feedback of outputs.
//!
//! ```text
//! z_i(t) = E_{r_i}[u(t) − u(t−1) + z_i(t−1)],  E_r[x] = min(max(x, −r), r),  r_i = i·u_max/(n + 1)
//! inputs: [z_1 … z_n, u + Σ p_i z_i, u̇],  u̇ = (u(t) − u(t−1))/T
//! ```
//!
//! Without a projection p the command stands for itself, as in the paper. With it a curve behind a loop, as Kuhnen's
//! dead zones behind his operators are, is a function of one input.
//!
//! The paper prints r_i = i/((n + 1)|u|max), whose unit is not that of a command. At the start
//! z_i = E_r[u], as for a command that rose from 0.
//!
//! Each input is divided by a fixed width, so that all are of order one: stops and command by u_max,
//! the rate by `rate_scale`.
//!
//! Source: LS-SVM with stop operators tuned by particle swarm, eqs. (17)-(19).

/// Number and range.
#[derive(Clone, Debug, PartialEq)]
pub struct StopOperators {
    /// Number of stop operators n.
    pub count: usize,
    /// Greatest command u_max.
    pub range: f64,
    /// Sample time T in s.
    pub period: f64,
    /// What the rate is divided by, in commands per s.
    pub rate_scale: f64,
    /// Weights p of the stops that are added to the command; none: it stands for itself.
    pub projection: Vec<f64>,
}

/// What the rate is divided by where it is no input: it is then nothing beside the others.
const NO_RATE: f64 = 1e12;

impl StopOperators {
    /// So many stops up to the greatest command, a sample every `period` s; without a projection, and the rate
    /// as good as none.
    #[must_use]
    pub fn new(count: usize, range: f64, period: f64) -> Self {
        Self { count, range, period, rate_scale: NO_RATE, projection: Vec::new() }
    }

    /// These stops with the rate as an input, divided by `scale`.
    #[must_use]
    pub fn rated(self, scale: f64) -> Self {
        Self { rate_scale: scale, ..self }
    }

    /// These stops without the projection.
    #[must_use]
    pub fn bare(&self) -> Self {
        Self { projection: Vec::new(), ..self.clone() }
    }

    /// Whether stops are added to the command.
    #[must_use]
    pub fn is_projected(&self) -> bool {
        !self.projection.is_empty()
    }

    pub(super) fn dimension(&self) -> usize {
        self.count + 2
    }

    pub(super) fn memory(&self) -> usize {
        self.count + 1
    }

    fn threshold(&self, index: usize) -> f64 {
        (index + 1) as f64 * self.range / (self.count + 1) as f64
    }

    pub(super) fn rest(&self, u: f64, memory: &mut [f64]) {
        let Some((last, stops)) = memory.split_last_mut() else { return };
        *last = u;
        for (i, z) in stops.iter_mut().enumerate() {
            let r = self.threshold(i);
            *z = u.clamp(-r, r);
        }
    }

    pub(super) fn step(&self, u: f64, memory: &mut [f64], z: &mut [f64]) {
        let Some((last, stops)) = memory.split_last_mut() else { return };
        let Some((stops_out, [u_out, rate_out])) = z.split_last_chunk_mut::<2>() else { return };
        let change = u - *last;
        *last = u;
        for (i, (stop, out)) in stops.iter_mut().zip(stops_out.iter_mut()).enumerate() {
            let r = self.threshold(i);
            *stop = (*stop + change).max(-r).min(r);
            *out = *stop / self.range;
        }
        let added: f64 = self.projection.iter().zip(stops_out).map(|(p, z)| p * *z).sum();
        *u_out = u / self.range + added;
        *rate_out = change / self.period / self.rate_scale;
    }
}

#[cfg(test)]
mod tests {
    use components::hysteresis::play::{Drive, Threshold, play};

    use super::super::Features;
    use super::*;

    #[test]
    fn a_stop_is_the_command_less_its_play() {
        let mut stops = StopOperators::new(3, 4.0, 0.5).rated(2.0);
        let u: Vec<f64> = (0..60).map(|k| 2.0 + 2.0 * libm::sin(0.4 * f64::from(k))).collect();
        let all = Features::StopOperators(stops.clone()).of_record(&u, &u);
        for (i, r) in [1.0, 2.0, 3.0].into_iter().enumerate() {
            let mut p = u[0] - u[0].clamp(-r, r);
            for (k, u) in u.iter().enumerate() {
                p = play(Drive(*u), Threshold(r), p);
                assert!((all[5 * k + i] - (u - p) / 4.0).abs() < 1e-12);
            }
        }
        for k in 1..u.len() {
            assert_eq!(all[5 * k + 3], u[k] / 4.0);
            assert!((all[5 * k + 4] - (u[k] - u[k - 1])).abs() < 1e-12);
        }
        stops.projection = vec![0.5, 0.0, -2.0];
        let projected = Features::StopOperators(stops).of_record(&u, &u);
        for (with, z) in projected.chunks(5).zip(all.chunks(5)) {
            assert!((with[3] - (z[3] + 0.5 * z[0] - 2.0 * z[2])).abs() < 1e-12);
            assert_eq!((&with[..3], with[4]), (&z[..3], z[4]));
        }
    }
}
