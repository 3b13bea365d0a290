//! One axis on its way to a controller: its feedback, and the ways of its feedforward.

use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint};
use identify::learned::InverseFigures;
use model::{AxisSpec, Kind, NodeSpec};

use crate::analysis::{Analysed, linear_of};
use crate::damping::{self, Damped, DampedPlant, Damping};
use crate::design::{Feedback, Linear, SHIFTS, design};
use crate::feedforward::{self, Candidate};
use crate::inverse_filter::InverseFilter;
use crate::inversion::ControlSettings;
use crate::learned_axis::LearnedAxis;
use crate::linearised::{is_discrete, lead_of, modes, shifted, varied};
use crate::loop_shape::{Limits, Shaped};

/// One axis on its way to a controller.
pub(crate) struct Design {
    pub(crate) learned: Option<LearnedAxis>,
    pub(crate) shaped: Shaped,
    /// In front of the law, where the axis is part of a loop of coupled axes.
    pub(crate) notches: Vec<ComponentBlueprint>,
    /// The inner loop, where one is asked for.
    pub(crate) damped: Option<Damped>,
    pub(crate) slope: f64,
    /// The leads for all linear parts but those that a filter undoes.
    pub(crate) leads: Vec<ComponentBlueprint>,
    pub(crate) delay: f64,
    pub(crate) ways: Vec<Candidate>,
    pub(crate) chosen: usize,
    pub(crate) notes: Vec<String>,
    /// So many of the notes say what is left to feedback anyway; those behind them are about ways.
    pub(crate) left: usize,
    pub(crate) inverse: Option<InverseFigures>,
    pub(crate) tables: Vec<(String, model::Table)>,
}

/// The feedback of an axis, and the ways of its feedforward that need no run.
///
/// # Errors
/// Every reason why there is none.
pub(crate) fn axis_design(
    plant: &CheckedBlueprint,
    analysed: &Analysed,
    index: usize,
    settings: &ControlSettings,
    (step, period): (f64, f64),
) -> Result<Design, Vec<String>> {
    let one = |reason: String| vec![reason];
    let path = &analysed.paths[index];
    let learned = LearnedAxis::of(plant, index, period)?;
    let slope = learned.as_ref().map_or(path.sweep.slope, |learned| learned.slope);
    let nodes = linear_of(analysed, index);
    let response =
        |nodes: &[NodeSpec]| analysed.impulse(plant, index, nodes, slope, (step, period));
    let mut all_modes = modes(&nodes);
    all_modes.extend(learned.iter().flat_map(LearnedAxis::modes));
    let shifts = if modes(&nodes).is_empty() { &SHIFTS[..1] } else { &SHIFTS[..] };
    let impulses = shifts
        .iter()
        .map(|shift| response(&shifted(&nodes, *shift)).map_err(one))
        .collect::<Result<Vec<_>, _>>()?;
    let linear = Linear {
        impulses: &impulses,
        modes: &all_modes,
        slope,
        is_learned: nodes.iter().any(is_discrete),
        period,
    };
    let limits = Limits { sensitivity: settings.sensitivity, noise: settings.noise };
    let two_leads = damping::leads(lead_of(&impulses[0], period), &all_modes);
    let damped = if settings.damping == Damping::None {
        None
    } else {
        if learned.is_some() {
            return Err(one(
                "was learned, and its modes have no frequency that could be varied: no robust \
                            damping can be designed; leave --damping out"
                    .to_owned(),
            ));
        }
        let impulses = damping::grid()
            .map(|(shift, damping)| response(&varied(&nodes, shift, damping)).map_err(one))
            .collect::<Result<Vec<_>, _>>()?;
        let axis_plant = DampedPlant {
            impulses: &impulses,
            modes: &all_modes,
            slopes: (slope, path.sweep.least_slope),
            leads: &two_leads,
            period,
        };
        let derivative = settings.feedback == Feedback::Pid;
        let found =
            damping::damped(&axis_plant, settings.damping, derivative, settings.acts, limits);
        Some(found.map_err(one)?)
    };
    let shaped = match &damped {
        Some(damped) => damped.shaped,
        None => design(&linear, settings.feedback, settings.acts, limits).ok_or_else(|| {
            vec![
                "no feedback gain keeps the margins; allow a larger sensitivity or a shorter period"
                    .to_owned(),
            ]
        })?,
    };
    let delay = lead_of(&impulses[0], period).0 - 0.5 * period;
    let lead = match &learned {
        None if nodes.is_empty() && path.own.len() == 1 => None,
        None => lead_component(lead_of(&impulses[0], period), path.sweep.reach),
        Some(learned) => {
            let others: Vec<NodeSpec> =
                nodes.iter().filter(|node| !is_discrete(node)).cloned().collect();
            let inverse_filter = InverseFilter::of(&learned.linear, period);
            if others.is_empty() && !inverse_filter.filters() {
                None
            } else {
                let own = lead_of(&response(&others).map_err(one)?, period);
                let (lag, inertia) = (inverse_filter.lag, inverse_filter.inertia);
                let both = (own.0 + lag, own.1 + lag * own.0 + inertia);
                lead_component(both, learned.reach)
            }
        }
    };
    let leads = if damped.is_some() {
        let each = two_leads.into_iter().enumerate();
        each.filter_map(|(k, one)| {
            let found = lead_component(one, path.sweep.reach)?;
            Some(if k == 0 { found.named("mode_lead") } else { found })
        })
        .collect()
    } else {
        lead.into_iter().collect()
    };
    let mut ways = Vec::new();
    let mut notes = path.left.clone();
    notes.extend(analysed.left[index].iter().cloned());
    notes.extend(damped.iter().filter_map(Damped::shortfall));
    let left = notes.len();
    if learned.is_none() {
        for way in feedforward::declared(path) {
            match way.and_then(|way| buildable(way, &path.axis, period)) {
                Ok(way) => ways.push(way),
                Err(reason) => notes.push(format!("{}: {reason}", path.actuator.name)),
            }
        }
    }
    let (inverse, tables) = (None, Vec::new());
    Ok(Design {
        learned,
        shaped,
        notches: Vec::new(),
        damped,
        slope,
        leads,
        delay,
        ways,
        chosen: 0,
        notes,
        left,
        inverse,
        tables,
    })
}

/// The way, where a controller can be built of it.
pub(crate) fn buildable(way: Candidate, axis: &AxisSpec, period: f64) -> Result<Candidate, String> {
    let mut own = AxisBlueprint::new("x", &axis.command_unit, &axis.position_unit);
    own.command = own.command.between(axis.command_range.0, axis.command_range.1);
    own.components.clone_from(&way.chain);
    let mut blueprint = Blueprint::new(Kind::Controller, "part", period).axis(own);
    blueprint.tables.extend(way.tables.iter().cloned());
    match blueprint.check(learned::COMPONENTS) {
        Ok(_) => Ok(way),
        Err(problems) => Err(format!("{} does not suit: {problems}", way.name)),
    }
}

/// What the feedforward adds to the reference for the linear parts of the path.
fn lead_component((lag, inertia): (f64, f64), reach: (f64, f64)) -> Option<ComponentBlueprint> {
    let limit = 0.5 * (reach.1 - reach.0);
    let component = ComponentBlueprint::new("reference-lead");
    let component = component.value("lag", lag.max(0.0)).value("inertia", inertia.max(0.0));
    Some(component.value("limit", limit))
}
