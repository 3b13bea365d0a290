//! Root element, interface types, log categories, default experiment.

use super::{Checker, repeated};
use crate::description::{CoSimulation, DefaultExperiment, FmiVersion, Interface};
use crate::problem::Topic;

pub(super) fn check(checker: &mut Checker<'_>) {
    token(checker);
    generation_time(checker);
    interfaces(checker);
    log_categories(checker);
    if let Some(experiment) = &checker.description.default_experiment {
        default_experiment(checker, experiment);
    }
}

fn token(checker: &mut Checker<'_>) {
    let line = checker.description.line;
    if checker.description.instantiation_token.is_empty() {
        let name = match checker.version {
            FmiVersion::V2 => "guid",
            FmiVersion::V3 => "instantiationToken",
        };
        checker.error(
            Topic::Root,
            line,
            format!("{name} is missing or empty"),
            "it shows whether description and binary belong together",
            "derive it from the variables",
        );
    }
}

fn generation_time(checker: &mut Checker<'_>) {
    let line = checker.description.line;
    let Some(time) = &checker.description.generation_date_and_time else { return };
    let found = format!("generationDateAndTime=\"{time}\"");
    let way_out = "write it as 2009-12-08T14:33:22Z";
    match date_time(time) {
        DateTime::AsTheStandardWants => {}
        DateTime::Other => checker.warning(
            Topic::Root,
            line,
            found,
            "the format should be YYYY-MM-DDThh:mm:ssZ, in UTC, without fractions",
            way_out,
        ),
        DateTime::None => {
            checker.error(Topic::Root, line, found, "it must be an xs:dateTime", way_out);
        }
    }
}

enum DateTime {
    AsTheStandardWants,
    /// Valid as `xs:dateTime`: with fractions, an offset or no zone.
    Other,
    None,
}

fn date_time(text: &str) -> DateTime {
    let Some((head, tail)) = text.split_at_checked(19) else { return DateTime::None };
    if !is_instant(head) {
        return DateTime::None;
    }
    if tail == "Z" {
        return DateTime::AsTheStandardWants;
    }
    let after_fraction = match tail.strip_prefix('.') {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => {
            rest.trim_start_matches(|c: char| c.is_ascii_digit())
        }
        Some(_) => return DateTime::None,
        None => tail,
    };
    let is_zone = match after_fraction.split_at_checked(1) {
        None => true,
        Some(("Z", "")) => true,
        Some(("+" | "-", offset)) => is_offset(offset),
        Some(_) => false,
    };
    if is_zone { DateTime::Other } else { DateTime::None }
}

/// `YYYY-MM-DDThh:mm:ss` of a day that exists.
fn is_instant(text: &str) -> bool {
    let shape = text.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).collect::<String>();
    if shape != "0000-00-00T00:00:00" {
        return false;
    }
    let number = |from: usize, to: usize| text.get(from..to).and_then(|t| t.parse::<u32>().ok());
    let (Some(year), Some(month), Some(day)) = (number(0, 4), number(5, 7), number(8, 10)) else {
        return false;
    };
    let leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let days = match month {
        2 if leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return false,
    };
    let below = |from, to, limit| number(from, to).is_some_and(|value| value < limit);
    (1..=days).contains(&day) && below(11, 13, 24) && below(14, 16, 60) && below(17, 19, 60)
}

/// `hh:mm` up to 14:00.
fn is_offset(text: &str) -> bool {
    match text.split_once(':') {
        Some((hours, minutes)) if hours.len() == 2 && minutes.len() == 2 => {
            let number = |text: &str| text.parse::<u32>().unwrap_or(u32::MAX);
            number(minutes) < 60 && (number(hours) < 14 || (hours == "14" && minutes == "00"))
        }
        _ => false,
    }
}

fn interfaces(checker: &mut Checker<'_>) {
    let description = checker.description;
    let line = description.line;
    if description.interfaces().next().is_none() {
        let rule = match checker.version {
            FmiVersion::V2 => "ModelExchange or CoSimulation must be present",
            FmiVersion::V3 => "ModelExchange, CoSimulation or ScheduledExecution must be present",
        };
        checker.error(
            Topic::Root,
            line,
            "the FMU offers no interface type".to_owned(),
            rule,
            "add the element",
        );
    }
    for (element, interface) in description.interfaces() {
        let topic = match element {
            "CoSimulation" => Topic::CoSimulation,
            "ModelExchange" => Topic::ModelExchange,
            _ => Topic::ScheduledExecution,
        };
        common(checker, topic, interface);
    }
    if let Some(co_simulation) = &description.co_simulation {
        co_simulation_flags(checker, co_simulation);
    }
}

fn common(checker: &mut Checker<'_>, topic: Topic, interface: &Interface) {
    let identifier = &interface.model_identifier;
    if !is_c_identifier(identifier) {
        checker.error(
            topic,
            interface.line,
            format!("modelIdentifier=\"{identifier}\""),
            "it must be a C identifier: letters, digits and _, not starting with a digit",
            "rename the model and its library",
        );
    }
    if interface.can_serialize_fmu_state && !interface.can_get_and_set_fmu_state {
        checker.error(
            topic,
            interface.line,
            "the FMU state can be serialised, but not got and set".to_owned(),
            "canSerialize… requires canGetAndSet…",
            "offer both or neither",
        );
    }
}

/// Letters, digits and underscores, not starting with a digit.
pub(super) fn is_c_identifier(text: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    text.starts_with(is_letter) && text.chars().all(|c| is_letter(c) || c.is_ascii_digit())
}

fn co_simulation_flags(checker: &mut Checker<'_>, cs: &CoSimulation) {
    let line = cs.common.line;
    if let Some(step) = cs.fixed_internal_step_size.filter(|step| !is_positive(*step)) {
        checker.error(
            Topic::CoSimulation,
            line,
            format!("fixedInternalStepSize=\"{step}\""),
            "it must be positive",
            "give the step in s",
        );
    }
    if cs.can_return_early_after_intermediate_update && !cs.provides_intermediate_update {
        checker.error(
            Topic::CoSimulation,
            line,
            "canReturnEarlyAfterIntermediateUpdate without providesIntermediateUpdate".to_owned(),
            "the importer asks for the early return inside an intermediate update",
            "offer both or neither",
        );
    }
}

fn is_positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn log_categories(checker: &mut Checker<'_>) {
    let categories = &checker.description.log_categories;
    for (again, first) in repeated(categories, |category| category.name.as_str()) {
        checker.error(
            Topic::LogCategories,
            again.line,
            format!(
                "log category \"{}\" is there twice, first at line {}",
                again.name, first.line.0
            ),
            "names must be unique",
            "remove or rename one",
        );
    }
    for category in categories.iter().filter(|category| category.name.is_empty()) {
        checker.error(
            Topic::LogCategories,
            category.line,
            "a log category has an empty name".to_owned(),
            "it is switched on by its name",
            "name it",
        );
    }
}

fn default_experiment(checker: &mut Checker<'_>, experiment: &DefaultExperiment) {
    let topic = Topic::DefaultExperiment;
    let times = [("startTime", experiment.start_time), ("stopTime", experiment.stop_time)];
    for (name, value) in times {
        if let Some(value) = value.filter(|value| !value.is_finite()) {
            let found = format!("{name}=\"{value}\"");
            checker.error(topic, experiment.line, found, "it must be finite", "give a time in s");
        }
    }
    let positive = [("stepSize", experiment.step_size), ("tolerance", experiment.tolerance)];
    for (name, value) in positive {
        if let Some(value) = value.filter(|value| !is_positive(*value)) {
            let found = format!("{name}=\"{value}\"");
            let way_out = "correct it or leave it out";
            checker.error(topic, experiment.line, found, "it must be positive", way_out);
        }
    }
    let start = experiment.start_time.unwrap_or(0.0);
    if let Some(stop) = experiment.stop_time.filter(|stop| *stop < start) {
        checker.error(
            topic,
            experiment.line,
            format!("stopTime=\"{stop}\" is before startTime=\"{start}\""),
            "a run ends after it starts",
            "correct one of them",
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_stamps() {
        let is_wanted = |text| matches!(date_time(text), DateTime::AsTheStandardWants);
        let is_other = |text| matches!(date_time(text), DateTime::Other);
        assert!(is_wanted("2009-12-08T14:33:22Z") && is_wanted("2024-02-29T00:00:00Z"));
        for text in [
            "2026-11-21T00:00:00.123456789+00:00",
            "2026-11-21T00:00:00",
            "2026-11-21T00:00:00-14:00",
            "2026-11-21T00:00:00.5Z",
        ] {
            assert!(is_other(text), "{text}");
        }
        for text in [
            "",
            "2026-11-21",
            "2026-11-21 00:00:00Z",
            "2023-02-29T00:00:00Z",
            "2026-13-01T00:00:00Z",
            "2026-01-01T24:00:01Z",
            "2026-01-01T00:00:00.Z",
            "2026-01-01T00:00:00+1:00",
            "2026-01-01T00:00:00ZZ",
            "Sat Nov 21 00:00:00 2026",
            "2026-11-2\u{e9}T00:00:00Z",
        ] {
            assert!(!is_wanted(text) && !is_other(text), "{text}");
        }
    }

    #[test]
    fn c_identifiers() {
        assert!(["a", "_", "A_1", "_9"].into_iter().all(is_c_identifier));
        assert!(!["", "1a", "a-b", "a b", "ü", "a.b"].into_iter().any(is_c_identifier));
    }
}
