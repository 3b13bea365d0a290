//! The hysteresis models that can be identified: one file per method, and the one list of them. An operator of plays
//! needs none: its component declares how it is fitted ([`model::Fit`], `declared`).
//!
//! A method says which of its parameters enter the position linearly, its *weights*, and which do
//! not, its *shape*. For a shape it gives one column per weight; the weights are then found by least
//! squares with bounds, and only the shape is searched. To add a method, write its file and its line
//! in [`METHODS`].

mod bouc_wen;
mod curved_prandtl_ishlinskii;
mod declared;
mod dynamic_prandtl_ishlinskii;
mod generalised_play;
mod linear;
mod modified_prandtl_ishlinskii;
mod prandtl_ishlinskii;
mod preisach;

use std::borrow::Cow;
use std::sync::LazyLock;

use data::ComponentBlueprint;

use crate::error::Error;
use crate::fit::response::Part;
use crate::learned::family::Family;

/// All methods, the simplest first. Among methods that differ little the simpler one is returned.
pub(crate) static METHODS: LazyLock<Vec<&'static dyn Method>> = LazyLock::new(|| {
    let declared = declared::Declared::all().map(|method| &*Box::leak(Box::new(method)) as _);
    STATIC_METHODS.into_iter().chain(declared).chain(FREER_METHODS).collect()
});

/// Those before the ones that components declare.
const STATIC_METHODS: [&dyn Method; 4] = [
    &linear::Linear,
    &prandtl_ishlinskii::PrandtlIshlinskii,
    &bouc_wen::BoucWen { asymmetric: false },
    &bouc_wen::BoucWen { asymmetric: true },
];

/// Those behind them: they have more freedom.
const FREER_METHODS: [&dyn Method; 5] = [
    &generalised_play::GeneralisedPlay,
    &modified_prandtl_ishlinskii::ModifiedPrandtlIshlinskii,
    &curved_prandtl_ishlinskii::Curved,
    &dynamic_prandtl_ishlinskii::DynamicPrandtlIshlinskii,
    &preisach::Preisach,
];

/// A hysteresis model that can be fitted to records.
pub(crate) trait Method: Sync {
    /// The method's name on the command line.
    fn name(&self) -> &'static str;
    /// One sentence.
    fn summary(&self) -> &'static str;
    /// Parameters that are searched; none where everything is linear.
    fn shape(&self, scene: &FitContext) -> Vec<Shape>;
    /// Other starts of the search, full vectors of the shape.
    fn starts(&self, scene: &FitContext) -> Vec<Vec<f64>> {
        vec![self.shape(scene).iter().map(|s| s.start).collect()]
    }
    /// Parameters that are linear, in the order of the columns: those of any sign first.
    fn weights(&self, scene: &FitContext) -> Weights;
    /// The columns, one per weight: its part of the position for each sample of a signal, `step` seconds apart.
    ///
    /// # Errors
    /// [`Error::Model`] where the component refuses the shape.
    fn bank<'a>(
        &'a self,
        scene: &'a FitContext,
        shape: &[f64],
        step: f64,
    ) -> Result<Bank<'a>, Error>;
    /// Least value of the first weight where none is free.
    fn least(&self, scene: &FitContext) -> f64 {
        let _ = scene;
        0.0
    }
    /// The parameter of the component that holds the weights, where it states their common tolerance.
    fn tolerance(&self) -> Option<&'static str> {
        None
    }
    /// Positions before the static map that the method puts behind everything, and the slope of that
    /// map there; `None` where there is no such map.
    fn unmapped(
        &self,
        scene: &FitContext,
        shape: &[f64],
        output: &[f64],
    ) -> Option<Vec<(f64, f64)>> {
        let _ = (scene, shape, output);
        None
    }
    /// Whether the offset is part of the shape, since the static map is tied to it.
    fn anchored(&self) -> bool {
        false
    }
    /// Rows of a penalty on the weights, in position, per square root of a sample.
    fn penalty(&self, scene: &FitContext) -> Vec<Vec<f64>> {
        let _ = scene;
        Vec::new()
    }
    /// The components of a fitted model.
    fn chain(&self, scene: &FitContext, shape: &[f64], weights: &[f64], offset: f64) -> Chain;
}

/// What a method knows of the records.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FitContext {
    /// Least and greatest command.
    pub(crate) command: [f64; 2],
    /// Least and greatest position on the rows fitted on.
    pub(crate) position: [f64; 2],
    /// Position at zero command on the best straight line.
    pub(crate) zero: f64,
    /// Longest time fitted on, in s.
    pub(crate) duration: f64,
    /// Thresholds of plays, from 0.
    pub(crate) thresholds: Vec<f64>,
    /// Levels of a Preisach model.
    pub(crate) levels: usize,
    /// Least slope of a model for small motions, in position per command.
    pub(crate) least_slope: f64,
}

impl FitContext {
    /// Position at zero command on the line from the least to the greatest command and position.
    pub(crate) fn zero_of([low, high]: [f64; 2], [bottom, top]: [f64; 2]) -> f64 {
        bottom - low * (top - bottom) / (high - low)
    }

    /// Middle and half of the command's range.
    pub(crate) fn centre(&self) -> (f64, f64) {
        let [low, high] = self.command;
        (0.5 * (low + high), (0.5 * (high - low)).max(f64::MIN_POSITIVE))
    }

    /// Middle and half of the position's range.
    pub(crate) fn middle(&self) -> (f64, f64) {
        let [low, high] = self.position;
        (0.5 * (low + high), (0.5 * (high - low)).max(f64::MIN_POSITIVE))
    }
}

/// A parameter that is searched.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    pub(crate) name: Cow<'static, str>,
    /// Unit, with `{command}` and `{position}` for those of the axis.
    pub(crate) unit: &'static str,
    pub(crate) start: f64,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
}

impl Shape {
    pub(crate) fn new(
        name: impl Into<Cow<'static, str>>,
        unit: &'static str,
        start: f64,
        (lower, upper): (f64, f64),
    ) -> Self {
        Self { name: name.into(), unit, start, lower, upper }
    }
}

/// The linear parameters of a method.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Weights {
    /// How many of them, the first ones, may have any sign; the others are not negative.
    pub(crate) free: usize,
    /// Name and unit of each.
    pub(crate) names: Vec<(String, &'static str)>,
    /// Thresholds of the plays; their weights are the last ones.
    pub(crate) thresholds: Vec<f64>,
}

pub(crate) const PER_COMMAND: &str = "{position}/{command}";

impl Weights {
    /// These of any sign, then one per play.
    pub(crate) fn plays(free: &[(&str, &'static str)], thresholds: &[f64]) -> Self {
        let named = free.iter().map(|(name, unit)| ((*name).to_owned(), *unit));
        let plays = (1..=thresholds.len()).map(|i| (format!("hysteresis.w[{i}]"), PER_COMMAND));
        let (free, thresholds) = (free.len(), thresholds.to_vec());
        Self { free, names: named.chain(plays).collect(), thresholds }
    }

    /// Threshold of the play with this weight.
    pub(crate) fn threshold(&self, index: usize) -> Option<f64> {
        let first = self.names.len() - self.thresholds.len();
        index.checked_sub(first).map(|play| self.thresholds[play])
    }
}

/// The components of a fitted model: those that turn the command into a position, and those behind
/// the mechanics.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Chain {
    pub(crate) hysteresis: Vec<ComponentBlueprint>,
    pub(crate) reading: Vec<ComponentBlueprint>,
}

impl Chain {
    pub(crate) fn of(hysteresis: ComponentBlueprint) -> Self {
        Self { hysteresis: vec![hysteresis], reading: Vec::new() }
    }
}

/// The columns of a method: takes the next sample of the signal and writes its row. The machine rests under the first one.
pub(crate) type Bank<'a> = Box<dyn FnMut(f64, &mut [f64]) + 'a>;

/// Runs a component over the signal and takes each row from what it remembers.
pub(crate) fn stepped(
    mut part: Part,
    mut take: impl FnMut(f64, &[f64], &mut [f64]) + 'static,
) -> Bank<'static> {
    let mut at_rest = true;
    Box::new(move |u, row| {
        if at_rest {
            part.rest(u);
        } else {
            part.step(u);
        }
        at_rest = false;
        take(u, part.state(), row);
    })
}

/// Name of plays between two curves with a small network.
pub(crate) const NETWORK: &str = "learned-plays";

/// The method whose plays these are.
pub(crate) static CURVED: &dyn Method = &curved_prandtl_ishlinskii::Curved;

/// The static model with hysteresis: its offsets and linear parts are where the others begin.
pub(crate) static STATIC: &dyn Method = &prandtl_ishlinskii::PrandtlIshlinskii;

/// The model without hysteresis.
pub(crate) static GAIN: &dyn Method = &linear::Linear;

/// Name of the model without hysteresis.
pub(crate) const LINEAR: &str = "linear";

/// The method of this name.
pub(crate) fn find(name: &str) -> Option<Strategy> {
    let operator = METHODS.iter().copied().find(|m| m.name() == name).map(Strategy::Operator);
    let learned = || Family::ALL.into_iter().find(|f| f.name() == name).map(Strategy::Learned);
    let network = (name == NETWORK).then_some(Strategy::Network);
    operator.or_else(learned).or(network)
}

/// How a plant is found.
#[derive(Clone, Copy)]
pub(crate) enum Strategy {
    /// By a fit.
    Operator(&'static dyn Method),
    /// By learning.
    Learned(Family),
    /// Plays between two curves, and a small network that learns what they leave.
    Network,
}

impl Strategy {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Strategy::Operator(method) => method.name(),
            Strategy::Learned(family) => family.name(),
            Strategy::Network => NETWORK,
        }
    }
}

/// Whether the method of this name learns a machine.
#[must_use]
pub fn is_learned(name: &str) -> bool {
    matches!(find(name), Some(Strategy::Learned(_)))
}

/// Name and sentence of every method that can be identified.
pub fn methods() -> impl Iterator<Item = (&'static str, &'static str)> {
    let learned = Family::ALL.into_iter().map(|f| (f.name(), f.summary()));
    let operators = METHODS.iter().map(|m| (m.name(), m.summary()));
    let network = (
        NETWORK,
        "Smooth Prandtl-Ishlinskii between two curves, and a network over its plays: learned",
    );
    operators.chain(learned).chain([network])
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_are_unique_and_found() {
        let names: BTreeSet<_> = methods().map(|(name, _)| name).collect();
        assert_eq!(names.len(), 1 + METHODS.len() + Family::ALL.len());
        assert!(names.iter().all(|name| find(name).is_some()));
    }

    #[test]
    fn every_method_has_a_column_per_weight_and_a_start_within_bounds() {
        let scene = FitContext {
            command: [0.0, 10.0],
            position: [-1.0, 20.0],
            zero: 0.0,
            duration: 1.0,
            thresholds: vec![0.0, 1.0, 2.0, 3.0],
            levels: 6,
            least_slope: 0.0,
        };
        let signal: Vec<f64> = (0..100).map(|k| 5.0 - 5.0 * (f64::from(k) * 0.1).cos()).collect();
        for method in METHODS.iter() {
            let shape = method.shape(&scene);
            for start in method.starts(&scene) {
                assert_eq!(start.len(), shape.len(), "{}", method.name());
                for (value, s) in start.iter().zip(&shape) {
                    assert!((s.lower..=s.upper).contains(value), "{}: {s:?}", method.name());
                }
                let bank = method.bank(&scene, &start, 0.01);
                let mut bank = bank.unwrap_or_else(|e| panic!("{}: {e}", method.name()));
                let weights = method.weights(&scene);
                assert!(weights.free <= weights.names.len());
                // Each value of a row is written.
                let mut row = vec![f64::NAN; weights.names.len()];
                for &u in &signal {
                    bank(u, &mut row);
                    assert!(row.iter().all(|value| value.is_finite()), "{}", method.name());
                }
            }
        }
    }
}
