//! What an SSD, an SSV and an SSM say.

use super::connector::{Connector, Source};
use super::dictionary::{DictionaryReference, SignalDictionary};
use crate::description::{Line, Unit};
use crate::names::named;
use crate::xml;

/// An SSD, `SystemStructure.ssd`.
#[derive(Debug, Clone, PartialEq)]
pub struct SystemStructure {
    /// Version of the format, `1.0` or `2.0`.
    pub version: String,
    /// Name of the structure.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// Tool that wrote the file.
    pub generation_tool: Option<String>,
    /// The outermost system.
    pub system: System,
    /// Units that connectors and parameters refer to.
    pub units: Vec<Unit>,
    /// Enumerations that connectors and parameters refer to.
    pub enumerations: Vec<Enumeration>,
    /// Time span of a run.
    pub default_experiment: Experiment,
}

impl SystemStructure {
    /// A structure of version 1.0 with an empty system; both have this name.
    pub fn new(name: impl Into<String>) -> Self {
        let name = name.into();
        SystemStructure {
            version: "1.0".to_owned(),
            system: System::new(&name),
            name,
            description: None,
            generation_tool: None,
            units: Vec::new(),
            enumerations: Vec::new(),
            default_experiment: Experiment::default(),
        }
    }
}

/// Time span of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Experiment {
    /// Start in s.
    pub start_time: Option<f64>,
    /// End in s.
    pub stop_time: Option<f64>,
}

/// A list of named whole numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Enumeration {
    /// Name that parameters refer to.
    pub name: String,
    /// Name and value of each item.
    pub items: Vec<(String, i64)>,
    /// Where it stands.
    pub line: Line,
}

/// A system: elements and what connects them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct System {
    /// Name, unique in the enclosing system.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// What the system shows to the outside.
    pub connectors: Vec<Connector>,
    /// Parameters that are set from this level.
    pub bindings: Vec<Binding>,
    /// Components and systems inside.
    pub elements: Vec<Element>,
    /// Connections between connectors of the elements and of the system itself.
    pub connections: Vec<Connection>,
    /// Signals that elements share by name.
    pub dictionaries: Vec<SignalDictionary>,
    /// What tools noted.
    pub annotations: Vec<Annotation>,
    /// Where it stands.
    pub line: Line,
}

impl System {
    /// An empty system.
    pub fn new(name: impl Into<String>) -> Self {
        System { name: name.into(), ..System::default() }
    }
}

/// What a system consists of.
#[derive(Debug, Clone, PartialEq)]
pub enum Element {
    /// An FMU.
    Component(Component),
    /// A system inside the system.
    System(System),
    /// A signal dictionary.
    Dictionary(DictionaryReference),
}

impl Element {
    /// Name, unique in the enclosing system.
    pub fn name(&self) -> &str {
        match self {
            Element::Component(component) => &component.name,
            Element::System(system) => &system.name,
            Element::Dictionary(reference) => &reference.name,
        }
    }

    /// What the element shows to the enclosing system.
    pub fn connectors(&self) -> &[Connector] {
        match self {
            Element::Component(component) => &component.connectors,
            Element::System(system) => &system.connectors,
            Element::Dictionary(reference) => &reference.connectors,
        }
    }

    pub(super) fn line(&self) -> Line {
        match self {
            Element::Component(component) => component.line,
            Element::System(system) => system.line,
            Element::Dictionary(reference) => reference.line,
        }
    }
}

named! {
    /// Which interface of an FMU is used.
    Implementation {
        /// The importer chooses.
        Any = "any",
        /// Model exchange.
        ModelExchange = "ModelExchange",
        /// Co-simulation.
        CoSimulation = "CoSimulation",
        /// Scheduled execution (2.0).
        ScheduledExecution = "ScheduledExecution",
    }
}

/// A component: an FMU by its source.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Name, unique in the enclosing system.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// Relative URI from the SSD, such as `resources/plant.fmu`.
    pub source: String,
    /// Media type; [`super::FMU_TYPE`] for FMUs.
    pub media_type: String,
    /// Which interface of the FMU is used.
    pub implementation: Implementation,
    /// The variables of the FMU that take part.
    pub connectors: Vec<Connector>,
    /// Parameters that are set from this level.
    pub bindings: Vec<Binding>,
    /// What tools noted.
    pub annotations: Vec<Annotation>,
    /// Where it stands.
    pub line: Line,
}

impl Component {
    /// An FMU for co-simulation.
    pub fn new(name: impl Into<String>, source: impl Into<String>) -> Self {
        Component {
            name: name.into(),
            description: None,
            source: source.into(),
            media_type: super::FMU_TYPE.to_owned(),
            implementation: Implementation::CoSimulation,
            connectors: Vec::new(),
            bindings: Vec::new(),
            annotations: Vec::new(),
            line: Line(0),
        }
    }
}

/// One end of a connection.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct End {
    /// Name of an element; none: the system itself.
    pub element: Option<String>,
    /// Name of its connector.
    pub connector: String,
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.element {
            Some(element) => write!(f, "\"{element}.{}\"", self.connector),
            None => write!(f, "\"{}\" of the system itself", self.connector),
        }
    }
}

/// A connection. The kinds of the connectors state which end is the source, not their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Connection {
    /// `startElement`, `startConnector`.
    pub start: End,
    /// `endElement`, `endConnector`.
    pub end: End,
    /// Applied after unit conversion.
    pub transformation: Option<Transformation>,
    /// Units are not converted.
    pub suppress_unit_conversion: bool,
    /// Where it stands.
    pub line: Line,
}

impl Connection {
    /// A plain connection from an element's connector to another element's.
    pub fn new(start: End, end: End) -> Self {
        Connection {
            start,
            end,
            transformation: None,
            suppress_unit_conversion: false,
            line: Line(0),
        }
    }
}

/// What happens to a value on its way.
#[derive(Debug, Clone, PartialEq)]
pub enum Transformation {
    /// `target = factor · source + offset`.
    Linear {
        /// The factor.
        factor: f64,
        /// The offset.
        offset: f64,
    },
    /// Source and target of each truth value.
    Boolean(Vec<(bool, bool)>),
    /// Source and target of each number.
    Integer(Vec<(i64, i64)>),
    /// Source and target of each item.
    Enumeration(Vec<(String, String)>),
}

/// A parameter set that is applied to a component or a system.
#[derive(Debug, Clone, PartialEq)]
pub struct Binding {
    /// Put before every name of the set.
    pub prefix: String,
    /// Where the set comes from.
    pub source: Source,
    /// The set, once it is loaded.
    pub values: Option<ParameterSet>,
    /// How names and values are mapped.
    pub mapping: Option<Mapping>,
    /// Where it stands.
    pub line: Line,
}

/// The mapping of a binding.
#[derive(Debug, Clone, PartialEq)]
pub struct Mapping {
    /// Where it comes from.
    pub source: Source,
    /// The mapping, once it is loaded.
    pub mapping: Option<ParameterMapping>,
    /// Where it stands.
    pub line: Line,
}

/// An SSV.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterSet {
    /// Version of the format.
    pub version: String,
    /// Name of the set.
    pub name: String,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// Units that they refer to.
    pub units: Vec<Unit>,
    /// Enumerations that they refer to.
    pub enumerations: Vec<Enumeration>,
}

impl ParameterSet {
    /// An empty set of version 1.0.
    pub fn new(name: impl Into<String>) -> Self {
        ParameterSet {
            version: "1.0".to_owned(),
            name: name.into(),
            parameters: Vec::new(),
            units: Vec::new(),
            enumerations: Vec::new(),
        }
    }
}

/// A parameter and its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// The parameter's name.
    pub name: String,
    /// The parameter's value.
    pub value: ParameterValue,
    /// Unit of a real value.
    pub unit: Option<String>,
    /// Where it stands.
    pub line: Line,
}

/// The value of a parameter; arrays (2.0) have several.
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterValue {
    /// Real numbers.
    Real(Vec<f64>),
    /// Whole numbers.
    Integer(Vec<i64>),
    /// Truth values.
    Boolean(Vec<bool>),
    /// Texts.
    Text(Vec<String>),
    /// Names of an enumeration's items, and the enumeration's name if stated.
    Enumeration(Vec<String>, Option<String>),
    /// Bytes.
    Binary(Vec<u8>),
}

/// An SSM.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterMapping {
    /// Version of the format.
    pub version: String,
    /// The entries.
    pub entries: Vec<MappingEntry>,
}

/// How one parameter is mapped.
#[derive(Debug, Clone, PartialEq)]
pub struct MappingEntry {
    /// Name in the set, with the binding's prefix.
    pub source: String,
    /// Name in the component or system.
    pub target: String,
    /// Applied after unit conversion.
    pub transformation: Option<Transformation>,
    /// Units are not converted.
    pub suppress_unit_conversion: bool,
    /// Where it stands.
    pub line: Line,
}

/// A parameter of a set as a binding applies it.
#[derive(Debug, Clone, PartialEq)]
pub struct Mapped<'a> {
    /// Name in the component or system.
    pub target: String,
    /// The parameter.
    pub parameter: &'a Parameter,
    /// The entry that maps it.
    pub entry: Option<&'a MappingEntry>,
}

impl Binding {
    /// A set inside the SSD.
    pub fn inline(values: ParameterSet) -> Self {
        Binding {
            prefix: String::new(),
            source: Source::Inline,
            values: Some(values),
            mapping: None,
            line: Line(0),
        }
    }

    /// The parameters with the prefix before their names and mapped. With a mapping, those that it
    /// does not name are not applied.
    pub fn mapped(&self) -> Vec<Mapped<'_>> {
        let parameters = self.values.iter().flat_map(|values| &values.parameters);
        let named = parameters.map(|p| (format!("{}{}", self.prefix, p.name), p));
        let Some(mapping) = &self.mapping else {
            return named
                .map(|(target, parameter)| Mapped { target, parameter, entry: None })
                .collect();
        };
        let entries = || mapping.mapping.iter().flat_map(|mapping| &mapping.entries);
        named
            .flat_map(|(name, parameter)| {
                entries().filter(move |entry| entry.source == name).map(move |entry| Mapped {
                    target: entry.target.clone(),
                    parameter,
                    entry: Some(entry),
                })
            })
            .collect()
    }
}

/// What a tool noted: `type`, and the content as XML.
#[derive(Debug, Clone, PartialEq)]
pub struct Annotation {
    /// Reversed domain of the tool.
    pub kind: String,
    /// The content, if it is an element.
    pub content: Option<xml::Element>,
}
