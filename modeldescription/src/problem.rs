//! One problem of an FMU: where it is, which rule of which section it breaks, and the way out.

use std::fmt;

use serde::Serialize;

use crate::description::FmiVersion;

/// How bad a problem is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Allowed, but some importers stumble over it.
    Warning,
    /// The standard forbids it.
    Error,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Severity::Warning => "warning",
            Severity::Error => "error",
        })
    }
}

/// What a rule is about; names the section of the standard for each version.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Topic {
    /// The XML document as such: encoding, well-formedness.
    Document,
    /// The root element and its attributes.
    Root,
    /// `<CoSimulation>`.
    CoSimulation,
    /// `<ModelExchange>`.
    ModelExchange,
    /// `<ScheduledExecution>` (3.0).
    ScheduledExecution,
    /// `<UnitDefinitions>`.
    Units,
    /// `<TypeDefinitions>`.
    Types,
    /// `<LogCategories>`.
    LogCategories,
    /// `<DefaultExperiment>`.
    DefaultExperiment,
    /// `<ModelVariables>`.
    Variables,
    /// The variable naming convention.
    Names,
    /// `<ModelStructure>`.
    Structure,
    /// The zip archive and its folders.
    Distribution,
    /// The shared libraries and the functions they export.
    Binaries,
    /// Further data that travels with the FMU, such as reference results.
    Extra,
}

impl Topic {
    /// The section of the standard (2.0.5 or 3.0.2) that holds the rules of this topic.
    pub fn section(self, version: FmiVersion) -> &'static str {
        match version {
            FmiVersion::V2 => self.section_2_0_5(),
            FmiVersion::V3 => self.section_3_0_2(),
        }
    }

    fn section_2_0_5(self) -> &'static str {
        match self {
            Topic::Document => "FMI 2.0.5, 2.2",
            Topic::Root => "FMI 2.0.5, 2.2.1",
            Topic::CoSimulation => "FMI 2.0.5, 4.3.1",
            Topic::ModelExchange | Topic::ScheduledExecution => "FMI 2.0.5, 3.3.1",
            Topic::Units => "FMI 2.0.5, 2.2.2",
            Topic::Types => "FMI 2.0.5, 2.2.3",
            Topic::LogCategories => "FMI 2.0.5, 2.2.4",
            Topic::DefaultExperiment => "FMI 2.0.5, 2.2.5",
            Topic::Variables => "FMI 2.0.5, 2.2.7",
            Topic::Structure => "FMI 2.0.5, 2.2.8",
            Topic::Names => "FMI 2.0.5, 2.2.9",
            Topic::Distribution | Topic::Binaries | Topic::Extra => "FMI 2.0.5, 2.3",
        }
    }

    fn section_3_0_2(self) -> &'static str {
        match self {
            Topic::Document => "FMI 3.0.2, 2.4",
            Topic::Root => "FMI 3.0.2, 2.4.1",
            Topic::CoSimulation => "FMI 3.0.2, 4.4",
            Topic::ModelExchange => "FMI 3.0.2, 3.4",
            Topic::ScheduledExecution => "FMI 3.0.2, 5.4",
            Topic::Units => "FMI 3.0.2, 2.4.3",
            Topic::Types => "FMI 3.0.2, 2.4.4",
            Topic::LogCategories => "FMI 3.0.2, 2.4.5",
            Topic::DefaultExperiment => "FMI 3.0.2, 2.4.6",
            Topic::Variables => "FMI 3.0.2, 2.4.7",
            Topic::Names => "FMI 3.0.2, 2.4.7.5.1",
            Topic::Structure => "FMI 3.0.2, 2.4.8",
            Topic::Distribution => "FMI 3.0.2, 2.5",
            Topic::Binaries => "FMI 3.0.2, 2.5.1.4",
            Topic::Extra => "FMI 3.0.2, 2.5.1.6",
        }
    }
}

/// One problem of an FMU.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// How bad it is.
    pub severity: Severity,
    /// File inside the FMU (`modelDescription.xml`, `binaries/linux64/plant.so`, …).
    pub file: String,
    /// Line in that file, counted from 1, where the file is text.
    pub line: Option<u32>,
    /// Section of the FMI standard that holds the rule.
    pub section: &'static str,
    /// What was found, with the name of the element, variable or entry and the value.
    pub found: String,
    /// The rule that is broken.
    pub rule: String,
    /// What to change.
    pub way_out: String,
    /// The value could not be understood, so the description cannot be used as it is.
    #[serde(skip)]
    pub(crate) unreadable: bool,
}

/// Name of the description inside an FMU.
pub const MODEL_DESCRIPTION: &str = "modelDescription.xml";

impl Problem {
    /// An error in `modelDescription.xml`; the rule and the way out follow with
    /// [`Problem::rule`] and [`Problem::way_out`].
    pub(crate) fn in_xml(version: FmiVersion, topic: Topic, line: u32, found: String) -> Self {
        Problem {
            severity: Severity::Error,
            file: MODEL_DESCRIPTION.to_owned(),
            line: (line > 0).then_some(line),
            section: topic.section(version),
            found,
            rule: String::new(),
            way_out: String::new(),
            unreadable: false,
        }
    }

    /// An error of an entry of the archive; the rule and the way out follow with [`Problem::rule`]
    /// and [`Problem::way_out`].
    pub fn in_entry(version: FmiVersion, topic: Topic, entry: &str, found: String) -> Self {
        Problem { file: entry.to_owned(), ..Problem::in_xml(version, topic, 0, found) }
    }

    /// Adds the rule that is broken.
    #[must_use]
    pub fn rule(mut self, rule: impl Into<String>) -> Self {
        self.rule = rule.into();
        self
    }

    /// Adds what to change.
    #[must_use]
    pub fn way_out(mut self, way_out: impl Into<String>) -> Self {
        self.way_out = way_out.into();
        self
    }

    pub(crate) fn warning(mut self) -> Self {
        self.severity = Severity::Warning;
        self
    }

    pub(crate) fn unreadable(mut self) -> Self {
        self.unreadable = true;
        self
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}: {}; {}", self.severity, self.found, self.rule)?;
        if !self.way_out.is_empty() {
            write!(f, "; {}", self.way_out)?;
        }
        write!(f, " [{}]", self.section)
    }
}
