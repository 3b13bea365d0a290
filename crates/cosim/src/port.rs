//! What the ends of a connection are.

/// A variable of a slave.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Port {
    /// Name of the slave.
    pub slave: String,
    /// Name of the variable.
    pub variable: String,
}

impl<S: Into<String>, V: Into<String>> From<(S, V)> for Port {
    fn from((slave, variable): (S, V)) -> Self {
        Port { slave: slave.into(), variable: variable.into() }
    }
}

impl std::fmt::Display for Port {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`{}` of FMU `{}`", self.variable, self.slave)
    }
}
