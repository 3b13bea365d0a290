//! A quantity: declared once, on one line, at its field.

use alloc::string::String;

use crate::{Effect, Unit};

/// When a value may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Set before the run, constant in it.
    Fixed,
    /// May change during the run; effective at the next step.
    Tunable,
}

/// How many values a quantity has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One value.
    Scalar,
    /// As many values as the structural setting with this index says.
    Array(usize),
}

/// What bounds a quantity beside its own least and greatest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Within {
    /// Nothing.
    Any,
    /// The least and the greatest command of its axis.
    Commands,
    /// The structural settings with these indices: the least value, where one says it, the greatest.
    Settings(Option<usize>, usize),
}

/// What a quantity is to those who know its component only by what it declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Thresholds of plays, in the unit of the command.
    Threshold,
    /// Weights of these plays, in position per command.
    Weight,
    /// A part without memory beside plays, in position per command.
    Slope,
    /// Undamped natural frequency of a mode.
    Frequency,
    /// Damping ratio of a mode.
    Damping,
    /// Static gain of a mode.
    Gain,
}

/// A parameter of a component: name, unit, sentence, start, bounds, and whether it may be fitted.
///
/// The unit is a text in which `{command}` and `{position}` stand for the units of the axis, so that
/// the same component serves an axis in um and one in urad: a play weight has the unit
/// `{position}/{command}`.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Name, the blueprint's key and the last part of the FMI name.
    pub name: &'static str,
    /// Unit, with `{command}` and `{position}` for the axis' own.
    pub unit: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// Default; `None` where the value could be anything and must be given.
    pub start: Option<f64>,
    /// Least value allowed, in [`unit`](Self::unit).
    pub min: f64,
    /// Greatest value allowed.
    pub max: f64,
    /// What else bounds it.
    pub within: Within,
    /// Number of values.
    pub shape: Shape,
    /// Whether it may change during a run.
    pub variability: Variability,
    /// Whether an identification may fit it.
    pub fit: bool,
    /// Whether it is the seed of noise: the component then sees it mixed with its own place in the
    /// model, so that two components never draw the same numbers.
    pub is_seed: bool,
    /// What the quantity is to others, where they ask.
    pub role: Option<Role>,
    /// The effect that a machine has where this quantity is off by more than its tolerance.
    pub releases: Option<&'static Effect>,
}

impl Quantity {
    /// A fixed scalar that must be given and may take any finite value.
    #[must_use]
    pub const fn new(name: &'static str, unit: &'static str, description: &'static str) -> Self {
        Self {
            name,
            unit,
            description,
            start: None,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            within: Within::Any,
            shape: Shape::Scalar,
            variability: Variability::Fixed,
            fit: false,
            is_seed: false,
            role: None,
            releases: None,
        }
    }
    /// With this default.
    #[must_use]
    pub const fn start(mut self, value: f64) -> Self {
        self.start = Some(value);
        self
    }
    /// With this least value.
    #[must_use]
    pub const fn min(mut self, value: f64) -> Self {
        self.min = value;
        self
    }
    /// With this greatest value.
    #[must_use]
    pub const fn max(mut self, value: f64) -> Self {
        self.max = value;
        self
    }
    /// A command: from the least to the greatest one of its axis.
    #[must_use]
    pub const fn a_command(mut self) -> Self {
        self.within = Within::Commands;
        self
    }
    /// At most what structural setting number `greatest` says.
    #[must_use]
    pub const fn at_most(mut self, greatest: usize) -> Self {
        self.within = Within::Settings(None, greatest);
        self
    }
    /// From what structural setting number `least` says to what number `greatest` says.
    #[must_use]
    pub const fn from_to(mut self, least: usize, greatest: usize) -> Self {
        self.within = Within::Settings(Some(least), greatest);
        self
    }
    /// An array with as many values as structural setting number `index` says.
    #[must_use]
    pub const fn per(mut self, index: usize) -> Self {
        self.shape = Shape::Array(index);
        self
    }
    /// May change during a run.
    #[must_use]
    pub const fn tunable(mut self) -> Self {
        self.variability = Variability::Tunable;
        self
    }
    /// Is the seed of noise.
    #[must_use]
    pub const fn seed(mut self) -> Self {
        self.is_seed = true;
        self
    }
    /// Is this to others.
    #[must_use]
    pub const fn role(mut self, role: Role) -> Self {
        self.role = Some(role);
        self
    }
    /// Stands for this effect where it is off.
    #[must_use]
    pub const fn releases(mut self, effect: &'static Effect) -> Self {
        self.releases = Some(effect);
        self
    }
    /// May be fitted by an identification and varied by a diagnosis.
    #[must_use]
    pub const fn fitted(mut self) -> Self {
        self.fit = true;
        self
    }
    /// Least and greatest value in a component with these structural settings, on an axis with these
    /// commands.
    #[must_use]
    pub fn bounds(&self, structure: &[f64], commands: (f64, f64)) -> (f64, f64) {
        let setting = |index: usize, free: f64| structure.get(index).copied().unwrap_or(free);
        let (least, greatest) = match self.within {
            Within::Any => (self.min, self.max),
            Within::Commands => commands,
            Within::Settings(least, greatest) => {
                (least.map_or(self.min, |k| setting(k, self.min)), setting(greatest, self.max))
            }
        };
        (least.max(self.min), greatest.min(self.max))
    }
}

/// A structural setting: it fixes the variable table and the arenas, so it lives in the blueprint
/// only and is no variable of the FMU.
#[derive(Clone, Copy, Debug)]
pub struct Structural {
    /// Name, the blueprint's key.
    pub name: &'static str,
    /// Unit, fixed (`1` for a count).
    pub unit: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// Default; `None`: taken from the length of the arrays that depend on it, else must be given.
    pub start: Option<f64>,
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Whether it is a count.
    pub integer: bool,
}

impl Structural {
    /// A count from `min` to `max`, by default the length of the arrays that depend on it.
    #[must_use]
    pub const fn count(
        name: &'static str,
        description: &'static str,
        min: usize,
        max: usize,
    ) -> Self {
        Self {
            name,
            unit: "1",
            description,
            start: None,
            min: min as f64,
            max: max as f64,
            integer: true,
        }
    }
    /// A real number with a default.
    #[must_use]
    pub const fn real(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        start: f64,
        min: f64,
        max: f64,
    ) -> Self {
        Self { name, unit, description, start: Some(start), min, max, integer: false }
    }
}

/// A unit text with `{command}` and `{position}` replaced by the units of an axis, and `{si_position}` by
/// the SI unit of its position, in a form that [`Unit::parse`](crate::Unit::parse) reads: a compound unit
/// in a denominator is inverted, and factors of 1 are dropped.
#[must_use]
pub fn unit_on_axis(unit: &str, command: &str, position: &str) -> String {
    let mut text = String::new();
    let mut sign = '.';
    let mut rest = unit;
    while !rest.is_empty() {
        let end = rest.find(['.', '/']).unwrap_or(rest.len());
        let symbol = match &rest[..end] {
            "{command}" => command,
            "{position}" => position,
            "{si_position}" => in_si(position),
            other => other,
        };
        append(&mut text, sign, symbol);
        sign = rest[end..].chars().next().unwrap_or('.');
        rest = rest.get(end + 1..).unwrap_or("");
    }
    if text.is_empty() { String::from("1") } else { text }
}

/// The SI unit of a length, an angle or a ratio; another unit is kept.
fn in_si(unit: &str) -> &str {
    let is_like = |si: &&&str| match (Unit::parse(unit), Unit::parse(si)) {
        (Ok(unit), Ok(si)) => unit.is_compatible(&si),
        _ => false,
    };
    ["m", "rad", "1"].iter().find(is_like).unwrap_or(&unit)
}

/// Appends `symbol`, whose own factors change sides where `sign` is a `/`.
fn append(text: &mut String, sign: char, symbol: &str) {
    let mut inner = '.';
    let mut rest = symbol;
    while !rest.is_empty() {
        let end = rest.find(['.', '/']).unwrap_or(rest.len());
        let factor = &rest[..end];
        let joined = if inner == sign { '.' } else { '/' };
        if !matches!(factor, "" | "1") {
            match (text.is_empty(), joined) {
                (true, '.') => {}
                (true, _) => text.push_str("1/"),
                (false, joined) => text.push(joined),
            }
            text.push_str(factor);
        }
        inner = rest[end..].chars().next().unwrap_or('.');
        rest = rest.get(end + 1..).unwrap_or("");
    }
}

#[cfg(test)]
mod tests {
    use super::unit_on_axis;

    #[test]
    fn units_take_the_axis_units() {
        assert_eq!(unit_on_axis("{position}/{command}", "V", "um"), "um/V");
        assert_eq!(unit_on_axis("{command}/{position}/s", "V", "um"), "V/um/s");
        assert_eq!(unit_on_axis("{position}/{command}", "V", "1"), "1/V");
        assert_eq!(unit_on_axis("{position}/{command}", "1", "1"), "1");
        assert_eq!(unit_on_axis("{position}", "V", "mm/m"), "mm/m");
        assert_eq!(unit_on_axis("{command}/{position}", "V", "mm/m"), "V/mm.m");
        assert_eq!(unit_on_axis("Hz", "V", "um"), "Hz");
        assert_eq!(unit_on_axis("{si_position}/s", "V", "um"), "m/s");
        assert_eq!(unit_on_axis("{si_position}", "V", "urad"), "rad");
        assert_eq!(unit_on_axis("{si_position}", "V", "%"), "1");
        assert_eq!(unit_on_axis("{si_position}", "V", "kg"), "kg");
        assert_eq!(unit_on_axis("1/s", "V", "um"), "1/s");
    }
}
