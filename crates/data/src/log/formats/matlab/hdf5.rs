//! HDF5 as MATLAB 7.3 writes it, and plain HDF5 of other programs, by crate `hdf5-reader`.
//!
//! MATLAB says in the attribute `MATLAB_class` what an object is, counts the first index fastest
//! (so that sizes stand reversed) and keeps the elements of cells and of arrays of structures in
//! `#refs#`, by reference.

use std::collections::HashMap;
use std::path::Path;

use hdf5_reader::error::{ByteOrder, Error};
use hdf5_reader::group::Group;
use hdf5_reader::reference::read_object_references;
use hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions};

use super::super::broken;
use super::super::budget::Budget;
use super::{Array, Value, Variables};
use crate::log::group::Refusal;

/// Deepest group in a group.
const DEEPEST: usize = 16;
/// Most objects; a group can be in itself.
const MOST: usize = 200_000;

/// The variables of a file; groups are structures.
pub(super) fn read(path: &Path, budget: &mut Budget) -> Result<Variables, Refusal> {
    let bytes = std::fs::read(path).map_err(|error| broken("HDF5", error))?;
    let is_matlab = bytes.starts_with(b"MATLAB");
    let left = usize::try_from(budget.left()).unwrap_or(usize::MAX);
    let options = OpenOptions::default()
        .with_chunk_cache_bytes(0)
        .with_max_chunk_bytes(left)
        .with_max_read_bytes(left)
        .with_max_object_header_bytes(bytes.len());
    let file = Hdf5File::from_vec_with_options(bytes, options).map_err(failed)?;
    let root = file.root_group().map_err(failed)?;
    let mut reader = Reader { root: root.clone(), budget, is_matlab, elements: None, seen: 0 };
    reader.members(&root, 0)
}

fn failed(error: Error) -> Refusal {
    broken("HDF5", error)
}

struct Reader<'a> {
    root: Group,
    budget: &'a mut Budget,
    is_matlab: bool,
    /// What references lead to, by address.
    elements: Option<HashMap<u64, Object>>,
    seen: usize,
}

#[derive(Clone)]
enum Object {
    Dataset(Box<Dataset>),
    Group(Group),
}

impl Reader<'_> {
    fn members(&mut self, group: &Group, depth: usize) -> Result<Variables, Refusal> {
        Ok(self.fields(group, depth)?.into_iter().map(single).collect())
    }

    /// The members of a group, each with one value or, in arrays of structures, several.
    fn fields(
        &mut self,
        group: &Group,
        depth: usize,
    ) -> Result<Vec<(String, Vec<Value>)>, Refusal> {
        let (groups, datasets) = group.members().map_err(failed)?;
        self.count(groups.len() + datasets.len())?;
        let mut fields = Vec::new();
        for dataset in datasets {
            fields.push((dataset.name().to_owned(), self.dataset(&dataset, depth)?));
        }
        for group in groups.into_iter().filter(|group| !group.name().starts_with('#')) {
            let value = self.group(&group, depth)?;
            fields.push((group.name().to_owned(), vec![value]));
        }
        Ok(fields)
    }

    fn count(&mut self, more: usize) -> Result<(), Refusal> {
        self.seen += more;
        match self.seen > MOST {
            true => Err(broken("HDF5", format_args!("it has more than {MOST} objects"))),
            false => Ok(()),
        }
    }

    fn group(&mut self, group: &Group, depth: usize) -> Result<Value, Refusal> {
        if group.attribute("MATLAB_sparse").is_ok() {
            return Ok(Value::Other("is a sparse array".into()));
        }
        // Octave: a variable is a group of its type and its value, which stands as in MATLAB's files.
        if group.attribute("OCTAVE_NEW_FORMAT").is_ok()
            && let Ok(value) = group.dataset("value")
        {
            let before = std::mem::replace(&mut self.is_matlab, true);
            let value = self.dataset(&value, depth);
            self.is_matlab = before;
            return Ok(single(("", value?)).1);
        }
        if depth == DEEPEST {
            return Ok(Value::Other("is nested too deep".into()));
        }
        Ok(Value::Structure(self.fields(group, depth + 1)?))
    }

    fn dataset(&mut self, dataset: &Dataset, depth: usize) -> Result<Vec<Value>, Refusal> {
        let attributes = dataset.attributes();
        let find = |name: &str| attributes.iter().find(|attribute| attribute.name == name);
        let text = |name: &str| find(name).and_then(|attribute| attribute.read_string().ok());
        let class = text("MATLAB_class").unwrap_or_default();
        let other = |what: String| Ok(vec![Value::Other(what)]);
        if find("MATLAB_object_decode").is_some() {
            return other(format!("is an object of class {class}"));
        }
        if find("MATLAB_empty").is_some() {
            return other("is empty".into());
        }
        match (class.as_str(), dataset.dtype()) {
            ("char", _) => {
                let codes = self.numbers(dataset, None)?.map(|array| array.values);
                let codes = codes.unwrap_or_default();
                let letter = |code: &f64| char::from_u32(*code as u32).unwrap_or('\u{fffd}');
                Ok(vec![Value::Text(codes.iter().map(letter).collect())])
            }
            ("cell", _) => other("is a cell array".into()),
            ("function_handle", _) => other("is a function".into()),
            (_, Datatype::Reference { .. }) => self.elements(dataset, depth),
            (_, Datatype::Compound { size, fields }) => {
                let bytes = self.bytes(dataset)?;
                let mut columns = Vec::new();
                for field in fields {
                    let start = field.byte_offset as usize;
                    let end = start + width(&field.datatype).unwrap_or(0);
                    let rows = bytes.chunks_exact((*size as usize).max(1));
                    self.budget.column(rows.len() as u64)?;
                    let values = rows.map(|row| number(row.get(start..end)?, &field.datatype));
                    let value = match values.collect::<Option<Vec<f64>>>() {
                        Some(values) => {
                            let array = Array { size: size_of(dataset), values, unit: None };
                            Value::Numbers(if self.is_matlab { array } else { turned(array) })
                        }
                        None => Value::Other("holds no numbers".into()),
                    };
                    columns.push((field.name.clone(), vec![value]));
                }
                Ok(vec![Value::Structure(columns)])
            }
            _ => {
                let unit = ["units", "unit", "Units", "Unit"].iter().find_map(|name| text(name));
                Ok(vec![match self.numbers(dataset, unit)? {
                    Some(array) => Value::Numbers(array),
                    None => Value::Other("holds no numbers".into()),
                }])
            }
        }
    }

    /// What the references of a dataset lead to.
    fn elements(&mut self, dataset: &Dataset, depth: usize) -> Result<Vec<Value>, Refusal> {
        if depth >= DEEPEST {
            return Ok(vec![Value::Other("is nested too deep".into())]);
        }
        let bytes = self.bytes(dataset)?;
        let size = self.root.offset_size();
        let addresses = read_object_references(&bytes, size).map_err(failed)?;
        self.count(addresses.len())?;
        if self.elements.is_none() {
            self.elements = Some(elements(&self.root).map_err(failed)?);
        }
        let mut values = Vec::new();
        for address in addresses {
            let object = self.elements.as_ref().and_then(|all| all.get(&address)).cloned();
            values.push(match object {
                Some(Object::Dataset(dataset)) => {
                    single(("", self.dataset(&dataset, depth + 1)?)).1
                }
                Some(Object::Group(group)) => self.group(&group, depth + 1)?,
                None => Value::Other("is a reference that leads nowhere".into()),
            });
        }
        Ok(values)
    }

    /// The bytes of a dataset, after all filters.
    fn bytes(&mut self, dataset: &Dataset) -> Result<Vec<u8>, Refusal> {
        let size = dataset.raw_byte_len().map_err(failed)? as u64;
        self.budget.unpack(size)?;
        dataset.read_raw_bytes().map_err(failed)
    }

    /// The numbers of a dataset; `None` where it holds none.
    fn numbers(
        &mut self,
        dataset: &Dataset,
        unit: Option<String>,
    ) -> Result<Option<Array>, Refusal> {
        let Some(width) = width(dataset.dtype()) else { return Ok(None) };
        let count = dataset.num_elements().map_err(failed)?;
        self.budget.column(count)?;
        let bytes = self.bytes(dataset)?;
        let numbers = bytes.chunks_exact(width).map(|bytes| number(bytes, dataset.dtype()));
        let Some(values) = numbers.collect::<Option<Vec<f64>>>() else { return Ok(None) };
        let array = Array { size: size_of(dataset), values, unit };
        Ok(Some(if self.is_matlab { array } else { turned(array) }))
    }
}

/// The first index running fastest.
fn size_of(dataset: &Dataset) -> Vec<usize> {
    dataset.shape().iter().rev().map(|length| *length as usize).collect()
}

/// Row by row becomes column by column; arrays of more dimensions stay as they are, with the times last.
fn turned(array: Array) -> Array {
    let [columns, rows] = *array.size.as_slice() else { return array };
    let values = (0..columns)
        .flat_map(|column| array.values.iter().skip(column).step_by(columns.max(1)).copied())
        .collect();
    Array { size: vec![rows, columns], values, unit: array.unit }
}

fn single<T>((name, mut values): (T, Vec<Value>)) -> (T, Value) {
    let value = match values.len() {
        1 => values.remove(0),
        count => Value::Other(format!("is an array of {count} structures")),
    };
    (name, value)
}

/// The objects in `#refs#`, by address.
fn elements(root: &Group) -> Result<HashMap<u64, Object>, Error> {
    let (groups, datasets) = match root.group("#refs#") {
        Ok(elements) => elements.members()?,
        Err(_) => root.members()?,
    };
    let groups = groups.into_iter().map(|group| (group.address(), Object::Group(group)));
    let datasets = datasets.into_iter().map(|set| (set.address(), Object::Dataset(Box::new(set))));
    Ok(groups.chain(datasets).collect())
}

/// Bytes of a number; `None` where it is none.
fn width(kind: &Datatype) -> Option<usize> {
    match kind {
        Datatype::FixedPoint { size, .. } | Datatype::Bitfield { size, .. } => {
            matches!(size, 1 | 2 | 4 | 8).then_some(usize::from(*size))
        }
        Datatype::FloatingPoint { size, .. } => matches!(size, 4 | 8).then_some(usize::from(*size)),
        Datatype::Enum { base, .. } => width(base),
        _ => None,
    }
}

fn number(bytes: &[u8], kind: &Datatype) -> Option<f64> {
    let mut word = [0; 8];
    let word = word.get_mut(..bytes.len())?;
    word.copy_from_slice(bytes);
    let (order, is_signed, is_float) = match kind {
        Datatype::FixedPoint { signed, byte_order, .. } => (byte_order, *signed, false),
        Datatype::Bitfield { byte_order, .. } => (byte_order, false, false),
        Datatype::FloatingPoint { byte_order, .. } => (byte_order, false, true),
        Datatype::Enum { base, .. } => return number(bytes, base),
        _ => return None,
    };
    if *order == ByteOrder::BigEndian {
        word.reverse();
    }
    let unsigned = word.iter().rev().fold(0_u64, |sum, byte| sum << 8 | u64::from(*byte));
    let unused = 64_u32.checked_sub(8 * bytes.len() as u32)?;
    Some(match (is_float, is_signed, bytes.len()) {
        (true, _, 4) => f64::from(f32::from_bits(unsigned as u32)),
        (true, ..) => f64::from_bits(unsigned),
        (_, true, 1..) => ((unsigned << unused) as i64 >> unused) as f64,
        _ => unsigned as f64,
    })
}
