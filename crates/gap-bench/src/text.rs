//! Scores as text.

use std::io::{self, Write};

use crate::score::Scores;
use crate::statistics::Rate;

/// Said next to every headline number.
pub const CAUTION: &str = "The machines share the structure of their baseline with the models; \
                           expect less on hardware.";

impl Scores {
    /// Writes the scores as tables for a terminal.
    ///
    /// # Errors
    /// The writer's.
    pub fn write_text(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{} cases answered. {CAUTION}", self.answered)?;
        self.write_figures(out)?;
        self.write_singles(out)?;
        self.write_effects(out)?;
        self.write_confusion(out)?;
        self.write_removed(out)?;
        self.write_calibration(out)?;
        self.write_verdicts(out)?;
        self.write_failures(out)
    }

    fn write_figures(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "\nFigures, with Clopper-Pearson intervals of 95 %")?;
        for figure in &self.figures {
            let mark = match figure.is_met() {
                Some(true) => "met",
                Some(false) => "MISSED",
                None => "",
            };
            let (name, text, goal) = (&figure.name, figure.text(), figure.goal_text());
            writeln!(out, "  {name:<68} {text:<32} {goal:<8} {mark}")?;
        }
        Ok(())
    }

    fn write_singles(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "\nSingle effects: right (group rule), truth first, in the set, exactly, set"
        )?;
        for row in &self.singles {
            writeln!(
                out,
                "  {:<24} {:>3} σ  {:<30} {:<9} {:<9} {:<9} {}",
                row.family,
                row.size,
                row.right.to_string(),
                percent(row.is_first),
                percent(row.in_set),
                percent(row.exactly),
                row.mean_set.map_or("-".into(), |mean| format!("{mean:.2}"))
            )?;
        }
        Ok(())
    }

    fn write_effects(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "\nBy effect: right with the textbook's formula, with another one, in the set"
        )?;
        for row in &self.effects {
            writeln!(
                out,
                "  {:<24} {:>3} σ  {:>8} {:>8} {:>8}",
                row.effect,
                row.size,
                short(row.standard),
                short(row.other),
                short(row.in_set)
            )?;
        }
        Ok(())
    }

    fn write_confusion(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "\nWhat is named first, by what is there")?;
        for row in &self.confusion {
            let answers: Vec<String> =
                row.answers.iter().map(|(name, count)| format!("{name} {count}")).collect();
            writeln!(out, "  {:<24} {}", row.truth, answers.join(", "))?;
        }
        Ok(())
    }

    fn write_removed(&self, out: &mut dyn Write) -> io::Result<()> {
        let r = &self.removed;
        writeln!(out, "\nOwn candidate removed")?;
        for (name, rate) in [
            ("unknown", r.abstained),
            ("overlooked", r.overlooked),
            ("a neighbour of its group", r.neighbour),
            ("a name outside its group", r.outside),
            ("of the names, says that something is left", r.flagged),
        ] {
            writeln!(out, "  {name:<44} {rate}")?;
        }
        for (truth, name, count) in &r.stand_ins {
            writeln!(out, "    {truth} called {name}: {count}")?;
        }
        Ok(())
    }

    fn write_calibration(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "\nProbability said, and how often the name is right")?;
        for bin in &self.calibration.bins {
            writeln!(out, "  {:.2}  {}", bin.probability, bin.right)?;
        }
        Ok(())
    }

    fn write_verdicts(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "\nVerdicts, and the median time of one diagnosis")?;
        for row in &self.verdicts {
            let verdicts: Vec<String> =
                row.verdicts.iter().map(|(verdict, count)| format!("{verdict} {count}")).collect();
            let seconds = row.seconds.map_or(String::new(), |s| format!("{s:.2} s"));
            writeln!(out, "  {:<24} {seconds:>8}  {}", row.family, verdicts.join(", "))?;
        }
        Ok(())
    }

    fn write_failures(&self, out: &mut dyn Write) -> io::Result<()> {
        if !self.not_drawn.is_empty() {
            writeln!(out, "\n{} cases without a machine:", self.not_drawn.len())?;
        }
        for reason in &self.not_drawn {
            writeln!(out, "  {reason}")?;
        }
        for failure in &self.failed {
            let cases = &failure.cases;
            let first = cases.first().map_or("", String::as_str);
            writeln!(out, "\nThe tool failed on {} cases, as {first}:", cases.len())?;
            writeln!(out, "  {}", failure.message)?;
        }
        Ok(())
    }
}

fn percent(rate: Rate) -> String {
    rate.share().map_or("-".into(), |share| format!("{:.1} %", 100.0 * share))
}

fn short(rate: Rate) -> String {
    if rate.of == 0 { "-".into() } else { format!("{}/{}", rate.hits, rate.of) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_benchmark_says_so_and_claims_nothing() {
        let mut text = Vec::new();
        Scores::of(&[]).write_text(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert!(text.starts_with("0 cases answered.") && text.contains(CAUTION), "{text}");
        assert!(text.contains("no case") && !text.contains(" met") && !text.contains("MISSED"));
    }
}
