//! How an identification finds the parameters of an operator of plays, and how a diagnosis finds that one is missing.

/// What a fit of an operator of plays must know of it: thresholds come from the record, weights and other linear
/// parameters from least squares with bounds, and the rest from a search. Its plays are its first states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// One sentence, for the list of methods.
    pub summary: &'static str,
    /// Parameters that multiply a power of the command: name, power. With any of them there is no play of threshold 0.
    pub powers: &'static [(&'static str, i32)],
    /// Parameters that are searched.
    pub search: &'static [Search],
    /// Starts of the search, one value per searched parameter, in units of its scale.
    pub starts: &'static [&'static [f64]],
}

/// A parameter that is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// The parameter.
    pub name: &'static str,
    /// What its start and bounds are counted in.
    pub scale: Scale,
    /// Where it has no effect, or is best begun.
    pub start: f64,
    /// Least value.
    pub lower: f64,
    /// Greatest value.
    pub upper: f64,
}

/// A unit of [`Search`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// The unit of the parameter.
    Own,
    /// The growth of thresholds with the command's rate, in s, by which a command that crosses its range within the
    /// time fitted on moves them by half the range: a twentieth of that time.
    Growth,
}

/// How a diagnosis finds that a machine has an operator whose model has plain plays: it is tried with the model's
/// thresholds and weights. It stands for the effect that its declaration names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Missing {
    /// What the machine does, as in `plays that lag`.
    pub name: &'static str,
    /// Parameters that are fitted, scalars; what is neither these nor thresholds and weights keeps its start value.
    pub free: &'static [Free],
}

/// A parameter that a diagnosis fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// The parameter.
    pub quantity: &'static str,
    /// The parameter's name in answers and in repaired FMUs.
    pub name: &'static str,
    /// Where it is looked for.
    pub range: Range,
}

/// Where a diagnosis looks for a parameter. Starts of several parameters are combined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Between two values in SI, from these.
    Between {
        /// Least value.
        lower: f64,
        /// Greatest value.
        upper: f64,
        /// Values to start from.
        starts: &'static [f64],
    },
    /// The growth of thresholds with the command's rate in s, over decades about the one that moves them by half the
    /// command's range at the rate of the record (root mean square).
    Growth,
    /// A bandwidth in Hz, from what the length of the record shows to what its sample time does.
    Bandwidth,
}
