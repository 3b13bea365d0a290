//! The rate that widens a hysteresis is that of the command over the time that it is held, whatever
//! internal step divides this time and however the communication steps are cut.

use components::find;
use model::{AxisSpec, ComponentRef, Connections, Kind, NodeSpec, System, SystemSpec};

const SAMPLE: f64 = 1e-3;
/// Samples until all models do the same.
const SETTLED: usize = 10;

/// A model, its structure and its parameters, the rate among them.
type Rated = (&'static str, &'static [f64], fn(f64) -> Vec<f64>);

const MODELS: [Rated; 4] = [
    ("rate-dependent-play", &[2.0], |rate| vec![4.0, 12.0, 0.02, 0.01, 0.3, 0.05, rate]),
    ("grpi", &[2.0], |rate| vec![0.0, 12.0, 0.05, 0.01, 0.3, 1.0, -rate, 1.0, rate]),
    ("mpi", &[2.0], |rate| vec![4.0, 12.0, 0.02, 0.01, 0.3, 0.05, 1e-8, 1.0, rate]),
    ("dynamic-prandtl-ishlinskii", &[2.0, 4.0], |rate| {
        let (a, b) = (1e-2 * rate, 1e-6 * rate);
        vec![0.0, 12.0, 0.05, 0.01, a, a, a, a, b, b, b, b, 0.3]
    }),
];

fn machine(kind: &str, structure: &[f64], values: Vec<f64>, period: f64) -> System {
    let axis = AxisSpec {
        name: "X".to_owned(),
        command_unit: "V".to_owned(),
        position_unit: "um".to_owned(),
        command_range: (0.0, 100.0),
        position_range: (0.0, 20.0),
        start: 0.0,
        aliases: Vec::new(),
        components: vec![NodeSpec {
            component: ComponentRef::Static(find(kind).expect("a component")),
            name: "hysteresis".to_owned(),
            structure: structure.to_vec(),
            values,
            enabled: true,
        }],
    };
    let spec = SystemSpec {
        name: "stage".to_owned(),
        kind: Kind::Plant,
        period,
        axes: vec![axis],
        connections: Connections::default(),
    };
    System::new(&spec).expect("a system")
}

/// Positions at the samples of a triangle of 0 to 80 V at 10 Hz.
fn positions(mut machine: System, cuts: u32) -> Vec<f64> {
    let find = |machine: &System, name| machine.variables().find(name).expect("a variable");
    let (u, y) = (find(&machine, "command[1]"), find(&machine, "position[1]"));
    machine.initialise(0.0).expect("rest");
    (1..=300)
        .map(|n| {
            let phase = f64::from(n) / 100.0;
            machine.set(u, 160.0 * (phase - (phase + 0.5).floor()).abs()).expect("a command");
            for cut in 1..=cuts {
                let part = f64::from(cut) / f64::from(cuts) - 1.0;
                machine.advance((f64::from(n) + part) * SAMPLE).expect("a step");
            }
            machine.get(y).expect("a position")
        })
        .collect()
}

#[test]
fn the_internal_step_does_not_change_what_a_rate_does() {
    for (kind, structure, values) in MODELS {
        let run =
            |rate, parts: f64| positions(machine(kind, structure, values(rate), SAMPLE / parts), 1);
        let complete = run(1e-3, 1.0);
        for parts in [2.0, 5.0, 7.0] {
            let divided = run(1e-3, parts);
            let cut =
                positions(machine(kind, structure, values(1e-3), SAMPLE / parts), parts as u32);
            assert_eq!(divided, cut, "{kind}: in {parts} communication steps");
            // Three samples pass until it is known how long a command is held.
            let off = complete[SETTLED..]
                .iter()
                .zip(&divided[SETTLED..])
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(off < 1e-9, "{kind}: a step of a part of {parts} moves it by {off}");
            let faster = run(3e-3, parts);
            let effect = faster.iter().zip(&divided).map(|(a, b)| (a - b).abs());
            let effect = effect.fold(0.0, f64::max);
            assert!(effect > 1e-2, "{kind}: three times the rate moves it by {effect} only");
        }
    }
}
