//! The ways of feedforward.

/// How the feedforward is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Feedforward {
    /// The best of all on the plant itself.
    #[default]
    Automatic,
    /// The inverse that the components declare.
    Inverse,
    /// The component's own model beside the machine, without an inverse.
    InverseFree,
    /// The inverse of a Prandtl–Ishlinskii model that is fitted to what the plant does.
    Fitted,
    /// The inverse of a dynamic Prandtl–Ishlinskii model that is fitted to what the plant does at several rates.
    Dynamic,
    /// A Gaussian process over the position and its rate, learned from the plant at several rates.
    Process,
    /// A straight line.
    Linear,
    /// The best of all, and in front of it the inverse of a coupling's dynamics, which knows the reference ahead.
    Preview,
    /// None: feedback alone.
    None,
}

impl Feedforward {
    /// All kinds of feedforward.
    pub const ALL: [Self; 9] = [
        Self::Automatic,
        Self::Inverse,
        Self::InverseFree,
        Self::Fitted,
        Self::Dynamic,
        Self::Process,
        Self::Linear,
        Self::Preview,
        Self::None,
    ];

    /// The feedforward's name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Automatic => "automatic",
            Self::Inverse => "inverse",
            Self::InverseFree => "inverse-free",
            Self::Fitted => "fitted",
            Self::Dynamic => "dynamic",
            Self::Process => "gp",
            Self::Linear => "linear",
            Self::Preview => "preview",
            Self::None => "none",
        }
    }

    /// One sentence.
    #[must_use]
    pub const fn summary(self) -> &'static str {
        match self {
            Self::Automatic => "the kind with the least error on the plant itself",
            Self::Inverse => "the inverse that the plant's components declare",
            Self::InverseFree => {
                "the hysteresis model itself, in parallel to the machine, without an inverse"
            }
            Self::Fitted => "the inverse of a Prandtl-Ishlinskii model that is fitted to the plant",
            Self::Dynamic => {
                "the inverse of a dynamic Prandtl-Ishlinskii model, fitted to the plant at several rates"
            }
            Self::Process => {
                "a Gaussian process over the position and its rate, learned from the plant at several rates"
            }
            Self::Linear => "a straight line",
            Self::Preview => {
                "as automatic, and the dynamics of a coupling are compensated too: the position follows the reference with a stated delay"
            }
            Self::None => "feedback alone",
        }
    }
}
