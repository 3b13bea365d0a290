//! Files of other programs: tables of named columns, some in groups.

#[cfg(feature = "formats")]
mod mat;
#[cfg(feature = "formats")]
mod mdf;
#[cfg(feature = "formats")]
mod numpy;
#[cfg(feature = "formats")]
mod parquet;
#[cfg(feature = "formats")]
mod tdms;

use std::path::Path;

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
        // The parsers are other people's; a damaged file must not end the program.
        let found = std::panic::catch_unwind(|| match self {
            Self::Mat => mat::read(path).map(Found::from),
            Self::Mdf => mdf::read(path).map(Found::from),
            Self::Npy => numpy::array(path).map(Found::from),
            Self::Npz => numpy::archive(path).map(Found::from),
            Self::Parquet => parquet::read(path).map(Found::from),
            Self::Tdms => tdms::read(path).map(Found::from),
            Self::Hdf5 => Err((
                "is HDF5, as MATLAB 7.3 writes it, which is not read".into(),
                "save it with -v7, or as Parquet or CSV".into(),
            )),
        });
        let damaged = || ("is damaged: its reader gave up".to_owned(), "write it again".to_owned());
        let refuse = |(rule, way_out): Refusal| Problems::from(Problem::new(origin, rule, way_out));
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
