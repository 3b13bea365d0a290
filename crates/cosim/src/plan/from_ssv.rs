//! Start values from a parameter set beside the system's file.

use std::collections::HashSet;
use std::path::Path;

use modeldescription::ssp::{Linear, ParameterSet, SspError};

use super::{Plan, PlannedStart};
use crate::error::Error;
use crate::unit::Transformations;

impl Plan {
    /// Takes the start values of an SSV, whose parameters are named `fmu.variable`. They replace
    /// those that the plan has.
    ///
    /// # Errors
    /// The file cannot be read, is no SSV, or names an FMU that is not in the system.
    pub fn set(&mut self, path: &Path) -> Result<(), Error> {
        let file = path.display().to_string();
        let refused = |reason: String| Error::Package { path: path.to_path_buf(), reason };
        let text =
            files::read_text(path).map_err(|error| refused(format!("cannot be read: {error}")))?;
        let set = ParameterSet::parse(text.as_bytes(), &file).map_err(SspError::Problems)?;
        for parameter in set.parameters {
            let Some(to) = self.port(&parameter.name) else {
                let there: Vec<&str> = self.fmus.iter().map(|fmu| fmu.name.as_str()).collect();
                return Err(refused(format!(
                    "line {}: parameter \"{}\" belongs to no FMU of the system; parameters are \
                     named `fmu.variable`, and the FMUs are {}",
                    parameter.line.0,
                    parameter.name,
                    there.join(", ")
                )));
            };
            let unit = parameter.unit.as_deref();
            let from = set.units.iter().find(|known| Some(known.name.as_str()) == unit).cloned();
            let step =
                Linear { from, to: None, suppress_unit_conversion: false, transformation: None };
            self.starts.push(PlannedStart {
                to,
                value: parameter.value,
                way: Transformations(vec![step]),
                place: format!("{file}:{}: parameter \"{}\"", parameter.line.0, parameter.name),
                optional: false,
            });
        }
        let mut seen = HashSet::new();
        let starts = std::mem::take(&mut self.starts).into_iter().rev();
        self.starts = starts.filter(|start| seen.insert(start.to.clone())).collect();
        self.starts.reverse();
        Ok(())
    }
}
