//! Files of other programs: tables of named columns, some in groups.

mod arrow;
mod budget;
mod half;
mod matlab;
mod mdf;
mod names;
mod numpy;
mod parquet;
mod table;
mod tdms;
mod universal;
mod wav;

use std::path::Path;

use self::budget::Budget;
use super::dataset::Dataset;
use super::group::{Found, Refusal};
use super::{Log, ReadOptions};
use crate::{Problem, Problems};

/// A format of logs that is no text.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Short name, also that of its examples, `dev/fuzz/corpus/log-NAME`.
    pub name: &'static str,
    /// The ending that its files usually have.
    pub ending: &'static str,
    /// Whether a file with these first bytes is one.
    begins: fn(&Path, &[u8]) -> bool,
    /// Reads one; the last argument: whether the user says what the times are, so that no reader looks for them.
    read: fn(&Path, &mut Budget, bool) -> Result<Found, Refusal>,
}

/// All formats, each with the bytes by which a file is recognised; the first that fits is it.
pub(super) const FORMATS: &[Format] = &[
    format("hdf5", "mat", |_, start| is_hdf5(start), matlab::version_7_3),
    format("mat", "mat", |_, start| start.starts_with(b"MATLAB "), matlab::version_5),
    format("mf4", "mf4", |_, start| is_mdf(start), |path, budget, _| mdf::read(path, budget)),
    format(
        "npy",
        "npy",
        |_, start| start.starts_with(b"\x93NUMPY"),
        |path, budget, _| numpy::array(path, budget).map(Found::from),
    ),
    format("npz", "npz", is_npz, |path, budget, _| numpy::archive(path, budget).map(Found::from)),
    format(
        "parquet",
        "parquet",
        |_, start| start.starts_with(b"PAR1"),
        |path, budget, _| parquet::read(path, budget).map(Found::from),
    ),
    format("tdms", "tdms", |_, start| start.starts_with(b"TDSm"), tdms::read),
    format("uff", "uff", |_, start| universal::is_begin(start), universal::read),
    format("wav", "wav", |_, start| wav::is_begin(start), wav::read),
    format("mat4", "mat", |_, start| matlab::v4::is_begin(start), matlab::version_4),
];

const fn format(
    name: &'static str,
    ending: &'static str,
    begins: fn(&Path, &[u8]) -> bool,
    read: fn(&Path, &mut Budget, bool) -> Result<Found, Refusal>,
) -> Format {
    Format { name, ending, begins, read }
}

/// HDF5, which MATLAB 7.3 is too.
fn is_hdf5(start: &[u8]) -> bool {
    start.starts_with(b"MATLAB 7.") || start.starts_with(b"\x89HDF")
}

fn is_mdf(start: &[u8]) -> bool {
    start.starts_with(b"MDF ") || start.starts_with(b"UnFinMF")
}

/// Other zip archives are no logs.
fn is_npz(path: &Path, start: &[u8]) -> bool {
    let is_named = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz"));
    is_named && matches!(start, [b'P', b'K', 3 | 5, 4 | 6, ..])
}

impl Format {
    /// The format of a file that begins like this; `None` for what may be text.
    pub(super) fn of(path: &Path, start: &[u8]) -> Option<Self> {
        FORMATS.iter().find(|format| (format.begins)(path, start)).copied()
    }

    /// Reads a file of this format.
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
        let is_stated = |dataset: &Dataset| dataset.rate.is_some() || dataset.time_column.is_some();
        let is_timed = options.rate.is_some() || datasets.iter().any(is_stated);
        // Parsers are other people's; a damaged file must not end the program.
        let found = std::panic::catch_unwind(|| {
            (self.read)(path, &mut Budget::new(size, options.memory), is_timed)
        });
        let damaged = || ("is damaged: its reader gave up".to_owned(), "write it again".to_owned());
        let found = found.unwrap_or_else(|_| Err(damaged())).map_err(refuse)?;
        found.log(origin, options, datasets)
    }
}

/// A refusal with what another library says.
fn broken(what: &str, error: impl std::fmt::Display) -> Refusal {
    let way_out = "check that the file is whole; other tools can save it as CSV or Parquet";
    (format!("cannot be read as {what}: {error}"), way_out.into())
}
