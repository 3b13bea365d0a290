//! Systems that the tests write, and the files made of them.

use std::io::Write;
use std::path::{Path, PathBuf};

use modeldescription::description::{BaseUnit, Line, Unit};
use modeldescription::ssp::*;

pub(crate) fn unit(name: &str, base: BaseUnit) -> Unit {
    Unit { name: name.to_owned(), base: Some(base), display_units: Vec::new(), line: Line(0) }
}

pub(crate) fn connector(name: &str, kind: Kind, unit: Option<&str>) -> Connector {
    Connector { data_type: Some(ConnectorType::real(unit)), ..Connector::new(name, kind) }
}

pub(crate) fn end(element: &str, connector: &str) -> End {
    let element = (!element.is_empty()).then(|| element.to_owned());
    End { element, connector: connector.to_owned() }
}

pub(crate) fn parameter(name: &str, value: f64, unit: Option<&str>) -> Parameter {
    Parameter {
        name: name.to_owned(),
        value: ParameterValue::Real(vec![value]),
        unit: unit.map(str::to_owned),
        line: Line(0),
    }
}

/// A stage inside a system of its own, a controller outside, parameters in every place.
pub(crate) fn structure() -> SystemStructure {
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

pub(crate) fn packed(folder: &Path) -> PathBuf {
    let path = folder.join("loop ü.ssp");
    let mut builder = SspBuilder::new(&structure()).unwrap();
    builder.entry("resources/stage.fmu", b"an FMU".to_vec()).unwrap();
    builder.entry("resources/controller.fmu", b"another".to_vec()).unwrap();
    builder.write(&path).unwrap();
    path
}

/// An archive of these entries, made without any check.
pub(crate) fn archive(path: &Path, entries: &[(&str, &[u8])]) {
    let mut zip = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    for (name, content) in entries {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap();
}

/// A controller outside and a stage in a system inside, which meet in a dictionary only.
pub(crate) fn meeting() -> SystemStructure {
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
