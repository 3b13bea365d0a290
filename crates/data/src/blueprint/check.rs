//! The check of a [`Blueprint`]: all problems, or a specification.

use model::Registry;

use super::checker::Checker;
use super::{Blueprint, CheckedBlueprint, build, frame};
use crate::Problems;

pub(super) fn check(
    blueprint: &Blueprint,
    registry: Registry,
) -> Result<CheckedBlueprint, Problems> {
    let mut checker = Checker::new(blueprint, registry);
    let draft = frame::draft(&mut checker);
    let system = build::system(&mut checker, &draft);
    match system {
        Some(system) if checker.problems.is_empty() => Ok(CheckedBlueprint {
            blueprint: blueprint.clone(),
            spec: super::Spec(draft.spec),
            system,
        }),
        _ => Err(Problems::new(checker.problems)),
    }
}
