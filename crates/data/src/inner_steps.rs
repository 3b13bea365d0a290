//! Whether times can be in seconds: how many inner steps of a model lie between two of them.
//!
//! A log in microseconds that is read as seconds, or one stray time, asks a model for millions of
//! steps between two rows: hours, or gigabytes where they are kept. Before that somebody is asked.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::log::median;

/// Most inner steps between two rows, unless [`allow`] says otherwise.
pub const MOST: u64 = 500_000;

static ALLOWED: AtomicU64 = AtomicU64::new(MOST);

/// Allows this program so many inner steps between two rows.
pub fn allow(most: u64) {
    ALLOWED.store(most, Ordering::Relaxed);
}

/// How many are allowed between two rows.
#[must_use]
pub fn allowed() -> u64 {
    ALLOWED.load(Ordering::Relaxed)
}

/// Holds a sample time against the inner step of a model, both in s.
///
/// # Errors
/// It is more steps than are allowed; the message asks for the unit.
pub fn check(sample: f64, inner: f64) -> Result<(), String> {
    let Some(steps) = too_many(sample, inner) else { return Ok(()) };
    let units = [(1e-3, "ms"), (1e-6, "us"), (1e-9, "ns")];
    let meant = units.iter().find(|(factor, _)| steps * factor <= 100.0).unwrap_or(&units[2]).1;
    Err(format!(
        "the sample time of {sample} s is {steps:.1e} inner steps of {inner} s; is time in {meant}? {}",
        way_out()
    ))
}

/// Holds the times of a record against the inner step of a model, all in s.
///
/// # Errors
/// Two rows are further apart than is allowed; the message asks for the unit, or names the row where
/// the others are not so far apart.
pub fn check_rows(time: &[f64], inner: f64) -> Result<(), String> {
    let gaps = || time.windows(2).map(|pair| pair[1] - pair[0]);
    let Some(row) = gaps().position(|gap| too_many(gap, inner).is_some()) else { return Ok(()) };
    let gap = time[row + 1] - time[row];
    if let Some(usual) = median(&mut gaps().collect::<Vec<f64>>()) {
        // At the limit itself rounding makes some of equal gaps too large.
        check(if gap < 1.01 * usual { gap } else { usual }, inner)?;
    }
    Err(format!(
        "row {} is at {} s, {gap} s behind the row before it, which is {:.1e} inner steps of {inner} s; \
         is that time a slip? {}",
        row + 2,
        time[row + 1],
        gap / inner,
        way_out()
    ))
}

fn too_many(sample: f64, inner: f64) -> Option<f64> {
    let steps = sample / inner;
    (inner > 0.0 && steps > allowed() as f64).then_some(steps)
}

fn way_out() -> String {
    format!(
        "At most {} inner steps are taken between two rows; --most-steps N allows more",
        allowed()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_unit_and_a_stray_time_are_distinguished() {
        assert_eq!(check(1.0, 1e-5), Ok(()));
        let message = check(100.0, 1e-4).unwrap_err();
        assert!(
            message.starts_with(
                "the sample time of 100 s is 1.0e6 inner steps of 0.0001 s; is time in us?"
            ),
            "{message}"
        );
        assert!(message.contains("--most-steps"), "{message}");
        let mut time: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(check_rows(&time, 1e-5), Ok(()));
        time[99] = 1e9;
        let message = check_rows(&time, 1e-5).unwrap_err();
        assert!(
            message.starts_with("row 100 is at 1000000000 s") && message.contains("slip"),
            "{message}"
        );
        let micros: Vec<f64> = time.iter().map(|t| t * 1e3).collect();
        assert!(check_rows(&micros, 1e-5).unwrap_err().contains("is time in us?"));
        let rounded: Vec<f64> = (0..100).map(|k| f64::from(k) * 1e-4 * 1e6).collect();
        assert!(check_rows(&rounded, 2e-4).unwrap_err().contains("is time in us?"));
        // An FMU that tells no step.
        assert_eq!(check_rows(&micros, 0.0), Ok(()));
        assert_eq!(check_rows(&[], 1e-5), Ok(()));
    }
}
