//! The journal: an append-only file that is good up to its last whole block.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `PZLJRNL1` |
//! | 4, n | length and text of the description, JSON |
//! | 4 | CRC-32 of the description |
//! | then, per block: 4 | number of values, a multiple of the columns |
//! | 8 n | the values, f64 |
//! | 4 | CRC-32 of number and values |
//!
//! All numbers are little-endian. A block is handed to the operating system when it is written: a
//! killed process loses nothing of it. Once per second the file is put on disk.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::cycle::Column;

const MAGIC: &[u8; 8] = b"PZLJRNL1";
/// Longest description and block that is believed.
const LONGEST: u32 = 1 << 26;
/// How often the file is put on disk.
const SYNC: Duration = Duration::from_secs(1);

/// What a journal says about itself.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct About {
    /// The columns; the first is time in s.
    pub columns: Vec<Column>,
    /// Where it comes from: versions, hashes of FMU and plan, seed, begin.
    pub provenance: serde_json::Map<String, serde_json::Value>,
}

/// A journal that cannot be written or read.
#[derive(Debug, Error)]
pub enum JournalError {
    /// What the operating system says.
    #[error("{}: cannot be {what}: {error}; check the folder, its permissions and the free space", path.display())]
    Io {
        /// File.
        path: PathBuf,
        /// `written` or `read`.
        what: &'static str,
        /// What the system says.
        error: io::Error,
    },
    /// It ends within its description.
    #[error("{}: its {bytes} bytes end within its description; a run that was killed as it began leaves that, without a row: delete it", path.display())]
    Short {
        /// File.
        path: PathBuf,
        /// The path's length.
        bytes: u64,
    },
    /// It is none.
    #[error("{}: is no journal of the bench: {rule}; give the file that `bench run` left, which ends in .journal", path.display())]
    NotOne {
        /// File.
        path: PathBuf,
        /// What is wrong.
        rule: &'static str,
    },
}

/// A journal that is written.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    block: Vec<u8>,
    synced: Instant,
}

impl Journal {
    /// Begins a journal; there must be none of this name yet.
    ///
    /// # Errors
    /// The file is there, or cannot be written.
    pub fn create(path: &Path, about: &About) -> Result<Self, JournalError> {
        let failed = |error| JournalError::Io { path: path.to_owned(), what: "written", error };
        let mut file = File::create_new(path).map_err(failed)?;
        let text = serde_json::to_vec(about).map_err(|error| failed(error.into()))?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(&text);
        bytes.extend(crc32fast::hash(&text).to_le_bytes());
        file.write_all(&bytes).and_then(|()| file.sync_all()).map_err(failed)?;
        Ok(Journal { path: path.to_owned(), file, block: Vec::new(), synced: Instant::now() })
    }

    /// The journal's file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes whole rows as one block.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn write(&mut self, values: &[f64]) -> Result<(), JournalError> {
        if values.is_empty() {
            return Ok(());
        }
        self.block.clear();
        self.block.extend((values.len() as u32).to_le_bytes());
        values.iter().for_each(|value| self.block.extend(value.to_le_bytes()));
        let checksum = crc32fast::hash(&self.block);
        self.block.extend(checksum.to_le_bytes());
        let written = self.file.write_all(&self.block);
        let written = match self.synced.elapsed() >= SYNC {
            true => {
                self.synced = Instant::now();
                written.and_then(|()| self.file.sync_data())
            }
            false => written,
        };
        written.map_err(|error| self.failed(error))
    }

    /// Puts everything on disk.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn finish(self) -> Result<PathBuf, JournalError> {
        self.file.sync_all().map_err(|error| self.failed(error))?;
        Ok(self.path)
    }

    fn failed(&self, error: io::Error) -> JournalError {
        JournalError::Io { path: self.path.clone(), what: "written", error }
    }
}

/// A journal that is read, whole or broken off.
#[derive(Debug)]
pub struct JournalReader {
    path: PathBuf,
    file: BufReader<File>,
    about: About,
    /// Bytes behind the last whole block.
    broken: u64,
}

impl JournalReader {
    /// Opens a journal.
    ///
    /// # Errors
    /// The file cannot be read, or is no journal.
    pub fn open(path: &Path) -> Result<Self, JournalError> {
        let failed = |error| JournalError::Io { path: path.to_owned(), what: "read", error };
        let not = |rule| JournalError::NotOne { path: path.to_owned(), rule };
        let mut file = BufReader::new(File::open(path).map_err(failed)?);
        let mut magic = Vec::new();
        file.by_ref().take(8).read_to_end(&mut magic).map_err(failed)?;
        if !MAGIC.starts_with(&magic) {
            return Err(not("it does not begin with PZLJRNL1"));
        }
        let bytes = file.get_ref().metadata().map_err(failed)?.len();
        let short = || JournalError::Short { path: path.to_owned(), bytes };
        let text = sized(&mut file, 1).ok_or_else(short)?;
        let mut checksum = [0; 4];
        file.read_exact(&mut checksum).map_err(|_| short())?;
        if crc32fast::hash(&text).to_le_bytes() != checksum {
            return Err(not("its description is damaged"));
        }
        let about: About = serde_json::from_slice(&text)
            .map_err(|_| not("its description is of another version"))?;
        Ok(JournalReader { path: path.to_owned(), file, about, broken: 0 })
    }

    /// What the journal reader says about itself.
    #[must_use]
    pub fn about(&self) -> &About {
        &self.about
    }

    /// The rows of the next whole block; none at the end, or where the journal breaks off.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn block(&mut self) -> Result<Option<Vec<f64>>, JournalError> {
        let before = io::Seek::stream_position(&mut self.file).map_err(|e| self.failed(e))?;
        let block = self.complete_block();
        if block.is_none() {
            let length = self.file.get_ref().metadata().map_err(|e| self.failed(e))?.len();
            self.broken = length - before.min(length);
        }
        Ok(block)
    }

    fn complete_block(&mut self) -> Option<Vec<f64>> {
        let bytes = sized(&mut self.file, 8)?;
        let mut checksum = [0; 4];
        self.file.read_exact(&mut checksum).ok()?;
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&((bytes.len() / 8) as u32).to_le_bytes());
        hasher.update(&bytes);
        if hasher.finalize().to_le_bytes() != checksum {
            return None;
        }
        let (values, _) = bytes.as_chunks::<8>();
        let complete = values.len().is_multiple_of(self.about.columns.len().max(1));
        complete.then(|| values.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
    }

    /// Bytes behind the last whole block, once the end was reached.
    #[must_use]
    pub fn broken(&self) -> u64 {
        self.broken
    }

    fn failed(&self, error: io::Error) -> JournalError {
        JournalError::Io { path: self.path.clone(), what: "read", error }
    }
}

/// A number and as many pieces of `size` bytes.
fn sized(file: &mut impl Read, size: u32) -> Option<Vec<u8>> {
    let mut count = [0; 4];
    file.read_exact(&mut count).ok()?;
    let length = u32::from_le_bytes(count).checked_mul(size).filter(|n| *n <= LONGEST)?;
    let mut bytes = Vec::new();
    file.take(length.into()).read_to_end(&mut bytes).ok()?;
    (bytes.len() == length as usize).then_some(bytes)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn about() -> About {
        let column =
            |name: &str| Column { name: name.into(), unit: None, description: String::new() };
        About { columns: vec![column("time"), column("y")], provenance: serde_json::Map::new() }
    }

    fn written(folder: &Path, blocks: &[Vec<f64>]) -> PathBuf {
        let path = folder.join("run.journal");
        let mut journal = Journal::create(&path, &about()).unwrap();
        blocks.iter().for_each(|block| journal.write(block).unwrap());
        journal.finish().unwrap()
    }

    fn read(path: &Path) -> (Vec<Vec<f64>>, u64) {
        let mut reader = JournalReader::open(path).unwrap();
        assert_eq!(reader.about(), &about());
        let blocks = std::iter::from_fn(|| reader.block().unwrap()).collect();
        (blocks, reader.broken())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn cut_anywhere_it_gives_every_block_before_the_cut(
            lengths in prop::collection::vec(1usize..6, 1..8), part in 0.0f64..1.0,
        ) {
            let folder = tempfile::tempdir().unwrap();
            let blocks: Vec<Vec<f64>> =
                lengths.iter().map(|n| (0..2 * n).map(|v| v as f64).collect()).collect();
            let path = written(folder.path(), &blocks);
            prop_assert_eq!(read(&path), (blocks.clone(), 0));
            let bytes = std::fs::read(&path).unwrap();
            let sizes: usize = blocks.iter().map(|block| 8 + 8 * block.len()).sum();
            let head = bytes.len() - sizes;
            let cut = head + (part * sizes as f64) as usize;
            std::fs::write(&path, &bytes[..cut]).unwrap();
            let (found, broken) = read(&path);
            let mut end = head;
            let complete = blocks.iter().take_while(|b| { end += 8 + 8 * b.len(); end <= cut }).count();
            prop_assert_eq!(&found[..], &blocks[..complete]);
            let kept: usize = found.iter().map(|block| 8 + 8 * block.len()).sum();
            prop_assert_eq!(broken as usize, cut - head - kept);
        }
    }

    #[test]
    fn a_damaged_block_ends_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = written(folder.path(), &[vec![1.0, 2.0], vec![3.0, 4.0]]);
        let mut bytes = std::fs::read(&path).unwrap();
        let last = bytes.len() - 9;
        bytes[last] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(read(&path), (vec![vec![1.0, 2.0]], 24));
    }

    #[test]
    fn other_files_and_existing_ones_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.journal");
        std::fs::write(&path, "time,y\n").unwrap();
        let message = JournalReader::open(&path).unwrap_err().to_string();
        assert!(message.contains("PZLJRNL1") && message.contains("x.journal"), "{message}");
        assert!(Journal::create(&path, &about()).unwrap_err().to_string().contains("exists"));
    }
}
