//! Blueprints: the files that describe a plant or a controller.
//!
//! ```toml
//! piezoloop = 1                       # format of this file
//! kind = "plant"                      # or "controller"
//! name = "stage"
//! step = 20e-6                        # internal step in s, or a text with a unit: "20 us"
//!
//! [[axis]]
//! name = "Y"
//! command = { name = "u", unit = "V", min = 0, max = 120, start = 0 }
//! position = { name = "y", unit = "um" }
//!
//! [[axis.component]]
//! type = "prandtl-ishlinskii"
//! r = [0, 6, 12]                      # in the quantity's unit on this axis
//! w = [0.01354, 0.0279, 0]
//!
//! [[axis.component]]
//! type = "mode"
//! record = "p-752-21c"                # values of a specimen; keys beside it go before them
//! damping = 0.03
//!
//! [[coupling]]                        # only where axes are coupled
//! type = "displacement-coupling"
//! axes = ["Y", "Z"]                   # rows and columns of the matrix, by name
//! after = "mechanics"                 # on every coupled axis; default: behind the last mechanics
//! matrix = [[0, 0.01], [0.02, 0]]
//!
//! [[connection]]                      # only where a port reads another signal than its own
//! from = "Y.displacement"             # axis and signal: command, voltage, displacement, position,
//!                                     # an input on demand, or an output such as charge
//! to = "Z.disturbance.disturbance"    # axis, component and port; both measure the same
//! ```
//!
//! An axis may name the inputs that its components ask for (`force = { name = "f", unit = "mN" }`,
//! `disturbance`), and, in front of optics, the unit of its motion (`motion = { unit = "1" }`); the
//! model its `temperature`. A controller has none of these.

mod build;
mod check;
mod checker;
mod component;
mod connection;
mod coupling;
mod draft;
mod frame;
mod measure;
mod origin;
mod read;
mod reader;
mod record;
mod signal;
mod structure;
mod table;
mod write;

use std::collections::BTreeMap;
use std::path::Path;

use model::{Kind, Registry, System, SystemSpec, Table};
use origin::Origin;
pub use record::{ParameterRecord, RecordValue};
pub use table::npy_of;

use crate::{AtomicFile, Problem, Problems};

/// Number of the file format, the value of the key `piezoloop`.
const FORMAT: f64 = 1.0;
/// A component's key for its learned table.
const TABLE: &str = "table";

/// A plant or a controller as a file says it: unchecked.
///
/// Two blueprints are equal where they say the same, wherever they came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Blueprint {
    /// Plant or controller.
    pub kind: Kind,
    /// Name of the model: letters, digits and `_`, a letter first.
    pub name: String,
    /// One sentence; may be empty.
    pub description: String,
    /// Provenance, free text; may be empty.
    pub source: String,
    /// Who made the model, person and organisation; may be empty.
    pub author: String,
    /// Version of the model; may be empty.
    pub version: String,
    /// Who holds the rights in the model; may be empty.
    pub copyright: String,
    /// Under which terms the model may be used; may be empty.
    pub license: String,
    /// Internal step in s, or a text with a unit of time.
    pub step: Value,
    /// Short name, unit and start of the input `temperature`, where a component reads it.
    pub temperature: SignalBlueprint,
    /// The axes.
    pub axes: Vec<AxisBlueprint>,
    /// The couplings between them.
    pub couplings: Vec<CouplingBlueprint>,
    /// Ports that read another signal than their own.
    pub connections: Vec<ConnectionBlueprint>,
    /// Tables in memory by the name that components give; others are files beside the blueprint.
    pub tables: BTreeMap<String, Table>,
    /// File and lines, for messages.
    origin: Origin,
}

/// One axis of a [`Blueprint`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisBlueprint {
    /// Name; empty: `axis1`, `axis2`, …
    pub name: String,
    /// The command: unit, and for plants short name, bounds and start.
    pub command: SignalBlueprint,
    /// The position: unit, and for plants the short name.
    pub position: SignalBlueprint,
    /// Controllers: short name and start of the reference (`measured` starts there too).
    pub reference: SignalBlueprint,
    /// Controllers: short name of the measured position.
    pub measured: SignalBlueprint,
    /// Short name, unit and start of the load force, where a component reads it.
    pub force: SignalBlueprint,
    /// Short name, unit and start of the disturbance, where a component reads it.
    pub disturbance: SignalBlueprint,
    /// The unit of the motion in front of a coupling that turns it into a position (optics).
    pub motion: SignalBlueprint,
    /// The components in the order of the signal path.
    pub components: Vec<ComponentBlueprint>,
}

/// An input or output of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignalBlueprint {
    /// Short name, as in `u`; empty: none.
    pub name: String,
    /// Unit, as in `um`; empty: not given.
    pub unit: String,
    /// Least value; `None`: no bound.
    pub min: Option<Value>,
    /// Greatest value; `None`: no bound.
    pub max: Option<Value>,
    /// Value before anybody sets one; `None`: 0.
    pub start: Option<Value>,
}

/// One component of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct ComponentBlueprint {
    /// The component blueprint's type, as in `prandtl-ishlinskii`.
    pub kind: String,
    /// The component blueprint's name; empty: the declaration's.
    pub name: String,
    /// Whether it acts.
    pub enabled: bool,
    /// Structural settings and parameters by name, in the order of the file.
    pub values: Vec<(String, Value)>,
    /// Relative standard deviation (1 σ) of a parameter by name.
    pub tolerance: BTreeMap<String, f64>,
    /// Free text; may be empty.
    pub note: String,
}

/// One coupling between axes.
#[derive(Clone, Debug, PartialEq)]
pub struct CouplingBlueprint {
    /// The component; matrices may be lists of rows.
    pub component: ComponentBlueprint,
    /// The names of the axes, in the order of the rows and columns.
    pub axes: Vec<String>,
    /// The component behind which it stands on each of them; empty: behind the mechanics.
    pub after: String,
}

/// A port that reads another signal than its own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ConnectionBlueprint {
    /// Axis and signal, as in `Y.displacement`.
    pub from: String,
    /// Axis, component and port, as in `Z.load.force`.
    pub to: String,
}

/// A value as a file says it.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number, in the quantity's unit on its axis.
    Number(f64),
    /// A number with a unit, as in `2.1 kHz`.
    Text(String),
    /// Several.
    List(Vec<Self>),
}

/// A blueprint without a problem, and the specification that it says.
#[derive(Clone, Debug)]
pub struct CheckedBlueprint {
    blueprint: Blueprint,
    spec: Spec,
    system: System,
}

/// A [`SystemSpec`] that can be printed by its name.
#[derive(Clone)]
struct Spec(SystemSpec);

impl std::fmt::Debug for Spec {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SystemSpec").field("name", &self.0.name).finish_non_exhaustive()
    }
}

impl Blueprint {
    /// A blueprint without axes; `step` is the internal step in s.
    #[must_use]
    pub fn new(kind: Kind, name: &str, step: f64) -> Self {
        Self {
            kind,
            name: name.into(),
            description: String::new(),
            source: String::new(),
            author: String::new(),
            version: String::new(),
            copyright: String::new(),
            license: String::new(),
            step: Value::Number(step),
            temperature: SignalBlueprint::default(),
            axes: Vec::new(),
            couplings: Vec::new(),
            connections: Vec::new(),
            tables: BTreeMap::new(),
            origin: Origin::default(),
        }
    }

    /// With this axis at the end.
    #[must_use]
    pub fn axis(mut self, axis: AxisBlueprint) -> Self {
        self.axes.push(axis);
        self
    }

    /// With this coupling between axes.
    #[must_use]
    pub fn coupling(mut self, axes: &[&str], component: ComponentBlueprint) -> Self {
        let axes = axes.iter().map(|name| (*name).to_string()).collect();
        self.couplings.push(CouplingBlueprint { component, axes, after: String::new() });
        self
    }

    /// With this connection from `axis.signal` to `axis.component.port`.
    #[must_use]
    pub fn connection(mut self, from: &str, to: &str) -> Self {
        self.connections.push(ConnectionBlueprint { from: from.into(), to: to.into() });
        self
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or its text is no TOML: all places. Everything else that is wrong
    /// is reported by [`check`](Self::check).
    pub fn read(path: &Path) -> Result<Self, Problems> {
        let origin = path.display().to_string();
        let text = files::read_text(path).map_err(|error| {
            let way_out = if error.kind() == std::io::ErrorKind::InvalidData {
                "save it as UTF-8 text"
            } else {
                "check the name and the permissions"
            };
            Problem::new(&origin, format!("cannot be read: {error}"), way_out)
        })?;
        Self::parse(&text, &origin)
    }

    /// Reads a text; `origin` is what messages call it, the file's name as a rule.
    ///
    /// # Errors
    /// The text is no TOML: all places.
    pub fn parse(text: &str, origin: &str) -> Result<Self, Problems> {
        read::parse(text, origin)
    }

    /// The blueprint as TOML, in a fixed order.
    #[must_use]
    pub fn to_toml(&self) -> String {
        write::to_toml(self)
    }

    /// Writes the file `path`, whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Problems> {
        AtomicFile::write_all_of(path, self.to_toml().as_bytes())
            .map_err(|error| Problem::unwritable(path, &error).into())
    }

    /// Names of the records whose values it took when it was read. [`to_toml`](Self::to_toml) writes
    /// the values themselves, so that its text needs no record.
    #[must_use]
    pub fn records(&self) -> &[String] {
        &self.origin.records
    }

    /// The values for components of this type in the records that it took: each record's name and its values.
    #[must_use]
    pub fn recorded(&self, kind: &str) -> Vec<(String, Vec<RecordValue>)> {
        let found = self.origin.records.iter().filter_map(|name| {
            let record = record::find(name, &self.origin.file).ok()?;
            Some((record.name.clone(), record.values(kind)?.to_vec()))
        });
        found.collect()
    }

    /// Checks all values and names against the components of `registry`.
    ///
    /// # Errors
    /// Every [`Problem`] there is.
    pub fn check(&self, registry: Registry) -> Result<CheckedBlueprint, Problems> {
        check::check(self, registry)
    }
}

impl AxisBlueprint {
    /// An axis without components, whose command and position have these units.
    #[must_use]
    pub fn new(name: &str, command_unit: &str, position_unit: &str) -> Self {
        Self {
            name: name.into(),
            command: SignalBlueprint::of_unit(command_unit),
            position: SignalBlueprint::of_unit(position_unit),
            ..Self::default()
        }
    }

    /// With this component at the end of the signal path.
    #[must_use]
    pub fn component(mut self, component: ComponentBlueprint) -> Self {
        self.components.push(component);
        self
    }
}

impl SignalBlueprint {
    /// A signal of this unit.
    #[must_use]
    pub fn of_unit(unit: &str) -> Self {
        Self { unit: unit.into(), ..Self::default() }
    }
    /// With this short name.
    #[must_use]
    pub fn named(mut self, name: &str) -> Self {
        self.name = name.into();
        self
    }
    /// With these bounds, in the signal's unit.
    #[must_use]
    pub fn between(mut self, min: f64, max: f64) -> Self {
        (self.min, self.max) = (Some(min.into()), Some(max.into()));
        self
    }
    /// With this start, in the signal's unit.
    #[must_use]
    pub fn start(mut self, start: f64) -> Self {
        self.start = Some(start.into());
        self
    }
}

impl ComponentBlueprint {
    /// A component of this type, enabled, with no values yet.
    #[must_use]
    pub fn new(kind: &str) -> Self {
        Self {
            kind: kind.into(),
            name: String::new(),
            enabled: true,
            values: Vec::new(),
            tolerance: BTreeMap::new(),
            note: String::new(),
        }
    }
    /// With this name.
    #[must_use]
    pub fn named(mut self, name: &str) -> Self {
        self.name = name.into();
        self
    }
    /// With this value of a structural setting or a parameter, in the place of an earlier one.
    #[must_use]
    pub fn value(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.set(name, value);
        self
    }
    /// With this relative standard deviation (1 σ) of a parameter.
    #[must_use]
    pub fn tolerance(mut self, name: &str, relative: f64) -> Self {
        self.tolerance.insert(name.into(), relative);
        self
    }
    /// With this note.
    #[must_use]
    pub fn note(mut self, note: &str) -> Self {
        self.note = note.into();
        self
    }
    /// Switched on or off.
    #[must_use]
    pub fn enabled(mut self, enabled: bool) -> Self {
        self.enabled = enabled;
        self
    }
    /// Sets a structural setting or a parameter.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) {
        let value = value.into();
        match self.values.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = value,
            None => self.values.push((name.into(), value)),
        }
    }
    /// The value of a structural setting or a parameter as it was given.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.values.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }
}

impl CheckedBlueprint {
    /// The blueprint that was checked.
    #[must_use]
    pub fn blueprint(&self) -> &Blueprint {
        &self.blueprint
    }
    /// What the checked blueprint says, with every value in the unit of its quantity on its axis.
    #[must_use]
    pub fn spec(&self) -> &SystemSpec {
        &self.spec.0
    }
    /// A system of its own, as it is before initialisation.
    #[must_use]
    pub fn build(&self) -> System {
        self.system.clone()
    }
    /// The system that was built to check the blueprint, for its variable table.
    #[must_use]
    pub fn system(&self) -> &System {
        &self.system
    }
    /// The values of a parameter: axis number from 1, name of the component, name of the parameter;
    /// in the unit of the quantity on its axis. `None` where there is no such parameter.
    #[must_use]
    pub fn parameter(&self, axis: usize, component: &str, name: &str) -> Option<&[f64]> {
        let axis = self.spec.0.axes.get(axis.checked_sub(1)?)?;
        let node = axis.components.iter().find(|node| node.name == component)?;
        let declaration = node.component.declaration();
        let index = declaration.parameters.iter().position(|q| q.name == name)?;
        let before: usize = (0..index).map(|i| declaration.length(i, &node.structure)).sum();
        node.values.get(before..before + declaration.length(index, &node.structure))
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}
impl From<&str> for Value {
    fn from(value: &str) -> Self {
        Self::Text(value.into())
    }
}
impl From<&[f64]> for Value {
    fn from(values: &[f64]) -> Self {
        Self::List(values.iter().map(|value| Self::Number(*value)).collect())
    }
}
impl From<Vec<f64>> for Value {
    fn from(values: Vec<f64>) -> Self {
        values.as_slice().into()
    }
}
impl From<&Vec<f64>> for Value {
    fn from(values: &Vec<f64>) -> Self {
        values.as_slice().into()
    }
}
impl<const N: usize> From<[f64; N]> for Value {
    fn from(values: [f64; N]) -> Self {
        values.as_slice().into()
    }
}
