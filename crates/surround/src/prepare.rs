//! What steps a block: the kernel with its parameters.

use components::actuator::ActuatorAgeing;
use components::amplifier::{AmplifierClamp, AmplifierSlew};
use components::hysteresis::{LaggingPlay, RateDependentPlay};
use components::mechanics::{Backlash, CollocatedMode, MODE};
use components::sensor::{
    Crosstalk, SENSOR_QUANTISATION, SENSOR_SCALE, SensorLag, SensorPolynomial,
};
use model::Component;

use crate::block::Block;
use crate::component::{Behind, Own, Series};
use crate::kernel::{Banked, Count, Kernel, Stepping, WrongCount, each, exactly};
use crate::linear::{self, Auxiliary, BeforeMode, Creep, Delay, Mode};
use crate::map;
use crate::mechanics::{Dahl, Forced};
use crate::memory::{self, BoucWen};
use crate::operator::Operator;
use crate::rated::{self, Smoothed};
use crate::span::Memory;
use crate::warmth::{Heating, Onto, Warming, Warmth};

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
            stepping(Own::<C, P, K, N>::new(component, values), dt)
        }
        /// A mode of unit gain.
        fn mode(frequency: f64, damping: f64, dt: f64) -> Result<Kernel, WrongCount> {
            own::<_, 3, 4, 2>(&MODE, [frequency, damping, 1.0], dt)
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
            Self::Factor => {
                let [factor] = exactly(p)?;
                own::<_, 2, 2, 0>(&SENSOR_SCALE, [factor, 0.0], dt)
            }
            Self::Offset => {
                let [offset] = exactly(p)?;
                own::<_, 2, 2, 0>(&SENSOR_SCALE, [1.0, offset], dt)
            }
            Self::Delay => exactly(p).map(|[time]| Kernel::new(Delay { time }, dt)),
            Self::Rounding { half } => {
                let [steps, phase] = exactly(p)?;
                own::<_, 2, 2, 0>(&SENSOR_QUANTISATION, [2.0 * half / steps, phase], dt)
            }
            Self::MissingCodes { half, every, missing } => {
                exactly(p).map(|p| map::missing_codes(*half, *every, *missing, p))
            }
            Self::Lag { order } => exactly(p).map(|[bandwidth]| {
                let lag: Own<_, 1, 1, 1> = Own::new(&SensorLag, [bandwidth]);
                Kernel::new(Series(vec![lag; *order]), dt)
            }),
            Self::SecondOrder => {
                let [frequency, damping] = exactly(p)?;
                mode(frequency, damping, dt)
            }
            Self::BeforeMode { frequency, damping } => {
                let [] = exactly(p)?;
                stepping(BeforeMode::new(*frequency, *damping), dt)
            }
            Self::Mode { frequency, damping } => {
                let [] = exactly(p)?;
                mode(*frequency, *damping, dt)
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
                let gain = 1.0 + gain;
                let scale: Own<_, 2, 2, 0> = Own::new(&SENSOR_SCALE, [gain, 0.0]);
                let ageing: Own<_, 2, 2, 0> = Own::new(&ActuatorAgeing, [-growth / gain, 0.1]);
                stepping(Behind(scale, ageing), dt)
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
                let (creep, elements) = Creep::of(self.elements(p)?.unwrap_or_default());
                banked(creep, elements, dt)
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
                // 1 − g + g·M is a pair of poles over a pair of zeros with the static gain 1.
                if gain < 1.0 {
                    let root = (1.0 - gain).sqrt();
                    let values = [frequency, damping, frequency / root, damping * root];
                    return own::<_, 4, 5, 2>(&CollocatedMode, values, dt);
                }
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
}
