//! An example of every component type, and a model around it.
#![allow(unreachable_pub)]

use std::sync::LazyLock;

use components::find;
use model::{
    AxisSpec, Component, Connections, Conversion, CouplingSpec, Declaration, Kind, NodeSpec,
    Quantity, Shape, Stage, SystemSpec,
};

/// Internal step in s.
pub const T: f64 = 1e-4;

/// Kind, structure, parameters in the declared units with V and um.
pub type Example = (&'static str, &'static [f64], &'static [f64]);

/// One of each component type, in the order of the registry: of those below, else as it declares, else of
/// `rigs/effects.toml`.
pub static EXAMPLES: LazyLock<Vec<Example>> = LazyLock::new(|| {
    let own = |kind: &str| OWN.iter().find(|example| example.0 == kind).copied();
    let of = |component: &&'static dyn Component| {
        let declaration = component.declaration();
        own(declaration.kind).or_else(|| declared(*component)).or_else(|| of_rig(declaration))
    };
    components::COMPONENTS.iter().filter_map(of).collect()
});

/// The example that a component declares; none where it declares none.
fn declared(component: &dyn Component) -> Option<Example> {
    let limits =
        |name: &str| LIMITS.iter().find(|limit| limit.0 == name).map(|limit| vec![limit.1]);
    let given = component.example();
    let of = |name: &str| given.iter().find(|value| value.0 == name).map(|value| value.1.to_vec());
    if given.is_empty() {
        None
    } else {
        complete(component.declaration(), |n| of(n).or_else(|| limits(n)))
    }
}

/// Commands that inverses search between.
const LIMITS: [(&str, f64); 2] = [("command_min", -20.0), ("command_max", 150.0)];

/// The example of a component in `rigs/effects.toml`; none where it is not there.
fn of_rig(declaration: &'static Declaration) -> Option<Example> {
    const RIG: &str = include_str!("../../../../rigs/effects.toml");
    let is_it = format!("type = \"{}\"\n", declaration.kind);
    let section = RIG.split("[[axis.component]]\n").find(|section| section.starts_with(&is_it))?;
    complete(declaration, |name| {
        let begin = format!("{name} = ");
        let text = section.lines().find_map(|line| line.strip_prefix(&begin))?;
        let each = text.trim_matches(['[', ']']).split(',').map(|number| number.trim().parse());
        Some(each.collect::<Result<_, _>>().unwrap_or_else(|_| panic!("{is_it}{text}")))
    })
}

/// An example of these values; where there is none, the start values, and lengths of the lists.
fn complete(
    declaration: &'static Declaration,
    numbers: impl Fn(&str) -> Option<Vec<f64>>,
) -> Option<Example> {
    let of_structure = |(at, part): (usize, &model::Structural)| {
        numbers(part.name).map(|given| given[0]).or(part.start).or_else(|| {
            let is_along = |q: &&Quantity| matches!(q.shape, Shape::Array(along) if along == at);
            let array = declaration.parameters.iter().find(is_along)?;
            Some(numbers(array.name)?.len() as f64)
        })
    };
    let structure = declaration.structure.iter().enumerate().map(of_structure);
    let structure: Vec<f64> = structure.collect::<Option<_>>()?;
    let given = declaration.parameters.iter().map(|quantity| {
        let start = || quantity.start.map(|start| vec![start]);
        numbers(quantity.name).or_else(start)
    });
    let values = given.collect::<Option<Vec<_>>>()?.concat();
    Some((declaration.kind, structure.leak(), values.leak()))
}

/// Examples of the components that declare none and are not in `rigs/effects.toml`, or not with all their parts.
const OWN: &[Example] = &[
    ("amplifier-lag", &[], &[800.0, 1.1]),
    ("amplifier-foldback", &[], &[0.02, 0.1, 1e-6, 0.5]),
    ("amplifier-clamp", &[], &[-20.0, 120.0, 2.0]),
    ("actuator-gain", &[], &[0.05, 0.3]),
    ("thermal-port", &[], &[0.2, 0.02, 1.8e-6, 1e-3, 293.15, 1.0]),
    (
        "skewed-play",
        &[3.0],
        &[
            0.0, 8.0, 20.0, 0.05, 0.02, 0.01, 0.0, 0.004, -0.002, 0.3, 0.01, 0.2, 0.1, -0.05, 50.0,
            70.0,
        ],
    ),
    ("remanence", &[], &[0.5, 40.0]),
    ("mode", &[], &[482.6, 0.02, 1.1]),
    ("arx", &[2e-4, 2.0, 2.0], &[0.2, -0.1, -1.2, 0.3]),
    ("position-stiffness", &[], &[482.6, 0.02, 0.1, 0.05, 3.0, 5.0]),
    ("nonlinear-damping", &[], &[482.6, 0.02, 0.05, 40.0, 1e-6]),
    ("backlash", &[], &[0.05, 0.2]),
    ("mechanical-port", &[], &[]),
    ("command-coupling", &[2.0, 4.0], &[0.0, 1e-3, 2e-3, 0.0]),
    ("displacement-coupling", &[2.0, 4.0], &[0.0, 0.02, -0.03, 0.0]),
    ("mode-coupling", &[2.0, 4.0], &[0.0, 1e-3, 2e-3, 0.0, 480.0, 290.0, 0.02, 0.03]),
    (
        "modal-matrix",
        &[2.0, 4.0, 1.0, 4.0],
        &[0.3, 0.0, 0.0, 0.2, 480.0, 0.02, 0.7, 0.1, -0.2, 0.8, 0.01, 0.0, 0.0, -0.01],
    ),
    (
        "softening-modes",
        &[2.0, 4.0, 1.0, 4.0],
        &[
            0.3, 0.0, 0.0, 0.2, 480.0, 0.02, -0.05, 0.4, 0.7, 0.1, -0.2, 0.8, 0.01, 0.0, 0.0,
            -0.01, 5.0, 5.0, 1.0, 0.05,
        ],
    ),
    ("optics-jacobian", &[2.0, 4.0], &[1.0, 0.02, -0.03, 0.9, 3.0, -2.0]),
    ("psd-pincushion", &[2.0], &[0.01, 5000.0]),
    ("thermal-expansion", &[], &[0.02, 0.01, 20.0]),
    ("inverse-bouc-wen", &[], &[0.06, 0.2, 0.02, 0.01, 0.002, 1.0, 0.3, -20.0, 150.0]),
    ("inverse-duhem", &[], &[0.06, 0.04, 0.05, 0.3, -20.0, 150.0]),
    ("inverse-dahl", &[], &[0.06, 0.4, 20.0, 0.3, -20.0, 150.0]),
    (
        "inverse-rate-dependent-play",
        &[2.0],
        &[4.0, 12.0, 0.02, 0.01, 0.3, 0.05, 1e-5, -20.0, 150.0],
    ),
    ("inverse-grpi", &[2.0], &[0.0, 12.0, 0.05, 0.01, 0.3, 1.02, -1e-5, 0.99, 2e-5, -20.0, 150.0]),
    ("inverse-mpi", &[2.0], &[4.0, 12.0, 0.02, 0.01, 0.3, 0.05, 1e-8, 1.1, 1e-5, -20.0, 150.0]),
    (
        "inverse-dynamic-prandtl-ishlinskii",
        &[2.0, 4.0],
        &[
            0.0, 12.0, 0.05, 0.01, -1e-8, -1e-8, 1e-8, 1e-8, 1e-13, 1e-13, 1e-13, 1e-13, 0.3,
            -20.0, 150.0,
        ],
    ),
    ("reference-curve", &[3.0], &[0.0, 4.0, 9.0, 0.1, 3.8, 9.5]),
    ("command-curve", &[3.0], &[0.0, 50.0, 120.0, -2.0, 52.0, 118.0]),
];

/// The component of an example.
pub fn node((kind, structure, values): &Example) -> NodeSpec {
    let component = find(kind).unwrap_or_else(|| panic!("{kind} is not registered"));
    let name = component.declaration().name.to_string();
    let (structure, values) = (structure.to_vec(), values.to_vec());
    NodeSpec { component: component.into(), name, structure, values, enabled: true }
}

/// One component that turns command into position, or back.
pub fn gain(kind: &'static str) -> NodeSpec {
    let mut node = node(&(kind, &[], &[0.05, 0.3]));
    if kind == "feedforward-gain" {
        node.values = vec![20.0, 0.3];
    }
    node.name = "linear".into();
    node
}

/// A model of one axis with this component where its kind of signal is; of two axes around a
/// coupling.
pub fn system_of(node: NodeSpec) -> SystemSpec {
    let declaration = node.component.declaration();
    if declaration.conversion == Conversion::PositionToMotion {
        let linear = || vec![gain("feedforward-gain")];
        let axes = vec![axis("x", linear()), axis("y", linear())];
        let coupling = CouplingSpec { node, axes: vec![0, 1], after: None };
        return system(Kind::Controller, axes, vec![coupling]);
    }
    if declaration.is_coupling() {
        let axes =
            vec![axis("x", vec![gain("actuator-gain")]), axis("y", vec![gain("actuator-gain")])];
        let coupling = CouplingSpec { node, axes: vec![0, 1], after: None };
        return system(Kind::Plant, axes, vec![coupling]);
    }
    let before =
        declaration.stage <= Stage::Amplifier || declaration.kind == "polarisation-saturation";
    let (kind, components) = match declaration.conversion {
        Conversion::CommandToPosition => (Kind::Plant, vec![node]),
        Conversion::None if declaration.stage == Stage::Control => {
            (Kind::Controller, vec![node, gain("feedforward-gain")])
        }
        Conversion::None if before => (Kind::Plant, vec![node, gain("actuator-gain")]),
        Conversion::None | Conversion::MotionToPosition | Conversion::PositionToMotion => {
            (Kind::Plant, vec![gain("actuator-gain"), node])
        }
        Conversion::PositionToCommand => (Kind::Controller, vec![node]),
        Conversion::Control => (Kind::Controller, vec![gain("feedforward-gain"), node]),
    };
    system(kind, vec![axis("x", components)], Vec::new())
}

fn axis(name: &str, components: Vec<NodeSpec>) -> AxisSpec {
    AxisSpec {
        name: name.into(),
        command_unit: "V".into(),
        position_unit: "um".into(),
        command_range: (-1000.0, 1000.0),
        position_range: (f64::NEG_INFINITY, f64::INFINITY),
        start: 0.0,
        aliases: vec![],
        components,
    }
}

fn system(kind: Kind, axes: Vec<AxisSpec>, couplings: Vec<CouplingSpec>) -> SystemSpec {
    let connections = Connections { couplings, ..Connections::default() };
    SystemSpec { name: "test".into(), kind, period: T, axes, connections }
}
