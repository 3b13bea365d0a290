//! Names of variables: unique, and of the declared convention.

use std::collections::HashMap;

use super::Checker;
use crate::description::{Line, NamingConvention};
use crate::problem::Topic;

pub(super) fn check(checker: &mut Checker<'_>) {
    let description = checker.description;
    let mut first: HashMap<&str, Line> = HashMap::new();
    for variable in &description.variables {
        let aliases = variable.aliases.iter().map(|alias| alias.name.as_str());
        for name in std::iter::once(variable.name.as_str()).chain(aliases) {
            one(checker, name, variable.line);
            if let Some(line) = first.get(name) {
                checker.error(
                    Topic::Variables,
                    variable.line,
                    format!("variable \"{name}\" is there twice, first at line {}", line.0),
                    "names must be unique",
                    "rename one",
                );
            } else {
                first.insert(name, variable.line);
            }
        }
    }
}

fn one(checker: &mut Checker<'_>, name: &str, line: Line) {
    if name.is_empty() {
        let found = "a variable has an empty name".to_owned();
        checker.error(Topic::Names, line, found, "names must not be empty", "name it");
        return;
    }
    let shown = name.escape_debug();
    match checker.description.variable_naming_convention {
        NamingConvention::Flat if name.contains(['\r', '\n', '\t']) => checker.error(
            Topic::Names,
            line,
            format!("variable \"{shown}\""),
            "a name must not hold a carriage return, line feed or tab",
            "remove it",
        ),
        NamingConvention::Flat => {}
        NamingConvention::Structured => {
            if let Err(fault) = structured(name) {
                checker.error(
                    Topic::Names,
                    line,
                    format!("variable \"{shown}\": {fault}"),
                    "structured names look like a.b[1].'any text' or der(x)",
                    "rename it, put odd parts in apostrophes, or declare the flat convention",
                );
            }
        }
    }
}

/// Parses a name of the structured convention; tells what is wrong where.
///
/// The grammar is that of 2.2.9 (2.0.5) and 2.4.7.5.1 (3.0.2).
pub(super) fn structured(name: &str) -> Result<(), String> {
    let mut rest = Rest { text: name, length: name.len() };
    if let Some(inner) = name.strip_prefix("der(") {
        rest.text = inner;
        rest.identifier()?;
        if rest.take(',') {
            rest.unsigned_integer()?;
        }
        rest.expect(')')?;
    } else {
        rest.identifier()?;
    }
    match rest.text.chars().next() {
        None => Ok(()),
        Some(character) => Err(rest.fault(&format!("'{character}' is not expected here"))),
    }
}

/// What is left of a name.
struct Rest<'a> {
    text: &'a str,
    length: usize,
}

impl Rest<'_> {
    fn fault(&self, what: &str) -> String {
        format!("{what} (character {})", self.length - self.text.len() + 1)
    }

    fn take(&mut self, character: char) -> bool {
        match self.text.strip_prefix(character) {
            Some(rest) => {
                self.text = rest;
                true
            }
            None => false,
        }
    }

    fn expect(&mut self, character: char) -> Result<(), String> {
        match self.take(character) {
            true => Ok(()),
            false => Err(self.fault(&format!("'{character}' is missing"))),
        }
    }

    /// `B-name [arrayIndices] { "." B-name [arrayIndices] }`
    fn identifier(&mut self) -> Result<(), String> {
        loop {
            self.part()?;
            if self.take('[') {
                self.indices()?;
            }
            if !self.take('.') {
                return Ok(());
            }
        }
    }

    /// `nondigit { digit | nondigit } | Q-name`
    fn part(&mut self) -> Result<(), String> {
        if self.take('\'') {
            return self.quoted();
        }
        let is_letter = |c: char| c.is_ascii_alphabetic() || c == '_';
        if !self.text.starts_with(is_letter) {
            return Err(self.fault("a letter, '_' or an apostrophe is expected here"));
        }
        self.text = self.text.trim_start_matches(|c: char| is_letter(c) || c.is_ascii_digit());
        Ok(())
    }

    /// The rest of a name in apostrophes.
    fn quoted(&mut self) -> Result<(), String> {
        let mut is_empty = true;
        loop {
            let mut characters = self.text.chars();
            match characters.next() {
                None => return Err(self.fault("the closing apostrophe is missing")),
                Some('\'') if is_empty => return Err(self.fault("nothing is in the apostrophes")),
                Some('\'') => {
                    self.text = characters.as_str();
                    return Ok(());
                }
                Some('\\') => match characters.next() {
                    Some('\'' | '"' | '?' | '\\' | 'a' | 'b' | 'f' | 'n' | 'r' | 't' | 'v') => {}
                    _ => return Err(self.fault("this is no escape sequence")),
                },
                Some(c) if is_quotable(c) => {}
                Some(c) => {
                    return Err(self.fault(&format!("'{c}' is not allowed in apostrophes")));
                }
            }
            self.text = characters.as_str();
            is_empty = false;
        }
    }

    /// `unsignedInteger { "," unsignedInteger } "]"`
    fn indices(&mut self) -> Result<(), String> {
        loop {
            self.unsigned_integer()?;
            if !self.take(',') {
                return self.expect(']');
            }
        }
    }

    fn unsigned_integer(&mut self) -> Result<(), String> {
        if !self.text.starts_with(|c: char| c.is_ascii_digit()) {
            return Err(self.fault("a digit is expected here"));
        }
        self.text = self.text.trim_start_matches(|c: char| c.is_ascii_digit());
        Ok(())
    }
}

fn is_quotable(character: char) -> bool {
    character.is_ascii_alphanumeric() || "_!#$%&()*+,-./:;<>=?@[]^{}|~ ".contains(character)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_standard() {
        for name in [
            "vehicle.engine.speed",
            "resistor12.u",
            "v_min",
            "robot.axis.'motor #234'",
            "der(pipe[3,4].T[14],2)",
            "der(x)",
            "a[0].b",
            "_",
            "derivative",
            "der",
            "'it\\'s'.x",
        ] {
            assert_eq!(structured(name), Ok(()), "{name}");
        }
    }

    #[test]
    fn illegal_names() {
        for (name, position) in [
            ("1a", 1),
            ("a..b", 3),
            ("a.", 3),
            ("a[]", 3),
            ("a[1", 4),
            ("a[-1]", 3),
            ("a[1]b", 5),
            ("a b", 2),
            ("ü", 1),
            ("a-b", 2),
            ("''", 2),
            ("'a", 3),
            ("'a\\x'", 3),
            ("'µ'", 2),
            ("der(x", 6),
            ("der(x,)", 7),
            ("der(der(x))", 8),
            ("[1]", 1),
        ] {
            let fault = structured(name).unwrap_err();
            assert!(fault.ends_with(&format!("(character {position})")), "{name}: {fault}");
        }
    }
}
