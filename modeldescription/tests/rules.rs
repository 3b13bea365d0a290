//! Rules beyond the detection matrix, of both versions; and no rule fires on valid descriptions.

mod common;

use std::path::Path;

use common::{fmpy_problems, python, stage, stage_3};
use modeldescription::{
    FmiVersion, ModelDescription, Problem, check_description, check_model, required_functions,
};

fn listing(problems: &[Problem]) -> String {
    problems.iter().map(|problem| format!("{problem}\n")).collect()
}

fn two(variables: &str, structure: &str) -> String {
    description(
        "fmiVersion=\"2.0\" modelName=\"m\" guid=\"g\"",
        &format!(
            "<UnitDefinitions><Unit name=\"m\"><BaseUnit m=\"1\"/></Unit></UnitDefinitions>
             <TypeDefinitions><SimpleType name=\"E\"><Enumeration><Item name=\"a\" value=\"1\"/>
             <Item name=\"b\" value=\"3\"/></Enumeration></SimpleType></TypeDefinitions>
             <ModelVariables>{variables}</ModelVariables>
             <ModelStructure>{structure}</ModelStructure>"
        ),
    )
}

fn three(variables: &str, structure: &str) -> String {
    let time = "<Float64 name=\"time\" valueReference=\"0\" causality=\"independent\"/>";
    description(
        "fmiVersion=\"3.0\" modelName=\"m\" instantiationToken=\"t\"",
        &format!(
            "<ModelVariables>{time}{variables}</ModelVariables>
             <ModelStructure>{structure}</ModelStructure>"
        ),
    )
}

fn description(attributes: &str, content: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription {attributes}>
         <CoSimulation modelIdentifier=\"m\"/>{content}</fmiModelDescription>"
    )
}

/// A variable of FMI 2.0 and what is reported about it; empty if it is valid.
#[test]
fn variables_of_version_2() {
    let v = |attributes: &str, element: &str| {
        format!(
            "<ScalarVariable name=\"v\" valueReference=\"1\" {attributes}>{element}</ScalarVariable>"
        )
    };
    let constant = "variability=\"constant\"";
    let fixed = "variability=\"fixed\"";
    let discrete = "variability=\"discrete\"";
    let parameter = "causality=\"parameter\" variability=\"fixed\"";
    for (attributes, element, says) in [
        ("", "<Real/>", ""),
        (constant, "<Real start=\"1\"/>", ""),
        (constant, "<Real/>", "variability constant must have a start value"),
        (fixed, "<Real/>", ""),
        (fixed, "<Integer/>", ""),
        ("variability=\"fixed\" initial=\"approx\"", "<Real start=\"1\"/>", ""),
        (
            "variability=\"fixed\" initial=\"exact\"",
            "<Real start=\"1\"/>",
            "allows initial calculated, approx",
        ),
        (
            "causality=\"parameter\" variability=\"fixed\" initial=\"approx\"",
            "<Real start=\"1\"/>",
            "allows initial exact",
        ),
        (parameter, "<Real/>", "causality parameter must have a start value"),
        (parameter, "<Real start=\"\"/>", "has 0 start values"),
        (parameter, "<Real start=\"1 2\"/>", "has 2 start values"),
        (parameter, "<String start=\"\"/>", ""),
        (parameter, "<Enumeration declaredType=\"E\" start=\"3\"/>", ""),
        (parameter, "<Enumeration declaredType=\"E\" start=\"2\"/>", "value of an item of \"E\""),
        (parameter, "<Enumeration start=\"1\"/>", "an enumeration must name the type"),
        (parameter, "<Integer declaredType=\"E\" start=\"1\"/>", "the type is of Enumeration"),
        (parameter, "<Integer start=\"2147483648\"/>", "a list of integers from"),
        (parameter, "<Boolean start=\"yes\"/>", "true, false, 1, 0"),
        (parameter, "<Real start=\"nan\"/>", "a list of numbers"),
        (discrete, "<Boolean/>", ""),
        ("", "<Boolean/>", "only floating point variables are continuous"),
        ("", "<Real nominal=\"0\"/>", "the nominal value must be positive"),
        ("", "<Real displayUnit=\"m\"/>", "a display unit needs a unit"),
        ("", "<Real derivative=\"9\"/>", "there is no variable at that position"),
        ("", "<Real derivative=\"1\"/>", "not its own derivative"),
        ("", "<Real reinit=\"true\"/>", "only continuous states may"),
        ("canHandleMultipleSetPerTimeInstant=\"true\"", "<Real/>", "only inputs may"),
        (
            "causality=\"independent\" variability=\"discrete\"",
            "<Real/>",
            "allows variability continuous",
        ),
        ("colour=\"red\"", "<Real/>", "has the attribute colour=\"red\""),
        ("", "<Real/><Real/>", "the schema allows this element once"),
        ("", "<Complex/>", "has no type"),
    ] {
        let found = check_description(two(&v(attributes, element), "").as_bytes());
        match says.is_empty() {
            true => assert!(found.is_empty(), "{attributes} {element}:\n{}", listing(&found)),
            false => {
                let text = listing(&found);
                assert!(found.len() == 1 && text.contains(says), "{attributes} {element}:\n{text}");
            }
        }
    }
}

#[test]
fn aliases_of_version_2() {
    let set = |first: &str, second: &str| {
        two(
            &format!(
                "<ScalarVariable name=\"a\" valueReference=\"1\" {first}</ScalarVariable>
                 <ScalarVariable name=\"b\" valueReference=\"1\" {second}</ScalarVariable>"
            ),
            "",
        )
    };
    let plain = "><Real unit=\"m\"/>";
    let input = "causality=\"input\"><Real unit=\"m\" start=\"0\"/>";
    let constant = |start| format!("variability=\"constant\"><Real unit=\"m\" start=\"{start}\"/>");
    for (first, second, says) in [
        (plain, plain, ""),
        (input, plain, ""),
        (input, "variability=\"discrete\"><Integer/>", ""),
        (input, input, "at most one of several aliases"),
        (plain, "><Real/>", "has the unit none, not m"),
        (plain, "><Real unit=\"m\" relativeQuantity=\"true\"/>", "same relativeQuantity"),
        (plain, &constant(1), "either all or none of the aliases must be constant"),
        (&constant(1), &constant(1), ""),
        (&constant(1), &constant(2), "the same start value"),
    ] {
        let found = check_description(set(first, second).as_bytes());
        let text = listing(&found);
        let expected = usize::from(!says.is_empty());
        assert!(found.len() == expected && text.contains(says), "{first} {second}:\n{text}");
    }
}

/// States, derivatives, approximations: a valid model-exchange FMU, and its structure with errors.
#[test]
fn structure_of_version_2() {
    let variables = "
        <ScalarVariable name=\"x\" valueReference=\"1\" causality=\"output\" initial=\"exact\">
          <Real start=\"2\" reinit=\"false\"/></ScalarVariable>
        <ScalarVariable name=\"der(x)\" valueReference=\"2\"><Real derivative=\"1\"/></ScalarVariable>
        <ScalarVariable name=\"v\" valueReference=\"3\" initial=\"approx\"><Real start=\"0\"/>
          </ScalarVariable>
        <ScalarVariable name=\"der(v)\" valueReference=\"4\"><Real derivative=\"3\"/></ScalarVariable>
        <ScalarVariable name=\"mu\" valueReference=\"5\" causality=\"parameter\" variability=\"fixed\">
          <Real start=\"1\"/></ScalarVariable>";
    let outputs = "<Outputs><Unknown index=\"1\" dependencies=\"1\"/></Outputs>";
    let derivatives = "<Derivatives><Unknown index=\"2\" dependencies=\"3\"/>
        <Unknown index=\"4\" dependencies=\"1 3\" dependenciesKind=\"dependent tunable\"/></Derivatives>";
    let initial = "<InitialUnknowns><Unknown index=\"2\"/><Unknown index=\"3\"/>
        <Unknown index=\"4\" dependencies=\"1 5\" dependenciesKind=\"constant dependent\"/>
        </InitialUnknowns>";
    let valid = [outputs, derivatives, initial].concat();
    let xml = two(variables, &valid);
    assert_eq!(listing(&check_description(xml.as_bytes())), "");
    if let Some(python) = python() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("modelDescription.xml"), &xml).unwrap();
        assert_eq!(fmpy_problems(&python, folder.path()), "");
    }
    // The last two leave an output unlisted, which is reported as well.
    for (from, to, says, expected) in [
        ("<Unknown index=\"3\"/>", "", "it is a state with initial approx", 1),
        ("<Unknown index=\"2\"/>", "", "it is the derivative of a state", 1),
        ("index=\"2\" dependencies=\"3\"", "index=\"2\" dependencies=\"5\"", "parameters only", 1),
        ("dependencies=\"1 3\"", "dependencies=\"3 1\"", "ascending order", 1),
        ("dependencies=\"1 3\"", "dependencies=\"1 1\"", "each known is listed once", 1),
        ("constant dependent", "fixed dependent", "dependent and constant only", 1),
        ("dependencies=\"1 5\"", "dependencies=\"2 5\"", "at initialisation, knowns are", 1),
        (
            "<Unknown index=\"1\"",
            "<Unknown index=\"0\"",
            "position of a variable, counted from 1",
            2,
        ),
        (outputs, "<Outputs/>", "a list that is present must have", 2),
    ] {
        assert_eq!(valid.matches(from).count(), 1, "{from}");
        let found = check_description(two(variables, &valid.replace(from, to)).as_bytes());
        let text = listing(&found);
        assert!(text.contains(says), "{to}: {says} is not in\n{text}");
        assert_eq!(found.len(), expected, "{to}:\n{text}");
    }
    let no_derivative = variables.replace(" derivative=\"3\"", "");
    let text = listing(&check_description(two(&no_derivative, &valid).as_bytes()));
    assert!(text.contains("Derivatives has \"der(v)\" (index 4)"), "{text}");
}

#[test]
fn units_types_and_names_of_version_2() {
    let base = stage(FmiVersion::V2).to_xml().unwrap();
    for (from, to, says) in [
        ("name=\"N/m\">", "name=\"um\">", "unit \"um\" is defined twice"),
        ("factor=\"1e-6\"", "factor=\"0\"", "could not be converted back"),
        (
            "<DisplayUnit name=\"nm\" factor=\"1000.0\"/>",
            "<DisplayUnit name=\"nm\" factor=\"1000.0\"/><DisplayUnit name=\"nm\"/>",
            "display unit \"nm\" of \"um\" is defined twice",
        ),
        (
            "SimpleType name=\"Mode\"",
            "SimpleType name=\"Length\"",
            "type \"Length\" is defined twice",
        ),
        ("SimpleType name=\"Length\"", "SimpleType name=\"plays\"", "has the name of the variable"),
        ("name=\"closed\" value=\"2\"", "name=\"closed\" value=\"1\"", "values must be unique"),
        ("name=\"closed\"", "name=\"open\"", "names must be unique"),
        ("quantity=\"Length\" unit=\"um\"", "unit=\"um2\"", "type \"Length\" has unit=\"um2\""),
        ("name=\"plays\"", "name=\"\"", "names must not be empty"),
        ("encoding=\"UTF-8\"", "encoding=\"ASCII\"", "it must be UTF-8"),
        ("tolerance=\"1e-6\"", "tolerance=\"0\"", "it must be positive"),
        ("stopTime=\"0.05\"", "stopTime=\"INF\"", "it must be finite"),
        ("modelIdentifier=\"stage\"", "modelIdentifier=\"sta-ge\"", "C identifier"),
        ("modelIdentifier=\"stage\"", "", "has no attribute modelIdentifier"),
        ("<LogCategories>", "<LogCategories><Kategorie/>", "<Kategorie> stands in <LogCategories>"),
        ("name=\"logEvents\"", "name=\"\"", "an empty name"),
    ] {
        assert!(base.contains(from), "{from}");
        let found = check_description(base.replacen(from, to, 1).as_bytes());
        let text = listing(&found);
        assert!(text.contains(says), "{to}: {says} is not in\n{text}");
        assert!(found[0].line.is_some(), "{text}");
    }
    let flat = base.replace(" variableNamingConvention=\"structured\"", "");
    assert_eq!(listing(&check_description(flat.as_bytes())), "");
    let tab = flat.replace("name=\"plays\"", "name=\"pl&#9;ays\"");
    let text = listing(&check_description(tab.as_bytes()));
    assert!(text.contains("must not hold a carriage return"), "{text}");
}

#[test]
fn the_interface_must_be_there_and_consistent() {
    let mut description = stage(FmiVersion::V2);
    description.co_simulation = None;
    assert!(listing(&check_model(&description)).contains("offers no interface type"));
    let mut three = stage_3();
    let co_simulation = three.co_simulation.as_mut().unwrap();
    co_simulation.can_return_early_after_intermediate_update = true;
    co_simulation.fixed_internal_step_size = Some(0.0);
    let found = check_model(&three);
    assert_eq!(found.len(), 2, "{}", listing(&found));
    assert!(found.iter().all(|problem| problem.section == "FMI 3.0.2, 4.4"));
}

#[test]
fn defects_of_version_3() {
    let base = stage_3().to_xml().unwrap();
    for (from, to, says) in [
        ("fmiVersion=\"3.0\"", "fmiVersion=\"3.00\"", "the value must be \"3.0\""),
        (" instantiationToken=\"0123456789abcdef\"", "", "instantiationToken is missing"),
        ("valueReference=\"23\"", "valueReference=\"22\"", "value references must be unique"),
        ("    <Output valueReference=\"8\" dependencies=\"\"/>\n", "", "Output lacks \"mode\""),
        ("    <InitialUnknown valueReference=\"4\"/>\n", "", "InitialUnknown lacks"),
        (
            "<InitialUnknown valueReference=\"4\"/>",
            "<InitialUnknown valueReference=\"1\"/><InitialUnknown valueReference=\"4\"/>",
            "InitialUnknown has \"axis[1].command\" (valueReference 1) of causality input",
        ),
        ("dependencies=\"1\"", "dependencies=\"77\"", "depends on valueReference 77"),
        ("dependencies=\"1\"", "dependencies=\"9\"", "knowns are inputs, parameters, states"),
        (
            "causality=\"independent\"",
            "causality=\"local\"",
            "exactly one variable must be independent",
        ),
        (
            "<Dimension valueReference=\"20\"/>",
            "<Dimension valueReference=\"5\"/>",
            "structural parameter",
        ),
        ("<Dimension start=\"2\"/>", "<Dimension start=\"0\"/>", "must be positive"),
        ("<Dimension start=\"2\"/>", "<Dimension/>", "exactly one of the two must be given"),
        ("start=\"0.0 1.5\"", "start=\"0.0 1.5 2.0\"", "an array of 2 elements"),
        ("start=\"18446744073709551615\"", "start=\"18446744073709551616\"", "integers from 0 to"),
        ("<Alias name=\"jacobian\"", "<Alias name=\"axes\"", "\"axes\" is there twice"),
        ("value=\"0001fe\"", "value=\"0001f\"", "pairs of hexadecimal digits"),
        ("canGetAndSetFMUState=\"true\" ", "", "canSerialize… requires canGetAndSet…"),
        ("<CoSimulation ", "<CoSimulation canGetAndSetFMUstate=\"true\" ", "canGetAndSetFMUstate"),
        ("<Int32 name=\"plays\"", "<Integer name=\"plays\"", "<Integer> stands in"),
        (
            "variability=\"fixed\" start=\"true\"",
            "variability=\"continuous\" start=\"true\"",
            "only floating",
        ),
        (
            "initial=\"exact\" start=\"-1.5e-300\"",
            "start=\"-1.5e-300\"",
            "must have no start value",
        ),
    ] {
        assert!(base.contains(from), "{from}");
        let changed = base.replacen(from, to, 1);
        let found = check_description(changed.as_bytes());
        let text = listing(&found);
        assert!(text.contains(says), "{to}: {says} is not in\n{text}");
        assert!(text.contains("[FMI 3.0.2, "), "{text}");
    }
}

/// Clocks, clocked states, arrays sized by parameters: what only 3.0 has, valid.
#[test]
fn clocks_and_states_of_version_3() {
    let variables = "
        <Clock name=\"tick\" valueReference=\"1\" causality=\"input\" intervalVariability=\"triggered\"/>
        <Int32 name=\"n\" valueReference=\"2\" causality=\"output\" clocks=\"1\" previous=\"3\"/>
        <Int32 name=\"previous(n)\" valueReference=\"3\" clocks=\"1\"/>
        <Float64 name=\"x\" valueReference=\"4\" initial=\"exact\" start=\"1\"/>
        <Float64 name=\"v\" valueReference=\"5\" derivative=\"4\"/>
        <Float64 name=\"k\" valueReference=\"6\" causality=\"parameter\" start=\"1\"/>
        <Float64 name=\"u\" valueReference=\"7\" causality=\"input\" start=\"0\" initial=\"exact\"/>";
    let structure = "
        <Output valueReference=\"2\" dependencies=\"1\"/>
        <ContinuousStateDerivative valueReference=\"5\" dependencies=\"6 4\"/>
        <ClockedState valueReference=\"2\"/>
        <InitialUnknown valueReference=\"5\" dependencies=\"4 6 7\"/>
        <EventIndicator valueReference=\"4\"/>";
    let xml = three(variables, structure);
    assert_eq!(listing(&check_description(xml.as_bytes())), "");
    let read = ModelDescription::parse(xml.as_bytes()).unwrap();
    let again = ModelDescription::parse(read.to_xml().unwrap().as_bytes()).unwrap();
    assert_eq!(read, again);
    for (from, to, says) in [
        ("\"triggered\"", "\"sometimes\"", "a clock must have one of"),
        (
            "clocks=\"1\" previous=\"3\"",
            "clocks=\"4\" previous=\"3\"",
            "value references of clocks",
        ),
        ("previous=\"3\"", "previous=\"2\"", "refers to another discrete variable"),
        (
            "clocks=\"1\" previous=\"3\"",
            "clocks=\"1\"",
            "must have the attributes previous and clocks",
        ),
        ("derivative=\"4\"", "derivative=\"44\"", "no variable with that value reference"),
        (
            "<EventIndicator valueReference=\"4\"/>",
            "<EventIndicator valueReference=\"3\"/>",
            "continuous",
        ),
        (
            "valueReference=\"1\" causality=\"input\"",
            "valueReference=\"1\" causality=\"parameter\" variability=\"fixed\"",
            "input, output or local",
        ),
    ] {
        assert!(xml.contains(from), "{from}");
        let text = listing(&check_description(xml.replacen(from, to, 1).as_bytes()));
        assert!(text.contains(says), "{to}: {says} is not in\n{text}");
    }
}

/// Whatever the bytes: an answer, never a panic, and never a description that cannot be written.
#[test]
fn damaged_descriptions_are_answered() {
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = |below: usize| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % below as u64) as usize
    };
    let pieces =
        ["\"", "<", "/>", "&", "-1", "99999999999", "NaN", " ", "\u{0}", "é", "name=", "]]>"];
    let mut readable = 0;
    for base in [stage(FmiVersion::V2).to_xml().unwrap(), stage_3().to_xml().unwrap()] {
        for _ in 0..4000 {
            let mut bytes = base.clone().into_bytes();
            for _ in 0..=next(3) {
                let at = next(bytes.len());
                let end = (at + next(12)).min(bytes.len());
                let piece = pieces[next(pieces.len())];
                bytes.splice(at..end, piece.bytes());
            }
            let problems = check_description(&bytes);
            match ModelDescription::parse(&bytes) {
                Ok(read) => {
                    readable += 1;
                    assert!(
                        read.to_xml().is_ok() || String::from_utf8_lossy(&bytes).contains('\0')
                    );
                }
                Err(_) => assert!(!problems.is_empty()),
            }
        }
    }
    assert!(readable > 100, "only {readable} of 8000 could be read: the test damages too much");
}

/// The lists of functions are those of the standard's headers, which fmpy brings along.
#[test]
fn required_functions_are_those_of_the_headers() {
    let Some(python) = python() else { return };
    let script = "import fmpy, pathlib; print(pathlib.Path(fmpy.__file__).parent / 'c-code')";
    let output = std::process::Command::new(python).args(["-c", script]).output().unwrap();
    let folder = String::from_utf8(output.stdout).unwrap();
    for (version, header) in
        [(FmiVersion::V2, "fmi2FunctionTypes.h"), (FmiVersion::V3, "fmi3FunctionTypes.h")]
    {
        let text = std::fs::read_to_string(Path::new(folder.trim()).join(header)).unwrap();
        let mut declared: Vec<&str> = text
            .split(|c: char| !c.is_ascii_alphanumeric())
            .filter_map(|word| word.strip_suffix("TYPE"))
            // The header's comments mention functions of FMI 1.0.
            .filter(|name| name.starts_with("fmi2") || name.starts_with("fmi3"))
            .collect();
        let mut description = stage(version);
        let common = description.co_simulation.as_ref().unwrap().common.clone();
        description.scheduled_execution = Some(common);
        description.model_exchange = Some(Default::default());
        let mut required = required_functions(&description);
        declared.sort();
        declared.dedup();
        required.sort();
        required.dedup();
        assert_eq!(required, declared, "{header}");
    }
}

#[test]
fn a_draft_of_the_standard_is_stated() {
    let text = |version: &str| {
        three("", "").replace("fmiVersion=\"3.0\"", &format!("fmiVersion=\"{version}\""))
    };
    for draft in ["3.0-beta.2", "3.0-rc.1", "3.0-alpha.5"] {
        let problems = check_description(text(draft).as_bytes());
        let message = listing(&problems);
        assert!(
            message.contains(draft) && message.contains("is a draft of the standard"),
            "{message}"
        );
        let read = ModelDescription::parse(text(draft).as_bytes()).unwrap();
        assert_eq!((read.draft.as_deref(), read.fmi_version), (Some(draft), FmiVersion::V3));
        assert!(read.to_xml().unwrap().contains(&format!("fmiVersion=\"{draft}\"")));
    }
    assert!(!listing(&check_description(text("3.0").as_bytes())).contains("draft"));
    assert!(!listing(&check_description(text("3.0.1").as_bytes())).contains("draft"));
}
