//! What was tried, as it is reported.

use super::{Session, Tried};
use crate::identification::{Candidate, Identification, RULES, RecordFit};
use crate::judge::compare;
use crate::methods::STATIC;
use crate::record::Rows;

impl Session<'_> {
    pub(super) fn candidate(&self, tried: &Tried, reason: &str) -> Candidate {
        let worst = |rows: &[Rows]| {
            let each = self.records.iter().zip(rows).zip(&tried.simulations);
            each.map(|((r, rows), s)| compare(r.output(), s, *rows).nrmse).fold(0.0, f64::max)
        };
        Candidate {
            method: tried.method,
            structure: tried.structure.clone(),
            held_out_rmse: Some(tried.held_out_rmse),
            held_out_nrmse: Some(worst(&self.plan.judged)),
            fitted_nrmse: Some(worst(&self.plan.fitted)),
            parameters: tried.count(),
            seconds: tried.seconds,
            predicted: tried.predicted.clone(),
            accepted: false,
            reason: reason.to_owned(),
            plant: Some(tried.plant.clone()),
            simulations: tried.simulations.clone(),
        }
    }

    /// Root mean square error over all rows held out.
    pub(super) fn pooled(&self, simulations: &[Vec<f64>]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for ((record, rows), simulation) in
            self.records.iter().zip(&self.plan.judged).zip(simulations)
        {
            let figures = compare(record.output(), simulation, *rows);
            sum += figures.rmse.powi(2) * rows.len() as f64;
            count += rows.len();
        }
        (sum / count.max(1) as f64).sqrt()
    }

    pub(super) fn result(
        self,
        baseline: Tried,
        best: Tried,
        candidates: Vec<Candidate>,
        stopped: bool,
    ) -> Identification {
        let records = (0..self.records.len())
            .map(|k| {
                let (fitted, judged) = (self.plan.fitted[k], self.plan.judged[k]);
                let (model, line) = (&best.simulations[k], &baseline.simulations[k]);
                RecordFit::of(&self.records[k], fitted, judged, model, line)
            })
            .collect();
        Identification {
            plant: best.plant,
            unit: self.target.axis.position.unit.clone(),
            rules: RULES,
            method: best.method.unwrap_or(STATIC.name()),
            stopped,
            records,
            candidates,
            parameters: best.parameters,
        }
    }
}
