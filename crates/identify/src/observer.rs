//! How long work reports its progress. Nothing here prints.

/// What a method reports while it works. Every call has a default that does nothing.
pub trait Observer {
    /// `done` of `total` units of `stage` are done; `total` is the most that there can be.
    fn progress(&mut self, stage: &'static str, done: usize, total: usize) {
        let _ = (stage, done, total);
    }

    /// Whether the work is to end now. What is finished by then is returned.
    fn stopped(&self) -> bool {
        false
    }
}

/// An observer that listens to nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}
