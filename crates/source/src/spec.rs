//! What a system is built from, as bytes: version, then the fields of [`SystemSpec`] in postcard's format.
//! A component is the name of its type and, where it runs one, its table.

use model::{
    AxisSpec, Connections, CouplingSpec, InputSpec, Kind, NodeSpec, PortSpec, Registry, SystemSpec,
    Table,
};
use serde::{Deserialize, Serialize};

/// Version of the layout.
const VERSION: u8 = 1;

#[derive(Serialize, Deserialize)]
struct Spec {
    name: String,
    is_controller: bool,
    period: f64,
    axes: Vec<Axis>,
    couplings: Vec<Coupling>,
    motion_units: Vec<Option<String>>,
    /// Variable, alias, unit, start.
    inputs: Vec<(String, Option<String>, String, f64)>,
    /// Axis, component, port, axis of the signal, signal.
    ports: Vec<(usize, String, String, usize, String)>,
}

#[derive(Serialize, Deserialize)]
struct Axis {
    name: String,
    command_unit: String,
    position_unit: String,
    command_range: (f64, f64),
    position_range: (f64, f64),
    start: f64,
    aliases: Vec<Option<String>>,
    components: Vec<Node>,
}

#[derive(Serialize, Deserialize)]
struct Node {
    kind: String,
    name: String,
    structure: Vec<f64>,
    values: Vec<f64>,
    enabled: bool,
    /// Columns and values.
    table: Option<(usize, Vec<f64>)>,
}

#[derive(Serialize, Deserialize)]
struct Coupling {
    node: Node,
    axes: Vec<usize>,
    after: Option<String>,
}

/// The bytes of a spec.
///
/// # Errors
/// Postcard's, which for these types it does not have.
pub fn to_bytes(spec: &SystemSpec) -> Result<Vec<u8>, String> {
    let SystemSpec { name, kind, period, axes, connections } = spec;
    let Connections { couplings, motion_units, inputs, ports } = connections;
    let spec = Spec {
        name: name.clone(),
        is_controller: *kind == Kind::Controller,
        period: *period,
        axes: axes.iter().map(axis_of).collect(),
        couplings: couplings.iter().map(coupling_of).collect(),
        motion_units: motion_units.clone(),
        inputs: inputs
            .iter()
            .map(|i| (i.variable.clone(), i.alias.clone(), i.unit.clone(), i.start))
            .collect(),
        ports: ports
            .iter()
            .map(|p| (p.axis, p.component.clone(), p.port.clone(), p.from, p.signal.clone()))
            .collect(),
    };
    postcard::to_extend(&spec, vec![VERSION]).map_err(|error| error.to_string())
}

/// The spec that [`to_bytes`] wrote, with the components of this registry.
///
/// # Errors
/// What is wrong with the bytes.
pub fn from_bytes(bytes: &[u8], registry: Registry) -> Result<SystemSpec, String> {
    let Some((VERSION, rest)) = bytes.split_first().map(|(version, rest)| (*version, rest)) else {
        let found = bytes.first().map_or("no bytes".into(), |version| format!("layout {version}"));
        return Err(format!("the model has {found}, layout {VERSION} is read; pack the FMU again"));
    };
    let spec: Spec = postcard::from_bytes(rest)
        .map_err(|error| format!("the model's bytes are damaged ({error}); pack the FMU again"))?;
    let axes = spec.axes.into_iter().map(|axis| axis.spec(registry));
    let couplings = spec.couplings.into_iter().map(|coupling| {
        let Coupling { node, axes, after } = coupling;
        Ok(CouplingSpec { node: node.spec(registry)?, axes, after })
    });
    let inputs = spec.inputs.into_iter();
    let ports = spec.ports.into_iter();
    Ok(SystemSpec {
        name: spec.name,
        kind: if spec.is_controller { Kind::Controller } else { Kind::Plant },
        period: spec.period,
        axes: axes.collect::<Result<_, String>>()?,
        connections: Connections {
            couplings: couplings.collect::<Result<_, String>>()?,
            motion_units: spec.motion_units,
            inputs: inputs
                .map(|(variable, alias, unit, start)| InputSpec { variable, alias, unit, start })
                .collect(),
            ports: ports
                .map(|(axis, component, port, from, signal)| PortSpec {
                    axis,
                    component,
                    port,
                    from,
                    signal,
                })
                .collect(),
        },
    })
}

fn axis_of(axis: &AxisSpec) -> Axis {
    Axis {
        name: axis.name.clone(),
        command_unit: axis.command_unit.clone(),
        position_unit: axis.position_unit.clone(),
        command_range: axis.command_range,
        position_range: axis.position_range,
        start: axis.start,
        aliases: axis.aliases.clone(),
        components: axis.components.iter().map(node_of).collect(),
    }
}

fn node_of(node: &NodeSpec) -> Node {
    Node {
        kind: node.component.declaration().kind.into(),
        name: node.name.clone(),
        structure: node.structure.clone(),
        values: node.values.clone(),
        enabled: node.enabled,
        table: node.component.table().map(|table| (table.columns(), table.values().to_vec())),
    }
}

fn coupling_of(coupling: &CouplingSpec) -> Coupling {
    let CouplingSpec { node, axes, after } = coupling;
    Coupling { node: node_of(node), axes: axes.clone(), after: after.clone() }
}

impl Axis {
    fn spec(self, registry: Registry) -> Result<AxisSpec, String> {
        let components = self.components.into_iter().map(|node| node.spec(registry));
        Ok(AxisSpec {
            components: components.collect::<Result<_, _>>()?,
            name: self.name,
            command_unit: self.command_unit,
            position_unit: self.position_unit,
            command_range: self.command_range,
            position_range: self.position_range,
            start: self.start,
            aliases: self.aliases,
        })
    }
}

impl Node {
    fn spec(self, registry: Registry) -> Result<NodeSpec, String> {
        let Self { kind, name, structure, values, enabled, table } = self;
        let found = registry.iter().find(|c| c.declaration().kind == kind);
        let component = found.ok_or_else(|| format!("there is no component type \"{kind}\""))?;
        let component = match table {
            None => (*component).into(),
            Some((columns, values)) => {
                component.with_table(&structure, &Table::new(columns, values)?)?
            }
        };
        Ok(NodeSpec { component, name, structure, values, enabled })
    }
}
