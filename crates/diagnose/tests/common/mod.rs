//! A machine whose truth is known: plays, a mode, a sensor, and one or more effects with formulas that
//! are not those of the library.
#![allow(unreachable_pub, clippy::needless_range_loop, clippy::ptr_arg)]
#![allow(dead_code)]

pub mod machine;
pub mod truth;

use data::Log;
use diagnose::{Gap, Model, Noise, Request, Silent};
use machine::Machine;

/// Diagnoses logs of a machine.
pub fn diagnose_machine(machine: &Machine, logs: Vec<Log>, without: &[&str]) -> Gap {
    let model = Model::Blueprint(Box::new(machine::blueprint()));
    let mut request = Request::new(model, logs);
    request.noise = Noise::Given(vec![(None, machine.sigma)]);
    request.without = without.iter().map(|s| (*s).to_owned()).collect();
    diagnose::diagnose(&request, &mut Silent).unwrap()
}
