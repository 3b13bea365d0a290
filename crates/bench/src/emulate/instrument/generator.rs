//! The wave generator and the data recorder of an emulated instrument.

/// A wave generator: points of a table, each held over some servo cycles.
#[derive(Clone, Debug, Default)]
pub(in crate::emulate) struct Generator {
    pub(super) table: Vec<f64>,
    /// Servo cycles per point.
    pub(super) hold: u32,
    /// Times the table is played; 0 without end.
    pub(super) cycles: u32,
    /// Added to each point.
    pub(super) offset: f64,
    /// First point of the first cycle.
    pub(super) first: usize,
    at: Option<u64>,
}

impl Generator {
    pub(super) fn new() -> Self {
        Generator { hold: 1, ..Generator::default() }
    }

    pub(super) fn start(&mut self) {
        self.at = (!self.table.is_empty()).then_some(self.first as u64 * u64::from(self.hold));
    }

    pub(super) fn stop(&mut self) {
        self.at = None;
    }

    pub(super) fn is_running(&self) -> bool {
        self.at.is_some()
    }

    /// The point that is played.
    pub(super) fn index(&self) -> usize {
        let point = self.at.unwrap_or_default() / u64::from(self.hold.max(1));
        (point % (self.table.len() as u64).max(1)) as usize
    }

    /// The value of this servo cycle; none: it does not run.
    pub(super) fn next(&mut self) -> Option<f64> {
        let at = self.at?;
        let length = self.table.len() as u64 * u64::from(self.hold);
        if self.cycles > 0 && at >= length * u64::from(self.cycles) {
            self.at = None;
            return None;
        }
        let value = self.table[self.index()] + self.offset;
        self.at = Some(at + 1);
        Some(value)
    }
}

/// What can be recorded of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::emulate) enum Seen {
    #[default]
    Nothing,
    Target,
    Position,
    Error,
    AbsoluteError,
    Voltage,
}

/// What a table records: axis and signal.
pub(in crate::emulate) type Source = (usize, Seen);

/// A data recorder: all tables at once, until they are full.
#[derive(Clone, Debug)]
pub(in crate::emulate) struct Recorder {
    pub(super) sources: Vec<Source>,
    /// Servo cycles per value.
    pub(super) every: u32,
    /// Values per table.
    pub(super) length: usize,
    pub(super) tables: Vec<Vec<f64>>,
    at: Option<u64>,
}

impl Recorder {
    pub(super) fn new(sources: Vec<Source>, length: usize) -> Self {
        let tables = vec![Vec::new(); sources.len()];
        Recorder { sources, every: 1, length, tables, at: None }
    }

    pub(super) fn start(&mut self) {
        self.tables.iter_mut().for_each(Vec::clear);
        self.at = Some(0);
    }

    pub(super) fn stop(&mut self) {
        self.at = None;
    }

    pub(super) fn is_running(&self) -> bool {
        self.at.is_some()
    }

    /// One servo cycle.
    pub(super) fn take(&mut self, value: impl Fn(Source) -> f64) {
        let Some(at) = self.at else { return };
        if at.is_multiple_of(u64::from(self.every.max(1))) {
            let values = self.sources.iter().map(|source| value(*source));
            self.tables.iter_mut().zip(values).for_each(|(table, value)| table.push(value));
        }
        let is_full = self.tables.first().is_none_or(|table| table.len() >= self.length);
        self.at = (!is_full).then_some(at + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_held_and_repeated_and_recorded() {
        let mut generator =
            Generator { table: vec![1.0, 2.0], hold: 2, cycles: 2, ..Generator::new() };
        let mut recorder = Recorder::new(vec![(0, Seen::Target)], 4);
        recorder.every = 2;
        assert_eq!(generator.next(), None);
        generator.start();
        recorder.start();
        let mut all = Vec::new();
        while let Some(value) = generator.next() {
            recorder.take(|_| value);
            all.push(value);
        }
        assert_eq!(all, [1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 2.0]);
        assert_eq!(recorder.tables, [[1.0, 2.0, 1.0, 2.0]]);
        assert!(!recorder.is_running() && !generator.is_running());
    }
}
