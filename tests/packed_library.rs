//! The shared library inside a packed FMU, loaded by C hosts as importers load it: what it exports
//! and needs, that stepping allocates nothing, lives of many instances, where resources are found.
#![cfg(target_os = "linux")]

use crate::common;

use common::packed::{CONTROLLER, Host, PLANT, Packed, compile_library, copy, with};
use common::{refuse, succeed};
use std::collections::BTreeSet;
use std::process::Command;

const BOTH: [&str; 2] = [PLANT, CONTROLLER];

#[test]
fn stepping_setting_and_getting_allocate_nothing() {
    let host = Host::new("allocations.c");
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "2");
        print!("{}: {}", fmu.name(), host.run(&fmu.arguments()));
        let fmu = Packed::new(blueprint, "3");
        let inputs = if blueprint == PLANT { "2" } else { "4" };
        let outputs = if blueprint == PLANT { "2" } else { "6" };
        print!("{}: {}", fmu.name(), host.run(&with(fmu.arguments(), &[inputs, outputs])));
    }
}

fn tool(program: &str, arguments: &[&str], file: &std::path::Path) -> String {
    let output = Command::new(program).args(arguments).arg(file).output();
    let output = output.unwrap_or_else(|e| panic!("{program} (Debian: binutils): {e}"));
    assert!(output.status.success());
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Versions of glibc that a library asks for, by its table of needed versions.
fn glibc_versions(file: &str) -> Vec<(u32, u32, u32)> {
    use object::read::elf::{ElfFile64, FileHeader as _};
    let data = std::fs::read(file).expect("a library");
    let elf = ElfFile64::<object::Endianness>::parse(&*data).expect("ELF of 64 bits");
    let endian = elf.endian();
    let sections = elf.elf_header().sections(endian, &*data).expect("sections");
    let (mut needs, link) =
        sections.gnu_verneed(endian, &*data).expect("is read").expect("it needs versions");
    let names = sections.strings(endian, &*data, link).expect("names");
    let mut found = Vec::new();
    while let Some((_, mut versions)) = needs.next().expect("is read") {
        while let Some(version) = versions.next().expect("is read") {
            let name = version.name(endian, names).expect("a name");
            let name = std::str::from_utf8(name).expect("UTF-8");
            if let Some(number) = name.strip_prefix("GLIBC_") {
                let mut parts = number.split('.').map(|part| part.parse().expect("a number"));
                let mut part = || parts.next().unwrap_or(0);
                found.push((part(), part(), part()));
            }
        }
    }
    found
}

/// The libraries that the tool carries run where glibc is that of 2012, whatever machine they are built on.
#[test]
#[cfg(all(target_env = "gnu", target_arch = "x86_64"))]
fn no_library_needs_a_newer_glibc_than_2_17() {
    for file in [env!("PIEZOLOOP_BLUEPRINT_LIBRARY"), env!("PIEZOLOOP_WRAP_LIBRARY")] {
        let versions = glibc_versions(file);
        let newest = versions.iter().max().expect("some version");
        println!("{file}: needs glibc {}.{}", newest.0, newest.1);
        assert!(*newest <= (2, 17, 0), "{file}: {versions:?}");
    }
    // What is linked without this needs a newer one, where the machine has one: the test can fail.
    println!(
        "this test: {:?}",
        glibc_versions(&std::env::args().next().expect("its name")).iter().max()
    );
}

/// All functions of FMI 2.0 and 3.0 and no other symbol; no library but the C library's, the
/// loader, and the compiler's unwinder.
#[test]
fn only_the_standards_functions_are_exported_and_only_the_c_library_is_needed() {
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "2");
        let file = fmu.library();
        let symbols = tool("nm", &["-D", "--defined-only", "--format=posix"], &file);
        let names: Vec<_> = symbols.lines().filter_map(|l| l.split(' ').next()).collect();
        let of = |prefix: &str| names.iter().filter(|name| name.starts_with(prefix)).count();
        assert_eq!((of("fmi2"), of("fmi3")), (44, 75), "{names:?}");
        assert_eq!(names.len(), 44 + 75, "more than the standard's: {names:?}");
        // What Windows' linkers are told to export.
        let list = include_str!("../crates/fmi-bindings/fmi.def").lines();
        let described: BTreeSet<&str> = list.filter_map(|line| line.strip_prefix("    ")).collect();
        assert_eq!(described, names.into_iter().collect());

        let dynamic = tool("readelf", &["-d", "-W"], &file);
        let needed: Vec<_> = dynamic
            .lines()
            .filter(|line| line.contains("(NEEDED)"))
            .filter_map(|line| line.split(['[', ']']).nth(1))
            .collect();
        let known = ["libc.so.", "libm.so.", "libgcc_s.so.", "ld-linux", "libdl.so.", "libpthread"];
        let foreign = |name: &&&str| !known.iter().any(|prefix| name.starts_with(prefix));
        assert_eq!(needed.iter().find(foreign), None, "{needed:?}");
        assert!(dynamic.contains("SYMBOLIC"), "it calls its own functions: {dynamic}");
        assert!(!dynamic.contains("RPATH") && !dynamic.contains("RUNPATH"), "{dynamic}");
        let size = file.metadata().expect("a file").len();
        println!("{}: {} kB, needs {}", fmu.name(), size.div_ceil(1000), needed.join(", "));
        assert!(size < 2_500_000, "{size} B");
    }
}

#[test]
fn a_host_that_exports_the_same_names_reaches_each_librarys_own_functions() {
    let (plant, controller) = (Packed::new(PLANT, "2"), Packed::new(CONTROLLER, "2"));
    let plain = Host::new("run.c");
    let alone = plain.run(&plant.arguments()) + &plain.run(&controller.arguments());
    let mut both = plant.arguments();
    both.extend(controller.arguments());
    let host = Host::new("namesakes.c");
    assert_eq!(host.run(&both), alone);

    // A library that calls itself by name is caught by this host, unless it is linked as ours are.
    let folder = tempfile::tempdir().expect("a folder");
    let library = folder.path().join("calls_by_name.so");
    let path = library.to_str().expect("UTF-8");
    let with_it = with(plant.arguments(), &[path, "x", "x", "1e-3", "0", "1"]);
    compile_library("calls_by_name.c", &[], &library);
    let output = host.output(&with_it);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("the host's fmi2SetReal was reached"), "{message}");
    compile_library("calls_by_name.c", &["-Wl,-Bsymbolic"], &library);
    host.run(&with_it);

    // Nor is there any place in ours that could be bound to somebody else's function.
    for fmu in [&plant, &controller] {
        let places = tool("readelf", &["-r", "-W"], &fmu.library());
        assert!(places.contains("R_") && !places.contains("fmi"), "{places}");
    }
}

#[test]
fn many_instances_live_in_many_threads() {
    let host = Host::new("life.c");
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "2");
        print!("{}: {}", fmu.name(), host.run(&with(fmu.arguments(), &["threads"])));
    }
}

#[test]
fn loading_failing_and_unloading_many_times_loses_no_memory() {
    let host = Host::new("life.c");
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "2");
        print!("{}: {}", fmu.name(), host.run(&with(fmu.arguments(), &["400"])));
    }
}

/// The folder that `file:` URIs are made for in the tests below.
const ODD_FOLDER: &str = "a b%20c 100% Größe 压电";

#[test]
fn resources_are_found_whatever_the_path_and_however_it_is_spelt() {
    let fmu = Packed::new(PLANT, "2");
    let host = Host::new("run.c");
    let wanted = host.run(&fmu.arguments());
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path().join(ODD_FOLDER);
    copy(fmu.package.folder(), &folder);
    let moved = modeldescription::Package::open(&folder).expect("the copy is an FMU");
    let library = moved.binary().expect("a library");
    let uri = moved.resources_uri();
    let path = moved.resources().to_str().expect("UTF-8").to_owned();
    let encoded = uri.strip_prefix("file://").expect("a file URI");
    for resources in [
        uri.clone(),
        format!("{uri}/"),
        format!("file:///{encoded}"),
        format!("file:{encoded}"),
        format!("file://localhost{encoded}"),
        format!("file://{path}"),
        format!("file:///{path}"),
        path.clone(),
        String::new(),
        "(null)".to_owned(),
        "file:///nowhere/at/all".to_owned(),
    ] {
        let message = host.run(&fmu.arguments_at(&library, &resources));
        assert_eq!(message, wanted, "{resources}");
    }
}

#[test]
fn an_fmu_without_its_resources_is_refused_with_the_folders_that_were_tried() {
    let fmu = Packed::new(PLANT, "2");
    let temporary = tempfile::tempdir().expect("a folder");
    copy(fmu.package.folder(), temporary.path());
    std::fs::remove_dir_all(temporary.path().join("resources")).expect("removed");
    let moved = modeldescription::Package::open(temporary.path()).expect("an FMU");
    let arguments = fmu.arguments_at(&moved.binary().expect("a library"), "file:///nowhere");
    let message = Host::new("run.c").run(&arguments);
    assert!(message.starts_with("refused: fmi2Instantiate: no blueprint.toml"), "{message}");
    assert!(message.contains("/nowhere") && message.contains("resources"), "{message}");
}

#[test]
fn the_guid_of_another_fmu_is_refused() {
    let (plant, controller) = (Packed::new(PLANT, "2"), Packed::new(CONTROLLER, "2"));
    let host = Host::new("run.c");
    for guid in [controller.guid(), "", "{00000000-0000-0000-0000-000000000000}"] {
        let mut arguments = plant.arguments();
        arguments[1] = guid.to_owned();
        let message = host.run(&arguments);
        assert!(message.starts_with("refused: fmi2Instantiate: the GUID"), "{message}");
        assert!(
            message.contains(plant.guid()) && message.contains("pack the FMU again"),
            "{message}"
        );
    }
}

/// One library serves plants and controllers; the identifier shows that resources belong to another FMU.
#[test]
fn the_resources_of_another_fmu_are_refused() {
    let (plant, controller) = (Packed::new(PLANT, "2"), Packed::new(CONTROLLER, "2"));
    let host = Host::new("run.c");
    for (fmu, other) in [(&plant, &controller), (&controller, &plant)] {
        let message = host.run(&fmu.arguments_at(&fmu.library(), &other.package.resources_uri()));
        assert!(message.starts_with("refused: fmi2Instantiate: the GUID"), "{message}");
        assert!(message.contains(fmu.guid()) && message.contains(other.guid()), "{message}");
    }
}

/// As somebody does who has libraries for an older Linux.
#[test]
fn a_library_that_is_given_takes_the_place_of_the_tools_own() {
    let folder = tempfile::tempdir().expect("a folder");
    for (blueprint, version) in [(PLANT, "2"), (CONTROLLER, "3")] {
        let fmu = Packed::new(blueprint, version);
        let mut other = std::fs::read(fmu.library()).expect("a library");
        other.extend(b"another build");
        std::fs::write(folder.path().join("other.so"), &other).expect("written");
        for platform in ["linux64", "x86_64-linux"] {
            let binary = format!("{platform}=other.so");
            let arguments = ["pack", blueprint, "--fmi", version, "--binary", &binary];
            let message = succeed(&[&arguments[..], &["-o", "x.fmu"]].concat(), folder.path());
            let of_version = if version == "2" { "linux64" } else { "x86_64-linux" };
            assert!(message.contains(&format!("for {of_version}, ")), "{message}");
            let packed = modeldescription::Package::open(folder.path().join("x.fmu"));
            let packed = packed.expect("an FMU");
            let library = packed.binary().expect("a library");
            assert!(std::fs::read(library).expect("a library") == other, "{platform}");
        }
        // From a folder as dev/tools/portable makes it; a folder that is no platform's is left alone.
        for platform in ["all/linux64", "all/notes"] {
            let place = folder.path().join(platform);
            std::fs::create_dir_all(&place).expect("the folder is writable");
            std::fs::write(place.join("libpiezoloop_fmu_blueprint.so"), &other).expect("written");
        }
        let arguments = ["pack", blueprint, "--fmi", version, "--libraries", "all", "-o", "y.fmu"];
        succeed(&arguments, folder.path());
        let packed = modeldescription::Package::open(folder.path().join("y.fmu")).expect("an FMU");
        let library = packed.binary().expect("a library");
        assert!(std::fs::read(library).expect("a library") == other, "--libraries");
        assert_eq!(packed.platforms().len(), 1);
    }
    let refused = |libraries| {
        refuse(&["pack", PLANT, "--libraries", libraries, "-o", "z.fmu"], folder.path())
    };
    assert!(refused("none").contains("no such folder"));
    assert!(refused("all/notes").contains("no library piezoloop_fmu_blueprint"));
    // Told before the work: there is no such log either.
    let diagnose = ["diagnose", "--model", "y.fmu", "--log", "no.csv", "--repair", "r.fmu"];
    let error = refuse(&[&diagnose[..], &["--libraries", "all"]].concat(), folder.path());
    assert!(error.contains("no library piezoloop_fmu_wrap"), "{error}");
}

#[test]
fn a_library_that_would_not_serve_is_refused() {
    let plant = Packed::new(PLANT, "2");
    let folder = tempfile::tempdir().expect("a folder");
    let trivial = folder.path().join("trivial.so");
    compile_library("trivial.c", &[], &trivial);
    let path = |file: &std::path::Path| file.to_str().expect("UTF-8").to_owned();
    for (platform, file, words) in [
        (
            "linux64",
            env!("PIEZOLOOP_WRAP_LIBRARY").to_owned(),
            ["piezoloop_fmu_wrap", "piezoloop_fmu_blueprint"],
        ),
        ("win64", path(&plant.library()), ["Elf", "not PE for x86_64"]),
        ("aarch64-linux", path(&plant.library()), ["X86_64", "not ELF for aarch64"]),
        ("linux64", path(&trivial), ["no library of Piezoloop", "piezoloop_fmu_blueprint"]),
        ("linux64", path(&plant.file), ["no library", "shared library"]),
    ] {
        let binary = format!("{platform}={file}");
        let message = refuse(&["pack", PLANT, "--binary", &binary, "-o", "x.fmu"], folder.path());
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
        assert!(message.contains(&binary) && !folder.path().join("x.fmu").exists(), "{message}");
    }
    let twice = format!("linux64={}", path(&plant.library()));
    let arguments = ["pack", PLANT, "--binary", &twice, "--binary", &twice, "-o", "x.fmu"];
    assert!(refuse(&arguments, folder.path()).contains("one library per platform"));
}

#[test]
fn the_start_time_changes_no_bit_of_the_run() {
    let host = Host::new("run.c");
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "2");
        let wanted = host.run(&with(fmu.arguments(), &["0"]));
        for start in ["1024", "-3.5", "0.1", "86400", "1e6"] {
            assert_eq!(host.run(&with(fmu.arguments(), &[start])), wanted, "start {start} s");
        }
    }
}
