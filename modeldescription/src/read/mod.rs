//! Reads `modelDescription.xml`.
//!
//! Reading goes on past every deviation from the schema and reports it. Deviations that leave the
//! meaning clear (an unknown attribute, an element in the wrong place) do not keep a description from
//! being used; a value that cannot be understood does.

mod interfaces;
mod structure;
mod units;
mod values;
mod variables;

use crate::description::NamingConvention;
use crate::description::{DefaultExperiment, FmiVersion, Line, LogCategory, ModelDescription};
use crate::problem::{Problem, Topic};
use crate::xml::{self, Document, Element, XmlError, XmlLimits};
use values::{Attributes, Context};

/// Why a model description cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ParseError {
    /// The XML cannot be read.
    #[error("modelDescription.xml{}: {}", at(.0), .0)]
    Xml(#[from] XmlError),
    /// The root element is another one.
    #[error(
        "modelDescription.xml:{line}: the root element is <{found}>; it must be <fmiModelDescription>"
    )]
    Root {
        /// Line of the root element.
        line: u32,
        /// The line's name.
        found: String,
    },
    /// A version of the standard that is not supported.
    #[error(
        "modelDescription.xml:{line}: fmiVersion=\"{found}\"; versions 2.0 and 3.x are supported"
    )]
    Version {
        /// Line of the root element.
        line: u32,
        /// The version found.
        found: String,
    },
    /// Values that cannot be understood.
    #[error("{}", list(.0))]
    Unreadable(Vec<Problem>),
}

/// `:12`, or nothing where the error has no line.
fn at(error: &XmlError) -> String {
    error.line().map_or_else(String::new, |line| format!(":{line}"))
}

fn list(problems: &[Problem]) -> String {
    let mut text: Vec<String> = problems.iter().take(10).map(Problem::to_string).collect();
    if problems.len() > text.len() {
        text.push(format!("… and {} more", problems.len() - text.len()));
    }
    text.join("\n")
}

impl ModelDescription {
    /// Reads `modelDescription.xml` of FMI 2.0 or 3.0, leniently: whatever can be understood is
    /// accepted; [`crate::check`] tells what deviates from the standard.
    ///
    /// # Errors
    /// If the XML is not well-formed or exceeds a limit (see [`XmlLimits`]), is no FMI 2.0 or 3.0
    /// description, or holds values that cannot be understood (all of them are named).
    pub fn parse(bytes: &[u8]) -> Result<Self, ParseError> {
        usable(bytes, &XmlLimits::default())
    }
}

/// Reads a description that can be used, whatever else deviates from the schema.
pub(crate) fn usable(bytes: &[u8], limits: &XmlLimits) -> Result<ModelDescription, ParseError> {
    let (description, problems) = read(bytes, limits)?;
    let unreadable: Vec<Problem> = problems.into_iter().filter(|p| p.unreadable).collect();
    match unreadable.is_empty() {
        true => Ok(description),
        false => Err(ParseError::Unreadable(unreadable)),
    }
}

/// Reads a description as far as possible, and everything that deviates from the schema.
pub(crate) fn read(
    bytes: &[u8],
    limits: &XmlLimits,
) -> Result<(ModelDescription, Vec<Problem>), ParseError> {
    let document = xml::parse(bytes, limits)?;
    let root = &document.root;
    if root.name != "fmiModelDescription" {
        return Err(ParseError::Root { line: root.line, found: root.name.clone() });
    }
    let text = root.attribute("fmiVersion").unwrap_or_default();
    let version = match text.trim() {
        v if v == "2" || v.starts_with("2.") => FmiVersion::V2,
        v if v.starts_with("3.") => FmiVersion::V3,
        v => return Err(ParseError::Version { line: root.line, found: v.to_owned() }),
    };
    let mut context = Context { version, problems: Vec::new() };
    check_encoding(&mut context, &document);
    check_version(&mut context, root, text);
    let description = read_root(&mut context, root);
    Ok((description, context.problems))
}

fn check_encoding(context: &mut Context, document: &Document) {
    let found = match document.encoding.as_deref() {
        Some(encoding) if encoding.eq_ignore_ascii_case("utf-8") => return,
        Some(encoding) => format!("the XML declares encoding=\"{encoding}\""),
        None => "the XML declares no encoding".to_owned(),
    };
    let problem = Problem::in_xml(context.version, Topic::Document, 1, found)
        .rule("the first line must declare the encoding, and it must be UTF-8")
        .way_out("start the file with <?xml version=\"1.0\" encoding=\"UTF-8\"?>");
    context.report(problem);
}

fn check_version(context: &mut Context, root: &Element, text: &str) {
    let exact = match context.version {
        FmiVersion::V2 => text == "2.0",
        FmiVersion::V3 => is_version_3(text),
    };
    if !exact {
        let must = context.version.text();
        let found = format!("fmiVersion=\"{text}\"");
        let problem = Problem::in_xml(context.version, Topic::Root, root.line, found)
            .rule(format!("the value must be \"{must}\", whatever the revision of the standard"))
            .way_out(format!("write fmiVersion=\"{must}\""));
        context.report(problem);
    } else if is_draft(text) {
        let found = format!("fmiVersion=\"{text}\" is a draft of the standard");
        let problem = Problem::in_xml(context.version, Topic::Root, root.line, found)
            .rule("drafts differ from FMI 3.0 in functions and attributes; it is read as FMI 3.0")
            .way_out("have it exported for FMI 3.0");
        context.report(problem.warning());
    }
}

/// Whether a version is that of a draft, such as `3.0-beta.2`.
fn is_draft(version: &str) -> bool {
    version.contains('-')
}

/// `3[.](0|[1-9][0-9]*)([.](0|[1-9][0-9]*))?(-.+)?`
fn is_version_3(text: &str) -> bool {
    let (numbers, suffix) = match text.split_once('-') {
        Some((numbers, suffix)) => (numbers, Some(suffix)),
        None => (text, None),
    };
    let parts: Vec<&str> = numbers.split('.').collect();
    let number = |part: &&str| {
        !part.is_empty()
            && part.bytes().all(|b| b.is_ascii_digit())
            && (*part == "0" || !part.starts_with('0'))
    };
    parts.first() == Some(&"3")
        && (parts.len() == 2 || parts.len() == 3)
        && parts.iter().all(number)
        && suffix != Some("")
}

const ROOT_ATTRIBUTES: [&str; 12] = [
    "fmiVersion",
    "modelName",
    "description",
    "author",
    "version",
    "copyright",
    "license",
    "generationTool",
    "generationDateAndTime",
    "variableNamingConvention",
    "guid",
    "numberOfEventIndicators",
];

const ROOT_CHILDREN_2: [&str; 9] = [
    "ModelExchange",
    "CoSimulation",
    "UnitDefinitions",
    "TypeDefinitions",
    "LogCategories",
    "DefaultExperiment",
    "VendorAnnotations",
    "ModelVariables",
    "ModelStructure",
];

const ROOT_CHILDREN_3: [&str; 10] = [
    "ModelExchange",
    "CoSimulation",
    "ScheduledExecution",
    "UnitDefinitions",
    "TypeDefinitions",
    "LogCategories",
    "DefaultExperiment",
    "ModelVariables",
    "ModelStructure",
    "Annotations",
];

fn read_root(context: &mut Context, root: &Element) -> ModelDescription {
    let at = Attributes { element: root, topic: Topic::Root };
    expect_root(context, at);
    // A missing token does not keep an FMU from being used; the checker reports it.
    let token = match context.version {
        FmiVersion::V2 => context.text(at, "guid").unwrap_or_default(),
        FmiVersion::V3 => context.text(at, "instantiationToken").unwrap_or_default(),
    };
    let name = context.required_text(at, "modelName");
    let mut description = ModelDescription::new(context.version, name, token);
    description.line = Line(root.line);
    description.draft = context.text(at, "fmiVersion").filter(|version| is_draft(version));
    description.description = context.text(at, "description");
    description.author = context.text(at, "author");
    description.version = context.text(at, "version");
    description.copyright = context.text(at, "copyright");
    description.license = context.text(at, "license");
    description.generation_tool = context.text(at, "generationTool");
    description.generation_date_and_time = context.text(at, "generationDateAndTime");
    description.variable_naming_convention = context
        .named(at, "variableNamingConvention", NamingConvention::ALL, NamingConvention::from_name)
        .unwrap_or(NamingConvention::Flat);
    description.number_of_event_indicators = context.integer(at, "numberOfEventIndicators");
    for child in &root.children {
        read_child(context, child, &mut description);
    }
    for required in ["ModelVariables", "ModelStructure"] {
        if root.child(required).is_none() {
            let found = format!("<fmiModelDescription> has no <{required}>");
            let problem = Problem::in_xml(context.version, Topic::Root, root.line, found)
                .rule("the element is required")
                .way_out(format!("add <{required}>"));
            context.report(problem);
        }
    }
    description
}

fn expect_root(context: &mut Context, at: Attributes<'_>) {
    match context.version {
        // The order of the two interface types is free in 2.0.
        FmiVersion::V2 if interfaces_reversed(at.element) => {
            let mut children = ROOT_CHILDREN_2;
            children.swap(0, 1);
            context.expect(at, &ROOT_ATTRIBUTES, &children);
        }
        FmiVersion::V2 => context.expect(at, &ROOT_ATTRIBUTES, &ROOT_CHILDREN_2),
        FmiVersion::V3 => {
            let mut attributes = ROOT_ATTRIBUTES[..10].to_vec();
            attributes.push("instantiationToken");
            context.expect(at, &attributes, &ROOT_CHILDREN_3);
        }
    }
}

fn interfaces_reversed(root: &Element) -> bool {
    let position = |name: &str| root.children.iter().position(|child| child.name == name);
    matches!((position("CoSimulation"), position("ModelExchange")), (Some(a), Some(b)) if a < b)
}

fn read_child(context: &mut Context, child: &Element, description: &mut ModelDescription) {
    let at = |topic| Attributes { element: child, topic };
    match child.name.as_str() {
        "ModelExchange" => {
            let read = interfaces::model_exchange(context, at(Topic::ModelExchange));
            description.model_exchange = Some(read);
        }
        "CoSimulation" => {
            let read = interfaces::co_simulation(context, at(Topic::CoSimulation));
            description.co_simulation = Some(read);
        }
        "ScheduledExecution" if context.version == FmiVersion::V3 => {
            let read = interfaces::scheduled_execution(context, at(Topic::ScheduledExecution));
            description.scheduled_execution = Some(read);
        }
        "UnitDefinitions" => description.units = units::units(context, at(Topic::Units)),
        "TypeDefinitions" => description.types = variables::types(context, at(Topic::Types)),
        "LogCategories" => {
            description.log_categories = log_categories(context, at(Topic::LogCategories));
        }
        "DefaultExperiment" => {
            let read = default_experiment(context, at(Topic::DefaultExperiment));
            description.default_experiment = Some(read);
        }
        "ModelVariables" => {
            description.variables = variables::variables(context, at(Topic::Variables));
        }
        "ModelStructure" => {
            description.structure = structure::structure(context, at(Topic::Structure));
        }
        _ => {}
    }
}

fn log_categories(context: &mut Context, at: Attributes<'_>) -> Vec<LogCategory> {
    context.expect(at, &[], &["Category*"]);
    context.expect_some(at);
    let mut categories = Vec::new();
    for element in at.element.children.iter().filter(|child| child.name == "Category") {
        let at = Attributes { element, topic: at.topic };
        context.expect(at, &["name", "description"], &["Annotations"]);
        categories.push(LogCategory {
            name: context.required_text(at, "name"),
            description: context.text(at, "description"),
            line: Line(element.line),
        });
    }
    categories
}

fn default_experiment(context: &mut Context, at: Attributes<'_>) -> DefaultExperiment {
    let attributes = ["startTime", "stopTime", "tolerance", "stepSize"];
    context.expect(at, &attributes, &["Annotations"]);
    DefaultExperiment {
        start_time: context.float(at, "startTime"),
        stop_time: context.float(at, "stopTime"),
        tolerance: context.float(at, "tolerance"),
        step_size: context.float(at, "stepSize"),
        line: Line(at.element.line),
    }
}
