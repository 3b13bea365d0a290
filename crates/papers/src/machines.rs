//! The machines on which the papers' tables are reproduced, and the waves for signals that a paper describes by
//! their band alone.

/// Laser beam steering.
pub const P0: &str = "p0-machine";
/// P-752.21C.
pub const P1: &str = "p1-machine";
/// Piezo bimorph.
pub const P2: &str = "p2-machine";
/// P66X30.
pub const P3: &str = "p3-machine";
/// Elliptical vibration cutting.
pub const P4: &str = "p4-machine";

/// Settings of a signal.
pub type Given = &'static [(&'static str, f64)];

/// Greatest command of P1's training signals in V, which is that of its stop operators (table 3).
const GREATEST: f64 = 8.5;

/// A signal of P1 by its letter, a to g, and its settings. C, F and G are "random sinusoids" of a band: half waves whose
/// frequencies are even over the band and whose reversals are even over the upper and lower half of 0 to `top`. C, which
/// trains, and G reach the stop operators' greatest command; F the 5 V of the sines.
#[must_use]
pub fn p1(letter: char) -> (String, Given) {
    const LARGE: Given = &[("top", GREATEST), ("after", 1.0), ("swing", 0.5), ("bias", 1.0)];
    const SMALL: Given = &[("top", 5.0), ("after", 1.0), ("swing", 0.5), ("bias", 1.0)];
    let given: Given = match letter {
        'c' | 'g' => LARGE,
        'f' => SMALL,
        _ => &[],
    };
    (format!("p1-{letter}"), given)
}

#[cfg(test)]
mod tests {
    use sha2::{Digest, Sha256};

    use super::*;
    use crate::matching;

    /// As the machines' blueprints, they were fixed before any model ran on them.
    #[test]
    fn waves_that_stand_in_are_frozen() {
        let mut hash = Sha256::new();
        for letter in ['c', 'f', 'g'] {
            let (name, given) = p1(letter);
            let (values, _) = matching::signal(&name, given).expect("a signal");
            assert_eq!(values.len(), 500);
            for value in values {
                hash.update(value.to_le_bytes());
            }
        }
        let hash: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hash, "bc3c0484db76c9e82f67d19e945c94de65dd7305157769602fe3dba67b4f77e0");
    }

    #[test]
    fn each_machine_is_a_frozen_rig() {
        for name in [P0, P1, P2, P3, P4] {
            assert!(rigs::find(name).is_some_and(|rig| rig.frozen.is_some()), "{name}");
        }
    }
}
