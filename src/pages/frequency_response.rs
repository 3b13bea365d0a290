//! The page of a frequency response: Bode plots with coherence, levels of noise and distortion, modes.

use identify::frequency::Line;
use report::{
    Axis, Bode, Column, KeyFigure, Provenance, Report, Role, Section, Spectrum, Table, Value,
    Verdict,
};

use super::polar;
use crate::results::frequency_response::{Measured, Plant, Signal};

/// Coherence below which a response is told not to be sound.
const SOUND: f64 = 0.9;

/// The page of a measured response.
pub(crate) fn frequency_response(measured: &Measured, provenance: Provenance) -> Report {
    let mut page = Report::new("frequency-response", "Frequency response", verdict(measured));
    page = page.provenance(provenance);
    for note in &measured.notes {
        page = page.warning(note);
    }
    if let Some(fit) = &measured.fit {
        for (k, mode) in fit.modes.iter().filter(|mode| mode.damping < 1.0).enumerate() {
            let name = format!("Mode {}", k + 1);
            let note = format!("damping {}", report::format_number(mode.damping, 3));
            page = page.key_figure(KeyFigure::new(name, mode.frequency, "Hz").note(note));
        }
    }
    let mut responses = Section::new("Response");
    for (i, input) in measured.inputs.iter().enumerate() {
        responses = responses.figure(bode(measured, i, input));
    }
    let mut quality = Section::new("Signal, noise, distortion").table(levels(measured));
    for (o, output) in measured.outputs.iter().enumerate() {
        quality = quality.figure(spectrum(measured, o, output));
    }
    page = page.section(responses).section(quality);
    if let Some(section) = modes(measured) {
        page = page.section(section);
    }
    if let Some(plant) = &measured.plant {
        page = page.section(simulation(plant));
    }
    page
}

/// How far the plant that was written is from the records.
fn simulation(plant: &Plant) -> Section {
    let columns = [
        Column::new("record"),
        Column::new("output"),
        Column::new("unit"),
        Column::new("rms error"),
        Column::new("of the output's rms").unit("%").decimals(2),
    ];
    let mut table = Table::new("Plant simulated with the inputs of the records", columns);
    for error in &plant.errors {
        table = table.row([
            Value::from(error.record.as_str()),
            error.output.as_str().into(),
            error.unit.as_str().into(),
            error.rmse.into(),
            (100.0 * error.relative).into(),
        ]);
    }
    let text = format!(
        "{}: {} modes common to all axes, for inputs held between samples. The plant starts at rest and \
         sees the inputs alone; records with periods are judged from the second one on, without their means. It was \
         fitted to these records.",
        plant.blueprint.display(),
        plant.modes
    );
    Section::new("The plant").paragraph(text).table(table)
}

fn verdict(measured: &Measured) -> Verdict {
    let least = measured.levels.iter().map(|one| one.mean_coherence).fold(1.0, f64::min);
    let sentence = format!(
        "{} lines from {} to {} Hz; the commands explain {} % of the outputs' power by a linear response.",
        measured.lines,
        report::format_number(measured.from_hz, 4),
        report::format_number(measured.to_hz, 4),
        report::format_number(100.0 * least, 4)
    );
    if least < SOUND { Verdict::caution(sentence) } else { Verdict::neutral(sentence) }
}

/// The responses of all outputs to an input, and the fitted model's.
fn bode(measured: &Measured, input: usize, signal: &Signal) -> Bode {
    let lines = &measured.response.lines;
    let of = |get: &dyn Fn(&Line) -> f64| -> Vec<f64> { lines.iter().map(get).collect() };
    let frequency = of(&|line| line.frequency);
    let first = measured.outputs.first().map_or("1", Signal::unit);
    let unit = format!("{first}/{}", signal.unit());
    let mut figure = Bode::new(format!("From {}", signal.name), unit);
    let is_single = measured.outputs.len() == 1;
    for (o, output) in measured.outputs.iter().enumerate() {
        let response: Vec<_> = lines.iter().map(|line| line.response[(o, input)]).collect();
        let (magnitude, phase) = polar(&response);
        let coherence = of(&|line| line.coherence[o]);
        let role = if is_single { Role::Measured } else { Role::Other };
        let name = output.name.as_str();
        figure = figure.response(role, name, &frequency, &magnitude, &phase, Some(&coherence));
        if let Some(choice) = &measured.model {
            let model: Vec<_> =
                frequency.iter().map(|f| choice.model.response(*f)[(o, input)]).collect();
            let (magnitude, phase) = polar(&model);
            let role = if is_single { Role::Model } else { Role::Other };
            let name = format!("{name}, fitted");
            figure = figure.response(role, name, &frequency, &magnitude, &phase, None);
        }
    }
    figure.caption(
        "Local polynomial method. Coherence: the share of an output's power that follows linearly from all \
         inputs; hysteresis and noise lower it.",
    )
}

/// What an output holds at the lines, and what of it is not linear.
fn spectrum(measured: &Measured, output: usize, signal: &Signal) -> Spectrum {
    let lines = &measured.response.lines;
    let of = |get: &dyn Fn(&Line) -> f64| -> Vec<f64> { lines.iter().map(get).collect() };
    let frequency = of(&|line| line.frequency);
    let axis = Axis::new("amplitude", signal.unit());
    let mut figure = Spectrum::new(format!("Lines of {}", signal.name), axis)
        .trace(Role::Measured, "output", &frequency, &of(&|line| line.amplitude[output]))
        .trace(Role::Other, "noise and distortion", &frequency, &of(&|line| line.total[output]));
    if lines.iter().all(|line| line.noise.is_some()) {
        let noise = of(&|line| line.noise.as_ref().map_or(f64::NAN, |noise| noise[output]));
        figure = figure.trace(Role::Other, "noise", &frequency, &noise);
    }
    let distortion = &measured.response.distortion;
    for (name, lines) in [("even lines", &distortion.even), ("odd lines", &distortion.odd)] {
        if !lines.is_empty() {
            let (frequency, values): (Vec<f64>, Vec<f64>) =
                lines.iter().map(|(f, values)| (*f, values[output])).unzip();
            figure = figure.trace(Role::Other, name, &frequency, &values);
        }
    }
    figure.caption(
        "Amplitude of each line. Noise: the scatter from period to period, of the mean of all periods. Even and odd lines: the output at lines that the input omits, without its linear part.",
    )
}

fn levels(measured: &Measured) -> Table {
    let columns = [
        Column::new("output"),
        Column::new("unit"),
        Column::new("rms per line"),
        Column::new("noise"),
        Column::new("distortion"),
        Column::new("even lines"),
        Column::new("odd lines"),
        Column::new("mean coherence").decimals(4),
        Column::new("least coherence").decimals(4),
    ];
    let rows = measured.levels.iter().zip(&measured.outputs);
    rows.fold(Table::new("Levels over the band", columns), |table, (one, output)| {
        let or = |value: Option<f64>| value.map_or(Value::from("unknown"), Value::from);
        let levels = &one.levels;
        table.row([
            Value::from(one.name.as_str()),
            output.unit().into(),
            levels.output.into(),
            or(levels.noise),
            or(levels.distortion),
            or(levels.even),
            or(levels.odd),
            one.mean_coherence.into(),
            one.least_coherence.into(),
        ])
    })
}

fn modes(measured: &Measured) -> Option<Section> {
    let fit = measured.fit.as_ref()?;
    let columns = [
        Column::new("pole or pair"),
        Column::new("frequency").unit("Hz"),
        Column::new("damping ratio"),
        Column::new("height"),
    ];
    let mut table = Table::new("Fitted modes", columns);
    for (k, mode) in (1_u32..).zip(&fit.modes) {
        table = table.row([
            Value::from(k),
            mode.frequency.into(),
            mode.damping.into(),
            mode.height.into(),
        ]);
    }
    let text = format!(
        "One denominator for all elements, least squares weighted by the response's own scatter; delay {} s. The error of the fit is {} times that scatter: 1 is as good as the data are; more indicates a missing mode or delay, or a nonlinearity that no linear model has. A damping ratio of 1 is a real pole, its frequency the corner.",
        report::format_number(fit.delay_s, 3),
        report::format_number(fit.misfit.sqrt(), 3)
    );
    Some(Section::new("Modes").paragraph(text).table(table))
}
