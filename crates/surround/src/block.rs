//! Blocks: what an effect does to one signal, value by value. Quantities are SI.
//!
//! A block starts at rest under its first value. A value is what is held over the step that ends
//! now; steps may differ in length.
//!
//! Where a component does the same, the component itself steps ([`Kernel::components`](crate::Kernel::components)), and
//! is what a diagnosis hands back. The other blocks have formulas of their own: no component does just that, they are
//! differences to what the original already does, or they count steps, whose lengths differ here (delay).

use serde::{Deserialize, Serialize};

use crate::kernel::{Count, WrongCount, each, exactly};
use crate::linear;
use crate::mechanics::Force;
use crate::operator::Operator;
use crate::rated::Growth;
use crate::span::{Memory, Span};
use crate::warmth::Loss;

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
        /// Which of these codes is missing.
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
    /// `k + a·tanh((x − k)/a)` above a knee k: k, a.
    KneeAbove,
    /// `c + a·tanh((x − c)/a)`: a over the half range.
    Tanh(Span),
    /// S-curve that flattens to both ends: size, shift of the centre.
    SCurve(Span),
    /// `x + g·(x − rest)` about the value at rest: g.
    Gain,
    /// `x·(1 + g + a·lg(1 + t/0.1 s))`, t from the start: g, a.
    AgeingGain,
    /// Slopes beyond ± 0.3 of the range: added above, added below.
    DeadZones(Span),
    /// Polynomial about the centre, over the half range: coefficients of 2, 3, ….
    Polynomial(Span),
    /// Sine over the range: size in the half range, cycles over the range, phase.
    Sine(Span),
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
        /// Range of the drive.
        #[serde(flatten)]
        span: Span,
    },
    /// Plays whose thresholds grow along the range: curvature.
    CurvedPlays {
        /// Plays of the original.
        #[serde(flatten)]
        memory: Memory,
        /// Range of the drive.
        #[serde(flatten)]
        span: Span,
    },
    /// Plays between the envelopes `v + half·(a·z + b·z² + c·z³ − w) − r` and `v + half·(d·z + e·z² + f·z³ + w) + r`
    /// of the drive v with its place z in the range: a, b, c, d, e, f, w.
    BentPlays {
        /// Plays of the original.
        #[serde(flatten)]
        memory: Memory,
        /// Range of the drive.
        #[serde(flatten)]
        span: Span,
    },
    /// `x + C[v] − Σ w·P_r[v]` of the drive v, C the component of this operator with the same plays: its parameters
    /// that a diagnosis fits, in their order.
    Operator {
        /// The component.
        component: Operator,
        /// Plays of the original.
        #[serde(flatten)]
        memory: Memory,
    },
    /// As earlier versions wrote the operator `rate-dependent-play`: T.
    RatePlays(Memory),
    /// Plays whose thresholds grow in their own proportion, `r·(1 + g·f(|ρ|/(k·scale)))`, with the smoothed
    /// rate ρ of the drive: g, k, and the time in s over which the rate is smoothed, where it is free.
    GrowingPlays {
        /// Plays of the original.
        #[serde(flatten)]
        memory: Memory,
        /// The law f.
        law: Growth,
        /// A rate in the drive's unit per second.
        scale: f64,
        /// Time in s over which the size of the rate is smoothed; where it is a parameter, the rate is smoothed
        /// with its sign.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        smoothing: Option<f64>,
    },
    /// As earlier versions wrote the operator `lagging-play`: bandwidth in Hz.
    LaggedPlays(Memory),
    /// `x + T·ρ/half·Σ w·(P[v] − v)` with the smoothed rate ρ of the drive v: T.
    RateMemory {
        /// Plays of the original.
        #[serde(flatten)]
        memory: Memory,
        /// Half of the drive's range.
        half: f64,
        /// Time over which the rate is smoothed in s.
        smoothing: f64,
    },
    /// `x − a·D·h`, `h′ = v′/D·(1 − (β sign(v′h) + 1 − β)·h²)` of the drive v: a, D, β.
    BoucWen,
    /// `x + w·(P[v] − v)` of the drive v, P a play of half the width `half·(r₀ + r₁z + r₂z²)` with the
    /// place z in the range: w, r₀, r₁, r₂.
    GeneralisedPlay(Span),
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
    /// `x + a·lag(s)` of an auxiliary signal s: a, bandwidth of the lag in Hz.
    LaggedAuxiliary {
        /// Range of the signal over that of the path.
        scale: f64,
        /// Value of the signal that changes nothing.
        zero: f64,
    },
    /// `x + a·M[s]` of an auxiliary signal s with a mode M: a, frequency in Hz, damping.
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

impl Block {
    /// Share and time constant in s of each element of a creep; none of another block.
    ///
    /// # Errors
    /// [`WrongCount`] where it takes another number of parameters.
    pub fn elements(&self, p: &[f64]) -> Result<Option<Vec<(f64, f64)>>, WrongCount> {
        Ok(Some(match self {
            Self::Creep if p.is_empty() || p.len() % 2 == 1 => {
                return Err(WrongCount { given: p.len(), wanted: Count::Pairs });
            }
            Self::Creep => p.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect(),
            Self::FixedCreep { times } => {
                let shares = each(p, times.len())?.iter().copied();
                shares.zip(times.iter().copied()).collect()
            }
            Self::LogCreep { longest } => linear::log_creep(*longest, exactly(p)?),
            Self::PowerCreep { shortest, longest } => {
                linear::power_creep(*shortest, *longest, exactly(p)?)
            }
            _ => return Ok(None),
        }))
    }

    /// Whether it reads an auxiliary signal.
    #[must_use]
    pub fn reads_auxiliary(&self) -> bool {
        matches!(
            self,
            Self::Auxiliary { .. } | Self::LaggedAuxiliary { .. } | Self::ModalAuxiliary { .. }
        )
    }
}
