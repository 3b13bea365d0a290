//! `piezoloop log`: what a log holds, what is doubtful about it, and the same as CSV.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use cli::{Answer, Screen, rounded};
use data::{Log as Measured, SampleTime, UnitPlace};
use serde::Serialize;

use crate::inputs::{self, LogOptions};

/// Findings that are printed per log; JSON has all of them.
const MOST_SHOWN: usize = 20;

/// Shows what logs contain, flags doubtful samples, and converts logs to CSV
///
/// Reads CSV and other text files of instruments, and the measurement files that docs/files.md lists (Parquet, NumPy,
/// MATLAB, HDF5, MDF 4, TDMS and others); reports what it recognised, assumed and left out. Detects missing rows,
/// outliers, saturation and stuck readings, with their lines. Nothing is repaired. The exit code is 1 if samples are
/// doubtful.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop log measured.csv\n  piezoloop log bench.mf4 --group Scope --unit y=um -o measured.csv\n  piezoloop log bench.mf4 --resample=1000 -o joined.csv"
)]
pub(crate) struct Log {
    /// Logs of any supported format
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    options: LogOptions,
    /// Also write the log to this CSV file, with its units in FILE.dataset.toml
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Described {
    logs: Vec<One>,
    #[serde(skip_serializing_if = "Option::is_none")]
    written: Option<PathBuf>,
}

#[derive(Serialize)]
struct One {
    path: PathBuf,
    rows: usize,
    records: Vec<Record>,
    columns: Vec<Column>,
    findings: Vec<Doubt>,
    /// What was recognised, assumed, skipped and left out.
    notes: Vec<String>,
    left_out: Vec<LeftOut>,
}

#[derive(Serialize)]
struct Record {
    record: i64,
    rows: usize,
    start_s: f64,
    end_s: f64,
    /// `null` where the rows are not equally spaced.
    sample_rate_hz: Option<f64>,
}

#[derive(Serialize)]
struct Column {
    name: String,
    unit: Option<String>,
    min: f64,
    max: f64,
}

/// A column that the file has and nobody can use.
#[derive(Serialize)]
struct LeftOut {
    name: String,
    why: String,
}

#[derive(Serialize)]
struct Doubt {
    column: String,
    record: i64,
    place: String,
    rows: usize,
    message: String,
}

impl Log {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        if self.out.is_some() && self.logs.len() > 1 {
            anyhow::bail!("-o writes one log, {} are given; convert each alone", self.logs.len());
        }
        if let Some(out) = &self.out {
            cli::can_write_as(out, inputs::CSV)?;
        }
        let mut logs = Vec::new();
        for path in &self.logs {
            let log = self.options.read_in_silence(path)?;
            if let Some(out) = &self.out {
                log.write(out, UnitPlace::Sidecar)?;
            }
            logs.push(describe(path.clone(), &log));
        }
        screen.show(&Described { logs, written: self.out })
    }
}

fn describe(path: PathBuf, log: &Measured) -> One {
    let records = log.records().iter().map(|record| {
        let time = &log.time()[record.rows.clone()];
        let grid = log.sample_time(record, SampleTime::TOLERANCE);
        Record {
            record: record.id,
            rows: time.len(),
            start_s: time.first().copied().unwrap_or_default(),
            end_s: time.last().copied().unwrap_or_default(),
            sample_rate_hz: grid.ok().map(|grid| 1.0 / grid.period),
        }
    });
    let columns = log.columns().iter().map(|column| Column {
        name: column.name.clone(),
        unit: column.unit.as_ref().map(|unit| unit.text.clone()),
        min: column.values.iter().copied().fold(f64::INFINITY, f64::min),
        max: column.values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    });
    let left_out = log
        .left_out()
        .iter()
        .map(|column| LeftOut { name: column.name.clone(), why: column.why.clone() });
    let findings = log.quality().into_iter().map(|finding| Doubt {
        message: finding.to_string(),
        column: finding.column,
        record: finding.record,
        place: finding.place,
        rows: finding.rows.len(),
    });
    One {
        path,
        rows: log.len(),
        records: records.collect(),
        columns: columns.collect(),
        findings: findings.collect(),
        notes: log.notes(),
        left_out: left_out.collect(),
    }
}

impl Answer for Described {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for log in &self.logs {
            writeln!(out, "{}: {}", log.path.display(), data::counted(log.rows, "row"))?;
            for record in &log.records {
                let Record { record, rows, start_s, end_s, sample_rate_hz } = record;
                let rate = match sample_rate_hz {
                    Some(rate) => format!("{} Hz", rounded(*rate)),
                    None => "not equally spaced".to_owned(),
                };
                let (start, end) = (rounded(*start_s), rounded(*end_s));
                let rows = data::counted(*rows, "row");
                writeln!(out, "  record {record}: {rows}, {start} s to {end} s, {rate}")?;
            }
            for Column { name, unit, min, max } in &log.columns {
                let unit = unit.as_deref().unwrap_or("(no unit)");
                writeln!(out, "  {name}: {} to {} {unit}", rounded(*min), rounded(*max))?;
            }
            for note in &log.notes {
                writeln!(out, "  note: {note}")?;
            }
            for doubt in log.findings.iter().take(MOST_SHOWN) {
                writeln!(out, "{}", doubt.message)?;
            }
            match log.findings.len() {
                0 => writeln!(out, "  no doubtful samples")?,
                count if count > MOST_SHOWN => {
                    writeln!(out, "… and {} more; --json has all", count - MOST_SHOWN)?;
                }
                _ => {}
            }
        }
        match &self.written {
            Some(path) => writeln!(out, "written: {}", path.display()),
            None => Ok(()),
        }
    }

    fn exit_code(&self) -> u8 {
        u8::from(self.logs.iter().any(|log| !log.findings.is_empty()))
    }
}
