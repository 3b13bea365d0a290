//! The linear model that is fitted to a frequency response.

use std::path::Path;

use anyhow::Context;
use data::{Blueprint, Log, SampleTime};
use diagnose::Between;
use identify::frequency::{self, FrequencyResponse as Response, PlantNames, RationalSettings};

use super::{Asked, Generated, columns_of, fitted, in_numbers};
use crate::commands::diagnose::thresholds::Thresholds;
use crate::commands::frequency_response::table::{self, Table};
use crate::commands::identify::{identifier, short_name, usual_unit};
use crate::inputs::{self, BlueprintText};
use crate::results::frequency_response::Signal;

/// The plant of a frequency response: delay and static gain of each axis, and the modes that they share.
pub(super) fn of_response(
    asked: &Asked<'_>,
    table: &Path,
    most: usize,
) -> anyhow::Result<Generated> {
    let logs = asked
        .logs
        .iter()
        .map(|path| asked.options.read_in_silence(path))
        .collect::<anyhow::Result<Vec<Log>>>()?;
    let names = asked.options.names()?;
    let column = |name: &String| names.column(name).unwrap_or(name).to_owned();
    let mut notes = Vec::new();
    let mut signals = |all: &[String], usual: &str| {
        let signal = |name: &String| {
            let name = column(name);
            let found = logs.iter().find_map(|log| log.column(&name)?.unit.clone());
            let unit = found.map_or_else(|| usual_unit(&name, usual, &mut notes), |unit| unit.text);
            Signal { name, unit: Some(unit) }
        };
        all.iter().map(signal).collect::<Vec<Signal>>()
    };
    let (inputs, outputs) = (signals(asked.inputs, "V"), signals(asked.outputs, "um"));
    let first = &logs[0];
    let record = first.records().first().context("the logs have no record")?;
    let period = first.sample_time(record, SampleTime::TOLERANCE)?.period;
    let Table { response, notes: table_notes } = table::read(table, (&inputs, &outputs), period)?;
    notes.extend(table_notes);
    let mut ranges = Vec::new();
    for input in &inputs {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for log in &logs {
            let values = inputs::column(log, &input.name, &mut input.unit.clone())?;
            range = values.iter().fold(range, |(low, high), u| (low.min(*u), high.max(*u)));
        }
        ranges.push((identifier(&input.name), input.unit().to_owned(), range));
    }
    let plant = PlantNames {
        model: "linear".to_owned(),
        description: format!(
            "Modes fitted to the frequency response {} over {} lines",
            table.display(),
            response.lines.len()
        ),
        inputs: ranges,
        outputs: outputs.iter().map(|s| (identifier(&s.name), s.unit().to_owned())).collect(),
    };
    let (mut blueprint, what, leaves) = fitted_to(&response, period, most, &plant)
        .with_context(|| format!("{}: no plant can be fitted", table.display()))?;
    notes.push(format!(
        "no --model was given; a linear one is fitted to {}: {what}; its error is {:.2} % of the response over {} lines from {} \
         to {} Hz",
        table.display(),
        100.0 * leaves,
        response.lines.len(),
        response.lines[0].frequency,
        response.lines[response.lines.len() - 1].frequency
    ));
    for (k, axis) in blueprint.axes.iter_mut().enumerate() {
        axis.command.name = short_name(&inputs[k].name, "command", k);
        axis.position.name = short_name(&outputs[k].name, "position", k);
    }
    let outputs: Vec<&str> = outputs.iter().map(|signal| signal.name.as_str()).collect();
    let baselines = in_numbers(&blueprint, &outputs)?;
    let map = columns_of(asked, &column);
    let text = BlueprintText { text: blueprint.to_toml(), blueprint };
    let readings = Between::with_reading(asked.readings.0, asked.readings.1);
    Ok(Generated { text, baselines, notes, run_in: 0.0, readings, map })
}

/// The plant of a response: modes side by side where they need fewer numbers for what they leave, and leave much less, else
/// parts in a row. With what it is in words, and the part of the response that it leaves.
fn fitted_to(
    response: &Response,
    period: f64,
    most: usize,
    names: &PlantNames,
) -> anyhow::Result<(Blueprint, String, f64)> {
    let number = |x: f64| report::format_number(x, 4);
    let left = |model: &dyn Fn(&frequency::Line) -> [f64; 2]| {
        let sums =
            response.lines.iter().map(model).fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        (sums[0] / sums[1]).sqrt()
    };
    // The parts stand behind the hold.
    let behind = response.lines.iter().map(|line| {
        let hold = frequency::hold(line.frequency, period);
        let own = line.response.iter().map(|g| g / hold).collect();
        (line.frequency, own, line.deviation.iter().map(|d| d / hold.norm()).collect())
    });
    let shape = (names.outputs.len(), names.inputs.len());
    let behind = Response::given(shape, behind.collect(), period);
    let chain = frequency::choose_chain(&behind);
    let modes = frequency::choose_held(response, period, &RationalSettings::default(), most);
    match (chain, modes) {
        (Ok(chain), modes)
            if !modes.as_ref().is_ok_and(|(_, choice)| {
                let most = Thresholds::SIDE_BY_SIDE * chain.misfit;
                choice.length < chain.length && choice.misfit < most
            }) =>
        {
            let least = [Thresholds::LEAST, Thresholds::LEAST_OF_DAMPING];
            let checked = chain.blueprint(names, period, least)?;
            let mut what = format!("static gain {}", number(chain.gain));
            if chain.delay != 0.0 {
                what += &format!(", delay {} s", number(chain.delay));
            }
            if chain.delay < 0.0 {
                what +=
                    " (readings that are taken after their command has acted; the model has none)";
            }
            for lag in &chain.lags {
                what += &format!(", lag of {} Hz", number(*lag));
            }
            if let Some([natural, damping]) = chain.mode {
                what += &format!(", mode of {} Hz (damping {})", number(natural), number(damping));
            }
            let leaves = left(&|line| {
                let g = line.response[(0, 0)];
                let model =
                    chain.response(line.frequency) * frequency::hold(line.frequency, period);
                [(g - model).norm_sqr(), g.norm_sqr()]
            });
            Ok((checked.blueprint().clone(), what, leaves))
        }
        (_, Ok((held, choice))) => {
            let checked = held.blueprint(names)?;
            let mut blueprint = checked.blueprint().clone();
            for (axis, spec) in blueprint.axes.iter_mut().zip(&checked.spec().axes) {
                for (part, node) in axis.components.iter_mut().zip(&spec.components) {
                    let values = fitted(node).filter(|(_, _, value)| *value != 0.0);
                    part.tolerance
                        .extend(values.map(|(name, ..)| (name.to_owned(), Thresholds::LEAST)));
                }
            }
            let all = |text: Vec<String>| text.join(", ");
            let what = format!(
                "modes of {}, delay {} s, static gain {}",
                all(held
                    .modes
                    .iter()
                    .map(|mode| format!(
                        "{} Hz (damping {})",
                        number(mode.frequency),
                        number(mode.damping)
                    ))
                    .collect()),
                held.delay,
                all(held.static_gain().iter().map(|g| number(*g)).collect())
            );
            let leaves = left(&|line| {
                let rest = &line.response - choice.model.response(line.frequency);
                [rest.norm_squared(), line.response.norm_squared()]
            });
            Ok((blueprint, what, leaves))
        }
        (_, Err(error)) => Err(error.into()),
    }
}
