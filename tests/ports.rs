//! `pack --ports`: what a simulator of a whole system connects to a plant. Against closed forms, by energy, in
//! fmpy; a port whose physics is not known is refused.
#![cfg(unix)]

use crate::common;

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::Path;

use common::{foreign, json, python, refuse, root, succeed};

/// Columns of a CSV file by name.
fn table(file: &Path) -> HashMap<String, Vec<f64>> {
    let text = fs::read_to_string(file).expect("a table");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let names: Vec<String> = reader.headers().expect("a header").iter().map(String::from).collect();
    let mut columns: HashMap<String, Vec<f64>> = HashMap::new();
    for row in reader.records() {
        let row = row.expect("a row");
        for (name, cell) in names.iter().zip(row.iter()) {
            // A unit may stand behind a name.
            let name = name.split(" [").next().unwrap_or(name).to_owned();
            columns.entry(name).or_default().push(cell.parse().expect("a number"));
        }
    }
    columns
}

/// Writes a log: its inputs at each step.
fn write_log(file: &Path, step: f64, names: &[&str], rows: &[Vec<f64>]) {
    let mut writer = csv::Writer::from_path(file).expect("writable");
    let mut header = vec!["time"];
    header.extend(names);
    writer.write_record(&header).expect("writable");
    for (k, row) in rows.iter().enumerate() {
        let cells = std::iter::once(k as f64 * step).chain(row.iter().copied());
        writer.write_record(cells.map(|x| x.to_string())).expect("writable");
    }
    writer.flush().expect("writable");
}

/// Runs an FMU over the inputs; all its outputs.
fn run(
    folder: &Path,
    fmu: &str,
    step: f64,
    names: &[&str],
    rows: &[Vec<f64>],
) -> HashMap<String, Vec<f64>> {
    write_log(&folder.join("in.csv"), step, names, rows);
    succeed(&["simulate", fmu, "--log", "in.csv", "-o", "out.csv"], folder);
    table(&folder.join("out.csv"))
}

/// Stiffness in N/m, gain in m/V, capacitance in F, natural frequency in Hz and damping of rig p1.
const K: f64 = 20e6;
const G: f64 = 0.35e-6;
const C: f64 = 2.1e-6;
const F0: f64 = 2100.0;
const ZETA: f64 = 0.02;

/// Rig p1 with both ports at an internal step, its amplifier switched off: the command is the voltage.
fn p1(folder: &Path, step: &str) -> serde_json::Value {
    let shown = succeed(&["list", "rigs", "--show", "p1"], folder);
    let off = "type = \"amplifier-lag\"\nenabled = false\n";
    fs::write(folder.join("p1.toml"), shown.replacen("type = \"amplifier-lag\"\n", off, 1))
        .expect("writable");
    let pack =
        ["pack", "p1.toml", "--step", step, "--ports", "mechanical,electrical", "--port-value"];
    json(&[&pack[..], &["capacitance=2.1 uF", "-o", "p1.fmu"]].concat(), folder)
}

#[test]
fn a_force_bends_the_tip_as_a_mode_does_and_draws_its_charge() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let packed = p1(folder, "1e-5");
    // The stiffness stands in the record; the transduction follows by reciprocity: 20 N/um · 0.35 um/V.
    let values = &packed["ports"][1]["values"];
    assert_eq!(values["transduction"]["value"], "7.000000e0 C/m", "{packed}");
    let stiffness = packed["ports"][0]["values"]["stiffness"]["from"].as_str().expect("its source");
    assert!(stiffness.contains("record p-752-21c: maker's data"), "{stiffness}");

    // 60 ms, in which the mode settles to 1e-7.
    const HELD: usize = 6000;
    let (step, force, rows) = (1e-5, 100.0, HELD + 2000);
    let inputs: Vec<_> =
        (0..rows).map(|k| vec![0.0, if (1..=HELD).contains(&k) { force } else { 0.0 }]).collect();
    let out = run(folder, "p1.fmu", step, &["command[1]", "force[1]"], &inputs);
    let (w, d) = (TAU * F0, (1.0 - ZETA * ZETA).sqrt());
    let answer = |t: f64| {
        let (s, c) = (w * d * t).sin_cos();
        1.0 - (-ZETA * w * t).exp() * (c + ZETA / d * s)
    };
    for k in 0..rows {
        // It begins at rest, is pushed from row 1 on, and let go after HELD rows.
        let mut exact = 0.0;
        for (begin, sign) in [(1, 1.0), (HELD + 1, -1.0)] {
            if k > begin {
                exact += sign * force / K * answer((k - begin) as f64 * step);
            }
        }
        let found = out["tip[1]"][k];
        assert!((found - exact).abs() < 1e-9 * force / K, "row {k}: {found} {exact}");
        // The charge of the motion, that of the hit before.
        let late = if k > 0 { out["tip[1]"][k - 1] } else { 0.0 };
        let charge = out["charge[1]"][k];
        assert!((charge - K * G * late).abs() < 1e-9 * K * G * force / K, "row {k}: {charge}");
    }
    // The work of a force that settles: half of it is stored, half of it is lost, to the closed form.
    let work: f64 =
        (1..=HELD + 1).map(|k| inputs[k - 1][1] * (out["tip[1]"][k] - out["tip[1]"][k - 1])).sum();
    assert!((work / (force * force / K) - 1.0).abs() < 1e-3, "{work}");
    let power: f64 =
        (1..=HELD + 1).map(|k| inputs[k - 1][1] * out["tip_velocity[1]"][k] * step).sum();
    assert!((power / work - 1.0).abs() < 1e-9, "{power} {work}");
}

/// A voltage and a force at once, for whole periods: what goes in at both ports is what the damper loses, and each
/// port's part is that of the closed form.
#[test]
fn the_work_at_both_ports_is_what_the_damper_loses() {
    let (volts, newtons, phase, frequency) = (3.0_f64, 30.0_f64, 0.7_f64, 500.0_f64);
    let mut errors = Vec::new();
    for step in [2e-6_f64, 1e-6] {
        let folder = tempfile::tempdir().expect("a folder");
        p1(folder.path(), &step.to_string());
        // 40 periods until what was at the start is gone, then ten.
        let per = (1.0 / (frequency * step)).round() as usize;
        let (from, to) = (40 * per, 50 * per);
        let w = TAU * frequency;
        let rows: Vec<Vec<f64>> = (0..=to + 1)
            .map(|k| {
                // Held over the step: its middle.
                let t = (k as f64 + 0.5) * step;
                vec![5.0 + volts * (w * t).cos(), newtons * (w * t + phase).cos()]
            })
            .collect();
        let out = run(folder.path(), "p1.fmu", step, &["command[1]", "force[1]"], &rows);
        let (tip, voltage, current) = (&out["tip[1]"], &out["voltage[1]"], &out["current[1]"]);
        let mechanical: f64 = (from + 1..=to).map(|k| rows[k - 1][1] * (tip[k] - tip[k - 1])).sum();
        let electrical: f64 = (from + 1..=to).map(|k| voltage[k] * current[k] * step).sum();
        // The phasor of the tip: x = (n·v + F)/(k·(1 − r² + 2jζr)).
        let n = K * G;
        let r = frequency / F0;
        let (re, im) = (n * volts + newtons * phase.cos(), newtons * phase.sin());
        let (a, b) = (K * (1.0 - r * r), K * 2.0 * ZETA * r);
        let size = a * a + b * b;
        let (x, y) = ((re * a + im * b) / size, (im * a - re * b) / size);
        // Per period: π·Im(F*·x)·(−1), with x + jy the tip and its part behind the force as work.
        let by_force = -PI * newtons * (phase.cos() * y - phase.sin() * x) * 10.0;
        let by_voltage = -PI * n * volts * y * 10.0;
        let damper = K * 2.0 * ZETA / (TAU * F0);
        let lost = PI * damper * w * (x * x + y * y) * 10.0;
        assert!(((by_force + by_voltage) / lost - 1.0).abs() < 1e-9, "the closed forms agree");
        println!(
            "step {step}: force {mechanical:.6e} J ({by_force:.6e}), voltage {electrical:.6e} J ({by_voltage:.6e}), \
             lost {lost:.6e} J"
        );
        assert!((mechanical / by_force - 1.0).abs() < 1e-3);
        // The current has the motion of the step before: the tip's phasor turned back by it.
        let (sin, cos) = (w * step).sin_cos();
        let late = -PI * n * volts * (y * cos - x * sin) * 10.0;
        // A capacitance that is charged in stairs takes C·Δv²/2 more at each.
        let stairs: f64 =
            (from + 1..=to).map(|k| 0.5 * C * (voltage[k] - voltage[k - 1]).powi(2)).sum();
        let exchanged = PI * n * volts * x.hypot(y) * 10.0;
        assert!((electrical - late - stairs).abs() < 1e-5 * exchanged, "{electrical} {late}");
        errors.push((electrical - by_voltage).abs() / exchanged);
        assert!(mechanical + electrical > 0.0);
    }
    // So what it lacks goes with the step.
    assert!(errors[0] < 1e-2 && (errors[0] / errors[1] - 2.0).abs() < 0.02, "{errors:?}");
}

/// No force, however chosen, gets energy out of a plant at rest.
#[test]
fn no_force_gets_energy_out_of_a_plant_at_rest() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let pack = [
        "pack",
        "evc",
        "--ports",
        "mechanical",
        "--port-value",
        "stiffness=20 N/um",
        "-o",
        "evc.fmu",
    ];
    succeed(&pack, folder);
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    for (kind, frequency) in [("noise", 0.0), ("at the resonance", 482.6), ("between", 371.0)] {
        let rows: Vec<Vec<f64>> = (0..4000)
            .map(|k| {
                let wave = if frequency > 0.0 {
                    (TAU * frequency * f64::from(k) * 2e-5).sin()
                } else {
                    random()
                };
                // The first row is what it rests under.
                let size = if k == 0 { 0.0 } else { 50.0 };
                vec![0.0, 0.0, size * wave, size * random()]
            })
            .collect();
        let names = ["command[1]", "command[2]", "force[1]", "force[2]"];
        let out = run(folder, "evc.fmu", 2e-5, &names, &rows);
        for axis in [1, 2] {
            let tip = &out[&format!("tip[{axis}]")];
            let (mut work, mut least) = (0.0, 0.0_f64);
            for k in 1..tip.len() {
                work += rows[k - 1][1 + axis] * (tip[k] - tip[k - 1]);
                least = least.min(work);
            }
            println!("{kind}, axis {axis} (seed 7): work {work:.3e} J, least {least:.1e} J");
            assert!(work > 0.0 && least > -1e-12 * work, "{kind}, axis {axis}: {least}");
        }
    }
}

#[test]
fn ports_that_nothing_is_connected_to_change_no_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    succeed(&["pack", "evc-truth", "-o", "plain.fmu"], folder);
    let values = ["stiffness=20 N/um", "capacitance=3.1 uF", "growth=0.2 um/K", "loss=0.02"];
    let mut pack =
        vec!["pack", "evc-truth", "--ports", "mechanical,electrical,thermal", "-o", "ports.fmu"];
    pack.extend(values.iter().flat_map(|value| ["--port-value", value]));
    succeed(&pack, folder);
    let rows: Vec<Vec<f64>> = (0..3000_u32)
        .map(|k| {
            vec![
                60.0 - 50.0 * (f64::from(k) * 0.01).cos(),
                40.0 + 30.0 * (f64::from(k) * 0.017).sin(),
            ]
        })
        .collect();
    let names = ["command[1]", "command[2]"];
    let plain = run(folder, "plain.fmu", 2e-5, &names, &rows);
    let ports = run(folder, "ports.fmu", 2e-5, &names, &rows);
    for name in ["position[1]", "position[2]"] {
        let bits = |columns: &HashMap<String, Vec<f64>>| {
            columns[name].iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        };
        assert!(bits(&plain) == bits(&ports), "{name}");
    }
    // Warmth moves the tip, by its growth.
    let warm: Vec<Vec<f64>> = rows.iter().map(|row| vec![row[0], row[1], 303.15]).collect();
    let names = ["command[1]", "command[2]", "actuator_temperature[1]"];
    let warm = run(folder, "ports.fmu", 2e-5, &names, &warm);
    for (k, (a, b)) in warm["tip[1]"].iter().zip(&ports["tip[1]"]).enumerate() {
        assert!((a - b - 2e-6).abs() < 1e-9, "row {k}: {a} {b}");
    }
    assert!(
        ports["heat[1]"].iter().all(|heat| *heat >= 0.0)
            && ports["heat[1]"].iter().any(|heat| *heat > 0.0)
    );
}

#[test]
fn what_is_not_known_is_refused_with_the_way_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    succeed(&["invert", "evc", "-o", "controller.toml"], folder);
    let toml = "piezoloop = 1\nkind = \"plant\"\nname = \"t\"\nstep = 1e-4\n[[axis]]\nname = \"x\"\n\
                command = { unit = \"V\", min = 0, max = 100 }\nposition = { unit = \"um\" }\n\
                [[axis.component]]\ntype = \"actuator-gain\"\ngain = 0.1\n[[axis.component]]\n\
                type = \"mode\"\nfrequency = 500\ndamping = 0.02\n";
    fs::write(folder.join("own.toml"), toml.replace("[[axis.component]]\ntype = \"mode\"",
        "[[axis.component]]\ntype = \"load-force\"\nstiffness = 5\n[[axis.component]]\ntype = \"mode\"")).expect("writable");
    // A second mode that moves the tip against its force.
    fs::write(
        folder.join("pair.toml"),
        toml.replace(
            "type = \"mode\"",
            "type = \"mode-pair\"\nsecond_frequency = 800\nsecond_damping = 0.01\nshare = -0.05",
        ),
    )
    .expect("writable");
    for (arguments, words) in [
        (
            &["evc", "--ports", "mechanical"][..],
            "axis Y, mechanical port: neither the blueprint nor a record that it takes states stiffness",
        ),
        (
            &["evc", "--ports", "mechanical", "--port-value", "Y.stiffness=20 N/um"],
            "axis Z, mechanical port",
        ),
        (
            &["evc", "--ports", "electrical", "--port-value", "capacitance=3 uF"],
            "states transduction or stiffness",
        ),
        (
            &["evc", "--ports", "thermal", "--port-value", "growth=0.1"],
            "states loss and capacitance",
        ),
        (
            &["p0", "--ports", "mechanical", "--port-value", "stiffness=1"],
            "which optics turn into a position",
        ),
        (
            &["pair.toml", "--ports", "mechanical", "--port-value", "stiffness=20 N/um"],
            "get out more energy than it puts in: at 80",
        ),
        (&["evc", "--ports", "mechanic"], "did you mean mechanical?"),
        (&["evc", "--ports", "X.mechanical"], "no axis is called X"),
        (
            &["evc", "--ports", "mechanical", "--port-value", "stifness=3"],
            "did you mean stiffness?",
        ),
        (&["evc", "--ports", "mechanical", "--port-value", "stiffness=20 V"], "stiffness"),
        (&["evc", "--ports", "mechanical", "--port-value", "stiffness=0"], "must be above zero"),
        (
            &["p1", "--ports", "mechanical", "--port-value", "loss=0.1"],
            "no port that is added needs it",
        ),
        (
            &["own.toml", "--ports", "mechanical", "--port-value", "stiffness=7"],
            "no port that is added needs it",
        ),
        (&["controller.toml", "--ports", "mechanical"], "this is a controller"),
    ] {
        println!("{arguments:?}");
        let message = refuse(&[&["pack"], arguments, &["-o", "no.fmu"]].concat(), folder);
        assert!(message.contains(words), "{arguments:?}: {message}");
        assert!(!folder.join("no.fmu").exists());
    }
    // One axis of two; a force that the blueprint has; a stiffness from the record of the printed values.
    let one = [
        "pack",
        "evc",
        "--ports",
        "Y.mechanical",
        "--port-value",
        "stiffness=20 N/um",
        "-o",
        "one.fmu",
    ];
    let packed = json(&one, folder);
    assert_eq!(packed["ports"].as_array().map(Vec::len), Some(1), "{packed}");
    let packed = json(&["pack", "own.toml", "--ports", "mechanical", "-o", "own.fmu"], folder);
    assert!(
        packed["ports"][0]["notes"][0]
            .as_str()
            .is_some_and(|n| n.contains("force is in the blueprint")),
        "{packed}"
    );
    let packed = json(&["pack", "p2", "--ports", "mechanical", "-o", "p2.fmu"], folder);
    assert_eq!(packed["ports"][0]["values"]["stiffness"]["value"], "1.1659e4 N/m", "{packed}");
}

/// A mode with a gain of its own: the tip has the stiffness that was stated.
#[test]
fn the_stated_stiffness_is_that_of_the_tip() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let toml = "piezoloop = 1\nkind = \"plant\"\nname = \"t\"\nstep = 1e-4\n[[axis]]\nname = \"x\"\n\
                command = { unit = \"V\", min = 0, max = 100 }\nposition = { unit = \"um\" }\n\
                [[axis.component]]\ntype = \"actuator-gain\"\ngain = 0.1\n[[axis.component]]\n\
                type = \"mode\"\nfrequency = 500\ndamping = 0.3\ngain = 0.8\n";
    fs::write(folder.join("t.toml"), toml).expect("writable");
    let pack =
        ["pack", "t.toml", "--ports", "mechanical,electrical", "--port-value", "stiffness=4 N/um"];
    let packed =
        json(&[&pack[..], &["--port-value", "capacitance=1 uF", "-o", "t.fmu"]].concat(), folder);
    let rows: Vec<Vec<f64>> = (0..1000).map(|k| vec![0.0, if k > 0 { 2.0 } else { 0.0 }]).collect();
    let out = run(folder, "t.fmu", 1e-4, &["command[1]", "force[1]"], &rows);
    let end = out["tip[1]"].last().expect("rows");
    assert!((end / 0.5e-6 - 1.0).abs() < 1e-9, "{end}");
    // 4 N/um times 0.08 um/V.
    assert_eq!(
        packed["ports"][1]["values"]["transduction"]["value"], "3.200000e-1 C/m",
        "{packed}"
    );
}

/// fmpy's validation of both versions; the terminals against the standard's schema, and their members against
/// the model description.
#[test]
fn fmpy_finds_no_fault_and_the_terminals_are_those_of_the_standard() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (rig, version) in [("evc", "2"), ("evc", "3"), ("p1", "2"), ("p1", "3")] {
        let file = format!("{rig}{version}.fmu");
        let mut pack = vec![
            "pack",
            rig,
            "--fmi",
            version,
            "--ports",
            "mechanical,electrical,thermal",
            "-o",
            &file,
        ];
        for value in ["stiffness=20 N/um", "capacitance=3.1 uF", "growth=0.2 um/K", "loss=0.02"] {
            pack.extend(["--port-value", value]);
        }
        succeed(&pack, folder);
        succeed(&["check", &file], folder);
    }
    succeed(&["pack", "evc", "--fmi", "3", "-o", "plain3.fmu"], folder);
    let code = r#"
import sys, zipfile, pathlib
import fmpy
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from lxml import etree
for name in ("evc2.fmu", "p12.fmu", "evc3.fmu", "p13.fmu"):
    problems = validate_fmu(name)
    assert not problems, (name, problems)
schema = pathlib.Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
schema = etree.XMLSchema(etree.parse(str(schema)))
for name in ("evc3.fmu", "p13.fmu", "plain3.fmu"):
    with zipfile.ZipFile(name) as archive:
        entries = archive.namelist()
        root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    schema.assertValid(root)
    variables = {v.name: v for v in read_model_description(name).modelVariables}
    for terminal in root.iter("Terminal"):
        members = [(m.get("memberName"), m.get("variableKind")) for m in terminal.iter("TerminalMemberVariable")]
        for m in terminal.iter("TerminalMemberVariable"):
            assert m.get("variableName") in variables, (name, m.get("variableName"))
        icon = terminal.find("TerminalGraphicalRepresentation").get("iconBaseName")
        assert f"terminalsAndIcons/{icon}.png" in entries, entries
        print(name, terminal.get("name"), terminal.get("matchingRule"), members)
"#;
    let message = python::script(code, &[], folder);
    println!("{message}");
    assert_eq!(message.matches("plug").count(), 6, "{message}");
    assert!(!message.contains("plain3.fmu"), "{message}");
    assert!(
        message.contains("[('force', 'inflow'), ('tip', 'signal'), ('tip_velocity', 'signal')]"),
        "{message}"
    );
    assert!(
        message.contains("[('voltage', 'signal'), ('current', 'inflow'), ('charge', 'signal')]"),
        "{message}"
    );
    assert!(
        message.contains("[('actuator_temperature', 'signal'), ('heat', 'outflow')]"),
        "{message}"
    );
}

/// Example 11 in other masters: the same motion, force and power as in ours.
#[test]
fn the_cutting_process_runs_in_other_masters_as_in_ours() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let example = root().join("examples/11_cutting_force/run.sh");
    let tools = Path::new(env!("CARGO_BIN_EXE_piezoloop")).parent().expect("a folder");
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::iter::once(tools.to_owned()).chain(std::env::split_paths(&path));
    let mut sh = std::process::Command::new("sh");
    sh.arg(example).arg(folder).env("PYTHON", python::python());
    sh.env("PATH", std::env::join_paths(paths).expect("a PATH"));
    println!("{}", foreign::message(&mut sh, folder));
    let (cut, ssp) = (fs::read(folder.join("cut.csv")), fs::read(folder.join("ssp.csv")));
    assert!(cut.expect("a run") == ssp.expect("a run"), "the SSP says what the TOML says");
    let jacobi = [
        "system",
        "cutting.ssp",
        "--input",
        "ellipse.csv",
        "--stop",
        "0.04",
        "--algorithm",
        "jacobi",
    ];
    succeed(&[&jacobi[..], &["-o", "jacobi.csv"]].concat(), folder);
    print!("{}", foreign::script(&python::python(), "cutting_in.py", &["fmpy.ssp"], folder));
    let Some(python) = foreign::python() else { return };
    for (tool, module) in [("libcosim", "libcosimpy"), ("ecos", "ecospy")] {
        let loads =
            std::process::Command::new(python).args(["-c", &format!("import {module}")]).output();
        if !loads.expect("it starts").status.success() {
            println!("SKIPPED: {module} does not load");
            continue;
        }
        print!("{}", foreign::script(python, "cutting_in.py", &[tool], folder));
    }
}
