//! Initialization: values go along the connections until inputs and outputs agree.
//!
//! FMI 2.0.5 §4.2.4 and FMI 3.0 §2.3.3: in Initialization Mode outputs follow inputs at once, as the
//! dependencies of the initial unknowns say, and the importer passes them on. So an output is read
//! once the outputs that feed the inputs it depends on are known; where outputs depend on each other
//! in a circle, the circle is iterated. How the slaves step later does not matter.

use modeldescription::ModelDescription;
use modeldescription::variable::{Initial, Variable};

use super::iteration::{Group, Iteration};
use crate::error::Error;
use crate::slave::Address;
use crate::system::System;

/// A connected output.
struct Output {
    slave: usize,
    /// Its place on the bus.
    place: usize,
    /// Number of each output that it depends on, and the place where the wire begins.
    needs: Vec<(usize, usize)>,
}

/// Sets all inputs and reads all connected outputs, the slaves of a circle in this order.
///
/// # Errors
/// Whatever a slave says; a circle without a solution, where `is_strict`. Else such a circle begins
/// with what one pass through it gives, and the system notes it.
pub(super) fn settle(
    system: &mut System,
    order: &[usize],
    iteration: &Iteration,
    is_strict: bool,
) -> Result<(), Error> {
    for group in groups(system, order) {
        let once = |system: &mut System| {
            group.slaves.iter().try_for_each(|slave| system.feed_through(*slave))
        };
        if !group.is_loop() {
            once(system)?;
            continue;
        }
        let begin: Vec<f64> = group.torn.iter().map(|place| system.bus[*place]).collect();
        match iteration.solve(&group, system, |system, _| once(system)) {
            Err(Error::Loop { variables, .. }) if !is_strict => {
                for (place, value) in group.torn.iter().zip(begin) {
                    system.bus[*place] = value;
                }
                once(system)?;
                system.unsolved.push(variables);
            }
            outcome => outcome?,
        }
    }
    order.iter().try_for_each(|slave| system.transfer(*slave))
}

/// Outputs that are known together, sources before targets.
fn groups(system: &System, order: &[usize]) -> Vec<Group> {
    let outputs = outputs(system, order);
    let reaches: Vec<Vec<bool>> = (0..outputs.len()).map(|from| reach(&outputs, from)).collect();
    let rank = |output: usize| order.iter().position(|slave| *slave == outputs[output].slave);
    let mut left: Vec<usize> = (0..outputs.len()).collect();
    let mut groups = Vec::new();
    // The first output that needs nothing of what is left but its own circle.
    let free = |left: &[usize]| {
        let waits = |o: usize| left.iter().any(|other| reaches[o][*other] && !reaches[*other][o]);
        left.iter().copied().find(|output| !waits(*output))
    };
    while let Some(first) = free(&left) {
        let together =
            |other: &usize| *other == first || (reaches[first][*other] && reaches[*other][first]);
        let members: Vec<usize> = left.iter().copied().filter(together).collect();
        left.retain(|output| !members.contains(output));
        let (mut slaves, mut torn) = (Vec::new(), Vec::new());
        for target in &members {
            if !slaves.contains(&outputs[*target].slave) {
                slaves.push(outputs[*target].slave);
            }
            for (source, place) in &outputs[*target].needs {
                let is_back = members.contains(source) && rank(*source) >= rank(*target);
                if is_back && !torn.contains(place) {
                    torn.push(*place);
                }
            }
        }
        groups.push(Group { slaves, torn });
    }
    groups
}

/// The connected outputs, in the order of the slaves, and what they need.
fn outputs(system: &System, order: &[usize]) -> Vec<Output> {
    let mut outputs: Vec<Output> = Vec::new();
    for slave in order {
        let places = &system.participants[*slave].outputs.places;
        outputs.extend(places.iter().map(|place| Output {
            slave: *slave,
            place: *place,
            needs: Vec::new(),
        }));
    }
    let mut needs = Vec::with_capacity(outputs.len());
    for slave in order {
        let participant = &system.participants[*slave];
        let description = participant.slave.description();
        let variable =
            |name: &String| Address::find("", description, name).ok().map(|a| a.variable);
        // Inputs that outputs feed: the variable, the output, the place where the wire begins.
        let mut fed = Vec::new();
        for (name, wire) in participant.driven.names().iter().zip(&participant.wires) {
            let source = outputs.iter().position(|output| {
                let seen = system.participants[output.slave].pace.seen(wire.from);
                output.place == wire.from || seen == Some(output.place)
            });
            if let (Some(input), Some(source)) = (variable(name), source) {
                fed.push((input, source, wire.from));
            }
        }
        for name in participant.outputs.selection.names() {
            let output = variable(name);
            let depends = |input: &Variable| {
                output.as_ref().is_none_or(|output| depends(description, output, input))
            };
            let of = fed.iter().filter(|(input, ..)| depends(input));
            needs.push(of.map(|(_, source, place)| (*source, *place)).collect());
        }
    }
    outputs.iter_mut().zip(needs).for_each(|(output, needs)| output.needs = needs);
    outputs
}

/// Whether an output depends on an input at initialization; where nothing is stated, it may.
fn depends(description: &ModelDescription, output: &Variable, input: &Variable) -> bool {
    let is = |reference: u32, variable: &Variable| {
        description.referenced(reference).is_some_and(|found| {
            found.value_reference == variable.value_reference
                && found.data_type == variable.data_type
        })
    };
    let unknowns = &description.structure.initial_unknowns;
    match unknowns.iter().find(|unknown| is(unknown.variable, output)) {
        Some(unknown) => match &unknown.dependencies {
            Some(knowns) => knowns.iter().any(|known| is(*known, input)),
            None => true,
        },
        None => output.initial(description.fmi_version) != Some(Initial::Exact),
    }
}

/// The outputs that one needs, at first or second hand.
fn reach(outputs: &[Output], from: usize) -> Vec<bool> {
    let mut reached = vec![false; outputs.len()];
    let mut open = vec![from];
    while let Some(at) = open.pop() {
        for (source, _) in &outputs[at].needs {
            if !std::mem::replace(&mut reached[*source], true) {
                open.push(*source);
            }
        }
    }
    reached
}
