//! Scales that turn the numbers of a converter into physical values: NI's properties
//! `NI_Scale[k]_…`. The last one is that of the channel; each takes the values of another one, of the
//! converter, or of a scaler of DAQmx.

use std::collections::BTreeMap;

use super::object::{Object, Property};

/// Most scales of a channel; NI-DAQmx writes some three.
const MOST: f64 = 64.0;
/// Source of a scale: what the converter gave.
const RAW: u32 = u32::MAX;

/// The values of a channel after its scales, or why they cannot be had; `above` are its group and its file.
pub(super) fn scaled(
    channel: &mut Object,
    above: &[&BTreeMap<String, Property>],
) -> Result<(), String> {
    let scaled = {
        let own = std::iter::once(&channel.properties).chain(above.iter().copied());
        let mut scales = own.filter_map(Scales::of);
        match scales.next() {
            Some(scales) => scales.value(scales.count - 1, channel, 0)?,
            None if channel.raw.len() == 1 => {
                channel.raw.values().next().cloned().unwrap_or_default()
            }
            None if channel.raw.is_empty() => return Ok(()),
            None => return Err("has raw values of DAQmx without a scale".into()),
        }
    };
    channel.values = scaled;
    Ok(())
}

struct Scales<'a> {
    properties: &'a BTreeMap<String, Property>,
    count: u32,
}

impl<'a> Scales<'a> {
    fn of(properties: &'a BTreeMap<String, Property>) -> Option<Self> {
        let is_done = matches!(properties.get("NI_Scaling_Status"),
            Some(Property::Text(status)) if status == "scaled");
        match properties.get("NI_Number_Of_Scales") {
            Some(Property::Number(count)) if !is_done && (1.0..=MOST).contains(count) => {
                Some(Self { properties, count: *count as u32 })
            }
            _ => None,
        }
    }

    fn number(&self, scale: u32, name: &str) -> Result<f64, String> {
        match self.properties.get(&format!("NI_Scale[{scale}]_{name}")) {
            Some(Property::Number(value)) => Ok(*value),
            _ => Err(format!("has a scale without \"{name}\"")),
        }
    }

    fn list(&self, scale: u32, name: &str) -> Result<Vec<f64>, String> {
        let count = self.number(scale, &format!("{name}_Size"))?;
        let count = if count <= 1e6 { count as usize } else { 0 };
        (0..count).map(|at| self.number(scale, &format!("{name}[{at}]"))).collect()
    }

    /// The values that a scale gives.
    fn value(&self, scale: u32, channel: &Object, depth: usize) -> Result<Vec<f64>, String> {
        if scale == RAW {
            return Ok(channel.values.clone());
        }
        if depth > 8 || scale >= self.count {
            return Err("has scales that lead nowhere".into());
        }
        let kind = match self.properties.get(&format!("NI_Scale[{scale}]_Scale_Type")) {
            Some(Property::Text(kind)) => kind.as_str(),
            // A scale of no type is what the converter gave.
            _ if channel.raw.is_empty() => return Ok(channel.values.clone()),
            _ => {
                let raw = channel.raw.get(&scale);
                return raw.cloned().ok_or_else(|| "has a scale of no type".into());
            }
        };
        let source = |name: &str| {
            let source = self.number(scale, &format!("{name}_Input_Source"));
            let source = source.map_or(RAW, |source| source as u32);
            self.value(source, channel, depth + 1)
        };
        match kind {
            "Linear" => {
                let slope = self.number(scale, "Linear_Slope")?;
                let intercept = self.number(scale, "Linear_Y_Intercept")?;
                Ok(map(source("Linear")?, |x| x * slope + intercept))
            }
            "Polynomial" => {
                let factors = self.list(scale, "Polynomial_Coefficients").or_else(|_| {
                    let name = |at| format!("Polynomial_Coefficients[{at}]");
                    (0..4).map(|at| self.number(scale, &name(at))).collect()
                })?;
                let value = |x| factors.iter().rev().fold(0.0, |sum, factor| sum * x + factor);
                Ok(map(source("Polynomial")?, value))
            }
            "Table" => {
                let from = self.list(scale, "Table_Pre_Scaled_Values")?;
                let to = self.list(scale, "Table_Scaled_Values")?;
                let mut pairs: Vec<[f64; 2]> =
                    from.iter().zip(&to).map(|(from, to)| [*from, *to]).collect();
                pairs.sort_by(|left, right| left[0].total_cmp(&right[0]));
                if pairs.is_empty() {
                    return Err("has a table without values".into());
                }
                Ok(map(source("Table")?, |x| crate::log::formats::table::between(&pairs, x)))
            }
            "Add" | "Subtract" => {
                let sign = if kind == "Add" { 1.0 } else { -1.0 };
                let left = source(&format!("{kind}_Left_Operand"))?;
                let right = source(&format!("{kind}_Right_Operand"))?;
                // NI subtracts the left operand from the right one.
                Ok(left.iter().zip(&right).map(|(left, right)| right + sign * left).collect())
            }
            "AdvancedAPI" => source("AdvancedAPI"),
            other => Err(format!("has a scale \"{other}\", which is not read")),
        }
    }
}

fn map(mut values: Vec<f64>, function: impl Fn(f64) -> f64) -> Vec<f64> {
    values.iter_mut().for_each(|value| *value = function(*value));
    values
}
