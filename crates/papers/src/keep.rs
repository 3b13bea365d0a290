//! What a reproduction leaves for others: its logs, and the blueprints of its machine, its model and its controller.

use data::{AxisBlueprint, Blueprint, CheckedBlueprint, Log, SignalBlueprint};
use identify::learned::{Arx, Machine};
use model::Kind;

use crate::matching::Response;
use crate::reproduce::control::{Tracked, arx_component};

/// Logs and blueprints of one part of a paper, each with its name.
#[derive(Default)]
pub struct Kept {
    logs: Vec<(String, Log)>,
    blueprints: Vec<(&'static str, Blueprint)>,
}

/// A log is kept in columns with their units.
type Columns<'a> = [(String, &'a str, &'a [f64])];

impl Kept {
    /// Names and logs.
    pub fn logs(&self) -> &[(String, Log)] {
        &self.logs
    }

    /// Names and blueprints.
    pub fn blueprints(&self) -> &[(&'static str, Blueprint)] {
        &self.blueprints
    }

    /// Keeps what another one keeps.
    pub(crate) fn append(&mut self, other: Self) {
        self.logs.extend(other.logs);
        self.blueprints.extend(other.blueprints);
    }

    /// Keeps a rig.
    pub(crate) fn rig(&mut self, name: &'static str, rig: &str) -> anyhow::Result<()> {
        if let Some(rig) = rigs::find(rig) {
            self.blueprint(name, Blueprint::parse(rig.blueprint, rig.name)?);
        }
        Ok(())
    }

    /// Keeps a blueprint.
    pub(crate) fn blueprint(&mut self, name: &'static str, blueprint: Blueprint) {
        self.blueprints.push((name, blueprint));
    }

    /// Keeps a plant that was fitted.
    pub(crate) fn model(&mut self, name: &str, model: &CheckedBlueprint) {
        let mut blueprint = model.blueprint().clone();
        blueprint.name = name.to_owned();
        self.blueprint("model", blueprint);
    }

    /// Keeps a learned machine, with the linear part behind it, as a plant.
    pub(crate) fn machine(
        &mut self,
        name: &str,
        [command, position]: [&str; 2],
        machine: &Machine,
        linear: Option<&Arx>,
        period: f64,
    ) -> anyhow::Result<()> {
        let mut blueprint = Blueprint::new(Kind::Plant, name, period);
        let table = machine.table().map_err(anyhow::Error::msg)?;
        blueprint.tables.insert("hysteresis.npy".into(), table);
        let mut axis = AxisBlueprint::new("x", command, position);
        axis.command = SignalBlueprint::of_unit(command).between(-1e3, 1e3);
        axis = axis.component(machine.component(false, "hysteresis.npy", period));
        if let Some(linear) = linear {
            axis = axis.component(arx_component(linear, period));
        }
        self.blueprint("model", blueprint.axis(axis));
        Ok(())
    }

    /// Keeps what an axis did under a command, and what a model makes of it.
    pub(crate) fn record(
        &mut self,
        name: &str,
        [command, position]: [&str; 2],
        run: &Response,
        model: Option<&[f64]>,
    ) -> anyhow::Result<()> {
        // Row k: the position before the command of row k acts. A model's row is the end of that sample.
        let rows = run.command.len();
        let first = run.position.first().copied().unwrap_or(0.0);
        let model: Option<Vec<f64>> =
            model.map(|y| std::iter::once(first).chain(y.iter().copied()).take(rows).collect());
        let mut columns = vec![
            ("command[1]".to_owned(), command, &run.command[..]),
            ("position[1]".to_owned(), position, &run.position[..rows]),
        ];
        if let Some(model) = &model {
            columns.push(("model[1]".to_owned(), position, model));
        }
        self.columns(&format!("record-{name}"), run.period, &columns)
    }

    /// Keeps a closed loop: what the controller was told, the commands, the positions.
    pub(crate) fn run(&mut self, name: &str, run: &Tracked, period: f64) -> anyhow::Result<()> {
        let mut columns: Vec<(String, &str, &[f64])> = Vec::new();
        let rows = run.rows();
        for (what, unit, all) in [
            ("reference", "um", &run.previewed),
            ("command", "V", &run.command),
            ("position", "um", &run.position),
        ] {
            let named = (1..)
                .zip(all)
                .map(|(axis, values)| (format!("{what}[{axis}]"), unit, &values[..rows]));
            columns.extend(named);
        }
        self.columns(&format!("loop-{name}"), period, &columns)
    }

    fn columns(&mut self, name: &str, period: f64, columns: &Columns<'_>) -> anyhow::Result<()> {
        let rows = columns.iter().map(|(.., values)| values.len()).min().unwrap_or(0);
        let name = file_name(name);
        let mut log = Log::new(&name, (0..rows).map(|k| k as f64 * period).collect())?;
        for (column, unit, values) in columns {
            log.add_column(column, Some(unit), values[..rows].to_vec())?;
        }
        self.logs.push((name, log));
        Ok(())
    }
}

/// Units of command and position.
pub(crate) const UNITS: [&str; 2] = ["V", "um"];

/// A name as files bear it: small letters, digits and single dashes.
fn file_name(name: &str) -> String {
    let mut all = String::new();
    for c in name.chars() {
        if c.is_ascii_alphanumeric() {
            all.push(c.to_ascii_lowercase());
        } else if !all.ends_with('-') {
            all.push('-');
        }
    }
    all.trim_matches('-').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_of_a_record_is_what_is_read_before_its_command_acts() {
        let run =
            Response { command: vec![1.0, 2.0], position: vec![0.0, 10.0, 20.0], period: 0.5 };
        let mut kept = Kept::default();
        kept.record("Test 1: NARX", UNITS, &run, Some(&[11.0, 21.0])).expect("columns");
        let (name, log) = &kept.logs()[0];
        assert_eq!(name, "record-test-1-narx");
        assert_eq!(log.time(), [0.0, 0.5]);
        let column = |name: &str| log.column(name).expect("a column").values.clone();
        assert_eq!(column("position[1]"), [0.0, 10.0]);
        assert_eq!(column("model[1]"), [0.0, 11.0]);
    }
}
