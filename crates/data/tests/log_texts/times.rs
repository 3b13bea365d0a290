//! Times of every kind.

use std::fmt::Write as _;

use data::{ReadOptions, Resample};

use super::tables::*;

#[test]
fn dates_and_clocks_are_times_after_the_first_row() {
    let clock = |k: u32| format!("03:00:00.{k:03}");
    let values = |k: u32| format!("{k},{}", f64::from(k) / 2.0);
    for (head, row) in [
        (
            "timestamp,u,y\n",
            Box::new(move |k| format!("2026-11-25 {},{}", clock(k), values(k)))
                as Box<dyn Fn(u32) -> String>,
        ),
        (",u,y\n", Box::new(move |k| format!("2026-11-25T{}Z,{}", clock(k), values(k)))),
        ("Time,u,y\n", Box::new(move |k| format!("{},{}", clock(k), values(k)))),
        ("Date,Time,u,y\n", Box::new(move |k| format!("25.11.2026,{},{}", clock(k), values(k)))),
    ] {
        let log = read(table(head, row));
        is(&log, ms, PLAIN);
        assert!(notes(&log).contains("in s after the first row"), "{head}: {}", notes(&log));
    }
    // Cells of a date and a clock time; the day changes.
    let text = "Datum;Uhrzeit;u\n25.11.2026;23:59:59,5;0\n26.11.2026;00:00:00,5;1\n";
    assert_eq!(read(text).time(), [0.0, 1.0]);
}

#[test]
fn times_have_the_unit_that_their_head_says() {
    for (head, factor) in [
        ("Time (ms)", 1e-3),
        ("time_ms", 1e-3),
        ("t / us", 1e-6),
        ("timestamps", 1.0),
        ("tout", 1.0),
        ("Time(S)", 1.0),
    ] {
        let log =
            read(table(&format!("{head},u,y\n"), |k| format!("{k},{k},{}", f64::from(k) / 2.0)));
        is(&log, |k| k * factor, PLAIN);
    }
}

#[test]
fn rate_and_start_of_a_preamble_are_the_times() {
    let counted = |k: u32| format!("{k},{k},{},,", f64::from(k) / 2.0);
    let values = |k: u32| format!("{k}.0 {}", f64::from(k) / 2.0);
    // Rigol: start and increment below their names.
    let log = read(table("X,u,y,Start,Increment,\nSequence,Volt,um,-2.0e-03,1.0e-03\n", counted));
    is(&log, |k| (k - 2.0) / 1000.0, UNITS);
    // PI GCS array.
    let head = "# REM E-727.3CDA\n#\n# TYPE = 1\n# SEPARATOR = 32\n# DIM = 2\n# SAMPLE_TIME = 0.00005\n# NDATA = 10\n#\n\
                # NAME0 = Target Position of axis1\n# NAME1 = Current Position of axis1\n#\n# END_HEADER\n";
    let log = read(table(head, values));
    is(
        &log,
        |k| k * 5e-5,
        [("Target Position of axis1", None), ("Current Position of axis1", None)],
    );
    assert_eq!(log.time()[7], 7.0 / 20_000.0);
    // Yokogawa: keys in the first column, which is empty in the rows.
    let head = "\"Model Name\",\"DL850\",\"\"\n\"TraceName\",\"u\",\"y\"\n\"VUnit\",\"V\",\"um\"\n\"SampleRate\",1.00E+03,1.00E+03\n\
                \"HOffset\",-5.0e-3,-5.0e-3\n\"HUnit\",\"s\",\"s\"\n\n";
    let log = read(table(head, |k| format!(",{k}.0,{}", f64::from(k) / 2.0)));
    is(&log, |k| (k - 5.0) / 1000.0, UNITS);
}

/// Nanoseconds since 1970 have more digits than a double.
#[test]
fn long_integer_times_keep_their_digits() {
    let exact = |log: &data::Log, rate: f64| {
        assert_eq!(log.len(), 10);
        for (at, time) in log.time().iter().enumerate() {
            assert_eq!(*time, at as f64 / rate, "row {at}");
        }
        assert!(notes(log).contains("times are those after the first row, at 1700000000"));
    };
    let options = |unit: &str| ReadOptions {
        units: [("time".to_owned(), unit.to_owned())].into(),
        ..ReadOptions::default()
    };
    let ns = |k: u32| 1_700_000_000_000_000_000 + 1000 * u64::from(k);
    let rows = |k: u32| format!("{},{k},{}", ns(k), f64::from(k) / 2.0);
    exact(&read(table("time [ns],u [V],y [um]\n", rows)), 1e6);
    exact(&read_with(table("time,u,y\n", rows), &options("ns")).unwrap(), 1e6);
    exact(&read(table("time_ns,u,y\n", |k| rows(k).replace(',', " , "))), 1e6);
    // With a preamble, a text column, blanks between, a time for each signal.
    exact(&read(table("Version,1\nOwner,me\n\ntime [ns],u [V],y [um]\n", rows)), 1e6);
    exact(&read(table("time [ns],u,mode\n", |k| format!("{},{k},on", ns(k)))), 1e6);
    exact(&read(table("time_ns u y\n", |k| rows(k).replace(',', " "))), 1e6);
    exact(&read(table("time_ns,u,time_ns,y\n", |k| format!("{0},{k},{0},{k}", ns(k)))), 1e6);
    // Parts of a tick, and microseconds, which lose their last digit in s.
    exact(&read(table("time_ns,u,y\n", |k| format!("{}.0,{k},0", ns(k)))), 1e6);
    let us = |k: u32| format!("{},{k},0", 1_700_000_000_000_000 + u64::from(k));
    exact(&read(table("time_us,u,y\n", us)), 1e6);
    // A time that is written in another way in between.
    let mixed = |k: u32| if k == 5 { "1.7e18,5,0".to_owned() } else { rows(k) };
    let error = read_with(table("time_ns,u,y\n", mixed), &ReadOptions::default()).unwrap_err();
    assert!(error.contains(":7: time_ns = \"1.7e18\""), "{error}");
    // Nobody says the unit.
    let log = read(table("time,u,y\n", rows));
    assert!(notes(&log).contains("are they ms, us or ns since 1970?"), "{}", notes(&log));
    // What is long and no time stays as it is.
    let log = read(table("time,count\n", |k| format!("{k}.5,{}", ns(k))));
    assert_eq!(log.column("count").unwrap().values[9], ns(9) as f64);
}

#[test]
fn signals_with_times_of_their_own_are_groups() {
    let same = |k: u32| format!("{0},{k},{0},{1}", f64::from(k) / 1000.0, f64::from(k) / 2.0);
    is(&read(table("Time (s),u (V),Time (s),y (um)\n", same)), ms, UNITS);
    let slow = |k: u32| match k < 5 {
        true => {
            format!("{},{k},{},{}", f64::from(k) / 1000.0, f64::from(k) / 500.0, f64::from(k) + 0.5)
        }
        false => format!("{},{k},,", f64::from(k) / 1000.0),
    };
    let text = table("time,u,time,y\n", slow);
    let error = read_with(&text, &ReadOptions::default()).unwrap_err();
    assert!(
        error.contains("2 groups with different times: \"u\" (10 rows), \"y\" (5 rows)"),
        "{error}"
    );
    assert!(error.contains("--resample"), "{error}");
    let options = ReadOptions { resample: Some(Resample::Fastest), ..ReadOptions::default() };
    let log = read_with(&text, &options).unwrap();
    assert_eq!(log.time(), (0..9).map(|k| f64::from(k) / 1000.0).collect::<Vec<_>>());
    let y = &log.column("y").unwrap().values;
    assert!(y.iter().zip(0..).all(|(y, k)| (y - (f64::from(k) / 2.0 + 0.5)).abs() < 1e-9), "{y:?}");
    assert!(notes(&log).contains("are joined and resampled onto 1000 Hz"), "{}", notes(&log));
    let options = ReadOptions { group: Some("y".into()), ..ReadOptions::default() };
    assert_eq!(read_with(&text, &options).unwrap().len(), 5);
}

#[test]
fn a_log_on_changes_only_is_brought_onto_a_rate() {
    let options = ReadOptions { resample: Some(Resample::Rate(2.0)), ..ReadOptions::default() };
    let log = read_with("Time [s],CH_A,x\n1.0,0,0.5\n2.0,1,1.5\n4.0,0,0.5\n", &options).unwrap();
    assert_eq!(log.time(), [1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]);
    assert_eq!(log.column("CH_A").unwrap().values, [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
    assert_eq!(log.column("x").unwrap().values, [0.5, 1.0, 1.5, 1.25, 1.0, 0.75, 0.5]);
    assert!(notes(&log).contains("CH_A held: whole numbers"), "{}", notes(&log));
    let many = ReadOptions { resample: Some(Resample::Rate(1e12)), ..ReadOptions::default() };
    assert!(read_with("time,x\n0,1\n1,2\n", &many).unwrap_err().contains("too many"));
}

#[test]
fn of_two_rows_at_one_time_the_second_acts() {
    let log = read("time,u\n0.0,1.0\n0.5,1.0\n0.5,2.0\n1.0,2.0\n1.0,3.0\n");
    assert_eq!(
        (log.time(), log.columns()[0].values.as_slice()),
        (&[0.0, 0.5, 1.0][..], &[1.0, 2.0, 3.0][..])
    );
    assert!(
        notes(&log).contains("2 rows have the time of the row before (first in line 4, 0.5 s)"),
        "{}",
        notes(&log)
    );
    // A long table of steps, in which every time but the ends occurs twice.
    let mut steps = "time,u,mode\n".to_owned();
    for k in 0..50 {
        write!(steps, "{k},{k},1\n{},{k},1\n", k + 1).unwrap();
    }
    let log = read(&steps);
    assert_eq!((log.len(), log.columns()[0].values[20]), (51, 20.0));
}

#[test]
fn times_with_too_few_digits_are_refused_unless_the_rate_is_given() {
    let mut text = "time,u,y\n".to_owned();
    for k in 0..60 {
        writeln!(text, "{:.3},{},{}", f64::from(k) / 10_000.0, f64::from(k).sin(), k % 7).unwrap();
    }
    let error = read_with(&text, &ReadOptions::default()).unwrap_err();
    assert!(
        error.contains("times are written with too few digits; give the sample rate"),
        "{error}"
    );
    let options = ReadOptions { rate: Some(10_000.0), ..ReadOptions::default() };
    let log = read_with(&text, &options).unwrap();
    assert_eq!((log.len(), log.time()[59]), (60, 0.0059));
    assert!(
        notes(&log).contains("\"time\" does not count rows: it is left out"),
        "{}",
        notes(&log)
    );
}

#[test]
fn an_index_of_pandas_and_durations_of_matlab_are_read() {
    let log = read(table(",time,u,y\n", |k| format!("{k},{}", comma(k))));
    is(&log, ms, PLAIN);
    assert!(notes(&log).contains("has no name, as pandas writes"), "{}", notes(&log));
    let log = read(table("Time,u,y\n", |k| comma(k).replacen(',', " sec,", 1)));
    is(&log, ms, PLAIN);
}

#[test]
fn doubtful_times_are_noted() {
    let text: String = (0..200).map(|k| format!("{},1\n", 100 * k)).collect();
    assert!(notes(&read(format!("time,y\n{text}"))).contains("is time in ms or us?"));
    assert!(notes(&read(format!("time [us],y\n{text}"))).is_empty());
    let stray: String = (0..100)
        .map(|k| format!("{},1\n", if k == 99 { 1e9 } else { f64::from(k) * 1e-3 }))
        .collect();
    assert!(notes(&read(format!("time,y\n{stray}"))).contains("is that a wrong time?"));
}

#[test]
fn names_for_a_table_without_times_leave_them_to_the_rate() {
    let bare = table("", |k| format!("{},{k}.5", k % 3));
    let error = read_with(&bare, &ReadOptions::default()).unwrap_err();
    assert!(error.contains("--columns y1,y2 --rate HZ"), "{error}");
}
