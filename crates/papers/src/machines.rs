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
    use super::*;

    #[test]
    fn each_machine_is_a_frozen_rig() {
        for name in [P0, P1, P2, P3, P4] {
            assert!(rigs::find(name).is_some_and(|rig| rig.frozen.is_some()), "{name}");
        }
    }
}
