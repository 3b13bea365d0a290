//! Axes that a coupling with dynamics joins: their laws and their feedforward, for all of them together.

use identify::{Error, NotInvertible};

use super::Work;
use crate::coupled_loop::{CoupledPlants, coupled};
use crate::coupling::Group;
use crate::damping::grid;
use crate::design::Feedback;
use crate::feedforward::Feedforward;
use crate::inversion::refused;
use crate::loop_shape::Limits;
use crate::preview::{self, Preview};

impl Work<'_> {
    /// Designs the laws of axes that a coupling with dynamics joins, for all of them together.
    pub(crate) fn couple(&mut self) -> Result<(), Error> {
        let (settings, analysed) = (self.settings, self.analysed);
        for group in &analysed.groups {
            let preview = self.preview(group)?;
            if preview.is_some() {
                for axis in &group.axes {
                    self.designs[*axis].leads.clear();
                }
            }
            self.previews.push(preview);
            self.coupled.push(None);
            if !group.is_dynamic || settings.independent || settings.feedback == Feedback::None {
                continue;
            }
            let names = group.axes.iter().map(|axis| &*self.plant.spec().axes[*axis].name);
            let place = format!("axes {}", names.collect::<Vec<_>>().join(", "));
            let at_group =
                |reason: String| refused(vec![NotInvertible { place: place.clone(), reason }]);
            let times = (self.step, self.period);
            let responses = grid()
                .map(|factors| analysed.coupled_impulses(self.plant, group, times, factors))
                .collect::<Result<Vec<_>, _>>()
                .map_err(at_group)?;
            let shapes: Vec<_> =
                group.axes.iter().map(|axis| self.designs[*axis].shaped.shape).collect();
            let slopes: Vec<f64> =
                group.axes.iter().map(|axis| self.designs[*axis].slope).collect();
            let light = group.light_modes(self.plant);
            let coupled_plants = CoupledPlants {
                responses: &responses,
                slopes: &slopes,
                first: light.into_iter().min_by(f64::total_cmp),
                period: self.period,
            };
            let limits = Limits { sensitivity: settings.sensitivity, noise: settings.noise };
            let found = coupled(&coupled_plants, &shapes, settings.feedback, settings.acts, limits);
            let found = found.map_err(at_group)?;
            for (axis, shaped) in group.axes.iter().zip(&found.axes) {
                self.designs[*axis].shaped = *shaped;
                self.designs[*axis].notches = found.notches();
            }
            self.coupled.pop();
            self.coupled.push(Some(found.figures));
        }
        if self.settings.feedforward == Feedforward::Preview
            && self.previews.iter().all(Option::is_none)
        {
            let reason = "--feedforward preview compensates the dynamics of a coupling between axes, and this plant has no coupling with dynamics; leave it out";
            let place = self.plant.spec().name.clone();
            return Err(refused(vec![NotInvertible { place, reason: reason.to_owned() }]));
        }
        Ok(())
    }

    /// The inverse of a group's dynamics, where one is asked for.
    fn preview(&self, group: &Group) -> Result<Option<Preview>, Error> {
        if self.settings.feedforward != Feedforward::Preview || !group.is_dynamic {
            return Ok(None);
        }
        let times = (self.step, self.period);
        let responses = preview::SHIFTS
            .map(|shift| self.analysed.coupled_impulses(self.plant, group, times, (shift, 1.0)))
            .into_iter()
            .collect::<Result<Vec<_>, _>>()
            .map_err(|reason| {
                refused(vec![NotInvertible { place: self.plant.spec().name.clone(), reason }])
            })?;
        let slopes: Vec<f64> = group.axes.iter().map(|axis| self.designs[*axis].slope).collect();
        Ok(Some(preview::inverse(&responses, &slopes, self.settings.acts.later(), self.period)))
    }

    /// The feedforward of each axis that is asked for.
    pub(super) fn asked(&self) -> Feedforward {
        match self.settings.feedforward {
            Feedforward::Preview => Feedforward::Automatic,
            other => other,
        }
    }

    /// By how many periods each axis follows late.
    pub(super) fn late(&self) -> Vec<usize> {
        let mut late = vec![0; self.designs.len()];
        for (group, preview) in self.analysed.groups.iter().zip(&self.previews) {
            for axis in &group.axes {
                late[*axis] = preview.as_ref().map_or(0, |preview| preview.ahead);
            }
        }
        late
    }
}
