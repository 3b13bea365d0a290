//! The C of source-code FMUs gives the bits of the shared libraries: an example of every component type, and
//! the known machines, stepped in both.
//!
//! By default compiled with `cc -O0`, which takes some seconds, and 2000 steps. Others are asked for with variables:
//! `PIEZOLOOP_CC` (compiler and flags), `PIEZOLOOP_RUN` (what runs the program, such as `qemu-arm -L …`),
//! `PIEZOLOOP_STEPS`; `dev/tools/source-bits` goes through all of them.
#![allow(clippy::print_stdout, clippy::print_stderr)]

#[path = "../../components/tests/examples/mod.rs"]
mod examples;
mod learned_examples;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use model::{Causality, DataType, System, SystemSpec};

/// A model and what is called it.
struct Case {
    name: String,
    spec: SystemSpec,
    is_learned: bool,
}

fn cases() -> Vec<Case> {
    let examples = examples::EXAMPLES
        .iter()
        .map(|example| (example.0, examples::system_of(examples::node(example))));
    let mut all: Vec<Case> =
        examples.map(|(name, spec)| Case { name: name.into(), spec, is_learned: false }).collect();
    all.extend(learned_examples::all().into_iter().map(|(name, is_learned, spec)| Case {
        name: name.into(),
        spec,
        is_learned,
    }));
    for rig in rigs::RIGS {
        let blueprint = data::Blueprint::parse(rig.blueprint, rig.name).expect("a rig");
        let checked = blueprint.check(learned::COMPONENTS).expect("a rig");
        all.push(Case { name: rig.name.into(), spec: checked.spec().clone(), is_learned: false });
    }
    all
}

/// A variable that is driven or read.
struct Port {
    reference: u32,
    data_type: DataType,
    range: (f64, f64),
}

fn ports(system: &System, causality: Causality) -> Vec<Port> {
    let range = |reference: u32| {
        let variable = &system.variables().as_slice()[reference as usize];
        let (start, unit) = (variable.start.unwrap_or(0.0), variable.unit.as_str());
        match (
            variable.name.split('[').next(),
            variable.min.is_finite() && variable.max.is_finite(),
        ) {
            (_, true) => (variable.min.max(-200.0), variable.max.min(200.0)),
            (Some("force"), _) => (start, start + 5.0),
            (Some("temperature"), _) => (start, start + 10.0),
            (Some("disturbance"), _) => (start, start + 0.1),
            _ if unit == "V" => (0.0, 100.0),
            _ => (start, start + 6.0),
        }
    };
    let all = system.variables().with(causality);
    all.map(|(reference, v)| Port { reference, data_type: v.data_type, range: range(reference) })
        .collect()
}

/// The number of a type in the cases' file.
fn number_of(data_type: DataType) -> u32 {
    match data_type {
        DataType::Real => 0,
        DataType::Boolean => 1,
        DataType::Integer => 2,
    }
}

/// What a case says to the C program.
fn write_case(file: &mut Vec<u8>, spec: &SystemSpec, system: &System, ports: [&[Port]; 2]) {
    let bytes = source::spec::to_bytes(spec).expect("bytes");
    let word = |file: &mut Vec<u8>, n: usize| file.extend((n as u32).to_le_bytes());
    word(file, bytes.len());
    file.extend(&bytes);
    file.extend(system.variables().fingerprint().as_bytes());
    file.extend(system.period().to_le_bytes());
    for list in ports {
        word(file, list.len());
        for port in list {
            word(file, port.reference as usize);
            word(file, number_of(port.data_type) as usize);
            file.extend(port.range.0.to_le_bytes());
            file.extend(port.range.1.to_le_bytes());
        }
    }
}

/// The outputs of all steps, as bits.c drives and reads them.
fn native(system: &mut System, inputs: &[Port], outputs: &[Port], steps: u32) -> Vec<f64> {
    let period = system.period();
    let mut all = Vec::with_capacity(steps as usize * outputs.len());
    system.initialise(0.0).expect("valid");
    for k in 0..steps {
        for (i, port) in (3..).zip(inputs) {
            let value = if port.data_type == DataType::Boolean {
                f64::from(u8::from(k % 5000 < 4500))
            } else {
                let phase = u64::from(k) * i % 2000;
                let share = (if phase < 1000 { phase } else { 2000 - phase }) as f64 / 1000.0;
                (port.range.1 - port.range.0) * share + port.range.0
            };
            system.set(port.reference, value).expect("in range");
        }
        system.advance(f64::from(k) * period + period).expect("finite");
        all.extend(outputs.iter().map(|port| system.get(port.reference).expect("in the table")));
    }
    all
}

/// Of the outputs' range: learned models sum their kernels as wide as the machine's vectors are, with fused
/// multiplication where it has it; C one after the other without.
const LEARNED: f64 = 1e-12;

/// The outputs that C gives of the learned models.
fn answers(
    program: &Path,
    runner: &[String],
    cases: &[Case],
    steps: u32,
    folder: &Path,
) -> Vec<Vec<f64>> {
    let learned: Vec<&Case> = cases.iter().filter(|case| case.is_learned).collect();
    let mut file = Vec::new();
    file.extend((learned.len() as u32).to_le_bytes());
    file.extend(u32::to_le_bytes(steps));
    let mut counts = Vec::new();
    for case in learned {
        let system = System::new(&case.spec).expect("a model");
        let (inputs, outputs) =
            (ports(&system, Causality::Input), ports(&system, Causality::Output));
        write_case(&mut file, &case.spec, &system, [&inputs, &outputs]);
        counts.push(outputs.len() * steps as usize);
    }
    let [cases, answers] = ["learned", "answers"].map(|name| folder.join(name));
    std::fs::write(&cases, file).expect("a file");
    run(program, runner, &[&cases, &answers]);
    let bytes = std::fs::read(answers).expect("answers");
    let (words, _) = bytes.as_chunks::<8>();
    let mut numbers = words.iter().map(|word| f64::from_le_bytes(*word));
    counts.into_iter().map(|count| numbers.by_ref().take(count).collect()).collect()
}

/// What the program says.
fn run(program: &Path, runner: &[String], arguments: &[&Path]) -> String {
    let mut words: Vec<&std::ffi::OsStr> = runner.iter().map(AsRef::as_ref).collect();
    words.push(program.as_os_str());
    words.extend(arguments.iter().map(|path| path.as_os_str()));
    let output = Command::new(words[0]).args(&words[1..]).output().expect("the program starts");
    let message = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{message}{}", String::from_utf8_lossy(&output.stderr));
    message
}

fn hash(values: &[f64]) -> u64 {
    model::fnv_64(values.iter().map(|value| value.to_bits()))
}

/// The standard's headers, which fmpy in the tests' Python environment carries.
fn headers() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("PIEZOLOOP_FMI_HEADERS") {
        return Some(folder.into());
    }
    let environment = match std::env::var_os("PIEZOLOOP_PYTHON") {
        Some(python) => PathBuf::from(python).parent()?.parent()?.to_path_buf(),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?.join("target/python-env"),
    };
    let versions = std::fs::read_dir(environment.join("lib")).ok()?;
    let mut folders = versions.flatten().map(|v| v.path().join("site-packages/fmpy/c-code"));
    folders.find(|folder| folder.join("fmi2Functions.h").is_file())
}

/// Compiles a program of `tests/c` in the folder, beside the given sources and with further flags; none with a line that
/// says why.
fn compile<N: AsRef<Path>>(
    folder: &Path,
    sources: Vec<(N, Vec<u8>)>,
    main: &str,
    flags: &[&str],
) -> Option<PathBuf> {
    let given = compiler();
    let mut words = given.split_whitespace();
    let compiler = words.next()?;
    if Command::new(compiler).arg("--version").output().is_err() {
        println!("SKIPPED: no C compiler {compiler} is here, so that sources are not compiled");
        return None;
    }
    let Some(headers) = headers() else {
        println!("SKIPPED: no fmpy with the standard's headers (PIEZOLOOP_PYTHON not set)");
        return None;
    };
    for (name, content) in sources {
        std::fs::write(folder.join(name), content).expect("a file");
    }
    let program = folder.join("program");
    let output = Command::new(compiler)
        .args(words)
        // On bare metal `uint32_t` is another type than `unsigned int`, and newer compilers refuse to mix them.
        .arg("-Werror=incompatible-pointer-types")
        .arg("-I")
        .arg(folder)
        .arg("-I")
        .arg(headers)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/c").join(main))
        .arg("-o")
        .arg(&program)
        .args(flags)
        .output()
        .expect("the compiler starts");
    assert!(output.status.success(), "{given}: {}", String::from_utf8_lossy(&output.stderr));
    Some(program)
}

fn compiler() -> String {
    std::env::var("PIEZOLOOP_CC").unwrap_or("cc -O0".into())
}

/// What runs a program that is not for this machine.
fn runner() -> Vec<String> {
    let given = std::env::var("PIEZOLOOP_RUN").unwrap_or_default();
    given.split_whitespace().map(str::to_owned).collect()
}

/// Only gcc can return from a trap without a function of the C library (`setjmp`).
#[test]
fn an_fmu_in_a_program_without_a_c_library_gives_the_bits_of_the_native_code() {
    if compiler().starts_with("clang") || !cfg!(target_os = "linux") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let rig = rigs::RIGS.iter().find(|rig| rig.name == "evc").expect("a rig");
    let blueprint = data::Blueprint::parse(rig.blueprint, rig.name).expect("a rig");
    let checked = blueprint.check(learned::COMPONENTS).expect("a rig");
    let mut system = System::new(checked.spec()).expect("a model");
    let sources = source::package::files(checked.spec(), &system, false).expect("sources");
    let flags = ["-static", "-nostdlib", "-nostartfiles", "-fno-stack-protector", "-lgcc"];
    let Some(program) = compile(folder.path(), sources, "bare.c", &flags) else { return };
    let port = |system: &System, name: &str| {
        let found = system.variables().as_slice().iter().position(|v| v.name == name);
        u32::try_from(found.expect("a variable")).expect("a reference")
    };
    let [commands, positions] = ["command", "position"]
        .map(|name| [1, 2].map(|axis| port(&system, &format!("{name}[{axis}]"))));
    system.initialise(0.0).expect("valid");
    let mut values = Vec::new();
    for k in 0..2000 {
        let u = [f64::from(40 + k % 97), f64::from(90 - k % 41)];
        for (reference, value) in commands.into_iter().zip(u) {
            system.set(reference, value).expect("in range");
        }
        system.advance(f64::from(k) * 2e-5 + 2e-5).expect("finite");
        values.extend(positions.map(|reference| system.get(reference).expect("in the table")));
    }
    let message = run(&program, &runner(), &[]);
    assert_eq!(message.trim_end(), format!("{:016x}", hash(&values)));
    println!("bare evc: the same bits");
}

#[test]
fn every_component_and_machine_gives_the_bits_of_the_native_code() {
    let steps =
        std::env::var("PIEZOLOOP_STEPS").map_or(2000, |text| text.parse().expect("a number"));
    let folder = tempfile::tempdir().expect("a folder");
    let core = source::package::core().expect("whole");
    let Some(program) = compile(folder.path(), core, "bits.c", &[]) else { return };
    let cases = cases();
    let mut file = Vec::new();
    file.extend((cases.len() as u32).to_le_bytes());
    file.extend(u32::to_le_bytes(steps));
    let mut wanted = Vec::new();
    for case in &cases {
        let mut system = System::new(&case.spec).expect("a model");
        let (inputs, outputs) =
            (ports(&system, Causality::Input), ports(&system, Causality::Output));
        write_case(&mut file, &case.spec, &system, [&inputs, &outputs]);
        let begun = std::time::Instant::now();
        let values = native(&mut system, &inputs, &outputs, steps);
        wanted.push((values, begun.elapsed().as_nanos() as f64 / f64::from(steps)));
    }
    let path = folder.path().join("cases");
    std::fs::write(&path, &file).expect("a file");
    let runner = runner();
    let message = run(&program, &runner, &[&path]);
    let mut wrong = String::new();
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!(lines.len(), cases.len(), "{message}");
    let tail = answers(&program, &runner, &cases, steps, folder.path());
    for (case, found) in cases.iter().filter(|case| case.is_learned).zip(&tail) {
        let (values, _) = &wanted[cases.iter().position(|c| c.name == case.name).expect("it")];
        let span = values
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)]);
        let away = values.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            / (span[1] - span[0]);
        println!("{}: {away:.1e} of the range", case.name);
        assert!(values.len() == found.len() && away < LEARNED, "{}: {away:e}", case.name);
    }
    for ((case, (values, ns)), line) in cases.iter().zip(&wanted).zip(&lines) {
        let found = line.split(' ').nth(1).unwrap_or("");
        let is_same = found == format!("{:016x}", hash(values));
        println!(
            "{} {} {line}; native {ns:.0} ns",
            if is_same { "same" } else { "OTHER" },
            case.name
        );
        assert!(line.contains(" 0 after instantiation"), "{}: {line}", case.name);
        if !is_same && !case.is_learned {
            let _ = writeln!(wrong, "{}: {line}", case.name);
        }
    }
    assert!(wrong.is_empty(), "other bits:\n{wrong}");
}
