//! What the tests share: the measured logs, and random numbers with a printed seed.
#![allow(dead_code, reason = "each test binary uses a part")]

use std::path::{Path, PathBuf};

use data::{AxisBlueprint, SignalBlueprint};
use identify::{Columns, Record, Target};

/// The folder of a measured data set, or `None` with a line that says so where it is absent.
pub(crate) fn data_folder(name: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    #[allow(clippy::print_stdout, reason = "a test that is skipped says so")]
    {
        println!("SKIPPED: {} is absent", folder.display());
    }
    None
}

/// The columns of a CSV file with a header and no quotes.
pub(crate) fn csv(path: &Path) -> Vec<(String, Vec<f64>)> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut lines = text.lines();
    let header = lines.next().expect("a header row");
    let mut columns: Vec<(String, Vec<f64>)> =
        header.split(',').map(|name| (name.to_owned(), Vec::new())).collect();
    for line in lines.filter(|line| !line.is_empty()) {
        for ((_, column), field) in columns.iter_mut().zip(line.split(',')) {
            column.push(field.parse().unwrap_or_else(|e| panic!("{field}: {e}")));
        }
    }
    columns
}

/// A record of two columns of a CSV file.
pub(crate) fn record(path: &Path, input: &str, output: &str) -> Record {
    let columns = csv(path);
    let column = |name: &str| {
        let found = columns.iter().find(|(n, _)| n == name);
        found.map(|(_, values)| values.as_slice()).unwrap_or_else(|| panic!("no column {name}"))
    };
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    Record::new(Columns {
        name: &name,
        time: column("time"),
        input_name: input,
        input: column(input),
        output_name: output,
        output: column(output),
    })
    .unwrap_or_else(|problems| panic!("{problems:?}"))
}

/// A target with a command in V and a position in um.
pub(crate) fn target(model: &str) -> Target {
    let mut axis = AxisBlueprint::new("X", "V", "um");
    axis.command = SignalBlueprint::of_unit("V").named("u");
    axis.position = SignalBlueprint::of_unit("um").named("y");
    Target { model: model.to_owned(), source: "test".to_owned(), axis }
}
