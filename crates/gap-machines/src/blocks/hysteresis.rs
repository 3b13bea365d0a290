//! Hysteresis.

use super::linear::Lags;
use super::{Block, Tick};

/// How plays take their input.
#[derive(Clone, Debug)]
pub(crate) enum PlaysLaw {
    /// `P ← max(u − r, min(u + r, P))`.
    Plain,
    /// Envelopes that are bent apart, `u ± (r + bend·(u/span)²)`: loops open towards the top.
    Bent {
        /// Shift of each envelope at full span, in V.
        bend: f64,
        /// Full span in V.
        span: f64,
    },
    /// Thresholds that grow with the rate: `r + seconds·|u′|` for all plays with r > 0.
    Rate {
        /// Growth in V per V/s.
        seconds: f64,
        /// Period in s.
        period: f64,
    },
    /// All plays with r > 0 take their input through a lag.
    Lagged(Lags),
    /// Plays start apart from rest: moved by a share of the way to the other end of their range.
    Start {
        /// Between 0, at rest, and 1.
        share: f64,
    },
}

/// Prandtl–Ishlinskii: a weighted sum of plays.
#[derive(Clone, Debug)]
pub(crate) struct Plays {
    thresholds: Vec<f64>,
    weights: Vec<f64>,
    state: Vec<f64>,
    last: f64,
    law: PlaysLaw,
}

impl Plays {
    pub(crate) fn new(thresholds: &[f64], weights: &[f64], law: PlaysLaw) -> Self {
        let state = vec![0.0; thresholds.len()];
        Self { thresholds: thresholds.to_vec(), weights: weights.to_vec(), state, last: 0.0, law }
    }

    fn sum(&self) -> f64 {
        self.weights.iter().zip(&self.state).map(|(w, p)| w * p).sum()
    }

    fn advance(&mut self, u: f64) {
        let (mut grow, mut bend, mut inner) = (0.0, 0.0, u);
        match &mut self.law {
            PlaysLaw::Plain | PlaysLaw::Start { .. } => {}
            PlaysLaw::Bent { bend: b, span } => bend = *b * (u / *span) * (u / *span),
            PlaysLaw::Rate { seconds, period } => {
                grow = *seconds * ((u - self.last) / *period).abs();
            }
            PlaysLaw::Lagged(lags) => inner = lags.follow(u),
        }
        for (r, p) in self.thresholds.iter().zip(&mut self.state) {
            *p = if *r > 0.0 {
                (inner - r - grow - bend).max((inner + r + grow + bend).min(*p))
            } else {
                u
            };
        }
        self.last = u;
    }
}

impl Block for Plays {
    fn rest(&mut self, u: f64, _tick: &Tick) -> f64 {
        self.state.fill(0.0);
        self.last = u;
        if let PlaysLaw::Lagged(lags) = &mut self.law {
            lags.set(u);
        }
        self.advance(u);
        if let PlaysLaw::Start { share } = self.law {
            for (r, p) in self.thresholds.iter().zip(&mut self.state) {
                *p += share * (u + r - *p);
            }
        }
        self.sum()
    }

    fn step(&mut self, u: f64, _tick: &Tick) -> f64 {
        self.advance(u);
        self.sum()
    }
}

/// A generalised play more, less its slope: `y = x − weight·(u − P[u])`, P between the bent envelopes
/// `u ± (r + bend·(u/span)²)`.
#[derive(Clone, Debug)]
pub(crate) struct GeneralisedPlay {
    weight: f64,
    play: Plays,
}

impl GeneralisedPlay {
    /// The weight in µm/V; threshold, bend and span in V.
    pub(crate) fn new(weight: f64, threshold: f64, bend: f64, span: f64) -> Self {
        let law = PlaysLaw::Bent { bend, span };
        Self { weight, play: Plays::new(&[threshold], &[1.0], law) }
    }
}

impl Block for GeneralisedPlay {
    fn rest(&mut self, x: f64, tick: &Tick) -> f64 {
        x - self.weight * (tick.command - self.play.rest(tick.command, tick))
    }
    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        x - self.weight * (tick.command - self.play.step(tick.command, tick))
    }
}

/// An additional Bouc–Wen loop: `y = x − gain·h`, `h′ = v′ − β|v′|h|h| − γ v′ h²` with v the command
/// over its width.
#[derive(Clone, Debug)]
pub(crate) struct BoucWen {
    gain: f64,
    width: f64,
    last: f64,
    h: f64,
}

impl BoucWen {
    /// A loop of `gain` µm with the memory length `width` in V.
    pub(crate) fn new(gain: f64, width: f64) -> Self {
        Self { gain, width, last: 0.0, h: 0.0 }
    }
}

impl Block for BoucWen {
    fn rest(&mut self, x: f64, tick: &Tick) -> f64 {
        (self.last, self.h) = (tick.command, 0.0);
        x
    }

    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        // Small steps keep the integration true where the command jumps.
        let total = (tick.command - self.last) / self.width;
        let parts = (total.abs() * 20.0).ceil().max(1.0);
        let dv = total / parts;
        for _ in 0..parts as usize {
            let h = self.h;
            self.h += dv - 0.6 * dv.abs() * h * h.abs() - 0.4 * dv * h * h;
        }
        self.last = tick.command;
        x - self.gain * self.h
    }
}

/// A map of the command that depends on the branch: `y = x + gain·b·(2u/span − 1)`, where b in
/// [−1, 1] says how far a play of half the width `r` has turned over since the last reversal. The
/// loop opens at one end of the range and closes at the other.
#[derive(Clone, Debug)]
pub(crate) struct Branch {
    gain: f64,
    span: f64,
    r: f64,
    play: f64,
}

impl Branch {
    pub(crate) fn new(gain: f64, span: f64, r: f64) -> Self {
        Self { gain, span, r, play: 0.0 }
    }

    fn output(&self, x: f64, u: f64) -> f64 {
        let branch = (u - self.play) / self.r;
        x + self.gain * branch * (2.0 * u / self.span - 1.0)
    }
}

impl Block for Branch {
    fn rest(&mut self, x: f64, tick: &Tick) -> f64 {
        self.play = tick.command;
        self.output(x, tick.command)
    }

    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        let u = tick.command;
        self.play = (u - self.r).max((u + self.r).min(self.play));
        self.output(x, u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area of the last of three loops between ±a.
    fn area(block: &mut dyn Block, a: f64, steps: usize) -> f64 {
        let n = 2 * steps;
        let u = |k: usize| {
            let phase = (k % n) as f64 / steps as f64;
            a * if phase < 1.0 { 2.0 * phase - 1.0 } else { 3.0 - 2.0 * phase }
        };
        let mut y = block.rest(u(0), &Tick { command: u(0), ..Tick::default() });
        let mut area = 0.0;
        for k in 1..=3 * n {
            let next = block.step(u(k), &Tick { command: u(k), ..Tick::default() });
            if k > 2 * n {
                area += 0.5 * (next + y) * (u(k) - u(k - 1));
            }
            y = next;
        }
        -area
    }

    #[test]
    fn loop_area_of_plays_is_known() {
        let mut plays = Plays::new(&[0.0, 5.0, 20.0], &[0.3, 0.02, 0.01], PlaysLaw::Plain);
        let exact = 4.0 * 0.02 * 5.0 * 45.0 + 4.0 * 0.01 * 20.0 * 30.0;
        assert!((area(&mut plays, 50.0, 1000) - exact).abs() < 1e-9);
    }

    #[test]
    fn each_law_is_plain_where_its_size_is_zero() {
        for law in [
            PlaysLaw::Bent { bend: 0.0, span: 100.0 },
            PlaysLaw::Rate { seconds: 0.0, period: 1e-3 },
            PlaysLaw::Lagged(Lags::new(0.0, 1, 1e-3)),
        ] {
            let mut plain = Plays::new(&[0.0, 7.0], &[0.1, 0.05], PlaysLaw::Plain);
            let mut other = Plays::new(&[0.0, 7.0], &[0.1, 0.05], law);
            let tick = Tick::default();
            assert_eq!(plain.rest(30.0, &tick), other.rest(30.0, &tick));
            for k in 0..500 {
                let u = 50.0 + 40.0 * (f64::from(k) * 0.1).sin();
                assert_eq!(plain.step(u, &tick), other.step(u, &tick));
            }
        }
    }

    #[test]
    fn a_bent_loop_is_wider_at_the_top_than_at_the_bottom() {
        let mut bent = GeneralisedPlay::new(1.0, 2.0, 20.0, 100.0);
        let at = |bent: &mut GeneralisedPlay, u: f64| {
            bent.step(0.0, &Tick { command: u, ..Tick::default() })
        };
        bent.rest(0.0, &Tick::default());
        // Far up and far down again: each envelope is reached.
        let up: Vec<f64> = (0..=100).map(|u| at(&mut bent, f64::from(u))).collect();
        let down: Vec<f64> = (-60..100).rev().map(|u| at(&mut bent, f64::from(u))).collect();
        assert!((up[90] + 2.0 + 20.0 * 0.81).abs() < 1e-12, "{}", up[90]);
        // At −10 V on the way down.
        assert!((down[109] - (2.0 + 20.0 * 0.01)).abs() < 1e-12, "{}", down[109]);
    }

    #[test]
    fn a_wider_play_at_a_higher_rate() {
        let law = |seconds| PlaysLaw::Rate { seconds, period: 1e-3 };
        let slow = area(&mut Plays::new(&[0.0, 5.0], &[1.0, 1.0], law(0.0)), 50.0, 100);
        let fast = area(&mut Plays::new(&[0.0, 5.0], &[1.0, 1.0], law(2e-3)), 50.0, 100);
        // 100 steps per branch: 1 V per ms, so every threshold grows by 2 V.
        assert!((slow - 4.0 * 5.0 * 45.0).abs() < 1e-9, "{slow}");
        assert!((fast - 4.0 * 7.0 * 43.0).abs() < 20.0, "{fast}");
    }

    #[test]
    fn bouc_wen_and_branch_loops_have_the_sign_of_hysteresis_and_scale() {
        let one = area(&mut BoucWen::new(0.1, 10.0), 50.0, 1000);
        let two = area(&mut BoucWen::new(0.2, 10.0), 50.0, 1000);
        assert!(one > 0.0 && (two / one - 2.0).abs() < 1e-9, "{one} {two}");
        // Rate plays no part.
        let coarse = area(&mut BoucWen::new(0.1, 10.0), 50.0, 200);
        assert!((coarse / one - 1.0).abs() < 0.02, "{coarse} {one}");
        let mut branch = Branch::new(0.1, 100.0, 10.0);
        assert_eq!(branch.rest(1.0, &Tick { command: 80.0, ..Tick::default() }), 1.0);
        let up = branch.step(1.0, &Tick { command: 95.0, ..Tick::default() });
        assert!((up - (1.0 + 0.1 * 0.9)).abs() < 1e-12);
    }
}
