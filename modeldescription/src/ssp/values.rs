//! Reads SSV, SSM, and what they share with an SSD: units, enumerations, transformations.

use super::problem::Format;
use super::reader::{Reader, boolean, child, children, connector_type, float, listed, local};
use super::structure::*;
use crate::description::{BaseUnit, Line, Unit};
use crate::problem::Problem;
use crate::variable::DataType;
use crate::xml::{self, XmlLimits};

impl ParameterSet {
    /// Reads an SSV. `file` is its name in messages.
    ///
    /// # Errors
    /// Everything that cannot be understood, with file and line.
    pub fn parse(bytes: &[u8], file: &str) -> Result<Self, Vec<Problem>> {
        let mut problems = Vec::new();
        let set = read_set(bytes, file, &XmlLimits::default(), &mut problems);
        set.filter(|_| problems.is_empty()).ok_or(problems)
    }
}

impl ParameterMapping {
    /// Reads an SSM. `file` is its name in messages.
    ///
    /// # Errors
    /// Everything that cannot be understood, with file and line.
    pub fn parse(bytes: &[u8], file: &str) -> Result<Self, Vec<Problem>> {
        let mut problems = Vec::new();
        let mapping = read_mapping(bytes, file, &XmlLimits::default(), &mut problems);
        mapping.filter(|_| problems.is_empty()).ok_or(problems)
    }
}

/// Reads an SSV as far as possible.
pub(super) fn read_set(
    bytes: &[u8],
    file: &str,
    limits: &XmlLimits,
    problems: &mut Vec<Problem>,
) -> Option<ParameterSet> {
    let mut reader = Reader { file: file.to_owned(), format: Format::Values, problems };
    let root = reader.root(bytes, limits)?;
    Some(parameter_set(&mut reader, &root))
}

/// Reads an SSM as far as possible.
pub(super) fn read_mapping(
    bytes: &[u8],
    file: &str,
    limits: &XmlLimits,
    problems: &mut Vec<Problem>,
) -> Option<ParameterMapping> {
    let mut reader = Reader { file: file.to_owned(), format: Format::Mapping, problems };
    let root = reader.root(bytes, limits)?;
    Some(parameter_mapping(&mut reader, &root))
}

pub(super) fn parameter_set(reader: &mut Reader<'_>, element: &xml::Element) -> ParameterSet {
    let known = ["Parameters", "Enumerations", "Units"];
    reader.only(element, &known, &["Annotations", "MetaData", "Signature"]);
    let mut parameters: Vec<Parameter> = Vec::new();
    for found in listed(element, "Parameters", "Parameter") {
        let Some(parameter) = parameter(reader, found) else { continue };
        if parameters.iter().any(|other| other.name == parameter.name) {
            let found = format!("parameter \"{}\" stands in the set twice", parameter.name);
            reader.report(parameter.line.0, found, "names are unique", "keep one of them");
        }
        parameters.push(parameter);
    }
    ParameterSet {
        version: reader.version(element),
        name: reader.required(element, "name"),
        parameters,
        units: units(reader, element),
        enumerations: enumerations(reader, element),
    }
}

fn parameter(reader: &mut Reader<'_>, element: &xml::Element) -> Option<Parameter> {
    let name = reader.required(element, "name");
    let known = |child: &&xml::Element| !matches!(local(&child.name), "Annotations" | "Dimension");
    let Some(content) = element.children.iter().find(known) else {
        let found = format!("parameter \"{name}\" has no value");
        let rule = "it holds one of Real, Integer, Boolean, String, Enumeration, Binary";
        reader.report(element.line, found, rule, "add the value");
        return None;
    };
    let value = value(reader, &name, content)?;
    let unit = reader.stated(content, "unit").map(str::to_owned);
    Some(Parameter { name, value, unit, line: Line(element.line) })
}

fn value(reader: &mut Reader<'_>, name: &str, content: &xml::Element) -> Option<ParameterValue> {
    let type_name = local(&content.name);
    let Some(data_type) = connector_type(type_name) else {
        let found = format!("parameter \"{name}\" is of type <{}>", content.name);
        let rule = "types are Real, Integer, Boolean, String, Enumeration, Binary and the numeric \
                    types of FMI 3.0";
        reader.report(content.line, found, rule, "correct the type");
        return None;
    };
    let several: Vec<String> = children(content, "Value")
        .filter_map(|value| value.attribute("value").map(str::to_owned))
        .collect();
    let texts = |reader: &mut Reader<'_>| match several.is_empty() {
        true => vec![reader.required(content, "value")],
        false => several.clone(),
    };
    if content.attribute("value").is_none() && several.is_empty() {
        reader.required(content, "value");
        return None;
    }
    let value = "value";
    Some(match data_type {
        DataType::Float32 | DataType::Float64 => {
            ParameterValue::Real(reader.parsed(content, value, "a number", |t| each(t, float))?)
        }
        DataType::Boolean => {
            let rule = "true or false";
            ParameterValue::Boolean(reader.parsed(content, value, rule, |t| each(t, boolean))?)
        }
        DataType::String => ParameterValue::Text(texts(reader)),
        DataType::Enumeration => {
            let enumeration = content.attribute("name").map(str::to_owned);
            ParameterValue::Enumeration(texts(reader), enumeration)
        }
        DataType::Binary => {
            ParameterValue::Binary(reader.parsed(content, value, "bytes in hexadecimal", hex)?)
        }
        _ => {
            let integer = |text: &str| text.parse::<i64>().ok();
            let rule = "a whole number";
            ParameterValue::Integer(reader.parsed(content, value, rule, |t| each(t, integer))?)
        }
    })
}

/// A list of values separated by white space; scalars are lists of one.
fn each<T>(text: &str, parse: impl Fn(&str) -> Option<T>) -> Option<Vec<T>> {
    let values: Option<Vec<T>> = text.split_whitespace().map(parse).collect();
    values.filter(|values| !values.is_empty())
}

fn hex(text: &str) -> Option<Vec<u8>> {
    if !text.is_ascii() || !text.len().is_multiple_of(2) {
        return None;
    }
    let pairs = text.as_bytes().chunks(2);
    pairs.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()).collect()
}

pub(super) fn parameter_mapping(
    reader: &mut Reader<'_>,
    element: &xml::Element,
) -> ParameterMapping {
    reader.only(element, &["MappingEntry"], &["Annotations", "MetaData", "Signature"]);
    let entry = |reader: &mut Reader<'_>, entry: &xml::Element| MappingEntry {
        source: reader.required(entry, "source"),
        target: reader.required(entry, "target"),
        transformation: transformation(reader, entry),
        suppress_unit_conversion: reader.flag(entry, "suppressUnitConversion"),
        line: Line(entry.line),
    };
    ParameterMapping {
        version: reader.version(element),
        entries: children(element, "MappingEntry").map(|e| entry(reader, e)).collect(),
    }
}

pub(super) fn transformation(
    reader: &mut Reader<'_>,
    element: &xml::Element,
) -> Option<Transformation> {
    let ignored = ["ConnectionGeometry", "Annotations"];
    let found = element.children.iter().find(|c| !ignored.contains(&local(&c.name)))?;
    match local(&found.name) {
        "LinearTransformation" => Some(Transformation::Linear {
            factor: reader.finite(found, "factor", 1.0),
            offset: reader.finite(found, "offset", 0.0),
        }),
        "BooleanMappingTransformation" => {
            Some(Transformation::Boolean(pairs(reader, found, "true or false", boolean)))
        }
        "IntegerMappingTransformation" => {
            let integer = |text: &str| text.parse::<i64>().ok();
            Some(Transformation::Integer(pairs(reader, found, "a whole number", integer)))
        }
        "EnumerationMappingTransformation" => {
            let text = |text: &str| Some(text.to_owned());
            Some(Transformation::Enumeration(pairs(reader, found, "an item", text)))
        }
        _ => {
            let what = format!("<{}> stands in <{}>", found.name, element.name);
            let rule = "a transformation is Linear-, BooleanMapping-, IntegerMapping- or \
                        EnumerationMappingTransformation";
            reader.report(found.line, what, rule, "remove the element");
            None
        }
    }
}

fn pairs<T>(
    reader: &mut Reader<'_>,
    element: &xml::Element,
    rule: &str,
    parse: impl Fn(&str) -> Option<T>,
) -> Vec<(T, T)> {
    let mut pairs = Vec::new();
    for entry in children(element, "MapEntry") {
        reader.required(entry, "source");
        reader.required(entry, "target");
        let source = reader.parsed(entry, "source", rule, &parse);
        let target = reader.parsed(entry, "target", rule, &parse);
        pairs.extend(source.zip(target));
    }
    pairs
}

pub(super) fn units(reader: &mut Reader<'_>, root: &xml::Element) -> Vec<Unit> {
    let mut units: Vec<Unit> = Vec::new();
    for element in listed(root, "Units", "Unit") {
        let name = reader.required(element, "name");
        if units.iter().any(|unit| unit.name == name) {
            let found = format!("unit \"{name}\" is defined twice");
            reader.report(element.line, found, "names are unique", "keep one of them");
        }
        let base = child(element, "BaseUnit").map(|base| base_unit(reader, base));
        units.push(Unit { name, base, display_units: Vec::new(), line: Line(element.line) });
    }
    units
}

fn base_unit(reader: &mut Reader<'_>, element: &xml::Element) -> BaseUnit {
    let mut exponent = |name: &str| {
        reader.parsed(element, name, "a whole number", |t| t.parse::<i32>().ok()).unwrap_or(0)
    };
    let mut unit = BaseUnit {
        kg: exponent("kg"),
        m: exponent("m"),
        s: exponent("s"),
        a: exponent("A"),
        k: exponent("K"),
        mol: exponent("mol"),
        cd: exponent("cd"),
        rad: exponent("rad"),
        ..BaseUnit::default()
    };
    unit.factor = reader.finite(element, "factor", 1.0);
    unit.offset = reader.finite(element, "offset", 0.0);
    if unit.factor == 0.0 {
        let found = "<BaseUnit> has factor=\"0\"";
        reader.report(element.line, found, "a factor is not 0", "correct the factor");
        unit.factor = 1.0;
    }
    unit
}

pub(super) fn enumerations(reader: &mut Reader<'_>, root: &xml::Element) -> Vec<Enumeration> {
    let mut enumerations = Vec::new();
    for element in listed(root, "Enumerations", "Enumeration") {
        let mut items = Vec::new();
        for item in children(element, "Item") {
            let name = reader.required(item, "name");
            reader.required(item, "value");
            let integer = |text: &str| text.parse::<i64>().ok();
            items
                .extend(reader.parsed(item, "value", "a whole number", integer).map(|v| (name, v)));
        }
        let name = reader.required(element, "name");
        enumerations.push(Enumeration { name, items, line: Line(element.line) });
    }
    enumerations
}
