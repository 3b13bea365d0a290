//! What only the scorer knows about a case.

use gap_machines::{Effect, Formula, Scene, Setting, Timing};
use serde::{Deserialize, Serialize};

use crate::case::Case;

/// The truth of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// The case.
    pub case: String,
    /// The label's family.
    pub family: String,
    /// The effects of the machine's first output.
    pub effects: Vec<TrueEffect>,
    /// Candidates that were taken out of the library.
    pub without: Vec<String>,
    /// Root mean square of what the re-tuned model leaves of all effects, over the noise.
    pub total: f64,
    /// Standard deviation of the noise in µm.
    pub sigma: f64,
    /// Rows of the logs that the diagnosis gets.
    pub rows: usize,
    /// Sample rate in Hz.
    pub rate: f64,
    /// `open loop`, `closed loop` or `operation`.
    pub setting: String,
    /// By how much the re-tuned model misses each record that nobody sees; empty where the effects do
    /// not follow from the command alone.
    pub missed: Vec<Miss>,
}

/// By how much a model misses a record without noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Miss {
    /// Root mean square in µm.
    pub rms: f64,
    /// Rows of the record.
    pub rows: usize,
}

impl Miss {
    /// The root mean square over several records; not a number where there is none.
    #[must_use]
    pub fn pooled(all: &[Self]) -> f64 {
        let sum: f64 = all.iter().map(|miss| miss.rms * miss.rms * miss.rows as f64).sum();
        let rows: usize = all.iter().map(|miss| miss.rows).sum();
        (sum / rows as f64).sqrt()
    }
}

/// One withheld effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrueEffect {
    /// Identifier.
    pub effect: String,
    /// Whether its formula is another one than the textbook's.
    pub is_other_formula: bool,
    /// The size that was asked for, over the noise.
    pub wanted_size: f64,
    /// The size that it has.
    pub size: f64,
    /// The true effect's magnitude in its own unit.
    pub magnitude: f64,
    /// Group within which one output without taps cannot always decide.
    pub group: Option<String>,
}

impl Label {
    /// The label of a case whose scene was drawn.
    #[must_use]
    pub fn new(case: &Case, scene: &Scene) -> Self {
        let mut effects: Vec<TrueEffect> = case
            .order
            .effects
            .iter()
            .zip(&scene.insertions)
            .zip(&scene.sizes)
            .map(|((wish, insertion), size)| TrueEffect {
                effect: wish.effect.name().to_owned(),
                is_other_formula: wish.formula == Formula::Other,
                wanted_size: wish.size,
                size: *size,
                magnitude: insertion.magnitude,
                group: group(wish.effect, wish.formula).map(str::to_owned),
            })
            .collect();
        if case.order.wrong_weights > 0.0 {
            effects.push(TrueEffect {
                effect: Effect::Hysteresis.name().to_owned(),
                is_other_formula: false,
                // Not asked for in noise: what the model misses is not split among the effects.
                wanted_size: 0.0,
                size: 0.0,
                magnitude: case.order.wrong_weights,
                group: None,
            });
        }
        // A simulation takes every log as read before its command acts, and an identified model is not the machine.
        let is_plain = case.order.timing == Timing::Before && !case.is_identified;
        let is_predictable =
            is_plain && case.order.effects.iter().all(|wish| wish.effect.is_predictable());
        let missed = scene.unseen.iter().filter(|_| is_predictable).filter_map(|record| {
            record.missed.map(|rms| Miss { rms, rows: record.commands[0].len() })
        });
        let logs = scene.fit.iter().chain(&scene.held_out);
        Self {
            case: case.id.clone(),
            family: case.family.to_owned(),
            effects,
            without: case.without.clone(),
            total: scene.total,
            sigma: scene.sigma.first().copied().unwrap_or_default(),
            rows: logs.map(|record| record.commands[0].len()).sum(),
            rate: case.order.rate,
            setting: match case.order.setting {
                Setting::OpenLoop => "open loop",
                Setting::ClosedLoop => "closed loop",
                Setting::Operation => "operation",
            }
            .to_owned(),
            missed: missed.collect(),
        }
    }

    /// Whether the machine has this effect.
    #[must_use]
    pub fn has(&self, effect: &str) -> bool {
        self.effects.iter().any(|truth| truth.effect == effect)
    }
}

/// A hard rail is no smooth map and can be told from one.
fn group(effect: Effect, formula: Formula) -> Option<&'static str> {
    let is_hard = effect == Effect::AmplifierSaturation && formula == Formula::Standard;
    effect.group().filter(|_| !is_hard)
}
