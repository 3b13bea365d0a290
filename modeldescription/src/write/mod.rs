//! Writes `modelDescription.xml`.
//!
//! Attributes that equal the schema's default are left out; floats are written with as many digits
//! as it takes to read the same value back.

mod text;
mod variables;

use crate::description::{
    CoSimulation, FmiVersion, Interface, ModelDescription, ModelExchange, NamingConvention, Unit,
};
use crate::structure::{DependencyKind, Unknown};
use text::{Text, float, integers};

/// Why a description cannot be written.
#[derive(Debug, thiserror::Error, Clone, PartialEq, Eq)]
pub enum WriteError {
    /// XML 1.0 has no such character.
    #[error(
        "{element}: {attribute} contains the character U+{character:04X}, which XML cannot hold; remove it"
    )]
    Character {
        /// Element that would be written.
        element: String,
        /// Attribute that would be written.
        attribute: String,
        /// The character's number.
        character: u32,
    },
    /// FMI 2.0 has no such thing.
    #[error("\"{name}\" has {what}, which FMI 2.0 does not have; write FMI 3.0, or {way_out}")]
    NotInVersion2 {
        /// Name of the variable or type.
        name: String,
        /// What the name has.
        what: String,
        /// What to do instead.
        way_out: &'static str,
    },
    /// `SOURCE_DATE_EPOCH` is no time.
    #[error(
        "SOURCE_DATE_EPOCH=\"{value}\"; it must be the number of seconds since 1970-01-01; correct or unset it"
    )]
    SourceDateEpoch {
        /// The value of the environment variable.
        value: String,
    },
}

impl ModelDescription {
    /// The description as `modelDescription.xml`, in the element and attribute order of the schema.
    ///
    /// # Errors
    /// If a text holds a character that XML cannot hold, or the description is of FMI 2.0 and has
    /// something that only FMI 3.0 has.
    pub fn to_xml(&self) -> Result<String, WriteError> {
        let mut xml = Text::new();
        xml.open("fmiModelDescription");
        root_attributes(&mut xml, self);
        if let Some(model_exchange) = &self.model_exchange {
            write_model_exchange(&mut xml, self.fmi_version, model_exchange);
        }
        if let Some(co_simulation) = &self.co_simulation {
            write_co_simulation(&mut xml, self.fmi_version, co_simulation);
        }
        if let (FmiVersion::V3, Some(interface)) = (self.fmi_version, &self.scheduled_execution) {
            xml.open("ScheduledExecution");
            interface_attributes(&mut xml, self.fmi_version, interface);
            xml.close();
        }
        list(&mut xml, "UnitDefinitions", &self.units, |xml, unit| {
            write_unit(xml, self.fmi_version, unit);
        });
        variables::types(&mut xml, self)?;
        list(&mut xml, "LogCategories", &self.log_categories, |xml, category| {
            xml.open("Category");
            xml.attribute("name", &category.name);
            xml.optional("description", category.description.as_deref());
            xml.close();
        });
        write_default_experiment(&mut xml, self);
        variables::variables(&mut xml, self)?;
        write_structure(&mut xml, self);
        xml.close();
        xml.finish()
    }
}

/// A list element with one child per item; an empty list is not written.
fn list<T>(xml: &mut Text, name: &'static str, items: &[T], write: impl Fn(&mut Text, &T)) {
    if items.is_empty() {
        return;
    }
    xml.open(name);
    for item in items {
        write(xml, item);
    }
    xml.close();
}

fn root_attributes(xml: &mut Text, description: &ModelDescription) {
    let version = description.draft.as_deref().unwrap_or(description.fmi_version.text());
    xml.attribute("fmiVersion", version);
    xml.attribute("modelName", &description.model_name);
    let token = match description.fmi_version {
        FmiVersion::V2 => "guid",
        FmiVersion::V3 => "instantiationToken",
    };
    xml.attribute(token, &description.instantiation_token);
    xml.optional("description", description.description.as_deref());
    xml.optional("author", description.author.as_deref());
    xml.optional("version", description.version.as_deref());
    xml.optional("copyright", description.copyright.as_deref());
    xml.optional("license", description.license.as_deref());
    xml.optional("generationTool", description.generation_tool.as_deref());
    xml.optional("generationDateAndTime", description.generation_date_and_time.as_deref());
    if description.variable_naming_convention != NamingConvention::Flat {
        xml.attribute("variableNamingConvention", description.variable_naming_convention.name());
    }
    if description.fmi_version == FmiVersion::V2 {
        xml.optional_display("numberOfEventIndicators", description.number_of_event_indicators);
    }
}

fn interface_attributes(xml: &mut Text, version: FmiVersion, interface: &Interface) {
    xml.attribute("modelIdentifier", &interface.model_identifier);
    xml.flag("needsExecutionTool", interface.needs_execution_tool);
    xml.flag(
        "canBeInstantiatedOnlyOncePerProcess",
        interface.can_be_instantiated_only_once_per_process,
    );
    match version {
        FmiVersion::V2 => {
            xml.flag(
                "canNotUseMemoryManagementFunctions",
                interface.can_not_use_memory_management_functions,
            );
            xml.flag("canGetAndSetFMUstate", interface.can_get_and_set_fmu_state);
            xml.flag("canSerializeFMUstate", interface.can_serialize_fmu_state);
            xml.flag("providesDirectionalDerivative", interface.provides_directional_derivatives);
        }
        FmiVersion::V3 => {
            xml.flag("canGetAndSetFMUState", interface.can_get_and_set_fmu_state);
            xml.flag("canSerializeFMUState", interface.can_serialize_fmu_state);
            xml.flag("providesDirectionalDerivatives", interface.provides_directional_derivatives);
            xml.flag("providesAdjointDerivatives", interface.provides_adjoint_derivatives);
            xml.flag("providesPerElementDependencies", interface.provides_per_element_dependencies);
        }
    }
}

fn source_files(xml: &mut Text, version: FmiVersion, interface: &Interface) {
    if version == FmiVersion::V2 {
        list(xml, "SourceFiles", &interface.source_files, |xml, file| {
            xml.open("File");
            xml.attribute("name", file);
            xml.close();
        });
    }
}

fn write_model_exchange(xml: &mut Text, version: FmiVersion, model_exchange: &ModelExchange) {
    xml.open("ModelExchange");
    interface_attributes(xml, version, &model_exchange.common);
    match version {
        FmiVersion::V2 => xml.flag(
            "completedIntegratorStepNotNeeded",
            !model_exchange.needs_completed_integrator_step,
        ),
        FmiVersion::V3 => {
            xml.flag(
                "needsCompletedIntegratorStep",
                model_exchange.needs_completed_integrator_step,
            );
            xml.flag(
                "providesEvaluateDiscreteStates",
                model_exchange.provides_evaluate_discrete_states,
            );
        }
    }
    source_files(xml, version, &model_exchange.common);
    xml.close();
}

fn write_co_simulation(xml: &mut Text, version: FmiVersion, cs: &CoSimulation) {
    xml.open("CoSimulation");
    interface_attributes(xml, version, &cs.common);
    xml.flag(
        "canHandleVariableCommunicationStepSize",
        cs.can_handle_variable_communication_step_size,
    );
    if cs.max_output_derivative_order > 0 {
        xml.attribute("maxOutputDerivativeOrder", &cs.max_output_derivative_order.to_string());
    }
    match version {
        FmiVersion::V2 => {
            xml.flag("canInterpolateInputs", cs.can_interpolate_inputs);
            // The spelling of the standard.
            xml.flag("canRunAsynchronuously", cs.can_run_asynchronously);
        }
        FmiVersion::V3 => co_simulation_3(xml, cs),
    }
    source_files(xml, version, &cs.common);
    xml.close();
}

fn co_simulation_3(xml: &mut Text, cs: &CoSimulation) {
    xml.optional_float("fixedInternalStepSize", cs.fixed_internal_step_size);
    if cs.recommended_intermediate_input_smoothness != 0 {
        xml.attribute(
            "recommendedIntermediateInputSmoothness",
            &cs.recommended_intermediate_input_smoothness.to_string(),
        );
    }
    xml.flag("providesIntermediateUpdate", cs.provides_intermediate_update);
    xml.flag("mightReturnEarlyFromDoStep", cs.might_return_early_from_do_step);
    xml.flag(
        "canReturnEarlyAfterIntermediateUpdate",
        cs.can_return_early_after_intermediate_update,
    );
    xml.flag("hasEventMode", cs.has_event_mode);
    xml.flag("providesEvaluateDiscreteStates", cs.provides_evaluate_discrete_states);
}

fn write_unit(xml: &mut Text, version: FmiVersion, unit: &Unit) {
    xml.open("Unit");
    xml.attribute("name", &unit.name);
    if let Some(base) = &unit.base {
        xml.open("BaseUnit");
        for (name, exponent) in base.exponents() {
            if exponent != 0 {
                xml.attribute(name, &exponent.to_string());
            }
        }
        factor_and_offset(xml, base.factor, base.offset);
        xml.close();
    }
    for display_unit in &unit.display_units {
        xml.open("DisplayUnit");
        xml.attribute("name", &display_unit.name);
        factor_and_offset(xml, display_unit.factor, display_unit.offset);
        if version == FmiVersion::V3 {
            xml.flag("inverse", display_unit.inverse);
        }
        xml.close();
    }
    xml.close();
}

fn factor_and_offset(xml: &mut Text, factor: f64, offset: f64) {
    if factor != 1.0 {
        xml.attribute("factor", &float(factor));
    }
    if offset != 0.0 {
        xml.attribute("offset", &float(offset));
    }
}

fn write_default_experiment(xml: &mut Text, description: &ModelDescription) {
    if let Some(experiment) = &description.default_experiment {
        xml.open("DefaultExperiment");
        xml.optional_float("startTime", experiment.start_time);
        xml.optional_float("stopTime", experiment.stop_time);
        xml.optional_float("tolerance", experiment.tolerance);
        xml.optional_float("stepSize", experiment.step_size);
        xml.close();
    }
}

fn write_structure(xml: &mut Text, description: &ModelDescription) {
    let structure = &description.structure;
    xml.open("ModelStructure");
    match description.fmi_version {
        FmiVersion::V2 => {
            let unknown = |xml: &mut Text, item: &Unknown| write_unknown(xml, "Unknown", item, 2);
            list(xml, "Outputs", &structure.outputs, unknown);
            list(xml, "Derivatives", &structure.derivatives, unknown);
            list(xml, "InitialUnknowns", &structure.initial_unknowns, unknown);
        }
        FmiVersion::V3 => {
            let lists = [
                ("Output", &structure.outputs),
                ("ContinuousStateDerivative", &structure.derivatives),
                ("ClockedState", &structure.clocked_states),
                ("InitialUnknown", &structure.initial_unknowns),
                ("EventIndicator", &structure.event_indicators),
            ];
            for (element, unknowns) in lists {
                for item in unknowns {
                    write_unknown(xml, element, item, 3);
                }
            }
        }
    }
    xml.close();
}

fn write_unknown(xml: &mut Text, element: &'static str, unknown: &Unknown, version: u8) {
    xml.open(element);
    let reference = if version == 2 { "index" } else { "valueReference" };
    xml.attribute(reference, &unknown.variable.to_string());
    xml.optional("dependencies", unknown.dependencies.as_deref().map(integers).as_deref());
    let kinds = unknown.dependency_kinds.as_deref().map(kinds);
    xml.optional("dependenciesKind", kinds.as_deref());
    xml.close();
}

fn kinds(kinds: &[DependencyKind]) -> String {
    kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(" ")
}
