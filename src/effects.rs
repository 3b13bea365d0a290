//! Every effect of the registry at its default strength: added to a blueprint, or tried on a loop.

use anyhow::{Context, bail};
use data::{
    AxisBlueprint, Blueprint, ComponentBlueprint, CouplingBlueprint, SignalBlueprint, Value,
};
use model::{Component, Conversion, Declaration, Kind, Shape, Stage};

/// The blueprint of all effects: the rig `effects`, and an axis for each component that makes a position of the
/// command and declares an example.
pub(crate) fn library() -> anyhow::Result<Blueprint> {
    let mut library = Blueprint::parse(rigs::EFFECTS, "effects.toml")?;
    for component in components::COMPONENTS {
        let declared = component.declaration();
        if declared.conversion == Conversion::CommandToPosition && !component.example().is_empty() {
            library.axes.push(axis_of(*component));
        }
    }
    Ok(library)
}

/// An axis with the example of a component.
fn axis_of(component: &dyn Component) -> AxisBlueprint {
    let kind = component.declaration().kind;
    let name = kind.replace('-', "_");
    let mut axis = AxisBlueprint::new(&name, "V", "um");
    axis.command = SignalBlueprint::of_unit("V").between(0.0, 150.0);
    let mut part = ComponentBlueprint::new(kind);
    for (name, values) in component.example() {
        match values {
            [value] if !is_list(component, name) => part.set(name, *value),
            _ => part.set(name, values.to_vec()),
        }
    }
    part.name = name;
    axis.components = vec![part];
    axis
}

/// Whether this quantity of a component has several values.
fn is_list(component: &dyn Component, name: &str) -> bool {
    let quantity = component.declaration().parameters.iter().find(|quantity| quantity.name == name);
    quantity.is_some_and(|quantity| matches!(quantity.shape, Shape::Array(_)))
}

fn declaration(kind: &str) -> anyhow::Result<&'static Declaration> {
    let component = components::find(kind);
    Ok(component.with_context(|| format!("no component is named {kind}"))?.declaration())
}

/// Adds every effect that a plant does not have yet, switched off, at its stage of each axis, and the
/// couplings where it has axes to couple.
pub(crate) fn add_all(blueprint: &mut Blueprint) -> anyhow::Result<()> {
    if blueprint.kind != Kind::Plant {
        bail!(
            "{}: --all-effects adds effects to a plant, and this is a controller",
            blueprint.name
        );
    }
    let library = library()?;
    let all = library.axes.first().context("the library of effects has an axis")?;
    for axis in &mut blueprint.axes {
        for effect in &all.components {
            let declared = declaration(&effect.kind)?;
            if declared.can_be_disabled() && !axis.components.iter().any(|c| c.kind == effect.kind)
            {
                let at = place(axis, declared)?;
                let mut off = effect.clone().enabled(false);
                while axis.components.iter().any(|c| name_of(c).as_deref() == Some(&off.name)) {
                    off.name.push_str("_effect");
                }
                axis.components.insert(at, off);
            }
        }
    }
    let count = blueprint.axes.len();
    let unit = |axis: &AxisBlueprint| (axis.command.unit.clone(), axis.position.unit.clone());
    let alike = blueprint.axes.windows(2).all(|pair| unit(&pair[0]) == unit(&pair[1]));
    for coupling in library.couplings {
        let declared = declaration(&coupling.component.kind)?;
        let has = blueprint.couplings.iter().any(|c| c.component.kind == coupling.component.kind);
        let fits = (2..=most_axes(declared)).contains(&count);
        if !has && fits && alike && declared.can_be_disabled() {
            blueprint.couplings.push(over(coupling, &blueprint.axes));
        }
    }
    Ok(())
}

/// Most axes of a coupling, by its ports and its own settings.
fn most_axes(declared: &Declaration) -> usize {
    let own = declared.structure.iter().find(|setting| setting.name == "axes");
    own.map_or(0, |setting| declared.most_axes().min(setting.max as usize))
}

/// A coupling without effect over all these axes.
fn over(mut coupling: CouplingBlueprint, axes: &[AxisBlueprint]) -> CouplingBlueprint {
    coupling.axes = (1..)
        .zip(axes)
        .map(
            |(number, axis)| {
                if axis.name.is_empty() { format!("axis{number}") } else { axis.name.clone() }
            },
        )
        .collect();
    for (name, value) in &mut coupling.component.values {
        let Value::List(items) = value else { continue };
        let first = items.first().cloned().unwrap_or(Value::Number(0.0));
        *value = if name == "matrix" {
            Value::List(vec![Value::Number(0.0); axes.len() * axes.len()])
        } else {
            Value::List(vec![first; axes.len()])
        };
    }
    coupling.component.enabled = false;
    coupling
}

fn name_of(component: &ComponentBlueprint) -> Option<String> {
    if component.name.is_empty() {
        return declaration(&component.kind).ok().map(|d| d.name.to_owned());
    }
    Some(component.name.clone())
}

/// Where on an axis an effect belongs: behind the last component of its stage or an earlier one; in
/// front of the one that makes a position of the command where it acts on the voltage.
pub(crate) fn place(axis: &AxisBlueprint, effect: &Declaration) -> anyhow::Result<usize> {
    let turns = |c: &ComponentBlueprint| {
        declaration(&c.kind).is_ok_and(|d| d.conversion == model::Conversion::CommandToPosition)
    };
    let turn = axis.components.iter().position(turns).unwrap_or(axis.components.len());
    // In the actuator: where its values are in the unit of the command, and the signal of the path is that command.
    let in_command = effect.parameters.iter().any(|q| q.unit == "{command}");
    let on_voltage = effect.stage <= Stage::Amplifier || (in_command && effect.inputs.len() == 1);
    let mut at = 0;
    for (index, component) in axis.components.iter().enumerate() {
        if declaration(&component.kind)?.stage <= effect.stage {
            at = index + 1;
        }
    }
    Ok(if on_voltage { at.min(turn) } else { at.max((turn + 1).min(axis.components.len())) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_is_in_the_library_and_fits_every_plant() {
        let library = library().unwrap_or_else(|e| panic!("{e:#}"));
        library.check(components::COMPONENTS).unwrap_or_else(|e| panic!("{e}"));
        let axes = library.axes.iter().flat_map(|axis| &axis.components);
        let kinds: Vec<&str> = axes
            .chain(library.couplings.iter().map(|c| &c.component))
            .map(|c| c.kind.as_str())
            .collect();
        for component in components::COMPONENTS {
            let declared = component.declaration();
            assert!(
                !declared.can_be_disabled() || kinds.contains(&declared.kind),
                "{}",
                declared.kind
            );
        }
        for rig in rigs::RIGS {
            let mut blueprint =
                Blueprint::parse(rig.blueprint, rig.name).unwrap_or_else(|e| panic!("{e}"));
            add_all(&mut blueprint).unwrap_or_else(|e| panic!("{e:#}"));
            let checked = blueprint.check(components::COMPONENTS);
            let checked = checked.unwrap_or_else(|e| panic!("{}: {e}", rig.name));
            let variables = checked.system().variables();
            assert!(
                variables.as_slice().iter().filter(|v| v.name.ends_with(".enabled")).count() > 20
            );
        }
    }

    /// Adding all effects, switched off, changes no bit of any output.
    #[test]
    fn all_effects_switched_off_are_absent_to_the_bit() {
        for rig in rigs::RIGS {
            let plain = Blueprint::parse(rig.blueprint, rig.name).unwrap_or_else(|e| panic!("{e}"));
            let mut with = plain.clone();
            add_all(&mut with).unwrap_or_else(|e| panic!("{e:#}"));
            let build = |b: &Blueprint| {
                b.check(components::COMPONENTS).unwrap_or_else(|e| panic!("{e}")).build()
            };
            let (mut plain, mut with) = (build(&plain), build(&with));
            let period = plain.period();
            for n in 0..400_u32 {
                for system in [&mut plain, &mut with] {
                    for axis in 1..=4 {
                        if let Some(command) = system.variables().find(&format!("command[{axis}]"))
                        {
                            let wave = 1.5 * (1.0 - (0.05 * f64::from(n) + f64::from(axis)).cos());
                            system.set(command, wave).expect("in range");
                        }
                    }
                    system.advance(f64::from(n + 1) * period).expect("finite");
                }
                for axis in 1..=4 {
                    let read = |system: &model::System| {
                        let found = system.variables().find(&format!("position[{axis}]"));
                        found.and_then(|p| system.get(p)).map(f64::to_bits)
                    };
                    assert_eq!(read(&plain), read(&with), "{} axis {axis}, hit {n}", rig.name);
                }
            }
        }
    }
}
