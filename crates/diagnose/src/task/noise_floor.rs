//! The noise of an output before anything is fitted: stated, of a record at rest, or from the readings themselves.

use crate::data_set::DataSet;
use crate::error::Error;
use crate::gap::NoiseFloor;
use crate::noise;
use crate::port::{Port, column};
use crate::request::{Noise, Request};
use crate::steps::Steps;
use crate::thresholds::noise::Thresholds;

/// The noise of an output, in its unit.
pub(super) fn floor(
    request: &Request,
    port: &Port,
    data: &DataSet,
    steps: Option<Steps>,
) -> Result<(NoiseFloor, Option<f64>, Option<Steps>), Error> {
    let factor = port.si.factor;
    let records = || data.records.iter().map(|r| r.rows.clone());
    let second = noise::second_differences(&data.y, records()).map(|s| s / factor);
    let command: Vec<f64> = data.row_hit.iter().map(|h| data.command[*h as usize]).collect();
    let repeats = noise::Repeats::of(&command, &data.y, records());
    let periods = repeats.as_ref().and_then(noise::Repeats::sigma).map(|s| s / factor);
    let mut rest_corner = None;
    let (sigma, source) = match &request.noise {
        Noise::Given(all) => {
            let own =
                all.iter().rev().find(|(n, _)| n.as_deref().is_some_and(|name| port.is(name)));
            let found = own.or_else(|| all.iter().rev().find(|(n, _)| n.is_none()));
            (found.map(|(_, s)| *s), "given")
        }
        Noise::Rest(log) => {
            let y = column(request, port, log, "output")?;
            let records: Vec<&[f64]> = log.records().iter().map(|r| &y[r.rows.clone()]).collect();
            let sample = log.time().windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
            let found = noise::of_rest(&records, sample);
            rest_corner = found.map(|(_, corner)| corner);
            // As much of the slow part as the records of the log are long.
            let (low, high) = (1.0 / data.longest(), 0.5 / data.sample_time);
            let sigma =
                |(white, corner): (f64, f64)| white * noise::coloured(corner, low, high).sqrt();
            (found.map(sigma), "rest record")
        }
        Noise::Estimated => {
            // Where the command fills the whole band no difference of neighbours cancels it.
            let rich = |s: &f64| second.is_none_or(|second| *s < Thresholds::PERIODS_RICH * second);
            let found = periods.filter(rich);
            let shape = |r: &noise::Repeats| r.shape(data.sample_time).map(|(_, corner)| corner);
            rest_corner = found.and(repeats.as_ref()).and_then(shape);
            (found, "periods")
        }
    };
    // What was said may hold the rounding.
    let steps = steps.and_then(|steps| match sigma.filter(|_| source == "given") {
        Some(given) if factor * given > Thresholds::HOLDS_ROUNDING * steps.rounding() => None,
        Some(given) => Some(steps.with_noise(factor * given)),
        None => Some(steps),
    });
    if let Some(found) = steps {
        let sigma = found.sigma() / factor;
        let source = "steps of the reading".to_owned();
        let noise = NoiseFloor { sigma, source, second_differences: second, periods, corner: None };
        return Ok((noise, None, steps));
    }
    let (sigma, source) = match sigma.filter(|s| *s > 0.0) {
        Some(sigma) => (sigma, source),
        None => match second {
            Some(sigma) => (sigma, "second differences"),
            None => {
                return Err(Error::Log {
                    log: request.logs[0].origin().to_owned(),
                    message: format!(
                        "the noise of {} cannot be estimated (the reading hardly changes); give it with --noise SIGMA",
                        port.label()
                    ),
                });
            }
        },
    };
    let (second_differences, source) = (second, source.to_owned());
    let noise = NoiseFloor { sigma, source, second_differences, periods, corner: None };
    Ok((noise, rest_corner, None))
}
