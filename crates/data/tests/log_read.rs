//! Logs that are read, and every way in which a file can be none.

use data::{Log, ReadOptions, SampleTime};

fn read(text: &str) -> Result<Log, String> {
    read_with(text, &ReadOptions::default())
}

fn read_with(text: &str, options: &ReadOptions) -> Result<Log, String> {
    Log::parse(text.as_bytes(), "log.csv", options).map_err(|problems| problems.to_string())
}

fn rate(rate: f64) -> ReadOptions {
    ReadOptions { rate: Some(rate), ..ReadOptions::default() }
}

fn values<'a>(log: &'a Log, name: &str) -> &'a [f64] {
    &log.column(name).unwrap_or_else(|| panic!("no column {name}")).values
}

#[test]
fn reads_names_units_and_values() {
    let log = read("\u{feff}time, u [V] ,position[1] [um],plain\r\n0,1,2,3\r\n0.5, 4 ,5e-1,-6\r\n")
        .unwrap();
    assert_eq!(log.time(), [0.0, 0.5]);
    assert_eq!(values(&log, "u"), [1.0, 4.0]);
    assert_eq!(values(&log, "position[1]"), [2.0, 0.5]);
    let unit = |name: &str| log.column(name).and_then(|c| c.unit.as_ref()).map(|u| u.text.clone());
    assert_eq!(unit("u").as_deref(), Some("V"));
    assert_eq!(unit("position[1]").as_deref(), Some("um"));
    assert_eq!(unit("plain"), None);
    assert_eq!(log.records().len(), 1);
    assert_eq!(log.convert("u", "mV").unwrap(), [1000.0, 4000.0]);
    assert_eq!(log.convert("plain", "mV").unwrap(), [3.0, -6.0]);
    let error = log.convert("u", "um").unwrap_err().to_string();
    assert!(error.contains("u: is in V, which does not convert to um"), "{error}");
}

#[test]
fn reads_what_fmpy_writes() {
    let log = read("\"time\",\"position[1]\",\"enable\"\n0.0,1e-05,True\n0.1,2.5,False\n").unwrap();
    assert_eq!(values(&log, "position[1]"), [1e-5, 2.5]);
    assert_eq!(values(&log, "enable"), [1.0, 0.0]);
}

#[test]
fn names_the_columns_that_there_are() {
    let log = read("time,position,u\n0,1,2\n").unwrap();
    let error = log.require("positon").unwrap_err().to_string();
    assert_eq!(
        error,
        "log.csv: positon: is no column of this log; did you mean \"position\"? the columns are \
         position, u"
    );
}

#[test]
fn records_may_restart_time() {
    for name in ["record", "realization"] {
        let text = format!("time,{name},y\n0,7,1\n1,7,2\n0,3,3\n0.5,3,4\n1.5,3,5\n");
        let log = read(&text).unwrap();
        let records: Vec<_> = log.records().iter().map(|r| (r.id, r.rows.clone())).collect();
        assert_eq!(records, [(7, 0..2), (3, 2..5)]);
        assert!(log.column(name).is_none());
    }
    let error = read("time,y\n0,1\n1,2\n0,3\n").unwrap_err();
    assert_eq!(
        error,
        "log.csv:4: time = 0 s: time goes back from 1 s; if a new record begins here, add a column \
         record: 0, 0, …, 1, 1, …"
    );
    let error = read("record,time,y\n1,0,1\n2,0,2\n1,1,3\n").unwrap_err();
    assert!(error.starts_with("log.csv:4: record = 1: the record appeared before; "), "{error}");
    let error = read("record,time,y\n1.5,0,1\n").unwrap_err();
    assert!(error.starts_with("log.csv:2: record = 1.5: a record has a whole number; "), "{error}");
}

#[test]
fn a_rate_stands_for_missing_times() {
    let log = read_with("u,y\n1,2\n3,4\n5,6\n", &rate(200.0)).unwrap();
    assert_eq!(log.time(), [0.0, 0.005, 0.01]);
    let log = read_with("realization,y\n0,2\n0,4\n1,6\n1,6\n", &rate(2.0)).unwrap();
    assert_eq!(log.time(), [0.0, 0.5, 0.0, 0.5]);
    // A column that counts rows keeps the place of lost ones.
    for name in ["n", "index", "time", ""] {
        let text = format!("{name},y\n10,1\n11,2\n13,4\n");
        let log = read_with(&text, &rate(10.0)).unwrap();
        assert_eq!(log.time(), [1.0, 1.1, 1.3], "{name}");
        assert_eq!(log.columns().len(), 1, "{name}");
    }
    // A column of times that counts nothing is left out, and that is noted.
    for times in
        [["0", "0.5", "1"], ["0", "0", "0"], ["0", "100", "200"], ["0", "", "1"], ["a", "b", "c"]]
    {
        let text = format!("time,y\n{},1\n{},2\n{},3\n", times[0], times[1], times[2]);
        let log =
            read_with(&text, &rate(10.0)).unwrap_or_else(|error| panic!("{times:?}: {error}"));
        assert_eq!(log.time(), [0.0, 0.1, 0.2], "{times:?}");
        assert!(
            log.notes()[0].contains("times are made from the sample rate"),
            "{:?}",
            log.notes()
        );
    }
    // With the smallest the times are infinite.
    for value in [0.0, 5e-324, f64::INFINITY] {
        let error = read_with("y\n0\n", &rate(value)).unwrap_err();
        assert!(error.starts_with("log.csv: --rate = "), "{error}");
        assert!(error.contains("is no sample rate; give a number of Hz"), "{error}");
    }
    let error = read("n,y\n0,1\n").unwrap_err();
    assert!(error.contains("time: is missing: a log has times in s; "), "{error}");
    let error = read("tme,y\n0,1\n").unwrap_err();
    assert!(
        error.contains("rename \"tme\", write time = { column = \"tme\", unit = \"s\" }"),
        "{error}"
    );
}

#[test]
fn the_caller_s_units_go_first_and_must_fit() {
    let mut options = ReadOptions::default();
    options.add_unit("y=nm").unwrap();
    options.add_unit(" time = ms ").unwrap();
    let log = read_with("time,y [um]\n0,1\n5,2\n", &options).unwrap();
    assert_eq!(log.column("y").unwrap().unit.as_ref().unwrap().text, "nm");
    assert_eq!(log.time(), [0.0, 0.005]);
    options.add_unit("x=um").unwrap();
    let error = read_with("time,y\n0,1\n", &options).unwrap_err();
    assert!(error.starts_with("log.csv: x: has a unit but is no column of this log; "), "{error}");
    for bad in ["y", "=um", "y=", "y=furlong"] {
        assert!(options.add_unit(bad).is_err(), "{bad}");
    }
    let error = read("time [um],y\n0,1\n").unwrap_err();
    assert!(error.contains("time: has a unit that is none of time"), "{error}");
}

#[test]
fn a_column_of_an_unknown_unit_is_an_error_only_where_it_is_used() {
    let log = read("time,y [furlong],u [Volts],n [-]\n0,1,2,3\n").unwrap();
    let note = "log.csv: column \"y\" is left out: it has a unit that is not known, \"furlong\"; say it: \
                --unit y=um";
    assert_eq!(log.notes(), [note]);
    assert_eq!(log.left_out()[0].name, "y");
    let error = log.require("y").unwrap_err().to_string();
    assert!(
        error.starts_with("log.csv: y: cannot be used: it has a unit that is not known"),
        "{error}"
    );
    assert_eq!(log.convert("u", "mV").unwrap(), [2000.0]);
    assert_eq!(log.columns().len(), 2);
    let mut options = ReadOptions::default();
    options.add_unit("y=um").unwrap();
    let log = read_with("time,y [furlong]\n0,1\n", &options).unwrap();
    assert_eq!((log.convert("y", "um").unwrap()[0], log.notes().len()), (1.0, 0));
    // The time is always used.
    let error = read("time [furlong],y\n0,1\n").unwrap_err();
    assert!(error.starts_with("log.csv:1: time: has a unit that is not known"), "{error}");
}

#[test]
fn datasets_beside_a_log_say_units() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let read = || Log::read(&path, &ReadOptions::default());
    write("run.csv", "t,y,u\n0,1,2\n5,3,4\n");
    write(
        "dataset.toml",
        "rate = 10\ntime = { column = \"t\", unit = \"ms\" }\n[columns]\ny = { unit = \"um\", \
         description = \"Stage\" }\nother = { unit = \"K\" }\n",
    );
    let log = read().unwrap();
    assert_eq!(log.time(), [0.0, 0.005]);
    let y = log.column("y").unwrap();
    assert_eq!((y.unit.as_ref().unwrap().text.as_str(), y.description.as_str()), ("um", "Stage"));

    write("run.dataset.toml", "[columns]\ny.unit = \"nm\"\n");
    assert_eq!(read().unwrap().column("y").unwrap().unit.as_ref().unwrap().text, "nm");

    write("run.csv", "t,y [um]\n0,1\n5,3\n");
    let error = read().unwrap_err().to_string();
    assert!(error.contains("run.csv:1: y: the header says um, but "), "{error}");
    assert!(error.contains("run.dataset.toml says nm; correct one of them"), "{error}");

    write("run.dataset.toml", "[columns]\nx.unit = \"nm\"\n");
    let error = read().unwrap_err().to_string();
    assert!(error.contains("run.dataset.toml:2: columns.x: is no column of "), "{error}");

    write("run.dataset.toml", "rates = 10\nrate = 5e-324\ntime = 3\n[columns]\nx.unit = 1\n");
    let error = read().unwrap_err();
    let lines: Vec<_> = error.as_slice().iter().map(|problem| problem.line).collect();
    assert_eq!(lines, [Some(1), Some(2), Some(3), Some(5)], "{error}");
}

#[test]
fn gaps_are_refused_with_line_and_way_out() {
    let error = read("time,u,y\n0,1,2\n1,,2\n2,1,NaN\n3,inf,x\n").unwrap_err();
    let lines: Vec<&str> = error.lines().collect();
    assert_eq!(lines.len(), 4, "{error}");
    assert!(lines[0].starts_with("log.csv:3: u = \"\": is a gap: "), "{error}");
    assert!(lines[0].ends_with(
        "; leave the row out and begin a new record behind it, or fill it in beforehand"
    ));
    assert!(lines[1].starts_with("log.csv:4: y = \"NaN\": is a gap: "), "{error}");
    assert!(lines[2].starts_with("log.csv:5: u = \"inf\": is not finite; "), "{error}");
    assert!(lines[3].starts_with("log.csv:5: y = \"x\": is no number; "), "{error}");
}

#[test]
fn twenty_problems_are_listed_and_the_rest_is_counted() {
    let rows: String = (0..50).map(|k| format!("{k},bad\n")).collect();
    let problems =
        Log::parse(format!("time,y\n{rows}").as_bytes(), "log.csv", &ReadOptions::default())
            .unwrap_err();
    assert_eq!((problems.as_slice().len(), problems.omitted()), (20, 30));
    assert!(problems.to_string().ends_with("\n… and 30 more"));
}

#[test]
fn hostile_files_are_refused_with_a_reason() {
    let cases: [(&[u8], &str); 14] = [
        (b"", "log.csv: is empty; "),
        (b"time,y\n", "log.csv: has no rows of data; "),
        (b"0,1\n0.5,2\n", "log.csv:1: has no header: the first line holds numbers; "),
        (
            b"time,y\n0,1\n0,5,1,2\n",
            "log.csv:3: the row has 4 cells, the header 2; if the numbers have decimal commas",
        ),
        (b"time,u,y\n0,1\n", "log.csv:2: the row has 2 cells, the header 3; give each row"),
        (b"time,y\n0,\"1,5\"\n", "log.csv:2: y = \"1,5\": has a decimal comma; "),
        (b"time,y,y\n0,1,2\n", "log.csv:1: y: is the name of two columns; "),
        (b"time,y,\n0,1,2\n", "log.csv:1: column 3: has no name; "),
        (
            b"time,record,realization,y\n0,1,1,1\n",
            "log.csv:1: record: two columns number the records; ",
        ),
        (b"time,y\n0,1 2\n", "log.csv:2: y = \"1 2\": holds several numbers; "),
        (b"\xff\xfet\x00i\x00", "log.csv: has no rows of data; "),
        (b"time,y\n0,1\n\x00\x01\x02", "log.csv: is no text but binary data; "),
        (b"PK\x03\x04\x14", "log.csv: is a zip archive or a workbook; "),
        (b"time,y\n0,\xff\xff\n", "log.csv:2: y = \""),
    ];
    for (bytes, wanted) in cases {
        let problems = Log::parse(bytes, "log.csv", &ReadOptions::default()).unwrap_err();
        let text = problems.to_string();
        assert!(text.starts_with(wanted), "wanted {wanted}\nfound  {text}");
        assert_eq!(problems.as_slice().len(), 1, "{text}");
    }
}

#[test]
fn huge_fields_give_short_messages() {
    let huge = "9".repeat(5_000_000);
    for text in [format!("time,y\n0,{huge}x\n"), format!("time,y\n0,\"1\n{huge}")] {
        let error = read(&text).unwrap_err();
        assert!(error.len() < 500, "{}", error.len());
        assert!(error.starts_with("log.csv:2: y = "), "{error}");
    }
    let error = read(&huge).unwrap_err();
    assert!(error.starts_with("log.csv: has no line end in its first mebibyte"), "{error}");
    // More digits than a double has are a number all the same.
    assert!(read(&format!("time,y\n0,0.{}\n", "3".repeat(10_000))).is_ok());
}

#[test]
fn lines_count_blank_lines_and_quoted_line_ends() {
    let error = read("time,y\n\n0,1\n\n\"1\",\"2\n\"\nx,3\n").unwrap_err();
    assert!(error.starts_with("log.csv:7: time = \"x\": is no number"), "{error}");
}

#[test]
fn absent_files_and_folders_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let error = Log::read(&folder.path().join("no.csv"), &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("no.csv: cannot be read: "), "{error}");
    let error = Log::read(folder.path(), &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().ends_with("is a folder; give the name of a file in it"), "{error}");
}

#[test]
fn sample_times_are_found_and_lost_samples_are_reported() {
    let log = |times: &[f64]| Log::new("log.csv", times.to_vec()).unwrap();
    let find = |log: &Log| log.sample_time(&log.records()[0], SampleTime::TOLERANCE);
    let of = |h: f64, n: u32, digits: i32| -> Vec<f64> {
        let scale = 10f64.powi(digits);
        (0..n).map(|k| (f64::from(k) * h * scale).round() / scale).collect()
    };
    assert_eq!(find(&log(&of(0.005, 2000, 12))).unwrap().period, 0.005);
    assert_eq!(find(&log(&of(1.0 / 6400.0, 5000, 12))).unwrap().period, 1.0 / 6400.0);
    // 30 kHz, written with 7 digits behind the point: the rate is a whole number of Hz.
    let thirty = find(&log(&of(1.0 / 30_000.0, 3000, 7))).unwrap();
    assert_eq!(thirty.period, 1.0 / 30_000.0);
    assert!(thirty.jitter > 0.001 && thirty.jitter < 0.002, "{thirty:?}");
    assert_eq!(
        find(&log(&[5.0, 7.5, 10.0])).unwrap(),
        SampleTime { start: 5.0, period: 2.5, jitter: 0.0 }
    );

    let mut lost = of(0.01, 100, 12);
    lost.remove(40);
    let error = find(&log(&lost)).unwrap_err().to_string();
    assert!(error.starts_with("log.csv: record 0: is not sampled uniformly: row "), "{error}");
    assert!(find(&log(&[1.0])).unwrap_err().to_string().contains("has one row"));
}

#[test]
fn rows_are_selected_by_time_and_number() {
    let text = "record,time,y\n1,0,0\n1,1,1\n1,2,2\n2,0,3\n2,1,4\n";
    let log = read(text).unwrap();
    let first = &log.records()[0];
    assert_eq!(log.rows_between(first, 1.0, 2.0), 1..2);
    assert_eq!(log.rows_between(first, 0.5, 9.0), 1..3);
    assert_eq!(log.rows_between(first, 5.0, 1.0), 3..3);
    assert_eq!(log.split_at(first, 1.0), (0..1, 1..3));
    let part = log.select(2..4);
    assert_eq!(part.time(), [2.0, 0.0]);
    assert_eq!(values(&part, "y"), [2.0, 3.0]);
    let records: Vec<_> = part.records().iter().map(|r| (r.id, r.rows.clone())).collect();
    assert_eq!(records, [(1, 0..1), (2, 1..2)]);
    assert!(log.select(7..9).is_empty());
}

#[test]
fn logs_created_in_code_keep_the_same_rules() {
    assert!(Log::new("run", vec![0.0, 1.0, 1.0]).is_err());
    assert!(Log::new("run", vec![0.0, f64::NAN]).is_err());
    assert!(Log::with_records("run", vec![0.0, 1.0, 0.0], &[(1, 2), (2, 1)]).is_ok());
    assert!(Log::with_records("run", vec![0.0, 1.0, 0.0], &[(1, 2)]).is_err());
    assert!(Log::with_records("run", vec![0.0, 0.0], &[(1, 1), (1, 1)]).is_err());
    let mut log = Log::new("run", vec![0.0, 1.0]).unwrap();
    log.add_column("y", Some("um"), vec![1.0, 2.0]).unwrap();
    for (name, unit, values) in [
        ("y", None, vec![0.0, 0.0]),
        ("time", None, vec![0.0, 0.0]),
        ("a\nb", None, vec![0.0, 0.0]),
        ("z", None, vec![0.0]),
        ("z", None, vec![0.0, f64::INFINITY]),
        ("z", Some("furlong"), vec![0.0, 0.0]),
    ] {
        assert!(log.add_column(name, unit, values).is_err(), "{name}");
    }
    assert_eq!(log.columns().len(), 1);
}

mod quality {
    use data::{Log, Quality, ReadOptions};

    /// A noisy sine with a line per sample, after `change`.
    fn log(change: impl Fn(usize, f64) -> f64, skip: &[usize]) -> Log {
        let mut text = String::from("time,y [um]\n");
        let mut state = 7_u64;
        for k in 0..2000_usize {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let noise = (state >> 40) as f64 / (1 << 24) as f64 - 0.5;
            let y = (k as f64 * 0.01).sin() + 1e-3 * noise;
            if !skip.contains(&k) {
                text += &format!("{},{}\n", k as f64 * 1e-3, change(k, y));
            }
        }
        Log::parse(text.as_bytes(), "log.csv", &ReadOptions::default()).unwrap()
    }

    #[test]
    fn a_clean_log_has_no_findings() {
        assert_eq!(log(|_, y| y, &[]).quality(), []);
    }

    #[test]
    fn missing_rows_are_counted_at_their_line() {
        let found = log(|_, y| y, &[100, 101, 102]).quality();
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].quality, Quality::Missing(3));
        // The header is line 1, so row 99 is line 101.
        assert!(found[0].to_string().starts_with("log.csv:101: time = 0.099: 3 rows are missing"));
    }

    #[test]
    fn outliers_are_found_and_steps_are_not() {
        let found = log(|k, y| if k == 500 { y + 0.5 } else { y }, &[]).quality();
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].rows.clone(), found[0].place.as_str()), (500..501, "log.csv:502"));
        assert!(matches!(found[0].quality, Quality::Outlier(by) if by > 100.0));
        assert_eq!(log(|k, y| if k >= 500 { y + 0.5 } else { y }, &[]).quality(), []);
    }

    #[test]
    fn the_corners_of_a_triangle_are_no_outliers() {
        // Amplitudes fall, so that slopes differ; written with rounding as in any CSV.
        let triangle = |k: usize, _: f64| {
            let (turn, at) = (k / 50, (k % 50) as f64 / 50.0);
            (120.0 - turn as f64) * if turn % 2 == 0 { at } else { 1.0 - at } + 0.1
        };
        assert_eq!(log(triangle, &[]).quality(), []);
        let spoilt = |k: usize, y: f64| triangle(k, y) + if k == 420 { 30.0 } else { 0.0 };
        let found = log(spoilt, &[]).quality();
        assert!(matches!(found.as_slice(), [one] if one.rows == (420..421)), "{found:?}");
    }

    #[test]
    fn a_group_that_nothing_can_have_is_noted() {
        let options = ReadOptions { group: Some("Scope".into()), ..ReadOptions::default() };
        let log = Log::parse(b"time,y\n0,1\n1,2\n", "log.csv", &options).unwrap();
        let notes = log.notes().join("\n");
        assert!(notes.contains("--group Scope has no effect"), "{notes}");
    }

    #[test]
    fn saturated_and_stuck_samples_are_distinguished() {
        let found = log(|_, y| y.min(0.9), &[]).quality();
        assert!(found.len() >= 3 && found.iter().all(|f| f.quality == Quality::Saturated));
        let found = log(|k, y| if (700..760).contains(&k) { 0.25 } else { y }, &[]).quality();
        assert!(found.iter().any(|f| f.quality == Quality::Stuck && f.rows == (700..760)));
    }

    #[test]
    fn a_held_command_is_not_doubtful() {
        let found = log(|k, _| (k / 200) as f64, &[]).quality();
        assert_eq!(found, []);
    }
}

#[test]
fn times_that_were_rounded_are_those_of_the_grid() {
    let text = |times: &mut dyn Iterator<Item = String>| {
        let rows: Vec<String> = times.map(|t| format!("{t},1\n")).collect();
        format!("time,y\n{}", rows.concat())
    };
    let grid = |k: u32| f64::from(k) / 6400.0;
    // Six digits, as printf's %g writes them.
    let short = |t: f64| {
        let size = if t == 0.0 { 0 } else { t.log10().floor() as i32 };
        let decimals = (5 - size).max(1) as usize;
        format!("{t:.decimals$}").trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    let log = read(&text(&mut (0..16_384).map(|k| short(grid(k))))).unwrap();
    let is_grid = |log: &Log| log.time().iter().zip(0..).all(|(t, k)| (t - grid(k)).abs() < 1e-15);
    assert!(is_grid(&log));
    assert!(matches!(log.rounded(), [r] if r.period == 1.0 / 6400.0 && r.distance > 0.02));
    assert!(log.note_on_times().unwrap().contains("too few digits"));
    // Single precision.
    let log = read(&text(&mut (0..16_384).map(|k| f64::from(grid(k) as f32 * 1.0).to_string())));
    assert!(is_grid(&log.unwrap()));
    let late = |k: u32| f64::from((3.0 + f64::from(k) * 1e-4) as f32).to_string();
    let log = read(&text(&mut (0..5000).map(late))).unwrap();
    assert_eq!((log.rounded().len(), log.time()[4999]), (1, 3.0 + 4999.0 * 1e-4));

    // A clock that trembles is no rounding: 1 % of a sample, all digits given.
    let tremble = |k: u32| (grid(k) + 1.5e-6 * f64::from(k * 7919 % 13) / 13.0).to_string();
    let log = read(&text(&mut (0..2000).map(tremble))).unwrap();
    assert!(log.rounded().is_empty() && log.time()[1] != grid(1));
    // All digits that a double has.
    let log = read(&text(&mut (0..2000).map(|k| (f64::from(k) / 3000.0).to_string()))).unwrap();
    assert!(log.rounded().is_empty());
}
