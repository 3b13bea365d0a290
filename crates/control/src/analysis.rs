//! A plant taken apart: the path of each axis up to its couplings, the couplings, and what stands behind them.

use data::CheckedBlueprint;
use identify::{Error, NotInvertible, simulate_axes};
use model::{AxisSpec, NodeSpec};

use crate::coupling::{self, AS_GIVEN, Group};
use crate::feedforward::obstacle;
use crate::linearised::{impulse_response, varied};
use crate::path::{Nature, Part, Path, WAY, at_rest, parts_behind, steps_of};

/// Least time of one way over the range in mean lags and in periods.
const LONG: (f64, f64) = (20.0, 20.0);
/// Time at a bound in mean lags, until the position is there.
const WAITS: f64 = 5.0;

/// All axes.
pub(crate) struct Analysed {
    pub(crate) paths: Vec<Path>,
    /// Behind the couplings.
    pub(crate) outer: Vec<Vec<Part>>,
    pub(crate) groups: Vec<Group>,
    /// Of each axis, what is left to feedback behind the couplings.
    pub(crate) left: Vec<Vec<String>>,
}

/// Takes a plant apart.
///
/// # Errors
/// Every reason why it cannot be controlled.
pub(crate) fn analyse(
    plant: &CheckedBlueprint,
    times: (f64, f64),
) -> Result<Analysed, Vec<NotInvertible>> {
    let spec = plant.spec();
    let sets = plant.coupled_axes();
    let mut reasons = Vec::new();
    let mut paths = Vec::new();
    for (index, axis) in spec.axes.iter().enumerate() {
        let count = coupling::place(plant, index);
        let motion = spec.connections.motion_units.get(index).and_then(Option::as_ref);
        let mut own: AxisSpec = axis.clone();
        if let Some(unit) =
            motion.filter(|_| count < axis.components.len() || is_coupled(&sets, index))
        {
            own.position_unit.clone_from(unit);
        }
        match Path::of(&own, count, times) {
            Ok(path) => {
                if let Some(reason) = obstacle(&path.actuator) {
                    reasons.push(NotInvertible { place: format!("axis {}", axis.name), reason });
                }
                paths.push(path);
            }
            Err(reason) => {
                reasons.push(NotInvertible { place: format!("axis {}", axis.name), reason });
            }
        }
    }
    if !reasons.is_empty() {
        return Err(reasons);
    }
    let refuse = |reason: String| vec![NotInvertible { place: spec.name.clone(), reason }];
    let mut outer = vec![Vec::new(); paths.len()];
    let mut left = vec![Vec::new(); paths.len()];
    let mut groups = Vec::new();
    for set in sets {
        let plain = vec![(1.0, 0.0); paths.len()];
        let bare = Group::of(plant, &set, &paths, &plain).map_err(refuse)?;
        let motions: Vec<_> = set.iter().map(|axis| paths[*axis].sweep.reach).collect();
        let reach = bare.reach(&motions);
        let mut lines = plain;
        for (number, axis) in set.iter().enumerate() {
            let nodes = &spec.axes[*axis].components[coupling::place(plant, *axis)..];
            let range = [reach[number].0, reach[number].1];
            let (parts, notes) =
                parts_behind(&spec.axes[*axis], nodes, range, times).map_err(refuse)?;
            let map = at_rest(&spec.axes[*axis], &parts, false, range, times).map_err(refuse)?;
            let last = map.at.len() - 1;
            let gain = (map.value[last] - map.value[0]) / (map.at[last] - map.at[0]);
            lines[*axis] = (gain, map.value[0] - gain * map.at[0]);
            left[*axis] = notes;
            if map.line().is_none() {
                let names = nodes.iter().map(|node| node.name.as_str()).collect::<Vec<_>>();
                left[*axis].push(format!(
                    "{}: acts behind the coupling; its linear part is compensated, the rest is left to feedback",
                    names.join(", ")
                ));
            }
            outer[*axis] = parts;
        }
        groups.push(Group::of(plant, &set, &paths, &lines).map_err(refuse)?);
    }
    Ok(Analysed { paths, outer, groups, left })
}

fn is_coupled(sets: &[Vec<usize>], axis: usize) -> bool {
    sets.iter().any(|set| set.contains(&axis))
}

/// All linear parts with memory of an axis.
pub(crate) fn linear_of(analysed: &Analysed, axis: usize) -> Vec<NodeSpec> {
    let mut nodes = analysed.paths[axis].linear();
    let outer = analysed.outer[axis].iter().filter(|part| part.nature == Nature::Linear);
    nodes.extend(outer.map(|part| part.node.clone()));
    nodes
}

/// One response behind another; each answers within its first sample at the earliest.
fn convolved(response: &[f64], own: &[f64]) -> Vec<f64> {
    if let [gain] = own {
        return response.iter().map(|h| h * gain).collect();
    }
    let mut both = vec![0.0; response.len() + own.len() - 1];
    for (k, h) in response.iter().enumerate() {
        for (i, g) in own.iter().enumerate() {
            both[k + i] += h * g;
        }
    }
    both
}

impl Analysed {
    fn group_of(&self, axis: usize) -> Option<(&Group, usize)> {
        self.groups.iter().find_map(|group| {
            let number = group.axes.iter().position(|other| *other == axis)?;
            Some((group, number))
        })
    }

    /// The impulse response of an axis with these linear parts behind its slope, as its law sees it.
    ///
    /// # Errors
    /// Why it cannot be had.
    pub(crate) fn impulse(
        &self,
        plant: &CheckedBlueprint,
        axis: usize,
        nodes: &[NodeSpec],
        slope: f64,
        times: (f64, f64),
    ) -> Result<Vec<f64>, String> {
        if let Some((group, number)) = self.group_of(axis).filter(|(group, _)| group.is_dynamic) {
            let slopes: Vec<f64> = self.paths.iter().map(|path| path.sweep.slope).collect();
            let linear = |other: usize| {
                if other == axis { nodes.to_vec() } else { linear_of(self, other) }
            };
            let mut responses =
                group.impulse_responses(plant, number, &linear, &slopes, times, AS_GIVEN)?;
            return Ok(convolved(&responses.swap_remove(number), &self.paths[axis].own));
        }
        // The gain of linear parts at rest is in the slope.
        let mut response = impulse_response(&self.paths[axis].axis, nodes, 1.0, times)?;
        let sum: f64 = response.iter().sum();
        for h in &mut response {
            *h *= slope / sum;
        }
        Ok(convolved(&response, &self.paths[axis].own))
    }

    /// The impulse responses of all motions of a group to each of its commands, `[command][motion]`, with all modes'
    /// frequencies and light dampings multiplied.
    ///
    /// # Errors
    /// Why they cannot be had.
    pub(crate) fn coupled_impulses(
        &self,
        plant: &CheckedBlueprint,
        group: &Group,
        times: (f64, f64),
        factors: (f64, f64),
    ) -> Result<Vec<Vec<Vec<f64>>>, String> {
        let slopes: Vec<f64> = self.paths.iter().map(|path| path.sweep.slope).collect();
        let linear = |axis: usize| varied(&linear_of(self, axis), factors.0, factors.1);
        let each = group.axes.iter().enumerate().map(|(number, axis)| {
            let rows = group.impulse_responses(plant, number, &linear, &slopes, times, factors)?;
            Ok(rows.iter().map(|row| convolved(row, &self.paths[*axis].own)).collect())
        });
        each.collect()
    }

    /// Position at rest under a command; where axes are coupled, under the same command of all.
    ///
    /// # Errors
    /// What the model says.
    pub(crate) fn at_rest(&self, axis: usize, command: f64) -> Result<f64, String> {
        let Some((group, number)) = self.group_of(axis) else {
            return self.paths[axis].at_rest(command);
        };
        let mut position = group.offset[number];
        for (column, other) in group.axes.iter().enumerate() {
            let start = if *other == axis { command } else { self.paths[*other].axis.start };
            position += group.jacobian[(number, column)] * self.paths[*other].at_rest(start)?;
        }
        Ok(position)
    }

    /// Least and greatest position of each axis, as simulated; of coupled axes what all may use at once.
    ///
    /// # Errors
    /// What the model says.
    pub(crate) fn reaches(
        &self,
        plant: &CheckedBlueprint,
        delays: &[f64],
        period: f64,
    ) -> Result<Vec<(f64, f64)>, Error> {
        let slowest = delays.iter().copied().fold(0.0, f64::max);
        let way = WAY.max(LONG.0 * slowest).max(LONG.1 * period);
        let rows = steps_of(way, period);
        let leg = rows + (WAITS * slowest * rows as f64 / way).ceil() as usize;
        let part = |k: usize| {
            let along = ((k % leg) as f64 / rows as f64).min(1.0);
            if (k / leg).is_multiple_of(2) { along } else { 1.0 - along }
        };
        let commands: Vec<Vec<f64>> = self
            .paths
            .iter()
            .map(|path| {
                let (low, high) = path.axis.command_range;
                (0..=4 * leg).map(|k| low + (high - low) * part(k)).collect()
            })
            .collect();
        let rest: Vec<f64> = self.paths.iter().map(|path| path.axis.command_range.0).collect();
        let run = simulate_axes(plant, &commands, &rest, |k| k as f64 * way / rows as f64)?;
        let mut reaches: Vec<(f64, f64)> = run
            .iter()
            .map(|y| {
                let (a, b) = (y[4 * leg], y[3 * leg]);
                (a.min(b), a.max(b))
            })
            .collect();
        for group in &self.groups {
            let motions: Vec<_> =
                group.axes.iter().map(|axis| self.paths[*axis].sweep.reach).collect();
            for (axis, reach) in group.axes.iter().zip(group.reach(&motions)) {
                reaches[*axis] = reach;
            }
        }
        Ok(reaches)
    }

    /// Errors of positions as errors of motions.
    pub(crate) fn motions(&self, errors: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut motions = errors.to_vec();
        for group in &self.groups {
            let rows = group.axes.iter().map(|axis| errors[*axis].len()).min().unwrap_or(0);
            for (number, axis) in group.axes.iter().enumerate() {
                motions[*axis] = (0..rows)
                    .map(|k| {
                        let each = group.axes.iter().enumerate();
                        each.map(|(i, other)| group.inverse[(number, i)] * errors[*other][k]).sum()
                    })
                    .collect();
            }
        }
        motions
    }

    /// The reach of an axis' motion.
    pub(crate) fn motion_reach(&self, axis: usize, position: (f64, f64)) -> (f64, f64) {
        if self.group_of(axis).is_some() { self.paths[axis].sweep.reach } else { position }
    }
}
