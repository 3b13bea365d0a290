//! Which slaves wait for each other.

use crate::problem::Problem;
use crate::system::System;

/// Slaves that are stepped together: one, or the slaves of a loop in the order of their places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Group {
    pub(super) slaves: Vec<usize>,
    /// Places on the bus of the outputs whose values are guessed: those that feed the slave itself
    /// or one before it. Empty: no loop.
    pub(super) torn: Vec<usize>,
}

/// The slaves of a group whose steps end together, as far as they wait for each other.
#[derive(Debug)]
pub(super) struct Meeting {
    /// Number of the group.
    pub(super) group: usize,
    /// For each slave of the group, whether its step ends.
    due: Vec<bool>,
    pub(super) parts: Vec<Group>,
}

impl Meeting {
    /// Of those slaves of a group that are due now.
    pub(super) fn new(number: usize, group: &Group, system: &System) -> Self {
        let due: Vec<bool> = group.due(system).collect();
        let slaves = group.slaves.iter().zip(&due).filter_map(|(slave, due)| due.then_some(*slave));
        Meeting { group: number, parts: groups_among(system, slaves.collect()), due }
    }

    pub(super) fn is_now(&self, group: &Group, system: &System) -> bool {
        group.due(system).eq(self.due.iter().copied())
    }
}

/// By slave, whether it is in a group with different steps or fed by one, at whatever distance.
pub(super) fn late(system: &System, groups: &[Group]) -> Vec<bool> {
    let mut late = vec![false; system.len()];
    for group in groups {
        let mut sources = group.slaves.iter().flat_map(|slave| system.sources_of(*slave));
        if group.has_different_steps(system) || sources.any(|source| late[source]) {
            group.slaves.iter().for_each(|slave| late[*slave] = true);
        }
    }
    late
}

/// The groups, sources before targets.
pub(super) fn groups(system: &System) -> Vec<Group> {
    groups_among(system, (0..system.len()).collect())
}

/// The groups among some slaves, as if the others gave constants.
fn groups_among(system: &System, among: Vec<usize>) -> Vec<Group> {
    let n = system.len();
    let mut reaches = vec![vec![false; n]; n];
    let connected = |target: usize| system.sources_of(target).map(move |source| (source, target));
    for (source, target) in among.iter().copied().flat_map(connected) {
        reaches[source][target] = among.contains(&source);
    }
    for via in 0..n {
        let from_via = reaches[via].clone();
        for row in reaches.iter_mut().filter(|row| row[via]) {
            row.iter_mut().zip(&from_via).for_each(|(reaches, further)| *reaches |= further);
        }
    }
    let mut left = among;
    let mut groups = Vec::new();
    // The first slave that nobody outside its own loop and still left feeds.
    let free = |left: &[usize]| {
        let waits = |s: usize| left.iter().any(|o| reaches[*o][s] && !reaches[s][*o]);
        left.iter().copied().find(|slave| !waits(*slave))
    };
    while let Some(first) = free(&left) {
        let together =
            |slave: &usize| *slave == first || (reaches[first][*slave] && reaches[*slave][first]);
        let slaves: Vec<usize> = left.iter().copied().filter(together).collect();
        left.retain(|slave| !slaves.contains(slave));
        let torn = torn(system, &slaves);
        groups.push(Group { slaves, torn });
    }
    groups
}

fn torn(system: &System, slaves: &[usize]) -> Vec<usize> {
    let position = |slave: usize| slaves.iter().position(|there| *there == slave);
    let mut torn = Vec::new();
    for (place, target) in slaves.iter().enumerate() {
        for wire in &system.participants[*target].wires {
            let Some(source) = system.owners.get(wire.from).copied().flatten() else { continue };
            // What a slow slave has reached is what others are given here, whoever ran before.
            let from = system.participants[source].pace.seen(wire.from).unwrap_or(wire.from);
            if position(source).is_some_and(|source| source >= place) && !torn.contains(&from) {
                torn.push(from);
            }
        }
    }
    torn
}

impl Group {
    pub(super) fn is_loop(&self) -> bool {
        !self.torn.is_empty()
    }

    /// Whether each slave steps now.
    fn due(&self, system: &System) -> impl Iterator<Item = bool> {
        self.slaves.iter().map(|slave| system.participants[*slave].pace.due)
    }

    pub(super) fn is_due(&self, system: &System) -> bool {
        self.due(system).all(|due| due)
    }

    fn has_different_steps(&self, system: &System) -> bool {
        let mut paces = self.slaves.iter().map(|slave| system.participants[*slave].pace.every);
        let first = paces.next();
        paces.any(|pace| Some(pace) != first)
    }

    /// What keeps a loop from being solved.
    pub(super) fn problems(&self, system: &System) -> Vec<Problem> {
        if !self.is_loop() {
            return Vec::new();
        }
        let mut problems = Vec::new();
        for participant in self.slaves.iter().map(|slave| &system.participants[*slave]) {
            let common = participant.slave.description().co_simulation.as_ref();
            if !common.is_some_and(|cs| cs.common.can_get_and_set_fmu_state) {
                problems.push(Problem::Iteration(format!(
                    "FMU `{}` is in the algebraic loop of {}, which needs its state to be rolled \
                     back, but its model description does not state canGetAndSetFMUstate; use \
                     Gauss-Seidel or Jacobi",
                    participant.slave.name(),
                    self.names(system)
                )));
            }
        }
        problems
    }

    /// The guessed outputs, for messages.
    pub(super) fn names(&self, system: &System) -> String {
        let names: Vec<String> = (0..self.torn.len()).map(|i| self.name(system, i)).collect();
        names.join(", ")
    }

    pub(super) fn name(&self, system: &System, torn: usize) -> String {
        let place = self.torn.get(torn).copied().unwrap_or(usize::MAX);
        let found = self.slaves.iter().find_map(|slave| {
            let participant = &system.participants[*slave];
            let output = participant.output_at(place)?;
            Some(format!("`{output}` of FMU `{}`", participant.slave.name()))
        });
        found.unwrap_or_default()
    }
}
