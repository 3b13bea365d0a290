//! What an identification gives.

use std::io::{self, Write};
use std::path::PathBuf;

use cli::Answer;
use identify::{Identification, Record};
use serde::Serialize;

/// The result: one identification per axis.
#[derive(Serialize)]
pub(crate) struct Identified {
    pub(crate) blueprint: PathBuf,
    pub(crate) axes: Vec<AxisResult>,
    pub(crate) notes: Vec<String>,
    /// Run-in in s, the longest of all axes.
    #[serde(skip)]
    pub(crate) run_in: f64,
}

/// One axis.
#[derive(Serialize)]
pub(crate) struct AxisResult {
    pub(crate) name: String,
    #[serde(flatten)]
    pub(crate) identification: Identification,
    /// The records it was identified from.
    #[serde(skip)]
    pub(crate) records: Vec<Record>,
    #[serde(skip)]
    pub(crate) command_unit: String,
}

impl Answer for Identified {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for note in &self.notes {
            writeln!(out, "note: {note}")?;
        }
        for axis in &self.axes {
            let id = &axis.identification;
            writeln!(out, "axis {}", axis.name)?;
            writeln!(
                out,
                "  {:48} {:>9} {:>9} {:>7}  verdict",
                "structure tried", "fitted", "held out", "numbers"
            )?;
            for candidate in &id.candidates {
                let percent = |part: Option<f64>| {
                    part.map_or_else(|| "failed".to_owned(), |e| format!("{:.3} %", 100.0 * e))
                };
                let mark = if candidate.accepted { "selected: " } else { "" };
                writeln!(
                    out,
                    "  {:48} {:>9} {:>9} {:>7}  {mark}{}",
                    candidate.structure,
                    percent(candidate.fitted_nrmse),
                    percent(candidate.held_out_nrmse),
                    candidate.parameters,
                    candidate.reason
                )?;
            }
            for candidate in &id.candidates {
                let Some(predicted) = &candidate.predicted else { continue };
                let output = match &predicted.output {
                    Some(output) => format!(
                        "; the plant's output deviation runs on {} of the samples and differs from it by at most {:.2} %",
                        output.centres,
                        100.0 * output.apart
                    ),
                    None => "; --deviation makes it an output of the plant".to_owned(),
                };
                writeln!(
                    out,
                    "  {}: its own standard deviation on {} rows held out: median {:.5} {u}, at most {:.5} {u} (noise {:.5} {u}); {:.0} % of the errors \
                     lie within 1.96 of it (95 % where it knows what it does not know){output}",
                    candidate.structure,
                    predicted.rows,
                    predicted.median,
                    predicted.greatest,
                    predicted.noise,
                    100.0 * predicted.within,
                    u = id.unit
                )?;
            }
            if id.stopped {
                writeln!(out, "  stopped: the best of what was finished is taken")?;
            }
            for record in &id.records {
                let (held, line) = (&record.held_out, &record.baseline_held_out);
                writeln!(
                    out,
                    "  {}: held out {:.3} % of range (rmse {:.5} {u}, max {:.5} {u}, offset {:.4} {u}); a straight line {:.3} %",
                    record.record,
                    100.0 * held.nrmse,
                    held.rmse,
                    held.max,
                    held.offset,
                    100.0 * line.nrmse,
                    u = id.unit
                )?;
            }
            let open: Vec<_> = id.undetermined().map(|p| p.name.as_str()).collect();
            if !open.is_empty() {
                let some = open[..open.len().min(6)].join(", ");
                let dots = if open.len() > 6 { ", …" } else { "" };
                writeln!(
                    out,
                    "  {} of {} parameters are not determined one by one: {some}{dots} (--json lists all)",
                    open.len(),
                    id.parameters.len()
                )?;
            }
        }
        writeln!(out, "{}: written", self.blueprint.display())
    }
}
