//! Small FMUs with one fault each: `tests/c/faulty.c`, and descriptions that lie.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::root;

/// How the description differs from the truth.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Lie {
    None,
    /// Another GUID than the library's.
    Guid,
    /// An output under a reference that the library does not know.
    Reference,
    /// A library of another name.
    Identifier,
}

/// Whether there is a C compiler; says so where there is none.
pub(crate) fn has_compiler() -> bool {
    let found = Command::new("cc").arg("--version").output().is_ok();
    if !found {
        println!("SKIPPED: no C compiler `cc`");
    }
    found
}

/// Makes `NAME.fmu`, an unpacked FMU, with what is defined; its name.
pub(crate) fn build(folder: &Path, name: &str, defines: &[&str], lie: Lie) -> String {
    let file = format!("{name}.fmu");
    let fmu = folder.join(&file);
    let machine = if cfg!(target_arch = "x86_64") { "linux64" } else { "aarch64-linux" };
    let binaries = fmu.join("binaries").join(machine);
    fs::create_dir_all(&binaries).expect("a folder");
    compile(&binaries.join("faulty.so"), defines);
    let is_controller = defines.contains(&"CONTROLLER");
    fs::write(fmu.join("modelDescription.xml"), description(is_controller, lie)).expect("written");
    file
}

fn compile(library: &Path, defines: &[&str]) {
    let source: PathBuf = root().join("tests/c/faulty.c");
    let output = Command::new("cc")
        .args(["-std=gnu11", "-O1", "-w", "-shared", "-fPIC", "-frounding-math", "-o"])
        .args([library, &source])
        .args(defines.iter().map(|define| format!("-D{define}")))
        .arg("-lm")
        .output()
        .expect("the C compiler runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn description(is_controller: bool, lie: Lie) -> String {
    let guid = if lie == Lie::Guid { "another" } else { "faulty" };
    let identifier = if lie == Lie::Identifier { "sound" } else { "faulty" };
    let output = if lie == Lie::Reference { 77 } else { 1 };
    let input = |name: &str, reference: u32| {
        format!(
            "<ScalarVariable name=\"{name}\" valueReference=\"{reference}\" causality=\"input\">\
             <Real start=\"0\"/></ScalarVariable>\n"
        )
    };
    let variables = if is_controller {
        let command = "<ScalarVariable name=\"command[1]\" valueReference=\"2\" causality=\"output\">\
                       <Real/></ScalarVariable>\n";
        input("reference[1]", 0) + &input("measured[1]", 1) + command
    } else {
        input("command[1]", 0)
            + &format!(
                "<ScalarVariable name=\"position[1]\" valueReference=\"{output}\" \
                 causality=\"output\"><Real/></ScalarVariable>\n\
                 <ScalarVariable name=\"gain\" valueReference=\"2\" causality=\"parameter\" \
                 variability=\"tunable\"><Real start=\"2\"/></ScalarVariable>\n"
            )
    };
    let index = if is_controller { 3 } else { 2 };
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"2.0\" modelName=\"faulty\" guid=\"{guid}\">\n\
         <CoSimulation modelIdentifier=\"{identifier}\" \
         canHandleVariableCommunicationStepSize=\"true\"/>\n\
         <DefaultExperiment stepSize=\"0.1\"/>\n\
         <ModelVariables>\n{variables}</ModelVariables>\n\
         <ModelStructure><Outputs><Unknown index=\"{index}\"/></Outputs>\
         <InitialUnknowns><Unknown index=\"{index}\"/></InitialUnknowns></ModelStructure>\n\
         </fmiModelDescription>\n"
    )
}
