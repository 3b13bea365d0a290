//! From a plan to a cycle that can run.

use std::path::Path;

use cosim::Fmu;
use modeldescription::variable::Causality;
use serde_json::json;
use sha2::{Digest, Sha256};

use super::sequence::{Channel, Table};
use super::{AxisPlan, Plan, PlanError};
use crate::cycle::{self, Column, ControllerError, Cycle, Driver, Player, Setup};
use crate::replay::{Recipe, RecipeAxis};
use crate::runner::Settings;
use crate::safety::{AxisLimits, Watch};

/// Everything that a run needs.
#[derive(Debug)]
pub struct Prepared {
    /// The cycle.
    pub cycle: Cycle,
    /// How the runner goes about it.
    pub settings: Settings,
    /// Columns of the record.
    pub columns: Vec<Column>,
    /// Where the record comes from.
    pub provenance: serde_json::Map<String, serde_json::Value>,
    /// What a person should know before it runs.
    pub notes: Vec<String>,
    /// Seconds that are played.
    pub seconds: f64,
}

/// One axis with everything decided.
struct Axis {
    reference: Channel,
    position: Channel,
    command: Channel,
    measured: String,
    limits: AxisLimits,
}

impl Plan {
    /// Opens the controller, makes the table of references, sets the limits.
    ///
    /// # Errors
    /// Every problem of the plan; or what the FMU says.
    pub fn prepare(
        &self,
        fmu: Option<&Fmu>,
        fmu_file: Option<&Path>,
    ) -> Result<Prepared, PlanError> {
        let mut problems = Vec::new();
        let mut notes = Vec::new();
        let period_ns = self.period(&mut problems);
        let period = period_ns as f64 / 1e9;
        let watch = self.watch(&mut problems);
        let axes = self.all_axes(fmu, &mut problems, &mut notes);
        notes.extend(fmu.and_then(|fmu| other_sample_time(fmu, period)));
        if let Some(data) = &self.ethercat {
            let name = self.name();
            let found = data.problems(axes.len());
            problems.extend(found.into_iter().map(|problem| format!("{name}: {problem}")));
        }
        let seconds = |value: Option<f64>, default: f64, name: &str, problems: &mut Vec<String>| {
            let value = value.unwrap_or(default);
            if !(0.0..=1e6).contains(&value) {
                problems.push(format!("{}: {name} = {value} must be 0 s or more", self.name()));
            }
            (value / period).round()
        };
        let settle = seconds(self.settle, 0.1, "settle", &mut problems);
        let approach = seconds(self.approach, 0.2, "approach", &mut problems);
        let blend = seconds(self.blend, 0.1, "blend", &mut problems);
        let patience = seconds(self.patience, 10.0, "patience", &mut problems);
        if !problems.is_empty() {
            return Err(PlanError(problems));
        }
        let pick = |of: fn(&Axis) -> &Channel| axes.iter().map(of).cloned().collect::<Vec<_>>();
        let (commands, positions) = (pick(|axis| &axis.command), pick(|axis| &axis.position));
        let played = if fmu.is_some() { pick(|axis| &axis.reference) } else { commands.clone() };
        let (table, message) = Table::new(self, &played, period, fmu.is_some()).rows()?;
        notes.extend(message);
        let player = Player::new(axes.len(), table, approach as u32);
        let seconds = player.rows() as f64 * period;
        let driver = match fmu {
            Some(fmu) => self.controller(fmu, &axes, period)?,
            None => Driver::Direct,
        };
        let first_sequence = (crate::clock::now_ns() / 1000) as u32;
        let setup = Setup {
            period_ns,
            driver,
            player,
            limits: axes.iter().map(|axis| axis.limits).collect(),
            watch,
            blend: blend as u32,
            first_sequence,
        };
        // Without a controller the reference is the command itself, under a name of its own.
        let references = match fmu {
            Some(_) => pairs(&played),
            None => {
                pairs(&commands).into_iter().map(|(n, u)| (format!("planned.{n}"), u)).collect()
            }
        };
        let has_controller = fmu.is_some();
        let columns =
            cycle::columns(&references, &pairs(&positions), &pairs(&commands), has_controller);
        let settings =
            Settings { period_ns, settle: settle as u64, patience: patience.max(1.0) as u64 };
        let recipe = self.recipe(&columns, &axes, period_ns, blend as u32);
        let provenance = self.provenance(fmu, fmu_file, period_ns, &recipe)?;
        Ok(Prepared { cycle: Cycle::new(setup), settings, columns, provenance, notes, seconds })
    }

    fn period(&self, problems: &mut Vec<String>) -> u64 {
        let rate = self.rate.unwrap_or(f64::NAN);
        if !(0.1..=200e3).contains(&rate) {
            let given = self.rate.map_or("is not given".to_owned(), |rate| format!("is {rate} Hz"));
            problems.push(format!(
                "{}: the rate {given}; give 0.1 Hz to 200 kHz with rate = 10000 or --rate 10k",
                self.name()
            ));
            return 1_000_000;
        }
        (1e9 / rate).round() as u64
    }

    fn watch(&self, problems: &mut Vec<String>) -> Watch {
        let (default, given) = (Watch::default(), self.watch);
        let watch = Watch {
            hold: given.hold.unwrap_or(default.hold),
            max_age: given.max_age.unwrap_or(default.max_age),
            tracking: given.tracking.unwrap_or(default.tracking),
            stuck: given.stuck.unwrap_or(default.stuck),
            saturated: given.saturated.unwrap_or(default.saturated),
            overrun: given.overrun.unwrap_or(default.overrun),
        };
        if watch.hold > 1_000_000 || watch.max_age > 1_000_000 {
            let name = self.name();
            problems.push(format!("{name}: [watch] hold and max_age are at most 1000000 cycles"));
        }
        watch
    }

    fn all_axes(
        &self,
        fmu: Option<&Fmu>,
        problems: &mut Vec<String>,
        notes: &mut Vec<String>,
    ) -> Vec<Axis> {
        let found = fmu.map_or(0, |fmu| {
            let outputs = fmu.names(Causality::Output);
            outputs.iter().filter(|name| name.starts_with("command[")).count()
        });
        let count = if self.axes.is_empty() { found } else { self.axes.len() };
        let measured = fmu.map_or(found, |fmu| {
            let inputs = fmu.names(Causality::Input);
            inputs.iter().filter(|name| name.starts_with("measured[")).count()
        });
        if self.axes.is_empty() && found > 0 && measured != found {
            problems.push(format!(
                "{}: the controller has {found} outputs command[i] and {measured} inputs measured[i]; \
                 a bench has one position for each command (docs/gateway.md, Channels): choose the \
                 pairs with [[axis]] command = …, measured = …",
                self.name()
            ));
            return Vec::new();
        }
        if count == 0 || count > crate::packet::MAX_CHANNELS {
            problems.push(format!(
                "{}: {count} axes; give 1 to {} with [[axis]] (without them, the controller's \
                 outputs command[1], command[2], … are taken)",
                self.name(),
                crate::packet::MAX_CHANNELS
            ));
            return Vec::new();
        }
        (0..count)
            .map(|index| {
                let axis = self.axes.get(index).unwrap_or(&self.other_axes);
                self.axis(axis, index + 1, fmu, problems, notes)
            })
            .collect()
    }

    fn axis(
        &self,
        axis: &AxisPlan,
        number: usize,
        fmu: Option<&Fmu>,
        problems: &mut Vec<String>,
        notes: &mut Vec<String>,
    ) -> Axis {
        let or = |given: &Option<String>, word: &str| {
            given.clone().unwrap_or_else(|| format!("{word}[{number}]"))
        };
        let (command, measured) = (or(&axis.command, "command"), or(&axis.measured, "measured"));
        let (reference, position) =
            (or(&axis.reference, "reference"), or(&axis.position, "position"));
        let mut unit = |name: &str, given: &Option<String>| {
            let variable = fmu.map(|fmu| fmu.variable(name));
            match variable {
                Some(Ok(variable)) => given.clone().or(variable.properties.unit),
                Some(Err(error)) => {
                    problems.push(format!("{}: axis {number}: {error}", self.name()));
                    None
                }
                None => given.clone(),
            }
        };
        let command_unit = unit(&command, &axis.command_unit);
        let position_unit = unit(&measured, &axis.position_unit);
        let reference_unit = unit(&reference, &axis.position_unit);
        let limits = self.limits(axis, number, fmu, &command, problems, notes);
        Axis {
            reference: Channel { name: reference, unit: reference_unit },
            position: Channel { name: position, unit: position_unit },
            command: Channel { name: command, unit: command_unit },
            measured,
            limits,
        }
    }

    fn limits(
        &self,
        axis: &AxisPlan,
        number: usize,
        fmu: Option<&Fmu>,
        command: &str,
        problems: &mut Vec<String>,
        notes: &mut Vec<String>,
    ) -> AxisLimits {
        let none = [f64::NEG_INFINITY, f64::INFINITY];
        let declared = fmu.and_then(|fmu| fmu.variable(command).ok()).map(|variable| {
            let range = &variable.properties;
            [
                range.min.map_or(none[0], |min| min.as_f64()),
                range.max.map_or(none[1], |max| max.as_f64()),
            ]
        });
        let limits = axis.command_limits.or(declared).unwrap_or(none);
        if limits.iter().any(|limit| limit.is_infinite()) {
            notes.push(format!(
                "axis {number}: NO LIMITS of the command are known; give command_limits = [MIN, MAX] \
                 in the plan, or --command-limits MIN..MAX"
            ));
        }
        let free = f64::INFINITY;
        let width = limits[1] - limits[0];
        let or = |given: Option<f64>| given.unwrap_or(free);
        let result = AxisLimits {
            command: limits,
            command_rate: or(axis.command_rate),
            position: axis.position_limits.unwrap_or(none),
            position_rate: or(axis.position_rate),
            tracking_error: or(axis.tracking_error),
            safe: axis.safe.unwrap_or(0.0_f64.max(limits[0]).min(limits[1])),
            safe_rate: axis.safe_rate.unwrap_or(if width.is_finite() {
                10.0 * width
            } else {
                free
            }),
        };
        let mut must = |holds: bool, rule: &str| {
            if !holds {
                problems.push(format!("{}: axis {number}: {rule}", self.name()));
            }
        };
        must(limits[0] < limits[1], "command_limits = [MIN, MAX] with MIN < MAX");
        must(
            result.position[0] < result.position[1],
            "position_limits = [MIN, MAX] with MIN < MAX",
        );
        let inside = (limits[0]..=limits[1]).contains(&result.safe);
        must(inside && result.safe.is_finite(), "safe must lie within command_limits");
        let rates = [result.command_rate, result.position_rate, result.safe_rate];
        let positive = rates.iter().chain([&result.tracking_error]).all(|limit| *limit > 0.0);
        must(positive, "rates and tracking_error must be greater than 0");
        result
    }

    fn controller(&self, fmu: &Fmu, axes: &[Axis], period: f64) -> Result<Driver, PlanError> {
        let names = |of: fn(&Axis) -> &String| axes.iter().map(of).cloned().collect::<Vec<_>>();
        let message = |error: ControllerError| PlanError::one(format!("{}: {error}", self.name()));
        let driver = Driver::controller(
            fmu,
            &names(|axis| &axis.reference.name),
            &names(|axis| &axis.measured),
            &names(|axis| &axis.command.name),
            &self.start,
            period,
        );
        driver.map_err(message)
    }

    /// What a replay needs beside the rows.
    fn recipe(&self, columns: &[Column], axes: &[Axis], period_ns: u64, blend: u32) -> Recipe {
        // The references' columns have names of their own where the plan plays commands.
        let references = columns.iter().skip(1).map(|column| column.name.clone());
        let axis = |(axis, column): (&Axis, String)| RecipeAxis {
            column,
            reference: axis.reference.name.clone(),
            position: axis.position.name.clone(),
            measured: axis.measured.clone(),
            command: axis.command.name.clone(),
            command_limits: axis.limits.command,
            command_rate: axis.limits.command_rate,
            safe: axis.limits.safe,
            safe_rate: axis.limits.safe_rate,
        };
        let axes = axes.iter().zip(references).map(axis).collect();
        Recipe { version: Recipe::VERSION, period_ns, blend, start: self.start.clone(), axes }
    }

    fn provenance(
        &self,
        fmu: Option<&Fmu>,
        fmu_file: Option<&Path>,
        period_ns: u64,
        recipe: &Recipe,
    ) -> Result<serde_json::Map<String, serde_json::Value>, PlanError> {
        let mut all = serde_json::Map::new();
        let mut put = |key: &str, value: serde_json::Value| all.insert(key.to_owned(), value);
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        let start_ns = since.map_or(0, |time| u64::try_from(time.as_nanos()).unwrap_or(0));
        put("tool", json!(format!("piezoloop {}", env!("CARGO_PKG_VERSION"))));
        put("platform", json!(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)));
        put("start_ns", json!(start_ns));
        put("period_ns", json!(period_ns));
        put("gateway", json!(self.gateway));
        if let Some(description) = fmu.map(Fmu::description) {
            put("controller_model", json!(description.model_name));
            put("controller_guid", json!(description.instantiation_token));
        }
        put("replay", json!(recipe.to_toml().map_err(PlanError::one)?));
        for (name, file) in [("controller", fmu_file), ("plan", self.origin.as_deref())] {
            let Some(file) = file else { continue };
            let bytes = std::fs::read(file).map_err(|error| {
                PlanError::one(format!("{}: cannot be read: {error}", file.display()))
            })?;
            let hash = hex::encode(Sha256::digest(&bytes));
            // A record is read in other folders too.
            let file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
            put(name, json!(file.display().to_string()));
            put(&format!("{name}_sha256"), json!(hash));
            if let ("plan", Ok(text)) = (name, String::from_utf8(bytes)) {
                put("plan_text", json!(text));
            }
        }
        let seeds: Vec<f64> = self
            .sequence
            .iter()
            .filter_map(|step| match step {
                super::Step::Signal { set, .. } => set.get("seed").copied(),
                _ => None,
            })
            .collect();
        put("seeds", json!(seeds));
        Ok(all)
    }
}

/// What to know where the controller has another sample time than the bench.
fn other_sample_time(fmu: &Fmu, period: f64) -> Option<String> {
    let description = fmu.description();
    let co_simulation = description.co_simulation.as_ref();
    let fixed = co_simulation.and_then(|kind| kind.fixed_internal_step_size);
    let experiment = description.default_experiment.as_ref();
    let own = fixed.or_else(|| experiment.and_then(|experiment| experiment.step_size))?;
    let steps = period / own;
    // Periods are whole ns.
    let differs = (steps - 1.0).abs() > 1e-4 && own > 0.0;
    differs.then(|| {
        format!(
            "the controller's own step is {own} s, a cycle of the bench {period} s: it makes {steps:.3} \
             of its steps per cycle; --rate {:.6} would make one",
            1.0 / own
        )
    })
}

fn pairs(channels: &[Channel]) -> Vec<(String, Option<String>)> {
    channels.iter().map(|channel| (channel.name.clone(), channel.unit.clone())).collect()
}
