//! Ports that are connected by name to another signal than their own.

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use super::{Builder, POINTS};
use crate::quantity::unit_on_axis;
use crate::{DEMANDED_INPUTS, Input, Kind, PortSpec, Source, Unit};

impl Builder<'_> {
    /// Refuses connections to what is not there, and of signals that measure something else.
    pub(super) fn check_ports(&mut self) {
        let spec = self.spec;
        for (connection, number) in spec.connections.ports.iter().zip(1..) {
            if spec.kind == Kind::Controller {
                let place = format!("connection[{number}]");
                self.error(place, "a controller has no connections; leave it out");
                continue;
            }
            let earlier = &spec.connections.ports[..number - 1];
            let twice = |other: &PortSpec| {
                (other.axis, &other.component, &other.port)
                    == (connection.axis, &connection.component, &connection.port)
            };
            if earlier.iter().any(twice) {
                let to = format!("connection[{number}].to");
                self.error(to, "this port is connected already; keep one of the two");
            }
            let port = self.port_unit(connection);
            let signal = self.signal_of(connection.from, &connection.signal);
            let signal = signal.map(|(_, unit)| unit).ok_or_else(|| self.no_signal(connection));
            match (port, signal) {
                (Ok(port), Ok(signal)) => self.check_units(number, connection, &port, &signal),
                (port, signal) => {
                    for (end, verdict) in [("to", port), ("from", signal)] {
                        if let Err(message) = verdict {
                            self.error(format!("connection[{number}].{end}"), message);
                        }
                    }
                }
            }
        }
    }

    fn check_units(&mut self, number: usize, connection: &PortSpec, port: &str, signal: &str) {
        let (Ok(a), Ok(b)) = (Unit::parse(port), Unit::parse(signal)) else { return };
        if !a.is_compatible(&b) {
            let (name, from) = (&connection.port, &connection.signal);
            self.error(
                format!("connection[{number}].from"),
                format!(
                    "{from} is in {signal}, and the port {name} reads {port}: they do not measure \
                     the same; connect a signal in a unit that converts to {port}"
                ),
            );
        }
    }

    /// The unit of what a port reads, or why it cannot be connected.
    fn port_unit(&self, connection: &PortSpec) -> Result<String, String> {
        let Some(axis) = self.spec.axes.get(connection.axis) else {
            return Err(format!("there is no axis number {}; name one", connection.axis + 1));
        };
        let node = axis.components.iter().find(|node| node.name == connection.component);
        let Some(node) = node else {
            let names: Vec<&str> = axis.components.iter().map(|node| &*node.name).collect();
            return Err(format!(
                "axis {} has no component \"{}\"; it has {}",
                axis.name,
                connection.component,
                names.join(", ")
            ));
        };
        let inputs = node.component.declaration().inputs.iter();
        let free = inputs.filter(|port| matches!(port.source, Source::Axis(_) | Source::System(_)));
        let free: Vec<&Input> = free.collect();
        let Some(port) = free.iter().find(|port| port.name == connection.port) else {
            let names: Vec<&str> = free.iter().map(|port| port.name).collect();
            let way_out = if names.is_empty() {
                "it has none; take another component".to_string()
            } else {
                format!("it has {}", names.join(", "))
            };
            return Err(format!(
                "{} has no port \"{}\" that can be connected; {way_out}",
                connection.component, connection.port
            ));
        };
        let (Source::Axis(name) | Source::System(name)) = port.source else {
            return Ok("1".to_string());
        };
        Ok(self.signal_of(connection.axis, name).map_or_else(|| "1".to_string(), |(_, unit)| unit))
    }

    fn no_signal(&self, connection: &PortSpec) -> String {
        let Some(axis) = self.spec.axes.get(connection.from) else {
            return format!("there is no axis number {}; name one", connection.from + 1);
        };
        let mut names: Vec<&str> = alloc::vec!["command"];
        names.extend(POINTS);
        names.extend(DEMANDED_INPUTS.iter().map(|input| input.name));
        names.extend(self.published(connection.from).map(|(name, _)| name));
        names.dedup();
        let (axis, signal) = (&axis.name, &connection.signal);
        format!("axis {axis} has no signal \"{signal}\"; it has {}", names.join(", "))
    }

    /// Names and units of the outputs that the components of an axis publish.
    fn published(&self, axis: usize) -> impl Iterator<Item = (&'static str, &'static str)> {
        let nodes = self.spec.axes.get(axis).into_iter().flat_map(|axis| &axis.components);
        let outputs = nodes.flat_map(|node| node.component.declaration().outputs);
        outputs.filter_map(|output| output.published.map(|p| (output.name, p.unit)))
    }

    /// Name and unit of a signal of an axis.
    pub(super) fn signal_of(&self, axis: usize, name: &str) -> Option<(&'static str, String)> {
        let spec = self.spec.axes.get(axis)?;
        let motion = self.spec.connections.motion_units.get(axis).cloned().flatten();
        let motion = motion.as_deref().unwrap_or(&spec.position_unit);
        let on_axis = |unit| unit_on_axis(unit, &spec.command_unit, motion);
        let known = match name {
            "command" => Some(("command", spec.command_unit.clone())),
            "voltage" => Some(("voltage", spec.command_unit.clone())),
            "displacement" => Some(("displacement", motion.to_string())),
            "position" => Some(("position", spec.position_unit.clone())),
            _ => None,
        };
        let demanded = || {
            let input = DEMANDED_INPUTS.iter().find(|input| input.name == name)?;
            Some((input.name, unit_on_axis(input.unit, "1", &spec.position_unit)))
        };
        let published = || {
            let (name, unit) = self.published(axis).find(|(known, _)| *known == name)?;
            Some((name, on_axis(unit)))
        };
        known.or_else(demanded).or_else(published)
    }

    /// Axis and signal that a port is connected to.
    pub(super) fn connected(
        &self,
        axis: usize,
        component: &str,
        port: &str,
    ) -> Option<(usize, &'static str)> {
        let mut all = self.spec.connections.ports.iter();
        let found = all.find(|connection| {
            connection.axis == axis && connection.component == component && connection.port == port
        })?;
        Some((found.from, self.signal_of(found.from, &found.signal)?.0))
    }

    /// Whether a connection reads this signal of an axis.
    pub(super) fn is_connected(&self, axis: usize, name: &str) -> bool {
        let mut all = self.spec.connections.ports.iter();
        all.any(|connection| connection.from == axis && connection.signal == name)
    }

    /// Whether a component of the axis publishes this output.
    pub(super) fn publishes(&self, axis: usize, name: &str) -> bool {
        self.published(axis).any(|(known, _)| known == name)
    }
}
