//! Blueprints of known machines. Each is a file of its own beside this one; this is their list.
//!
//! A machine of a paper is there three times. The *nominal* rig is what a controller may know. The *machine*
//! is one that could exist: hysteresis after Rayleigh's law in the shape of a measured loop, creep, modes, amplifier,
//! sensor, from physics, makers' data and what the paper tells of its rig, and not from its tables of errors; the
//! papers' tables are reproduced on it, and `piezoloop-papers --match` says how far it is from what the paper's
//! baselines leave. The *truth* is an earlier stand-in that was fitted to those errors; examples run on it. Both are
//! frozen by their hash: nothing may tune them to a method.

/// A machine by name.
#[derive(Clone, Copy, Debug)]
pub struct Rig {
    /// Name, as the commands take it.
    pub name: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// The blueprint's text.
    pub blueprint: &'static str,
    /// SHA-256 of the text, in hexadecimal digits, of a machine or truth.
    pub frozen: Option<&'static str>,
}

/// All rigs.
pub const RIGS: &[Rig] = &[
    Rig {
        name: "p0",
        summary: "Laser beam steering, four axes and two detectors, as a controller may know it",
        blueprint: include_str!("p0.toml"),
        frozen: None,
    },
    Rig {
        name: "p0-truth",
        summary: "The same as a machine: asymmetric hysteresis, creep, modes, detectors with noise",
        blueprint: include_str!("p0-truth.toml"),
        frozen: Some("8febc01aeec122fe255c9486822dd4ebd4007501929bf3d9bd1613160d2005ff"),
    },
    Rig {
        name: "p0-machine",
        summary: "Laser beam steering as it could be: Rayleigh hysteresis, creep, modes, detectors with noise",
        blueprint: include_str!("p0-machine.toml"),
        frozen: Some("6105182b62b40d84217a9fcb1f0b985a80e051747302f817441a380dc0e14b64"),
    },
    Rig {
        name: "p1",
        summary: "PI P-752.21C nanopositioning stage, linear",
        blueprint: include_str!("p1.toml"),
        frozen: None,
    },
    Rig {
        name: "p1-truth",
        summary: "The same as a machine: Kuhnen hysteresis, creep, 40 Hz low-pass",
        blueprint: include_str!("p1-truth.toml"),
        frozen: Some("e8f273e072c3f99e9fc4472c402c5872ced46d3b21a4010b4643e26c0d8663a0"),
    },
    Rig {
        name: "p1-machine",
        summary: "P-752.21C as it could be: Rayleigh hysteresis of a measured stack, creep, 40 Hz low-pass",
        blueprint: include_str!("p1-machine.toml"),
        frozen: Some("12b36e3f63e4d22a4e8e66718047089153c74330455869036666410f6bffa934"),
    },
    Rig {
        name: "p2",
        summary: "Piezo bimorph with the Bouc-Wen model that the paper printed",
        blueprint: include_str!("p2.toml"),
        frozen: None,
    },
    Rig {
        name: "p2-truth",
        summary: "The same as a machine: plays that widen with the rate, creep, a light mode",
        blueprint: include_str!("p2-truth.toml"),
        frozen: Some("83e5f879dedb17cc8fc83d32ba71815b4d8f6a46e9d87a1617f4926b673140ad"),
    },
    Rig {
        name: "p2-machine",
        summary: "Piezo bimorph as it could be: Rayleigh hysteresis, creep, a light mode, laser sensor",
        blueprint: include_str!("p2-machine.toml"),
        frozen: Some("46d0a3406274e2a5973c111cbb57c5a0baf9b9983c7ca3d160c6dc3959f82c6c"),
    },
    Rig {
        name: "p3",
        summary: "P66X30 nanopositioning stage, linear",
        blueprint: include_str!("p3.toml"),
        frozen: None,
    },
    Rig {
        name: "p3-truth",
        summary: "The same as a machine: plays that widen with the rate, creep, strain gauge",
        blueprint: include_str!("p3-truth.toml"),
        frozen: Some("bca9710b7a7943078e3ca3ab7e496bf784953181cf44e452af3c1720bea065fd"),
    },
    Rig {
        name: "p3-machine",
        summary: "P66X30 as it could be: Rayleigh hysteresis, material loss, strain gauge",
        blueprint: include_str!("p3-machine.toml"),
        frozen: Some("e8b305cbb4e012b2b21d6da2fe8688aba6c757d0e4621a6c235694da12c3e1e2"),
    },
    Rig {
        name: "evc",
        summary: "Elliptical vibration cutting device, axes Y and Z, as the paper identified it",
        blueprint: include_str!("evc.toml"),
        frozen: None,
    },
    Rig {
        name: "p4-truth",
        summary: "The same device as the paper measured it: asymmetric hysteresis, creep, weak modes",
        blueprint: include_str!("p4-truth.toml"),
        frozen: Some("46c55e859afba6065e13ace66fa3f5c52f9228eef1f6e7333c8c99ec7a1b7966"),
    },
    Rig {
        name: "evc-truth",
        summary: "The same device with smoother loops, to be identified: another hysteresis family, noise",
        blueprint: include_str!("evc-truth.toml"),
        frozen: Some("0041c5cd88a645d4dd33f38b1230c4c45c287c9c7f05c0f277926e7832762abc"),
    },
    Rig {
        name: "p4-machine",
        summary: "The device as it could be: Rayleigh hysteresis, creep, the finite elements' modes",
        blueprint: include_str!("p4-machine.toml"),
        frozen: Some("373faf690765e4a80574edd977345327b700c9f140cbb94e7ed545cb50a961db"),
    },
    Rig {
        name: "p885",
        summary: "PI P-885.91 stack in an amplified flexure, identified from a measured 1 Hz log",
        blueprint: include_str!("p885.toml"),
        frozen: None,
    },
];

/// Blueprint of a plant that has every effect at its default strength, switched off where it can be.
pub const EFFECTS: &str = include_str!("effects.toml");

/// A record: the values of one specimen with their sources, apart from the components that take them.
/// A blueprint's component takes them by `record = "p-752-21c"`.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Name, as blueprints write it.
    pub name: &'static str,
    /// The record's text.
    pub text: &'static str,
}

/// All records.
pub const RECORDS: &[Record] = &[
    Record { name: "p-752-21c", text: include_str!("records/p-752-21c.toml") },
    Record { name: "t434-a4-201", text: include_str!("records/t434-a4-201.toml") },
    Record { name: "evc-y", text: include_str!("records/evc-y.toml") },
    Record { name: "evc-z", text: include_str!("records/evc-z.toml") },
];

/// The record of this name.
#[must_use]
pub fn record(name: &str) -> Option<&'static Record> {
    RECORDS.iter().find(|record| record.name == name)
}

/// The rig of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Rig> {
    RIGS.iter().find(|rig| rig.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sha2::{Digest, Sha256};

    #[test]
    fn machines_and_truths_are_frozen() {
        for rig in RIGS {
            let hash: String =
                Sha256::digest(rig.blueprint).iter().map(|byte| format!("{byte:02x}")).collect();
            if rig.name.ends_with("-truth") || rig.name.ends_with("-machine") {
                assert_eq!(rig.frozen, Some(&*hash), "{} was changed", rig.name);
            } else {
                assert_eq!(rig.frozen, None, "{}", rig.name);
            }
        }
    }

    /// Each value belongs to a parameter of a component, and fits it: unit, bounds, length.
    #[test]
    fn records_fit_the_components_that_they_name() {
        for file in RECORDS {
            let record = data::ParameterRecord::parse(file.text, file.name)
                .unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(record.name, file.name);
            for (kind, values) in &record.components {
                let component = components::find(kind).unwrap_or_else(|| panic!("{kind}"));
                let text = format!(
                    "piezoloop = 1\nkind = \"plant\"\nname = \"t\"\nstep = 1e-4\n[[axis]]\n\
                     name = \"x\"\ncommand = {{ unit = \"V\" }}\nposition = {{ unit = \"um\" }}\n\
                     [[axis.component]]\ntype = \"{kind}\"\nrecord = \"{}\"\n",
                    file.name
                );
                let blueprint = data::Blueprint::parse(&text, "test").expect("reads");
                let given: Vec<_> =
                    blueprint.axes[0].components[0].values.iter().map(|(name, _)| name).collect();
                assert_eq!(given, values.iter().map(|v| &v.name).collect::<Vec<_>>());
                // What is still wrong is what the record does not say, and the rest of the axis.
                let problems = blueprint.check(components::COMPONENTS).err();
                for problem in problems.iter().flat_map(|p| p.as_slice()) {
                    let mine = values.iter().any(|v| problem.place.ends_with(&v.name));
                    assert!(!mine, "{}: {problem}", file.name);
                }
                let _ = component.declaration();
            }
        }
    }

    #[test]
    fn names_are_unique() {
        for (at, rig) in RIGS.iter().enumerate() {
            assert!(RIGS[..at].iter().all(|other| other.name != rig.name), "{}", rig.name);
        }
    }

    /// Hits that are done in blocks are those done one by one, to the bit, whatever the partition.
    #[test]
    fn long_steps_give_the_bits_of_short_ones() {
        let texts = RIGS.iter().map(|rig| (rig.name, rig.blueprint)).chain([("all", EFFECTS)]);
        for (name, text) in texts {
            let blueprint = data::Blueprint::parse(text, name).expect("reads");
            let [mut long, mut short] =
                [0, 1].map(|_| blueprint.check(components::COMPONENTS).expect("is sound").build());
            let effects = (0..long.variables().len() as u32)
                .filter(|v| long.variables().get(*v).is_some_and(|v| v.name.ends_with(".enabled")));
            let effects: Vec<u32> = effects.collect();
            let axes = blueprint.axes.len();
            for (number, system) in [&mut long, &mut short].into_iter().enumerate() {
                // Every second effect that can be switched off is.
                for (k, effect) in effects.iter().enumerate() {
                    system.set(*effect, f64::from(k as u32 % 2)).expect("a switch");
                }
                let commands: Vec<u32> = (1..=axes)
                    .map(|axis| system.variables().find(&format!("command[{axis}]")))
                    .map(|reference| reference.expect("a command"))
                    .collect();
                system.initialise(0.0).expect("rests");
                let period = system.period();
                for row in 0..6_u32 {
                    for command in &commands {
                        system.set(*command, f64::from(1 + row * 3 % 7)).expect("in range");
                    }
                    for part in 1..=40 {
                        if number == 1 || part == 40 {
                            let hit = f64::from(row * 40 + part);
                            system.advance(hit * period).expect("finite");
                        }
                    }
                }
            }
            let (a, b) = (long.context(), short.context());
            assert_eq!(a.to_bytes(), b.to_bytes(), "{name}");
        }
    }
}
