//! A campaign of faults in virtual time: each must end in the state that is expected, within its
//! deadline in cycles, and with the machine at rest.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::cycle::{Cycle, Orders};
use crate::emulate::{Fault, PlantError, Script, ScriptError};
use crate::safety::{AxisLimits, Reason, State};
use crate::virtual_run::{Ended, VirtualRun};

/// A campaign, in TOML:
///
/// ```toml
/// plan = "plan.toml"              # bench plan: controller, limits, watch, what is played
/// plant = "plant.fmu"             # the machine: an FMU, a blueprint or the name of a rig
/// seed = 7
///
/// [[case]]
/// name = "no sample comes any more"
/// at = [30, 500]                  # cycles of the machine: the case is tried at each of them
/// expect = { state = "safe", reason = "sample-lost", within = 8 }
///
/// [[case.fault]]                  # as in a script of faults; from and to are s after `at`
/// kind = "loss"
/// probability = 1
/// ```
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    /// The bench plan.
    pub plan: Option<PathBuf>,
    /// The plant.
    pub plant: Option<PathBuf>,
    /// Seed of all that is random.
    #[serde(default)]
    pub seed: u64,
    /// Steps without a command after which the machine stops itself; default 100.
    pub heartbeat: Option<u32>,
    /// Commands while the machine is stopped; default: the plant's start values.
    #[serde(default)]
    pub safe: Vec<f64>,
    /// The cases.
    #[serde(default, rename = "case")]
    pub cases: Vec<Case>,
}

/// One case: faults, when they come, and what must come of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// What the case is called.
    pub name: String,
    /// Cycles of the machine from which the times of the faults count; one trial for each.
    #[serde(default = "from_the_begin")]
    pub at: Vec<u32>,
    /// The end that is expected.
    pub expect: Expect,
    /// The faults as they stand in the file.
    #[serde(default, rename = "fault")]
    tables: Vec<toml::Table>,
    /// The faults, their times in s after `at`.
    #[serde(skip)]
    pub faults: Vec<Fault>,
}

fn from_the_begin() -> Vec<u32> {
    vec![0]
}

/// The end of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// Last state.
    pub state: State,
    /// The reason.
    pub reason: Reason,
    /// Most cycles from the trial's `at` to the last state; none: before the plan has ended.
    pub within: Option<u32>,
}

/// How a trial ended.
#[derive(Clone, Debug, Serialize)]
pub struct Trial {
    /// Name of the case.
    pub case: String,
    /// Cycle from which its faults' times count.
    pub at: u32,
    /// The trial's seed.
    pub seed: u64,
    /// Last state.
    pub state: &'static str,
    /// The trial's reason.
    pub reason: String,
    /// Cycles from `at` to the last state.
    pub took: u64,
    /// What was not as expected; empty for a trial that passed.
    pub problems: Vec<String>,
}

/// A campaign that cannot be run.
#[derive(Debug, Error)]
pub enum CampaignError {
    /// Everything that is wrong with its text.
    #[error("{}", .0.join("\n"))]
    Text(Vec<String>),
    /// The plant FMU failed.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

impl Campaign {
    /// Reads a campaign; `origin` is what messages call it.
    ///
    /// # Errors
    /// Every problem of the text.
    pub fn parse(text: &str, origin: &str) -> Result<Self, CampaignError> {
        let mut campaign: Campaign = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            let other = data::of_another_kind(text, "a campaign of the bench");
            CampaignError::Text(vec![format!("{origin}:{line}: {other}{}", error.message())])
        })?;
        let mut problems = Vec::new();
        if campaign.cases.is_empty() {
            problems.push(format!("{origin}: there is no [[case]]"));
        }
        for case in &mut campaign.cases {
            let place = format!("{origin}: case `{}`", case.name);
            if case.at.is_empty() {
                problems.push(format!("{place}: at = []: give one cycle or more"));
            }
            match Script::of_tables(&case.tables, &place) {
                Ok(faults) => case.faults = faults,
                Err(ScriptError(found)) => problems.extend(found),
            }
        }
        if problems.is_empty() { Ok(campaign) } else { Err(CampaignError::Text(problems)) }
    }

    /// Number of trials.
    #[must_use]
    pub fn trials(&self) -> usize {
        self.cases.iter().map(|case| case.at.len()).sum()
    }

    /// Tries every case at each of its times. `bench` puts runner and machine together for one trial
    /// with this script of faults; the plan starts after `settle` cycles. `each` sees every trial and
    /// its bench when it has ended.
    ///
    /// # Errors
    /// The first trial that cannot be made or whose plant failed.
    pub fn run<E: From<PlantError>>(
        &self,
        settle: u64,
        mut bench: impl FnMut(Script) -> Result<VirtualRun, E>,
        mut each: impl FnMut(&Trial, &VirtualRun) -> Result<(), E>,
    ) -> Result<Vec<Trial>, E> {
        let all = self.cases.iter().flat_map(|case| case.at.iter().map(move |at| (case, *at)));
        let mut trials = Vec::with_capacity(self.trials());
        for ((case, at), index) in all.zip(0..) {
            let seed = self.seed.wrapping_add(index);
            let rehearse = |period: f64| Script { seed, faults: case.shifted(at, period) };
            // The period is the bench's own: a bench without faults tells it.
            let period = bench(Script::default())?.period();
            let mut bench = bench(rehearse(period))?;
            let trial = case.judge(at, seed, settle, &mut bench)?;
            each(&trial, &bench)?;
            trials.push(trial);
        }
        Ok(trials)
    }
}

impl Case {
    /// The faults of a trial, with times of the machine.
    fn shifted(&self, at: u32, period: f64) -> Vec<Fault> {
        // Half a cycle early, so that rounding does not decide.
        let begin = (f64::from(at) - 0.5) * period;
        let later = |fault: &Fault| Fault {
            from: (begin + fault.from).max(0.0),
            to: fault.to.map(|to| begin + to),
            ..fault.clone()
        };
        self.faults.iter().map(later).collect()
    }

    fn judge(
        &self,
        at: u32,
        seed: u64,
        settle: u64,
        bench: &mut VirtualRun,
    ) -> Result<Trial, PlantError> {
        let mut watcher = Watcher::new(&bench.cycle, bench.period());
        let within = u64::from(self.expect.within.unwrap_or(0));
        let length = settle + bench.cycle.planned_cycles();
        let most = length.max(u64::from(at) + within) + watcher.ramp.unwrap_or(1000) + 200;
        let ended = bench.run(most, |bench, _| {
            watcher.look(&bench.cycle);
            Orders { start: bench.next() >= settle, ..Orders::default() }
        })?;
        let took = ended.entered.saturating_sub(at.into());
        let mut problems = self.differences(&ended, took);
        problems.extend(watcher.problems(&ended));
        let (state, reason) = (ended.memory.state.name(), ended.memory.reason.to_string());
        Ok(Trial { case: self.name.clone(), at, seed, state, reason, took, problems })
    }

    fn differences(&self, ended: &Ended, took: u64) -> Vec<String> {
        let Expect { state, reason, within } = self.expect;
        let mut problems = Vec::new();
        let found = ended.memory;
        if (found.state, found.reason) != (state, reason) {
            problems.push(format!(
                "ended in the state {}: {}; expected {state}: {reason}",
                found.state, found.reason
            ));
        }
        if let Some(within) = within.filter(|within| took > u64::from(*within)) {
            problems.push(format!("took {took} cycles; at most {within} are allowed"));
        }
        problems
    }
}

/// What must hold in every trial: the command keeps its limits, and ends at rest.
struct Watcher {
    limits: Vec<AxisLimits>,
    period: f64,
    before: Vec<f64>,
    left: bool,
    /// Cycles of the longest way to the safe value; none without limits.
    ramp: Option<u64>,
}

impl Watcher {
    fn new(cycle: &Cycle, period: f64) -> Self {
        let limits = cycle.limits().to_vec();
        let cycles = |axis: &AxisLimits| {
            let [least, greatest] = axis.command;
            let way = (greatest - axis.safe).max(axis.safe - least);
            way / (axis.safe_rate * period)
        };
        let longest = limits.iter().map(cycles).fold(0.0, f64::max);
        let ramp = longest.is_finite().then(|| longest as u64 + 2);
        Watcher { before: cycle.commands().to_vec(), limits, period, left: false, ramp }
    }

    fn look(&mut self, cycle: &Cycle) {
        for ((axis, now), before) in self.limits.iter().zip(cycle.commands()).zip(&mut self.before)
        {
            let [least, greatest] = axis.command;
            let most = axis.command_rate.max(axis.safe_rate) * self.period;
            self.left |= !(least..=greatest).contains(now);
            self.left |= (now - *before).abs() > most * (1.0 + 1e-9) + 1e-9;
            *before = *now;
        }
    }

    fn problems(&self, ended: &Ended) -> Vec<String> {
        let mut problems = Vec::new();
        if self.left {
            problems.push("a command left its limits".to_owned());
        }
        if ended.at_rest == u64::MAX {
            problems.push("it never came to rest".to_owned());
        } else if self.ramp.is_some_and(|ramp| ended.at_rest > ended.entered + ramp) {
            let late = ended.at_rest - ended.entered;
            problems.push(format!("at rest only {late} cycles after its last state began"));
        }
        problems
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_problem_of_a_campaign_is_reported() {
        let text = "[[case]]\nname = \"a\"\nexpect = { state = \"safe\", reason = \"finished\" }\n\
                    at = []\n[[case.fault]]\nkind = \"loss\"\nprobability = 2\n\
                    [[case]]\nname = \"b\"\nexpect = { state = \"fault\", reason = \"power-lost\" }\n\
                    [[case.fault]]\nkind = \"power-loss\"\naxis = 1\n\
                    [[case.fault]]\nkind = \"offset\"\n";
        let CampaignError::Text(problems) = Campaign::parse(text, "c.toml").unwrap_err() else {
            panic!("no problems")
        };
        for word in ["case `a`: at = []", "probability = 2", "there is no `axis`", "value"] {
            assert!(problems.iter().any(|problem| problem.contains(word)), "{word}: {problems:?}");
        }
        let wrong =
            "[[case]]\nname = \"a\"\nexpect = { state = \"save\", reason = \"finished\" }\n";
        let message = Campaign::parse(wrong, "c.toml").unwrap_err().to_string();
        assert!(message.starts_with("c.toml:3") && message.contains("safe"), "{message}");
        assert!(Campaign::parse("", "c.toml").unwrap_err().to_string().contains("[[case]]"));
    }
}
