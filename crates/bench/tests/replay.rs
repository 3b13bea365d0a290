//! A record is its replay: what a controller computed and what was sent come out again to the bit,
//! whatever the line did, from every kind of record.
//!
//! `PIEZOLOOP_CYCLES=1000000 PIEZOLOOP_SCRIPTS=200` makes it long.
#![allow(clippy::print_stdout)]

use std::path::Path;

use crate::common::{Law, PERIOD_NS, WATCH, controller, emulator, limits, names};
use bench::cycle::{Column, Cycle, Driver, Orders, Player, Setup, columns};
use bench::emulate::Script;
use bench::record::{About, Format, Journal, Recording, convert};
use bench::replay::{Difference, Recipe, RecipeAxis, Replayed, replay};
use bench::safety::{AxisLimits, State};
use bench::virtual_run::VirtualRun;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

const AXES: usize = 2;
const BLEND: u32 = 40;

/// Feedforward, an integrator and a term that carries every bit of its inputs into its state.
fn law() -> Law {
    Box::new(|_, inputs, state, u| {
        let (r, y) = inputs.split_at(AXES);
        for axis in 0..AXES {
            let error = r[axis] - y[axis];
            state[axis] += 0.2 * error;
            state[AXES + axis] = (0.9 * state[AXES + axis] + error).sin();
            u[axis] = 10.0 * r[axis] + state[axis] + 0.01 * state[AXES + axis];
        }
        true
    })
}

fn limits_here() -> AxisLimits {
    AxisLimits { tracking_error: f64::INFINITY, position_rate: f64::INFINITY, ..limits() }
}

fn columns_here() -> Vec<Column> {
    let named = |word: &str| names(word, AXES).into_iter().map(|n| (n, None)).collect::<Vec<_>>();
    columns(&named("reference"), &named("position"), &named("command"), true)
}

fn recipe() -> Recipe {
    let limits = limits_here();
    let axis = |n: usize| RecipeAxis {
        column: format!("reference[{n}]"),
        reference: format!("reference[{n}]"),
        position: format!("position[{n}]"),
        measured: format!("measured[{n}]"),
        command: format!("command[{n}]"),
        command_limits: limits.command,
        command_rate: limits.command_rate,
        safe: limits.safe,
        safe_rate: limits.safe_rate,
    };
    let axes = (1..=AXES).map(axis).collect();
    let version = Recipe::VERSION;
    Recipe { version, period_ns: PERIOD_NS, blend: BLEND, start: Default::default(), axes }
}

/// A virtual run of so many rows under a script, with deadlines missed at random.
fn rehearse(driver: Driver, script: Script, rows: usize) -> Vec<f64> {
    let value = |row: usize, axis: usize| 5.0 + 3.0 * (0.03 * row as f64 + axis as f64).sin();
    let table = (0..rows).flat_map(|row| (0..AXES).map(move |axis| value(row, axis))).collect();
    let mut random = ChaCha8Rng::seed_from_u64(script.seed);
    let cycle = Cycle::new(Setup {
        period_ns: PERIOD_NS,
        driver,
        player: Player::new(AXES, table, 50),
        limits: vec![limits_here(); AXES],
        watch: WATCH,
        blend: BLEND,
        first_sequence: 77,
    });
    let mut bench = VirtualRun::new(cycle, emulator(AXES, script), PERIOD_NS).recorded();
    while bench.next() < rows as u64 + 300 {
        let skipped = if random.next_u32() % 200 == 0 { random.next_u32() % 5 } else { 0 };
        let orders = Orders { start: bench.next() >= 10, ..Orders::default() };
        let state = bench.tick(&orders, skipped).unwrap().state;
        if matches!(state, State::Safe | State::Fault) && bench.cycle.at_rest() {
            break;
        }
    }
    bench.record().to_vec()
}

/// What a bad line and a bad machine do: three faults that a run survives, and one of four that may end it.
fn script(seed: u64, rows: usize) -> Script {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut pick = |all: &[&'static str]| all[random.next_u32() as usize % all.len()];
    let bearable = [
        "kind = \"loss\"\nprobability = 0.05\ndirection = \"both\"",
        "kind = \"jitter\"\nseconds = 1.5e-3",
        "kind = \"reorder\"\nprobability = 0.05\nseconds = 2.5e-3",
        "kind = \"duplicate\"\nprobability = 0.1",
        "kind = \"corrupt\"\nprobability = 0.05\ndirection = \"both\"",
        "kind = \"quantisation\"\nstep = 0.01",
        "kind = \"offset\"\naxis = 1\nvalue = -0.3",
        "kind = \"delay\"\nseconds = 1e-3",
    ];
    let end = [
        "kind = \"power-loss\"",
        "kind = \"nan\"\naxis = 2",
        "kind = \"restart\"",
        "kind = \"stuck\"",
    ];
    let chosen = [pick(&bearable), pick(&bearable), pick(&bearable), pick(&end)];
    // The last one comes near the end, so that most cycles run.
    let from = [0.0, 0.1, 0.2, 0.9].map(|part| part * rows as f64 * 1e-3);
    let faults = chosen
        .iter()
        .zip(from)
        .map(|(fault, from)| format!("[[fault]]\n{fault}\nfrom = {from:?}\n"));
    Script::parse(&format!("seed = {seed}\n{}", faults.collect::<String>()), "script").unwrap()
}

fn write(rows: &[f64], folder: &Path, name: &str, format: Format) -> Recording {
    let columns = columns_here();
    let provenance = serde_json::json!({ "tool": "piezoloop", "replay": recipe().to_toml().unwrap(), "a<b": "\"&\n" });
    let width = columns.len();
    let about = About { columns, provenance: provenance.as_object().unwrap().clone() };
    let mut journal = Journal::create(&folder.join("run.journal"), &about).unwrap();
    rows.chunks(1000 * width).for_each(|block| journal.write(block).unwrap());
    let journal = journal.finish().unwrap();
    convert(&journal, &folder.join(name), format, &Default::default()).unwrap();
    let found = Recording::read(&folder.join(name)).unwrap();
    assert_eq!(found.about("a<b").map(str::trim), Some("\"&"));
    std::fs::remove_file(journal).unwrap();
    found
}

fn replayed(recording: &Recording, law: Law) -> Replayed {
    let recipe = Recipe::parse(recording.about("replay").unwrap()).unwrap();
    replay(recording, &recipe, controller(AXES, law)).unwrap()
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().map_or(default, |text| text.parse().expect("a number"))
}

#[test]
fn every_record_under_faults_is_replayed_to_the_bit() {
    let rows = number("PIEZOLOOP_CYCLES", 4000) as usize;
    let folder = tempfile::tempdir().unwrap();
    let kinds = [("a.parquet", Format::Parquet), ("a.csv", Format::Csv), ("a.mf4", Format::Mf4)];
    let (mut cycles, mut compared, mut held) = (0, 0, 0);
    let scripts = number("PIEZOLOOP_SCRIPTS", 24);
    for seed in 0..scripts {
        let record = rehearse(controller(AXES, law()), script(seed, rows), rows);
        let (name, format) = kinds[seed as usize % kinds.len()];
        let recording = write(&record, folder.path(), name, format);
        let found = replayed(&recording, law());
        assert_eq!((found.differing, &found.first_difference), (0, &None), "seed {seed} {name}");
        assert!(!found.notes.iter().any(|note| note.contains("rows are missing")), "seed {seed}");
        held += u64::from(found.notes.iter().any(|note| note.contains("older position")));
        cycles += found.cycles;
        compared += found.compared;
    }
    println!("{cycles} cycles, {compared} numbers: the same bits; {held} scripts held positions");
    assert!(4 * held >= scripts && compared > cycles);
}

#[test]
fn the_first_difference_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let record = rehearse(controller(AXES, law()), Script::default(), 1000);
    let recording = write(&record, folder.path(), "a.csv", Format::Csv);
    // The last bit of one output in one step.
    let mut good = law();
    let other: Law = Box::new(move |step, inputs, state, u| {
        let answer = good(step, inputs, state, u);
        if step == 500 {
            u[1] = f64::from_bits(u[1].to_bits() ^ 1);
        }
        answer
    });
    let found = replayed(&recording, other);
    assert_eq!(found.differing, 2, "what was computed and what was sent");
    let width = columns_here().len();
    let Difference { row, cycle, time, signal, recorded, replayed: again, bits, .. } =
        found.first_difference.unwrap();
    assert_eq!((row, signal.as_str()), (500, "bench.computed.command[2]"));
    assert_eq!(time, record[500 * width]);
    assert_eq!(cycle, (time * 1e3).round() as u64);
    assert_eq!(recorded.to_bits() ^ again.to_bits(), 1);
    assert_eq!(bits[0], format!("{:016x}", record[501 * width - 1].to_bits()));
    // One that fails where the recorded one did not.
    let failing: Law = Box::new(|step, _, _, u| {
        u.fill(0.0);
        step < 3
    });
    let found = replayed(&recording, failing).first_difference.unwrap();
    assert_eq!((found.row, found.signal.as_str()), (3, "bench.state"));
    assert!(found.failure.is_some());
}

#[test]
fn failures_of_the_controller_are_replayed_too() {
    let folder = tempfile::tempdir().unwrap();
    for broken in [Some(f64::NAN), Some(f64::NEG_INFINITY), None] {
        let breaks = |at: u64| -> Law {
            let mut good = law();
            Box::new(move |step, inputs, state, u| {
                let answer = good(step, inputs, state, u);
                u[0] = if step >= at { broken.unwrap_or(u[0]) } else { u[0] };
                answer && (step < at || broken.is_some())
            })
        };
        let record = rehearse(controller(AXES, breaks(300)), Script::default(), 1000);
        let recording = write(&record, folder.path(), "a.parquet", Format::Parquet);
        let found = replayed(&recording, breaks(300));
        assert_eq!(found.first_difference, None, "{broken:?}");
        let never = replayed(&recording, law()).first_difference.unwrap();
        assert_eq!((never.row, never.signal.as_str()), (300, "bench.reason"), "{broken:?}");
        let later = replayed(&recording, breaks(100)).first_difference.unwrap();
        assert_eq!((later.row, later.signal.as_str()), (100, "bench.state"), "{broken:?}");
    }
}

#[test]
fn rows_that_are_missing_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let mut record = rehearse(controller(AXES, law()), Script::default(), 500);
    let width = columns_here().len();
    record.drain(200 * width..203 * width);
    let recording = write(&record, folder.path(), "a.mf4", Format::Mf4);
    let found = replayed(&recording, law());
    let note = "3 rows are missing in the record, from row 200";
    assert!(found.notes.iter().any(|found| found.starts_with(note)), "{found:?}");
    assert_eq!(found.first_difference.unwrap().row, 200);
}
