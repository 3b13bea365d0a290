//! SSP: what is written is read back, what is wrong is told with file and line, hierarchy and
//! parameter bindings are resolved, hostile archives are refused, and foreign tools agree.
#![allow(clippy::print_stdout)]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use modeldescription::description::{BaseUnit, Line, Unit};
use modeldescription::ssp::*;

fn unit(name: &str, base: BaseUnit) -> Unit {
    Unit { name: name.to_owned(), base: Some(base), display_units: Vec::new(), line: Line(0) }
}

fn connector(name: &str, kind: Kind, unit: Option<&str>) -> Connector {
    Connector { data_type: Some(ConnectorType::real(unit)), ..Connector::new(name, kind) }
}

fn end(element: &str, connector: &str) -> End {
    let element = (!element.is_empty()).then(|| element.to_owned());
    End { element, connector: connector.to_owned() }
}

fn parameter(name: &str, value: f64, unit: Option<&str>) -> Parameter {
    Parameter {
        name: name.to_owned(),
        value: ParameterValue::Real(vec![value]),
        unit: unit.map(str::to_owned),
        line: Line(0),
    }
}

/// A stage inside a system of its own, a controller outside, parameters in every place.
fn structure() -> SystemStructure {
    let mut plant = Component::new("stage", "resources/stage.fmu");
    plant.connectors = vec![
        connector("command[1]", Kind::Input, Some("V")),
        connector("position[1]", Kind::Output, Some("um")),
    ];
    plant.bindings = vec![Binding::inline(ParameterSet {
        parameters: vec![parameter("gain", 1.0, None), parameter("mass", 2.0, None)],
        ..ParameterSet::new("inner")
    })];
    let mut machine = System::new("machine");
    machine.connectors =
        vec![connector("u", Kind::Input, Some("V")), connector("y", Kind::Output, Some("m"))];
    machine.elements = vec![Element::Component(plant)];
    machine.connections = vec![
        Connection::new(end("", "u"), end("stage", "command[1]")),
        Connection::new(end("stage", "position[1]"), end("", "y")),
    ];
    let mut controller = Component::new("controller", "resources/controller.fmu");
    controller.connectors = vec![
        connector("reference[1]", Kind::Input, Some("um")),
        connector("measured[1]", Kind::Input, Some("um")),
        connector("command[1]", Kind::Output, None),
    ];
    let mut structure = SystemStructure::new("loop \"a\" <b> & ü");
    structure.units = vec![
        unit("V", BaseUnit { kg: 1, m: 2, s: -3, a: -1, ..BaseUnit::default() }),
        unit("m", BaseUnit { m: 1, ..BaseUnit::default() }),
        unit("um", BaseUnit { m: 1, factor: 1e-6, ..BaseUnit::default() }),
    ];
    structure.enumerations = vec![Enumeration {
        name: "mode".to_owned(),
        items: vec![("off".to_owned(), 0), ("on".to_owned(), 3)],
        line: Line(0),
    }];
    structure.default_experiment = Experiment { start_time: Some(0.5), stop_time: Some(1e-300) };
    let system = &mut structure.system;
    system.connectors = vec![
        connector("r", Kind::Input, Some("um")),
        connector("position", Kind::Output, Some("m")),
    ];
    system.elements = vec![Element::System(machine), Element::Component(controller)];
    let mut scaled = Connection::new(end("controller", "command[1]"), end("machine", "u"));
    scaled.transformation = Some(Transformation::Linear { factor: -2.5, offset: 0.1 });
    scaled.suppress_unit_conversion = true;
    system.connections = vec![
        Connection::new(end("", "r"), end("controller", "reference[1]")),
        scaled,
        // Start and end say nothing about the direction.
        Connection::new(end("controller", "measured[1]"), end("machine", "y")),
        Connection::new(end("machine", "y"), end("", "position")),
    ];
    system.annotations = vec![Annotation { kind: "org.example".to_owned(), content: None }];
    let mode = Parameter {
        name: "mode".to_owned(),
        value: ParameterValue::Enumeration(vec!["on".to_owned()], Some("mode".to_owned())),
        unit: None,
        line: Line(0),
    };
    let values = ParameterSet {
        parameters: vec![parameter("g", 7.0, Some("um")), mode, parameter("unused", 1.0, None)],
        ..ParameterSet::new("outer")
    };
    let entry = |source: &str, target: &str, transformation| MappingEntry {
        source: source.to_owned(),
        target: target.to_owned(),
        transformation,
        suppress_unit_conversion: false,
        line: Line(0),
    };
    let double = Some(Transformation::Linear { factor: 2.0, offset: 0.0 });
    let mapping = ParameterMapping {
        version: "1.0".to_owned(),
        entries: vec![
            entry("set.g", "machine.stage.gain", double),
            entry("set.mode", "machine.stage.mode", None),
        ],
    };
    system.bindings = vec![Binding {
        prefix: "set.".to_owned(),
        source: Source::File("parameters/outer.ssv".to_owned()),
        values: Some(values),
        mapping: Some(Mapping {
            source: Source::File("parameters/outer.ssm".to_owned()),
            mapping: Some(mapping),
            line: Line(0),
        }),
        line: Line(0),
    }];
    structure
}

fn packed(folder: &Path) -> PathBuf {
    let path = folder.join("loop ü.ssp");
    let mut builder = SspBuilder::new(&structure()).unwrap();
    builder.entry("resources/stage.fmu", b"an FMU".to_vec()).unwrap();
    builder.entry("resources/controller.fmu", b"another".to_vec()).unwrap();
    builder.write(&path).unwrap();
    path
}

#[test]
fn what_is_written_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let ssp = Ssp::open(packed(folder.path())).unwrap();
    assert_eq!(*ssp.structure(), structure());
    let stage = ssp.file("resources/stage.fmu").unwrap();
    assert_eq!(std::fs::read(stage).unwrap(), b"an FMU");
    let first = std::fs::read(packed(folder.path())).unwrap();
    assert_eq!(first, std::fs::read(packed(folder.path())).unwrap(), "the same bytes");
}

#[test]
fn hierarchy_and_bindings_are_resolved() {
    let structure = structure();
    let flat = structure.flatten("SystemStructure.ssd").unwrap();
    let paths: Vec<&str> = flat.components.iter().map(|c| c.path.as_str()).collect();
    assert_eq!(paths, ["machine.stage", "controller"]);

    let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
    let found: Vec<_> = flat.connections.iter().map(|c| (c.from.clone(), c.to.clone())).collect();
    assert!(
        found.contains(&(pair("controller", "command[1]"), pair("machine.stage", "command[1]")))
    );
    assert!(
        found.contains(&(pair("machine.stage", "position[1]"), pair("controller", "measured[1]")))
    );
    assert_eq!(found.len(), 2);

    let command = flat.connections.iter().find(|c| c.to.1 == "command[1]").unwrap();
    let factors: Vec<_> = command.way.iter().map(|step| step.transformation).collect();
    assert_eq!(factors, [Some((-2.5, 0.1)), None]);
    assert!(command.way[0].suppress_unit_conversion);
    let measured = flat.connections.iter().find(|c| c.to.1 == "measured[1]").unwrap();
    let units: Vec<_> = measured
        .way
        .iter()
        .map(|step| {
            (step.from.as_ref().unwrap().name.as_str(), step.to.as_ref().unwrap().name.as_str())
        })
        .collect();
    assert_eq!(units, [("um", "m"), ("m", "um")]);

    assert_eq!(flat.inputs.len(), 1);
    assert_eq!(
        (flat.inputs[0].connector.as_str(), &flat.inputs[0].to),
        ("r", &pair("controller", "reference[1]"))
    );
    assert_eq!(
        (flat.outputs[0].connector.as_str(), &flat.outputs[0].from),
        ("position", &pair("machine.stage", "position[1]"))
    );

    // The outer value replaces the inner one; what the mapping does not name is not applied.
    let starts: Vec<_> = flat
        .starts
        .iter()
        .map(|s| (s.to.1.as_str(), s.value.clone(), s.way.transformation))
        .collect();
    assert_eq!(
        starts,
        [
            ("mass", ParameterValue::Real(vec![2.0]), None),
            ("gain", ParameterValue::Real(vec![7.0]), Some((2.0, 0.0))),
            ("mode", ParameterValue::Integer(vec![3]), None),
        ]
    );
}

/// All problems of an SSD, as text.
fn problems(system: &str, rest: &str) -> Vec<String> {
    let text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <s:SystemStructureDescription version=\"1.0\" name=\"n\" \
         xmlns:s=\"http://ssp-standard.org/SSP1/SystemStructureDescription\" \
         xmlns:ssc=\"http://ssp-standard.org/SSP1/SystemStructureCommon\">\n\
         {system}\n{rest}</s:SystemStructureDescription>"
    );
    let problems = match SystemStructure::parse(text.as_bytes(), "a.ssd") {
        Ok(structure) => structure.flatten("a.ssd").err().unwrap_or_default(),
        Err(problems) => problems,
    };
    problems.iter().map(ToString::to_string).collect()
}

#[test]
fn every_problem_is_told_with_file_line_rule_and_way_out() {
    let component = |name: &str| {
        format!(
            "<s:Component name=\"{name}\" source=\"x.fmu\"><s:Connectors>\n\
             <s:Connector name=\"u\" kind=\"input\"><ssc:Real unit=\"lightyear\"/></s:Connector>\n\
             <s:Connector name=\"y\" kind=\"output\"/></s:Connectors></s:Component>"
        )
    };
    let connection = |start: &str, end: &str| {
        format!(
            "<s:Connection startElement=\"a\" startConnector=\"{start}\" endElement=\"b\" \
             endConnector=\"{end}\"/>\n"
        )
    };
    let text = format!(
        "<s:System name=\"top\"><s:Elements>{}\n{}\n{}</s:Elements><s:Connections>\n{}{}{}{}\
         <s:Connection startElement=\"c\" startConnector=\"y\" endElement=\"b\" \
         endConnector=\"u\"/></s:Connections></s:System>",
        component("a"),
        component("b"),
        component("b"),
        connection("y", "u"),
        connection("y", "u"),
        connection("u", "u"),
        connection("z", "u"),
    );
    let found = problems(&text, "");
    for (line, words) in [
        (4, "unit \"lightyear\" is not defined"),
        (7, "unit \"lightyear\" is not defined"),
        (9, "two elements are called \"b\""),
        (13, "\"b.u\" has a second source; the first is at line 12"),
        (14, "joins two connectors that both take"),
        (15, "the connector \"a.z\", which is not declared"),
        (16, "names the element \"c\""),
    ] {
        let wanted = format!("a.ssd:{line}: error: ");
        let hit = found.iter().any(|text| text.starts_with(&wanted) && text.contains(words));
        assert!(hit, "{wanted}{words} is not among\n{}", found.join("\n"));
    }
    assert_eq!(found.len(), 7, "{}", found.join("\n"));
}

#[test]
fn what_cannot_be_read_is_told() {
    let cases = [
        ("", "<s:SystemStructureDescription> has no <System>"),
        ("<s:System name=\"\"/>", "has an empty name"),
        ("<s:System/>", "<s:System> has no attribute name"),
        (
            "<s:System name=\"t\"><s:Elements><s:Component name=\"a\"/></s:Elements></s:System>",
            "<s:Component> has no attribute source",
        ),
        (
            "<s:System name=\"t\"><s:Connectors><s:Connector name=\"a\" kind=\"ear\"/>\
             </s:Connectors></s:System>",
            "kind=\"ear\"",
        ),
        (
            "<s:System name=\"t\"><s:ParameterBindings><s:ParameterBinding/>\
             </s:ParameterBindings></s:System>",
            "<s:ParameterBinding> has neither",
        ),
        (
            "<s:System name=\"t\"><s:Elements><s:SignalDictionaryReference name=\"d\"/>\
             </s:Elements></s:System>",
            "<s:SignalDictionaryReference> has no attribute dictionary",
        ),
        (
            "<s:System name=\"t\"><s:Connectors><s:Connector name=\"a\" kind=\"input\">\
             <s:Clock/></s:Connector></s:Connectors></s:System>",
            "clocks of SSP 2.0 are not supported",
        ),
    ];
    for (text, words) in cases {
        let found = problems(text, "");
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        assert!(found[0].starts_with("a.ssd:3:") || text.is_empty(), "{}", found[0]);
        assert!(found[0].contains(words), "{}", found[0]);
    }
    let wrong = problems(
        "<s:System name=\"t\"/>",
        "<s:Units><ssc:Unit name=\"m\"><ssc:BaseUnit m=\"one\" factor=\"0\"/></ssc:Unit></s:Units>",
    );
    assert_eq!(wrong.len(), 2, "{wrong:?}");
    let root = SystemStructure::parse(b"<a/>", "a.ssd").unwrap_err();
    assert!(root[0].to_string().contains("the root element is <a>"));
    let set = ParameterSet::parse(
        b"<ParameterSet xmlns=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\" \
          version=\"1.0\" name=\"n\"><Parameters>\n<Parameter name=\"a\"><Real value=\"x\"/>\
          </Parameter>\n<Parameter name=\"b\"/><Parameter name=\"c\"><Integer value=\"1.5\"/>\
          </Parameter></Parameters></ParameterSet>",
        "a.ssv",
    );
    let texts: Vec<String> = set.unwrap_err().iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), 3, "{texts:?}");
    assert!(texts[0].starts_with("a.ssv:2: error: <Real> has value=\"x\""), "{}", texts[0]);
    assert!(texts[1].starts_with("a.ssv:3: "), "{}", texts[1]);
}

/// An archive of these entries, made without any check.
fn archive(path: &Path, entries: &[(&str, &[u8])]) {
    let mut zip = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    for (name, content) in entries {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap();
}

/// A controller outside and a stage in a system inside, which meet in a dictionary only.
fn meeting() -> SystemStructure {
    let reference = |name: &str, kind: Kind| {
        Element::Dictionary(DictionaryReference {
            name: name.to_owned(),
            dictionary: "bus".to_owned(),
            connectors: vec![Connector::new("command", kind)],
            line: Line(0),
        })
    };
    let mut structure = SystemStructure::new("meeting");
    let volt = BaseUnit { kg: 1, m: 2, s: -3, a: -1, ..BaseUnit::default() };
    structure.units = vec![unit("V", volt)];
    let mut plant = Component::new("stage", "resources/stage.fmu");
    plant.connectors = vec![connector("command[1]", Kind::Input, Some("V"))];
    let mut machine = System::new("machine");
    machine.elements = vec![Element::Component(plant), reference("inner", Kind::Output)];
    machine.connections =
        vec![Connection::new(end("stage", "command[1]"), end("inner", "command"))];
    let mut controller = Component::new("controller", "resources/controller.fmu");
    controller.connectors = vec![connector("u", Kind::Output, Some("V"))];
    let mut bus =
        SignalDictionary::inline("bus", vec![connector("command", Kind::Inout, Some("mV"))]);
    bus.units = vec![unit("mV", BaseUnit { factor: 1e-3, ..volt })];
    let system = &mut structure.system;
    system.name = "meeting".to_owned();
    system.dictionaries = vec![bus];
    system.elements = vec![
        Element::System(machine),
        Element::Component(controller),
        reference("outer", Kind::Inout),
    ];
    system.connections = vec![Connection::new(end("controller", "u"), end("outer", "command"))];
    structure
}

#[test]
fn what_meets_in_a_signal_dictionary_is_connected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("meeting.ssp");
    let mut structure = meeting();
    for source in [Source::Inline, Source::File("signals.ssb".to_owned())] {
        structure.system.dictionaries[0].source = source;
        let mut builder = SspBuilder::new(&structure).unwrap();
        builder.entry("resources/stage.fmu", Vec::new()).unwrap();
        builder.write(&path).unwrap();
        let read = Ssp::open(&path).unwrap();
        let list = &read.structure().system.dictionaries[0];
        assert_eq!(list.signals.as_ref().unwrap()[0].name, "command");
        let flat = read.structure().flatten("SystemStructure.ssd").unwrap();
        let [connection] = &flat.connections[..] else { panic!("{:?}", flat.connections) };
        assert_eq!(connection.from, ("controller".to_owned(), "u".to_owned()));
        assert_eq!(connection.to, ("machine.stage".to_owned(), "command[1]".to_owned()));
        let units = |way: &Linear| [&way.from, &way.to].map(|u| u.clone().unwrap().name);
        let way: Vec<_> = connection.way.iter().map(units).collect();
        assert_eq!(way, [["V", "mV"], ["mV", "V"]]);
    }
}

#[test]
fn what_is_wrong_with_a_signal_dictionary_is_told() {
    let described = |change: &dyn Fn(&mut SystemStructure)| {
        let mut structure = meeting();
        change(&mut structure);
        let found = structure.flatten("a.ssd").unwrap_err();
        found.iter().map(|problem| format!("{problem}\n")).collect::<String>()
    };
    let nothing = described(&|s| s.system.dictionaries[0].name = "other".to_owned());
    assert!(nothing.contains("there is no signal dictionary \"bus\""), "{nothing}");
    let no_signal = described(&|s| s.system.dictionaries[0].signals = Some(Vec::new()));
    assert!(no_signal.contains("\"bus\" has no signal \"command\""), "{no_signal}");
    let twice = described(&|s| {
        let Element::Component(controller) = &mut s.system.elements[1] else { return };
        controller.connectors.push(connector("v", Kind::Output, Some("V")));
        let second = Connection::new(end("controller", "v"), end("outer", "command"));
        s.system.connections.push(second);
    });
    assert!(twice.contains("\"outer.command\" has a second source"), "{twice}");
}

#[test]
fn parameters_inside_a_component_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let within = ParameterSet {
        parameters: vec![parameter("gain", 4.0, None)],
        ..ParameterSet::new("within")
    };
    let fmu = folder.path().join("stage.fmu");
    let content = within.to_xml().unwrap();
    archive(&fmu, &[("resources/my values.ssv", content.as_bytes())]);
    let fmu = std::fs::read(fmu).unwrap();
    let open = |source: &str, of_system: bool| {
        let mut binding = Binding::inline(ParameterSet::new("unread"));
        binding.source = Source::InComponent(source.to_owned());
        binding.values = None;
        let mut component = Component::new("stage", "resources/stage.fmu");
        let mut structure = SystemStructure::new("one");
        match of_system {
            true => structure.system.bindings.push(binding),
            false => component.bindings.push(binding),
        }
        structure.system.elements.push(Element::Component(component));
        let path = folder.path().join("one.ssp");
        let mut builder = SspBuilder::new(&structure).unwrap();
        builder.entry("resources/stage.fmu", fmu.clone()).unwrap();
        builder.write(&path).unwrap();
        Ssp::open(path).map(|ssp| ssp.structure().system.elements[0].clone())
    };
    let Element::Component(stage) = open("resources/my%20values.ssv", false).unwrap() else {
        panic!("a component")
    };
    let read = stage.bindings[0].values.as_ref().unwrap();
    assert_eq!(read.parameters[0].value, ParameterValue::Real(vec![4.0]));
    for (source, of_system, words) in [
        ("resources/other.ssv", false, "there is no file \"resources/other.ssv\" in "),
        ("../stage.ssv", false, "leads out of the SSP"),
        ("resources/my%20values.ssv", true, "the binding is a system's"),
    ] {
        let refused = open(source, of_system).unwrap_err().to_string();
        assert!(
            refused.starts_with("SystemStructure.ssd:") && refused.contains(words),
            "{refused}"
        );
    }
}

#[test]
fn hostile_archives_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("evil.ssp");
    let refused = |entries: &[(&str, &[u8])]| {
        archive(&path, entries);
        Ssp::open(&path).unwrap_err().to_string()
    };
    let climbs = refused(&[("SystemStructure.ssd", b"<a/>"), ("../evil", b"x")]);
    assert!(climbs.contains("\"..\""), "{climbs}");
    let bomb = b"<!DOCTYPE a [<!ENTITY x \"ha\">]><a b=\"&x;\"/>";
    let doctype = refused(&[("SystemStructure.ssd", bomb)]);
    assert!(doctype.starts_with("SystemStructure.ssd:1: ") && doctype.contains("DOCTYPE"));
    assert!(refused(&[("other.ssd", b"<a/>")]).contains("there is no SystemStructure.ssd"));
    let text = structure().to_xml().unwrap().replace("parameters/outer.ssv", "../../etc/passwd");
    let outside = refused(&[("SystemStructure.ssd", text.as_bytes())]);
    assert!(outside.contains("\"../../etc/passwd\" leads out of the SSP"), "{outside}");
    for source in ["/etc/passwd", "file:///etc/passwd", "%2e%2e/x", "a/%2e%2e/b", "http://a/b"] {
        archive(
            &path,
            &[("SystemStructure.ssd", SystemStructure::new("n").to_xml().unwrap().as_bytes())],
        );
        let ssp = Ssp::open(&path).unwrap();
        assert!(ssp.file(source).unwrap_err().contains("leads out of the SSP"), "{source}");
    }
    let mut builder = SspBuilder::new(&SystemStructure::new("n")).unwrap();
    for name in ["../a", "/a", "a//b", "SystemStructure.ssd", "C:a", "a\\b"] {
        assert!(builder.entry(name, Vec::new()).is_err(), "{name}");
    }
}

#[test]
fn damaged_files_never_panic() {
    let text = structure().to_xml().unwrap();
    for cut in (0..text.len()).step_by(7).filter(|cut| text.is_char_boundary(*cut)) {
        let _ = SystemStructure::parse(&text.as_bytes()[..cut], "a.ssd");
        let mut bytes = text.clone().into_bytes();
        bytes[cut] = b'"';
        if let Ok(structure) = SystemStructure::parse(&bytes, "a.ssd") {
            let _ = structure.flatten("a.ssd");
        }
    }
}

/// A Python that has this module, from the tests' environment or the one that is named.
fn python(module: &str) -> Option<PathBuf> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).parent()?;
    let own = |name: &str| Some(workspace.join(format!("target/{name}/bin/python")));
    let named = |name: &str| std::env::var_os(name).map(PathBuf::from);
    let all = [
        named("PIEZOLOOP_PYTHON"),
        named("PIEZOLOOP_FOREIGN_PYTHON"),
        own("python-env"),
        own("python-foreign"),
    ];
    all.into_iter().flatten().find(|python| {
        let import = format!("import {module}");
        Command::new(python).args(["-c", &import]).output().is_ok_and(|o| o.status.success())
    })
}

fn read_by(module: &str, script: &str) {
    let Some(python) = python(module) else {
        println!("SKIPPED: no Python with {module}; the tests of the tool make one below target/");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let ssp = packed(folder.path());
    let output = Command::new(python).args(["-c", script]).arg(ssp).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.lines().any(|line| line == "read"), "{text}");
}

#[test]
fn fmpy_reads_ours_and_its_schemas_hold() {
    read_by(
        "fmpy.ssp.ssd",
        r#"
import sys
from fmpy.ssp.ssd import read_ssd, find_components, get_connections
ssd = read_ssd(sys.argv[1])
assert ssd.name == 'loop "a" <b> & ü', ssd.name
assert [c.name for c in find_components(ssd.system)] == ["controller", "stage"]
assert {u.name: u.factor for u in ssd.units} == {"V": 1.0, "m": 1.0, "um": 1e-6}
binding = ssd.system.parameterBindings[0]
assert [(p.name, p.value, p.unit) for p in binding.parameterValues[0].parameters][0] == ("g", "7.0", "um")
entry = binding.parameterMapping[0].mappingEntries[0]
assert (entry.source, entry.target) == ("set.g", "machine.stage.gain")
assert float(entry.transformation.factor) == 2.0
print("read")
"#,
    );
}

#[test]
fn pyssp_standard_reads_ours_and_finds_it_compliant() {
    read_by(
        "pyssp_standard",
        r#"
import sys
from pyssp_standard.ssp import SSP
with SSP(sys.argv[1], mode="r") as ssp:
    with ssp.system_structure as ssd:
        ssd.__check_compliance__()
        assert ssd.name == 'loop "a" <b> & ü', ssd.name
print("read")
"#,
    );
}
