//! Blocks: what an effect does to one signal, value by value. Quantities are SI.
//!
//! A block starts at rest under its first value. A value is what is held over the step that ends
//! now; steps may differ in length.
//!
//! Where a component does the same, the component itself steps ([`Kernel::components`]), and is what a diagnosis
//! hands back. The other blocks are no components: formulas that are fitted and never handed back, differences to what
//! the original already does, and those that need a time that does not count steps (delay, ageing).

use components::amplifier::{AmplifierClamp, AmplifierSlew};
use components::hysteresis::{LaggingPlay, RateDependentPlay};
use components::mechanics::{Backlash, CollocatedMode, MODE};
use components::sensor::{Crosstalk, SensorLag, SensorPolynomial};
use model::Component;
use serde::{Deserialize, Serialize};

use crate::component::{Own, Series};
use crate::kernel::{Banked, Count, Kernel, Stepping, WrongCount, each, exactly};
use crate::linear::{self, Auxiliary, BeforeMode, Creep, Delay, Element, Mode};
use crate::map;
use crate::mechanics::{Dahl, Force, Forced};
use crate::memory::{self, BoucWen};
use crate::operator::Operator;
use crate::rated::{self, Growth, Smoothed};
use crate::span::{Memory, Span};
use crate::warmth::{Heating, Loss, Onto, Warming, Warmth};

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
    /// The block with these parameters for steps of `dt` s.
    ///
    /// # Errors
    /// [`WrongCount`] where it takes another number of parameters.
    pub fn prepare(&self, p: &[f64], dt: f64) -> Result<Kernel, WrongCount> {
        /// A law with N numbers as its state.
        fn stepping<const N: usize>(
            law: impl crate::kernel::Step<N>,
            dt: f64,
        ) -> Result<Kernel, WrongCount> {
            Ok(Kernel::new(Stepping(law), dt))
        }
        /// A law of elements side by side.
        fn banked<K: crate::kernel::Bank<H, S>, const H: usize, const S: usize>(
            bank: K,
            elements: Vec<K::Element>,
            dt: f64,
        ) -> Result<Kernel, WrongCount> {
            Ok(Kernel::new(Banked { bank, elements }, dt))
        }
        /// A component with these values.
        fn own<C: Component, const P: usize, const K: usize, const N: usize>(
            component: &'static C,
            values: [f64; P],
            dt: f64,
        ) -> Result<Kernel, WrongCount> {
            Ok(Kernel::new(Own::<C, P, K, N>::new(component, values), dt))
        }
        /// A mode of unit gain.
        fn mode(frequency: f64, damping: f64, dt: f64) -> Kernel {
            Kernel::new(Own::<_, 3, 4, 2>::new(&MODE, [frequency, damping, 1.0]), dt)
        }
        /// A component that earlier versions wrote by another name.
        fn earlier(
            component: &'static dyn Component,
            memory: &Memory,
            p: &[f64],
            dt: f64,
        ) -> Result<Kernel, WrongCount> {
            let operator = Operator::of(component).expect("it declares how it is tried");
            operator.kernel(memory, p, dt)
        }
        match self {
            Self::Factor => exactly(p).map(|[factor]| map::factor(factor)),
            Self::Offset => exactly(p).map(|[offset]| map::offset(offset)),
            Self::Delay => exactly(p).map(|[time]| Kernel::new(Delay { time }, dt)),
            Self::Rounding { half } => {
                exactly(p).map(|[steps, phase]| map::rounding(*half, steps, phase))
            }
            Self::MissingCodes { half, every, missing } => {
                exactly(p).map(|p| map::missing_codes(*half, *every, *missing, p))
            }
            Self::Lag { order } => exactly(p).map(|[bandwidth]| {
                let lag: Own<_, 1, 1, 1> = Own::new(&SensorLag, [bandwidth]);
                Kernel::new(Series(vec![lag; *order]), dt)
            }),
            Self::SecondOrder => {
                exactly(p).map(|[frequency, damping]| mode(frequency, damping, dt))
            }
            Self::BeforeMode { frequency, damping } => {
                let [] = exactly(p)?;
                stepping(BeforeMode::new(*frequency, *damping), dt)
            }
            Self::Mode { frequency, damping } => {
                let [] = exactly(p)?;
                Ok(mode(*frequency, *damping, dt))
            }
            Self::ForcedMode { frequency, damping, force, far } => {
                stepping(Forced::new(*frequency, *damping, force.acting(p, *far)?), dt)
            }
            Self::Slew => own::<_, 1, 1, 1>(&AmplifierSlew, exactly(p)?, dt),
            Self::UnevenSlew => {
                let [rate, ratio] = exactly(p)?;
                stepping(linear::UnevenSlew { rates: [ratio * rate, rate], ways: [0.0; 2] }, dt)
            }
            Self::SoftSlew => {
                let [rate, bandwidth] = exactly(p)?;
                stepping(linear::SoftSlew { rate, bandwidth, step: [0.0; 2] }, dt)
            }
            Self::LimitAbove => {
                let [high] = exactly(p)?;
                own::<_, 3, 3, 0>(&AmplifierClamp, [f64::NEG_INFINITY, high, 0.0], dt)
            }
            Self::LimitBelow => {
                let [low] = exactly(p)?;
                own::<_, 3, 3, 0>(&AmplifierClamp, [low, f64::INFINITY, 0.0], dt)
            }
            Self::Limits { centre } => {
                let [half] = exactly(p)?;
                own::<_, 3, 3, 0>(&AmplifierClamp, [centre - half, centre + half, 0.0], dt)
            }
            Self::SoftLimitAbove => {
                exactly(p).map(|[limit, width]| map::soft_limit_above(limit, width))
            }
            Self::KneeAbove => exactly(p).map(|[knee, width]| map::knee_above(knee, width)),
            Self::Tanh(span) => exactly(p).map(|[size]| map::hyperbolic_tangent(*span, size)),
            Self::SCurve(span) => exactly(p).map(|[size, shift]| map::s_curve(*span, size, shift)),
            Self::Gain => {
                let [gain] = exactly(p)?;
                stepping(linear::Gain { gain }, dt)
            }
            Self::AgeingGain => {
                let [gain, growth] = exactly(p)?;
                stepping(linear::AgeingGain { gain, growth }, dt)
            }
            Self::DeadZones(span) => {
                exactly(p).map(|[high, low]| map::dead_zones(*span, high, low))
            }
            Self::Polynomial(_) if p.is_empty() => {
                Err(WrongCount { given: 0, wanted: Count::OneOrMore })
            }
            Self::Polynomial(span) => match *p {
                [square, cubic] => {
                    let values = [square, cubic, span.centre, span.half];
                    own::<_, 4, 4, 0>(&SensorPolynomial, values, dt)
                }
                _ => Ok(map::polynomial(*span, p.to_vec())),
            },
            Self::Sine(span) => exactly(p).map(|p| map::sine(*span, p)),
            Self::Creep
            | Self::LogCreep { .. }
            | Self::PowerCreep { .. }
            | Self::FixedCreep { .. } => {
                let elements = self.elements(p)?.into_iter().flatten();
                banked(Creep, elements.map(Element::new).collect(), dt)
            }
            Self::Plays { r, slope } => {
                let weights = each(p, r.len() + usize::from(*slope))?;
                let (slope, weights) = weights.split_at(usize::from(*slope));
                let plays = r.iter().copied().zip(weights.iter().copied()).collect();
                banked(memory::Plays { slope: slope.first().copied() }, plays, dt)
            }
            Self::SkewedPlays { r, span } => {
                let plays = r.iter().copied().zip(each(p, r.len())?.iter().copied()).collect();
                banked(memory::SkewedPlays { span: *span }, plays, dt)
            }
            Self::CurvedPlays { memory, span } => {
                let [curvature] = exactly(p)?;
                banked(memory::CurvedPlays { span: *span, curvature }, memory.plays(), dt)
            }
            Self::BentPlays { memory, span } => {
                banked(memory::BentPlays { span: *span, bends: exactly(p)? }, memory.plays(), dt)
            }
            Self::Operator { component, memory } => component.kernel(memory, p, dt),
            Self::RatePlays(memory) => earlier(&RateDependentPlay, memory, p, dt),
            Self::LaggedPlays(memory) => earlier(&LaggingPlay, memory, p, dt),
            Self::GrowingPlays { memory, law, scale, smoothing } => {
                let (growth, of_scale, rate) = match smoothing {
                    Some(time) => {
                        let [growth, of_scale] = exactly(p)?;
                        (growth, of_scale, Smoothed::new(*time, true))
                    }
                    None => {
                        let [growth, of_scale, time] = exactly(p)?;
                        (growth, of_scale, Smoothed::new(time, false))
                    }
                };
                let (law, reference) = (*law, of_scale * scale);
                banked(rated::GrowingPlays { rate, growth, law, reference }, memory.plays(), dt)
            }
            Self::RateMemory { memory, half, smoothing } => {
                let [time] = exactly(p)?;
                let rate = Smoothed::new(*smoothing, true);
                banked(rated::RateMemory { rate, time, half: *half }, memory.plays(), dt)
            }
            Self::BoucWen => {
                let [gain, width, turning] = exactly(p)?;
                stepping(BoucWen { gain, width, turning }, dt)
            }
            Self::GeneralisedPlay(span) => {
                let [weight, width @ ..] = exactly::<4>(p)?;
                stepping(memory::GeneralisedPlay { span: *span, weight, width }, dt)
            }
            Self::Heating { half, loss } => {
                let [growth, time] = exactly(p)?;
                let onto = Onto::Path(*half);
                stepping(Heating { loss: *loss, onto, growth, time, step: (0.0, 0.0) }, dt)
            }
            Self::HeatingGain { loss } => {
                let [growth, time] = exactly(p)?;
                let onto = Onto::Gain;
                stepping(Heating { loss: *loss, onto, growth, time, step: (0.0, 0.0) }, dt)
            }
            Self::Warming { half, loss, times } => {
                let (growths, gain) = each(p, times.len() + 1)?.split_at(times.len());
                // The gain goes with their mean.
                let gain = gain[0] / times.len() as f64;
                let warmth = |(time, growth): (&f64, &f64)| Warmth {
                    time: *time,
                    growth: half * growth,
                    gain,
                    fraction: 0.0,
                };
                let warmths = times.iter().zip(growths).map(warmth).collect();
                banked(Warming { loss: *loss, dt }, warmths, dt)
            }
            Self::ParallelMode => {
                let [gain, frequency, damping] = exactly(p)?;
                stepping(linear::ParallelMode { gain, mode: Mode::new(frequency, damping) }, dt)
            }
            Self::PoleZero => {
                let [pole, damping, ratio, zero_damping] = exactly(p)?;
                let values = [pole, damping, pole * ratio, zero_damping];
                own::<_, 4, 5, 2>(&CollocatedMode, values, dt)
            }
            Self::Backlash => {
                let [half] = exactly(p)?;
                own::<_, 2, 2, 1>(&Backlash, [2.0 * half, 0.0], dt)
            }
            Self::BridgedBacklash => {
                let [half, bridge] = exactly(p)?;
                own::<_, 2, 2, 1>(&Backlash, [2.0 * half, bridge], dt)
            }
            Self::Dahl => {
                let [size, distance] = exactly(p)?;
                stepping(Dahl { size, distance }, dt)
            }
            Self::Auxiliary { scale, zero } => {
                let (value, rate) = match *p {
                    [value] => (value, 0.0),
                    [value, rate] => (value, rate),
                    _ => return Err(WrongCount { given: p.len(), wanted: Count::OneOrTwo }),
                };
                // The rate's weight is that of a lead of one millisecond.
                let rate = 1e-3 * rate;
                stepping(Auxiliary { value, rate, zero: *zero, scale: *scale, dt }, dt)
            }
            Self::LaggedAuxiliary { scale, zero } => {
                let [value, bandwidth] = exactly(p)?;
                let (weight, zero) = (value / scale, *zero);
                stepping(linear::LaggedAuxiliary { weight, bandwidth, zero, fraction: 0.0 }, dt)
            }
            Self::ModalAuxiliary { scale, zero } => {
                let [value, frequency, damping] = exactly(p)?;
                let (weight, mode) = (value / scale, Mode::new(frequency, damping));
                stepping(linear::ModalAuxiliary { weight, mode, zero: *zero }, dt)
            }
            Self::FeedThrough { scale, time } => {
                let [value, rate] = exactly(p)?;
                own::<_, 2, 2, 1>(&Crosstalk, [value / scale, rate * time / scale], dt)
            }
        }
    }

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
