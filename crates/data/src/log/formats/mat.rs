//! MATLAB 5: arrays of real numbers, by crate `matfile`.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use flate2::read::ZlibDecoder;
use matfile::{Array, MatFile, NumericData};

use super::broken;
use crate::log::group::{Group, Raw, Refusal};

/// Arrays of the same length are one group, named by that length; columns of a matrix get indices
/// from 1. Structures and `timeseries` objects are not read by the crate.
pub(super) fn read(path: &Path) -> Result<Vec<Group>, Refusal> {
    let failed = |error| broken("MATLAB 5", error);
    let mut bytes = BufReader::new(File::open(path).map_err(failed)?);
    only_variables(&mut bytes)?;
    bytes.rewind().map_err(failed)?;
    let file = MatFile::parse(bytes).map_err(|error| broken("MATLAB 5", error))?;
    let mut groups: Vec<Group> = Vec::new();
    for array in file.arrays() {
        let columns = columns(array);
        let Some(rows) = columns.first().map(|raw| raw.values.len()) else { continue };
        let name = rows.to_string();
        match groups.iter_mut().find(|group| group.name == name) {
            Some(group) => group.columns.extend(columns),
            None => groups.push(Group::new(name, columns)),
        }
    }
    if groups.is_empty() {
        let rule = "has no arrays of real numbers; structures and timeseries are not read";
        let way_out = "save plain arrays, as in time = ts.Time; y = ts.Data; save(f, 'time', 'y')";
        return Err((rule.into(), way_out.into()));
    }
    Ok(groups)
}

/// Refuses a file whose elements are not all variables: the crate would print that to standard output,
/// among our answers, and pass over it. A file that ends early the crate refuses.
fn only_variables(mut bytes: impl Read + Seek) -> Result<(), Refusal> {
    const MATRIX: u32 = 14;
    const COMPRESSED: u32 = 15;
    let failed = |error| broken("MATLAB 5", error);
    let mut header = [0; 128];
    if bytes.read_exact(&mut header).is_err() {
        return Ok(());
    }
    let is_little = header.ends_with(b"IM");
    let number = |bytes: [u8; 4]| match is_little {
        true => u32::from_le_bytes(bytes),
        false => u32::from_be_bytes(bytes),
    };
    let mut tag = [[0; 4]; 2];
    while bytes.read_exact(tag.as_flattened_mut()).is_ok() {
        let [kind, size] = tag.map(number);
        let content = bytes.stream_position().map_err(failed)?;
        let end = content + u64::from(size);
        let (kind, next) = match kind {
            COMPRESSED => {
                let mut inside = [0; 4];
                let packed = ZlibDecoder::new((&mut bytes).take(u64::from(size)));
                let unpacked = { packed }.read_exact(&mut inside);
                // What cannot be unpacked the crate refuses.
                (unpacked.map_or(MATRIX, |()| number(inside)), end)
            }
            kind => (kind, end.next_multiple_of(8)),
        };
        if kind != MATRIX {
            return Err(broken(
                "MATLAB 5",
                format_args!("at byte {} there is data of type {kind}, no variable", content - 8),
            ));
        }
        bytes.seek(SeekFrom::Start(next)).map_err(failed)?;
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use flate2::Compression;
    use flate2::write::ZlibEncoder;

    use super::*;

    /// A file with one element of this type and content.
    fn file(kind: u32, content: &[u8]) -> Vec<u8> {
        let mut bytes = vec![b' '; 124];
        bytes.extend([0, 1, b'I', b'M']);
        bytes.extend(kind.to_le_bytes());
        bytes.extend((content.len() as u32).to_le_bytes());
        bytes.extend(content);
        bytes
    }

    #[test]
    fn what_is_no_variable_is_refused_packed_or_not() {
        let packed = |kind: u32| {
            let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
            packed.write_all(&file(kind, &[0; 8])[128..]).unwrap();
            file(15, &packed.finish().unwrap())
        };
        assert!(only_variables(Cursor::new(file(14, &[0; 8]))).is_ok());
        assert!(only_variables(Cursor::new(packed(14))).is_ok());
        for bytes in [file(9, &[0; 8]), packed(9)] {
            let (rule, _) = only_variables(Cursor::new(bytes)).unwrap_err();
            assert!(rule.contains("at byte 128 there is data of type 9"), "{rule}");
        }
        let mut second = file(14, &[0; 5]);
        second.extend([0; 3]);
        second.extend(&file(7, &[])[128..]);
        assert!(only_variables(Cursor::new(second)).unwrap_err().0.contains("at byte 144"));
        assert!(only_variables(Cursor::new(&file(14, &[])[..100])).is_ok(), "the crate refuses it");
    }
}
