//! MATLAB 5: arrays of real numbers, by crate `matfile`.

use std::fs::File;
use std::path::Path;

use matfile::{Array, MatFile, NumericData};

use super::tables::{Group, Raw};
use super::{Refusal, broken};

/// Arrays of the same length are one group, named by that length; columns of a matrix get indices
/// from 1. Structures and `timeseries` objects are not read by the crate.
pub(super) fn read(path: &Path) -> Result<Vec<Group>, Refusal> {
    let file = File::open(path).map_err(|error| broken("MATLAB 5", error))?;
    let file = MatFile::parse(file).map_err(|error| broken("MATLAB 5", error))?;
    let mut groups: Vec<Group> = Vec::new();
    for array in file.arrays() {
        let columns = columns(array);
        let Some(rows) = columns.first().map(|raw| raw.values.len()) else { continue };
        let name = rows.to_string();
        match groups.iter_mut().find(|group| group.name == name) {
            Some(group) => group.columns.extend(columns),
            None => groups.push(Group { name, columns }),
        }
    }
    if groups.is_empty() {
        let rule = "has no arrays of real numbers; structures and timeseries are not read";
        let way_out = "save plain arrays, as in time = ts.Time; y = ts.Data; save(f, 'time', 'y')";
        return Err((rule.into(), way_out.into()));
    }
    Ok(groups)
}

/// The columns of an array; none where it is a scalar, empty, complex or has more dimensions.
fn columns(array: &Array) -> Vec<Raw> {
    let (Some(values), [rows, columns]) = (real(array.data()), array.size().as_slice()) else {
        return Vec::new();
    };
    let (rows, columns) = if *rows == 1 { (*columns, 1) } else { (*rows, *columns) };
    if rows < 2 || columns == 0 || rows.checked_mul(columns) != Some(values.len()) {
        return Vec::new();
    }
    let named = values.chunks_exact(rows).enumerate().map(|(index, values)| {
        let name = match columns {
            1 => array.name().to_owned(),
            _ => format!("{}[{}]", array.name(), index + 1),
        };
        Raw::new(name, None, values.to_vec())
    });
    named.collect()
}

fn real(data: &NumericData) -> Option<Vec<f64>> {
    macro_rules! numbers {
        ($($kind:ident: $convert:expr),*) => {
            match data {
                $(NumericData::$kind { real, imag: None } => {
                    Some(real.iter().map($convert).collect())
                })*
                _ => None,
            }
        };
    }
    numbers!(
        Int8: |v| f64::from(*v), UInt8: |v| f64::from(*v), Int16: |v| f64::from(*v),
        UInt16: |v| f64::from(*v), Int32: |v| f64::from(*v), UInt32: |v| f64::from(*v),
        Int64: |v| *v as f64, UInt64: |v| *v as f64, Single: |v| f64::from(*v), Double: |v| *v
    )
}
