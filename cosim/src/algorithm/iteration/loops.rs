//! Which slaves wait for each other.

use crate::problem::Problem;
use crate::system::System;

/// Slaves that are stepped together: one, or the slaves of a loop in the order of their places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::algorithm) struct Group {
    pub(in crate::algorithm) slaves: Vec<usize>,
    /// Places on the bus of the outputs whose values are guessed: those that feed the slave itself
    /// or one before it. Empty: no loop.
    pub(in crate::algorithm) torn: Vec<usize>,
}

/// The groups, sources before targets.
pub(super) fn groups(system: &System) -> Vec<Group> {
    let n = system.len();
    let mut reaches = vec![vec![false; n]; n];
    let connected = |target: usize| system.sources_of(target).map(move |source| (source, target));
    for (source, target) in (0..n).flat_map(connected) {
        reaches[source][target] = true;
    }
    for via in 0..n {
        let from_via = reaches[via].clone();
        for row in reaches.iter_mut().filter(|row| row[via]) {
            row.iter_mut().zip(&from_via).for_each(|(reaches, further)| *reaches |= further);
        }
    }
    let mut left: Vec<usize> = (0..n).collect();
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
            let source = system.owners.get(wire.from).copied().flatten().and_then(position);
            if source.is_some_and(|source| source >= place) && !torn.contains(&wire.from) {
                torn.push(wire.from);
            }
        }
    }
    torn
}

impl Group {
    pub(in crate::algorithm) fn is_loop(&self) -> bool {
        !self.torn.is_empty()
    }

    pub(super) fn is_due(&self, system: &System) -> bool {
        self.slaves.iter().all(|slave| system.participants[*slave].pace.due)
    }

    /// What keeps a loop from being solved.
    pub(super) fn problems(&self, system: &System) -> Vec<Problem> {
        if !self.is_loop() {
            return Vec::new();
        }
        let mut problems = Vec::new();
        let participants = || self.slaves.iter().map(|slave| &system.participants[*slave]);
        for participant in participants() {
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
        let mut paces = participants().map(|participant| participant.pace.every);
        let first = paces.next();
        if paces.any(|pace| Some(pace) != first) {
            problems.push(Problem::Iteration(format!(
                "the FMUs of the algebraic loop of {} step with different lengths; give them one \
                 step, or use Gauss-Seidel or Jacobi",
                self.names(system)
            )));
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
