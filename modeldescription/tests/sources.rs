//! What `check` says about the C in an FMU.

mod common;

use common::stage;
use modeldescription::check;
use modeldescription::description::FmiVersion;
use modeldescription::package::PackageBuilder;

const BUILD: &str = "<fmiBuildDescription fmiVersion=\"3.0\"><BuildConfiguration modelIdentifier=\"stage\">\
    <SourceFileSet language=\"C99\"><SourceFile name=\"fmu.c\"/></SourceFileSet></BuildConfiguration>\
    </fmiBuildDescription>";

/// What is found in an FMU without libraries whose folder `sources` holds these files.
fn found(version: FmiVersion, files: &[(&str, &str)]) -> String {
    let mut description = stage(version);
    if version == FmiVersion::V2 {
        let cs = description.co_simulation.as_mut().expect("co-simulation");
        cs.common.source_files = vec!["fmu.c".to_owned()];
    }
    let mut package = PackageBuilder::new(&description).expect("a description");
    for (name, content) in files {
        package.source(name, content.as_bytes().to_vec()).expect("a name");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("stage.fmu");
    package.write(&file).expect("written");
    check(&file).expect("read").iter().map(|problem| format!("{problem}\n")).collect()
}

#[test]
fn sources_alone_are_an_fmu() {
    let main =
        ("fmu.c", "#include \"core/a.h\"\n#include \"fmi2Functions.h\"\n#include \"stdint.h\"");
    let more =
        [("core/a.h", "# include \"b.h\"\n#include \"../top.h\""), ("core/b.h", ""), ("top.h", "")];
    let files = [&[main], &more[..]].concat();
    assert_eq!(found(FmiVersion::V2, &files), "");
    let files = [&files[..], &[("buildDescription.xml", BUILD)]].concat();
    assert_eq!(found(FmiVersion::V3, &files), "");
    assert_eq!(found(FmiVersion::V2, &files), "");
}

/// Version of FMI, the files under sources/ with their texts, and what is reported.
type Case<'a> = (FmiVersion, &'a [(&'a str, &'a str)], &'a str);

#[test]
fn what_a_compiler_would_miss_is_named() {
    let cases: &[Case] = &[
        (FmiVersion::V2, &[("other.c", "")], "sources/fmu.c"),
        (FmiVersion::V2, &[("fmu.c", "#include \"a.h\"")], "includes \"a.h\", which is not there"),
        (FmiVersion::V2, &[("fmu.c", "#include \"../../a.h\"")], "which is not there"),
        (FmiVersion::V2, &[("fmu.c", ""), ("fmi2Functions.h", "")], "its own copy"),
        (FmiVersion::V3, &[("fmu.c", "")], "buildDescription.xml"),
        (FmiVersion::V3, &[("buildDescription.xml", BUILD)], "sources/fmu.c"),
        (
            FmiVersion::V3,
            &[("buildDescription.xml", "<build/>"), ("fmu.c", "")],
            "its root is <build>",
        ),
        (FmiVersion::V3, &[("buildDescription.xml", "<x"), ("fmu.c", "")], "well-formed"),
        (
            FmiVersion::V3,
            &[("buildDescription.xml", "<fmiBuildDescription/>"), ("fmu.c", "")],
            "modelIdentifier=\"stage\"",
        ),
    ];
    for (version, files, wanted) in cases {
        let problems = found(*version, files);
        assert!(problems.contains(wanted), "{files:?}: {problems}");
    }
}
