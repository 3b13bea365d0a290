//! Quotation marks, ends of lines and bytes that are no text change nothing of the numbers and their lines.

use data::{Log, ReadOptions};

fn read(text: &str) -> Result<Log, String> {
    Log::parse(text.as_bytes(), "log.csv", &ReadOptions::default())
        .map_err(|error| error.to_string())
}

/// Time and values of a log, and where its rows stand.
fn all(log: &Log) -> (Vec<u64>, Vec<u64>, Vec<String>) {
    let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let values = log.columns().iter().flat_map(|column| bits(&column.values)).collect();
    (bits(log.time()), values, (0..log.len()).map(|row| log.place_of(row)).collect())
}

#[test]
fn quotation_marks_and_ends_of_lines_change_nothing() {
    let mut lines: Vec<String> = vec!["time,u,y".into()];
    for k in 0..40 {
        lines.push(format!("{},{},{:e}", f64::from(k) * 0.1, k * k, f64::from(k).sin()));
    }
    for end in ["\n", "\r\n", "\r", "\n\n", "\r\n\r\n"] {
        let plain = read(&(lines.join(end) + end)).unwrap();
        assert_eq!(plain.len(), 40);
        for quoted in [1, 2, 20, 40] {
            let mut lines = lines.clone();
            lines[quoted] = lines[quoted].replacen(',', ",\"", 1).replacen(",", "\u{1}", 1);
            lines[quoted] = lines[quoted].replacen(',', "\",", 1).replace('\u{1}', ",");
            assert!(lines[quoted].matches('"').count() == 2, "{}", lines[quoted]);
            let other = read(&(lines.join(end) + end)).unwrap();
            assert_eq!(all(&other), all(&plain), "{end:?}, line {quoted}");
        }
        // Without an end of the last line.
        assert_eq!(all(&read(&lines.join(end)).unwrap()), all(&plain), "{end:?}");
    }
}

#[test]
fn what_is_wrong_is_reported_with_its_line_before_and_behind_quotation_marks() {
    for (text, line) in [
        ("time,u\n0,1\n1,2\n1.5,x\n", "log.csv:4"),
        ("time,u\n0,1\n1,\"2\"\n2,x\n", "log.csv:4"),
        ("\"time\",u\n0,1\n1,2\n2,x\n", "log.csv:4"),
        ("time,\"u\nv\"\n0,1\n1,x\n", "log.csv:4"),
    ] {
        let message = read(text).unwrap_err();
        assert!(message.contains(line), "{text:?}: {message}");
    }
}
