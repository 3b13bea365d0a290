//! Writes SSD, SSV, SSM, and what they share with an SSB.

use super::connector::{Connector, Dimension, Source};
use super::dictionary::{DictionaryReference, SignalDictionary};
use super::problem::{Format, SspError};
use super::structure::*;
use crate::description::Unit;
use crate::variable::DataType;
use crate::xml::Element as Xml;

const COMMON: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";

impl SystemStructure {
    /// The SSD as XML of version 1.0.
    ///
    /// # Errors
    /// A text that XML cannot carry.
    pub fn to_xml(&self) -> Result<String, SspError> {
        let mut root = root(Format::Structure, "ssd");
        root.attributes.push(("xmlns:ssv".to_owned(), Format::Values.namespace()));
        root.attributes.push(("xmlns:ssm".to_owned(), Format::Mapping.namespace()));
        root.attributes.push(("xmlns:ssb".to_owned(), Format::Dictionary.namespace()));
        let root = root
            .with("version", &self.version)
            .with("name", &self.name)
            .maybe("description", self.description.as_deref())
            .maybe("generationTool", self.generation_tool.as_deref())
            .holding(system(&self.system))
            .list("ssd:Enumerations", self.enumerations.iter().map(enumeration))
            .list("ssd:Units", self.units.iter().map(unit));
        let Experiment { start_time, stop_time } = self.default_experiment;
        let experiment = element("ssd:DefaultExperiment")
            .maybe("startTime", start_time.map(number).as_deref())
            .maybe("stopTime", stop_time.map(number).as_deref());
        let stated = !experiment.attributes.is_empty();
        text(&if stated { root.holding(experiment) } else { root })
    }
}

impl ParameterSet {
    /// The SSV as XML.
    ///
    /// # Errors
    /// A text that XML cannot carry.
    pub fn to_xml(&self) -> Result<String, SspError> {
        document(Format::Values, "ssv", set(self))
    }
}

impl ParameterMapping {
    /// The SSM as XML.
    ///
    /// # Errors
    /// A text that XML cannot carry.
    pub fn to_xml(&self) -> Result<String, SspError> {
        document(Format::Mapping, "ssm", mapping_content(self))
    }
}

impl SignalDictionary {
    /// The list as an SSB.
    ///
    /// # Errors
    /// A text that XML cannot carry.
    pub fn to_xml(&self) -> Result<String, SspError> {
        document(Format::Dictionary, "ssb", dictionary_content(self))
    }
}

/// The content as a file of its own.
fn document(format: Format, prefix: &str, content: Xml) -> Result<String, SspError> {
    let mut root = root(format, prefix);
    root.attributes.extend(content.attributes);
    root.children = content.children;
    text(&root)
}

fn root(format: Format, prefix: &str) -> Xml {
    let mut root = element(&format!("{prefix}:{}", format.root()));
    root.attributes.push((format!("xmlns:{prefix}"), format.namespace()));
    root.attributes.push(("xmlns:ssc".to_owned(), COMMON.to_owned()));
    root
}

fn element(name: &str) -> Xml {
    Xml { name: name.to_owned(), attributes: Vec::new(), children: Vec::new(), line: 0 }
}

/// Building an element attribute by attribute and child by child.
impl Xml {
    fn with(mut self, name: &str, value: &str) -> Self {
        self.attributes.push((name.to_owned(), value.to_owned()));
        self
    }

    fn maybe(self, name: &str, value: Option<&str>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    fn flag(self, name: &str, value: bool) -> Self {
        self.maybe(name, value.then_some("true"))
    }

    fn holding(mut self, child: Xml) -> Self {
        self.children.push(child);
        self
    }

    fn holding_all(mut self, children: impl Iterator<Item = Xml>) -> Self {
        self.children.extend(children);
        self
    }

    /// A list element, left out where it would be empty.
    fn list(self, name: &str, items: impl Iterator<Item = Xml>) -> Self {
        let list = element(name).holding_all(items);
        if list.children.is_empty() { self } else { self.holding(list) }
    }
}

fn system(system: &System) -> Xml {
    let elements = system.elements.iter().map(|inner| match inner {
        Element::Component(inner) => component(inner),
        Element::System(inner) => self::system(inner),
        Element::Dictionary(inner) => dictionary_reference(inner),
    });
    element("ssd:System")
        .maybe("description", system.description.as_deref())
        .with("name", &system.name)
        .list("ssd:Connectors", system.connectors.iter().map(connector))
        .list("ssd:ParameterBindings", system.bindings.iter().map(binding))
        .list("ssd:Elements", elements)
        .list("ssd:Connections", system.connections.iter().map(connection))
        .list("ssd:SignalDictionaries", system.dictionaries.iter().map(dictionary))
        .list("ssd:Annotations", system.annotations.iter().map(annotation))
}

fn component(component: &Component) -> Xml {
    let any = component.implementation == Implementation::Any;
    element("ssd:Component")
        .maybe("description", component.description.as_deref())
        .with("name", &component.name)
        .with("type", &component.media_type)
        .with("source", &component.source)
        .maybe("implementation", (!any).then_some(component.implementation.name()))
        .list("ssd:Connectors", component.connectors.iter().map(connector))
        .list("ssd:ParameterBindings", component.bindings.iter().map(binding))
        .list("ssd:Annotations", component.annotations.iter().map(annotation))
}

fn annotation(annotation: &Annotation) -> Xml {
    element("ssc:Annotation")
        .with("type", &annotation.kind)
        .holding_all(annotation.content.clone().into_iter())
}

fn connector(connector: &Connector) -> Xml {
    element("ssd:Connector")
        .with("name", &connector.name)
        .with("kind", connector.kind.name())
        .holding_all(stated_type(connector).into_iter())
        .holding_all(connector.dimensions.iter().map(|dimension| match dimension {
            Dimension::Size(size) => element("ssd:Dimension").with("size", &size.to_string()),
            Dimension::Connector(name) => element("ssd:Dimension").with("sizeConnector", name),
        }))
}

/// The type of a connector or of a signal.
fn stated_type(connector: &Connector) -> Option<Xml> {
    connector.data_type.as_ref().map(|stated| {
        let name = match stated.data_type {
            DataType::Float64 | DataType::Float32 => "Real",
            DataType::Boolean | DataType::String | DataType::Enumeration | DataType::Binary => {
                stated.data_type.name()
            }
            _ => "Integer",
        };
        element(&format!("ssc:{name}"))
            .maybe("unit", stated.unit.as_deref())
            .maybe("name", stated.enumeration.as_deref())
    })
}

fn connection(connection: &Connection) -> Xml {
    let Connection { start, end, transformation, suppress_unit_conversion, .. } = connection;
    element("ssd:Connection")
        .maybe("startElement", start.element.as_deref())
        .with("startConnector", &start.connector)
        .maybe("endElement", end.element.as_deref())
        .with("endConnector", &end.connector)
        .flag("suppressUnitConversion", *suppress_unit_conversion)
        .holding_all(transformation.iter().map(transformed))
}

fn transformed(transformation: &Transformation) -> Xml {
    let entry = |source: String, target: String| {
        element("ssc:MapEntry").with("source", &source).with("target", &target)
    };
    match transformation {
        Transformation::Linear { factor, offset } => element("ssc:LinearTransformation")
            .with("factor", &number(*factor))
            .with("offset", &number(*offset)),
        Transformation::Boolean(map) => element("ssc:BooleanMappingTransformation")
            .holding_all(map.iter().map(|(s, t)| entry(s.to_string(), t.to_string()))),
        Transformation::Integer(map) => element("ssc:IntegerMappingTransformation")
            .holding_all(map.iter().map(|(s, t)| entry(s.to_string(), t.to_string()))),
        Transformation::Enumeration(map) => element("ssc:EnumerationMappingTransformation")
            .holding_all(map.iter().map(|(s, t)| entry(s.clone(), t.clone()))),
    }
}

fn binding(binding: &Binding) -> Xml {
    let inline = match (&binding.source, &binding.values) {
        (Source::Inline, Some(values)) => Some(element("ssd:ParameterValues").holding(set(values))),
        _ => None,
    };
    let prefix = Some(binding.prefix.as_str()).filter(|prefix| !prefix.is_empty());
    sourced(element("ssd:ParameterBinding"), &binding.source)
        .maybe("prefix", prefix)
        .holding_all(inline.into_iter())
        .holding_all(binding.mapping.iter().map(mapping))
}

fn mapping(mapping: &Mapping) -> Xml {
    let inline = match (&mapping.source, &mapping.mapping) {
        (Source::Inline, Some(mapping)) => Some(mapping_content(mapping)),
        _ => None,
    };
    sourced(element("ssd:ParameterMapping"), &mapping.source).holding_all(inline.into_iter())
}

fn sourced(element: Xml, source: &Source) -> Xml {
    match source {
        Source::Inline => element,
        Source::File(file) => element.with("source", file),
        Source::InComponent(file) => element.with("source", file).with("sourceBase", "component"),
    }
}

fn set(set: &ParameterSet) -> Xml {
    let parameters = set.parameters.iter().map(parameter);
    element("ssv:ParameterSet")
        .with("version", &set.version)
        .with("name", &set.name)
        .holding(element("ssv:Parameters").holding_all(parameters))
        .list("ssv:Enumerations", set.enumerations.iter().map(enumeration))
        .list("ssv:Units", set.units.iter().map(unit))
}

fn parameter(parameter: &Parameter) -> Xml {
    let content = match &parameter.value {
        ParameterValue::Real(values) => valued("ssv:Real", values.iter().copied().map(number))
            .maybe("unit", parameter.unit.as_deref()),
        ParameterValue::Integer(values) => valued("ssv:Integer", values.iter().map(i64::to_string)),
        ParameterValue::Boolean(values) => {
            valued("ssv:Boolean", values.iter().map(bool::to_string))
        }
        ParameterValue::Text(texts) => texts_of("ssv:String", texts),
        ParameterValue::Enumeration(items, name) => {
            texts_of("ssv:Enumeration", items).maybe("name", name.as_deref())
        }
        ParameterValue::Binary(bytes) => element("ssv:Binary").with("value", &hex::encode(bytes)),
    };
    element("ssv:Parameter").with("name", &parameter.name).holding(content)
}

fn valued(name: &str, values: impl Iterator<Item = String>) -> Xml {
    element(name).with("value", &values.collect::<Vec<_>>().join(" "))
}

/// One text as attribute; several (2.0) as children.
fn texts_of(name: &str, texts: &[String]) -> Xml {
    match texts {
        [text] => element(name).with("value", text),
        texts => element(name)
            .holding_all(texts.iter().map(|text| element("ssv:Value").with("value", text))),
    }
}

fn mapping_content(mapping: &ParameterMapping) -> Xml {
    let entries = mapping.entries.iter().map(|entry| {
        element("ssm:MappingEntry")
            .with("source", &entry.source)
            .with("target", &entry.target)
            .flag("suppressUnitConversion", entry.suppress_unit_conversion)
            .holding_all(entry.transformation.iter().map(transformed))
    });
    element("ssm:ParameterMapping").with("version", &mapping.version).holding_all(entries)
}

/// `<ssd:SignalDictionary>`, with the list inside where it is inline.
fn dictionary(dictionary: &SignalDictionary) -> Xml {
    let inline =
        matches!(dictionary.source, Source::Inline).then(|| dictionary_content(dictionary));
    sourced(element("ssd:SignalDictionary"), &dictionary.source)
        .with("name", &dictionary.name)
        .holding_all(inline.into_iter())
}

/// `<ssd:SignalDictionaryReference>`.
fn dictionary_reference(reference: &DictionaryReference) -> Xml {
    element("ssd:SignalDictionaryReference")
        .with("name", &reference.name)
        .with("dictionary", &reference.dictionary)
        .list("ssd:Connectors", reference.connectors.iter().map(connector))
}

fn dictionary_content(dictionary: &SignalDictionary) -> Xml {
    let entries = dictionary.signals.iter().flatten().map(|signal| {
        element("ssb:DictionaryEntry")
            .with("name", &signal.name)
            .holding_all(stated_type(signal).into_iter())
    });
    element("ssb:SignalDictionary")
        .with("version", "1.0")
        .holding_all(entries)
        .list("ssb:Units", dictionary.units.iter().map(unit))
}

fn enumeration(enumeration: &Enumeration) -> Xml {
    let items = enumeration.items.iter().map(|(name, value)| {
        element("ssc:Item").with("name", name).with("value", &value.to_string())
    });
    element("ssc:Enumeration").with("name", &enumeration.name).holding_all(items)
}

fn unit(unit: &Unit) -> Xml {
    let base = unit.base.unwrap_or_default();
    let exponents = base.exponents().into_iter().filter(|(_, exponent)| *exponent != 0);
    let mut content = element("ssc:BaseUnit");
    for (name, exponent) in exponents {
        content = content.with(name, &exponent.to_string());
    }
    if base.factor != 1.0 {
        content = content.with("factor", &number(base.factor));
    }
    if base.offset != 0.0 {
        content = content.with("offset", &number(base.offset));
    }
    element("ssc:Unit").with("name", &unit.name).holding(content)
}

/// `xs:double` that reads back as the same bits.
fn number(value: f64) -> String {
    match value {
        value if value.is_nan() => "NaN".to_owned(),
        f64::INFINITY => "INF".to_owned(),
        f64::NEG_INFINITY => "-INF".to_owned(),
        value => format!("{value:?}"),
    }
}

/// The document as indented text.
fn text(root: &Xml) -> Result<String, SspError> {
    let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned();
    write_element(root, 0, &mut text)?;
    Ok(text)
}

fn write_element(element: &Xml, depth: usize, text: &mut String) -> Result<(), SspError> {
    let indent = "  ".repeat(depth);
    text.push_str(&format!("{indent}<{}", element.name));
    for (name, value) in &element.attributes {
        text.push_str(&format!(" {name}=\""));
        for character in value.chars() {
            write_escaped(character, text).map_err(|character| SspError::Character {
                element: element.name.clone(),
                attribute: name.clone(),
                character,
            })?;
        }
        text.push('"');
    }
    if element.children.is_empty() {
        text.push_str("/>\n");
        return Ok(());
    }
    text.push_str(">\n");
    for child in &element.children {
        write_element(child, depth + 1, text)?;
    }
    text.push_str(&format!("{indent}</{}>\n", element.name));
    Ok(())
}

/// Tabs and line breaks, written as they are, would be read back as spaces.
fn write_escaped(character: char, text: &mut String) -> Result<(), u32> {
    match character {
        '&' => text.push_str("&amp;"),
        '<' => text.push_str("&lt;"),
        '>' => text.push_str("&gt;"),
        '"' => text.push_str("&quot;"),
        '\t' | '\n' | '\r' => text.push_str(&format!("&#{};", u32::from(character))),
        '\u{0}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => return Err(character.into()),
        _ => text.push(character),
    }
    Ok(())
}
