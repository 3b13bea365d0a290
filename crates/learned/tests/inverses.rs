//! The pairs that components declare: forward and inverse, by the names of their parameters.

use learned::COMPONENTS;
use model::{Conversion, Stage, Undoing};

#[test]
fn an_inverse_has_the_parameters_of_what_it_undoes() {
    let mut pairs = 0;
    for component in COMPONENTS {
        let forward = component.declaration();
        for inverse in component.inverses() {
            pairs += 1;
            let place = format!("{} by {}", forward.kind, inverse.kind);
            let found = COMPONENTS.iter().map(|c| c.declaration()).find(|d| d.kind == inverse.kind);
            let found = found.unwrap_or_else(|| panic!("{place}: there is none"));
            assert_eq!(found.stage, Stage::Control, "{place}");
            let turned = match forward.conversion {
                Conversion::CommandToPosition => Conversion::PositionToCommand,
                other => other,
            };
            assert_eq!(found.conversion, turned, "{place}");
            if inverse.undoing == Undoing::Learned {
                continue;
            }
            for quantity in found.parameters {
                let bounds = ["command_min", "command_max"].contains(&quantity.name);
                let own = forward.parameters.iter().any(|q| q.name == quantity.name);
                assert!(
                    bounds || own || quantity.start.is_some(),
                    "{place}: {} must be given, and nothing says how",
                    quantity.name
                );
            }
        }
    }
    assert!(pairs >= 14, "{pairs} pairs");
}

#[test]
fn every_inverse_of_the_registry_undoes_something() {
    let declared: Vec<&str> =
        COMPONENTS.iter().flat_map(|c| c.inverses()).map(|inverse| inverse.kind).collect();
    for component in components::COMPONENTS {
        let kind = component.declaration().kind;
        if kind.starts_with("inverse-") {
            assert!(declared.contains(&kind), "{kind} is the inverse of nothing");
        }
    }
}
