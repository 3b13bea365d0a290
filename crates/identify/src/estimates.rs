//! What the data say about each fitted parameter.

use data::AxisBlueprint;
use model::unit_on_axis;
use numerics::least_squares::Partner;

use crate::fit::coordinates::Deviations;
use crate::fit::operator::{self, Fit, Operator, Solved};
use crate::fit::response::LinearPart;
use crate::identification::{Correlation, Estimate, Verdict};
use crate::settings::Plan;

/// Relative standard deviation from which a parameter is uncertain.
const UNCERTAIN: f64 = 0.5;

/// The estimates of a fit.
pub(crate) fn of(
    plan: &Plan,
    axis: &AxisBlueprint,
    operator: &Operator<'_>,
    fit: &Fit,
) -> Vec<Estimate> {
    let mut all = of_linear_part(plan, &fit.solved.linear, fit.deviations);
    let unit = |unit: &str| unit_on_axis(unit, &axis.command.unit, &axis.position.unit);
    let shapes = operator.method.shape(operator.scene);
    for (index, (shape, value)) in shapes.iter().zip(&fit.solved.shape).enumerate() {
        let deviation = fit.shape_deviation.get(index).copied().flatten();
        let mut one =
            estimate(&shape.name, *value, &unit(shape.unit), deviation, deviation.is_none());
        one.correlated = correlation(fit.shape_partner.get(index), |i| shapes[i].name.to_string());
        all.push(one);
    }
    let weights = operator.method.weights(operator.scene);
    let names = &weights.names;
    let noise = operator::noise(&fit.solved, shapes.len());
    for (index, (weight, (name, of))) in fit.solved.weights.iter().zip(names).enumerate() {
        let deviation = fit.solved.variance[index].map(|v| (v * noise).sqrt());
        let mut one = estimate(name, *weight, &unit(of), deviation, deviation.is_none());
        if weights.threshold(index).is_some_and(|r| r >= plan.half_range) {
            one.verdict = Verdict::NotExcited;
        }
        one.correlated = correlation(fit.solved.partner.get(index), |i| names[i].0.clone());
        all.push(one);
    }
    all
}

fn of_linear_part(plan: &Plan, linear: &LinearPart, deviations: Deviations) -> Vec<Estimate> {
    let at_bound = linear.delay <= 0.0 || linear.delay >= plan.longest_delay;
    let mut all = vec![estimate("delay.delay", linear.delay, "s", deviations.delay, at_bound)];
    if let Some(bandwidth) = linear.bandwidth {
        let deviation = deviations.bandwidth;
        all.push(estimate("amplifier.bandwidth", bandwidth, "Hz", deviation, deviation.is_none()));
    }
    if let Some(mode) = linear.mode {
        let (frequency, damping) = (deviations.frequency, deviations.damping);
        all.push(estimate("mode.frequency", mode.frequency, "Hz", frequency, frequency.is_none()));
        all.push(estimate("mode.damping", mode.damping, "1", damping, damping.is_none()));
    }
    all
}

fn correlation(
    partner: Option<&Option<Partner>>,
    name: impl Fn(usize) -> String,
) -> Option<Correlation> {
    let (index, coefficient) = (*partner?)?;
    Some(Correlation { with: name(index), coefficient })
}

/// Root mean square of the weights' deviations over that of the weights; `None` where the weights
/// are known one by one too little for a tolerance (neighbouring plays replace each other).
pub(crate) fn relative_deviation(solved: &Solved) -> Option<f64> {
    let noise = operator::noise(solved, 0);
    let spread: f64 = solved.variance.iter().flatten().map(|v| v * noise).sum();
    let size: f64 = solved.weights.iter().map(|w| w * w).sum();
    let relative = (spread / size).sqrt();
    (relative > 0.0 && relative < UNCERTAIN).then_some(relative)
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
    let (name, unit) = (name.to_owned(), unit.to_owned());
    Estimate { name, value, unit, deviation, verdict, correlated: None }
}
