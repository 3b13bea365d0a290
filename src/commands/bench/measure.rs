//! `piezoloop bench measure`: a signal on the wave generator of an instrument, and its data recorder as a log.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use bench::gateway::station::{self, Follow, Recorded, Station, Wave};
use bench::gateway::{self, Address};
use clap::Args;
use cli::{Answer, Screen};
use data::{Log, SampleTime, UnitPlace};
use serde::Serialize;

use crate::inputs::{self, LogOptions};
use crate::ranges;

/// Plays a signal on an instrument's own wave generator, and reads its data recorder into a log
///
/// The instrument plays and records in its servo cycle, so neither line nor computer disturb the timing. With
/// ?mode=open behind the address the signal is a voltage and the servo is off: the log shows the plant, for
/// `identify`. Otherwise it is a target: the log shows the loop. Before and after, the axis is led slowly to where the
/// signal begins, and back. Wave table and record tables of the instrument are overwritten.
///
/// --follow N records a loop that follows input signal N of the instrument instead, such as its analog input.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop bench measure triangles.csv --gateway 'gcs://10.0.0.5?mode=open' -o log.csv\n  piezoloop bench measure steps.csv --gateway 'gcs:///dev/ttyUSB0?axes=2&baud=115200' --every 2 -o loop.csv\n  piezoloop bench measure triangles.csv --gateway nv200://10.0.0.6 -o loop.csv\n  piezoloop bench measure --follow 4 --duration 2 --gateway gcs://10.0.0.5 -o loop.csv\n  piezoloop bench measure --follow 1 --duration 2 --gateway nv200://10.0.0.6 -o loop.csv"
)]
pub(crate) struct Measure {
    /// The signal: a log with one record of equally spaced rows
    #[arg(required_unless_present = "follow")]
    signal: Option<PathBuf>,
    /// Number of the instrument's input signal that gives the targets meanwhile (1 for the analog input of an NV200); it
    /// needs --duration
    #[arg(long, value_name = "INPUT", conflicts_with_all = ["signal", "column", "cycles"], requires = "duration", value_parser = ranges::integers(1, 1000_u32))]
    follow: Option<u32>,
    /// How long an input signal is followed, in s
    #[arg(long, value_name = "S", requires = "follow", value_parser = ranges::above(0.0, ranges::LONGEST))]
    duration: Option<f64>,
    /// Column of the signal [default: the only one]
    #[arg(long, value_name = "COLUMN")]
    column: Option<String>,
    #[arg(long, value_name = "ADDRESS", value_parser = super::address, help = super::instrument_help())]
    gateway: Address,
    /// Times the signal is played
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = ranges::integers(1, 10_000_u32))]
    cycles: u32,
    /// Servo cycles per recorded row [default: one row per row of the signal; with --follow as few as the recorder has
    /// room for]
    #[arg(long, value_name = "N", value_parser = ranges::integers(1, 1_000_000_u32))]
    every: Option<u32>,
    /// Unit of the axis
    #[arg(long, value_name = "UNIT", default_value = "um")]
    position_unit: String,
    #[command(flatten)]
    options: LogOptions,
    /// The log to write (CSV): command, voltage and position of the axis
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Measured {
    instrument: String,
    servo_cycle_s: f64,
    sample_time_s: f64,
    rows: usize,
    columns: Vec<String>,
    written: PathBuf,
}

impl Measure {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        cli::can_write_as(&self.out, inputs::CSV)?;
        let signal = self.signal.as_deref().map(|file| self.points(file)).transpose()?;
        let mut station = gateway::open_station(&self.gateway)?;
        let cycle = station.cycle();
        let (recorded, closed) = match (signal, self.follow) {
            (Some((points, sample_time)), _) => {
                let wave = self.wave(points, sample_time, &*station)?;
                screen.say(&format!(
                    "{}: {} points, {:.3} s",
                    station.describe(),
                    wave.points.len(),
                    wave.duration(cycle)
                ));
                (station::play(&mut *station, &wave).map_err(anyhow::Error::msg)?, wave.closed)
            }
            (None, input) => (self.followed(screen, &mut *station, input.unwrap_or(1))?, true),
        };
        let log = log_of(&recorded, station.number(), closed, &self.position_unit, &self.out)?;
        log.write(&self.out, UnitPlace::Sidecar)?;
        screen.show(&Measured {
            instrument: station.describe(),
            servo_cycle_s: cycle,
            sample_time_s: recorded.period,
            rows: log.len(),
            columns: log.columns().iter().map(|column| column.name.clone()).collect(),
            written: self.out,
        })
    }

    /// Records a loop whose targets come from an input signal.
    fn followed(
        &self,
        screen: &Screen,
        station: &mut dyn Station,
        input: u32,
    ) -> anyhow::Result<Recorded> {
        if station.is_open_loop() {
            bail!("{}: an input signal gives targets; leave mode=open out", self.gateway);
        }
        let (_, most) = station.most();
        let all = (self.duration.unwrap_or_default() / station.cycle()).round();
        let every = self.every.unwrap_or((all / most as f64).ceil().clamp(1.0, 1e9) as u32);
        let rows = (all / f64::from(every)).floor() as usize;
        if rows < 2 {
            bail!(
                "--duration: {all} servo cycles of {} s make {rows} rows; give a longer time",
                station.cycle()
            );
        }
        // Ended early, the input is disconnected first.
        cli::interrupt::listen()?;
        screen.say(&format!("{}: follows input signal {input}", station.describe()));
        let follow = Follow { input, every, rows };
        station::follow(station, &follow, &|| !cli::interrupt::asked()).map_err(anyhow::Error::msg)
    }

    /// The values of the signal, and their sample time.
    fn points(&self, signal: &Path) -> anyhow::Result<(Vec<f64>, f64)> {
        let log = self.options.read(signal)?;
        let file = signal.display();
        let [record] = log.records() else {
            bail!("{file}: has {} records; an instrument plays one", log.records().len());
        };
        let column = match (&self.column, log.columns()) {
            (Some(name), _) => log.require(name)?,
            (None, [only]) => only,
            (None, all) => {
                let names: Vec<&str> = all.iter().map(|column| column.name.as_str()).collect();
                bail!("{file}: has the columns {}; choose one with --column", names.join(", "))
            }
        };
        let sample_time = log.sample_time(record, SampleTime::TOLERANCE)?.period;
        Ok((column.values.clone(), sample_time))
    }

    fn wave(
        &self,
        points: Vec<f64>,
        sample_time: f64,
        station: &dyn Station,
    ) -> anyhow::Result<Wave> {
        let cycle = station.cycle();
        let exact = sample_time / cycle;
        let hold = exact.round();
        if !(1.0..=1e6).contains(&hold) || (exact - hold).abs() > 1e-3 {
            bail!(
                "{}: sample time {sample_time} s is no multiple of the servo cycle, {cycle} s; give a signal with one, as with --set sample_time={}",
                self.signal.as_deref().unwrap_or(Path::new("the signal")).display(),
                hold.max(1.0) * cycle
            );
        }
        let every = self.every.unwrap_or(hold as u32);
        let all = points.len() as u64 * hold as u64 * u64::from(self.cycles);
        let rows = usize::try_from(all / u64::from(every)).context("too many rows")?;
        if rows < 2 {
            bail!(
                "--every {every}: leaves {rows} rows of {all} servo cycles; give a smaller number"
            );
        }
        let closed = !station.is_open_loop();
        Ok(Wave { closed, points, hold: hold as u32, cycles: self.cycles, every, rows })
    }
}

/// What was recorded of an axis, as a log.
pub(super) fn log_of(
    recorded: &Recorded,
    axis: usize,
    closed: bool,
    unit: &str,
    file: &Path,
) -> anyhow::Result<Log> {
    let time = (0..recorded.position.len()).map(|k| k as f64 * recorded.period).collect();
    let mut log = Log::new(&file.display().to_string(), time)?;
    let command_unit = if closed { unit } else { "V" };
    log.add_column(&format!("command[{axis}]"), Some(command_unit), recorded.command.clone())?;
    if closed && !recorded.voltage.is_empty() {
        log.add_column(&format!("voltage[{axis}]"), Some("V"), recorded.voltage.clone())?;
    }
    log.add_column(&format!("position[{axis}]"), Some(unit), recorded.position.clone())?;
    Ok(log)
}

impl Answer for Measured {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "{} rows of {}, every {} s, in {}",
            self.rows,
            self.columns.join(", "),
            self.sample_time_s,
            self.written.display()
        )
    }
}
