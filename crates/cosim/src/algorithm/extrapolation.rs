//! Jacobi with inputs that move on straight lines.

use std::cell::RefCell;

use modeldescription::FmiVersion;
use modeldescription::variable::DataType;

use super::{Algorithm, Jacobi};
use crate::error::Error;
use crate::problem::{Problem, Problems};
use crate::slave::Selection;
use crate::system::{Participant, System};
use crate::unit::Conversion;

/// Steps all slaves side by side like [`Jacobi`], but an input that is fed by an output moves over
/// the step on a straight line,
/// `u(t) = y(t_k) + y'(t_k)·(t − t_k)`, with the slope that the output's FMU states
/// (`fmi2GetRealOutputDerivatives` → `fmi2SetRealInputDerivatives`, order 1). The error of a smooth
/// signal over a step h falls from O(h) to O(h²); at jumps of the output it is larger than that of
/// Jacobi (FMI 2.0.5 §4.2.2).
///
/// It acts on connections whose source states `maxOutputDerivativeOrder` of 1 or more, and whose
/// target states `canInterpolateInputs`; both of FMI 2.0, with the communication step as their own.
/// All other inputs are held.
#[derive(Debug)]
pub struct Extrapolation {
    sources: Vec<Outputs>,
    targets: Vec<Inputs>,
    work: RefCell<Work>,
}

/// Outputs of one slave whose slopes are asked for.
#[derive(Debug)]
struct Outputs {
    slave: usize,
    selection: Selection,
    /// Place of the first slope.
    first: usize,
}

/// Inputs of one slave that get slopes.
#[derive(Debug)]
struct Inputs {
    slave: usize,
    selection: Selection,
    /// Place of the slope and what converts it.
    from: Vec<(usize, f64)>,
}

#[derive(Debug, Default)]
struct Work {
    slopes: Vec<f64>,
    values: Vec<f64>,
}

impl Extrapolation {
    /// Finds the connections on which it acts.
    ///
    /// # Errors
    /// There is no such connection.
    pub fn new(system: &System) -> Result<Self, Problems> {
        // Per connection: source, its variable, target, its variable, factor of the conversion.
        let mut found = Vec::new();
        for (target, fed) in system.participants.iter().enumerate() {
            for (input, wire) in fed.driven.names().iter().zip(&fed.wires) {
                let Some(source) = system.owners.get(wire.from).copied().flatten() else {
                    continue;
                };
                let giver = &system.participants[source];
                let Some(output) = giver.output_at(wire.from) else { continue };
                let is_smooth = interpolates(fed) && is_real(fed, input);
                if is_smooth && states_slopes(giver) && is_real(giver, output) {
                    let factor = match wire.conversion {
                        Conversion::Same => 1.0,
                        Conversion::Linear { factor, .. } => factor,
                    };
                    found.push((source, output.to_owned(), target, input.clone(), factor));
                }
            }
        }
        if found.is_empty() {
            return Err(Problems(vec![Problem::NoSlopes]));
        }
        let mut outputs: Vec<(usize, &str)> = Vec::new();
        for (source, output, ..) in &found {
            if !outputs.contains(&(*source, output)) {
                outputs.push((*source, output));
            }
        }
        outputs.sort_by_key(|(source, _)| *source);
        let select = |slave: usize, names: &[&str]| {
            let description = system.participants[slave].slave.description();
            Selection::of(description, names).map_err(|_| Problems(vec![Problem::NoSlopes]))
        };
        let (mut sources, mut targets) = (Vec::new(), Vec::new());
        for slave in 0..system.len() {
            let own = outputs.iter().filter(|(source, _)| *source == slave);
            let names: Vec<&str> = own.map(|(_, name)| *name).collect();
            if let Some(first) = outputs.iter().position(|(source, _)| *source == slave) {
                sources.push(Outputs { slave, selection: select(slave, &names)?, first });
            }
            let (mut inputs, mut from) = (Vec::new(), Vec::new());
            for (source, output, target, input, factor) in &found {
                let place = outputs.iter().position(|o| *o == (*source, output.as_str()));
                if let (true, Some(place)) = (*target == slave, place) {
                    inputs.push(input.as_str());
                    from.push((place, *factor));
                }
            }
            if !inputs.is_empty() {
                targets.push(Inputs { slave, selection: select(slave, &inputs)?, from });
            }
        }
        let work = Work { slopes: vec![0.0; outputs.len()], values: Vec::new() };
        Ok(Extrapolation { sources, targets, work: RefCell::new(work) })
    }

    /// Number of connections on which it acts.
    pub fn connections(&self) -> usize {
        self.targets.iter().map(|inputs| inputs.from.len()).sum()
    }
}

/// Whether a slave takes slopes of inputs.
fn interpolates(participant: &Participant) -> bool {
    let description = participant.slave.description();
    let offers = description.co_simulation.as_ref().is_some_and(|cs| cs.can_interpolate_inputs);
    offers && description.fmi_version == FmiVersion::V2 && participant.pace.every == 1
}

/// Whether a slave gives slopes of outputs.
fn states_slopes(participant: &Participant) -> bool {
    let description = participant.slave.description();
    let offers =
        description.co_simulation.as_ref().is_some_and(|cs| cs.max_output_derivative_order > 0);
    offers && description.fmi_version == FmiVersion::V2 && participant.pace.every == 1
}

fn is_real(participant: &Participant, name: &str) -> bool {
    let variable = participant.slave.description().variable(name);
    variable.is_some_and(|variable| variable.data_type == DataType::Float64)
}

impl Algorithm for Extrapolation {
    fn step(&self, system: &mut System, time: f64, step: f64) -> Result<(), Error> {
        let mut work = self.work.borrow_mut();
        let Work { slopes, values } = &mut *work;
        for Outputs { slave, selection, first } in &self.sources {
            let slopes = &mut slopes[*first..][..selection.len()];
            system.participants[*slave].slave.output_slopes(selection, slopes)?;
        }
        for Inputs { slave, selection, from } in &self.targets {
            values.clear();
            values.extend(from.iter().map(|(place, factor)| slopes[*place] * factor));
            system.participants[*slave].slave.set_input_slopes(selection, values)?;
        }
        Jacobi.step(system, time, step)
    }
}
