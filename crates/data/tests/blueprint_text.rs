//! A blueprint that was written is read again as the same.

use std::collections::BTreeMap;

use crate::common::{PLANT, REGISTRY};
use data::{
    AxisBlueprint, Blueprint, ComponentBlueprint, CouplingBlueprint, SignalBlueprint, Value,
};
use model::Kind;
use proptest::prelude::*;

#[test]
fn the_text_is_stable_and_in_order() {
    let blueprint = Blueprint::parse(PLANT, "plant.toml").unwrap();
    let text = blueprint.to_toml();
    assert_eq!(text, PLANT);
    assert_eq!(Blueprint::parse(&text, "again.toml").unwrap(), blueprint);
}

#[test]
fn long_lists_are_folded() {
    let w: Vec<f64> = (1..=40).map(|k| 1.0 / f64::from(k)).collect();
    let component = ComponentBlueprint::new("plays").value("w", &w);
    let axis = AxisBlueprint::new("Y", "V", "um").component(component);
    let blueprint = Blueprint::new(Kind::Plant, "p", 1e-4).axis(axis);
    let text = blueprint.to_toml();
    assert!(text.lines().all(|line| line.len() <= 100), "{text}");
    assert!(text.contains("w = [\n    1, 0.5, 0.3333333333333333, 0.25,"), "{text}");
    assert_eq!(Blueprint::parse(&text, "").unwrap(), blueprint);
}

#[test]
fn a_file_appears_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.toml");
    let blueprint = Blueprint::parse(PLANT, "plant.toml").unwrap();
    blueprint.write(&path).unwrap();
    let again = Blueprint::read(&path).unwrap();
    assert_eq!(again, blueprint);
    assert!(again.check(REGISTRY).is_ok());
    let error = blueprint.write(&folder.path().join("no/plant.toml")).unwrap_err().to_string();
    assert!(error.contains("plant.toml: cannot be written: "), "{error}");
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>().prop_filter("no NaN is equal to itself", |x| !x.is_nan()),
        (-1000i32..1000).prop_map(f64::from),
        Just(-0.0),
        Just(9_007_199_254_740_993.0),
    ]
}

fn value() -> impl Strategy<Value = Value> {
    let one = prop_oneof![number().prop_map(Value::Number), any::<String>().prop_map(Value::Text)];
    prop_oneof![one.clone(), prop::collection::vec(one, 0..40).prop_map(Value::List)]
}

fn quantity() -> impl Strategy<Value = String> {
    let used = ["type", "name", "note", "enabled", "tolerance", "axes", "after"];
    any::<String>().prop_filter("keys of their own", move |name| !used.contains(&name.as_str()))
}

prop_compose! {
    fn signal()(
        name in any::<String>(),
        unit in any::<String>(),
        min in prop::option::of(value()),
        max in prop::option::of(value()),
        start in prop::option::of(value()),
    ) -> SignalBlueprint {
        SignalBlueprint { name, unit, min, max, start }
    }
}

prop_compose! {
    fn component()(
        kind in any::<String>(),
        name in any::<String>(),
        enabled in any::<bool>(),
        values in prop::collection::btree_map(quantity(), value(), 0..5),
        tolerance in prop::collection::btree_map(any::<String>(), number(), 0..3),
        note in any::<String>(),
    ) -> ComponentBlueprint {
        let values = values.into_iter().collect();
        ComponentBlueprint { kind, name, enabled, values, tolerance, note }
    }
}

prop_compose! {
    fn axis()(
        name in any::<String>(),
        signals in (signal(), signal(), signal(), signal()),
        more in (signal(), signal(), signal()),
        components in prop::collection::vec(component(), 0..4),
    ) -> AxisBlueprint {
        let (command, position, reference, measured) = signals;
        let (force, disturbance, motion) = more;
        AxisBlueprint {
            name, command, position, reference, measured, force, disturbance, motion, components,
        }
    }
}

prop_compose! {
    fn coupling()(
        component in component(),
        axes in prop::collection::vec(any::<String>(), 0..4),
        after in any::<String>(),
    ) -> CouplingBlueprint {
        CouplingBlueprint { component, axes, after }
    }
}

prop_compose! {
    fn blueprint()(
        is_plant in any::<bool>(),
        texts in (any::<String>(), any::<String>(), any::<String>()),
        step in value(),
        axes in prop::collection::vec(axis(), 0..3),
        temperature in signal(),
        couplings in prop::collection::vec(coupling(), 0..3),
    ) -> Blueprint {
        let kind = if is_plant { Kind::Plant } else { Kind::Controller };
        let mut blueprint = Blueprint::new(kind, &texts.0, 0.0);
        (blueprint.description, blueprint.source) = (texts.1, texts.2);
        (blueprint.step, blueprint.axes) = (step, axes);
        (blueprint.temperature, blueprint.couplings) = (temperature, couplings);
        blueprint
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_again_equal(blueprint in blueprint()) {
        let text = blueprint.to_toml();
        let again = Blueprint::parse(&text, "again.toml").unwrap();
        prop_assert_eq!(&again, &blueprint);
        prop_assert_eq!(again.to_toml(), text);
    }

    /// Whatever stands in a file, the check answers.
    #[test]
    fn no_blueprint_makes_the_check_fall(blueprint in blueprint()) {
        let _ = blueprint.check(REGISTRY);
    }

    #[test]
    fn no_text_makes_the_reader_fall(
        text in "(\\[\\[axis\\]\\]|\\[\\[axis.component\\]\\]|\n|type = \"plays\"|r = |w = |\\[|\\]|1|,|\"|[ -~]){0,60}",
    ) {
        if let Ok(blueprint) = Blueprint::parse(&text, "any.toml") {
            let _ = blueprint.check(REGISTRY);
        }
    }
}

/// The bits of a number survive, its sign too.
#[test]
fn numbers_keep_their_bits() {
    for number in [-0.0, 1e-310, f64::MAX, f64::MIN_POSITIVE, 1e15 + 0.5, 2f64.powi(53), 1e22] {
        let component = ComponentBlueprint {
            tolerance: BTreeMap::from([("w".to_string(), number)]),
            ..ComponentBlueprint::new("plays").value("w", number)
        };
        let axis = AxisBlueprint::default().component(component);
        let blueprint = Blueprint::new(Kind::Plant, "p", number).axis(axis);
        let again = Blueprint::parse(&blueprint.to_toml(), "").unwrap();
        let component = &again.axes[0].components[0];
        let Some(Value::Number(found)) = component.get("w") else { panic!("{again:?}") };
        assert_eq!(found.to_bits(), number.to_bits());
        assert_eq!(component.tolerance["w"].to_bits(), number.to_bits());
    }
}
