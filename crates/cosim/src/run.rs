//! Running a system: initialization, communication steps, record.

use data::inner_steps;
use fmi_bindings::import::Experiment;

use crate::algorithm::Algorithm;
use crate::error::{Error, RunError};
use crate::problem::{Problem, Problems};
use crate::record::Recorder;
use crate::signals::{Held, Signals};
use crate::statistics::Stopwatch;
use crate::system::{Ending, System};
use crate::time::Points;

/// One record of a run: when, and driven by what.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    /// Number of the record, for recorders and messages.
    pub record: usize,
    /// Communication points.
    pub points: Points<'a>,
    /// The input table; columns that nothing needs are ignored.
    pub signals: &'a Signals<'a>,
    /// Relative tolerance for FMUs with error control.
    pub tolerance: Option<f64>,
    /// Do not tell the FMUs the stop time; some refuse a last step that reaches it but for rounding.
    pub no_stop_time: bool,
    /// Seconds that are simulated in a second on the clock: 1 is real time. None: as fast as it goes.
    pub pace: Option<f64>,
}

impl<'a> Run<'a> {
    /// Record 0 over these points, driven by a table.
    pub fn new(points: Points<'a>, signals: &'a Signals<'a>) -> Self {
        Run { record: 0, points, signals, tolerance: None, no_stop_time: false, pace: None }
    }
}

impl System {
    /// Runs from the first communication point to the last.
    ///
    /// In the order in which it happens (for one slave it is what `fmpy.simulate_fmu` does):
    ///
    /// 1. A system that ran before is reset.
    /// 2. Each slave: `fmi2SetupExperiment(start, stop)`, start values, `fmi2EnterInitializationMode`.
    /// 3. In initialization mode: connected outputs are read; then each slave gets its inputs, from
    ///    the first row of the table and from the outputs, and its connected outputs are read again,
    ///    in the order in which outputs depend on inputs at initialization, so that at its end all
    ///    inputs are those that belong to the outputs. Outputs that depend on each other in a circle
    ///    are iterated ([`Algorithm::initialize`]). Then `fmi2ExitInitializationMode`, and all is
    ///    read.
    /// 4. Row k is: outputs at t_k; then inputs as they act over \[t_k, t_{k+1}\], set by the
    ///    algorithm while it steps. The last row holds the inputs that would act next. A slave with
    ///    a longer step of its own shows its outputs when their time is reached.
    /// 5. `fmi2Terminate`.
    ///
    /// Returns the [`Ending`] if an FMU asked for the end before the stop time. The last row is
    /// then at the time that FMU reached (one that does not say so has reached the beginning of the
    /// step, whose row is there); other slaves are at the end of their step.
    ///
    /// # Errors
    /// [`Error::Run`] with the time; the rows until then, that of the failing step included, are
    /// with the recorder, whose record is ended.
    pub fn run(
        &mut self,
        run: &Run<'_>,
        algorithm: &dyn Algorithm,
        recorder: &mut dyn Recorder,
    ) -> Result<Option<Ending>, Error> {
        let mut held = self.check(run)?;
        self.check_steps(run)?;
        let step = self.common_step(&run.points)?;
        recorder.begin(run.record, &self.columns, run.points.steps() + 1)?;
        let mut stepping = Stepping { system: self, run, algorithm, recorder, time: 0.0 };
        let outcome = stepping.complete_run(&mut held, step);
        let time = stepping.time;
        // What the FMU says is more than what the recorder says.
        let ended = recorder.end().map_err(Error::from);
        let outcome = outcome.and_then(|ending| ended.map(|()| ending));
        outcome.map_err(|cause| Box::new(RunError { record: run.record, time, cause }).into())
    }

    /// Back to the state before the first run.
    pub fn reset(&mut self) -> Result<(), Error> {
        self.participants.iter_mut().try_for_each(|participant| participant.slave.reset())?;
        self.bus.fill(0.0);
        self.participants.iter_mut().for_each(|participant| participant.pace.due = true);
        self.ending = None;
        self.used = false;
        Ok(())
    }

    /// The columns this system needs, or all problems of the table.
    fn check<'a>(&self, run: &Run<'a>) -> Result<Held<'a>, Problems> {
        let mut problems = Vec::new();
        let mut columns: Vec<&'a [f64]> = Vec::new();
        if !self.externals.is_empty() {
            problems = run.signals.problems(run.record);
        }
        for name in &self.externals {
            match run.signals.columns.iter().find(|column| column.name == *name) {
                Some(column) => columns.push(column.values),
                None => problems.push(self.no_column(name, run.signals)),
            }
        }
        Problems::none_or(problems, Held::new(run.signals.time, columns))
    }

    /// Whether the communication points are as far apart as seconds can be.
    fn check_steps(&self, run: &Run<'_>) -> Result<(), Problems> {
        let mut problems = Vec::new();
        for participant in &self.participants {
            let experiment = participant.slave.description().default_experiment.as_ref();
            let Some(inner) = experiment.and_then(|e| e.step_size) else { continue };
            let found = match &run.points {
                Points::Uniform { step, .. } => inner_steps::check(*step, inner),
                Points::Rows(times) => inner_steps::check_rows(times, inner),
            };
            if let Err(what) = found {
                let slave = participant.slave.name();
                problems.push(Problem::Time(format!("FMU `{slave}`: {what}")));
                break;
            }
        }
        Problems::none_or(problems, ())
    }

    fn no_column(&self, name: &str, signals: &Signals<'_>) -> Problem {
        let there: Vec<&str> = signals.columns.iter().map(|c| c.name.as_str()).collect();
        let (slave, variable) = self.fed_by(name).unwrap_or_default();
        Problem::NoSuchColumn { name: name.to_owned(), slave, variable, there: there.join(", ") }
    }

    /// The one step that all steps must be, if a slave takes equal steps only.
    fn common_step(&self, points: &Points<'_>) -> Result<Option<f64>, Problems> {
        let mut problems = Vec::new();
        let mut common = None;
        for participant in &self.participants {
            problems.extend(participant.pace.problem(participant.slave.as_ref(), points));
            let co_simulation = participant.slave.description().co_simulation.as_ref();
            if co_simulation.is_some_and(|cs| cs.can_handle_variable_communication_step_size) {
                continue;
            }
            match points.equal_steps() {
                Ok(step) => common = Some(step),
                Err(what) => {
                    let slave = participant.slave.name().to_owned();
                    problems.push(Problem::UnequalSteps { slave, what });
                }
            }
        }
        Problems::none_or(problems, common)
    }
}

/// A run under way.
struct Stepping<'s, 'r> {
    system: &'s mut System,
    run: &'s Run<'r>,
    algorithm: &'s dyn Algorithm,
    recorder: &'s mut dyn Recorder,
    /// The communication point it is at, for errors.
    time: f64,
}

impl Stepping<'_, '_> {
    fn complete_run(
        &mut self,
        held: &mut Held<'_>,
        step: Option<f64>,
    ) -> Result<Option<Ending>, Error> {
        self.time = self.run.points.start();
        if self.system.used {
            self.system.reset()?;
        }
        self.system.used = true;
        self.system.unsolved.clear();
        self.initialize(held)?;
        let ending = self.steps(held, step)?;
        // One that ended where a row was just written adds none.
        if ending.as_ref().is_none_or(|ending| ending.time > self.time) {
            self.time = ending.as_ref().map_or(self.time, |ending| ending.time);
            self.last_row(held)?;
        }
        for participant in &mut self.system.participants {
            participant.slave.terminate()?;
        }
        Ok(ending)
    }

    fn initialize(&mut self, held: &mut Held<'_>) -> Result<(), Error> {
        let Run { points, tolerance, no_stop_time, .. } = self.run;
        let (start, stop) = (points.start(), (!no_stop_time).then(|| points.stop()));
        let experiment = Experiment { start, stop, tolerance: *tolerance };
        for participant in &mut self.system.participants {
            let slave = &mut participant.slave;
            slave.setup(&experiment)?;
            participant.starts_before.iter().try_for_each(|(n, v)| slave.set_start(n, v))?;
            slave.enter_initialization()?;
            participant.starts_during.iter().try_for_each(|(n, v)| slave.set_start(n, v))?;
        }
        self.hold(held, start);
        let algorithm = self.algorithm;
        self.system.look_ahead(
            |slave| algorithm.steps_late(slave),
            |source, target| algorithm.looks_ahead(source, target),
        );
        (0..self.system.len()).try_for_each(|slave| self.system.read_outputs(slave))?;
        self.system.publish();
        self.algorithm.initialize(self.system)?;
        for participant in &mut self.system.participants {
            participant.slave.exit_initialization()?;
        }
        (0..self.system.len()).try_for_each(|slave| self.system.read(slave))?;
        self.system.publish();
        Ok(())
    }

    fn steps(&mut self, held: &mut Held<'_>, common: Option<f64>) -> Result<Option<Ending>, Error> {
        let mut watch = Stopwatch::start(self.system.len());
        let mut steps_done = 0;
        let outcome = self.each_step(held, common, &mut watch, &mut steps_done);
        self.system.is_timed = false;
        let simulated = self.run.points.at(steps_done) - self.run.points.start();
        watch.stop(&mut self.system.total, steps_done, simulated);
        outcome
    }

    /// All steps; `made` counts them.
    fn each_step(
        &mut self,
        held: &mut Held<'_>,
        common: Option<f64>,
        watch: &mut Stopwatch,
        steps_done: &mut usize,
    ) -> Result<Option<Ending>, Error> {
        let (points, pace) = (&self.run.points, self.run.pace);
        let (start, mut next) = (points.start(), points.start());
        for n in 0..points.steps() {
            self.system.pace(points, n);
            self.time = next;
            next = points.at(n + 1);
            if let Some(pace) = pace {
                watch.wait((self.time - start) / pace, (next - self.time) / pace);
            }
            self.system.is_timed = watch.is_due(n);
            *steps_done = n + 1;
            let step = common.unwrap_or(next - self.time);
            self.hold(held, self.time);
            self.system.tap_outputs();
            let outcome = self.algorithm.step(self.system, self.time, step);
            self.system.tap_inputs();
            self.recorder.row(self.time, &self.system.row)?;
            outcome?;
            if let Some(ending) = self.system.ending.take() {
                self.system.publish_late();
                return Ok(Some(ending));
            }
        }
        if let Some(pace) = pace {
            watch.wait((next - start) / pace, f64::INFINITY);
        }
        self.system.pace(points, points.steps());
        self.time = next;
        Ok(None)
    }

    /// The row at the end: outputs, and inputs as they would act next.
    fn last_row(&mut self, held: &mut Held<'_>) -> Result<(), Error> {
        self.hold(held, self.time);
        self.system.tap_outputs();
        (0..self.system.len()).for_each(|slave| self.system.gather(slave));
        self.system.tap_inputs();
        self.recorder.row(self.time, &self.system.row)?;
        Ok(())
    }

    /// Puts the values of the input table that act from `time` on onto the bus.
    #[inline]
    fn hold(&mut self, held: &mut Held<'_>, time: f64) {
        let columns = self.system.externals.len();
        if columns > 0 {
            held.at(time, &mut self.system.bus[..columns]);
        }
    }
}
