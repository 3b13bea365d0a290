//! Writes `<ModelVariables>` and `<TypeDefinitions>`.

use super::WriteError;
use super::text::{Text, float, integers};
use crate::description::{FmiVersion, ModelDescription, TypeDefinition};
use crate::variable::{
    Causality, ClockProperties, DataType, Dimension, Number, Properties, Start, Variable,
};

pub(super) fn types(xml: &mut Text, description: &ModelDescription) -> Result<(), WriteError> {
    if description.types.is_empty() {
        return Ok(());
    }
    xml.open("TypeDefinitions");
    for definition in &description.types {
        let element = element(description, &definition.name, definition.data_type)?;
        match description.fmi_version {
            FmiVersion::V2 => {
                xml.open("SimpleType");
                named(xml, definition);
                xml.open(element);
                // The schema of 2.0 has no min and max for enumeration types.
                let enumeration = definition.data_type == DataType::Enumeration;
                let bounds = !enumeration;
                properties(xml, &definition.properties, bounds);
                items(xml, definition);
                xml.close();
                xml.close();
            }
            FmiVersion::V3 => {
                xml.open(type_element(definition.data_type));
                named(xml, definition);
                properties(xml, &definition.properties, true);
                items(xml, definition);
                xml.close();
            }
        }
    }
    xml.close();
    Ok(())
}

fn named(xml: &mut Text, definition: &TypeDefinition) {
    xml.attribute("name", &definition.name);
    xml.optional("description", definition.description.as_deref());
}

fn items(xml: &mut Text, definition: &TypeDefinition) {
    for item in &definition.items {
        xml.open("Item");
        xml.attribute("name", &item.name);
        xml.attribute("value", &item.value.to_string());
        xml.optional("description", item.description.as_deref());
        xml.close();
    }
}

fn type_element(data_type: DataType) -> &'static str {
    match data_type {
        DataType::Float32 => "Float32Type",
        DataType::Float64 => "Float64Type",
        DataType::Int8 => "Int8Type",
        DataType::UInt8 => "UInt8Type",
        DataType::Int16 => "Int16Type",
        DataType::UInt16 => "UInt16Type",
        DataType::Int32 => "Int32Type",
        DataType::UInt32 => "UInt32Type",
        DataType::Int64 => "Int64Type",
        DataType::UInt64 => "UInt64Type",
        DataType::Boolean => "BooleanType",
        DataType::String => "StringType",
        DataType::Binary => "BinaryType",
        DataType::Enumeration => "EnumerationType",
        DataType::Clock => "ClockType",
    }
}

fn element(
    description: &ModelDescription,
    name: &str,
    data_type: DataType,
) -> Result<&'static str, WriteError> {
    data_type.element(description.fmi_version).ok_or_else(|| WriteError::NotInVersion2 {
        name: name.to_owned(),
        what: format!("the type {data_type}"),
        way_out: "use Float64, Int32, Boolean, String or Enumeration",
    })
}

pub(super) fn variables(xml: &mut Text, description: &ModelDescription) -> Result<(), WriteError> {
    xml.open("ModelVariables");
    for variable in &description.variables {
        match description.fmi_version {
            FmiVersion::V2 => variable_2(xml, description, variable)?,
            FmiVersion::V3 => variable_3(xml, variable),
        }
    }
    xml.close();
    Ok(())
}

fn variable_2(
    xml: &mut Text,
    description: &ModelDescription,
    variable: &Variable,
) -> Result<(), WriteError> {
    let not_in_version_2 = |what: &str, way_out| {
        Err(WriteError::NotInVersion2 {
            name: variable.name.clone(),
            what: what.to_owned(),
            way_out,
        })
    };
    if !variable.dimensions.is_empty() {
        return not_in_version_2("dimensions", "write one scalar variable per element");
    }
    if !variable.aliases.is_empty() {
        return not_in_version_2("aliases", "write variables with the same value reference");
    }
    if variable.causality == Causality::StructuralParameter {
        return not_in_version_2("causality structuralParameter", "make it a fixed parameter");
    }
    let element = element(description, &variable.name, variable.data_type)?;
    xml.open("ScalarVariable");
    head(xml, variable);
    xml.open(element);
    body(xml, variable, FmiVersion::V2);
    xml.close();
    xml.close();
    Ok(())
}

fn variable_3(xml: &mut Text, variable: &Variable) {
    xml.open(variable.data_type.name());
    head(xml, variable);
    body(xml, variable, FmiVersion::V3);
    if !variable.clocks.is_empty() {
        xml.attribute("clocks", &integers(&variable.clocks));
    }
    xml.optional_display("intermediateUpdate", variable.intermediate_update);
    xml.optional_display("previous", variable.previous);
    for dimension in &variable.dimensions {
        xml.open("Dimension");
        match dimension {
            Dimension::Size(size) => xml.attribute("start", &size.to_string()),
            Dimension::Parameter(reference) => {
                xml.attribute("valueReference", &reference.to_string());
            }
        }
        xml.close();
    }
    start_elements(xml, variable);
    for alias in &variable.aliases {
        xml.open("Alias");
        xml.attribute("name", &alias.name);
        xml.optional("description", alias.description.as_deref());
        xml.optional("displayUnit", alias.display_unit.as_deref());
        xml.close();
    }
    xml.close();
}

fn head(xml: &mut Text, variable: &Variable) {
    xml.attribute("name", &variable.name);
    xml.attribute("valueReference", &variable.value_reference.to_string());
    xml.optional("description", variable.description.as_deref());
    if variable.causality != Causality::Local {
        xml.attribute("causality", variable.causality.name());
    }
    xml.optional("variability", variable.stated_variability.map(|v| v.name()));
    xml.optional("initial", variable.stated_initial.map(|i| i.name()));
    xml.optional_display(
        "canHandleMultipleSetPerTimeInstant",
        variable.can_handle_multiple_set_per_time_instant,
    );
}

fn body(xml: &mut Text, variable: &Variable, version: FmiVersion) {
    xml.optional("declaredType", variable.declared_type.as_deref());
    properties(xml, &variable.properties, true);
    let as_elements = version == FmiVersion::V3
        && matches!(variable.data_type, DataType::String | DataType::Binary);
    if let (Some(start), false) = (&variable.start, as_elements) {
        xml.attribute("start", &start_text(start));
    }
    xml.optional_display("derivative", variable.derivative);
    xml.optional_display("reinit", variable.reinit);
}

fn start_text(start: &Start) -> String {
    match start {
        Start::Float(values) => values.iter().copied().map(float).collect::<Vec<_>>().join(" "),
        Start::Integer(values) => integers(values),
        Start::Boolean(values) => integers(values),
        Start::Text(values) => values.join(" "),
        Start::Binary(values) => values.iter().map(hex::encode).collect::<Vec<_>>().join(" "),
    }
}

fn start_elements(xml: &mut Text, variable: &Variable) {
    let values: Vec<String> = match &variable.start {
        Some(Start::Text(values)) => values.clone(),
        Some(Start::Binary(values)) => values.iter().map(hex::encode).collect(),
        _ => return,
    };
    for value in values {
        xml.open("Start");
        xml.attribute("value", &value);
        xml.close();
    }
}

fn number(value: Number) -> String {
    match value {
        Number::Float(value) => float(value),
        Number::Integer(value) => value.to_string(),
    }
}

fn properties(xml: &mut Text, properties: &Properties, bounds: bool) {
    xml.optional("quantity", properties.quantity.as_deref());
    xml.optional("unit", properties.unit.as_deref());
    xml.optional("displayUnit", properties.display_unit.as_deref());
    xml.optional_display("relativeQuantity", properties.relative_quantity);
    if bounds {
        xml.optional("min", properties.min.map(number).as_deref());
        xml.optional("max", properties.max.map(number).as_deref());
    }
    xml.optional_float("nominal", properties.nominal);
    xml.optional_display("unbounded", properties.unbounded);
    xml.optional("mimeType", properties.mime_type.as_deref());
    xml.optional_display("maxSize", properties.max_size);
    if let Some(clock) = &properties.clock {
        clock_properties(xml, clock);
    }
}

fn clock_properties(xml: &mut Text, clock: &ClockProperties) {
    xml.optional_display("canBeDeactivated", clock.can_be_deactivated);
    xml.optional_display("priority", clock.priority);
    xml.optional("intervalVariability", clock.interval_variability.as_deref());
    xml.optional_float("intervalDecimal", clock.interval_decimal);
    xml.optional_float("shiftDecimal", clock.shift_decimal);
    xml.optional_display("supportsFraction", clock.supports_fraction);
    xml.optional_display("resolution", clock.resolution);
    xml.optional_display("intervalCounter", clock.interval_counter);
    xml.optional_display("shiftCounter", clock.shift_counter);
}
