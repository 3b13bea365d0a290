//! How far our machines are from the papers': what a paper measured of its rig, its do-nothing errors, and what its
//! baseline models leave, run on our machines with the paper's signals. The machines were not made for these figures:
//! one that no plausible machine has is a finding.

pub(crate) mod baseline;
mod drive;
mod p0;
pub(crate) mod p1;
mod p2;
pub(crate) mod p3;
mod p4;

pub(crate) use self::drive::{Response, axis_driven, driven};
use anyhow::{Context, anyhow};
use data::Blueprint;
use model::System;
use serde::Serialize;

/// Greatest relative difference of a matched figure.
const TOLERANCE: f64 = 0.25;

/// One figure of a paper beside ours.
#[derive(Serialize)]
pub struct Figure {
    /// The rig that stands in for the paper's machine.
    pub rig: &'static str,
    /// What the paper prints.
    pub what: String,
    /// Unit of both values.
    pub unit: &'static str,
    /// The paper's value.
    pub paper: f64,
    /// The value of the rig.
    pub ours: f64,
    /// Whether they differ by 25 % of the paper's at most.
    pub within: bool,
    /// Whether the paper measured it of its rig by itself; else it is what a baseline leaves.
    pub of_rig: bool,
    /// What is to be known of the comparison.
    pub note: String,
}

impl Figure {
    fn new(
        rig: &'static str,
        what: impl Into<String>,
        unit: &'static str,
        paper: f64,
        ours: f64,
    ) -> Self {
        let within = (ours / paper - 1.0).abs() <= TOLERANCE;
        let (of_rig, note) = (false, String::new());
        Self { rig, what: what.into(), unit, paper, ours, within, of_rig, note }
    }

    fn of_rig(self) -> Self {
        Self { of_rig: true, ..self }
    }

    fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
}

/// The figures of one paper's machine.
pub type Table = fn() -> anyhow::Result<Vec<Figure>>;

/// All papers' machines, rig by rig.
pub const TABLES: [Table; 5] = [p0::figures, p1::figures, p2::figures, p3::figures, p4::figures];

/// A built rig.
pub(crate) fn rig(name: &str) -> anyhow::Result<System> {
    let rig = rigs::find(name).with_context(|| format!("there is no rig {name}"))?;
    let blueprint = Blueprint::parse(rig.blueprint, rig.name)?;
    Ok(blueprint.check(learned::COMPONENTS)?.build())
}

/// Sets the command of an axis, from 1.
pub(crate) fn command(system: &mut System, axis: usize, value: f64) -> anyhow::Result<()> {
    let reference = variable(system, &format!("command[{axis}]"))?;
    system.set(reference, value).map_err(|error| anyhow!(system.explain_set(&error)))
}

fn variable(system: &System, name: &str) -> anyhow::Result<u32> {
    system.variables().find(name).with_context(|| format!("{} has no {name}", system.name()))
}

pub(crate) fn position(system: &System, axis: usize) -> anyhow::Result<f64> {
    let reference = variable(system, &format!("position[{axis}]"))?;
    system.get(reference).context("a variable of the table")
}

/// At rest under these commands: the positions of all axes.
pub(crate) fn rest(system: &mut System, commands: &[f64]) -> anyhow::Result<Vec<f64>> {
    for (axis, value) in (1..).zip(commands) {
        command(system, axis, *value)?;
    }
    system.initialise(0.0).map_err(|error| anyhow!(system.explain(&error)))?;
    (1..=commands.len()).map(|axis| position(system, axis)).collect()
}

/// The position of `axis` at t = n·period while its command is `u`; row n is read before u[n] acts.
pub(crate) fn response(
    system: &mut System,
    axis: usize,
    u: &[f64],
    period: f64,
) -> anyhow::Result<Vec<f64>> {
    system.reset();
    command(system, axis, u.first().copied().unwrap_or(0.0))?;
    system.initialise(0.0).map_err(|error| anyhow!(system.explain(&error)))?;
    let mut y = Vec::with_capacity(u.len());
    for (n, value) in u.iter().enumerate() {
        y.push(position(system, axis)?);
        command(system, axis, *value)?;
        let end = (n + 1) as f64 * period;
        system.advance(end).map_err(|error| anyhow!(system.explain(&error)))?;
    }
    Ok(y)
}

/// A paper's signal: its only channel and its sample time.
pub(crate) fn signal(name: &str, settings: &[(&str, f64)]) -> anyhow::Result<(Vec<f64>, f64)> {
    let signal = signals::lookup(name)?.generate(settings)?;
    let channel = signal.channels.first().context("a signal has a channel")?;
    Ok((channel.values.clone(), signal.period))
}

pub(crate) fn extremes(values: &[f64]) -> (f64, f64) {
    let fold = |start: f64, pick: fn(f64, f64) -> f64| values.iter().copied().fold(start, pick);
    (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max))
}

pub(crate) fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(|x| x * x).sum::<f64>() / count).sqrt()
}
