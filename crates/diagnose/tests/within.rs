//! A reading late by a part of a row, and a delay of a part of a row, are no mode near half the sample rate.

use std::f64::consts::TAU;

use crate::common::machine::Normal;
use components::COMPONENTS;
use data::{Blueprint, CheckedBlueprint, Log};
use diagnose::{Gap, Model, Noise, Reading, Request, Silent, Verdict, diagnose};

const SEED: u64 = 83;
/// Rows per second.
const RATE: f64 = 2000.0;
const ROWS: usize = 6000;
/// Steps of the machine in a row: the unit of what is late.
const FINE: usize = 100;
const HYSTERESIS: &str = "type = \"prandtl-ishlinskii\"\nr = [0, 4, 12]\nw = [0.4, 0.06, 0.05]\n";
const STRAIGHT: &str = "type = \"actuator-gain\"\ngain = 0.5\ntolerance = { gain = 0.02 }\n";

fn stage(step: f64, actuator: &str, frequency: f64) -> CheckedBlueprint {
    let text = format!(
        "piezoloop = 1\nkind = \"plant\"\nname = \"stage\"\nstep = {step}\n[[axis]]\nname = \"X\"\n\
         command = {{ name = \"u\", unit = \"V\", min = 0, max = 150, start = 50 }}\n\
         position = {{ name = \"y\", unit = \"um\" }}\n\
         [[axis.component]]\n{actuator}\
         [[axis.component]]\ntype = \"mode\"\nname = \"mechanics\"\nfrequency = {frequency}\ndamping = 0.05\n\
         tolerance = {{ frequency = 0.02, damping = 0.1 }}\n"
    );
    Blueprint::parse(&text, "stage.toml").unwrap().check(COMPONENTS).unwrap()
}

/// A log of a held command, each reading so many hundredths of a row later than its row, or earlier.
fn log(random: &mut Normal, actuator: &str, hundredths: isize, noise: f64) -> Log {
    let lines: Vec<(f64, f64)> = (0..32)
        .map(|k| (0.5 * 160_f64.powf(f64::from(k) / 31.0), TAU * random.uniform()))
        .collect();
    let step = 1.0 / (RATE * FINE as f64);
    let mut system = stage(step, actuator, 180.0).build();
    let of = |name: &str| system.variables().find(name).unwrap();
    let (input, output) = (of("command[1]"), of("position[1]"));
    let time: Vec<f64> = (0..ROWS).map(|row| row as f64 / RATE).collect();
    let command = |t: f64| -> f64 {
        let sum: f64 = lines.iter().map(|(f, phase)| (TAU * f * t + phase).sin()).sum();
        50.0 + 3.5 * sum * (t / 0.3).min(1.0)
    };
    let u: Vec<f64> = time.iter().map(|t| command(*t)).collect();
    system.set(input, u[0]).unwrap();
    system.initialise(0.0).unwrap();
    let wanted = |row: usize| (row * FINE) as isize + hundredths;
    let mut y = Vec::new();
    // Rows that would be read before the start.
    while wanted(y.len()) < 0 {
        y.push(system.get(output).unwrap() + noise * random.draw());
    }
    for n in 0..(ROWS * FINE) as isize {
        if y.len() < ROWS && wanted(y.len()) == n {
            y.push(system.get(output).unwrap() + noise * random.draw());
        }
        system.set(input, u[n as usize / FINE]).unwrap();
        system.advance((n + 1) as f64 * step).unwrap();
    }
    let mut log = Log::new("log.csv", time).unwrap();
    log.add_column("u", Some("V"), u).unwrap();
    log.add_column("y", Some("um"), y).unwrap();
    log
}

fn gap_of(actuator: &str, hundredths: isize, noise: f64, reading: Option<Reading>) -> Gap {
    let mut random = Normal::new(SEED);
    let logs = (0..2).map(|_| log(&mut random, actuator, hundredths, noise)).collect();
    let model = Model::Blueprint(Box::new(stage(1.0 / RATE, STRAIGHT, 179.0)));
    let mut request = Request::new(model, logs);
    request.noise = Noise::Given(vec![(None, noise)]);
    request.reading = reading;
    diagnose(&request, &mut Silent).unwrap()
}

#[test]
fn a_reading_late_by_a_part_of_a_row_is_no_effect() {
    for (hundredths, noise) in [(0, 1e-4), (1, 1e-4), (8, 1e-4), (30, 1e-4), (50, 1e-4), (90, 1e-4)]
    {
        let gap = gap_of(STRAIGHT, hundredths, noise, None);
        let message = || format!("seed {SEED}, {hundredths}: {} {:?}", gap.sentence, gap.warnings);
        assert_eq!(gap.verdict, Verdict::Retune, "{}", message());
        let late = gap.outputs[0].reading_late;
        match (hundredths, late) {
            (0, None) => assert!(gap.warnings.is_empty(), "{}", message()),
            (_, Some(late)) => {
                let part = late * RATE * 100.0;
                assert!((part - hundredths as f64).abs() < 0.05, "{part}: {}", message());
                assert!(gap.warnings.iter().any(|w| w.contains("after its row")), "{}", message());
            }
            _ => panic!("{}", message()),
        }
    }
    // Who says that readings are taken at their rows is believed.
    let gap = gap_of(STRAIGHT, 8, 1e-3, Some(Reading::Before));
    assert_eq!(gap.outputs[0].reading_late, None, "seed {SEED}");
}

#[test]
fn a_delay_of_a_part_of_a_row_is_one_effect() {
    for (hundredths, noise) in [(-10, 1e-3), (-30, 1e-4), (-50, 1e-3), (-130, 1e-4)] {
        let gap = gap_of(STRAIGHT, hundredths, noise, None);
        let message = || format!("seed {SEED}, {hundredths}: {} {:?}", gap.sentence, gap.warnings);
        let [delay] = &gap.effects[..] else { panic!("{}", message()) };
        assert_eq!(delay.effect, "delay", "{}", message());
        let found = delay.parameters["delay.delay"].value * RATE * 100.0;
        assert!((found + hundredths as f64).abs() < 3.0, "{found}: {}", message());
        assert_eq!(gap.outputs[0].reading_late, None, "{}", message());
    }
}

#[test]
fn a_late_reading_hides_no_effect() {
    for hundredths in [0, 8, -8] {
        let gap = gap_of(HYSTERESIS, hundredths, 1e-2, None);
        let first = gap.effects.first().map(|e| e.effect.as_str());
        let message = || format!("seed {SEED}, {hundredths}: {} {:?}", gap.sentence, gap.warnings);
        assert_eq!(first, Some("hysteresis"), "{}", message());
    }
}
