//! One instance of the FMU, whatever the version of the standard: its life and its time.

mod arrays;
mod derivatives;
mod states;
mod values;

use std::ffi::{CStr, CString, c_void};

pub(super) use states::SavedState;

use arrays::{Layout, Lists};
use model::{Causality, DataType, DerivativeRoom, Past, Quick, StepError, System, Variable};

use crate::export::guard::{self, Guarded};
use crate::export::log::{Logger, Sink};
use crate::export::notice::{Notice, Outcome, Status};
use crate::export::phase::{Phase, Rule};
use crate::export::progress::{Experiment, Progress};
use crate::export::resources::{self, Location};
use crate::export::{BLUEPRINT, Factory};

/// A model with its place in the standard's state machine, its time and its importer.
///
/// The edges hand out pointers to it; everything else about it is private to the export.
pub struct Instance {
    logger: Logger,
    system: System,
    fingerprint: String,
    progress: Progress,
    /// The time in s from zero up to which double precision resolves a hundredth of the internal
    /// step.
    reach: f64,
    /// So many variables from the first one on are Real, and so many of these are inputs.
    reals: u32,
    real_inputs: u32,
    /// Slopes of the inputs in the next step, by value reference: inputs come first.
    slopes: Vec<f64>,
    /// How the present outputs came about, for their derivatives.
    past: Past,
    room: DerivativeRoom,
    /// Value reference of the independent variable, where the version has one.
    time_reference: Option<u32>,
    /// What the value references stand for, where the version has arrays.
    layout: Layout,
    lists: Lists,
    /// Saved states that the importer has not freed.
    states: Vec<*mut SavedState>,
}

/// What an importer gives at instantiation.
pub(super) struct Request<'a> {
    pub(super) name: Option<&'a CStr>,
    pub(super) token: Option<&'a CStr>,
    /// What the standard calls the token: `GUID`.
    pub(super) token_name: &'static str,
    /// Whether the version has arrays, and time as a variable, with the reference behind the last one
    /// of the model.
    pub(super) has_arrays_and_time: bool,
    pub(super) location: Location<'a>,
    pub(super) sink: Sink,
    pub(super) logging_on: bool,
}

impl Guarded for Instance {
    fn send(&self, status: Status, message: &str) {
        self.logger.send(status, message);
    }

    fn fail(&mut self) {
        self.progress.phase = Phase::Error;
    }
}

/// Life.
impl Instance {
    /// Reads the resources and builds the model.
    pub(super) fn new(request: &Request<'_>, factory: Factory) -> Result<Box<Self>, Notice> {
        let name: CString = match request.name {
            Some(name) if !name.to_bytes().trim_ascii().is_empty() => name.into(),
            _ => return Err(Notice::error("the instance name is empty; give each instance one")),
        };
        #[cfg(not(target_family = "wasm"))]
        super::Library::Blueprint.carry();
        let folder = resources::find(request.location, BLUEPRINT).map_err(Notice::error)?;
        let system = factory(&folder).map_err(Notice::error)?;
        let fingerprint = system.variables().fingerprint();
        let given = request.token.map(CStr::to_bytes);
        if given != Some(fingerprint.as_bytes()) {
            let given = given.map_or("null".into(), String::from_utf8_lossy);
            return Err(Notice::error(format!(
                "the {} of the model description is \"{given}\", the one of {} is \
                 \"{fingerprint}\": they belong to different FMUs; pack the FMU again",
                request.token_name,
                folder.join(BLUEPRINT).display()
            )));
        }
        let inputs = system.variables().with(Causality::Input).count();
        let is_real = |variable: &&Variable| variable.data_type == DataType::Real;
        let reals = system.variables().as_slice().iter().take_while(is_real).count() as u32;
        let instance = Self {
            logger: Logger::new(request.sink, name, request.logging_on),
            time_reference: request.has_arrays_and_time.then_some(system.variables().len() as u32),
            layout: match request.has_arrays_and_time {
                true => Layout::of(system.variables()),
                false => Layout::default(),
            },
            lists: Lists::of(system.variables()),
            fingerprint,
            progress: Progress::NEW,
            reach: 0.01 * system.period() / f64::EPSILON,
            reals,
            real_inputs: reals.min(inputs as u32),
            slopes: vec![0.0; inputs],
            past: system.past(),
            room: system.derivative_room(),
            states: Vec::new(),
            system,
        };
        if instance.logger.wants(Status::Ok) {
            let (name, count) = (instance.system.name(), instance.system.variables().len());
            let text = format!("model \"{name}\", {count} variables, from {}", folder.display());
            instance.logger.send(Status::Ok, &text);
        }
        Ok(Box::new(instance))
    }

    /// Carries out one call on an instance, where the call table allows it.
    ///
    /// # Safety
    /// The contract of [`guard::call`].
    pub(super) unsafe fn call(
        pointer: *mut c_void,
        rule: &Rule,
        body: impl FnOnce(&mut Self) -> Outcome,
    ) -> Status {
        let body = |instance: &mut Self| {
            let phase = instance.progress.phase;
            if rule.allows(phase) {
                body(instance)
            } else {
                Err(Notice::error(rule.refusal(phase)))
            }
        };
        // SAFETY: as the caller promises.
        unsafe { guard::call(pointer, rule.function, body) }.err().unwrap_or(Status::Ok)
    }

    /// A success, with an event to tell where somebody wants to know.
    fn event(&self, what: &str) -> Outcome {
        if !self.logger.wants(Status::Ok) {
            return Ok(());
        }
        let message = format!("{what} at {} s", self.progress.time);
        Err(Notice { status: Status::Ok, message })
    }

    /// Switches debug logging, for all categories where none is given.
    pub(super) fn set_debug_logging(&mut self, on: bool, categories: &[&CStr]) -> Outcome {
        let unknown = self.logger.set_debug_logging(on, categories);
        if unknown.is_empty() {
            return Ok(());
        }
        let known: Vec<_> = crate::export::LOG_CATEGORIES.iter().map(|(name, _)| *name).collect();
        Err(Notice::warning(format!(
            "unknown log categories: {}; the categories are {}",
            unknown.join(", "),
            known.join(", ")
        )))
    }

    /// Takes over start and stop time.
    pub(super) fn set_up(&mut self, start: f64, stop: Option<f64>) -> Outcome {
        let last = stop.unwrap_or(f64::INFINITY);
        if !start.is_finite() {
            return Err(Notice::error(format!("start time {start} s; give a finite one")));
        }
        if stop.is_some_and(|stop| !stop.is_finite()) || last < start {
            return Err(Notice::error(format!(
                "stop time {last} s; give a finite one that is not before the start, {start} s"
            )));
        }
        self.progress.experiment = Experiment { defined: true, start, stop: last };
        Ok(())
    }

    /// Enters the initialization mode.
    pub(super) fn enter_initialization(&mut self) -> Outcome {
        let experiment = self.progress.experiment;
        self.progress.phase = Phase::Initialization;
        self.progress.time = experiment.start;
        self.progress.stale = true;
        if experiment.defined {
            return Ok(());
        }
        Err(Notice::warning("no experiment was set up before, so time starts at 0 s"))
    }

    /// Leaves the initialization mode: the model is at rest under its inputs.
    pub(super) fn exit_initialization(&mut self) -> Outcome {
        self.settle()?;
        self.progress.phase = Phase::Step;
        self.event("initialised")
    }

    pub(super) fn terminate(&mut self) -> Outcome {
        self.progress.phase = Phase::Terminated;
        self.event("terminated")
    }

    /// Back to the state right after instantiation.
    pub(super) fn reset(&mut self) -> Outcome {
        self.system.reset();
        self.system.note_rest(&mut self.past);
        self.slopes.fill(0.0);
        self.progress = Progress::NEW;
        self.event("reset")
    }

    /// Computes the outputs that belong to the values set so far, before the first step.
    fn settle(&mut self) -> Outcome {
        if !self.progress.stale {
            return Ok(());
        }
        let start = self.progress.experiment.start;
        self.system.initialise(start).map_err(|error| self.explain(&error))?;
        self.system.note_rest(&mut self.past);
        self.progress.stale = false;
        Ok(())
    }

    #[cold]
    fn explain(&self, error: &StepError) -> Notice {
        Notice::error(self.system.explain(error))
    }
}

/// How far the importer's time may be from the instance's: what adding up steps in floating point
/// loses, and nothing that could be a step.
fn tolerance(time: f64, step: f64) -> f64 {
    1e-9 * time.abs() + 1e-5 * step
}

/// Time.
impl Instance {
    /// The last communication point in s.
    pub(super) fn time(&self) -> f64 {
        self.progress.time
    }

    /// The usual step of an instance whose model is a chain of gains and offsets, which calls nothing and
    /// cannot panic; `false`: nothing is done, and it takes [`call`](Self::call).
    ///
    /// # Safety
    /// The contract of [`guard::call`].
    #[inline(always)]
    pub(super) unsafe fn affine_step(pointer: *mut c_void, time: f64, step: f64) -> bool {
        // SAFETY: null or alive and used by this thread only, as the caller promises.
        let Some(instance) = (unsafe { pointer.cast::<Self>().as_mut() }) else { return false };
        // Asked first, so that other models lose no time.
        if !instance.system.is_affine() {
            return false;
        }
        let end = time + step;
        let done = instance.progress.phase == Phase::Step
            && !instance.progress.sloped
            && instance.is_sound(time, step, end)
            && instance.system.affine_step(end, time, &mut instance.past);
        if done {
            instance.progress.time = end;
        }
        done
    }

    /// Whether there is a step from `time` by `step` to `end`. No comparison holds for NaN, and the last one
    /// not for an infinite step.
    #[inline(always)]
    fn is_sound(&self, time: f64, step: f64, end: f64) -> bool {
        let Progress { time: now, experiment: Experiment { stop, .. }, .. } = self.progress;
        step > 0.0
            && (time - now).abs() <= tolerance(now, step)
            && (end <= stop || end <= stop + tolerance(stop, step))
            && end.abs() <= self.reach
    }

    /// Advances from the communication point `time` by `step`, both in s.
    #[inline(always)]
    pub(super) fn do_step(&mut self, time: f64, step: f64) -> Outcome {
        let end = time + step;
        if !self.is_sound(time, step, end) {
            return Err(self.no_step(time, step));
        }
        let quick = match self.progress.sloped {
            false => self.system.quick_step(end, time, &mut self.past),
            true => Quick::Other,
        };
        if quick != Quick::Done {
            self.other_step(end, time, quick)?;
        }
        self.progress.time = end;
        Ok(())
    }

    /// The steps that are not so quick, apart from the others.
    #[inline(never)]
    fn other_step(&mut self, end: f64, time: f64, quick: Quick) -> Outcome {
        if quick == Quick::Broken {
            return Err(self.explain(&self.system.not_finite()));
        }
        let slopes = if self.progress.sloped { &self.slopes[..] } else { &[] };
        if let Err(error) = self.system.advance_noted(end, time, slopes, &mut self.past) {
            return Err(self.explain(&error));
        }
        if self.progress.sloped {
            self.slopes.fill(0.0);
            self.progress.sloped = false;
        }
        Ok(())
    }

    /// Why there is no such step.
    #[cold]
    fn no_step(&self, time: f64, step: f64) -> Notice {
        let Progress { time: now, experiment, .. } = self.progress;
        let (end, stop, near) = (time + step, experiment.stop, tolerance(now, step));
        Notice::error(if !(step > 0.0 && step.is_finite()) {
            format!("communication step size {step} s; give a finite one greater than 0")
        } else if (time - now).abs() > near || time.is_nan() {
            format!(
                "communication point {time} s, but the instance is at {now} s; step from there, \
                 or set the FMU state of that time"
            )
        } else if end > stop + tolerance(stop, step) {
            format!(
                "the step from {time} s by {step} s ends at {end} s, past the stop time {stop} s; \
                 step up to it, or set up the experiment without a stop time"
            )
        } else {
            format!(
                "the step from {time} s by {step} s ends at {end} s, where double precision no \
                 longer resolves the internal step of {} s; simulate nearer to time 0",
                self.system.period()
            )
        })
    }
}
