//! `pack --ports`: what a simulator of a whole system connects to a plant, per axis: force and motion of the
//! tip, voltage, current and charge, temperature and heat.
//!
//! Each port is a component of the blueprint; what its physics needs is given, or stands in a record that
//! the blueprint takes, or the port is refused. Two things are found out on the plant itself: its static
//! gain, and whether a force at its tip meets a passive structure.

use std::collections::BTreeMap;

use anyhow::{Context as _, anyhow, bail};
use data::{AxisBlueprint, Blueprint, ComponentBlueprint, Value};
use model::{Conversion, Declaration, Kind, Role, Source, Stage, Unit};
use serde::Serialize;

use crate::effects;

mod physics;
mod probe;
mod terminals;

use probe::Probe;
pub(crate) use terminals::terminals;

/// What a port carries.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Port {
    /// Force on the tip, its position and velocity
    Mechanical,
    /// Voltage at the actuator, current into it, its charge
    Electrical,
    /// Temperature of the actuator, heat out of it
    Thermal,
}

/// What terminals look like.
pub(crate) const ICONS: &[(&str, &[u8])] = &[
    ("mechanical", include_bytes!("icons/mechanical.png")),
    ("electrical", include_bytes!("icons/electrical.png")),
    ("thermal", include_bytes!("icons/thermal.png")),
];

impl Port {
    const ALL: [Self; 3] = [Self::Mechanical, Self::Electrical, Self::Thermal];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Mechanical => "mechanical",
            Self::Electrical => "electrical",
            Self::Thermal => "thermal",
        }
    }

    /// The port's members without the number of the axis, and how FMI 3.0 counts each: what flows in, what flows
    /// out, or a signal.
    pub(crate) fn members(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Mechanical => {
                &[("force", "inflow"), ("tip", "signal"), ("tip_velocity", "signal")]
            }
            Self::Electrical => {
                &[("voltage", "signal"), ("current", "inflow"), ("charge", "signal")]
            }
            Self::Thermal => &[("actuator_temperature", "signal"), ("heat", "outflow")],
        }
    }

    /// The component that gives a name of the port, and the values that it needs and may have.
    fn parts(self) -> &'static [Part] {
        match self {
            Self::Mechanical => &[
                Part { gives: "force", kind: "load-force", needs: &["stiffness"], takes: &[] },
                Part { gives: "tip", kind: "mechanical-port", needs: &[], takes: &[] },
            ],
            Self::Electrical => &[Part {
                gives: "charge",
                kind: "piezo-charge",
                needs: &["capacitance"],
                takes: &["transduction"],
            }],
            Self::Thermal => &[Part {
                gives: "heat",
                kind: "thermal-port",
                needs: &["growth", "loss", "capacitance"],
                takes: &["coefficient"],
            }],
        }
    }
}

/// A component of a port.
struct Part {
    /// The input or output that shows that an axis has it.
    gives: &'static str,
    kind: &'static str,
    needs: &'static [&'static str],
    takes: &'static [&'static str],
}

/// What each quantity is, for who must state it: name, an example, where it is found.
const QUANTITIES: [(&str, &str, &str); 6] = [
    (
        "stiffness",
        "20 N/um",
        "static stiffness at the tip, of the actuator with its flexure: data sheet",
    ),
    ("capacitance", "3.1 uF", "capacitance of the actuator at constant length: data sheet"),
    (
        "transduction",
        "2.5 C/m",
        "charge per displacement = force per voltage of the blocked actuator",
    ),
    ("growth", "0.2 um/K", "change of the tip's position per kelvin"),
    ("loss", "0.02", "loss tangent of the ceramic"),
    ("coefficient", "0.002 1/K", "relative change of the gain per kelvin"),
];

/// A port that was asked for: on one axis, or on all.
#[derive(Clone, Debug)]
pub(crate) struct Wish {
    axis: Option<String>,
    port: Port,
}

/// Reads `KIND` or `AXIS.KIND`.
pub(crate) fn wish(text: &str) -> Result<Wish, String> {
    let (axis, word) = match text.rsplit_once('.') {
        Some((axis, word)) => (Some(axis.to_owned()), word),
        None => (None, text),
    };
    let found = Port::ALL.into_iter().find(|port| port.name() == word);
    let port = found.ok_or_else(|| {
        let meant = crate::inputs::meant(word, Port::ALL.map(Port::name));
        format!("{meant}write mechanical, electrical or thermal, or AXIS.mechanical for one axis")
    })?;
    Ok(Wish { axis, port })
}

/// A value that a port needs, as somebody gave it: on one axis, or on all.
#[derive(Clone, Debug)]
pub(crate) struct Given {
    axis: Option<String>,
    quantity: &'static str,
    value: Value,
    text: String,
}

/// Reads `QUANTITY=VALUE` or `AXIS.QUANTITY=VALUE`.
pub(crate) fn given(text: &str) -> Result<Given, String> {
    let (name, value) = text
        .split_once('=')
        .ok_or("write QUANTITY=VALUE or AXIS.QUANTITY=VALUE, as in 'stiffness=20 N/um'")?;
    let (axis, word) = match name.trim().rsplit_once('.') {
        Some((axis, word)) => (Some(axis.to_owned()), word),
        None => (None, name.trim()),
    };
    let names = QUANTITIES.map(|(name, ..)| name);
    let quantity = names.into_iter().find(|name| *name == word).ok_or_else(|| {
        let meant = crate::inputs::meant(word, names);
        format!("{word} is no value of a port; {meant}they are {}", names.join(", "))
    })?;
    let value = value.trim();
    let value = value.parse().map_or_else(|_| Value::Text(value.to_owned()), Value::Number);
    Ok(Given { axis, quantity, value, text: text.to_owned() })
}

/// A port that an axis has.
#[derive(Serialize)]
pub(crate) struct Offered {
    axis: String,
    pub(crate) port: Port,
    /// Its variables in the FMU.
    variables: Vec<String>,
    /// The values that were put in, each with where it comes from.
    values: BTreeMap<&'static str, Stated>,
    /// What there is to know about it.
    notes: Vec<String>,
}

/// A value that was put in.
#[derive(Serialize)]
struct Stated {
    value: String,
    from: String,
}

impl Offered {
    /// Sentences for people.
    pub(crate) fn sentences(&self) -> Vec<String> {
        let values = self.values.iter();
        let values: Vec<String> =
            values.map(|(name, s)| format!("{name} {} ({})", s.value, s.from)).collect();
        let mut all = vec![format!(
            "{} port of axis {}: {}{}",
            self.port.name(),
            self.axis,
            self.variables.join(", "),
            if values.is_empty() { String::new() } else { format!("; {}", values.join(", ")) }
        )];
        all.extend(self.notes.iter().map(|note| format!("  {note}")));
        all
    }
}

fn declaration(kind: &str) -> Option<&'static Declaration> {
    let mut all = learned::COMPONENTS.iter();
    all.find(|component| component.declaration().kind == kind).map(|c| c.declaration())
}

/// Whether a component reads this input of its axis, or publishes this output.
fn gives(component: &ComponentBlueprint, name: &str) -> bool {
    declaration(&component.kind).is_some_and(|declared| {
        let reads = |source| matches!(source, Source::Axis(read) if read == name);
        declared.inputs.iter().any(|port| name == "force" && reads(port.source))
            || declared.outputs.iter().any(|o| o.published.is_some() && o.name == name)
    })
}

fn name_of(axis: &AxisBlueprint, index: usize) -> String {
    if axis.name.is_empty() { format!("axis{}", index + 1) } else { axis.name.clone() }
}

/// Adds the ports that were asked for, and says what was assumed.
///
/// # Errors
/// A port whose physics the plant does not have, a value that is missing, unknown or not used.
pub(crate) fn add(
    blueprint: &mut Blueprint,
    wishes: &[Wish],
    values: &[Given],
) -> anyhow::Result<Vec<Offered>> {
    if blueprint.kind != Kind::Plant {
        bail!("{}: --ports adds ports to a plant, and this is a controller", blueprint.name);
    }
    // Whatever is wrong in the blueprint itself is said with its lines.
    blueprint.check(learned::COMPONENTS)?;
    let names: Vec<String> =
        blueprint.axes.iter().enumerate().map(|(index, axis)| name_of(axis, index)).collect();
    for axis in wishes.iter().map(|w| &w.axis).chain(values.iter().map(|v| &v.axis)).flatten() {
        if !names.contains(axis) {
            let meant = crate::inputs::meant(axis, names.iter().map(String::as_str));
            bail!("no axis is called {axis}; {meant}axes are {}", names.join(", "));
        }
    }
    let mut offered = Vec::new();
    let mut used = vec![false; values.len()];
    for (index, name) in names.iter().enumerate() {
        for port in Port::ALL {
            let is_for = |wish: &&Wish| {
                wish.port == port && wish.axis.as_ref().is_none_or(|axis| axis == name)
            };
            if wishes.iter().any(|wish| is_for(&wish)) {
                let mut maker = Maker { blueprint, index, name, values, used: &mut used };
                offered.push(
                    maker
                        .offer(port)
                        .with_context(|| format!("axis {name}, {} port", port.name()))?,
                );
            }
        }
    }
    if let Some((given, _)) = values.iter().zip(&used).find(|(_, used)| !**used) {
        bail!(
            "--port-value '{}': no port that is added needs it; leave it out, or change the blueprint where \
             the component is there already",
            given.text
        );
    }
    Ok(offered)
}

/// The ports of one axis.
struct Maker<'a> {
    blueprint: &'a mut Blueprint,
    index: usize,
    name: &'a str,
    values: &'a [Given],
    used: &'a mut [bool],
}

impl Maker<'_> {
    fn axis(&mut self) -> &mut AxisBlueprint {
        &mut self.blueprint.axes[self.index]
    }

    fn offer(&mut self, port: Port) -> anyhow::Result<Offered> {
        if port == Port::Mechanical {
            self.refuse_what_is_no_length()?;
        }
        let mut offered = Offered {
            axis: self.name.to_owned(),
            port,
            variables: Vec::new(),
            values: BTreeMap::new(),
            notes: Vec::new(),
        };
        let mut added_force = false;
        for part in port.parts() {
            if self.axis().components.iter().any(|component| gives(component, part.gives)) {
                offered.notes.push(format!("{} is in the blueprint already", part.gives));
                continue;
            }
            let mut component = ComponentBlueprint::new(part.kind);
            let (mut missing, mut described) = (Vec::new(), Vec::new());
            for quantity in part.needs.iter().chain(part.takes) {
                match self.value(part.kind, quantity) {
                    Some((value, from)) => {
                        let shown = shown(&value);
                        described.push(format!("{quantity} {from}"));
                        component.set(quantity, value);
                        offered.values.insert(quantity, Stated { value: shown, from });
                    }
                    None if part.needs.contains(quantity) => missing.push(*quantity),
                    None => {}
                }
            }
            if !missing.is_empty() {
                bail!("{}", self.must_be_stated(&missing, " and "));
            }
            component.note = described.join("; ");
            self.insert(component, part)?;
            added_force |= part.gives == "force";
        }
        self.values_fit()?;
        match port {
            Port::Mechanical => self.mechanical(added_force, &mut offered)?,
            Port::Electrical => self.electrical(&mut offered)?,
            Port::Thermal => {}
        }
        let number = self.index + 1;
        offered.variables =
            port.members().iter().map(|(name, _)| format!("{name}[{number}]")).collect();
        Ok(offered)
    }

    /// Whether the values that were put in fit their components; they stand in no line of a file.
    fn values_fit(&self) -> anyhow::Result<()> {
        let Err(problems) = self.blueprint.check(learned::COMPONENTS) else { return Ok(()) };
        let message = problems.as_slice().iter().map(|problem| {
            format!("{} = {}: {}; {}", problem.place, problem.value, problem.rule, problem.way_out)
        });
        bail!("{}", message.collect::<Vec<_>>().join("\n"))
    }

    fn refuse_what_is_no_length(&mut self) -> anyhow::Result<()> {
        let axis = self.axis();
        if !axis.motion.unit.is_empty() {
            bail!(
                "its motion is in {}, which optics turn into a position: there is no tip that a force in N moves; \
                 ask for the other ports alone",
                axis.motion.unit
            );
        }
        let unit = axis.position.unit.clone();
        let metre = Unit::parse("m").map_err(|e| anyhow!("{e}"))?;
        if !Unit::parse(&unit).is_ok_and(|unit| unit.is_compatible(&metre)) {
            bail!(
                "its position is in {unit}, and a force in N moves lengths; ask for the other ports alone, or write \
                 AXIS.mechanical for the axes that have a length"
            );
        }
        Ok(())
    }

    /// A value that was given, or stands in the one record that has it.
    fn value(&mut self, kind: &str, quantity: &str) -> Option<(Value, String)> {
        let mut found = None;
        for (at, given) in self.values.iter().enumerate() {
            let is_own = given.axis.as_deref() == Some(self.name);
            if given.quantity == quantity && (is_own || given.axis.is_none()) {
                self.used[at] = true;
                // What is given for the axis goes before what is given for all.
                if found.is_none() || is_own {
                    found = Some((given.value.clone(), "given with --port-value".to_owned()));
                }
            }
        }
        found.or_else(|| {
            let records = self.blueprint.recorded(kind);
            let mut stated = records.iter().filter_map(|(record, values)| {
                let value = values.iter().find(|value| value.name == quantity)?;
                Some((value.value.clone(), format!("record {record}: {}", value.source)))
            });
            let first = stated.next();
            if stated.next().is_some() { None } else { first }
        })
    }

    fn must_be_stated(&self, missing: &[&str], joint: &str) -> String {
        let lines = QUANTITIES.iter().filter(|(name, ..)| missing.contains(name));
        let ways: Vec<String> = lines
            .map(|(name, example, what)| {
                format!("--port-value '{}.{name}={example}' ({what})", self.name)
            })
            .collect();
        format!(
            "neither the blueprint nor a record that it takes states {}; state it, for example {}",
            missing.join(joint),
            ways.join(joint)
        )
    }

    fn insert(&mut self, mut component: ComponentBlueprint, part: &Part) -> anyhow::Result<()> {
        let declared = declaration(part.kind).context("a component of the registry")?;
        let axis = self.axis();
        let at = if part.gives == "force" { in_front_of_the_last_mode(axis) } else { None };
        let at = match at {
            Some(at) => at,
            None => effects::place(axis, declared)?,
        };
        let mut name = declared.name.to_owned();
        while axis.components.iter().any(|other| {
            let own = declaration(&other.kind).map_or("", |d| d.name);
            name == if other.name.is_empty() { own } else { &other.name }
        }) {
            name.push_str("_port");
        }
        component.name = name;
        axis.components.insert(at, component);
        Ok(())
    }

    /// The model as it would be packed, with motion and voltage of this axis to be read.
    fn probe(&mut self) -> anyhow::Result<Probe> {
        let mut copy = self.blueprint.clone();
        let index = self.index;
        let axis = &mut copy.axes[index];
        for (gives_, kind, value) in [
            ("tip", "mechanical-port", None),
            ("charge", "piezo-charge", Some(("capacitance", 1e-6))),
        ] {
            if !axis.components.iter().any(|component| gives(component, gives_)) {
                let declared = declaration(kind).context("a component of the registry")?;
                let mut component = ComponentBlueprint::new(kind).named(&format!("probe_{gives_}"));
                if let Some((name, value)) = value {
                    component.set(name, Value::Number(value));
                }
                let at = effects::place(axis, declared)?;
                axis.components.insert(at, component);
            }
        }
        let system = copy.check(learned::COMPONENTS)?.build();
        Probe::new(system, index + 1)
    }

    /// The stiffness in N/m that a force meets at the tip at rest, or nothing where the axis has no force.
    fn stiffness(&mut self) -> anyhow::Result<Option<f64>> {
        if !self.axis().components.iter().any(|component| gives(component, "force")) {
            return Ok(None);
        }
        let probe = self.probe()?;
        // As much as bends what is as soft as a stage or as stiff as a stack by far more than rounding does.
        const FORCE: f64 = 1e-2;
        let rest = probe.at_rest(None, 0.0)?.0;
        let bent = probe.at_rest(None, FORCE)?.0;
        Ok(Some(FORCE / (bent - rest)))
    }
}

fn shown(value: &Value) -> String {
    match value {
        Value::Number(number) => number.to_string(),
        Value::Text(text) => text.clone(),
        Value::List(_) => "a list".to_owned(),
    }
}

/// In front of the enabled mode that is nearest to the tip: a force there meets this mode's own mass, spring
/// and damper, which are passive; a second mode between the two would not be.
fn in_front_of_the_last_mode(axis: &AxisBlueprint) -> Option<usize> {
    axis.components.iter().rposition(|component| {
        component.enabled
            && declaration(&component.kind).is_some_and(|declared| {
                declared.stage == Stage::Mechanics
                    && declared.conversion == Conversion::None
                    && declared.parameters.iter().any(|q| q.role == Some(Role::Frequency))
            })
    })
}
