//! Axes that act on each other: what their couplings do at rest, as a Jacobian.

use data::CheckedBlueprint;
use model::{Connections, CouplingSpec, Kind, NodeSpec, Role, System, SystemSpec};
use nalgebra::DMatrix;

use crate::linearised::{LIGHT, settled_impulse, small, values_of, varied};
use crate::path::Path;
use crate::probe::{bare, straight};

/// Greatest condition number of a Jacobian that is inverted.
const CONDITION: f64 = 1000.0;
/// Factors of the frequencies and dampings of a plant's modes.
pub(crate) const AS_GIVEN: (f64, f64) = (1.0, 1.0);

/// Axes that are coupled, and their Jacobian.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// Indices of the axes.
    pub(crate) axes: Vec<usize>,
    /// Position per motion.
    pub(crate) jacobian: DMatrix<f64>,
    /// Positions at zero motion.
    pub(crate) offset: Vec<f64>,
    pub(crate) inverse: DMatrix<f64>,
    pub(crate) condition: f64,
    /// Whether a coupling has dynamics.
    pub(crate) is_dynamic: bool,
    /// Whether the Jacobian is that of the middle of the range only.
    pub(crate) is_bent: bool,
    /// Kinds of the couplings.
    pub(crate) kinds: Vec<String>,
}

/// Number of components of an axis that stand in front of its first coupling.
pub(crate) fn place(plant: &CheckedBlueprint, axis: usize) -> usize {
    let spec = plant.spec();
    let own = spec.connections.couplings.iter().filter(|c| acts(c, axis));
    let places = own.map(|coupling| plant.before_coupling(coupling, axis));
    places.min().unwrap_or(spec.axes[axis].components.len())
}

fn acts(coupling: &CouplingSpec, axis: usize) -> bool {
    coupling.node.enabled && coupling.axes.contains(&axis)
}

/// The plant with only these parts on its axes, and its couplings, whose modes' frequencies and light dampings are
/// multiplied.
fn system(
    plant: &CheckedBlueprint,
    parts: impl Fn(usize) -> Vec<NodeSpec>,
    step: f64,
    (shift, damping): (f64, f64),
) -> Result<System, String> {
    let spec = plant.spec();
    let mut axes = Vec::new();
    for (index, axis) in spec.axes.iter().enumerate() {
        axes.push(bare(axis, parts(index)));
    }
    let free = |coupling: &CouplingSpec| {
        let nodes = varied(std::slice::from_ref(&coupling.node), shift, damping);
        let node = nodes.into_iter().next().unwrap_or_else(|| coupling.node.clone());
        CouplingSpec { after: None, node, ..coupling.clone() }
    };
    let connections = Connections {
        couplings: spec.connections.couplings.iter().map(free).collect(),
        motion_units: spec.connections.motion_units.clone(),
        ..Connections::default()
    };
    let spec = SystemSpec {
        name: "coupled".to_owned(),
        kind: Kind::Plant,
        period: step,
        axes,
        connections,
    };
    System::new(&spec)
        .map_err(|all| all.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
}

fn set(system: &mut System, axis: usize, command: f64) -> Result<(), String> {
    let name = format!("command[{}]", axis + 1);
    let reference = system.variables().find(&name).ok_or_else(|| format!("has no {name}"))?;
    system.set(reference, command).map_err(|e| system.explain_set(&e))
}

fn positions(system: &System, axes: &[usize]) -> Vec<f64> {
    let one = |axis: &usize| {
        let found = system.variables().find(&format!("position[{}]", axis + 1));
        found.and_then(|reference| system.get(reference)).unwrap_or(f64::NAN)
    };
    axes.iter().map(one).collect()
}

impl Group {
    /// The Jacobian of these axes, at the middle of their motions; `outer` has gain and offset of what stands
    /// behind the couplings.
    ///
    /// # Errors
    /// That it cannot be inverted, and why.
    pub(crate) fn of(
        plant: &CheckedBlueprint,
        axes: &[usize],
        paths: &[Path],
        outer: &[(f64, f64)],
    ) -> Result<Self, String> {
        let slopes: Vec<f64> = paths.iter().map(|path| path.sweep.mean_slope).collect();
        let step = paths.first().map_or(1.0, |path| path.times.0);
        let mut machine = system(plant, |axis| vec![straight(slopes[axis])], step, AS_GIVEN)?;
        let mut rest = |motions: &[f64]| -> Result<Vec<f64>, String> {
            for (axis, motion) in motions.iter().enumerate() {
                set(&mut machine, axis, motion / slopes[axis])?;
            }
            machine.initialise(0.0).map_err(|e| machine.explain(&e))?;
            Ok(positions(&machine, axes))
        };
        let reach = |axis: usize| paths[axis].sweep.reach;
        let middle: Vec<f64> =
            (0..paths.len()).map(|axis| 0.5 * (reach(axis).0 + reach(axis).1)).collect();
        let centre = rest(&middle)?;
        let n = axes.len();
        let mut jacobian = DMatrix::zeros(n, n);
        let mut bent = 0.0_f64;
        for (column, axis) in axes.iter().enumerate() {
            let half = 0.5 * (reach(*axis).1 - reach(*axis).0);
            let mut moved = middle.clone();
            moved[*axis] = middle[*axis] + half;
            let up = rest(&moved)?;
            moved[*axis] = middle[*axis] - half;
            let down = rest(&moved)?;
            for row in 0..n {
                let entry = (up[row] - down[row]) / (2.0 * half);
                let width = (up[row] - down[row]).abs();
                bent =
                    bent.max((up[row] + down[row] - 2.0 * centre[row]).abs() / width.max(1e-300));
                jacobian[(row, column)] = if entry.abs() < 1e-12 * width.max(half) {
                    0.0
                } else {
                    entry * outer[axes[row]].0
                };
            }
        }
        let own: Vec<f64> = axes.iter().map(|axis| middle[*axis]).collect();
        let offset = (0..n).map(|row| {
            let at = outer[axes[row]].0 * centre[row] + outer[axes[row]].1;
            at - (0..n).map(|j| jacobian[(row, j)] * own[j]).sum::<f64>()
        });
        let offset = offset.collect();
        // Rounding of what is printed in decimal.
        let jacobian = jacobian.map(tidy);
        let mut entries: Vec<f64> = jacobian.transpose().iter().copied().collect();
        let condition = components::control::condition(&mut entries, n);
        let inverse = jacobian.clone().try_inverse().filter(|_| condition <= CONDITION);
        let Some(inverse) = inverse else {
            return Err(format!(
                "the coupling's Jacobian has the condition number {condition:.3e}, above {CONDITION}: motions \
                 of some axes cannot be distinguished by the sensors; change the coupling"
            ));
        };
        let couplings = || {
            let all = plant.spec().connections.couplings.iter();
            all.filter(|c| c.node.enabled && c.axes.iter().any(|axis| axes.contains(axis)))
        };
        let states = |c: &CouplingSpec| c.node.component.sizes(&c.node.structure, step).states;
        Ok(Self {
            axes: axes.to_vec(),
            jacobian,
            offset,
            inverse,
            condition,
            is_dynamic: couplings().any(|c| states(c) > 0),
            is_bent: bent > 1e-6,
            kinds: couplings().map(|c| c.node.component.declaration().kind.to_owned()).collect(),
        })
    }

    /// The impulse responses of all motions, as the coordinator sees them, to the command of one axis, with the
    /// couplings' dynamics and these linear parts on the axes: as far as that axis' own settles, and as long again.
    /// `factors`: of the frequencies and the dampings of the couplings' modes.
    ///
    /// # Errors
    /// Why they cannot be had.
    pub(crate) fn impulse_responses(
        &self,
        plant: &CheckedBlueprint,
        number: usize,
        linear: &dyn Fn(usize) -> Vec<NodeSpec>,
        slopes: &[f64],
        (step, period): (f64, f64),
        factors: (f64, f64),
    ) -> Result<Vec<Vec<f64>>, String> {
        let parts = |axis: usize| [vec![straight(slopes[axis])], linear(axis)].concat();
        let mut machine = system(plant, parts, step, factors)?;
        let own = self.axes[number];
        let size = small(&plant.spec().axes[own]);
        machine.initialise(0.0).map_err(|e| machine.explain(&e))?;
        let rest = positions(&machine, &self.axes);
        set(&mut machine, own, size)?;
        let n = self.axes.len();
        let mut steps: Vec<Vec<f64>> = vec![vec![0.0]; n];
        let mut count = 0;
        let mut next = || -> Result<f64, String> {
            count += 1;
            machine.advance(f64::from(count) * period).map_err(|e| machine.explain(&e))?;
            let moved = positions(&machine, &self.axes);
            for (row, steps) in steps.iter_mut().enumerate() {
                let motion = moved.iter().zip(&rest).enumerate();
                let sum: f64 = motion.map(|(i, (p, p0))| self.inverse[(row, i)] * (p - p0)).sum();
                steps.push(sum / size);
            }
            Ok(steps[number].last().copied().unwrap_or(f64::NAN))
        };
        let settled = settled_impulse(period, &mut next)?.len();
        for _ in 0..settled {
            next()?;
        }
        let impulse = |steps: &Vec<f64>| steps.windows(2).map(|pair| pair[1] - pair[0]).collect();
        Ok(steps.iter().map(impulse).collect())
    }

    /// Frequencies in Hz of the couplings' light modes.
    pub(crate) fn light_modes(&self, plant: &CheckedBlueprint) -> Vec<f64> {
        let joined = |c: &&CouplingSpec| {
            c.node.enabled && c.axes.iter().any(|axis| self.axes.contains(axis))
        };
        let couplings = plant.spec().connections.couplings.iter().filter(joined);
        couplings
            .flat_map(|c| {
                let damping = values_of(&c.node, Role::Damping);
                values_of(&c.node, Role::Frequency).iter().zip(damping)
            })
            .filter(|(_, damping)| **damping < LIGHT)
            .map(|(frequency, _)| *frequency)
            .collect()
    }

    /// For each axis the middle of its positions and the half width that all of them may use at once, where
    /// the motions stay within these.
    pub(crate) fn reach(&self, motions: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let n = self.axes.len();
        let middle: Vec<f64> = motions.iter().map(|(low, high)| 0.5 * (low + high)).collect();
        let half: Vec<f64> = motions.iter().map(|(low, high)| 0.5 * (high - low)).collect();
        let wide =
            |row: usize| (0..n).map(|j| (self.jacobian[(row, j)] * half[j]).abs()).sum::<f64>();
        let wide: Vec<f64> = (0..n).map(wide).collect();
        let used = |i: usize| {
            (0..n).map(|j| (self.inverse[(i, j)] * wide[j]).abs()).sum::<f64>() / half[i]
        };
        let scale = 1.0 / (0..n).map(used).fold(1e-300, f64::max);
        (0..n)
            .map(|row| {
                let at: f64 = self.offset[row]
                    + (0..n).map(|j| self.jacobian[(row, j)] * middle[j]).sum::<f64>();
                (at - scale * wide[row], at + scale * wide[row])
            })
            .collect()
    }
}

/// A number to 12 digits.
fn tidy(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}
