//! Reads `<ModelVariables>` and `<TypeDefinitions>`.

use super::values::{
    Attributes, Context, parse_boolean, parse_float, parse_hex, parse_integer, parse_ranged,
};
use crate::description::{EnumerationItem, FmiVersion, Line, TypeDefinition};
use crate::problem::Problem;
use crate::variable::{
    Alias, Causality, ClockProperties, DataType, Dimension, Initial, Number, Properties, Start,
    Variability, Variable,
};
use crate::xml::Element;

const FLOAT: [&str; 8] =
    ["quantity", "unit", "displayUnit", "relativeQuantity", "min", "max", "nominal", "unbounded"];
const INTEGER: [&str; 3] = ["quantity", "min", "max"];
const BINARY: [&str; 2] = ["mimeType", "maxSize"];
const CLOCK: [&str; 9] = [
    "canBeDeactivated",
    "priority",
    "intervalVariability",
    "intervalDecimal",
    "shiftDecimal",
    "supportsFraction",
    "resolution",
    "intervalCounter",
    "shiftCounter",
];

/// The attributes that variables and types of this kind share.
fn shared_attributes(data_type: DataType) -> &'static [&'static str] {
    match data_type {
        DataType::Float32 | DataType::Float64 => &FLOAT,
        DataType::Boolean | DataType::String => &[],
        DataType::Binary => &BINARY,
        DataType::Clock => &CLOCK,
        _ => &INTEGER,
    }
}

fn properties(context: &mut Context, at: Attributes<'_>, data_type: DataType) -> Properties {
    let mut read = Properties::default();
    let range = data_type.integer_range(context.version);
    if data_type.is_float() {
        read.unit = context.text(at, "unit");
        read.display_unit = context.text(at, "displayUnit");
        read.relative_quantity = context.boolean(at, "relativeQuantity");
        read.unbounded = context.boolean(at, "unbounded");
        read.min = context.float(at, "min").map(Number::Float);
        read.max = context.float(at, "max").map(Number::Float);
        read.nominal = context.float(at, "nominal");
    }
    if let Some(range) = range {
        read.min = context.ranged(at, "min", range).map(Number::Integer);
        read.max = context.ranged(at, "max", range).map(Number::Integer);
    }
    if data_type.is_float() || range.is_some() {
        read.quantity = context.text(at, "quantity");
    }
    if data_type == DataType::Binary {
        read.mime_type = context.text(at, "mimeType");
        read.max_size = context.integer(at, "maxSize");
    }
    if data_type == DataType::Clock {
        read.clock = Some(Box::new(clock(context, at)));
    }
    read
}

fn clock(context: &mut Context, at: Attributes<'_>) -> ClockProperties {
    ClockProperties {
        interval_variability: context.text(at, "intervalVariability"),
        can_be_deactivated: context.boolean(at, "canBeDeactivated"),
        priority: context.integer(at, "priority"),
        interval_decimal: context.float(at, "intervalDecimal"),
        shift_decimal: context.float(at, "shiftDecimal"),
        supports_fraction: context.boolean(at, "supportsFraction"),
        resolution: context.integer(at, "resolution"),
        interval_counter: context.integer(at, "intervalCounter"),
        shift_counter: context.integer(at, "shiftCounter"),
    }
}

pub(super) fn variables(context: &mut Context, at: Attributes<'_>) -> Vec<Variable> {
    context.expect_some(at);
    match context.version {
        FmiVersion::V2 => variables_2(context, at),
        FmiVersion::V3 => variables_3(context, at),
    }
}

/// The type element among the children of `<ScalarVariable>` or `<SimpleType>` (2.0).
fn type_element<'a>(
    context: &mut Context,
    at: Attributes<'a>,
) -> Option<(DataType, Attributes<'a>)> {
    let find = |child: &'a Element| {
        let data_type = DataType::from_element(FmiVersion::V2, &child.name)?;
        Some((data_type, Attributes { element: child, topic: at.topic }))
    };
    let found = at.element.children.iter().find_map(find);
    if found.is_none() {
        let name = at.element.attribute("name").unwrap_or_default();
        let found = format!("<{} name=\"{name}\"> has no type", at.element.name);
        let problem = Problem::in_xml(context.version, at.topic, at.element.line, found)
            .rule("exactly one of Real, Integer, Boolean, String, Enumeration must be present")
            .way_out("add the type element")
            .unreadable();
        context.report(problem);
    }
    found
}

const SCALAR_VARIABLE: [&str; 7] = [
    "name",
    "valueReference",
    "description",
    "causality",
    "variability",
    "initial",
    "canHandleMultipleSetPerTimeInstant",
];

fn variables_2(context: &mut Context, at: Attributes<'_>) -> Vec<Variable> {
    context.expect(at, &[], &["ScalarVariable*"]);
    let mut variables = Vec::new();
    for element in at.element.children.iter().filter(|child| child.name == "ScalarVariable") {
        let at = Attributes { element, topic: at.topic };
        let Some((data_type, typed)) = type_element(context, at) else { continue };
        context.expect(at, &SCALAR_VARIABLE, &[typed.element.name.as_str(), "Annotations"]);
        let mut own = vec!["declaredType", "start"];
        if data_type.is_float() {
            own.extend(["derivative", "reinit"]);
        }
        context.expect(typed, &[shared_attributes(data_type), &own].concat(), &[]);
        let mut variable = head(context, at, data_type);
        body(context, typed, &mut variable);
        variables.push(variable);
    }
    variables
}

fn variables_3(context: &mut Context, at: Attributes<'_>) -> Vec<Variable> {
    let allowed: Vec<String> = DataType::ALL.iter().map(|t| format!("{t}*")).collect();
    let mut variables = Vec::new();
    for element in &at.element.children {
        let at = Attributes { element, topic: at.topic };
        let Some(data_type) = DataType::from_element(FmiVersion::V3, &element.name) else {
            let found = format!("<{}> stands in <ModelVariables>", element.name);
            let problem = Problem::in_xml(context.version, at.topic, element.line, found)
                .rule(format!("the schema allows here: {}", allowed.join(", ").replace('*', "")))
                .way_out("rename or remove the element");
            context.report(problem);
            continue;
        };
        expect_variable_3(context, at, data_type);
        let mut variable = head(context, at, data_type);
        body(context, at, &mut variable);
        arrays_and_clocks(context, at, &mut variable);
        variables.push(variable);
    }
    variables
}

fn expect_variable_3(context: &mut Context, at: Attributes<'_>, data_type: DataType) {
    let clock = data_type == DataType::Clock;
    let lists_start = matches!(data_type, DataType::String | DataType::Binary);
    let mut attributes = shared_attributes(data_type).to_vec();
    attributes.extend(SCALAR_VARIABLE.iter().filter(|name| !(clock && **name == "initial")));
    attributes.extend(["declaredType", "clocks"]);
    if !clock {
        attributes.extend(["intermediateUpdate", "previous"]);
    }
    if !clock && !lists_start {
        attributes.push("start");
    }
    if data_type.is_float() {
        attributes.extend(["derivative", "reinit"]);
    }
    let children: &[&str] = match (clock, lists_start) {
        (true, _) => &["Annotations", "Alias*"],
        (_, true) => &["Annotations", "Dimension*", "Start*", "Alias*"],
        _ => &["Annotations", "Dimension*", "Alias*"],
    };
    context.expect(at, &attributes, children);
}

/// What all variables have.
fn head(context: &mut Context, at: Attributes<'_>, data_type: DataType) -> Variable {
    let causalities = match context.version {
        FmiVersion::V2 => Causality::ALL.split_last().map_or(Causality::ALL, |(_, rest)| rest),
        FmiVersion::V3 => Causality::ALL,
    };
    let mut variable = Variable::new(
        context.required_text(at, "name"),
        context.required_integer(at, "valueReference"),
        data_type,
    );
    variable.line = Line(at.element.line);
    variable.description = context.text(at, "description");
    variable.causality = context
        .named(at, "causality", causalities, Causality::from_name)
        .unwrap_or(Causality::Local);
    variable.stated_variability =
        context.named(at, "variability", Variability::ALL, Variability::from_name);
    variable.stated_initial = context.named(at, "initial", Initial::ALL, Initial::from_name);
    variable.can_handle_multiple_set_per_time_instant =
        context.boolean(at, "canHandleMultipleSetPerTimeInstant");
    variable
}

/// What stands at the type element in 2.0 and at the variable itself in 3.0.
fn body(context: &mut Context, at: Attributes<'_>, variable: &mut Variable) {
    let data_type = variable.data_type;
    variable.declared_type = context.text(at, "declaredType");
    variable.properties = properties(context, at, data_type);
    variable.start = start(context, at, data_type);
    if data_type.is_float() {
        variable.derivative = context.integer(at, "derivative");
        variable.reinit = context.boolean(at, "reinit");
    }
}

/// The start value. One that cannot be read is reported and kept as text, so that it does not count
/// as missing, too; the description is then not used.
fn start(context: &mut Context, at: Attributes<'_>, data_type: DataType) -> Option<Start> {
    let read = readable_start(context, at, data_type);
    read.or_else(|| context.text(at, "start").map(|text| Start::Text(vec![text])))
}

fn readable_start(context: &mut Context, at: Attributes<'_>, data_type: DataType) -> Option<Start> {
    let version = context.version;
    match data_type {
        DataType::Float32 | DataType::Float64 => {
            context.list(at, "start", "numbers", parse_float).map(Start::Float)
        }
        DataType::Boolean => {
            context.list(at, "start", "true, false, 1, 0", parse_boolean).map(Start::Boolean)
        }
        DataType::String if version == FmiVersion::V2 => {
            context.text(at, "start").map(|text| Start::Text(vec![text]))
        }
        DataType::String => {
            let texts = start_elements(context, at).map(|values| {
                values.into_iter().map(|(_, text)| text.to_owned()).collect::<Vec<_>>()
            });
            texts.map(Start::Text)
        }
        DataType::Binary => {
            let elements = start_elements(context, at)?;
            let mut bytes = Vec::new();
            for (element, text) in elements {
                let value = parse_hex(text);
                if value.is_none() {
                    let at = Attributes { element, topic: at.topic };
                    context.list::<u8>(at, "value", "pairs of hexadecimal digits", |_| None);
                }
                bytes.push(value.unwrap_or_default());
            }
            Some(Start::Binary(bytes))
        }
        DataType::Clock => None,
        _ => {
            let range = data_type.integer_range(version)?;
            let rule = format!("integers from {} to {}", range.0, range.1);
            context.list(at, "start", rule, |text| parse_ranged(text, range)).map(Start::Integer)
        }
    }
}

/// The `<Start value="…">` elements of texts and binaries in 3.0.
fn start_elements<'a>(
    context: &mut Context,
    at: Attributes<'a>,
) -> Option<Vec<(&'a Element, &'a str)>> {
    let mut values = Vec::new();
    for element in at.element.children.iter().filter(|child| child.name == "Start") {
        context.expect(Attributes { element, topic: at.topic }, &["value"], &[]);
        values.push((element, element.attribute("value").unwrap_or_default()));
    }
    (!values.is_empty()).then_some(values)
}

fn arrays_and_clocks(context: &mut Context, at: Attributes<'_>, variable: &mut Variable) {
    variable.clocks =
        context.list(at, "clocks", "value references", parse_integer).unwrap_or_default();
    variable.intermediate_update = context.boolean(at, "intermediateUpdate");
    variable.previous = context.integer(at, "previous");
    for element in &at.element.children {
        let child = Attributes { element, topic: at.topic };
        match element.name.as_str() {
            "Dimension" => {
                context.expect(child, &["start", "valueReference"], &[]);
                if let Some(dimension) = dimension(context, child) {
                    variable.dimensions.push(dimension);
                }
            }
            "Alias" => {
                context.expect(child, &["name", "description", "displayUnit"], &[]);
                variable.aliases.push(Alias {
                    name: context.required_text(child, "name"),
                    description: context.text(child, "description"),
                    display_unit: context.text(child, "displayUnit"),
                });
            }
            _ => {}
        }
    }
}

fn dimension(context: &mut Context, at: Attributes<'_>) -> Option<Dimension> {
    let size = context.integer(at, "start");
    let parameter = context.integer(at, "valueReference");
    match (size, parameter) {
        (Some(size), None) => Some(Dimension::Size(size)),
        (None, Some(reference)) => Some(Dimension::Parameter(reference)),
        _ => {
            let found = "<Dimension> without, or with both of, start and valueReference".to_owned();
            let problem = Problem::in_xml(context.version, at.topic, at.element.line, found)
                .rule("exactly one of the two must be given")
                .way_out("give the size as start, or the structural parameter as valueReference")
                .unreadable();
            context.report(problem);
            None
        }
    }
}

pub(super) fn types(context: &mut Context, at: Attributes<'_>) -> Vec<TypeDefinition> {
    context.expect_some(at);
    let mut types = Vec::new();
    if context.version == FmiVersion::V2 {
        context.expect(at, &[], &["SimpleType*"]);
    }
    for element in &at.element.children {
        let at = Attributes { element, topic: at.topic };
        match context.version {
            FmiVersion::V2 if element.name == "SimpleType" => {
                let Some((data_type, typed)) = type_element(context, at) else { continue };
                context.expect(at, &["name", "description"], &[typed.element.name.as_str()]);
                let attributes: &[&str] = match data_type {
                    DataType::Enumeration => &["quantity"],
                    _ => shared_attributes(data_type),
                };
                context.expect(typed, attributes, items_of(data_type, &[]));
                types.push(type_definition(context, at, typed, data_type));
            }
            FmiVersion::V2 => {}
            FmiVersion::V3 => {
                let name = element.name.strip_suffix("Type").unwrap_or_default();
                let Some(data_type) = DataType::from_element(FmiVersion::V3, name) else {
                    let found = format!("<{}> stands in <TypeDefinitions>", element.name);
                    let problem = Problem::in_xml(context.version, at.topic, element.line, found)
                        .rule("the schema allows Float64Type, Int32Type, … here")
                        .way_out("rename or remove the element");
                    context.report(problem);
                    continue;
                };
                let attributes = [shared_attributes(data_type), &["name", "description"]].concat();
                context.expect(at, &attributes, items_of(data_type, &["Annotations"]));
                types.push(type_definition(context, at, at, data_type));
            }
        }
    }
    types
}

fn items_of(data_type: DataType, others: &'static [&'static str]) -> &'static [&'static str] {
    match (data_type, others.is_empty()) {
        (DataType::Enumeration, true) => &["Item*"],
        (DataType::Enumeration, false) => &["Annotations", "Item*"],
        _ => others,
    }
}

fn type_definition(
    context: &mut Context,
    at: Attributes<'_>,
    typed: Attributes<'_>,
    data_type: DataType,
) -> TypeDefinition {
    let mut items = Vec::new();
    for element in typed.element.children.iter().filter(|child| child.name == "Item") {
        let item = Attributes { element, topic: at.topic };
        context.expect(item, &["name", "value", "description"], &["Annotations"]);
        items.push(EnumerationItem {
            name: context.required_text(item, "name"),
            value: context.required_integer(item, "value"),
            description: context.text(item, "description"),
        });
    }
    TypeDefinition {
        name: context.required_text(at, "name"),
        description: context.text(at, "description"),
        data_type,
        properties: properties(context, typed, data_type),
        items,
        line: Line(at.element.line),
    }
}
