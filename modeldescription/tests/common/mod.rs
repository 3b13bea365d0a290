//! Descriptions that the tests share: one valid FMU of each version that uses most of the standard.
// Each test file uses a part; a skipped test says so.
#![allow(dead_code, clippy::print_stdout)]

use std::path::{Path, PathBuf};
use std::process::Command;

use modeldescription::description::*;
use modeldescription::structure::*;
use modeldescription::variable::*;

pub(crate) fn variable(
    name: &str,
    value_reference: u32,
    data_type: DataType,
    causality: Causality,
    variability: Variability,
) -> Variable {
    Variable {
        causality,
        stated_variability: Some(variability),
        ..Variable::new(name, value_reference, data_type)
    }
}

fn float(value: f64) -> Option<Start> {
    Some(Start::Float(vec![value]))
}

fn in_unit(unit: &str) -> Properties {
    Properties { unit: Some(unit.to_owned()), ..Properties::default() }
}

/// A piezo stage: what its parts are called is what users see, so it has the names of a real one.
pub(crate) fn stage(version: FmiVersion) -> ModelDescription {
    let mut stage = ModelDescription::new(version, "Piezo stage", "0123456789abcdef");
    stage.description = Some("One axis & a sensor <\"µm\">".to_owned());
    stage.author = Some("Ada".to_owned());
    stage.version = Some("1.2".to_owned());
    stage.copyright = Some("© 2026".to_owned());
    stage.license = Some("MIT".to_owned());
    stage.generation_tool = Some("Piezoloop".to_owned());
    stage.generation_date_and_time = Some("2026-11-21T00:00:00Z".to_owned());
    stage.co_simulation = Some(co_simulation(version));
    stage.units = units();
    stage.types = types();
    stage.log_categories = ["logStatusError", "logEvents"]
        .map(|name| LogCategory { name: name.to_owned(), description: None, line: Line(0) })
        .to_vec();
    stage.default_experiment = Some(DefaultExperiment {
        start_time: Some(0.0),
        stop_time: Some(0.05),
        tolerance: Some(1e-6),
        step_size: Some(5e-5),
        line: Line(0),
    });
    stage.variables = variables();
    let reference = |name: &str| {
        let position = stage.variables.iter().position(|v| v.name == name).unwrap();
        stage.reference_to(position).unwrap()
    };
    let position = reference("axis[1].position");
    let stiffness = reference("axis[1].stiffness");
    let mode = reference("mode");
    let command = reference("axis[1].command");
    let mut output = Unknown::depending_on(position, vec![command]);
    output.dependency_kinds = Some(vec![DependencyKind::Dependent]);
    let outputs = vec![output, Unknown::depending_on(mode, Vec::new())];
    let initial_unknowns =
        vec![Unknown::new(position), Unknown::new(stiffness), Unknown::new(mode)];
    stage.structure = ModelStructure { outputs, initial_unknowns, ..ModelStructure::default() };
    stage
}

fn co_simulation(version: FmiVersion) -> CoSimulation {
    let mut read = CoSimulation::new("stage");
    read.common.can_get_and_set_fmu_state = true;
    read.common.can_serialize_fmu_state = true;
    read.common.can_not_use_memory_management_functions = version == FmiVersion::V2;
    read.can_handle_variable_communication_step_size = true;
    read.fixed_internal_step_size = (version == FmiVersion::V3).then_some(5e-5);
    read
}

fn units() -> Vec<Unit> {
    let unit = |name: &str, base: BaseUnit| Unit {
        name: name.to_owned(),
        base: Some(base),
        display_units: Vec::new(),
        line: Line(0),
    };
    let mut length = unit("um", BaseUnit { m: 1, factor: 1e-6, ..BaseUnit::default() });
    length.display_units.push(DisplayUnit {
        name: "nm".to_owned(),
        factor: 1e3,
        offset: 0.0,
        inverse: false,
        line: Line(0),
    });
    vec![
        length,
        unit("V", BaseUnit { kg: 1, m: 2, s: -3, a: -1, ..BaseUnit::default() }),
        unit("N/m", BaseUnit { kg: 1, s: -2, ..BaseUnit::default() }),
        unit("s", BaseUnit { s: 1, ..BaseUnit::default() }),
    ]
}

fn types() -> Vec<TypeDefinition> {
    let item = |name: &str, value| EnumerationItem {
        name: name.to_owned(),
        value,
        description: Some(format!("the loop is {name}")),
    };
    let definition = |name: &str, data_type| TypeDefinition {
        name: name.to_owned(),
        description: None,
        data_type,
        properties: Properties::default(),
        items: Vec::new(),
        line: Line(0),
    };
    let mut length = definition("Length", DataType::Float64);
    length.properties = in_unit("um");
    length.properties.quantity = Some("Length".to_owned());
    length.properties.nominal = Some(1.0);
    let mut mode = definition("Mode", DataType::Enumeration);
    mode.items = vec![item("open", 1), item("closed", 2)];
    vec![length, mode]
}

fn variables() -> Vec<Variable> {
    use Causality::*;
    use DataType::{Boolean, Enumeration, Float64, Int32};
    use Variability::*;
    let mut command = variable("axis[1].command", 1, Float64, Input, Continuous);
    command.start = float(0.0);
    command.properties = in_unit("V");
    command.properties.min = Some(Number::Float(-20.0));
    command.properties.max = Some(Number::Float(120.0));
    let mut position = variable("axis[1].position", 2, Float64, Output, Continuous);
    position.declared_type = Some("Length".to_owned());
    position.properties.display_unit = Some("nm".to_owned());
    let mut gain = variable("axis[1].gain", 3, Float64, Parameter, Tunable);
    gain.start = float(0.1 + 0.2);
    gain.description = Some("gain of the amplifier".to_owned());
    let mut stiffness = variable("axis[1].stiffness", 4, Float64, CalculatedParameter, Fixed);
    stiffness.properties = in_unit("N/m");
    let mut plays = variable("plays", 5, Int32, Parameter, Fixed);
    plays.start = Some(Start::Integer(vec![10]));
    plays.properties.min = Some(Number::Integer(1));
    plays.properties.max = Some(Number::Integer(100));
    let mut enabled = variable("enabled", 6, Boolean, Parameter, Fixed);
    enabled.start = Some(Start::Boolean(vec![true]));
    let mut label = variable("label", 7, DataType::String, Parameter, Fixed);
    label.start = Some(Start::Text(vec!["x < y & \"z\"\n'w'".to_owned()]));
    let mut mode = variable("mode", 8, Enumeration, Output, Discrete);
    mode.declared_type = Some("Mode".to_owned());
    let mut state = variable("axis[1].'velocity #1'", 9, Float64, Local, Continuous);
    state.stated_initial = Some(Initial::Exact);
    state.start = float(-1.5e-300);
    let mut time = variable("time", 10, Float64, Independent, Continuous);
    time.properties = in_unit("s");
    vec![command, position, gain, stiffness, plays, enabled, label, mode, state, time]
}

/// The stage in FMI 3.0, with what only 3.0 has.
pub(crate) fn stage_3() -> ModelDescription {
    use Causality::*;
    use Variability::*;
    let mut stage = stage(FmiVersion::V3);
    let mut size = variable("axes", 20, DataType::UInt64, StructuralParameter, Fixed);
    size.start = Some(Start::Integer(vec![2]));
    let mut commands = variable("commands", 21, DataType::Float64, Input, Continuous);
    commands.start = Some(Start::Float(vec![0.0, 1.5]));
    commands.dimensions = vec![Dimension::Parameter(20)];
    let mut matrix = variable("coupling", 22, DataType::Float32, Parameter, Tunable);
    matrix.start = Some(Start::Float(vec![1.0, 0.25, 0.5, 1.0]));
    matrix.dimensions = vec![Dimension::Size(2), Dimension::Size(2)];
    matrix.aliases = vec![Alias {
        name: "jacobian".to_owned(),
        description: Some("the same".to_owned()),
        display_unit: None,
    }];
    let mut counter = variable("counter", 23, DataType::UInt64, Parameter, Fixed);
    counter.start = Some(Start::Integer(vec![u64::MAX.into()]));
    let mut names = variable("names", 24, DataType::String, Parameter, Fixed);
    names.start = Some(Start::Text(vec!["x".to_owned(), "y z".to_owned()]));
    names.dimensions = vec![Dimension::Size(2)];
    let mut table = variable("table", 25, DataType::Binary, Parameter, Fixed);
    table.start = Some(Start::Binary(vec![vec![0, 1, 0xfe]]));
    table.properties.max_size = Some(1024);
    stage.variables.extend([size, commands, matrix, counter, names, table]);
    stage
}

/// A Python with fmpy: the one `PIEZOLOOP_PYTHON` names, else that of the tests' environment below
/// the workspace's target folder. Says so and is None where there is none; one that is named must work.
pub(crate) fn python() -> Option<PathBuf> {
    let named = std::env::var_os("PIEZOLOOP_PYTHON").map(PathBuf::from);
    let is_named = named.is_some();
    let own = || Some(Path::new(env!("CARGO_MANIFEST_DIR")).parent()?.join(PYTHON_BELOW_WORKSPACE));
    let python = named.or_else(own)?;
    let has_fmpy = Command::new(&python)
        .args(["-c", "import fmpy"])
        .output()
        .is_ok_and(|output| output.status.success());
    assert!(has_fmpy || !is_named, "{} has no fmpy", python.display());
    if !has_fmpy {
        println!("SKIPPED: no Python with fmpy; PIEZOLOOP_PYTHON may name one");
    }
    has_fmpy.then_some(python)
}

const PYTHON_BELOW_WORKSPACE: &str = "target/python-env/bin/python";

/// What `fmpy.validation.validate_fmu` says of a file; no line if it finds nothing.
pub(crate) fn fmpy_problems(python: &Path, file: &Path) -> String {
    let script = "import sys\nfrom fmpy.validation import validate_fmu\n\
                  print('\\n'.join(validate_fmu(sys.argv[1])), end='')";
    let output = Command::new(python).arg("-c").arg(script).arg(file).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "fmpy failed: {stderr}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A shared library of this computer that exports these functions (which do nothing).
pub(crate) fn library(functions: &[&str]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let source: String = functions
        .iter()
        .map(|name| format!("#[unsafe(no_mangle)] pub extern \"C\" fn {name}() {{}}\n"))
        .collect();
    let (file, library) = (folder.path().join("lib.rs"), folder.path().join("library"));
    std::fs::write(&file, format!("#![allow(non_snake_case)]\n{source}")).unwrap();
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(compiler)
        .args(["--edition", "2024", "--crate-type", "cdylib", "-C", "strip=symbols", "-o"])
        .arg(&library)
        .arg(&file)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::read(library).unwrap()
}
