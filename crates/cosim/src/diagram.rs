//! A system as its user draws it: not yet checked.

use std::collections::{HashMap, HashSet};

use modeldescription::ModelDescription;
use modeldescription::description::Unit;
use modeldescription::variable::{Causality, DataType, Variability, Variable};

use crate::port::Port;
use crate::problem::{Problem, Problems};
use crate::slave::{Address, Index, Settable, Slave, Value, can_be_triggered, settable};
use crate::system::{Participant, Recorded, System, Wire};
use crate::unit::{Conversion, Transformations};

/// An output that feeds an input, with unit conversion where both declare a unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// The output.
    pub from: Port,
    /// The input.
    pub to: Port,
}

/// A column of the input table that feeds an input or a tunable parameter.
#[derive(Clone, Debug)]
struct Feed {
    column: String,
    unit: Option<Unit>,
    to: Port,
    way: Transformations,
    /// Where it stands; empty: nowhere.
    place: String,
}

/// A [`Connection`] on its way.
struct Joined {
    connection: Connection,
    way: Transformations,
    /// Where it stands; empty: nowhere.
    place: String,
}

/// Slaves, what connects them, what feeds them and what is recorded. [`Diagram::build`] checks it.
#[derive(Default)]
pub struct Diagram {
    slaves: Vec<Box<dyn Slave>>,
    connections: Vec<Joined>,
    feeds: Vec<Feed>,
    starts: Vec<(Port, Value, String)>,
    records: Vec<(Port, Option<String>)>,
    paces: Vec<(String, usize)>,
}

impl Diagram {
    /// An empty diagram.
    pub fn new() -> Self {
        Diagram::default()
    }

    /// Adds a slave; its name must be new.
    pub fn add(&mut self, slave: Box<dyn Slave>) -> &mut Self {
        self.slaves.push(slave);
        self
    }

    /// Lets an output feed an input.
    pub fn connect(&mut self, from: impl Into<Port>, to: impl Into<Port>) -> &mut Self {
        self.connect_by(from, to, Transformations::default())
    }

    /// [`Diagram::connect`], with what happens to the values on their way.
    pub fn connect_by(
        &mut self,
        from: impl Into<Port>,
        to: impl Into<Port>,
        way: Transformations,
    ) -> &mut Self {
        self.connect_at(from.into(), to.into(), way, "")
    }

    /// [`Diagram::connect_by`], of a connection that stands at this place.
    pub(crate) fn connect_at(
        &mut self,
        from: Port,
        to: Port,
        way: Transformations,
        place: &str,
    ) -> &mut Self {
        let (connection, place) = (Connection { from, to }, place.to_owned());
        self.connections.push(Joined { connection, way, place });
        self
    }

    /// Lets a column of the input table feed an input or a tunable parameter. A column without a
    /// unit is in the variable's.
    pub fn feed(
        &mut self,
        column: impl Into<String>,
        unit: Option<Unit>,
        to: impl Into<Port>,
    ) -> &mut Self {
        self.feed_by(column, unit, to, Transformations::default())
    }

    /// [`Diagram::feed`], with what happens to the values on their way.
    pub fn feed_by(
        &mut self,
        column: impl Into<String>,
        unit: Option<Unit>,
        to: impl Into<Port>,
        way: Transformations,
    ) -> &mut Self {
        self.feed_at(column.into(), unit, to.into(), way, "")
    }

    /// [`Diagram::feed_by`], of a connection that stands at this place.
    pub(crate) fn feed_at(
        &mut self,
        column: String,
        unit: Option<Unit>,
        to: Port,
        way: Transformations,
        place: &str,
    ) -> &mut Self {
        self.feeds.push(Feed { column, unit, to, way, place: place.to_owned() });
        self
    }

    /// Lets a slave step once every `steps` communication steps, over all of them; see
    /// [`algorithm`](crate::algorithm) for what that means for its connections.
    pub fn every(&mut self, slave: impl Into<String>, steps: usize) -> &mut Self {
        self.paces.push((slave.into(), steps));
        self
    }

    /// Gives a parameter, or another variable with a start value, a value before each run.
    pub fn start(&mut self, variable: impl Into<Port>, value: impl Into<Value>) -> &mut Self {
        self.start_at(variable.into(), value.into(), "")
    }

    /// [`Diagram::start`], of a value that stands at this place.
    pub(crate) fn start_at(&mut self, variable: Port, value: Value, place: &str) -> &mut Self {
        self.starts.push((variable, value, place.to_owned()));
        self
    }

    /// Records a variable under its own name, or `slave.variable` where two slaves share it.
    pub fn record(&mut self, variable: impl Into<Port>) -> &mut Self {
        self.records.push((variable.into(), None));
        self
    }

    /// Records a variable under another name.
    pub fn record_as(&mut self, variable: impl Into<Port>, name: impl Into<String>) -> &mut Self {
        self.records.push((variable.into(), Some(name.into())));
        self
    }

    /// Checks the diagram and makes it ready to run.
    ///
    /// # Errors
    /// All problems: names that do not exist, variables in the wrong role, inputs with two
    /// sources, units that do not convert, values that cannot be set.
    pub fn build(self) -> Result<System, Problems> {
        let mut builder = Builder::new(self.slaves);
        builder.feeds(&self.feeds);
        builder.connections(&self.connections);
        builder.starts(self.starts);
        builder.records(&self.records);
        builder.paces(&self.paces);
        Problems::none_or(builder.problems, builder.system)
    }
}

/// Turns names into places, and collects problems.
struct Builder {
    index: Index,
    system: System,
    /// Places on the bus of the columns of the input table.
    columns: HashMap<String, usize>,
    /// For each participant what feeds its driven variables, for messages.
    sources: Vec<Vec<String>>,
    problems: Vec<Problem>,
}

impl Builder {
    fn new(slaves: Vec<Box<dyn Slave>>) -> Self {
        let mut names = HashSet::new();
        let again = slaves.iter().map(|slave| slave.name()).filter(|name| !names.insert(*name));
        let problems = again.map(|name| Problem::SameName { name: name.to_owned() }).collect();
        let sources = vec![Vec::new(); slaves.len()];
        let participants = slaves.into_iter().map(Participant::new).collect();
        let (index, columns) = (Index::default(), HashMap::new());
        Builder { index, system: System::new(participants), columns, sources, problems }
    }

    /// The columns come first on the bus, each once even if it feeds several inputs.
    fn feeds(&mut self, feeds: &[Feed]) {
        for feed in feeds {
            let known = self.columns.get(&feed.column).copied();
            let from = known.unwrap_or_else(|| self.system.add_external(&feed.column));
            self.columns.entry(feed.column.clone()).or_insert(from);
            let outcome = self.feed(feed, from);
            self.problems.extend(outcome.err().map(|problem| problem.at(&feed.place)));
        }
    }

    fn feed(&mut self, feed: &Feed, from: usize) -> Result<(), Problem> {
        let source = format!("column `{}`", feed.column);
        let placed = placed(&source, &feed.place);
        let (to, address) = self.find(&feed.to)?;
        let variable = &address.variable;
        let description = self.system.participants[to].slave.description();
        if !can_be_fed(variable, description) {
            let role = format!("be fed by {source}");
            return Err(wrong_role(&feed.to, variable, "an input or a tunable parameter", role));
        }
        let unit = self.unit(to, variable);
        let units = (feed.unit.as_ref(), unit.as_ref());
        let conversion = convert(&source, &feed.to, units, &feed.way, false)?;
        self.drive(to, &address, placed, Wire { from, conversion })
    }

    fn connections(&mut self, connections: &[Joined]) {
        for joined in connections {
            let outcome = self.connection(joined);
            self.problems.extend(outcome.err().map(|problem| problem.at(&joined.place)));
        }
    }

    fn connection(&mut self, joined: &Joined) -> Result<(), Problem> {
        let Joined { connection: Connection { from, to }, way, place: at } = joined;
        let (source, from_address) = self.find(from)?;
        let (target, to_address) = self.find(to)?;
        let (output, input) = (&from_address.variable, &to_address.variable);
        if output.causality != Causality::Output {
            let role = format!("feed {to}");
            return Err(wrong_role(from, output, "an output", role));
        }
        let is_timed = input.data_type == DataType::Clock
            && !can_be_fed(input, self.system.participants[target].slave.description());
        if input.causality != Causality::Input || is_timed {
            let role = format!("be fed by {from}");
            let must_be =
                if is_timed { "a clock that does not tick by itself" } else { "an input" };
            return Err(wrong_role(to, input, must_be, role));
        }
        if rank(output.data_type) > rank(input.data_type) {
            let is = format!("of type {}", output.data_type.name());
            let role = format!("feed {to}, which is of type {}", input.data_type.name());
            let (slave, variable) = (from.slave.clone(), from.variable.clone());
            let must_be = "of a type that fits";
            return Err(Problem::WrongRole { slave, variable, is, must_be, role });
        }
        let (from_unit, to_unit) = (self.unit(source, output), self.unit(target, input));
        let differences = self.is_difference(source, output) && self.is_difference(target, input);
        let name = format!("output {from}");
        let units = (from_unit.as_ref(), to_unit.as_ref());
        let conversion = convert(&name, to, units, way, differences)?;
        let name = placed(&name, at);
        let place = self.system.connect_output(source, &from_address)?;
        self.drive(target, &to_address, name.clone(), Wire { from: place, conversion })?;
        // Whole numbers of 64 bits go as they are.
        let rest = to_address.rest(self.system.participants[target].slave.description());
        if let (Some(rest), Conversion::Same) = (rest, conversion)
            && let Some(from) = self.system.rest_of(source, &from_address)
        {
            self.drive(target, &rest, name, Wire { from, conversion })?;
        }
        Ok(())
    }

    /// Makes the variable one that is set before each step.
    fn drive(
        &mut self,
        slave: usize,
        address: &Address,
        source: String,
        wire: Wire,
    ) -> Result<(), Problem> {
        let participant = &mut self.system.participants[slave];
        if let Some(place) = participant.driven.position(&address.variable.name) {
            return Err(Problem::TwoSources {
                slave: participant.slave.name().to_owned(),
                variable: address.variable.name.clone(),
                first: self.sources[slave][place].clone(),
                second: source,
            });
        }
        participant.drive(address, wire)?;
        self.sources[slave].push(source);
        Ok(())
    }

    fn starts(&mut self, starts: Vec<(Port, Value, String)>) {
        for (port, value, place) in starts {
            let outcome = self.start(&port, value);
            self.problems.extend(outcome.err().map(|problem| problem.at(&place)));
        }
    }

    fn start(&mut self, port: &Port, value: Value) -> Result<(), Problem> {
        let (slave, Address { variable, .. }) = self.find(port)?;
        let participant = &mut self.system.participants[slave];
        let problem = |why: String| Problem::StartValue {
            slave: port.slave.clone(),
            variable: port.variable.clone(),
            value: value.to_string(),
            why,
        };
        if value.fit(variable.data_type).is_none() {
            return Err(problem(format!("the variable is of type {}", variable.data_type.name())));
        }
        let when = settable(&variable, participant.slave.description().fmi_version);
        let start = (port.variable.clone(), value.clone());
        match when {
            Settable::Instantiated => participant.starts_before.push(start),
            Settable::Initialization => participant.starts_during.push(start),
            Settable::Never => {
                return Err(problem(format!(
                    "the variable is computed by the FMU (causality {}); set inputs, parameters \
                     or variables with a start value",
                    variable.causality.name()
                )));
            }
        }
        Ok(())
    }

    fn records(&mut self, records: &[(Port, Option<String>)]) {
        let mut owners: HashMap<&str, HashSet<&str>> = HashMap::new();
        for (port, _) in records.iter().filter(|(_, label)| label.is_none()) {
            owners.entry(&port.variable).or_default();
        }
        for (port, _) in records {
            if let Some(owners) = owners.get_mut(port.variable.as_str()) {
                owners.insert(&port.slave);
            }
        }
        for (port, label) in records {
            let shared = owners.get(port.variable.as_str()).is_some_and(|owners| owners.len() > 1);
            let name = match label {
                Some(label) => label.clone(),
                None if shared => format!("{}.{}", port.slave, port.variable),
                None => port.variable.clone(),
            };
            let outcome = self.record(port, name);
            self.problems.extend(outcome.err());
        }
    }

    fn record(&mut self, port: &Port, name: String) -> Result<(), Problem> {
        let (slave, address) = self.find(port)?;
        let unit = self.unit(slave, &address.variable).map(|unit| unit.name);
        self.system.record(Recorded { slave, address: &address, name, unit })
    }

    fn paces(&mut self, paces: &[(String, usize)]) {
        for (slave, steps) in paces {
            let outcome = self.system.position(slave).and_then(|place| {
                let what = || "every 0 communication steps; give 1 or more".to_owned();
                match steps {
                    0 => Err(Problem::Pace { slave: slave.clone(), what: what() }),
                    steps => Ok((place, *steps)),
                }
            });
            match outcome {
                Ok((place, steps)) => self.system.set_pace(place, steps),
                Err(problem) => self.problems.push(problem),
            }
        }
    }

    /// Place of a slave and a copy of its variable's declaration.
    fn find(&self, port: &Port) -> Result<(usize, Address), Problem> {
        let slave = self.system.position(&port.slave)?;
        let description = self.system.participants[slave].slave.description();
        let found = self.index.find(&port.slave, description, &port.variable);
        found.map(|address| (slave, address))
    }

    fn unit(&self, slave: usize, variable: &Variable) -> Option<Unit> {
        let description = self.system.participants[slave].slave.description();
        let name = description.properties(variable).unit?;
        let undefined = || Unit {
            name: name.clone(),
            base: None,
            display_units: Vec::new(),
            line: Default::default(),
        };
        Some(description.unit(&name).cloned().unwrap_or_else(undefined))
    }

    fn is_difference(&self, slave: usize, variable: &Variable) -> bool {
        let description = self.system.participants[slave].slave.description();
        description.properties(variable).relative_quantity.unwrap_or(false)
    }
}

/// A source's name, with its place if that is known.
fn placed(source: &str, place: &str) -> String {
    if place.is_empty() { source.to_owned() } else { format!("{source} ({place})") }
}

/// Whether a column may feed the variable: an input, or a tunable parameter.
pub(crate) fn can_be_fed(variable: &Variable, description: &ModelDescription) -> bool {
    let version = description.fmi_version;
    if variable.data_type == DataType::Clock {
        return can_be_triggered(description, variable);
    }
    match variable.causality {
        Causality::Input => true,
        Causality::Parameter => variable.variability(version) == Variability::Tunable,
        _ => false,
    }
}

fn convert(
    source: &str,
    target: &Port,
    (from, to): (Option<&Unit>, Option<&Unit>),
    way: &Transformations,
    differences: bool,
) -> Result<Conversion, Problem> {
    let name = |unit: Option<&Unit>| unit.map(|unit| unit.name.clone()).unwrap_or_default();
    way.conversion(from, to, differences).map_err(|why| Problem::Units {
        from: source.to_owned(),
        from_unit: name(from),
        to: target.to_string(),
        to_unit: name(to),
        why,
    })
}

fn wrong_role(port: &Port, variable: &Variable, must_be: &'static str, role: String) -> Problem {
    Problem::WrongRole {
        slave: port.slave.clone(),
        variable: port.variable.clone(),
        is: format!("of causality {}", variable.causality.name()),
        must_be,
        role,
    }
}

/// Values may go from a narrower type to a wider one: boolean, whole number, real.
fn rank(data_type: DataType) -> u8 {
    match data_type {
        DataType::Boolean | DataType::Clock => 0,
        DataType::Float32 | DataType::Float64 => 2,
        _ => 1,
    }
}
