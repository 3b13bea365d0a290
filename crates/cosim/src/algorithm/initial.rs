//! Initialization: values go along the connections until inputs and outputs agree.
//!
//! FMI 2.0.5 §4.2.4 and FMI 3.0 §2.3.3: in Initialization Mode outputs follow inputs at once, as the
//! dependencies of the initial unknowns say, and the importer passes them on. So an output is read
//! once the outputs that feed the inputs it depends on are known; where outputs depend on each other
//! in a circle, the circle is iterated. How the slaves step later does not matter.

use std::collections::{BTreeSet, HashMap, HashSet};

use modeldescription::variable::{DataType, Initial, Variable};
use modeldescription::{FmiVersion, ModelDescription};

use super::loops::Group;
use super::solver::Solver;
use crate::error::Error;
use crate::slave::Index;
use crate::system::System;

/// A connected output.
struct Output {
    slave: usize,
    /// The output's place on the bus.
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
    solver: &Solver,
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
        match solver.solve(&group, system, |system, _| once(system)) {
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

/// Outputs that are known together, sources before targets: of those that wait for nothing any more, the
/// one that comes first.
fn groups(system: &System, order: &[usize]) -> Vec<Group> {
    let outputs = outputs(system, order);
    let ranks: HashMap<usize, usize> = order.iter().copied().zip(0..).collect();
    let rank = |output: usize| ranks.get(&outputs[output].slave).copied();
    let of = circles(&outputs);
    let count = of.iter().max().map_or(0, |most| most + 1);
    let mut members = vec![Vec::new(); count];
    of.iter().enumerate().for_each(|(output, circle)| members[*circle].push(output));
    let mut feeds = vec![HashSet::new(); count];
    let mut waits = vec![0_usize; count];
    for (target, output) in outputs.iter().enumerate() {
        for (source, _) in &output.needs {
            let (from, to) = (of[*source], of[target]);
            if from != to && feeds[from].insert(to) {
                waits[to] += 1;
            }
        }
    }
    // By their first members, which are in ascending order.
    let first = |circle: usize| (members[circle].first().copied(), circle);
    let mut free: BTreeSet<(Option<usize>, usize)> =
        (0..count).filter(|circle| waits[*circle] == 0).map(first).collect();
    let mut groups = Vec::with_capacity(count);
    while let Some((_, circle)) = free.pop_first() {
        for target in &feeds[circle] {
            waits[*target] -= 1;
            if waits[*target] == 0 {
                free.insert(first(*target));
            }
        }
        let (mut slaves, mut torn) = (Vec::new(), Vec::new());
        for target in &members[circle] {
            if !slaves.contains(&outputs[*target].slave) {
                slaves.push(outputs[*target].slave);
            }
            for (source, place) in &outputs[*target].needs {
                let is_back = of[*source] == circle && rank(*source) >= rank(*target);
                if is_back && !torn.contains(place) {
                    torn.push(*place);
                }
            }
        }
        groups.push(Group { slaves, torn });
    }
    groups
}

/// The circle that each output is in, by number: outputs that need each other, at first or second hand
/// (Tarjan 1972, with a stack of its own as chains may be long).
fn circles(outputs: &[Output]) -> Vec<usize> {
    const NONE: usize = usize::MAX;
    let mut number = vec![NONE; outputs.len()];
    let mut lowest = vec![NONE; outputs.len()];
    let mut circle = vec![NONE; outputs.len()];
    let (mut counted, mut found) = (0, 0);
    let mut open = Vec::new();
    for root in 0..outputs.len() {
        if number[root] != NONE {
            continue;
        }
        // Output, and how many of its needs have been looked at.
        let mut path = vec![(root, 0)];
        while let Some((at, next)) = path.pop() {
            if next == 0 {
                (number[at], lowest[at]) = (counted, counted);
                counted += 1;
                open.push(at);
            }
            match outputs[at].needs.get(next) {
                Some((need, _)) => {
                    path.push((at, next + 1));
                    if number[*need] == NONE {
                        path.push((*need, 0));
                    } else if circle[*need] == NONE {
                        lowest[at] = lowest[at].min(number[*need]);
                    }
                }
                None => {
                    if let Some((before, _)) = path.last() {
                        lowest[*before] = lowest[*before].min(lowest[at]);
                    }
                    if lowest[at] == number[at] {
                        while let Some(member) = open.pop() {
                            circle[member] = found;
                            if member == at {
                                break;
                            }
                        }
                        found += 1;
                    }
                }
            }
        }
    }
    circle
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
    // By place on the bus: what is reached, and, of a slow slave, what is seen of it.
    let mut at_place = HashMap::new();
    for (number, output) in outputs.iter().enumerate() {
        at_place.entry(output.place).or_insert(number);
    }
    let source_at = |place: usize| {
        let owner = system.owners.get(place).copied().flatten()?;
        let reached = system.participants[owner].pace.seen(place);
        reached.and_then(|place| at_place.get(&place)).or_else(|| at_place.get(&place)).copied()
    };
    let index = Index::default();
    let mut needs = Vec::with_capacity(outputs.len());
    for slave in order {
        let participant = &system.participants[*slave];
        if participant.outputs.places.is_empty() {
            continue;
        }
        let description = participant.slave.description();
        let variable = |name: &String| index.find("", description, name).ok().map(|a| a.variable);
        let unknowns = Unknowns::of(description);
        // Inputs that outputs feed: the variable, the output, the place where the wire begins.
        let mut fed = Vec::new();
        for (name, wire) in participant.driven.names().iter().zip(&participant.wires) {
            if let (Some(input), Some(source)) = (variable(name), source_at(wire.from)) {
                fed.push((input, source, wire.from));
            }
        }
        for name in participant.outputs.selection.names() {
            let output = variable(name);
            let depends = |input: &Variable| {
                output.as_ref().is_none_or(|output| unknowns.depends(output, input))
            };
            let of = fed.iter().filter(|(input, ..)| depends(input));
            needs.push(of.map(|(_, source, place)| (*source, *place)).collect());
        }
    }
    outputs.iter_mut().zip(needs).for_each(|(output, needs)| output.needs = needs);
    outputs
}

/// Value reference and type of a variable.
type Key = (u32, DataType);

/// What the initial unknowns of a description depend on.
struct Unknowns<'a> {
    description: &'a ModelDescription,
    /// None: on everything.
    dependencies: HashMap<Key, Option<HashSet<Key>>>,
}

impl<'a> Unknowns<'a> {
    fn of(description: &'a ModelDescription) -> Self {
        let key = |variable: &Variable| (variable.value_reference, variable.data_type);
        let by_reference: HashMap<u32, Key> = match description.fmi_version {
            FmiVersion::V2 => (1..).zip(description.variables.iter().map(key)).collect(),
            FmiVersion::V3 => {
                let all = description.variables.iter().rev();
                all.map(|variable| (variable.value_reference, key(variable))).collect()
            }
        };
        let mut dependencies = HashMap::new();
        for unknown in &description.structure.initial_unknowns {
            let Some(variable) = by_reference.get(&unknown.variable) else { continue };
            let knowns = unknown.dependencies.as_ref().map(|knowns| {
                knowns.iter().filter_map(|known| by_reference.get(known).copied()).collect()
            });
            dependencies.entry(*variable).or_insert(knowns);
        }
        Unknowns { description, dependencies }
    }

    /// Whether an output depends on an input at initialization; where nothing is stated, it may.
    fn depends(&self, output: &Variable, input: &Variable) -> bool {
        match self.dependencies.get(&(output.value_reference, output.data_type)) {
            Some(Some(knowns)) => knowns.contains(&(input.value_reference, input.data_type)),
            Some(None) => true,
            None => output.initial(self.description.fmi_version) != Some(Initial::Exact),
        }
    }
}
