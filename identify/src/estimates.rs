//! What the data say about each fitted parameter.

use data::AxisBlueprint;
use model::unit_on_axis;

use crate::fit::delay::Delay;
use crate::fit::linear_part::Deviations;
use crate::fit::weights::{Fitted, independent_samples};
use crate::identification::{Estimate, Verdict};
use crate::settings::Plan;

/// Relative standard deviation from which a parameter is uncertain.
const UNCERTAIN: f64 = 0.5;

/// The estimates of a plant with plays. `independent` is the number of independent residuals.
pub(crate) fn of(
    plan: &Plan,
    axis: &AxisBlueprint,
    fitted: &Fitted,
    delay: Delay,
    deviations: Deviations,
    independent: f64,
) -> Vec<Estimate> {
    let at_bound = delay.value <= 0.0 || delay.value >= plan.longest_delay;
    let mut all = vec![estimate("delay.delay", delay.value, "s", Some(delay.deviation), at_bound)];
    if let Some(bandwidth) = fitted.linear.bandwidth {
        let deviation = deviations.bandwidth;
        all.push(estimate("amplifier.bandwidth", bandwidth, "Hz", deviation, deviation.is_none()));
    }
    if let Some(mode) = fitted.linear.mode {
        let (frequency, damping) = (deviations.frequency, deviations.damping);
        all.push(estimate("mode.frequency", mode.frequency, "Hz", frequency, frequency.is_none()));
        all.push(estimate("mode.damping", mode.damping, "1", damping, damping.is_none()));
    }
    let unit = unit_on_axis("{position}/{command}", &axis.command.unit, &axis.position.unit);
    let noise = noise(fitted, independent);
    for (index, (&weight, variance)) in fitted.weights.iter().zip(&fitted.variance).enumerate() {
        let deviation = variance.map(|v| (v * noise).sqrt());
        let name = format!("hysteresis.w[{}]", index + 1);
        let mut weight = estimate(&name, weight, &unit, deviation, deviation.is_none());
        if plan.thresholds.get(index).is_some_and(|r| *r >= plan.half_range) {
            weight.verdict = Verdict::NotExcited;
        }
        all.push(weight);
    }
    all
}

/// Root mean square of the weights' deviations over that of the weights; `None` where the weights
/// are known one by one too little for a tolerance (neighbouring plays replace each other).
pub(crate) fn relative_deviation(fitted: &Fitted) -> Option<f64> {
    let noise = noise(fitted, independent_samples(&fitted.residual));
    let spread: f64 = fitted.variance.iter().flatten().map(|v| v * noise).sum();
    let size: f64 = fitted.weights.iter().map(|w| w * w).sum();
    let relative = (spread / size).sqrt();
    (relative > 0.0 && relative < UNCERTAIN).then_some(relative)
}

/// Variance of the residual over what one sample of it is worth.
fn noise(fitted: &Fitted, independent: f64) -> f64 {
    let unknowns = fitted.variance.iter().flatten().count() as f64;
    fitted.sum_of_squares / (independent - unknowns).max(1.0)
}

fn estimate(
    name: &str,
    value: f64,
    unit: &str,
    deviation: Option<f64>,
    at_bound: bool,
) -> Estimate {
    let deviation = deviation.filter(|d| d.is_finite());
    let verdict = match deviation {
        _ if at_bound => Verdict::AtBound,
        Some(deviation) if deviation < UNCERTAIN * value.abs() => Verdict::Determined,
        _ => Verdict::Uncertain,
    };
    Estimate { name: name.to_owned(), value, unit: unit.to_owned(), deviation, verdict }
}
