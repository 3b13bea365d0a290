//! Inputs of the three models.

use super::*;

/// What an affine function of these inputs leaves of h, as a part of its range.
fn left(record: &Record, inputs: &dyn Fn(usize) -> Vec<f64>) -> f64 {
    let rows: Vec<Vec<f64>> =
        (3..record.h.len()).map(|k| [vec![1.0], inputs(k)].concat()).collect();
    let count = rows[0].len();
    let mut errors: Vec<f64> = record.h[3..].to_vec();
    // Projections in turn, until they end.
    for _ in 0..20_000 {
        for i in 0..count {
            let norm: f64 = rows.iter().map(|row| row[i] * row[i]).sum();
            let step = rows.iter().zip(&errors).map(|(row, e)| row[i] * e).sum::<f64>() / norm;
            errors.iter_mut().zip(&rows).for_each(|(e, row)| *e -= step * row[i]);
        }
    }
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let span = identify::learned::Span::of(&record.h);
    rms / (span.high - span.low)
}

#[test]
fn no_model_knows_what_it_is_asked_for() {
    let record = record("p2-test-2", PRINTED).unwrap();
    let printed = left(&record, &|k| vec![record.u[k], record.y[k]]);
    assert!(printed < 1e-3, "the printed model III solves an identity: {printed}");
    for inputs in MODELS {
        // From outside come the command, or the position.
        let signal = match inputs.position {
            Positions::Measured => &record.y,
            _ => &record.u,
        };
        let outside = left(&record, &|k| (0..=PAST).map(|i| signal[k - i]).collect());
        assert!(outside > 0.02, "{}: {outside}", inputs.name);
    }
}
