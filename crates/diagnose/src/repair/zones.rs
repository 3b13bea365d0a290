//! A bent characteristic right behind the actuator, as plays followed by one-sided dead zones.

use data::ComponentBlueprint;
use model::Extension;

use super::{Plays, extended, gain_in_front, number, take_place};
use crate::candidate::Candidate;
use crate::formula::{Piece, Slot};
use crate::outcome::Outcome;
use crate::thresholds::repair::Thresholds;

/// The actuator with the map of a block behind it; none where the block is no static map there.
pub(super) fn bent(
    o: &Outcome,
    last: &Candidate,
    piece: &Piece,
    p: &[f64],
    old: &ComponentBlueprint,
) -> Option<ComponentBlueprint> {
    if piece.slot != Slot::AfterActuator {
        return None;
    }
    let kernel = piece.block.effect()?.prepare(p, o.task.data.step).ok()?;
    kernel.map(0.0)?;
    let mut plays = Plays::of(old)?;
    let y = o.task.factor;
    let offset = old.get("offset").and_then(number).unwrap_or(0.0);
    // The gain of the output is in the plays already; the map lies before it.
    let gain = gain_in_front(&o.task.base, (&last.chain, &last.fit.theta));
    let map = |s: f64| gain * kernel.map((offset + s) * y / gain).unwrap_or(f64::NAN) / y;
    let slope: f64 = plays.pairs.iter().map(|(_, w)| w).sum();
    let span = o.task.data.command_span;
    let end = |side: f64| {
        let end = slope * (span.centre + side * (1.0 + Thresholds::ZONES_BEYOND) * span.half)
            / o.task.command_factor;
        if end * side > 0.0 { end } else { side * 0.02 * slope * span.half / o.task.command_factor }
    };
    let zones = Zones::of(&map, end(-1.0), end(1.0))?;
    plays.pairs.iter_mut().for_each(|(_, w)| *w *= zones.slope);
    let mut component = plays
        .written(extended(old, Extension::Bend)?)?
        .value("edge", zones.edges)
        .value("slope", zones.changes);
    take_place(&mut component, old);
    Some(component.value("offset", zones.offset))
}

/// A map in straight pieces: `offset + S(slope·s)`, S the identity about zero.
struct Zones {
    offset: f64,
    slope: f64,
    /// Where the slope changes, over the map's own argument times `slope`.
    edges: Vec<f64>,
    /// By how much, over `slope`.
    changes: Vec<f64>,
}

impl Zones {
    /// Of a map between an end below zero and one above.
    fn of(map: &dyn Fn(f64) -> f64, low: f64, high: f64) -> Option<Self> {
        let side = |end: f64| -> Vec<f64> {
            (1..=Thresholds::ZONES).map(|k| end * k as f64 / Thresholds::ZONES as f64).collect()
        };
        let (below, above) = (side(low), side(high));
        let (near, far) = (*below.first()?, *above.first()?);
        let slope = (map(far) - map(near)) / (far - near);
        if !(slope.is_finite() && slope > 0.0) {
            return None;
        }
        // The middle piece goes through both its ends; at zero it has its own value.
        let offset = map(near) - slope * near;
        let changes = |knots: &[f64]| -> Vec<(f64, f64)> {
            let mut before = slope;
            let pairs = knots.windows(2).map(|pair| {
                let own = (map(pair[1]) - map(pair[0])) / (pair[1] - pair[0]);
                let change = own - before;
                before = own;
                (slope * pair[0], change / slope)
            });
            pairs.filter(|(_, change)| change.abs() > Thresholds::ZONES_SLOPE).collect()
        };
        let mut all = changes(&below);
        all.reverse();
        all.extend(changes(&above));
        let (edges, changes): (Vec<f64>, Vec<f64>) = all.into_iter().unzip();
        (!edges.is_empty()).then_some(Self { offset, slope, edges, changes })
    }
}

#[cfg(test)]
mod tests {
    use components::hysteresis::dead_zone::DeadZones;

    use super::*;

    #[test]
    fn straight_pieces_follow_a_bent_map_on_both_sides_of_zero() {
        let map = |s: f64| 0.3 + 4.0 * (0.2 * s - 0.1).tanh();
        let zones = Zones::of(&map, -3.0, 8.0).unwrap();
        let pieces = DeadZones { edges: &zones.edges, slopes: &zones.changes };
        pieces.check().unwrap();
        for k in 0..=110 {
            let s = -3.0 + 0.1 * f64::from(k);
            let own = zones.offset + pieces.map(zones.slope * s);
            assert!((own - map(s)).abs() < 5e-3, "{s}: {own} {}", map(s));
        }
    }

    #[test]
    fn a_map_that_falls_has_no_zones() {
        assert!(Zones::of(&|s: f64| -s, -1.0, 1.0).is_none());
    }
}
