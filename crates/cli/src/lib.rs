//! What the programs of this project have in common: answers on the screen and as JSON, pages, progress, and what
//! happens when they are interrupted.

mod answer;
pub mod interrupt;
mod output;
mod page;
mod progress;

pub use answer::{
    Answer, ErasedAnswer, STANDARD_OUTPUT, Screen, keep_standard_output, note_on_log, rounded,
    sentence, standard_output,
};
pub use output::{can_write, can_write_as, ends_in};
pub use page::{PageOptions, Pages};
pub use progress::bar;
