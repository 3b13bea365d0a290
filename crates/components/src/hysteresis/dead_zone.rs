//! One-sided dead zones: a memoryless, piecewise linear map and its inverse.
//!
//! `S(x) = x + Σ slope_j · z_j(x)`, `z_j(x) = max(x − edge_j, 0)` for edge_j > 0 and
//! `min(x − edge_j, 0)` for edge_j < 0. It changes its slope at each edge, on the side away from
//! zero, and is the identity between the innermost edges.
//!
//! Source: K. Kuhnen, European Journal of Control 9 (2003) 407–418.

use model::Violation;

use crate::rules::{WRONG_LENGTH, require_at};

/// Edges in increasing order, and the change of slope at each.
#[derive(Clone, Copy, Debug)]
pub struct DeadZones<'a> {
    /// Edges, increasing, none 0.
    pub edges: &'a [f64],
    /// Change of slope beyond each edge.
    pub slopes: &'a [f64],
}

impl DeadZones<'_> {
    /// The map.
    #[inline]
    #[must_use]
    pub fn map(&self, x: f64) -> f64 {
        let mut y = x;
        for (edge, slope) in self.edges.iter().zip(self.slopes) {
            let beyond = x - edge;
            let active = if *edge > 0.0 { beyond > 0.0 } else { beyond < 0.0 };
            if active {
                y += slope * beyond;
            }
        }
        y
    }

    /// Checks that the map is strictly increasing, so that it has an inverse.
    ///
    /// # Errors
    /// The first [`Violation`], of `edge` or `slope`.
    pub fn check(&self) -> Result<(), Violation> {
        if self.edges.len() != self.slopes.len() {
            return Err(WRONG_LENGTH);
        }
        let mut last = f64::NEG_INFINITY;
        for (i, &edge) in self.edges.iter().enumerate() {
            let rule = "edges are strictly increasing and none is 0; sort them";
            require_at(edge > last && edge != 0.0, "edge", i, edge, rule)?;
            last = edge;
        }
        let rule = "the slopes from the middle outwards add up to less than nothing: the position \
                    would fall with rising command; raise this one";
        for (i, total) in self.outwards() {
            let slope = self.slopes.get(i).copied().unwrap_or(0.0);
            require_at(total > 0.0, "slope", i, slope, rule)?;
        }
        Ok(())
    }

    /// Index of each zone, from the middle outwards on both sides, with the slope beyond its edge.
    fn outwards(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let side = |positive: bool| {
            let n = self.edges.len();
            let mut total = 1.0;
            (0..n).map(move |i| if positive { i } else { n - 1 - i }).filter_map(move |i| {
                let here = self.edges.get(i).is_some_and(|e| (*e > 0.0) == positive);
                here.then(|| {
                    total += self.slopes.get(i).copied().unwrap_or(0.0);
                    (i, total)
                })
            })
        };
        side(true).chain(side(false))
    }

    /// Edges and slopes of the inverse map: the edges are the images of the edges, and each slope
    /// changes from the reciprocal of the old slope to that of the new one.
    pub fn invert(&self, edges: &mut [f64], slopes: &mut [f64]) {
        for (image, edge) in edges.iter_mut().zip(self.edges) {
            *image = self.map(*edge);
        }
        for (i, total) in self.outwards() {
            if let (Some(inverse), Some(change)) = (slopes.get_mut(i), self.slopes.get(i)) {
                *inverse = 1.0 / total - 1.0 / (total - change);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn the_map_changes_its_slope_beyond_each_edge() {
        let zones = DeadZones { edges: &[-2.0, -1.0, 0.5, 2.0], slopes: &[0.5, -0.25, -0.5, 2.0] };
        let map = |x| zones.map(x);
        assert_eq!([map(-1.0), map(-0.5), map(0.0), map(0.5)], [-1.0, -0.5, 0.0, 0.5]);
        // Slopes 0.5 and 2.5 on the right, 0.75 and 1.25 on the left.
        assert_eq!([map(1.5), map(2.0), map(3.0)], [1.0, 1.25, 3.75]);
        assert_eq!([map(-1.5), map(-2.0), map(-3.0)], [-1.375, -1.75, -3.0]);
    }

    #[test]
    fn the_inverse_undoes_the_map() {
        let zones = DeadZones { edges: &[-3.0, -1.0, 0.5, 2.0], slopes: &[0.5, -0.2, -0.3, -0.4] };
        zones.check().unwrap();
        let (mut edges, mut slopes) = ([0.0; 4], [0.0; 4]);
        zones.invert(&mut edges, &mut slopes);
        let inverse = DeadZones { edges: &edges, slopes: &slopes };
        for x in Random::new(1).signal(-6.0, 6.0, 2000) {
            assert!((inverse.map(zones.map(x)) - x).abs() < 1e-13);
            assert!((zones.map(inverse.map(x)) - x).abs() < 1e-13);
        }
    }

    #[test]
    fn maps_that_fold_back_are_refused() {
        let check = |edges: &[f64], slopes: &[f64]| {
            DeadZones { edges, slopes }.check().err().map(|v| (v.quantity, v.index))
        };
        assert_eq!(check(&[1.0, 2.0], &[-0.6, -0.4]), Some(("slope", Some(1))));
        assert_eq!(check(&[-2.0, -1.0], &[-0.6, -0.4]), Some(("slope", Some(0))));
        assert_eq!(check(&[-1.0, 1.0], &[-0.9, -0.9]), None);
        assert_eq!(check(&[0.0], &[0.1]), Some(("edge", Some(0))));
        assert_eq!(check(&[1.0, 1.0], &[0.1, 0.1]), Some(("edge", Some(1))));
    }
}
