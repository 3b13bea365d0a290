//! Axes that static couplings join: the motion of each axis, worked out of the readings of all of them.
//!
//! Behind the axes' motions m stand couplings without memory and one and the same linear filter F on every axis, so
//! that the readings are `y = F(A·m + b)`. Then `A⁻¹·(y − F(b)) = F(m)`: each axis shows alone, and an effect in it
//! is found from all readings at once.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use data::{CheckedBlueprint, Log};
use model::{CouplingSpec, NodeSpec, Source, Tick, Unit, unit_on_axis};
use nalgebra::DMatrix;
use surround::Span;

use crate::base::{Base, Part, is_noise};
use crate::chain::{Bench, Horizon};
use crate::data_set::Auxiliary;
use crate::error::Error;
use crate::fit::Fitter;
use crate::outcome::{self, Outcome};
use crate::problem::{Port, Problem, assemble, column, unit_text};
use crate::request::{Noise, Request};
use crate::score::mean_square;
use crate::select::has_gap;

/// Greatest condition number of couplings that are undone.
const CONDITION: f64 = 1000.0;
/// Relative deviation from a straight line that is rounding.
const ROUNDING: f64 = 1e-9;

/// Axes that couplings join, with what the couplings do.
pub(crate) struct Group {
    /// Indices of the axes.
    pub(crate) axes: Vec<usize>,
    /// Names of the couplings.
    pub(crate) couplings: Vec<String>,
    /// A, reading per motion, SI.
    matrix: DMatrix<f64>,
    /// A⁻¹, motion per reading, SI.
    inverse: DMatrix<f64>,
    /// F(b), readings at zero motion, SI.
    at_zero: Vec<f64>,
    /// Condition number of A, its rows and columns scaled to the same size.
    pub(crate) condition: f64,
}

/// A group of axes, all of which are looked at.
pub(crate) struct Coupled {
    pub(crate) group: Group,
    /// The reading of each axis as a function of its position, which is put in place of the command.
    readings: Vec<Problem>,
}

/// The groups of axes that couplings join.
///
/// # Errors
/// [`Error::Model`]: couplings that cannot be undone, and why.
pub(crate) fn groups(blueprint: &CheckedBlueprint) -> Result<Vec<Group>, Error> {
    let joins = |c: &&CouplingSpec| c.node.enabled && c.axes.len() > 1;
    let couplings = || blueprint.spec().connections.couplings.iter().filter(joins);
    let group = |axes: Vec<usize>| {
        let own: Vec<&CouplingSpec> =
            couplings().filter(|c| c.axes.iter().any(|axis| axes.contains(axis))).collect();
        let names: Vec<&str> = own.iter().map(|c| c.node.name.as_str()).collect();
        Group::of(blueprint, axes, &own)
            .map_err(|reason| refused(blueprint, &names.join(", "), &reason))
    };
    blueprint.coupled_axes().into_iter().filter(|axes| axes.len() > 1).map(group).collect()
}

/// That coupled axes are not looked at one by one, and the way out.
pub(crate) fn refused(blueprint: &CheckedBlueprint, coupling: &str, reason: &str) -> Error {
    let message = format!(
        "couples its axes (coupling {coupling}), and {reason}; pack it (piezoloop pack) and diagnose the FMU, whose \
         inputs all act"
    );
    Error::Model { model: blueprint.spec().name.clone(), message }
}

/// The problems of the axes that couplings join: their motions, worked out of the readings of all of them.
///
/// # Errors
/// [`Error`]: couplings that cannot be undone, or a log without a column for one of their outputs.
pub(crate) fn problems(
    request: &Request,
    blueprint: &CheckedBlueprint,
    (inputs, outputs): (&[Port], &[Port]),
    chosen: &[usize],
) -> Result<Vec<Problem>, Error> {
    let mut all = Vec::new();
    for group in groups(blueprint)? {
        let own: Vec<usize> =
            group.axes.iter().copied().filter(|axis| chosen.contains(axis)).collect();
        if own.is_empty() {
            continue;
        }
        let mut ports = outputs.to_vec();
        for axis in &group.axes {
            ports[*axis] = Port {
                name: format!("motion[{}]", axis + 1),
                alias: None,
                unit: motion_text(blueprint, *axis).to_owned(),
                si: motion_unit(blueprint, *axis),
                ..outputs[*axis].clone()
            };
        }
        let mut with = request.clone();
        group.add_motions(&mut with, outputs, &ports)?;
        let (step, first) = (Some(blueprint.spec().period), all.len());
        let gain = request.gain_tolerance;
        for index in own {
            let base =
                Base::white(blueprint, (index + 1, Part::Motion), &request.tolerances, gain)?;
            all.push(assemble(&with, inputs, &ports, index, index, base, step)?);
        }
        let labels: Vec<&str> = group.axes.iter().map(|axis| outputs[*axis].label()).collect();
        all[first].warnings.push(format!(
            "the axes are coupled ({}): each is judged by its motion in front of that, motion[k], worked out of {} \
             (condition number {:.3}); an effect of a single sensor shows in several motions",
            group.couplings.join(", "),
            labels.join(", "),
            group.condition
        ));
        if all.len() - first == group.axes.len() {
            let reading = |index: &usize| {
                let from = blueprint.spec().axes[*index].components.len();
                let base = Base::reading(from, gain);
                assemble(request, inputs, outputs, *index, *index, base, step)
            };
            let readings = group.axes.iter().map(reading).collect::<Result<_, _>>()?;
            let coupled = Arc::new(Coupled { group, readings });
            all[first..].iter_mut().for_each(|p| p.coupled = Some(Arc::clone(&coupled)));
        }
    }
    Ok(all)
}

/// Where something is left of the motions of a group, looks for it behind the couplings too: in the reading of each
/// axis under the positions that the model gives. The answers that leave less of all readings stay, for as many
/// parameters as they need.
///
/// # Errors
/// As [`outcome::of`].
pub(crate) fn in_readings(
    outcomes: &mut Vec<Outcome>,
    request: &Request,
    count: &AtomicU64,
) -> Result<(), Error> {
    let mut first = 0;
    while first < outcomes.len() {
        let Some(coupled) = outcomes[first].problem.coupled.clone() else {
            first += 1;
            continue;
        };
        let members = first..first + coupled.group.axes.len();
        first = members.end;
        let motions = &outcomes[members.clone()];
        if motions.iter().all(|o| !has_gap(&o.found.base, o.adequate)) {
            continue;
        }
        let mut readings = coupled.readings(motions, request, count)?;
        // Without a name there it is no better place to show what is left.
        let has_one = readings.iter().any(|o| !o.found.last.picks.is_empty());
        if has_one && cost_of_readings(&readings) < coupled.cost_of_motions(motions, &readings) {
            let told = motions.iter().flat_map(|o| o.problem.warnings.clone());
            let couplings = coupled.group.couplings.join(", ");
            let why = format!(
                "the gap lies behind the coupling ({couplings}): changes of single readings explain all readings \
                 better than changes of the motions in front of it"
            );
            let told: Vec<String> = told.chain([why]).collect();
            readings[0].problem.warnings.extend(told);
            outcomes.splice(members, readings);
        }
    }
    Ok(())
}

impl Coupled {
    /// The readings under the positions that the model as it came gives.
    fn readings(
        &self,
        motions: &[Outcome],
        request: &Request,
        count: &AtomicU64,
    ) -> Result<Vec<Outcome>, Error> {
        let moved = |o: &Outcome| {
            let chain = &o.found.base.chain;
            let mut bench = Bench::new(chain, &o.problem.data, Horizon::All, count);
            let given = vec![0.0; chain.parameters.len()];
            bench.keep(&given).ok().map(<[f64]>::to_vec)
        };
        let Some(moved) = motions.iter().map(moved).collect::<Option<Vec<_>>>() else {
            return Ok(Vec::new());
        };
        let mut all = Vec::with_capacity(self.readings.len());
        for (i, reading) in self.readings.iter().enumerate() {
            let mut problem = reading.clone();
            problem.course = motions[i].problem.course;
            let data = &mut problem.data;
            for (hit, command) in data.command.iter_mut().enumerate() {
                let sum = moved.iter().enumerate().map(|(j, m)| self.group.matrix[(i, j)] * m[hit]);
                *command = self.group.at_zero[i] + sum.sum::<f64>();
            }
            data.command_span = Span::of(data.command.iter().copied());
            let others = moved.iter().enumerate().filter(|(j, _)| *j != i);
            data.aux = others
                .map(|(j, m)| Auxiliary {
                    name: motions[j].problem.output.clone(),
                    is_command: true,
                    hits: m.clone(),
                    span: Span::of(m.iter().copied()),
                })
                .collect();
            problem.input = format!("{} of the model", problem.output);
            problem.command_unit.clone_from(&problem.unit);
            problem.command_factor = problem.factor;
            all.push(outcome::of(problem, request, count)?);
        }
        Ok(all)
    }

    /// What the answers of the motions leave of the readings and need for it, in twice the logarithm of a likelihood.
    fn cost_of_motions(&self, motions: &[Outcome], readings: &[Outcome]) -> f64 {
        let left = |(i, reading): (usize, &Outcome)| {
            let rows = reading.problem.data.y.len();
            let at = |row: usize| {
                let own = motions.iter().enumerate();
                let sum = own.map(|(j, o)| {
                    self.group.matrix[(i, j)] * o.sigma * o.found.last.judged.residual[row]
                });
                (sum.sum::<f64>() / reading.sigma).powi(2)
            };
            let square = (0..rows).map(at).sum::<f64>() / rows.max(1) as f64;
            effective(reading) * square.max(1.0).ln()
        };
        readings.iter().enumerate().map(left).sum::<f64>() + motions.iter().map(needed).sum::<f64>()
    }
}

/// The same of the answers of the readings.
fn cost_of_readings(readings: &[Outcome]) -> f64 {
    if readings.is_empty() {
        return f64::INFINITY;
    }
    let left = |o: &Outcome| {
        let square = mean_square(&o.found.last.judged.residual);
        effective(o) * square.max(1.0).ln()
    };
    readings.iter().map(|o| left(o) + needed(o)).sum()
}

fn effective(o: &Outcome) -> f64 {
    let count = AtomicU64::new(0);
    Fitter { data: &o.problem.data, sigma: o.sigma, count: &count, weights: None }.effective()
}

/// What the parameters of an answer count.
fn needed(o: &Outcome) -> f64 {
    let records = o.problem.data.records.len();
    let picks = o.found.last.picks.iter();
    let all = picks.map(|(family, k)| o.library[*family].formulas[*k].freedom(records));
    all.sum::<usize>() as f64 * effective(o).ln()
}

impl Group {
    fn of(
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
                if (at - line).abs() > ROUNDING * (at.abs() + zero.abs() + line.abs()) {
                    return Err("what they do is no straight line".to_owned());
                }
            }
        }
        let condition = condition(&matrix);
        let inverse = matrix.clone().try_inverse().filter(|_| condition <= CONDITION).ok_or_else(|| {
            format!(
                "their matrix has the condition number {condition:.3e}, above {CONDITION}: the readings do not tell \
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

/// The unit of an axis' motion in front of its couplings.
pub(crate) fn motion_unit(blueprint: &CheckedBlueprint, axis: usize) -> Unit {
    Unit::parse(motion_text(blueprint, axis)).unwrap_or(Unit::ONE)
}

/// Its text.
pub(crate) fn motion_text(blueprint: &CheckedBlueprint, axis: usize) -> &str {
    let spec = blueprint.spec();
    let own = spec.connections.motion_units.get(axis).and_then(Option::as_deref);
    own.unwrap_or(&spec.axes[axis].position_unit)
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

/// Values of a component that stands behind the couplings, in SI where they have no unit of the axis.
fn run(node: &NodeSpec, x: &[f64], step: f64) -> Option<Vec<f64>> {
    let declaration = node.component.declaration();
    if declaration.inputs.len() != 1 {
        return None;
    }
    let mut values = Vec::with_capacity(node.values.len());
    for (index, quantity) in declaration.parameters.iter().enumerate() {
        let unit = Unit::parse(&unit_on_axis(quantity.unit, "1", "1")).unwrap_or(Unit::ONE);
        let own = node.values.iter().skip(values.len());
        let length = declaration.length(index, &node.structure);
        values.extend(own.take(length).map(|v| unit.to_si(*v)).collect::<Vec<_>>());
    }
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
    const STEPS: usize = 400;
    let wave = |rate: f64, size: f64| -> Vec<f64> {
        (0..STEPS).map(|n| size * (rate * n as f64 + 0.3).sin()).collect()
    };
    let (a, b) = (wave(0.05, 1.0), wave(0.173, -7.0));
    let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
    let out = |x: &[f64]| run(node, x, step);
    let (Some(zero), Some(a), Some(b), Some(sum)) =
        (out(&[0.0; STEPS]), out(&a), out(&b), out(&sum))
    else {
        return false;
    };
    let largest = a.iter().chain(&b).fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    zero.iter().all(|v| *v == 0.0)
        && (0..STEPS).all(|n| (sum[n] - a[n] - b[n]).abs() <= ROUNDING * largest)
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
    let mut values = Vec::with_capacity(node.values.len());
    for (index, quantity) in declaration.parameters.iter().enumerate() {
        let unit =
            Unit::parse(&unit_on_axis(quantity.unit, &command, &position)).unwrap_or(Unit::ONE);
        let own = node.values.iter().skip(values.len());
        let length = declaration.length(index, &node.structure);
        values.extend(own.take(length).map(|v| unit.to_si(*v)).collect::<Vec<_>>());
    }
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
    let values = scaled.singular_values();
    let (most, least) = (values.max(), values.min());
    if least > 0.0 { most / least } else { f64::INFINITY }
}
