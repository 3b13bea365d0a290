//! The states of an instance, and which function may be called in which.

use std::fmt;

/// State of an instance (FMI 2.0.5 §4.2.4, FMI 3.0 §2.3 and §4.2).
///
/// The standards' other states cannot be reached here: a step is computed at once and completely,
/// so nothing is ever in progress, canceled or failed; and neither event mode nor configuration
/// mode is offered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Phase {
    /// After instantiation or reset.
    Instantiated = 1,
    /// Between entering and leaving the initialization mode.
    Initialization = 2,
    /// Between two steps (`stepComplete` of FMI 2.0, Step Mode of 3.0).
    Step = 4,
    /// After the end of the simulation.
    Terminated = 8,
    /// After a call that returned an error.
    Error = 16,
}

impl Phase {
    /// All states, in the order of a simulation.
    pub const ALL: [Self; 5] =
        [Self::Instantiated, Self::Initialization, Self::Step, Self::Terminated, Self::Error];

    /// The state with this number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|phase| *phase as u8 == number)
    }

    /// How one gets on from here, for messages.
    fn way_out(self) -> &'static str {
        match self {
            Self::Instantiated => "enter and exit the initialization mode to begin the simulation",
            Self::Initialization => "exit the initialization mode to begin the simulation",
            Self::Step => "reset the instance to begin again",
            Self::Terminated => "values can be read; reset the instance to begin again",
            Self::Error => "reset the instance, set an FMU state saved before, or free it",
        }
    }
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "Instantiated",
            Self::Initialization => "Initialization Mode",
            Self::Step => "Step Mode (stepComplete)",
            Self::Terminated => "Terminated",
            Self::Error => "Error",
        })
    }
}

/// A row of a call table: a function and the states in which it may be called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// Name, as the standard spells it.
    pub function: &'static str,
    allowed: u8,
}

impl Rule {
    /// A row: one character per state in the order of [`Phase::ALL`], `x` where the function may
    /// be called and `.` where not; blanks do not count.
    #[must_use]
    pub const fn new(function: &'static str, marks: &str) -> Self {
        let marks = marks.as_bytes();
        let (mut allowed, mut bit, mut at) = (0, 1_u8, 0);
        while at < marks.len() {
            match marks[at] {
                b'x' => {
                    allowed |= bit;
                    bit <<= 1;
                }
                b'.' => bit <<= 1,
                b' ' => {}
                _ => panic!("a row of a call table holds only x, . and blanks"),
            }
            at += 1;
        }
        assert!(bit == 1 << Phase::ALL.len(), "a row of a call table has one mark per state");
        Self { function, allowed }
    }

    /// Whether the function may be called in this state.
    #[must_use]
    pub const fn allows(&self, phase: Phase) -> bool {
        self.allowed & phase as u8 != 0
    }

    /// What to say where it may not.
    pub(super) fn refusal(&self, phase: Phase) -> String {
        let names: Vec<_> =
            Phase::ALL.iter().filter(|p| self.allows(**p)).map(ToString::to_string).collect();
        let allowed = if names.is_empty() {
            "this FMU does not offer it".to_string()
        } else {
            format!("it is allowed in {}", names.join(", "))
        };
        format!("not allowed in the state {phase}: {allowed}; {}", phase.way_out())
    }
}

/// Writes a call table: a constant per row, and all rows in the order of the header.
macro_rules! table {
    ($($name:ident $function:ident $marks:literal)*) => {
        $(pub(super) const $name: Rule = Rule::new(stringify!($function), $marks);)*
        /// All rows, in the order of the header; functions that need no instance are left out.
        pub const TABLE: &[Rule] = &[$($name),*];
    };
}
pub(super) use table;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_read_in_the_order_of_the_states() {
        let rule = Rule::new("f", "x . x x .");
        let allowed: Vec<_> = Phase::ALL.iter().map(|p| rule.allows(*p)).collect();
        assert_eq!(allowed, [true, false, true, true, false]);
        assert_eq!(Phase::from_number(4), Some(Phase::Step));
        assert_eq!(Phase::from_number(3), None);
    }

    #[test]
    fn a_refusal_names_the_state_what_is_allowed_and_the_way_out() {
        let text = Rule::new("fmi2DoStep", "..x..").refusal(Phase::Instantiated);
        assert!(text.contains("Instantiated") && text.contains("Step Mode"), "{text}");
        assert!(text.contains("exit the initialization mode"), "{text}");
    }
}
