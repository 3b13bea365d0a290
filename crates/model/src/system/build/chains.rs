//! The order of the nodes: each axis' chain in the order of its path, and the couplings between them.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use super::variables::Units;
use super::{Builder, Domain, Site, ZERO};
use crate::{AxisSpec, Conversion, Declaration, Kind, NodeSpec, Stage};

/// How far the chain of one axis is built.
pub(super) struct Cursor<'a> {
    /// Index of the axis.
    axis: usize,
    /// The signal on the path.
    pub(super) path: usize,
    domain: Domain,
    /// The next component.
    next: usize,
    /// Couplings ahead: the component in front of which each stands, and its index.
    stops: Vec<(usize, usize)>,
    /// Unit of a position here.
    position_unit: &'a str,
}

impl<'a> Builder<'a> {
    /// Builds all chains: axis by axis, each as far as the next coupling, then the couplings whose
    /// axes are all there.
    pub(super) fn chains(&mut self) {
        let couplings = &self.spec.connections.couplings;
        let mut cursors: Vec<_> = (0..self.spec.axes.len()).map(|a| self.cursor(a)).collect();
        let mut waiting: Vec<usize> =
            (0..couplings.len()).filter(|index| self.coupling_frame(*index)).collect();
        for cursor in &mut cursors {
            cursor.stops.retain(|(_, index)| waiting.contains(index));
        }
        loop {
            for cursor in &mut cursors {
                self.advance(cursor);
            }
            let is_there = |cursor: &Cursor<'_>, index| {
                cursor.stops.first().is_some_and(|(_, coupling)| *coupling == index)
            };
            let ready = waiting.iter().position(|index| {
                couplings[*index].axes.iter().all(|axis| is_there(&cursors[*axis], *index))
            });
            let Some(ready) = ready else { break };
            self.coupling(&mut cursors, waiting.remove(ready));
        }
        for index in waiting {
            let place = coupling_place(&couplings[index].node);
            self.error(
                place,
                "is behind another coupling on one axis and before it on another; correct their \"after\"",
            );
        }
        for cursor in &cursors {
            self.end(cursor);
        }
    }

    fn cursor(&self, axis: usize) -> Cursor<'a> {
        let spec = &self.spec.axes[axis];
        let connections = &self.spec.connections;
        let plant = self.spec.kind == Kind::Plant;
        let entry = if plant { "command" } else { "reference" };
        let mut stops: Vec<(usize, usize)> = Vec::new();
        for (index, coupling) in connections.couplings.iter().enumerate() {
            if coupling.axes.contains(&axis) {
                stops.push((place_of(self.spec.kind, spec, coupling.after.as_deref()), index));
            }
        }
        stops.sort_by_key(|(place, _)| *place);
        let motion = connections.motion_units.get(axis).and_then(Option::as_deref);
        Cursor {
            axis,
            path: self.axis_signal(axis + 1, entry).unwrap_or(ZERO),
            domain: if plant { Domain::Command } else { Domain::Position },
            next: 0,
            stops,
            position_unit: motion.filter(|_| plant).unwrap_or(&spec.position_unit),
        }
    }

    /// Adds the components of an axis up to its next coupling.
    fn advance(&mut self, cursor: &mut Cursor<'a>) {
        let axis = &self.spec.axes[cursor.axis];
        let number = cursor.axis + 1;
        let stop = cursor.stops.first().map_or(usize::MAX, |(place, _)| *place);
        let displaced = place_of(self.spec.kind, axis, None);
        while cursor.next < axis.components.len().min(stop) {
            let at = cursor.next;
            let node = &axis.components[at];
            let place = format!("axis[{number}].{}", node.name);
            if axis.components[..at].iter().any(|other| other.name == node.name) {
                self.error(
                    &place,
                    "the name is used twice on this axis; give each component its own",
                );
            }
            let declaration = node.component.declaration();
            if declaration.is_coupling() {
                let way = "put it in a [[coupling]] section";
                self.error(&place, format!("{} is no part of one axis; {way}", declaration.kind));
            }
            let before = cursor.path;
            let domain = self.domain_after(cursor.domain, declaration, &place, &mut cursor.path);
            if domain != cursor.domain && domain == Domain::Position {
                self.ends[cursor.axis].signals.push(("voltage", before));
            }
            cursor.domain = domain;
            let units = Units { command: &axis.command_unit, position: cursor.position_unit };
            let commands = axis.command_range;
            let site = Site { axes: &[cursor.axis], paths: &[cursor.path], units, commands };
            cursor.path = self.node(node, place, &site);
            self.replace(declaration, cursor.axis, cursor.path, 1);
            cursor.next += 1;
            if cursor.next == displaced {
                self.ends[cursor.axis].signals.push(("displacement", cursor.path));
            }
        }
    }

    fn coupling(&mut self, cursors: &mut [Cursor<'a>], index: usize) {
        let coupling = &self.spec.connections.couplings[index];
        let place = coupling_place(&coupling.node);
        let declaration = coupling.node.component.declaration();
        let paths: Vec<usize> = coupling.axes.iter().map(|axis| cursors[*axis].path).collect();
        let Some(&first) = coupling.axes.first() else { return };
        let units = |cursor: &Cursor<'a>| {
            (&*self.spec.axes[cursor.axis].command_unit, cursor.position_unit)
        };
        let (command, motion) = units(&cursors[first]);
        for axis in &coupling.axes {
            if units(&cursors[*axis]) != (command, motion) {
                let (own_command, own) = units(&cursors[*axis]);
                let (one, other) = (&self.spec.axes[first].name, &self.spec.axes[*axis].name);
                self.error(
                    &place,
                    format!(
                        "axis {one} has {command} and {motion}, axis {other} {own_command} and {own}; \
                         give the axes that it couples the same units"
                    ),
                );
            }
            if cursors[*axis].domain != Domain::Position {
                let name = &self.spec.axes[*axis].name;
                self.error(&place, format!("couples positions, but the signal of axis {name} is still a command there; put it behind the component that turns the command into a position"));
            }
        }
        let position = &*self.spec.axes[first].position_unit;
        let motions = &self.spec.connections.motion_units;
        let motion_of = |axis: usize| motions.get(axis).and_then(Option::as_deref);
        let conversion = declaration.conversion;
        let units = match conversion {
            // {position} is behind it, {command} the motion in front of it.
            Conversion::MotionToPosition => Units { command: motion, position },
            Conversion::PositionToMotion => {
                Units { command: motion_of(first).unwrap_or(position), position }
            }
            _ => Units { command, position: motion },
        };
        let commands = self.spec.axes[first].command_range;
        let site = Site { axes: &coupling.axes, paths: &paths, units, commands };
        let output = self.node(&coupling.node, place, &site);
        for (port, axis) in coupling.axes.iter().enumerate() {
            let cursor = &mut cursors[*axis];
            cursor.path = output + port;
            cursor.stops.remove(0);
            let position = &*self.spec.axes[*axis].position_unit;
            match conversion {
                Conversion::MotionToPosition => cursor.position_unit = position,
                Conversion::PositionToMotion => {
                    cursor.position_unit = motion_of(*axis).unwrap_or(position);
                }
                _ => {}
            }
            self.replace(declaration, *axis, output + port, coupling.axes.len());
        }
    }

    /// Puts outputs of a controller's component in the place of the axis' signals of their names; `first`
    /// is the axis' first output, its others follow at this distance.
    fn replace(&mut self, declaration: &Declaration, axis: usize, first: usize, distance: usize) {
        if self.spec.kind == Kind::Plant {
            return;
        }
        let others = declaration.outputs.iter().enumerate().skip(1);
        for (at, output) in others.filter(|(_, output)| output.published.is_none()) {
            for (name, signal) in &mut self.ends[axis].signals {
                if *name == output.name {
                    *signal = first + at * distance;
                }
            }
        }
    }

    /// Whether a coupling names axes that there are and a component that they have.
    fn coupling_frame(&mut self, index: usize) -> bool {
        let spec = self.spec;
        let coupling = &spec.connections.couplings[index];
        let declaration = coupling.node.component.declaration();
        let place = coupling_place(&coupling.node);
        let before = self.errors.len();
        let earlier = &spec.connections.couplings[..index];
        if earlier.iter().any(|other| other.node.name == coupling.node.name) {
            self.error(&place, "the name is used twice; give each coupling its own");
        }
        let coordinates = declaration.conversion == Conversion::PositionToMotion;
        if coordinates != (spec.kind == Kind::Controller) {
            let message = if coordinates {
                "turns positions into motions; it belongs in a controller"
            } else {
                "couples the axes of a machine; a controller has jacobian-coordinator instead, or nothing"
            };
            self.error(&place, message);
        }
        if !declaration.is_coupling() {
            let kind = declaration.kind;
            self.error(
                &place,
                format!("{kind} is part of one axis; put it in an [[axis.component]] section"),
            );
        }
        let count = coupling.axes.len();
        let (least, most) = (declaration.least_axes(), declaration.most_axes());
        if !(least..=most).contains(&count) {
            self.error(&place, format!("{count} axes; it couples {least} to {most}"));
        }
        for (at, axis) in coupling.axes.iter().enumerate() {
            if coupling.axes[..at].contains(axis) || *axis >= spec.axes.len() {
                let number = axis + 1;
                self.error(
                    &place,
                    format!("axis number {number} is unknown or named twice; name each axis once"),
                );
            } else if let Some(after) = &coupling.after
                && !spec.axes[*axis].components.iter().any(|node| node.name == *after)
            {
                let name = &spec.axes[*axis].name;
                self.error(
                    format!("{place}.after"),
                    format!("axis {name} has no component \"{after}\"; name one that every coupled axis has"),
                );
            }
        }
        self.errors.len() == before
    }

    /// The end of an axis' chain.
    fn end(&mut self, cursor: &Cursor<'_>) {
        let axis = &self.spec.axes[cursor.axis];
        let number = cursor.axis + 1;
        let plant = self.spec.kind == Kind::Plant;
        let wanted = if plant { Domain::Position } else { Domain::Command };
        if cursor.domain != wanted {
            let way = if plant {
                "add a component that turns the command into a position (a hysteresis model or \
                 actuator-gain)"
            } else {
                "add a component that gives a command (an inverse model or pid)"
            };
            self.error(
                format!("axis[{number}]"),
                format!("the chain ends with the wrong signal: {way}"),
            );
        }
        if plant && cursor.position_unit != axis.position_unit {
            let unit = cursor.position_unit;
            self.error(
                format!("axis[{number}]"),
                format!("the motion in {unit} is never turned into a position in {}; add a coupling that does it, or give both the same unit", axis.position_unit),
            );
        }
        let motion = self.spec.connections.motion_units.get(cursor.axis).and_then(Option::as_deref);
        if let Some(unit) = motion.filter(|unit| !plant && cursor.position_unit != *unit) {
            let message = format!(
                "the position in {} is never turned into a motion in {unit}; add a \
                 jacobian-coordinator that names this axis, or leave motion out",
                axis.position_unit
            );
            self.error(format!("axis[{number}]"), message);
        }
        let signals = &mut self.ends[cursor.axis].signals;
        if plant {
            if !signals.iter().any(|(name, _)| *name == "displacement") {
                signals.push(("displacement", cursor.path));
            }
            signals.push(("position", cursor.path));
        }
        self.exit(axis, number, cursor.path);
    }

    fn domain_after(
        &mut self,
        domain: Domain,
        declaration: &Declaration,
        place: &str,
        path: &mut usize,
    ) -> Domain {
        match (declaration.conversion, domain) {
            (Conversion::None | Conversion::MotionToPosition | Conversion::PositionToMotion, _) => {
                domain
            }
            (Conversion::CommandToPosition, Domain::Command) => Domain::Position,
            (Conversion::PositionToCommand, Domain::Position) => Domain::Command,
            (Conversion::Control, Domain::Position) => {
                *path = ZERO;
                Domain::Command
            }
            (Conversion::Control, Domain::Command) => Domain::Command,
            (Conversion::CommandToPosition, Domain::Position) => {
                let kind = declaration.kind;
                self.error(place, format!("{kind} takes a command, but the signal is a position here; an axis turns one into the other once"));
                domain
            }
            (Conversion::PositionToCommand, Domain::Command) => {
                let kind = declaration.kind;
                self.error(place, format!("{kind} takes a position, but the signal is a command here; an axis turns one into the other once"));
                domain
            }
        }
    }
}

/// The place of a coupling in names and messages.
fn coupling_place(node: &NodeSpec) -> String {
    format!("coupling.{}", node.name)
}

/// The index behind the component `after`, by default behind the last one up to the mechanics, in a
/// controller in front of all.
fn place_of(kind: Kind, axis: &AxisSpec, after: Option<&str>) -> usize {
    let is_last = |node: &NodeSpec| match after {
        Some(name) => node.name == name,
        None => kind == Kind::Plant && node.component.declaration().stage <= Stage::Mechanics,
    };
    axis.components.iter().rposition(is_last).map_or(0, |at| at + 1)
}
