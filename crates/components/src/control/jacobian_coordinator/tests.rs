use std::vec;
use std::vec::Vec;

use model::Tick;

use super::*;
use crate::testing::Random;

/// The laser beam's.
const J: [f64; 16] = [
    504.693, 3.33402, 0.0, 0.0, 14.4123, -515.344, 0.0, 0.0, 210.358, -12.0015, -129.337, 7.85753,
    1.18470, 217.263, -3.04729, -142.002,
];
const P0: [f64; 4] = [-261.625, 272.281, -46.6467, -39.1210];

fn parameters(matrix: &[f64], offset: &[f64], condition_max: f64) -> Vec<f64> {
    [matrix, offset, &[condition_max]].concat()
}

fn refusal(matrix: &[f64], n: usize, limit: f64) -> Option<Violation> {
    let structure = [n as f64, (n * n) as f64];
    let sizes = JacobianCoordinator.sizes(&structure, 1e-3);
    let values = parameters(matrix, &vec![0.0; n], limit);
    JacobianCoordinator.prepare(&structure, &values, 1e-3, &mut vec![0.0; sizes.coefficients]).err()
}

/// Motions for references, then for measured positions.
fn run(matrix: &[f64], offset: &[f64], reference: &[f64], measured: &[f64]) -> Vec<f64> {
    let n = offset.len();
    let structure = [n as f64, (n * n) as f64];
    let sizes = JacobianCoordinator.sizes(&structure, 1e-3);
    let mut coefficients = vec![0.0; sizes.coefficients];
    let values = parameters(matrix, offset, 1000.0);
    JacobianCoordinator.prepare(&structure, &values, 1e-3, &mut coefficients).expect("invertible");
    let mut out = vec![0.0; 3 * n];
    let tick = Tick { index: 1, time: 1e-3, period: 1e-3 };
    let inputs = [reference, measured].concat();
    JacobianCoordinator.step(&coefficients, &mut [], tick, &inputs, &mut out);
    assert_eq!(out[..n], out[n..2 * n], "the path is the reference");
    out.split_off(n)
}

/// Positions of these motions.
fn positions(matrix: &[f64], offset: &[f64], theta: &[f64]) -> Vec<f64> {
    let row =
        |(row, p0): (&[f64], &f64)| row.iter().zip(theta).map(|(j, t)| j * t).sum::<f64>() + p0;
    matrix.chunks_exact(theta.len()).zip(offset).map(row).collect()
}

#[test]
fn it_inverts_the_optics() {
    let other = [0.5, 0.25, 0.0, 1.0];
    let measured = positions(&J, &P0, &other);
    for theta in [[0.1, 0.9, 0.4, 0.7], [0.0; 4], [1.0, 0.0, 1.0, 0.0]] {
        let found = run(&J, &P0, &positions(&J, &P0, &theta), &measured);
        for (found, wanted) in found.iter().zip(theta.iter().chain(&other)) {
            assert!((found - wanted).abs() < 1e-13, "{found} {wanted}");
        }
    }
}

#[test]
fn structural_zeros_stay_exact() {
    // Detector 1 does not see mirror 2: the first two motions follow from its coordinates alone, and
    // setting the block below to zero changes nothing for them.
    let mut apart = J;
    for at in [8, 9, 12, 13] {
        apart[at] = 0.0;
    }
    let run = |matrix: &[f64; 16], p: [f64; 4]| run(matrix, &P0, &p, &[0.0; 4]);
    let (a, b) = (run(&J, [10.0, 20.0, 30.0, 40.0]), run(&J, [10.0, 20.0, -7.0, 1e3]));
    assert_eq!(a[..2].map_bits(), b[..2].map_bits());
    let c = run(&apart, [10.0, 20.0, 30.0, 40.0]);
    assert_eq!(a[..2].map_bits(), c[..2].map_bits());
    assert_ne!(a[2], c[2]);
}

trait Bits {
    fn map_bits(&self) -> Vec<u64>;
}

impl Bits for [f64] {
    fn map_bits(&self) -> Vec<u64> {
        self.iter().map(|x| x.to_bits()).collect()
    }
}

#[test]
fn singular_and_nearly_singular_matrices_are_refused() {
    assert_eq!(refusal(&J, 4, 1000.0), None);
    let twins = [1.0, 2.0, 2.0, 4.0];
    let found = refusal(&twins, 2, 1e9).expect("refused");
    assert!(found.quantity == "matrix" && found.value > 1e9, "{found}");
    // Exactly on the diagonal the condition is known.
    assert_eq!(refusal(&[1.0, 0.0, 0.0, 1e-3], 2, 1000.0 + 1e-9), None);
    let found = refusal(&[1.0, 0.0, 0.0, 1e-3], 2, 999.0).expect("refused");
    assert!((found.value - 1000.0).abs() < 1e-9, "{found}");
    assert!(refusal(&[0.0; 4], 2, 1e300).is_some());
    assert!(refusal(&[f64::NAN, 0.0, 0.0, 1.0], 2, 1000.0).is_some());
}

#[test]
fn a_zero_diagonal_needs_an_exchange_of_rows() {
    let swap = [0.0, 2.0, 4.0, 0.0];
    assert_eq!(run(&swap, &[0.0; 2], &[2.0, 8.0], &[0.0, 4.0]), [2.0, 1.0, 1.0, 0.0]);
}

#[test]
fn many_axes() {
    for n in [2, 3, 7, 32] {
        let mut j = Random::new(7).signal(-0.5, 0.5, n * n);
        (0..n).for_each(|i| j[i * n + i] += 4.0);
        let theta: Vec<f64> = (0..n).map(|k| k as f64 / n as f64).collect();
        let offset = vec![0.25; n];
        let out = run(&j, &offset, &positions(&j, &offset, &theta), &offset);
        for (found, wanted) in out.iter().zip(&theta) {
            assert!((found - wanted).abs() < 1e-12, "{n} axes: {found} {wanted}");
        }
    }
}
