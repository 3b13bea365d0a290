//! Records: the values of one specimen with their sources, apart from the components.
//!
//! ```toml
//! piezoloop_record = 1                # format of this file
//! name = "p-752-21c"
//! description = "PI P-752.21C nanopositioning stage, 35 um"
//!
//! [mode]                              # the type of a component
//! frequency = { value = "2.1 kHz", source = "data sheet" }
//! ```
//!
//! A component of a blueprint takes the values of its type by `record = "p-752-21c"`, or by
//! `record = "my-stage.toml"` from a file beside the blueprint. Its own keys go before the record's.

use std::path::Path;

use toml::Spanned;
use toml::de::DeValue;

use super::origin::Place;
use super::reader::Reader;
use super::{ComponentBlueprint, Value};
use crate::nearest::did_you_mean;
use crate::toml_text::{self, shown};
use crate::{Problem, Problems};

/// Number of the file format, the value of the key `piezoloop_record`.
const FORMAT: f64 = 1.0;

/// The values of one specimen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterRecord {
    /// Name, as blueprints write it.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// For each type of component, its values.
    pub components: Vec<(String, Vec<RecordValue>)>,
}

/// One value of a [`ParameterRecord`].
#[derive(Clone, Debug, PartialEq)]
pub struct RecordValue {
    /// Name of the parameter or structural setting.
    pub name: String,
    /// The value, with a unit where it has one.
    pub value: Value,
    /// Where it comes from.
    pub source: String,
}

impl ParameterRecord {
    /// Reads a record's text; `origin` is what messages call it, the file's name as a rule.
    ///
    /// # Errors
    /// Every [`Problem`]: no TOML, another format, a missing name, a value without a source. Whether
    /// the values fit their component is reported by the check of a blueprint that takes them.
    pub fn parse(text: &str, origin: &str) -> Result<Self, Problems> {
        let document = toml_text::parse(text, origin)?;
        let mut reader = Reader::new(text, origin);
        let mut record = Self::default();
        let mut has_format = false;
        for (key, value, place) in reader.items(document.get_ref(), &Place::new("")) {
            match key {
                "piezoloop_record" => {
                    has_format = true;
                    if toml_text::number(value.get_ref()) != Some(FORMAT) {
                        let shown = shown(value.get_ref());
                        let rule = "is a format of records that this program does not know";
                        reader.note(&place, &shown, rule, "use a newer program, or write 1");
                    }
                }
                "name" => record.name = reader.name(value, &place),
                "description" => record.description = reader.text(value, &place),
                kind => record.components.push((kind.into(), values(&mut reader, value, &place))),
            }
        }
        if !has_format {
            let rule = "is missing, so the file is no record";
            reader.note(&Place::new("piezoloop_record"), "", rule, "write piezoloop_record = 1");
        }
        if record.name.is_empty() {
            reader.note(&Place::new("name"), "", "is missing", "name the specimen");
        }
        reader.problems().map_or(Ok(record), Err)
    }

    /// The values for a type of component.
    #[must_use]
    pub fn values(&self, kind: &str) -> Option<&[RecordValue]> {
        let found = self.components.iter().find(|(known, _)| known == kind);
        found.map(|(_, values)| values.as_slice())
    }
}

/// The values of one section.
fn values(reader: &mut Reader, section: &Spanned<DeValue<'_>>, place: &Place) -> Vec<RecordValue> {
    let way_out = "write a section with the type of a component, as in [mode]";
    let Some(table) = section.get_ref().as_table() else {
        reader.note(place, &shown(section.get_ref()), "is no key of a record", way_out);
        return Vec::new();
    };
    let mut values = Vec::new();
    for (name, entry, place) in reader.items(table, place) {
        let way_out = "write for example { value = \"2.1 kHz\", source = \"data sheet\" }";
        let Some(entry) = entry.get_ref().as_table() else {
            reader.note(&place, &shown(entry.get_ref()), "must have a value and a source", way_out);
            continue;
        };
        let (mut value, mut source) = (None, String::new());
        for (key, item, place) in reader.items(entry, &place) {
            match key {
                "value" => value = reader.value(item, &place),
                "source" => source = reader.text(item, &place),
                _ => reader.note(&place, "", "is no key of a record's value", way_out),
            }
        }
        match value {
            Some(value) if !source.is_empty() => {
                values.push(RecordValue { name: name.to_string(), value, source });
            }
            Some(_) => reader.note(&place, "", "has no source", way_out),
            None => reader.note(&place, "", "has no value", way_out),
        }
    }
    values
}

/// A record by name, or from a file beside the blueprint `origin`.
pub(super) fn find(name: &str, origin: &str) -> Result<ParameterRecord, Problems> {
    if Path::new(name).extension().is_some_and(|ending| ending == "toml") {
        let folder = Path::new(origin).parent().unwrap_or(Path::new(""));
        let path = folder.join(name);
        let shown = path.display().to_string();
        let text = files::read_text(&path).map_err(|error| {
            let rule = format!("cannot be read: {error}");
            Problem::new(&shown, rule, "give the record's path from the blueprint's folder")
        })?;
        return ParameterRecord::parse(&text, &shown);
    }
    let known = || rigs::RECORDS.iter().map(|record| record.name);
    let Some(record) = rigs::record(name) else {
        let near = did_you_mean(name, known());
        let all: Vec<_> = known().collect();
        let way_out = format!(
            "{near}known are {}, or the name of a file that ends with .toml",
            all.join(", ")
        );
        return Err(Problem::new("", "is no record", way_out).into());
    };
    ParameterRecord::parse(record.text, record.name)
}

/// Gives a component the values of a record that it does not have itself.
pub(super) fn fill(
    reader: &mut Reader,
    component: &mut ComponentBlueprint,
    name: &str,
    place: &Place,
) {
    let record = match find(name, &reader.origin.file) {
        Ok(record) => record,
        Err(problems) => {
            for problem in problems.as_slice() {
                if problem.file.is_empty() {
                    reader.note(place, name, problem.rule.clone(), &problem.way_out);
                } else {
                    let rule = format!("cannot be taken: {problem}");
                    reader.note(place, name, rule, "correct the record");
                }
            }
            return;
        }
    };
    let Some(values) = record.values(&component.kind) else {
        let all: Vec<_> = record.components.iter().map(|(kind, _)| kind.as_str()).collect();
        let rule = format!("has no values for {}", component.kind);
        let way_out = format!("it has those of {}; leave the key out", all.join(", "));
        reader.note(place, name, rule, &way_out);
        return;
    };
    let mut taken = Vec::new();
    for value in values {
        if component.get(&value.name).is_none() {
            taken.push(format!("{} ({})", value.name, value.source));
            component.values.push((value.name.clone(), value.value.clone()));
        }
    }
    let described = format!("record {}: {}", record.name, taken.join(", "));
    let parts = [component.note.as_str(), &described];
    component.note = parts.into_iter().filter(|p| !p.is_empty()).collect::<Vec<_>>().join("; ");
    reader.took_record(name);
}
