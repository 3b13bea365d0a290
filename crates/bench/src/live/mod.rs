//! Live views of a run: on the terminal, and as a local web page. Both look at the recorder's
//! [`View`](crate::record::View); the cycle knows nothing of them.

mod dashboard;
mod terminal;
mod web;

pub use dashboard::Dashboard;
pub use terminal::{Terminal, draw};
pub use web::{Web, WebError};
