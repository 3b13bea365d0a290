//! What is declared about the learned components.

use model::{
    Conversion, Declaration, Effect, Inverse, Output, Quantity, Stage, Structural, Undoing,
};

use super::Family;

pub(super) const SAMPLE_TIME: Structural = Structural {
    name: "sample_time",
    unit: "s",
    description: "Sample time of the learned model, a whole number of internal steps",
    start: None,
    min: 1e-9,
    max: 1e3,
    integer: false,
};

/// A count that must be given.
pub(super) const fn count(
    name: &'static str,
    description: &'static str,
    min: f64,
    max: f64,
) -> Structural {
    Structural { name, unit: "1", description, start: None, min, max, integer: true }
}

const SLOPE: Structural = Structural::real(
    "slope",
    "1",
    "Slope of the straight line over the scaled input that is added to the kernels",
    0.0,
    -1e6,
    1e6,
);

const NARX: &[Structural] = &[
    SAMPLE_TIME,
    count("past_inputs", "Number of past inputs, beside the present one", 0.0, 100.0),
    count("past_outputs", "Number of the model's own past outputs", 0.0, 100.0),
];
const STOPS: &[Structural] = &[
    SAMPLE_TIME,
    count("stops", "Number of stop operators", 0.0, 1000.0),
    Structural::real("range", "1", "Greatest scaled input of the stops", 1.0, 1e-9, 1e9),
    Structural::real("rate_scale", "1/s", "Divisor of the scaled rate", 1.0, 1e-12, 1e12),
    SLOPE,
    Structural {
        name: "projected",
        unit: "1",
        description: "1: the table's second row holds weights with which the stops are added to the input",
        start: Some(0.0),
        min: 0.0,
        max: 1.0,
        integer: true,
    },
];
const DERIVATIVES: &[Structural] = &[
    SAMPLE_TIME,
    count("inputs", "Number of inputs: 2, 6, 9 or 12", 2.0, 12.0),
    count("half", "Half length of the low-pass in samples, which is also its delay", 0.0, 1000.0),
    Structural::real(
        "cutoff",
        "1",
        "Cut-off of the low-pass in cycles per sample",
        0.25,
        1e-6,
        0.5,
    ),
    SLOPE,
];

const PROCESS_STRUCTURE: &[Structural] = &[
    DERIVATIVES[0],
    DERIVATIVES[1],
    DERIVATIVES[2],
    DERIVATIVES[3],
    DERIVATIVES[4],
    Structural {
        name: "deviation_centres",
        unit: "1",
        description: "Number of centres of the standard deviation, which is then the output deviation; the table's last rows hold them",
        start: Some(0.0),
        min: 0.0,
        max: 1000.0,
        integer: true,
    },
];

/// Of the feedforward without an inverse: its inputs are positions, its outputs hysteresis terms.
pub(super) const FEEDFORWARD_STRUCTURE: &[Structural] = NARX;
pub(super) const NARX_SOURCE_XU: &str =
    "Q. Xu, IEEE Trans. Ind. Electron. 60 (2013) 3927-3937, eqs. (5)-(9)";

const PARAMETERS: &[Quantity] = &[
    Quantity::new("command_low", "{command}", "Command that corresponds to 0 in the table")
        .start(0.0),
    Quantity::new("command_high", "{command}", "Command that corresponds to 1 in the table"),
    Quantity::new("position_low", "{position}", "Position that corresponds to 0 in the table")
        .start(0.0),
    Quantity::new("position_high", "{position}", "Position that corresponds to 1 in the table"),
];

const PROCESS_PARAMETERS: &[Quantity] = &[
    PARAMETERS[0],
    PARAMETERS[1],
    PARAMETERS[2],
    PARAMETERS[3],
    Quantity::new(
        "signal",
        "{position}",
        "Standard deviation of a position far from all samples, without noise",
    )
    .start(0.0)
    .min(0.0),
    Quantity::new("noise", "{position}", "Standard deviation of the noise of a measured position")
        .start(0.0)
        .min(0.0),
];

const NARX_SOURCE: &str = "Laser beam pointing with LS-SVM models of four piezo axes, eqs. (1)-(8), \
                           (12)";
const STOPS_SOURCE: &str = "LS-SVM with stop operators tuned by particle swarm, eqs. (17)-(19)";
const GP_SOURCE: &str = "Gaussian process with high-dimensional input, eqs. (8), (10), (13)-(19)";

const NARX_EQUATION: &str = "y(t) = bias + sum(w[i]*exp(-|x[i] - z|^2)); z = [u(t), u(t-1), ..., \
                             y(t-1), ...], scaled";
const STOPS_EQUATION: &str = "y(t) = slope*u + bias + sum(w[i]*exp(-|x[i] - z|^2)); z = [stops of \
                              u, u + sum(p[i]*stop[i]), u'], scaled";
const GP_EQUATION: &str = "y(t) = slope*u + mean + sum(w[i]*exp(-|x[i] - z|^2)); z = [u, u', u'', u'''] about \
                           t minus the delay, scaled; deviation^2 = signal^2*(1 - |v|^2 + |w|^2) + noise^2; L*v = k(z); C*w = v";

const fn plant(
    kind: &'static str,
    summary: &'static str,
    equation: &'static str,
    reference: &'static str,
    structure: &'static [Structural],
    effect: &'static Effect,
) -> Declaration {
    Declaration {
        kind,
        name: "hysteresis",
        summary,
        equation,
        reference,
        stage: Stage::Actuator,
        conversion: Conversion::CommandToPosition,
        effect: Some(effect),
        structure,
        parameters: PARAMETERS,
        ..Declaration::PATH
    }
}

const fn inverse(
    kind: &'static str,
    summary: &'static str,
    equation: &'static str,
    reference: &'static str,
    structure: &'static [Structural],
) -> Declaration {
    Declaration {
        kind,
        name: "feedforward",
        summary,
        equation,
        reference,
        stage: Stage::Control,
        conversion: Conversion::PositionToCommand,
        structure,
        parameters: PARAMETERS,
        ..Declaration::PATH
    }
}

use components::effects::HYSTERESIS;

pub(super) static LSSVM_NARX: &Family = &Family {
    declaration: &plant(
        "lssvm-narx",
        "Hysteresis learned by an LS-SVM over past commands and its own past outputs",
        NARX_EQUATION,
        NARX_SOURCE,
        NARX,
        &HYSTERESIS,
    ),
    inverses: &[],
    inverse: false,
    features: super::narx,
    deviating: None,
};
pub(super) static LSSVM_STOPS: &Family = &Family {
    declaration: &plant(
        "lssvm-stops",
        "Hysteresis learned by an LS-SVM over stop operators, the command and its rate",
        STOPS_EQUATION,
        STOPS_SOURCE,
        STOPS,
        &HYSTERESIS,
    ),
    inverses: &[Inverse { kind: "lssvm-stops-inverse", undoing: Undoing::Learned }],
    inverse: false,
    features: super::stops,
    deviating: None,
};
const PROCESS: Declaration = Declaration {
    parameters: PROCESS_PARAMETERS,
    ..plant(
        "gaussian-process",
        "Hysteresis learned by a Gaussian process over the command and its derivatives",
        GP_EQUATION,
        GP_SOURCE,
        PROCESS_STRUCTURE,
        &HYSTERESIS,
    )
};
static PROCESS_AND_DEVIATION: Declaration = Declaration {
    outputs: &[
        Output::PATH,
        Output::published(
            "deviation",
            "{position}",
            "Standard deviation that the Gaussian process predicts of a measured position",
            false,
        ),
    ],
    ..PROCESS
};
pub(super) static GAUSSIAN_PROCESS: &Family = &Family {
    declaration: &PROCESS,
    inverses: &[],
    inverse: false,
    features: super::derivatives,
    deviating: Some(&PROCESS_AND_DEVIATION),
};
pub(super) static LSSVM_INVERSE: &Family = &Family {
    declaration: &inverse(
        "lssvm-inverse",
        "Inverse learned by an LS-SVM over past positions and its own past commands",
        NARX_EQUATION,
        NARX_SOURCE,
        NARX,
    ),
    inverses: &[],
    inverse: true,
    features: super::narx,
    deviating: None,
};
pub(super) static LSSVM_STOPS_INVERSE: &Family = &Family {
    declaration: &inverse(
        "lssvm-stops-inverse",
        "Inverse learned by an LS-SVM over stop operators, the position and its rate",
        STOPS_EQUATION,
        STOPS_SOURCE,
        STOPS,
    ),
    inverses: &[],
    inverse: true,
    features: super::stops,
    deviating: None,
};
pub(super) static GP_INVERSE: &Family = &Family {
    declaration: &inverse(
        "gp-inverse",
        "Inverse learned by a Gaussian process over the position and its derivatives",
        GP_EQUATION,
        GP_SOURCE,
        DERIVATIVES,
    ),
    inverses: &[],
    inverse: true,
    features: super::derivatives,
    deviating: None,
};
