//! What a record carries so that it can be replayed.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::safety::AxisLimits;

/// What a replay needs beside the rows and the FMU. Records hold it as TOML, in which numbers read
/// back to their bits and limits may be infinite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    /// [`Recipe::VERSION`] of its writer.
    pub version: u32,
    /// Length of a cycle in ns.
    pub period_ns: u64,
    /// Cycles over which the controller took over.
    pub blend: u32,
    /// Start values of the controller.
    #[serde(default)]
    pub start: BTreeMap<String, toml::Value>,
    /// The axes.
    #[serde(rename = "axis")]
    pub axes: Vec<RecipeAxis>,
}

/// One axis: columns of the record, variables of the FMU, and what shapes the command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecipeAxis {
    /// Column of the reference.
    pub column: String,
    /// Input of the controller for the reference.
    pub reference: String,
    /// Column of the position.
    pub position: String,
    /// Input of the controller for the position.
    pub measured: String,
    /// Output of the controller, and column of what was sent.
    pub command: String,
    /// Least and greatest command.
    pub command_limits: [f64; 2],
    /// Fastest change of the command, per second.
    pub command_rate: f64,
    /// Command of the safe state.
    pub safe: f64,
    /// How fast the command goes there, per second.
    pub safe_rate: f64,
}

impl Recipe {
    /// Changes with the meaning of a field, and with what the cycle does to a command.
    pub const VERSION: u32 = 1;

    /// The recipe's text.
    ///
    /// # Errors
    /// A start value that TOML does not write.
    pub fn to_toml(&self) -> Result<String, String> {
        toml::to_string(self).map_err(|error| format!("[start] cannot be recorded: {error}"))
    }

    /// Reads its text.
    ///
    /// # Errors
    /// It is of another version, or damaged.
    pub fn parse(text: &str) -> Result<Self, String> {
        #[derive(Deserialize)]
        struct Version {
            version: u32,
        }
        let Version { version } =
            toml::from_str(text).map_err(|error| error.message().to_owned())?;
        if version != Recipe::VERSION {
            let own = Recipe::VERSION;
            return Err(format!("it is of version {version}, this program replays version {own}"));
        }
        let recipe: Recipe = toml::from_str(text).map_err(|error| error.message().to_owned())?;
        if recipe.period_ns == 0 || recipe.axes.is_empty() {
            return Err("it has no period or no axes".to_owned());
        }
        Ok(recipe)
    }

    /// Names of one kind, axis by axis.
    pub fn names(&self, of: fn(&RecipeAxis) -> &String) -> Vec<String> {
        self.axes.iter().map(of).cloned().collect()
    }

    pub(super) fn limits(&self) -> Vec<AxisLimits> {
        let limits = |axis: &RecipeAxis| AxisLimits {
            command: axis.command_limits,
            command_rate: axis.command_rate,
            safe: axis.safe,
            safe_rate: axis.safe_rate,
            ..AxisLimits::default()
        };
        self.axes.iter().map(limits).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_to_their_bits() {
        let axis = RecipeAxis {
            column: "r \"1\"".into(),
            reference: "r".into(),
            position: "p".into(),
            measured: "m".into(),
            command: "u".into(),
            command_limits: [f64::NEG_INFINITY, 0.1 + 0.2],
            command_rate: f64::INFINITY,
            safe: -0.0,
            safe_rate: 5e-324,
        };
        let recipe = Recipe {
            version: Recipe::VERSION,
            period_ns: 333_333,
            blend: 7,
            start: [("k".to_owned(), toml::Value::Float(1.0 / 3.0))].into(),
            axes: vec![axis],
        };
        let back = Recipe::parse(&recipe.to_toml().unwrap()).unwrap();
        assert_eq!(back, recipe);
        assert_eq!(back.axes[0].safe.to_bits(), (-0.0_f64).to_bits());
        let newer = recipe.to_toml().unwrap().replace("version = 1", "version = 2\nmore = 3");
        assert!(Recipe::parse(&newer).unwrap_err().contains("version 2"));
    }
}
