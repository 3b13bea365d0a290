//! Universal files of modal testing: dataset 58 as text and with binary values.
#![cfg(feature = "formats")]

use std::fs;
use std::path::Path;

use data::{Log, ReadOptions};

const ROWS: usize = 50;

/// How a dataset has its values.
#[derive(Clone, Copy, PartialEq)]
enum NumberForm {
    Text,
    Glued,
    Binary { is_little: bool },
}

fn value(k: usize, size: f64) -> f64 {
    // Nothing that a decimal number of 13 digits rounds.
    size * (k as f64 - 20.0) / 16.0
}

/// A dataset 58; `kind` is its function type, `even` whether its times are.
fn dataset(name: &str, unit: &str, kind: u8, size: f64, even: bool, way: NumberForm) -> Vec<u8> {
    let numbers: Vec<f64> = (0..ROWS)
        .flat_map(|k| {
            let time = (!even).then_some(k as f64 / 512.0 + f64::from(u8::from(k > 9)));
            time.into_iter().chain([value(k, size)])
        })
        .collect();
    let data: Vec<u8> = match way {
        NumberForm::Binary { is_little: true } => {
            numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
        }
        NumberForm::Binary { is_little: false } => {
            numbers.iter().flat_map(|x| x.to_be_bytes()).collect()
        }
        NumberForm::Text => numbers
            .chunks(4)
            .map(|row| row.iter().map(|x| format!(" {x:19.12e}")).collect::<String>() + "\r\n")
            .collect::<String>()
            .into_bytes(),
        // Fields of full width without a blank between them.
        NumberForm::Glued => {
            let field = |(k, x): (usize, &f64)| {
                if !even && k % 2 == 0 { format!("{x:+013.5E}") } else { format!("{x:+020.12E}") }
            };
            let fields: Vec<String> = numbers.iter().enumerate().map(field).collect();
            fields
                .chunks(4)
                .map(|row| row.concat() + "\n")
                .collect::<String>()
                .replace('E', "D")
                .into_bytes()
        }
    };
    let begin = match way {
        NumberForm::Binary { is_little } => {
            let order = 2 - u8::from(is_little);
            format!(
                "    58b{order:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}",
                2,
                11,
                data.len(),
                0,
                0,
                0,
                0
            )
        }
        _ => format!("{:>6}", 58),
    };
    let step = if even { 1.0 / 512.0 } else { 0.0 };
    let head = format!(
        "    -1\n{begin}\n{name}\nNONE\nNONE\nNONE\nNONE\n\
         {kind:5}{:10}{:5}{:10} {:>10}{:10}{:4} {:>10}{:10}{:4}\n\
         {:10}{ROWS:10}{:10}{:13.5e}{step:13.5e}{:13.5e}\n\
         {:10}{:5}{:5}{:5} {:<20} {:<20}\n\
         {:10}{:5}{:5}{:5} {:<20} {unit:<20}\n\
         {:10}{:5}{:5}{:5} {:<20} {:<20}\n{:10}{:5}{:5}{:5} {:<20} {:<20}\n",
        0,
        0,
        0,
        "NONE",
        7,
        3,
        "NONE",
        1,
        3,
        4,
        u8::from(even),
        0.0,
        0.0,
        17,
        0,
        0,
        0,
        "Time",
        "s",
        8,
        0,
        0,
        0,
        "out",
        0,
        0,
        0,
        0,
        "NONE",
        "NONE",
        0,
        0,
        0,
        0,
        "NONE",
        "NONE",
    );
    [head.into_bytes(), data, b"    -1\n".to_vec()].concat()
}

fn read(folder: &Path, bytes: &[u8]) -> Result<Log, data::Problems> {
    let file = folder.join("modal.uff");
    fs::write(&file, bytes).unwrap();
    Log::read(&file, &ReadOptions::default())
}

#[test]
fn time_responses_are_columns_whatever_way_they_are_written() {
    let folder = tempfile::tempdir().unwrap();
    for even in [true, false] {
        let ways = [
            NumberForm::Text,
            NumberForm::Glued,
            NumberForm::Binary { is_little: true },
            NumberForm::Binary { is_little: false },
        ];
        for way in ways {
            let file = [
                b"    -1\n   164\n         1SI: Meter\n    -1\n".to_vec(),
                dataset("command", "V", 1, 1.0, even, way),
                dataset("NONE", "um", 1, 3.0, even, way),
                dataset("answer", "NONE", 4, 1.0, even, way),
            ]
            .concat();
            let log = read(folder.path(), &file).unwrap();
            let names: Vec<&str> = log.columns().iter().map(|c| c.name.as_str()).collect();
            assert_eq!(names, ["command", "node7+z"]);
            for (column, (size, unit)) in log.columns().iter().zip([(1.0, "V"), (3.0, "um")]) {
                let expected: Vec<f64> = (0..ROWS).map(|k| value(k, size)).collect();
                assert_eq!(column.values, expected);
                assert_eq!(column.unit.as_ref().unwrap().text, unit);
            }
            let gap = if even { 0.0 } else { 1.0 };
            // Some times stand with six digits.
            assert!((log.time()[49] - 49.0 / 512.0 - gap).abs() < 1e-5, "{}", log.time()[49]);
            let notes = log.notes().join("\n");
            assert!(notes.contains("1 functions that are no real time responses"), "{notes}");
            assert!(notes.contains("dataset 164"), "{notes}");
        }
    }
}

#[test]
fn what_is_cut_off_or_has_no_time_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let complete = dataset("u", "V", 1, 1.0, true, NumberForm::Binary { is_little: true });
    let refused = |bytes: &[u8]| read(folder.path(), bytes).unwrap_err().to_string();
    assert!(refused(&complete[..complete.len() - 100]).contains("ends within"));
    let text = dataset("u", "V", 1, 1.0, true, NumberForm::Text);
    assert!(refused(&text[..text.len() - 200]).contains("of 50 values"));
    let spectrum = dataset("u", "V", 4, 1.0, true, NumberForm::Text);
    assert!(refused(&spectrum).contains("without a time response (1 other functions)"));
    for end in (0..text.len()).step_by(17) {
        let _ = read(folder.path(), &text[..end]);
        let _ = read(folder.path(), &complete[..end.min(complete.len())]);
    }
}
