//! The values of a TOML text with their lines, and notes of what is wrong in them.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::Value;
use super::origin::{Origin, Place};
use crate::toml_text::{self, Lines, shown};
use crate::{Problem, Problems};

pub(super) type Spot<'a, 'i> = &'a Spanned<DeValue<'i>>;

/// Reads tables of a text and notes what is wrong in them.
pub(super) struct Reader {
    lines: Lines,
    pub(super) origin: Origin,
}

impl Reader {
    pub(super) fn new(text: &str, origin: &str) -> Self {
        let origin = Origin { file: origin.into(), ..Origin::default() };
        Self { lines: Lines::new(text), origin }
    }

    /// Everything that was noted; `None` where nothing was.
    pub(super) fn problems(self) -> Option<Problems> {
        let all: Vec<_> = self.origin.problems.into_iter().map(|(_, problem)| problem).collect();
        (!all.is_empty()).then(|| Problems::new(all))
    }

    /// Notes that a component took values of this record.
    pub(super) fn took_record(&mut self, name: &str) {
        if !self.origin.records.iter().any(|known| known == name) {
            self.origin.records.push(name.into());
        }
    }

    pub(super) fn note(
        &mut self,
        place: &Place,
        value: &str,
        rule: impl Into<String>,
        way_out: &str,
    ) {
        let mut problem =
            Problem::new(&self.origin.file, rule, way_out).at(&place.shown).value(value);
        problem.line = self.origin.line(&place.key);
        self.origin.problems.push((place.key.clone(), problem));
    }

    /// The items of a table in the order of the file, their lines noted.
    pub(super) fn items<'a, 'i>(
        &mut self,
        table: &'a DeTable<'i>,
        place: &Place,
    ) -> Vec<(&'a str, Spot<'a, 'i>, Place)> {
        let mut items: Vec<_> = table.iter().collect();
        items.sort_by_key(|(key, _)| key.span().start);
        items
            .into_iter()
            .map(|(key, value)| {
                let place = place.child(key.get_ref());
                let line = self.lines.at(key.span().start);
                self.origin.lines.insert(place.key.clone(), line);
                (key.get_ref().as_ref(), value, place)
            })
            .collect()
    }

    pub(super) fn text(&mut self, value: Spot<'_, '_>, place: &Place) -> String {
        if let Some(text) = value.get_ref().as_str() {
            return text.to_string();
        }
        let shown = shown(value.get_ref());
        self.note(place, &shown, "must be a text", "put it in quotation marks");
        String::new()
    }

    /// A text that must not be empty where it is given.
    pub(super) fn name(&mut self, value: Spot<'_, '_>, place: &Place) -> String {
        let text = self.text(value, place);
        if text.is_empty() && !self.origin.is_spoilt(&place.key) {
            self.note(place, "\"\"", "is empty", "give a text or leave the key out");
        }
        text
    }

    pub(super) fn value(&mut self, value: Spot<'_, '_>, place: &Place) -> Option<Value> {
        let number = match value.get_ref() {
            DeValue::String(text) => return Some(Value::Text(text.to_string())),
            DeValue::Array(items) => return Some(self.list(items, place)),
            other => toml_text::number(other),
        };
        if number.is_none() {
            let shown = shown(value.get_ref());
            let way_out = "write a number, or a text with a unit as in \"2.1 kHz\"";
            let rule = "must be a number, a text with a unit or a list of them";
            self.note(place, &shown, rule, way_out);
        }
        number.map(Value::Number)
    }

    fn list<'i>(&mut self, items: &[Spanned<DeValue<'i>>], place: &Place) -> Value {
        let mut values = Vec::with_capacity(items.len());
        for (item, number) in items.iter().zip(1..) {
            let place = place.item(number);
            self.origin.lines.insert(place.key.clone(), self.lines.at(item.span().start));
            // A spoilt item keeps its seat, so that the length of the list stays right.
            values.push(self.value(item, &place).unwrap_or(Value::Number(0.0)));
        }
        Value::List(values)
    }

    /// The sections of a list, each read by `section`.
    pub(super) fn sections<T>(
        &mut self,
        value: Spot<'_, '_>,
        place: &Place,
        header: &str,
        section: impl Fn(&mut Self, &DeTable<'_>, &Place) -> T,
    ) -> Vec<T> {
        let way_out = format!("write the header {header} with two brackets on each side");
        let Some(items) = value.get_ref().as_array() else {
            self.note(place, "", "must be a list of sections", &way_out);
            return Vec::new();
        };
        let mut sections = Vec::new();
        for (item, number) in items.iter().zip(1..) {
            let place = place.item(number);
            self.origin.lines.insert(place.key.clone(), self.lines.at(item.span().start));
            match item.get_ref().as_table() {
                Some(table) => sections.push(section(self, table, &place)),
                None => self.note(&place, &shown(item.get_ref()), "must be a section", &way_out),
            }
        }
        sections
    }
}
