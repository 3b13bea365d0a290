//! The generator's baseline is the plant of the components: a model within tolerance can match.

use components::COMPONENTS;
use data::Blueprint;
use gap_machines::{Baseline, Drive, Kind, Machine, Random, blueprint};

const RATE: f64 = 4000.0;

fn drive(kind: Kind) -> Drive {
    let command = kind.command(4000, 1.0 / RATE, 1.0, &mut Random::new(5, &[]));
    Drive { neighbour: vec![0.0; command.len()], command, record: 0 }
}

/// The plant that the blueprint describes, driven row by row.
fn plant(text: &str, command: &[f64]) -> Vec<f64> {
    let checked = Blueprint::parse(text, "machine").unwrap().check(COMPONENTS).unwrap();
    let mut system = checked.build();
    let (input, output) = {
        let variables = system.variables();
        (variables.find("command[1]").unwrap(), variables.find("position[1]").unwrap())
    };
    system.set(input, command[0]).unwrap();
    system.initialise(0.0).unwrap();
    let mut positions = Vec::new();
    for (row, value) in command.iter().enumerate() {
        positions.push(system.get(output).unwrap());
        system.set(input, *value).unwrap();
        system.advance((row + 1) as f64 / RATE).unwrap();
    }
    positions
}

#[test]
fn generator_and_components_agree_on_every_kind_of_record() {
    let mut with_bandwidths = 0;
    for seed in 0..6 {
        let full = Baseline::draw(&mut Random::new(seed, &[]));
        with_bandwidths += usize::from(full.sensor.is_some());
        for model in [full.clone(), full.linear()] {
            let text = blueprint("machine", &[&model], 1.0 / RATE);
            for kind in [Kind::Multisine, Kind::FallingTriangle, Kind::Staircase] {
                let drive = drive(kind);
                let here = Machine::plain(&model, 1.0 / RATE).run(&drive);
                let there = plant(&text, &drive.command);
                let largest =
                    here.iter().zip(&there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(largest < 1e-9, "seed {seed}, {kind:?}: {largest} um");
            }
        }
    }
    assert!((1..6).contains(&with_bandwidths));
}
