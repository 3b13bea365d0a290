//! Blocks: what an effect does to a whole signal on the path.
//!
//! A signal is one value per hit of the grid; value 0 is the rest value, value n is held over hit n.
//! A block starts at rest under value 0 and writes as many values as it reads. Quantities are SI.

mod input;
mod linear;
mod map;
mod memory;
mod motion;

use self::memory::Bank;
pub(crate) use self::memory::{GROWING, Memory, SATURATING};

/// Centre and half width of the range of a signal, to bring formulas to numbers near one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    /// Middle of the range.
    pub(crate) centre: f64,
    /// Half the range; above zero.
    pub(crate) half: f64,
}

impl Span {
    /// The span of these values; half is 1 where they are constant.
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let half = 0.5 * (high - low);
        if half > 0.0 && half.is_finite() {
            Self { centre: 0.5 * (high + low), half }
        } else {
            Self { centre: if low.is_finite() { low } else { 0.0 }, half: 1.0 }
        }
    }

    /// The value from −1 to 1.
    pub(crate) fn unit(self, value: f64) -> f64 {
        (value - self.centre) / self.half
    }
}

/// What warms an actuator, over its mean in the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Loss {
    /// The square of the drive's rate, as in a resistance; the mean square.
    Rate(f64),
    /// The rate times the drive, voltage times current; mean.
    Apparent(f64),
    /// The rate times the distance from the centre, as the area of loops: the same at every rate of a
    /// loop, f·V²; mean, and the range.
    Loops(f64, Span),
}

/// What a block reads.
#[derive(Clone, Copy)]
pub(crate) struct Wires<'a> {
    /// The path before the block.
    pub(crate) x: &'a [f64],
    /// The path before the actuator; for output-side blocks of a black box the command.
    pub(crate) drive: &'a [f64],
    /// The command as it enters the model.
    pub(crate) command: &'a [f64],
    /// An auxiliary column.
    pub(crate) aux: &'a [f64],
    /// Step of the grid in s.
    pub(crate) step: f64,
}

/// A parametric change of a signal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Block {
    /// `x(t − T)`; T in s.
    Delay,
    /// `x(t·(1 − e))` within the record.
    Clock,
    /// `q·(round(x/q − p) + p)`; steps over the range, phase p.
    Quantiser(Span),
    /// `q·(c + ½ + p)` with the code `c = ⌊x/q − p⌋`, or the one before where c mod `every` is
    /// `missing`; steps over the range, phase p.
    GappedQuantiser {
        /// Range.
        span: Span,
        /// Of so many codes one is missing.
        every: u32,
        /// Which one.
        missing: u32,
    },
    /// Equal first-order lags in series; bandwidth of each in Hz.
    Lag(usize),
    /// Second-order lag; frequency in Hz, damping.
    Lag2,
    /// Slope limit in command per second.
    Slew,
    /// Slope limit up, and the one down over it.
    UnevenSlew,
    /// Slope limit and first-order approach: slope limit, bandwidth.
    SoftSlew,
    /// Upper limit.
    ClampHigh,
    /// Lower limit.
    ClampLow,
    /// Both limits: half width about the centre.
    ClampBoth(Span),
    /// Smooth limit at the top: limit, width of the bend.
    SoftHigh,
    /// `c + A tanh((x − c)/A)`: A over the half range.
    Tanh(Span),
    /// Smooth S-curve with a slope that flattens to both ends: size, shift of the centre.
    Sigmoid(Span),
    /// `x·(1 + g)` about the rest value.
    Gain,
    /// `x·(1 + g + a·lg(1 + t/0.1 s))`, t from the record's start.
    AgeingGain,
    /// Warmth over several times: growth of each in the half range, and gain over the growth.
    Warming {
        /// Range of the path.
        span: Span,
        /// What the power is proportional to.
        loss: Loss,
        /// Time constants in s.
        times: Vec<f64>,
    },
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
    /// Creep of elements with these times in s: one share each.
    FixedCreep(Vec<f64>),
    /// Creep of elements with free times: share, time, share, time, …
    FreeCreep(usize),
    /// `x + Σ w_k·(P_k[drive] − drive) + w_0·drive`: w_0 (where `gain`), w_k.
    Plays {
        /// Thresholds.
        bank: Bank,
        /// Whether the part without memory is free.
        gain: bool,
    },
    /// `x − a·D·h`, `h′ = v′/D·(1 − (β sign(v′h) + 1 − β)·h²)`: a, D, β.
    BoucWen,
    /// Memory part times the place in the range: one weight per threshold.
    SkewedPlays {
        /// Thresholds.
        bank: Bank,
        /// Range of the drive.
        span: Span,
    },
    /// `x + w·(P[v] − v)`, P a play of half the width `h·(r₀ + r₁z + r₂z²)` with the place z of v in the
    /// range: w, r₀, r₁, r₂.
    GeneralisedPlay(Span),
    /// Plays with curved envelopes: one curvature; weights from the model.
    CurvedPlays {
        /// Memory of the model.
        memory: Memory,
        /// Range of the drive.
        span: Span,
    },
    /// Plays of the model between envelopes that are bent each by itself, `v + h·(a·z + b·z²) − r` and
    /// `v + h·(c·z + d·z²) + r` with the place z of the drive v in its range: a, b, c, d.
    BentPlays {
        /// Memory of the model.
        memory: Memory,
        /// Range of the drive.
        span: Span,
    },
    /// One-sided dead zones after the actuator: weight above, weight below (in the half range).
    DeadZones(Span),
    /// Thresholds that grow with the rate: s.
    RatePlays(Memory),
    /// Thresholds that grow in proportion up to a limit: growth, rate of half the growth over the
    /// steepest command.
    SaturatingPlays {
        /// Memory of the model.
        memory: Memory,
        /// Steepest slope of the command.
        steepest: f64,
    },
    /// Thresholds that grow with the smoothed rate, in proportion to themselves: growth, rate of reference
    /// over the steepest command, time of the smoothing.
    GrowingPlays {
        /// Memory of the model.
        memory: Memory,
        /// Steepest slope of the command.
        steepest: f64,
        /// How they grow.
        law: surround::Growth,
    },
    /// Plays that lag behind the drive: bandwidth in Hz.
    LaggedPlays(Memory),
    /// Memory part that grows with the rate: s, over the half range.
    RateMemory {
        /// Memory of the model.
        memory: Memory,
        /// Half range of the drive.
        half: f64,
    },
    /// Memory at the start of the record: −1 (from below) to 1.
    StartMemory(Memory),
    /// Temperature from the drive's power: growth in the half range, time constant in s.
    Heating {
        /// Range of the path.
        span: Span,
        /// What the power is proportional to.
        loss: Loss,
    },
    /// The same as a change of gain.
    HeatingGain {
        /// What the power is proportional to.
        loss: Loss,
    },
    /// A parallel mode with the static gain kept: gain, frequency in Hz, damping.
    ParallelMode,
    /// Pole pair over zero pair in series: pole Hz, pole damping, zero Hz over pole Hz, zero damping.
    PoleZero,
    /// What has to enter a mode of unit gain for x to come out; no parameters.
    BeforeMode {
        /// Natural frequency in Hz.
        frequency: f64,
        /// Damping ratio.
        damping: f64,
    },
    /// Clearance: half its width.
    Backlash,
    /// Clearance with a spring across it: half its width, share of the motion that passes within it.
    BridgedBacklash,
    /// Dahl friction on the displacement: size, pre-sliding distance.
    Dahl,
    /// Polynomial about the centre, over the half range: coefficients of 2, 3, ….
    Polynomial {
        /// Range.
        span: Span,
        /// Highest power.
        order: usize,
    },
    /// A sine over the range: size in the half range, cycles over the range, phase.
    Sine(Span),
    /// Auxiliary signal: weight of its value and, where `rate`, of its rate.
    Aux {
        /// Scale of the signal over that of the path.
        scale: f64,
        /// Whether its rate counts as well.
        rate: bool,
    },
    /// Auxiliary signal through a first-order lag: weight, bandwidth in Hz.
    LaggedAux {
        /// Scale of the signal over that of the path.
        scale: f64,
    },
    /// Auxiliary signal through a mode: weight, frequency in Hz, damping.
    ModalAux {
        /// Scale of the signal over that of the path.
        scale: f64,
    },
    /// A reading that droops towards zero, as behind a capacitor in series: corner in Hz, part of the
    /// first value that has drooped before the record begins.
    Droop,
    /// Feed-through of the path before the actuator: weight of its value and of its rate (s).
    FeedThrough {
        /// Scale of the command over that of the path.
        scale: f64,
        /// Time in s that scales the rate.
        time: f64,
    },
    /// The same of the command as it enters the model.
    CommandFeedThrough {
        /// Scale of the command over that of the path.
        scale: f64,
        /// Time in s that scales the rate.
        time: f64,
    },
}

impl Block {
    /// Writes what the block makes of its input; the slices have one length.
    pub(crate) fn run(&self, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
        match self {
            Self::Delay => input::delay(p, w, out),
            Self::Clock => input::clock(p, w, out),
            Self::Quantiser(span) => input::quantise(*span, p, w, out),
            Self::GappedQuantiser { span, every, missing } => {
                input::quantise_with_gaps(*span, (*every, *missing), p, w, out);
            }
            Self::Slew => input::slew(p, w, out),
            Self::UnevenSlew => input::uneven_slew(p, w, out),
            Self::SoftSlew => input::soft_slew(p, w, out),
            Self::Lag(order) => linear::lags(*order, p, w, out),
            Self::Lag2 => linear::second_order(p, w, out),
            Self::ParallelMode => linear::parallel_mode(p, w, out),
            Self::PoleZero => linear::pole_zero(p, w, out),
            Self::BeforeMode { frequency, damping } => {
                linear::before_mode((*frequency, *damping), w, out);
            }
            Self::LogCreep { .. }
            | Self::PowerCreep { .. }
            | Self::FixedCreep(_)
            | Self::FreeCreep(_) => linear::creep(self, p, w, out),
            Self::Aux { scale, rate } => linear::aux(*scale, *rate, p, w, out),
            Self::LaggedAux { scale } => linear::lagged_aux(*scale, p, w, out),
            Self::ModalAux { scale } => linear::modal_aux(*scale, p, w, out),
            Self::Droop => linear::droop(p, w, out),
            Self::FeedThrough { scale, time } => {
                linear::feed_through(*scale, *time, p, w.drive, w, out);
            }
            Self::CommandFeedThrough { scale, time } => {
                linear::feed_through(*scale, *time, p, w.command, w, out);
            }
            Self::ClampHigh
            | Self::ClampLow
            | Self::ClampBoth(_)
            | Self::SoftHigh
            | Self::Tanh(_)
            | Self::Sigmoid(_)
            | Self::Gain
            | Self::DeadZones(_)
            | Self::Polynomial { .. }
            | Self::Sine(_) => self.run_map(p, w, out),
            Self::Plays { bank, gain } => memory::plays(bank, *gain, p, w, out),
            Self::BoucWen => memory::bouc_wen(p, w, out),
            Self::GeneralisedPlay(span) => memory::generalised(*span, p, w, out),
            Self::SkewedPlays { bank, span } => memory::skewed(bank, *span, p, w, out),
            Self::CurvedPlays { memory, span } => memory::curved(memory, *span, p, w, out),
            Self::BentPlays { memory, span } => memory::bent(memory, *span, p, w, out),
            Self::GrowingPlays { memory, steepest, law } => {
                memory::growing(memory, (*steepest, *law), p, w, out);
            }
            Self::RatePlays(memory) => memory::rate_plays(memory, p, w, out),
            Self::SaturatingPlays { memory, steepest } => {
                memory::saturating_plays(memory, *steepest, p, w, out);
            }
            Self::LaggedPlays(memory) => memory::lagged_plays(memory, p, w, out),
            Self::RateMemory { memory, half } => memory::rate_memory(memory, *half, p, w, out),
            Self::StartMemory(memory) => memory::start_memory(memory, p, w, out),
            Self::Heating { span, loss } => motion::heating(Some(*span), *loss, p, w, out),
            Self::HeatingGain { loss } => motion::heating(None, *loss, p, w, out),
            Self::AgeingGain => motion::ageing(p, w, out),
            Self::Warming { span, loss, times } => {
                motion::warming(*span, *loss, times, p, w, out);
            }
            Self::Backlash | Self::BridgedBacklash => motion::backlash(p, w, out),
            Self::Dahl => motion::dahl(p, w, out),
        }
    }

    /// Share and time constant of each element of a creep.
    pub(crate) fn elements(&self, p: &[f64]) -> Option<Vec<(f64, f64)>> {
        linear::elements(self, p)
    }

    /// Whether it maps each value by itself, whatever the rest value is.
    pub(crate) fn is_map(&self) -> bool {
        matches!(
            self,
            Self::Tanh(_) | Self::Sigmoid(_) | Self::DeadZones(_) | Self::Polynomial { .. }
        )
    }

    /// What such a block makes of one value.
    pub(crate) fn map(&self, p: &[f64], x: f64) -> f64 {
        map::value(self, p, x, 0.0)
    }

    /// Runs a block that maps each value by itself.
    fn run_map(&self, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
        let rest = w.x.first().copied().unwrap_or(0.0);
        for (y, x) in out.iter_mut().zip(w.x) {
            *y = map::value(self, p, *x, rest);
        }
    }
}
