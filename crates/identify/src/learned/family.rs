//! The families of machines that can be learned.

/// Which machine is learned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// An LS-SVM over stop operators and the command.
    StopOperators,
    /// An LS-SVM over past commands and its own past outputs.
    Narx,
    /// An LS-SVM for the hysteresis term beside a straight line, over commands, positions and its own past.
    Term,
    /// A Gaussian process over the command and its derivatives.
    Process,
}

impl Family {
    /// All families.
    pub(crate) const ALL: [Self; 4] = [Self::StopOperators, Self::Narx, Self::Term, Self::Process];

    /// The family's name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::StopOperators => "lssvm-stops",
            Self::Narx => "lssvm-narx",
            Self::Term => "lssvm-term",
            Self::Process => "gp",
        }
    }

    /// One sentence.
    pub(crate) fn summary(self) -> &'static str {
        match self {
            Self::StopOperators => {
                "LS-SVM over stop operators, and a linear part: learned, of any shape"
            }
            Self::Narx => {
                "LS-SVM over past commands and its own past outputs, and a linear part: learned"
            }
            Self::Term => {
                "Straight line with a hysteresis term by an LS-SVM over commands, positions and its own past: learned"
            }
            Self::Process => "Gaussian process over the command and its derivatives: learned",
        }
    }

    /// What an observer is shown while it is learned.
    pub(super) fn stage(self) -> &'static str {
        match self {
            Self::StopOperators => "LS-SVM over stop operators",
            Self::Narx => "LS-SVM over past outputs",
            Self::Term => "LS-SVM for a hysteresis term",
            Self::Process => "Gaussian process",
        }
    }
}
