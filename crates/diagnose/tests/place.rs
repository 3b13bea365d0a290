//! What an amplifier lacks stands on the side of its lag where the machine has it.

use crate::common::machine::{Machine, Normal, RATE};
use crate::common::positions;
use components::COMPONENTS;
use data::{Blueprint, CheckedBlueprint, Log};
use diagnose::{Model, Noise, Request, Silent, examine};

const NOISE: f64 = 0.005;
const LAG: &str = "type = \"amplifier-lag\"\nname = \"amplifier\"\nbandwidth = 300\n";
const SLEW: &str = "type = \"amplifier-slew\"\nrate = 20000\n";
const CLAMP: &str = "type = \"amplifier-clamp\"\nlow = -200\nhigh = 95\n";

/// A plant with these parts of an amplifier.
fn plant(amplifier: &[&str]) -> CheckedBlueprint {
    let behind = [
        "type = \"prandtl-ishlinskii\"\nr = [0, 5, 12, 24, 40]\nw = [0.06, 0.01, 0.01, 0.01, 0.01]\n",
        "type = \"mode\"\nfrequency = 500\ndamping = 0.04\n",
    ];
    let parts = amplifier.iter().chain(&behind);
    let parts: String = parts.map(|part| format!("[[axis.component]]\n{part}")).collect();
    let text = format!(
        "piezoloop = 1\nkind = \"plant\"\nname = \"stage\"\nstep = {}\n[[axis]]\nname = \"X\"\n\
         command = {{ name = \"u\", unit = \"V\", min = 0, max = 120 }}\n\
         position = {{ name = \"y\", unit = \"um\" }}\n{parts}",
        1.0 / RATE
    );
    Blueprint::parse(&text, "stage.toml").unwrap().check(COMPONENTS).unwrap()
}

/// A log of the plant under a command.
fn log((number, command): (usize, Vec<f64>), plant: &CheckedBlueprint) -> Log {
    let mut noise = Normal::new(number as u64 + 1);
    let mut reading = positions(plant, &command, 1.0 / RATE);
    reading.iter_mut().for_each(|y| *y += NOISE * noise.draw());
    let time = (0..command.len()).map(|row| row as f64 / RATE).collect();
    let mut log = Log::new(&format!("{number}.csv"), time).unwrap();
    log.add_column("u", Some("V"), command).unwrap();
    log.add_column("y", Some("um"), reading).unwrap();
    log
}

#[test]
fn a_limit_stands_before_or_behind_the_lag_as_in_the_machine() {
    let kinds = |plant: &Blueprint| -> Vec<String> {
        plant.axes[0].components.iter().map(|part| part.kind.clone()).take(2).collect()
    };
    for (limit, name) in [(SLEW, "amplifier_slew"), (CLAMP, "amplifier_saturation")] {
        for amplifier in [[LAG, limit], [limit, LAG]] {
            let machine = plant(&amplifier);
            let commands = Machine::new(1, 0.0).commands();
            let logs = commands.into_iter().enumerate().map(|each| log(each, &machine)).collect();
            let mut request = Request::new(Model::Blueprint(Box::new(plant(&[LAG]))), logs);
            request.noise = Noise::Given(vec![(None, NOISE)]);
            let mut examined = examine(&request, &mut Silent).unwrap();
            let gap = &examined.gap;
            let names: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
            assert_eq!(names, [name], "{amplifier:?}: {}", gap.sentence);
            let left = gap.shrink.rms_after / NOISE;
            assert!(left < 1.03, "{amplifier:?}: {left} times the noise is left");
            let (repaired, _) = examined.repair(plant(&[LAG]).blueprint());
            assert_eq!(kinds(&repaired), kinds(machine.blueprint()), "{amplifier:?}");
        }
    }
}
