//! Systems as other tools write them: empty units and elements, SSDs in plain folders, arrays of SSP 2.0,
//! bindings that reach nothing, the file of the Open Simulation Platform.
#![allow(clippy::print_stdout)]

use crate::common;
use std::fs;
use std::path::{Path, PathBuf};

use common::Fmus;
use cosim::{Fmu, InstanceOptions, Memory, Plan, Points, Run, Signals};

const NAMESPACES: &str = "xmlns:ssd=\"http://ssp-standard.org/SSP1/SystemStructureDescription\" \
    xmlns:ssv=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\" \
    xmlns:ssc=\"http://ssp-standard.org/SSP1/SystemStructureCommon\" \
    xmlns:ssm=\"http://ssp-standard.org/SSP1/SystemStructureParameterMapping\"";

/// An SSD of version 2.0 with this content of its system.
fn ssd(system: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<ssd:SystemStructureDescription {NAMESPACES} version=\"2.0\" \
         name=\"s\">\n<ssd:System name=\"root\">\n{system}\n</ssd:System>\n\
         </ssd:SystemStructureDescription>\n"
    )
}

/// A component with its connectors, on two lines.
fn component(name: &str, source: &str, content: &str) -> String {
    format!("<ssd:Component name=\"{name}\" source=\"{source}\">\n{content}</ssd:Component>\n")
}

/// Writes an SSD under a name of its own; the FMUs lie beside it.
fn written(fmus: &Fmus, system: &str) -> PathBuf {
    let file = fmus.path("mine.ssd");
    fs::write(&file, ssd(system)).unwrap();
    file
}

/// Runs over 4 steps of 1 s with ones at all inputs; the record and the notes.
fn run(file: &Path) -> Result<(Memory, Vec<String>, Vec<String>), String> {
    let plan = Plan::read(file).map_err(|error| error.to_string())?;
    let open = |fmu: &cosim::plan::PlannedFmu| Fmu::open(&fmu.path).map_err(|e| e.to_string());
    let fmus = plan.fmus.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    let named = plan.fmus.iter().zip(&fmus);
    let slaves =
        named.map(|(planned, fmu)| fmu.instantiate(&planned.name, &InstanceOptions::default()));
    let slaves = slaves.collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
    let mut prepared = plan.prepare(slaves, 1.0, &[]).map_err(|error| error.to_string())?;
    let (time, ones) = ([0.0, 1.0, 2.0, 3.0, 4.0], [1.0; 5]);
    let columns = plan.columns();
    let signals = columns.iter().fold(Signals::new(&time), |all, name| all.with(*name, &ones));
    let run = Run::new(Points::uniform(0.0, 4.0, 1.0).unwrap(), &signals);
    let mut memory = Memory::new();
    prepared.system.run(&run, &*prepared.algorithm, &mut memory).map_err(|e| e.to_string())?;
    Ok((memory, prepared.notes, prepared.unfed))
}

const INTEGRATOR: &str = "<ssd:Connectors>\n\
    <ssd:Connector name=\"command[1]\" kind=\"input\"><ssc:Real unit=\"\"/></ssd:Connector>\n\
    <ssd:Connector name=\"position[1]\" kind=\"output\"><ssc:Real unit=\" \"/></ssd:Connector>\n\
    </ssd:Connectors>\n";

fn integrator(fmus: &Fmus) -> String {
    fmus.pack("integrator", &common::integrator());
    fs::rename(fmus.path("integrator é.fmu"), fmus.path("plant.fmu")).unwrap();
    component("p", "plant.fmu", INTEGRATOR)
}

#[test]
fn empty_units_elements_and_attributes_say_nothing() {
    let fmus = fmus_or_skip!();
    let system = format!(
        "<ssd:Connectors><ssd:Connector name=\"in\" kind=\"input\"><ssc:Real unit=\"\"/></ssd:Connector>\
         <ssd:Connector name=\"out\" kind=\"output\"><ssc:Real/></ssd:Connector></ssd:Connectors>\
         <ssd:ParameterBindings/><ssd:Elements>{}</ssd:Elements><ssd:Connections>\
         <ssd:Connection startElement=\"\" startConnector=\"in\" endElement=\"p\" endConnector=\"command[1]\" \
         suppressUnitConversion=\"\"/>\
         <ssd:Connection startElement=\"p\" startConnector=\"position[1]\" endElement=\"\" endConnector=\"out\">\
         <ssc:LinearTransformation factor=\"\" offset=\"\"/></ssd:Connection></ssd:Connections>",
        integrator(&fmus).replace("source=", "implementation=\"\" type=\"\" source=")
    );
    let (memory, notes, unfed) = run(&written(&fmus, &system)).unwrap();
    assert_eq!(memory.values("p.position[1]").unwrap(), [0.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(notes, Vec::<String>::new());
    assert_eq!(unfed, ["p.misbehaviour", "p.enabled"]);
}

#[test]
fn a_fault_is_blamed_on_its_file_and_line() {
    let fmus = fmus_or_skip!();
    let component = integrator(&fmus);
    let elements = |content: &str| format!("<ssd:Elements>{content}</ssd:Elements>");
    // In the SSD, whatever it is called.
    let unit = component.replace("unit=\" \"", "unit=\"furlong\"");
    let message = run(&written(&fmus, &elements(&unit))).unwrap_err();
    assert!(message.contains("mine.ssd:7: error: unit \"furlong\" is not defined"), "{message}");
    let message =
        run(&written(&fmus, &elements(&component.replace("plant.fmu", "none.fmu")))).unwrap_err();
    assert!(
        message.contains("mine.ssd:4: component \"p\": there is no file \"none.fmu\""),
        "{message}"
    );
    // In a parameter set of its own.
    let set = format!(
        "<?xml version=\"1.0\"?>\n<ssv:ParameterSet {NAMESPACES} version=\"1.0\" name=\"s\"><ssv:Parameters>\n\
         <ssv:Parameter name=\"p.k\"><ssv:Real value=\"2\"/></ssv:Parameter>\n\n\
         <ssv:Parameter name=\"p.limit\"><ssv:Real value=\"7\" unit=\"cubit\"/></ssv:Parameter>\n\
         </ssv:Parameters></ssv:ParameterSet>\n"
    );
    fs::write(fmus.path("set.ssv"), &set).unwrap();
    let bound = format!(
        "<ssd:ParameterBindings><ssd:ParameterBinding source=\"set.ssv\"/></ssd:ParameterBindings>{}",
        elements(&component)
    );
    let message = run(&written(&fmus, &bound)).unwrap_err();
    assert!(message.contains("set.ssv:5: error: unit \"cubit\" is not defined"), "{message}");
    fs::write(fmus.path("set.ssv"), set.replace(" unit=\"cubit\"", "")).unwrap();
    let file = written(&fmus, &bound);
    assert!(run(&file).is_ok());
    let missing = fs::read_to_string(&file).unwrap().replace("set.ssv", "other.ssv");
    fs::write(&file, missing).unwrap();
    let message = run(&file).unwrap_err();
    assert!(message.contains("mine.ssd:4: error: there is no file \"other.ssv\""), "{message}");
}

#[test]
fn bindings_that_reach_nothing_are_named() {
    let fmus = fmus_or_skip!();
    let parameter = |name: &str| {
        format!("<ssv:Parameter name=\"{name}\"><ssv:Real value=\"3\"/></ssv:Parameter>\n")
    };
    let names = ["p.k", "p.nothing", "q.k", "k"];
    let set: String = names.iter().map(|name| parameter(name)).collect();
    let system = format!(
        "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>\
         <ssv:ParameterSet version=\"1.0\" name=\"a\"><ssv:Parameters>\n{set}</ssv:Parameters></ssv:ParameterSet>\
         </ssd:ParameterValues></ssd:ParameterBinding><ssd:ParameterBinding><ssd:ParameterValues>\
         <ssv:ParameterSet version=\"1.0\" name=\"b\"><ssv:Parameters>\n{}{}</ssv:Parameters></ssv:ParameterSet>\
         </ssd:ParameterValues><ssd:ParameterMapping><ssm:ParameterMapping version=\"1.0\">\
         <ssm:MappingEntry source=\"x\" target=\"p.limit\"/>\
         <ssm:MappingEntry source=\"z\" target=\"p.end\"/></ssm:ParameterMapping></ssd:ParameterMapping>\
         </ssd:ParameterBinding></ssd:ParameterBindings><ssd:Elements>{}</ssd:Elements>",
        parameter("x"),
        parameter("y"),
        integrator(&fmus)
    );
    let (_, notes, _) = run(&written(&fmus, &system)).unwrap();
    let contains = |words: &[&str]| {
        assert!(
            notes.iter().any(|note| words.iter().all(|word| note.contains(word))),
            "{words:?} in {notes:#?}"
        );
    };
    contains(&["mine.ssd:6: parameter \"p.nothing\"", "FMU `p` has no `nothing`"]);
    contains(&["mine.ssd:7: parameter \"q.k\" is ignored", "reaches no variable"]);
    contains(&["mine.ssd:8: parameter \"k\" is ignored", "reaches no variable"]);
    contains(&["parameter \"y\" is ignored: the mapping does not name it"]);
    contains(&["the mapping of \"z\" is ignored: the parameter set has no such parameter"]);
    assert_eq!(notes.len(), 5, "{notes:#?}");
}

#[test]
fn a_plain_folder_may_name_fmus_beside_it_and_an_archive_may_not() {
    let fmus = fmus_or_skip!();
    let component = integrator(&fmus).replace("plant.fmu", "../plant.fmu");
    let text = ssd(&format!("<ssd:Elements>{component}</ssd:Elements>"));
    let folder = fmus.path("system");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("SystemStructure.ssd"), &text).unwrap();
    assert!(run(&folder).is_ok());
    assert!(run(&folder.join("SystemStructure.ssd")).is_ok());
    let archive = fmus.path("s.ssp");
    let mut zip = zip::ZipWriter::new(fs::File::create(&archive).unwrap());
    zip.start_file("SystemStructure.ssd", zip::write::SimpleFileOptions::default()).unwrap();
    std::io::Write::write_all(&mut zip, text.as_bytes()).unwrap();
    zip.finish().unwrap();
    let message = run(&archive).unwrap_err();
    assert!(message.contains("leads out of the SSP"), "{message}");
    for outside in ["/etc/passwd", "file:///etc/passwd", "a/%00"] {
        fs::write(folder.join("SystemStructure.ssd"), text.replace("../plant.fmu", outside))
            .unwrap();
        assert!(run(&folder).unwrap_err().contains("leads out"), "{outside}");
    }
}

#[test]
fn arrays_are_connected_element_by_element() {
    let fmus = fmus_or_skip!();
    fmus.pack("integrator3", &common::integrator3());
    let array = |name: &str, kind: &str, dimension: &str| {
        format!(
            "<ssd:Connector name=\"{name}\" kind=\"{kind}\"><ssc:Float64/>{dimension}</ssd:Connector>"
        )
    };
    let system = |size: &str, other: &str| {
        let connectors = format!(
            "<ssd:Connectors>{}{}</ssd:Connectors>",
            array("u", "input", size),
            array("y", "output", size)
        );
        let fmu = |name: &str| component(name, "integrator3%20%C3%A9.fmu", &connectors);
        format!(
            "<ssd:Connectors>{}</ssd:Connectors><ssd:Elements>{}{}</ssd:Elements><ssd:Connections>\
             <ssd:Connection startConnector=\"in\" endElement=\"a\" endConnector=\"u\"/>\
             <ssd:Connection startElement=\"a\" startConnector=\"y\" endElement=\"b\" endConnector=\"u\"/>\
             </ssd:Connections>",
            array("in", "input", other),
            fmu("a"),
            fmu("b")
        )
    };
    let three = "<ssd:Dimension size=\"3\"/>";
    // The sizes of the FMUs are known where the system has none but for its own input.
    for size in [three, ""] {
        let (memory, ..) = run(&written(&fmus, &system(size, three))).unwrap();
        for element in 1..=3 {
            let values = |name: &str| memory.values(&format!("{name}[{element}]")).unwrap();
            assert_eq!(values("a.y"), [0.0, 1.0, 2.0, 3.0, 4.0]);
            assert_eq!(values("b.u")[..4], values("a.y")[1..]);
            assert_eq!(values("b.y"), [0.0, 1.0, 3.0, 6.0, 10.0]);
        }
    }
    let message = run(&written(&fmus, &system(three, "<ssd:Dimension size=\"2\"/>"))).unwrap_err();
    assert!(message.contains("an array of 2 elements is connected to one of 3"), "{message}");
}

#[test]
fn the_file_of_the_open_simulation_platform_is_read() {
    let fmus = fmus_or_skip!();
    integrator(&fmus);
    let controller = fmus.pack("controller", &common::controller());
    fs::create_dir_all(fmus.path("deep/er")).unwrap();
    let file = fmus.path("deep/er/OspSystemStructure.xml");
    let text = format!(
        "<?xml version=\"1.0\"?>\n<OspSystemStructure \
         xmlns=\"http://opensimulationplatform.com/MSMI/OSPSystemStructure\" version=\"0.1\">\n\
         <StartTime>0.0</StartTime><BaseStepSize>1</BaseStepSize>\n<Simulators>\n\
         <Simulator name=\"p\" source=\"../../plant.fmu\" stepSize=\"1\">\n<InitialValues>\
         <InitialValue variable=\"k\"><Real value=\"0.5\"/></InitialValue></InitialValues></Simulator>\n\
         <Simulator name=\"c\" source=\"file://{}\"><InitialValues>\
         <InitialValue variable=\"reference[1]\"><Real value=\"8\"/></InitialValue></InitialValues></Simulator>\n\
         </Simulators><Functions><LinearTransformation name=\"half\" factor=\"0.5\"/></Functions>\n<Connections>\n\
         <VariableConnection><Variable simulator=\"c\" name=\"measured[1]\"/>\
         <Variable simulator=\"p\" name=\"position[1]\"/></VariableConnection>\n\
         <SignalConnection><Variable simulator=\"c\" name=\"command[1]\"/><Signal function=\"half\" name=\"in\"/>\
         </SignalConnection><SignalConnection><Signal function=\"half\" name=\"out\"/>\
         <Variable simulator=\"p\" name=\"command[1]\"/></SignalConnection></Connections></OspSystemStructure>",
        controller.display().to_string().replace(' ', "%20")
    );
    fs::write(&file, &text).unwrap();
    let (memory, notes, _) = run(&file).unwrap();
    assert_eq!(notes, Vec::<String>::new());
    // Jacobi: c steps with y_k and gives u_{k+1}; y_{k+1} = y_k + 0.5 · (0.5 · u_k).
    let (mut y, mut u) = (vec![0.0], 0.0);
    for k in 0..4 {
        let next = y[k] + 0.25 * u;
        u = 8.0 - y[k];
        y.push(next);
    }
    assert_eq!(memory.values("p.position[1]").unwrap(), y);
    assert!(run(file.parent().unwrap()).is_ok(), "its folder is the system, too");
    // What only the FMUs can tell stands in a line, too.
    for (from, to, line, words) in [
        ("variable=\"k\"", "variable=\"gain\"", 6, "FMU `p` has no variable `gain`"),
        ("<Real value=\"0.5\"", "<String value=\"much\"", 6, "variable `k` of FMU `p`"),
        ("\"reference[1]\"", "\"command[1]\"", 7, "variable `command[1]` of FMU `c`"),
        ("\"position[1]\"", "\"positon[1]\"", 10, "did you mean `position[1]`"),
        ("\"measured[1]\"", "\"gains[1]\"", 10, "FMU `c` has no variable `gains[1]`"),
        ("p\" name=\"command[1]", "p\" name=\"position[1]", 11, "`position[1]` of FMU `p` is of"),
        ("name=\"measured[1]\"", "name=\"command[1]\"", 10, "`command[1]` of FMU `c`"),
    ] {
        fs::write(&file, text.replacen(from, to, 1)).unwrap();
        let message = run(&file).unwrap_err();
        let place = format!("OspSystemStructure.xml:{line}: ");
        assert!(message.contains(words) && message.contains(&place), "{from}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    let twice = "<Variable simulator=\"c\" name=\"command[1]\"/></VariableConnection>";
    let once = "<VariableConnection><Variable simulator=\"p\" name=\"command[1]\"/>";
    let more = text.replace("</Connections>", &format!("\n{once}{twice}</Connections>"));
    fs::write(&file, more).unwrap();
    let message = run(&file).unwrap_err();
    assert!(message.contains("two sources") && message.contains("xml:12)"), "{message}");
    assert!(message.contains("xml:11: ") && message.lines().count() == 1, "{message}");
    for (from, to, words) in [
        (
            "simulator=\"p\" name=\"position",
            "simulator=\"x\" name=\"position",
            "there is no simulator \"x\"",
        ),
        ("LinearTransformation", "VectorSum", "only LinearTransformation"),
        ("<BaseStepSize>1<", "<BaseStepSize>fast<", "\"fast\" is no finite number"),
        ("<BaseStepSize>1<", "<BaseStepSize>-1<", "a step of -1 s cannot be made"),
        ("stepSize=\"1\"", "stepSize=\"-1e-3\"", "a step of -0.001 s cannot be made"),
        (
            "<Signal function=\"half\" name=\"out\"",
            "<Signal function=\"half\" name=\"in\"",
            "two variables go into",
        ),
        ("../../plant.fmu", "proxy-fmu://there", "proxy-fmu:// is not loaded"),
        ("name=\"in\"", "name=\"inn\"", "there is no signal \"inn\""),
    ] {
        fs::write(&file, text.replace(from, to)).unwrap();
        let message = run(&file).unwrap_err();
        assert!(message.contains(words) && message.contains("OspSystemStructure.xml"), "{message}");
    }
}

/// Twenty thousand of everything, and as many mistakes: each look-up is one.
#[test]
fn a_large_file_of_the_open_simulation_platform_takes_no_time() {
    let count = 20_000;
    let mut text = "<OspSystemStructure><Simulators>".to_owned();
    (0..count).for_each(|k| text += &format!("<Simulator name=\"s{k}\" source=\"s.fmu\"/>"));
    text += "</Simulators><Functions>";
    (0..count).for_each(|k| text += &format!("<LinearTransformation name=\"f{k}\"/>"));
    text += "</Functions><Connections>";
    for k in 0..count {
        text += &format!(
            "<SignalConnection><Variable simulator=\"s{k}\" name=\"y\"/><Signal function=\"f{k}\" name=\"in\"/>\
             </SignalConnection><VariableConnection><Variable simulator=\"s{k}\" name=\"u\"/>\
             <Variable simulator=\"t{k}\" name=\"y\"/></VariableConnection>"
        );
    }
    text += "</Connections></OspSystemStructure>";
    let begin = std::time::Instant::now();
    let message = cosim::Plan::parse_osp(&text, Path::new("large.xml")).unwrap_err().to_string();
    assert!(begin.elapsed().as_secs() < 20, "{:?}", begin.elapsed());
    assert!(
        message.contains("\"t0\"")
            && message.contains("s0, s1, s10")
            && message.contains("19980 more")
    );
    assert!(message.len() < 10_000_000, "{} bytes", message.len());
}
