//! The variable table of a built system: what an FMU shows of it.

use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

use crate::{Unit, fnv_128};

/// Type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// Double precision.
    Real,
    /// 32-bit whole number.
    Integer,
    /// Truth value, stored as 0 or 1.
    Boolean,
}

/// What a variable is to its surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Set by the outside at communication points.
    Input,
    /// Computed.
    Output,
    /// A parameter that cannot change during a run.
    FixedParameter,
    /// A parameter that may change at communication points.
    TunableParameter,
}

/// One variable. Its value reference is its index in the table.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Structured name, as in `axis[1].hysteresis.w[3]`; never with a comma.
    pub name: String,
    /// Short names under which a blueprint lets the variable be addressed, as in `u`.
    pub alias: Option<String>,
    /// One sentence.
    pub description: String,
    /// Type.
    pub data_type: DataType,
    /// Unit as text; empty for none.
    pub unit: String,
    /// The unit as factor and exponents.
    pub si: Unit,
    /// Causality and, for parameters, variability.
    pub causality: Causality,
    /// Whether a real input or output changes only at sample instants.
    pub discrete: bool,
    /// Start value in `unit`; `None` for outputs.
    pub start: Option<f64>,
    /// Least value allowed, −∞ for none.
    pub min: f64,
    /// Greatest value allowed, +∞ for none.
    pub max: f64,
    /// Whether an identification may fit it.
    pub fit: bool,
    /// Outputs: value references that its value at initialisation depends on; `None`: any.
    pub initial_dependencies: Option<Vec<u32>>,
}

/// What has to be known about a variable each time it is read or set.
#[derive(Clone, Copy, Debug)]
pub struct Gate {
    /// The gate's type.
    pub data_type: DataType,
    /// The gate's causality.
    pub causality: Causality,
    /// Values that can be set lie between these two; none does for an output.
    least: f64,
    greatest: f64,
}

impl Gate {
    fn of(variable: &Variable) -> Self {
        let (least, greatest) = match variable.causality {
            // An input may pass its bounds: they tell what the machine is made for.
            Causality::Input => (f64::MIN, f64::MAX),
            Causality::Output => (f64::INFINITY, f64::NEG_INFINITY),
            _ => (variable.min.max(f64::MIN), variable.max.min(f64::MAX)),
        };
        let Variable { data_type, causality, .. } = *variable;
        Self { data_type, causality, least, greatest }
    }

    /// Whether this value can be set: a finite number, of a parameter one within its bounds.
    #[inline]
    #[must_use]
    pub fn takes(&self, value: f64) -> bool {
        (self.least..=self.greatest).contains(&value)
    }
}

/// All variables of a system, by value reference.
#[derive(Clone, Debug, Default)]
pub struct VariableTable {
    variables: Vec<Variable>,
    gates: Vec<Gate>,
}

/// Why a value was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetError {
    /// No variable has this value reference.
    Unknown {
        /// The value reference.
        reference: u32,
        /// How many variables there are.
        count: u32,
    },
    /// The variable is an output.
    NotSettable {
        /// The value reference.
        reference: u32,
    },
    /// NaN or infinite.
    NotFinite {
        /// The value reference.
        reference: u32,
        /// The value.
        value: f64,
    },
    /// Outside its bounds.
    OutOfRange {
        /// The value reference.
        reference: u32,
        /// The value.
        value: f64,
        /// Least value allowed.
        min: f64,
        /// Greatest value allowed.
        max: f64,
    },
}

impl VariableTable {
    /// The table of these variables; value references are the indices.
    #[must_use]
    pub fn new(variables: Vec<Variable>) -> Self {
        let gates = variables.iter().map(Gate::of).collect();
        Self { variables, gates }
    }

    /// What has to be known about the variable with this value reference to read or set it.
    #[inline]
    #[must_use]
    pub fn gate(&self, reference: u32) -> Option<&Gate> {
        self.gates.get(reference as usize)
    }

    /// All variables, in the order of their value references.
    #[must_use]
    pub fn as_slice(&self) -> &[Variable] {
        &self.variables
    }

    /// Number of variables.
    #[must_use]
    pub fn len(&self) -> usize {
        self.variables.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.variables.is_empty()
    }

    /// The variable with this value reference.
    #[must_use]
    pub fn get(&self, reference: u32) -> Option<&Variable> {
        self.variables.get(reference as usize)
    }

    /// The value reference of the variable with this name or alias.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<u32> {
        let by_name = self.variables.iter().position(|v| v.name == name);
        by_name
            .or_else(|| self.variables.iter().position(|v| v.alias.as_deref() == Some(name)))
            .map(|i| i as u32)
    }

    /// Value references and variables of one causality, in order.
    pub fn with(&self, causality: Causality) -> impl Iterator<Item = (u32, &Variable)> {
        self.variables
            .iter()
            .enumerate()
            .filter(move |(_, v)| v.causality == causality)
            .map(|(i, v)| (i as u32, v))
    }

    /// A fingerprint of the table: 128-bit FNV-1a over name, reference, type, unit, causality,
    /// variability and the bits of the start of every variable, as 32 hexadecimal digits. It is the
    /// FMU's GUID, so that XML and binary cannot disagree unnoticed.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        let mut bytes = Vec::new();
        for (reference, v) in self.variables.iter().enumerate() {
            bytes.extend(v.name.bytes());
            bytes.push(0);
            bytes.extend((reference as u32).to_le_bytes());
            bytes.extend([v.data_type as u8, v.causality as u8, u8::from(v.discrete)]);
            bytes.extend(v.unit.bytes());
            bytes.push(0);
            match v.start {
                Some(start) => bytes.extend(start.to_bits().to_le_bytes()),
                None => bytes.push(0xff),
            }
        }
        let mut text = String::with_capacity(32);
        let _ = fmt::write(&mut text, format_args!("{:032x}", fnv_128(bytes)));
        text
    }
}

impl fmt::Display for SetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Unknown { reference, count } => write!(
                f,
                "value reference {reference} is unknown; this model has the references 0 to {}",
                count.saturating_sub(1)
            ),
            Self::NotSettable { reference } => {
                write!(f, "value reference {reference} is an output and cannot be set")
            }
            Self::NotFinite { reference, value } => write!(
                f,
                "value reference {reference}: {value} is not a finite number; set a finite one"
            ),
            Self::OutOfRange { reference, value, min, max } => write!(
                f,
                "value reference {reference}: {value} is outside {min} to {max}; set a value inside"
            ),
        }
    }
}

impl core::error::Error for SetError {}
