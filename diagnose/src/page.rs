//! The answer as a page: the sentence first, then where, which, how much, what next.

use report::{
    Axis, Column, KeyFigure, Report, Role, Section, Spectrum, Table, TimeSeries, Value,
    Verdict as Word,
};

use crate::Diagnosis;
use crate::gap::{Gap, Verdict};
use crate::outcome::Outcome;

pub(crate) fn report(diagnosis: &Diagnosis) -> Report {
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
    for outcome in &diagnosis.outcomes {
        page = page.section(place(gap, outcome));
    }
    page.section(which(gap)).section(how_much(gap)).section(tried(gap)).section(next(gap))
}

fn figures(mut page: Report, gap: &Gap) -> Report {
    let s = &gap.shrink;
    page = page
        .key_figure(KeyFigure::new("Gap before (held-out rms)", s.rms_before, s.unit.as_str()))
        .key_figure(KeyFigure::new("Gap after", s.rms_after, s.unit.as_str()))
        .key_figure(KeyFigure::new("Noise", s.noise_floor, s.unit.as_str()));
    if let Some(fraction) = s.fraction {
        let note = s.ci95.map_or_else(String::new, |[low, high]| {
            format!("95 % for a new record: {:.0} to {:.0} %", 100.0 * low, 100.0 * high)
        });
        let figure = KeyFigure::new("Part of the gap's power that goes", 100.0 * fraction, "%");
        page = page.key_figure(figure.note(note));
    }
    page
}

fn place(gap: &Gap, o: &Outcome) -> Section {
    let mut section = Section::new(format!("Where: {}", o.problem.output));
    if gap.place.output == o.problem.output {
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
            Column::new("over the noise before").unit("dB"),
            Column::new("after").unit("dB"),
        ];
        let mut table = Table::new("Bands where the gap lies", columns);
        for b in &p.bands {
            let cells = [b.hz[0], b.hz[1], 100.0 * b.share, b.over_noise_db[0], b.over_noise_db[1]];
            table = table.row(cells);
        }
        section = section.table(table);
    }
    signals(section, o)
}

/// Measured, simulated and what is left, record by record; spectra before and after.
fn signals(mut section: Section, o: &Outcome) -> Section {
    let data = &o.problem.data;
    let scale = o.sigma / o.problem.factor;
    let unit = o.problem.unit.as_str();
    for record in &data.records {
        let rows = record.rows.clone();
        let in_unit = |v: &[f64]| v[rows.clone()].iter().map(|r| r * scale).collect::<Vec<f64>>();
        let y: Vec<f64> = data.y[rows.clone()].iter().map(|y| y / o.problem.factor).collect();
        let (before, after) =
            (in_unit(&o.found.base.judged.residual), in_unit(&o.found.last.judged.residual));
        let model: Vec<f64> = y.iter().zip(&before).map(|(y, r)| y - r).collect();
        let mut figure = TimeSeries::new(
            format!("{}: {}", o.problem.output, record.name),
            &data.time[rows.clone()],
        )
        .measured("measured", unit, &y)
        .model("model, re-tuned", unit, &model)
        .panel("gap")
        .residual("before", unit, &before);
        if !o.found.last.picks.is_empty() {
            figure = figure.other("after", unit, &after);
        }
        section = section.figure(figure);
        let curve = |v: &[f64]| {
            let power = crate::spectrum::density(v);
            let width = 1.0 / (v.len() as f64 * data.sample_time());
            // One-sided amplitude density.
            let factor = 2.0 * data.sample_time();
            let frequency: Vec<f64> = (1..power.len()).map(|k| k as f64 * width).collect();
            (frequency, power.iter().skip(1).map(|p| (p * factor).sqrt()).collect::<Vec<f64>>())
        };
        let axis = Axis::new("gap", format!("{unit}/sqrt(Hz)"));
        let (f, values) = curve(&before);
        let mut spectrum = Spectrum::new(format!("Spectrum of the gap: {}", record.name), axis)
            .trace(Role::Residual, "before", &f, &values);
        if !o.found.last.picks.is_empty() {
            let (f, values) = curve(&after);
            spectrum = spectrum.trace(Role::Other, "after", &f, &values);
        }
        let floor = scale * (2.0 * data.sample_time()).sqrt();
        spectrum = spectrum.limit(floor, "noise");
        section = section.figure(spectrum);
    }
    section
}

fn which(gap: &Gap) -> Section {
    let mut section = Section::new("Which effect");
    if gap.effects.is_empty() {
        return section.paragraph("No effect is named.");
    }
    for e in &gap.effects {
        let known = components::effects::find(&e.effect);
        let text = format!(
            "{} on {}, stage {}: probability {:.2}{}. {}",
            e.effect,
            e.output,
            e.stage,
            e.probability,
            if e.set.len() > 1 { format!(", one of {}", e.set.join(", ")) } else { String::new() },
            known.map_or("", |k| k.signature)
        );
        section = section.paragraph(text);
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

fn how_much(gap: &Gap) -> Section {
    let unit = gap.shrink.unit.as_str();
    let mut table = Table::new(
        format!("Rows that were not used: {}", gap.provenance.split),
        [
            Column::new("record"),
            Column::new("rms before").unit(unit),
            Column::new("rms after").unit(unit),
            Column::new("part that goes").unit("%"),
        ],
    );
    for h in &gap.shrink.holdout {
        table = table.row([
            Value::from(h.record.as_str()),
            h.rms_before.into(),
            h.rms_after.into(),
            Value::from(h.fraction.map(|f| 100.0 * f)),
        ]);
    }
    let mut tuned = Table::new(
        "Parameters re-tuned under their tolerance",
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
            "Left: {:.2} times the noise's power. The formula of an effect is never quite the machine's; or something small is still missing.",
            left.over_noise
        )
    } else {
        format!("Nothing is left: {:.2} times the noise's power.", left.over_noise)
    };
    Section::new("How much").table(table).paragraph(text).table(tuned)
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
        ]);
    }
    Section::new("Candidates").table(table)
}

fn next(gap: &Gap) -> Section {
    let section = Section::new("What to do next");
    let section = match &gap.next_experiment {
        Some(e) => section.paragraph(format!("{}.", e.sentence)),
        None => section.paragraph("Nothing is undecided that a measurement could decide."),
    };
    if gap.effects.is_empty() {
        return section;
    }
    section
        .paragraph("The repaired model takes the place of the old one; diagnose it against a log that was not used here:")
        .code("piezoloop diagnose … --repair repaired.toml\npiezoloop diagnose --model repaired.toml --log new.csv")
}
