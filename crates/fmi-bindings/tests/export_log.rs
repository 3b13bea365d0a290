//! Messages: environment, name, category, escapes, panics.

use std::ffi::{CStr, c_char};

use crate::support::{Arguments, Fmu, plant};
use fmi_bindings::export::{LOG_CATEGORIES, v2};
use fmi_bindings::fmi2::*;

fn logging(on: fmi2Boolean) -> Fmu {
    Fmu::with(plant, Arguments { logging_on: on, ..Arguments::of(plant) })
}

fn set(fmu: &Fmu, on: fmi2Boolean, categories: &[&CStr]) -> fmi2Status {
    let pointers: Vec<*const c_char> = categories.iter().map(|c| c.as_ptr()).collect();
    unsafe { v2::fmi2SetDebugLogging(fmu.c, on, pointers.len(), pointers.as_ptr()) }
}

#[test]
fn with_logging_on_events_are_reported() {
    let fmu = logging(fmi2True);
    fmu.start(0.5);
    fmu.terminate();
    fmu.reset();
    let messages = fmu.messages();
    let texts: Vec<_> = messages.iter().map(|s| s.format.as_str()).collect();
    assert!(texts[0].contains("model \"stage\""), "{texts:?}");
    assert!(texts[1].contains("initialised at 0.5 s"), "{texts:?}");
    assert_eq!(texts.len(), 4, "{texts:?}");
    for messages in &messages {
        assert_eq!((messages.status, messages.category.as_str()), (fmi2OK, "logEvents"));
        assert_eq!(messages.environment, (&raw const *fmu.recorder) as usize);
        assert_eq!(messages.name, "it");
    }
}

#[test]
fn with_logging_off_only_failures_are_reported() {
    let fmu = logging(fmi2False);
    fmu.start(0.0);
    assert!(fmu.messages().is_empty());
    fmu.step(9.0, 1.0);
    assert_eq!(fmu.messages()[0].category, "logStatusError");
    assert_eq!(fmu.messages()[0].status, fmi2Error);
}

#[test]
fn only_the_categories_that_were_chosen_go_out() {
    let fmu = logging(fmi2False);
    assert_eq!(set(&fmu, fmi2True, &[c"logEvents"]), fmi2OK);
    fmu.start(0.0);
    fmu.step(9.0, 1.0);
    assert_eq!(fmu.messages().len(), 1, "{:?}", fmu.messages());
    assert_eq!(set(&fmu, fmi2True, &[c"logStatusError", c"logStatusWarning"]), fmi2OK);
    fmu.step(9.0, 1.0);
    assert_eq!(fmu.messages().len(), 2);
    assert_eq!(set(&fmu, fmi2True, &[]), fmi2OK);
    fmu.reset();
    assert_eq!(fmu.messages().len(), 3);
}

#[test]
fn an_unknown_category_is_a_warning_that_names_the_known_ones() {
    let fmu = logging(fmi2True);
    assert_eq!(set(&fmu, fmi2True, &[c"logStatusWarning", c"logNonsense"]), fmi2Warning);
    for (name, _) in LOG_CATEGORIES {
        assert!(fmu.last().contains(name), "{}", fmu.last());
    }
    assert!(fmu.last().contains("logNonsense"));
    fmu.start(0.0);
}

#[test]
fn every_category_that_is_used_is_declared() {
    let fmu = logging(fmi2True);
    fmu.enter();
    fmu.exit();
    unsafe { v2::fmi2GetStatus(fmu.c, fmi2DoStepStatus, std::ptr::null_mut()) };
    fmu.step(9.0, 1.0);
    let mut used: Vec<_> = fmu.messages().into_iter().map(|s| s.category).collect();
    used.sort();
    used.dedup();
    let mut declared: Vec<_> = LOG_CATEGORIES.iter().map(|(n, _)| (*n).to_string()).collect();
    declared.retain(|name| name != "logAll");
    declared.sort();
    assert_eq!(used, declared);
}

#[test]
fn a_panic_is_an_error_and_the_instance_can_be_reset_and_freed() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("axis[1].lag.fault", 2.0);
    assert_eq!(fmu.step(0.0, 1e-3), fmi2Error);
    let text = fmu.last();
    assert!(text.starts_with("fmi2DoStep: internal defect"), "{text}");
    assert!(text.contains("a fault on 100%% purpose"), "{text}");
    assert_eq!(fmu.step(0.0, 1e-3), fmi2Error);
    assert_eq!(fmu.reset(), fmi2OK);
    fmu.start(0.0);
    assert_eq!(fmu.step(0.0, 1e-3), fmi2OK);
}
