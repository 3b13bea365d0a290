//! What is known of a controller.

use super::{HARMFUL, Work};
use crate::check::Check;
use crate::coupled_loop::CoupledFigures;
use crate::coupling::Group;
use crate::design::Feedback;
use crate::inversion::{Coordinator, LoopFigures};
use crate::loop_shape::Shaped;
use crate::preview::Preview;

impl Work<'_> {
    pub(super) fn figures(
        &self,
        index: usize,
        pick: usize,
        reach: (f64, f64),
        checks: Vec<Check>,
    ) -> LoopFigures {
        let design = &self.designs[index];
        let Shaped { shape, ki, .. } = design.shaped;
        let ki = if self.settings.feedback == Feedback::None { 0.0 } else { ki };
        let way = design.ways.get(pick);
        let mut left = design.notes.clone();
        if let Some(check) = checks.first()
            && let Some(alone) = check.feedforward.filter(|alone| *alone < check.closed_loop)
            && check.closed_loop > HARMFUL
            && ki != 0.0
        {
            left.push(format!(
                "with feedback the error is larger than with the feedforward alone ({:.3} % of the reach instead of {:.3} %): the position does not follow small commands smoothly; --feedback none omits the feedback",
                100.0 * check.closed_loop,
                100.0 * alone
            ));
        }
        LoopFigures {
            axis: self.plant.spec().axes[index].name.clone(),
            feedforward: way.map_or_else(|| "none".to_owned(), |way| way.name.clone()),
            shape: shape.name.to_owned(),
            slope: design.slope,
            kp: ki * shape.a,
            ki,
            kd: ki * shape.b,
            derivative_filter: shape.filter,
            bandwidth: design.shaped.bandwidth,
            gain_margin: design.shaped.gain_margin,
            phase_margin: design.shaped.phase_margin.to_degrees(),
            sensitivity: design.shaped.sensitivity,
            noise_gain: match &design.damped {
                Some(damped) => damped.figures.noise / design.slope.abs(),
                None => ki.abs() * shape.noise(self.period),
            },
            delay: design.delay,
            reach,
            damping: design.damped.as_ref().map(|damped| damped.figures.clone()),
            checks,
            left_to_feedback: left,
            inverse: design.inverse,
        }
    }

    pub(super) fn coordinators(&self) -> Vec<Coordinator> {
        let one = |((group, figures), preview): (
            (&Group, &Option<CoupledFigures>),
            &Option<Preview>,
        )| {
            let mut notes = Vec::new();
            if group.is_dynamic && preview.is_none() {
                notes.push("decoupled by the gain at rest; the dynamics between axes remain");
            }
            if self.settings.independent {
                notes.push("in pairs, each on its own sensor: what one pair does to another is left to feedback");
            }
            if group.is_bent {
                notes
                    .push("straight about the middle of the motions; the rest is left to feedback");
            }
            Coordinator {
                axes: group.axes.iter().map(|a| self.plant.spec().axes[*a].name.clone()).collect(),
                couplings: group.kinds.clone(),
                condition: group.condition,
                coupled_loop: figures.clone(),
                preview: preview.as_ref().map(|preview| preview.figures.clone()),
                note: notes.join("; "),
            }
        };
        self.analysed.groups.iter().zip(&self.coupled).zip(&self.previews).map(one).collect()
    }
}

/// What stands beside the law in the blueprint.
pub(super) fn note_of(figures: &LoopFigures) -> String {
    let mut note = format!(
        "{}: loop gain 1 at {:.4} Hz, gain margin {:.1}, phase margin {:.0} deg, maximum sensitivity \
         {:.2}, delay {:.3e} s; feedforward: {}; reach {:.5} to {:.5}",
        figures.shape,
        figures.bandwidth,
        figures.gain_margin,
        figures.phase_margin,
        figures.sensitivity,
        figures.delay,
        figures.feedforward,
        figures.reach.0,
        figures.reach.1
    );
    if let Some(damped) = &figures.damping {
        note += &format!(
            "; resonance {:.4} Hz, closed loop within 3 dB up to {:.4} Hz (at least {:.4} Hz on {} plants, all stable), \
             2 % of a step within {:.3e} s{}, noise to the command {:.2}",
            damped.resonance,
            damped.closed_loop_bandwidth,
            damped.least_closed_loop_bandwidth,
            damped.plants,
            damped.settling,
            damped
                .notch_settling
                .map_or_else(String::new, |(given, _)| format!(" (PI with a notch {given:.3e} s)")),
            damped.noise
        );
    }
    for check in &figures.checks {
        let percent = |part: f64| format!("{:.4} %", 100.0 * part);
        note += &format!(
            "; on its own plant at {:.4} Hz: loop {}, feedforward alone {}, feedback alone {} of the reach (rms)",
            check.frequency,
            percent(check.closed_loop),
            check.feedforward.map_or_else(|| "none".to_owned(), percent),
            percent(check.feedback)
        );
    }
    for left in &figures.left_to_feedback {
        note += "; left to feedback: ";
        note += left;
    }
    note
}
