//! Foreign tools read what is written.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::systems::*;

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
