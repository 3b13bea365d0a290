//! The answer's form, its determinism, the repair, and what is refused.

use crate::common::machine::{Machine, blueprint};
use crate::common::truth::Effect;
use components::COMPONENTS;
use data::{Blueprint, Log};
use diagnose::{Error, Files, Model, Noise, Request, Silent, diagnose, examine};

fn request(machine: &Machine, logs: Vec<Log>) -> Request {
    let mut request = Request::new(Model::Blueprint(Box::new(blueprint())), logs);
    request.noise = Noise::Given(vec![(None, machine.sigma)]);
    request
}

#[test]
fn threads_do_not_change_a_byte() {
    let machine = Machine::new(31, 1.0).with(Effect::Creep, 6.0);
    let answer = |threads: usize| {
        let mut request = request(&machine, machine.logs());
        request.threads = threads;
        serde_json::to_string(&diagnose(&request, &mut Silent).unwrap()).unwrap()
    };
    assert_eq!(answer(1), answer(3));
}

#[test]
fn the_repaired_blueprint_no_longer_lacks_the_effect() {
    let machine = Machine::new(32, 1.0).with(Effect::Creep, 10.0);
    let mut first = examine(&request(&machine, machine.logs()), &mut Silent).unwrap();
    assert_eq!(first.gap.effects[0].effect, "creep");
    let repaired: Blueprint = first.repair(blueprint().blueprint()).0;
    let text = repaired.to_toml();
    assert!(text.contains("kelvin-voigt-creep"), "{text}");
    let checked = repaired.check(COMPONENTS).unwrap();
    let mut again = request(&machine, machine.logs());
    again.model = Model::Blueprint(Box::new(checked));
    let second = diagnose(&again, &mut Silent).unwrap();
    assert!(second.shrink.rms_as_given < 1.1 * first.gap.shrink.rms_after, "{}", second.sentence);
    assert!(second.effects.is_empty(), "{}", second.sentence);
}

#[test]
fn the_page_has_the_sentence_and_the_candidates() {
    let machine = Machine::new(33, 1.0).with(Effect::MainsHum, 6.0);
    let diagnosis = examine(&request(&machine, machine.logs()), &mut Silent).unwrap();
    let page = diagnosis.report(&Files::default()).to_html().unwrap();
    assert!(page.contains("mains hum"), "the sentence names it");
    assert!(page.contains("All candidates as the first effect"));
}

#[test]
fn the_answer_has_the_fields_of_its_schema() {
    let machine = Machine::new(34, 1.0).with(Effect::Delay, 6.0);
    let gap = diagnose(&request(&machine, machine.logs()), &mut Silent).unwrap();
    let value = serde_json::to_value(&gap).unwrap();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/gap.schema.json");
    let schema: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let mut errors = Vec::new();
    conforms(&schema, &schema, &value, "gap", &mut errors);
    assert!(errors.is_empty(), "{errors:#?}");
}

/// The part of JSON Schema that the schema uses.
fn conforms(
    root: &serde_json::Value,
    schema: &serde_json::Value,
    value: &serde_json::Value,
    place: &str,
    errors: &mut Vec<String>,
) {
    if let Some(name) = schema["$ref"].as_str() {
        let part = name.trim_start_matches("#/$defs/");
        return conforms(root, &root["$defs"][part], value, place, errors);
    }
    if let Some(any) = schema["anyOf"].as_array() {
        let fits = any.iter().any(|option| {
            let mut own = Vec::new();
            conforms(root, option, value, place, &mut own);
            own.is_empty()
        });
        if !fits {
            errors.push(format!("{place}: fits no option"));
        }
        return;
    }
    let kind = match value {
        serde_json::Value::Null => "null",
        serde_json::Value::Bool(_) => "boolean",
        serde_json::Value::Number(_) => "number",
        serde_json::Value::String(_) => "string",
        serde_json::Value::Array(_) => "array",
        serde_json::Value::Object(_) => "object",
    };
    let takes = |name: &str| name == kind || (name == "integer" && value.is_u64());
    let is_fit = match &schema["type"] {
        serde_json::Value::String(name) => takes(name),
        serde_json::Value::Array(names) => names.iter().filter_map(|n| n.as_str()).any(takes),
        _ => true,
    };
    if !is_fit {
        errors.push(format!("{place}: {kind} is not {}", schema["type"]));
    }
    if let Some(all) = schema["enum"].as_array()
        && !all.contains(value)
    {
        errors.push(format!("{place}: {value} is none of {all:?}"));
    }
    // As the standard has it, of objects only: what may be null has no fields then.
    for name in schema["required"].as_array().into_iter().flatten().filter_map(|n| n.as_str()) {
        if value.is_object() && value.get(name).is_none() {
            errors.push(format!("{place}.{name} is missing"));
        }
    }
    for (name, part) in value.as_object().into_iter().flatten() {
        let own = schema["properties"].get(name).or_else(|| schema.get("additionalProperties"));
        match own {
            Some(own) => conforms(root, own, part, &format!("{place}.{name}"), errors),
            None => errors.push(format!("{place}.{name} is not in the schema")),
        }
    }
    if let Some(item) = schema.get("items") {
        for (k, part) in value.as_array().into_iter().flatten().enumerate() {
            conforms(root, item, part, &format!("{place}[{k}]"), errors);
        }
    }
}

#[test]
fn refusals_name_the_thing_and_the_way_out() {
    let machine = Machine::new(35, 0.0);
    let mut wrong = request(&machine, machine.logs());
    wrong.without = vec!["crep".to_owned()];
    let message = diagnose(&wrong, &mut Silent).unwrap_err().to_string();
    assert!(
        message.contains("--without crep") && message.contains("did you mean creep"),
        "{message}"
    );

    let mut wrong = request(&machine, machine.logs());
    wrong.outputs = vec!["z".to_owned()];
    let message = diagnose(&wrong, &mut Silent).unwrap_err().to_string();
    assert!(message.contains("--outputs z") && message.contains('y'), "{message}");

    let mut log = Log::new("a.csv", (0..100).map(f64::from).collect()).unwrap();
    log.add_column("speed", None, vec![0.0; 100]).unwrap();
    let error = diagnose(&request(&machine, vec![log]), &mut Silent).unwrap_err();
    assert!(matches!(error, Error::Log { .. }));
    let message = error.to_string();
    assert!(message.contains("a.csv") && message.contains("--map y=COLUMN"), "{message}");
}
