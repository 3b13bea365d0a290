//! The spy: an FMU that records what its importer calls.

use std::fs;
use std::path::{Path, PathBuf};

use modeldescription::description::CoSimulation;
use modeldescription::package::{PackageBuilder, Platform};
use modeldescription::structure::Unknown;
use modeldescription::variable::{Causality, DataType, Start, Variability, Variable};
use modeldescription::{FmiVersion, ModelDescription};
use serde_json::Value;

use super::packed::compile_library;

/// Packs the spy into a folder. Its record is where `SPY_RECORD` says when the importer runs.
pub(crate) fn pack(folder: &Path) -> PathBuf {
    let library = folder.join("spy.so");
    compile_library("spy.c", &[], &library);
    let mut description = ModelDescription::new(FmiVersion::V2, "spy", "spy");
    let mut co_simulation = CoSimulation::new("spy");
    co_simulation.can_handle_variable_communication_step_size = true;
    description.co_simulation = Some(co_simulation);
    let real = |name: &str, reference: u32, causality: Causality, start: Option<f64>| {
        let mut variable = Variable::new(name, reference, DataType::Float64);
        variable.causality = causality;
        variable.start = start.map(|value| Start::Float(vec![value]));
        variable
    };
    let mut gain = real("gain", 2, Causality::Parameter, Some(2.0));
    gain.stated_variability = Some(Variability::Fixed);
    description.variables = vec![
        real("u", 0, Causality::Input, Some(0.0)),
        real("y", 1, Causality::Output, None),
        gain,
    ];
    description.structure.outputs = vec![Unknown::new(2)];
    description.structure.initial_unknowns = vec![Unknown::new(2)];
    let mut package = PackageBuilder::new(&description).expect("a valid description");
    let platform = Platform::host().expect("a known platform").folder(FmiVersion::V2);
    let bytes = fs::read(&library).expect("the library");
    package.binary(platform, bytes).expect("one library");
    let file = folder.join("spy.fmu");
    package.write(&file).expect("an FMU");
    file
}

/// The calls in a record, in their order.
pub(crate) fn calls(record: &Path) -> Vec<Value> {
    let text = fs::read_to_string(record).expect("the importer called the spy");
    text.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

/// The calls of one function.
pub(crate) fn of<'a>(calls: &'a [Value], function: &str) -> Vec<&'a Value> {
    calls.iter().filter(|call| call["call"] == function).collect()
}
