//! From the variable table to the description.

mod common;

use common::{fmpy_problems, library, python};
use model::{Causality, DataType, Unit, Variable, VariableTable};
use modeldescription::describe::{About, DescribeError, describe, time_reference};
use modeldescription::description::CoSimulation;
use modeldescription::package::Platform;
use modeldescription::{FmiVersion, ModelDescription, PackageBuilder, check, required_functions};

fn row(name: &str, causality: Causality, start: Option<f64>) -> Variable {
    Variable {
        name: name.to_owned(),
        alias: None,
        description: format!("the {name}"),
        data_type: DataType::Real,
        unit: "um".to_owned(),
        si: Unit::parse("um").unwrap(),
        causality,
        discrete: false,
        start,
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        fit: false,
        initial_dependencies: None,
    }
}

fn rows() -> Vec<Variable> {
    let mut command = row("command[1]", Causality::Input, Some(0.0));
    command.unit = "V".to_owned();
    command.si = Unit::parse("V").unwrap();
    command.alias = Some("u".to_owned());
    (command.min, command.max) = (-20.0, 120.0);
    let mut position = row("position[1]", Causality::Output, None);
    position.initial_dependencies = Some(vec![3, 0, 3]);
    let mut plays = row("plays", Causality::FixedParameter, Some(10.0));
    plays.data_type = DataType::Integer;
    (plays.unit, plays.min, plays.max) = (String::new(), 1.0, f64::INFINITY);
    let gain = row("axis[1].gain", Causality::TunableParameter, Some(0.1 + 0.2));
    let mut enabled = row("enabled", Causality::FixedParameter, Some(1.0));
    enabled.data_type = DataType::Boolean;
    enabled.unit = String::new();
    let mut reading = row("reading", Causality::Output, None);
    reading.discrete = true;
    vec![command, position, plays, gain, enabled, reading]
}

fn about(version: FmiVersion) -> About {
    let mut co_simulation = CoSimulation::new("plant");
    co_simulation.can_handle_variable_communication_step_size = true;
    let mut about = About::new(version, "Plant", co_simulation, 5e-5);
    about.log_categories = vec![("logStatusError".to_owned(), "errors".to_owned())];
    about
}

#[test]
fn table_and_description_say_the_same() {
    let table = VariableTable::new(rows());
    let described = describe(&table, &about(FmiVersion::V2)).unwrap();
    assert_eq!(described.instantiation_token, table.fingerprint());
    for (reference, row) in table.as_slice().iter().enumerate() {
        let variable = &described.variables[reference];
        assert_eq!((&variable.name, variable.value_reference), (&row.name, reference as u32));
    }
    let xml = described.to_xml().unwrap();
    for line in [
        r#"<DefaultExperiment startTime="0.0" stopTime="0.05" stepSize="5e-5"/>"#,
        r#"<BaseUnit kg="1" m="2" s="-3" A="-1"/>"#,
        r#"<BaseUnit m="1" factor="1e-6"/>"#,
        r#"<Real unit="V" min="-20.0" max="120.0" start="0.0"/>"#,
        r#"<Real unit="um" start="0.30000000000000004"/>"#,
        r#"<Integer min="1" start="10"/>"#,
        r#"<Boolean start="true"/>"#,
        r#"causality="output" variability="discrete" initial="calculated""#,
        r#"<Unknown index="2" dependencies=""/>"#,
        r#"<Unknown index="2" dependencies="1 4"/>"#,
        r#"<Unknown index="6"/>"#,
    ] {
        assert!(xml.contains(line), "{line} is missing in\n{xml}");
    }
    assert_eq!(ModelDescription::parse(xml.as_bytes()).unwrap(), described);
}

#[test]
fn version_3_has_time_and_short_names_in_the_description() {
    let table = VariableTable::new(rows());
    let described = describe(&table, &about(FmiVersion::V3)).unwrap();
    let command = described.variable("command").unwrap();
    assert!(command.description.as_deref().unwrap().ends_with("(u)"), "{command:?}");
    assert!(described.variables.iter().all(|v| v.aliases.is_empty()));
    assert_eq!(described.variable("time").unwrap().value_reference, time_reference(&table));
    assert_eq!(described.structure.outputs[0].variable, 1);
    assert_eq!(described.structure.initial_unknowns[0].dependencies, Some(vec![0, 3]));
}

/// Two axes, one with short names, and parameters of both.
fn two_axes() -> Vec<Variable> {
    let axis = |name: &str, axis: &str| {
        let mut row = row(name, Causality::Input, Some(1.0));
        row.description = format!("Command, axis {axis}");
        row
    };
    let (mut y, mut z) = (axis("command[1]", "Y"), axis("command[2]", "Z"));
    y.alias = Some("u1".to_owned());
    (y.min, y.max, y.start) = (-20.0, 100.0, Some(0.5));
    (z.min, z.max) = (0.0, 120.0);
    let mut rows = vec![y, z];
    for (index, knowns) in [(1, vec![0, 4]), (2, vec![1])] {
        let mut position = row(&format!("position[{index}]"), Causality::Output, None);
        position.description = "Position".to_owned();
        position.initial_dependencies = Some(knowns);
        rows.push(position);
    }
    for index in 1..=3 {
        let name = format!("axis[1].hysteresis.w[{index}]");
        let mut weight = row(&name, Causality::TunableParameter, Some(f64::from(index) * 0.1));
        weight.min = 0.0;
        rows.push(weight);
    }
    rows
}

#[test]
fn version_3_has_arrays_of_axes_and_parameters() {
    let table = VariableTable::new(two_axes());
    let described = describe(&table, &about(FmiVersion::V3)).unwrap();
    let names: Vec<_> = described.variables.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["command", "position", "axis[1].hysteresis.w", "time"]);
    let xml = described.to_xml().unwrap();
    for part in [
        r#"<Float64 name="command" valueReference="0" description="Command, axes Y (u1), Z""#,
        // Bounds that every element is within.
        r#"min="-20.0" max="120.0" start="0.5 1.0""#,
        r#"<Float64 name="position" valueReference="2""#,
        r#"<Float64 name="axis[1].hysteresis.w" valueReference="4""#,
        r#"min="0.0" start="0.1 0.2 0.30000000000000004""#,
        r#"<Dimension start="2"/>"#,
        r#"<Dimension start="3"/>"#,
        r#"<Output valueReference="2" dependencies=""/>"#,
        r#"<InitialUnknown valueReference="2" dependencies="0 4"/>"#,
    ] {
        assert!(xml.contains(part), "{part} is missing in\n{xml}");
    }
    assert_eq!(ModelDescription::parse(xml.as_bytes()).unwrap(), described);
    // FMI 2.0 has none.
    let described = describe(&table, &about(FmiVersion::V2)).unwrap();
    assert_eq!(described.variables.len(), table.len());
}

#[test]
fn axes_in_different_units_stay_scalars() {
    let mut rows = two_axes();
    rows[1].unit = "urad".to_owned();
    rows[1].si = Unit::parse("urad").unwrap();
    let described = describe(&VariableTable::new(rows), &about(FmiVersion::V3)).unwrap();
    assert!(described.variable("command[2]").unwrap().dimensions.is_empty());
    let first = described.variable("command[1]").unwrap();
    assert_eq!(first.description.as_deref(), Some("Command, axis Y (u1)"));
    assert!(described.variable("position").is_some());
}

#[test]
fn fmpy_finds_nothing_wrong() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let described = [FmiVersion::V2, FmiVersion::V3].into_iter().flat_map(|version| {
        [rows(), two_axes()]
            .map(|rows| describe(&VariableTable::new(rows), &about(version)).unwrap())
    });
    for described in described {
        let file = folder.path().join("modelDescription.xml");
        std::fs::write(&file, described.to_xml().unwrap()).unwrap();
        assert_eq!(fmpy_problems(&python, folder.path()), "");
    }
}

/// Described, packed with a complete library, checked: nothing to complain about.
#[test]
fn the_checker_finds_nothing_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.fmu");
    for version in [FmiVersion::V2, FmiVersion::V3] {
        let described = describe(&VariableTable::new(rows()), &about(version)).unwrap();
        let mut fmu = PackageBuilder::new(&described).unwrap();
        let library = library(&required_functions(&described));
        fmu.binary(Platform::host().unwrap().tuple, library).unwrap();
        fmu.write(&path).unwrap();
        let problems = check(&path).unwrap();
        assert!(problems.is_empty(), "{problems:#?}");
    }
}

#[test]
fn bad_tables_are_refused() {
    let refused = |change: fn(&mut Vec<Variable>)| {
        let mut rows = rows();
        change(&mut rows);
        describe(&VariableTable::new(rows), &about(FmiVersion::V2)).unwrap_err()
    };
    let error = refused(|rows| rows[0].start = None);
    assert_eq!(error, DescribeError::NoStart { name: "command[1]".to_owned() });
    let error = refused(|rows| rows[2].start = Some(1.5)).to_string();
    assert!(error.contains("\"plays\"") && error.contains("1.5"), "{error}");
    let error = refused(|rows| rows[4].start = Some(2.0)).to_string();
    assert!(error.contains("0 or 1"), "{error}");
    let mut about = about(FmiVersion::V2);
    about.internal_step = 0.0;
    let error = describe(&VariableTable::new(rows()), &about).unwrap_err();
    assert_eq!(error, DescribeError::Step { step: 0.0 });
}
