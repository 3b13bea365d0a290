//! The one list of all signals.

use crate::error::UnknownSignal;
use crate::signal_type::SignalType;
use crate::{general, papers};

/// Signals that belong together.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// Heading.
    pub title: &'static str,
    /// The signals.
    pub signals: &'static [SignalType],
}

/// All families, and with them all signals.
pub static FAMILIES: &[Family] = &[
    Family { title: "P0: laser beam pointing, four piezo axes", signals: papers::P0 },
    Family { title: "P0: motions of all four axes", signals: papers::P0_MOTIONS },
    Family { title: "P1: stop-operator LS-SVM, nanopositioning stage", signals: papers::P1 },
    Family { title: "P2: LS-SVM without an inverse, piezo bimorph", signals: papers::P2 },
    Family { title: "P3: Gaussian process, nanopositioning stage", signals: papers::P3 },
    Family { title: "P4: elliptical vibration cutting device", signals: papers::P4 },
    Family { title: "General: sine", signals: general::SINE },
    Family { title: "General: chirps", signals: general::CHIRPS },
    Family { title: "General: multisines", signals: general::MULTISINES },
    Family { title: "General: pseudo-random binary", signals: general::BINARY },
    Family { title: "General: triangles", signals: general::TRIANGLES },
    Family { title: "General: first-order reversal curves", signals: general::REVERSAL_CURVES },
    Family { title: "General: levels", signals: general::LEVELS },
    Family { title: "General: ellipse", signals: general::ELLIPSE },
];

/// All signals in the order of the families.
pub fn all() -> impl Iterator<Item = &'static SignalType> {
    FAMILIES.iter().flat_map(|family| family.signals)
}

/// The signal of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static SignalType> {
    all().find(|signal| signal.name == name)
}

/// The signal of this name, or an error with all names.
///
/// # Errors
/// [`UnknownSignal`] where no signal has this name.
pub fn lookup(name: &str) -> Result<&'static SignalType, UnknownSignal> {
    find(name).ok_or_else(|| {
        let known: Vec<&str> = all().map(|signal| signal.name).collect();
        UnknownSignal { name: name.to_owned(), known: known.join(", ") }
    })
}

#[cfg(test)]
mod tests {
    use super::all;

    #[test]
    fn laws_and_rules_ask_for_declared_parameters_only() {
        for signal in all() {
            assert!(signal.generate(&[]).is_ok(), "{}", signal.name);
        }
    }
}
