//! Reads the interface types: model exchange, co-simulation, scheduled execution.

use super::values::{Attributes, Context};
use crate::description::{CoSimulation, FmiVersion, Interface, Line, ModelExchange};

const COMMON_2: [&str; 7] = [
    "modelIdentifier",
    "needsExecutionTool",
    "canBeInstantiatedOnlyOncePerProcess",
    "canNotUseMemoryManagementFunctions",
    "canGetAndSetFMUstate",
    "canSerializeFMUstate",
    "providesDirectionalDerivative",
];

const COMMON_3: [&str; 8] = [
    "modelIdentifier",
    "needsExecutionTool",
    "canBeInstantiatedOnlyOncePerProcess",
    "canGetAndSetFMUState",
    "canSerializeFMUState",
    "providesDirectionalDerivatives",
    "providesAdjointDerivatives",
    "providesPerElementDependencies",
];

fn interface(context: &mut Context, at: Attributes<'_>, own: &[&str]) -> Interface {
    let (attributes, children): (&[&str], &[&str]) = match context.version {
        FmiVersion::V2 => (&COMMON_2, &["SourceFiles"]),
        FmiVersion::V3 => (&COMMON_3, &["Annotations"]),
    };
    context.expect(at, &[attributes, own].concat(), children);
    let mut read = Interface::new(context.required_text(at, "modelIdentifier"));
    read.line = Line(at.element.line);
    read.needs_execution_tool = context.flag(at, "needsExecutionTool");
    read.can_be_instantiated_only_once_per_process =
        context.flag(at, "canBeInstantiatedOnlyOncePerProcess");
    match context.version {
        FmiVersion::V2 => {
            read.can_not_use_memory_management_functions =
                context.flag(at, "canNotUseMemoryManagementFunctions");
            read.can_get_and_set_fmu_state = context.flag(at, "canGetAndSetFMUstate");
            read.can_serialize_fmu_state = context.flag(at, "canSerializeFMUstate");
            read.provides_directional_derivatives =
                context.flag(at, "providesDirectionalDerivative");
            read.source_files = source_files(context, at);
        }
        FmiVersion::V3 => {
            read.can_get_and_set_fmu_state = context.flag(at, "canGetAndSetFMUState");
            read.can_serialize_fmu_state = context.flag(at, "canSerializeFMUState");
            read.provides_directional_derivatives =
                context.flag(at, "providesDirectionalDerivatives");
            read.provides_adjoint_derivatives = context.flag(at, "providesAdjointDerivatives");
            read.provides_per_element_dependencies =
                context.flag(at, "providesPerElementDependencies");
        }
    }
    read
}

fn source_files(context: &mut Context, at: Attributes<'_>) -> Vec<String> {
    let Some(list) = at.element.child("SourceFiles") else { return Vec::new() };
    let at = Attributes { element: list, topic: at.topic };
    context.expect(at, &[], &["File*"]);
    context.expect_some(at);
    let mut files = Vec::new();
    for file in list.children.iter().filter(|child| child.name == "File") {
        let at = Attributes { element: file, topic: at.topic };
        context.expect(at, &["name"], &[]);
        files.push(context.required_text(at, "name"));
    }
    files
}

pub(super) fn model_exchange(context: &mut Context, at: Attributes<'_>) -> ModelExchange {
    match context.version {
        FmiVersion::V2 => ModelExchange {
            common: interface(context, at, &["completedIntegratorStepNotNeeded"]),
            needs_completed_integrator_step: !context.flag(at, "completedIntegratorStepNotNeeded"),
            provides_evaluate_discrete_states: false,
        },
        FmiVersion::V3 => ModelExchange {
            common: interface(
                context,
                at,
                &["needsCompletedIntegratorStep", "providesEvaluateDiscreteStates"],
            ),
            needs_completed_integrator_step: context.flag(at, "needsCompletedIntegratorStep"),
            provides_evaluate_discrete_states: context.flag(at, "providesEvaluateDiscreteStates"),
        },
    }
}

pub(super) fn scheduled_execution(context: &mut Context, at: Attributes<'_>) -> Interface {
    interface(context, at, &[])
}

const CO_SIMULATION_2: [&str; 4] = [
    "canHandleVariableCommunicationStepSize",
    "canInterpolateInputs",
    "maxOutputDerivativeOrder",
    // The spelling of the standard.
    "canRunAsynchronuously",
];

const CO_SIMULATION_3: [&str; 9] = [
    "canHandleVariableCommunicationStepSize",
    "fixedInternalStepSize",
    "maxOutputDerivativeOrder",
    "recommendedIntermediateInputSmoothness",
    "providesIntermediateUpdate",
    "mightReturnEarlyFromDoStep",
    "canReturnEarlyAfterIntermediateUpdate",
    "hasEventMode",
    "providesEvaluateDiscreteStates",
];

pub(super) fn co_simulation(context: &mut Context, at: Attributes<'_>) -> CoSimulation {
    let own: &[&str] = match context.version {
        FmiVersion::V2 => &CO_SIMULATION_2,
        FmiVersion::V3 => &CO_SIMULATION_3,
    };
    let mut read = CoSimulation {
        common: interface(context, at, own),
        can_handle_variable_communication_step_size: context
            .flag(at, "canHandleVariableCommunicationStepSize"),
        max_output_derivative_order: context
            .integer(at, "maxOutputDerivativeOrder")
            .unwrap_or_default(),
        ..CoSimulation::default()
    };
    match context.version {
        FmiVersion::V2 => {
            read.can_interpolate_inputs = context.flag(at, "canInterpolateInputs");
            read.can_run_asynchronously = context.flag(at, "canRunAsynchronuously");
        }
        FmiVersion::V3 => {
            read.fixed_internal_step_size = context.float(at, "fixedInternalStepSize");
            read.recommended_intermediate_input_smoothness =
                context.integer(at, "recommendedIntermediateInputSmoothness").unwrap_or_default();
            read.provides_intermediate_update = context.flag(at, "providesIntermediateUpdate");
            read.might_return_early_from_do_step = context.flag(at, "mightReturnEarlyFromDoStep");
            read.can_return_early_after_intermediate_update =
                context.flag(at, "canReturnEarlyAfterIntermediateUpdate");
            read.has_event_mode = context.flag(at, "hasEventMode");
            read.provides_evaluate_discrete_states =
                context.flag(at, "providesEvaluateDiscreteStates");
        }
    }
    read
}
