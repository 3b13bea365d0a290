//! Scores as a page.

use report::{Axis, KeyFigure, Outcome, Report, Role, Section, Table, Value, Verdict, XyLoop};

use crate::score::Scores;
use crate::statistics::Rate;
use crate::target::{Figure, Goal};
use crate::text::CAUTION;

impl Scores {
    /// The page, without its provenance.
    #[must_use]
    pub fn page(&self) -> Report {
        let mut page = Report::new("gap-bench", "The withheld-effect benchmark", self.verdict())
            .warning(CAUTION);
        if !self.failed.is_empty() {
            let cases: usize = self.failed.iter().map(|failure| failure.cases.len()).sum();
            page = page.warning(format!("The tool failed on {cases} cases; see the last section."));
        }
        for figure in self.figures.iter().filter(|figure| figure.value.is_some()) {
            page = page.key_figure(key_figure(figure));
        }
        page.section(self.singles_section())
            .section(self.confusion_section())
            .section(self.removed_section())
            .section(self.calibration_section())
            .section(self.shrink_section())
            .section(self.rest_section())
    }

    fn verdict(&self) -> Verdict {
        let judged: Vec<bool> = self.figures.iter().filter_map(Figure::is_met).collect();
        let met = judged.iter().filter(|met| **met).count();
        let sentence = format!(
            "{} machines with withheld effects were diagnosed; {met} of {} goals are met.",
            self.answered,
            judged.len()
        );
        match (met == judged.len(), judged.is_empty()) {
            (_, true) => Verdict::neutral(sentence),
            (true, _) => Verdict::pass(sentence),
            (false, _) => Verdict::caution(sentence),
        }
    }

    fn singles_section(&self) -> Section {
        let columns =
            ["family", "size", "right", "truth first", "in the set", "exactly", "mean set"];
        let mut table = Table::new("By family and size", columns);
        for row in &self.singles {
            table = table.row([
                Value::from(row.family.as_str()),
                format!("{} σ", row.size).into(),
                row.right.to_string().into(),
                percent(row.is_first),
                percent(row.in_set),
                percent(row.exactly),
                row.mean_set.map(|mean| (mean * 100.0).round() / 100.0).into(),
            ]);
        }
        let columns = ["effect", "size", "textbook formula", "other formula", "in the set"];
        let mut effects = Table::new("By effect", columns);
        for row in &self.effects {
            effects = effects.row([
                Value::from(row.effect.as_str()),
                format!("{} σ", row.size).into(),
                counts(row.standard),
                counts(row.other),
                counts(row.in_set),
            ]);
        }
        Section::new("Single effects")
            .paragraph(
                "Size: rms error of the re-tuned model on the noise-free reading, divided by the noise. \
                 Right: the first name is the true effect; for an effect of the groups lag, slow and \
                 static_map it suffices that the set contains it and has no name outside its group.",
            )
            .table(table)
            .table(effects)
    }

    fn confusion_section(&self) -> Section {
        let mut answers: Vec<&str> = Vec::new();
        for (answer, _) in self.confusion.iter().flat_map(|row| &row.answers) {
            if !answers.contains(&answer.as_str()) {
                answers.push(answer);
            }
        }
        answers.sort_unstable();
        let columns = std::iter::once("truth").chain(answers.iter().copied());
        let mut table = Table::new("Counts; rows: truth, columns: first name or verdict", columns);
        for row in &self.confusion {
            let count = |answer: &&str| {
                let found = row.answers.iter().find(|(name, _)| name == answer);
                Value::from(found.map_or(String::new(), |(_, n)| n.to_string()))
            };
            let cells = answers.iter().map(count);
            table = table.row(std::iter::once(Value::from(row.truth.as_str())).chain(cells));
        }
        Section::new("Confusion matrix").table(table)
    }

    fn removed_section(&self) -> Section {
        let r = &self.removed;
        let mut table = Table::new("Answers", ["answer", "share"]);
        for (name, rate) in [
            ("unknown", r.abstained),
            ("overlooked", r.overlooked),
            ("a neighbour of its group", r.neighbour),
            ("a name outside its group", r.outside),
            ("of the names, says that something is left", r.flagged),
        ] {
            table = table.row([name.to_owned(), rate.to_string()]);
        }
        let mut names = Table::new("Names outside the group", ["truth", "name", "cases"]);
        for (truth, name, count) in &r.stand_ins {
            names = names.row([Value::from(truth.as_str()), name.as_str().into(), (*count).into()]);
        }
        Section::new("Own candidate removed").table(table).table(names)
    }

    fn calibration_section(&self) -> Section {
        let bins = &self.calibration.bins;
        let stated: Vec<f64> = bins.iter().map(|bin| bin.probability).collect();
        let found: Vec<f64> =
            bins.iter().map(|bin| bin.right.share().unwrap_or_default()).collect();
        let figure = XyLoop::new(
            "Reliability",
            Axis::new("probability said", "1"),
            Axis::new("share right", "1"),
        )
        .line(Role::Reference, "calibrated", &[0.0, 1.0], &[0.0, 1.0])
        .measured("found", &stated, &found);
        let mut table = Table::new("Bins", ["probability", "right"]);
        for bin in bins {
            table = table.row([format!("{:.3}", bin.probability), bin.right.to_string()]);
        }
        Section::new("Probabilities").figure(figure).table(table)
    }

    fn shrink_section(&self) -> Section {
        let mut sorted: Vec<_> = self.shrinks.iter().collect();
        sorted.sort_by(|a, b| a.predicted.total_cmp(&b.predicted));
        let column = |get: &dyn Fn(&crate::score::ShrinkPair) -> f64| -> Vec<f64> {
            sorted.iter().map(|pair| get(pair)).collect()
        };
        let number: Vec<f64> = (1..=sorted.len()).map(|n| n as f64).collect();
        let figure = XyLoop::new(
            "Shrink, cases in the order of the prediction",
            Axis::new("case", ""),
            Axis::new("explained part of the gap", "1"),
        )
        .model("predicted", &number, &column(&|pair| pair.predicted))
        .line(Role::Other, "lower end", &number, &column(&|pair| pair.ci95[0]))
        .line(Role::Other, "upper end", &number, &column(&|pair| pair.ci95[1]))
        .measured("realised", &number, &column(&|pair| pair.realised.max(-1.0)));
        Section::new("Error reduction on records that the diagnosis did not use")
            .paragraph(
                "Realised: the repaired model against the re-tuned one, on noise-free records of the \
                 kinds held out. Effects that do not follow from the command are left out.",
            )
            .figure(figure)
    }

    fn rest_section(&self) -> Section {
        let mut table = Table::new("Verdicts", ["family", "verdicts", "median time in s"]);
        for row in &self.verdicts {
            let verdicts: Vec<String> =
                row.verdicts.iter().map(|(verdict, n)| format!("{verdict} {n}")).collect();
            table = table.row([
                Value::from(row.family.as_str()),
                verdicts.join(", ").into(),
                row.seconds.into(),
            ]);
        }
        let failed = self.failed.iter().map(|failure| {
            format!(
                "{} cases ({}, …): {}",
                failure.cases.len(),
                failure.cases.first().map_or("", String::as_str),
                failure.message
            )
        });
        let all: Vec<String> = failed.chain(self.not_drawn.iter().cloned()).collect();
        let section = Section::new("Verdicts, times, failures").table(table);
        if all.is_empty() { section } else { section.list(all) }
    }
}

fn key_figure(figure: &Figure) -> KeyFigure {
    let scale = if figure.rate.is_some() { 100.0 } else { 1.0 };
    let unit = if figure.rate.is_some() { "%" } else { "" };
    let value = figure.value.map(|value| scale * value);
    let key = KeyFigure::new(figure.name.as_str(), value, unit);
    let key = match figure.goal {
        Goal::AtLeast(limit) => key.at_least(scale * limit),
        Goal::AtMost(limit) => key.at_most(scale * limit),
        Goal::None => key.outcome(Outcome::None),
    };
    match figure.rate {
        Some(rate) => key.note(format!(
            "{} of {}, 95 %: {:.1} to {:.1} %",
            rate.hits,
            rate.of,
            100.0 * rate.low,
            100.0 * rate.high
        )),
        None => key,
    }
}

fn percent(rate: Rate) -> Value {
    rate.share().map(|share| format!("{:.1} %", 100.0 * share)).into()
}

fn counts(rate: Rate) -> Value {
    (rate.of > 0).then(|| format!("{}/{}", rate.hits, rate.of)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_renders_with_and_without_outcomes() {
        let html = Scores::of(&[]).page().to_html().unwrap();
        assert!(html.contains("0 machines"), "the sentence is missing");
    }
}
