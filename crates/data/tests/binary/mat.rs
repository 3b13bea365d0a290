//! Small MATLAB files, versions 4 and 5.

/// A value of a variable.
#[derive(Clone)]
pub(crate) enum Value {
    /// Rows, columns and values, the rows running fastest.
    Numbers(usize, usize, Vec<f64>),
    Bytes(Vec<u8>),
    Text(&'static str),
    /// Elements of a structure: fields of each.
    Structure(Vec<Vec<(&'static str, Value)>>),
    /// An object, as `timeseries` is one.
    Object(&'static str),
}

pub(crate) fn row(values: &[f64]) -> Value {
    Value::Numbers(1, values.len(), values.to_vec())
}

pub(crate) fn column(values: &[f64]) -> Value {
    Value::Numbers(values.len(), 1, values.to_vec())
}

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

fn matrix(name: &str, value: &Value) -> Vec<u8> {
    let (class, size, parts) = match value {
        Value::Numbers(rows, columns, values) => {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            (6_u32, [*rows, *columns], element(9, &bytes))
        }
        // Whole numbers of a double array are stored in bytes.
        Value::Bytes(values) => (6, [values.len(), 1], element(2, values)),
        Value::Text(text) => {
            let units: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
            (4, [1, text.len()], element(4, &units))
        }
        Value::Structure(elements) => {
            let names: Vec<&str> =
                elements.first().into_iter().flatten().map(|(name, _)| *name).collect();
            let mut parts = element(5, &32_u32.to_le_bytes());
            let padded = |name: &&str| {
                let mut name = name.as_bytes().to_vec();
                name.resize(32, 0);
                name
            };
            parts.extend(element(1, &names.iter().flat_map(padded).collect::<Vec<u8>>()));
            parts.extend(elements.iter().flatten().flat_map(|(_, value)| matrix("", value)));
            (2, [1, elements.len()], parts)
        }
        Value::Object(class) => {
            let inside = [element(6, &[17, 0, 0, 0, 0, 0, 0, 0]), element(1, name.as_bytes())];
            let inside = [inside.concat(), element(1, b"MCOS"), element(1, class.as_bytes())];
            let parts = [inside.concat(), matrix("", &column(&[1.0, 2.0]))].concat();
            return element(14, &parts);
        }
    };
    let flags = [class.to_le_bytes(), [0; 4]].concat();
    let size: Vec<u8> = size.iter().flat_map(|length| (*length as u32).to_le_bytes()).collect();
    let head = [element(6, &flags), element(5, &size), element(1, name.as_bytes())].concat();
    element(14, &[head, parts].concat())
}

pub(crate) fn version_5(variables: &[(&str, Value)]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, written by a test".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    bytes.extend(variables.iter().flat_map(|(name, value)| matrix(name, value)));
    bytes
}

/// A matrix of version 4; `kind` is its type, as 0 for doubles or 51 for text.
pub(crate) fn version_4(
    name: &str,
    kind: u32,
    rows: usize,
    columns: usize,
    data: &[u8],
) -> Vec<u8> {
    let head = [kind, rows as u32, columns as u32, 0, name.len() as u32 + 1];
    let is_big = kind / 1000 == 1;
    let word = |word: u32| if is_big { word.to_be_bytes() } else { word.to_le_bytes() };
    [&head.map(word).concat()[..], name.as_bytes(), &[0], data].concat()
}

pub(crate) fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// The texts as columns of characters, each of `length`.
pub(crate) fn standing(texts: &[&str], length: usize) -> Vec<u8> {
    let padded = texts.iter().flat_map(|text| {
        let mut text = text.as_bytes().to_vec();
        text.resize(length, b' ');
        text
    });
    padded.collect()
}
