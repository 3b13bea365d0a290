//! Linear effects: delay, lags, modes, creep, gains, feed-through.

use components::amplifier::slewed;
use components::creep::{KelvinVoigtCreep, crept};
use components::linear::{SecondOrder, Transition, approach, lag_fraction};
use libm::{log10, pow};

use crate::kernel::{Bank, Law, Signals, Step, Stepped, Wires};
use crate::state::{State, past};

/// `x(t − T)`, straight lines between the steps. State: what is not older than T.
#[derive(Clone)]
pub(crate) struct Delay {
    /// T in s.
    pub(crate) time: f64,
}

impl Law for Delay {
    fn set_step(&mut self, _dt: f64) {}

    fn rest(&self, w: Wires, state: &mut State) -> f64 {
        state.past.push_back((0.0, w.x));
        w.x
    }

    fn step(&self, w: Wires, t: f64, state: &mut State) -> f64 {
        state.past.push_back((t, w.x));
        past(t - self.time, state)
    }

    // As above, with a place in the signal in the place of the queue.
    fn run(&self, signals: Signals<'_>, dt: f64, out: &mut [f64]) {
        let x = signals.x;
        let (mut t, mut oldest, mut at) = (0.0, 0.0, 0);
        for (n, y) in out.iter_mut().enumerate().take(x.len()) {
            if n > 0 {
                t += dt;
            }
            let time = t - self.time;
            while at < n && oldest + dt <= time {
                (at, oldest) = (at + 1, oldest + dt);
            }
            *y = if at < n && time > oldest {
                x[at] + (time - oldest) / ((oldest + dt) - oldest) * (x[at + 1] - x[at])
            } else {
                x[at]
            };
        }
    }

    fn states(&self) -> usize {
        0
    }

    fn has_past(&self) -> bool {
        true
    }

    fn boxed(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}

/// A mode of unit gain beside others of a path. State: position, and rate over the natural frequency.
#[derive(Clone)]
pub(crate) struct Mode {
    frequency: f64,
    damping: f64,
    law: SecondOrder,
}

impl Mode {
    /// Of a natural frequency in Hz and a damping ratio.
    pub(crate) fn new(frequency: f64, damping: f64) -> Self {
        Self { frequency, damping, law: SecondOrder::of([1.0, 0.0, 1.0, 1.0]) }
    }

    fn set_step(&mut self, dt: f64) {
        self.law = SecondOrder::new(self.frequency, self.damping, 1.0, dt);
    }
}

/// What must have been held at the input of a mode of unit gain over a step, for its position to be x now. State:
/// as that of the mode.
#[derive(Clone)]
pub(crate) struct BeforeMode {
    pub(crate) frequency: f64,
    pub(crate) damping: f64,
    pub(crate) transition: Transition,
}

impl BeforeMode {
    pub(crate) fn new(frequency: f64, damping: f64) -> Self {
        Self { frequency, damping, transition: Transition { same: 1.0, cross: 0.0, rate: 1.0 } }
    }
}

impl Step<2> for BeforeMode {
    fn set_step(&mut self, dt: f64) {
        self.transition = Transition::new(self.frequency, self.damping, dt);
    }

    fn rest(&self, w: Wires) -> ([f64; 2], f64) {
        ([w.x, 0.0], w.x)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [position, rate]: &mut [f64; 2]) -> f64 {
        // x = u + same·(position − u) + cross·rate.
        let Transition { same, cross, .. } = self.transition;
        let free = 1.0 - same;
        if free == 0.0 {
            return w.x;
        }
        let u = (w.x - same * *position - cross * *rate) / free;
        let (_, r) = self.transition.apply(*position - u, *rate);
        (*position, *rate) = (w.x, r);
        u
    }
}

/// `x + g·(M[x] − x)` with a mode M of unit gain.
#[derive(Clone)]
pub(crate) struct ParallelMode {
    pub(crate) gain: f64,
    pub(crate) mode: Mode,
}

impl Step<2> for ParallelMode {
    fn set_step(&mut self, dt: f64) {
        self.mode.set_step(dt);
    }

    fn rest(&self, w: Wires) -> ([f64; 2], f64) {
        ([w.x, 0.0], w.x)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, z: &mut [f64; 2]) -> f64 {
        w.x + self.gain * (self.mode.law.step(w.x, z) - w.x)
    }
}

/// `x + Σ share·lag(x)`: the component `kelvin-voigt-creep`.
#[derive(Clone)]
pub(crate) struct Creep {
    structure: [f64; 1],
    parameters: Vec<f64>,
}

impl Creep {
    /// Of the share and time constant of each element; with the elements, shortest time first, as the component has them.
    pub(crate) fn of(mut all: Vec<(f64, f64)>) -> (Self, Vec<Element>) {
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (shares, times): (Vec<f64>, Vec<f64>) = all.iter().copied().unzip();
        let creep = Self { structure: [all.len() as f64], parameters: [shares, times].concat() };
        (
            creep,
            all.into_iter().map(|(share, time)| Element { share, time, fraction: 0.0 }).collect(),
        )
    }
}

/// An element of creep.
#[derive(Clone, Copy)]
pub(crate) struct Element {
    share: f64,
    /// Time constant in s.
    time: f64,
    fraction: f64,
}

impl Bank<0, 1> for Creep {
    type Element = Element;
    type Shared = f64;

    fn set_step(&mut self, dt: f64, elements: &mut [Element]) {
        elements.iter_mut().for_each(|e| e.fraction = approach(e.time, dt));
    }

    fn rest(&self, w: Wires) -> ([f64; 0], [f64; 1]) {
        ([], [w.x])
    }

    #[inline]
    fn shared(&self, w: Wires, _: &[f64; 0]) -> f64 {
        w.x
    }

    #[inline]
    fn add(element: &Element, x: f64, [z]: &mut [f64; 1]) -> f64 {
        crept(x, (element.share, element.fraction), z)
    }

    fn component(&self) -> Option<Stepped<'_>> {
        let Self { structure, parameters } = self;
        Some(Stepped { component: &KelvinVoigtCreep, structure, parameters })
    }
}

/// Elements of creep with the same growth in each decade: share and time of two per decade.
pub(crate) fn log_creep(longest: f64, [gain, shortest]: [f64; 2]) -> Vec<(f64, f64)> {
    grid(shortest, longest.max(3.0 * shortest)).map(|time| (0.5 * gain, time)).collect()
}

/// Elements of creep whose growth per decade goes with a power of the time.
pub(crate) fn power_creep(
    shortest: f64,
    longest: f64,
    [gain, exponent]: [f64; 2],
) -> Vec<(f64, f64)> {
    let middle = (shortest * longest).sqrt();
    let share = |time: f64| 0.5 * gain * pow(time / middle, exponent);
    grid(shortest, longest).map(|time| (share(time), time)).collect()
}

/// Two elements per decade.
fn grid(shortest: f64, longest: f64) -> impl Iterator<Item = f64> {
    let decades = log10(longest / shortest).max(0.5);
    // All times that a number can be are 632 decades.
    let count = (2.0 * decades).round().clamp(1.0, 1300.0);
    (0..count as usize).map(move |i| shortest * pow(10.0, decades * (i as f64 + 0.5) / count))
}

/// Slope limits down and up in the path's unit per second. State: the output.
#[derive(Clone)]
pub(crate) struct UnevenSlew {
    pub(crate) rates: [f64; 2],
    /// Greatest ways in a step.
    pub(crate) ways: [f64; 2],
}

impl Step<1> for UnevenSlew {
    fn set_step(&mut self, dt: f64) {
        self.ways = self.rates.map(|rate| rate * dt);
    }

    fn rest(&self, w: Wires) -> ([f64; 1], f64) {
        ([w.x], w.x)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [z]: &mut [f64; 1]) -> f64 {
        *z = slewed(*z, w.x, self.ways);
        *z
    }
}

/// First-order approach whose slope goes softly into a limit. State: the output.
#[derive(Clone)]
pub(crate) struct SoftSlew {
    pub(crate) rate: f64,
    /// In Hz.
    pub(crate) bandwidth: f64,
    /// Greatest way in a step, and the part of the way to the input in it.
    pub(crate) step: [f64; 2],
}

impl Step<1> for SoftSlew {
    fn set_step(&mut self, dt: f64) {
        self.step = [self.rate * dt, lag_fraction(self.bandwidth, dt)];
    }

    fn rest(&self, w: Wires) -> ([f64; 1], f64) {
        ([w.x], w.x)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [v]: &mut [f64; 1]) -> f64 {
        // z/√(1 + z²): straight at small slopes, never above the limit.
        let [most, fraction] = self.step;
        let z = if most > 0.0 { fraction * (w.x - *v) / most } else { 0.0 };
        *v += most * z / (1.0 + z * z).sqrt();
        *v
    }
}

/// `x + g·(x − rest)` about the value at rest, which is the state.
#[derive(Clone)]
pub(crate) struct Gain {
    pub(crate) gain: f64,
}

impl Step<1> for Gain {
    fn rest(&self, w: Wires) -> ([f64; 1], f64) {
        ([w.x], w.x)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [rest]: &mut [f64; 1]) -> f64 {
        w.x + self.gain * (w.x - *rest)
    }
}

/// `x + (a·(s − zero) + b·s′)/scale` of an auxiliary signal s. State: s before.
#[derive(Clone)]
pub(crate) struct Auxiliary {
    pub(crate) value: f64,
    /// In s.
    pub(crate) rate: f64,
    pub(crate) zero: f64,
    pub(crate) scale: f64,
    pub(crate) dt: f64,
}

impl Auxiliary {
    #[inline]
    fn at(&self, w: Wires, slope: f64) -> f64 {
        w.x + (self.value * (w.aux - self.zero) + self.rate * slope) / self.scale
    }
}

impl Step<1> for Auxiliary {
    fn set_step(&mut self, dt: f64) {
        self.dt = dt;
    }

    fn rest(&self, w: Wires) -> ([f64; 1], f64) {
        ([w.aux], self.at(w, 0.0))
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [before]: &mut [f64; 1]) -> f64 {
        let slope = (w.aux - *before) / self.dt;
        *before = w.aux;
        self.at(w, slope)
    }
}

/// `x + a·lag(s − zero)` of an auxiliary signal s. State: the lag's output.
#[derive(Clone)]
pub(crate) struct LaggedAuxiliary {
    pub(crate) weight: f64,
    /// In Hz.
    pub(crate) bandwidth: f64,
    pub(crate) zero: f64,
    pub(crate) fraction: f64,
}

impl Step<1> for LaggedAuxiliary {
    fn set_step(&mut self, dt: f64) {
        self.fraction = lag_fraction(self.bandwidth, dt);
    }

    fn rest(&self, w: Wires) -> ([f64; 1], f64) {
        let z = w.aux - self.zero;
        ([z], w.x + self.weight * z)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [z]: &mut [f64; 1]) -> f64 {
        *z += self.fraction * (w.aux - self.zero - *z);
        w.x + self.weight * *z
    }
}

/// `x + a·M[s − zero]` of an auxiliary signal s, with a mode M of unit gain.
#[derive(Clone)]
pub(crate) struct ModalAuxiliary {
    pub(crate) weight: f64,
    pub(crate) mode: Mode,
    pub(crate) zero: f64,
}

impl Step<2> for ModalAuxiliary {
    fn set_step(&mut self, dt: f64) {
        self.mode.set_step(dt);
    }

    fn rest(&self, w: Wires) -> ([f64; 2], f64) {
        let z = w.aux - self.zero;
        ([z, 0.0], w.x + self.weight * z)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, z: &mut [f64; 2]) -> f64 {
        w.x + self.weight * self.mode.law.step(w.aux - self.zero, z)
    }
}

/// The time constant in s of a first-order lag that goes this part of the way in each step.
#[must_use]
pub fn time_of(part: f64, dt: f64) -> f64 {
    -dt / libm::log1p(-part)
}
