//! The arithmetic of `learned-plays`: its parameters in the order in which they are given and in groups of four, and
//! what plays, creeps and network make of a command.

use components::hysteresis::play::{Drive, Threshold, between, play};

/// Inputs of a unit: command, position, four groups of stops, three creeps.
pub const INPUTS: usize = 2 + GROUPS + CREEPS;
/// Groups of neighbouring stops.
pub(super) const GROUPS: usize = 4;
/// Most creeps.
pub(super) const CREEPS: usize = 3;
/// Plays, and units, that are stepped at once.
pub(super) const LANES: usize = 4;
/// Numbers of one unit: weights, bias, height.
pub(super) const EACH: usize = INPUTS + 2;
/// Input at which [`unit`] reaches 1.
const FULL: f64 = 15.0 / 8.0;

type Lanes = [f64; LANES];

/// What a unit gives of the sum of its inputs: σ.
#[inline]
#[must_use]
pub fn unit(inside: f64) -> f64 {
    let c = between(-1.0, 1.0, inside * (1.0 / FULL));
    let square = c * c;
    c * (1.875 + square * (0.375 * square - 1.25))
}

/// Derivative of [`unit()`].
#[cfg(feature = "train")]
#[must_use]
pub fn unit_slope(inside: f64) -> f64 {
    let c = between(-1.0, 1.0, inside * (1.0 / FULL));
    (1.0 - c * c) * (1.0 - c * c)
}

/// Numbers that are neither of plays nor creeps nor units.
#[derive(Clone, Copy)]
pub(super) struct Scalars {
    pub(super) offset: f64,
    pub(super) bend: f64,
    pub(super) centre: f64,
    pub(super) half: f64,
    pub(super) quadratic: f64,
    pub(super) cubic: f64,
    pub(super) position_centre: f64,
    pub(super) position_half: f64,
    pub(super) beyond: f64,
}

impl Scalars {
    pub(super) const COUNT: usize = 9;

    pub(super) fn of(scalars: &[f64; Self::COUNT]) -> Self {
        let [offset, bend, centre, half, quadratic, cubic, position_centre, position_half, beyond] =
            *scalars;
        Self {
            offset,
            bend,
            centre,
            half,
            quadratic,
            cubic,
            position_centre,
            position_half,
            beyond,
        }
    }
}

/// Plays, creeps and units.
#[derive(Clone, Copy)]
pub(super) struct Counts {
    pub(super) plays: usize,
    pub(super) elements: usize,
    pub(super) units: usize,
}

impl Counts {
    pub(super) fn of(structure: &[f64]) -> Option<Self> {
        let &[plays, elements, units, weights, _] = structure else { return None };
        let [plays, elements, units] = [plays, elements, units].map(|count| count as usize);
        (weights as usize == units * INPUTS).then_some(Self { plays, elements, units })
    }

    /// First play that is not in this group.
    pub(super) fn end(self, group: usize) -> usize {
        ((group + 1) * self.plays).div_ceil(GROUPS)
    }

    /// Plays of each group, four at a time, the last four filled up: their first and the one after.
    #[inline]
    pub(super) fn groups(self) -> [[usize; 2]; GROUPS] {
        let (mut all, mut from, mut first) = ([[0; 2]; GROUPS], 0, 0);
        for (group, bounds) in all.iter_mut().enumerate() {
            let end = self.end(group);
            let next = first + (end - from).div_ceil(LANES);
            *bounds = [first, next];
            (from, first) = (end, next);
        }
        all
    }

    /// All plays, with those that fill up groups.
    pub(super) fn filled(self) -> usize {
        self.groups()[GROUPS - 1][1] * LANES
    }

    pub(super) fn states(self) -> usize {
        self.filled() + self.elements
    }

    pub(super) fn coefficients(self) -> usize {
        let network = self.units.div_ceil(LANES) * EACH * LANES;
        2 * self.filled() + 2 * self.elements + network + Scalars::COUNT + TAIL
    }
}

/// Coefficients after the scalars: scale of the stops, activation, counts.
pub(super) const TAIL: usize = 5;

/// Parameters as they are given.
pub(super) struct Given<'a> {
    pub(super) r: &'a [f64],
    pub(super) w: &'a [f64],
    pub(super) share: &'a [f64],
    pub(super) time_constant: &'a [f64],
    pub(super) height: &'a [f64],
    pub(super) bias: &'a [f64],
    pub(super) weight: &'a [f64],
    pub(super) scalars: &'a [f64; Scalars::COUNT],
}

/// Of `r | w | share | time_constant | height | bias | weight | scalars`.
pub(super) fn split(values: &[f64], counts: Counts) -> Option<Given<'_>> {
    let (r, rest) = values.split_at_checked(counts.plays)?;
    let (w, rest) = rest.split_at_checked(counts.plays)?;
    let (share, rest) = rest.split_at_checked(counts.elements)?;
    let (time_constant, rest) = rest.split_at_checked(counts.elements)?;
    let (height, rest) = rest.split_at_checked(counts.units)?;
    let (bias, rest) = rest.split_at_checked(counts.units)?;
    let (weight, scalars) = rest.split_at_checked(counts.units * INPUTS)?;
    let scalars = scalars.try_into().ok()?;
    Some(Given { r, w, share, time_constant, height, bias, weight, scalars })
}

/// Coefficients: thresholds and weights of each group filled up by plays of threshold and weight 0, which add nothing and
/// whose stop is 0; units in blocks of four, [`INPUTS`] rows of weights, biases, heights.
pub(super) struct Parts<'a> {
    pub(super) r: &'a [Lanes],
    pub(super) w: &'a [Lanes],
    network: &'a [[Lanes; EACH]],
    pub(super) share: &'a [f64],
    fraction: &'a [f64],
    pub(super) scalars: Scalars,
    /// From the sum of a group's stops to its input of the network.
    stop_scale: f64,
    is_tanh: bool,
    groups: [[usize; 2]; GROUPS],
}

#[inline]
pub(super) fn read(coefficients: &[f64]) -> Option<Parts<'_>> {
    let (rest, &[stop_scale, activation, plays, elements, units]) =
        coefficients.split_last_chunk::<TAIL>()?;
    let [plays, elements, units] = [plays, elements, units].map(|count| count as usize);
    let counts = Counts { plays, elements, units };
    let (rest, scalars) = rest.split_last_chunk::<{ Scalars::COUNT }>()?;
    let filled = counts.filled();
    let (r, rest) = rest.split_at_checked(filled)?;
    let (w, rest) = rest.split_at_checked(filled)?;
    let (share, rest) = rest.split_at_checked(elements)?;
    let (fraction, network) = rest.split_at_checked(elements)?;
    Some(Parts {
        r: r.as_chunks().0,
        w: w.as_chunks().0,
        network: network.as_chunks().0.as_chunks().0,
        share,
        fraction,
        scalars: Scalars::of(scalars),
        stop_scale,
        is_tanh: activation < 0.5,
        groups: counts.groups(),
    })
}

/// Their sum, always in this order: that of two vectors of two.
#[inline]
fn total([a, b, c, d]: Lanes) -> f64 {
    (a + c) + (b + d)
}

impl Parts<'_> {
    /// The command within its limits, over half its range.
    #[inline]
    fn place(&self, u: f64) -> f64 {
        let limit = self.scalars.beyond;
        ((u - self.scalars.centre) / self.scalars.half).clamp(-limit, limit)
    }

    /// What the plays see.
    #[inline]
    fn bent(&self, place: f64) -> f64 {
        self.scalars.centre + self.scalars.half * (place + self.scalars.bend * place * place)
    }

    /// Position, without the network and with it, where four plays and a creep are those that `each` and `crept` give.
    #[inline]
    fn position(
        &self,
        u: f64,
        mut each: impl FnMut(usize, f64, &Lanes) -> Lanes,
        mut crept: impl FnMut(usize, f64) -> f64,
        x: &mut [f64; INPUTS],
    ) -> f64 {
        *x = [0.0; INPUTS];
        x[0] = self.place(u);
        let b = self.bent(x[0]);
        let mut h = [0.0; LANES];
        for (x, [first, end]) in x[2..].iter_mut().zip(self.groups) {
            let mut stops = [0.0; LANES];
            let (Some(r), Some(w)) = (self.r.get(first..end), self.w.get(first..end)) else {
                continue;
            };
            for (i, (r, w)) in r.iter().zip(w).enumerate() {
                let p = each(first + i, b, r);
                for k in 0..LANES {
                    h[k] += w[k] * p[k];
                    stops[k] += b - p[k];
                }
            }
            *x = total(stops) * self.stop_scale;
        }
        let h = self.scalars.offset + total(h);
        let mut v = h;
        for (j, share) in self.share.iter().enumerate() {
            let z = crept(j, h);
            v += share * z;
            x[2 + GROUPS + j] = (h - z) / self.scalars.position_half;
        }
        let eta = (v - self.scalars.position_centre) / self.scalars.position_half;
        x[1] = eta;
        let curve = (self.scalars.quadratic + self.scalars.cubic * eta) * eta * eta;
        let added = if self.is_tanh { self.added(x, libm::tanh) } else { self.added(x, unit) };
        v + self.scalars.position_half * (curve + added)
    }

    /// What the network adds.
    #[inline]
    fn added(&self, x: &[f64; INPUTS], activation: impl Fn(f64) -> f64) -> f64 {
        let mut sum = [0.0; LANES];
        for [weights @ .., bias, height] in self.network {
            let mut inside = *bias;
            for (weight, x) in weights.iter().zip(x) {
                for k in 0..LANES {
                    inside[k] += weight[k] * x;
                }
            }
            for k in 0..LANES {
                sum[k] += height[k] * activation(inside[k]);
            }
        }
        total(sum)
    }

    /// Plays, four at a time, and creeps.
    #[inline]
    fn of<'s>(&self, state: &'s mut [f64]) -> Option<(&'s mut [Lanes], &'s mut [f64])> {
        let (plays, creeps) = state.split_at_mut_checked(self.r.len() * LANES)?;
        Some((plays.as_chunks_mut().0, creeps))
    }

    pub(super) fn rest(&self, u: f64, state: &mut [f64], x: &mut [f64; INPUTS]) -> f64 {
        let Some((plays, creeps)) = self.of(state) else { return 0.0 };
        let moved = |i: usize, b: f64, r: &Lanes| {
            plays[i] = r.map(|r| play(Drive(b), Threshold(r), 0.0));
            plays[i]
        };
        let crept = |j: usize, h: f64| {
            creeps[j] = h;
            h
        };
        self.position(u, moved, crept, x)
    }

    #[inline]
    pub(super) fn step(&self, u: f64, state: &mut [f64], x: &mut [f64; INPUTS]) -> f64 {
        let Some((plays, creeps)) = self.of(state) else { return 0.0 };
        let moved = |i: usize, b: f64, r: &Lanes| {
            plays[i] = after(b, r, &plays[i]);
            plays[i]
        };
        let crept = |j: usize, h: f64| {
            creeps[j] += self.fraction[j] * (h - creeps[j]);
            creeps[j]
        };
        self.position(u, moved, crept, x)
    }

    pub(super) fn frozen(&self, u: f64, state: &[f64]) -> f64 {
        let Some((plays, creeps)) = state.split_at_checked(self.r.len() * LANES) else {
            return 0.0;
        };
        let plays = plays.as_chunks().0;
        let moved = |i: usize, b: f64, r: &Lanes| after(b, r, &plays[i]);
        let crept = |j: usize, h: f64| creeps[j] + self.fraction[j] * (h - creeps[j]);
        self.position(u, moved, crept, &mut [0.0; INPUTS])
    }
}

/// Plays of these thresholds after their input went to `b`.
#[inline]
fn after(b: f64, r: &Lanes, plays: &Lanes) -> Lanes {
    let mut moved = *plays;
    for k in 0..LANES {
        moved[k] = play(Drive(b), Threshold(r[k]), plays[k]);
    }
    moved
}
