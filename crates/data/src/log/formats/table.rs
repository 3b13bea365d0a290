//! Values between the keys of a table.

/// The value at x on the straight lines between pairs (key, value) whose keys grow; outside of them that of the
/// nearest end. There is at least one pair.
pub(super) fn between(pairs: &[[f64; 2]], x: f64) -> f64 {
    let above = pairs.partition_point(|pair| pair[0] < x);
    let Some(right) = pairs.get(above) else { return pairs[pairs.len() - 1][1] };
    let Some(left) = above.checked_sub(1).map(|at| pairs[at]) else { return right[1] };
    left[1] + (x - left[0]) / (right[0] - left[0]) * (right[1] - left[1])
}

/// The value of the nearest key, of the lower one of two.
pub(super) fn nearest(pairs: &[[f64; 2]], x: f64) -> f64 {
    let above = pairs.partition_point(|pair| pair[0] < x);
    let Some(right) = pairs.get(above) else { return pairs[pairs.len() - 1][1] };
    let Some(left) = above.checked_sub(1).map(|at| pairs[at]) else { return right[1] };
    if x - left[0] <= right[0] - x { left[1] } else { right[1] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_between_and_beyond_their_keys() {
        let pairs = [[0.0, 10.0], [1.0, 20.0], [3.0, 0.0]];
        let smooth = [-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 9.0].map(|x| between(&pairs, x));
        assert_eq!(smooth, [10.0, 10.0, 15.0, 20.0, 10.0, 0.0, 0.0]);
        let steps = [-1.0, 0.5, 0.6, 2.0, 2.1].map(|x| nearest(&pairs, x));
        assert_eq!(steps, [10.0, 10.0, 20.0, 20.0, 0.0]);
    }
}
