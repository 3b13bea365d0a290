//! A record as NumPy file: `.npy`, an array of rows with named fields, or `.npz`, an array per
//! column.
//!
//! Format: NumPy Enhancement Proposal 1, versions 1.0 and 3.0 (names in UTF-8), little endian.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use data::AtomicFile;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::{Column, Recorder};

/// Bytes of the header, so that the number of rows fits when it is known.
const ALIGNMENT: usize = 64;
/// Digits of the largest number of rows.
const DIGITS: usize = 20;

/// An `.npy` file: one array of shape (rows,), whose fields are `time`, `record` where there are
/// several, and the recorded variables, all `<f8`. It appears whole or not at all, see
/// [`CsvFile`](super::CsvFile); memory does not grow.
pub struct NpyFile {
    rows: Rows<AtomicFile>,
}

/// An `.npz` file: an array of shape (rows,) per column, `numpy.load(…)["position[1]"]`. Rows go to
/// a temporary file beside it and become columns at the end; memory does not grow.
pub struct NpzFile {
    rows: Rows<BufWriter<File>>,
    columns: AtomicFile,
}

/// Rows on disk, after space for a header.
struct Rows<W> {
    out: W,
    names: Vec<String>,
    record: usize,
    count: u64,
}

impl<W: Write + Seek> Rows<W> {
    fn new(out: W) -> Self {
        Rows { out, names: Vec::new(), record: 0, count: 0 }
    }

    fn begin(&mut self, record: usize, columns: &[Column]) -> io::Result<()> {
        self.record = record;
        if !self.names.is_empty() {
            return Ok(());
        }
        let names = columns.iter().map(|column| column.name.clone());
        self.names = ["time".to_owned(), "record".to_owned()].into_iter().chain(names).collect();
        let header = header(&descriptor(&self.names), 0);
        self.out.write_all(&header)
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.out.write_all(&time.to_le_bytes())?;
        self.out.write_all(&(self.record as f64).to_le_bytes())?;
        for value in values {
            self.out.write_all(&value.to_le_bytes())?;
        }
        self.count += 1;
        Ok(())
    }

    /// Writes the header that fits.
    fn complete(&mut self) -> io::Result<()> {
        if self.names.is_empty() {
            self.begin(0, &[])?;
        }
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&header(&descriptor(&self.names), self.count))?;
        self.out.flush()
    }
}

impl NpyFile {
    /// Begins the file that will be at `path`.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(NpyFile { rows: Rows::new(AtomicFile::create(path)?) })
    }

    /// Gives the file its name, in place of a file that has it.
    pub fn finish(mut self) -> io::Result<()> {
        self.rows.complete()?;
        self.rows.out.commit()
    }
}

impl NpzFile {
    /// Begins the file that will be at `path`.
    pub fn create(path: &Path) -> io::Result<Self> {
        let columns = AtomicFile::create(path)?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let rows = tempfile::tempfile_in(folder.unwrap_or(Path::new(".")))?;
        Ok(NpzFile { rows: Rows::new(BufWriter::new(rows)), columns })
    }

    /// Writes the columns and gives the file its name, in place of a file that has it.
    pub fn finish(mut self) -> io::Result<()> {
        self.rows.complete()?;
        let Rows { out, names, count, .. } = self.rows;
        let mut rows = out.into_inner().map_err(io::IntoInnerError::into_error)?;
        let data = header(&descriptor(&names), count).len() as u64;
        let mut zip = ZipWriter::new(self.columns);
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(count.saturating_mul(8) > u64::from(u32::MAX) / 2);
        for (column, name) in names.iter().enumerate() {
            zip.start_file(format!("{name}.npy"), options).map_err(io::Error::other)?;
            zip.write_all(&header("'<f8'", count))?;
            rows.seek(SeekFrom::Start(data))?;
            let mut reader = BufReader::with_capacity(1 << 16, &rows);
            let mut row = vec![0_u8; 8 * names.len()];
            for _ in 0..count {
                reader.read_exact(&mut row)?;
                zip.write_all(row.get(8 * column..8 * column + 8).unwrap_or_default())?;
            }
        }
        zip.finish().map_err(io::Error::other)?.commit()
    }
}

macro_rules! recorder {
    ($file:ty) => {
        impl Recorder for $file {
            fn begin(&mut self, record: usize, columns: &[Column], _: usize) -> io::Result<()> {
                self.rows.begin(record, columns)
            }

            fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
                self.rows.row(time, values)
            }

            fn end(&mut self) -> io::Result<()> {
                self.rows.out.flush()
            }
        }
    };
}

recorder!(NpyFile);
recorder!(NpzFile);

/// `descr` of an array of rows with these fields.
fn descriptor(names: &[String]) -> String {
    let fields: Vec<String> =
        names.iter().map(|name| format!("({}, '<f8')", quoted(name))).collect();
    format!("[{}]", fields.join(", "))
}

/// A Python string.
fn quoted(name: &str) -> String {
    let mut text = String::from("'");
    for character in name.chars() {
        match character {
            '\'' | '\\' => text.extend(['\\', character]),
            c if c.is_control() => text.push_str(&format!("\\x{:02x}", u32::from(c).min(255))),
            c => text.push(c),
        }
    }
    text + "'"
}

/// The header of an array of so many rows; its length does not depend on their number.
fn header(descriptor: &str, rows: u64) -> Vec<u8> {
    let shape = format!("({rows},), }}");
    let mut text = format!("{{'descr': {descriptor}, 'fortran_order': False, 'shape': ");
    let longest = text.len() + "(,), }".len() + DIGITS;
    text.push_str(&shape);
    let prefix: &[u8] = match text.is_ascii() && longest < 60_000 {
        true => b"\x93NUMPY\x01\x00",
        false => b"\x93NUMPY\x03\x00",
    };
    let head = if prefix.get(6) == Some(&1) { 10 } else { 12 };
    // At least the line break follows.
    let length = (head + longest + 1).next_multiple_of(ALIGNMENT) - head;
    let mut bytes = prefix.to_vec();
    match head {
        10 => bytes.extend((length as u16).to_le_bytes()),
        _ => bytes.extend((length as u32).to_le_bytes()),
    }
    bytes.extend(text.as_bytes());
    bytes.resize(head + length - 1, b' ');
    bytes.push(b'\n');
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_aligned_and_as_long_for_any_number_of_rows() {
        for name in ["position[1]", "position µ", &"x".repeat(70_000)] {
            let names = vec![name.to_owned()];
            let lengths: Vec<usize> =
                [0, 9, 10, u64::MAX].map(|rows| header(&descriptor(&names), rows).len()).to_vec();
            assert!(lengths.iter().all(|n| *n == lengths[0] && n % ALIGNMENT == 0), "{lengths:?}");
        }
        let text = String::from_utf8_lossy(&header("'<f8'", 3)).into_owned();
        assert!(text.ends_with('\n') && text.contains("'shape': (3,), }"), "{text}");
        assert_eq!(quoted("a'b\\c"), "'a\\'b\\\\c'");
    }
}
