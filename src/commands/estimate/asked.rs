//! What is to be found: parameters that all logs share, and values that every record has its own of.

use anyhow::{Context, bail};
use cosim::{Fmu, Sought};
use identify::calibration::Tunable;
use modeldescription::variable::{Number, Start};

use crate::fmus::Addresses;

/// A value to find.
#[derive(Clone)]
pub(super) struct Asked {
    pub(super) name: String,
    pub(super) unit: Option<String>,
    pub(super) tunable: Tunable,
    /// The record whose own it is; none: all share it.
    pub(super) own: Option<Own>,
}

/// A record of a log.
#[derive(Clone)]
pub(super) struct Own {
    /// Number of the log, held-out ones behind the others.
    pub(super) log: usize,
    /// Number of the record in the log.
    pub(super) record: usize,
    /// What it is called.
    pub(super) label: String,
}

impl Asked {
    /// What messages call it.
    pub(super) fn label(&self) -> String {
        match &self.own {
            Some(own) => format!("{} of {}", self.name, own.label),
            None => self.name.clone(),
        }
    }

    /// Whether a record of a log has it.
    pub(super) fn is_of(&self, log: usize, record: usize) -> bool {
        self.own.as_ref().is_none_or(|own| own.log == log && own.record == record)
    }
}

/// The values to find, as `NAME[=START[,LOW..HIGH]]`.
pub(super) fn asked_of(
    option: &str,
    texts: &[String],
    fmu: &Fmu,
    addresses: &Addresses,
    all: &mut Vec<Asked>,
) -> anyhow::Result<()> {
    for text in texts {
        let sought = match Sought::parse(text) {
            Ok(sought) => sought,
            Err(why) => bail!("{option} {text}: {why}"),
        };
        let name = addresses.variable(&sought.name);
        let variable = fmu.variable(&name).with_context(|| format!("{option} {text}"))?;
        if all.iter().any(|other| other.name == name) {
            bail!("{option} {text}: `{name}` is asked for twice");
        }
        if !variable.data_type.is_float() {
            bail!(
                "{option} {text}: `{name}` is of type {}; only real numbers are tuned",
                variable.data_type.name()
            );
        }
        let own = match &variable.start {
            Some(Start::Float(values)) => values.first().copied(),
            _ => None,
        };
        let Some(start) = sought.start.or(own) else {
            bail!("{option} {text}: the FMU says no start value of `{name}`; write {name}=VALUE");
        };
        let properties = fmu.description().properties(&variable);
        let stated = |bound: Option<Number>, none: f64| bound.map_or(none, Number::as_f64);
        let (mut lower, mut upper) =
            (stated(properties.min, f64::NEG_INFINITY), stated(properties.max, f64::INFINITY));
        if let Some((low, high)) = sought.bounds {
            lower = lower.max(low);
            upper = upper.min(high);
        }
        if !(lower <= start && start <= upper && lower < upper) {
            bail!("{option} {text}: the start {start} is not within the bounds {lower} to {upper}");
        }
        let nominal = properties.nominal.filter(|n| *n > 0.0);
        let width = Some(0.5 * (upper - lower)).filter(|width| width.is_finite());
        let size = Some(start.abs()).filter(|size| *size > 0.0);
        let scale = size.or(nominal).or(width).unwrap_or(1.0);
        let tunable = Tunable { start, lower, upper, scale };
        all.push(Asked { name, unit: properties.unit.clone(), tunable, own: None });
    }
    Ok(())
}
