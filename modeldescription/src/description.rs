//! The model description: what an FMU says about itself.
//!
//! One structure holds FMI 2.0 and FMI 3.0. Where both have the same thing under two names, the
//! name of 3.0 is used: `guid` is `instantiation_token`, `Real` is `Float64`, `Integer` is `Int32`.

use crate::names::named;
use crate::structure::ModelStructure;
use crate::variable::{Properties, Variable};
pub use crate::version::FmiVersion;
pub use crate::xml::Line;

named! {
    /// How variable names are built.
    NamingConvention {
        /// Any text.
        Flat = "flat",
        /// A hierarchy: `axis[1].mode.frequency`.
        Structured = "structured",
    }
}

/// The content of `modelDescription.xml`.
///
/// Vendor annotations are not kept: they belong to the tool that wrote them.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelDescription {
    /// Version of the standard.
    pub fmi_version: FmiVersion,
    /// The draft of the standard that it was written for, as in `3.0-beta.2`; none: the standard.
    pub draft: Option<String>,
    /// Name of the model in the tool that made it.
    pub model_name: String,
    /// `guid` (2.0) or `instantiationToken` (3.0).
    pub instantiation_token: String,
    /// One sentence about the model.
    pub description: Option<String>,
    /// Author of the model.
    pub author: Option<String>,
    /// Version of the model.
    pub version: Option<String>,
    /// Copyright notice.
    pub copyright: Option<String>,
    /// Licence of the model.
    pub license: Option<String>,
    /// Tool that wrote the file.
    pub generation_tool: Option<String>,
    /// `YYYY-MM-DDThh:mm:ssZ`, see [`crate::generation_time`].
    pub generation_date_and_time: Option<String>,
    /// How variable names are built.
    pub variable_naming_convention: NamingConvention,
    /// Number of event indicators (2.0, model exchange).
    pub number_of_event_indicators: Option<u32>,
    /// Present if the FMU offers model exchange.
    pub model_exchange: Option<ModelExchange>,
    /// Present if the FMU offers co-simulation.
    pub co_simulation: Option<CoSimulation>,
    /// Present if the FMU offers scheduled execution (3.0).
    pub scheduled_execution: Option<Interface>,
    /// Units that variables refer to.
    pub units: Vec<Unit>,
    /// Types that variables refer to.
    pub types: Vec<TypeDefinition>,
    /// Categories of log messages.
    pub log_categories: Vec<LogCategory>,
    /// Settings of a run that suit the model.
    pub default_experiment: Option<DefaultExperiment>,
    /// The variables, in the file's order.
    pub variables: Vec<Variable>,
    /// Outputs, derivatives, initial unknowns and what they depend on.
    pub structure: ModelStructure,
    /// Where the root element stands.
    pub line: Line,
}

impl ModelDescription {
    /// An otherwise empty description.
    pub fn new(
        fmi_version: FmiVersion,
        model_name: impl Into<String>,
        instantiation_token: impl Into<String>,
    ) -> Self {
        ModelDescription {
            fmi_version,
            draft: None,
            model_name: model_name.into(),
            instantiation_token: instantiation_token.into(),
            description: None,
            author: None,
            version: None,
            copyright: None,
            license: None,
            generation_tool: None,
            generation_date_and_time: None,
            variable_naming_convention: NamingConvention::Structured,
            number_of_event_indicators: None,
            model_exchange: None,
            co_simulation: None,
            scheduled_execution: None,
            units: Vec::new(),
            types: Vec::new(),
            log_categories: Vec::new(),
            default_experiment: None,
            variables: Vec::new(),
            structure: ModelStructure::default(),
            line: Line(0),
        }
    }

    /// The variable of this name (aliases of 3.0 included).
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables
            .iter()
            .find(|v| v.name == name || v.aliases.iter().any(|alias| alias.name == name))
    }

    /// The variable that a reference of [`ModelStructure`], `derivative` or a dependency means:
    /// its position counted from 1 in FMI 2.0, its value reference in FMI 3.0.
    pub fn referenced(&self, reference: u32) -> Option<&Variable> {
        match self.fmi_version {
            FmiVersion::V2 => self.variables.get((reference as usize).checked_sub(1)?),
            FmiVersion::V3 => self.variables.iter().find(|v| v.value_reference == reference),
        }
    }

    /// How [`ModelStructure`], `derivative` and dependencies refer to the variable at `position`
    /// (counted from 0) of [`ModelDescription::variables`].
    pub fn reference_to(&self, position: usize) -> Option<u32> {
        let variable = self.variables.get(position)?;
        match self.fmi_version {
            FmiVersion::V2 => u32::try_from(position + 1).ok(),
            FmiVersion::V3 => Some(variable.value_reference),
        }
    }

    /// The type a variable declares, if it is defined.
    pub fn declared_type(&self, variable: &Variable) -> Option<&TypeDefinition> {
        let name = variable.declared_type.as_deref()?;
        self.types.iter().find(|definition| definition.name == name)
    }

    /// Unit, min, max, … of a variable: its own, else those of its declared type.
    pub fn properties(&self, variable: &Variable) -> Properties {
        match self.declared_type(variable) {
            Some(definition) => variable.properties.or(&definition.properties),
            None => variable.properties.clone(),
        }
    }

    /// The unit of this name.
    pub fn unit(&self, name: &str) -> Option<&Unit> {
        self.units.iter().find(|unit| unit.name == name)
    }

    /// The interface types the FMU offers, with the names of their elements.
    pub fn interfaces(&self) -> impl Iterator<Item = (&'static str, &Interface)> {
        let model_exchange = self.model_exchange.as_ref().map(|me| ("ModelExchange", &me.common));
        let co_simulation = self.co_simulation.as_ref().map(|cs| ("CoSimulation", &cs.common));
        let scheduled = self.scheduled_execution.as_ref().map(|se| ("ScheduledExecution", se));
        [model_exchange, co_simulation, scheduled].into_iter().flatten()
    }
}

/// What all interface types declare; the flags are false unless given.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Interface {
    /// Name of the shared library, a C identifier.
    pub model_identifier: String,
    /// A tool must be installed to run the FMU.
    pub needs_execution_tool: bool,
    /// At most one instance per process.
    pub can_be_instantiated_only_once_per_process: bool,
    /// The FMU does not use the importer's memory callbacks (2.0).
    pub can_not_use_memory_management_functions: bool,
    /// The FMU state can be read and restored.
    pub can_get_and_set_fmu_state: bool,
    /// The FMU state can be turned into bytes.
    pub can_serialize_fmu_state: bool,
    /// Directional derivatives are offered.
    pub provides_directional_derivatives: bool,
    /// Adjoint derivatives are offered (3.0).
    pub provides_adjoint_derivatives: bool,
    /// Dependencies of single array elements can be asked for (3.0).
    pub provides_per_element_dependencies: bool,
    /// C sources to compile (2.0).
    pub source_files: Vec<String>,
    /// Where the element stands.
    pub line: Line,
}

impl Interface {
    /// An interface whose shared library has this name, with no optional capability.
    pub fn new(model_identifier: impl Into<String>) -> Self {
        Interface { model_identifier: model_identifier.into(), ..Interface::default() }
    }
}

/// `<ModelExchange>`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModelExchange {
    /// What all interface types declare.
    pub common: Interface,
    /// `fmi?CompletedIntegratorStep` must be called (2.0: `completedIntegratorStepNotNeeded` negated).
    pub needs_completed_integrator_step: bool,
    /// `fmi3EvaluateDiscreteStates` is offered (3.0).
    pub provides_evaluate_discrete_states: bool,
}

/// `<CoSimulation>`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CoSimulation {
    /// What all interface types declare.
    pub common: Interface,
    /// The communication step may change from step to step.
    pub can_handle_variable_communication_step_size: bool,
    /// Inputs may be given with derivatives (2.0).
    pub can_interpolate_inputs: bool,
    /// `fmi2DoStep` may return before the step is done (2.0, `canRunAsynchronuously`).
    pub can_run_asynchronously: bool,
    /// Highest derivative of outputs that can be asked for.
    pub max_output_derivative_order: u32,
    /// Internal step in s, if it is fixed (3.0).
    pub fixed_internal_step_size: Option<f64>,
    /// Smoothness of inputs the FMU's solver likes (3.0).
    pub recommended_intermediate_input_smoothness: i32,
    /// Intermediate update is offered (3.0).
    pub provides_intermediate_update: bool,
    /// `fmi3DoStep` may return early (3.0).
    pub might_return_early_from_do_step: bool,
    /// The importer may ask for an early return (3.0).
    pub can_return_early_after_intermediate_update: bool,
    /// Event mode is offered (3.0).
    pub has_event_mode: bool,
    /// `fmi3EvaluateDiscreteStates` is offered (3.0).
    pub provides_evaluate_discrete_states: bool,
}

impl CoSimulation {
    /// Co-simulation by the shared library of this name, with no optional capability.
    pub fn new(model_identifier: impl Into<String>) -> Self {
        CoSimulation { common: Interface::new(model_identifier), ..CoSimulation::default() }
    }
}

/// A unit: its name and, if known, what it is in SI base units.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Name that variables refer to, such as `um` or `N.m`.
    pub name: String,
    /// The unit in SI base units.
    pub base: Option<BaseUnit>,
    /// Units the values may be shown in.
    pub display_units: Vec<DisplayUnit>,
    /// Where the element stands.
    pub line: Line,
}

/// A unit in SI base units: `value_SI = factor · value + offset`, exponents of the base units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseUnit {
    /// Exponent of the kilogram.
    pub kg: i32,
    /// Exponent of the metre.
    pub m: i32,
    /// Exponent of the second.
    pub s: i32,
    /// Exponent of the ampere.
    pub a: i32,
    /// Exponent of the kelvin.
    pub k: i32,
    /// Exponent of the mole.
    pub mol: i32,
    /// Exponent of the candela.
    pub cd: i32,
    /// Exponent of the radian.
    pub rad: i32,
    /// Factor to SI.
    pub factor: f64,
    /// Offset to SI.
    pub offset: f64,
}

impl Default for BaseUnit {
    fn default() -> Self {
        BaseUnit { kg: 0, m: 0, s: 0, a: 0, k: 0, mol: 0, cd: 0, rad: 0, factor: 1.0, offset: 0.0 }
    }
}

impl BaseUnit {
    /// Exponents of kg, m, s, A, K, mol, cd, rad, in the standard's order.
    pub fn exponents(&self) -> [(&'static str, i32); 8] {
        [
            ("kg", self.kg),
            ("m", self.m),
            ("s", self.s),
            ("A", self.a),
            ("K", self.k),
            ("mol", self.mol),
            ("cd", self.cd),
            ("rad", self.rad),
        ]
    }
}

/// A unit for display: `value_display = factor · value + offset`, or `factor / value`.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayUnit {
    /// Name that variables refer to.
    pub name: String,
    /// Factor from the unit.
    pub factor: f64,
    /// Offset from the unit.
    pub offset: f64,
    /// The display value is `factor / value` (3.0).
    pub inverse: bool,
    /// Where the element stands.
    pub line: Line,
}

/// A type that variables may declare.
#[derive(Debug, Clone, PartialEq)]
pub struct TypeDefinition {
    /// Name that variables refer to.
    pub name: String,
    /// One sentence about the type.
    pub description: Option<String>,
    /// Kind of values.
    pub data_type: crate::variable::DataType,
    /// Defaults of the variables of this type.
    pub properties: Properties,
    /// Items of an enumeration.
    pub items: Vec<EnumerationItem>,
    /// Where the element stands.
    pub line: Line,
}

/// One value of an enumeration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EnumerationItem {
    /// Name of the value.
    pub name: String,
    /// The number that stands for it.
    pub value: i64,
    /// One sentence about it.
    pub description: Option<String>,
}

/// A category of log messages that can be switched on.
#[derive(Debug, Clone, PartialEq)]
pub struct LogCategory {
    /// Name of the category.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// Where the element stands.
    pub line: Line,
}

/// Settings of a run that suit the model; times in the unit of the independent variable (s).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DefaultExperiment {
    /// Start of the run in s.
    pub start_time: Option<f64>,
    /// End of the run in s.
    pub stop_time: Option<f64>,
    /// Relative tolerance.
    pub tolerance: Option<f64>,
    /// Communication step in s.
    pub step_size: Option<f64>,
    /// Where the element stands.
    pub line: Line,
}
