//! Signal dictionaries: one place per signal, wherever a reference to the dictionary stands.

use super::{Flattener, NodeInfo, joined};
use crate::ssp::connector::{Kind, Source};
use crate::ssp::dictionary::{DictionaryReference, SignalDictionary};
use crate::ssp::problem::Format;

impl<'a> Flattener<'a> {
    /// Takes up the connectors of a reference, and the signals that they stand for.
    pub(super) fn reference(&mut self, reference: &DictionaryReference, path: &str) {
        let Some((place, dictionary)) = self.dictionary(reference) else { return };
        self.connectors(path, &reference.connectors, false);
        for connector in &reference.connectors {
            let signals = dictionary.signals.iter().flatten();
            let Some(signal) = signals.into_iter().find(|s| s.name == connector.name) else {
                let found = format!(
                    "the signal dictionary \"{}\" has no signal \"{}\"",
                    dictionary.name, connector.name
                );
                let rule = "connectors of a reference are signals of its dictionary";
                self.report(connector.line, found, rule, "add the signal or correct the name");
                continue;
            };
            let name = signal.data_type.as_ref().and_then(|stated| stated.unit.as_deref());
            let own = |name: &str| dictionary.units.iter().find(|u| u.name == name).cloned();
            let (format, file) = match &dictionary.source {
                Source::File(file) | Source::InComponent(file) => {
                    (Format::Dictionary, file.clone())
                }
                Source::Inline => (Format::Structure, self.file.to_owned()),
            };
            let outer = |this: &mut Self, name| this.unit_of(name, format, &file, signal.line);
            let unit = name.and_then(|name| own(name).or_else(|| outer(self, name)));
            let (kind, elements) = (Kind::Inout, Vec::new());
            let info = NodeInfo { kind, unit, is_component: false, elements };
            self.nodes.insert((place.clone(), signal.name.clone()), info);
        }
        self.shared.insert(path.to_owned(), place);
    }

    /// The dictionary that a reference means, of its system or the nearest around, and its path. No
    /// element can have this path, because no XML can carry a zero byte.
    fn dictionary(
        &mut self,
        reference: &DictionaryReference,
    ) -> Option<(String, &'a SignalDictionary)> {
        let found = self.enclosing.iter().rev().find_map(|(path, system)| {
            let named = system.dictionaries.iter().find(|d| d.name == reference.dictionary)?;
            Some((format!("{}\0", joined(path, &named.name)), named))
        });
        if found.is_none() {
            self.report(
                reference.line,
                format!("there is no signal dictionary \"{}\"", reference.dictionary),
                "a reference names a dictionary of its system or of one around it",
                "add the dictionary or correct the name",
            );
        }
        found
    }
}
