//! What acts on the path of a model: an effect of the machine, as it steps in a repaired FMU too, or something of
//! the record alone.
//!
//! A signal is one value per hit of the grid; value 0 is the rest value, value n is held over hit n. Quantities
//! are SI.

use components::hysteresis::play::{Drive, Threshold, play};
use components::linear::lag_fraction;
use surround::{Block, Kernel, Memory, Signals, WrongCount, exactly};

/// A parametric change of a signal on the path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PathBlock {
    /// Of the machine.
    Effect(Block),
    /// Of the record.
    Record(RecordBlock),
}

impl From<Block> for PathBlock {
    fn from(block: Block) -> Self {
        Self::Effect(block)
    }
}

impl From<RecordBlock> for PathBlock {
    fn from(block: RecordBlock) -> Self {
        Self::Record(block)
    }
}

/// What belongs to a record and not to the machine: two clocks, what was before the first row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RecordBlock {
    /// `x(t·(1 − e))` within the record.
    Clock,
    /// Memory at the start of the record: −1 (from below) to 1.
    StartMemory(Memory),
    /// Readings at other instants within the rows of a held command, each in so many steps of the grid: what goes
    /// into them later, or earlier, by a time in s. From row to row the motion is smooth.
    Instant { parts: usize, is_late: bool },
    /// A reading that droops towards zero, as behind a capacitor in series: corner in Hz, part of the
    /// first value that has drooped before the record begins.
    Droop,
}

/// A block with its parameters, for one step of the grid.
pub(crate) enum Prepared<'a> {
    /// An effect of the machine.
    Effect(Kernel),
    /// The clock's offset.
    Clock(f64),
    /// Steps per row, and steps by which the readings are later.
    Instant(usize, f64),
    /// The plays, and the place in the loop at the start.
    StartMemory(&'a Memory, f64),
    /// The part of the way that the droop goes in a step, and the part of the first value that is gone.
    Droop(f64, f64),
}

impl PathBlock {
    /// The effect of the machine.
    pub(crate) fn effect(&self) -> Option<&Block> {
        match self {
            Self::Effect(block) => Some(block),
            Self::Record(_) => None,
        }
    }

    /// With these parameters, for steps of this length in s.
    pub(crate) fn prepare(&self, p: &[f64], step: f64) -> Result<Prepared<'_>, WrongCount> {
        Ok(match self {
            Self::Effect(block) => Prepared::Effect(block.prepare(p, step)?),
            Self::Record(block) => block.prepare(p, step)?,
        })
    }
}

impl RecordBlock {
    fn prepare(&self, p: &[f64], step: f64) -> Result<Prepared<'_>, WrongCount> {
        Ok(match self {
            Self::Clock => exactly(p).map(|[offset]| Prepared::Clock(offset))?,
            Self::Instant { parts, is_late } => exactly(p).map(|[time]| {
                Prepared::Instant(*parts, if *is_late { time / step } else { -time / step })
            })?,
            Self::StartMemory(memory) => {
                exactly(p).map(|[place]| Prepared::StartMemory(memory, place))?
            }
            Self::Droop => exactly(p)
                .map(|[corner, part]| Prepared::Droop(lag_fraction(corner, step), part))?,
        })
    }
}

impl Prepared<'_> {
    /// Writes what the block makes of its signals; all slices have one length.
    pub(crate) fn run(&self, signals: Signals<'_>, out: &mut [f64]) {
        match self {
            Self::Effect(kernel) => kernel.run(signals, out),
            Self::Clock(offset) => clock(*offset, signals.x, out),
            Self::Instant(parts, later) => instant(*parts, *later, signals.x, out),
            Self::StartMemory(memory, place) => start_memory(memory, *place, signals, out),
            Self::Droop(fraction, part) => droop(*fraction, *part, signals.x, out),
        }
    }
}

fn clock(offset: f64, x: &[f64], out: &mut [f64]) {
    for (n, y) in out.iter_mut().enumerate() {
        *y = between(x, n as f64 * (1.0 - offset));
    }
}

/// The signal so many steps later, by Lagrange's polynomial through the values of the row in which that is: over a
/// row the command is held, and where it jumps the motion has a bend, across which no polynomial leads.
fn instant(parts: usize, later: f64, x: &[f64], out: &mut [f64]) {
    for (n, y) in out.iter_mut().enumerate() {
        let place = (n as f64 + later).max(0.0);
        let row = (place / parts as f64) as usize * parts;
        let rest = place - row as f64;
        *y = match x.get(row..=row + parts) {
            Some(own) if rest > 0.0 => {
                let weight = |i: usize| {
                    let others = (0..=parts).filter(|j| *j != i);
                    others.map(|j| (rest - j as f64) / (i as f64 - j as f64)).product::<f64>()
                };
                own.iter().enumerate().map(|(i, value)| weight(i) * value).sum()
            }
            _ => at(x, place),
        };
    }
}

/// A smooth signal at a place between its values, held at its ends: Lagrange's polynomial through the six
/// nearest. A sine of eight rows per period is met within 1e-3, where a straight line loses 8 % of it.
fn between(x: &[f64], place: f64) -> f64 {
    /// Places of the values about the one before.
    const NODES: [f64; 6] = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
    /// Products of a node's distances from the others.
    const PRODUCTS: [f64; 6] = [-120.0, 24.0, -12.0, 12.0, -24.0, 120.0];
    let integer = place.floor();
    let rest = place - integer;
    let k = integer as usize;
    match x.get(k.wrapping_sub(2)..k.saturating_add(4)) {
        Some(near) if rest > 0.0 => {
            let distances = NODES.map(|node| rest - node);
            let weight = |i: usize| {
                let others = (0..6).filter(|j| *j != i).map(|j| distances[j]);
                others.product::<f64>() / PRODUCTS[i]
            };
            near.iter().enumerate().map(|(i, value)| weight(i) * value).sum()
        }
        _ => at(x, place),
    }
}

/// The signal at a place between its values by straight lines, held at its ends.
fn at(x: &[f64], place: f64) -> f64 {
    let (Some(&first), Some(&last)) = (x.first(), x.last()) else { return 0.0 };
    if place.is_nan() || place <= 0.0 {
        return first;
    }
    let integer = place.floor();
    let k = integer as usize;
    match (x.get(k), x.get(k + 1)) {
        (Some(a), Some(b)) => a + (place - integer) * (b - a),
        _ => last,
    }
}

fn start_memory(memory: &Memory, place: f64, signals: Signals<'_>, out: &mut [f64]) {
    out.copy_from_slice(signals.x);
    let Some(&first) = signals.drive.first() else { return };
    for (r, weight) in memory.r.iter().zip(&memory.w) {
        // As the model has it, and as the machine does.
        let mut virgin = play(Drive(first), Threshold(*r), 0.0);
        let mut real = first + place * r;
        for (y, u) in out.iter_mut().zip(signals.drive) {
            virgin = play(Drive(*u), Threshold(*r), virgin);
            real = play(Drive(*u), Threshold(*r), real);
            *y += weight * (real - virgin);
            if virgin == real {
                break;
            }
        }
    }
}

fn droop(fraction: f64, part: f64, x: &[f64], out: &mut [f64]) {
    let Some(&first) = x.first() else { return };
    let mut gone = part * first;
    for (y, x) in out.iter_mut().zip(x) {
        *y = x - gone;
        gone += fraction * (x - gone);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn a_clock_that_is_off_reads_a_smooth_signal_where_it_is() {
        let (step, offset) = (2.5e-4, 7e-5);
        let signal = |t: f64| (TAU * 500.0 * t).sin() + 0.3 * (TAU * 20.0 * t).cos();
        let x: Vec<f64> = (0..20_000).map(|n| signal(f64::from(n) * step)).collect();
        let mut out = vec![0.0; x.len()];
        let clock = PathBlock::from(RecordBlock::Clock);
        clock.prepare(&[offset], step).unwrap().run(Signals::path(&x), &mut out);
        for n in 10..19_990 {
            let expected = signal(f64::from(n) * step * (1.0 - offset));
            let found = out[n as usize];
            assert!((found - expected).abs() < 1.2e-3, "{n}: {found} {expected}");
        }
        clock.prepare(&[0.0], step).unwrap().run(Signals::path(&x), &mut out);
        assert_eq!(out, x);
    }

    #[test]
    fn a_reading_within_a_row_is_exact_for_a_held_command() {
        let (row, w, parts) = (5e-4, TAU * 180.0, 4);
        let step = row / parts as f64;
        // An undamped mode whose rest jumps at each row.
        let command = |row: usize| ((7 * row) % 11) as f64;
        let later = |state: (f64, f64), u: f64, t: f64| {
            let (c, s) = ((w * t).cos(), (w * t).sin());
            (u + (state.0 - u) * c + state.1 / w * s, state.1 * c - (state.0 - u) * w * s)
        };
        let (mut states, mut x) = (vec![(0.0, 0.0)], vec![0.0]);
        for row in 0..50 {
            for part in 1..=parts {
                x.push(later(states[row], command(row), part as f64 * step).0);
            }
            states.push(later(states[row], command(row), parts as f64 * step));
        }
        let read = |is_late: bool, time: f64| {
            let block = PathBlock::from(RecordBlock::Instant { parts, is_late });
            let mut out = vec![0.0; x.len()];
            block.prepare(&[time], step).unwrap().run(Signals::path(&x), &mut out);
            out
        };
        for part in [0.01, 0.3, 0.97] {
            let (late, early) = (read(true, part * row), read(false, part * row));
            for k in 1..49 {
                let expected = later(states[k], command(k), part * row).0;
                assert!((late[k * parts] - expected).abs() < 2e-4, "late by {part}, row {k}");
                let expected = later(states[k - 1], command(k - 1), (1.0 - part) * row).0;
                assert!((early[k * parts] - expected).abs() < 2e-4, "early by {part}, row {k}");
            }
        }
        assert_eq!(read(true, 0.0), x);
        // Before the first row it rests.
        assert_eq!(read(false, 3.0 * row)[..=3 * parts], vec![0.0; 3 * parts + 1]);
    }

    #[test]
    fn a_polynomial_of_the_fifth_order_is_met_between_its_values() {
        let f = |t: f64| 1.0 + t * (0.5 - t * (0.2 - t * (0.03 + t * (0.01 - 0.002 * t))));
        let x: Vec<f64> = (0..12).map(|k| f(f64::from(k) - 5.0)).collect();
        for place in [2.0, 2.25, 5.5, 7.9, 8.0] {
            assert!((between(&x, place) - f(place - 5.0)).abs() < 1e-12, "{place}");
        }
        // Held at the ends.
        assert_eq!([between(&x, -3.0), between(&x, 40.0)], [x[0], x[11]]);
    }

    #[test]
    fn a_wrong_number_of_parameters_is_an_error() {
        let memory = Memory { r: vec![0.2], w: vec![0.3] };
        let all = [
            (RecordBlock::Clock, 1),
            (RecordBlock::StartMemory(memory), 1),
            (RecordBlock::Droop, 2),
            (RecordBlock::Instant { parts: 4, is_late: true }, 1),
        ];
        for (block, count) in all {
            let block = PathBlock::from(block);
            for given in 0..4 {
                let prepared = block.prepare(&vec![0.1; given], 1e-3);
                assert_eq!(prepared.is_ok(), given == count, "{block:?} with {given}");
            }
        }
    }
}
