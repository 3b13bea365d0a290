//! The one table of all families of cases.

use gap_machines::{Setting, Timing};

/// What cases of a family have in common.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// The family's name, as `--cases` takes it.
    pub name: &'static str,
    /// What the family is about.
    pub about: &'static str,
    /// Cases of the full benchmark.
    pub full: usize,
    /// Cases of the short form.
    pub short: usize,
    /// What is withheld.
    pub(crate) content: Content,
    /// How the records are made.
    pub(crate) setting: Setting,
    /// Whether the model is an FMU.
    pub(crate) is_black_box: bool,
    /// Number of axes.
    pub(crate) axes: usize,
    /// Offset that all readings share, over the noise.
    pub(crate) offset: f64,
    /// When readings are taken, and how the command runs between rows.
    pub(crate) timing: Timing,
    /// Whether a smooth part of the gap is in no formula: 1 to 5 % of its power.
    pub(crate) is_smooth: bool,
    /// Whether the model is what the tool identifies from one log of the machine without its effect.
    pub(crate) is_identified: bool,
}

/// What is withheld.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Content {
    /// Nothing.
    None,
    /// Nothing; model and machine are straight lines.
    NoneLinear,
    /// One effect of the list, all in turn.
    Single,
    /// One effect that others resemble, about as large as the noise, in a record of 1.6 s.
    Faint,
    /// One of the effects inside a box that its outside does not show: loops that are skewed or grow with the rate,
    /// and friction.
    Inside,
    /// An effect of `Inside` whose own candidate is taken out of the library.
    Removed,
    /// One of the effects that are counted apart.
    Apart,
    /// One effect that is in nobody's library.
    Stray,
    /// So many effects of the list, different ones, of 6 or 20 σ.
    Several(usize),
    /// The weights of the model's plays are wrong.
    WrongWeights,
    /// The weights of the model's plays are wrong, and there is an effect of 6 or 20 σ.
    WrongWeightsAndSingle,
    /// The model is a straight line, the machine has hysteresis.
    NoHysteresis,
    /// One effect, 25 s of log at 10 kHz: for the time.
    Long,
}

const OPEN: Family = Family {
    name: "",
    about: "",
    full: 0,
    short: 0,
    content: Content::None,
    setting: Setting::OpenLoop,
    is_black_box: false,
    axes: 1,
    offset: 0.0,
    timing: Timing::Before,
    is_smooth: false,
    is_identified: false,
};

/// All families. A full benchmark has at least 500 cases without effect and 30 per effect and size.
pub const FAMILIES: &[Family] = &[
    Family {
        name: "none",
        about: "no effect, values off within tolerance",
        full: 250,
        short: 6,
        ..OPEN
    },
    Family {
        name: "none-linear",
        about: "no effect, straight line",
        full: 50,
        short: 1,
        content: Content::NoneLinear,
        ..OPEN
    },
    Family {
        name: "none-closed-loop",
        about: "no effect, closed loop",
        full: 60,
        short: 1,
        setting: Setting::ClosedLoop,
        ..OPEN
    },
    Family {
        name: "none-operation",
        about: "no effect, log of production only",
        full: 60,
        short: 1,
        setting: Setting::Operation,
        ..OPEN
    },
    Family {
        name: "none-black-box",
        about: "no effect, the model is an FMU",
        full: 60,
        short: 1,
        is_black_box: true,
        ..OPEN
    },
    Family {
        name: "none-two-axes",
        about: "no effect, two axes",
        full: 40,
        short: 1,
        axes: 2,
        ..OPEN
    },
    Family {
        name: "single",
        about: "one effect",
        full: 2340,
        short: 10,
        content: Content::Single,
        ..OPEN
    },
    Family {
        name: "removed",
        about: "one effect, its own candidate removed",
        full: 780,
        short: 3,
        content: Content::Removed,
        ..OPEN
    },
    Family {
        name: "unknown",
        about: "an effect that is in no library",
        full: 210,
        short: 3,
        content: Content::Stray,
        ..OPEN
    },
    Family {
        name: "apart",
        about: "noise, resolution, start of the record",
        full: 90,
        short: 1,
        content: Content::Apart,
        ..OPEN
    },
    Family {
        name: "pair",
        about: "two effects",
        full: 200,
        short: 2,
        content: Content::Several(2),
        ..OPEN
    },
    Family {
        name: "triple",
        about: "three effects",
        full: 40,
        short: 0,
        content: Content::Several(3),
        ..OPEN
    },
    Family {
        name: "wrong-hysteresis",
        about: "weights of the plays 30 % off",
        full: 40,
        short: 1,
        content: Content::WrongWeights,
        ..OPEN
    },
    Family {
        name: "wrong-hysteresis-single",
        about: "the same and one effect",
        full: 78,
        short: 0,
        content: Content::WrongWeightsAndSingle,
        ..OPEN
    },
    Family {
        name: "no-hysteresis",
        about: "straight line, the machine has hysteresis",
        full: 60,
        short: 1,
        content: Content::NoHysteresis,
        ..OPEN
    },
    Family {
        name: "closed-loop",
        about: "one effect, closed loop",
        full: 150,
        short: 1,
        content: Content::Single,
        setting: Setting::ClosedLoop,
        ..OPEN
    },
    Family {
        name: "operation",
        about: "one effect, log of production only",
        full: 156,
        short: 1,
        content: Content::Single,
        setting: Setting::Operation,
        ..OPEN
    },
    Family {
        name: "black-box",
        about: "one effect, the model is an FMU",
        full: 156,
        short: 1,
        content: Content::Single,
        is_black_box: true,
        ..OPEN
    },
    Family {
        name: "two-axes",
        about: "one effect on one of two axes",
        full: 156,
        short: 1,
        content: Content::Single,
        axes: 2,
        ..OPEN
    },
    Family {
        name: "long",
        about: "one effect, 25 s at 10 kHz",
        full: 4,
        short: 0,
        content: Content::Long,
        ..OPEN
    },
    // New families stand last: a case is drawn by the number of its family.
    Family {
        name: "black-box-inside",
        about: "skewed loops, loops that grow with the rate, friction; the model is an FMU",
        full: 36,
        short: 0,
        content: Content::Inside,
        is_black_box: true,
        ..OPEN
    },
    Family {
        name: "common-offset",
        about: "one effect, all readings share an offset of 30 σ; the model is an FMU",
        full: 52,
        short: 0,
        content: Content::Single,
        is_black_box: true,
        offset: 30.0,
        ..OPEN
    },
    Family {
        name: "ambiguous",
        about: "one faint effect of a group, a short log of production; where several names are left, up to two experiments are made",
        full: 1650,
        short: 2,
        content: Content::Faint,
        setting: Setting::Operation,
        ..OPEN
    },
    Family {
        name: "reading-after",
        about: "one effect, readings are taken at the end of their row's period",
        full: 52,
        short: 1,
        content: Content::Single,
        timing: Timing::After,
        ..OPEN
    },
    Family {
        name: "band-limited",
        about: "one effect, the command is band-limited between the rows",
        full: 52,
        short: 1,
        content: Content::Single,
        timing: Timing::BandLimited,
        ..OPEN
    },
    Family {
        name: "smooth-rest",
        about: "one effect, beside it a smooth 1 to 5 % of the gap's power that no formula has",
        full: 52,
        short: 1,
        content: Content::Single,
        is_smooth: true,
        ..OPEN
    },
    Family {
        name: "identified",
        about: "one effect, the model is identified from one log of the machine without it",
        full: 52,
        short: 1,
        content: Content::Single,
        is_identified: true,
        ..OPEN
    },
];

/// Whether further experiments are made where several names are left.
pub(crate) fn is_ambiguous(family: &str) -> bool {
    family == "ambiguous"
}
