//! The journal of a sweep under way: an append-only file that is good up to its last whole row.
//!
//! First a line `piezoloop-sweep/1 FINGERPRINT`, then for each row, in the order in which they came:
//! number of bytes and CRC-32, both `u32` little-endian, and the row by `postcard`. A row is handed to
//! the operating system as it comes: a killed process loses at most the runs it was at.

use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::row::Row;

/// Longest row that is believed.
const LONGEST: u32 = 1 << 26;

/// The first line of the journal of a sweep.
fn head(fingerprint: &str) -> String {
    format!("piezoloop-sweep/1 {fingerprint}\n")
}

/// A row as it stands in a journal.
#[must_use]
pub fn frame(row: &Row) -> Vec<u8> {
    // Rows hold nothing that postcard cannot write.
    let bytes = postcard::to_allocvec(row).unwrap_or_default();
    let mut frame = Vec::with_capacity(bytes.len() + 8);
    frame.extend((bytes.len() as u32).to_le_bytes());
    frame.extend(crc32fast::hash(&bytes).to_le_bytes());
    frame.extend(bytes);
    frame
}

/// The whole rows at the beginning of `bytes`, and how many bytes they take.
fn frames(bytes: &[u8]) -> (Vec<Row>, usize) {
    let (mut rows, mut at) = (Vec::new(), 0);
    while let Some((row, length)) = bytes.get(at..).and_then(first) {
        rows.push(row);
        at += length;
    }
    (rows, at)
}

fn first(bytes: &[u8]) -> Option<(Row, usize)> {
    let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let (length, checksum) = (number(0)?, number(4)?);
    if length == 0 || length > LONGEST {
        return None;
    }
    let end = 8 + length as usize;
    let content = bytes.get(8..end)?;
    if crc32fast::hash(content) != checksum {
        return None;
    }
    Some((postcard::from_bytes(content).ok()?, end))
}

/// A journal that is open for this process alone.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Opens the journal of this sweep, or begins it; also the rows that it holds. What stands
    /// behind the last whole row is cut off.
    ///
    /// # Errors
    /// It belongs to another sweep, another process has it, or it cannot be read or written.
    pub fn open(path: &Path, fingerprint: &str) -> Result<(Self, Vec<Row>), Error> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(path).map_err(|error| Error::written(path, error))?;
        if file.try_lock().is_err() {
            let rule = "another process runs this sweep";
            return Err(Error::file(path, rule, "wait for it, or give another --out"));
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(|error| Error::read(path, error))?;
        let head = head(fingerprint);
        let written = |error| Error::written(path, error);
        if head.as_bytes().starts_with(&bytes) && bytes.len() < head.len() {
            // New, or killed before the first line was whole.
            file.set_len(0).and_then(|()| file.rewind()).map_err(written)?;
            file.write_all(head.as_bytes()).map_err(written)?;
            return Ok((Journal { path: path.to_owned(), file }, Vec::new()));
        }
        if !bytes.starts_with(head.as_bytes()) {
            let rule = "holds the runs of another sweep: the plan, one of its files or this tool \
                        has changed since";
            let way_out = "delete it to begin anew, or give another --out";
            return Err(Error::file(path, rule, way_out));
        }
        let (rows, length) = frames(&bytes[head.len()..]);
        let end = (head.len() + length) as u64;
        file.set_len(end).map_err(written)?;
        file.seek(SeekFrom::Start(end)).map_err(written)?;
        Ok((Journal { path: path.to_owned(), file }, rows))
    }

    /// Adds a row.
    ///
    /// # Errors
    /// What the system says.
    pub fn add(&mut self, row: &Row) -> Result<(), Error> {
        self.file.write_all(&frame(row)).map_err(|error| Error::written(&self.path, error))
    }

    /// Deletes it: its rows are in a table now.
    ///
    /// # Errors
    /// What the system says.
    pub fn remove(self) -> Result<(), Error> {
        std::fs::remove_file(&self.path).map_err(|error| Error::written(&self.path, error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Cell;

    fn row(run: u64) -> Row {
        let cells = vec![Cell::Real(0.1 * run as f64), Cell::Text("a".into()), Cell::Missing];
        Row { run, cells }
    }

    #[test]
    fn a_torn_end_is_cut_off_and_the_journal_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("j");
        let (mut journal, rows) = Journal::open(&path, "f").unwrap();
        assert!(rows.is_empty());
        (0..3).for_each(|run| journal.add(&row(run)).unwrap());
        drop(journal);
        let complete = std::fs::read(&path).unwrap();
        for cut in 0..complete.len() {
            std::fs::write(&path, &complete[..cut]).unwrap();
            let (mut journal, rows) = Journal::open(&path, "f").unwrap();
            assert!(rows.len() < 3, "{cut}");
            (rows.len() as u64..3).for_each(|run| journal.add(&row(run)).unwrap());
            drop(journal);
            assert_eq!(std::fs::read(&path).unwrap(), complete, "cut at {cut}");
        }
        let mut bad = complete.clone();
        *bad.last_mut().unwrap() ^= 1;
        std::fs::write(&path, &bad).unwrap();
        assert_eq!(Journal::open(&path, "f").unwrap().1, vec![row(0), row(1)]);
    }

    #[test]
    fn another_sweep_and_another_process_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("j");
        let (journal, _) = Journal::open(&path, "f").unwrap();
        let text = Journal::open(&path, "f").unwrap_err().to_string();
        assert!(text.contains("another process"), "{text}");
        drop(journal);
        let text = Journal::open(&path, "g").unwrap_err().to_string();
        assert!(text.contains("another sweep") && text.contains("--out"), "{text}");
    }
}
