//! What a diagnosis answers, as far as the scorer looks: the stable fields of `gap.json`.

use serde::{Deserialize, Serialize};

/// The stable fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// `adequate`, `retune`, `effects`, `unknown` or `insufficient_excitation`.
    pub verdict: String,
    /// The effects that are named.
    pub effects: Vec<Named>,
    /// How much of the gap is foretold to go.
    pub shrink: Shrink,
    /// What is left.
    pub leftover: Leftover,
}

/// One effect that is named.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Identifier.
    pub effect: String,
    /// Output that shows it.
    pub output: String,
    /// Probability that the name is right.
    pub probability: f64,
    /// Names that it may be.
    pub set: Vec<String>,
}

/// The prediction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shrink {
    /// Part of the gap's power that goes.
    pub fraction: Option<f64>,
    /// The shrink's 95 % prediction interval.
    pub ci95: Option<[f64; 2]>,
    /// Root mean square of the held-out rows of the re-tuned model.
    #[serde(default)]
    pub rms_before: Option<f64>,
    /// Root mean square of the held-out rows of the model with the effects.
    #[serde(default)]
    pub rms_after: Option<f64>,
}

/// What is left.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Leftover {
    /// Whether something is left.
    pub present: bool,
}

impl Answer {
    /// Whether several names stand for an effect.
    #[must_use]
    pub fn has_rivals(&self) -> bool {
        self.effects.iter().any(|named| named.set.len() > 1)
    }

    /// Whether an effect is named and each has one name.
    #[must_use]
    pub fn is_single(&self) -> bool {
        !self.effects.is_empty() && !self.has_rivals()
    }

    /// Reads `gap.json`.
    ///
    /// # Errors
    /// The text is no JSON or lacks a field; the message says which.
    pub fn parse(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn further_fields_are_no_matter_and_missing_ones_are() {
        let text = r#"{"schema":"piezoloop.gap/1","verdict":"effects","effects":[{"effect":"creep",
            "output":"y","stage":"actuator","probability":0.97,"set":["creep"],"group":"slow"}],
            "shrink":{"fraction":0.9,"ci95":[0.8,0.95]},"leftover":{"present":false}}"#;
        let answer = Answer::parse(text).unwrap();
        assert_eq!(answer.effects[0].set, ["creep"]);
        assert_eq!(answer.shrink.ci95, Some([0.8, 0.95]));
        let message = Answer::parse(&text.replace("verdict", "verdikt")).unwrap_err();
        assert!(message.contains("verdict"), "{message}");
    }
}
