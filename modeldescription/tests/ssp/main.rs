//! SSP: what is written is read back, what is wrong is reported with file and line, hierarchy and
//! parameter bindings are resolved, hostile archives are refused, and foreign tools agree.
#![allow(clippy::print_stdout)]

mod foreign;
mod systems;
mod wrong;

use modeldescription::ssp::*;

use self::systems::*;

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
