//! Reads `<UnitDefinitions>`.

use super::values::{Attributes, Context};
use crate::description::{BaseUnit, DisplayUnit, FmiVersion, Line, Unit};

pub(super) fn units(context: &mut Context, at: Attributes<'_>) -> Vec<Unit> {
    context.expect(at, &[], &["Unit*"]);
    context.expect_some(at);
    let mut units = Vec::new();
    for element in at.element.children.iter().filter(|child| child.name == "Unit") {
        units.push(unit(context, Attributes { element, topic: at.topic }));
    }
    units
}

fn unit(context: &mut Context, at: Attributes<'_>) -> Unit {
    let children: &[&str] = match context.version {
        FmiVersion::V2 => &["BaseUnit", "DisplayUnit*"],
        FmiVersion::V3 => &["BaseUnit", "DisplayUnit*", "Annotations"],
    };
    context.expect(at, &["name"], children);
    let mut read = Unit {
        name: context.required_text(at, "name"),
        base: None,
        display_units: Vec::new(),
        line: Line(at.element.line),
    };
    for element in &at.element.children {
        let at = Attributes { element, topic: at.topic };
        match element.name.as_str() {
            "BaseUnit" => read.base = Some(base_unit(context, at)),
            "DisplayUnit" => read.display_units.push(display_unit(context, at)),
            _ => {}
        }
    }
    read
}

fn base_unit(context: &mut Context, at: Attributes<'_>) -> BaseUnit {
    let attributes = ["kg", "m", "s", "A", "K", "mol", "cd", "rad", "factor", "offset"];
    context.expect(at, &attributes, &[]);
    let mut exponent = |name| context.integer(at, name).unwrap_or_default();
    BaseUnit {
        kg: exponent("kg"),
        m: exponent("m"),
        s: exponent("s"),
        a: exponent("A"),
        k: exponent("K"),
        mol: exponent("mol"),
        cd: exponent("cd"),
        rad: exponent("rad"),
        factor: context.float(at, "factor").unwrap_or(1.0),
        offset: context.float(at, "offset").unwrap_or(0.0),
    }
}

fn display_unit(context: &mut Context, at: Attributes<'_>) -> DisplayUnit {
    match context.version {
        FmiVersion::V2 => context.expect(at, &["name", "factor", "offset"], &[]),
        FmiVersion::V3 => {
            context.expect(at, &["name", "factor", "offset", "inverse"], &["Annotations"]);
        }
    }
    DisplayUnit {
        name: context.required_text(at, "name"),
        factor: context.float(at, "factor").unwrap_or(1.0),
        offset: context.float(at, "offset").unwrap_or(0.0),
        inverse: context.version == FmiVersion::V3 && context.flag(at, "inverse"),
        line: Line(at.element.line),
    }
}
