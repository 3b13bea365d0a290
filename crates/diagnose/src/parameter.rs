//! The free numbers of a chain.

/// A parameter of a chain, in the coordinate in which it is fitted.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parameter {
    /// Name in reports.
    pub(crate) name: String,
    /// Unit in reports.
    pub(crate) unit: String,
    /// Least value of the coordinate.
    pub(crate) low: f64,
    /// Greatest value of the coordinate.
    pub(crate) high: f64,
    /// Whether the coordinate is the logarithm of the value.
    pub(crate) log: bool,
    /// Step of the coordinate for finite differences.
    pub(crate) step: f64,
    /// Whether the output jumps where it moves, so that no slope shows the way.
    pub(crate) jumps: bool,
    /// Weight of the prior `coordinate²`; 0: none.
    pub(crate) prior: f64,
    /// First node that depends on it.
    pub(crate) node: usize,
    /// Whether it belongs to the model as it came.
    pub(crate) is_base: bool,
}

impl Parameter {
    /// The value of this coordinate.
    pub(crate) fn value(&self, coordinate: f64) -> f64 {
        if self.log { coordinate.exp() } else { coordinate }
    }

    /// Whether this coordinate lies between the bounds, and at neither.
    pub(crate) fn is_inside(&self, coordinate: f64) -> bool {
        coordinate > self.low && coordinate < self.high
    }
}

/// How a parameter of the chain moves a parameter of a component: value + deviation·coordinate.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Link {
    /// Number of the parameter in the chain.
    pub(crate) parameter: usize,
    /// Index in the component's values.
    pub(crate) index: usize,
    /// Change per unit of the coordinate, in SI.
    pub(crate) deviation: f64,
}
