//! What an amplifier does to a voltage.

use super::{Block, Tick};

/// A limit of the slope, hard or with a smooth approach and different rates up and down.
#[derive(Clone, Debug)]
pub(crate) struct SlewLimit {
    /// Largest change per period, up and down, in V.
    up: f64,
    down: f64,
    is_soft: bool,
    last: f64,
}

impl SlewLimit {
    /// One limit in V/s both ways; reached at once.
    pub(crate) fn hard(slope: f64, period: f64) -> Self {
        Self { up: slope * period, down: slope * period, is_soft: false, last: 0.0 }
    }

    /// A sink that is a third weaker than the source, and a limit that is approached smoothly.
    pub(crate) fn soft(slope: f64, period: f64) -> Self {
        Self { up: slope * period, down: slope * period / 1.5, is_soft: true, last: 0.0 }
    }
}

impl Block for SlewLimit {
    fn rest(&mut self, v: f64, _tick: &Tick) -> f64 {
        self.last = v;
        v
    }

    fn step(&mut self, v: f64, _tick: &Tick) -> f64 {
        let wanted = v - self.last;
        let limit = if wanted > 0.0 { self.up } else { self.down };
        let ratio = (wanted / limit).abs();
        self.last += if !self.is_soft {
            wanted.clamp(-limit, limit)
        } else {
            // x/(1+x⁸)^(1/8): within 0.1 % of the wanted slope up to four tenths of the limit.
            wanted / (1.0 + ratio.powi(8)).powf(0.125)
        };
        self.last
    }
}

/// A rail, hard or with a soft knee: `v − width·ln(1 + exp((v − limit)/width))`.
#[derive(Clone, Debug)]
pub(crate) struct Clamp {
    limit: f64,
    /// Width of the knee in V; 0 for a hard one.
    width: f64,
}

impl Clamp {
    pub(crate) fn hard(limit: f64) -> Self {
        Self { limit, width: 0.0 }
    }
    pub(crate) fn soft(limit: f64, width: f64) -> Self {
        Self { limit, width }
    }

    fn output(&self, v: f64) -> f64 {
        if self.width <= 0.0 {
            return v.min(self.limit);
        }
        let x = (v - self.limit) / self.width;
        // ln(1 + eˣ) without overflow.
        v - self.width * (x.max(0.0) + (-x.abs()).exp().ln_1p())
    }
}

impl Block for Clamp {
    fn rest(&mut self, v: f64, _tick: &Tick) -> f64 {
        self.output(v)
    }
    fn step(&mut self, v: f64, _tick: &Tick) -> f64 {
        self.output(v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_stay_below_the_limit() {
        for mut block in [SlewLimit::hard(1e3, 1e-3), SlewLimit::soft(1e3, 1e-3)] {
            let tick = Tick::default();
            block.rest(0.0, &tick);
            assert!((block.step(0.2, &tick) - 0.2).abs() < 1e-5);
            let before = block.last;
            let after = block.step(50.0, &tick);
            assert!((after - before - 1.0).abs() < 1e-9, "{before} {after}");
            assert!(block.step(-50.0, &tick) < after);
        }
    }

    #[test]
    fn a_soft_rail_is_the_hard_one_away_from_the_knee() {
        let (hard, soft) = (Clamp::hard(90.0), Clamp::soft(90.0, 1.0));
        for v in [0.0, 60.0, 120.0, 1e4] {
            assert!((hard.output(v) - soft.output(v)).abs() < 1e-9, "{v}");
        }
        assert!((soft.output(90.0) - (90.0 - 2.0_f64.ln())).abs() < 1e-12);
    }
}
