//! Reads the attributes of an element: text to value, with a problem for everything that deviates.

use std::fmt::Display;
use std::str::FromStr;

use crate::description::FmiVersion;
use crate::problem::{Problem, Topic};
use crate::xml::Element;

/// Collects the problems of a document while it is read.
pub(super) struct Context {
    pub(super) version: FmiVersion,
    pub(super) problems: Vec<Problem>,
}

/// An element whose attributes are being read, and the topic its rules belong to.
#[derive(Clone, Copy)]
pub(super) struct Attributes<'a> {
    pub(super) element: &'a Element,
    pub(super) topic: Topic,
}

impl Context {
    pub(super) fn report(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    fn problem(&self, at: Attributes<'_>, found: String) -> Problem {
        Problem::in_xml(self.version, at.topic, at.element.line, found)
    }

    /// Reports attributes the schema does not know, and children it does not know, that stand in
    /// the wrong order or too often. In `children`, `*` marks those that may repeat.
    pub(super) fn expect(&mut self, at: Attributes<'_>, attributes: &[&str], children: &[&str]) {
        let name = &at.element.name;
        for (attribute, value) in &at.element.attributes {
            let foreign = attribute.contains(':') || attribute == "xmlns";
            if foreign || attributes.contains(&attribute.as_str()) {
                continue;
            }
            let found = format!("<{name}> has the attribute {attribute}=\"{value}\"");
            let problem = self
                .problem(at, found)
                .rule(format!("the schema allows here: {}", attributes.join(", ")))
                .way_out("remove the attribute, or correct its name");
            self.report(problem);
        }
        self.expect_children(at, children);
    }

    fn expect_children(&mut self, at: Attributes<'_>, allowed: &[&str]) {
        let mut reached = 0;
        let mut previous: Option<&str> = None;
        for child in &at.element.children {
            let position = allowed.iter().position(|name| name.trim_end_matches('*') == child.name);
            let repeats =
                position.is_some_and(|p| allowed.get(p).is_some_and(|a| a.ends_with('*')));
            let rule = match position {
                None if allowed.is_empty() => "the schema allows no element here".to_owned(),
                None => format!("the schema allows here: {}", plain(allowed)),
                Some(p) if p < reached => format!("the schema's order is: {}", plain(allowed)),
                Some(_) if !repeats && previous == Some(child.name.as_str()) => {
                    "the schema allows this element once".to_owned()
                }
                Some(p) => {
                    reached = p;
                    previous = Some(&child.name);
                    continue;
                }
            };
            let found = format!("<{}> stands in <{}>", child.name, at.element.name);
            let problem = self
                .problem(Attributes { element: child, topic: at.topic }, found)
                .rule(rule)
                .way_out("move, rename or remove the element");
            self.report(problem);
        }
    }

    /// Reports a list element that has no child.
    pub(super) fn expect_some(&mut self, at: Attributes<'_>) {
        if at.element.children.is_empty() {
            let problem = self
                .problem(at, format!("<{}> is empty", at.element.name))
                .rule("a list that is present must have at least one element")
                .way_out("remove the empty list");
            self.report(problem);
        }
    }

    pub(super) fn text(&self, at: Attributes<'_>, name: &str) -> Option<String> {
        at.element.attribute(name).map(str::to_owned)
    }

    pub(super) fn required_text(&mut self, at: Attributes<'_>, name: &str) -> String {
        match at.element.attribute(name) {
            Some(value) => value.to_owned(),
            None => {
                self.missing(at, name);
                String::new()
            }
        }
    }

    fn missing(&mut self, at: Attributes<'_>, name: &str) {
        let problem = self
            .problem(at, format!("<{}> has no attribute {name}", at.element.name))
            .rule("the attribute is required")
            .way_out(format!("add {name}=\"…\""))
            .unreadable();
        self.report(problem);
    }

    fn unreadable(&mut self, at: Attributes<'_>, name: &str, value: &str, rule: impl Display) {
        let mut shown: String = value.chars().take(80).collect();
        if shown.len() < value.len() {
            shown.push('…');
        }
        let element = describe(at.element);
        let problem = self
            .problem(at, format!("{element} has {name}=\"{shown}\""))
            .rule(format!("the value must be {rule}"))
            .way_out("correct the value")
            .unreadable();
        self.report(problem);
    }

    pub(super) fn boolean(&mut self, at: Attributes<'_>, name: &str) -> Option<bool> {
        let value = at.element.attribute(name)?;
        let parsed = parse_boolean(value);
        if parsed.is_none() {
            self.unreadable(at, name, value, "true, false, 1 or 0");
        }
        parsed
    }

    pub(super) fn flag(&mut self, at: Attributes<'_>, name: &str) -> bool {
        self.boolean(at, name).unwrap_or(false)
    }

    pub(super) fn float(&mut self, at: Attributes<'_>, name: &str) -> Option<f64> {
        let value = at.element.attribute(name)?;
        let parsed = parse_float(value);
        if parsed.is_none() {
            self.unreadable(at, name, value, "a number such as 1.5e-6");
        }
        parsed
    }

    /// An integer of the type's range.
    pub(super) fn integer<T: FromStr>(&mut self, at: Attributes<'_>, name: &str) -> Option<T> {
        let value = at.element.attribute(name)?;
        let parsed = parse_integer(value);
        if parsed.is_none() {
            let bits = 8 * std::mem::size_of::<T>();
            self.unreadable(at, name, value, format_args!("an integer of at most {bits} bits"));
        }
        parsed
    }

    pub(super) fn required_integer<T: FromStr + Default>(
        &mut self,
        at: Attributes<'_>,
        name: &str,
    ) -> T {
        if at.element.attribute(name).is_none() {
            self.missing(at, name);
        }
        self.integer(at, name).unwrap_or_default()
    }

    /// An integer inside `range`, both ends included.
    pub(super) fn ranged(
        &mut self,
        at: Attributes<'_>,
        name: &str,
        range: (i128, i128),
    ) -> Option<i128> {
        let value = at.element.attribute(name)?;
        let parsed = parse_ranged(value, range);
        if parsed.is_none() {
            let (low, high) = range;
            self.unreadable(at, name, value, format_args!("an integer from {low} to {high}"));
        }
        parsed
    }

    /// One of the names of an enumeration.
    pub(super) fn named<T: Copy + Display>(
        &mut self,
        at: Attributes<'_>,
        name: &str,
        values: &[T],
        from_name: impl Fn(&str) -> Option<T>,
    ) -> Option<T> {
        let value = at.element.attribute(name)?;
        let parsed = from_name(value.trim()).filter(|v| values.iter().any(|w| same(*v, *w)));
        if parsed.is_none() {
            let names: Vec<String> = values.iter().map(T::to_string).collect();
            self.unreadable(at, name, value, format_args!("one of {}", names.join(", ")));
        }
        parsed
    }

    /// A list separated by white space.
    pub(super) fn list<T>(
        &mut self,
        at: Attributes<'_>,
        name: &str,
        rule: impl Display,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Option<Vec<T>> {
        let value = at.element.attribute(name)?;
        let parsed: Option<Vec<T>> = value.split_whitespace().map(parse).collect();
        if parsed.is_none() {
            self.unreadable(at, name, value, format_args!("a list of {rule}"));
        }
        parsed
    }
}

fn same<T: Display>(a: T, b: T) -> bool {
    a.to_string() == b.to_string()
}

fn plain(names: &[&str]) -> String {
    names.iter().map(|name| name.trim_end_matches('*')).collect::<Vec<_>>().join(", ")
}

/// `<Real>` or `<Unit name="um">`.
fn describe(element: &Element) -> String {
    match element.attribute("name") {
        Some(name) => format!("<{} name=\"{name}\">", element.name),
        None => format!("<{}>", element.name),
    }
}

pub(super) fn parse_boolean(text: &str) -> Option<bool> {
    match text.trim() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// `xs:double`: digits with a point and an exponent, `INF`, `-INF` or `NaN`.
pub(super) fn parse_float(text: &str) -> Option<f64> {
    let text = text.trim();
    match text {
        "INF" | "+INF" => Some(f64::INFINITY),
        "-INF" => Some(f64::NEG_INFINITY),
        "NaN" => Some(f64::NAN),
        // Rust reads `inf` and `infinity` too, the schema does not.
        _ if text.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b)) => text.parse().ok(),
        _ => None,
    }
}

pub(super) fn parse_integer<T: FromStr>(text: &str) -> Option<T> {
    text.trim().parse().ok()
}

pub(super) fn parse_ranged(text: &str, (low, high): (i128, i128)) -> Option<i128> {
    parse_integer(text).filter(|value| (low..=high).contains(value))
}

/// `xs:hexBinary`.
pub(super) fn parse_hex(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim().as_bytes();
    if !digits.len().is_multiple_of(2) {
        return None;
    }
    let nibble = |digit: u8| char::from(digit).to_digit(16);
    digits
        .chunks_exact(2)
        .map(|pair| match pair {
            [high, low] => u8::try_from(nibble(*high)? * 16 + nibble(*low)?).ok(),
            _ => None,
        })
        .collect()
}
