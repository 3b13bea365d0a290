//! Lines of numbers alone are read in blocks, on all processors: the same log, and the same lines in messages, as by
//! the CSV reader, which a quotation mark in the first row asks for.

use data::{Log, ReadOptions};
use proptest::prelude::*;

/// Finite doubles of all sizes, as programs write them.
fn number() -> impl Strategy<Value = String> {
    let any = any::<f64>().prop_filter("finite", |number| number.is_finite());
    prop_oneof![
        any.prop_map(|number| number.to_string()),
        (-1e4..1e4).prop_map(|number: f64| format!("{number:e}")),
        (-1e4..1e4).prop_map(|number: f64| format!("{number:.9E}")),
        "[+-]?[0-9]{1,25}",
        "[+-]?[0-9]{0,9}\\.[0-9]{1,30}(e[+-]?[0-9]{1,2})?",
        "[0-9]{1,4}\\.",
    ]
}

fn parse(text: &str) -> Result<Log, String> {
    Log::parse(text.as_bytes(), "log.csv", &ReadOptions::default()).map_err(|e| e.to_string())
}

/// Some 40 000 rows, more than a block each for several threads.
fn rows(count: usize, numbers: &[String], separator: &str, end: &str) -> Vec<String> {
    let at = |k: usize| &numbers[k % numbers.len()];
    let row = |k| format!("{}e-4{separator}{}{separator}{}{end}", k, at(k), at(7 * k + 3));
    (0..count).map(row).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn blocks_hold_what_the_csv_reader_reads(
        numbers in prop::collection::vec(number(), 1..40),
        (separator, end) in prop::sample::select(vec![(",", "\n"), (", ", "\r\n"), (" ,", " \n"), (";", "\n"), ("\t", "\n")]),
        count in prop_oneof![2usize..20, 20_000usize..40_000],
        blank in any::<prop::sample::Index>(),
        has_blank in any::<bool>(),
    ) {
        let mut rows = rows(count, &numbers, separator, end);
        if has_blank {
            rows.insert(blank.index(count), end.to_owned());
        }
        let head = ["time", "u", "y"].join(separator) + end;
        let text = head.clone() + rows.concat().trim_end();
        let log = parse(&text).unwrap();
        prop_assert_eq!(log.len(), count);
        rows[0] = rows[0].replacen("0e-4", "\"0e-4\"", 1);
        if !rows[0].trim().is_empty() {
            prop_assert!(rows[0].starts_with('"'));
            let other = parse(&(head + &rows.concat())).unwrap();
            prop_assert_eq!(&log, &other);
            for row in [0, 1, count / 2, count - 1] {
                prop_assert_eq!(log.place_of(row), other.place_of(row));
            }
        }
    }

    #[test]
    fn a_fault_is_found_in_its_line(
        row in 1usize..40_000,
        (cell, rule) in prop::sample::select(vec![
            ("abc", "is no number"), ("nan", "is a gap"), ("inf", "is not finite"), ("1e999", "is not finite"),
            ("1,2", "the row has 4 cells, the header 3"), ("", "is a gap"), ("1 2", "holds several numbers"),
        ]),
    ) {
        let numbers: Vec<String> = (0..50).map(|k| format!("{}", f64::from(k).sin())).collect();
        let mut rows = rows(40_000, &numbers, ",", "\n");
        rows[row] = format!("{row}e-4,{cell},3\n");
        let error = parse(&("time,u,y\n".to_owned() + &rows.concat())).unwrap_err();
        prop_assert!(error.starts_with(&format!("log.csv:{}: ", row + 2)), "{}", error);
        prop_assert!(error.contains(rule), "{}", error);
    }
}

#[test]
fn numbers_are_the_nearest_doubles() {
    for text in [
        "9007199254740993",
        "1.00000000000000011102230246251565",
        "4.9e-324",
        "2.2250738585072011e-308",
        ".1",
        "+7",
    ] {
        let log = parse(&format!("time,y\n0,{text}\n1,\"{text}\"\n")).unwrap();
        let number: f64 = text.parse().unwrap();
        assert_eq!(log.column("y").unwrap().values, [number; 2], "{text}");
    }
}
