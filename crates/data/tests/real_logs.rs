//! Measured logs of several sources; each test is skipped where the data are absent.

use std::path::PathBuf;

use data::{Fit, Log, ReadOptions, SampleTime};

/// The file in the folder of measured data, if it is there.
fn measured(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name);
    if !path.exists() {
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), "SKIPPED: {} is absent", path.display());
        return None;
    }
    Some(path)
}

fn read(path: &std::path::Path, options: &ReadOptions) -> Log {
    Log::read(path, options).unwrap_or_else(|problems| panic!("{problems}"))
}

#[test]
fn piezo_stack_at_200_hz() {
    let Some(path) = measured("pea_p885_1hz_inverse_ff/model_1hz_3v6.csv") else { return };
    let log = read(&path, &ReadOptions::default());
    let [record] = log.records() else { panic!("{:?}", log.records()) };
    let time = log.sample_time(record, SampleTime::TOLERANCE).unwrap();
    assert_eq!((time.start, time.period), (0.0, 0.005));
    assert_eq!(log.column("u").unwrap().values[..2], [1.8, 1.856539]);
    assert_eq!(log.column("y").unwrap().values[0], -123.0591);
    let y = &log.column("y").unwrap().values;
    let fit = Fit::of(y, y).unwrap();
    assert_eq!((fit.rmse, fit.fit_percent), (0.0, 100.0));
    let names: Vec<&str> = log.columns().iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["u", "y"]);
}

#[test]
fn the_other_log_of_the_stack_has_the_same_clock() {
    let Some(path) = measured("pea_p885_1hz_inverse_ff/test_ff.csv") else { return };
    let log = read(&path, &ReadOptions::default());
    let time = log.sample_time(&log.records()[0], SampleTime::TOLERANCE).unwrap();
    assert_eq!(time.period, 0.005);
    assert_eq!(log.columns().len(), 8);
    let window = log.select(5050..6050);
    assert_eq!(window.len(), 1000);
}

#[test]
fn steering_mirror_in_numbered_records() {
    let Some(path) = measured("fsm_cubespec_multisine/fsm_100mV_test.csv") else { return };
    let log = read(&path, &ReadOptions::default());
    for record in log.records() {
        let time = log.sample_time(record, SampleTime::TOLERANCE).unwrap();
        assert_eq!((time.start, time.period), (0.0, 1.0 / 6400.0), "record {}", record.id);
    }
    let rows: usize = log.records().iter().map(|record| record.rows.len()).sum();
    assert_eq!(rows, log.len());
    assert_eq!(log.columns().len(), 6);
}

#[test]
fn triangle_at_10_khz() {
    let Some(path) = measured("piezo_stage_closedloop_triangle/triangle_100_400um_50khz_dec5.csv")
    else {
        return;
    };
    let log = read(&path, &ReadOptions::default());
    let time = log.sample_time(&log.records()[0], SampleTime::TOLERANCE).unwrap();
    assert_eq!(time.period, 1e-4);
}

#[test]
fn telemetry_that_counts_frames_needs_a_rate() {
    let Some(path) = measured("keck_tiptilt_telemetry/n0088.csv") else { return };
    let error = Log::read(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("time: is missing: a log has times in s"), "{error}");
    let options = ReadOptions { rate: Some(1000.0), ..ReadOptions::default() };
    let log = read(&path, &options);
    assert_eq!(log.time()[..3], [0.0, 0.001, 0.002]);
    assert!(log.column("n").is_none());
    assert_eq!(log.column("cmd_x").unwrap().values[0], -0.038461);
}
