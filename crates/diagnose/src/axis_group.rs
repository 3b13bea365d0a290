//! What static couplings do, and how it is inverted: the motion of each axis, worked out of the readings of all of them.
//!
//! Behind the axes' motions m stand couplings without memory and one and the same linear filter F on every axis, so
//! that the readings are `y = F(A·m + b)`. Then `A⁻¹·(y − F(b)) = F(m)`: each axis shows alone, and an effect in it
//! is found from all readings at once.

use data::{CheckedBlueprint, Log};
use model::{CouplingSpec, NodeSpec, Source, Tick};
use nalgebra::DMatrix;

use crate::base::coupling::motion_unit;
use crate::base::{in_si, is_noise};
use crate::error::Error;
use crate::port::{Port, column, unit_text};
use crate::request::{Noise, Request};
use crate::thresholds::base::Thresholds;

/// Axes that couplings join, with what the couplings do.
pub(crate) struct Group {
    /// Indices of the axes.
    pub(crate) axes: Vec<usize>,
    /// Names of the couplings.
    pub(crate) couplings: Vec<String>,
    /// A, reading per motion, SI.
    pub(crate) matrix: DMatrix<f64>,
    /// A⁻¹, motion per reading, SI.
    inverse: DMatrix<f64>,
    /// F(b), readings at zero motion, SI.
    pub(crate) at_zero: Vec<f64>,
    /// Condition number of A, its rows and columns scaled to the same size.
    pub(crate) condition: f64,
}

impl Group {
    pub(crate) fn of(
        blueprint: &CheckedBlueprint,
        axes: Vec<usize>,
        couplings: &[&CouplingSpec],
    ) -> Result<Self, String> {
        let step = blueprint.spec().period;
        let behind = same_filter(blueprint, &axes, couplings)?;
        let order = in_order(blueprint, &axes, couplings);
        let scales: Vec<f64> =
            axes.iter().map(|axis| motion_unit(blueprint, *axis).factor).collect();
        let positions = |motion: &[f64]| -> Result<Vec<f64>, String> {
            let mut path = motion.to_vec();
            for coupling in &order {
                through(blueprint, coupling, &axes, &mut path)?;
            }
            Ok(path)
        };
        let n = axes.len();
        let zero = positions(&vec![0.0; n])?;
        let mut matrix = DMatrix::zeros(n, n);
        for j in 0..n {
            let mut unit = vec![0.0; n];
            unit[j] = scales[j];
            for (i, (at, zero)) in positions(&unit)?.iter().zip(&zero).enumerate() {
                matrix[(i, j)] = (at - zero) / scales[j];
            }
        }
        for factor in [-2.0, 3.0] {
            let motion: Vec<f64> = scales
                .iter()
                .enumerate()
                .map(|(k, s)| factor * s * (1.0 + 0.3 * k as f64))
                .collect();
            for (i, (at, zero)) in positions(&motion)?.iter().zip(&zero).enumerate() {
                let line = zero + (0..n).map(|j| matrix[(i, j)] * motion[j]).sum::<f64>();
                if (at - line).abs()
                    > Thresholds::AFFINE_ROUNDING * (at.abs() + zero.abs() + line.abs())
                {
                    return Err("what they do is no straight line".to_owned());
                }
            }
        }
        let (condition, most) = (condition(&matrix), Thresholds::CONDITION);
        let inverse = matrix.clone().try_inverse().filter(|_| condition <= most).ok_or_else(|| {
            format!(
                "their matrix has the condition number {condition:.3e}, above {most}: the readings do not tell \
                 the motions apart"
            )
        })?;
        let at_zero = zero.iter().map(|b| at_rest(&behind, *b, step)).collect::<Result<_, _>>()?;
        let couplings = couplings.iter().map(|c| c.node.name.clone()).collect();
        Ok(Self { axes, couplings, matrix, inverse, at_zero, condition })
    }

    /// Adds the motions of its axes to all logs, as columns with the names of `ports`, and what is known of their
    /// noise.
    ///
    /// # Errors
    /// [`Error`]: a log without a column for one of the outputs.
    pub(crate) fn add_motions(
        &self,
        request: &mut Request,
        outputs: &[Port],
        ports: &[Port],
    ) -> Result<(), Error> {
        let names = request.clone();
        for log in request.logs.iter_mut().chain(&mut request.holdout) {
            self.add_to(log, &names, outputs, ports)?;
        }
        match &mut request.noise {
            Noise::Rest(log) => self.add_to(log, &names, outputs, ports)?,
            Noise::Given(all) => {
                let of = |port: &Port| {
                    let own = |(name, _): &&(Option<String>, f64)| {
                        name.as_deref().is_some_and(|name| port.is(name))
                    };
                    let found = all.iter().rev().find(own);
                    let found = found.or_else(|| all.iter().rev().find(|(name, _)| name.is_none()));
                    found.map(|(_, sigma)| sigma * port.si.factor)
                };
                let sigmas: Option<Vec<f64>> =
                    self.axes.iter().map(|axis| of(&outputs[*axis])).collect();
                // Where one of them is not known, neither is any motion's.
                match sigmas {
                    Some(sigmas) => all.extend(self.axes.iter().enumerate().map(|(j, axis)| {
                        let square = |(i, s): (usize, &f64)| (self.inverse[(j, i)] * s).powi(2);
                        let sigma = sigmas.iter().enumerate().map(square).sum::<f64>().sqrt();
                        (Some(ports[*axis].name.clone()), sigma / ports[*axis].si.factor)
                    })),
                    None => request.noise = Noise::Estimated,
                }
            }
            Noise::Estimated => {}
        }
        Ok(())
    }

    fn add_to(
        &self,
        log: &mut Log,
        request: &Request,
        outputs: &[Port],
        ports: &[Port],
    ) -> Result<(), Error> {
        let mut readings = Vec::with_capacity(self.axes.len());
        for (axis, zero) in self.axes.iter().zip(&self.at_zero) {
            let (port, own) = (&outputs[*axis], column(request, &outputs[*axis], log, "output")?);
            readings.push(own.iter().map(|y| port.si.to_si(*y) - zero).collect::<Vec<f64>>());
        }
        for (j, axis) in self.axes.iter().enumerate() {
            let port = &ports[*axis];
            let at = |row: usize| {
                let sum = readings.iter().enumerate().map(|(i, y)| self.inverse[(j, i)] * y[row]);
                port.si.from_si(sum.sum::<f64>())
            };
            let motion: Vec<f64> = (0..log.len()).map(at).collect();
            log.add_column(&port.name, Some(unit_text(port)), motion)?;
        }
        Ok(())
    }
}

/// What stands behind the first coupling of every axis, where it is one linear filter without an offset.
fn same_filter(
    blueprint: &CheckedBlueprint,
    axes: &[usize],
    couplings: &[&CouplingSpec],
) -> Result<Vec<NodeSpec>, String> {
    let (all, step) = (&blueprint.spec().axes, blueprint.spec().period);
    let behind = |axis: usize| -> Vec<&NodeSpec> {
        let own = couplings.iter().filter(|c| c.axes.contains(&axis));
        let first = own.map(|c| blueprint.before_coupling(c, axis)).min().unwrap_or(usize::MAX);
        let nodes = all[axis].components.iter().skip(first);
        nodes.filter(|node| node.enabled && !is_noise(node.component.declaration())).collect()
    };
    let first = behind(axes[0]);
    let is_same = |a: &NodeSpec, b: &NodeSpec| {
        let kind = |node: &NodeSpec| node.component.declaration().kind;
        kind(a) == kind(b) && a.structure == b.structure && a.values == b.values
    };
    for axis in &axes[1..] {
        let other = behind(*axis);
        let pairs = first.iter().zip(&other);
        if first.len() != other.len() || !pairs.clone().all(|(a, b)| is_same(a, b)) {
            let differs = pairs.clone().find(|(a, b)| !is_same(a, b)).map(|(a, _)| a.name.as_str());
            let longer = if first.len() > other.len() { &first } else { &other };
            let extra = || longer.get(first.len().min(other.len())).map(|node| node.name.as_str());
            let name = differs.or_else(extra).unwrap_or_default();
            return Err(format!(
                "axes {} and {} differ in {name} behind it",
                all[axes[0]].name, all[*axis].name
            ));
        }
    }
    for node in &first {
        if !is_linear(node, step) {
            return Err(format!("{} behind it is not linear", node.name));
        }
    }
    Ok(first.into_iter().cloned().collect())
}

/// What a component without units of its axis gives, from rest under the first value; none where it reads more.
fn run(node: &NodeSpec, x: &[f64], step: f64) -> Option<Vec<f64>> {
    let declaration = node.component.declaration();
    if declaration.inputs.len() != 1 {
        return None;
    }
    let values = in_si(("1", "1"), node);
    let sizes = node.component.sizes(&node.structure, step);
    let (mut coefficients, mut state) = (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
    let mut outputs = vec![0.0; declaration.outputs.len()];
    node.component.prepare(&node.structure, &values, step, &mut coefficients).ok()?;
    node.component.rest(&coefficients, &x[..1], &mut state, &mut outputs);
    let mut all = vec![outputs[0]];
    for (n, u) in x.iter().enumerate().skip(1) {
        let tick = Tick { index: n as u64, time: n as f64 * step, period: step };
        node.component.step(&coefficients, &mut state, tick, &[*u], &mut outputs);
        all.push(outputs[0]);
    }
    Some(all)
}

/// Whether a component is linear in its input and gives nothing for nothing.
fn is_linear(node: &NodeSpec, step: f64) -> bool {
    let wave = |rate: f64, size: f64| -> Vec<f64> {
        (0..Thresholds::LINEAR_STEPS).map(|n| size * (rate * n as f64 + 0.3).sin()).collect()
    };
    let (a, b) = (wave(0.05, 1.0), wave(0.173, -7.0));
    let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
    let out = |x: &[f64]| run(node, x, step);
    let (Some(zero), Some(a), Some(b), Some(sum)) =
        (out(&[0.0; Thresholds::LINEAR_STEPS]), out(&a), out(&b), out(&sum))
    else {
        return false;
    };
    let largest = a.iter().chain(&b).fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    zero.iter().all(|v| *v == 0.0)
        && (0..Thresholds::LINEAR_STEPS)
            .all(|n| (sum[n] - a[n] - b[n]).abs() <= Thresholds::AFFINE_ROUNDING * largest)
}

/// What the filter gives for a value that has been held for ever.
fn at_rest(filter: &[NodeSpec], value: f64, step: f64) -> Result<f64, String> {
    filter.iter().try_fold(value, |x, node| {
        let rested = run(node, &[x], step).and_then(|all| all.first().copied());
        rested.ok_or_else(|| format!("{} behind it does not rest", node.name))
    })
}

/// The couplings in the order of the path: one acts once it is the next of all its axes.
fn in_order<'a>(
    blueprint: &CheckedBlueprint,
    axes: &[usize],
    couplings: &[&'a CouplingSpec],
) -> Vec<&'a CouplingSpec> {
    let mut stops: Vec<(usize, Vec<usize>)> = axes
        .iter()
        .map(|axis| {
            let own = couplings.iter().enumerate().filter(|(_, c)| c.axes.contains(axis));
            let mut own: Vec<(usize, usize)> =
                own.map(|(k, c)| (blueprint.before_coupling(c, *axis), k)).collect();
            own.sort_by_key(|(place, _)| *place);
            (*axis, own.into_iter().map(|(_, k)| k).collect())
        })
        .collect();
    let mut order = Vec::with_capacity(couplings.len());
    while order.len() < couplings.len() {
        let is_next = |k: &usize| {
            let on = stops.iter().filter(|(axis, _)| couplings[*k].axes.contains(axis));
            on.clone().all(|(_, own)| own.first() == Some(k))
        };
        // A blueprint whose couplings have no order is refused where it is read.
        let Some(next) = (0..couplings.len()).filter(|k| !order.contains(k)).find(is_next) else {
            break;
        };
        for (_, own) in &mut stops {
            own.retain(|k| *k != next);
        }
        order.push(next);
    }
    order.into_iter().map(|k| couplings[k]).collect()
}

/// Takes the paths of a group through one coupling, in SI.
fn through(
    blueprint: &CheckedBlueprint,
    coupling: &CouplingSpec,
    axes: &[usize],
    path: &mut [f64],
) -> Result<(), String> {
    let (node, step) = (&coupling.node, blueprint.spec().period);
    let declaration = node.component.declaration();
    let sizes = node.component.sizes(&node.structure, step);
    if sizes.states > 0 {
        return Err(format!("{} has dynamics", node.name));
    }
    if declaration.inputs.iter().any(|port| port.source != Source::EachPath) {
        return Err(format!("{} reads other signals than the paths of its axes", node.name));
    }
    let [command, position] = blueprint.coupling_units(coupling);
    let values = in_si((&command, &position), node);
    let mut coefficients = vec![0.0; sizes.coefficients];
    let prepared = node.component.prepare(&node.structure, &values, step, &mut coefficients);
    prepared.map_err(|violation| format!("{}: {violation}", node.name))?;
    let places: Vec<usize> =
        coupling.axes.iter().filter_map(|axis| axes.iter().position(|own| own == axis)).collect();
    let inputs: Vec<f64> = places.iter().map(|at| path[*at]).collect();
    let mut outputs = inputs.clone();
    node.component.rest(&coefficients, &inputs, &mut [], &mut outputs);
    for (at, output) in places.into_iter().zip(outputs) {
        path[at] = output;
    }
    Ok(())
}

/// Condition number of a matrix whose rows and columns are scaled to the same size.
fn condition(matrix: &DMatrix<f64>) -> f64 {
    let mut scaled = matrix.clone();
    for _ in 0..5 {
        for mut row in scaled.row_iter_mut() {
            let size = row.norm();
            row.iter_mut().for_each(|v| *v /= size.max(f64::MIN_POSITIVE));
        }
        for mut column in scaled.column_iter_mut() {
            let size = column.norm();
            column.iter_mut().for_each(|v| *v /= size.max(f64::MIN_POSITIVE));
        }
    }
    // That of the transpose is the same.
    components::control::condition(scaled.as_mut_slice(), matrix.nrows())
}
