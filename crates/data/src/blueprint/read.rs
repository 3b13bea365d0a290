//! From TOML to a [`Blueprint`].
//!
//! Only a text that is no TOML is refused here. A key that is unknown or has a value of the wrong
//! kind is noted and reported by the check, together with everything else.

use std::collections::BTreeMap;

use toml::de::DeTable;

use super::origin::Place;
use super::reader::{Reader, Spot};
use super::{
    AxisBlueprint, Blueprint, ComponentBlueprint, ConnectionBlueprint, CouplingBlueprint, FORMAT,
    SignalBlueprint, Value, record,
};
use crate::Problems;
use crate::nearest::did_you_mean;
use crate::toml_text::{self, shown};
use model::Kind;

pub(super) fn parse(text: &str, origin: &str) -> Result<Blueprint, Problems> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let document = toml_text::parse(text, origin)?;
    let mut reader = Reader::new(text, origin);
    let (mut blueprint, format) = reader.blueprint(document.get_ref());
    if format.is_some_and(|format| format != FORMAT) {
        // Everything else would be noise: another format has other keys.
        reader.origin.problems.retain(|(key, _)| key == "piezoloop");
        return Err(Problems::new(reader.origin.problems.into_iter().map(|(_, p)| p).collect()));
    }
    blueprint.origin = reader.origin;
    Ok(blueprint)
}

impl Reader {
    fn blueprint(&mut self, table: &DeTable<'_>) -> (Blueprint, Option<f64>) {
        let mut blueprint = Blueprint::new(Kind::Plant, "", f64::NAN);
        let mut seen = Vec::new();
        let mut format = None;
        for (key, value, place) in self.items(table, &Place::new("")) {
            seen.push(key);
            match key {
                "piezoloop" => format = self.format(value, &place),
                "kind" => blueprint.kind = self.kind(value, &place),
                "name" => blueprint.name = self.name(value, &place),
                "description" => blueprint.description = self.text(value, &place),
                "source" => blueprint.source = self.text(value, &place),
                "author" => blueprint.author = self.text(value, &place),
                "version" => blueprint.version = self.text(value, &place),
                "copyright" => blueprint.copyright = self.text(value, &place),
                "license" => blueprint.license = self.text(value, &place),
                "step" => blueprint.step = self.value(value, &place).unwrap_or(blueprint.step),
                "temperature" => blueprint.temperature = self.signal(value, &place),
                "axis" => blueprint.axes = self.sections(value, &place, "[[axis]]", Self::axis),
                "coupling" => {
                    blueprint.couplings =
                        self.sections(value, &place, "[[coupling]]", Self::coupling);
                }
                "connection" => {
                    blueprint.connections =
                        self.sections(value, &place, "[[connection]]", Self::connection);
                }
                _ => self.unknown(key, &place, &KEYS),
            }
        }
        for (key, rule, way_out) in REQUIRED {
            if !seen.contains(&key) {
                self.note(&Place::new(key), "", rule, way_out);
            }
        }
        (blueprint, format)
    }

    fn unknown(&mut self, key: &str, place: &Place, known: &[&str]) {
        let near = did_you_mean(key, known.iter().copied());
        let way_out = format!("{near}known are {}", known.join(", "));
        self.note(place, "", "is no key of a blueprint here", &way_out);
    }

    fn format(&mut self, value: Spot<'_, '_>, place: &Place) -> Option<f64> {
        let Some(Value::Number(number)) = self.value(value, place) else { return None };
        if number != FORMAT {
            let rule = format!("is a format that this program does not know; it reads {FORMAT}");
            self.note(place, &number.to_string(), rule, "use a newer program, or write 1");
        }
        Some(number)
    }

    fn kind(&mut self, value: Spot<'_, '_>, place: &Place) -> Kind {
        match value.get_ref().as_str() {
            Some("plant") => return Kind::Plant,
            Some("controller") => return Kind::Controller,
            _ => {}
        }
        let shown = shown(value.get_ref());
        self.note(place, &shown, "is no kind of blueprint", "write \"plant\" or \"controller\"");
        Kind::Plant
    }

    fn axis(&mut self, table: &DeTable<'_>, place: &Place) -> AxisBlueprint {
        let mut axis = AxisBlueprint::default();
        for (key, value, place) in self.items(table, place) {
            match key {
                "name" => axis.name = self.name(value, &place),
                "command" => axis.command = self.signal(value, &place),
                "position" => axis.position = self.signal(value, &place),
                "reference" => axis.reference = self.signal(value, &place),
                "measured" => axis.measured = self.signal(value, &place),
                "force" => axis.force = self.signal(value, &place),
                "disturbance" => axis.disturbance = self.signal(value, &place),
                "motion" => axis.motion = self.signal(value, &place),
                "component" => {
                    let header = "[[axis.component]]";
                    axis.components = self.sections(value, &place, header, Self::component);
                }
                _ => self.unknown(key, &place, &AXIS_KEYS),
            }
        }
        axis
    }

    fn signal(&mut self, value: Spot<'_, '_>, place: &Place) -> SignalBlueprint {
        let mut signal = SignalBlueprint::default();
        let Some(table) = value.get_ref().as_table() else {
            let way_out = "write for example { name = \"u\", unit = \"V\" }";
            self.note(place, &shown(value.get_ref()), "must be a table", way_out);
            return signal;
        };
        for (key, value, place) in self.items(table, place) {
            match key {
                "name" => signal.name = self.name(value, &place),
                "unit" => signal.unit = self.name(value, &place),
                "min" => signal.min = self.value(value, &place),
                "max" => signal.max = self.value(value, &place),
                "start" => signal.start = self.value(value, &place),
                _ => self.unknown(key, &place, &SIGNAL_KEYS),
            }
        }
        signal
    }

    fn coupling(&mut self, table: &DeTable<'_>, place: &Place) -> CouplingBlueprint {
        let (mut axes, mut after) = (Vec::new(), String::new());
        let mut rest = Vec::new();
        for (key, value, place) in self.items(table, place) {
            match key {
                "axes" => axes = self.texts(value, &place),
                "after" => after = self.name(value, &place),
                _ => rest.push((key, value, place)),
            }
        }
        CouplingBlueprint { component: self.component_of(rest), axes, after }
    }

    fn connection(&mut self, table: &DeTable<'_>, place: &Place) -> ConnectionBlueprint {
        let mut connection = ConnectionBlueprint::default();
        for (key, value, place) in self.items(table, place) {
            match key {
                "from" => connection.from = self.name(value, &place),
                "to" => connection.to = self.name(value, &place),
                _ => self.unknown(key, &place, &["from", "to"]),
            }
        }
        connection
    }

    /// A list of texts.
    fn texts(&mut self, value: Spot<'_, '_>, place: &Place) -> Vec<String> {
        let items = value.get_ref().as_array();
        let texts: Option<Vec<String>> = items
            .map(|items| items.iter().map(|item| Some(item.get_ref().as_str()?.to_string())))
            .and_then(Iterator::collect);
        texts.unwrap_or_else(|| {
            let way_out = "write the names of the axes, as in [\"Y\", \"Z\"]";
            self.note(place, &shown(value.get_ref()), "must be a list of texts", way_out);
            Vec::new()
        })
    }

    fn component(&mut self, table: &DeTable<'_>, place: &Place) -> ComponentBlueprint {
        let items = self.items(table, place);
        self.component_of(items)
    }

    fn component_of(&mut self, items: Vec<(&str, Spot<'_, '_>, Place)>) -> ComponentBlueprint {
        let mut component = ComponentBlueprint::new("");
        let mut record = None;
        for (key, value, place) in items {
            match key {
                "type" => component.kind = self.name(value, &place),
                "name" => component.name = self.name(value, &place),
                "note" => component.note = self.text(value, &place),
                "record" => record = Some((self.name(value, &place), place)),
                "enabled" => component.enabled = self.switch(value, &place),
                "tolerance" => component.tolerance = self.tolerance(value, &place),
                _ => {
                    if let Some(value) = self.value(value, &place) {
                        component.values.push((key.to_string(), value));
                    }
                }
            }
        }
        if let Some((name, place)) = record.filter(|(name, _)| !name.is_empty()) {
            record::fill(self, &mut component, &name, &place);
        }
        component
    }

    fn switch(&mut self, value: Spot<'_, '_>, place: &Place) -> bool {
        value.get_ref().as_bool().unwrap_or_else(|| {
            let shown = shown(value.get_ref());
            self.note(place, &shown, "must be a truth value", "write true or false");
            true
        })
    }

    fn tolerance(&mut self, value: Spot<'_, '_>, place: &Place) -> BTreeMap<String, f64> {
        let mut tolerances = BTreeMap::new();
        let way_out = "write for example { w = 0.05 }, relative, 1 sigma";
        let Some(table) = value.get_ref().as_table() else {
            self.note(place, &shown(value.get_ref()), "must be a table", way_out);
            return tolerances;
        };
        for (key, value, place) in self.items(table, place) {
            match self.value(value, &place) {
                Some(Value::Number(number)) => {
                    tolerances.insert(key.to_string(), number);
                }
                Some(_) => self.note(&place, &shown(value.get_ref()), "must be a number", way_out),
                None => {}
            }
        }
        tolerances
    }
}

const KEYS: [&str; 14] = [
    "piezoloop",
    "kind",
    "name",
    "description",
    "source",
    "author",
    "version",
    "copyright",
    "license",
    "step",
    "temperature",
    "axis",
    "coupling",
    "connection",
];
const AXIS_KEYS: [&str; 9] = [
    "name",
    "command",
    "position",
    "reference",
    "measured",
    "force",
    "disturbance",
    "motion",
    "component",
];
const SIGNAL_KEYS: [&str; 5] = ["name", "unit", "min", "max", "start"];
const REQUIRED: [(&str, &str, &str); 4] = [
    ("piezoloop", "is missing, so the format of the file is unknown", "write piezoloop = 1"),
    ("kind", "is missing", "write kind = \"plant\" or kind = \"controller\""),
    ("name", "is missing", "name the model, as in name = \"stage\""),
    ("step", "is missing", "give the internal step in s, as in step = 20e-6"),
];
