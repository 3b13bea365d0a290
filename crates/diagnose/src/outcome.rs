//! The diagnosis of one output, as the answer, the page and the repair take it.

use std::sync::OnceLock;

use crate::belief::BeliefContext;
use crate::between::Course;
use crate::candidate::{Candidate, Found};
use crate::formula::{Family, Formula};
use crate::gap::{SecondOpinion, Verdict};
use crate::offset::Offset;
use crate::score::{Judge, Judged};
use crate::task::Task;

/// The diagnosis of one output.
pub(crate) struct Outcome {
    pub(crate) task: Task,
    pub(crate) library: Vec<Family>,
    pub(crate) judge: Judge,
    /// Standard deviation of the noise in SI.
    pub(crate) sigma: f64,
    /// Mean square over the noise's up to which nothing is left.
    pub(crate) adequate: f64,
    /// What the user calls good enough, in powers of the noise.
    pub(crate) fine: f64,
    /// What is left and follows from the command, in powers of the noise; none where no record is long enough to see it.
    pub(crate) caused: Option<f64>,
    pub(crate) verdict: Verdict,
    /// The model as given, judged.
    pub(crate) given: Judged,
    pub(crate) found: Found,
    /// Residual of the robustly re-tuned model, in standard deviations.
    pub(crate) robust: Vec<f64>,
    /// Standard deviation of the noise over the stated one, where that is all that is missing.
    pub(crate) noise_ratio: Option<f64>,
    /// How well complete records that are left out of the fit are predicted.
    pub(crate) second: Option<SecondOpinion>,
    /// Offsets of the records.
    pub(crate) offset: Option<Offset>,
    /// The axes that a coupling joins with this one and in front of which something was found that moves this reading.
    pub(crate) moved_by: Vec<usize>,
    /// What the model left as it came, without what was found in those.
    pub(crate) original: Option<Original>,
    /// The answer judged without a course of its own, which no model predicts, where it has one.
    pub(crate) predicted: Option<Judged>,
    /// Single effects that explain the log as well, each under another reading of it.
    pub(crate) otherwise: Vec<(Course, &'static str)>,
    /// Draws of the part of the gap's power that is left on new records, once they are asked for.
    pub(crate) on_new_records: OnceLock<Vec<f64>>,
}

/// The model as it came, where a part of what is missing was found in other axes.
#[derive(Clone)]
pub(crate) struct Original {
    /// The model as given, judged.
    pub(crate) given: Judged,
    /// The re-tuned model, judged.
    pub(crate) before: Judged,
    /// Residual of the robustly re-tuned model, in standard deviations.
    pub(crate) robust: Vec<f64>,
    /// Standard deviation of the noise by which all are judged, in SI.
    pub(crate) sigma: f64,
}

impl Original {
    /// The model as it came in standard deviations of another outcome's noise.
    pub(crate) fn in_units_of(self, o: &Outcome) -> Self {
        let ratio = self.sigma / o.sigma;
        let scaled = |residual: &[f64]| residual.iter().map(|r| ratio * r).collect::<Vec<f64>>();
        let judged = |j: &Judged| o.judge.figures(scaled(&j.residual), &o.task.data);
        let (given, before) = (judged(&self.given), judged(&self.before));
        Self { given, before, robust: scaled(&self.robust), sigma: o.sigma }
    }
}

impl Outcome {
    /// The model as given, judged.
    pub(crate) fn as_given(&self) -> &Judged {
        self.original.as_ref().map_or(&self.given, |original| &original.given)
    }

    /// The re-tuned model, judged, without anything that was found.
    pub(crate) fn before(&self) -> &Judged {
        self.original.as_ref().map_or(&self.found.base.judged, |original| &original.before)
    }

    /// The formulas of a candidate.
    pub(crate) fn formulas(&self, candidate: &Candidate) -> impl Iterator<Item = &Formula> {
        candidate.picks.iter().map(|(family, number)| &self.library[*family].formulas[*number])
    }

    /// Numbers of the model's parameters that the effects of a candidate release.
    pub(crate) fn released(&self, candidate: &Candidate) -> Vec<usize> {
        self.formulas(candidate).flat_map(|formula| formula.releases.clone()).collect()
    }

    /// The effects of a candidate: name, formula, values of its parameters.
    pub(crate) fn effects<'a>(
        &'a self,
        candidate: &'a Candidate,
    ) -> impl Iterator<Item = (&'static str, &'a Formula, Vec<f64>)> {
        let parameters = candidate.chain.parameters.iter().zip(&candidate.fit.theta);
        let mut own = parameters.skip_while(|(p, _)| p.is_base);
        candidate.picks.iter().map(move |(family, number)| {
            let family = &self.library[*family];
            let formula = &family.formulas[*number];
            let values = own.by_ref().take(formula.parameters.len()).map(|(p, q)| p.value(*q));
            (family.effect.name, formula, values.collect())
        })
    }

    /// Whether something was found that explains the reading, in its own axis or in others.
    pub(crate) fn is_explained(&self) -> bool {
        !self.found.last.picks.is_empty() || !self.moved_by.is_empty()
    }

    /// The answer's candidate, or the best single effect where none is named.
    pub(crate) fn best(&self) -> &Candidate {
        let found = &self.found;
        if !found.last.picks.is_empty() {
            return &found.last;
        }
        let fitted = found.first.iter().filter_map(|l| l.best.as_ref());
        fitted.min_by(|a, b| a.rank.total_cmp(&b.rank)).unwrap_or(&found.base)
    }

    /// The answer as a model can predict it.
    pub(crate) fn with_effects(&self) -> &Judged {
        self.predicted.as_ref().unwrap_or(&self.found.last.judged)
    }

    /// What beliefs in what was found are formed from.
    pub(crate) fn sight(&self) -> BeliefContext<'_> {
        let sight = BeliefContext::new(&self.library, &self.found.base, self.adequate, self.fine);
        sight.with_left(&self.found.last, self.caused)
    }

    /// Mean square in SI that [`Self::best`] leaves, on fitted and held-out rows alike.
    pub(crate) fn left(&self) -> f64 {
        let judged = &self.best().judged;
        0.5 * (judged.training + judged.held_out) * self.sigma.powi(2)
    }

    /// What is left as given, re-tuned and at last, the last one rounded as the reading is, over the noise before the
    /// rounding; none where the reading moves in no steps that are named.
    pub(crate) fn against_noise(&self, left: [&Judged; 3]) -> Option<[Judged; 3]> {
        let steps = self.task.steps?;
        let data = &self.task.data;
        let over = self.sigma / steps.beside;
        let [given, before, after] =
            left.map(|judged| -> Vec<f64> { judged.residual.iter().map(|r| over * r).collect() });
        let si: Vec<f64> = after.iter().map(|r| steps.beside * r).collect();
        let rounded = steps.left(&data.y, &si).into_iter().map(|r| r / steps.beside).collect();
        Some([given, before, rounded].map(|residual| self.judge.figures(residual, data)))
    }
}
