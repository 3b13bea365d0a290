//! The feedback of one axis.

use core::f64::consts::TAU;

use crate::linearised::lead_of;
use crate::loop_shape::{Limits, Response, Shape, Shaped, shape};

/// Relative shifts of the modes' frequencies for which the loop keeps its margins.
pub(crate) const SHIFTS: [f64; 3] = [1.0, 0.9, 1.1];
/// Time constants of the derivative's filter that are tried, over that of the lowest mode.
const FILTERS: [f64; 4] = [0.0, 0.05, 0.15, 0.4];
/// Frequencies of the zeros of a PID that damps a mode, relative to the mode's.
const ZERO_FREQUENCIES: [f64; 7] = [0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8];
/// Damping ratios of these zeros.
const ZERO_DAMPINGS: [f64; 5] = [0.5, 0.7, 1.0, 1.5, 2.5];
/// Proportional parts that are tried, in parts of the mean lag behind the first sample.
const CANCELLED: [f64; 4] = [1.0, 0.7, 0.5, 0.3];
/// Parts of a PID against lags that are tried: of the mean lag, and of the square of that.
const ZEROS: ([f64; 4], [f64; 3]) = ([0.7, 1.0, 1.4, 2.0], [0.15, 0.3, 0.5]);
/// Proportional parts that are tried on a learned linear part, in samples of lag.
const PROPORTIONAL: [f64; 8] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// The law that acts on the error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Feedback {
    /// PID in positional form.
    #[default]
    Pid,
    /// PID in incremental form, without a filter of the derivative.
    IncrementalPid,
    /// Without a derivative.
    Pi,
    /// The integral alone.
    Integral,
    /// None: the feedforward alone, within the command's limits.
    None,
}

impl Feedback {
    /// All kinds of feedback.
    pub const ALL: [Self; 5] =
        [Self::Pid, Self::IncrementalPid, Self::Pi, Self::Integral, Self::None];

    /// The feedback's name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pid => "pid",
            Self::IncrementalPid => "incremental-pid",
            Self::Pi => "pi",
            Self::Integral => "integral",
            Self::None => "none",
        }
    }

    /// One sentence.
    #[must_use]
    pub const fn summary(self) -> &'static str {
        match self {
            Self::Pid => "PID in positional form",
            Self::IncrementalPid => "PID in incremental form, without a filter of the derivative",
            Self::Pi => "PI",
            Self::Integral => "the integral alone",
            Self::None => "the feedforward alone, within the command's limits",
        }
    }
}

/// When a command acts that the law has computed from a reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CommandActs {
    /// Not known: the margins hold for both.
    #[default]
    Either,
    /// In the period of the reading, as on the bench and where the controller is stepped before the plant.
    AtOnce,
    /// One period later, as in masters that exchange signals once per period and where computing takes one.
    NextPeriod,
}

impl CommandActs {
    /// All assumptions about when a command acts.
    pub const ALL: [Self; 3] = [Self::Either, Self::AtOnce, Self::NextPeriod];

    /// For each of the times that are meant, whether it is a period later.
    pub(crate) const fn later(self) -> &'static [bool] {
        match self {
            Self::Either => &[true, false],
            Self::AtOnce => &[false],
            Self::NextPeriod => &[true],
        }
    }

    /// The command acts' name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Either => "either",
            Self::AtOnce => "at-once",
            Self::NextPeriod => "next-period",
        }
    }

    /// One sentence.
    #[must_use]
    pub const fn summary(self) -> &'static str {
        match self {
            Self::Either => "the loop keeps its margins in both cases",
            Self::AtOnce => {
                "in the period of the reading, as on the bench and in `simulate --loop`"
            }
            Self::NextPeriod => "one period later, as in masters that step all FMUs at once",
        }
    }
}

/// The linear part that a loop is closed around.
pub(crate) struct Linear<'a> {
    /// Impulse responses with the modes at their frequencies and shifted, the first as given.
    pub(crate) impulses: &'a [Vec<f64>],
    /// Modes in Hz with their damping.
    pub(crate) modes: &'a [(f64, f64)],
    pub(crate) slope: f64,
    /// Whether it was learned.
    pub(crate) is_learned: bool,
    pub(crate) period: f64,
}

/// The loop with the largest integral gain that keeps the limits wherever the command may act.
pub(crate) fn design(
    linear: &Linear<'_>,
    law: Feedback,
    acts: CommandActs,
    limits: Limits,
) -> Option<Shaped> {
    let period = linear.period;
    let mut variants = Vec::new();
    for (impulse, shift) in linear.impulses.iter().zip(SHIFTS) {
        let modes: Vec<f64> = linear.modes.iter().map(|(f, _)| f * shift).collect();
        variants.push(Response::new(impulse, period, &modes));
    }
    let at_once: Vec<Response> = variants.iter().map(Response::at_once).collect();
    match acts {
        CommandActs::Either => variants.extend(at_once),
        CommandActs::AtOnce => variants = at_once,
        CommandActs::NextPeriod => {}
    }
    let allowed = |shape: &Shape| match law {
        Feedback::Pid | Feedback::None => true,
        Feedback::IncrementalPid => shape.filter == 0.0,
        Feedback::Pi => shape.b == 0.0,
        Feedback::Integral => shape.a == 0.0 && shape.b == 0.0,
    };
    let loops = shapes(linear)
        .into_iter()
        .filter(allowed)
        .filter_map(|s| shape(&variants, s, linear.slope, limits));
    loops.max_by(|a, b| a.ki.abs().total_cmp(&b.ki.abs()))
}

/// The shapes that suit the axis.
fn shapes(linear: &Linear<'_>) -> Vec<Shape> {
    let period = linear.period;
    let omega = |frequency: f64| TAU * frequency;
    let lag = linear.impulses.first().map_or(0.0, |h| lead_of(h, period).0 - period);
    let mut shapes = vec![Shape { name: "integral", a: 0.0, b: 0.0, filter: 0.0 }];
    if lag > 0.0 {
        let name = "integral, with the lags cancelled";
        let tried = CANCELLED.map(|part| Shape { name, a: part * lag, b: 0.0, filter: 0.0 });
        shapes.extend(tried);
    }
    if lag > 0.0 {
        let name = "PID, with the lags cancelled";
        for a in ZEROS.0.map(|part| part * lag) {
            for b in ZEROS.1.map(|part| part * a * a) {
                for filter in [0.0, 2.0 * period] {
                    shapes.push(Shape { name, a, b, filter });
                }
            }
        }
    }
    if linear.is_learned {
        // The lag that a discrete linear part stands for is tried.
        let name = "integral and proportional";
        let tried =
            PROPORTIONAL.map(|samples| Shape { name, a: samples * period, b: 0.0, filter: 0.0 });
        shapes.extend(tried);
    }
    let lowest = linear.modes.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((frequency, damping)) = lowest {
        let omega = omega(*frequency);
        let second_order = |name, omega: f64, damping: f64, filter| Shape {
            name,
            a: 2.0 * damping / omega,
            b: 1.0 / (omega * omega),
            filter,
        };
        for filter in FILTERS.map(|relative| relative / omega) {
            shapes.push(second_order("PID that inverts the lowest mode", omega, *damping, filter));
            for (relative, damping) in ZERO_FREQUENCIES.into_iter().flat_map(with_dampings) {
                let name = "PID that damps the lowest mode";
                shapes.push(second_order(name, relative * omega, damping, filter));
            }
        }
    }
    shapes
}

fn with_dampings(frequency: f64) -> impl Iterator<Item = (f64, f64)> {
    ZERO_DAMPINGS.into_iter().map(move |damping| (frequency, damping))
}
