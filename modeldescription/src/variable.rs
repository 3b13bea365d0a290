//! Variables of an FMU.

use crate::names::named;
use crate::version::FmiVersion;
use crate::xml::Line;

named! {
    /// What a variable is for.
    Causality {
        /// Set by the user before the run.
        Parameter = "parameter",
        /// Computed from parameters.
        CalculatedParameter = "calculatedParameter",
        /// Set by the importer.
        Input = "input",
        /// Read by the importer.
        Output = "output",
        /// Internal, readable.
        Local = "local",
        /// The independent variable, usually time.
        Independent = "independent",
        /// Sets the sizes of arrays (3.0).
        StructuralParameter = "structuralParameter",
    }
}

named! {
    /// When a variable may change.
    Variability {
        /// Never.
        Constant = "constant",
        /// Not after initialisation.
        Fixed = "fixed",
        /// When the user changes a tunable parameter.
        Tunable = "tunable",
        /// At events or communication points.
        Discrete = "discrete",
        /// At any time.
        Continuous = "continuous",
    }
}

named! {
    /// How a variable gets its initial value.
    Initial {
        /// It is the start value.
        Exact = "exact",
        /// The start value is a guess.
        Approx = "approx",
        /// It is computed from others.
        Calculated = "calculated",
    }
}

named! {
    /// Kind of values, named as in FMI 3.0.
    DataType {
        /// 32-bit float (3.0).
        Float32 = "Float32",
        /// 64-bit float; `Real` in FMI 2.0.
        Float64 = "Float64",
        /// 8-bit signed integer (3.0).
        Int8 = "Int8",
        /// 8-bit unsigned integer (3.0).
        UInt8 = "UInt8",
        /// 16-bit signed integer (3.0).
        Int16 = "Int16",
        /// 16-bit unsigned integer (3.0).
        UInt16 = "UInt16",
        /// 32-bit signed integer; `Integer` in FMI 2.0.
        Int32 = "Int32",
        /// 32-bit unsigned integer (3.0).
        UInt32 = "UInt32",
        /// 64-bit signed integer (3.0).
        Int64 = "Int64",
        /// 64-bit unsigned integer (3.0).
        UInt64 = "UInt64",
        /// True or false.
        Boolean = "Boolean",
        /// Text.
        String = "String",
        /// Bytes (3.0).
        Binary = "Binary",
        /// One of a declared list of values.
        Enumeration = "Enumeration",
        /// Clock (3.0).
        Clock = "Clock",
    }
}

impl DataType {
    /// Name of the element in this version of the standard, if the version has such values.
    pub fn element(self, version: FmiVersion) -> Option<&'static str> {
        match (version, self) {
            (FmiVersion::V3, _) => Some(self.name()),
            (FmiVersion::V2, DataType::Float64) => Some("Real"),
            (FmiVersion::V2, DataType::Int32) => Some("Integer"),
            (FmiVersion::V2, DataType::Boolean | DataType::String | DataType::Enumeration) => {
                Some(self.name())
            }
            (FmiVersion::V2, _) => None,
        }
    }

    /// The data type of an element in this version of the standard.
    pub fn from_element(version: FmiVersion, element: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|data_type| data_type.element(version) == Some(element))
    }

    /// Whether values are floating point.
    pub fn is_float(self) -> bool {
        matches!(self, DataType::Float32 | DataType::Float64)
    }

    /// Smallest and largest value of an integer type (enumerations are `int` in 2.0, `long` in 3.0).
    pub fn integer_range(self, version: FmiVersion) -> Option<(i128, i128)> {
        let range = match self {
            DataType::Int8 => (i8::MIN.into(), i8::MAX.into()),
            DataType::UInt8 => (0, u8::MAX.into()),
            DataType::Int16 => (i16::MIN.into(), i16::MAX.into()),
            DataType::UInt16 => (0, u16::MAX.into()),
            DataType::Int32 => (i32::MIN.into(), i32::MAX.into()),
            DataType::UInt32 => (0, u32::MAX.into()),
            DataType::Int64 => (i64::MIN.into(), i64::MAX.into()),
            DataType::UInt64 => (0, u64::MAX.into()),
            DataType::Enumeration if version == FmiVersion::V2 => {
                (i32::MIN.into(), i32::MAX.into())
            }
            DataType::Enumeration => (i64::MIN.into(), i64::MAX.into()),
            _ => return None,
        };
        Some(range)
    }
}

/// A number as it stands in the XML.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Number {
    /// A floating point number.
    Float(f64),
    /// An integer of up to 64 bits, signed or unsigned.
    Integer(i128),
}

impl Number {
    /// The number as a 64-bit float.
    pub fn as_f64(self) -> f64 {
        match self {
            Number::Float(value) => value,
            Number::Integer(value) => value as f64,
        }
    }
}

/// Start values; scalars have one.
#[derive(Debug, Clone, PartialEq)]
pub enum Start {
    /// Of floating point variables.
    Float(Vec<f64>),
    /// Of integers and enumerations.
    Integer(Vec<i128>),
    /// Of booleans.
    Boolean(Vec<bool>),
    /// Of texts.
    Text(Vec<String>),
    /// Of binary variables.
    Binary(Vec<Vec<u8>>),
}

impl Start {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Start::Float(values) => values.len(),
            Start::Integer(values) => values.len(),
            Start::Boolean(values) => values.len(),
            Start::Text(values) => values.len(),
            Start::Binary(values) => values.len(),
        }
    }

    /// Whether there is no value at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The numbers, for floats and integers.
    pub fn numbers(&self) -> Option<Vec<Number>> {
        match self {
            Start::Float(values) => Some(values.iter().copied().map(Number::Float).collect()),
            Start::Integer(values) => Some(values.iter().copied().map(Number::Integer).collect()),
            _ => None,
        }
    }
}

/// What variables and type definitions both declare.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Properties {
    /// Physical quantity.
    pub quantity: Option<String>,
    /// Name of a defined unit.
    pub unit: Option<String>,
    /// Name of a display unit of that unit.
    pub display_unit: Option<String>,
    /// The unit's offset does not apply.
    pub relative_quantity: Option<bool>,
    /// The variable grows far beyond its nominal value.
    pub unbounded: Option<bool>,
    /// Smallest allowed value.
    pub min: Option<Number>,
    /// Largest allowed value.
    pub max: Option<Number>,
    /// Typical magnitude.
    pub nominal: Option<f64>,
    /// Kind of bytes (3.0, binary).
    pub mime_type: Option<String>,
    /// Most bytes (3.0, binary).
    pub max_size: Option<u64>,
    /// Of clocks (3.0).
    pub clock: Option<Box<ClockProperties>>,
}

impl Properties {
    /// These properties, and the ones of `defaults` where these say nothing.
    pub fn or(&self, defaults: &Properties) -> Properties {
        Properties {
            quantity: self.quantity.clone().or_else(|| defaults.quantity.clone()),
            unit: self.unit.clone().or_else(|| defaults.unit.clone()),
            display_unit: self.display_unit.clone().or_else(|| defaults.display_unit.clone()),
            relative_quantity: self.relative_quantity.or(defaults.relative_quantity),
            unbounded: self.unbounded.or(defaults.unbounded),
            min: self.min.or(defaults.min),
            max: self.max.or(defaults.max),
            nominal: self.nominal.or(defaults.nominal),
            mime_type: self.mime_type.clone().or_else(|| defaults.mime_type.clone()),
            max_size: self.max_size.or(defaults.max_size),
            clock: self.clock.clone().or_else(|| defaults.clock.clone()),
        }
    }
}

/// When a clock ticks (3.0); the standard's attributes by their names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClockProperties {
    /// `constant`, `fixed`, `tunable`, `changing`, `countdown` or `triggered`.
    pub interval_variability: Option<String>,
    /// May be deactivated by the importer.
    pub can_be_deactivated: Option<bool>,
    /// Priority in scheduled execution.
    pub priority: Option<u32>,
    /// Interval in s.
    pub interval_decimal: Option<f64>,
    /// Delay of the first tick in s.
    pub shift_decimal: Option<f64>,
    /// Fractions are supported.
    pub supports_fraction: Option<bool>,
    /// Ticks per second of the counters.
    pub resolution: Option<u64>,
    /// Interval in ticks.
    pub interval_counter: Option<u64>,
    /// Delay in ticks.
    pub shift_counter: Option<u64>,
}

/// One dimension of an array (3.0).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// A fixed size.
    Size(u64),
    /// The value reference of the structural parameter that is the size.
    Parameter(u32),
}

/// Another name of a variable (3.0).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Alias {
    /// The other name.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// Unit it is shown in.
    pub display_unit: Option<String>,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Unique name.
    pub name: String,
    /// Handle in the C functions.
    pub value_reference: u32,
    /// One sentence about it.
    pub description: Option<String>,
    /// What the variable is for.
    pub causality: Causality,
    /// When it may change, if stated; see [`Variable::variability`].
    pub stated_variability: Option<Variability>,
    /// How it gets its initial value, if stated; see [`Variable::initial`].
    pub stated_initial: Option<Initial>,
    /// It may be set several times at one instant.
    pub can_handle_multiple_set_per_time_instant: Option<bool>,
    /// Kind of values.
    pub data_type: DataType,
    /// Name of a defined type.
    pub declared_type: Option<String>,
    /// Unit, min, max, …
    pub properties: Properties,
    /// Start value.
    pub start: Option<Start>,
    /// The variable it is the derivative of (position in 2.0, value reference in 3.0).
    pub derivative: Option<u32>,
    /// The state may be reset at events.
    pub reinit: Option<bool>,
    /// Size of an array; empty for scalars (3.0).
    pub dimensions: Vec<Dimension>,
    /// Other names (3.0; in 2.0 aliases are variables with the same value reference).
    pub aliases: Vec<Alias>,
    /// Clocks it belongs to (3.0).
    pub clocks: Vec<u32>,
    /// Accessible in intermediate update mode (3.0).
    pub intermediate_update: Option<bool>,
    /// The variable that holds its previous value (3.0).
    pub previous: Option<u32>,
    /// Where the element stands.
    pub line: Line,
}

impl Variable {
    /// A local variable of this name, value reference and type; variability is by default the
    /// standard's.
    pub fn new(name: impl Into<String>, value_reference: u32, data_type: DataType) -> Self {
        Variable {
            name: name.into(),
            value_reference,
            description: None,
            causality: Causality::Local,
            stated_variability: None,
            stated_initial: None,
            can_handle_multiple_set_per_time_instant: None,
            data_type,
            declared_type: None,
            properties: Properties::default(),
            start: None,
            derivative: None,
            reinit: None,
            dimensions: Vec::new(),
            aliases: Vec::new(),
            clocks: Vec::new(),
            intermediate_update: None,
            previous: None,
            line: Line(0),
        }
    }

    /// When the variable may change: as stated, else the default of the standard.
    pub fn variability(&self, version: FmiVersion) -> Variability {
        self.stated_variability.unwrap_or_else(|| default_variability(self, version))
    }

    /// How the variable gets its initial value: as stated, else the default of the standard.
    /// None for the independent variable and for combinations that the standard forbids.
    pub fn initial(&self, version: FmiVersion) -> Option<Initial> {
        let allowed = allowed_initials(self.causality, self.variability(version))?;
        self.stated_initial.or_else(|| allowed.first().copied())
    }
}

fn default_variability(variable: &Variable, version: FmiVersion) -> Variability {
    use Causality::{CalculatedParameter, Parameter, StructuralParameter};
    match (version, variable.causality) {
        (FmiVersion::V2, _) => Variability::Continuous,
        (FmiVersion::V3, Parameter | CalculatedParameter | StructuralParameter) => {
            Variability::Fixed
        }
        (FmiVersion::V3, _) if variable.data_type.is_float() => Variability::Continuous,
        (FmiVersion::V3, _) => Variability::Discrete,
    }
}

/// The values `initial` may have for a pair of causality and variability, the default first; None
/// if the pair is not allowed. For inputs the list is `exact`, but the attribute must not be stated;
/// for the independent variable it is empty.
///
/// Source: the two tables of 2.2.7 (2.0.5) and 2.4.7.4 (3.0.2).
pub fn allowed_initials(
    causality: Causality,
    variability: Variability,
) -> Option<&'static [Initial]> {
    use Causality::*;
    use Initial::{Approx, Calculated, Exact};
    use Variability::{Constant, Continuous, Discrete, Fixed, Tunable};
    match (causality, variability) {
        (Parameter | StructuralParameter, Fixed | Tunable) => Some(&[Exact]),
        (CalculatedParameter, Fixed | Tunable) => Some(&[Calculated, Approx]),
        (Input, Discrete | Continuous) => Some(&[Exact]),
        (Output | Local, Constant) => Some(&[Exact]),
        (Local, Fixed | Tunable) => Some(&[Calculated, Approx]),
        (Output | Local, Discrete | Continuous) => Some(&[Calculated, Exact, Approx]),
        (Independent, Continuous) => Some(&[]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table of 2.2.7 (2.0.5): 15 pairs; 3.0.2 adds the two of structural parameters.
    #[test]
    fn pairs_of_causality_and_variability() {
        let allowed = |causality| {
            let is_allowed = |v: &&Variability| allowed_initials(causality, **v).is_some();
            Variability::ALL.iter().filter(is_allowed).map(|v| v.name()).collect::<Vec<_>>()
        };
        assert_eq!(allowed(Causality::Parameter), ["fixed", "tunable"]);
        assert_eq!(allowed(Causality::CalculatedParameter), ["fixed", "tunable"]);
        assert_eq!(allowed(Causality::Input), ["discrete", "continuous"]);
        assert_eq!(allowed(Causality::Output), ["constant", "discrete", "continuous"]);
        let all = ["constant", "fixed", "tunable", "discrete", "continuous"];
        assert_eq!(allowed(Causality::Local), all);
        assert_eq!(allowed(Causality::Independent), ["continuous"]);
        assert_eq!(allowed(Causality::StructuralParameter), ["fixed", "tunable"]);
        let pairs: usize = Causality::ALL.iter().map(|c| allowed(*c).len()).sum();
        assert_eq!(pairs, 15 + 2);
    }

    #[test]
    fn types_of_version_2() {
        let elements: Vec<_> =
            DataType::ALL.iter().filter_map(|t| t.element(FmiVersion::V2)).collect();
        assert_eq!(elements, ["Real", "Integer", "Boolean", "String", "Enumeration"]);
        assert_eq!(DataType::from_element(FmiVersion::V2, "Float64"), None);
        assert_eq!(DataType::from_element(FmiVersion::V3, "Real"), None);
        assert_eq!(DataType::from_element(FmiVersion::V2, "Real"), Some(DataType::Float64));
    }
}
