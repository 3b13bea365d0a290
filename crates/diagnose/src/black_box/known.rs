//! The last runs of a black box, so that none is made twice.

use std::collections::VecDeque;

use crate::thresholds::base::Thresholds;

/// One run.
struct Run {
    /// First row of its record.
    record: usize,
    values: Vec<f64>,
    course: Vec<f64>,
    answer: Vec<f64>,
}

/// The last runs, the newest first.
#[derive(Default)]
pub(super) struct Known {
    runs: VecDeque<Run>,
    kept: usize,
}

fn is_same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

impl Known {
    /// Writes the answer of a known run over the same rows or more: what comes later changes nothing.
    pub(super) fn recall(
        &mut self,
        record: usize,
        values: &[f64],
        course: &[f64],
        answer: &mut [f64],
    ) -> bool {
        let found = self.runs.iter().position(|run| {
            run.record == record
                && is_same(&run.values, values)
                && run.course.get(..course.len()).is_some_and(|begin| is_same(begin, course))
        });
        let Some(run) = found.and_then(|at| self.runs.remove(at)) else { return false };
        answer.copy_from_slice(&run.answer[..answer.len()]);
        self.runs.push_front(run);
        true
    }

    /// Keeps a run, and forgets those that were used longest ago.
    pub(super) fn keep(&mut self, record: usize, values: Vec<f64>, course: &[f64], answer: &[f64]) {
        let (course, answer) = (course.to_vec(), answer.to_vec());
        self.kept += course.len() + answer.len();
        self.runs.push_front(Run { record, values, course, answer });
        while self.kept > Thresholds::KEPT_VALUES
            && let Some(last) = self.runs.pop_back()
        {
            self.kept -= last.course.len() + last.answer.len();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_run_is_recalled_and_no_other() {
        let mut known = Known::default();
        known.keep(0, vec![1.0], &[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0]);
        let mut answer = [0.0; 2];
        assert!(known.recall(0, &[1.0], &[1.0, 2.0], &mut answer), "its begin");
        assert_eq!(answer, [4.0, 5.0]);
        let mut recall = |record, value, course: &[f64]| {
            known.recall(record, &[value], course, &mut vec![0.0; course.len()])
        };
        assert!(!recall(7, 1.0, &[1.0, 2.0]), "another record");
        assert!(!recall(0, 1.1, &[1.0, 2.0]), "other values");
        assert!(!recall(0, 1.0, &[1.0, 2.5]), "another course");
        assert!(!recall(0, 1.0, &[1.0, 2.0, 3.0, 4.0]), "more than is known");
    }

    #[test]
    fn what_was_used_longest_ago_is_forgotten() {
        let mut known = Known::default();
        let long = vec![0.0; Thresholds::KEPT_VALUES / 5];
        for record in 0..3 {
            known.keep(record, Vec::new(), &long, &long);
        }
        let mut answer = long.clone();
        assert!(!known.recall(0, &[], &long, &mut answer));
        assert!(known.recall(2, &[], &long, &mut answer));
    }
}
