//! The ways in which an axis' static part and its creep are undone in front of it.

mod way;

use data::{AxisBlueprint, ComponentBlueprint};
use identify::learned::learned_inverse;
use identify::{
    Columns, Dynamics, Methods, Observer, Record, Search, Settings, Silent, Target, identify,
};
use model::{Component, Conversion, Declaration, Inverse, NodeSpec, Role, Shape, Table, Undoing};

pub use self::way::Feedforward;
use crate::curve::Curve;
use crate::linearised::{setting, values, values_of};
use crate::path::{Nature, Part, Path, at_rest};

/// Models that are fitted to what an axis does where it has no inverse of its own: operators from command to position
/// whose inverse has a closed form, and their chain with a curve.
fn models() -> Vec<&'static str> {
    let is_exact = |component: &&'static dyn Component| {
        component.declaration().conversion == Conversion::CommandToPosition
            && !component.is_affine()
            && component.inverses().iter().any(|i| i.undoing == Undoing::ClosedForm)
    };
    let operators = components::COMPONENTS.iter().copied().filter(is_exact);
    let kinds = operators.map(|component| component.declaration().kind);
    kinds.chain(["curved-prandtl-ishlinskii"]).collect()
}
/// Plays of the fitted models, and the time between their rows in s, which says nothing.
const PLAYS: (usize, f64) = (40, 1e-2);

/// Samples of the fastest wave that a model with rates is fitted to, and how many times slower and how many waves of each
/// there are: the fastest ones last too, where the fit is judged.
const FASTEST: usize = 50;
const RATES: [(usize, usize); 5] = [(1, 4), (4, 2), (16, 1), (4, 1), (1, 4)];
/// Parts of the range that they swing over.
const SWINGS: [f64; 2] = [1.0, 0.6];

/// Most rows that they are fitted to.
const ROWS: usize = 2000;

/// One way to undo an axis.
#[derive(Clone)]
pub(crate) struct Candidate {
    pub(crate) way: Feedforward,
    /// For reports, as in `inverse-mpi (iteration with a bound)`.
    pub(crate) name: String,
    pub(crate) chain: Vec<ComponentBlueprint>,
    /// Of its components that run one, by the names of their files.
    pub(crate) tables: Vec<(String, Table)>,
    /// What the candidate leaves to feedback.
    pub(crate) left: Vec<String>,
}

/// The inverses that the actuator of an axis declares, as chains; each with what stands around it.
pub(crate) fn declared(path: &Path) -> Vec<Result<Candidate, String>> {
    let inverses = path.actuator.component.inverses().iter();
    let own = inverses.filter(|inverse| inverse.undoing != Undoing::Learned);
    own.map(|inverse| {
        let way = match inverse.undoing {
            Undoing::InverseFree => Feedforward::InverseFree,
            _ => Feedforward::Inverse,
        };
        let name = format!("{} ({})", inverse.kind, inverse.undoing.name());
        if let Some(folded) = folded(path, *inverse) {
            return Ok(Candidate {
                way,
                name,
                chain: vec![folded?],
                tables: Vec::new(),
                left: Vec::new(),
            });
        }
        if let Some(obstacle) = obstacle(&path.actuator) {
            return Err(obstacle);
        }
        let own = undoing(&path.actuator, *inverse, path.bounds)?;
        let (mut chain, left) = chain(path, own)?;
        let tables = own_table(path, *inverse, &mut chain);
        Ok(Candidate { way, name, chain, tables, left })
    })
    .collect()
}

/// The actuator's own table, where what undoes it runs the same one.
fn own_table(
    path: &Path,
    inverse: Inverse,
    chain: &mut [ComponentBlueprint],
) -> Vec<(String, Table)> {
    let mut registry = learned::COMPONENTS.iter();
    let takes = registry.any(|c| c.declaration().kind == inverse.kind && c.takes_table());
    let own = path.actuator.component.table().filter(|_| takes);
    let undoing = chain.iter_mut().find(|component| component.kind == inverse.kind);
    let (Some(table), Some(undoing)) = (own, undoing) else { return Vec::new() };
    let file = format!("{}-feedforward.npy", path.axis.name);
    undoing.set("table", data::Value::Text(file.clone()));
    vec![(file, table.clone())]
}

/// A straight line through the ends.
pub(crate) fn linear(path: &Path) -> Candidate {
    let (low, high) = path.sweep.reach;
    let (least, greatest) = path.axis.command_range;
    let gain = 1.0 / path.sweep.mean_slope;
    let offset = 0.5 * (low + high) - 0.5 * (least + greatest) * path.sweep.mean_slope;
    let chain = vec![
        ComponentBlueprint::new("feedforward-gain").value("gain", gain).value("offset", offset),
    ];
    let name = "a straight line".to_owned();
    Candidate { way: Feedforward::Linear, name, chain, tables: Vec::new(), left: Vec::new() }
}

type Suits<'a> = dyn Fn(Candidate) -> Result<Candidate, String> + 'a;

/// The inverse of the Prandtl–Ishlinskii model that errs least on what the axis does at rest.
///
/// # Errors
/// Why there is none.
pub(crate) fn fitted(
    path: &Path,
    suits: &Suits<'_>,
    observer: &mut dyn Observer,
) -> Result<Candidate, String> {
    let sweep = &path.sweep;
    // So many rows tell as much as all.
    let every = sweep.command.len().div_ceil(ROWS);
    let command: Vec<f64> = sweep.command.iter().copied().step_by(every).collect();
    let position: Vec<f64> = sweep.position.iter().copied().step_by(every).collect();
    inverse_of(
        path,
        (Feedforward::Fitted, &models()),
        (&command, &position, PLAYS.1),
        suits,
        observer,
    )
}

/// The inverse of a dynamic Prandtl–Ishlinskii model of what the axis does at several rates.
///
/// # Errors
/// Why there is none.
pub(crate) fn dynamic(
    path: &Path,
    suits: &Suits<'_>,
    observer: &mut dyn Observer,
) -> Result<Candidate, String> {
    let command = at_rates(path);
    let position = path.answers(&command)?;
    let model = (Feedforward::Dynamic, &["dynamic-prandtl-ishlinskii"][..]);
    inverse_of(path, model, (&command, &position, path.times.1), suits, observer)
}

/// A Gaussian process from the position and its rate to the command, and its table for the file `file`.
///
/// # Errors
/// Why there is none.
pub(crate) fn process(
    path: &Path,
    file: &str,
    observer: &mut dyn Observer,
) -> Result<(Candidate, Table), String> {
    let command = at_rates(path);
    let position = path.answers(&command)?;
    let machine = learned_inverse(&command, &position, path.times.1, observer)
        .map_err(|error| error.to_string())?;
    let table = machine.table()?;
    let mut chain = creep(path);
    chain.push(machine.component(true, file, path.times.1));
    let name = format!("gp-inverse (learned from {} samples of the plant)", command.len());
    Ok((
        Candidate { way: Feedforward::Process, name, chain, tables: Vec::new(), left: Vec::new() },
        table,
    ))
}

/// Commands that wave over the range and over its middle at three rates, the fastest of [`FASTEST`] samples a wave.
fn at_rates(path: &Path) -> Vec<f64> {
    let (low, high) = path.axis.command_range;
    let mut command = Vec::new();
    for (slower, waves) in RATES {
        let samples = FASTEST * slower;
        for swing in SWINGS {
            let (least, width) = (low + 0.5 * (1.0 - swing) * (high - low), swing * (high - low));
            let wave = |k: usize| {
                let turn = core::f64::consts::TAU * k as f64 / samples as f64;
                least + 0.5 * width * (1.0 - turn.cos())
            };
            command.extend((0..waves * samples).map(wave));
        }
    }
    command
}

/// The inverse of the model of least error, from the sensor on.
fn inverse_of(
    path: &Path,
    (way, models): (Feedforward, &[&str]),
    (command, position, step): (&[f64], &[f64], f64),
    suits: &Suits<'_>,
    observer: &mut dyn Observer,
) -> Result<Candidate, String> {
    let sign = path.sweep.mean_slope.signum();
    let rows = command.len();
    let time: Vec<f64> = (0..rows).map(|k| k as f64 * step).collect();
    // The position of a row is read before its command acts.
    let output: Vec<f64> = (0..rows).map(|k| sign * position[k.saturating_sub(1)]).collect();
    let columns = Columns {
        name: "the plant at rest",
        time: &time,
        input_name: "command",
        input: command,
        output_name: "position",
        output: &output,
    };
    let record = Record::new(columns)
        .map_err(|all| all.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))?;
    let axis = AxisBlueprint::new("x", &path.axis.command_unit, &path.axis.position_unit);
    let target = Target { model: "fitted".to_owned(), source: String::new(), axis };
    let mut best: Option<(f64, Candidate)> = None;
    let mut failures = Vec::new();
    for (number, model) in models.iter().enumerate() {
        observer.progress("fitting the plant", number, models.len());
        if observer.stopped() {
            break;
        }
        let settings = Settings {
            methods: Methods::Named(vec![(*model).to_owned()]),
            dynamics: Dynamics::Static,
            plays: PLAYS.0,
            longest_delay: Some(0.0),
            hold_out: 0.25,
            search: Search::default(),
            ..Settings::default()
        };
        let found = identify(std::slice::from_ref(&record), &target, &settings, &mut Silent)
            .map_err(|e| e.to_string())
            .and_then(|found| {
                let error = found.records.iter().map(|r| r.fitted.nrmse).fold(0.0, f64::max);
                let axis = found.plant.spec().axes.first().ok_or("no axis")?.clone();
                let count = axis.components.len();
                let own = Path::of(&axis, count, (step, step))?;
                let inverse = *own.actuator.component.inverses().first().ok_or("no inverse")?;
                let inverse_filter = undoing(&own.actuator, inverse, own.bounds)?;
                let name = format!("inverse of a {model} that was fitted to the plant");
                let (chain, left) = (chain(&own, inverse_filter)?.0, Vec::new());
                suits(Candidate { way, name, chain, tables: Vec::new(), left })
                    .map(|candidate| (error, candidate))
            });
        match found {
            Ok((error, candidate)) => {
                if best.as_ref().is_none_or(|(least, _)| error < *least) {
                    best = Some((error, candidate));
                }
            }
            Err(reason) => failures.push(format!("{model}: {reason}")),
        }
    }
    let (_, mut found) = best.ok_or_else(|| failures.join("; "))?;
    if sign < 0.0 {
        let (low, high) = path.sweep.reach;
        found.chain.insert(0, curve("reference-curve", &turned(low, high)).named("sign"));
    }
    let creep = creep(path);
    found.chain.splice(0..0, creep);
    Ok(found)
}

fn turned(low: f64, high: f64) -> Curve {
    Curve { at: vec![low, high], value: vec![-low, -high] }
}

/// The inverses of the creep of an axis, from the sensor on.
fn creep(path: &Path) -> Vec<ComponentBlueprint> {
    let parts = path.after.iter().rev().filter(|part| part.nature == Nature::Creep);
    parts
        .filter_map(|part| {
            let inverse = part.node.component.inverses().first()?;
            undoing(&part.node, *inverse, part.range).ok()?.into_iter().next()
        })
        .collect()
}

/// The inverse of an operator with the gains around it put into its parameters: `g P_r[a u] = g a P_{r/a}[u]`
/// for a > 0. `None` where it is none, or what stands around it is more than gains.
fn folded(path: &Path, inverse: Inverse) -> Option<Result<ComponentBlueprint, String>> {
    let node = &path.actuator;
    let roles: Vec<Option<Role>> =
        node.component.declaration().parameters.iter().map(|q| q.role).collect();
    let gain = |map: &Curve| {
        let (gain, offset) = map.line()?;
        let height = map.value.iter().fold(0.0_f64, |m, y| m.max(y.abs()));
        (offset.abs() <= 1e-9 * height).then_some(gain)
    };
    let (first, last) = (gain(&path.maps[0])?, gain(&path.maps[1])?);
    if path.after.iter().any(|part| part.nature == Nature::Creep) {
        return None;
    }
    let offset = last * values(node, "offset").first().copied().unwrap_or(0.0);
    match &roles[..] {
        [Some(Role::Slope), None] => {
            let own = values_of(node, Role::Slope).first().copied().unwrap_or(0.0);
            let slope = own * first * last;
            let component = ComponentBlueprint::new(inverse.kind).value("gain", 1.0 / slope);
            Some(Ok(component.value("offset", offset)))
        }
        [Some(Role::Threshold), Some(Role::Weight), None] if first > 0.0 => {
            if let Some(obstacle) = obstacle(node) {
                return Some(Err(obstacle));
            }
            let thresholds = values_of(node, Role::Threshold).iter();
            let r: Vec<f64> = thresholds.map(|r| r / first).collect();
            let weights = values_of(node, Role::Weight).iter();
            let w: Vec<f64> = weights.map(|w| w * first * last).collect();
            if last < 0.0 {
                return None;
            }
            let component = ComponentBlueprint::new(inverse.kind).value("r", r).value("w", w);
            Some(Ok(component.value("offset", offset)))
        }
        _ => None,
    }
}

/// Why plays have no inverse.
pub(crate) fn obstacle(node: &NodeSpec) -> Option<String> {
    let (r, w) = (values_of(node, Role::Threshold), values_of(node, Role::Weight));
    let plain = node.component.declaration().parameters.len() == 3;
    if r.is_empty() || r.len() != w.len() || !plain {
        return None;
    }
    let name = &node.name;
    if r[0] != 0.0 {
        return Some(format!(
            "{name}.r[1] = {} is above 0: a small motion of the command moves nothing, so there is \
             no inverse; identify the plant with a first threshold of 0",
            r[0]
        ));
    }
    (w[0] <= 0.0).then(|| {
        format!(
            "{name}.w[1] = {} is not above 0, so there is no inverse; identify the plant with a \
             least slope above 0",
            w[0]
        )
    })
}

/// What undoes a component, by its declaration: parameters of the same names, bounds of the command, and the
/// reciprocal of a gain; what it has no parameter for stands in front of it.
///
/// # Errors
/// That the registry has no such component.
pub(crate) fn undoing(
    node: &NodeSpec,
    inverse: Inverse,
    bounds: [f64; 2],
) -> Result<Vec<ComponentBlueprint>, String> {
    let mut registry = learned::COMPONENTS.iter().map(|c| c.declaration());
    let declaration: &Declaration = registry
        .find(|d| d.kind == inverse.kind)
        .ok_or_else(|| format!("there is no component {}", inverse.kind))?;
    let mut component = ComponentBlueprint::new(inverse.kind);
    for (index, setting_of) in declaration.structure.iter().enumerate() {
        let counted =
            declaration.parameters.iter().any(|q| matches!(q.shape, Shape::Array(i) if i == index));
        if let Some(value) = setting(node, setting_of.name).filter(|_| !counted) {
            component = component.value(setting_of.name, value);
        }
    }
    let forward = node.component.declaration();
    for quantity in declaration.parameters {
        let own = values(node, quantity.name);
        let same = forward.parameters.iter().find(|q| q.name == quantity.name);
        component = match (quantity.name, quantity.shape) {
            ("command_min", _) => component.value("command_min", bounds[0]),
            ("command_max", _) => component.value("command_max", bounds[1]),
            (name, _) if own.is_empty() || same.is_none() => {
                let _ = name;
                component
            }
            (name, Shape::Scalar) if same.is_some_and(|q| q.unit != quantity.unit) => {
                component.value(name, 1.0 / own[0])
            }
            (name, Shape::Scalar) => component.value(name, own[0]),
            (name, Shape::Array(_)) => component.value(name, own),
        };
    }
    let mut all = vec![component];
    let lost = values(node, "offset").first().copied().unwrap_or(0.0);
    if lost != 0.0 && !declaration.parameters.iter().any(|q| q.name == "offset") {
        let shift = Curve { at: vec![lost, lost + 1.0], value: vec![0.0, 1.0] };
        all.insert(0, curve("reference-curve", &shift).named("offset"));
    }
    Ok(all)
}

/// A curve as a component.
fn curve(kind: &str, curve: &Curve) -> ComponentBlueprint {
    ComponentBlueprint::new(kind).value("at", &curve.at).value("value", &curve.value)
}

/// The chain that undoes an axis around what undoes its actuator, and what it leaves.
///
/// # Errors
/// What the model says.
pub(crate) fn chain(
    path: &Path,
    actuator: Vec<ComponentBlueprint>,
) -> Result<(Vec<ComponentBlueprint>, Vec<String>), String> {
    let mut left = Vec::new();
    let mut chain = Vec::new();
    let mut group: Vec<Part> = Vec::new();
    for part in path.after.iter().rev() {
        match part.nature {
            Nature::Static | Nature::Linear => group.insert(0, part.clone()),
            Nature::Creep => {
                if let Some(inverse) = part.node.component.inverses().first() {
                    chain.extend(flush(path, &mut group, false, &mut left)?);
                    chain.extend(undoing(&part.node, *inverse, part.range)?);
                }
            }
            Nature::Left => {}
        }
    }
    chain.extend(flush(path, &mut group, false, &mut left)?);
    chain.extend(actuator);
    let mut group = path.before.clone();
    chain.extend(flush(path, &mut group, true, &mut left)?);
    let mut names: Vec<String> = Vec::new();
    for (number, component) in chain.iter_mut().enumerate() {
        let mut registry = learned::COMPONENTS.iter().map(|c| c.declaration());
        let usual = registry.find(|d| d.kind == component.kind).map_or("", |d| d.name);
        let name =
            if component.name.is_empty() { usual.to_owned() } else { component.name.clone() };
        if names.contains(&name) {
            component.name = format!("{name}_{}", number + 1);
        }
        names.push(name);
    }
    Ok((chain, left))
}

/// The way back through a group of parts, which is emptied.
fn flush(
    path: &Path,
    group: &mut Vec<Part>,
    of_the_command: bool,
    left: &mut Vec<String>,
) -> Result<Option<ComponentBlueprint>, String> {
    let parts = core::mem::take(group);
    let Some(first) = parts.first() else { return Ok(None) };
    let map = at_rest(&path.axis, &parts, of_the_command, first.range, path.times)?;
    if map.is_identity() {
        return Ok(None);
    }
    let kind = if of_the_command { "command-curve" } else { "reference-curve" };
    if let Some(back) = map.back() {
        return Ok(Some(curve(kind, &back)));
    }
    // Stairs or a fall: a straight line through the ends.
    let last = map.at.len() - 1;
    let line =
        Curve { at: vec![map.at[0], map.at[last]], value: vec![map.value[0], map.value[last]] };
    let names: Vec<&str> = parts.iter().map(|part| part.node.name.as_str()).collect();
    let bent = map.at.iter().zip(&map.value).map(|(x, y)| (line.value(*x) - y).abs());
    left.push(format!(
        "{}: a position belongs to several values of it; a straight line is undone, and up to {:.3} % of the \
         range is left to feedback",
        names.join(", "),
        100.0 * bent.fold(0.0, f64::max) / (line.value[1] - line.value[0]).abs()
    ));
    Ok(line.back().filter(|back| !back.is_identity()).map(|back| curve(kind, &back)))
}

/// Whether a component of a controller's axis is part of the feedforward.
pub(crate) fn is_feedforward(component: &ComponentBlueprint) -> bool {
    let mut registry = learned::COMPONENTS.iter().map(|c| c.declaration());
    registry.find(|d| d.kind == component.kind).is_some_and(|d| d.conversion != Conversion::Control)
}
