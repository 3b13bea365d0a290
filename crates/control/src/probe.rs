//! Parts of one axis, run by themselves in the units of the axis.

use components::actuator::ACTUATOR_GAIN;
use model::{
    AxisSpec, ComponentRef, Connections, Conversion, Kind, NodeSpec, StepError, System, SystemSpec,
};

/// A chain of nodes as a plant of one axis: what goes in is a command, what comes out a position.
pub(crate) struct Probe {
    system: System,
    command: u32,
    position: u32,
    period: f64,
    count: u64,
}

/// A straight actuator of gain 1 in the place of one that is looked at without it.
pub(crate) fn straight(gain: f64) -> NodeSpec {
    NodeSpec {
        component: ComponentRef::Static(&ACTUATOR_GAIN),
        name: "straight__".to_owned(),
        structure: Vec::new(),
        values: vec![gain, 0.0],
        enabled: true,
    }
}

/// The axis with other components, free of bounds, start and short names.
pub(crate) fn bare(axis: &AxisSpec, components: Vec<NodeSpec>) -> AxisSpec {
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    AxisSpec {
        name: axis.name.clone(),
        command_unit: axis.command_unit.clone(),
        position_unit: axis.position_unit.clone(),
        command_range: free,
        position_range: free,
        start: 0.0,
        aliases: Vec::new(),
        components,
    }
}

/// Whether the component turns a command into a position.
pub(crate) fn is_actuator(node: &NodeSpec) -> bool {
    node.component.declaration().conversion == Conversion::CommandToPosition
}

impl Probe {
    /// The nodes between an input and an output that are read every `period` seconds, with the internal
    /// `step`. Where none of them is an actuator, a straight one stands in front of them, or behind them where
    /// they belong to the command.
    ///
    /// # Errors
    /// What the model says.
    pub(crate) fn new(
        axis: &AxisSpec,
        nodes: &[NodeSpec],
        of_the_command: bool,
        (step, period): (f64, f64),
    ) -> Result<Self, String> {
        let mut components = nodes.to_vec();
        if !components.iter().any(is_actuator) {
            let at = if of_the_command { components.len() } else { 0 };
            components.insert(at, straight(1.0));
        }
        let spec = SystemSpec {
            name: "part".to_owned(),
            kind: Kind::Plant,
            period: step,
            axes: vec![bare(axis, components)],
            connections: Connections::default(),
        };
        let system = System::new(&spec)
            .map_err(|all| all.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))?;
        let variable =
            |name: &str| system.variables().find(name).ok_or_else(|| format!("has no {name}"));
        let (command, position) = (variable("command[1]")?, variable("position[1]")?);
        Ok(Self { system, command, position, period, count: 0 })
    }

    fn explain<T>(&self, result: Result<T, StepError>) -> Result<T, String> {
        result.map_err(|e| self.system.explain(&e))
    }

    /// The output at rest under this input.
    pub(crate) fn rest(&mut self, u: f64) -> Result<f64, String> {
        self.count = 0;
        self.system.set(self.command, u).map_err(|e| self.system.explain_set(&e))?;
        let result = self.system.initialise(0.0);
        self.explain(result)?;
        Ok(self.system.get(self.position).unwrap_or(f64::NAN))
    }

    /// The output at the end of one period with this input.
    pub(crate) fn step(&mut self, u: f64) -> Result<f64, String> {
        self.count += 1;
        self.system.set(self.command, u).map_err(|e| self.system.explain_set(&e))?;
        let result = self.system.advance(self.count as f64 * self.period);
        self.explain(result)?;
        Ok(self.system.get(self.position).unwrap_or(f64::NAN))
    }

    /// The outputs at the ends of the periods with these inputs, from rest under the first.
    pub(crate) fn run(&mut self, u: &[f64]) -> Result<Vec<f64>, String> {
        self.rest(u.first().copied().unwrap_or(0.0))?;
        u.iter().map(|u| self.step(*u)).collect()
    }
}
