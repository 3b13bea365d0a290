//! The tables of learned components: NumPy arrays of doubles with two dimensions, beside the
//! blueprint.
//!
//! `table = "hysteresis.npy"` names a file in the blueprint's folder (in an FMU, the resources), or
//! a table that the blueprint holds in memory.

use std::collections::BTreeMap;
use std::path::Path;

use model::Table;

use super::{Blueprint, CheckedBlueprint, ComponentBlueprint, TABLE, Value};
use crate::{AtomicFile, Problem, Problems};

/// Greatest file that is read, in bytes.
const MOST: u64 = 1 << 28;
const MAGIC: &[u8; 8] = b"\x93NUMPY\x01\x00";
/// What is wrong, and the way out.
type Refusal = (String, &'static str);

impl Blueprint {
    /// The table of this name.
    pub(super) fn table(&self, name: &str) -> Result<Table, Refusal> {
        if let Some(table) = self.tables.get(name) {
            return Ok(table.clone());
        }
        let plain = !name.is_empty() && Path::new(name).file_name().is_some_and(|f| f == name);
        if !plain || name.contains(['\\', ':']) {
            let way_out = "put the file beside the blueprint and give its name alone";
            return Err(("is no plain file name".into(), way_out));
        }
        let path = Path::new(&self.origin.file).with_file_name(name);
        let failed = |error: std::io::Error| {
            let rule = format!("cannot be read from {}: {error}", path.display());
            (rule, "put the table beside the blueprint")
        };
        files::note_read(&path);
        if std::fs::metadata(&path).map_err(failed)?.len() > MOST {
            return Err((format!("is longer than {MOST} bytes"), "compress the model"));
        }
        parse(&std::fs::read(&path).map_err(failed)?)
            .map_err(|rule| (rule, "save it as a NumPy array of doubles with two dimensions"))
    }
}

impl CheckedBlueprint {
    /// The files of all tables that its components run, by name, as they lie beside the blueprint.
    #[must_use]
    pub fn table_files(&self) -> Vec<(String, Vec<u8>)> {
        let components = self.blueprint.axes.iter().flat_map(|axis| &axis.components);
        let mut files = BTreeMap::new();
        for component in components {
            if let Some(Value::Text(name)) = component.get(TABLE)
                && let Ok(table) = self.blueprint.table(name)
            {
                files.insert(name.clone(), npy_of(&table));
            }
        }
        files.into_iter().collect()
    }

    /// Writes the blueprint, and before it its tables, whose files are named after its own.
    ///
    /// # Errors
    /// A file cannot be written, or that of a table is a file of the call itself or of somebody else.
    pub fn write(&self, file: &Path) -> Result<(), Problems> {
        let mut blueprint = self.blueprint.clone();
        let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        for (name, bytes) in self.table_files() {
            let own = format!("{stem}-{name}");
            let table = file.with_file_name(&own);
            // A table of the blueprint that is replaced.
            let is_ours = || std::fs::read_to_string(file).is_ok_and(|text| text.contains(&own));
            files::check_beside(&table, is_ours)
                .and_then(|()| AtomicFile::write_all_of(&table, &bytes))
                .map_err(|error| Problem::unwritable(&table, &error))?;
            let parts = blueprint.axes.iter_mut().flat_map(|axis| &mut axis.components);
            for part in parts.filter(|part| part.get(TABLE) == Some(&name.as_str().into())) {
                part.set(TABLE, own.as_str());
            }
        }
        blueprint.write(file)
    }

    /// The table that a component of this blueprint runs.
    #[must_use]
    pub fn table_of(&self, component: &ComponentBlueprint) -> Option<Table> {
        match component.get(TABLE) {
            Some(Value::Text(name)) => self.blueprint.table(name).ok(),
            _ => None,
        }
    }
}

/// The bytes of a table as a NumPy file (format 1.0, little endian, row after row).
#[must_use]
pub fn npy_of(table: &Table) -> Vec<u8> {
    let (rows, columns) = (table.rows(), table.columns());
    let head =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    // The numbers begin at a multiple of 64 bytes.
    let length = (MAGIC.len() + 2 + head.len() + 1).next_multiple_of(64) - MAGIC.len() - 2;
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&(length as u16).to_le_bytes());
    bytes.extend_from_slice(format!("{head:<width$}\n", width = length - 1).as_bytes());
    table.values().iter().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
    bytes
}

/// A NumPy file's table.
fn parse(bytes: &[u8]) -> Result<Table, String> {
    let wrong = |what: &str| format!("is no table: {what}");
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| wrong("no NumPy file of format 1.0"))?;
    let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(|| wrong("it is cut"))?;
    let length = usize::from(u16::from_le_bytes(*length));
    let (head, numbers) = rest.split_at_checked(length).ok_or_else(|| wrong("it is cut"))?;
    let head = String::from_utf8_lossy(head);
    if !head.contains("'<f8'") || !head.contains("'fortran_order': False") {
        return Err(wrong("its numbers are not little-endian doubles, row after row"));
    }
    let shape = head.split_once("'shape': (").and_then(|(_, shape)| shape.split_once(')'));
    let sizes: Vec<usize> = shape
        .map(|(shape, _)| shape.split(',').filter_map(|n| n.trim().parse().ok()).collect())
        .unwrap_or_default();
    let &[rows, columns] = sizes.as_slice() else {
        return Err(wrong("its shape has not two dimensions"));
    };
    let count = rows.checked_mul(columns).and_then(|n| n.checked_mul(8));
    if count != Some(numbers.len()) {
        return Err(format!(
            "has {} bytes of numbers for a shape of {rows} × {columns}",
            numbers.len()
        ));
    }
    let (words, _) = numbers.as_chunks::<8>();
    Table::new(columns, words.iter().map(|w| f64::from_le_bytes(*w)).collect())
        .map_err(|error| wrong(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_table_is_read_as_it_was() {
        let table = Table::new(3, (0..12).map(|x| 0.1 * f64::from(x)).collect()).unwrap();
        let bytes = npy_of(&table);
        assert_eq!(parse(&bytes).unwrap(), table);
        assert_eq!((bytes.len() - 96) % 64, 0);
        for cut in [0, 5, 9, 40, bytes.len() - 1] {
            assert!(parse(&bytes[..cut]).is_err(), "{cut}");
        }
        let mut single = bytes.clone();
        let kind = single.windows(3).position(|word| word == b"<f8").unwrap();
        single[kind + 2] = b'4';
        assert!(parse(&single).unwrap_err().contains("doubles"));
    }

    #[test]
    fn a_name_leads_nowhere_else() {
        let blueprint = Blueprint::new(model::Kind::Plant, "x", 1e-3);
        for name in ["", "../x.npy", "/etc/passwd", "a/b.npy", "c:\\x"] {
            assert_eq!(blueprint.table(name).unwrap_err().0, "is no plain file name", "{name}");
        }
        assert!(blueprint.table("none.npy").unwrap_err().0.contains("cannot be read"));
    }
}
