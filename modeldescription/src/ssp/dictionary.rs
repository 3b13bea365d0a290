//! Signal dictionaries: signals that elements share by their names (SSB).

use super::problem::{Format, SspError};
use super::reader::{Reader, children, local};
use super::structure::{Connector, Kind, Source};
use super::{read, values, write};
use crate::description::{Line, Unit};
use crate::problem::Problem;
use crate::xml::{self, XmlLimits};

/// A list of signals. All connectors of one name, at all references to it, are one signal.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalDictionary {
    /// Name, unique in its system; references look it up there and in the systems around.
    pub name: String,
    /// Where the list comes from.
    pub source: Source,
    /// The signals, each a connector of kind inout; none where the list is not loaded.
    pub signals: Option<Vec<Connector>>,
    /// Units that the list brings along.
    pub units: Vec<Unit>,
    /// Where it stands.
    pub line: Line,
}

/// An element that stands for a signal dictionary.
#[derive(Debug, Clone, PartialEq)]
pub struct DictionaryReference {
    /// Name, unique in the enclosing system.
    pub name: String,
    /// Name of the dictionary.
    pub dictionary: String,
    /// The signals that are connected here.
    pub connectors: Vec<Connector>,
    /// Where it stands.
    pub line: Line,
}

impl SignalDictionary {
    /// A list inside the SSD.
    pub fn inline(name: impl Into<String>, signals: Vec<Connector>) -> Self {
        let (name, signals) = (name.into(), Some(signals));
        SignalDictionary { name, source: Source::Inline, signals, units: Vec::new(), line: Line(0) }
    }

    /// The list as an SSB.
    ///
    /// # Errors
    /// A text that XML cannot carry.
    pub fn to_xml(&self) -> Result<String, SspError> {
        let content = content(self);
        let mut root = write::root(Format::Dictionary, "ssb");
        root.attributes.extend(content.attributes);
        root.children = content.children;
        write::text(&root)
    }
}

/// `<SignalDictionary>` of a system.
pub(super) fn dictionary(reader: &mut Reader<'_>, element: &xml::Element) -> SignalDictionary {
    let inline = element.children.iter().find(|c| local(&c.name) == Format::Dictionary.root());
    let mut found = SignalDictionary {
        name: reader.required(element, "name"),
        source: read::source(reader, element, inline.is_some()),
        signals: None,
        units: Vec::new(),
        line: Line(element.line),
    };
    if let Some(list) = inline {
        fill(reader, list, &mut found);
    }
    found
}

/// `<SignalDictionaryReference>` of a system.
pub(super) fn reference(reader: &mut Reader<'_>, element: &xml::Element) -> DictionaryReference {
    reader.only(element, &["Connectors"], &["ElementGeometry", "Annotations", "ParameterBindings"]);
    DictionaryReference {
        name: read::name(reader, element),
        dictionary: reader.required(element, "dictionary"),
        connectors: read::connectors(reader, element),
        line: Line(element.line),
    }
}

/// Reads an SSB into a dictionary as far as possible.
pub(super) fn load(
    bytes: &[u8],
    file: &str,
    limits: &XmlLimits,
    problems: &mut Vec<Problem>,
    into: &mut SignalDictionary,
) {
    let mut reader = Reader { file: file.to_owned(), format: Format::Dictionary, problems };
    if let Some(root) = reader.root(bytes, limits) {
        fill(&mut reader, &root, into);
    }
}

fn fill(reader: &mut Reader<'_>, list: &xml::Element, into: &mut SignalDictionary) {
    reader.only(list, &["DictionaryEntry", "Enumerations", "Units"], &["Annotations"]);
    reader.version(list);
    into.units = values::units(reader, list);
    let mut signals: Vec<Connector> = Vec::new();
    for entry in children(list, "DictionaryEntry") {
        let signal = Connector {
            name: reader.required(entry, "name"),
            kind: Kind::Inout,
            data_type: read::stated_type(reader, entry, "signal"),
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

/// `<ssd:SignalDictionary>`, with the list inside where it is inline.
pub(super) fn written(dictionary: &SignalDictionary) -> xml::Element {
    let inline = matches!(dictionary.source, Source::Inline).then(|| content(dictionary));
    write::sourced(write::element("ssd:SignalDictionary"), &dictionary.source)
        .with("name", &dictionary.name)
        .holding_all(inline.into_iter())
}

/// `<ssd:SignalDictionaryReference>`.
pub(super) fn written_reference(reference: &DictionaryReference) -> xml::Element {
    write::element("ssd:SignalDictionaryReference")
        .with("name", &reference.name)
        .with("dictionary", &reference.dictionary)
        .list("ssd:Connectors", reference.connectors.iter().map(write::connector))
}

fn content(dictionary: &SignalDictionary) -> xml::Element {
    let entries = dictionary.signals.iter().flatten().map(|signal| {
        write::element("ssb:DictionaryEntry")
            .with("name", &signal.name)
            .holding_all(write::stated_type(signal).into_iter())
    });
    write::element("ssb:SignalDictionary")
        .with("version", "1.0")
        .holding_all(entries)
        .list("ssb:Units", dictionary.units.iter().map(write::unit))
}
