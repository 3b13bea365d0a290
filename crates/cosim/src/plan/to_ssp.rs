//! A plan as SSP.

use std::path::Path;

use modeldescription::description::{Line, Unit};
use modeldescription::ssp::*;
use modeldescription::variable::{Causality, Variable};
use modeldescription::{ModelDescription, xml};

use super::from_ssp::ANNOTATION;
use super::{Plan, PlannedFmu};
use crate::algorithm::Relaxation;
use crate::error::Error;
use crate::port::Port;
use crate::slave::Address;
use crate::unit::Transformations;

impl Plan {
    /// Writes the plan as an SSP 1.0 that holds the FMUs' files. `descriptions` are those of the
    /// FMUs, in their order; they tell types and units of connectors.
    ///
    /// Columns of the input table become inputs of the system, what is recorded its outputs. Start
    /// values are one parameter set, `parameters/start.ssv`. Step, algorithm and order, for which
    /// SSP has no words, are an annotation that [`Plan::read`] understands.
    ///
    /// # Errors
    /// Files that cannot be read or written, names that do not exist.
    pub fn export_ssp(&self, path: &Path, descriptions: &[&ModelDescription]) -> Result<(), Error> {
        let mut export = Export {
            plan: self,
            descriptions,
            structure: SystemStructure::new(&self.name),
            components: Vec::new(),
        };
        let builder = export.build()?;
        Ok(builder.write(path)?)
    }
}

struct Export<'a> {
    plan: &'a Plan,
    descriptions: &'a [&'a ModelDescription],
    structure: SystemStructure,
    components: Vec<Component>,
}

/// SSP joins names of levels by dots, so an element's own name has none.
fn plain(name: &str) -> String {
    name.replace('.', "_")
}

impl Export<'_> {
    fn build(&mut self) -> Result<SspBuilder, Error> {
        let plan = self.plan;
        let mut files = Vec::new();
        for fmu in &plan.fmus {
            let source = format!("resources/{}.fmu", file_name(&plain(&fmu.name)));
            let bytes = std::fs::read(&fmu.path).map_err(|error| Error::Package {
                path: fmu.path.clone(),
                reason: format!("it cannot be read: {error}; an SSP is made of packed FMUs"),
            })?;
            files.push((source.clone(), bytes));
            let mut component = Component::new(plain(&fmu.name), &source);
            component.annotations.extend(
                fmu.step.map(|step| annotation(&[("step", step.to_string())], Vec::new(), "Slave")),
            );
            self.components.push(component);
        }
        self.connect()?;
        self.starts();
        self.structure.system.annotations = vec![self.master()];
        self.structure.generation_tool = Some("Piezoloop".to_owned());
        self.structure.default_experiment =
            Experiment { start_time: plan.master.start, stop_time: plan.master.stop };
        let components = std::mem::take(&mut self.components);
        self.structure.system.elements = components.into_iter().map(Element::Component).collect();
        let mut builder = SspBuilder::new(&self.structure)?;
        for (source, bytes) in files {
            builder.entry(&source, bytes)?;
        }
        Ok(builder)
    }

    fn connect(&mut self) -> Result<(), Error> {
        for connection in &self.plan.connections {
            let (from, to) = (self.end(&connection.from)?, self.end(&connection.to)?);
            self.add(Connection::new(from, to), &connection.way);
        }
        for input in &self.plan.inputs {
            let data_type = self.connector_type(&input.to)?;
            self.system_connector(&input.column, Kind::Input, data_type);
            let from = End { element: None, connector: input.column.clone() };
            let to = self.end(&input.to)?;
            self.add(Connection::new(from, to), &input.way);
        }
        for (port, name) in &self.plan.record {
            let is_output = self.variable(port)?.causality == Causality::Output;
            let taken = self.structure.system.connectors.iter().any(|c| c.name == *name);
            if is_output && !taken {
                let data_type = self.connector_type(port)?;
                self.system_connector(name, Kind::Output, data_type);
                let to = End { element: None, connector: name.clone() };
                let from = self.end(port)?;
                self.add(Connection::new(from, to), &Transformations::default());
            }
        }
        Ok(())
    }

    fn add(&mut self, mut connection: Connection, way: &Transformations) {
        let transformation = way.0.iter().filter_map(|step| step.transformation);
        let (mut factor, mut offset) = (1.0, 0.0);
        for (f, o) in transformation {
            (factor, offset) = (f * factor, f * offset + o);
        }
        connection.suppress_unit_conversion =
            way.0.iter().any(|step| step.suppress_unit_conversion);
        if (factor, offset) != (1.0, 0.0) {
            connection.transformation = Some(Transformation::Linear { factor, offset });
        }
        self.structure.system.connections.push(connection);
    }

    fn system_connector(&mut self, name: &str, kind: Kind, data_type: ConnectorType) {
        let connectors = &mut self.structure.system.connectors;
        if !connectors.iter().any(|connector| connector.name == name) {
            let data_type = Some(data_type);
            connectors.push(Connector { data_type, ..Connector::new(name, kind) });
        }
    }

    fn place(&self, port: &Port) -> Result<usize, Error> {
        let found = self.plan.fmus.iter().position(|fmu: &PlannedFmu| fmu.name == port.slave);
        found.filter(|place| *place < self.descriptions.len()).ok_or_else(|| Error::Package {
            path: self.plan.origin.clone(),
            reason: format!("there is no FMU `{}`", port.slave),
        })
    }

    fn variable(&self, port: &Port) -> Result<Variable, Error> {
        let description = self.descriptions[self.place(port)?];
        let found = Address::find(&port.slave, description, &port.variable);
        found.map(|address| address.variable).map_err(|problem| Error::Problems(problem.into()))
    }

    fn connector_type(&mut self, port: &Port) -> Result<ConnectorType, Error> {
        let description = self.descriptions[self.place(port)?];
        let variable = self.variable(port)?;
        let unit = description.properties(&variable).unit;
        if let Some(unit) = unit.as_deref().and_then(|unit| description.unit(unit)) {
            self.define(unit);
        }
        let unit = unit.filter(|unit| self.structure.units.iter().any(|u| u.name == *unit));
        let enumeration = None;
        Ok(ConnectorType { data_type: variable.data_type, unit, enumeration })
    }

    /// A unit is defined once; one of the same name that is another keeps its own place.
    fn define(&mut self, unit: &Unit) {
        if unit.base.is_some() && !self.structure.units.iter().any(|u| u.name == unit.name) {
            let (display_units, line) = (Vec::new(), Line(0));
            self.structure.units.push(Unit { display_units, line, ..unit.clone() });
        }
    }

    /// The end of a connection at a component; its connector is declared.
    fn end(&mut self, port: &Port) -> Result<End, Error> {
        let place = self.place(port)?;
        let kind = match self.variable(port)?.causality {
            Causality::Output => Kind::Output,
            Causality::Parameter => Kind::Parameter,
            Causality::CalculatedParameter => Kind::CalculatedParameter,
            _ => Kind::Input,
        };
        let data_type = Some(self.connector_type(port)?);
        let component = &mut self.components[place];
        if !component.connectors.iter().any(|connector| connector.name == port.variable) {
            component
                .connectors
                .push(Connector { data_type, ..Connector::new(&port.variable, kind) });
        }
        Ok(End { element: Some(component.name.clone()), connector: port.variable.clone() })
    }

    fn starts(&mut self) {
        let parameters: Vec<Parameter> = self
            .plan
            .starts
            .iter()
            .map(|start| Parameter {
                name: format!("{}.{}", plain(&start.to.slave), start.to.variable),
                value: scaled(&start.value, &start.way),
                unit: None,
                line: Line(0),
            })
            .collect();
        if parameters.is_empty() {
            return;
        }
        let set = ParameterSet { parameters, ..ParameterSet::new("start values") };
        let source = Source::File("parameters/start.ssv".to_owned());
        self.structure.system.bindings = vec![Binding { source, ..Binding::inline(set) }];
    }

    fn master(&self) -> Annotation {
        let master = &self.plan.master;
        let mut attributes = vec![("algorithm", master.coupling.name().to_owned())];
        attributes.extend(master.step.map(|step| ("step", step.to_string())));
        if let Relaxation::Fixed(omega) = master.iteration.relaxation {
            attributes.push(("relaxation", omega.to_string()));
        }
        attributes.push(("tolerance", master.iteration.tolerance.to_string()));
        attributes.push(("iterations", master.iteration.iterations.to_string()));
        let order = master.order.iter().map(|name| child("Slave", &[("name", plain(name))]));
        let record = self.plan.record.iter().map(|(port, name)| {
            let variable = format!("{}.{}", plain(&port.slave), port.variable);
            child("Record", &[("name", name.clone()), ("variable", variable)])
        });
        annotation(&attributes, order.chain(record).collect(), "Master")
    }
}

/// A value as the variable takes it: its conversion is applied where it is no unit's.
fn scaled(value: &ParameterValue, way: &Transformations) -> ParameterValue {
    let scale = way.0.iter().find_map(|step| step.transformation);
    match (value, scale) {
        (ParameterValue::Real(values), Some((factor, offset))) => {
            ParameterValue::Real(values.iter().map(|value| factor * value + offset).collect())
        }
        _ => value.clone(),
    }
}

/// A name as part of a path.
fn file_name(name: &str) -> String {
    let odd = |c: char| c.is_control() || "/\\:?#%*\"<>| ".contains(c);
    name.chars().map(|c| if odd(c) { '_' } else { c }).collect()
}

fn child(name: &str, attributes: &[(&str, String)]) -> xml::Element {
    let attributes = attributes.iter().map(|(name, value)| ((*name).to_owned(), value.clone()));
    xml::Element {
        name: format!("piezoloop:{name}"),
        attributes: attributes.collect(),
        children: Vec::new(),
        line: 0,
    }
}

fn annotation(
    attributes: &[(&str, String)],
    children: Vec<xml::Element>,
    name: &str,
) -> Annotation {
    let mut content = child(name, attributes);
    let namespace = "https://github.com/piezoloop/piezoloop";
    content.attributes.insert(0, ("xmlns:piezoloop".to_owned(), namespace.to_owned()));
    content.children = children;
    Annotation { kind: ANNOTATION.to_owned(), content: Some(content) }
}
