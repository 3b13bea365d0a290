//! Numbers in JSON: a value that is not finite is `null`, and `null` is not a number again.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Writes a list; `serde_json` alone would fail to read its own `null` back.
pub(crate) fn serialize<S: Serializer>(values: &[f64], out: S) -> Result<S::Ok, S::Error> {
    out.collect_seq(values.iter().map(|value| value.is_finite().then_some(*value)))
}

/// Reads a list.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(input: D) -> Result<Vec<f64>, D::Error> {
    let values = Vec::<Option<f64>>::deserialize(input)?;
    Ok(values.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect())
}

/// Writes and reads a list that may be absent.
pub(crate) mod optional {
    use super::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(
        values: &Option<Vec<f64>>,
        out: S,
    ) -> Result<S::Ok, S::Error> {
        values
            .as_ref()
            .map(|list| list.iter().map(|v| v.is_finite().then_some(*v)).collect::<Vec<_>>())
            .serialize(out)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        input: D,
    ) -> Result<Option<Vec<f64>>, D::Error> {
        let values = Option::<Vec<Option<f64>>>::deserialize(input)?;
        Ok(values.map(|list| list.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect()))
    }
}
