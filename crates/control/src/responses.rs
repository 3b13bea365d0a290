//! What a finished controller does over frequency and in time, computed from the controller as it is written.
//!
//! The feedback of an axis is linear between its limits. Its responses C (measured position to command) and R (reference
//! to command) come from an impulse into its components alone, without limits and couplings. With the plant's response G
//! at its steepest slope, hold and delays included,
//!
//! ```text
//! L = C·G,   S = 1/(1 + L),   T = R·G/(1 + L)   (reference to position, feedback alone)
//! ```
//!
//! None of this uses the design's own laws, so that the curves also test them. The runs in time are those of the whole
//! controller on the whole plant.

use core::f64::consts::TAU;

use data::{Blueprint, CheckedBlueprint, Value};
use identify::Error;
use model::{Kind, NodeSpec};
use nalgebra::Complex;

use crate::along::late;
use crate::analysis::{Analysed, analyse, linear_of};
use crate::check;
use crate::closed_loop::{LoopRun, Side, simulate_loop};
use crate::damping;
use crate::design::{CommandActs, SHIFTS};
use crate::inversion::{LoopFigures, refused};
use crate::invert::step_of;
use crate::learned_axis::LearnedAxis;
use crate::linearised::{modes, shifted, varied};
use crate::loop_shape::Response;

/// Part of the reach of a step of the reference.
const STEP: f64 = 0.1;
/// Length of a step's run in parts of 1/bandwidth, and its fewest and most samples.
const LENGTH: (f64, usize, usize) = (3.0, 200, 20_000);
/// Part of what is kept of a step's run before the step; as long a run-in in front of it is left out.
const BEFORE: f64 = 0.1;
/// Most samples of a law's impulse response, and the part of its greatest value that has died away.
const RESPONSE: (usize, f64) = (100_000, 1e-13);
/// Samples in a row that must have died away.
const QUIET: usize = 50;
/// Limits that no impulse reaches.
const UNLIMITED: f64 = 1e15;

/// The loop of an axis over frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyCurves {
    /// In Hz, up to half the sample rate.
    pub frequency: Vec<f64>,
    /// L on the plant as given, the later of the times at which a command may act.
    pub open: Vec<Complex<f64>>,
    /// T there.
    pub closed: Vec<Complex<f64>>,
    /// The greatest |S| of all plants.
    pub worst: Vec<f64>,
    /// How many plants these are.
    pub plants: usize,
    /// Whether other axes act on this one within the loop: the curves are then those of the axis by itself.
    pub is_coupled: bool,
}

/// A run of the whole loop and of its parts.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeRun {
    /// Frequency of the wave in Hz; `None`: a step of this axis.
    pub wave: Option<f64>,
    /// Reference, later by the controller's preview; all behind the run-in.
    pub reference: Vec<f64>,
    /// The whole controller: position, command.
    pub complete: (Vec<f64>, Vec<f64>),
    /// Position with the feedforward alone; `None` where there is none.
    pub feedforward: Option<Vec<f64>>,
    /// Position with the feedback alone.
    pub feedback: Vec<f64>,
}

/// What an axis does.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisResponses {
    /// Sample time of the runs in s.
    pub period: f64,
    /// None where the axis has no feedback.
    pub curves: Option<FrequencyCurves>,
    /// A step, then waves as of [`Check`](crate::Check).
    pub runs: Vec<TimeRun>,
    /// What could not be run, and why.
    pub notes: Vec<String>,
}

/// What a controller of [`invert`](crate::invert) does on its plant.
///
/// # Errors
/// [`Error::NotInvertible`] with every reason on every axis; [`Error::Model`] where the plant does not run.
pub fn responses(
    plant: &CheckedBlueprint,
    controller: &CheckedBlueprint,
    axes: &[LoopFigures],
    acts: CommandActs,
) -> Result<Vec<AxisResponses>, Error> {
    let period = controller.spec().period;
    let wrong = |message: String| Error::Model { name: plant.spec().name.clone(), message };
    let step = step_of(plant.spec(), period).map_err(wrong)?;
    let analysed = analyse(plant, (step, period)).map_err(refused)?;
    let mut slowed = plant.blueprint().clone();
    slowed.step = Value::Number(step);
    let slowed = slowed.check(learned::COMPONENTS).map_err(|e| wrong(e.to_string()))?;
    let complete = Runs::new(&slowed, controller, axes)?;
    let mut all = Vec::new();
    for (index, figures) in axes.iter().enumerate() {
        let plant_axis =
            PlantAxis { plant, analysed: &analysed, index, figures, acts, step, period };
        let curves = if figures.ki == 0.0 && figures.damping.is_none() {
            None
        } else {
            Some(plant_axis.curves(controller).map_err(wrong)?)
        };
        let (runs, notes) = complete.of(index);
        all.push(AxisResponses { period, curves, runs, notes });
    }
    Ok(all)
}

/// An axis of the plant.
struct PlantAxis<'a> {
    plant: &'a CheckedBlueprint,
    analysed: &'a Analysed,
    index: usize,
    figures: &'a LoopFigures,
    acts: CommandActs,
    step: f64,
    period: f64,
}

impl PlantAxis<'_> {
    fn curves(&self, controller: &CheckedBlueprint) -> Result<FrequencyCurves, String> {
        let (index, period) = (self.index, self.period);
        let law = law_of(controller.blueprint(), index)?;
        let measured = impulse(&law, "measured", period)?;
        let reference = impulse(&law, "reference", period)?;
        let nodes = linear_of(self.analysed, index);
        let mut light = modes(&nodes);
        let learned = LearnedAxis::of(self.plant, index, period).map_err(|e| e.join("; "))?;
        light.extend(learned.iter().flat_map(LearnedAxis::modes));
        let shifted = |mode: &(f64, f64)| SHIFTS.map(|shift| shift * mode.0);
        let frequencies: Vec<f64> = light.iter().flat_map(shifted).collect();
        let mut plants = self.variants(&nodes)?;
        if plants.is_empty() {
            return Err("has no response".to_owned());
        }
        let given = Response::new(&plants.remove(0), period, &frequencies);
        let laws: Vec<[Complex<f64>; 2]> = given
            .angles
            .iter()
            .map(|angle| {
                let back = Complex::from_polar(1.0, -angle);
                [-along(&measured, back), along(&reference, back)]
            })
            .collect();
        let later = self.acts.later();
        let as_late =
            |plant: &Response, is_later| if is_later { plant.clone() } else { plant.at_once() };
        let one = Complex::new(1.0, 0.0);
        let nominal = as_late(&given, later.contains(&true));
        let pairs = || laws.iter().zip(&nominal.values);
        let open: Vec<Complex<f64>> = pairs().map(|([c, _], plant)| c * plant).collect();
        let closed = pairs().zip(&open).map(|(([_, r], plant), l)| r * plant / (one + l)).collect();
        let mut worst = vec![0.0_f64; open.len()];
        let others = plants.iter().map(|impulse| given.of(impulse));
        let slopes = self.slopes();
        let mut number = 0;
        for plant in std::iter::once(given.clone()).chain(others) {
            for is_later in later {
                let plant = as_late(&plant, *is_later);
                for slope in &slopes {
                    number += 1;
                    for (([c, _], plant), worst) in laws.iter().zip(&plant.values).zip(&mut worst) {
                        *worst = worst.max(1.0 / (one + c * plant * slope).norm());
                    }
                }
            }
        }
        Ok(FrequencyCurves {
            frequency: given.angles.iter().map(|angle| angle / (TAU * period)).collect(),
            open,
            closed,
            worst,
            plants: number,
            is_coupled: self
                .analysed
                .groups
                .iter()
                .any(|g| g.is_dynamic && g.axes.contains(&index)),
        })
    }

    /// The impulse responses for which the loop is designed, that of the plant as given first.
    fn variants(&self, nodes: &[NodeSpec]) -> Result<Vec<Vec<f64>>, String> {
        let of = |nodes: &[NodeSpec]| {
            let times = (self.step, self.period);
            self.analysed.impulse(self.plant, self.index, nodes, self.figures.slope, times)
        };
        if self.figures.damping.is_some() {
            let grid = damping::grid();
            return grid.map(|(shift, damping)| of(&varied(nodes, shift, damping))).collect();
        }
        let shifts = if modes(nodes).is_empty() { &SHIFTS[..1] } else { &SHIFTS[..] };
        shifts.iter().map(|shift| of(&shifted(nodes, *shift))).collect()
    }

    /// Slopes over the steepest for which the loop is designed one by one.
    fn slopes(&self) -> Vec<f64> {
        if self.figures.damping.is_none() {
            return vec![1.0];
        }
        damping::slopes(self.figures.slope, self.analysed.paths[self.index].sweep.least_slope)
            .to_vec()
    }
}

/// Σ dₖ z⁻ᵏ/(1 − z⁻¹) of the differences d of a response.
fn along(differences: &[f64], back: Complex<f64>) -> Complex<f64> {
    let sum = differences.iter().rev().fold(Complex::new(0.0, 0.0), |sum, d| sum * back + d);
    sum / (Complex::new(1.0, 0.0) - back)
}

/// The feedback of an axis by itself, without limits.
fn law_of(controller: &Blueprint, index: usize) -> Result<CheckedBlueprint, String> {
    let alone = check::without_feedforward(controller);
    let mut axis = alone.axes.into_iter().nth(index).ok_or("the controller has no such axis")?;
    for component in &mut axis.components {
        for (limit, value) in [("output_min", -UNLIMITED), ("output_max", UNLIMITED)] {
            if component.get(limit).is_some() {
                component.set(limit, value);
            }
        }
    }
    axis.command = axis.command.between(-UNLIMITED, UNLIMITED);
    axis.motion = data::SignalBlueprint::default();
    (axis.position.min, axis.position.max) = (None, None);
    axis.reference.start = None;
    let step = controller.step.clone();
    let mut law = Blueprint::new(Kind::Controller, "law", 1.0).axis(axis);
    law.step = step;
    law.check(learned::COMPONENTS).map_err(|problems| problems.to_string())
}

/// The differences of the command after an impulse of 1 into this input, which die away where the law's one
/// integrator holds what it has.
fn impulse(law: &CheckedBlueprint, input: &str, period: f64) -> Result<Vec<f64>, String> {
    let run = || -> Result<Vec<f64>, Error> {
        let mut side = Side::new(law);
        side.set("reference", 0, 0.0)?;
        side.set("measured", 0, 0.0)?;
        side.initialise()?;
        side.advance(period)?;
        let mut last = side.get("command", 0)?;
        let (mut differences, mut greatest, mut quiet) = (Vec::new(), 0.0_f64, 0);
        for k in 0..RESPONSE.0 {
            side.set(input, 0, if k == 0 { 1.0 } else { 0.0 })?;
            side.advance((k + 2) as f64 * period)?;
            let command = side.get("command", 0)?;
            let difference = command - last;
            last = command;
            differences.push(difference);
            greatest = greatest.max(difference.abs());
            quiet = if difference.abs() <= RESPONSE.1 * greatest { quiet + 1 } else { 0 };
            if quiet >= QUIET {
                break;
            }
        }
        Ok(differences)
    };
    run().map_err(|error| error.to_string())
}

/// Runs of plant and controller, and of the controller's parts.
struct Runs<'a> {
    plant: &'a CheckedBlueprint,
    complete: &'a CheckedBlueprint,
    forward: Option<CheckedBlueprint>,
    back: CheckedBlueprint,
    axes: &'a [LoopFigures],
    period: f64,
}

impl<'a> Runs<'a> {
    fn new(
        plant: &'a CheckedBlueprint,
        complete: &'a CheckedBlueprint,
        axes: &'a [LoopFigures],
    ) -> Result<Self, Error> {
        let checked = |blueprint: Blueprint| {
            let name = blueprint.name.clone();
            let found = blueprint.check(learned::COMPONENTS);
            found.map_err(|problems| Error::Model { name, message: problems.to_string() })
        };
        let feeds = axes.iter().any(|axis| axis.checks.iter().any(|c| c.feedforward.is_some()));
        let forward = check::without_feedback(complete.blueprint());
        Ok(Self {
            plant,
            complete,
            forward: if feeds { Some(checked(forward)?) } else { None },
            back: checked(check::without_feedforward(complete.blueprint()))?,
            axes,
            period: complete.spec().period,
        })
    }

    /// A step of this axis, and the waves of all.
    fn of(&self, index: usize) -> (Vec<TimeRun>, Vec<String>) {
        let reaches: Vec<(f64, f64)> = self.axes.iter().map(|axis| axis.reach).collect();
        let (step, from) = self.step(index);
        let mut wanted = vec![(None, step, from)];
        for check in &self.axes[index].checks {
            let (references, from) = check::waves(&reaches, check.frequency, self.period);
            wanted.push((Some(check.frequency), references, from));
        }
        let (mut runs, mut notes) = (Vec::new(), Vec::new());
        for (wave, references, from) in wanted {
            match self.run(index, wave, &references, from) {
                Ok(run) => runs.push(run),
                Err(error) => {
                    let what = wave.map_or_else(
                        || "the step".to_owned(),
                        |frequency| format!("the wave of {frequency:.4} Hz"),
                    );
                    notes.push(format!("{what} could not be run: {error}"));
                }
            }
        }
        (runs, notes)
    }

    fn run(
        &self,
        index: usize,
        wave: Option<f64>,
        references: &[Vec<f64>],
        from: usize,
    ) -> Result<TimeRun, Error> {
        let run = |controller: &CheckedBlueprint| -> Result<LoopRun, Error> {
            simulate_loop(self.plant, controller, references, self.period)
        };
        let kept = |mut rows: Vec<f64>| rows.split_off(from.min(rows.len()));
        let (mut complete, mut back) = (run(self.complete)?, run(&self.back)?);
        let has = self.axes[index].checks.iter().any(|check| check.feedforward.is_some());
        let forward = self.forward.as_ref().filter(|_| has).map(run).transpose()?;
        let reference = &references[index];
        let wanted = check::delayed(reference, late(self.complete, index));
        Ok(TimeRun {
            wave,
            reference: kept(wanted.take(reference.len()).collect()),
            complete: (
                kept(std::mem::take(&mut complete.position[index])),
                kept(std::mem::take(&mut complete.command[index])),
            ),
            feedforward: forward.map(|mut run| kept(std::mem::take(&mut run.position[index]))),
            feedback: kept(std::mem::take(&mut back.position[index])),
        })
    }

    /// The references of a step of one axis in the middle of its reach, while the others rest there, and the first row
    /// after the run-in.
    fn step(&self, index: usize) -> (Vec<Vec<f64>>, usize) {
        let wanted = LENGTH.0 / (self.axes[index].bandwidth * self.period);
        let rows = wanted.clamp(LENGTH.1 as f64, LENGTH.2 as f64) as usize;
        let each = self.axes.iter().enumerate().map(|(other, axis)| {
            let (low, high) = axis.reach;
            let (middle, half) = (0.5 * (low + high), 0.5 * STEP * (high - low));
            let at = |k: usize| match (other == index, (k as f64) < (1.0 + BEFORE) * rows as f64) {
                (false, _) => middle,
                (true, true) => middle - half,
                (true, false) => middle + half,
            };
            (0..2 * rows).map(at).collect()
        });
        (each.collect(), rows)
    }
}
