//! The play operator and weighted sums of plays, as pure functions over slices.
//!
//! A play of threshold r follows its input like a piston in a cylinder of width 2r:
//! `P ← max(u − r, min(u + r, P))`. Its companion is the stop, `E = u − P`.
//!
//! Source: A. Visintin, Differential Models of Hysteresis, Springer 1994, ch. III; K. Kuhnen,
//! Modeling, identification and compensation of complex hysteretic nonlinearities, European Journal
//! of Control 9 (2003) 407–418.

/// What a play follows.
#[derive(Clone, Copy, Debug)]
pub struct Drive(pub f64);

/// By how much the input of a stop changes.
#[derive(Clone, Copy, Debug)]
pub struct Change(pub f64);

/// Half the width of a play, r ≥ 0.
#[derive(Clone, Copy, Debug)]
pub struct Threshold(pub f64);

/// A play, from its previous value, after its input went monotonically to another.
#[inline]
#[must_use]
pub fn play(Drive(u): Drive, Threshold(r): Threshold, previous: f64) -> f64 {
    between(u - r, u + r, previous)
}

/// A stop, from its previous value, after its input went monotonically by a change.
#[inline]
#[must_use]
pub fn stop(Change(change): Change, Threshold(r): Threshold, previous: f64) -> f64 {
    between(-r, r, previous + change)
}

/// `max(low, min(high, x))` in the form that compiles to one minimum and one maximum instruction.
#[inline]
#[must_use]
pub fn between(low: f64, high: f64, x: f64) -> f64 {
    let x = if x < high { x } else { high };
    if x > low { x } else { low }
}

/// A weighted sum of plays, `H[u] = Σ w_i P_{r_i}[u]`. Its state is one number per play.
#[derive(Clone, Copy, Debug)]
pub struct Plays<'a> {
    /// Thresholds.
    pub r: &'a [f64],
    /// Weights, as many.
    pub w: &'a [f64],
}

impl Plays<'_> {
    /// Sets the state that the virgin operator (all plays 0) has after its input went monotonically
    /// to `u`, and returns the sum.
    pub fn rest(&self, u: f64, state: &mut [f64]) -> f64 {
        state.fill(0.0);
        self.step(u, state)
    }

    /// Calls `each` with threshold and weight, over the command, of plays that follow a characteristic
    /// of this slope: `w·P_r[m·u] = m·w·P_{r/m}[u]`. None where it is flat.
    pub fn behind(&self, slope: f64, each: &mut dyn FnMut(f64, f64)) {
        if slope > 0.0 {
            self.r.iter().zip(self.w).for_each(|(r, w)| each(r / slope, slope * w));
        }
    }

    /// Moves the input monotonically to `u` and returns the sum, added up from the first play on.
    #[inline]
    pub fn step(&self, u: f64, state: &mut [f64]) -> f64 {
        let count = state.len().min(self.r.len()).min(self.w.len());
        // Two plays move at once, in one register.
        let (p, last_p) = state[..count].as_chunks_mut::<2>();
        let (r, last_r) = self.r[..count].as_chunks::<2>();
        let (w, last_w) = self.w[..count].as_chunks::<2>();
        let mut sum = 0.0;
        for ((p, r), w) in p.iter_mut().zip(r).zip(w) {
            *p = [play(Drive(u), Threshold(r[0]), p[0]), play(Drive(u), Threshold(r[1]), p[1])];
            sum += w[0] * p[0];
            sum += w[1] * p[1];
        }
        if let ([p], [r], [w]) = (last_p, last_r, last_w) {
            *p = play(Drive(u), Threshold(*r), *p);
            sum += w * *p;
        }
        sum
    }
}

/// The inverse of a sum of plays is a sum of plays, in closed form:
///
/// ```text
/// w'_1 = 1/w_1
/// w'_i = −w_i / (Σ_{j≤i} w_j · Σ_{j<i} w_j)     i > 1
/// r'_i = Σ_{j≤i} w_j (r_i − r_j)
/// ```
///
/// with the forward weights in all three. It needs r_1 = 0 and w_1 > 0. All slices are of one
/// length. Virgin states correspond to each other.
///
/// Source: Kuhnen 2003.
pub fn invert(r: &[f64], w: &[f64], inverse_r: &mut [f64], inverse_w: &mut [f64]) {
    let mut sum = 0.0;
    let mut threshold = 0.0;
    let mut last = 0.0;
    let inverse = inverse_r.iter_mut().zip(inverse_w);
    for ((r, w), (inverse_r, inverse_w)) in r.iter().zip(w).zip(inverse) {
        // r'_i − r'_{i−1} = (r_i − r_{i−1})·Σ_{j<i} w_j
        threshold += sum * (r - last);
        let next = sum + w;
        *inverse_r = threshold;
        *inverse_w = if sum == 0.0 { 1.0 / w } else { -w / (next * sum) };
        (sum, last) = (next, *r);
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;
    use crate::testing::{Random, loop_area, triangle};

    fn run(r: f64, signal: &[f64]) -> Vec<f64> {
        let mut p = 0.0;
        signal
            .iter()
            .map(|u| {
                p = play(Drive(*u), Threshold(r), p);
                p
            })
            .collect()
    }

    #[test]
    fn loop_area_of_a_play_is_4_r_a_minus_r() {
        for (r, a) in [(0.25, 1.0), (0.5, 1.0), (0.75, 3.0)] {
            let signal = triangle(-a, a, 400, 2);
            let output = run(r, &signal);
            let (x, y) = (&signal[800..], &output[800..]);
            let error = loop_area(x, y) - 4.0 * r * (a - r);
            assert!(error.abs() < 1e-12, "r {r}, a {a}: {error}");
        }
    }

    #[test]
    fn plays_in_pairs_are_single_plays_to_the_bit() {
        for count in 0..6 {
            let mut random = Random::new(11);
            let (r, w) = (random.signal(0.0, 1.0, count), random.signal(-1.0, 1.0, count));
            let plays = Plays { r: &r, w: &w };
            let (mut pairs, mut single) = (std::vec![0.0; count], std::vec![0.0; count]);
            for u in random.signal(-2.0, 2.0, 500) {
                let mut sum = 0.0;
                for ((p, r), w) in single.iter_mut().zip(&r).zip(&w) {
                    *p = play(Drive(u), Threshold(*r), *p);
                    sum += w * *p;
                }
                assert_eq!(plays.step(u, &mut pairs).to_bits(), sum.to_bits(), "{count} plays");
                assert_eq!(pairs, single);
            }
        }
    }

    #[test]
    fn stop_is_the_input_minus_the_play() {
        let signal = Random::new(7).signal(-2.0, 2.0, 2000);
        let (mut p, mut e, mut last) = (0.0, 0.0, 0.0);
        for u in signal {
            p = play(Drive(u), Threshold(0.6), p);
            e = stop(Change(u - last), Threshold(0.6), e);
            last = u;
            assert!((e - (u - p)).abs() < 1e-12, "u {u}: stop {e}, play {p}");
        }
    }

    #[test]
    fn wiping_out_a_larger_excursion_forgets_the_smaller_ones() {
        let plays = Plays { r: &[0.0, 0.3, 0.7, 1.1], w: &[1.0, 0.5, 0.25, 2.0] };
        let mut random = Random::new(3);
        for _ in 0..200 {
            let history = random.signal(-1.9, 1.9, 50);
            let (mut with, mut without) = ([0.0; 4], [0.0; 4]);
            for u in history.iter().chain(&[2.0, -2.0, 0.4]) {
                plays.step(*u, &mut with);
            }
            for u in [2.0, -2.0, 0.4] {
                plays.step(u, &mut without);
            }
            assert_eq!(with, without);
        }
    }

    #[test]
    fn congruency_minor_loops_between_the_same_inputs_have_the_same_shape() {
        let plays = Plays { r: &[0.0, 0.1, 0.2, 0.4], w: &[1.0, 0.5, 0.25, 2.0] };
        let minor = |history: &[f64]| {
            let mut state = [0.0; 4];
            for u in history {
                plays.step(*u, &mut state);
            }
            plays.step(0.5, &mut state);
            let base = plays.step(0.0, &mut state);
            triangle(0.0, 0.5, 50, 1).iter().map(|u| plays.step(*u, &mut state) - base).collect()
        };
        let (one, other): (Vec<f64>, Vec<f64>) = (minor(&[2.0, -3.0]), minor(&[-1.0, 4.0, 0.2]));
        for (a, b) in one.iter().zip(&other) {
            assert!((a - b).abs() < 1e-14, "{a} {b}");
        }
    }

    #[test]
    fn inverse_of_the_inverse_is_the_operator() {
        let (r, w) = ([0.0, 6.0, 12.0, 18.0], [0.0135, 0.0279, 0.0, 0.004]);
        let (mut ri, mut wi, mut rii, mut wii) = ([0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]);
        invert(&r, &w, &mut ri, &mut wi);
        invert(&ri, &wi, &mut rii, &mut wii);
        for i in 0..4 {
            assert!((rii[i] - r[i]).abs() < 1e-12, "{rii:?}");
            assert!((wii[i] - w[i]).abs() < 1e-15, "{wii:?}");
        }
    }
}
