//! Vectors as wide as the machine has them, chosen at run time; safe code throughout.
//!
//! On a machine with fused multiply-add the last bits differ from one without.

use pulp::Simd;

/// Lanes of a block: 4 vectors of the widest machine.
pub(crate) const LANES: usize = 32;

/// 32 numbers on a cache line's boundary: a wide load never crosses one.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block(pub(crate) [f64; LANES]);

impl Block {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);
}

/// 1.5·2⁵²: adding it rounds to a whole number, which then stands in the lowest bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// 1/13!, …, 1/0!.
const TAYLOR: [f64; 14] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
    1.0,
    1.0,
];

/// exp of four vectors of numbers that are not positive, without a branch; relative error below
/// 3·10⁻¹⁶. Below −708 it is exp(−708), which is 3·10⁻³⁰⁸.
#[inline(always)]
pub(crate) fn exp4<S: Simd>(s: S, x: [S::f64s; 4]) -> [S::f64s; 4] {
    let all = |value: f64| s.splat_f64s(value);
    let (mut rounded, mut rest, mut p) = (x, x, [all(TAYLOR[0]); 4]);
    for i in 0..4 {
        let x = s.max_f64s(x[i], all(-708.0));
        rounded[i] = s.mul_add_e_f64s(x, all(core::f64::consts::LOG2_E), all(ROUNDER));
        let n = s.sub_f64s(rounded[i], all(ROUNDER));
        rest[i] = s.mul_add_e_f64s(n, all(-LN2_HIGH), x);
        rest[i] = s.mul_add_e_f64s(n, all(-LN2_LOW), rest[i]);
    }
    for c in &TAYLOR[1..] {
        for i in 0..4 {
            p[i] = s.mul_add_e_f64s(p[i], rest[i], all(*c));
        }
    }
    for i in 0..4 {
        // The whole number into the exponent.
        let n = s.mul_u64s(s.transmute_u64s_f64s(rounded[i]), s.splat_u64s(1 << 52));
        p[i] = s.transmute_f64s_u64s(s.add_u64s(n, s.transmute_u64s_f64s(p[i])));
    }
    p
}

/// −x.
#[inline(always)]
pub(crate) fn minus4<S: Simd>(s: S, mut x: [S::f64s; 4]) -> [S::f64s; 4] {
    for x in &mut x {
        *x = s.neg_f64s(*x);
    }
    x
}

/// Squared distances of 32 points (a block for each coordinate) from `z`, group `h` of 4 vectors.
#[inline(always)]
pub(crate) fn distance4<S: Simd>(s: S, rows: &[Block], z: &[f64], h: usize) -> [S::f64s; 4] {
    let mut sum = [s.splat_f64s(0.0); 4];
    for (row, z) in rows.iter().zip(z) {
        let z = s.splat_f64s(*z);
        let row = &S::as_simd_f64s(&row.0).0[4 * h..4 * h + 4];
        for i in 0..4 {
            let e = s.sub_f64s(row[i], z);
            sum[i] = s.mul_add_e_f64s(e, e, sum[i]);
        }
    }
    sum
}

/// Squared distances of the points from `z`, two groups at once from group `h` on: eight sums that do not wait for
/// each other, and each row is read from end to end.
#[inline(always)]
pub(crate) fn distance8<S: Simd>(s: S, rows: &[Block], z: &[f64], h: usize) -> [[S::f64s; 4]; 2] {
    let mut sum = [[s.splat_f64s(0.0); 4]; 2];
    for (row, z) in rows.iter().zip(z) {
        let z = s.splat_f64s(*z);
        let row = &S::as_simd_f64s(&row.0).0[4 * h..4 * h + 8];
        for g in 0..2 {
            for i in 0..4 {
                let e = s.sub_f64s(row[4 * g + i], z);
                sum[g][i] = s.mul_add_e_f64s(e, e, sum[g][i]);
            }
        }
    }
    sum
}

/// Number of groups of 4 vectors in a block.
#[inline(always)]
pub(crate) const fn groups<S: Simd>() -> usize {
    LANES / S::F64_LANES / 4
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    struct Exp(f64);

    impl WithSimd for Exp {
        type Output = f64;
        #[inline(always)]
        fn with_simd<S: Simd>(self, s: S) -> f64 {
            let all = exp4(s, [s.splat_f64s(self.0); 4]);
            s.reduce_sum_f64s(all[3]) / S::F64_LANES as f64
        }
    }

    fn worst(arch: Arch) -> f64 {
        let error = |x: f64| (arch.dispatch(Exp(x)) / libm::exp(x) - 1.0).abs();
        (0..200_000).map(|k| error(-0.0035 * f64::from(k))).fold(0.0, f64::max)
    }

    #[test]
    fn exp_is_exact_to_the_last_places_on_every_machine() {
        assert!(worst(Arch::new()) < 4e-16, "{}", worst(Arch::new()));
        assert!(worst(Arch::Scalar) < 4e-16, "{}", worst(Arch::Scalar));
        for x in [-709.0, -1e9, f64::NEG_INFINITY] {
            assert!(Arch::new().dispatch(Exp(x)) < 1e-306);
        }
    }
}
