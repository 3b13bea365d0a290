//! A hysteresis term beside a straight line: past commands, positions, and past terms.
//!
//! ```text
//! y = offset + gain·(u + h)
//! model I:    h(t) = f(u(t) … u(t−m), h(t−1) … h(t−l))
//! model II:   h(t) = f(y(t) … y(t−m), h(t−1) … h(t−l))
//! model III:  h(t) = f(u(t) … u(t−m), y(t−1) … y(t−1−m), h(t−1) … h(t−l))
//! ```
//!
//! Told u(t) and y(t) together, f would solve y = offset + gain·(u + h) for h and know nothing of the machine: model III
//! has the positions up to one sample before. Model II is the one whose term needs no command, so that it serves as
//! feedforward without an inverse; here y(t) is the root of both equations.
//!
//! Source: Q. Xu, Identification and Compensation of Piezoelectric Hysteresis Without Modeling Hysteresis Inverse, IEEE Trans. Ind. Electron. 60
//! (2013) 3927-3937, eqs. (5)-(9); it prints u(t) and y(t) in model III.

use crate::KernelSum;

/// Which signals the term depends on, beside its own past.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TermSignals {
    /// The command: model I.
    Command,
    /// The position: model II.
    Position,
    /// Both: model III.
    Both,
}

/// A range that is 0 to 1 for the kernels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Is 0.
    pub low: f64,
    /// From there to 1.
    pub span: f64,
}

impl Range {
    fn inward(self, x: f64) -> f64 {
        (x - self.low) / self.span
    }

    fn outward(self, x: f64) -> f64 {
        self.low + x * self.span
    }
}

/// Line, inputs and ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Signals among the inputs.
    pub signals: TermSignals,
    /// Past values m of each signal.
    pub past: usize,
    /// Past terms l.
    pub terms: usize,
    /// Position per command of the line.
    pub gain: f64,
    /// Position at zero command and term.
    pub offset: f64,
    /// Of the command.
    pub command: Range,
    /// Of the position.
    pub position: Range,
    /// Of the term, in the command's unit.
    pub term: Range,
}

/// How far beyond its range a term may go, in ranges.
const BEYOND: f64 = 1.0;
/// Most evaluations for a position that its own term depends on, and the part of the range within which it is found.
const EVALUATIONS: usize = 60;
const FOUND: f64 = 1e-12;

impl Term {
    /// Numbers of one input.
    #[must_use]
    pub fn dimension(&self) -> usize {
        let signals = if self.signals == TermSignals::Both { 2 } else { 1 };
        signals * (self.past + 1) + self.terms
    }

    /// Numbers of memory.
    #[must_use]
    pub fn memory(&self) -> usize {
        self.commands() + self.positions() + self.terms
    }

    /// Past commands in the memory.
    fn commands(&self) -> usize {
        if self.signals == TermSignals::Position { 0 } else { self.past }
    }

    /// Past positions in the memory.
    fn positions(&self) -> usize {
        match self.signals {
            TermSignals::Command => 0,
            TermSignals::Position => self.past,
            TermSignals::Both => self.past + 1,
        }
    }

    /// The position of the line with a term.
    #[must_use]
    pub fn position(&self, u: f64, h: f64) -> f64 {
        self.offset + self.gain * (u + h)
    }

    /// The term that leads to a position.
    #[must_use]
    pub fn term(&self, u: f64, y: f64) -> f64 {
        (y - self.offset) / self.gain - u
    }

    /// The memory of a system that rests under `u` at `y`.
    pub fn rest(&self, u: f64, y: f64, memory: &mut [f64]) {
        let h = self.term.inward(self.term(u, y));
        let (commands, rest) = memory.split_at_mut(self.commands().min(memory.len()));
        let (positions, terms) = rest.split_at_mut(self.positions().min(rest.len()));
        commands.fill(self.command.inward(u));
        positions.fill(self.position.inward(y));
        terms.fill(h);
    }

    /// The inputs at one sample: the position matters to model II alone.
    fn fill(&self, u: f64, y: f64, memory: &[f64], z: &mut [f64]) {
        let mut z = z.iter_mut();
        let mut put = |x: f64| {
            if let Some(z) = z.next() {
                *z = x;
            }
        };
        match self.signals {
            TermSignals::Command | TermSignals::Both => put(self.command.inward(u)),
            TermSignals::Position => put(self.position.inward(y)),
        }
        memory.iter().for_each(|x| put(*x));
    }

    /// Takes what belongs to a sample into the memory.
    pub fn push(&self, u: f64, y: f64, h: f64, memory: &mut [f64]) {
        let (commands, rest) = memory.split_at_mut(self.commands().min(memory.len()));
        let (positions, terms) = rest.split_at_mut(self.positions().min(rest.len()));
        super::push(commands, self.command.inward(u));
        super::push(positions, self.position.inward(y));
        super::push(terms, self.term.inward(h));
    }

    /// The term as it is learned, within its bounds.
    fn value(&self, f: &KernelSum, z: &[f64], room: &mut [f64]) -> f64 {
        self.term.outward(f.value(z, room).clamp(-BEYOND, 1.0 + BEYOND))
    }

    /// One sample: the position that belongs to the command. `z` and `room` hold [`dimension`](Self::dimension) numbers each.
    pub fn respond(
        &self,
        f: &KernelSum,
        u: f64,
        memory: &mut [f64],
        (z, room): (&mut [f64], &mut [f64]),
    ) -> f64 {
        let y = match self.signals {
            TermSignals::Command | TermSignals::Both => {
                self.fill(u, 0.0, memory, z);
                self.position(u, self.value(f, z, room))
            }
            TermSignals::Position => {
                let mut missing = |y: f64| {
                    self.fill(u, y, memory, z);
                    self.position(u, self.value(f, z, room)) - y
                };
                let ends = [-BEYOND, 1.0 + BEYOND].map(|h| self.position(u, self.term.outward(h)));
                let first =
                    memory.first().map_or(self.position(u, 0.0), |y| self.position.outward(*y));
                self.root(ends, first, &mut missing)
            }
        };
        self.push(u, y, self.term(u, y), memory);
        y
    }

    /// Where what is missing vanishes between these ends, from `first` on: secants, and halves where these leave the
    /// bounds.
    fn root(&self, ends: [f64; 2], first: f64, missing: &mut dyn FnMut(f64) -> f64) -> f64 {
        // Something is missing at the lower end, and too much is there at the upper one.
        let (mut low, mut high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let limit = FOUND * self.position.span.abs();
        let mut before: Option<(f64, f64)> = None;
        let mut y = first.clamp(low, high);
        for _ in 0..EVALUATIONS {
            let rest = missing(y);
            if rest.abs() <= limit || high - low <= limit {
                break;
            }
            if rest > 0.0 {
                low = y;
            } else {
                high = y;
            }
            let secant = match before {
                Some((other, at)) if at != rest => y - rest * (y - other) / (rest - at),
                // As if the term did not depend on the position.
                _ => y + rest,
            };
            before = Some((y, rest));
            let within = secant > low && secant < high;
            y = if within { secant } else { 0.5 * (low + high) };
        }
        y
    }

    /// Inputs and scaled terms of a record, one after the other: positions that belong to the commands.
    #[must_use]
    pub fn of_record(&self, command: &[f64], position: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut memory, d) = (vec![0.0; self.memory()], self.dimension());
        let count = command.len().min(position.len());
        let (mut inputs, mut terms) = (vec![0.0; d * count], Vec::with_capacity(count));
        let (Some(u), Some(y)) = (command.first(), position.first()) else {
            return (inputs, terms);
        };
        self.rest(*u, *y, &mut memory);
        for ((u, y), z) in command.iter().zip(position).zip(inputs.chunks_exact_mut(d.max(1))) {
            self.fill(*u, *y, &memory, z);
            let h = self.term(*u, *y);
            terms.push(self.term.inward(h));
            self.push(*u, *y, h, &mut memory);
        }
        (inputs, terms)
    }

    /// Positions of the rows from `first` on, in simulation: from what was measured before them.
    #[must_use]
    pub fn simulate(
        &self,
        f: &KernelSum,
        command: &[f64],
        position: &[f64],
        first: usize,
    ) -> Vec<f64> {
        let (mut z, mut room) = (vec![0.0; self.dimension()], vec![0.0; self.dimension()]);
        let mut memory = vec![0.0; self.memory()];
        let (Some(u), Some(y)) = (command.first(), position.first()) else { return Vec::new() };
        self.rest(*u, *y, &mut memory);
        for (u, y) in command.iter().zip(position).take(first) {
            self.push(*u, *y, self.term(*u, *y), &mut memory);
        }
        let rest = command.get(first..).unwrap_or(&[]);
        rest.iter().map(|u| self.respond(f, *u, &mut memory, (&mut z, &mut room))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Range = Range { low: 0.0, span: 1.0 };

    fn term(signals: TermSignals) -> Term {
        Term {
            signals,
            past: 2,
            terms: 2,
            gain: 2.0,
            offset: 0.5,
            command: UNIT,
            position: Range { low: 0.5, span: 2.0 },
            term: Range { low: -0.5, span: 1.0 },
        }
    }

    #[test]
    fn inputs_are_those_of_the_three_models() {
        let (u, y) = ([0.1, 0.2, 0.4, 0.3], [0.7, 0.9, 1.1, 1.3]);
        let scaled = |y: f64| (y - 0.5) / 2.0;
        let h = |k: usize| (y[k] - 0.5) / 2.0 - u[k] + 0.5;
        let expected = [
            (TermSignals::Command, vec![0.3, 0.4, 0.2, h(2), h(1)]),
            (TermSignals::Position, vec![scaled(1.3), scaled(1.1), scaled(0.9), h(2), h(1)]),
            (
                TermSignals::Both,
                vec![0.3, 0.4, 0.2, scaled(1.1), scaled(0.9), scaled(0.7), h(2), h(1)],
            ),
        ];
        for (signals, expected) in expected {
            let term = term(signals);
            let (inputs, terms) = term.of_record(&u, &y);
            assert_eq!(term.dimension(), expected.len());
            let last = &inputs[3 * expected.len()..];
            assert!(
                last.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12),
                "{last:?} {expected:?}"
            );
            assert!((terms[3] - h(3)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_position_that_its_term_depends_on_is_the_root_of_both_equations() {
        let term = term(TermSignals::Position);
        let centres: Vec<f64> = (0..60).map(|i| libm::sin(1.3 * f64::from(i)).abs()).collect();
        let weights: Vec<f64> = (0..12).map(|i| 0.3 * libm::cos(f64::from(i))).collect();
        let f = KernelSum::new(5, &centres, &weights, &[0.8], 0.5);
        let u: Vec<f64> = (0..200).map(|k| 0.5 - 0.5 * libm::cos(0.1 * f64::from(k))).collect();
        let y = term.simulate(&f, &u, &[0.5], 0);
        // Told these positions, the term leads to them.
        let (inputs, terms) = term.of_record(&u, &y);
        let mut room = [0.0; 5];
        let mut greatest = 0.0_f64;
        for (k, z) in inputs.chunks(5).enumerate().skip(3) {
            greatest = greatest.max((f.value(z, &mut room) - terms[k]).abs());
        }
        assert!(greatest < 1e-9, "{greatest}");
        let span = y.iter().copied().fold(0.0, f64::max);
        assert!(span > 1.0 && y.iter().all(|y| y.is_finite()));
    }
}
