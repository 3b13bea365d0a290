//! A command that moves between the rows looks like a lag of the model that acts faster: the logs are read otherwise
//! before that lag is named.

use std::f64::consts::TAU;

use crate::common::machine::Normal;
use components::COMPONENTS;
use data::{Blueprint, CheckedBlueprint, Log};
use diagnose::{Between, Gap, Model, Noise, Reading, Request, Silent, Verdict, diagnose};

/// Rows per second.
const RATE: f64 = 4000.0;
/// Steps of the machine between two rows.
const FINE: usize = 16;
const ROWS: usize = 8000;
const SEED: u64 = 61;
const CREEP: &str = "[[axis.component]]\ntype = \"kelvin-voigt-creep\"\nshare = [0.03, 0.04]\n\
                     time_constant = [0.05, 0.4]\n";

/// An amplifier and plays, so that no part acts on another between two steps; and what the machine has behind them.
fn machine(step: f64, behind: &str) -> CheckedBlueprint {
    let text = format!(
        "piezoloop = 1\nkind = \"plant\"\nname = \"stage\"\nstep = {step}\n[[axis]]\nname = \"X\"\n\
         command = {{ name = \"u\", unit = \"V\", min = 0, max = 150 }}\n\
         position = {{ name = \"y\", unit = \"um\" }}\n\
         [[axis.component]]\ntype = \"amplifier-lag\"\nname = \"amplifier\"\nbandwidth = 600\n\
         tolerance = {{ bandwidth = 0.05 }}\n\
         [[axis.component]]\ntype = \"prandtl-ishlinskii\"\nr = [0, 15, 30, 45]\n\
         w = [0.06, 0.014, 0.012, 0.012]\n{behind}"
    );
    Blueprint::parse(&text, "stage.toml").unwrap().check(COMPONENTS).unwrap()
}

/// Waves in V.
fn command(lines: &[(f64, f64)], time: f64) -> f64 {
    let sum: f64 = lines.iter().map(|(f, phase)| (TAU * f * time + phase).sin()).sum();
    (75.0 + 9.0 * sum).clamp(0.0, 150.0)
}

/// What the command does between two rows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Course {
    Held,
    Moves,
    /// A converter interpolates: four values from row to row, each held.
    Stepped,
}
use Course::{Held, Moves, Stepped};

/// What diagnose says of a machine under waves up to `top` Hz; the model takes `steps` from row to row.
fn gap_of(seed: u64, behind: &str, course: Course, noise: f64, top: f64, steps: usize) -> Gap {
    let mut random = Normal::new(seed);
    let lines: Vec<(f64, f64)> =
        (0..24).map(|k| (1.0 * top.powf(f64::from(k) / 23.0), TAU * random.uniform())).collect();
    let step = 1.0 / (RATE * FINE as f64);
    let mut system = machine(step, behind).build();
    let of = |name: &str| system.variables().find(name).unwrap();
    let (input, output) = (of("command[1]"), of("position[1]"));
    system.set(input, command(&lines, 0.0)).unwrap();
    system.initialise(0.0).unwrap();
    let time: Vec<f64> = (0..ROWS).map(|row| row as f64 / RATE).collect();
    let (mut u, mut y) = (Vec::new(), Vec::new());
    for (row, start) in time.iter().enumerate() {
        u.push(command(&lines, *start));
        y.push(system.get(output).unwrap() + noise * random.draw());
        for part in 0..FINE {
            let n = row * FINE + part;
            let at = match course {
                Held => *start,
                // The mean over the step, nearly.
                Moves => (n as f64 + 0.5) * step,
                Stepped => (n / (FINE / 4) * (FINE / 4)) as f64 * step,
            };
            system.set(input, command(&lines, at)).unwrap();
            system.advance((n + 1) as f64 * step).unwrap();
        }
    }
    let mut log = Log::new("log.csv", time).unwrap();
    log.add_column("u", Some("V"), u).unwrap();
    log.add_column("y", Some("um"), y).unwrap();
    let model = Model::Blueprint(Box::new(machine(1.0 / (RATE * steps as f64), "")));
    let mut request = Request::new(model, vec![log]);
    request.noise = Noise::Given(vec![(None, noise)]);
    diagnose(&request, &mut Silent).unwrap()
}

#[test]
fn a_command_that_moves_between_the_rows_is_no_faster_lag_beside_the_effect() {
    for course in [Moves, Held] {
        let moves = course == Moves;
        let gap = gap_of(SEED, CREEP, course, 0.01, 60.0, 1);
        let names: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
        assert_eq!(names, ["creep"], "seed {SEED}: {} {:?}", gap.sentence, gap.warnings);
        let own = &gap.outputs[0];
        let read =
            if moves { (Between::Line, Reading::With) } else { (Between::Zoh, Reading::Before) };
        assert_eq!((own.between, own.reading), read, "seed {SEED}: {:?}", gap.warnings);
        // It leaves about as much: the lag is the reason.
        let is_lag = |w: &String| w.contains("a lag of the model would have to act faster");
        assert_eq!(gap.warnings.iter().any(is_lag), moves, "seed {SEED}: {:?}", gap.warnings);
    }
}

/// A held command is late by half a row: what makes a model earlier imitates that, a crosstalk or a mode far above the
/// command as well as a lag.
#[test]
fn a_command_that_moves_between_the_rows_is_no_other_effect_either() {
    for (noise, top) in [(0.01, 100.0), (0.02, 150.0), (0.03, 250.0)] {
        for (behind, wanted) in [("", &[][..]), (CREEP, &["creep"][..])] {
            for course in [Moves, Held] {
                let moves = course == Moves;
                let gap = gap_of(71, behind, course, noise, top, 1);
                let names: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
                assert_eq!(
                    names, wanted,
                    "{noise} {top} {moves}: {} {:?}",
                    gap.sentence, gap.warnings
                );
                assert_ne!(
                    gap.verdict,
                    Verdict::Unknown,
                    "{noise} {top} {moves}: {}",
                    gap.sentence
                );
                let is_held = gap.outputs[0].between == Between::Zoh;
                assert_eq!(is_held, !moves, "{noise} {top}: {:?}", gap.warnings);
            }
        }
    }
}

/// A model with several steps from row to row is played the course itself. A missing lag makes a held command the better
/// reading of the two, but explains nothing: it is found all the same.
#[test]
fn a_model_with_several_steps_from_row_to_row_follows_the_course() {
    let lag = "[[axis.component]]\ntype = \"sensor-lag\"\nbandwidth = 1500\n";
    for (behind, wanted) in [("", &[][..]), (CREEP, &["creep"][..]), (lag, &["sensor_bandwidth"])] {
        for course in [Moves, Stepped, Held] {
            let gap = gap_of(83, behind, course, 0.01, 250.0, 4);
            let names: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
            assert_eq!(names, wanted, "{course:?}: {} {:?}", gap.sentence, gap.warnings);
            assert_ne!(gap.verdict, Verdict::Unknown, "{course:?}: {}", gap.sentence);
            let is_held = gap.outputs[0].between == Between::Zoh;
            assert_eq!(is_held, course == Held, "{wanted:?}: {:?}", gap.warnings);
        }
    }
}
