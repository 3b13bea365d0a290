//! The report itself.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::diagram::Diagram;
use crate::error::ReportError;
use crate::figure::Figure;
use crate::provenance::Provenance;
use crate::table::Table;
use crate::value::{KeyFigure, Outcome};
use crate::{SCHEMA, write};

/// The result of one command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Always [`SCHEMA`].
    pub schema: String,
    /// The command that made it: `identify`, `simulate`, `diagnose`, …
    pub command: String,
    /// What the report is about, in a few words.
    pub title: String,
    /// The answer in one sentence.
    pub verdict: Verdict,
    /// What the reader must know before trusting the rest; shown right below the sentence.
    pub warnings: Vec<String>,
    /// The figures that matter.
    pub key_figures: Vec<KeyFigure>,
    /// The evidence.
    pub sections: Vec<Section>,
    /// What the report was made from; shown last.
    pub provenance: Provenance,
}

/// The answer in one sentence, and whether it is good news.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Verdict {
    /// Whether the result is as wanted.
    pub outcome: Outcome,
    /// The sentence, with its numbers.
    pub sentence: String,
}

impl Verdict {
    /// A verdict with a given outcome.
    pub fn new(outcome: Outcome, sentence: impl Into<String>) -> Self {
        Self { outcome, sentence: sentence.into() }
    }

    /// As wanted.
    pub fn pass(sentence: impl Into<String>) -> Self {
        Self::new(Outcome::Pass, sentence)
    }

    /// Not as wanted.
    pub fn fail(sentence: impl Into<String>) -> Self {
        Self::new(Outcome::Fail, sentence)
    }

    /// Undecided, or to be read with care.
    pub fn caution(sentence: impl Into<String>) -> Self {
        Self::new(Outcome::Caution, sentence)
    }

    /// A statement that is neither good nor bad.
    pub fn neutral(sentence: impl Into<String>) -> Self {
        Self::new(Outcome::None, sentence)
    }
}

/// One section: a heading and its blocks, in order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// The heading.
    pub heading: String,
    /// The content.
    pub blocks: Vec<Block>,
}

/// One piece of a [`Section`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Block {
    /// Plain text.
    Paragraph(String),
    /// Plain text, one item per line, with bullets.
    List(Vec<String>),
    /// Commands or a file's content, shown with a fixed pitch.
    Code(String),
    /// A figure.
    Figure(Figure),
    /// A table.
    Table(Table),
    /// Signal paths as rows of boxes.
    Diagram(Diagram),
}

impl Section {
    /// A section without content.
    pub fn new(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), blocks: Vec::new() }
    }

    /// Appends a paragraph of plain text.
    #[must_use]
    pub fn paragraph(self, text: impl Into<String>) -> Self {
        self.block(Block::Paragraph(text.into()))
    }

    /// Appends a list of plain-text items.
    #[must_use]
    pub fn list<S: Into<String>>(self, items: impl IntoIterator<Item = S>) -> Self {
        self.block(Block::List(items.into_iter().map(Into::into).collect()))
    }

    /// Appends commands or a file's content.
    #[must_use]
    pub fn code(self, text: impl Into<String>) -> Self {
        self.block(Block::Code(text.into()))
    }

    /// Appends a figure. Loops and histograms that follow one another stand side by side.
    #[must_use]
    pub fn figure(self, figure: impl Into<Figure>) -> Self {
        self.block(Block::Figure(figure.into()))
    }

    /// Appends a table.
    #[must_use]
    pub fn table(self, table: Table) -> Self {
        self.block(Block::Table(table))
    }

    /// Appends a diagram.
    #[must_use]
    pub fn diagram(self, diagram: Diagram) -> Self {
        self.block(Block::Diagram(diagram))
    }

    /// Appends any block.
    #[must_use]
    pub fn block(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }
}

impl Report {
    /// A report with its sentence and nothing else.
    pub fn new(command: impl Into<String>, title: impl Into<String>, verdict: Verdict) -> Self {
        Self {
            schema: SCHEMA.to_owned(),
            command: command.into(),
            title: title.into(),
            verdict,
            warnings: Vec::new(),
            key_figures: Vec::new(),
            sections: Vec::new(),
            provenance: Provenance::default(),
        }
    }

    /// Appends a warning.
    #[must_use]
    pub fn warning(mut self, text: impl Into<String>) -> Self {
        self.warnings.push(text.into());
        self
    }

    /// Appends a key figure.
    #[must_use]
    pub fn key_figure(mut self, figure: KeyFigure) -> Self {
        self.key_figures.push(figure);
        self
    }

    /// Appends a section.
    #[must_use]
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// Sets the provenance.
    #[must_use]
    pub fn provenance(mut self, provenance: Provenance) -> Self {
        self.provenance = provenance;
        self
    }

    /// Whether no key figure and not the verdict failed: for exit codes.
    pub fn passed(&self) -> bool {
        self.verdict.outcome != Outcome::Fail
            && self.key_figures.iter().all(|figure| figure.outcome != Outcome::Fail)
    }

    /// The context as JSON, figures as they are drawn.
    ///
    /// # Errors
    /// [`ReportError::Json`] if the JSON library refuses the context.
    pub fn to_json(&self) -> Result<String, ReportError> {
        Ok(serde_json::to_string(self)?)
    }

    /// Reads what [`Report::to_json`] wrote, so that a page can be rendered again.
    ///
    /// # Errors
    /// [`ReportError::Json`] if the text is no report, [`ReportError::Schema`] if it is one of
    /// another schema.
    pub fn from_json(text: &str) -> Result<Self, ReportError> {
        let report: Self = serde_json::from_str(text)?;
        if report.schema == SCHEMA {
            Ok(report)
        } else {
            Err(ReportError::Schema { found: report.schema })
        }
    }

    /// Writes the JSON, complete or not at all.
    ///
    /// # Errors
    /// [`Report::to_json`] fails, or [`ReportError::Write`].
    pub fn write_json(&self, path: impl AsRef<Path>) -> Result<(), ReportError> {
        write::complete(path.as_ref(), &self.to_json()?)
    }
}
