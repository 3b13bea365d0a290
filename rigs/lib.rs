//! Blueprints of known machines. Each is a file of its own beside this one; this is their list.

/// A machine by name.
#[derive(Clone, Copy, Debug)]
pub struct Rig {
    /// Name, as the commands take it.
    pub name: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// The blueprint's text.
    pub blueprint: &'static str,
}

/// All rigs.
pub const RIGS: &[Rig] = &[
    Rig {
        name: "evc",
        summary: "Elliptical vibration cutting device, axes Y and Z, as the paper identified it",
        blueprint: include_str!("evc.toml"),
    },
    Rig {
        name: "evc-truth",
        summary: "The same device as a machine to be identified: another hysteresis family, creep, noise",
        blueprint: include_str!("evc-truth.toml"),
    },
    Rig {
        name: "p885",
        summary: "PI P-885.91 stack in an amplified flexure, identified from a measured 1 Hz log",
        blueprint: include_str!("p885.toml"),
    },
];

/// The rig of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Rig> {
    RIGS.iter().find(|rig| rig.name == name)
}
