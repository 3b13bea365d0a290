//! From a plan to a system that is ready to run.

use std::collections::{HashMap, HashSet};

use modeldescription::ModelDescription;
use modeldescription::description::Unit;
use modeldescription::ssp::ParameterValue;
use modeldescription::variable::{Causality, DataType};

use super::{Coupling, Plan, PlannedConnection, PlannedStart};
use crate::algorithm::{Algorithm, Extrapolation, GaussSeidel, Iteration, Jacobi};
use crate::diagram::Diagram;
use crate::error::Error;
use crate::port::Port;
use crate::problem::{Problem, Problems};
use crate::slave::{Address, Index, Slave, Value, numbers, unrecorded};
use crate::system::System;

/// A multiple of the communication step that misses a whole number by less than this part is one.
const ROUNDING: f64 = 1e-6;

/// A system, and how it is stepped.
pub struct Prepared {
    /// The system.
    pub system: System,
    /// How it is stepped.
    pub algorithm: Box<dyn Algorithm>,
    /// What was ignored.
    pub notes: Vec<String>,
    /// Inputs, as `fmu.variable`, that nothing feeds and that the plan gives no start value.
    pub unfed: Vec<String>,
}

impl Plan {
    /// The communication step in s, where the plan or its FMUs say one: that of the plan, else the
    /// smallest step that an FMU has by the plan or prefers by its description.
    pub fn step(&self, descriptions: &[&ModelDescription]) -> Option<f64> {
        let preferred = |description: &&ModelDescription| {
            description.default_experiment.as_ref().and_then(|experiment| experiment.step_size)
        };
        let steps = self.fmus.iter().filter_map(|fmu| fmu.step);
        let steps = steps.chain(descriptions.iter().filter_map(preferred));
        let smallest = steps.filter(|step| *step > 0.0).reduce(f64::min);
        self.master.step.or(smallest)
    }

    /// Columns of the input table that are needed.
    pub fn columns(&self) -> Vec<&str> {
        let mut known = HashSet::new();
        let columns = self.inputs.iter().map(|input| input.column.as_str());
        columns.filter(|column| known.insert(*column)).collect()
    }

    /// Connects the slaves, which are instances of the FMUs in their order. `step` is the
    /// communication step in s; `units` are those of columns of the input table, where known.
    ///
    /// # Errors
    /// All problems: variables that do not exist or do not fit, units that do not convert, steps
    /// that are no multiples of the communication step.
    pub fn prepare(
        &self,
        slaves: Vec<Box<dyn Slave>>,
        step: f64,
        units: &[(String, Unit)],
    ) -> Result<Prepared, Error> {
        let mut problems = Vec::new();
        let mut notes = self.notes.clone();
        let mut diagram = Diagram::new();
        let known = Slaves::of(&slaves);
        for start in &self.starts {
            self.start(&known, start, &mut diagram, &mut notes, &mut problems);
        }
        let units: HashMap<&str, &Unit> =
            units.iter().map(|(n, unit)| (n.as_str(), unit)).collect();
        for input in &self.inputs {
            let unit = units.get(input.column.as_str()).map(|unit| Unit::clone(unit));
            let (column, to, way) = (input.column.clone(), input.to.clone(), input.way.clone());
            diagram.feed_at(column, unit, to, way, &input.place);
        }
        let connections = self.directed(&known);
        for PlannedConnection { from, to, way, place } in connections.clone() {
            diagram.connect_at(from, to, way, &place);
        }
        for fmu in &self.fmus {
            match multiple(fmu.step, step) {
                Ok(1) => {}
                Ok(every) => {
                    diagram.every(&fmu.name, every);
                }
                Err(what) => problems.push(Problem::Pace { slave: fmu.name.clone(), what }),
            }
        }
        for (port, name) in self.recorded(&slaves, &connections) {
            diagram.record_as(port, name);
        }
        if self.record.is_empty() {
            notes.extend(
                slaves.iter().filter_map(|slave| unrecorded(slave.name(), slave.description())),
            );
        }
        slaves.into_iter().for_each(|slave| {
            diagram.add(slave);
        });
        let system = match diagram.build() {
            Ok(system) if problems.is_empty() => system,
            built => {
                problems.extend(built.err().into_iter().flat_map(|problems| problems.0));
                return Err(Problems(problems).into());
            }
        };
        let unfed = unfed(&system);
        let algorithm = self.algorithm(&system)?;
        Ok(Prepared { system, algorithm, notes, unfed })
    }

    /// The values that the plan gives the structural parameters of one FMU, with which it is to be
    /// configured before it is instantiated.
    ///
    /// # Errors
    /// A value that is none.
    pub fn structure(
        &self,
        fmu: &str,
        description: &ModelDescription,
    ) -> Result<Vec<(String, Value)>, Error> {
        let mut structure = Vec::new();
        for start in self.starts.iter().filter(|start| start.to.slave == fmu) {
            let found = description.variable(&start.to.variable);
            let Some(variable) = found.filter(|v| v.causality == Causality::StructuralParameter)
            else {
                continue;
            };
            let address = Address::of(variable);
            let value = value_for(description, &address, start, 0).map_err(|why| {
                let (slave, variable) = (fmu.to_owned(), variable.name.clone());
                Problems::from(Problem::StartValue {
                    slave,
                    variable,
                    value: start.place.clone(),
                    why,
                })
            })?;
            structure.push((variable.name.clone(), value));
        }
        Ok(structure)
    }

    fn algorithm(&self, system: &System) -> Result<Box<dyn Algorithm>, Problems> {
        let order: Vec<&str> = self.master.order.iter().map(String::as_str).collect();
        Ok(match self.master.coupling {
            Coupling::Jacobi => Box::new(Jacobi),
            Coupling::Extrapolation => Box::new(Extrapolation::new(system)?),
            Coupling::GaussSeidel if order.is_empty() => {
                Box::new(GaussSeidel::by_dependency(system))
            }
            Coupling::GaussSeidel => Box::new(GaussSeidel::in_order(system, &order)?),
            Coupling::Iteration => Box::new(Iteration::new(system, self.master.iteration)?),
        })
    }

    /// The connections from output to input, those of arrays element by element.
    fn directed(&self, slaves: &Slaves<'_>) -> Vec<PlannedConnection> {
        let description = |port: &Port| slaves.description(&port.slave);
        let variable = |port: &Port| slaves.index.variable(description(port)?, &port.variable);
        let is = |port: &Port, causality| variable(port).is_some_and(|v| v.causality == causality);
        let elements = |port: &Port| -> Vec<Port> {
            let array = variable(port).filter(|variable| !variable.dimensions.is_empty());
            let names = array.zip(description(port)).map(|(v, d)| numbers(d, v));
            let port_of = |name: &String| Port::from((port.slave.as_str(), name.as_str()));
            names.unwrap_or_default().iter().map(port_of).collect()
        };
        let mut directed = Vec::new();
        for connection in &self.connections {
            let PlannedConnection { mut from, mut to, way, place } = connection.clone();
            let backwards = !is(&from, Causality::Output) && is(&to, Causality::Output);
            if self.undirected && backwards {
                std::mem::swap(&mut from, &mut to);
            }
            let (sources, targets) = (elements(&from), elements(&to));
            if sources.is_empty() || sources.len() != targets.len() {
                directed.push(PlannedConnection { from, to, way, place });
                continue;
            }
            let pairs = sources.into_iter().zip(targets);
            directed.extend(pairs.map(|(from, to)| PlannedConnection {
                from,
                to,
                way: way.clone(),
                place: place.clone(),
            }));
        }
        directed
    }

    /// What is recorded, and under which names.
    fn recorded(
        &self,
        slaves: &[Box<dyn Slave>],
        connections: &[PlannedConnection],
    ) -> Vec<(Port, String)> {
        if !self.record.is_empty() {
            return self.record.clone();
        }
        let mut ports: Vec<Port> = self.inputs.iter().map(|input| input.to.clone()).collect();
        ports.extend(connections.iter().map(|connection| connection.to.clone()));
        for slave in slaves {
            let description = slave.description();
            let outputs = description.variables.iter().filter(|v| v.causality == Causality::Output);
            let names = outputs.flat_map(|variable| numbers(description, variable));
            ports.extend(names.map(|name| Port::from((slave.name(), name.as_str()))));
        }
        let known: HashSet<Port> = ports.iter().cloned().collect();
        let mut further = HashSet::new();
        for port in connections.iter().map(|connection| &connection.from) {
            if !known.contains(port) && further.insert(port) {
                ports.push(port.clone());
            }
        }
        // What is fed twice is an error of its own.
        let mut once = HashSet::new();
        ports.retain(|port| once.insert(port.clone()));
        let named = |port: Port| {
            let name = format!("{}.{}", port.slave, port.variable);
            (port, name)
        };
        ports.into_iter().map(named).collect()
    }

    fn start(
        &self,
        slaves: &Slaves<'_>,
        start: &PlannedStart,
        diagram: &mut Diagram,
        notes: &mut Vec<String>,
        problems: &mut Vec<Problem>,
    ) {
        let Port { slave, variable } = &start.to;
        let Some(description) = slaves.description(slave) else {
            let problem = Problem::NoSuchSlave { name: slave.clone(), there: String::new() };
            problems.push(problem.at(&start.place));
            return;
        };
        let several = count(&start.value) > 1;
        // An array of several dimensions gets its values row by row.
        let found = slaves.index.variable(description, variable);
        let elements = found.map(|v| numbers(description, v));
        let elements = elements.filter(|names| names.len() == count(&start.value));
        let names = elements.unwrap_or_default();
        for i in 0..count(&start.value) {
            let name = match names.get(i) {
                Some(name) => name.clone(),
                None if several => format!("{variable}[{}]", i + 1),
                None => variable.clone(),
            };
            let address = match slaves.index.find(slave, description, &name) {
                Ok(address) => address,
                Err(_) if start.optional => {
                    notes
                        .push(format!("{} is ignored: FMU `{slave}` has no `{name}`", start.place));
                    continue;
                }
                Err(problem) => {
                    problems.push(problem.at(&start.place));
                    continue;
                }
            };
            match value_for(description, &address, start, i) {
                Ok(value) => {
                    diagram.start_at((slave, &name).into(), value, &start.place);
                }
                Err(why) => problems.push(Problem::StartValue {
                    slave: slave.clone(),
                    variable: name,
                    value: start.place.clone(),
                    why,
                }),
            }
        }
    }
}

/// Descriptions by the names of the slaves, and variables by their names.
struct Slaves<'a> {
    descriptions: HashMap<&'a str, &'a ModelDescription>,
    index: Index,
}

impl<'a> Slaves<'a> {
    fn of(slaves: &'a [Box<dyn Slave>]) -> Self {
        let named = slaves.iter().map(|slave| (slave.name(), slave.description()));
        Slaves { descriptions: named.collect(), index: Index::default() }
    }

    fn description(&self, name: &str) -> Option<&'a ModelDescription> {
        self.descriptions.get(name).copied()
    }
}

fn count(value: &ParameterValue) -> usize {
    match value {
        ParameterValue::Real(values) => values.len(),
        ParameterValue::Integer(values) => values.len(),
        ParameterValue::Boolean(values) => values.len(),
        ParameterValue::Text(texts) => texts.len(),
        ParameterValue::Enumeration(items, _) => items.len(),
        ParameterValue::Binary(_) => 1,
    }
}

/// A start value as the variable takes it, in its unit.
fn value_for(
    description: &ModelDescription,
    address: &Address,
    start: &PlannedStart,
    i: usize,
) -> Result<Value, String> {
    let missing = || "there is no value".to_owned();
    match &start.value {
        ParameterValue::Real(values) => {
            let value = values.get(i).copied().ok_or_else(missing)?;
            let properties = description.properties(&address.variable);
            let unit = properties.unit.as_deref().and_then(|name| description.unit(name));
            let differences = properties.relative_quantity.unwrap_or(false);
            Ok(Value::Real(start.way.conversion(None, unit, differences)?.apply(value)))
        }
        ParameterValue::Integer(values) => {
            values.get(i).map(|value| Value::Integer((*value).into())).ok_or_else(missing)
        }
        ParameterValue::Boolean(values) => {
            values.get(i).copied().map(Value::Boolean).ok_or_else(missing)
        }
        ParameterValue::Text(texts) => texts.get(i).cloned().map(Value::Text).ok_or_else(missing),
        ParameterValue::Enumeration(items, _) => {
            let item = items.get(i).ok_or_else(missing)?;
            let declared = description.declared_type(&address.variable);
            let known = declared.map(|declared| declared.items.as_slice()).unwrap_or_default();
            let found = known.iter().find(|known| known.name == *item);
            found.map(|found| Value::Integer(found.value.into())).ok_or_else(|| {
                let names: Vec<&str> = known.iter().map(|known| known.name.as_str()).collect();
                format!("\"{item}\" is no item of its enumeration: {}", names.join(", "))
            })
        }
        ParameterValue::Binary(_) if address.variable.data_type == DataType::Binary => {
            Err("binary values are not set".to_owned())
        }
        ParameterValue::Binary(_) => Err("the variable is not binary".to_owned()),
    }
}

/// Inputs that nothing feeds and that have no start value of the plan.
fn unfed(system: &System) -> Vec<String> {
    let mut names = Vec::new();
    for participant in &system.participants {
        let (slave, description) = (participant.slave.name(), participant.slave.description());
        let given = participant.starts_before.iter().chain(&participant.starts_during);
        let given: HashSet<&str> = given.map(|(name, _)| name.as_str()).collect();
        let inputs = description.variables.iter().filter(|v| v.causality == Causality::Input);
        let all = inputs.flat_map(|input| numbers(description, input));
        let is_fed = |name: &String| {
            given.contains(name.as_str()) || participant.driven.position(name).is_some()
        };
        names.extend(all.filter(|name| !is_fed(name)).map(|name| format!("{slave}.{name}")));
    }
    names
}

/// How many communication steps an FMU's own step has.
fn multiple(own: Option<f64>, step: f64) -> Result<usize, String> {
    let Some(own) = own else { return Ok(1) };
    let ratio = own / step;
    let integer = ratio.round();
    if (ratio - integer).abs() <= ROUNDING * ratio && (1.0..=1e15).contains(&integer) {
        return Ok(integer as usize);
    }
    Err(format!(
        "over {own} s, which is no multiple of the communication step of {step} s; choose a \
         communication step that divides the steps of all FMUs"
    ))
}
