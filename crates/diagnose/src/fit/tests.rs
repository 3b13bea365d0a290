//! Fits of a mode: corrected sensitivities, and fits that are not worth their own.

use surround::Block;

use super::*;
use crate::chain::Node;
use crate::data_set::RecordRows;
use crate::parameter::Parameter;

/// A mode, frequency and damping, and a gain.
fn mode() -> Chain {
    let parameter = |name: &str, log, node| Parameter {
        name: name.to_owned(),
        unit: "1".to_owned(),
        low: if log { 1e-3_f64.ln() } else { -3.0 },
        high: if log { 1e3_f64.ln() } else { 3.0 },
        log,
        step: 1e-3,
        jumps: false,
        prior: 0.0,
        node,
        is_base: true,
    };
    let block = Block::SecondOrder.into();
    Chain {
        nodes: vec![
            Node::Block { block, takes: vec![0, 1], aux: 0, of_command: false },
            Node::Gain { parameter: 2, deviation: 0.1 },
        ],
        parameters: vec![
            parameter("frequency", true, 0),
            parameter("damping", true, 0),
            parameter("gain", false, 1),
        ],
        drive: 0,
        nuisances: Vec::new(),
    }
}

/// What the chain answers to steps at these coordinates.
fn log(chain: &Chain, truth: &[f64]) -> DataSet {
    let rows = 600;
    let command = (0..rows).map(|k| f64::from(k / 50 % 3)).collect();
    let record = RecordRows { command, ..RecordRows::still(rows as usize, 0.7) };
    let mut data = DataSet::new(vec![record], &[], None);
    let count = AtomicU64::new(0);
    let mut bench = Bench::new(chain, &data, Horizon::All, &count);
    let y = data.at_rows(bench.keep(truth).unwrap());
    // A little of something else, so that the cost has a bottom.
    data.y = y.iter().enumerate().map(|(k, y)| y + 1e-3 * (1.7 * k as f64).sin()).collect();
    data
}

#[test]
fn corrected_sensitivities_lead_to_the_same_fit() {
    let chain = mode();
    let truth = [40.0_f64.ln(), 0.05_f64.ln(), 0.5];
    let data = log(&chain, &truth);
    let count = AtomicU64::new(0);
    let fitter = Fitter { data: &data, sigma: 1e-3, count: &count, weights: None };
    let start = [44.0_f64.ln(), 0.1_f64.ln(), 0.0];
    let complete = fitter.fit(&chain, &start).unwrap();
    // With its own sensitivities; with some that are wrong, which only the end puts right.
    for (wrong, is_fresh) in [(1.0, true), (2.0, false)] {
        let mut work = fitter.work(&chain);
        let point = work.keep(&start).unwrap();
        let mut columns = work.columns(&point, 0..3).unwrap();
        columns[..2].iter_mut().flatten().for_each(|c| *c *= wrong);
        let fresh = is_fresh.then_some(point.cost);
        let fit = work.fit_corrected(point, columns, &[0, 1], fresh).unwrap();
        for ((is, wanted), truth) in fit.theta.iter().zip(&complete.theta).zip(&truth) {
            assert!((is - wanted).abs() < 1e-3, "{wrong}: {:?}, {:?}", fit.theta, complete.theta);
            assert!((is - truth).abs() < 1e-2, "{wrong}: {:?}, {truth}", fit.theta);
        }
        assert!(fit.mean_square < 1.01 * complete.mean_square, "{wrong}: {}", fit.mean_square);
    }
}

#[test]
fn what_leaves_far_more_than_the_best_gets_no_sensitivities_of_its_own() {
    let chain = mode();
    let data = log(&chain, &[40.0_f64.ln(), 0.05_f64.ln(), 0.5]);
    let runs = |enough: f64| {
        let count = AtomicU64::new(0);
        let fitter = Fitter { data: &data, sigma: 1e-3, count: &count, weights: None };
        let mut work = fitter.work(&chain);
        work.enough = enough;
        let start = [300.0_f64.ln(), 0.9_f64.ln(), 0.0];
        let point = work.keep(&start).unwrap();
        // They show no way.
        let columns = vec![vec![0.0; point.residual.len()]; 3];
        work.fit_corrected(point, columns, &[0, 1], None).unwrap();
        count.into_inner()
    };
    assert!(runs(1.0) < runs(f64::INFINITY));
}

#[test]
fn a_correction_gives_the_change_of_its_step() {
    let point = |theta: &[f64], residual: &[f64]| Point {
        theta: theta.to_vec(),
        residual: residual.to_vec(),
        squares: 0.0,
        cost: 0.0,
    };
    let (before, after) = (point(&[0.0, 0.0], &[1.0, 1.0]), point(&[2.0, 1.0], &[3.0, 0.0]));
    let mut columns = vec![vec![0.5, 0.0], vec![1.0, -1.0]];
    let old = vec![columns[1].clone()];
    let missed = correct((&before, &after), &mut columns, &[0], (&[1], &old));
    // Of (2, -1) the first would do (1, 0) and the second (1, -1).
    assert!(missed < 1e-12, "{missed}");
    assert_eq!(columns[0], [0.5, 0.0]);
    columns[0] = vec![0.0, 0.0];
    let missed = correct((&before, &after), &mut columns, &[0], (&[1], &old));
    assert!((missed - (1.0_f64 / 5.0).sqrt()).abs() < 1e-12, "{missed}");
    assert_eq!(columns[0], [0.5, 0.0]);
}
