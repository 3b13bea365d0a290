//! Connectors and signals, and where the content of a list comes from.

use crate::description::Line;
use crate::names::named;
use crate::variable::DataType;

named! {
    /// What a connector is for.
    Kind {
        /// Takes a signal.
        Input = "input",
        /// Gives a signal.
        Output = "output",
        /// Takes a parameter.
        Parameter = "parameter",
        /// Gives a computed parameter.
        CalculatedParameter = "calculatedParameter",
        /// Of signal dictionaries only: what is connected says which way.
        Inout = "inout",
        /// Sets sizes of arrays (2.0).
        StructuralParameter = "structuralParameter",
        /// Never changes (2.0).
        Constant = "constant",
        /// Internal (2.0).
        Local = "local",
        /// Not stated (2.0).
        Unspecified = "unspecified",
    }
}

/// A connector of a component or a system.
#[derive(Debug, Clone, PartialEq)]
pub struct Connector {
    /// Name; of a component, that of the FMU's variable.
    pub name: String,
    /// What the connector is for.
    pub kind: Kind,
    /// Type and unit, if stated.
    pub data_type: Option<ConnectorType>,
    /// Sizes of an array (2.0); none: it is a scalar, or as the FMU has it.
    pub dimensions: Vec<Dimension>,
    /// Where it stands.
    pub line: Line,
}

/// One dimension of an array.
#[derive(Debug, Clone, PartialEq)]
pub enum Dimension {
    /// So many elements.
    Size(u64),
    /// As many as the value of this connector, a structural parameter.
    Connector(String),
}

impl Connector {
    /// A connector without a stated type.
    pub fn new(name: impl Into<String>, kind: Kind) -> Self {
        Connector {
            name: name.into(),
            kind,
            data_type: None,
            dimensions: Vec::new(),
            line: Line(0),
        }
    }
}

/// Type of a connector.
#[derive(Debug, Clone, PartialEq)]
pub struct ConnectorType {
    /// Kind of values.
    pub data_type: DataType,
    /// Name of the unit, of real values.
    pub unit: Option<String>,
    /// Name of the enumeration.
    pub enumeration: Option<String>,
}

impl ConnectorType {
    /// A real number, in a unit where one is known.
    pub fn real(unit: Option<&str>) -> Self {
        let unit = unit.map(str::to_owned);
        ConnectorType { data_type: DataType::Float64, unit, enumeration: None }
    }
}

/// Where the content of a binding, a mapping or a signal dictionary comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// It stands inside the SSD.
    Inline,
    /// A file, relative to the SSD.
    File(String),
    /// A file, relative to the component's source.
    InComponent(String),
}
