//! Files of other programs: tables of named columns, some in groups.

#[cfg(feature = "formats")]
mod arrow;
#[cfg(feature = "formats")]
mod budget;
#[cfg(feature = "formats")]
mod half;
#[cfg(feature = "formats")]
mod matlab;
#[cfg(feature = "formats")]
mod mdf;
#[cfg(feature = "formats")]
mod names;
#[cfg(feature = "formats")]
mod numpy;
#[cfg(feature = "formats")]
mod parquet;
#[cfg(feature = "formats")]
mod table;
#[cfg(feature = "formats")]
mod tdms;
#[cfg(feature = "formats")]
mod universal;

use std::path::Path;

#[cfg(feature = "formats")]
use self::budget::Budget;
use super::dataset::Dataset;
#[cfg(feature = "formats")]
use super::group::{Found, Refusal};
use super::{Log, ReadOptions};
use crate::{Problem, Problems};

/// Formats that are known, read or refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// MATLAB 5, of `save -v7` or older.
    Mat,
    /// MATLAB 4, and results of Dymola and OpenModelica.
    #[cfg_attr(
        not(feature = "formats"),
        expect(dead_code, reason = "told by its contents, with its reader")
    )]
    Mat4,
    /// HDF5, which MATLAB 7.3 is too.
    Hdf5,
    /// ASAM MDF, version 3 or 4.
    Mdf,
    /// One NumPy array.
    Npy,
    /// NumPy arrays by name, a zip archive.
    Npz,
    /// Apache Parquet.
    Parquet,
    /// National Instruments' TDMS.
    Tdms,
    /// Universal file of modal testing.
    #[cfg_attr(
        not(feature = "formats"),
        expect(dead_code, reason = "told by its contents, with its reader")
    )]
    Universal,
}

impl Format {
    /// The format of a file that begins like this; `None` for what may be text.
    pub(super) fn of(path: &Path, start: &[u8]) -> Option<Self> {
        let is_npz = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz"));
        match start {
            [b'M', b'A', b'T', b'L', b'A', b'B', b' ', b'7', b'.', ..] => Some(Self::Hdf5),
            [0x89, b'H', b'D', b'F', ..] => Some(Self::Hdf5),
            [b'M', b'A', b'T', b'L', b'A', b'B', b' ', ..] => Some(Self::Mat),
            [b'M', b'D', b'F', b' ', ..] | [b'U', b'n', b'F', b'i', b'n', b'M', b'F', ..] => {
                Some(Self::Mdf)
            }
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Some(Self::Npy),
            [b'P', b'K', 3 | 5, 4 | 6, ..] if is_npz => Some(Self::Npz),
            [b'P', b'A', b'R', b'1', ..] => Some(Self::Parquet),
            [b'T', b'D', b'S', b'm', ..] => Some(Self::Tdms),
            #[cfg(feature = "formats")]
            _ if universal::is_begin(start) => Some(Self::Universal),
            #[cfg(feature = "formats")]
            _ if matlab::v4::is_begin(start) => Some(Self::Mat4),
            _ => None,
        }
    }

    /// Reads a file of this format.
    #[cfg(feature = "formats")]
    pub(super) fn read(
        self,
        path: &Path,
        origin: &str,
        options: &ReadOptions,
        datasets: &[Dataset],
    ) -> Result<Log, Problems> {
        options.check(origin)?;
        let refuse = |(rule, way_out): Refusal| Problems::from(Problem::new(origin, rule, way_out));
        let size = std::fs::metadata(path).map_err(|error| refuse(broken("a file", error)))?.len();
        // Where the user says what the times are, no reader looks for them.
        let is_said = |dataset: &Dataset| dataset.rate.is_some() || dataset.time_column.is_some();
        let is_timed = options.rate.is_some() || datasets.iter().any(is_said);
        // Parsers are other people's; a damaged file must not end the program.
        let found = std::panic::catch_unwind(|| {
            let budget = &mut Budget::new(size, options.memory);
            match self {
                Self::Mat => matlab::version_5(path, budget, is_timed),
                Self::Mat4 => matlab::version_4(path, budget, is_timed),
                Self::Hdf5 => matlab::version_7_3(path, budget, is_timed),
                Self::Mdf => mdf::read(path, budget),
                Self::Npy => numpy::array(path, budget).map(Found::from),
                Self::Npz => numpy::archive(path, budget).map(Found::from),
                Self::Parquet => parquet::read(path, budget).map(Found::from),
                Self::Tdms => tdms::read(path, budget, is_timed),
                Self::Universal => universal::read(path, budget),
            }
        });
        let damaged = || ("is damaged: its reader gave up".to_owned(), "write it again".to_owned());
        let found = found.unwrap_or_else(|_| Err(damaged())).map_err(refuse)?;
        found.log(origin, options, datasets)
    }

    /// Refuses the file: this build reads texts only.
    #[cfg(not(feature = "formats"))]
    pub(super) fn read(
        self,
        _: &Path,
        origin: &str,
        _: &ReadOptions,
        _: &[Dataset],
    ) -> Result<Log, Problems> {
        let rule = format!("is no text but {self:?}, which this build does not read");
        Err(Problem::new(origin, rule, "save it as CSV, or build with the feature formats").into())
    }
}

/// A refusal with what another library says.
#[cfg(feature = "formats")]
fn broken(what: &str, error: impl std::fmt::Display) -> Refusal {
    let way_out = "check that the file is whole; other tools can save it as CSV or Parquet";
    (format!("cannot be read as {what}: {error}"), way_out.into())
}
