//! A checked system: slaves, the bus between them, and the moves of which algorithms are made.

mod pace;

use std::collections::{HashMap, HashSet};
use std::time::Instant;

use self::pace::Pace;
use crate::error::Error;
use crate::port::Port;
use crate::problem::Problem;
use crate::record::Column;
use crate::slave::{Address, Selection, Slave, Value};
use crate::statistics::{Statistics, Times};
use crate::unit::Conversion;
use fmi_bindings::import::StepResult;

/// Slaves that are connected and ready to run. Made by [`Diagram::build`](crate::Diagram::build).
///
/// The *bus* holds one value per column of the input table and per connected or recorded variable.
/// An algorithm moves a slave by three methods, in the order it likes: [`System::transfer`] from
/// the bus to the slave's inputs, [`System::advance`] in time, [`System::read`] from the slave's
/// outputs to the bus. None of them allocates; all of them do nothing for a slave whose own step
/// (see [`Diagram::every`](crate::Diagram::every)) does not begin at this communication point. A place that no slave has is a mistake in the
/// algorithm, and they panic on it.
pub struct System {
    pub(crate) participants: Vec<Participant>,
    pub(crate) bus: Vec<f64>,
    /// Names of the columns; they are the first values of the bus.
    pub(crate) externals: Vec<String>,
    /// For each connected variable of the bus the slave it belongs to.
    pub(crate) owners: Vec<Option<usize>>,
    pub(crate) columns: Vec<Column>,
    /// Names of the columns.
    recorded: HashSet<String>,
    /// Places of the slaves, the first of a name.
    places: HashMap<String, usize>,
    taps: Vec<Tap>,
    input_taps: Vec<InputTap>,
    pub(crate) row: Vec<f64>,
    pub(crate) ending: Option<Ending>,
    /// It has run, and must be reset before it runs again.
    pub(crate) used: bool,
    /// Circles of outputs that had no solution at the start of the last run, by their variables.
    pub(crate) unsolved: Vec<String>,
    /// Some slave steps more rarely than the system communicates.
    pub(crate) paced: bool,
    /// This communication step is timed.
    pub(crate) is_timed: bool,
    pub(crate) total: Statistics,
}

/// Why a run ended before its stop time without an error.
#[derive(Clone, Debug, PartialEq)]
pub struct Ending {
    /// The FMU that asked for the end.
    pub slave: String,
    /// Time it reached, s.
    pub time: f64,
}

/// A slave and its places on the bus.
pub(crate) struct Participant {
    pub(crate) slave: Box<dyn Slave>,
    pub(crate) starts_before: Vec<(String, Value)>,
    pub(crate) starts_during: Vec<(String, Value)>,
    pub(crate) driven: Selection,
    pub(crate) wires: Vec<Wire>,
    inputs: Vec<f64>,
    /// Outputs that feed others.
    pub(crate) outputs: Gather,
    /// Other variables that are only recorded.
    pub(crate) observed: Gather,
    pub(crate) pace: Pace,
    times: Times,
}

/// What feeds an input.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wire {
    /// Place on the bus.
    pub(crate) from: usize,
    pub(crate) conversion: Conversion,
}

/// Variables that are read together, and where their values go on the bus.
#[derive(Default)]
pub(crate) struct Gather {
    pub(crate) selection: Selection,
    values: Vec<f64>,
    pub(crate) places: Vec<usize>,
}

/// A recorded variable that is found on the bus, and its column of the row.
struct Tap {
    column: usize,
    place: usize,
}

/// A recorded variable that is an input, and its column of the row.
struct InputTap {
    column: usize,
    slave: usize,
    place: usize,
}

/// A variable to record.
pub(crate) struct Recorded<'a> {
    pub(crate) slave: usize,
    pub(crate) address: &'a Address,
    pub(crate) name: String,
    pub(crate) unit: Option<String>,
}

impl Gather {
    fn add(&mut self, slave: &str, address: &Address, place: usize) -> Result<(), Problem> {
        self.selection.add_address(slave, address)?;
        self.values.push(0.0);
        self.places.push(place);
        Ok(())
    }

    fn place(&self, variable: &str) -> Option<usize> {
        self.selection.position(variable).map(|i| self.places[i])
    }

    /// Reads the values to the bus. Whether all of them are finite numbers.
    #[inline(always)]
    fn read(&mut self, slave: &mut dyn Slave, bus: &mut [f64]) -> Result<bool, Error> {
        if self.places.is_empty() {
            return Ok(true);
        }
        slave.get(&self.selection, &mut self.values)?;
        // Zero times a number is zero, of whatever sign, unless the number is not finite.
        let mut zero = 0.0;
        for (place, value) in self.places.iter().zip(&self.values) {
            bus[*place] = *value;
            zero += 0.0 * *value;
        }
        Ok(zero == 0.0)
    }

    /// The first value that is NaN or infinite.
    fn not_finite(&self) -> Option<(String, f64)> {
        let at = self.values.iter().position(|value| !value.is_finite())?;
        Some((self.selection.names().get(at).cloned().unwrap_or_default(), self.values[at]))
    }
}

impl Participant {
    pub(crate) fn new(slave: Box<dyn Slave>) -> Self {
        Participant {
            slave,
            starts_before: Vec::new(),
            starts_during: Vec::new(),
            driven: Selection::default(),
            wires: Vec::new(),
            inputs: Vec::new(),
            outputs: Gather::default(),
            observed: Gather::default(),
            pace: Pace::default(),
            times: Times::default(),
        }
    }

    /// Name of the output that goes to this place of the bus.
    pub(crate) fn output_at(&self, place: usize) -> Option<&str> {
        let seen = self.pace.seen(place);
        let at =
            self.outputs.places.iter().position(|there| *there == place || seen == Some(*there));
        at.and_then(|at| self.outputs.selection.names().get(at)).map(String::as_str)
    }

    /// The error of a value that is NaN or infinite.
    #[cold]
    fn not_finite(&self) -> Error {
        let found = self.outputs.not_finite().or_else(|| self.observed.not_finite());
        let (variable, value) = found.unwrap_or_default();
        Error::NotFinite { fmu: self.slave.name().to_owned(), variable, value }
    }

    pub(crate) fn drive(&mut self, address: &Address, wire: Wire) -> Result<(), Problem> {
        self.driven.add_address(self.slave.name(), address)?;
        self.wires.push(wire);
        self.inputs.push(0.0);
        Ok(())
    }
}

impl System {
    pub(crate) fn new(participants: Vec<Participant>) -> Self {
        let mut places = HashMap::with_capacity(participants.len());
        for (place, participant) in participants.iter().enumerate() {
            places.entry(participant.slave.name().to_owned()).or_insert(place);
        }
        System {
            places,
            participants,
            bus: Vec::new(),
            externals: Vec::new(),
            owners: Vec::new(),
            columns: Vec::new(),
            recorded: HashSet::new(),
            taps: Vec::new(),
            input_taps: Vec::new(),
            row: Vec::new(),
            ending: None,
            used: false,
            unsolved: Vec::new(),
            paced: false,
            is_timed: false,
            total: Statistics::default(),
        }
    }

    /// Columns are added before everything else, so that they are the first values of the bus.
    pub(crate) fn add_external(&mut self, column: &str) -> usize {
        self.externals.push(column.to_owned());
        self.add_place(None)
    }

    pub(crate) fn add_place(&mut self, owner: Option<usize>) -> usize {
        self.bus.push(0.0);
        self.owners.push(owner);
        self.bus.len() - 1
    }

    /// Puts an output on the bus; its place.
    pub(crate) fn connect_output(
        &mut self,
        slave: usize,
        output: &Address,
    ) -> Result<usize, Problem> {
        if let Some(place) = self.participants[slave].outputs.place(&output.variable.name) {
            return Ok(place);
        }
        let place = self.add_place(Some(slave));
        let participant = &mut self.participants[slave];
        participant.outputs.add(participant.slave.name(), output, place)?;
        if let Some(rest) = output.rest(participant.slave.description()) {
            let place = self.add_place(Some(slave));
            let participant = &mut self.participants[slave];
            participant.outputs.add(participant.slave.name(), &rest, place)?;
        }
        Ok(place)
    }

    /// Place of what a double leaves of an output of 64 bits that is on the bus.
    pub(crate) fn rest_of(&self, slave: usize, output: &Address) -> Option<usize> {
        let participant = self.participants.get(slave)?;
        let rest = output.rest(participant.slave.description())?;
        participant.outputs.place(&rest.variable.name)
    }

    /// Records a variable: an input as it is set, anything else as it is read.
    pub(crate) fn record(&mut self, recorded: Recorded<'_>) -> Result<(), Problem> {
        let Recorded { slave, address, name, unit } = recorded;
        let variable = &address.variable.name;
        if !self.recorded.insert(name.clone()) {
            return Err(Problem::SameColumn { name });
        }
        let participant = &self.participants[slave];
        let number = self.columns.len();
        if let Some(place) = participant.driven.position(variable) {
            self.input_taps.push(InputTap { column: number, slave, place });
        } else if let Some(place) = participant.outputs.place(variable) {
            self.taps.push(Tap { column: number, place });
        } else {
            let place = self.add_place(None);
            let participant = &mut self.participants[slave];
            participant.observed.add(participant.slave.name(), address, place)?;
            self.taps.push(Tap { column: number, place });
        }
        self.columns.push(Column { name, unit });
        self.row.push(0.0);
        Ok(())
    }

    /// Number of slaves.
    pub fn len(&self) -> usize {
        self.participants.len()
    }

    /// Whether there is no slave.
    pub fn is_empty(&self) -> bool {
        self.participants.is_empty()
    }

    /// Names of the slaves, in the order in which they were added.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.participants.iter().map(|participant| participant.slave.name())
    }

    /// Place of a slave.
    pub fn position(&self, name: &str) -> Result<usize, Problem> {
        self.places.get(name).copied().ok_or_else(|| Problem::NoSuchSlave {
            name: name.to_owned(),
            there: self.names().collect::<Vec<_>>().join(", "),
        })
    }

    /// The slave at a place.
    pub fn slave(&mut self, slave: usize) -> Option<&mut (dyn Slave + 'static)> {
        self.participants.get_mut(slave).map(|participant| &mut *participant.slave)
    }

    /// Gives a variable another start value for the runs that follow.
    ///
    /// # Errors
    /// The variable got no start value in the diagram, or this one does not fit its type.
    pub fn set_start(&mut self, to: &Port, value: Value) -> Result<(), Problem> {
        let slave = self.position(&to.slave)?;
        let Participant { slave, starts_before, starts_during, .. } = &mut self.participants[slave];
        let refuse = |why: String| {
            let (slave, variable) = (to.slave.clone(), to.variable.clone());
            Err(Problem::StartValue { slave, variable, value: value.to_string(), why })
        };
        let data_type =
            Address::find(&to.slave, slave.description(), &to.variable)?.variable.data_type;
        if value.fit(data_type).is_none() {
            return refuse(format!("the variable is of type {}", data_type.name()));
        }
        let starts = starts_before.iter_mut().chain(starts_during);
        let mut found = starts.filter(|(variable, _)| *variable == to.variable).peekable();
        if found.peek().is_none() {
            return refuse("the diagram gives it no start value to replace".to_owned());
        }
        found.for_each(|(_, start)| start.clone_from(&value));
        Ok(())
    }

    /// The slaves whose outputs feed the slave at a place; one may come several times.
    pub fn sources_of(&self, slave: usize) -> impl Iterator<Item = usize> {
        let wires = self.participants.get(slave).map_or(&[][..], |p| &p.wires);
        wires.iter().filter_map(|wire| self.owners.get(wire.from).copied().flatten())
    }

    /// The first variable that a column of the input table feeds: slave and name.
    pub(crate) fn fed_by(&self, column: &str) -> Option<(String, String)> {
        let place = self.externals.iter().position(|name| name == column)?;
        self.participants.iter().find_map(|participant| {
            let input = participant.wires.iter().position(|wire| wire.from == place)?;
            let variable = participant.driven.names().get(input)?;
            Some((participant.slave.name().to_owned(), variable.clone()))
        })
    }

    /// The loops of outputs that depend on each other at once and for which no values were found at
    /// the start of the last run, so that it began with those of one pass through them.
    pub fn unsolved(&self) -> &[String] {
        &self.unsolved
    }

    /// How long the steps of all runs so far took.
    pub fn statistics(&self) -> Statistics {
        let report = |participant: &Participant| participant.times.report(participant.slave.name());
        Statistics { fmus: self.participants.iter().map(report).collect(), ..self.total.clone() }
    }

    /// The columns that a run records.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Sets the slave's driven inputs to the values on the bus.
    #[inline(always)]
    pub fn transfer(&mut self, slave: usize) -> Result<(), Error> {
        if !self.participants[slave].pace.due {
            return Ok(());
        }
        self.gather(slave);
        let participant = &mut self.participants[slave];
        if participant.inputs.is_empty() {
            return Ok(());
        }
        participant.slave.set(&participant.driven, &participant.inputs)
    }

    /// Computes the slave's driven inputs without setting them.
    #[inline(always)]
    pub(crate) fn gather(&mut self, slave: usize) {
        let participant = &mut self.participants[slave];
        for (input, wire) in participant.inputs.iter_mut().zip(&participant.wires) {
            *input = wire.conversion.apply(self.bus[wire.from]);
        }
    }

    /// Steps the slave from `time` over `step` seconds.
    ///
    /// # Errors
    /// Whatever the slave says, and a step that it discards without asking for the end of the run.
    /// If it asks for the end, the run ends after this communication step.
    #[inline(always)]
    pub fn advance(&mut self, slave: usize, time: f64, step: f64) -> Result<(), Error> {
        let participant = &mut self.participants[slave];
        if !participant.pace.due {
            return Ok(());
        }
        let (time, step) = participant.pace.own.unwrap_or((time, step));
        participant.times.calls += 1;
        let begin = if self.is_timed { Some(Instant::now()) } else { None };
        let outcome = participant.slave.step(time, step);
        if let Some(begin) = begin {
            participant.times.note(begin.elapsed());
        }
        match outcome? {
            StepResult::Completed => Ok(()),
            StepResult::Discarded { reached, terminated } => {
                let slave = participant.slave.name().to_owned();
                self.discarded(slave, (time, step), reached, terminated)
            }
        }
    }

    /// A slave has given up its step, or asks for the end.
    #[cold]
    fn discarded(
        &mut self,
        slave: String,
        (time, step): (f64, f64),
        reached: Option<f64>,
        terminated: bool,
    ) -> Result<(), Error> {
        if !terminated {
            return Err(Error::Discarded { fmu: slave, step, reached });
        }
        // An FMU that does not say how far it got has not done the step.
        let reached = reached.filter(|reached| (time..=time + step).contains(reached));
        self.ending = Some(Ending { slave, time: reached.unwrap_or(time) });
        Ok(())
    }

    /// Reads the slave's connected and recorded variables to the bus.
    ///
    /// # Errors
    /// What the slave says, and a value that is NaN or infinite.
    #[inline(always)]
    pub fn read(&mut self, slave: usize) -> Result<(), Error> {
        let participant = &mut self.participants[slave];
        if !participant.pace.due {
            return Ok(());
        }
        let outputs = participant.outputs.read(&mut *participant.slave, &mut self.bus)?;
        let observed = participant.observed.read(&mut *participant.slave, &mut self.bus)?;
        if outputs && observed { Ok(()) } else { Err(participant.not_finite()) }
    }

    /// In initialization mode: sets the slave's inputs and reads its connected outputs.
    pub(crate) fn feed_through(&mut self, slave: usize) -> Result<(), Error> {
        self.transfer(slave)?;
        self.read_outputs(slave)?;
        self.publish_one(slave);
        Ok(())
    }

    /// Reads the slave's connected outputs only.
    pub(crate) fn read_outputs(&mut self, slave: usize) -> Result<(), Error> {
        let participant = &mut self.participants[slave];
        participant.outputs.read(&mut *participant.slave, &mut self.bus).map(|_| ())
    }

    /// Notes the recorded outputs of this communication point.
    #[inline]
    pub(crate) fn tap_outputs(&mut self) {
        for Tap { column, place } in &self.taps {
            self.row[*column] = self.bus[*place];
        }
    }

    /// Notes the recorded inputs as they act from this communication point on.
    #[inline]
    pub(crate) fn tap_inputs(&mut self) {
        for InputTap { column, slave, place } in &self.input_taps {
            self.row[*column] = self.participants[*slave].inputs[*place];
        }
    }
}
