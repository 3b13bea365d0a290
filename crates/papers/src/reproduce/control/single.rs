//! Controllers of one axis, and what is judged on them.

use control::Gains;
use data::{AxisBlueprint, Blueprint, ComponentBlueprint, SignalBlueprint, Value};
use model::{Component as _, Kind, Tick};

use super::bed::{Bed, Tracked};

/// A controller of one axis.
pub(super) struct Design {
    pub(super) period: f64,
    pub(super) command: (f64, f64),
    pub(super) start: f64,
    /// Rows that the reference runs ahead.
    pub(super) preview: usize,
    /// Whether the PID is incremental, without a filter of its derivative.
    pub(super) incremental: bool,
    /// What the command goes through at the end.
    pub(super) notch: Option<Notch>,
}

/// The component `notch` of full depth.
#[derive(Clone, Copy)]
pub struct Notch {
    /// In Hz.
    pub frequency: f64,
    /// Damping of what it takes out.
    pub damping: f64,
}

impl Notch {
    fn component(self) -> ComponentBlueprint {
        let notch = ComponentBlueprint::new("notch").value("frequency", self.frequency);
        notch.value("damping", self.damping).value("depth", 0.0)
    }

    /// The component on the samples of a signal, from rest at `first`.
    fn filter(self, period: f64, first: f64) -> anyhow::Result<impl FnMut(f64) -> f64> {
        let notch = components::control::Notch;
        let sizes = notch.sizes(&[], period);
        let (mut coefficients, mut state) =
            (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
        notch
            .prepare(&[], &[self.frequency, self.damping, 0.0], period, &mut coefficients)
            .map_err(|violation| anyhow::anyhow!("notch: {violation}"))?;
        notch.rest(&coefficients, &[first], &mut state, &mut [first]);
        Ok(move |u| {
            let mut y = [u];
            let tick = Tick { index: 0, time: 0.0, period };
            notch.step(&coefficients, &mut state, tick, &[u], &mut y);
            y[0]
        })
    }
}

impl Design {
    /// The blueprint with this feedforward (with its tables) and these gains.
    pub(super) fn controller(
        &self,
        tables: &Blueprint,
        feedforward: &[ComponentBlueprint],
        gains: &Gains,
    ) -> Blueprint {
        let mut blueprint = Blueprint::new(Kind::Controller, "control", self.period);
        blueprint.tables = tables.tables.clone();
        let mut axis = AxisBlueprint::new("x", "V", "um");
        axis.command = SignalBlueprint::of_unit("V").between(self.command.0, self.command.1);
        axis.reference.start = Some(Value::Number(self.start));
        if self.preview > 0 {
            let ahead = self.preview as f64 * self.period;
            let preview = ComponentBlueprint::new("reference-preview");
            let longest = ahead.max(self.period) * 2.0;
            axis = axis.component(preview.value("longest", longest).value("preview", ahead));
        }
        for component in feedforward {
            axis = axis.component(component.clone());
        }
        let kind = if self.incremental { "incremental-pid" } else { "pid" };
        let mut law = ComponentBlueprint::new(kind)
            .value("kp", gains.kp)
            .value("ki", gains.ki)
            .value("kd", gains.kd)
            .value("output_min", self.command.0)
            .value("output_max", self.command.1);
        if !self.incremental {
            law.set("derivative_filter", gains.derivative_filter);
        }
        let axis = axis.component(law);
        blueprint.axis(match self.notch {
            Some(notch) => axis.component(notch.component()),
            None => axis,
        })
    }
}

/// Root mean square error over the last `part` of a run.
pub(super) fn rmse(run: &Tracked, part: f64) -> f64 {
    let rows = run.error[0].len();
    super::rms_of(&run.error, &[0], (rows as f64 * (1.0 - part)) as usize)
}

/// Whether the commands jump between the limits as those of an unstable loop do.
pub(super) fn is_unstable(run: &Tracked, (low, high): (f64, f64)) -> bool {
    let u = &run.command[0][run.command[0].len() / 2..];
    let jumps = u.windows(2).filter(|w| (w[1] - w[0]).abs() > 0.3 * (high - low)).count();
    jumps as f64 > 0.05 * u.len() as f64
}

/// A bed's only axis as a function, behind a notch.
fn behind<'a>(
    bed: &'a mut Bed,
    notch: Option<Notch>,
    period: f64,
    middle: f64,
) -> anyhow::Result<impl FnMut(f64) -> Result<f64, identify::Error> + 'a> {
    let mut filter = notch.map(|notch| notch.filter(period, middle)).transpose()?;
    Ok(move |u| {
        let u = filter.as_mut().map_or(u, |filter| filter(u));
        let moved = bed.step(&[u]).map(|p| p[0]);
        moved.map_err(|e| identify::Error::Tuning { message: format!("{e:#}") })
    })
}

/// The impulse response of a bed's only axis about a command.
pub fn impulse(
    bed: &mut Bed,
    [middle, amplitude]: [f64; 2],
    period: f64,
    samples: usize,
    notch: Option<Notch>,
) -> anyhow::Result<Vec<f64>> {
    bed.rest(&[middle], period)?;
    let mut machine = behind(bed, notch, period, middle)?;
    Ok(control::impulse_of(&mut machine, [middle, amplitude], samples, 4)?)
}

/// The ultimate gain of a bed's only axis by a relay.
pub(super) fn ultimate(
    bed: &mut Bed,
    point: [f64; 2],
    period: f64,
    notch: Option<Notch>,
) -> anyhow::Result<control::Ultimate> {
    bed.rest(&[point[0]], period)?;
    let mut machine = behind(bed, notch, period, point[0])?;
    Ok(control::relay(&mut machine, period, point, 20)?)
}

/// The frequency at which a bed's only axis rings after a step, as its samples see it, in Hz.
pub fn ringing(bed: &mut Bed, [middle, amplitude]: [f64; 2], period: f64) -> anyhow::Result<f64> {
    bed.rest(&[middle], period)?;
    let count = 1500;
    let y: Vec<f64> = (0..count)
        .map(|_| Ok(bed.step(&[middle + amplitude])?[0]))
        .collect::<anyhow::Result<_>>()?;
    // Differences take out creep; a window keeps the step's rest from hiding the peak.
    let change: Vec<f64> = y.windows(2).map(|w| w[1] - w[0]).collect();
    let strength = |f: f64| {
        let turn = std::f64::consts::TAU * f * period;
        let window = |k: usize| (std::f64::consts::PI * k as f64 / count as f64).sin();
        let sum = |part: fn(f64) -> f64| -> f64 {
            change.iter().enumerate().map(|(k, y)| y * window(k) * part(turn * k as f64)).sum()
        };
        sum(f64::sin).hypot(sum(f64::cos))
    };
    let highest = 0.5 / period;
    let (mut best, mut width) = (0.0, highest);
    for _ in 0..4 {
        let steps = if best == 0.0 { 2000 } else { 40 };
        let from = (best - width).max(0.05 * highest);
        let to = (best + width).min(0.98 * highest);
        let tried = (0..=steps).map(|k| from + (to - from) * f64::from(k) / f64::from(steps));
        best = tried
            .map(|f| (strength(f), f))
            .fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a })
            .1;
        width = 2.0 * (to - from) / f64::from(steps);
    }
    Ok(best)
}

/// A reference held at its first value for `rows` rows, then as given.
pub(super) fn with_rest(reference: &[f64], rows: usize) -> Vec<f64> {
    let first = reference.first().copied().unwrap_or(0.0);
    std::iter::repeat_n(first, rows).chain(reference.iter().copied()).collect()
}
