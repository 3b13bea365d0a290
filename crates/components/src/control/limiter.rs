//! What control laws share behind their sum: limits, enabling, and the parameters of both.

use model::{Input, Quantity, Source, Violation};

use crate::hysteresis::play::between;
use crate::rules::{WRONG_LENGTH, require};

/// The input that closes the loop; the output at rest depends on it.
pub(super) const ENABLE: Input =
    Input { name: "enable", source: Source::System("enable"), at_rest: true };

pub(super) const OUTPUT_MIN: Quantity =
    Quantity::new("output_min", "{command}", "Least command").a_command().tunable();
pub(super) const OUTPUT_MAX: Quantity =
    Quantity::new("output_max", "{command}", "Greatest command").a_command().tunable();
pub(super) const KFF: Quantity =
    Quantity::new("feedforward_gain", "1", "Share of the feedforward that is added")
        .start(1.0)
        .tunable();
pub(super) const RATE_MAX: Quantity =
    Quantity::new("rate_max", "{command}/s", "Greatest rate of the command, 0 for no limit")
        .start(0.0)
        .min(0.0)
        .tunable();
pub(super) const HOLD: Quantity = Quantity::new(
    "hold",
    "1",
    "While disabled: 1 holds the last command, 0 ramps to the safe command at the rate limit",
)
.start(1.0)
.min(0.0)
.max(1.0)
.tunable();
pub(super) const SAFE: Quantity =
    Quantity::new("safe", "{command}", "Command while disabled, if hold is 0").start(0.0).tunable();

/// Limits of the command, and what it is while the loop is open.
#[derive(Clone, Copy)]
pub(super) struct Limiter {
    low: f64,
    high: f64,
    /// Most that the command may change in one period.
    step: f64,
    hold: f64,
    safe: f64,
}

impl Limiter {
    /// Number of coefficients.
    pub(super) const COEFFICIENTS: usize = 5;

    /// From output_min, output_max, rate_max, hold and safe.
    pub(super) fn prepare(
        [low, high, rate, hold, safe]: [f64; 5],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        require(
            low < high,
            "output_min",
            low,
            "must be below output_max; set both before the next step",
        )?;
        let all = <&mut [f64; 5]>::try_from(coefficients).map_err(|_| WRONG_LENGTH)?;
        let step = if rate > 0.0 { rate * period } else { f64::INFINITY };
        *all = [low, high, step, hold, safe];
        Ok(())
    }

    #[inline]
    pub(super) fn of(coefficients: &[f64]) -> Option<Self> {
        let &[low, high, step, hold, safe] = coefficients else { return None };
        Some(Self { low, high, step, hold, safe })
    }

    /// Within the limits, without a rate.
    #[inline]
    pub(super) fn within(&self, free: f64) -> f64 {
        between(self.low, self.high, free)
    }

    /// The command for `free`, one period after `last`.
    #[inline]
    pub(super) fn limit(&self, free: f64, last: f64) -> f64 {
        let wanted = self.within(free);
        // The last command itself stays, so that a limit that was moved acts at once.
        self.within(between(last - self.step, last + self.step, wanted))
    }

    /// The command while disabled, one period after `last`.
    #[inline]
    pub(super) fn open(&self, last: f64) -> f64 {
        self.limit(if self.hold == 0.0 { self.safe } else { last }, last)
    }

    /// The command at rest.
    pub(super) fn rest(&self, free: f64, enable: f64) -> f64 {
        self.within(if enable == 0.0 && self.hold == 0.0 { self.safe } else { free })
    }
}

/// A truth value as a number.
pub(super) fn truth(value: bool) -> f64 {
    f64::from(u8::from(value))
}
