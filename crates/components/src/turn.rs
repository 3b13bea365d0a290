//! Sine and cosine of an angle in turns.
//!
//! An angle in turns is reduced without rounding, so that this is faster than `libm` and as exact
//! where the angle is `frequency · time`: the polynomials are those of FDLIBM on −1/8 … 1/8 turn,
//! within 1.2 units in the last place of the result or 1.2·10⁻¹⁶, whichever is greater.

use core::f64::consts::TAU;

/// 1.5·2⁵²: adding it to a number below 2⁵¹ rounds that to an integer.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// 2⁴⁹: of more turns double precision does not know the quarters well enough to round them.
const MOST: f64 = 562_949_953_421_312.0;

/// Sine and cosine of 2π·`turns`, for |`turns`| up to 2⁴⁹; beyond it the angle counts
/// as 0.
#[inline]
#[must_use]
pub fn sin_cos(turns: f64) -> [f64; 2] {
    let quarters = if turns.abs() < MOST { 4.0 * turns } else { 0.0 * turns };
    let nearest = (quarters + ROUND) - ROUND;
    let a = 0.25 * TAU * (quarters - nearest);
    let z = a * a;
    let s = a + a
        * z
        * (-1.666_666_666_666_663_2e-1
            + z * (8.333_333_333_322_49e-3
                + z * (-1.984_126_982_985_795e-4
                    + z * (2.755_731_370_707_007e-6
                        + z * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10)))));
    let c = 1.0 - 0.5 * z
        + z * z
            * (4.166_666_666_666_66e-2
                + z * (-1.388_888_888_887_411e-3
                    + z * (2.480_158_728_947_673e-5
                        + z * (-2.755_731_435_139_066_3e-7
                            + z * (2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11)))));
    match (nearest as i64) & 3 {
        0 => [s, c],
        1 => [c, -s],
        2 => [-s, -c],
        _ => [-c, s],
    }
}

/// Sine of 2π·`turns`; see [`sin_cos`].
#[inline]
#[must_use]
pub fn sin(turns: f64) -> f64 {
    let [sin, _] = sin_cos(turns);
    sin
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn agrees_with_the_functions_of_an_angle_in_radians() {
        let mut random = Random::new(5);
        for _ in 0..100_000 {
            let turns = random.between(-1.0, 1.0);
            let (s, c) = (TAU * turns).sin_cos();
            let [sin, cos] = sin_cos(turns);
            // The reference's argument is itself rounded: up to 2π·1.1e-16.
            assert!((sin - s).abs() < 9e-16 && (cos - c).abs() < 9e-16, "{turns}");
            assert!((sin * sin + cos * cos - 1.0).abs() < 5e-16);
        }
    }

    #[test]
    fn quarters_are_exact_however_many_turns() {
        for integer in [0.0, 1.0, -7.0, 1e12] {
            assert_eq!(sin_cos(integer), [0.0, 1.0]);
            assert_eq!(sin_cos(integer + 0.25), [1.0, 0.0]);
            assert_eq!(sin_cos(integer + 0.5), [0.0, -1.0]);
            assert_eq!(sin_cos(integer + 0.75), [-1.0, 0.0]);
        }
        assert_eq!(sin_cos(1e300), [0.0, 1.0]);
        assert!(sin_cos(f64::NAN)[0].is_nan() && sin_cos(f64::INFINITY)[0].is_nan());
    }
}
