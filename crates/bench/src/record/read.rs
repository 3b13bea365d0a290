//! A record read back: its columns and what it says about itself.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use data::{Log, ReadOptions};
use parquet::file::reader::{FileReader, SerializedFileReader};
use serde::Deserialize;
use thiserror::Error;

use super::convert::Format;
use super::journal::{JournalError, JournalReader};

/// Longest comment of an MF4 file that is believed.
const LONGEST: u64 = 1 << 26;

/// A record that cannot be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The journal.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The log.
    #[error(transparent)]
    Log(#[from] data::Problems),
    /// It is no record of the bench, or damaged.
    #[error("{}: {rule}", path.display())]
    Record {
        /// File.
        path: PathBuf,
        /// What is wrong, and the way out.
        rule: String,
    },
}

/// A record of the bench.
#[derive(Clone, Debug)]
pub struct Recording {
    path: PathBuf,
    columns: BTreeMap<String, Vec<f64>>,
    provenance: BTreeMap<String, String>,
    notes: Vec<String>,
}

impl Recording {
    /// Reads a `.parquet`, `.csv` (with its `.about.json`), `.mf4`, or the `.journal` of a run that
    /// was killed.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        files::note_read(path);
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        if ending.as_deref() == Some("journal") {
            return Recording::of_journal(path);
        }
        let broken = |rule: String| ReadError::Record { path: path.to_owned(), rule };
        let format = Format::of(path).map_err(|_| {
            broken("a record is a .parquet, .csv or .mf4, or the .journal of a killed run".into())
        })?;
        let log = Log::read(path, &ReadOptions::default())?;
        let provenance = match format {
            Format::Csv => beside(&path.with_extension("about.json")),
            Format::Parquet => in_parquet(path),
            Format::Mf4 => in_mf4(path),
        };
        let provenance = provenance.map_err(broken)?;
        let columns = log.columns().iter().map(|c| (c.name.clone(), c.values.clone()));
        let time = [("time".to_owned(), log.time().to_vec())];
        let columns = columns.chain(time).collect();
        Ok(Recording { path: path.to_owned(), columns, provenance, notes: log.notes() })
    }

    fn of_journal(path: &Path) -> Result<Self, ReadError> {
        let mut reader = JournalReader::open(path)?;
        let names: Vec<String> = reader.about().columns.iter().map(|c| c.name.clone()).collect();
        let mut values = vec![Vec::new(); names.len()];
        while let Some(block) = reader.block()? {
            for row in block.chunks_exact(names.len().max(1)) {
                values.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
            }
        }
        let provenance = reader.about().provenance.iter();
        let provenance = provenance.map(|(key, value)| (key.clone(), text_of(value))).collect();
        let columns = names.into_iter().zip(values).collect();
        let cut = reader.broken();
        let note = format!("{}: its last {cut} bytes were cut off in a write", path.display());
        let notes = if cut > 0 { vec![note] } else { Vec::new() };
        Ok(Recording { path: path.to_owned(), columns, provenance, notes })
    }

    /// A column.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn column(&self, name: &str) -> Result<&[f64], ReadError> {
        let found = self.columns.get(name);
        found.map(Vec::as_slice).ok_or_else(|| {
            self.broken(format!("has no column {name}, which the bench writes; was it edited?"))
        })
    }

    /// What the record says about itself under this key.
    #[must_use]
    pub fn about(&self, key: &str) -> Option<&str> {
        self.provenance.get(key).map(String::as_str)
    }

    /// What was assumed when it was read.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// An error of this record.
    #[must_use]
    pub fn broken(&self, rule: String) -> ReadError {
        ReadError::Record { path: self.path.clone(), rule }
    }
}

fn text_of(value: &serde_json::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

type About = Result<BTreeMap<String, String>, String>;

/// What stands beside a CSV.
fn beside(path: &Path) -> About {
    let text = files::read_text(path).map_err(|error| {
        format!("the description that `bench run` writes beside a CSV record, {}, cannot be read: {error}; only records of the bench can be replayed", path.display())
    })?;
    let all: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&text)
        .map_err(|error| format!("{} is damaged: {error}", path.display()))?;
    Ok(all.iter().map(|(key, value)| (key.clone(), text_of(value))).collect())
}

fn in_parquet(path: &Path) -> About {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let reader = SerializedFileReader::new(file).map_err(|error| error.to_string())?;
    let pairs = reader.metadata().file_metadata().key_value_metadata();
    let pairs = pairs.into_iter().flatten();
    Ok(pairs.filter_map(|pair| Some((pair.key.clone(), pair.value.clone()?))).collect())
}

/// The properties in the comment of the header block: HD stands at byte 64, its sixth link is MD.
fn in_mf4(path: &Path) -> About {
    #[derive(Deserialize)]
    struct Comment {
        common_properties: Option<Properties>,
    }
    #[derive(Deserialize)]
    struct Properties {
        #[serde(default, rename = "e")]
        all: Vec<Property>,
    }
    #[derive(Deserialize)]
    struct Property {
        #[serde(rename = "@name")]
        name: String,
        #[serde(default, rename = "$text")]
        value: String,
    }
    let text = mf4_comment(path).map_err(|error| format!("its comment cannot be read: {error}"))?;
    let comment: Comment = quick_xml::de::from_str(&text)
        .map_err(|error| format!("its comment is no XML of MDF 4: {error}"))?;
    let all = comment.common_properties.map_or_else(Vec::new, |properties| properties.all);
    Ok(all.into_iter().map(|property| (property.name, property.value)).collect())
}

fn mf4_comment(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut number = |place: u64| -> io::Result<u64> {
        let mut bytes = [0; 8];
        file.seek(SeekFrom::Start(place))?;
        file.read_exact(&mut bytes)?;
        Ok(u64::from_le_bytes(bytes))
    };
    let block = number(64 + 24 + 5 * 8)?;
    let length = number(block.saturating_add(8))?;
    let text = length.checked_sub(24).filter(|length| block > 0 && *length < LONGEST);
    let text = text.ok_or_else(|| io::Error::other("there is none"))?;
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(block + 24))?;
    file.take(text).read_to_end(&mut bytes)?;
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    bytes.truncate(end);
    String::from_utf8(bytes).map_err(io::Error::other)
}
