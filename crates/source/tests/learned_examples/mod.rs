//! Models of the learned types, one for each: most run a table.
#![allow(unreachable_pub)]

use model::{AxisSpec, ComponentRef, Connections, Conversion, Kind, NodeSpec, SystemSpec, Table};

const T: f64 = 1e-3;

/// Type, structure, inputs of the table (none: it runs none), parameters.
type Example = (&'static str, &'static [f64], usize, &'static [f64]);

const RANGES: &[f64] = &[0.0, 150.0, -20.0, 80.0];

const PROCESS: &[f64] = &[0.0, 150.0, -20.0, 80.0, 5.0, 0.1];

/// Centres of the deviation of the process, and their two triangles in one row of its table.
const CENTRES: f64 = 2.0;
const TRIANGLES: [f64; 7] = [1.0, 0.3, 0.95, 2.0, 0.5, 1.5, 0.0];

const EXAMPLES: &[Example] = &[
    ("lssvm-narx", &[2.0 * T, 1.0, 1.0], 3, RANGES),
    ("lssvm-stops", &[T, 2.0, 1.0, 100.0, 0.8, 0.0], 4, RANGES),
    ("gaussian-process", &[T, 6.0, 2.0, 0.25, 0.5, CENTRES], 6, PROCESS),
    ("lssvm-inverse", &[T, 1.0, 1.0], 3, RANGES),
    ("lssvm-stops-inverse", &[T, 2.0, 1.0, 100.0, 0.8, 0.0], 4, RANGES),
    ("gp-inverse", &[T, 6.0, 2.0, 0.25, 0.5], 6, RANGES),
    ("lssvm-feedforward", &[T, 1.0, 1.0], 3, &[0.5, 0.0, 1e-3, 1e-6, -5.0, 5.0, -20.0, 80.0]),
    ("lssvm-term", &[T, 2.0, 2.0, 2.0], 5, &[0.5, 0.0, 0.0, 150.0, -5.0, 5.0, -20.0, 80.0]),
    ("learned-plays", &[5.0, 2.0, 1.0, 9.0, 1.0], 0, PLAYS.first_chunk::<34>().expect("its own")),
    ("inverse-learned-plays", &[5.0, 2.0, 1.0, 9.0, 0.0], 0, PLAYS),
];

/// Plays, creeps, one unit, scalars; the inverse's limits.
const PLAYS: &[f64] = &[
    0.0, 8.0, 16.0, 24.0, 40.0, 0.1, 0.03, 0.02, 0.02, 0.03, 0.02, 0.01, 0.05, 1.0, 0.03, 0.1, 0.5,
    -0.8, 1.1, 0.3, -0.6, 0.9, 2.0, -1.5, 0.0, 0.5, 0.1, 50.0, 50.0, -0.05, 0.02, 10.0, 10.0, 1.5,
    0.0, 100.0,
];

/// 40 support vectors in the unit cube, by the fractional parts of multiples of square roots.
fn table(inputs: usize, deviates: bool) -> Table {
    let part = |i: usize, k: usize| (((i + 1) as f64) * ((k + 2) as f64).sqrt()).fract();
    let mut rows = vec![0.1];
    rows.extend((0..inputs).map(|k| 0.8 + 0.1 * k as f64));
    for i in 0..40 {
        rows.push(0.2 * (part(i, inputs) - 0.4));
        rows.extend((0..inputs).map(|k| part(i, k)));
    }
    if deviates {
        for i in 50..52 {
            rows.push(0.0);
            rows.extend((0..inputs).map(|k| part(i, k)));
        }
        rows.extend(TRIANGLES);
    }
    Table::new(inputs + 1, rows).expect("rows")
}

/// Each type's name, whether it runs a table, and a model around it.
pub fn all() -> Vec<(&'static str, bool, SystemSpec)> {
    let library = components::COMPONENTS.len();
    let types = learned::COMPONENTS.iter().skip(library);
    let named: Vec<_> = types.map(|c| c.declaration().kind).collect();
    assert_eq!(
        named,
        EXAMPLES.iter().map(|e| e.0).collect::<Vec<_>>(),
        "each type has its example"
    );
    EXAMPLES.iter().map(|example| (example.0, example.2 > 0, system_of(example))).collect()
}

fn system_of((kind, structure, inputs, values): &Example) -> SystemSpec {
    let found = learned::COMPONENTS.iter().find(|c| c.declaration().kind == *kind);
    let found = *found.expect("registered");
    let component = match inputs {
        0 => ComponentRef::from(found),
        _ => found
            .with_table(
                structure,
                &table(*inputs, structure.last() == Some(&CENTRES) && *inputs == 6),
            )
            .expect("fits"),
    };
    let is_plant = component.declaration().conversion == Conversion::CommandToPosition;
    let node = NodeSpec {
        name: component.declaration().name.into(),
        component,
        structure: structure.to_vec(),
        values: values.to_vec(),
        enabled: true,
    };
    let axis = AxisSpec {
        name: "x".into(),
        command_unit: "V".into(),
        position_unit: "um".into(),
        command_range: (-1000.0, 1000.0),
        position_range: (f64::NEG_INFINITY, f64::INFINITY),
        start: 0.0,
        aliases: Vec::new(),
        components: vec![node],
    };
    SystemSpec {
        name: (*kind).into(),
        kind: if is_plant { Kind::Plant } else { Kind::Controller },
        period: T,
        axes: vec![axis],
        connections: Connections::default(),
    }
}
