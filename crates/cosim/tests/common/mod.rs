//! Test FMUs: C sources of `tests/fmus`, compiled by the system's C compiler and packed.
#![allow(dead_code, unreachable_pub, unused_macros)]

use std::path::{Path, PathBuf};
use std::process::Command;

use cosim::{Fmu, InstanceOptions, Slave};
use modeldescription::description::{BaseUnit, CoSimulation, LogCategory, Unit};
use modeldescription::package::Platform;
use modeldescription::structure::Unknown;
use modeldescription::variable::{
    Causality, ClockProperties, DataType, Dimension, Initial, Number, Start, Variability, Variable,
};
use modeldescription::{FmiVersion, ModelDescription, PackageBuilder};

/// A folder with packed test FMUs; removed when dropped.
pub struct Fmus {
    folder: tempfile::TempDir,
}

/// Returns from a test, with a line, where no C compiler is.
#[macro_export]
macro_rules! fmus_or_skip {
    () => {
        match $crate::common::Fmus::new() {
            Some(fmus) => fmus,
            None => {
                println!("SKIPPED: no C compiler `cc`");
                return;
            }
        }
    };
}

impl Fmus {
    pub fn new() -> Option<Self> {
        Command::new("cc").arg("--version").output().ok()?;
        Some(Fmus { folder: tempfile::tempdir().expect("a temporary folder") })
    }

    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    /// Compiles a source of `tests/fmus` and packs it with a description.
    pub fn pack(&self, source: &str, description: &ModelDescription) -> PathBuf {
        let library = std::fs::read(self.compile(source)).expect("the library");
        let version = description.fmi_version;
        let platform = Platform::host().expect("a known platform").folder(version);
        let mut builder = PackageBuilder::new(description).expect("a valid description");
        builder.binary(platform, library).expect("one binary");
        let fmu = self.path(&format!("{source} é.fmu"));
        builder.write(&fmu).expect("a written package");
        fmu
    }

    pub fn compile(&self, source: &str) -> PathBuf {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fmus");
        let library = self.path(&format!("{source}.so"));
        let output = Command::new("cc")
            .args(["-std=c11", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-o"])
            .args([&library, &sources.join(format!("{source}.c"))])
            .output()
            .expect("the C compiler runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        library
    }

    pub fn integrator(&self) -> Fmu {
        Fmu::open(self.pack("integrator", &integrator())).expect("it opens")
    }

    pub fn controller(&self) -> Fmu {
        Fmu::open(self.pack("controller", &controller())).expect("it opens")
    }
}

pub fn instance(fmu: &Fmu, name: &str) -> Box<dyn Slave> {
    fmu.instantiate(name, &InstanceOptions::default()).expect("an instance")
}

fn variable(name: &str, reference: u32, data_type: DataType, causality: Causality) -> Variable {
    let mut variable = Variable::new(name, reference, data_type);
    variable.causality = causality;
    let discrete = !data_type.is_float();
    match causality {
        Causality::Parameter => variable.stated_variability = Some(Variability::Fixed),
        _ if discrete => variable.stated_variability = Some(Variability::Discrete),
        _ => {}
    }
    if matches!(causality, Causality::Parameter | Causality::Input) {
        variable.start = Some(match data_type {
            DataType::Boolean => Start::Boolean(vec![true]),
            DataType::Int32 => Start::Integer(vec![0]),
            DataType::String => Start::Text(vec![String::new()]),
            _ => Start::Float(vec![0.0]),
        });
    }
    variable
}

pub fn real(name: &str, reference: u32, causality: Causality, unit: Option<&str>) -> Variable {
    let mut variable = variable(name, reference, DataType::Float64, causality);
    variable.properties.unit = unit.map(str::to_owned);
    variable
}

fn described(identifier: &str, variables: Vec<Variable>) -> ModelDescription {
    let mut description = ModelDescription::new(FmiVersion::V2, identifier, identifier);
    let mut co_simulation = CoSimulation::new(identifier);
    co_simulation.can_handle_variable_communication_step_size = true;
    co_simulation.common.can_get_and_set_fmu_state = identifier != "bare";
    co_simulation.common.can_serialize_fmu_state = identifier != "bare";
    description.co_simulation = Some(co_simulation);
    description.log_categories = vec![LogCategory {
        name: "logStatus".to_owned(),
        description: None,
        line: Default::default(),
    }];
    let length = BaseUnit { m: 1, ..BaseUnit::default() };
    let volt = BaseUnit { kg: 1, m: 2, s: -3, a: -1, ..BaseUnit::default() };
    description.units =
        vec![unit("m", length), unit("um", BaseUnit { factor: 1e-6, ..length }), unit("V", volt)];
    let outputs = variables.iter().enumerate().filter(|(_, v)| v.causality == Causality::Output);
    let outputs: Vec<Unknown> = outputs.map(|(i, _)| Unknown::new(i as u32 + 1)).collect();
    description.structure.initial_unknowns.clone_from(&outputs);
    description.structure.outputs = outputs;
    description.variables = variables;
    description
}

pub fn unit(name: &str, base: BaseUnit) -> Unit {
    Unit {
        name: name.to_owned(),
        base: Some(base),
        display_units: Vec::new(),
        line: Default::default(),
    }
}

/// `integrator.c` as a plant: `position[1]' = k · command[1]`.
pub fn integrator() -> ModelDescription {
    use Causality::{Input, Local, Output, Parameter};
    let mut k = real("k", 2, Parameter, None);
    k.stated_variability = Some(Variability::Tunable);
    k.start = Some(Start::Float(vec![1.0]));
    let mut limit = real("limit", 3, Parameter, None);
    limit.start = Some(Start::Float(vec![1e300]));
    let mut end = real("end", 4, Parameter, None);
    end.start = Some(Start::Float(vec![1e300]));
    let mut history = variable("history", 1, DataType::String, Local);
    history.stated_initial = Some(Initial::Calculated);
    described(
        "integrator",
        vec![
            real("command[1]", 0, Input, Some("V")),
            real("position[1]", 1, Output, Some("um")),
            k,
            limit,
            end,
            variable("steps", 0, DataType::Int32, Output),
            variable("misbehaviour", 1, DataType::Int32, Input),
            variable("enabled", 0, DataType::Boolean, Input),
            variable("label", 0, DataType::String, Parameter),
            history,
        ],
    )
}

/// `controller.c`: `command[1] = k · (reference[1] − measured[1])`.
pub fn controller() -> ModelDescription {
    use Causality::{Input, Output, Parameter};
    let mut k = real("k", 3, Parameter, None);
    k.start = Some(Start::Float(vec![1.0]));
    described(
        "controller",
        vec![
            real("reference[1]", 0, Input, Some("um")),
            real("measured[1]", 1, Input, Some("um")),
            real("command[1]", 2, Output, Some("V")),
            k,
        ],
    )
}

/// `integrator3.c`: `position' = k · command`, of FMI 3.0, with a variable of every type.
pub fn integrator3() -> ModelDescription {
    use Causality::{Input, Output, Parameter};
    let mut k = real("k", 3, Parameter, None);
    k.start = Some(Start::Float(vec![1.0]));
    let number = |name: &str, reference: u32, data_type: DataType| {
        let mut variable = variable(name, reference, data_type, Input);
        if data_type.integer_range(FmiVersion::V3).is_some() {
            variable.start = Some(Start::Integer(vec![0]));
        }
        variable
    };
    let array = |name: &str, reference: u32, causality: Causality, start: &[f64]| {
        let mut array = real(name, reference, causality, None);
        array.dimensions = vec![Dimension::Size(3)];
        array.start = Some(Start::Float(start.to_vec())).filter(|start| !start.is_empty());
        array
    };
    let mut description = described(
        "integrator3",
        vec![
            real("command[1]", 1, Input, Some("V")),
            real("position[1]", 2, Output, Some("um")),
            k,
            variable("label", 4, DataType::String, Parameter),
            number("f32", 10, DataType::Float32),
            number("i8", 11, DataType::Int8),
            number("u8", 12, DataType::UInt8),
            number("i16", 13, DataType::Int16),
            number("u16", 14, DataType::UInt16),
            number("i32", 15, DataType::Int32),
            number("u32", 16, DataType::UInt32),
            number("i64", 17, DataType::Int64),
            number("u64", 18, DataType::UInt64),
            number("boolean", 19, DataType::Boolean),
            array("u", 30, Input, &[1.0, 2.0, 3.0]),
            array("y", 31, Output, &[]),
        ],
    );
    description.fmi_version = FmiVersion::V3;
    let outputs = vec![Unknown::new(2), Unknown::new(31)];
    description.structure.initial_unknowns.clone_from(&outputs);
    description.structure.outputs = outputs;
    description
}

/// `bare.c`: `y = 2 · u`.
pub fn bare() -> ModelDescription {
    described(
        "bare",
        vec![real("u", 0, Causality::Input, None), real("y", 1, Causality::Output, None)],
    )
}

/// `stranger.c`, an FMU of both versions that calls the logger with foreign pointers: `y = 2 · u`.
pub fn stranger(version: FmiVersion) -> ModelDescription {
    let mut description = described(
        "stranger",
        vec![real("u", 0, Causality::Input, None), real("y", 1, Causality::Output, None)],
    );
    description.fmi_version = version;
    if version == FmiVersion::V3 {
        description.structure.outputs = vec![Unknown::new(1)];
        description.structure.initial_unknowns = vec![Unknown::new(1)];
    }
    description
}

/// `events3.c`: event mode, clocks of every kind, time and state event, structural parameter.
pub fn events3() -> ModelDescription {
    use Causality::{Input, Output, Parameter, StructuralParameter};
    let clock = |name: &str, reference: u32, causality: Causality, kind: &str| {
        let mut clock = Variable::new(name, reference, DataType::Clock);
        clock.causality = causality;
        clock.stated_variability = Some(Variability::Discrete);
        let properties = ClockProperties {
            interval_variability: Some(kind.to_owned()),
            interval_decimal: (kind == "constant").then_some(0.25),
            shift_decimal: (kind == "constant").then_some(0.1),
            ..ClockProperties::default()
        };
        clock.properties.clock = Some(Box::new(properties));
        clock
    };
    let integer = |name: &str, reference: u32, data_type: DataType, causality: Causality| {
        let mut integer = variable(name, reference, data_type, causality);
        let has_start = matches!(causality, Input | Parameter | StructuralParameter);
        integer.start = has_start.then(|| Start::Integer(vec![0]));
        integer
    };
    let array = |name: &str, reference: u32, causality: Causality, start: &[f64]| {
        let mut array = real(name, reference, causality, None);
        array.dimensions = vec![Dimension::Parameter(40)];
        array.start = Some(Start::Float(start.to_vec())).filter(|start| !start.is_empty());
        array
    };
    let mut clocked = integer("clocked", 3, DataType::Int32, Input);
    clocked.clocks = vec![13];
    let mut size = integer("n", 40, DataType::UInt64, StructuralParameter);
    size.start = Some(Start::Integer(vec![2]));
    size.stated_variability = Some(Variability::Fixed);
    size.properties.min = Some(Number::Integer(1));
    size.properties.max = Some(Number::Integer(5));
    let count = |name: &str, reference: u32| integer(name, reference, DataType::Int32, Output);
    let mut description = described(
        "events3",
        vec![
            real("u", 1, Input, None),
            integer("level", 2, DataType::Int32, Input),
            clocked,
            clock("sample", 10, Input, "constant"),
            clock("asked", 11, Input, "fixed"),
            clock("countdown", 12, Input, "countdown"),
            clock("pulse", 13, Input, "triggered"),
            clock("out", 14, Output, "triggered"),
            clock("changing", 15, Input, "changing"),
            count("samples", 21),
            count("askeds", 22),
            count("countdowns", 23),
            count("pulses", 24),
            count("changes", 25),
            real("held", 26, Output, None),
            count("seen", 27),
            count("events", 28),
            real("y", 29, Output, None),
            real("last", 30, Output, None),
            integer("big", 31, DataType::Int64, Parameter),
            integer("huge", 32, DataType::UInt64, Parameter),
            integer("big out", 33, DataType::Int64, Output),
            integer("huge in", 34, DataType::UInt64, Input),
            integer("big in", 36, DataType::Int64, Input),
            integer("big fed", 37, DataType::Int64, Output),
            integer("huge out", 38, DataType::UInt64, Output),
            integer("huge fed", 39, DataType::UInt64, Output),
            count("taken", 35),
            size,
            array("x", 41, Parameter, &[1.0, 2.0]),
            array("in", 43, Input, &[0.0, 0.0]),
            array("out array", 44, Output, &[]),
            count("kick", 45),
            count("crossed", 46),
        ],
    );
    description.fmi_version = FmiVersion::V3;
    description.variable_naming_convention = modeldescription::description::NamingConvention::Flat;
    if let Some(co_simulation) = &mut description.co_simulation {
        co_simulation.has_event_mode = true;
        co_simulation.might_return_early_from_do_step = true;
    }
    let outputs = description.variables.iter().filter(|v| v.causality == Output);
    let outputs: Vec<Unknown> = outputs.map(|v| Unknown::new(v.value_reference)).collect();
    let is_clock = |u: &&Unknown| u.variable == 14;
    description.structure.initial_unknowns =
        outputs.iter().filter(|u| !is_clock(u)).cloned().collect();
    description.structure.outputs = outputs;
    description
}
