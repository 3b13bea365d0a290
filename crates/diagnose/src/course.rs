//! How the logs are read, where nobody says and they do: what the command does between rows, and when
//! readings are taken.

mod within;

use std::sync::atomic::AtomicU64;

use components::effects;
use model::Group;
use rayon::prelude::*;

use self::within::Within;
use crate::between::{Between, Course};
use crate::candidate::{Candidate, has_gap};
use crate::data_set::DataSet;
use crate::error::Error;
use crate::fit::Fitter;
use crate::gap::Verdict;
use crate::outcome::Outcome;
use crate::request::Request;
use crate::sentence::together;
use crate::stages;
use crate::task::Task;
use crate::thresholds::base::Thresholds;

/// Diagnoses one output. Where something is left, the other readings of the logs are tried with what was found:
/// one that leaves clearly less is taken, and the search made anew. A mode near half the sample rate is what a
/// command looks like that moves between the rows: before it is named the search is made with those at any rate,
/// and the one is taken that leaves less with fewer effects. Other effects look like that, too (a lag of the model that
/// acts faster, a crosstalk): another reading is taken if it leaves about as much with fewer effects.
pub(crate) fn settled(task: Task, request: &Request, count: &AtomicU64) -> Result<Outcome, Error> {
    stages::with_known_reading(read(task, request, count)?, request, count)
}

fn read(task: Task, request: &Request, count: &AtomicU64) -> Result<Outcome, Error> {
    let requested = (request.between, request.reading);
    let open = Course::open(task.course, requested, task.data.has_steps());
    let readings = Readings { fresh: task.clone(), request, count };
    let outcome = stages::of(task, request, count)?;
    let Some(instant) = readings.instant(&outcome) else {
        // An FMU takes its time: other readings are tried where the usual one does not explain the logs.
        let is_left = has_gap(&outcome.found.last, outcome.adequate);
        let is_tried =
            outcome.task.base.is_white || is_left || mode_near_nyquist(&outcome).is_some();
        return Ok(if is_tried { readings.in_other_course(outcome, open) } else { outcome });
    };
    if instant.looks_moving() {
        let outcome = readings.in_other_course(outcome, open);
        let moves = outcome.task.course.between != Between::Zoh && outcome.verdict.is_explained();
        if moves && (!instant.is_all() || outcome.found.last.picks.is_empty()) {
            return Ok(outcome);
        }
        return Ok(better(readings.within_rows(&outcome, instant), outcome));
    }
    let within = readings.within_rows(&outcome, instant);
    // What leaves nothing is taken at once.
    let within = match within {
        Some(within) if within.is_complete() && within.is_better(&outcome) => {
            return Ok(within.in_place_of(&outcome));
        }
        within => within,
    };
    Ok(better(within, readings.in_other_course(outcome, open)))
}

/// The answer with readings within the rows where it is better, or the other one.
fn better(within: Option<Within>, outcome: Outcome) -> Outcome {
    match within.filter(|within| within.is_better(&outcome)) {
        Some(within) => within.in_place_of(&outcome),
        None => outcome,
    }
}

/// The logs of a task, to be read otherwise.
struct Readings<'a> {
    fresh: Task,
    request: &'a Request,
    count: &'a AtomicU64,
}

impl Readings<'_> {
    /// With the reading of the logs that is clearly better than the usual one, and what to say of it.
    fn in_other_course(&self, outcome: Outcome, open: Vec<Course>) -> Outcome {
        let is_given = open.is_empty();
        let usual = outcome.task.course;
        let mode = mode_near_nyquist(&outcome);
        let (first, first_named) = (outcome.left(), names(&outcome));
        let had_lag = has_released_lag(&outcome);
        let outcome = match mode {
            Some(_) => self.without_mode(outcome, &open),
            None => self.best(outcome, &open),
        };
        let outcome = self.with_one_effect(outcome, usual, &open);
        let outcome = self.in_finer_steps(self.half_a_step_on(outcome));
        let mut outcome = self.or_otherwise(outcome, usual, &open);
        let (output, course) = (outcome.task.output.clone(), outcome.task.course);
        let read_as = |what: String| {
            format!(
                "{output}: the logs are read with {}: with {} {what} (--between {} --reading {} says otherwise)",
                course.words(),
                usual.words(),
                usual.between.name(),
                usual.reading.name()
            )
        };
        let warning = match mode {
            // Nothing else was asked.
            _ if course == usual && is_given => None,
            Some(frequency) if course == usual => Some(format!(
                "{output}: the mode at {frequency:.4} Hz lies within 10 % of half the sample rate; it stays whatever the \
                 command does between the rows"
            )),
            Some(frequency) => Some(read_as(format!(
                "a mode would be missing at {frequency:.4} Hz, within 10 % of half the sample rate"
            ))),
            None if course == usual => None,
            // Not less, but with fewer effects.
            None if outcome.left() >= Thresholds::READING_LESS * first => {
                // One name may stand for two effects.
                let mut gone = first_named;
                for name in names(&outcome) {
                    if let Some(at) = gone.iter().position(|other| *other == name) {
                        gone.remove(at);
                    }
                }
                Some(read_as(match had_lag {
                    true => "a lag of the model would have to act faster".to_owned(),
                    false => format!("{} would be missing", together(gone)),
                }))
            }
            None => Some(read_as(format!(
                "the best answer would leave {:.1} times as much",
                (first / outcome.left()).sqrt()
            ))),
        };
        let otherwise = outcome.otherwise.iter().map(|(course, name)| {
            let name = name.replace('_', " ");
            format!("{output}: with {}, {name} alone explains the logs as well", course.words())
        });
        outcome.task.warnings.extend(warning.into_iter().chain(otherwise));
        outcome
    }

    /// The answer under a command that was played so; none where the model cannot be simulated.
    fn answer(&self, course: Course, data: &DataSet) -> Option<Outcome> {
        self.answer_of(course, data, self.fresh.max_effects)
    }

    /// The answer of at most so many effects under a command that was played so.
    fn answer_of(&self, course: Course, data: &DataSet, max_effects: usize) -> Option<Outcome> {
        let task = Task { course, data: data.played(course), max_effects, ..self.fresh.clone() };
        stages::of(task, self.request, self.count).ok()
    }

    /// The answer, or a better one among these readings, each with the most effects that are looked for; the search ends with
    /// the first that leaves nothing.
    fn taken(
        &self,
        mut outcome: Outcome,
        courses: impl IntoIterator<Item = (Course, usize)>,
        is_better: impl Fn(&Outcome, &Outcome) -> bool,
    ) -> Outcome {
        for (course, most) in courses {
            let other = self.answer_of(course, &self.fresh.data, most);
            let Some(other) = other.filter(|other| is_better(other, &outcome)) else { continue };
            outcome = other;
            if !has_gap(&outcome.found.last, outcome.adequate) {
                break;
            }
        }
        outcome
    }

    /// In place of a mode near half the sample rate: a reading under which the command moves.
    fn without_mode(&self, outcome: Outcome, open: &[Course]) -> Outcome {
        let open = open.iter().copied().filter(|c| moves(*c)).rev();
        let open = open.map(|course| (course, self.fresh.max_effects));
        self.taken(outcome, open, |other, outcome| {
            let count = |o: &Outcome| o.found.last.picks.len();
            // With fewer effects it stands for the mode: what counts is what is left without that.
            let stands_for_it = count(other) < count(outcome)
                && without_mode(outcome)
                    .is_some_and(|left| held_out(other) < Thresholds::READING_LESS * left);
            let leaves_less = count(other) <= count(outcome) && other.left() < outcome.left();
            other.verdict.is_explained()
                && mode_near_nyquist(other).is_none()
                && (stands_for_it || leaves_less)
        })
    }

    /// The reading to which what was found points; where nothing is explained, those under which the command moves, too: it
    /// and a missing lag hide each other.
    fn best(&self, outcome: Outcome, open: &[Course]) -> Outcome {
        let is_open = outcome.verdict == Verdict::Unknown;
        let usual = outcome.task.course;
        let (mut outcome, mut tried) = self.pointed(outcome, open);
        let course = outcome.task.course;
        // Readings are half a row apart: of two wrong ones the nearer is taken first, and what is found with it points on.
        if outcome.verdict == Verdict::Unknown && course != usual {
            let rest: Vec<Course> = open.iter().copied().filter(|c| *c != course).collect();
            (outcome, tried) = self.pointed(outcome, &rest);
        }
        let is_left = has_gap(&outcome.found.last, outcome.adequate);
        if !is_open || !is_left || !outcome.task.base.is_white {
            return outcome;
        }
        let others = tried.into_iter().filter(|c| is_usual(*c) && *c != course).take(3);
        // One effect and the command explain all, or the reading is not taken: pairs take ten times as long.
        let others = others.map(|course| (course, self.fresh.max_effects.min(1)));
        self.taken(outcome, others, |other, outcome| {
            // Where nothing pointed to it, it must leave nothing, and much less than the best single effect of the usual
            // reading, which a delay of half a row may imitate: else it helps wrong names.
            if outcome.verdict == Verdict::Unknown {
                let leaves_nothing = !has_gap(&other.found.last, other.adequate);
                return other.verdict.is_explained()
                    && leaves_nothing
                    && leaves_less(other, outcome);
            }
            leaves_less(other, outcome) || stands_for_effects(other, outcome)
        })
    }

    /// In place of several effects, one under a reading to which they do not point: a wrong reading needs effects of its own.
    fn with_one_effect(&self, outcome: Outcome, usual: Course, open: &[Course]) -> Outcome {
        if outcome.found.last.picks.len() < 2 {
            return outcome;
        }
        let base = |course: &Course| part(&outcome, &outcome.found.base, *course, self.count);
        let mut others: Vec<(Course, f64)> = untried(&outcome, usual, open)
            .into_par_iter()
            .with_max_len(1)
            .filter_map(|course| Some((course, base(&course)?)))
            .filter(|(_, part)| *part < Thresholds::READING_TRIED_FOR_ONE)
            .collect();
        others.sort_by(|a, b| a.1.total_cmp(&b.1));
        let others = others.into_iter().map(|(course, _)| (course, 1)).take(2);
        self.taken(outcome, others, |other, outcome| {
            !has_gap(&other.found.last, other.adequate) && stands_for_effects(other, outcome)
        })
    }

    /// The answer, with the single effects that explain the log as well under another reading than the one that is taken
    /// against what is usual.
    fn or_otherwise(&self, mut outcome: Outcome, usual: Course, open: &[Course]) -> Outcome {
        let course = outcome.task.course;
        let is_one = outcome.found.last.picks.len() == 1;
        if course == usual || !is_one || has_gap(&outcome.found.last, outcome.adequate) {
            return outcome;
        }
        for course in untried(&outcome, usual, open) {
            let Some(other) = self.answer_of(course, &self.fresh.data, 1) else { continue };
            let is_one = other.found.last.picks.len() == 1;
            let leaves_alike = other.left() < Thresholds::READING_FOR_EFFECT * outcome.left();
            if is_one && leaves_alike && !has_gap(&other.found.last, other.adequate) {
                let known = outcome.otherwise.iter().map(|(_, name)| *name).chain(names(&outcome));
                let name = names(&other)[0];
                if !known.collect::<Vec<_>>().contains(&name) {
                    outcome.otherwise.push((course, name));
                }
            }
        }
        outcome
    }

    /// The answer, or that with the reading to which it points; and the readings to which it does not, the likeliest first.
    fn pointed(&self, outcome: Outcome, open: &[Course]) -> (Outcome, Vec<Course>) {
        let tried = promising(&outcome, open, self.count);
        let pointed = tried.first().filter(|(_, part)| *part < most(&outcome)).map(|t| t.0);
        let others = tried.into_iter().map(|t| t.0).filter(|c| Some(*c) != pointed).collect();
        let with_all = pointed.map(|course| (course, self.fresh.max_effects));
        let outcome = self.taken(outcome, with_all, |other, outcome| {
            leaves_less(other, outcome) || stands_for_effects(other, outcome)
        });
        (outcome, others)
    }

    /// Whether a command that moves is held over each step of the model is half a step: a lag beside what is missing.
    fn half_a_step_on(&self, outcome: Outcome) -> Outcome {
        let course = outcome.task.course;
        let has_steps = self.fresh.data.has_steps() && course.between != Between::Zoh;
        let other = Course { is_stepped: !course.is_stepped, ..course };
        let is_tried = has_steps && names_lag(&outcome);
        let other = is_tried.then_some((other, self.fresh.max_effects));
        self.taken(outcome, other, stands_for_effects)
    }

    /// With a model of several steps from row to row, where effects are missing and it has one: a held command stands for one
    /// that moves in linear parts alone.
    fn in_finer_steps(&self, outcome: Outcome) -> Outcome {
        let course = outcome.task.course;
        let is_alone = outcome.task.base.is_white && outcome.task.coupled.is_none();
        let has_one = !self.fresh.data.has_steps() && is_alone;
        if course.between == Between::Zoh || !has_one || outcome.verdict != Verdict::Effects {
            return outcome;
        }
        let is_better = |other: &Outcome| {
            let is_less = other.left() < Thresholds::FINER_LESS * outcome.left();
            stands_for_effects(other, &outcome) || (is_less && names(other) == names(&outcome))
        };
        let other = self.answer(course, &self.fresh.data.finer(Thresholds::FINER_STEPS));
        let Some(mut other) = other.filter(is_better) else { return outcome };
        other.task.warnings.push(format!(
            "{}: the model is simulated in steps of {} s: with its own, one from row to row, the best answer would leave \
             {:.2} times as much, with {}: a command that moves between the rows acts on a curved part otherwise than \
             its mean",
            other.task.output,
            other.task.data.step,
            (outcome.left() / other.left()).sqrt(),
            data::counted(outcome.found.last.picks.len(), "effect")
        ));
        other
    }
}

/// Names of the effects that were found.
fn names(o: &Outcome) -> Vec<&'static str> {
    o.found.last.picks.iter().map(|(family, _)| o.library[*family].effect.name).collect()
}

/// Whether a lag of the model that acts faster was found, as a command looks like that moves between the rows.
fn has_released_lag(o: &Outcome) -> bool {
    o.found.last.picks.iter().any(|(family, number)| {
        let family = &o.library[*family];
        family.effect.group == Some(Group::Lag) && !family.formulas[*number].releases.is_empty()
    })
}

/// Whether this reading leaves so much less that it is taken.
fn leaves_less(other: &Outcome, outcome: &Outcome) -> bool {
    other.left() < Thresholds::READING_LESS * outcome.left()
}

/// Whether this reading explains the log with fewer effects, and leaves about as much.
fn stands_for_effects(other: &Outcome, outcome: &Outcome) -> bool {
    other.verdict.is_explained()
        && other.found.last.picks.len() < outcome.found.last.picks.len()
        && other.left() < Thresholds::READING_FOR_EFFECT * outcome.left()
}

/// Whether a lag was found.
fn names_lag(o: &Outcome) -> bool {
    let mut picks = o.found.last.picks.iter();
    picks.any(|(family, _)| o.library[*family].effect.group == Some(Group::Lag))
}

/// Other readings than the usual one and that of the answer.
fn untried(o: &Outcome, usual: Course, open: &[Course]) -> Vec<Course> {
    let taken = o.task.course;
    open.iter().copied().filter(|c| is_usual(*c) && *c != taken && *c != usual).collect()
}

/// Whether the reading is a usual one of such a command.
fn is_usual(course: Course) -> bool {
    course.between == Between::Zoh || moves(course)
}

/// Whether the command moves, and the reading is the usual one of such a command.
fn moves(course: Course) -> bool {
    let usual = Course::given(Some(course.between), None);
    course.between != Between::Zoh && course.reading == usual.reading
}

/// The error power that the model, or the best that was found, leaves with each of these, over what it leaves now; the
/// least first.
fn promising(o: &Outcome, open: &[Course], count: &AtomicU64) -> Vec<(Course, f64)> {
    let both = [&o.found.base, o.best()];
    if !has_gap(&o.found.base, o.adequate) {
        return Vec::new();
    }
    let mut tried: Vec<(Course, f64)> = open
        .par_iter()
        .with_max_len(1)
        .filter_map(|course| {
            // What leaves next to nothing needs no other reading.
            let open = both.iter().filter(|c| has_gap(c, o.adequate));
            let parts = open.filter_map(|c| part(o, c, *course, count));
            Some((*course, parts.min_by(f64::total_cmp)?))
        })
        .collect();
    tried.sort_by(|a, b| a.1.total_cmp(&b.1));
    tried
}

/// The error power that a candidate leaves when the logs are read so, over what it leaves now.
fn part(o: &Outcome, c: &Candidate, course: Course, count: &AtomicU64) -> Option<f64> {
    let data = o.task.data.played(course);
    let fitter = Fitter { data: &data, sigma: o.sigma, count, weights: None };
    let theta = fitter.fit_again(&c.chain, &c.fit.theta).ok()?.theta;
    let judged = o.judge.judge(&c.chain, &theta, &data, o.sigma, count).ok()?;
    Some((judged.training + judged.held_out) / (c.judged.training + c.judged.held_out))
}

/// The greatest part of the error power with which another reading is tried.
fn most(o: &Outcome) -> f64 {
    match has_released_lag(o) {
        true => Thresholds::READING_TRIED_FOR_LAG,
        false => Thresholds::READING_LESS,
    }
}

/// Mean square in SI of what the answer leaves on held-out rows.
fn held_out(o: &Outcome) -> f64 {
    o.found.last.judged.held_out * o.sigma.powi(2)
}

/// Number of the effect that is a missing mode.
fn slot_of_mode(o: &Outcome) -> Option<usize> {
    names(o).iter().position(|name| *name == effects::EXTRA_MODE.name)
}

/// Mean square in SI of what the answer leaves on held-out rows without its mode.
fn without_mode(o: &Outcome) -> Option<f64> {
    let slot = slot_of_mode(o)?;
    let gap = (o.found.base.judged.held_out - 1.0).max(0.0) * o.sigma.powi(2);
    Some(held_out(o) + o.found.alone.get(slot)? * gap)
}

/// Frequency of a mode that was found within 10 % of half the sample rate, in Hz.
fn mode_near_nyquist(o: &Outcome) -> Option<f64> {
    let last = &o.found.last;
    slot_of_mode(o)?;
    let own = last.chain.parameters.iter().zip(&last.fit.theta).filter(|(p, _)| !p.is_base);
    let frequencies = own.filter(|(p, _)| p.unit == "Hz").map(|(p, q)| p.value(*q));
    let sample = o.task.data.sample_time;
    frequencies.filter(|f| f * sample >= Thresholds::MODE_NEAR_NYQUIST).reduce(f64::max)
}
