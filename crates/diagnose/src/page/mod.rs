//! The answer as a page: the sentence first, then the picture that proves it, then where, which, how much, what next.

mod evidence;

use std::collections::BTreeMap;

use report::{Column, KeyFigure, Report, Section, Table, TimeSeries, Value, Verdict as Word};

use crate::gap::{Estimate, Gap, HeldOut, ModelKind, Verdict};
use crate::outcome::Outcome;
use crate::sentence;
use crate::{Diagnosis, Files};

/// The gap of the first output over its command, in its slowest record, as SVG.
pub(crate) fn picture(diagnosis: &Diagnosis) -> Option<String> {
    let figure = evidence::slowest(diagnosis.outcomes.first()?)?;
    Some(report::Figure::from(figure).to_svg())
}

pub(crate) fn report(diagnosis: &Diagnosis, files: &Files<'_>) -> Report {
    let gap = &diagnosis.gap;
    let verdict = match gap.verdict {
        Verdict::Adequate => Word::pass(&gap.sentence),
        Verdict::Retune | Verdict::Effects => Word::neutral(&gap.sentence),
        Verdict::Unknown | Verdict::InsufficientExcitation => Word::caution(&gap.sentence),
    };
    let title = format!("Gap between {} and its logs", gap.provenance.model);
    let mut page = Report::new("diagnose", title, verdict);
    for warning in &gap.warnings {
        page = page.warning(warning);
    }
    page = figures(page, gap);
    let mut proof = Section::new("Measured, model, repaired model");
    for figure in diagnosis.outcomes.iter().filter_map(evidence::proof) {
        proof = proof.figure(figure);
    }
    page = page.section(proof);
    for outcome in &diagnosis.outcomes {
        page = page.section(place(gap, outcome));
    }
    page.section(which(gap))
        .section(how_much(gap))
        .section(tried(gap))
        .section(next(diagnosis, files))
        .section(use_it(gap, files))
}

fn figures(mut page: Report, gap: &Gap) -> Report {
    let s = &gap.shrink;
    let before = match gap.outputs.len() {
        1 => "Gap before (held-out rms)".to_owned(),
        _ => format!("Gap of {} before (held-out rms)", gap.place.output),
    };
    page = page
        .key_figure(KeyFigure::new(before, s.rms_before, s.unit.as_str()))
        .key_figure(KeyFigure::new("Gap after", s.rms_after, s.unit.as_str()))
        .key_figure(KeyFigure::new("Noise", s.noise_floor, s.unit.as_str()));
    if let Some(own) = s.own_course {
        let figure = KeyFigure::new(
            "Share of the gap's power in a drift of its own course",
            100.0 * own,
            "%",
        );
        page = page.key_figure(figure.note("no model predicts it".to_owned()));
    } else if let Some(fraction) = s.fraction {
        let note = s.ci95.map_or_else(String::new, |[low, high]| {
            let low = crate::sentence::at_least(low);
            format!("95 % for a new record like these: {low} to {:.0} %", 100.0 * high)
        });
        let figure = KeyFigure::new("Share of the gap's power removed", 100.0 * fraction, "%");
        page = page.key_figure(figure.note(note));
    }
    page
}

fn place(gap: &Gap, o: &Outcome) -> Section {
    let mut section = Section::new(format!("Where: {}", o.task.output));
    if gap.place.output == o.task.output {
        let p = &gap.place;
        let lines = [
            ("Amplitude", &p.amplitude),
            ("Direction", &p.branch),
            ("Time", &p.time),
            ("Stage", &p.stage),
        ];
        let mut items: Vec<String> = lines
            .into_iter()
            .filter_map(|(name, text)| Some(format!("{name}: {}", text.as_ref()?)))
            .collect();
        if let Some(driven) = p.input_driven {
            items.push(format!("Driven by the command: {}", if driven { "yes" } else { "no" }));
        }
        section = section.list(items);
        let columns = [
            Column::new("from").unit("Hz"),
            Column::new("to").unit("Hz"),
            Column::new("share of the gap").unit("%"),
            Column::new("above the noise before").unit("dB"),
            Column::new("after").unit("dB"),
        ];
        let mut table = Table::new("Bands where the gap lies", columns);
        for b in &p.bands {
            let cells = [b.hz[0], b.hz[1], 100.0 * b.share, b.over_noise_db[0], b.over_noise_db[1]];
            table = table.row(cells);
        }
        section = section.table(table);
    }
    evidence::add(section, o)
}

fn which(gap: &Gap) -> Section {
    let mut section = Section::new("Which effect");
    if gap.effects.is_empty() {
        section = section.paragraph("No effect is named.");
        for p in &gap.partial {
            if let Some(own) = p.own_course {
                section = section.paragraph(format!(
                    "The best single candidate for {} is {}: {}.",
                    p.effect.output,
                    p.effect.effect,
                    sentence::own_drift(own)
                ));
                continue;
            }
            section = section.paragraph(format!(
                "The best single candidate for {}, {}, would remove {:.0} % of the gap's power on held-out rows and leave {} {} rms of {} {}.",
                p.effect.output,
                p.effect.effect,
                100.0 * p.effect.explained,
                report::format_number(p.rms_after, 4),
                p.unit,
                report::format_number(p.rms_before, 4),
                p.unit
            ));
        }
        return section;
    }
    for e in &gap.effects {
        let known = components::effects::find(&e.effect);
        let outputs: Vec<&str> =
            [&e.output].into_iter().chain(&e.also).map(String::as_str).collect();
        let text = format!(
            "{} on {}, stage {}: probability {:.2}{}. {}",
            e.effect,
            outputs.join(", "),
            e.stage,
            e.probability,
            if e.set.len() > 1 { format!(", one of {}", e.set.join(", ")) } else { String::new() },
            known.map_or("", |k| k.signature)
        );
        section = section.paragraph(text);
        if let Some(k) = known {
            let mut items = vec![format!("Confirm with: {}", k.experiment)];
            if !k.confused_with.is_empty() {
                items.push(format!("Easily confused with: {}", k.confused_with.join(", ")));
            }
            section = section.list(items);
        }
    }
    let mut table = Table::new(
        "Parameters of the effects",
        ["parameter", "value", "standard deviation", "unit"],
    );
    for (name, p) in gap.effects.iter().flat_map(|e| &e.parameters) {
        table = table.row([
            name.as_str().into(),
            p.value.into(),
            Value::from(p.std),
            Value::from(p.unit.as_str()),
        ]);
    }
    section.table(table)
}

/// Root mean squares before and after, record by record.
fn stretches(title: String, unit: &str, all: &[HeldOut]) -> Table {
    let columns = [
        Column::new("record"),
        Column::new("rms before").unit(unit),
        Column::new("rms after").unit(unit),
        Column::new("share removed").unit("%"),
    ];
    all.iter().fold(Table::new(title, columns), |table, h| {
        table.row([
            Value::from(h.record.as_str()),
            h.rms_before.into(),
            h.rms_after.into(),
            Value::from(h.fraction.map(|f| 100.0 * f)),
        ])
    })
}

fn how_much(gap: &Gap) -> Section {
    let unit = gap.shrink.unit.as_str();
    let title = format!("Held-out rows: {}", gap.provenance.split);
    let mut section = Section::new("How much").table(stretches(title, unit, &gap.shrink.holdout));
    if let Some(second) = &gap.shrink.second_opinion {
        let title = format!("Second opinion: {}", second.split);
        section = section.table(stretches(title, unit, &second.records)).paragraph(format!(
            "On the records that were left out, {:.0} % of the gap's power is removed.",
            100.0 * second.fraction
        ));
    }
    let mut tuned = Table::new(
        "Parameters re-tuned within their tolerance",
        ["parameter", "from", "to", "tolerance (1 σ)", "unit", "at its limit"],
    );
    for (name, r) in &gap.retuned {
        tuned = tuned.row([
            Value::from(name.as_str()),
            r.from.into(),
            r.to.into(),
            r.tolerance.into(),
            r.unit.as_str().into(),
            r.at_limit.into(),
        ]);
    }
    let left = &gap.leftover;
    let text = if left.present {
        format!(
            "Remaining error: {} times the noise's power. The formula of an effect never matches the machine exactly, or a further small effect is missing.",
            report::format_number(left.over_noise, 3)
        )
    } else {
        format!("No error above the noise: {:.2} times the noise's power.", left.over_noise)
    };
    section.paragraph(text).table(tuned)
}

fn tried(gap: &Gap) -> Section {
    let mut table = Table::new(
        "All candidates as the first effect, best first",
        [
            "effect",
            "output",
            "formula",
            "score",
            "training / noise",
            "held out / noise",
            "probability",
            "named",
            "left out because",
            "parameters",
        ],
    );
    for c in &gap.candidates {
        table = table.row([
            Value::from(c.effect.as_str()),
            c.output.as_str().into(),
            c.formula.as_str().into(),
            Value::from(c.score),
            Value::from(c.training),
            Value::from(c.holdout),
            c.probability.into(),
            c.accepted.into(),
            c.left_out.as_deref().unwrap_or_default().into(),
            list(&c.parameters).into(),
        ]);
    }
    Section::new("Candidates").table(table)
}

/// Parameters in one line.
fn list(parameters: &BTreeMap<String, Estimate>) -> String {
    let one = |(name, p): (&String, &Estimate)| {
        let short = name.split_once('.').map_or(name.as_str(), |(_, short)| short);
        let unit = if p.unit == "1" { "" } else { p.unit.as_str() };
        format!("{} = {} {unit}", short.replace('_', " "), report::format_number(p.value, 4))
            .trim_end()
            .to_owned()
    };
    parameters.iter().map(one).collect::<Vec<_>>().join("; ")
}

fn next(diagnosis: &Diagnosis, files: &Files<'_>) -> Section {
    let gap = &diagnosis.gap;
    let section = Section::new("What to do next");
    let Some(e) = &gap.next_experiment else {
        let check = "No candidates remain that a measurement could separate. Record the machine once more \
                     with another signal, and compare the repaired model with that log.";
        return section.paragraph(check);
    };
    let mut section = section.paragraph(format!("{}.", e.sentence));
    if let Some(gain) = e.predicted_gain {
        section = section.paragraph(format!(
            "Predicted gain: the wrong one of {} would have a total misfit of {} noise variances, after a \
             new fit of its parameters, of an offset and of all coefficients of each record.",
            e.separates.join(" and "),
            report::format_number(gain, 3)
        ));
    }
    if let Some(file) = files.experiment {
        section = section.paragraph(format!("The signal to play is in {}.", file.display()));
    }
    let unit = |name: &str| {
        let own = diagnosis.outcomes.iter().find(|o| o.task.input == name);
        own.map_or("1", |o| o.task.command_unit.as_str())
    };
    if let (Some(period), Some(rows)) = (e.period, e.columns.values().map(Vec::len).max()) {
        let time: Vec<f64> = (0..rows).map(|k| k as f64 * period).collect();
        let mut figure = TimeSeries::new(format!("Signal to play: {}", e.signal), &time);
        for (name, values) in &e.columns {
            figure = figure.reference(name.as_str(), unit(name), values);
        }
        section = section.figure(figure);
    }
    section
}

fn use_it(gap: &Gap, files: &Files<'_>) -> Section {
    let mut section = Section::new("The repaired model");
    if gap.effects.is_empty() && gap.verdict != crate::gap::Verdict::Retune {
        return section.paragraph("No effect is named, so there is no repaired model.");
    }
    let Some(file) = files.repair else {
        return section
            .paragraph(
                "Run the diagnosis again with --repair to get the model with the effects in place:",
            )
            .code("piezoloop diagnose … --repair repaired.fmu");
    };
    let name = file.display();
    if file.extension().is_some_and(|e| e.eq_ignore_ascii_case("fmu"))
        && gap.provenance.kind == ModelKind::BlackBox
    {
        section = section
            .paragraph(format!(
                "{name} replaces the original FMU: it has the same inputs, outputs and parameters, and \
                 contains the unchanged original. Each effect can be disabled before the \
                 simulation starts; with all of them disabled the outputs have the original's bits."
            ))
            .code(format!(
                "from fmpy import simulate_fmu\nsimulate_fmu(\"{name}\", start_values={{{}}})",
                switches(gap)
            ));
    } else {
        section = section.paragraph(format!(
            "{name} contains the effects, as components whose names begin with found_, or in the \
             components that they change."
        ));
    }
    if !files.notes.is_empty() {
        section = section.list(files.notes.iter().cloned());
    }
    section
        .paragraph("Before you trust it, compare it with a log that was not used here:")
        .code(format!("piezoloop diagnose --model {name} --log new.csv"))
}

fn switches(gap: &Gap) -> String {
    let mut names: Vec<String> =
        gap.effects.iter().map(|e| format!("\"{}.enabled\": True", e.effect)).collect();
    names.push("\"retune.enabled\": True".to_owned());
    names.join(", ")
}
