//! What a report was made from.

use std::io::Read as _;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::error::ReportError;

/// What a report was made from: everything needed to make it again.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The tool's name.
    pub tool: String,
    /// The tool's version, with the commit if known.
    pub version: String,
    /// The command line as it was typed, one entry per argument.
    pub command_line: Vec<String>,
    /// The files that were read.
    pub files: Vec<InputFile>,
    /// The seed of all random numbers, if any were drawn.
    pub seed: Option<u64>,
    /// When it was made, as RFC 3339 in UTC; left out where equal inputs must give equal bytes.
    pub time: Option<String>,
    /// Anything else, as name and value.
    pub remarks: Vec<(String, String)>,
}

/// A file that was read, with its fingerprint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// What the input file was used as: `log`, `blueprint`, `FMU`, …
    pub role: String,
    /// The path as it was given.
    pub path: String,
    /// The input file's SHA-256, in hexadecimal.
    pub sha256: String,
    /// The input file's size in bytes.
    pub bytes: u64,
}

impl InputFile {
    /// Fingerprints a file.
    ///
    /// # Errors
    /// [`ReportError::Read`] if the file cannot be read.
    pub fn read(role: impl Into<String>, path: impl AsRef<Path>) -> Result<Self, ReportError> {
        let path = path.as_ref();
        let (sha256, bytes) = fingerprint(path)
            .map_err(|source| ReportError::Read { path: path.to_path_buf(), source })?;
        Ok(Self { role: role.into(), path: path.display().to_string(), sha256, bytes })
    }

    /// Fingerprints data that never was a file, such as embedded data.
    pub fn of_bytes(role: impl Into<String>, name: impl Into<String>, content: &[u8]) -> Self {
        Self {
            role: role.into(),
            path: name.into(),
            sha256: hex::encode(Sha256::digest(content)),
            bytes: content.len() as u64,
        }
    }
}

impl Provenance {
    /// Provenance with the tool's name and version.
    pub fn new(tool: impl Into<String>, version: impl Into<String>) -> Self {
        Self { tool: tool.into(), version: version.into(), ..Self::default() }
    }

    /// Sets the command line.
    #[must_use]
    pub fn command_line<S: Into<String>>(mut self, args: impl IntoIterator<Item = S>) -> Self {
        self.command_line = args.into_iter().map(Into::into).collect();
        self
    }

    /// Appends a file.
    #[must_use]
    pub fn file(mut self, file: InputFile) -> Self {
        self.files.push(file);
        self
    }

    /// Sets the seed.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = Some(seed);
        self
    }

    /// Sets the time, for example [`utc_timestamp`]`(SystemTime::now())`.
    #[must_use]
    pub fn time(mut self, time: impl Into<String>) -> Self {
        self.time = Some(time.into());
        self
    }

    /// Appends a remark.
    #[must_use]
    pub fn remark(mut self, name: impl Into<String>, value: impl Into<String>) -> Self {
        self.remarks.push((name.into(), value.into()));
        self
    }

    /// The command line as one line that a POSIX shell reads back.
    pub(crate) fn shell_line(&self) -> String {
        self.command_line.iter().map(|arg| quote(arg)).collect::<Vec<_>>().join(" ")
    }
}

fn fingerprint(path: &Path) -> std::io::Result<(String, u64)> {
    files::note_read(path);
    let mut file = std::fs::File::open(path)?;
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    let mut bytes = 0;
    loop {
        let n = file.read(&mut buffer)?;
        if n == 0 {
            return Ok((hex::encode(hash.finalize()), bytes));
        }
        hash.update(&buffer[..n]);
        bytes += n as u64;
    }
}

fn quote(arg: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=+,@%".contains(c);
    if !arg.is_empty() && arg.chars().all(plain) {
        arg.to_owned()
    } else {
        format!("'{}'", arg.replace('\'', r"'\''"))
    }
}

/// A point in time as RFC 3339 in UTC, to the second: `2026-11-21T09:30:00Z`.
///
/// Days are counted by the algorithm of Howard Hinnant, *chrono-compatible low-level date
/// algorithms*; a time before 1970 is given as 1970-01-01.
pub fn utc_timestamp(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_secs());
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn timestamps_know_leap_years_and_year_ends() {
        for (seconds, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_704_067_199, "2023-12-31T23:59:59Z"),
            (1_709_208_000, "2024-02-29T12:00:00Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(utc_timestamp(UNIX_EPOCH + Duration::from_secs(seconds)), text);
        }
    }

    #[test]
    fn a_file_and_its_bytes_have_the_same_fingerprint() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc");
        std::fs::write(&path, "abc").unwrap();
        let file = InputFile::read("log", &path).unwrap();
        // FIPS 180-2, appendix B.1.
        assert_eq!(file.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        assert_eq!(file.sha256, InputFile::of_bytes("log", "abc", b"abc").sha256);
        assert_eq!(file.bytes, 3);
    }

    #[test]
    fn the_command_line_reads_back_in_a_shell() {
        let line = Provenance::new("t", "1").command_line(["a", "b c", "it's", ""]).shell_line();
        assert_eq!(line, r"a 'b c' 'it'\''s' ''");
    }
}
