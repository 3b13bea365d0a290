//! A system without hierarchy.
//!
//! Connections are followed through the connectors of systems from each input back to its source.
//! Parameter bindings are resolved to the variables of components.

mod bindings;
mod dictionaries;

use std::collections::{HashMap, HashSet};

use super::connector::{Connector, Dimension, Kind};
use super::problem::{Format, problem};
use super::structure::*;
use crate::description::{Line, Unit};
use crate::problem::Problem;

/// A system as components and what connects them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Flat {
    /// All components, in the order of the file.
    pub components: Vec<FlatComponent>,
    /// All connections between components.
    pub connections: Vec<FlatConnection>,
    /// The variables that connectors of the outermost system feed.
    pub inputs: Vec<FlatInput>,
    /// The variables that connectors of the outermost system show.
    pub outputs: Vec<FlatOutput>,
    /// Start values of variables.
    pub starts: Vec<FlatStart>,
    /// Parameters and mappings that reach nothing.
    pub notes: Vec<String>,
}

/// A component and its place in the hierarchy.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatComponent {
    /// Names of the systems around it but the outermost, and its own, joined by dots.
    pub path: String,
    /// The flat component's source, as the SSD says.
    pub source: String,
    /// Which interface of the FMU is used.
    pub implementation: Implementation,
    /// The flat component's media type.
    pub media_type: String,
    /// What tools noted.
    pub annotations: Vec<Annotation>,
    /// Where it stands.
    pub line: Line,
}

/// A step of a signal's way: unit conversion where both units are known, then the transformation.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// Unit before, if the connector states one.
    pub from: Option<Unit>,
    /// Unit after, if the connector states one.
    pub to: Option<Unit>,
    /// Units are not converted.
    pub suppress_unit_conversion: bool,
    /// Factor and offset, applied after unit conversion.
    pub transformation: Option<(f64, f64)>,
}

/// A connection from component to component.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatConnection {
    /// Path of the component and variable that feed.
    pub from: (String, String),
    /// Path of the component and variable that are fed.
    pub to: (String, String),
    /// What happens on the way, in its order.
    pub way: Vec<Linear>,
    /// Line of the connection to the input.
    pub line: Line,
}

/// A variable that a connector of the outermost system feeds.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatInput {
    /// Name of the system's connector.
    pub connector: String,
    /// Path of the component and variable that are fed.
    pub to: (String, String),
    /// What happens on the way, in its order.
    pub way: Vec<Linear>,
    /// Line of the connection to the input.
    pub line: Line,
}

/// A variable that a connector of the outermost system shows.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatOutput {
    /// Name of the system's connector.
    pub connector: String,
    /// Path of the component and variable that are shown.
    pub from: (String, String),
    /// What happens on the way, in its order.
    pub way: Vec<Linear>,
    /// Line of the connection to the output.
    pub line: Line,
}

/// A start value of a component's variable.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatStart {
    /// Path of the component and variable.
    pub to: (String, String),
    /// The value, mappings of truth values, numbers and items applied.
    pub value: ParameterValue,
    /// The flat start's unit and what happens on the way to the variable.
    pub way: Linear,
    /// File and line of the parameter, for messages.
    pub place: String,
}

impl SystemStructure {
    /// The structure without hierarchy. `file` is its name in messages.
    ///
    /// # Errors
    /// Everything that does not fit together: names that stand twice or do not exist, connections
    /// between connectors of the wrong kinds, inputs with two sources, units that are not defined.
    pub fn flatten(&self, file: &str) -> Result<Flat, Vec<Problem>> {
        let mut flattener = Flattener {
            structure: self,
            file,
            enclosing: Vec::new(),
            shared: HashMap::new(),
            nodes: HashMap::new(),
            sources: HashMap::new(),
            flat: Flat::default(),
            problems: Vec::new(),
        };
        flattener.system(&self.system, "");
        flattener.trace();
        flattener.bindings();
        match flattener.problems.is_empty() {
            true => Ok(flattener.flat),
            false => Err(flattener.problems),
        }
    }
}

/// Arrays with more elements are not connected element by element.
const MOST_ELEMENTS: u64 = 1 << 16;

/// Path of an element, empty for the outermost system, and the name of its connector.
type Node = (String, String);

#[derive(Clone)]
struct NodeInfo {
    kind: Kind,
    unit: Option<Unit>,
    is_component: bool,
    /// Names of the elements of an array whose sizes are stated.
    elements: Vec<String>,
}

/// What feeds a node.
#[derive(Clone)]
struct Feed {
    from: Node,
    way: Linear,
    line: Line,
}

struct Flattener<'a> {
    structure: &'a SystemStructure,
    file: &'a str,
    /// The systems around the present one, and itself, with their paths.
    enclosing: Vec<(String, &'a System)>,
    /// The dictionary's path of each reference to it, by the path of the reference.
    shared: HashMap<String, String>,
    nodes: HashMap<Node, NodeInfo>,
    sources: HashMap<Node, Feed>,
    flat: Flat,
    problems: Vec<Problem>,
}

/// Whether a connector gives or takes, seen from the system that holds the connection.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    Gives,
    Takes,
    Either,
}

fn role(kind: Kind, own: bool) -> Role {
    let gives = match kind {
        Kind::Output | Kind::CalculatedParameter | Kind::Constant | Kind::Local => true,
        Kind::Input | Kind::Parameter | Kind::StructuralParameter => false,
        Kind::Inout | Kind::Unspecified => return Role::Either,
    };
    // What a system takes from outside it gives to its elements.
    if gives != own { Role::Gives } else { Role::Takes }
}

fn joined(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

impl<'a> Flattener<'a> {
    fn report(&mut self, line: Line, found: String, rule: &str, way_out: &str) {
        let found = problem(Format::Structure, self.file, line.0, found);
        self.problems.push(found.rule(rule).way_out(way_out));
    }

    /// A unit of the SSD that the SSD names at this line.
    fn unit(&mut self, name: &str, line: Line) -> Option<Unit> {
        let file = self.file;
        self.unit_of(name, Format::Structure, file, line)
    }

    /// A unit of the SSD that a file names at this line.
    fn unit_of(&mut self, name: &str, format: Format, file: &str, line: Line) -> Option<Unit> {
        let found = self.structure.units.iter().find(|unit| unit.name == name).cloned();
        if found.is_none() {
            let problem = problem(format, file, line.0, format!("unit \"{name}\" is not defined"));
            let rule = "a unit that is used is defined in <Units>";
            self.problems.push(problem.rule(rule).way_out("add the unit to <Units>"));
        }
        found
    }

    fn connectors(&mut self, path: &str, connectors: &[Connector], is_component: bool) {
        for connector in connectors {
            let name = connector.data_type.as_ref().and_then(|t| t.unit.as_deref());
            let unit = name.and_then(|name| self.unit(name, connector.line));
            let elements = elements(connector);
            let info = NodeInfo { kind: connector.kind, unit, is_component, elements };
            let node = (path.to_owned(), connector.name.clone());
            if self.nodes.insert(node, info).is_some() {
                self.report(
                    connector.line,
                    format!("two connectors are called \"{}\"", connector.name),
                    "names of connectors are unique in their element",
                    "remove one of them",
                );
            }
        }
    }

    fn system(&mut self, system: &'a System, path: &str) {
        self.enclosing.push((path.to_owned(), system));
        self.connectors(path, &system.connectors, false);
        let mut names = HashSet::new();
        for element in &system.elements {
            if !names.insert(element.name()) {
                self.report(
                    element.line(),
                    format!("two elements are called \"{}\"", element.name()),
                    "names of elements are unique in their system",
                    "give one of them another name",
                );
                continue;
            }
            let inner = joined(path, element.name());
            match element {
                Element::System(system) => self.system(system, &inner),
                Element::Dictionary(reference) => self.reference(reference, &inner),
                Element::Component(component) => {
                    self.connectors(&inner, &component.connectors, true);
                    self.flat.components.push(FlatComponent {
                        path: inner,
                        source: component.source.clone(),
                        implementation: component.implementation,
                        media_type: component.media_type.clone(),
                        annotations: component.annotations.clone(),
                        line: component.line,
                    });
                }
            }
        }
        for connection in &system.connections {
            self.connection((system, &names), connection, path);
        }
        self.enclosing.pop();
    }

    /// A connection of a system with elements of these names.
    fn connection(
        &mut self,
        system: (&System, &HashSet<&str>),
        connection: &Connection,
        path: &str,
    ) {
        let start = self.end(system, &connection.start, path, connection.line);
        let end = self.end(system, &connection.end, path, connection.line);
        let (Some(start), Some(end)) = (start, end) else { return };
        let ((start, start_role), (end, end_role)) = (start, end);
        let forward = match (start_role, end_role) {
            (Role::Gives, Role::Takes | Role::Either) | (Role::Either, Role::Takes) => true,
            (Role::Takes, Role::Gives | Role::Either) | (Role::Either, Role::Gives) => false,
            _ => {
                let found = format!(
                    "the connection from {} to {} joins two connectors that both {}",
                    connection.start,
                    connection.end,
                    if start_role == Role::Takes { "take" } else { "give" }
                );
                let rule = "a connection leads from an output to an input, or from a connector \
                            of the system to one of its elements of the same kind";
                self.report(connection.line, found, rule, "correct the kinds or the connection");
                return;
            }
        };
        let (from, to) = if forward { (start, end) } else { (end, start) };
        let unit = |node: &Node| self.nodes.get(node).and_then(|info| info.unit.clone());
        let way = Linear {
            from: unit(&from),
            to: unit(&to),
            suppress_unit_conversion: connection.suppress_unit_conversion,
            transformation: None,
        };
        let transformation = self.linear(connection);
        let feed = Feed { from, way: Linear { transformation, ..way }, line: connection.line };
        let name = if forward { &connection.end } else { &connection.start };
        if let Some(other) = self.sources.insert(to, feed) {
            self.report(
                connection.line,
                format!("{name} has a second source; the first is at line {}", other.line.0),
                "an input has one source",
                "remove one of the connections",
            );
        }
    }

    fn linear(&mut self, connection: &Connection) -> Option<(f64, f64)> {
        match &connection.transformation {
            None => None,
            Some(Transformation::Linear { factor, offset }) => Some((*factor, *offset)),
            Some(_) => {
                self.report(
                    connection.line,
                    format!("the connection to {} maps values", connection.end),
                    "connections transform numbers linearly only",
                    "use a LinearTransformation, or let an FMU map the values",
                );
                None
            }
        }
    }

    fn end(
        &mut self,
        (system, names): (&System, &HashSet<&str>),
        end: &End,
        path: &str,
        line: Line,
    ) -> Option<(Node, Role)> {
        let (path, own) = match &end.element {
            None => (path.to_owned(), true),
            Some(name) if names.contains(name.as_str()) => (joined(path, name), false),
            Some(name) => {
                let there: Vec<&str> = system.elements.iter().map(Element::name).collect();
                let found = format!("a connection names the element \"{name}\"");
                let rule =
                    format!("elements of system \"{}\" are: {}", system.name, there.join(", "));
                self.report(line, found, &rule, "correct the name");
                return None;
            }
        };
        let shared = self.shared.get(&path).cloned();
        let node = (path, end.connector.clone());
        match self.nodes.get(&node) {
            Some(info) => {
                let role = role(info.kind, own);
                // All references to a dictionary are one place.
                Some(((shared.unwrap_or(node.0), node.1), role))
            }
            None => {
                let found =
                    format!("a connection names the connector {end}, which is not declared");
                let rule = "connectors that are connected are declared in <Connectors>";
                self.report(line, found, rule, "declare the connector or correct the name");
                None
            }
        }
    }

    /// The origin of what feeds a node: a component's or the outermost system's, or nothing.
    fn origin(&mut self, node: &Node) -> Option<(Node, Vec<Linear>, Line)> {
        let first = self.sources.get(node)?.clone();
        let (mut at, mut way, line) = (first.from, vec![first.way], first.line);
        while self.nodes.get(&at).is_some_and(|info| !info.is_component) && !at.0.is_empty() {
            let feed = self.sources.get(&at)?.clone();
            at = feed.from;
            way.insert(0, feed.way);
            if way.len() > self.nodes.len() {
                self.report(
                    line,
                    format!("connections through \"{}\" form a circle", at.1),
                    "a signal comes from a component or from outside",
                    "remove one of the connections",
                );
                return None;
            }
        }
        Some((at, way, line))
    }

    fn trace(&mut self) {
        let mut sinks: Vec<(u32, Node)> =
            self.sources.iter().map(|(node, feed)| (feed.line.0, node.clone())).collect();
        sinks.sort();
        for (_, sink) in sinks {
            let is_component = self.nodes.get(&sink).is_some_and(|info| info.is_component);
            if !is_component && !sink.0.is_empty() {
                continue;
            }
            let Some((from, way, line)) = self.origin(&sink) else { continue };
            for (from, to) in self.elementwise(from, sink, line) {
                let way = way.clone();
                match (from.0.is_empty(), is_component) {
                    (false, true) => {
                        self.flat.connections.push(FlatConnection { from, to, way, line });
                    }
                    (true, true) => {
                        let connector = from.1;
                        self.flat.inputs.push(FlatInput { connector, to, way, line });
                    }
                    (false, false) => {
                        let connector = to.1;
                        self.flat.outputs.push(FlatOutput { connector, from, way, line });
                    }
                    // From outside to outside: no component takes part.
                    (true, false) => {}
                }
            }
        }
    }

    /// A connection, or, of two arrays, one for each of their elements. Where only one side states its
    /// sizes, the other has the same.
    fn elementwise(&mut self, from: Node, to: Node, line: Line) -> Vec<(Node, Node)> {
        let suffixes = |this: &Self, node: &Node| {
            this.nodes.get(node).map(|info| info.elements.clone()).unwrap_or_default()
        };
        let (a, b) = (suffixes(self, &from), suffixes(self, &to));
        if !a.is_empty() && !b.is_empty() && a != b {
            let found = format!(
                "an array of {} elements is connected to one of {}: {}.{} to {}.{}",
                a.len(),
                b.len(),
                from.0,
                from.1,
                to.0,
                to.1
            );
            let rule = "connected arrays have the same sizes";
            self.report(line, found, rule, "correct the <Dimension> of one of them");
            return Vec::new();
        }
        let indices = if a.is_empty() { b } else { a };
        if indices.is_empty() {
            return vec![(from, to)];
        }
        let element = |node: &Node, index: &String| (node.0.clone(), format!("{}{index}", node.1));
        indices.iter().map(|index| (element(&from, index), element(&to, index))).collect()
    }
}

/// `[1]`, `[2]`, … or `[1,1]`, `[1,2]`, … of an array whose sizes are stated and not too many to list.
fn elements(connector: &Connector) -> Vec<String> {
    let size = |dimension: &Dimension| match dimension {
        Dimension::Size(size) => Some(*size),
        Dimension::Connector(_) => None,
    };
    let sizes: Option<Vec<u64>> = connector.dimensions.iter().map(size).collect();
    let Some(sizes) = sizes.filter(|sizes| !sizes.is_empty()) else { return Vec::new() };
    let count = sizes.iter().try_fold(1_u64, |count, size| count.checked_mul(*size));
    if count.is_none_or(|count| count > MOST_ELEMENTS) {
        return Vec::new();
    }
    let heads = sizes.iter().fold(vec![String::new()], |heads, size| {
        let longer = |head: &String, index: u64| match head.as_str() {
            "" => index.to_string(),
            head => format!("{head},{index}"),
        };
        heads.iter().flat_map(|head| (1..=*size).map(move |index| longer(head, index))).collect()
    });
    heads.iter().map(|index| format!("[{index}]")).collect()
}
