//! What a model consists of, in words; and whether an axis has the sign that models take.

use data::ComponentBlueprint;

use crate::error::{Error, Problem};
use crate::fit::linear_part::Structure;
use crate::fit::response::LinearPart;
use crate::fit::weights::mean;
use crate::plant::Actuator;
use crate::record::Record;
use crate::settings::Plan;

/// Correlation of input and output below which the output is taken to fall where the input rises.
const CLEARLY_NEGATIVE: f64 = -0.3;

/// The structure of a static model with these linear parts.
pub(crate) fn name_of(structure: Structure) -> &'static str {
    match (structure.lag, structure.mode) {
        (true, false) => "delay, amplifier-lag, prandtl-ishlinskii",
        (false, true) => "delay, prandtl-ishlinskii, mode",
        (true, true) => "delay, amplifier-lag, prandtl-ishlinskii, mode",
        (false, false) => "delay, prandtl-ishlinskii",
    }
}

/// The components of a model, in order; a hysteresis that one component offers in several forms by the
/// name of its method.
pub(crate) fn describe(
    method: Option<&'static str>,
    actuator: &Actuator<'_>,
    linear: &LinearPart,
) -> String {
    let parts = match actuator {
        Actuator::Linear { .. } => {
            let parts = [
                (linear.delay > 0.0).then_some("delay"),
                linear.bandwidth.map(|_| "amplifier-lag"),
                Some("actuator-gain"),
                linear.mode.map(|_| "mode"),
            ];
            return parts.into_iter().flatten().collect::<Vec<_>>().join(", ");
        }
        Actuator::Plays { .. } => {
            let structure =
                Structure { lag: linear.bandwidth.is_some(), mode: linear.mode.is_some() };
            return name_of(structure).to_owned();
        }
        Actuator::Chain(parts) => parts,
    };
    let kinds = |parts: &[ComponentBlueprint]| {
        parts.iter().map(|part| part.kind.clone()).collect::<Vec<_>>()
    };
    let mut all = vec!["delay".to_owned()];
    all.extend(linear.bandwidth.map(|_| "amplifier-lag".to_owned()));
    match (method, &parts.hysteresis[..]) {
        (Some(method), [one]) if method.starts_with(&one.kind) => all.push(method.to_owned()),
        (_, several) => all.extend(kinds(several)),
    }
    all.extend(linear.mode.map(|_| "mode".to_owned()));
    all.extend(kinds(&parts.reading));
    all.join(", ")
}

/// A log whose output falls where its input rises is told apart from one that cannot be fitted.
pub(crate) fn check_sign(records: &[Record], plan: &Plan) -> Result<(), Error> {
    for (record, rows) in records.iter().zip(&plan.fitted) {
        let input = rows.of(record.input());
        let output = rows.of(record.output());
        let (u_mean, y_mean) = (mean(input), mean(output));
        // The output at a row belongs to the input of the row before.
        let pairs =
            || input.iter().zip(output.iter().skip(1)).map(|(u, y)| (u - u_mean, y - y_mean));
        let cross: f64 = pairs().map(|(u, y)| u * y).sum();
        let (uu, yy) = pairs().fold((0.0, 0.0), |(uu, yy), (u, y)| (uu + u * u, yy + y * y));
        if cross < CLEARLY_NEGATIVE * (uu * yy).sqrt() {
            return Err(Error::NegativeGain {
                record: record.name().to_owned(),
                input: record.input_name().to_owned(),
                output: record.output_name().to_owned(),
                gain: cross / uu,
            });
        }
    }
    if plan.half_range > 0.0 { Ok(()) } else { Err(Error::Unsuitable(vec![Problem::NoRecord])) }
}
