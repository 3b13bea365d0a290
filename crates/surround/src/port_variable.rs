//! Whole variables of the original that have ports.

use crate::repair::Port;

/// A whole variable of the original, or of the repair, that has ports.
#[derive(Clone, Debug)]
pub struct PortVariable {
    /// Value reference.
    pub reference: u32,
    /// Whether the original does not have it.
    pub own: bool,
    pub(crate) start: Vec<f64>,
    /// As the host sees it.
    pub shown: Vec<f64>,
    /// As the original sees it.
    pub inner: Vec<f64>,
    /// Numbers of its ports.
    pub(crate) ports: Vec<usize>,
}

impl PortVariable {
    pub(crate) fn new(reference: u32, start: &[f64], own: bool) -> Self {
        Self {
            reference,
            own,
            start: start.to_vec(),
            shown: start.to_vec(),
            inner: start.to_vec(),
            ports: Vec::new(),
        }
    }
}

/// The variables of these ports, each once.
pub(crate) fn port_variables(ports: &[Port]) -> Vec<PortVariable> {
    let mut all: Vec<PortVariable> = Vec::new();
    for (k, port) in ports.iter().enumerate() {
        let at = all.iter().position(|v| v.reference == port.variable.reference);
        let at = at.unwrap_or_else(|| {
            all.push(PortVariable::new(port.variable.reference, &port.variable.start, port.own));
            all.len() - 1
        });
        all[at].ports.push(k);
    }
    all
}
