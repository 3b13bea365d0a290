//! The check that the parts make a system: rules across values, order of the signals, size.

use model::{BuildError, NodeSpec, System, Unit, unit_on_axis};

use super::checker::Checker;
use super::draft::Draft;
use super::measure;
use super::origin::Place;

/// Cells (8 bytes each) that a model may have: 128 MiB.
const MOST_CELLS: usize = 1 << 24;

/// The system that the draft says, where it says one; problems are reported.
pub(super) fn system(checker: &mut Checker<'_>, draft: &Draft) -> Option<System> {
    if checker.is_spoilt("kind") || !fits(checker, draft) {
        return None;
    }
    if !checker.is_spoilt("step") {
        check_sets(checker, draft);
    }
    match System::new(&draft.spec) {
        Ok(system) => Some(system),
        Err(errors) => {
            let had_problems = checker.has_problems();
            for error in &errors {
                report(checker, draft, error, had_problems);
            }
            None
        }
    }
}

/// Whether the system has a size that a machine can hold.
fn fits(checker: &mut Checker<'_>, draft: &Draft) -> bool {
    let period = draft.spec.period;
    let mut sum = 0usize;
    for (node, place) in members(draft) {
        let sizes = node.component.sizes(&node.structure, period);
        let own = sizes.coefficients.saturating_add(sizes.states);
        sum = sum.saturating_add(own).saturating_add(node.values.len());
        if sum > MOST_CELLS && checker.is_spoilt("step") {
            return false;
        }
        if sum > MOST_CELLS {
            let rule = format!(
                "needs {own} numbers of memory at a step of {period} s; a model may have {MOST_CELLS}"
            );
            let way_out = "lengthen the step, or shorten what is stored";
            checker.report(place, "", rule, way_out);
            return false;
        }
    }
    true
}

/// All components with their places: those of the axes, then the couplings.
fn members(draft: &Draft) -> impl Iterator<Item = (&NodeSpec, &Place)> {
    let axes = draft.spec.axes.iter().zip(&draft.axes);
    let own = axes.flat_map(|(spec, places)| {
        spec.components.iter().zip(places.components.iter().map(|(place, _)| place))
    });
    let couplings = draft.spec.connections.couplings.iter().map(|coupling| &coupling.node);
    own.chain(couplings.zip(draft.couplings.iter().map(|(place, _)| place)))
}

/// Checks the rules that span several values of a component.
fn check_sets(checker: &mut Checker<'_>, draft: &Draft) {
    for (axis, places) in draft.spec.axes.iter().zip(&draft.axes) {
        let units = places.position_units.iter();
        for ((node, (place, is_clean)), position) in
            axis.components.iter().zip(&places.components).zip(units)
        {
            if *is_clean {
                check_set(checker, draft.spec.period, node, place, &axis.command_unit, position);
            }
        }
    }
    for (coupling, (place, is_clean)) in
        draft.spec.connections.couplings.iter().zip(&draft.couplings)
    {
        if *is_clean {
            let [command, position] = super::coupling::units(&draft.spec, coupling);
            check_set(checker, draft.spec.period, &coupling.node, place, &command, &position);
        }
    }
}

/// Checks the rules that span several values of one component whose `{command}` and `{position}`
/// stand for these units.
fn check_set(
    checker: &mut Checker<'_>,
    period: f64,
    node: &NodeSpec,
    place: &Place,
    command: &str,
    position: &str,
) {
    if [command, position].iter().any(|unit| Unit::parse(unit).is_err()) {
        return;
    }
    let declaration = node.component.declaration();
    let on_axis = |unit| unit_on_axis(unit, command, position);
    let mut values = node.values.iter();
    let mut si = Vec::with_capacity(node.values.len());
    for (index, quantity) in declaration.parameters.iter().enumerate() {
        let unit = Unit::parse(&on_axis(quantity.unit)).unwrap_or(Unit::ONE);
        let length = declaration.length(index, &node.structure);
        si.extend(values.by_ref().take(length).map(|value| unit.to_si(*value)));
    }
    let mut coefficients = vec![0.0; node.component.sizes(&node.structure, period).coefficients];
    let verdict = node.component.prepare(&node.structure, &si, period, &mut coefficients);
    let Err(violation) = verdict else { return };
    let mut place = place.child(violation.quantity);
    if let Some(index) = violation.index {
        place = place.item(index + 1);
    }
    let quantity = declaration.parameters.iter().find(|q| q.name == violation.quantity);
    let unit = quantity.map_or_else(|| "1".to_string(), |quantity| on_axis(quantity.unit));
    let factor = Unit::parse(&unit).unwrap_or(Unit::ONE);
    let shown = measure::shown(factor.from_si(violation.value), &unit);
    let (rule, way_out) = halves(violation.rule);
    checker.report(&place, &shown, rule, way_out);
}

/// Reports an error of the build at its line, unless its cause has been reported: a draft with
/// problems has values put in for wrong ones.
fn report(checker: &mut Checker<'_>, draft: &Draft, error: &BuildError, had_problems: bool) {
    let (place, axis) = locate(draft, &error.place);
    if had_problems {
        let has_gaps = axis.and_then(|axis| draft.axes.get(axis)).is_none_or(|axis| axis.has_gaps);
        let is_structure = axis.is_some_and(|axis| {
            place.key == format!("axis[{}]", axis + 1)
                || draft.axes[axis].components.iter().any(|(known, _)| known.key == place.key)
        });
        if has_gaps || !is_structure {
            return;
        }
    }
    let (rule, way_out) = halves(&error.message);
    checker.report(&place, "", rule, way_out);
}

/// The key of the place that the build names, as in `axis[1].hysteresis.w[3]`, and its axis.
fn locate(draft: &Draft, named: &str) -> (Place, Option<usize>) {
    let place = Place::new(named);
    if let Some(rest) = named.strip_prefix("coupling.") {
        return (locate_coupling(draft, rest).unwrap_or(place), None);
    }
    let Some(rest) = named.strip_prefix("axis[") else { return (place, None) };
    let Some((number, rest)) = rest.split_once(']') else { return (place, None) };
    let Some(axis) = number.parse::<usize>().ok().and_then(|n| n.checked_sub(1)) else {
        return (place, None);
    };
    let (Some(spec), Some(places)) = (draft.spec.axes.get(axis), draft.axes.get(axis)) else {
        return (place, None);
    };
    let rest = rest.strip_prefix('.').unwrap_or(rest);
    let end = rest.find(['.', '[']).unwrap_or(rest.len());
    let (name, tail) = rest.split_at(end);
    let known = spec.components.iter().position(|node| node.name == name);
    match known.and_then(|index| places.components.get(index)) {
        Some((known, _)) => {
            let key = format!("{}{tail}", known.key);
            (Place { key, shown: format!("{}{tail}", known.shown) }, Some(axis))
        }
        None => (place, Some(axis)),
    }
}

/// The key of the place that the build names `coupling.…`.
fn locate_coupling(draft: &Draft, rest: &str) -> Option<Place> {
    let (name, tail) = rest.split_at(rest.find(['.', '[']).unwrap_or(rest.len()));
    let couplings = &draft.spec.connections.couplings;
    let index = couplings.iter().position(|coupling| coupling.node.name == name)?;
    let (known, _) = draft.couplings.get(index)?;
    let join = |text: &str| format!("{text}{tail}");
    Some(Place { key: join(&known.key), shown: join(&known.shown) })
}

/// Rule and way out of a message `rule; way out`.
fn halves(message: &str) -> (&str, &str) {
    message.rsplit_once("; ").unwrap_or((message, ""))
}
