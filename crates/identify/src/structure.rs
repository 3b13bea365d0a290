//! What a model consists of, in words; and whether an axis has the sign that models take.

use data::ComponentBlueprint;

use crate::error::{Error, Problem};
use crate::fit::coordinates::Structure;
use crate::fit::residual::mean;
use crate::fit::response::LinearPart;
use crate::methods::{Chain, LINEAR, Method};
use crate::record::Record;
use crate::settings::Plan;

/// Correlation of input and output below which the output is taken to fall where the input rises.
const CLEARLY_NEGATIVE: f64 = -0.3;

/// The structure of a model that one method and these linear parts make.
pub(crate) fn name_of(method: &dyn Method, structure: Structure) -> String {
    let parts = [
        Some("delay"),
        structure.lag.then_some("amplifier-lag"),
        Some(method.name()),
        structure.mode.then_some("mode"),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// The components of a model, in order; a hysteresis that one component offers in several forms by the
/// name of its method.
pub(crate) fn describe(method: &str, chain: &Chain, linear: &LinearPart) -> String {
    let kinds = |parts: &[ComponentBlueprint]| {
        parts.iter().map(|part| part.kind.clone()).collect::<Vec<_>>()
    };
    let mut all = Vec::new();
    // A straight line that is there to compare with has none.
    if linear.delay > 0.0 || method != LINEAR {
        all.push("delay".to_owned());
    }
    all.extend(linear.bandwidth.map(|_| "amplifier-lag".to_owned()));
    match &chain.hysteresis[..] {
        [one] if method.starts_with(&one.kind) => all.push(method.to_owned()),
        several => all.extend(kinds(several)),
    }
    all.extend(linear.mode.map(|_| "mode".to_owned()));
    all.extend(kinds(&chain.reading));
    all.join(", ")
}

/// A log whose output falls where its input rises is kept apart from one that cannot be fitted.
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
