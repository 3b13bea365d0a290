//! What is written reads back the same, and fmpy finds nothing wrong with it.

mod common;

use common::{fmpy_problems, python, stage, stage_3};
use modeldescription::description::*;
use modeldescription::structure::Unknown;
use modeldescription::variable::*;
use modeldescription::{FmiVersion, ModelDescription, ParseError, WriteError};

#[test]
fn reads_back_what_it_wrote() {
    for description in [stage(FmiVersion::V2), stage(FmiVersion::V3), stage_3()] {
        let xml = description.to_xml().unwrap();
        let read = ModelDescription::parse(xml.as_bytes()).unwrap();
        assert_eq!(read, description, "{xml}");
        assert_eq!(read.to_xml().unwrap(), xml);
    }
}

#[test]
fn floats_keep_every_bit() {
    let values =
        [0.1, 1.0 / 3.0, 5e-324, f64::MAX, -0.0, 1e21, 123_456_789.123_456_79, f64::INFINITY];
    for value in values {
        let mut description = stage(FmiVersion::V2);
        description.variables[0].start = Some(Start::Float(vec![value]));
        let xml = description.to_xml().unwrap();
        let read = ModelDescription::parse(xml.as_bytes()).unwrap();
        let Some(Start::Float(start)) = &read.variables[0].start else { panic!("{xml}") };
        assert_eq!(start[0].to_bits(), value.to_bits(), "{value}");
    }
}

#[test]
fn fmpy_finds_nothing_wrong() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    for (name, description) in [
        ("two", stage(FmiVersion::V2)),
        ("three", stage(FmiVersion::V3)),
        ("three_only", stage_3()),
    ] {
        let fmu = folder.path().join(name);
        std::fs::create_dir(&fmu).unwrap();
        let file = fmu.join("modelDescription.xml");
        std::fs::write(&file, description.to_xml().unwrap()).unwrap();
        assert_eq!(fmpy_problems(&python, &fmu), "", "{name}");
    }
}

/// fmpy is no yes-man: it finds a defect when there is one.
#[test]
fn fmpy_finds_a_defect() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut description = stage(FmiVersion::V2);
    description.structure.outputs.pop();
    let xml = description.to_xml().unwrap();
    std::fs::write(folder.path().join("modelDescription.xml"), xml).unwrap();
    assert!(fmpy_problems(&python, folder.path()).contains("ModelStructure/Outputs"));
}

#[test]
fn lines_are_those_of_the_file() {
    let xml = stage(FmiVersion::V2).to_xml().unwrap();
    let read = ModelDescription::parse(xml.as_bytes()).unwrap();
    for variable in &read.variables {
        let line = xml.lines().nth(variable.line.0 as usize - 1).unwrap();
        let escaped = variable.name.replace('&', "&amp;");
        assert!(line.contains(&format!("<ScalarVariable name=\"{escaped}\"")), "{line}");
    }
}

#[test]
fn defaults_of_the_standard_apply() {
    let xml = r#"<?xml version="1.0" encoding="UTF-8"?>
        <fmiModelDescription fmiVersion="2.0" modelName="m" guid="g">
        <CoSimulation modelIdentifier="m"/>
        <ModelVariables>
          <ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable>
          <ScalarVariable name="p" valueReference="1" causality="parameter" variability="tunable">
            <Real start=" 1 "/></ScalarVariable>
        </ModelVariables><ModelStructure/></fmiModelDescription>"#;
    let read = ModelDescription::parse(xml.as_bytes()).unwrap();
    assert_eq!(read.variable_naming_convention, NamingConvention::Flat);
    let [y, p] = &read.variables[..] else { panic!() };
    assert_eq!(y.variability(FmiVersion::V2), Variability::Continuous);
    assert_eq!(y.initial(FmiVersion::V2), Some(Initial::Calculated));
    assert_eq!(p.initial(FmiVersion::V2), Some(Initial::Exact));
    assert_eq!(p.start, Some(Start::Float(vec![1.0])));
}

#[test]
fn properties_come_from_the_declared_type() {
    let stage = stage(FmiVersion::V2);
    let position = stage.variable("axis[1].position").unwrap();
    let properties = stage.properties(position);
    assert_eq!(properties.unit.as_deref(), Some("um"));
    assert_eq!(properties.display_unit.as_deref(), Some("nm"));
}

#[test]
fn references_are_positions_in_2_and_value_references_in_3() {
    let two = stage(FmiVersion::V2);
    assert_eq!(two.referenced(2).unwrap().name, "axis[1].position");
    assert_eq!(two.referenced(0), None);
    assert_eq!(two.referenced(99), None);
    let three = stage_3();
    assert_eq!(three.referenced(22).unwrap().name, "coupling");
    assert_eq!(three.variable("jacobian").unwrap().name, "coupling");
}

#[test]
fn unreadable_values_are_all_named() {
    let xml = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g">
<ModelVariables>
<ScalarVariable name="a" valueReference="-1"><Real/></ScalarVariable>
<ScalarVariable name="b" valueReference="2" causality="structuralParameter"><Real start="1,5"/></ScalarVariable>
<ScalarVariable name="c" valueReference="3"/>
</ModelVariables><ModelStructure><Outputs><Unknown index="one"/></Outputs></ModelStructure></fmiModelDescription>"#;
    let Err(ParseError::Unreadable(problems)) = ModelDescription::parse(xml.as_bytes()) else {
        panic!("was read");
    };
    let lines: Vec<_> = problems.iter().map(|p| p.line.unwrap()).collect();
    assert_eq!(lines, [4, 5, 5, 6, 7], "{problems:#?}");
    let text = problems[2].to_string();
    assert!(text.contains("start=\"1,5\"") && text.contains("2.2.7"), "{text}");
}

#[test]
fn harmless_deviations_do_not_keep_a_file_from_being_read() {
    let xml = r#"<fmiModelDescription fmiVersion="2.0.3" modelName="m" guid="g" vendor="x">
        <ModelVariables><ScalarVariable name="y" valueReference="0"><Real color="red"/>
        </ScalarVariable></ModelVariables><CoSimulation modelIdentifier="m"/><Extra/>
        </fmiModelDescription>"#;
    let read = ModelDescription::parse(xml.as_bytes()).unwrap();
    assert_eq!(read.variables.len(), 1);
    assert_eq!(read.co_simulation.unwrap().common.model_identifier, "m");
}

#[test]
fn other_files_are_refused() {
    let parse = |xml: &str| ModelDescription::parse(xml.as_bytes());
    assert!(matches!(parse("<html/>"), Err(ParseError::Root { line: 1, .. })));
    let one = "<fmiModelDescription fmiVersion='1.0'/>";
    assert!(matches!(parse(one), Err(ParseError::Version { .. })));
    assert!(matches!(parse("<fmiModelDescription"), Err(ParseError::Xml(_))));
}

#[test]
fn version_2_cannot_hold_what_only_3_has() {
    let mut three = stage_3();
    three.fmi_version = FmiVersion::V2;
    let error = three.to_xml().unwrap_err();
    assert!(matches!(&error, WriteError::NotInVersion2 { name, .. } if name == "axes"), "{error}");
}

#[test]
fn characters_that_xml_cannot_hold_are_refused() {
    let mut description = stage(FmiVersion::V2);
    description.model_name = "bell\u{7}".to_owned();
    let error = description.to_xml().unwrap_err().to_string();
    assert!(error.contains("modelName") && error.contains("U+0007"), "{error}");
}

#[test]
fn an_unknown_may_depend_on_nothing_or_on_everything() {
    let mut description = stage(FmiVersion::V2);
    description.structure.outputs = vec![Unknown::new(2), Unknown::depending_on(8, Vec::new())];
    let xml = description.to_xml().unwrap();
    assert!(xml.contains("<Unknown index=\"2\"/>"), "{xml}");
    assert!(xml.contains("<Unknown index=\"8\" dependencies=\"\"/>"), "{xml}");
    assert_eq!(ModelDescription::parse(xml.as_bytes()).unwrap(), description);
}
