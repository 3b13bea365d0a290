//! Blueprints of known machines. Each is a file of its own beside this one; this is their list.
//!
//! A machine of a paper is there twice. The *nominal* rig is what a controller may know; the *truth* is
//! richer and of another hysteresis family, and was matched to what the paper tells of the machine
//! without its method (`piezoloop list rigs --match`). Since then it is frozen by its hash: nothing
//! may tune it to a method.

/// A machine by name.
#[derive(Clone, Copy, Debug)]
pub struct Rig {
    /// Name, as the commands take it.
    pub name: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// The blueprint's text.
    pub blueprint: &'static str,
    /// SHA-256 of the text, in hexadecimal digits, of a truth that has been matched.
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
        name: "p1",
        summary: "PI P-752.21C nanopositioning stage, linear",
        blueprint: include_str!("p1.toml"),
        frozen: None,
    },
    Rig {
        name: "p1-truth",
        summary: "The same as a machine: Kuhnen hysteresis, creep, 40 Hz low-pass",
        blueprint: include_str!("p1-truth.toml"),
        frozen: Some("7202412982e2d58f7e49884c646052d7cbc27a1f166d4103154a87e76c813d59"),
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
        name: "p3",
        summary: "P66X30 nanopositioning stage, linear",
        blueprint: include_str!("p3.toml"),
        frozen: None,
    },
    Rig {
        name: "p3-truth",
        summary: "The same as a machine: plays that widen with the rate, creep, strain gauge",
        blueprint: include_str!("p3-truth.toml"),
        frozen: Some("03ecc1f717f1cb98c0f0771c2ccb6ef1823078be13b4a1ce90cc9212299da2fb"),
    },
    Rig {
        name: "evc",
        summary: "Elliptical vibration cutting device, axes Y and Z, as the paper identified it",
        blueprint: include_str!("evc.toml"),
        frozen: None,
    },
    Rig {
        name: "evc-truth",
        summary: "The same device as a machine to be identified: another hysteresis family, creep, noise",
        blueprint: include_str!("evc-truth.toml"),
        frozen: Some("c30f0d2f5864725cd08472e4f53ce2c3893a8143b97065196cb33b330c34e2f2"),
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
    /// Its text.
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
    fn matched_truths_are_frozen() {
        for rig in RIGS {
            let hash: String =
                Sha256::digest(rig.blueprint).iter().map(|byte| format!("{byte:02x}")).collect();
            if rig.name.ends_with("-truth") {
                assert_eq!(
                    rig.frozen,
                    Some(&*hash),
                    "{} was changed after it was matched",
                    rig.name
                );
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
}
