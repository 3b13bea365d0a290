//! Plays between two curves with creep, and what a small network adds.
//!
//! ```text
//! b = u + half_range·bend·ξ²,                     ξ = (u − centre)/half_range, held within ±1.5
//! h = offset + Σ w_i P_i,                         P_i ← max(b − r_i, min(b + r_i, P_i))
//! v = h + Σ share_j z_j,                          ż_j = (h − z_j)/time_constant_j
//! y = v + position_half_range·(quadratic·η² + cubic·η³ + Σ height_n σ(bias_n + Σ weight_nm x_m))
//! σ(a) = c·(15 − 10c² + 3c⁴)/8,                   c = 8a/15, held within ±1
//! x = ξ; η = (v − position_centre)/position_half_range; the mean stop b − P_i of each quarter of the plays over
//!     half_range, times its part of all plays; (h − z_j)/position_half_range
//! ```
//!
//! * r, w, offset as in `prandtl-ishlinskii`; share, time_constant (s) as in `kelvin-voigt-creep`, at most three; bend,
//!   quadratic, cubic without unit, as parts of half a range.
//! * height_n: most that a unit of the network adds, as a part of position_half_range; weight: nine of each unit, one unit
//!   after the other.
//! * σ: the quintic that rises from −1 to 1 with slope 1 at 0 and two continuous derivatives. It takes no function of a
//!   library, so that every platform has the same bits. With `activation = 0`, also where a blueprint does not name it, σ is tanh.
//! * State: one number per play, per play that fills up a group of four, and per creep.
//! * Plays and units are stepped four at a time, so that a compiler puts them into vectors; the order of all sums is fixed.
//!
//! Bounded: beyond 1.5 half ranges the command counts as its limit, and the network adds at most
//! Σ |height_n|·position_half_range, whatever its weights. Limits: of what no record showed the network knows nothing but
//! that bound.
//!
//! Sources: K. Kuhnen, European Journal of Control 9 (2003) 407–418 (plays between curves); M. Brokate, J. Sprekels,
//! Hysteresis and Phase Transitions, Springer 1996, ch. 2 (the states of plays are all that a Preisach memory knows).

mod parts;

use components::hysteresis::numeric_inverse::{Forward, NumericInverse, Rates};
use components::linear::approach;
use model::{
    Component, Conversion, Declaration, Inverse, Quantity, Role, Sizes, Stage, Structural, Tick,
    Violation,
};

use parts::{CREEPS, Counts, EACH, GROUPS, Given, LANES, Scalars, TAIL, read, split};

#[cfg(feature = "train")]
pub use parts::unit_slope;
pub use parts::{INPUTS, unit};

/// Half ranges beyond which the command counts as its limit.
const REACH: f64 = 1.5;

/// The component `learned-plays`.
pub struct LearnedPlays;

/// The component `inverse-learned-plays`.
pub(super) static INVERSE: NumericInverse<LearnedPlays> =
    NumericInverse::new(&LearnedPlays, &INVERSE_DECLARATION);

const STRUCTURE: &[Structural] = &[
    Structural::count("plays", "Number of play operators", 1, 4096),
    Structural::count("elements", "Number of creep elements", 0, CREEPS),
    Structural::count("units", "Number of units of the network", 0, 100),
    Structural::count(
        "weights",
        "Number of weights of the network, nine per unit",
        0,
        100 * INPUTS,
    ),
    Structural {
        name: "activation",
        unit: "1",
        description: "Activation function of a unit: 1 a quintic limited to -1 and 1, 0 tanh",
        start: Some(0.0),
        min: 0.0,
        max: 1.0,
        integer: true,
    },
];

const fn number(name: &'static str, unit: &'static str, description: &'static str) -> Quantity {
    Quantity::new(name, unit, description)
}

const PARAMETERS: [Quantity; 16] = [
    number("r", "{command}", "Threshold of each play, increasing from 0")
        .role(Role::Threshold)
        .min(0.0)
        .per(0),
    number("w", "{position}/{command}", "Weight of each play")
        .role(Role::Weight)
        .min(0.0)
        .per(0)
        .fitted(),
    number("share", "1", "Final creep of each element, relative to the elongation")
        .min(0.0)
        .per(1)
        .fitted(),
    number("time_constant", "s", "Time constant of each element").min(1e-9).per(1).fitted(),
    number(
        "height",
        "1",
        "Greatest contribution of each unit, relative to half the position's range",
    )
    .per(2),
    number("bias", "1", "Bias of each unit").per(2),
    number("weight", "1", "Weight of each input of each unit, unit after unit").per(3),
    number("offset", "{position}", "Position of the plays at zero command").start(0.0).fitted(),
    number("bend", "1", "Quadratic deviation of the command at the end of its range").start(0.0),
    number("centre", "{command}", "Middle of the command's range"),
    number("half_range", "{command}", "Half of it").min(0.0),
    number("quadratic", "1", "Quadratic deviation of the position at the end of its range")
        .start(0.0),
    number("cubic", "1", "Cubic deviation of the position at the end of its range").start(0.0),
    number("position_centre", "{position}", "Middle of the position's range"),
    number("position_half_range", "{position}", "Half of it").min(0.0),
    number("beyond", "1", "Half ranges beyond which the command counts as its limit")
        .start(REACH)
        .min(1.0)
        .max(10.0),
];

static DECLARATION: Declaration = Declaration {
    kind: "learned-plays",
    name: "hysteresis",
    summary: "Plays between two curves with creep, and a small network over their states",
    equation: "v = offset + sum(w[i]*P[i]) + creep; y = v + position_half_range*(quadratic*eta^2 + \
               cubic*eta^3 + sum(height[n]*s(bias[n] + sum(weight[n,m]*x[m])))); s(a) = \
               c*(15 - 10*c^2 + 3*c^4)/8, c = 8*a/15 within -1 and 1, or tanh(a); x = command, \
               position, stops, creeps, scaled",
    reference: "K. Kuhnen, European Journal of Control 9 (2003) 407-418",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&components::effects::ASYMMETRY),
    structure: STRUCTURE,
    parameters: &PARAMETERS,
    ..Declaration::PATH
};

const INVERSE_PARAMETERS: [Quantity; 18] = {
    let mut all = [PARAMETERS[0]; 18];
    let mut at = 0;
    while at < PARAMETERS.len() {
        all[at] = PARAMETERS[at];
        at += 1;
    }
    all[16] = number("command_min", "{command}", "Least command that the inverse gives");
    all[17] = number("command_max", "{command}", "Greatest command that the inverse gives");
    all
};

static INVERSE_DECLARATION: Declaration = Declaration {
    kind: "inverse-learned-plays",
    name: "feedforward",
    summary: "Inverse of a learned-plays model, solved at each step",
    equation: "learned-plays(u) = y, on a copy of the model",
    reference: "K. Kuhnen, European Journal of Control 9 (2003) 407-418",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: STRUCTURE,
    parameters: &INVERSE_PARAMETERS,
    ..Declaration::PATH
};

fn violation(quantity: &'static str, value: f64, rule: &'static str) -> Violation {
    Violation { quantity, index: None, value, rule }
}

const WRONG_LENGTH: &str = "this component was given a wrong number of values";

fn check(given: &Given<'_>) -> Result<(), Violation> {
    let scalars = Scalars::of(given.scalars);
    let rule = "thresholds start at 0 or above and are strictly increasing; sort them";
    for (index, pair) in given.r.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            let (quantity, index) = ("r", Some(index + 1));
            return Err(Violation { quantity, index, value: pair[1], rule });
        }
    }
    let sum: f64 = given.w.iter().sum();
    if sum <= 0.0 {
        return Err(violation("w", sum, "the sum of the weights is zero: nothing would move"));
    }
    for (quantity, half) in
        [("half_range", scalars.half), ("position_half_range", scalars.position_half)]
    {
        if half <= 0.0 {
            return Err(violation(quantity, half, "must be above zero"));
        }
    }
    // The command's curve must not turn back within its limits.
    if 2.0 * scalars.bend.abs() * scalars.beyond >= 1.0 {
        let rule = "the command's curve turns back within `beyond` half ranges; bend it less";
        return Err(violation("bend", scalars.bend, rule));
    }
    Ok(())
}

impl Component for LearnedPlays {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::iteration("inverse-learned-plays")] }
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let none = Sizes { coefficients: 0, states: 0 };
        Counts::of(structure).map_or(none, |counts| Sizes {
            coefficients: counts.coefficients(),
            states: counts.states(),
        })
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let counts = Counts::of(structure).ok_or_else(|| {
            let rule = "must be nine per unit: command, position, four stops, three creeps";
            violation("weight", structure.get(3).copied().unwrap_or(0.0), rule)
        })?;
        let wrong = || violation("r", parameters.len() as f64, WRONG_LENGTH);
        let given = split(parameters, counts).ok_or_else(wrong)?;
        check(&given)?;
        if coefficients.len() != counts.coefficients() {
            return Err(wrong());
        }
        coefficients.fill(0.0);
        let (r, rest) = coefficients.split_at_mut(counts.filled());
        let (w, rest) = rest.split_at_mut(counts.filled());
        let mut from = 0;
        for (group, [first, _]) in counts.groups().into_iter().enumerate() {
            let end = counts.end(group);
            let to = LANES * first..LANES * first + (end - from);
            r[to.clone()].copy_from_slice(&given.r[from..end]);
            w[to].copy_from_slice(&given.w[from..end]);
            from = end;
        }
        let (share, rest) = rest.split_at_mut(counts.elements);
        share.copy_from_slice(given.share);
        let (fraction, rest) = rest.split_at_mut(counts.elements);
        for (fraction, time) in fraction.iter_mut().zip(given.time_constant) {
            *fraction = approach(*time, period);
        }
        let (network, rest) = rest.split_at_mut(rest.len() - Scalars::COUNT - TAIL);
        let units = given.height.iter().zip(given.bias).zip(given.weight.as_chunks::<INPUTS>().0);
        for (n, ((height, bias), weight)) in units.enumerate() {
            let block = network[n / LANES * LANES * EACH..].iter_mut().skip(n % LANES);
            let numbers = weight.iter().chain([bias, height]);
            block.step_by(LANES).zip(numbers).for_each(|(to, number)| *to = *number);
        }
        let (scalars, tail) = rest.split_at_mut(Scalars::COUNT);
        scalars.copy_from_slice(given.scalars);
        let half = Scalars::of(given.scalars).half;
        let activation = structure.last().copied().unwrap_or(0.0);
        let [plays, elements, units] =
            [counts.plays, counts.elements, counts.units].map(|count| count as f64);
        let stop_scale = GROUPS as f64 / (plays * half);
        tail.copy_from_slice(&[stop_scale, activation, plays, elements, units]);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some(parts), &[u], [y]) = (read(coefficients), inputs, outputs) else { return };
        *y = parts.rest(u, state, &mut [0.0; INPUTS]);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some(parts), &[u], [y]) = (read(coefficients), inputs, outputs) else { return };
        *y = parts.step(u, state, &mut [0.0; INPUTS]);
    }
}

impl Forward for LearnedPlays {
    fn frozen(&self, coefficients: &[f64], state: &[f64], _rates: Rates, u: f64) -> f64 {
        read(coefficients).map_or(0.0, |parts| parts.frozen(u, state))
    }

    fn mean_slope(&self, coefficients: &[f64], [low, high]: [f64; 2]) -> f64 {
        let Some(parts) = read(coefficients) else { return 1.0 };
        let moved = |r: &f64| (high - low - 2.0 * r).max(0.0) / (high - low);
        let plays = parts.r.as_flattened().iter().zip(parts.w.as_flattened());
        plays.map(|(r, w)| w * moved(r)).sum()
    }

    fn check(
        &self,
        structure: &[f64],
        parameters: &[f64],
        limits: [f64; 2],
    ) -> Result<(), Violation> {
        let given = Counts::of(structure).and_then(|counts| split(parameters, counts));
        let given = given.ok_or_else(|| violation("r", 0.0, WRONG_LENGTH))?;
        let scalars = Scalars::of(given.scalars);
        let (r, w) = (given.r[0], given.w[0]);
        if r != 0.0 {
            let rule = "a model whose first threshold is above 0 has no inverse; give r[1] = 0";
            return Err(violation("r", r, rule));
        }
        if w <= 0.0 {
            let rule =
                "a model whose first weight is 0 has no inverse; identify it with w[1] above 0";
            return Err(violation("w", w, rule));
        }
        // Beyond them the position no longer rises.
        for (quantity, limit) in [("command_min", limits[0]), ("command_max", limits[1])] {
            if (limit - scalars.centre).abs() > scalars.beyond * scalars.half {
                let rule = "lies beyond the commands that the model knows; give a narrower range";
                return Err(violation(quantity, limit, rule));
            }
        }
        Ok(())
    }
}

/// What the network sees of a signal, and the position without it: the same code as in real time.
///
/// # Errors
/// The rule that the parameters break.
#[cfg(feature = "train")]
pub fn inputs_of(
    structure: &[f64],
    parameters: &[f64],
    signal: &[f64],
    period: f64,
) -> Result<Vec<([f64; INPUTS], f64)>, Violation> {
    let Sizes { coefficients, states } = LearnedPlays.sizes(structure, period);
    let (mut coefficients, mut state) = (vec![0.0; coefficients], vec![0.0; states]);
    LearnedPlays.prepare(structure, parameters, period, &mut coefficients)?;
    let wrong = || violation("r", 0.0, WRONG_LENGTH);
    let parts = read(&coefficients).ok_or_else(wrong)?;
    let mut all = Vec::with_capacity(signal.len());
    for (k, u) in signal.iter().enumerate() {
        let mut x = [0.0; INPUTS];
        let y = if k == 0 {
            parts.rest(*u, &mut state, &mut x)
        } else {
            parts.step(*u, &mut state, &mut x)
        };
        all.push((x, y));
    }
    Ok(all)
}
