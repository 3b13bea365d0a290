//! Small tables of ten rows, and what is expected of them.

use data::{Log, ReadOptions};

pub(crate) fn read(text: impl AsRef<[u8]>) -> Log {
    read_with(text, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn read_with(text: impl AsRef<[u8]>, options: &ReadOptions) -> Result<Log, String> {
    Log::parse(text.as_ref(), "log.txt", options).map_err(|problems| problems.to_string())
}

/// Rows k = 0 … 9 of `row(k)` behind `head`.
pub(crate) fn table(head: &str, row: impl Fn(u32) -> String) -> String {
    let rows: Vec<String> = (0..10).map(row).collect();
    format!("{head}{}\n", rows.join("\n"))
}

/// A log of ten rows: u = k V and y = k/2 um at these times.
pub(crate) fn is(log: &Log, times: impl Fn(f64) -> f64, columns: [(&str, Option<&str>); 2]) {
    assert_eq!(log.len(), 10);
    for (row, time) in log.time().iter().enumerate() {
        assert!((time - times(row as f64)).abs() < 1e-12, "row {row}: {time}");
    }
    let factors = [1.0, 0.5];
    assert_eq!(log.columns().len(), 2, "{:?}", log.columns());
    for ((name, unit), factor) in columns.into_iter().zip(factors) {
        let column = log.column(name).unwrap_or_else(|| panic!("no {name}: {:?}", log.columns()));
        assert_eq!(column.unit.as_ref().map(|unit| unit.text.as_str()), unit, "{name}");
        for (row, value) in column.values.iter().enumerate() {
            assert_eq!(*value, factor * row as f64, "{name} row {row}");
        }
    }
}

pub(crate) fn notes(log: &Log) -> String {
    log.notes().join("\n")
}

pub(crate) fn ms(k: f64) -> f64 {
    k / 1000.0
}

pub(crate) fn comma_half(k: u32) -> String {
    (f64::from(k) / 2.0).to_string().replace('.', ",")
}

pub(crate) fn comma(k: u32) -> String {
    format!("{},{},{}", f64::from(k) / 1000.0, k, f64::from(k) / 2.0)
}

pub(crate) const PLAIN: [(&str, Option<&str>); 2] = [("u", None), ("y", None)];

pub(crate) const UNITS: [(&str, Option<&str>); 2] = [("u", Some("V")), ("y", Some("um"))];
