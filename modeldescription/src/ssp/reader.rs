//! Reads attributes and children of an SSP's elements, and collects problems.

use std::str::FromStr;

use super::problem::{Format, no_xml, problem};
use crate::problem::Problem;
use crate::variable::DataType;
use crate::xml::{self, Element, XmlLimits};

/// A file of an SSP that is being read.
pub(super) struct Reader<'p> {
    pub(super) file: String,
    pub(super) format: Format,
    pub(super) problems: &'p mut Vec<Problem>,
}

/// The name without its namespace prefix.
pub(super) fn local(name: &str) -> &str {
    name.rsplit_once(':').map_or(name, |(_, local)| local)
}

/// The children of this local name.
pub(super) fn children<'e>(
    element: &'e Element,
    name: &'static str,
) -> impl Iterator<Item = &'e Element> {
    element.children.iter().filter(move |child| local(&child.name) == name)
}

/// The first child of this local name.
pub(super) fn child<'e>(element: &'e Element, name: &'static str) -> Option<&'e Element> {
    children(element, name).next()
}

/// The items of a list element, if it is there.
pub(super) fn listed<'e>(
    element: &'e Element,
    list: &'static str,
    item: &'static str,
) -> impl Iterator<Item = &'e Element> {
    child(element, list).into_iter().flat_map(move |list| children(list, item))
}

/// `Real` and `Integer` of 1.0, and the types of 2.0, which are those of FMI 3.0.
pub(super) fn connector_type(name: &str) -> Option<DataType> {
    match name {
        "Real" => Some(DataType::Float64),
        "Integer" => Some(DataType::Int32),
        "Clock" => None,
        other => DataType::from_name(other),
    }
}

impl Reader<'_> {
    /// The root element of a file of this format, in its namespace and of version 1.x or 2.x.
    pub(super) fn root(&mut self, bytes: &[u8], limits: &XmlLimits) -> Option<Element> {
        let document = match xml::parse(bytes, limits) {
            Ok(document) => document,
            Err(error) => {
                self.problems.push(no_xml(self.format, &self.file, &error));
                return None;
            }
        };
        let root = document.root;
        if local(&root.name) != self.format.root() {
            let found = format!("the root element is <{}>", root.name);
            let rule = format!("it must be <{}>", self.format.root());
            self.report(root.line, found, rule, "give the file that the SSD means");
            return None;
        }
        self.namespace(&root);
        Some(root)
    }

    fn namespace(&mut self, root: &Element) {
        let attribute = match root.name.split_once(':') {
            Some((prefix, _)) => format!("xmlns:{prefix}"),
            None => "xmlns".to_owned(),
        };
        let wanted = self.format.namespace();
        let found = root.attribute(&attribute).unwrap_or_default().to_owned();
        if found != wanted {
            let found = format!("<{}> is of the namespace \"{found}\"", root.name);
            let rule = format!("it must be {wanted}, in version 2.0 too");
            self.report(root.line, found, rule, format!("write {attribute}=\"{wanted}\""));
        }
    }

    /// `version`, which must be one that is understood.
    pub(super) fn version(&mut self, element: &Element) -> String {
        let version = self.required(element, "version");
        if !version.is_empty() && !version.starts_with("1.") && !version.starts_with("2.") {
            let found = format!("<{}> has version=\"{version}\"", element.name);
            self.report(
                element.line,
                found,
                "versions 1.x and 2.x are read",
                "write version=\"1.0\"",
            );
        }
        version
    }

    pub(super) fn report(
        &mut self,
        line: u32,
        found: impl Into<String>,
        rule: impl Into<String>,
        way_out: impl Into<String>,
    ) {
        let problem = problem(self.format, &self.file, line, found.into());
        self.problems.push(problem.rule(rule).way_out(way_out));
    }

    /// An attribute that must be there; empty where it is not.
    pub(super) fn required(&mut self, element: &Element, name: &str) -> String {
        match element.attribute(name) {
            Some(value) => value.to_owned(),
            None => {
                let found = format!("<{}> has no attribute {name}", element.name);
                self.report(
                    element.line,
                    found,
                    "the attribute is required",
                    format!("add {name}=\"…\""),
                );
                String::new()
            }
        }
    }

    /// An attribute that may be left out, or be there and say nothing, as some tools write it.
    pub(super) fn stated<'e>(&self, element: &'e Element, name: &str) -> Option<&'e str> {
        element.attribute(name).filter(|value| !value.trim().is_empty())
    }

    /// An attribute of a type that is parsed, where it says something.
    pub(super) fn optional<T>(
        &mut self,
        element: &Element,
        name: &str,
        rule: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Option<T> {
        self.stated(element, name)?;
        self.parsed(element, name, rule, parse)
    }

    /// An attribute of a type that is parsed; `rule` says what it takes.
    pub(super) fn parsed<T>(
        &mut self,
        element: &Element,
        name: &str,
        rule: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Option<T> {
        let text = element.attribute(name)?;
        let value = parse(text.trim());
        if value.is_none() {
            let shown: String = text.chars().take(80).collect();
            let found = format!("<{}> has {name}=\"{shown}\"", element.name);
            self.report(element.line, found, format!("it must be {rule}"), "correct the value");
        }
        value
    }

    /// A number (`xs:double`).
    pub(super) fn float(&mut self, element: &Element, name: &str) -> Option<f64> {
        self.optional(element, name, "a number such as 1.5e-6", float)
    }

    /// A finite number, or its default.
    pub(super) fn finite(&mut self, element: &Element, name: &str, default: f64) -> f64 {
        let finite = |text: &str| float(text).filter(|value| value.is_finite());
        self.optional(element, name, "a finite number such as 1.5e-6", finite).unwrap_or(default)
    }

    pub(super) fn flag(&mut self, element: &Element, name: &str) -> bool {
        self.optional(element, name, "true or false", boolean).unwrap_or(false)
    }

    /// Children that the format does not know, or that this reader cannot honour.
    pub(super) fn only(&mut self, element: &Element, known: &[&str], ignored: &[&str]) {
        for child in &element.children {
            let name = local(&child.name);
            if known.contains(&name) || ignored.contains(&name) {
                continue;
            }
            let found = format!("<{}> stands in <{}>", child.name, element.name);
            let rule = format!("understood here are: {}", known.join(", "));
            self.report(child.line, found, rule, "remove the element or correct its name");
        }
    }
}

pub(super) fn float(text: &str) -> Option<f64> {
    match text {
        "INF" | "+INF" => Some(f64::INFINITY),
        "-INF" => Some(f64::NEG_INFINITY),
        "NaN" => Some(f64::NAN),
        _ => f64::from_str(text).ok().filter(|value| value.is_finite()),
    }
}

pub(super) fn boolean(text: &str) -> Option<bool> {
    match text {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}
