//! Inputs and outputs of a model, and their columns in the logs.

use data::{Log, NameMap};
use model::Unit;

use crate::error::Error;
use crate::request::{Noise, Request};

/// An input or output of the model.
#[derive(Clone, Debug)]
pub(crate) struct Port {
    pub(crate) name: String,
    pub(crate) alias: Option<String>,
    pub(crate) unit: String,
    pub(crate) si: Unit,
    pub(crate) range: (f64, f64),
}

impl Port {
    /// Name in reports.
    pub(crate) fn label(&self) -> &str {
        self.alias.as_deref().unwrap_or(&self.name)
    }

    /// Whether a user may call it so.
    pub(crate) fn is(&self, name: &str) -> bool {
        self.name == name || self.alias.as_deref() == Some(name)
    }

    /// The port's column in a log.
    pub(crate) fn column<'a>(&'a self, names: &'a NameMap, log: &Log) -> Option<&'a str> {
        let alias = self.alias.as_deref();
        let mapped = names.column(&self.name).or_else(|| names.column(alias?));
        if let Some(column) = mapped {
            return log.column(column).map(|_| column);
        }
        [Some(self.name.as_str()), alias]
            .into_iter()
            .flatten()
            .find(|name| log.column(name).is_some())
    }
}

/// Names of `--noise` and `--map` against the model's: one of the first that is unknown is an error, of the second a
/// warning, as one list of pairs may serve several models.
pub(crate) fn check_names(
    request: &Request,
    model: &str,
    inputs: &[Port],
    outputs: &[Port],
) -> Result<Vec<String>, Error> {
    let near = |name: &str, ports: &[&Port]| {
        let names = ports.iter().flat_map(|p| [Some(p.name.as_str()), p.alias.as_deref()]);
        data::nearest(name, names.flatten())
            .map_or_else(String::new, |near| format!("did you mean {near}? "))
    };
    let labels = |ports: &[&Port]| ports.iter().map(|p| p.label()).collect::<Vec<_>>().join(", ");
    if let Noise::Given(all) = &request.noise {
        let known: Vec<&Port> = outputs.iter().collect();
        for name in all.iter().filter_map(|(name, _)| name.as_deref()) {
            // The column of a monitor is an output, too.
            let is_column = request.logs.iter().any(|log| log.column(name).is_some());
            if !is_column && !outputs.iter().any(|port| port.is(name)) {
                return Err(Error::Option {
                    option: "--noise",
                    value: name.to_owned(),
                    message: format!(
                        "is no output of {model}; {}its outputs are {}",
                        near(name, &known),
                        labels(&known)
                    ),
                });
            }
        }
    }
    let known: Vec<&Port> = inputs.iter().chain(outputs).collect();
    let pairs = request.names.iter();
    let unknown =
        pairs.filter(|(name, _)| *name != "time" && !known.iter().any(|port| port.is(name)));
    Ok(unknown
        .map(|(name, column)| {
            format!(
                "--map {name}={column} has no effect: {name} is neither an input nor an output of {model}; {}they are {}",
                near(name, &known),
                labels(&known)
            )
        })
        .collect())
}

/// Numbers of the outputs that are looked at.
pub(crate) fn choose(
    request: &Request,
    model: &str,
    outputs: &[Port],
) -> Result<Vec<usize>, Error> {
    let labels = || outputs.iter().map(Port::label).collect::<Vec<_>>().join(", ");
    for asked in &request.outputs {
        if !outputs.iter().any(|port| port.is(asked)) {
            return Err(Error::Option {
                option: "--outputs",
                value: asked.clone(),
                message: format!("is no output of {model}; its outputs are {}", labels()),
            });
        }
    }
    let is_asked = |port: &Port| {
        request.outputs.is_empty() || request.outputs.iter().any(|asked| port.is(asked))
    };
    let logs = || request.logs.iter().chain(&request.holdout);
    let chosen: Vec<usize> = (0..outputs.len())
        .filter(|k| is_asked(&outputs[*k]))
        .filter(|k| logs().all(|log| outputs[*k].column(&request.names, log).is_some()))
        .collect();
    if chosen.is_empty() {
        let log = &request.logs[0];
        let columns: Vec<&str> = log.columns().iter().map(|c| c.name.as_str()).collect();
        return Err(Error::Log {
            log: log.origin().to_owned(),
            message: format!(
                "no column is an output of {model}; outputs are {}, columns are {}: name one with --map {}=COLUMN",
                labels(),
                columns.join(", "),
                outputs.first().map_or("position[1]", Port::label)
            ),
        });
    }
    Ok(chosen)
}

/// Text of the unit of a port.
pub(crate) fn unit_text(port: &Port) -> &str {
    if port.unit.is_empty() { "1" } else { &port.unit }
}

/// The values of a port in a log, in the port's unit.
pub(crate) fn column(
    request: &Request,
    port: &Port,
    log: &Log,
    role: &str,
) -> Result<Vec<f64>, Error> {
    let Some(name) = port.column(&request.names, log) else {
        let there: Vec<&str> = log.columns().iter().map(|c| c.name.as_str()).collect();
        return Err(Error::Log {
            log: log.origin().to_owned(),
            message: format!(
                "has no column for the {role} {}; columns are {}: name one with --map {}=COLUMN",
                port.name,
                there.join(", "),
                port.label()
            ),
        });
    };
    Ok(log.convert(name, unit_text(port))?)
}
