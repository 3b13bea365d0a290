//! How an identification finds the parameters of an operator of plays.

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
    /// That of the parameter.
    Own,
    /// The growth of thresholds with the command's rate, in s, by which a command that crosses its range within the
    /// time fitted on moves them by half the range: a twentieth of that time.
    Growth,
}
