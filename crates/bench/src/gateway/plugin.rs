//! `plugin://./libmycard.so?options`: a driver in C behind the six functions of `gateway.h`.

use std::path::Path;

use ::plugin::{Plugin, Sample};

use super::device::{Device, Exchanged};

/// A card behind a shared library.
#[derive(Debug)]
pub struct PluginDevice {
    /// None once it is closed.
    card: Option<Plugin>,
}

impl PluginDevice {
    /// Loads the library and opens its card. `period` in s.
    ///
    /// # Errors
    /// It is no gateway, of another version, or says no.
    pub fn open(
        library: &Path,
        options: &str,
        channels: usize,
        period: f64,
    ) -> Result<Self, String> {
        let card = Plugin::open(library, options, channels, period);
        Ok(PluginDevice { card: Some(card.map_err(|error| error.to_string())?) })
    }
}

impl Device for PluginDevice {
    fn exchange(&mut self, enabled: bool, commands: &[f64], positions: &mut [f64]) -> Exchanged {
        let Some(card) = &mut self.card else { return Exchanged::Nothing };
        match card.exchange(enabled, commands, positions) {
            Ok(Some(Sample { valid, powered })) => Exchanged::Sample { valid, powered },
            Ok(None) => Exchanged::Nothing,
            Err(text) => Exchanged::Failed(text),
        }
    }

    fn describe(&mut self) -> Option<String> {
        self.card.as_mut().and_then(Plugin::describe)
    }

    fn close(&mut self) {
        self.card = None;
    }
}
