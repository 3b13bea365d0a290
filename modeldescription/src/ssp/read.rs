//! Reads an SSD.

use super::connector::{Connector, ConnectorType, Dimension, Kind, Source};
use super::dictionary::{DictionaryReference, SignalDictionary};
use super::problem::Format;
use super::reader::{Reader, child, children, connector_type, listed, local};
use super::structure::*;
use super::values;
use crate::description::Line;
use crate::problem::Problem;
use crate::variable::DataType;
use crate::xml::{self, XmlLimits};

impl SystemStructure {
    /// Reads an SSD. `file` is its name in messages.
    ///
    /// # Errors
    /// Everything that cannot be understood, with file and line.
    pub fn parse(bytes: &[u8], file: &str) -> Result<Self, Vec<Problem>> {
        let mut problems = Vec::new();
        let structure = read(bytes, file, &XmlLimits::default(), &mut problems);
        match structure {
            Some(structure) if problems.is_empty() => Ok(structure),
            _ => Err(problems),
        }
    }
}

/// Reads as far as possible.
pub(super) fn read(
    bytes: &[u8],
    file: &str,
    limits: &XmlLimits,
    problems: &mut Vec<Problem>,
) -> Option<SystemStructure> {
    let mut reader = Reader { file: file.to_owned(), format: Format::Structure, problems };
    let root = reader.root(bytes, limits)?;
    let known = ["System", "Enumerations", "Units", "DefaultExperiment"];
    reader.only(&root, &known, &["Annotations", "MetaData", "Signature"]);
    let Some(system) = child(&root, "System") else {
        let found = format!("<{}> has no <System>", root.name);
        reader.report(root.line, found, "an SSD holds one system", "add the system");
        return None;
    };
    Some(SystemStructure {
        version: reader.version(&root),
        name: reader.required(&root, "name"),
        description: root.attribute("description").map(str::to_owned),
        generation_tool: root.attribute("generationTool").map(str::to_owned),
        system: read_system(&mut reader, system),
        units: values::units(&mut reader, &root),
        enumerations: values::enumerations(&mut reader, &root),
        default_experiment: experiment(&mut reader, &root),
    })
}

fn experiment(reader: &mut Reader<'_>, root: &xml::Element) -> Experiment {
    let Some(element) = child(root, "DefaultExperiment") else { return Experiment::default() };
    Experiment {
        start_time: reader.float(element, "startTime"),
        stop_time: reader.float(element, "stopTime"),
    }
}

fn read_system(reader: &mut Reader<'_>, element: &xml::Element) -> System {
    let content = ["Connectors", "ParameterBindings", "Elements", "Connections"];
    let further = ["SignalDictionaries", "Annotations"];
    let graphics = ["ElementGeometry", "SystemGeometry", "GraphicalElements"];
    let unread = ["MetaData", "Signature"];
    let known = [&content[..], &further].concat();
    reader.only(element, &known, &[&graphics[..], &unread].concat());
    System {
        name: name(reader, element),
        description: element.attribute("description").map(str::to_owned),
        connectors: connectors(reader, element),
        bindings: bindings(reader, element),
        elements: elements(reader, element),
        connections: listed(element, "Connections", "Connection")
            .map(|connection| read_connection(reader, connection))
            .collect(),
        dictionaries: listed(element, "SignalDictionaries", "SignalDictionary")
            .map(|found| dictionary(reader, found))
            .collect(),
        annotations: annotations(element),
        line: Line(element.line),
    }
}

/// `<SignalDictionary>` of a system.
fn dictionary(reader: &mut Reader<'_>, element: &xml::Element) -> SignalDictionary {
    let inline = element.children.iter().find(|c| local(&c.name) == Format::Dictionary.root());
    let mut found = SignalDictionary {
        name: reader.required(element, "name"),
        source: source(reader, element, inline.is_some()),
        signals: None,
        units: Vec::new(),
        line: Line(element.line),
    };
    if let Some(list) = inline {
        fill_dictionary(reader, list, &mut found);
    }
    found
}

/// `<SignalDictionaryReference>` of a system.
fn dictionary_reference(reader: &mut Reader<'_>, element: &xml::Element) -> DictionaryReference {
    reader.only(element, &["Connectors"], &["ElementGeometry", "Annotations", "ParameterBindings"]);
    DictionaryReference {
        name: name(reader, element),
        dictionary: reader.required(element, "dictionary"),
        connectors: connectors(reader, element),
        line: Line(element.line),
    }
}

/// Reads an SSB into a dictionary as far as possible.
pub(super) fn load_dictionary(
    bytes: &[u8],
    file: &str,
    limits: &XmlLimits,
    problems: &mut Vec<Problem>,
    into: &mut SignalDictionary,
) {
    let mut reader = Reader { file: file.to_owned(), format: Format::Dictionary, problems };
    if let Some(root) = reader.root(bytes, limits) {
        fill_dictionary(&mut reader, &root, into);
    }
}

fn fill_dictionary(reader: &mut Reader<'_>, list: &xml::Element, into: &mut SignalDictionary) {
    reader.only(list, &["DictionaryEntry", "Enumerations", "Units"], &["Annotations"]);
    reader.version(list);
    into.units = values::units(reader, list);
    let mut signals: Vec<Connector> = Vec::new();
    for entry in children(list, "DictionaryEntry") {
        let signal = Connector {
            name: reader.required(entry, "name"),
            kind: Kind::Inout,
            data_type: stated_type(reader, entry, "signal"),
            dimensions: Vec::new(),
            line: Line(entry.line),
        };
        if signals.iter().any(|other| other.name == signal.name) {
            let found = format!("signal \"{}\" stands in the dictionary twice", signal.name);
            reader.report(entry.line, found, "names are unique", "keep one of them");
        }
        signals.push(signal);
    }
    into.signals = Some(signals);
}

/// A name, which must not be empty.
fn name(reader: &mut Reader<'_>, element: &xml::Element) -> String {
    let name = reader.required(element, "name");
    if element.attribute("name") == Some("") {
        let found = format!("<{}> has an empty name", element.name);
        reader.report(element.line, found, "an element has a name", "give it one");
    }
    name
}

fn elements(reader: &mut Reader<'_>, element: &xml::Element) -> Vec<Element> {
    let mut elements = Vec::new();
    for child in child(element, "Elements").map(|e| e.children.as_slice()).unwrap_or_default() {
        match local(&child.name) {
            "Component" => elements.push(Element::Component(component(reader, child))),
            "System" => elements.push(Element::System(read_system(reader, child))),
            "SignalDictionaryReference" => {
                elements.push(Element::Dictionary(dictionary_reference(reader, child)));
            }
            _ => {
                let found = format!("<{}> stands in <Elements>", child.name);
                let rule = "elements are Component, System and SignalDictionaryReference";
                reader.report(child.line, found, rule, "remove the element");
            }
        }
    }
    elements
}

fn component(reader: &mut Reader<'_>, element: &xml::Element) -> Component {
    let known = ["Connectors", "ParameterBindings", "Annotations"];
    reader.only(element, &known, &["ElementGeometry", "MetaData", "Signature"]);
    let implementation = reader.optional(
        element,
        "implementation",
        "any, ModelExchange, CoSimulation or ScheduledExecution",
        Implementation::from_name,
    );
    Component {
        name: name(reader, element),
        description: element.attribute("description").map(str::to_owned),
        source: reader.required(element, "source"),
        media_type: reader.stated(element, "type").unwrap_or(super::FMU_TYPE).to_owned(),
        implementation: implementation.unwrap_or(Implementation::Any),
        connectors: connectors(reader, element),
        bindings: bindings(reader, element),
        annotations: annotations(element),
        line: Line(element.line),
    }
}

fn connectors(reader: &mut Reader<'_>, element: &xml::Element) -> Vec<Connector> {
    listed(element, "Connectors", "Connector").map(|c| connector(reader, c)).collect()
}

fn connector(reader: &mut Reader<'_>, element: &xml::Element) -> Connector {
    let name = reader.required(element, "name");
    let rule = "input, output, parameter, calculatedParameter or inout";
    let kind = reader.parsed(element, "kind", rule, Kind::from_name);
    if element.attribute("kind").is_none() {
        reader.required(element, "kind");
    }
    let data_type = stated_type(reader, element, "connector");
    let (kind, line) = (kind.unwrap_or(Kind::Input), Line(element.line));
    Connector { name, kind, data_type, dimensions: dimensions(reader, element), line }
}

/// The sizes of a connector that is an array (SSP 2.0).
fn dimensions(reader: &mut Reader<'_>, element: &xml::Element) -> Vec<Dimension> {
    let mut dimensions = Vec::new();
    for found in children(element, "Dimension") {
        let rule = "a whole number from 1 to 16777216";
        let size = |text: &str| text.parse().ok().filter(|size| (1..=1 << 24).contains(size));
        let stated = reader.stated(found, "sizeConnector").map(str::to_owned);
        match (reader.stated(found, "size"), stated) {
            (Some(_), None) => {
                dimensions.extend(reader.parsed(found, "size", rule, size).map(Dimension::Size));
            }
            (None, Some(connector)) => dimensions.push(Dimension::Connector(connector)),
            (both, _) => {
                let what = if both.is_some() { "both" } else { "neither of" };
                let text = format!("<{}> has {what} size and sizeConnector", found.name);
                let rule = "a dimension has one of size and sizeConnector";
                reader.report(found.line, text, rule, "state the size");
            }
        }
    }
    dimensions
}

/// The type that stands in a connector or a signal, which is `what`.
fn stated_type(
    reader: &mut Reader<'_>,
    element: &xml::Element,
    what: &str,
) -> Option<ConnectorType> {
    let name = element.attribute("name").unwrap_or_default();
    let mut data_type = None;
    for child in &element.children {
        match local(&child.name) {
            "ConnectorGeometry" | "Annotations" | "MetaData" | "Signature" => {}
            "Dimension" if what == "connector" => {}
            "Dimension" | "Clock" => {
                let found = format!("{what} \"{name}\" has a <{}>", child.name);
                let rule = "arrays in signal dictionaries and clocks of SSP 2.0 are not supported";
                let way_out = "declare a signal per element of the array, as in command[1]; connect \
                               no clocks";
                reader.report(child.line, found, rule, way_out);
            }
            type_name => match connector_type(type_name) {
                Some(found) => {
                    let unit = reader.stated(child, "unit").map(str::to_owned);
                    let enumeration =
                        (found == DataType::Enumeration).then(|| reader.required(child, "name"));
                    data_type = Some(ConnectorType { data_type: found, unit, enumeration });
                }
                None => {
                    let found = format!("{what} \"{name}\" has the type <{}>", child.name);
                    let rule = "types are Real, Integer, Boolean, String, Enumeration, Binary \
                                and the numeric types of FMI 3.0";
                    reader.report(child.line, found, rule, "correct the type");
                }
            },
        }
    }
    data_type
}

fn read_connection(reader: &mut Reader<'_>, element: &xml::Element) -> Connection {
    // An empty name is the system itself, as OMSimulator writes it.
    let mut end = |element_name: &str, connector: &str| End {
        element: reader.stated(element, element_name).map(str::to_owned),
        connector: reader.required(element, connector),
    };
    let start = end("startElement", "startConnector");
    let end = end("endElement", "endConnector");
    Connection {
        start,
        end,
        transformation: values::transformation(reader, element),
        suppress_unit_conversion: reader.flag(element, "suppressUnitConversion"),
        line: Line(element.line),
    }
}

fn bindings(reader: &mut Reader<'_>, element: &xml::Element) -> Vec<Binding> {
    listed(element, "ParameterBindings", "ParameterBinding").map(|b| binding(reader, b)).collect()
}

fn binding(reader: &mut Reader<'_>, element: &xml::Element) -> Binding {
    media_type(reader, element, "application/x-ssp-parameter-set");
    let inline = child(element, "ParameterValues").and_then(|values| child(values, "ParameterSet"));
    let source = source(reader, element, inline.is_some());
    Binding {
        prefix: element.attribute("prefix").unwrap_or_default().to_owned(),
        source,
        values: inline.map(|set| values::parameter_set(reader, set)),
        mapping: child(element, "ParameterMapping").map(|mapping| read_mapping(reader, mapping)),
        line: Line(element.line),
    }
}

fn read_mapping(reader: &mut Reader<'_>, element: &xml::Element) -> Mapping {
    media_type(reader, element, "application/x-ssp-parameter-mapping");
    let inline = child(element, "ParameterMapping");
    Mapping {
        source: source(reader, element, inline.is_some()),
        mapping: inline.map(|mapping| values::parameter_mapping(reader, mapping)),
        line: Line(element.line),
    }
}

fn media_type(reader: &mut Reader<'_>, element: &xml::Element, wanted: &str) {
    if let Some(found) = reader.stated(element, "type").filter(|found| *found != wanted) {
        let found = format!("<{}> is of type=\"{found}\"", element.name);
        reader.report(element.line, found, format!("only {wanted} is understood"), "convert it");
    }
}

/// `source` and `sourceBase`; exactly one of a source and an inline content must be there.
fn source(reader: &mut Reader<'_>, element: &xml::Element, inline: bool) -> Source {
    let base = reader.optional(element, "sourceBase", "SSD or component", |text| match text {
        "SSD" => Some(false),
        "component" => Some(true),
        _ => None,
    });
    match (element.attribute("source").filter(|source| !source.is_empty()), inline) {
        (Some(source), false) if base == Some(true) => Source::InComponent(source.to_owned()),
        (Some(source), false) => Source::File(source.to_owned()),
        (None, true) => Source::Inline,
        (stated, _) => {
            let what = if stated.is_some() { "both a source and content" } else { "neither" };
            let found = format!("<{}> has {what}", element.name);
            let rule = "the content comes from a source or stands inside, one of the two";
            reader.report(element.line, found, rule, "keep one of them");
            Source::Inline
        }
    }
}

fn annotations(element: &xml::Element) -> Vec<Annotation> {
    let listed = children(element, "Annotations").flat_map(|list| children(list, "Annotation"));
    listed
        .map(|annotation| Annotation {
            kind: annotation.attribute("type").unwrap_or_default().to_owned(),
            content: annotation.children.first().cloned(),
        })
        .collect()
}
