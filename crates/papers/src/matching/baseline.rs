//! The papers' phenomenological baselines: fitted as the papers fit them, without delay or lag.

use anyhow::anyhow;
use data::{AxisBlueprint, CheckedBlueprint, SignalBlueprint};
use identify::{Columns, Dynamics, Methods, Record, Settings, Silent, Target, identify};

use super::{Response, response, rms};

/// Part of each record that the identification wants held out; the papers hold out nothing.
const HELD_OUT: f64 = 0.05;

/// What is fitted.
pub(crate) struct Baseline<'a> {
    /// Name of the method; none: the static Prandtl–Ishlinskii model.
    pub(crate) method: Option<&'a str>,
    /// Thresholds of the plays in the command's unit, from 0.
    pub(crate) thresholds: Vec<f64>,
    /// Levels of a Preisach model.
    pub(crate) levels: usize,
    /// Whether delay, lag and mode are fitted too.
    pub(crate) dynamic: bool,
}

impl Baseline<'_> {
    /// The model fitted to these records of the truth.
    pub(crate) fn fit(&self, runs: &[&Response]) -> anyhow::Result<CheckedBlueprint> {
        let records: anyhow::Result<Vec<Record>> = runs.iter().map(|run| record(run)).collect();
        let settings = Settings {
            thresholds: Some(self.thresholds.clone()),
            hold_out: HELD_OUT,
            longest_delay: if self.dynamic { None } else { Some(0.0) },
            dynamics: if self.dynamic { Dynamics::Automatic } else { Dynamics::Static },
            methods: match self.method {
                None => Methods::default(),
                Some(name) => Methods::Named(vec![name.to_owned()]),
            },
            levels: self.levels,
            ..Settings::default()
        };
        let signal = |unit: &str| SignalBlueprint {
            unit: unit.to_owned(),
            min: Some((-1e6).into()),
            max: Some(1e6.into()),
            ..SignalBlueprint::default()
        };
        let target = Target {
            model: "baseline".into(),
            source: String::new(),
            axis: AxisBlueprint {
                command: signal("V"),
                position: SignalBlueprint { unit: "um".into(), ..SignalBlueprint::default() },
                ..AxisBlueprint::default()
            },
        };
        Ok(identify(&records?, &target, &settings, &mut Silent)?.plant)
    }
}

fn record(run: &Response) -> anyhow::Result<Record> {
    let time: Vec<f64> = (0..run.command.len()).map(|k| k as f64 * run.period).collect();
    let columns = Columns {
        name: "run",
        time: &time,
        input_name: "u",
        input: &run.command,
        output_name: "y",
        output: &run.position[..time.len()],
    };
    let first = |problems: Vec<identify::Problem>| {
        problems.first().map_or_else(|| anyhow!("no record"), |p| anyhow!("{p}"))
    };
    Record::new(columns).map_err(first)
}

/// Rms of truth less model over a run, in the position's unit.
pub(crate) fn error(plant: &CheckedBlueprint, run: &Response) -> anyhow::Result<f64> {
    let model = simulated(plant, run)?;
    Ok(rms((0..model.len()).map(|k| run.position[k] - model[k])))
}

/// What the model does under a run's command.
pub(crate) fn simulated(plant: &CheckedBlueprint, run: &Response) -> anyhow::Result<Vec<f64>> {
    // A model that was fitted at one period is run at another's.
    let mut blueprint = plant.blueprint().clone();
    blueprint.step = run.period.into();
    let mut system = blueprint.check(learned::COMPONENTS)?.build();
    response(&mut system, 1, &run.command, run.period)
}
