//! A plan from the file of the Open Simulation Platform, `OspSystemStructure.xml`, as libcosim reads it.
//!
//! ```xml
//! <OspSystemStructure xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure" version="0.1">
//!   <StartTime>0.0</StartTime>
//!   <BaseStepSize>1e-3</BaseStepSize>
//!   <Simulators>
//!     <Simulator name="plant" source="plant.fmu" stepSize="1e-3">
//!       <InitialValues><InitialValue variable="k"><Real value="2"/></InitialValue></InitialValues>
//!     </Simulator>
//!   </Simulators>
//!   <Functions><LinearTransformation name="scale" factor="2" offset="0"/></Functions>
//!   <Connections>
//!     <VariableConnection>
//!       <Variable simulator="plant" name="y"/><Variable simulator="controller" name="measured"/>
//!     </VariableConnection>
//!   </Connections>
//! </OspSystemStructure>
//! ```
//!
//! All slaves exchange values side by side (Jacobi), as libcosim's fixed-step algorithm does.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use data::{Problem, Problems};
use modeldescription::ssp::ParameterValue;
use modeldescription::xml::{self, Element, XmlLimits};
use percent_encoding::percent_decode_str;

use super::{Coupling, Master, Plan, PlannedConnection, PlannedFmu, PlannedStart};
use crate::error::Error;
use crate::port::Port;
use crate::unit::Transformations;

/// Names that a message lists.
const MOST_NAMED: usize = 20;
/// Name of the file.
pub(super) const FILE: &str = "OspSystemStructure.xml";

impl Plan {
    pub(super) fn read_osp(path: &Path) -> Result<Self, Error> {
        let refused = |reason: String| Error::Package { path: path.to_path_buf(), reason };
        let text = files::read_text(path)
            .map_err(|error| refused(format!("it cannot be read: {error}")))?;
        Self::parse_osp(&text, path)
    }

    /// Reads the text of an `OspSystemStructure.xml`; `path` is its file, from which paths start.
    ///
    /// # Errors
    /// Everything that is wrong in it, with its lines.
    pub fn parse_osp(text: &str, path: &Path) -> Result<Self, Error> {
        let refused = |reason: String| Error::Package { path: path.to_path_buf(), reason };
        let document = xml::parse(text.as_bytes(), &XmlLimits::default())
            .map_err(|error| refused(error.to_string()))?;
        let (file, texts) = (path.display().to_string(), document.texts);
        let mut reader = Reader { file, texts, simulators: BTreeSet::new(), problems: Vec::new() };
        let plan = reader.plan(&document.root, path);
        if reader.problems.is_empty() {
            return Ok(plan);
        }
        Err(Error::File(Problems::new(reader.problems)))
    }
}

/// The name without its namespace prefix.
fn local(element: &Element) -> &str {
    element.name.rsplit_once(':').map_or(element.name.as_str(), |(_, local)| local)
}

fn children<'e>(element: &'e Element, name: &'static str) -> impl Iterator<Item = &'e Element> {
    element.children.iter().filter(move |child| local(child) == name)
}

fn listed<'e>(root: &'e Element, list: &'static str) -> impl Iterator<Item = &'e Element> {
    children(root, list).flat_map(|list| &list.children)
}

/// One end of a connection.
enum End {
    Variable(Port),
    /// Of a function: its name and that of the signal.
    Signal(String, String),
}

struct Reader {
    file: String,
    texts: Vec<(usize, String)>,
    /// Names of the simulators.
    simulators: BTreeSet<String>,
    problems: Vec<Problem>,
}

impl Reader {
    fn report(&mut self, element: &Element, rule: impl Into<String>, way_out: &str) {
        let problem = Problem::new(&self.file, rule, way_out).line(element.line as usize);
        self.problems.push(problem.at(format!("<{}>", element.name)));
    }

    fn place(&self, element: &Element) -> String {
        format!("{}:{}", self.file, element.line)
    }

    fn required(&mut self, element: &Element, name: &str) -> String {
        let found = element.attribute(name).unwrap_or_default();
        if found.is_empty() {
            self.report(element, format!("has no attribute {name}"), "add it");
        }
        found.to_owned()
    }

    fn number(&mut self, element: &Element, text: &str) -> Option<f64> {
        let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
        if number.is_none() {
            self.report(element, format!("\"{text}\" is no finite number"), "correct it");
        }
        number
    }

    /// A step; none where it is left to the FMU or its base step, which is written as 0.
    fn step(&mut self, element: &Element, text: &str) -> Option<f64> {
        let step = self.number(element, text)?;
        if step < 0.0 {
            let rule = format!("a step of {step} s cannot be made");
            self.report(element, rule, "give a positive one, or 0 for the FMU's own");
        }
        (step > 0.0).then_some(step)
    }

    fn plan(&mut self, root: &Element, path: &Path) -> Plan {
        if local(root) != "OspSystemStructure" {
            let way_out = "give an OspSystemStructure.xml, an SSP or a TOML";
            self.report(root, "is not <OspSystemStructure>", way_out);
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let mut plan = Plan {
            name: root.attribute("name").map(str::to_owned).or(stem).unwrap_or_default(),
            origin: path.to_path_buf(),
            fmus: Vec::new(),
            connections: Vec::new(),
            inputs: Vec::new(),
            starts: Vec::new(),
            record: Vec::new(),
            master: Master { coupling: Coupling::Jacobi, ..Master::default() },
            notes: Vec::new(),
            undirected: true,
            names: Default::default(),
            _ssp: None,
        };
        for (number, element) in root.children.iter().enumerate() {
            let found = self.texts.iter().find(|(of, _)| *of == number);
            let content = found.map(|(_, text)| text.clone()).unwrap_or_default();
            let text = |this: &mut Self| this.number(element, &content);
            match local(element) {
                "StartTime" => plan.master.start = text(self),
                "EndTime" | "StopTime" => plan.master.stop = text(self),
                "BaseStepSize" => plan.master.step = self.step(element, &content),
                "Simulators" | "Functions" | "Connections" => {}
                "Algorithm" if content == "fixedStep" => {}
                _ => plan.notes.push(format!(
                    "{}:{}: <{}> is ignored{}",
                    self.file,
                    element.line,
                    element.name,
                    if content.is_empty() { String::new() } else { format!(" ({content})") }
                )),
            }
        }
        for simulator in listed(root, "Simulators") {
            self.simulator(&mut plan, folder, simulator);
        }
        self.connections(&mut plan, root);
        if plan.fmus.is_empty() {
            self.report(root, "has no <Simulator>", "a system has FMUs: add them");
        }
        plan
    }

    fn simulator(&mut self, plan: &mut Plan, folder: &Path, element: &Element) {
        let name = self.required(element, "name");
        if !self.simulators.insert(name.clone()) {
            self.report(element, format!("two are called \"{name}\""), "rename one of them");
        }
        let source = self.required(element, "source");
        let path = match source_path(folder, &source) {
            Ok(path) => path,
            Err(rule) => return self.report(element, rule, "write a path to an FMU's file"),
        };
        let stated = element.attribute("stepSize").filter(|text| !text.is_empty());
        let step = stated.and_then(|text| self.step(element, text));
        let place = self.place(element);
        plan.fmus.push(PlannedFmu { name: name.clone(), path, place, step });
        for value in listed(element, "InitialValues") {
            let variable = self.required(value, "variable");
            let Some(found) = value.children.first() else {
                self.report(value, "has no value", "write <Real value=\"…\"/>");
                continue;
            };
            let text = self.required(found, "value");
            let parsed = match local(found) {
                "Real" => self.number(found, &text).map(|x| ParameterValue::Real(vec![x])),
                "Integer" => text.trim().parse().ok().map(|x| ParameterValue::Integer(vec![x])),
                "Boolean" => match text.trim() {
                    "true" | "1" => Some(ParameterValue::Boolean(vec![true])),
                    "false" | "0" => Some(ParameterValue::Boolean(vec![false])),
                    _ => None,
                },
                "String" => Some(ParameterValue::Text(vec![text.clone()])),
                _ => None,
            };
            let Some(parsed) = parsed else {
                let rule = format!("\"{text}\" is no value of its type");
                self.report(found, rule, "types are Real, Integer, Boolean and String");
                continue;
            };
            plan.starts.push(PlannedStart {
                to: Port::from((name.as_str(), variable.as_str())),
                value: parsed,
                way: Transformations::default(),
                place: format!("{}:{}: initial value of {name}.{variable}", self.file, value.line),
                optional: false,
            });
        }
    }

    fn connections(&mut self, plan: &mut Plan, root: &Element) {
        let mut functions = HashMap::new();
        for function in listed(root, "Functions") {
            let name = self.required(function, "name");
            if local(function) != "LinearTransformation" {
                let way_out =
                    "of functions only LinearTransformation is carried out; let an FMU do it";
                self.report(function, "cannot be carried out", way_out);
                continue;
            }
            let mut number = |name: &str, default| {
                let text = function.attribute(name).filter(|text| !text.is_empty());
                text.map_or(Some(default), |text| self.number(function, text)).unwrap_or(default)
            };
            let scale = (number("factor", 1.0), number("offset", 0.0));
            if functions.insert(name.clone(), scale).is_some() {
                let rule = format!("two functions are called \"{name}\"");
                self.report(function, rule, "rename one of them");
            }
        }
        // What goes into a function and what comes out of it.
        let (mut into, mut out_of) = (HashMap::new(), Vec::new());
        for connection in listed(root, "Connections") {
            if !matches!(local(connection), "VariableConnection" | "SignalConnection") {
                let way_out =
                    "groups of variables are not resolved: connect the variables one by one";
                self.report(connection, "cannot be carried out", way_out);
                continue;
            }
            let ends: Vec<End> = connection.children.iter().map(|end| self.end(end)).collect();
            match <[End; 2]>::try_from(ends) {
                Ok([End::Variable(from), End::Variable(to)]) => {
                    let (way, place) = (Transformations::default(), self.place(connection));
                    plan.connections.push(PlannedConnection { from, to, way, place });
                }
                Ok([End::Signal(function, signal), End::Variable(port)])
                | Ok([End::Variable(port), End::Signal(function, signal)]) => {
                    if !functions.contains_key(&function) {
                        self.report(
                            connection,
                            format!("there is no function \"{function}\""),
                            "correct the name",
                        );
                    }
                    match signal.as_str() {
                        "in" => {
                            if into.contains_key(&function) {
                                self.report(
                                    connection,
                                    format!("two variables go into function \"{function}\""),
                                    "a LinearTransformation has one: take one away",
                                );
                            }
                            into.entry(function).or_insert(port);
                        }
                        "out" => out_of.push((function, port, connection)),
                        _ => self.report(
                            connection,
                            format!("there is no signal \"{signal}\""),
                            "a LinearTransformation has the signals in and out",
                        ),
                    }
                }
                Ok(_) => self.report(
                    connection,
                    "joins two functions",
                    "put both transformations into one",
                ),
                Err(ends) => self.report(
                    connection,
                    format!("has {} ends", ends.len()),
                    "a connection has two: <Variable> or <Signal>",
                ),
            }
        }
        for (function, to, connection) in out_of {
            let (Some((factor, offset)), Some(from)) =
                (functions.get(&function), into.get(&function))
            else {
                self.report(
                    connection,
                    format!("nothing is connected to an input of function \"{function}\""),
                    "connect its signal in",
                );
                continue;
            };
            let (from, way) = (from.clone(), Transformations::scaled(*factor, *offset, true));
            let place = self.place(connection);
            plan.connections.push(PlannedConnection { from, to, way, place });
        }
    }

    fn end(&mut self, element: &Element) -> End {
        if local(element) == "Signal" {
            return End::Signal(self.required(element, "function"), self.required(element, "name"));
        }
        let simulator = self.required(element, "simulator");
        if !simulator.is_empty() && !self.simulators.contains(&simulator) {
            let there = self.simulators.iter().take(MOST_NAMED).map(String::as_str);
            let there = there.collect::<Vec<_>>().join(", ");
            let more = match self.simulators.len().saturating_sub(MOST_NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let rule = format!("there is no simulator \"{simulator}\"; there are: {there}{more}");
            self.report(element, rule, "correct the name");
        }
        let name = self.required(element, "name");
        End::Variable(Port::from((simulator.as_str(), name.as_str())))
    }
}

/// The file that a source means: a path, or a URI of a file, relative to the folder.
fn source_path(folder: &Path, source: &str) -> Result<PathBuf, String> {
    let path = match source.split_once("://") {
        None => source.strip_prefix("file:").unwrap_or(source),
        Some(("file", path)) => path,
        Some((scheme, _)) => return Err(format!("{scheme}:// is not loaded; only files are")),
    };
    let decoded = percent_decode_str(path).decode_utf8().map_err(|error| error.to_string())?;
    if decoded.contains('\0') {
        return Err("the source holds a zero byte".to_owned());
    }
    Ok(folder.join(&*decoded))
}
