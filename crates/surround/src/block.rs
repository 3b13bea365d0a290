//! Blocks: what an effect does to one signal, value by value. Quantities are SI.
//!
//! A block starts at rest under its first value. A value is what is held over the step that ends
//! now; steps may differ in length.

use components::hysteresis::rate;
use components::linear::lag_fraction;
use libm::{expm1, log10, pow};
use serde::{Deserialize, Serialize};

use crate::mechanics::{Force, ForcedMode, before_mode, dahl, mode};
use crate::rated::{self, Growth};
use crate::state::{State, past};
use crate::warmth::{Loss, warming};
use crate::{map, memory};

/// What a block does. Numbers that were known when the machine was diagnosed stand here, the fitted
/// ones are parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Block {
    /// `g·x`: factor.
    Factor,
    /// `x + c`: offset.
    Offset,
    /// `x(t − T)`: T in s.
    Delay,
    /// `q·(round(x/q − p) + p)` with the step `q = 2·half/n`: steps n over the range, phase p.
    Rounding {
        /// Half the range.
        half: f64,
    },
    /// `q·(c + ½ + p)`, `q = 2·half/n`, with the code `c = ⌊x/q − p⌋`, or the one before where
    /// c mod `every` is `missing`: steps n over the range, phase p.
    MissingCodes {
        /// Half the range.
        half: f64,
        /// Of so many codes one is missing.
        every: u32,
        /// Which one.
        missing: u32,
    },
    /// Equal first-order lags in series: bandwidth of each in Hz.
    Lag {
        /// How many.
        order: usize,
    },
    /// Second-order lag: frequency in Hz, damping.
    SecondOrder,
    /// What has to enter a mode of unit gain for x to come out.
    BeforeMode {
        /// Natural frequency in Hz.
        frequency: f64,
        /// Damping ratio.
        damping: f64,
    },
    /// A mode of unit gain.
    Mode {
        /// Natural frequency in Hz.
        frequency: f64,
        /// Damping ratio.
        damping: f64,
    },
    /// A mode of unit gain with another force on it, whose parameters these are.
    ForcedMode {
        /// Natural frequency in Hz.
        frequency: f64,
        /// Damping ratio.
        damping: f64,
        /// The force.
        force: Force,
        /// The far end of the range.
        far: f64,
    },
    /// Slope limit: rate per second.
    Slew,
    /// Slope limit up, and the one down over it: rate per second, ratio.
    UnevenSlew,
    /// First-order approach with a soft slope limit: rate per second, bandwidth in Hz.
    SoftSlew,
    /// Upper limit.
    LimitAbove,
    /// Lower limit.
    LimitBelow,
    /// Both limits: half width.
    Limits {
        /// The middle.
        centre: f64,
    },
    /// Smooth upper limit: limit, width of the bend.
    SoftLimitAbove,
    /// `c + a·tanh((x − c)/a)`: a over the half range.
    Tanh {
        /// Centre c.
        centre: f64,
        /// Half the range.
        half: f64,
    },
    /// S-curve that flattens to both ends: size, shift of the centre.
    SCurve {
        /// Middle of the range.
        centre: f64,
        /// Half the range.
        half: f64,
    },
    /// `x + g·(x − rest)` about the value at rest: g.
    Gain,
    /// `x·(1 + g + a·lg(1 + t/0.1 s))`, t from the start: g, a.
    AgeingGain,
    /// Slopes beyond ± 0.3 of the range: added above, added below.
    DeadZones {
        /// Middle of the range.
        centre: f64,
        /// Half the range.
        half: f64,
    },
    /// Polynomial about the centre, over the half range: coefficients of 2, 3, ….
    Polynomial {
        /// Centre.
        centre: f64,
        /// Half the range.
        half: f64,
    },
    /// Sine over the range: size in the half range, cycles over the range, phase.
    Sine {
        /// Centre.
        centre: f64,
        /// Half the range.
        half: f64,
    },
    /// `x + Σ share·lag(x)`: share and time constant in s, in pairs.
    Creep,
    /// Creep with the same growth in each decade between two times: gain per decade, shortest time.
    LogCreep {
        /// Longest time in s.
        longest: f64,
    },
    /// Creep whose growth per decade grows with time: gain, exponent.
    PowerCreep {
        /// Shortest time in s.
        shortest: f64,
        /// Longest time in s.
        longest: f64,
    },
    /// Creep of elements with given times: a share each.
    FixedCreep {
        /// Time constants in s.
        times: Vec<f64>,
    },
    /// `x + Σ w_k·(P_k[drive] − drive) + w_0·drive`: w_0 (where `slope`), w_k.
    Plays {
        /// Thresholds.
        r: Vec<f64>,
        /// Whether the part without memory is there.
        slope: bool,
    },
    /// `x + Σ w_k·(P_k[drive] − drive)·z` with the place z in the range: w_k.
    SkewedPlays {
        /// Thresholds.
        r: Vec<f64>,
        /// Middle of the drive's range.
        centre: f64,
        /// Half of the drive's range.
        half: f64,
    },
    /// Plays whose thresholds grow along the range: curvature.
    CurvedPlays {
        /// Thresholds.
        r: Vec<f64>,
        /// Weights.
        w: Vec<f64>,
        /// Middle of the drive's range.
        centre: f64,
        /// Half of the drive's range.
        half: f64,
    },
    /// Plays between the envelopes `v + half·(a·z + b·z²) − r` and `v + half·(c·z + d·z²) + r` of the drive v
    /// with its place z in the range: a, b, c, d.
    BentPlays {
        /// Thresholds.
        r: Vec<f64>,
        /// Weights.
        w: Vec<f64>,
        /// Middle of the drive's range.
        centre: f64,
        /// Half of the drive's range.
        half: f64,
    },
    /// Plays whose thresholds grow with the drive's rate by a time: `r + T·|v′|`, v′ as the component of that
    /// name takes it: T.
    RatePlays {
        /// Thresholds.
        r: Vec<f64>,
        /// Weights.
        w: Vec<f64>,
    },
    /// Plays whose thresholds grow in their own proportion, `r·(1 + g·f(|ρ|/(k·scale)))`, with the smoothed
    /// rate ρ of the drive: g, k, and the time in s over which the rate is smoothed, where it is free.
    GrowingPlays {
        /// Thresholds.
        r: Vec<f64>,
        /// Weights.
        w: Vec<f64>,
        /// The law f.
        law: Growth,
        /// A rate in the drive's unit per second.
        scale: f64,
        /// Time in s over which the size of the rate is smoothed; where it is a parameter, the rate is smoothed
        /// with its sign.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        smoothing: Option<f64>,
    },
    /// Plays that lag behind the drive: bandwidth in Hz.
    LaggedPlays {
        /// Thresholds.
        r: Vec<f64>,
        /// Weights.
        w: Vec<f64>,
    },
    /// `x + T·ρ/half·Σ w·(P[v] − v)` with the smoothed rate ρ of the drive v: T.
    RateMemory {
        /// Thresholds.
        r: Vec<f64>,
        /// Weights.
        w: Vec<f64>,
        /// Half of the drive's range.
        half: f64,
        /// Time over which the rate is smoothed in s.
        smoothing: f64,
    },
    /// `x − a·D·h`, `h′ = v′/D·(1 − (β sign(v′h) + 1 − β)·h²)` of the drive v: a, D, β.
    BoucWen,
    /// `x + w·(P[v] − v)` of the drive v, P a play of half the width `half·(r₀ + r₁z + r₂z²)` with the
    /// place z in the range: w, r₀, r₁, r₂.
    GeneralisedPlay {
        /// Middle of the drive's range.
        centre: f64,
        /// Half of the drive's range.
        half: f64,
    },
    /// Warmth from the drive's power adds to the path: growth, time constant in s.
    Heating {
        /// Half range of the path.
        half: f64,
        /// What the power is.
        loss: Loss,
    },
    /// Warmth from the drive's power changes the gain: growth, time constant in s.
    HeatingGain {
        /// What the power is.
        loss: Loss,
    },
    /// Warmth over several times: growth of each, and a gain that goes with their mean.
    Warming {
        /// Half range of the path.
        half: f64,
        /// What the power is.
        loss: Loss,
        /// Time constants in s.
        times: Vec<f64>,
    },
    /// `x + g·(M[x] − x)` with a mode M: gain, frequency in Hz, damping.
    ParallelMode,
    /// A pair of poles over a pair of zeros: pole in Hz, its damping, zero over pole, its damping.
    PoleZero,
    /// Clearance: half its width.
    Backlash,
    /// Clearance with a spring across it: half its width, share of the motion that passes within it.
    BridgedBacklash,
    /// Dahl friction: size, pre-sliding distance.
    Dahl,
    /// `x + a·s + b·s′` of an auxiliary signal s: a, and b in ms where there are two parameters.
    Auxiliary {
        /// Range of the signal over that of the path.
        scale: f64,
        /// Value of the signal that changes nothing.
        zero: f64,
    },
    /// The same through a first-order lag: a, bandwidth in Hz.
    LaggedAuxiliary {
        /// Range of the signal over that of the path.
        scale: f64,
        /// Value of the signal that changes nothing.
        zero: f64,
    },
    /// The same through a mode: a, frequency in Hz, damping.
    ModalAuxiliary {
        /// Range of the signal over that of the path.
        scale: f64,
        /// Value of the signal that changes nothing.
        zero: f64,
    },
    /// `x + (a·drive + b·time·drive′)/scale`: a, b.
    FeedThrough {
        /// Range of the drive over that of the path.
        scale: f64,
        /// In s.
        time: f64,
    },
}

/// What a block reads at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wires {
    /// The path before the block.
    pub x: f64,
    /// What drives the original.
    pub drive: f64,
    /// An auxiliary signal.
    pub aux: f64,
}

impl Block {
    /// Number of its parameters; `None`: any.
    #[must_use]
    pub fn parameters(&self) -> Option<usize> {
        Some(match self {
            Self::Polynomial { .. } | Self::Creep | Self::Auxiliary { .. } => return None,
            Self::FixedCreep { times } => times.len(),
            Self::Warming { times, .. } => times.len() + 1,
            Self::Plays { r, slope } => r.len() + usize::from(*slope),
            Self::SkewedPlays { r, .. } => r.len(),
            Self::ForcedMode { force, .. } => force.count(),
            Self::BeforeMode { .. } | Self::Mode { .. } => 0,
            Self::Factor
            | Self::Offset
            | Self::RatePlays { .. }
            | Self::LaggedPlays { .. }
            | Self::RateMemory { .. }
            | Self::Delay
            | Self::Lag { .. }
            | Self::Slew
            | Self::LimitAbove
            | Self::LimitBelow
            | Self::Limits { .. }
            | Self::Tanh { .. }
            | Self::Gain
            | Self::CurvedPlays { .. }
            | Self::Backlash => 1,
            Self::Rounding { .. }
            | Self::MissingCodes { .. }
            | Self::SecondOrder
            | Self::SoftSlew
            | Self::UnevenSlew
            | Self::AgeingGain
            | Self::SoftLimitAbove
            | Self::SCurve { .. }
            | Self::DeadZones { .. }
            | Self::LogCreep { .. }
            | Self::PowerCreep { .. }
            | Self::Heating { .. }
            | Self::HeatingGain { .. }
            | Self::Dahl
            | Self::BridgedBacklash
            | Self::LaggedAuxiliary { .. }
            | Self::FeedThrough { .. } => 2,
            Self::Sine { .. }
            | Self::ParallelMode
            | Self::ModalAuxiliary { .. }
            | Self::BoucWen => 3,
            Self::GrowingPlays { smoothing, .. } => 2 + usize::from(smoothing.is_none()),
            Self::PoleZero | Self::GeneralisedPlay { .. } | Self::BentPlays { .. } => 4,
        })
    }

    /// The output at rest under these inputs, and the state that belongs to it.
    pub fn rest(&self, p: &[f64], w: Wires, state: &mut State) -> f64 {
        let Wires { x, drive, aux } = w;
        state.z.clear();
        state.past.clear();
        match self {
            Self::Delay => state.past.push_back((0.0, x)),
            Self::Lag { order } => state.z.resize(*order, x),
            Self::SecondOrder
            | Self::BeforeMode { .. }
            | Self::Mode { .. }
            | Self::ParallelMode
            | Self::PoleZero => state.z.extend([x, 0.0]),
            Self::ForcedMode { force, far, .. } => {
                let mut slide = 0.0;
                let rest = ForcedMode::rest(x, |at| force.pull(p, *far, at, &mut slide, true));
                state.z.extend([rest, 0.0, rest, slide]);
            }
            Self::Slew
            | Self::UnevenSlew
            | Self::SoftSlew
            | Self::Backlash
            | Self::BridgedBacklash
            | Self::Gain => state.z.push(x),
            Self::BoucWen => state.z.extend([0.0, drive]),
            Self::GeneralisedPlay { .. } => state.z.push(0.0),
            Self::Warming { times, .. } => {
                state.z.resize(times.len(), 0.0);
                state.z.extend([drive, x]);
            }
            Self::Dahl => state.z.extend([0.0, x]),
            Self::Heating { .. } | Self::HeatingGain { .. } => state.z.extend([0.0, drive, x]),
            Self::Creep
            | Self::LogCreep { .. }
            | Self::PowerCreep { .. }
            | Self::FixedCreep { .. } => {
                self.each_element(p, |_, _| state.z.push(x));
            }
            Self::Plays { r, .. } | Self::SkewedPlays { r, .. } => {
                state.z.resize(r.len(), 0.0);
            }
            Self::CurvedPlays { r, .. } | Self::BentPlays { r, .. } => {
                state.z.resize(2 * r.len(), 0.0);
            }
            Self::RatePlays { r, .. } => {
                state.z.extend(rate::rest(drive));
                state.z.resize(rate::STATES + 2 * r.len(), 0.0);
            }
            Self::GrowingPlays { r, .. } | Self::RateMemory { r, .. } => {
                state.z.extend([drive, 0.0]);
                state.z.resize(2 + 2 * r.len(), 0.0);
            }
            Self::LaggedPlays { r, .. } => {
                state.z.push(drive);
                state.z.resize(1 + 2 * r.len(), 0.0);
            }
            Self::Auxiliary { .. } => state.z.push(aux),
            Self::FeedThrough { .. } => state.z.push(drive),
            Self::LaggedAuxiliary { zero, .. } => state.z.push(aux - zero),
            Self::ModalAuxiliary { zero, .. } => state.z.extend([aux - zero, 0.0]),
            _ => {}
        }
        self.step(p, w, 0.0, 0.0, state)
    }

    /// The output at the end of a step of length `dt` that ends `t` after the start, both in s.
    pub fn step(&self, p: &[f64], w: Wires, t: f64, dt: f64, state: &mut State) -> f64 {
        let x = w.x;
        let z = &mut state.z;
        match (self, p) {
            (Self::Factor, &[factor]) => factor * x,
            (Self::Offset, &[offset]) => x + offset,
            (Self::Delay, &[delay]) => {
                if dt > 0.0 {
                    state.past.push_back((t, x));
                }
                past(t - delay, state)
            }
            (Self::Lag { .. }, &[bandwidth]) => {
                let fraction = lag_fraction(bandwidth, dt);
                z.iter_mut().fold(x, |x, z| {
                    *z += fraction * (x - *z);
                    *z
                })
            }
            (Self::SecondOrder, &[frequency, damping]) => mode((frequency, damping), x, dt, z),
            (&Self::Mode { frequency, damping }, _) => mode((frequency, damping), x, dt, z),
            (&Self::BeforeMode { frequency, damping }, _) => {
                before_mode((frequency, damping), x, dt, z)
            }
            (&Self::ForcedMode { frequency, damping, force, far }, p) => {
                let Some((z, [slide, ..])) = z.split_first_chunk_mut::<3>() else { return x };
                if dt > 0.0 {
                    let pull = |at, goes_on| force.pull(p, far, at, slide, goes_on);
                    ForcedMode::new((frequency, damping), [force], dt).step(x, z, pull)
                } else {
                    z[0]
                }
            }
            (Self::ParallelMode, &[gain, frequency, damping]) => {
                x + gain * (mode((frequency, damping), x, dt, z) - x)
            }
            (Self::PoleZero, &[pole, damping, ratio, zero_damping]) => {
                // G = k² + (1 − k²)·M + 2k(ζ_z − k ζ_p)·M′/ω_p with k = ω_p/ω_z.
                let k = 1.0 / ratio;
                let position = mode((pole, damping), x, dt, z);
                let rate = z.get(1).copied().unwrap_or(0.0);
                k * k * x + (1.0 - k * k) * position + 2.0 * k * (zero_damping - k * damping) * rate
            }
            (Self::Slew, &[rate]) => follow(z, |v| v + (x - v).clamp(-rate * dt, rate * dt)),
            (Self::SoftSlew, &[rate, bandwidth]) => {
                let (most, fraction) = (rate * dt, lag_fraction(bandwidth, dt));
                // z/√(1 + z²): straight at small slopes, never above the limit.
                follow(z, |v| {
                    let z = if most > 0.0 { fraction * (x - v) / most } else { 0.0 };
                    v + most * z / (1.0 + z * z).sqrt()
                })
            }
            (Self::UnevenSlew, &[rate, ratio]) => {
                follow(z, |v| v + (x - v).clamp(-ratio * rate * dt, rate * dt))
            }
            (Self::Backlash, &[half]) => follow(z, |v| (x - half).max((x + half).min(v))),
            (Self::BridgedBacklash, &[half, bridge]) => {
                let play = follow(z, |v| (x - half).max((x + half).min(v)));
                play + bridge * (x - play)
            }
            (Self::Gain, &[gain]) => x + gain * (x - z.first().copied().unwrap_or(x)),
            (Self::AgeingGain, &[gain, growth]) => x + (gain + growth * log10(1.0 + t / 0.1)) * x,
            (Self::Warming { half, loss, times }, p) => warming(*half, *loss, times, p, w, dt, z),
            (Self::Dahl, &[size, distance]) => dahl(size, distance, x, z),
            (Self::Heating { half, loss }, &[growth, time]) => {
                x + growth * half * loss.warmth(time, w.drive, dt, z)
            }
            (Self::HeatingGain { loss }, &[growth, time]) => {
                let rest = z.get(2).copied().unwrap_or(x);
                x + growth * loss.warmth(time, w.drive, dt, z) * (x - rest)
            }
            (Self::Auxiliary { scale, zero }, &[a]) => x + a * (w.aux - zero) / scale,
            // The rate's weight is that of a lead of one millisecond.
            (Self::Auxiliary { scale, zero }, &[a, b]) => {
                x + (a * (w.aux - zero) + 1e-3 * b * slope(w.aux, dt, z)) / scale
            }
            (Self::LaggedAuxiliary { scale, zero }, &[a, bandwidth]) => {
                let fraction = lag_fraction(bandwidth, dt);
                x + a / scale * follow(z, |v| v + fraction * (w.aux - zero - v))
            }
            (Self::ModalAuxiliary { scale, zero }, &[a, frequency, damping]) => {
                x + a / scale * mode((frequency, damping), w.aux - zero, dt, z)
            }
            (Self::FeedThrough { scale, time }, &[a, b]) => {
                x + (a * w.drive + b * time * slope(w.drive, dt, z)) / scale
            }
            (
                Self::Creep
                | Self::LogCreep { .. }
                | Self::PowerCreep { .. }
                | Self::FixedCreep { .. },
                p,
            ) => self.creep(p, x, dt, z),
            (
                Self::Plays { .. }
                | Self::SkewedPlays { .. }
                | Self::CurvedPlays { .. }
                | Self::BentPlays { .. }
                | Self::BoucWen
                | Self::GeneralisedPlay { .. },
                p,
            ) => memory::step(self, p, w, z),
            (
                Self::RatePlays { .. }
                | Self::GrowingPlays { .. }
                | Self::LaggedPlays { .. }
                | Self::RateMemory { .. },
                p,
            ) => rated::step(self, p, w, dt, z),
            (block, p) => map::value(block, p, x),
        }
    }

    /// Calls `each` with share and time constant of every element of a creep.
    fn each_element(&self, p: &[f64], mut each: impl FnMut(f64, f64)) {
        match (self, p) {
            (Self::Creep, p) => p.chunks_exact(2).for_each(|pair| each(pair[0], pair[1])),
            (Self::FixedCreep { times }, p) => {
                times.iter().zip(p).for_each(|(time, share)| each(*share, *time));
            }
            (Self::LogCreep { longest }, &[gain, shortest]) => {
                grid(shortest, longest.max(3.0 * shortest)).for_each(|t| each(0.5 * gain, t));
            }
            (Self::PowerCreep { shortest, longest }, &[gain, exponent]) => {
                let middle = (shortest * longest).sqrt();
                grid(*shortest, *longest)
                    .for_each(|t| each(0.5 * gain * pow(t / middle, exponent), t));
            }
            _ => {}
        }
    }

    fn creep(&self, p: &[f64], x: f64, dt: f64, z: &mut [f64]) -> f64 {
        let mut y = x;
        let mut z = z.iter_mut();
        self.each_element(p, |share, time| {
            if let Some(z) = z.next() {
                *z += -expm1(-dt / time) * (x - *z);
                y += share * *z;
            }
        });
        y
    }
}

/// Two elements per decade.
fn grid(shortest: f64, longest: f64) -> impl Iterator<Item = f64> {
    let decades = log10(longest / shortest).max(0.5);
    let count = (2.0 * decades).round().max(1.0);
    (0..count as usize).map(move |i| shortest * pow(10.0, decades * (i as f64 + 0.5) / count))
}

/// Replaces the one number of a state.
fn follow(z: &mut [f64], next: impl FnOnce(f64) -> f64) -> f64 {
    let Some(z) = z.first_mut() else { return 0.0 };
    *z = next(*z);
    *z
}

/// The rate of a signal over the step; the state is its value before.
fn slope(signal: f64, dt: f64, z: &mut [f64]) -> f64 {
    let Some(before) = z.first_mut() else { return 0.0 };
    let rate = if dt > 0.0 { (signal - *before) / dt } else { 0.0 };
    *before = signal;
    rate
}
