//! Learned inverses as components of a controller.

use data::{Blueprint, ComponentBlueprint, Value};
use identify::learned::{
    Arx, Frame, GREATEST_GAMMA, Machine, Recipe, Span, SyntheticData, Waves, rms_difference, weigh,
};
use learned::features::{Features, StopOperators};

/// Adds the table of an inverse to a blueprint, and gives its component. Its commands and positions are those
/// of the machine, from output and input.
pub(super) fn learned_inverse(
    blueprint: &mut Blueprint,
    name: &str,
    machine: &Machine,
) -> anyhow::Result<ComponentBlueprint> {
    let file = format!("{name}.npy");
    let table = machine.table().map_err(anyhow::Error::msg)?;
    blueprint.tables.insert(file.clone(), table);
    let Value::Number(step) = blueprint.step else {
        anyhow::bail!("the blueprint's step is no number")
    };
    Ok(machine.component(true, &file, step).named("inverse"))
}

/// An inverse over stop operators: what it is to know, and where the search for its widths begins.
pub(super) struct Wanted<'a> {
    /// Its range becomes that of the forward model's answers.
    pub(super) stops: StopOperators,
    /// The component holds its command within twice this span.
    pub(super) span: Span,
    pub(super) waves: Waves,
    pub(super) group: &'a dyn Fn(usize) -> usize,
    /// Widths and γ.
    pub(super) begin: (&'a [f64], f64),
}

/// Evaluations of the evidence, and samples it looks at.
const SEARCH: (usize, usize) = (70, 750);
/// Of the rows of the waves, one in so many is learned.
const EVERY: usize = 4;

/// The inverse of a hysteresis, learned from what the forward model answers to these commands and to waves.
pub(super) fn hysteresis_inverse(
    forward: &Machine,
    start: f64,
    measured: &[&[f64]],
    wanted: &Wanted<'_>,
) -> anyhow::Result<Machine> {
    let simulate = |u: &[f64]| forward.simulate(u, start);
    let synthetic = SyntheticData::new(measured, Some(wanted.waves), simulate)?;
    let pairs = synthetic.pairs();
    let range = pairs.iter().flat_map(|(h, _)| *h).fold(0.0_f64, |top, h| top.max(h.abs()));
    let features = Features::StopOperators(StopOperators { range, ..wanted.stops.clone() });
    let frame = Frame::new(features, Span::UNIT, wanted.span, Recipe::Plain, &pairs);
    let frame = frame.on_a_line(&pairs);
    let found = weigh(&frame, &pairs, wanted.group, wanted.begin, SEARCH, GREATEST_GAMMA)?;
    let samples = synthetic.samples(&found.frame, 1, EVERY)?;
    Ok(Machine::train_on(found.frame, &samples, found.settings)?.0)
}

/// The stable linear part of least error from `from` (which may run `ahead` rows ahead) to `to`.
pub(crate) struct Linear {
    pub(crate) arx: Arx,
    pub(crate) ahead: usize,
    pub(crate) error: f64,
}

impl Linear {
    /// The response to `from`, which is told `ahead` rows early.
    pub(crate) fn simulate(&self, from: &[f64], to0: f64) -> Vec<f64> {
        self.arx.simulate(&early(from, self.ahead), to0)
    }
}

/// A signal some rows earlier, its last value held.
pub(crate) fn early(x: &[f64], rows: usize) -> Vec<f64> {
    let last = x.len().saturating_sub(1);
    (0..x.len()).map(|k| x[(k + rows).min(last)]).collect()
}

/// Numerator and denominator orders that are tried.
const ORDERS: [(usize, usize); 6] = [(1, 1), (2, 1), (2, 2), (2, 3), (3, 1), (4, 1)];

/// Fits a linear part with up to `most_ahead` rows of preview.
pub(crate) fn linear(from: &[f64], to: &[f64], period: f64, most_ahead: usize) -> Option<Linear> {
    let mut best: Option<Linear> = None;
    for ahead in 0..=most_ahead {
        let early = early(from, ahead);
        for (zeros, poles) in ORDERS {
            let Ok(arx) = Arx::fit(&early, to, zeros, poles) else { continue };
            if !is_stable(&arx, period) {
                continue;
            }
            let error = rms_difference(&arx.simulate(&early, to[0]), to);
            if error.is_finite() && best.as_ref().is_none_or(|b| error < 0.98 * b.error) {
                best = Some(Linear { arx, ahead, error });
            }
        }
    }
    best
}

/// Whether the component `arx` takes it.
fn is_stable(arx: &Arx, period: f64) -> bool {
    let Some(component) = components::find("arx") else { return false };
    let structure = [period, arx.b.len() as f64, arx.a.len() as f64];
    let mut room = vec![0.0; component.sizes(&structure, period).coefficients];
    let values = [&arx.b[..], &arx.a].concat();
    component.prepare(&structure, &values, period, &mut room).is_ok()
}

/// The component of a linear part.
pub(crate) fn arx_component(arx: &Arx, period: f64) -> ComponentBlueprint {
    let list = |values: &[f64]| Value::List(values.iter().map(|x| Value::Number(*x)).collect());
    ComponentBlueprint::new("arx")
        .value("sample_time", period)
        .value("b", list(&arx.b))
        .value("a", list(&arx.a))
}
