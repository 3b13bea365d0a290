//! A machine whose truth is known: plays, a mode, a sensor, and one or more effects with formulas that
//! are not those of the library.
#![allow(unreachable_pub, clippy::needless_range_loop, clippy::ptr_arg)]
#![allow(dead_code)]

pub mod machine;
pub mod truth;

use data::{CheckedBlueprint, Log};
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

/// The positions of a plant under a command from rest under the first one, one per row.
pub fn positions(plant: &CheckedBlueprint, commands: &[f64], step: f64) -> Vec<f64> {
    let mut system = plant.build();
    let variables = system.variables();
    let (u, y) = (variables.find("command[1]").unwrap(), variables.find("position[1]").unwrap());
    system.set(u, commands[0]).unwrap();
    system.initialise(0.0).unwrap();
    let mut all = Vec::new();
    for (n, command) in commands.iter().enumerate() {
        all.push(system.get(y).unwrap());
        system.set(u, *command).unwrap();
        system.advance((n + 1) as f64 * step).unwrap();
    }
    all
}
