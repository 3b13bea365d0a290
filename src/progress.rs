//! Progress of long work: on a terminal only.

use std::io;

use cli::{Screen, bar, interrupt};
use cosim::record::Column;
use indicatif::ProgressBar;

/// A progress bar that moves by the rows recorded. Asking a hidden bar takes a lock, so there is none
/// where nobody looks.
pub(crate) struct Rows(Option<ProgressBar>);

impl Rows {
    pub(crate) fn new(screen: &Screen, what: &'static str, rows: usize) -> Self {
        let bar = bar(screen, what, rows as u64);
        Self((!bar.is_hidden()).then_some(bar))
    }

    /// Takes it off the screen.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

impl cosim::Recorder for Rows {
    fn begin(&mut self, _: usize, _: &[Column], _: usize) -> io::Result<()> {
        Ok(())
    }

    fn row(&mut self, _: f64, _: &[f64]) -> io::Result<()> {
        if let Some(bar) = &self.0 {
            bar.inc(1);
        }
        Ok(())
    }
}

/// Shows nothing, and stops where the user asks to.
pub(crate) struct NoProgress;

impl identify::Observer for NoProgress {
    fn stopped(&self) -> bool {
        interrupt::asked()
    }
}

/// Shows the stages of an identification or an inversion, and stops where the user asks to.
pub(crate) struct Stages(ProgressBar);

impl Stages {
    pub(crate) fn new(screen: &Screen, what: &'static str) -> Self {
        Self(bar(screen, what, 1))
    }
}

impl identify::Observer for Stages {
    fn stopped(&self) -> bool {
        interrupt::asked()
    }

    fn progress(&mut self, stage: &'static str, done: usize, total: usize) {
        self.0.set_message(stage);
        self.0.set_length(total as u64);
        self.0.set_position(done as u64);
    }
}

impl Drop for Stages {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
