//! The damping laws: what each is called, its component, and its filter. To add one, write its variant, its line in
//! [`Damping::ALL`] and in `LAWS`, and its [`Law`].

use nalgebra::Complex;

/// Greatest gain of the inner loop at rest.
const INNER: f64 = 0.9;

/// How the first resonance is damped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Damping {
    /// Not at all.
    #[default]
    None,
    /// The law that settles first.
    Automatic,
    /// Integral resonant control.
    IntegralResonant,
    /// Positive position feedback.
    PositivePosition,
    /// Non-minimum-phase damping.
    NonMinimumPhase,
    /// PI with a notch: nothing is damped, the resonance is left out.
    Notch,
}

/// What is known of a way to damp.
struct Law {
    /// Name on the command line.
    name: &'static str,
    /// One sentence.
    summary: &'static str,
    /// What the loop is called.
    loop_name: &'static str,
    /// Type of the component.
    kind: &'static str,
    /// Bounds of the component's gains that are sought: gain over the plant's slope (or depth of the notch), frequency
    /// over the resonance, damping.
    own: &'static [(f64, f64)],
    /// F where it is evaluated; none for a law that is in line with the tracking law.
    filter: Option<fn(&Filtering) -> Complex<f64>>,
}

/// Where a filter is evaluated.
pub(super) struct Filtering {
    /// z⁻¹.
    pub(super) back: Complex<f64>,
    /// Tangent of half the angle of the filter's frequency.
    pub(super) w: f64,
    /// 2·damping·w.
    pub(super) broad: f64,
}

impl Filtering {
    /// ω/(s + ω).
    fn low_pass(&self) -> Complex<f64> {
        let one = Complex::new(1.0, 0.0);
        (one + self.back) * self.w / (one * (1.0 + self.w) - self.back * (1.0 - self.w))
    }

    /// c₀ + c₁·z⁻¹ + c₂·z⁻² of s² + d·s + ω² with d for `broad`, up to a factor.
    pub(super) fn second_order(&self, broad: f64) -> Complex<f64> {
        let square = self.w * self.w;
        Complex::new(1.0, 0.0) * (1.0 + square + broad)
            + self.back * (2.0 * (square - 1.0))
            + self.back * self.back * (1.0 + square - broad)
    }
}

static NONE: Law = Law {
    name: "none",
    summary: "no inner loop",
    loop_name: "PID",
    kind: "",
    own: &[],
    filter: None,
};

static AUTOMATIC: Law =
    Law { name: "automatic", summary: "the one of irc, ppf and nrc that settles first", ..NONE };

static INTEGRAL_RESONANT: Law = Law {
    name: "irc",
    summary: "integral resonant control",
    loop_name: "PID around integral resonant control",
    kind: "integral-resonant-control",
    own: &[(0.05, INNER), (0.1, 10.0)],
    filter: Some(Filtering::low_pass),
};

static POSITIVE_POSITION: Law = Law {
    name: "ppf",
    summary: "positive position feedback",
    loop_name: "PID around positive position feedback",
    kind: "positive-position-feedback",
    own: &[(0.05, INNER), (0.3, 10.0), (0.1, 2.0)],
    filter: Some(|at| {
        let sum = Complex::new(1.0, 0.0) + at.back;
        sum * sum * (at.w * at.w) / at.second_order(at.broad)
    }),
};

static NON_MINIMUM_PHASE: Law = Law {
    name: "nrc",
    summary: "non-minimum-phase resonant control",
    loop_name: "PID around non-minimum-phase damping",
    kind: "non-minimum-phase-damping",
    own: &[(0.05, INNER), (0.1, 10.0)],
    filter: Some(|at| at.low_pass() * 2.0 - Complex::new(1.0, 0.0)),
};

static NOTCH: Law = Law {
    name: "notch",
    summary: "PI with a notch at the resonance, which stays undamped",
    loop_name: "PI with a notch",
    kind: "notch",
    own: &[(1e-3, 1.0), (0.05, 2.0)],
    filter: None,
};

impl Damping {
    /// All damping laws.
    pub const ALL: [Self; 6] = [
        Self::None,
        Self::Automatic,
        Self::IntegralResonant,
        Self::PositivePosition,
        Self::NonMinimumPhase,
        Self::Notch,
    ];
    /// Those that damp.
    pub const LAWS: &[Self] =
        &[Self::NonMinimumPhase, Self::IntegralResonant, Self::PositivePosition];

    const fn law(self) -> &'static Law {
        match self {
            Self::None => &NONE,
            Self::Automatic => &AUTOMATIC,
            Self::IntegralResonant => &INTEGRAL_RESONANT,
            Self::PositivePosition => &POSITIVE_POSITION,
            Self::NonMinimumPhase => &NON_MINIMUM_PHASE,
            Self::Notch => &NOTCH,
        }
    }

    /// The damping's name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.law().name
    }

    /// One sentence.
    #[must_use]
    pub const fn summary(self) -> &'static str {
        self.law().summary
    }

    /// What the loop is called.
    pub(super) const fn loop_name(self) -> &'static str {
        self.law().loop_name
    }

    /// The damping's component.
    pub(super) const fn kind(self) -> &'static str {
        self.law().kind
    }

    /// How many gains of the component are sought.
    pub(super) const fn own_gains(self) -> usize {
        self.law().own.len()
    }

    /// Whether its filter has a damping ratio.
    pub(super) fn has_damping(self) -> bool {
        self == Self::Notch || self.own_gains() > 2
    }

    /// F; none where there is no inner loop.
    pub(super) fn filter(self, at: &Filtering) -> Option<Complex<f64>> {
        self.law().filter.map(|filter| filter(at))
    }

    /// Bounds of the gains that are sought, over the plant's slope and the resonance: those of the law, then kp, ki,
    /// kd and the corner of the derivative's filter.
    pub(super) fn bounds(self, derivative: bool) -> Vec<(f64, f64)> {
        let mut bounds = self.law().own.to_vec();
        bounds.extend([(1e-3, 3.0), (1e-2, 3.0)]);
        if derivative && self != Self::Notch {
            bounds.extend([(1e-3, 5.0), (0.5, 30.0)]);
        }
        bounds
    }
}

#[cfg(test)]
mod tests {
    use super::Damping;

    #[test]
    fn the_automatic_choice_names_what_it_chooses_from() {
        let summary = Damping::Automatic.summary();
        assert!(Damping::LAWS.iter().all(|law| summary.contains(law.name())), "{summary}");
    }
}
