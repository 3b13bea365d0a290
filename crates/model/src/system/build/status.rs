//! The output `status` of a controller.

use alloc::collections::BTreeSet;
use alloc::string::String;
use alloc::vec::Vec;

use super::variables::{Units, output_variable};
use super::{Builder, Site};
use crate::{
    Component, DataType, Declaration, Kind, MAX_PORTS, NodeSpec, Sizes, Stage, Tick, Violation,
};

/// Says in one number what a controller does: 0 the loop is open, 1 it is closed, 2 it is closed and
/// a command is at a limit.
struct Status;

static DECLARATION: Declaration = Declaration {
    kind: "status",
    name: "status",
    summary: "What the controller does",
    equation: "status = 0 while disabled, 2 while a command is at a limit, else 1",
    stage: Stage::Control,
    ..Declaration::PATH
};

impl Component for Status {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes::default()
    }

    fn prepare(&self, _: &[f64], _: &[f64], _: f64, _: &mut [f64]) -> Result<(), Violation> {
        Ok(())
    }

    fn rest(&self, _: &[f64], inputs: &[f64], _: &mut [f64], outputs: &mut [f64]) {
        let (Some((enable, limits)), [status]) = (inputs.split_first(), outputs) else { return };
        let at_limit = limits.iter().any(|saturated| *saturated != 0.0);
        *status = if *enable == 0.0 {
            0.0
        } else if at_limit {
            2.0
        } else {
            1.0
        };
    }

    fn step(&self, k: &[f64], state: &mut [f64], _: Tick, inputs: &[f64], outputs: &mut [f64]) {
        self.rest(k, inputs, state, outputs);
    }
}

impl Builder<'_> {
    /// Adds `status` to a controller, behind all its chains.
    pub(super) fn status(&mut self) {
        let enable = self.system_inputs.iter().find(|(name, _)| *name == "enable");
        let (Kind::Controller, Some(&(_, enable))) = (self.spec.kind, enable) else { return };
        let limits = self.published.iter().filter(|(_, name, _)| *name == "saturated");
        let limits: Vec<usize> = limits.map(|(_, _, signal)| *signal).collect();
        // One node reads so many limits; where there are more axes, several are read in turn.
        let mut status = None;
        for limits in limits.chunks(MAX_PORTS - 1) {
            let paths: Vec<usize> =
                core::iter::once(enable).chain(limits.iter().copied()).collect();
            let node = NodeSpec {
                component: crate::ComponentRef::from(&Status as &'static dyn Component),
                name: String::from("status"),
                structure: Vec::new(),
                values: Vec::new(),
                enabled: true,
            };
            let units = Units { command: "1", position: "1" };
            let commands = (f64::NEG_INFINITY, f64::INFINITY);
            let site = Site { axes: &[], paths: &paths, units, commands };
            let signal = self.node(&node, String::from("status"), &site);
            status = status.or(Some(signal));
        }
        let status = status.unwrap_or_else(|| self.signal(BTreeSet::new()));
        let sentence =
            "0 the loop is open, 1 it is closed, 2 it is closed and a command is at a limit";
        let variable = output_variable("status".into(), sentence.into(), "1".into());
        let variable = crate::Variable {
            data_type: DataType::Integer,
            discrete: true,
            unit: String::new(),
            ..variable
        };
        self.outputs.push((variable, status));
    }
}
