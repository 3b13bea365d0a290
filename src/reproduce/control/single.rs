//! Controllers of one axis, and what is judged on them.

use data::{AxisBlueprint, Blueprint, ComponentBlueprint, SignalBlueprint, Value};
use identify::Gains;
use model::Kind;

use super::bed::{Bed, Tracked};

/// A controller of one axis.
pub(super) struct Design {
    pub(super) period: f64,
    pub(super) command: (f64, f64),
    pub(super) start: f64,
    /// Rows that the reference runs ahead.
    pub(super) preview: usize,
    /// The law's type, `pid` or `incremental-pid`.
    pub(super) law: &'static str,
}

impl Design {
    /// The blueprint with this feedforward (with its tables), learning law, and these gains.
    pub(super) fn controller(
        &self,
        tables: &Blueprint,
        feedforward: &[ComponentBlueprint],
        learning: Option<ComponentBlueprint>,
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
        if let Some(law) = learning {
            axis = axis.component(law);
        }
        let mut law = ComponentBlueprint::new(self.law)
            .value("kp", gains.kp)
            .value("ki", gains.ki)
            .value("kd", gains.kd)
            .value("output_min", self.command.0)
            .value("output_max", self.command.1);
        if self.law == "pid" {
            law.set("derivative_filter", gains.derivative_filter);
        }
        blueprint.axis(axis.component(law))
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

/// The impulse response of a bed's only axis about a command.
pub(super) fn impulse(
    bed: &mut Bed,
    [middle, amplitude]: [f64; 2],
    period: f64,
    samples: usize,
) -> anyhow::Result<Vec<f64>> {
    bed.rest(&[middle], period)?;
    let mut machine = |u: f64| {
        let moved = bed.step(&[u]).map(|p| p[0]);
        moved.map_err(|e| identify::Error::Tuning { message: format!("{e:#}") })
    };
    Ok(identify::impulse_of(&mut machine, [middle, amplitude], samples, 4)?)
}

/// The ultimate gain of a bed's only axis by a relay.
pub(super) fn ultimate(
    bed: &mut Bed,
    point: [f64; 2],
    period: f64,
) -> anyhow::Result<identify::Ultimate> {
    bed.rest(&[point[0]], period)?;
    let mut machine = |u: f64| {
        let moved = bed.step(&[u]).map(|p| p[0]);
        moved.map_err(|e| identify::Error::Tuning { message: format!("{e:#}") })
    };
    Ok(identify::relay(&mut machine, period, point, 20)?)
}

/// A reference held at its first value for `rows` rows, then as given.
pub(super) fn with_rest(reference: &[f64], rows: usize) -> Vec<f64> {
    let first = reference.first().copied().unwrap_or(0.0);
    std::iter::repeat_n(first, rows).chain(reference.iter().copied()).collect()
}
