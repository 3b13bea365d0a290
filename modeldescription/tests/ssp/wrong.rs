//! What is wrong is reported with file and line; hostile archives are refused.

use modeldescription::ssp::*;

use super::systems::*;

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
fn every_problem_is_reported_with_file_line_rule_and_way_out() {
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
fn what_cannot_be_read_is_reported() {
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

#[test]
fn what_is_wrong_with_a_signal_dictionary_is_reported() {
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
