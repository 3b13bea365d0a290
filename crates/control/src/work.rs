//! The controller of a whole plant: the best way of feedforward for each axis, and the run on the plant.

mod coupled;
mod figures;

use data::{
    AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, SignalBlueprint, Value,
};
use identify::learned::inverse;
use identify::{Error, NotInvertible, Observer};
use model::{Kind, Undoing};

use self::figures::note_of;
use crate::analysis::Analysed;
use crate::axis::{Design, buildable};
use crate::check::{self, Check};
use crate::coupled_loop::CoupledFigures;
use crate::damping::Damping;
use crate::design::Feedback;
use crate::feedforward::{self, Candidate, Feedforward, is_feedforward};
use crate::inverse_filter::InverseFilter;
use crate::inversion::{ControlSettings, Inversion, refused};
use crate::loop_shape::Shaped;
use crate::preview::Preview;

/// Error of a declared inverse on the plant, in parts of the reach, up to which nothing else is tried.
const GOOD: f64 = 2e-3;
/// Part of the error of the ways before it below which a way is taken in their place.
const CLEARLY: f64 = 0.8;
/// Error of a loop in parts of the reach from which it is said that the feedforward alone errs less.
const HARMFUL: f64 = 5e-3;
/// Part by which a loop may err more than feedback alone, and the part of the reach that does not count.
const WORSE: (f64, f64) = (1.05, 1e-4);

/// The component of the filter, where it does anything.
fn filter(inverse_filter: &InverseFilter, period: f64) -> Option<ComponentBlueprint> {
    let none: &[f64] = &[0.0];
    let a = if inverse_filter.filter.a.is_empty() { none } else { &inverse_filter.filter.a };
    inverse_filter.filters().then(|| {
        ComponentBlueprint::new("arx")
            .value("sample_time", period)
            .value("b", &inverse_filter.filter.b[..])
            .value("a", a)
            .note("the plant's discrete linear part, undone")
    })
}

/// A controller that is being made.
pub(crate) struct Work<'a> {
    pub(crate) plant: &'a CheckedBlueprint,
    pub(crate) settings: &'a ControlSettings,
    pub(crate) analysed: &'a Analysed,
    pub(crate) designs: Vec<Design>,
    pub(crate) step: f64,
    pub(crate) period: f64,
    /// Of each group, the figures of its loop where it was designed for all axes together.
    pub(crate) coupled: Vec<Option<CoupledFigures>>,
    /// Of each group, the inverse of its dynamics, where one is asked for.
    pub(crate) previews: Vec<Option<Preview>>,
}

/// What the plant is run with.
pub(crate) struct Runs {
    plant: CheckedBlueprint,
    /// Of each axis, in its own position.
    reaches: Vec<(f64, f64)>,
}

impl Work<'_> {
    /// The plant with the step that it is looked at with, and what it reaches.
    pub(crate) fn slowed(&self) -> Result<Runs, Error> {
        let mut blueprint = self.plant.blueprint().clone();
        let name = blueprint.name.clone();
        let plant = if self.step == self.plant.spec().period {
            self.plant.clone()
        } else {
            blueprint.step = Value::Number(self.step);
            let checked = blueprint.check(learned::COMPONENTS);
            checked.map_err(|e| Error::Model { name, message: e.to_string() })?
        };
        let delays: Vec<f64> = self.designs.iter().map(|design| design.delay).collect();
        let reaches = self.analysed.reaches(&plant, &delays, self.period)?;
        let learned =
            self.designs.iter().zip(reaches).map(|(design, reach)| {
                design.learned.as_ref().map_or(reach, |learned| learned.reach)
            });
        Ok(Runs { reaches: learned.collect(), plant })
    }

    /// Learns the inverses that can only be learned.
    pub(crate) fn learn(&mut self, observer: &mut dyn Observer) -> Result<(), Error> {
        let (period, asked) = (self.period, self.asked());
        for (index, design) in self.designs.iter_mut().enumerate() {
            let Some(learned) = &design.learned else { continue };
            if !matches!(asked, Feedforward::Automatic | Feedforward::Inverse) {
                continue;
            }
            let name = &self.plant.spec().axes[index].name;
            let at_axis = |reason: String| {
                refused(vec![NotInvertible { place: format!("axis {name}"), reason }])
            };
            let purpose = learned.purpose(self.settings.band).map_err(at_axis)?;
            let (machine, figures) = inverse::learn(&learned.forward, &purpose, observer).map_err(
                |error| match error {
                    Error::Stopped => error,
                    error => at_axis(error.to_string()),
                },
            )?;
            let file = format!("{name}.npy");
            let table = machine.table().map_err(|message| Error::Learned { message })?;
            let inverse_filter = InverseFilter::of(&learned.linear, period);
            let own = machine.component(true, &file, period);
            let chain = filter(&inverse_filter, period).into_iter().chain([own]).collect();
            let inverses = self.analysed.paths[index].actuator.component.inverses().iter();
            let kind = inverses.filter(|i| i.undoing == Undoing::Learned).map(|i| i.kind).next();
            design.ways.push(Candidate {
                way: Feedforward::Inverse,
                name: format!("{} (learned)", kind.unwrap_or("inverse")),
                chain,
                tables: Vec::new(),
                left: Vec::new(),
            });
            design.tables.push((file, table));
            design.inverse = Some(figures);
        }
        Ok(())
    }

    /// Takes the best of the ways for each axis, on the plant itself.
    pub(crate) fn choose(&mut self, runs: &Runs, observer: &mut dyn Observer) -> Result<(), Error> {
        let asked = self.asked();
        for design in &mut self.designs {
            design.ways.retain(|way| asked == Feedforward::Automatic || way.way == asked);
        }
        let errors = self.judged(runs, |design| design.ways.len());
        for (index, errors) in errors.iter().enumerate() {
            let path = &self.analysed.paths[index];
            let found = errors.iter().copied().fold(f64::INFINITY, f64::min);
            let automatic = asked == Feedforward::Automatic;
            if asked == Feedforward::Fitted
                || automatic && found > GOOD && self.designs[index].learned.is_none()
            {
                let suits = |way: Candidate| buildable(way, &path.axis, self.period);
                match feedforward::fitted(path, &suits, observer) {
                    Ok(way) => self.designs[index].ways.push(way),
                    Err(reason) => {
                        let note =
                            format!("no model could be fitted to the plant at rest: {reason}");
                        self.designs[index].notes.push(note);
                    }
                }
            }
            if matches!(asked, Feedforward::Dynamic | Feedforward::Process) {
                self.at_rates(index, observer);
            }
            let path = &self.analysed.paths[index];
            if asked == Feedforward::Linear || automatic && found > GOOD {
                self.designs[index].ways.push(feedforward::linear(path));
            }
            if self.designs[index].ways.is_empty() && !matches!(asked, Feedforward::None) {
                let place = format!("axis {}", path.axis.name);
                let design = &self.designs[index];
                let notes = design.notes[design.left..].join("; ");
                let reason = format!(
                    "{} has no feedforward of the way \"{}\"{}{notes}; --list shows what suits this plant",
                    path.actuator.name,
                    asked.name(),
                    if notes.is_empty() { "" } else { ": " },
                );
                return Err(refused(vec![NotInvertible { place, reason }]));
            }
        }
        let errors = self.judged(runs, |design| design.ways.len());
        for (design, errors) in self.designs.iter_mut().zip(&errors) {
            // The first ones are kept where others are hardly better.
            for (at, error) in errors.iter().enumerate() {
                if *error < CLEARLY * errors[design.chosen] || errors[design.chosen].is_nan() {
                    design.chosen = at;
                }
            }
            if let Some(way) = design.ways.get(design.chosen) {
                design.notes.extend(way.left.iter().cloned());
            }
        }
        Ok(())
    }

    /// The way that is fitted to what the plant does at several rates, where there is one.
    fn at_rates(&mut self, index: usize, observer: &mut dyn Observer) {
        let path = &self.analysed.paths[index];
        let suits = |way: Candidate| buildable(way, &path.axis, self.period);
        let design = &mut self.designs[index];
        let found = if self.settings.feedforward == Feedforward::Dynamic {
            feedforward::dynamic(path, &suits, observer)
        } else {
            let file = format!("{}.npy", path.axis.name);
            feedforward::process(path, &file, observer).map(|(way, table)| {
                design.tables.push((file, table));
                way
            })
        };
        match found {
            Ok(way) => design.ways.push(way),
            Err(reason) => design.notes.push(reason),
        }
    }

    /// Errors of each axis' ways without feedback along the slow wave, in parts of its reach.
    fn judged(&self, runs: &Runs, count: impl Fn(&Design) -> usize) -> Vec<Vec<f64>> {
        let most = self.designs.iter().map(count).max().unwrap_or(0);
        let frequency = check::frequencies(self.period, 0.0)[0];
        let (references, from) = check::waves(&runs.reaches, frequency, self.period);
        let mut found = vec![Vec::new(); self.designs.len()];
        for number in 0..most {
            let pick = |design: &Design| number.min(design.ways.len().saturating_sub(1));
            let picks: Vec<usize> = self.designs.iter().map(pick).collect();
            let errors = self.controller(&picks).and_then(|blueprint| {
                let alone = check::without_feedback(&blueprint);
                alone.check(learned::COMPONENTS).map_err(|e| e.to_string())
            });
            let errors = match errors {
                Ok(alone) => {
                    let late = self.late();
                    check::errors(&runs.plant, &alone, &references, from, self.period, &late)
                }
                Err(_) => vec![vec![f64::INFINITY]; self.designs.len()],
            };
            let errors = self.analysed.motions(&errors);
            for (index, own) in errors.iter().enumerate() {
                if number < self.designs[index].ways.len() {
                    let reach = self.analysed.motion_reach(index, runs.reaches[index]);
                    let error = check::rms(own) / (reach.1 - reach.0);
                    found[index].push(error);
                }
            }
        }
        found
    }

    /// The controller with these ways.
    fn controller(&self, picks: &[usize]) -> Result<Blueprint, String> {
        let spec = self.plant.spec();
        let name =
            self.settings.name.clone().unwrap_or_else(|| format!("{}_controller", spec.name));
        let mut controller = Blueprint::new(Kind::Controller, &name, self.period);
        controller.description = format!("Inverse feedforward and PID for {}", spec.name);
        controller.source = format!("inverted from {}", self.plant.blueprint().source);
        let blueprints = self.plant.blueprint().axes.iter();
        for (((index, design), pick), blueprint) in
            self.designs.iter().enumerate().zip(picks).zip(blueprints)
        {
            let way = design.ways.get(*pick);
            let chain: Vec<ComponentBlueprint> = match way {
                Some(way) => design.leads.iter().chain(&way.chain).cloned().collect(),
                None => Vec::new(),
            };
            if let Some(way) = way {
                controller.tables.extend(design.tables.iter().chain(&way.tables).cloned());
            }
            controller.axes.push(self.axis(index, blueprint, chain)?);
        }
        for (group, preview) in self.analysed.groups.iter().zip(&self.previews) {
            let names: Vec<&str> =
                group.axes.iter().map(|axis| controller_axis_name(&controller, *axis)).collect();
            let list = |row: Vec<f64>| Value::List(row.into_iter().map(Value::Number).collect());
            // Two axes a mirror: each sees its own sensor only.
            let own = |i: usize, j: usize| !self.settings.independent || i / 2 == j / 2;
            let rows = group.jacobian.row_iter().enumerate().map(|(i, row)| {
                let each = row.iter().enumerate();
                list(each.map(|(j, x)| if own(i, j) { *x } else { 0.0 }).collect())
            });
            let preview = preview.as_ref();
            let kind = preview.map_or("jacobian-coordinator", |_| "preview-coordinator");
            let mut coordinator = ComponentBlueprint::new(kind)
                .value("matrix", Value::List(rows.collect()))
                .value("offset", list(group.offset.clone()));
            if let Some(preview) = preview {
                coordinator = coordinator
                    .value("sample_time", self.period)
                    .value("preview", preview.ahead as f64 * self.period)
                    .value("taps", list(preview.taps.clone()));
            }
            let names: Vec<String> = names.into_iter().map(str::to_owned).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            controller = controller.coupling(&names, coordinator);
        }
        Ok(controller)
    }

    fn axis(
        &self,
        index: usize,
        plant: &AxisBlueprint,
        chain: Vec<ComponentBlueprint>,
    ) -> Result<AxisBlueprint, String> {
        let spec = &self.plant.spec().axes[index];
        let design = &self.designs[index];
        let (low, high) = spec.command_range;
        let Shaped { shape, ki, .. } = design.shaped;
        let off = self.settings.feedback == Feedback::None;
        let gain = |value: f64| if off { 0.0 } else { value };
        let incremental = self.settings.feedback == Feedback::IncrementalPid;
        let mut pid = ComponentBlueprint::new(if incremental { "incremental-pid" } else { "pid" })
            .value("kp", gain(ki * shape.a))
            .value("ki", gain(ki))
            .value("kd", gain(ki * shape.b));
        if !incremental {
            pid = pid.value("derivative_filter", shape.filter);
        }
        let pid = pid.value("output_min", low).value("output_max", high);
        let mut controller =
            AxisBlueprint::new(&spec.name, &spec.command_unit, &spec.position_unit);
        controller.command = controller.command.named(&plant.command.name).between(low, high);
        (controller.position.min, controller.position.max) =
            (plant.position.min.clone(), plant.position.max.clone());
        controller.motion.unit.clone_from(&plant.motion.unit);
        let position = &plant.position.name;
        let start = match &design.learned {
            Some(learned) => learned.at_rest(spec.start),
            None => self.analysed.at_rest(index, spec.start)?,
        };
        controller.reference = SignalBlueprint::default().start(start);
        if !position.is_empty() {
            controller.reference = controller.reference.named(&format!("{position}_reference"));
            controller.measured = SignalBlueprint::default().named(position);
        }
        let feeds = !chain.is_empty();
        controller.components = chain;
        Ok(match &design.damped {
            // A notch takes the resonance out of the command, limits and all.
            Some(damped) if damped.law == Damping::Notch => {
                controller.component(pid).component(damped.component(feeds))
            }
            Some(damped) => controller.component(damped.component(feeds)).component(pid),
            None => {
                let notches = design.notches.iter().cloned();
                notches.fold(controller, AxisBlueprint::component).component(pid)
            }
        })
    }

    /// Checks the controller on the plant, and what is known of it.
    pub(crate) fn finish(mut self, runs: &Runs) -> Result<Inversion, Error> {
        let name = self.plant.spec().name.clone();
        let wrong = |message: String| Error::Model { name: name.clone(), message };
        let mut picks: Vec<usize> = self.designs.iter().map(|design| design.chosen).collect();
        let mut checks = self.checks(runs, &picks).map_err(wrong)?;
        let worse = |checks: &[Check]| {
            checks.first().is_some_and(|c| {
                c.closed_loop.is_nan() || c.closed_loop > WORSE.0 * c.feedback + WORSE.1
            })
        };
        let bad: Vec<usize> = (0..picks.len()).filter(|i| worse(&checks[*i])).collect();
        let feeds = self.settings.feedback != Feedback::None;
        if !bad.is_empty() && feeds && !self.settings.force {
            if self.asked() != Feedforward::Automatic {
                let reasons = bad.iter().map(|index| {
                    let (found, axis) = (&checks[*index][0], &self.plant.spec().axes[*index]);
                    let reason = format!(
                        "along a wave of {:.4} Hz on its own plant the error of the loop is {:.4} % of its reach, and {:.4} % with feedback alone; choose another --feedforward, or give --force",
                        found.frequency,
                        100.0 * found.closed_loop,
                        100.0 * found.feedback
                    );
                    NotInvertible { place: format!("axis {}", axis.name), reason }
                });
                return Err(refused(reasons.collect()));
            }
            for index in bad {
                let design = &mut self.designs[index];
                design.ways.clear();
                let note =
                    "every feedforward makes the loop worse on its own plant: feedback alone";
                design.notes.push(note.to_owned());
                (picks[index], design.inverse) = (0, None);
            }
            checks = self.checks(runs, &picks).map_err(wrong)?;
        }
        let mut controller = self.controller(&picks).map_err(wrong)?;
        let mut axes = Vec::new();
        for (index, checks) in checks.into_iter().enumerate() {
            let figures = self.figures(index, picks[index], runs.reaches[index], checks);
            let components = &mut controller.axes[index].components;
            let laws = components.iter_mut().filter(|component| !is_feedforward(component));
            if let Some(law) = laws.last() {
                law.note = note_of(&figures);
            }
            axes.push(figures);
        }
        let controller = controller.check(learned::COMPONENTS);
        let controller = controller.map_err(|problems| wrong(problems.to_string()))?;
        Ok(Inversion { controller, axes, coordinators: self.coordinators() })
    }

    /// For each axis what the controller does along the waves.
    fn checks(&self, runs: &Runs, picks: &[usize]) -> Result<Vec<Vec<Check>>, String> {
        let complete = self.controller(picks)?;
        let checked = |blueprint: &Blueprint| {
            blueprint.check(learned::COMPONENTS).map_err(|problems| problems.to_string())
        };
        let controller = checked(&complete)?;
        let forward = checked(&check::without_feedback(&complete))?;
        let back = checked(&check::without_feedforward(&complete))?;
        let widths = self.designs.iter().map(|design| design.shaped.bandwidth);
        let bandwidth = widths.fold(f64::INFINITY, f64::min);
        let mut found = vec![Vec::new(); self.designs.len()];
        let late = self.late();
        for frequency in check::frequencies(self.period, bandwidth) {
            let (references, from) = check::waves(&runs.reaches, frequency, self.period);
            let run = |controller: &CheckedBlueprint| {
                check::errors(&runs.plant, controller, &references, from, self.period, &late)
            };
            let (complete, forward, back) = (run(&controller), run(&forward), run(&back));
            for (index, checks) in found.iter_mut().enumerate() {
                let reach = runs.reaches[index].1 - runs.reaches[index].0;
                let part = |errors: &[Vec<f64>]| check::rms(&errors[index]) / reach;
                let has = picks[index] < self.designs[index].ways.len();
                checks.push(Check {
                    frequency,
                    swing: check::swing(),
                    feedforward: has.then(|| part(&forward)),
                    closed_loop: part(&complete),
                    feedback: part(&back),
                });
            }
        }
        Ok(found)
    }
}

fn controller_axis_name(controller: &Blueprint, axis: usize) -> &str {
    controller.axes.get(axis).map_or("", |axis| &axis.name)
}
