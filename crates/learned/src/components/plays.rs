//! Plays between two curves with creep, and what a small network adds.
//!
//! ```text
//! b = u + half_range·bend·ξ²,                     ξ = (u − centre)/half_range, held within ±1.5
//! h = offset + Σ w_i P_i,                         P_i ← max(b − r_i, min(b + r_i, P_i))
//! v = h + Σ share_j z_j,                          ż_j = (h − z_j)/time_constant_j
//! y = v + position_half_range·(quadratic·η² + cubic·η³ + Σ height_n tanh(bias_n + Σ weight_nm x_m))
//! x = ξ; η = (v − position_centre)/position_half_range; the mean stop b − P_i of each quarter of the plays over
//!     half_range, times its part of all plays; (h − z_j)/position_half_range
//! ```
//!
//! * r, w, offset as in `prandtl-ishlinskii`; share, time_constant (s) as in `kelvin-voigt-creep`, at most three; bend,
//!   quadratic, cubic without unit, as parts of half a range.
//! * height_n: most that a unit of the network adds, as a part of position_half_range; weight: nine of each unit, one unit
//!   after the other.
//! * State: one number per play and per creep.
//!
//! Bounded: beyond 1.5 half ranges the command counts as its limit, and the network adds at most
//! Σ |height_n|·position_half_range, whatever its weights. Limits: of what no record showed the network knows nothing but
//! that bound.
//!
//! Sources: K. Kuhnen, European Journal of Control 9 (2003) 407–418 (plays between curves); M. Brokate, J. Sprekels,
//! Hysteresis and Phase Transitions, Springer 1996, ch. 2 (the states of plays are all that a Preisach memory knows).

use components::hysteresis::numeric_inverse::{Forward, NumericInverse, Rates};
use components::hysteresis::play::play;
use model::{
    Component, Conversion, Declaration, Input, Inverse, Output, Quantity, Role, Sizes, Stage,
    Structural, Tick, Violation,
};

/// Inputs of a unit: command, position, four groups of stops, three creeps.
pub const INPUTS: usize = 2 + GROUPS + CREEPS;
/// Groups of neighbouring stops.
const GROUPS: usize = 4;
/// Most creeps.
const CREEPS: usize = 3;
/// Half ranges beyond which the command counts as its limit.
const REACH: f64 = 1.5;

/// The component `learned-plays`.
pub struct LearnedPlays;

/// The component `inverse-learned-plays`.
pub(super) static INVERSE: NumericInverse<LearnedPlays> =
    NumericInverse::new(&LearnedPlays, &INVERSE_DECLARATION);

const STRUCTURE: &[Structural] = &[
    Structural::count("plays", "Number of play operators", 1, 4096),
    Structural::count("elements", "Number of creeps", 0, CREEPS),
    Structural::count("units", "Number of units of the network", 0, 100),
    Structural::count(
        "weights",
        "Number of weights of the network, nine per unit",
        0,
        100 * INPUTS,
    ),
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
    number("share", "1", "Creep of each element over the elongation").min(0.0).per(1).fitted(),
    number("time_constant", "s", "Time constant of each element").min(1e-9).per(1).fitted(),
    number("height", "1", "Most that a unit adds, over half the position's range").per(2),
    number("bias", "1", "What a unit sees of nothing").per(2),
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
    summary: "Plays between two curves with creep, and a small network over what they remember",
    equation: "v = offset + sum(w[i]*P[i]) + creep; y = v + position_half_range*(quadratic*eta^2 + \
               cubic*eta^3 + sum(height[n]*tanh(bias[n] + sum(weight[n,m]*x[m])))); x = command, \
               position, stops, creeps, scaled",
    reference: "K. Kuhnen, European Journal of Control 9 (2003) 407-418",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&components::effects::ASYMMETRY),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: STRUCTURE,
    parameters: &PARAMETERS,
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
    effect: None,
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: STRUCTURE,
    parameters: &INVERSE_PARAMETERS,
};

/// Parameters, or coefficients with fractions in the place of time constants.
struct Parts<'a> {
    r: &'a [f64],
    w: &'a [f64],
    share: &'a [f64],
    fraction: &'a [f64],
    height: &'a [f64],
    bias: &'a [f64],
    weight: &'a [f64],
    offset: f64,
    bend: f64,
    centre: f64,
    half: f64,
    quadratic: f64,
    cubic: f64,
    position_centre: f64,
    position_half: f64,
    beyond: f64,
}

/// Of `r | w | share | time_constant | height | bias | weight | scalars`, with these counts.
fn split(values: &[f64], [plays, elements, units]: [usize; 3]) -> Option<Parts<'_>> {
    let (r, rest) = values.split_at_checked(plays)?;
    let (w, rest) = rest.split_at_checked(plays)?;
    let (share, rest) = rest.split_at_checked(elements)?;
    let (fraction, rest) = rest.split_at_checked(elements)?;
    let (height, rest) = rest.split_at_checked(units)?;
    let (bias, rest) = rest.split_at_checked(units)?;
    let (weight, scalars) = rest.split_at_checked(units * INPUTS)?;
    let &[offset, bend, centre, half, quadratic, cubic, position_centre, position_half, beyond] =
        scalars
    else {
        return None;
    };
    Some(Parts {
        r,
        w,
        share,
        fraction,
        height,
        bias,
        weight,
        offset,
        bend,
        centre,
        half,
        quadratic,
        cubic,
        position_centre,
        position_half,
        beyond,
    })
}

/// The same of coefficients, which end with the counts.
#[inline]
fn read(coefficients: &[f64]) -> Option<Parts<'_>> {
    let (values, counts) = coefficients.split_last_chunk::<3>()?;
    split(values, counts.map(|count| count as usize))
}

fn counts(structure: &[f64]) -> Option<[usize; 3]> {
    let &[plays, elements, units, weights] = structure else { return None };
    let counts = [plays, elements, units].map(|count| count as usize);
    (weights as usize == counts[2] * INPUTS).then_some(counts)
}

impl Parts<'_> {
    /// The command within its limits, over half its range.
    #[inline]
    fn place(&self, u: f64) -> f64 {
        ((u - self.centre) / self.half).clamp(-self.beyond, self.beyond)
    }

    /// What the plays see.
    #[inline]
    fn bent(&self, place: f64) -> f64 {
        self.centre + self.half * (place + self.bend * place * place)
    }

    /// Position, without the network and with it, where the plays and creeps are those that `each` and `crept` give.
    #[inline]
    fn position(
        &self,
        u: f64,
        mut each: impl FnMut(usize, f64) -> f64,
        mut crept: impl FnMut(usize, f64) -> f64,
        x: &mut [f64; INPUTS],
    ) -> f64 {
        *x = [0.0; INPUTS];
        x[0] = self.place(u);
        let b = self.bent(x[0]);
        let mut h = self.offset;
        let count = self.r.len();
        let mut first = 0;
        for group in 0..GROUPS {
            let end = ((group + 1) * count).div_ceil(GROUPS);
            let mut stops = 0.0;
            for i in first..end {
                let p = each(i, b);
                h += self.w[i] * p;
                stops += b - p;
            }
            x[2 + group] = stops * (GROUPS as f64 / (count as f64 * self.half));
            first = end;
        }
        let mut v = h;
        for (j, share) in self.share.iter().enumerate() {
            let z = crept(j, h);
            v += share * z;
            x[2 + GROUPS + j] = (h - z) / self.position_half;
        }
        let eta = (v - self.position_centre) / self.position_half;
        x[1] = eta;
        let curve = (self.quadratic + self.cubic * eta) * eta * eta;
        let mut sum = 0.0;
        let units = self.height.iter().zip(self.bias).zip(self.weight.as_chunks::<INPUTS>().0);
        for ((height, bias), weight) in units {
            let inside = weight.iter().zip(&*x).fold(*bias, |sum, (a, x)| sum + a * x);
            sum += height * libm::tanh(inside);
        }
        v + self.position_half * (curve + sum)
    }

    fn rest(&self, u: f64, state: &mut [f64], x: &mut [f64; INPUTS]) -> f64 {
        let Some((plays, creeps)) = state.split_at_mut_checked(self.r.len()) else { return 0.0 };
        let moved = |i: usize, b: f64| {
            plays[i] = play(b, self.r[i], 0.0);
            plays[i]
        };
        let crept = |j: usize, h: f64| {
            creeps[j] = h;
            h
        };
        self.position(u, moved, crept, x)
    }

    #[inline]
    fn step(&self, u: f64, state: &mut [f64], x: &mut [f64; INPUTS]) -> f64 {
        let Some((plays, creeps)) = state.split_at_mut_checked(self.r.len()) else { return 0.0 };
        let moved = |i: usize, b: f64| {
            plays[i] = play(b, self.r[i], plays[i]);
            plays[i]
        };
        let crept = |j: usize, h: f64| {
            creeps[j] += self.fraction[j] * (h - creeps[j]);
            creeps[j]
        };
        self.position(u, moved, crept, x)
    }

    fn frozen(&self, u: f64, state: &[f64]) -> f64 {
        let Some((plays, creeps)) = state.split_at_checked(self.r.len()) else { return 0.0 };
        let moved = |i: usize, b: f64| play(b, self.r[i], plays[i]);
        let crept = |j: usize, h: f64| creeps[j] + self.fraction[j] * (h - creeps[j]);
        self.position(u, moved, crept, &mut [0.0; INPUTS])
    }
}

fn violation(quantity: &'static str, value: f64, rule: &'static str) -> Violation {
    Violation { quantity, index: None, value, rule }
}

const WRONG_LENGTH: &str = "this component was given a wrong number of values";

fn check(parts: &Parts<'_>) -> Result<(), Violation> {
    let rule = "thresholds start at 0 or above and are strictly increasing; sort them";
    for (index, pair) in parts.r.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            let (quantity, index) = ("r", Some(index + 1));
            return Err(Violation { quantity, index, value: pair[1], rule });
        }
    }
    let sum: f64 = parts.w.iter().sum();
    if sum <= 0.0 {
        return Err(violation("w", sum, "the sum of the weights is zero: nothing would move"));
    }
    for (quantity, half) in
        [("half_range", parts.half), ("position_half_range", parts.position_half)]
    {
        if half <= 0.0 {
            return Err(violation(quantity, half, "must be above zero"));
        }
    }
    // The command's curve must not turn back within its limits.
    if 2.0 * parts.bend.abs() * parts.beyond >= 1.0 {
        let rule = "the command's curve turns back within `beyond` half ranges; bend it less";
        return Err(violation("bend", parts.bend, rule));
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
        let length = |index| DECLARATION.length(index, structure);
        let states = length(0) + length(2);
        Sizes { coefficients: DECLARATION.parameter_count(structure) + 3, states }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let counts = counts(structure).ok_or_else(|| {
            let rule = "must be nine per unit: command, position, four stops, three creeps";
            violation("weight", structure.last().copied().unwrap_or(0.0), rule)
        })?;
        let wrong = || violation("r", parameters.len() as f64, WRONG_LENGTH);
        check(&split(parameters, counts).ok_or_else(wrong)?)?;
        let (values, tail) = coefficients.split_last_chunk_mut::<3>().ok_or_else(wrong)?;
        if values.len() != parameters.len() {
            return Err(wrong());
        }
        values.copy_from_slice(parameters);
        *tail = counts.map(|count| count as f64);
        let [plays, elements, _] = counts;
        for fraction in values.iter_mut().skip(2 * plays + elements).take(elements) {
            *fraction = -libm::expm1(-period / *fraction);
        }
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
        parts.r.iter().zip(parts.w).map(|(r, w)| w * moved(r)).sum()
    }

    fn check(
        &self,
        structure: &[f64],
        parameters: &[f64],
        limits: [f64; 2],
    ) -> Result<(), Violation> {
        let parts = counts(structure).and_then(|counts| split(parameters, counts));
        let parts = parts.ok_or_else(|| violation("r", 0.0, WRONG_LENGTH))?;
        let (r, w) = (parts.r[0], parts.w[0]);
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
            if (limit - parts.centre).abs() > parts.beyond * parts.half {
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
