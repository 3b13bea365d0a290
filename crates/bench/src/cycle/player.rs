//! Plays the plan's rows.

use crate::safety::smooth;

/// A table of references, one row per cycle, with an approach before it.
#[derive(Clone, Debug)]
pub struct Player {
    axes: usize,
    /// Row by row.
    table: Box<[f64]>,
    /// Cycles in which the reference goes from where the machine is to the first row.
    approach: u64,
    /// Cycle since the start.
    cycle: Option<u64>,
    from: Box<[f64]>,
}

impl Player {
    /// Plays `table`, rows of `axes` values, after an approach of so many cycles.
    #[must_use]
    pub fn new(axes: usize, table: Vec<f64>, approach: u32) -> Self {
        let from = vec![0.0; axes].into();
        Player { axes, table: table.into(), approach: approach.into(), cycle: None, from }
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.table.len().checked_div(self.axes).unwrap_or(0) as u64
    }

    /// Cycles from the start to the end: the approach and the rows.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        self.approach + self.rows()
    }

    /// Begins, from these values.
    pub(crate) fn start(&mut self, from: &[f64]) {
        self.from.copy_from_slice(from);
        self.cycle = Some(0);
    }

    /// Goes on by some cycles.
    pub(crate) fn advance(&mut self, cycles: u64) {
        self.cycle = self.cycle.map(|cycle| cycle.saturating_add(cycles));
    }

    /// Back to before the start.
    pub(crate) fn rewind(&mut self) {
        self.cycle = None;
    }

    /// Whether rows of the table are played, not the approach.
    pub(crate) fn plays(&self) -> bool {
        self.row() >= 0.0
    }

    /// Whether the last row has had its cycle.
    pub(crate) fn is_finished(&self) -> bool {
        // The state machine asks before the next cycle's row is read.
        self.cycle.is_some_and(|cycle| cycle + 1 >= self.approach + self.rows())
    }

    /// The row that is played; -1 for none.
    pub(crate) fn row(&self) -> f64 {
        let row = self.cycle.and_then(|cycle| cycle.checked_sub(self.approach));
        row.map_or(-1.0, |row| row.min(self.rows().saturating_sub(1)) as f64)
    }

    /// The values of this cycle.
    pub(crate) fn read(&self, values: &mut [f64]) {
        let cycle = self.cycle.unwrap_or(0);
        let last = self.rows().saturating_sub(1);
        let row = cycle.saturating_sub(self.approach).min(last) as usize;
        let Some(target) = self.table.get(row * self.axes..(row + 1) * self.axes) else {
            values.copy_from_slice(&self.from);
            return;
        };
        if cycle >= self.approach {
            values.copy_from_slice(target);
            return;
        }
        let weight = smooth(cycle as f64 / self.approach as f64);
        for ((value, from), to) in values.iter_mut().zip(&self.from).zip(target) {
            *value = from + weight * (to - from);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_approaches_and_plays_each_row_once() {
        let mut player = Player::new(1, vec![4.0, 5.0, 6.0], 4);
        assert!(!player.is_finished());
        player.start(&[2.0]);
        let mut seen = Vec::new();
        loop {
            let mut value = [0.0];
            player.read(&mut value);
            seen.push((player.row(), value[0]));
            if player.is_finished() {
                break;
            }
            player.advance(1);
        }
        let rows: Vec<f64> = seen.iter().map(|(row, _)| *row).collect();
        assert_eq!(rows, [-1.0, -1.0, -1.0, -1.0, 0.0, 1.0, 2.0]);
        assert_eq!(seen[0].1, 2.0);
        assert_eq!(seen[2].1, 3.0);
        assert_eq!(seen[4..].iter().map(|s| s.1).collect::<Vec<_>>(), [4.0, 5.0, 6.0]);
    }

    #[test]
    fn missed_cycles_skip_rows() {
        let mut player = Player::new(1, (0..10).map(f64::from).collect(), 0);
        player.start(&[0.0]);
        player.advance(4);
        let mut value = [0.0];
        player.read(&mut value);
        assert_eq!(value, [4.0]);
        player.advance(400);
        player.read(&mut value);
        assert_eq!(value, [9.0]);
        assert!(player.is_finished());
    }
}
