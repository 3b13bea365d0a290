//! The candidates: each effect is a family of formulas.

mod actuator;
mod input;
mod mechanics;
mod sensor;
#[cfg(test)]
mod tests;

pub(crate) use actuator::gain;
use components::effects;
use model::{Effect, Stage};
use surround::Span;

use crate::base::{Base, Part};
use crate::converter::Gaps;
use crate::data_set::DataSet;
use crate::formula::{Family, Formula};
pub(crate) use crate::formula::{Piece, Slot};

/// What formulas are written for.
pub(crate) struct Setting<'a> {
    pub(crate) base: &'a Base,
    pub(crate) data: &'a DataSet,
    /// Range of the command.
    pub(crate) command: Span,
    /// Range of the simulated position behind the actuator, and of the output.
    pub(crate) position: Span,
    /// Root mean square that the re-tuned model leaves, over half the range of the readings.
    pub(crate) leaves: f64,
    /// Sample time of the log in s.
    pub(crate) sample: f64,
    /// Length of the longest record in s.
    pub(crate) length: f64,
    /// Greatest and root mean square slope of the command per second.
    pub(crate) steepest: f64,
    pub(crate) slope_power: f64,
    /// Mean of the command's rate times its distance from the centre.
    pub(crate) loop_power: f64,
    /// Mean of the command's rate times the command.
    pub(crate) apparent_power: f64,
    /// Residual of the re-tuned model at the rows of the fit, for the search for lines.
    pub(crate) lines: Vec<f64>,
    /// Frequencies in Hz at which instants may swing.
    pub(crate) swings: Vec<f64>,
    /// Frequency of the model's first mode in Hz.
    pub(crate) resonance: Option<f64>,
    /// Converters that may have rounded the command: steps over its range, phase.
    pub(crate) steps: Vec<(f64, f64)>,
    /// Converter of the command with codes missing.
    pub(crate) gaps: Option<Gaps>,
    /// Converters that may have rounded the reading: steps over the range of the position, phase.
    pub(crate) reading_steps: Vec<(f64, f64)>,
    /// Converter of the reading with codes missing.
    pub(crate) reading_gaps: Option<Gaps>,
}

impl Setting<'_> {
    /// Position over command, over the ranges of both: of the readings, where the model follows less of them than there is.
    pub(crate) fn slope(&self) -> f64 {
        self.position.half.max(self.data.output_span.half) / self.command.half
    }
}

/// All families, without those that were taken out and those that this model or log cannot show.
pub(crate) fn families(setting: &Setting<'_>, without: &[String]) -> Vec<Family> {
    let mut all = Vec::new();
    input::add(setting, &mut all);
    actuator::add(setting, &mut all);
    mechanics::add(setting, &mut all);
    sensor::add(setting, &mut all);
    for family in &mut all {
        family.add_release(setting.base);
        let is_white = setting.base.is_white;
        // A model that is cut at a tap has a part of the places only, a motion no reading of its own.
        let has_place = |f: &Formula| {
            let slots = &setting.base.slots;
            let is_there = |slot: Slot| slot != Slot::Reading || setting.base.part != Part::Motion;
            f.pieces.iter().all(|p| slots.contains_key(&p.slot) && is_there(p.slot))
        };
        family.formulas.retain(has_place);
        family.formulas.retain(|f| {
            let goes_in = !f.pieces.is_empty()
                || f.nuisance.is_some()
                || f.force.is_some()
                || f.joint_mode.is_some();
            goes_in || is_white || !f.releases.is_empty()
        });
    }
    let is_reading = matches!(setting.base.part, Part::Reading(_));
    all.retain(|f| !is_reading || is_of_reading(f.effect));
    all.retain(|f| !f.formulas.is_empty() && !without.iter().any(|name| name == f.effect.name));
    all
}

/// Whether an effect can lie behind the position, with nothing but the position known.
fn is_of_reading(effect: &Effect) -> bool {
    // What the command is by itself does not enter.
    let needs_command = effect.name == effects::CROSSTALK.name;
    let also = [&effects::ACTUATOR_GAIN, &effects::DELAY];
    (effect.stage >= Stage::Coupling && !needs_command)
        || also.iter().any(|other| other.name == effect.name)
}

impl Family {
    /// Adds the formula that takes the tolerance from the model's own parameters of this effect.
    fn add_release(&mut self, base: &Base) {
        let name = Some(self.effect.name);
        let own = base.parameters.iter().enumerate().filter(|(_, p)| p.effect == name);
        let releases: Vec<usize> = own.map(|(k, _)| k).collect();
        if !releases.is_empty() {
            let mut formula = Formula::new("the model's own parameter").start(&[]);
            formula.releases = releases;
            self.formulas.push(formula);
        }
    }
}
