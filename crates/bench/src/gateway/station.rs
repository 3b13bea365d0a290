//! Instruments with a wave generator and a data recorder of their own: they play a wave and record it in their servo
//! cycle, free of the jitter of line and computer. `bench measure` and `bench tune` work with them.

use std::thread::sleep;
use std::time::Duration;

/// From which the wait for an answer follows where none is given, in s. Nothing waits for the instrument in real time.
pub(super) const PERIOD: f64 = 1.5;
/// Steps in which an axis is led to the start of a wave, and the time between them.
const LEAD: u32 = 25;
const LEAD_STEP: Duration = Duration::from_millis(8);

/// A wave that an instrument plays.
#[derive(Clone, Debug, PartialEq)]
pub struct Wave {
    /// Targets of the servo; otherwise voltages, with the servo off.
    pub closed: bool,
    /// In the unit of the axis, or in V.
    pub points: Vec<f64>,
    /// Servo cycles for which each point is held.
    pub hold: u32,
    /// Times the points are played.
    pub cycles: u32,
    /// Servo cycles per recorded row.
    pub every: u32,
    /// Recorded rows.
    pub rows: usize,
}

impl Wave {
    /// A wave whose every point is recorded, as often as it is played.
    #[must_use]
    pub fn complete(closed: bool, points: Vec<f64>, hold: u32, cycles: u32) -> Self {
        let rows = points.len() * cycles as usize;
        Wave { closed, points, hold, cycles, every: hold, rows }
    }

    /// The point of a row.
    #[must_use]
    pub fn at(&self, row: usize) -> f64 {
        let cycle = row as u64 * u64::from(self.every);
        let point = (cycle / u64::from(self.hold)) % self.points.len() as u64;
        let is_over =
            cycle >= self.points.len() as u64 * u64::from(self.hold) * u64::from(self.cycles);
        self.points[if is_over { self.points.len() - 1 } else { point as usize }]
    }

    /// How long it is recorded, in s, for this servo cycle.
    #[must_use]
    pub fn duration(&self, cycle: f64) -> f64 {
        self.rows as f64 * f64::from(self.every) * cycle
    }
}

/// Targets that an input signal of the instrument gives, such as its analog input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Follow {
    /// Number of the input signal in the instrument, from 1.
    pub input: u32,
    /// Servo cycles per recorded row.
    pub every: u32,
    /// Recorded rows.
    pub rows: usize,
}

/// Where an input signal is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// The input signal that gives the targets of the axis now; 0: none.
    pub connected: u32,
    /// The target that the one asked for gives; none: the instrument does not tell, and is led there slowly when it is
    /// connected.
    pub target: Option<f64>,
}

/// What an instrument has recorded: in row k the position was sampled before command and voltage of that row acted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recorded {
    /// Time between rows in s.
    pub period: f64,
    /// Targets, or voltages with the servo off.
    pub command: Vec<f64>,
    /// Voltages; empty: there was no room for them.
    pub voltage: Vec<f64>,
    /// Positions.
    pub position: Vec<f64>,
}

/// A notch filter N(s) = (s² + 2·zeros·ω·s + ω²) / (s² + 2·poles·ω·s + ω²), bilinear with ω kept.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct NotchValues {
    /// In Hz.
    pub frequency: f64,
    /// Damping ratio of the zeros.
    pub zeros: f64,
    /// Damping ratio of the poles.
    pub poles: f64,
}

/// The law of the servo: u = κ·N·(kp·e + ki·∫e + kd·ė), κ the instrument's own.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Law {
    /// Proportional.
    pub kp: f64,
    /// Integral, 1/s.
    pub ki: f64,
    /// Derivative, s.
    pub kd: f64,
    /// Notch filters that are on.
    pub notches: Vec<NotchValues>,
}

/// Where an axis is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Whether the servo is on.
    pub closed: bool,
    /// Target of the servo.
    pub target: f64,
    /// In V.
    pub voltage: f64,
    /// Measured.
    pub position: f64,
}

/// An instrument, one axis of it. What fails says why.
pub trait Station {
    /// Who it is, and which axis.
    fn describe(&self) -> String;

    /// Number of the axis in the instrument, from 1.
    fn number(&self) -> usize;

    /// Length of a servo cycle in s.
    fn cycle(&self) -> f64;

    /// Most points of a wave, most rows of a record.
    fn most(&self) -> (usize, usize);

    /// Least and greatest target.
    fn travel(&self) -> [f64; 2];

    /// Whether its address asks for an open loop.
    fn is_open_loop(&self) -> bool;

    /// Where the axis is.
    ///
    /// # Errors
    /// The instrument says no, or nothing.
    fn place(&mut self) -> Result<Place, String>;

    /// Switches the servo.
    ///
    /// # Errors
    /// The instrument says no, or nothing.
    fn servo(&mut self, closed: bool) -> Result<(), String>;

    /// Commands a target, or a voltage with the servo off.
    ///
    /// # Errors
    /// The instrument says no, or nothing.
    fn command(&mut self, closed: bool, value: f64) -> Result<(), String>;

    /// Plays a wave from where it begins, and reads what was recorded.
    ///
    /// # Errors
    /// The instrument says no, or nothing.
    fn run(&mut self, wave: &Wave) -> Result<Recorded, String>;

    /// Where an input signal is that shall give the targets.
    ///
    /// # Errors
    /// The instrument says no, or nothing; or has no such inputs.
    fn input(&mut self, number: u32) -> Result<Input, String> {
        Err(no_input(number))
    }

    /// Connects the targets of the axis to an input signal, records, and connects them as they were. `go_on`: false
    /// ends it early.
    ///
    /// # Errors
    /// The instrument says no, or nothing; or it ended early.
    fn follow(&mut self, follow: &Follow, _: &dyn Fn() -> bool) -> Result<Recorded, String> {
        Err(no_input(follow.input))
    }

    /// Reads the law of the servo.
    ///
    /// # Errors
    /// The instrument says no, or nothing.
    fn law(&mut self) -> Result<Law, String>;

    /// Writes the law of the servo, until the next power-up, and reads it back.
    ///
    /// # Errors
    /// The instrument says no, or nothing; or has other values afterwards.
    fn set_law(&mut self, law: &Law) -> Result<(), String>;

    /// How many notch filters it has, and those that it can have at a frequency, from narrow to wide.
    fn notches(&self, frequency: f64) -> (usize, Vec<NotchValues>);
}

fn no_input(number: u32) -> String {
    format!(
        "the targets cannot come from input signal {number} here; gcs://IP and nv200://IP can do that"
    )
}

/// Leads the axis to a target or a voltage in small steps.
///
/// # Errors
/// What the instrument says.
pub fn lead(station: &mut dyn Station, closed: bool, value: f64) -> Result<(), String> {
    let place = station.place()?;
    if place.closed != closed {
        station.servo(closed)?;
    }
    let [least, greatest] = station.travel();
    let from = match (closed, place.closed) {
        (true, true) => place.target,
        // Of an axis that is thrown about the servo may have taken over anything.
        (true, false) => place.position.clamp(least, greatest),
        (false, _) => place.voltage,
    };
    for k in 1..=LEAD {
        let share = f64::from(k) / f64::from(LEAD);
        station.command(closed, from + share * (value - from))?;
        sleep(LEAD_STEP);
    }
    Ok(())
}

/// Waits until the position stays: the mean of some readings moves by less than `band`; for 5 s at most. The last mean.
///
/// # Errors
/// What the instrument says.
pub fn settled(station: &mut dyn Station, band: f64) -> Result<f64, String> {
    let mut before = f64::INFINITY;
    let mut mean = f64::NAN;
    for _ in 0..50 {
        mean = 0.0;
        for _ in 0..10 {
            mean += station.place()?.position / 10.0;
            sleep(Duration::from_millis(10));
        }
        if (mean - before).abs() <= band {
            break;
        }
        before = mean;
    }
    Ok(mean)
}

/// Plays a wave: leads the axis to its first point, plays, and leads the axis back to where it was, with the servo as it
/// was.
///
/// # Errors
/// The wave leaves the travel or is longer than the instrument takes; or what the instrument says.
pub fn play(station: &mut dyn Station, wave: &Wave) -> Result<Recorded, String> {
    let (points, rows) = station.most();
    let [least, greatest] = station.travel();
    let Some(first) = wave.points.first() else { return Err("the wave has no points".to_owned()) };
    if wave.points.len() > points || wave.rows > rows {
        return Err(format!(
            "the wave has {} points and {} rows are recorded; the instrument takes {points} and {rows}: give a shorter signal, or one of longer sample time",
            wave.points.len(),
            wave.rows
        ));
    }
    if let Some(bad) = wave.points.iter().find(|x| !x.is_finite()) {
        return Err(format!("the wave has the value {bad}; give finite ones"));
    }
    let outside = wave.points.iter().find(|x| wave.closed && !(least..=greatest).contains(*x));
    if let Some(outside) = outside {
        return Err(format!(
            "the wave has the target {outside}; the travel of the axis is from {least} to {greatest}"
        ));
    }
    let before = station.place()?;
    lead(station, wave.closed, *first)?;
    settled(station, 1e-5 * (greatest - least))?;
    let recorded = station.run(wave);
    let back = if before.closed { before.target } else { before.voltage };
    // The servo takes over where the axis is; from there to where it was.
    let returned = lead(station, before.closed, back);
    let recorded = recorded?;
    returned?;
    checked(recorded, wave.rows)
}

fn checked(recorded: Recorded, rows: usize) -> Result<Recorded, String> {
    let lengths = [&recorded.command, &recorded.voltage, &recorded.position].map(Vec::len);
    let is_short = |(at, length): (usize, &usize)| *length != rows && !(at == 1 && *length == 0);
    if lengths.iter().enumerate().any(is_short) {
        return Err(format!("the recorder gave {lengths:?} values where {rows} were asked for"));
    }
    Ok(recorded)
}

/// Records while the targets come from an input signal: leads the axis to where that is, connects it, records, and leads
/// the axis back to where it was, with the servo as it was. `go_on`: false ends it early.
///
/// # Errors
/// The signal is outside the travel, another one is connected, the record is longer than the instrument takes, or it
/// ended early; or what the instrument says.
pub fn follow(
    station: &mut dyn Station,
    follow: &Follow,
    go_on: &dyn Fn() -> bool,
) -> Result<Recorded, String> {
    let ((_, most), [least, greatest]) = (station.most(), station.travel());
    let number = follow.input;
    if follow.rows > most {
        return Err(format!(
            "{} rows are to be recorded; the instrument takes {most}: give more servo cycles per row, or a shorter time",
            follow.rows
        ));
    }
    let Input { connected, target } = station.input(number)?;
    if connected == number {
        // It works so by itself, and goes on.
        return checked(station.follow(follow, go_on)?, follow.rows);
    }
    if connected != 0 {
        return Err(format!(
            "input signal {connected} gives the targets of the axis already; record that one, or disconnect it first"
        ));
    }
    let outside = target.filter(|target| !(least..=greatest).contains(target));
    if let Some(target) = outside {
        return Err(format!(
            "input signal {number} asks for {target}, the travel of the axis is from {least} to {greatest}; scale the input with its offset and gain (parameters 0x02000200, 0x02000300), or change the signal"
        ));
    }
    let before = station.place()?;
    let begin = if before.closed { before.target } else { before.position };
    lead(station, true, target.unwrap_or(begin.clamp(least, greatest)))?;
    let recorded = station.follow(follow, go_on);
    // What is commanded now is no longer what was commanded last: on from where the axis is.
    let position = station.place().map(|place| place.position.clamp(least, greatest));
    let returned = position.and_then(|position| station.command(true, position)).and_then(|()| {
        let back = if before.closed { before.target } else { before.voltage };
        lead(station, before.closed, back)
    });
    let recorded = recorded?;
    returned?;
    checked(recorded, follow.rows)
}
