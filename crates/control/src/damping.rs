//! Control beyond the first resonance: a damping law in an inner loop and a PID law around it, designed together.
//!
//! With the machine G(z) (hold, delays and all), the tracking law C(z) and the damping law D(z) in positive feedback,
//!
//! ```text
//! L = (C − D)·G,   S = 1/(1 + L),   T = C·G/(1 + L)   (reference to position, without feedforward)
//! C = kp + ki·T/(1 − z⁻¹) + kd·(1 − z⁻¹)/T·(1 − f)/(1 − f·z⁻¹)
//! D = gain·F(z),   F as in the components, F(1) = 1
//! ```
//!
//! Of all laws with
//!
//! ```text
//! stable loop and |S| ≤ M            for each plant of the grid
//! |G·S| ≤ 4·G(1)                     the same: the resonance is damped, and not hidden behind a zero of the law
//! gain·G(1) ≤ 0.9, 1 − D·G stable    the inner loop is stable alone (negative imaginary systems: gain·G(1) < 1)
//! noise from sensor to command ≤ its limit
//! ```
//!
//! the one is taken that settles first (2 % of a step, mean over the slopes) among those whose |T| stays within 3 dB up
//! to 1.15 times the resonance, or, where there is none of these, the one whose |T| does so the furthest. The grid: the
//! modes' frequencies 10 and 5 % lower and higher, their damping halved and doubled, the slope of the hysteresis least,
//! mean and steepest, the command acting at once and one period later. A loop is stable where the curve of
//! (1 − z⁻¹)(1 + L) on the upper half of the unit circle does not go round zero (L is stable but for its integrator).
//! The search is differential evolution over the logarithms of all gains, the same at every run.
//!
//! Sources: as of the component; R. Storn, K. Price, Journal of Global Optimization 11 (1997) 341–359 (the search).

mod figures;
mod gains;
mod laws;
mod plants;

use core::f64::consts::TAU;

use data::ComponentBlueprint;
use serde::Serialize;

pub use self::laws::Damping;
use self::plants::{Plants, UNFIT};
use crate::design::CommandActs;
use crate::linearised::LIGHT;
use crate::loop_shape::{Limits, Shaped};

/// Factors of the modes' frequencies and dampings that the loop is made for; the first are the plant as given.
const FREQUENCIES: [f64; 5] = [1.0, 0.9, 0.95, 1.05, 1.1];
pub(crate) const DAMPINGS: [f64; 3] = [1.0, 0.5, 2.0];
/// The bandwidth that is wanted, over the resonance.
const BEYOND: f64 = 1.15;
/// The factors of each plant of the grid, the plant as given first.
pub(crate) fn grid() -> impl Iterator<Item = (f64, f64)> {
    FREQUENCIES.iter().flat_map(|frequency| DAMPINGS.iter().map(move |d| (*frequency, *d)))
}

/// Slopes over the steepest that the loop is made for: mean, least, steepest.
pub(crate) fn slopes(steepest: f64, least: f64) -> [f64; 3] {
    let share = (least / steepest).clamp(0.2, 1.0);
    [0.5 * (share + 1.0), share, 1.0]
}

/// What is known of a loop with a damped resonance. All of it is computed with the feedback alone on the linear parts,
/// but for `with_feedforward`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DampingFigures {
    /// Name of the law, see [`Damping::name`].
    pub law: &'static str,
    /// Gain of the inner loop in command per position; 0 for a notch.
    pub gain: f64,
    /// Frequency of its filter in Hz.
    pub frequency: f64,
    /// Damping ratio of its filter, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter_damping: Option<f64>,
    /// The first resonance in Hz.
    pub resonance: f64,
    /// Up to where |T| stays within 3 dB, in Hz: plant as given, mean slope, the later of the commands.
    pub closed_loop_bandwidth: f64,
    /// The least of these over all plants of the grid.
    pub least_closed_loop_bandwidth: f64,
    /// The least bandwidth from reference to position with the inverse feedforward, in Hz, on the plant as given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bandwidth_with_feedforward: Option<f64>,
    /// Time in s after which a step stays within 2 %: plant as given, mean slope.
    pub settling: f64,
    /// The longest of these over the slopes of the hysteresis.
    pub longest_settling: f64,
    /// Settling times of PI with a notch that keeps the same limits on the same plants.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub notch_settling: Option<(f64, f64)>,
    /// Greatest response to a disturbance of the command, |G·S|, over that at rest at the steepest slope, all plants.
    pub peak: f64,
    /// Greatest response to a disturbance of the command without control, over that at rest.
    pub undamped_peak: f64,
    /// Standard deviation of the command, as a position, per standard deviation of white sensor noise.
    pub noise: f64,
    /// Number of plants that the loop is stable on and keeps its sensitivity.
    pub plants: usize,
}

/// Lag and inertia of two leads one behind the other, that of the lightly damped first mode, and of the rest of what
/// is to be made up for: `lag` and `inertia` of both. So the third order of their product is made up for as well.
pub(crate) fn leads((lag, inertia): (f64, f64), modes: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let light = modes.iter().filter(|(_, damping)| *damping < LIGHT);
    let Some((frequency, damping)) = light.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return vec![(lag.max(0.0), inertia.max(0.0))];
    };
    let omega = TAU * frequency;
    let own = (2.0 * damping / omega, 1.0 / (omega * omega));
    let rest = lag - own.0;
    let left = inertia - own.1 - rest * own.0;
    vec![own, (rest.max(0.0), left.max(0.0))]
}

/// A damped loop.
#[derive(Clone, Debug)]
pub(crate) struct Damped {
    pub(crate) law: Damping,
    pub(crate) shaped: Shaped,
    pub(crate) figures: DampingFigures,
    depth: f64,
}

impl Damped {
    /// That the loop does not reach beyond the resonance, where it does not.
    pub(crate) fn shortfall(&self) -> Option<String> {
        let figures = &self.figures;
        let reached = figures.closed_loop_bandwidth / figures.resonance;
        (self.law != Damping::Notch && reached < BEYOND).then(|| {
            format!(
                "the closed loop stays within 3 dB up to {reached:.2} times the resonance only; with one period of computing delay, more needs about 35 samples per oscillation and a hysteresis whose slope varies little; a shorter --period or a larger --sensitivity extends it"
            )
        })
    }

    /// The component of the law; `feedforward`: the command of an inverse comes in front of it.
    pub(crate) fn component(&self, feedforward: bool) -> ComponentBlueprint {
        let component = ComponentBlueprint::new(self.law.kind());
        let component = component.value("frequency", self.figures.frequency);
        let component = match self.figures.filter_damping {
            Some(damping) => component.value("damping", damping),
            None => component,
        };
        if self.law == Damping::Notch {
            return component.value("depth", self.depth);
        }
        let weight = if feedforward { 1.0 } else { 0.0 };
        component.value("gain", self.figures.gain).value("setpoint_weight", weight)
    }
}

/// The plant of an axis.
pub(crate) struct DampedPlant<'a> {
    /// Impulse responses at the steepest slope: for each of [`FREQUENCIES`] each of [`DAMPINGS`].
    pub(crate) impulses: &'a [Vec<f64>],
    /// Modes in Hz with their damping.
    pub(crate) modes: &'a [(f64, f64)],
    /// Steepest and least slope of the hysteresis.
    pub(crate) slopes: (f64, f64),
    /// Lag and inertia of each lead in front of the feedforward.
    pub(crate) leads: &'a [(f64, f64)],
    pub(crate) period: f64,
}

/// The damped loop of an axis.
///
/// # Errors
/// Why there is none.
pub(crate) fn damped(
    axis_plant: &DampedPlant<'_>,
    damping: Damping,
    derivative: bool,
    acts: CommandActs,
    limits: Limits,
) -> Result<Damped, String> {
    let plants = Plants::of(axis_plant, acts)?;
    let laws: &[Damping] = match damping {
        Damping::Automatic => Damping::LAWS,
        _ => std::slice::from_ref(&damping),
    };
    let found = laws.iter().map(|law| plants.search(*law, derivative, limits));
    let best = found.min_by(|a, b| a.cost.total_cmp(&b.cost)).ok_or("no damping law")?;
    if best.cost >= UNFIT {
        return Err(format!(
            "no gains of {} keep the sensitivity below {} and the noise below {} on all plants with the modes' \
             frequencies up to 10 % off and their damping halved or doubled; allow a larger --sensitivity, or take a \
             shorter --period",
            damping.name(),
            limits.sensitivity,
            limits.noise
        ));
    }
    let notch = (best.law != Damping::Notch).then(|| plants.search(Damping::Notch, false, limits));
    Ok(plants.finished(&best, notch.filter(|notch| notch.cost < UNFIT).as_ref(), axis_plant))
}
