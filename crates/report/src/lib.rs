//! Results as a typed context, a JSON file and one self-contained page.
//!
//! Every command of the tool hands its result over as a [`Report`]: the sentence first, then the
//! key figures, then sections of paragraphs, figures and tables, and the provenance last. The same
//! context is written as JSON ([`Report::to_json`]) and as one HTML file ([`Report::to_html`])
//! that needs no network, reads without scripts and prints.
//!
//! Figures take full-length data and keep only what a page can show: at most a few thousand points
//! per trace, with the extremes of every stretch kept, and a [`Summary`] of *all* samples. What
//! could not be drawn (values that are not finite, lengths that differ, …) is said in the figure's
//! notes, never dropped in silence.
//!
//! ```
//! use report::{KeyFigure, Report, Section, TimeSeries, Verdict};
//!
//! let time = [0.0, 0.1, 0.2];
//! let report = Report::new("identify", "Identification", Verdict::pass("The model fits to 0.6 %."))
//!     .key_figure(KeyFigure::new("RMSE, held out", 0.61, "% of range").at_most(0.8))
//!     .section(
//!         Section::new("Held-out record").figure(
//!             TimeSeries::new("Measured and simulated position", &time)
//!                 .measured("measured", "um", &[0.0, 1.0, 2.0])
//!                 .model("simulated", "um", &[0.0, 1.1, 1.9]),
//!         ),
//!     );
//! assert!(report.to_html().unwrap().contains("The model fits to 0.6 %."));
//! ```

mod chart;
mod context;
mod diagram;
mod error;
mod figure;
mod finite;
mod number;
mod page;
mod provenance;
mod reduce;
mod schema;
mod summary;
mod table;
mod value;
mod write;

pub use context::{Block, Report, Section, Verdict};
pub use diagram::{Diagram, Lane, Look, Stage};
pub use error::ReportError;
pub use figure::{
    Axis, Band, Bode, Figure, Histogram, Limit, Loop, Marker, Panel, Response, Role, SampleSet,
    Spectrum, SpectrumTrace, TimeSeries, Trace, XyLoop,
};
pub use number::{format_number, format_unit};
pub use provenance::{InputFile, Provenance, utc_timestamp};
pub use schema::SCHEMA;
pub use summary::Summary;
pub use table::{Column, Table};
pub use value::{KeyFigure, Outcome, Target, Value};
